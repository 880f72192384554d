//! Uniform steps of soft spheres by Heun's method, a second-order Runge-Kutta scheme, included for comparison with the
//! paper that docs/paper.md describes.

use super::contacts::{EvaluationTime, StepRecord};
use super::{SoftSolver, Window, instant};
use crate::engine::Failure;
use crate::engine::distributed::SingleProcess;
use crate::engine::motion::drift;
use crate::neighbours::along_walls;
use crate::particles::Particles;
use crate::scene::{Scene, SceneInTime};
use nalgebra::Vector3;

impl SoftSolver {
    /// Moves all particles by Heun's method. Each of its two stages uses the overlaps and velocities of one instant.
    pub(super) fn heun(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        steps: u64,
        book: &mut StepRecord,
    ) -> Result<(), Failure> {
        let dt = window.duration / steps as f64;
        let fall = scene.gravity - along_walls(scene, scene.gravity);
        let mut scenes = SceneInTime::of(scene);
        for step in 0..steps {
            let elapsed = step as f64 * dt;
            self.list.clock.tell(window.start + elapsed);
            let mut at = EvaluationTime { weight: 0.5, travel_is_exact: false, ..instant(window, elapsed, dt) };
            self.meet_facets(particles, scenes.at(window.start + elapsed), at);
            self.evaluate(particles, scenes.at(window.start + elapsed), at, book)?;
            self.leave_facets(particles, scenes.at(window.start + elapsed), at);
            self.contacts.count(at, &SingleProcess);
            if self.may_pass(scene, elapsed, dt) {
                self.refuse_to_pass(particles, scene, window, elapsed, dt)?;
            }
            // predictor: position x + v dt and velocity v + a dt, with the acceleration a; the list is rebuilt only
            // between steps, so that indices stay valid
            drift(particles, dt, scene.gravity * (dt * (elapsed + 0.5 * dt)));
            let next = scenes.at(window.start + (elapsed + dt));
            self.kick(particles, &next.domain, dt);
            let travel = (self.closing_speed(particles, &next.domain) + fall.norm() * (elapsed + dt)) * dt;
            self.list.travel(travel);
            std::mem::swap(&mut self.before, &mut self.pushes);
            at = EvaluationTime {
                opens: false,
                weight: 0.5,
                travel_is_exact: false,
                ..instant(window, elapsed + dt, dt)
            };
            self.evaluate(particles, next, at, book)?;
            self.contacts.count(at, &SingleProcess);
            // corrector: the mean of both stages
            for push in self.before.iter().flat_map(|pushes| &pushes.list) {
                let mut take_back = |index: u32, force: Vector3<f64>| {
                    let i = index as usize;
                    let acceleration = force / particles.mass[i];
                    particles.position[i] += acceleration * (0.5 * dt * dt);
                    particles.velocity[i] -= acceleration * (0.5 * dt);
                };
                take_back(push.i, push.force);
                if let Some(j) = push.j {
                    take_back(j.get(), -push.force);
                }
            }
            self.kick(particles, &next.domain, 0.5 * dt);
            if !self.list.allows(2.0 * travel) {
                book.cross(particles, &next.domain);
                self.rebuild(particles, next, 2.0 * dt);
            }
        }
        self.pushes.clear();
        Ok(())
    }
}
