//! Forces of the calling program, such as a drag law of its own. They act between windows (times between two exchanges
//! with the gas). The ledger holds the sums of work, losses and impulses since the start.

use super::Simulation;
use super::weight::accelerate;
use crate::record::Ledger;
use nalgebra::Vector3;

impl Simulation {
    /// Accelerates all particles for `duration` [s] without any motion. `acceleration` returns the acceleration [m/s²]
    /// of the particle at a given index in [`particles`](Self::particles). The ledger (sums of work and losses) counts
    /// work and impulse as those of drag.
    ///
    /// Call this method when velocities and positions belong to one time: after [`run`](Self::run), or after
    /// [`complete`](Self::complete). If the acceleration is applied for half a window before and half a window after
    /// each window, its error is of second order in the window (Strang splitting). The drag of the scene has an error
    /// of the same order. The simulation must not be shared with other processes.
    pub fn accelerate(&mut self, acceleration: impl Fn(usize) -> Vector3<f64> + Sync, duration: f64) {
        let began = self.clock.now();
        let sums = accelerate(&mut self.particles, |index, _| acceleration(index) * duration);
        self.book_kick(sums, |drag_impulse, drag_work| Ledger { drag_impulse, drag_work, ..Ledger::default() });
        self.spent.drag += self.clock.now() - began;
    }
}
