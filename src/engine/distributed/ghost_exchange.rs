//! Operations with which several processes share uniform time steps. For a single process the operations are trivial.

use crate::engine::soft::{ContactSums, SoftSolver};
use crate::engine::{Failure, not_a_number};
use crate::particles::Particles;
use crate::scene::Scene;

/// Operations of uniform steps that involve other processes. The default methods are for a single process, which stores
/// all particles.
pub trait GhostExchange {
    /// True if this process is the lead process, or the only one.
    fn is_lead(&self) -> bool {
        true
    }

    /// Replaces each value by its largest value in any process.
    fn largest(&self, _values: &mut [f64]) {}

    /// Replaces the sums over the contacts of this process by the totals over all processes.
    fn gather(&self, _sums: &mut ContactSums) {}

    /// Returns the joint result of all processes: a failure if any process has failed.
    fn agree(&self, result: Result<(), Failure>) -> Result<(), Failure> {
        result
    }

    /// Makes the failure at `time` [s] for the particle, in any process, whose velocity is not a finite number.
    fn not_a_number(&self, _solver: &SoftSolver, particles: &Particles, time: f64) -> Failure {
        not_a_number(particles, time)
    }

    /// Rebuilds the neighbour list, for uses that are `times[0]` [s] apart. First, forces that are not yet applied act
    /// for the remaining time `times[1]` [s]. Then particles that have left their block are sent to the process that
    /// owns their new block.
    fn rebuild(&mut self, solver: &mut SoftSolver, particles: &mut Particles, scene: &Scene, times: [f64; 2]) {
        solver.rebuild(particles, scene, times[0]);
    }

    /// Stores the velocities before a kick (change of velocities by forces), since the kick is undone if another
    /// process fails.
    fn before_kick(&mut self, _particles: &Particles) {}

    /// Sends the velocities after a kick to the processes that borrow these particles. If any process failed to compute
    /// its `forces`, the kick is undone.
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

/// The operations for a single process, which exchanges no data.
pub struct SingleProcess;

impl GhostExchange for SingleProcess {}
