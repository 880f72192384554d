//! Exchange with the processes that take part in the same uniform steps, if there are any.

use super::contacts::{EvaluationTime, StepRecord};
use super::{Fastest, SoftSolver};
use crate::communicator::Communicator;
use crate::engine::{Failure, Window, not_a_number};
use crate::particles::Particles;
use crate::scene::Scene;

/// Operations of uniform steps that need the particles of other processes.
pub trait GhostExchange {
    /// Prepares the steps of a window, of `times.1` [s] each: finds the largest speed of all particles, and rebuilds an
    /// outdated list.
    fn begin(
        &mut self,
        solver: &mut SoftSolver,
        particles: &mut Particles,
        scene: &Scene,
        times: (Window, f64),
    ) -> Result<(), Failure>;

    /// Rebuilds the list between two steps; it will be used every `between_uses` [s].
    fn rebuild(&mut self, solver: &mut SoftSolver, particles: &mut Particles, scene: &Scene, between_uses: f64);

    /// Returns the result of all processes together: a failure if any process has one.
    fn agree(&mut self, result: Result<(), Failure>) -> Result<(), Failure>;

    /// Evaluates the forces.
    fn forces(
        &mut self,
        solver: &mut SoftSolver,
        particles: &Particles,
        scene: &Scene,
        at: EvaluationTime,
        book: &mut StepRecord,
    ) -> Result<(), Failure>;

    /// Kicks with the forces of the last evaluation, for `dt` [s].
    fn kick(&mut self, solver: &mut SoftSolver, particles: &mut Particles, dt: f64);

    /// Evaluates the forces, and kicks for the part of a step for which they act.
    fn step(
        &mut self,
        solver: &mut SoftSolver,
        particles: &mut Particles,
        scene: &Scene,
        at: EvaluationTime,
        book: &mut StepRecord,
    ) -> Result<(), Failure>;

    /// Connection to the other processes; `None` without other processes.
    fn communicator(&self) -> Option<&dyn Communicator>;
}

/// Exchange of a single process, which has all particles.
pub struct SingleProcess;

impl GhostExchange for SingleProcess {
    fn begin(
        &mut self,
        solver: &mut SoftSolver,
        particles: &mut Particles,
        scene: &Scene,
        (window, dt): (Window, f64),
    ) -> Result<(), Failure> {
        solver.speed = Fastest { all: particles.largest_speed(solver.list.frame()), ..solver.speed };
        let smallest = || particles.radius.iter().fold(f64::INFINITY, |a: f64, &r| a.min(r));
        solver.smallest = SoftSolver::has_thin_walls(scene).then(smallest);
        if !solver.speed.all.is_finite() {
            return Err(not_a_number(particles, window.start));
        }
        if !solver.list.allows(2.0 * solver.speed.all * dt) {
            solver.rebuild(particles, scene, 2.0 * dt);
        }
        Ok(())
    }

    fn rebuild(&mut self, solver: &mut SoftSolver, particles: &mut Particles, scene: &Scene, between_uses: f64) {
        solver.rebuild(particles, scene, between_uses);
    }

    fn agree(&mut self, result: Result<(), Failure>) -> Result<(), Failure> {
        result
    }

    fn forces(
        &mut self,
        solver: &mut SoftSolver,
        particles: &Particles,
        scene: &Scene,
        at: EvaluationTime,
        book: &mut StepRecord,
    ) -> Result<(), Failure> {
        solver.evaluate(particles, scene, at, book)?;
        solver.contacts.count(at, None);
        Ok(())
    }

    fn kick(&mut self, solver: &mut SoftSolver, particles: &mut Particles, dt: f64) {
        solver.kick(particles, dt);
    }

    fn step(
        &mut self,
        solver: &mut SoftSolver,
        particles: &mut Particles,
        scene: &Scene,
        at: EvaluationTime,
        book: &mut StepRecord,
    ) -> Result<(), Failure> {
        self.forces(solver, particles, scene, at, book)?;
        self.kick(solver, particles, at.weight * at.dt);
        Ok(())
    }

    fn communicator(&self) -> Option<&dyn Communicator> {
        None
    }
}
