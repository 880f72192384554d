//! Exchange with the processes that take part in the same uniform steps, if there are any.

use crate::engine::soft::{ContactSums, SoftSolver};
use crate::engine::{Failure, not_a_number};
use crate::particles::Particles;
use crate::scene::Scene;

/// Operations of uniform steps that need other processes. By default they are those of a single process, which has all
/// particles.
pub trait GhostExchange {
    /// True if this process is the lead, or the only one.
    fn is_lead(&self) -> bool {
        true
    }

    /// Replaces each value by the largest of all processes.
    fn largest(&self, _values: &mut [f64]) {}

    /// Adds up the sums over contacts of all processes.
    fn gather(&self, _sums: &mut ContactSums) {}

    /// Returns the result of all processes together: a failure if any process has one.
    fn agree(&self, result: Result<(), Failure>) -> Result<(), Failure> {
        result
    }

    /// Failure for the particle of any process whose velocity is not a number, at `time` [s].
    fn not_a_number(&self, _solver: &SoftSolver, particles: &Particles, time: f64) -> Failure {
        not_a_number(particles, time)
    }

    /// Rebuilds the list, for uses `times.0` [s] apart. Other processes get particles that have left their domain; before,
    /// the last forces are applied for the time `times.1` [s] for which they are still due.
    fn rebuild(&mut self, solver: &mut SoftSolver, particles: &mut Particles, scene: &Scene, times: [f64; 2]) {
        solver.rebuild(particles, scene, times[0]);
    }

    /// Prepares for a kick that may have to be taken back because another process fails.
    fn before_kick(&mut self, _particles: &Particles) {}

    /// Sends the velocities after a kick to the processes that see these particles. If any process has failed to compute
    /// the `forces`, the kick is taken back.
    ///
    /// # Errors
    /// The first failure of any process.
    fn after_kick(
        &mut self,
        _solver: &mut SoftSolver,
        _particles: &mut Particles,
        forces: Result<(), Failure>,
    ) -> Result<(), Failure> {
        forces
    }
}

/// Exchange of a single process, which has all particles.
pub struct SingleProcess;

impl GhostExchange for SingleProcess {}
