//! Beginnings and ends of the contacts of an island (group of particles that may meet). A slot is the number of a
//! candidate (pair, or particle and wall) in the neighbour list of the island.

use super::alone::{TOUCH, TRIALS};
use super::{InstantaneousRule, IslandRun};
use crate::encounter::Couple;
use crate::engine::soft::contact::{Contact, ContactState};
use crate::engine::soft::facets::{facet_turn, turn_motion};
use crate::engine::soft::rates::Rates;
use crate::engine::soft::rotating::SurfaceMotion;
use crate::record::{Between, Impact};
use nalgebra::Vector3;

impl<I: InstantaneousRule> IslandRun<'_, I> {
    /// Begins a contact between the two bodies of the slot `slot` (candidate), unless their touch is an instantaneous
    /// impulse.
    pub(super) fn open(&mut self, slot: usize) {
        let (_, rate) = self.scratch.gaps[slot];
        self.scratch.touches[slot].begin_at(-rate, (self.particles, self.scene), &self.engine.law);
        if self.strike(slot) {
            return;
        }
        let facet = self.meet_facet(slot);
        let (gap, rate) = self.scratch.gaps[slot];
        let touch = self.scratch.touches[slot];
        let began = self.window.start + self.now;
        let begun = ContactState::beginning(began, -rate, &touch, self.scene, &self.engine.law);
        let mut course = ContactState { overlap: -gap, growth: -rate, facet, ..begun };
        if self.rotates() {
            let met = self.encounter(slot, &touch.couple, self.moment());
            course.normal = self.is_by_distance(slot).then(|| met.normal.cast());
            let surfaces = SurfaceMotion::of(&touch.couple, touch.reach, &met, (self.particles, self.scene));
            course.first_slip = Some(surfaces.slip.cast());
            self.open_springs(&touch, &course, &met);
        }
        self.scratch.contacts.push(Contact { slot: slot as u32, touch, course });
    }

    /// Repeats the step that began at `start` [s], with the length at which the gap of the slot `slot` (candidate) is
    /// zero. The first guess of that length is `fraction` [-] of `dt` [s]. Returns the powers and wall forces as means
    /// over the step.
    ///
    /// The contact of the slot ends when its gap becomes positive, or begins when the gap becomes negative. If two such
    /// instants nearly coincide, the later one may have been passed when the last step ended. The gap then already has
    /// its new sign at the start of this step. The search tests the sign itself, not a change of sign, so it ends near
    /// that start. A search for a change of sign would go on to the end of the step, past all other such instants.
    pub(super) fn find_turn(&mut self, start: f64, dt: f64, fraction: f64, slot: usize) -> Rates {
        let touching = self.scratch.contacts.iter().any(|c| c.slot as usize == slot);
        let (mut low, mut high) = (0.0, 1.0);
        let mut fraction = fraction;
        let diameter = self.scratch.touches[slot].diameter;
        let mut rates = Rates::default();
        for _ in 0..TRIALS {
            rates = self.repeat(start, fraction * dt);
            let (gap, rate) = self.gap(slot);
            if gap.abs() <= TOUCH * diameter {
                break;
            }
            // Newton's method, restricted to the interval between a time before the change and one after it
            let turned = if touching { gap > 0.0 } else { gap < 0.0 };
            if turned {
                high = fraction
            } else {
                low = fraction
            }
            let newton = fraction - gap / (rate * dt);
            fraction = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        rates
    }

    /// Ends the contact of the slot `slot` (candidate) if there is one; otherwise begins a contact there, or applies an
    /// impulse if the touch is instantaneous.
    pub(super) fn turn(&mut self, slot: usize) {
        match self.scratch.contacts.iter().position(|c| c.slot as usize == slot) {
            None => self.open(slot),
            Some(k) => {
                let mut slip = None;
                if self.rotates() {
                    let (touch, met) = self.met(k);
                    let course = &self.scratch.contacts[k].course;
                    let bodies = (&*self.particles, self.scene);
                    slip = course.slip_change(&touch.couple, &touch, (&met, met.normal_velocity), bodies);
                    self.drop_springs(k);
                }
                let contact = self.scratch.contacts.remove(k);
                let (_, rate) = self.scratch.gaps[slot];
                // the bodies of a contact that existed at the start of the run may never have approached each other
                if contact.course.normal_speed > 0.0 {
                    let now = self.window.start + self.now;
                    let impact = Impact { slip, ..contact.course.impact(contact.touch.diameter, rate, now) };
                    let (species, other) = contact.touch.couple.kinds(self.particles);
                    self.island.log.impacts.push((Between::of(species, other), impact));
                }
                if let Some(turn) = contact.course.facet {
                    self.turn_motion(&contact.touch.couple, &-turn);
                }
            }
        }
    }

    /// Turns the velocity of the particle of the slot `slot` (candidate), if it touches a randomly inclined facet of a
    /// rough wall. Returns the rotation vector [rad]; `None` if the wall is smooth, or the other body a particle.
    fn meet_facet(&mut self, slot: usize) -> Option<Vector3<f64>> {
        let couple = self.scratch.touches[slot].couple;
        let met = self.encounter(slot, &couple, self.moment());
        let turn = facet_turn(&couple, &met, (self.particles, self.scene), self.particles.id[couple.i as usize])?;
        self.turn_motion(&couple, &turn);
        let (_, rate) = self.scratch.gaps[slot];
        self.scratch.touches[slot].begin_at(-rate, (self.particles, self.scene), &self.engine.law);
        Some(turn)
    }

    /// Turns the velocity of the first particle of `couple`, which touches a rough wall, by the rotation vector `turn`
    /// [rad]. Records the impulse of the wall, and computes the rates of all gaps anew.
    fn turn_motion(&mut self, couple: &Couple, turn: &Vector3<f64>) {
        let normal = couple.meet(self.particles, self.scene, self.moment()).normal;
        let fallen = self.scene.gravity * self.now;
        let impulse = turn_motion(self.particles, couple.i as usize, turn, &fallen);
        let ledger = &mut self.island.log.ledger;
        ledger.wall_impulse += impulse;
        ledger.wall_normal_impulse += impulse.dot(&normal);
        ledger.gravity_work += self.scene.gravity.dot(&impulse) * (self.window.duration - self.now);
        // the island will compare the new velocity with the speed limit of the particle
        self.struck = Some(*couple);
        self.update_gaps();
    }
}
