//! Sheared boxes in the calendar (the event queue of all particles). In a sheared box the periodic images beyond the
//! two sides normal to y slide along z. The ledger of a run contains the sums of work, losses and impulses.
//!
//! Particles and their images fly straight also across a sheared side, so their touches are predicted exactly. Only the
//! neighbour lists need a special treatment. A shell, the ball in which the list of a particle is valid, does not move,
//! but its images slide. Time is therefore divided into intervals. Within half an interval, images slide by [`SLIDE`]
//! times the margin, the distance that a particle may move from the centre of its shell. A neighbour list is made for
//! one interval. When the interval ends, all shells near the sheared sides are made anew.

use super::view::CalendarView;
use super::{CalendarWindow, GlobalCalendar, Recent, view_of, whole_of};
use crate::domain::Domain;
use crate::engine::driver::Work;
use crate::engine::hard::impulse::ParticleAccess;
use crate::particles::SideCrossings;
use crate::record::Record;
use crate::scene::Scene;
use nalgebra::Vector3;
use std::borrow::Cow;

/// [-] distance by which images slide in half an interval (time for which neighbour lists across a sheared side are
/// valid), over the margin, the radius of the shells in which lists are valid. With 1 in place of 3, twice as many
/// distances are computed in a gas of 1000 spheres at a volume fraction of 0.3.
pub const SLIDE: f64 = 3.0;

impl<'a> CalendarView<'a> {
    /// The box with its periodic images at their places in the middle of the present interval, the time for which
    /// neighbour lists across sheared sides are valid. The lists are made for these places of the images. Without
    /// shear, the result is the box of the scene itself.
    #[inline]
    pub fn domain_of_lists(&self) -> Cow<'a, Domain> {
        if self.scene.domain.shear.is_none() {
            return Cow::Borrowed(&self.scene.domain);
        }
        self.domain(self.lists_valid_until - 0.5 * interval(self.shells.margin, self.scene))
    }
}

/// Length [s] of an interval of time in which neighbour lists across sheared sides are valid; infinite if no images
/// slide. `margin` [m] is the distance that a particle may move from the centre of its shell, the ball in which its
/// neighbour list is valid.
fn interval(margin: f64, scene: &Scene) -> f64 {
    2.0 * SLIDE * margin / scene.domain.sliding().abs()
}

impl GlobalCalendar {
    /// Begins, at the present time, an interval in which neighbour lists across sheared sides are valid.
    pub(super) fn begin_interval(&mut self, scene: &Scene) {
        self.lists_valid_until = self.now + interval(self.shells.margin, scene);
    }

    /// Gives the particle at `index` a new shell (ball in which its neighbour list is valid), and predicts its events.
    /// In a sheared box the flight of the particle begins anew, at its present place in the box. If the particle has
    /// crossed a sheared side, the work of the crossing is added to the ledger, the sums of energies of the run.
    pub(super) fn renew_shell(&mut self, index: u32, work: &mut Work<Recent>, span: CalendarWindow) {
        if work.scene.domain.shear.is_some() {
            self.cross_sides(index, work);
        }
        let around = view_of!(self, work.scene);
        let particles = ParticleAccess::Exclusive(work.particles);
        let mut part = whole_of!(self, &around, particles, work.log, span);
        part.renew_shell(index);
        let counts = part.counts;
        self.count(counts);
    }

    /// Moves the particle at `index` along its flight to the present time, and shifts it by whole periods into the
    /// sheared box. If it has crossed a sheared side, the work of the crossing is added to the ledger (sums of energies
    /// of the run).
    fn cross_sides(&mut self, index: u32, work: &mut Work<Recent>) {
        let mass = self.shells.mass(&self.bodies[index as usize]);
        let domain = work.scene.domain.at(self.epoch + self.now);
        let body = &mut self.bodies[index as usize];
        body.advance(self.now);
        let before = body.velocity.z + self.frame.velocity_at(self.now).z;
        let change = domain.wrap_motion(&mut body.position, &mut body.velocity);
        if change != 0.0 {
            work.record.ledger += SideCrossings::of(mass, before, change);
        }
    }

    /// Particles that have flown beyond a sheared side of the box. For each of them: index, velocity along z [m/s]
    /// before the crossing of the side, and change of this velocity [m/s] by the crossing.
    fn crossings(&self, domain: &Domain) -> impl Iterator<Item = (usize, f64, f64)> {
        (0..self.bodies.len()).filter_map(|index| {
            let (mut position, mut velocity) = self.motion_in_scene(index);
            let before = velocity.z;
            let change = domain.wrap_motion(&mut position, &mut velocity);
            (change != 0.0).then_some((index, before, change))
        })
    }

    /// Removes from the ledger (sums of energies of the run) the side crossings that were added when positions in the
    /// particle store were shifted into the box. The event queue had written these positions at the end of the last
    /// window. The flights in the queue go on beyond the sheared sides; their crossings are recorded when the particles
    /// get new neighbour lists.
    pub(super) fn take_back_crossings(&self, work: &mut Work<Recent>) {
        if work.scene.domain.shear.is_some() {
            self.crossings(&work.scene.domain).for_each(|crossing| self.take_back(crossing, work.record));
        }
    }

    /// Velocities [m/s] of the particles after a kick (change of velocities, for instance by drag), for their flights
    /// in the event queue. If such a flight goes on beyond a sheared side, the change of velocity by the crossing of
    /// this side is subtracted. The crossing is then removed from the ledger (sums of energies of the run).
    pub(super) fn velocities_after_kick<'a>(&self, work: &'a mut Work<Recent>) -> Cow<'a, [Vector3<f64>]> {
        if work.scene.domain.shear.is_none() {
            return Cow::Borrowed(&work.particles.velocity);
        }
        let mut velocities = work.particles.velocity.clone();
        for (index, _, change) in self.crossings(&work.scene.domain) {
            velocities[index].z -= change;
            self.take_back((index, velocities[index].z, change), work.record);
        }
        Cow::Owned(velocities)
    }

    fn take_back(&self, (index, before, change): (usize, f64, f64), record: &mut Record) {
        record.ledger += -SideCrossings::of(self.shells.mass(&self.bodies[index]), before, change);
    }

    /// Begins the next interval of time in which neighbour lists across sheared sides are valid. Gives new lists to the
    /// particles near the sheared sides, and predicts the events of these particles.
    pub(super) fn next_interval(&mut self, work: &mut Work<Recent>, span: CalendarWindow) {
        self.begin_interval(work.scene);
        for index in 0..self.next_events.len() as u32 {
            if self.shells.is_at_sheared_side(&self.next_events[index as usize].shell, &work.scene.domain) {
                self.renew_shell(index, work, span);
            }
        }
    }
}
