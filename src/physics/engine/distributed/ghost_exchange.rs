//! Operations with which several processes share uniform time steps, in which all particles move by the same Δt. With a
//! single process they exchange nothing.

use crate::engine::soft::{ContactSums, SoftSolver};
use crate::engine::{Failure, not_a_number};
use crate::particles::Particles;
use crate::scene::Scene;

/// Operations within uniform time steps that involve other processes. The default methods are for a single process,
/// which stores all particles.
pub trait GhostExchange {
    /// True if this process is the lead process (process 0) or the only process.
    fn is_lead(&self) -> bool {
        true
    }

    /// Replaces each value by its largest value in any process.
    fn largest(&self, _values: &mut [f64]) {}

    /// Replaces the sums over the contacts of this process by the sums over the contacts of all processes.
    fn gather(&self, _sums: &mut ContactSums) {}

    /// Combines the results of all processes: the result is a failure if any process has failed.
    fn agree(&self, result: Result<(), Failure>) -> Result<(), Failure> {
        result
    }

    /// Makes the failure at `time` [s] that names a particle whose velocity is not a finite number. The particle may
    /// be in any process.
    fn not_a_number(&self, _solver: &SoftSolver, particles: &Particles, time: f64) -> Failure {
        not_a_number(particles, time)
    }

    /// Builds the neighbour list again, for steps that are `times[0]` [s] apart. If several processes share the run,
    /// particles that have left the block (region of the box) of their process are then sent to the new owner. Before
    /// that, forces that are computed but not yet applied change the velocities, for the remaining time `times[1]` [s].
    fn rebuild(&mut self, solver: &mut SoftSolver, particles: &mut Particles, scene: &Scene, times: [f64; 2]) {
        solver.rebuild(particles, scene, times[0]);
    }

    /// Stores the velocities before a kick (change of velocities by forces), so that the kick can be undone if another
    /// process fails.
    fn before_kick(&mut self, _particles: &Particles) {}

    /// Completes a kick (change of velocities by forces): sends the new velocities to the processes that have copies
    /// of these particles. If any process failed to compute its `forces`, the kick is undone.
    ///
    /// # Errors
    /// A process failed to compute its forces. All processes return the same failure, even if several have failed.
    fn after_kick(
        &mut self,
        _solver: &mut SoftSolver,
        _particles: &mut Particles,
        forces: Result<(), Failure>,
    ) -> Result<(), Failure> {
        forces
    }
}

/// Operations for a single process, which exchanges no data.
pub struct SingleProcess;

impl GhostExchange for SingleProcess {}
