//! Kicks (changes of velocities at fixed positions) by the forces of an orbit: Coriolis force and tides. The ledger
//! holds the sums of work, losses and impulses since the start.

use super::Simulation;
use super::weight::accelerate;
use crate::record::Ledger;

impl Simulation {
    /// Applies the forces of the orbit of a sheared box for `duration` [s], without any motion. The ledger counts the
    /// work and impulse of these forces as those of gravity, since tides are differences in gravity and the Coriolis
    /// force does no work.
    pub(super) fn kick_of_orbit(&mut self, duration: f64) {
        let domain = &self.scene.domain;
        let Some(orbit) = domain.orbit() else { return };
        let began = self.clock.now();
        let position = std::mem::take(&mut self.particles.position);
        let middle = 0.5 * domain.size.x;
        let sums = accelerate(&mut self.particles, |index, velocity| {
            let place = &position[index];
            orbit.kick(place.x - middle, &(velocity - domain.mean_flow(place)), duration)
        });
        self.particles.position = position;
        self.book_kick(sums, |gravity_impulse, gravity_work| Ledger {
            gravity_impulse,
            gravity_work,
            ..Ledger::default()
        });
        self.spent.drag += self.clock.now() - began;
    }
}
