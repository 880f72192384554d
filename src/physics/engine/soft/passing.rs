//! Detection of uniform steps in which the centre of a sphere passes a thin wall. Times are counted from the start of a
//! window, the time between two exchanges with the gas.

use super::SoftSolver;
use super::contact::{SHORT, passed};
use crate::engine::{Failure, Window};
use crate::particles::Particles;
use crate::scene::Scene;

impl SoftSolver {
    pub(super) fn has_thin_walls(scene: &Scene) -> bool {
        scene.walls.iter().any(|wall| wall.geometry.law().is_thin())
    }

    /// True if a sphere may move so far in a step of `dt` [s] that its centre passes a thin wall without a large
    /// overlap at the start or end of the step. The step begins `elapsed` [s] after the beginning of the window.
    pub(super) fn may_pass(&self, scene: &Scene, elapsed: f64, dt: f64) -> bool {
        let fall = scene.gravity * (elapsed + 0.5 * dt);
        let closing = self.speed.all + self.speed.of_walls + fall.norm();
        self.smallest.is_some_and(|smallest| closing * dt >= SHORT * smallest)
    }

    /// Returns an error if the next step moves the centre of a sphere through a thin wall. Sphere and wall need not
    /// overlap at the start or end of such a step. The step of `dt` [s] begins `elapsed` [s] after the beginning of the
    /// window.
    pub(super) fn refuse_to_pass(
        &self,
        particles: &Particles,
        scene: &Scene,
        window: Window,
        elapsed: f64,
        dt: f64,
    ) -> Result<(), Failure> {
        let fall = scene.gravity * (elapsed + 0.5 * dt);
        for near in self.list.walls.iter().filter(|near| near.at.which == 0) {
            let i = near.particle as usize;
            let from = particles.position[i];
            let to = from + (particles.velocity[i] + fall) * dt;
            // the walls of `scene` are where they were at the beginning of the window
            let ahead = [elapsed, elapsed + dt];
            if scene.walls[near.at.wall as usize].is_passed([&from, &to], particles.radius[i], ahead) {
                let instant = (near.at.wall, window.start + elapsed);
                return Err(passed(particles, i, instant, (to - from).norm()));
            }
        }
        Ok(())
    }
}
