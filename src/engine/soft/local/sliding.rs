//! Tangential springs of an island whose spheres rotate: they stick or slide, and the instants at which that changes
//! are found within a step.
//!
//! While a contact sticks, its shear ξ is a state of the Runge-Kutta method: dξ/dt = s + ω_n n × ξ, where ω_n is the
//! mean spin about the normal. While it slides, its state is the direction e of the force: the length of the spring
//! follows from the limit, and e turns towards the slip as the spring is dragged along. States are held in the plane
//! normal to n at the start of the step, and are carried along with n from there.

use super::{InstantaneousRule, IslandRun, Rates, TRIALS};
use crate::contact_law::ContactLaw;
use crate::contact_law::friction::{Slip, coulomb};
use crate::encounter::Encounter;
use crate::engine::soft::contact::{Contact, ContactConstants, ContactForce, TouchingPair};
use crate::rotation::{TangentialSpring, slip};
use nalgebra::Vector3;

/// Way in which the surfaces of a contact move on one another.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// The contact remembers nothing.
    Memoryless,
    /// Spring and dashpot are below the limit.
    Stick,
    /// The force is at the limit.
    Slide,
    /// The dashpot pulls: there is no tangential force.
    Free,
}

/// State of a tangential spring.
#[derive(Clone, Copy, Debug)]
struct SpringState {
    /// Shear ξ [m] of a contact that sticks, or direction e [-] of the force of one that slides; normal to `normal`.
    vector: Vector3<f64>,
    normal: Vector3<f64>,
}

/// Tangential spring of a contact, during a step.
#[derive(Clone, Copy, Debug)]
pub struct SlidingContact {
    phase: Phase,
    /// State at the start of the step.
    start: SpringState,
    /// State now.
    now: SpringState,
    /// Rate of change [1/s of the state] at the last stage, in the plane of the start.
    rate: Vector3<f64>,
    /// Weighted mean of the rates of all stages so far.
    mean: Vector3<f64>,
    /// [m] shear ξ now.
    shear: Vector3<f64>,
    /// Margins of the phase at the start of the step and now: the phase ends where one becomes negative.
    margins: [[f64; 2]; 2],
}

/// Relative motion and normal force of a contact between bodies that rotate.
struct SlidingMotion {
    /// [m/s]
    slip: Vector3<f64>,
    /// [-] lever arms over radii.
    arm: f64,
    /// [N]
    elastic: f64,
    /// [N]
    viscous: f64,
    /// [N] largest tangential force.
    limit: f64,
}

/// Index of the two sets of margins.
const BEFORE: usize = 0;
const AFTER: usize = 1;

/// [-] no step is cut to less than this share for the sake of friction.
const SHORTEST: f64 = 1e-3;

/// A vector normal to `from`, carried along to the plane normal to `to` by the shortest turn.
fn carried(vector: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
    let cosine = 1.0 + from.dot(to);
    if cosine > 0.0 { vector - (from + to) * (vector.dot(to) / cosine) } else { *vector }
}

impl SlidingContact {
    fn memoryless() -> Self {
        let none = SpringState { vector: Vector3::zeros(), normal: Vector3::zeros() };
        let (rate, mean, shear) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
        let margins = [[f64::INFINITY; 2]; 2];
        Self { phase: Phase::Memoryless, start: none, now: none, rate, mean, shear, margins }
    }

    /// Changes the phase, with the vector of the new one.
    fn take(&mut self, phase: Phase, vector: Vector3<f64>) {
        (self.phase, self.now.vector) = (phase, vector);
    }
}

impl SlidingMotion {
    fn of(run: &IslandRun<'_, impl InstantaneousRule>, touch: &TouchingPair, met: &Encounter) -> Self {
        let (surface, arm) = touch.couple.surface_velocity(run.particles, touch.reach, met.gap);
        let (elastic, viscous) = run.engine.law.force(&touch.spring, met.overlap(), met.normal_velocity);
        let limit = TangentialSpring::limit(touch.friction, elastic + viscous);
        Self { slip: slip(&met.velocity, &met.normal, &surface), arm, elastic, viscous, limit }
    }
}

/// [N/s] rate of the limit, from the rate of the normal velocity [m/s²].
fn limit_rate(law: &ContactLaw, touch: &TouchingPair, met: &Encounter, (acceleration, dt): (f64, f64)) -> f64 {
    // a difference over so little time is exact enough to find an instant by
    let time = 1e-4 * dt;
    let force = |overlap: f64, velocity: f64| {
        let (elastic, viscous) = law.force(&touch.spring, overlap, velocity);
        elastic + viscous
    };
    let later = force(met.overlap() - met.normal_velocity * time, met.normal_velocity + acceleration * time);
    touch.friction * (later - force(met.overlap(), met.normal_velocity)) / time
}

impl<I: InstantaneousRule> IslandRun<'_, I> {
    /// True if spheres rotate.
    #[inline(always)]
    pub(super) fn rotates(&self) -> bool {
        self.scene.rotation.is_some()
    }

    fn met(&self, k: usize) -> (TouchingPair, Encounter) {
        let touch = self.scratch.contacts[k].touch;
        (touch, touch.couple.meet(self.particles, self.scene, self.moment()))
    }

    /// Takes the tangential springs of contacts that last from the window before.
    pub(super) fn adopt_springs(&mut self) {
        self.scratch.sliding.clear();
        for k in 0..self.scratch.contacts.len() {
            let Contact { touch, course, .. } = self.scratch.contacts[k];
            let sliding = self.spring_of(&touch, course.shear);
            self.scratch.sliding.push(sliding);
        }
    }

    /// Tangential spring of a contact with that shear [m] at present.
    pub(super) fn spring_of(&self, touch: &TouchingPair, shear: Vector3<f64>) -> SlidingContact {
        let mut sliding = SlidingContact::memoryless();
        if touch.tangential.stiffness == 0.0 || touch.friction == 0.0 {
            return sliding;
        }
        let met = touch.couple.meet(self.particles, self.scene, self.moment());
        let motion = SlidingMotion::of(self, touch, &met);
        let flat = shear - met.normal * shear.dot(&met.normal);
        sliding.now = SpringState { vector: flat, normal: met.normal };
        sliding.shear = flat;
        let force = touch.tangential.force(&flat, &motion.slip);
        let (square, limit) = (force.norm_squared(), motion.limit);
        let begins = limit == 0.0 && met.overlap() <= 1e-9 * touch.diameter && met.normal_velocity < 0.0;
        let slides = if begins && square == 0.0 {
            // at the touch of an undamped contact spring and limit grow from zero at their rates
            let rate = limit_rate(&self.engine.law, touch, &met, (0.0, self.engine.step));
            touch.tangential.stiffness * motion.slip.norm() > rate
        } else {
            square >= limit * limit * (1.0 - 1e-12)
        };
        let along = if square > 0.0 { force } else { motion.slip };
        match (slides, limit == 0.0 && !begins) {
            (_, true) => sliding.take(Phase::Free, Vector3::zeros()),
            (true, _) => sliding.take(Phase::Slide, along.try_normalize(0.0).unwrap_or_else(Vector3::zeros)),
            (false, _) => sliding.take(Phase::Stick, flat),
        }
        sliding.start = sliding.now;
        sliding.margins[AFTER] = [0.0; 2];
        sliding
    }

    /// Begins a step: what is now is the state to which trials of the step go back.
    pub(super) fn keep_springs(&mut self) {
        let scratch = &mut *self.scratch;
        if let Some(spins) = &self.particles.spin {
            scratch.spin.clone_from(spins);
        }
        for sliding in &mut scratch.sliding {
            sliding.start = sliding.now;
            sliding.margins[BEFORE] = sliding.margins[AFTER];
        }
    }

    /// Goes back to the start of the step.
    pub(super) fn restore_spins(&mut self) {
        if let Some(spins) = &mut self.particles.spin {
            spins.clone_from(&self.scratch.spin);
        }
    }

    /// Begins a trial of a step for `count` particles.
    pub(super) fn begin_turning(&mut self, count: usize) {
        let scratch = &mut *self.scratch;
        scratch.turning.clear();
        scratch.turning.resize(count, Vector3::zeros());
        scratch.turned.clear();
        scratch.turned.resize(count, Vector3::zeros());
        for sliding in &mut scratch.sliding {
            (sliding.rate, sliding.mean) = (Vector3::zeros(), Vector3::zeros());
            sliding.now = sliding.start;
        }
    }

    /// Moves spins and springs from the start of the step to a stage `dt` [s] after it, at the rates of the stage
    /// before.
    pub(super) fn turn_to_stage(&mut self, dt: f64) {
        let scratch = &mut *self.scratch;
        if let Some(spins) = &mut self.particles.spin {
            let at_start = scratch.spin.iter().zip(&scratch.turning);
            spins.iter_mut().zip(at_start).for_each(|(spin, (start, rate))| *spin = start + rate * dt);
        }
        for sliding in &mut scratch.sliding {
            sliding.now.vector = sliding.start.vector + sliding.rate * dt;
        }
    }

    /// Adds the rates of a stage to their means.
    pub(super) fn add_turning(&mut self, weight: f64) {
        let scratch = &mut *self.scratch;
        scratch.turned.iter_mut().zip(&scratch.turning).for_each(|(mean, rate)| *mean += rate * weight);
        for sliding in &mut scratch.sliding {
            sliding.mean += sliding.rate * weight;
        }
    }

    /// Moves spins and springs by `dt` [s] at their mean rates, once positions and velocities have been moved.
    pub(super) fn end_turning(&mut self, dt: f64) {
        let scratch = &mut *self.scratch;
        if let Some(spins) = &mut self.particles.spin {
            let at_start = scratch.spin.iter().zip(&scratch.turned);
            spins.iter_mut().zip(at_start).for_each(|(spin, (start, mean))| *spin = start + mean * dt);
        }
        for k in 0..self.scratch.sliding.len() {
            let (touch, met) = self.met(k);
            let motion = SlidingMotion::of(self, &touch, &met);
            let sliding = &mut self.scratch.sliding[k];
            let vector = carried(&(sliding.start.vector + sliding.mean * dt), &sliding.start.normal, &met.normal);
            sliding.now = SpringState { vector, normal: met.normal };
            sliding.shear = match sliding.phase {
                Phase::Stick => vector,
                Phase::Slide => {
                    sliding.now.vector = vector.try_normalize(0.0).unwrap_or(vector);
                    let along = motion.slip.dot(&sliding.now.vector);
                    sliding.now.vector * touch.tangential.sliding_length(motion.limit, along)
                }
                Phase::Free | Phase::Memoryless => Vector3::zeros(),
            };
            self.scratch.sliding[k].margins[AFTER] = self.margins(k, &touch, (&met, &motion), dt);
        }
    }

    /// Force of a contact at a stage of a step of `dt` [s]; torques go to the turning of its particles, and the rate of
    /// its spring is kept.
    pub(super) fn force_at_stage(&mut self, k: usize, touch: &TouchingPair, met: &Encounter, dt: f64) -> ContactForce {
        let motion = SlidingMotion::of(self, touch, met);
        let SlidingMotion { slip, arm, elastic, viscous, limit } = motion;
        let (normal, spring) = (elastic + viscous, &touch.tangential);
        let sliding = &mut self.scratch.sliding[k];
        let SpringState { normal: start, .. } = sliding.start;
        let vector = carried(&sliding.now.vector, &start, &met.normal);
        let spun = |vector: &Vector3<f64>| met.normal.cross(vector) * touch.couple.twist(self.particles, &met.normal);
        let (tangential, rate) = match sliding.phase {
            Phase::Memoryless => {
                let slip =
                    Slip { velocity: slip, acceleration: ContactConstants::pull_along(&touch.couple, met, self.scene) };
                let friction = coulomb(touch.friction, normal, &slip, spring.mass, [dt, 0.0]);
                (friction.map_or_else(Vector3::zeros, |friction| friction.force), Vector3::zeros())
            }
            Phase::Stick => (spring.force(&vector, &slip), slip + spun(&vector)),
            Phase::Slide => {
                let along = slip.dot(&vector);
                let across = slip - vector * along;
                // a spring shorter than the way of a step turns within the step: not faster than the step can follow
                let length = spring.sliding_length(limit, along).max(slip.norm() * dt);
                let turning = if length > 0.0 { across / length } else { across };
                (vector * limit, turning + spun(&vector))
            }
            Phase::Free => (Vector3::zeros(), Vector3::zeros()),
        };
        sliding.rate = carried(&rate, &met.normal, &start);
        let torque = met.normal.cross(&tangential) * arm;
        if let Some(inertia) = &self.particles.inertia {
            for place in touch.couple.places().into_iter().flatten().map(|place| place as usize) {
                self.scratch.turning[place] += torque * (self.particles.radius[place] / inertia[place]);
            }
        }
        let on_i = met.normal * normal - tangential;
        ContactForce {
            on_i,
            normal,
            restitution_power: -viscous * met.normal_velocity,
            friction_power: tangential.dot(&slip),
            wall_power: touch.couple.driven(&on_i, self.scene),
            arm: met.normal * (touch.reach + met.gap),
        }
    }

    /// Margins by which contact `k` is away from the end of its phase, at the end of a trial of a step of `dt` [s]. Accelerations are
    /// those of the last stage, which stands at the end of the step.
    fn margins(
        &self,
        k: usize,
        touch: &TouchingPair,
        (met, motion): (&Encounter, &SlidingMotion),
        dt: f64,
    ) -> [f64; 2] {
        let sliding = &self.scratch.sliding[k];
        let normal = motion.elastic + motion.viscous;
        match sliding.phase {
            Phase::Memoryless => [f64::INFINITY; 2],
            Phase::Stick => {
                [motion.limit - touch.tangential.force(&sliding.now.vector, &motion.slip).norm(), f64::INFINITY]
            }
            Phase::Slide => [self.sliding_rate(touch, met, motion, (sliding, dt)), normal],
            Phase::Free => [-normal, f64::INFINITY],
        }
    }

    /// [m/s] rate λ = s·e - d|ξ|/dt at which the surfaces of a contact slide; a contact that would have to slide
    /// backwards sticks.
    fn sliding_rate(
        &self,
        touch: &TouchingPair,
        met: &Encounter,
        motion: &SlidingMotion,
        (sliding, dt): (&SlidingContact, f64),
    ) -> f64 {
        let (along, spring) = (sliding.now.vector, &touch.tangential);
        let speed = motion.slip.dot(&along);
        if spring.sliding_length(motion.limit, speed) == 0.0 {
            return speed.abs();
        }
        let acceleration = |place: u32| self.scratch.acceleration[place as usize];
        let turning = |place: u32| self.scratch.turning[place as usize] * self.particles.radius[place as usize];
        let (i, j) = (touch.couple.i, touch.couple.j());
        let (relative, surface) = match j {
            Some(j) => (acceleration(i) - acceleration(j), (turning(i) + turning(j)) * motion.arm),
            None => (acceleration(i) + self.scene.gravity, turning(i)),
        };
        let slip_rate = (relative - surface.cross(&met.normal)).dot(&along);
        // the normal of a pair turns
        let turns = if j.is_some() { met.slip().norm_squared() / (touch.reach + met.gap) } else { 0.0 };
        let rate = limit_rate(&self.engine.law, touch, met, (relative.dot(&met.normal) + turns, dt));
        speed - (rate - spring.dashpot * slip_rate) / spring.stiffness
    }

    /// The first end of a phase within a step: the fraction of the step at which it is about to come, the contact, and
    /// the margin that it shows in.
    pub(super) fn first_switch(&self) -> Option<(f64, usize, usize)> {
        let ends = self.scratch.sliding.iter().enumerate().flat_map(|(k, sliding)| {
            let [before, after] = sliding.margins;
            (0..2).filter(move |&which| after[which] < 0.0).map(move |which| {
                let fraction = if before[which] > 0.0 && before[which].is_finite() {
                    before[which] / (before[which] - after[which])
                } else {
                    0.5
                };
                (fraction, k, which)
            })
        });
        ends.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Repeats the step from `start` [s] with the length at which a phase of a contact ends; begins with a fraction of
    /// `dt` [s].
    pub(super) fn find_switch(&mut self, start: f64, dt: f64, (fraction, k, which): (f64, usize, usize)) -> Rates {
        let before = self.scratch.sliding[k].margins[BEFORE][which];
        let mut low = (0.0, before.max(0.0));
        let mut high = (1.0, self.scratch.sliding[k].margins[AFTER][which]);
        let scale = 1e-9 * before.abs().max(high.1.abs());
        let mut fraction = fraction.max(SHORTEST);
        let mut rates = Rates::default();
        for trial in 0..2 * TRIALS {
            rates = self.repeat(start, fraction * dt);
            let margin = self.scratch.sliding[k].margins[AFTER][which];
            if margin.abs() <= scale || fraction <= SHORTEST {
                break;
            }
            if margin < 0.0 {
                high = (fraction, margin)
            } else {
                low = (fraction, margin)
            }
            let linear = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
            let middle = 0.5 * (low.0 + high.0);
            fraction = if trial % 3 == 2 || low.1 == 0.0 { middle } else { linear };
            fraction = fraction.max(SHORTEST);
        }
        rates
    }

    /// Ends the phases that are over now, and that of the contact that is `due` by the given margin.
    pub(super) fn switch_phases(&mut self, due: Option<(usize, usize)>) {
        for k in 0..self.scratch.sliding.len() {
            let sliding = self.scratch.sliding[k];
            let over = || (0..2).rev().find(|&which| sliding.margins[AFTER][which] < 0.0);
            let Some(which) = due.filter(|(of, _)| *of == k).map(|(_, which)| which).or_else(over) else { continue };
            let (touch, met) = self.met(k);
            let motion = SlidingMotion::of(self, &touch, &met);
            let along = |vector: Vector3<f64>| vector.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
            let (phase, vector) = match sliding.phase {
                Phase::Memoryless => continue,
                Phase::Stick => (Phase::Slide, along(touch.tangential.force(&sliding.now.vector, &motion.slip))),
                Phase::Slide if which == 1 => (Phase::Free, Vector3::zeros()),
                Phase::Slide => (Phase::Stick, sliding.shear),
                Phase::Free => (Phase::Slide, along(motion.slip)),
            };
            self.scratch.sliding[k].take(phase, vector);
            self.scratch.sliding[k].margins[AFTER] = [0.0; 2];
        }
    }

    /// [J] energy of the tangential springs of pairs and of walls.
    pub(super) fn spring_energies(&self) -> [f64; 2] {
        let mut energies = [0.0; 2];
        for (contact, sliding) in self.scratch.contacts.iter().zip(&self.scratch.sliding) {
            energies[usize::from(contact.touch.couple.is_wall())] += contact.touch.tangential.energy(&sliding.shear);
        }
        energies
    }

    /// Takes what tangential springs hold more than the energies [J] that they `stored` before a step from the work
    /// that friction did in it.
    pub(super) fn keep_in_springs(&mut self, stored: [f64; 2]) {
        let kept = self.spring_energies();
        let ledger = &mut self.island.log.ledger;
        ledger.pair_friction_loss -= kept[0] - stored[0];
        ledger.wall_friction_loss -= kept[1] - stored[1];
    }

    /// Removes the tangential spring of a contact that has ended: friction takes the energy that it still holds.
    pub(super) fn drop_spring(&mut self, k: usize, touch: &TouchingPair) {
        let left = touch.tangential.energy(&self.scratch.sliding.remove(k).shear);
        let ledger = &mut self.island.log.ledger;
        match touch.couple.is_wall() {
            true => ledger.wall_friction_loss += left,
            false => ledger.pair_friction_loss += left,
        }
    }

    /// Leaves the shears to the contacts.
    pub(super) fn leave_springs(&mut self) {
        let scratch = &mut *self.scratch;
        for (contact, sliding) in scratch.contacts.iter_mut().zip(&scratch.sliding) {
            contact.course.shear = sliding.shear;
        }
    }
}
