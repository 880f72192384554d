//! Steps of an island (group of particles that may meet) by an explicit Runge-Kutta method.

use super::{InstantaneousRule, IslandRun, Rates};
use crate::encounter::FrameTime;
use crate::engine::soft::contact::Contact;
use nalgebra::Vector3;

/// Stage of an explicit Runge-Kutta method in which each stage uses only the stage before.
#[derive(Clone, Copy, Debug)]
pub struct RungeKuttaStage {
    /// [-] time of the stage, as a fraction of the step.
    pub at: f64,
    /// [-] weight of the stage in the mean over the step.
    pub weight: f64,
    /// [-] weight of the stage in the first moment of a force F about the middle of the step, ∫ F (t - Δt/2) dt/Δt²,
    /// with the length Δt of the step. A force that grows linearly from F₀ to F₁ has the moment (F₁ - F₀)/12.
    pub moment: f64,
}

/// Classical Runge-Kutta method of fourth order.
pub const FOURTH_ORDER: [RungeKuttaStage; 4] = [
    RungeKuttaStage { at: 0.0, weight: 1.0 / 6.0, moment: -1.0 / 12.0 },
    RungeKuttaStage { at: 0.5, weight: 1.0 / 3.0, moment: 0.0 },
    RungeKuttaStage { at: 0.5, weight: 1.0 / 3.0, moment: 0.0 },
    RungeKuttaStage { at: 1.0, weight: 1.0 / 6.0, moment: 1.0 / 12.0 },
];

/// Heun's method of second order.
pub const HEUN: [RungeKuttaStage; 2] = [
    RungeKuttaStage { at: 0.0, weight: 0.5, moment: -1.0 / 12.0 },
    RungeKuttaStage { at: 1.0, weight: 0.5, moment: 1.0 / 12.0 },
];

impl<I: InstantaneousRule> IslandRun<'_, I> {
    /// Moves all particles of the island by `dt` [s] with the contacts in progress. Returns the powers and wall forces
    /// as means over this time.
    pub(super) fn integrate(&mut self, dt: f64) -> Rates {
        let stages = self.engine.stages();
        let mut rates = Rates::default();
        let (start, count) = (self.now, self.particles.len());
        let scratch = &mut *self.scratch;
        scratch.acceleration.resize(count, Vector3::zeros());
        scratch.moved.clear();
        scratch.moved.resize(count, Vector3::zeros());
        scratch.kicked.clear();
        scratch.kicked.resize(count, Vector3::zeros());
        self.island.updates += (stages.len() * count) as u64;
        if self.rotates() {
            self.begin_turning(count);
        }
        for stage in stages {
            if stage.at > 0.0 {
                for k in 0..count {
                    let velocity = self.particles.velocity[k];
                    self.particles.position[k] = self.scratch.position[k] + velocity * (stage.at * dt);
                    self.particles.velocity[k] =
                        self.scratch.velocity[k] + self.scratch.acceleration[k] * (stage.at * dt);
                }
                if self.rotates() {
                    self.turn_to_stage(stage.at * dt);
                }
            }
            self.accelerations(start + stage.at * dt, dt, stage, &mut rates);
            let scratch = &mut *self.scratch;
            for k in 0..count {
                scratch.moved[k] += self.particles.velocity[k] * stage.weight;
                scratch.kicked[k] += scratch.acceleration[k] * stage.weight;
            }
            if self.rotates() {
                self.add_turning(stage.weight);
            }
        }
        for k in 0..count {
            self.particles.position[k] = self.scratch.position[k] + self.scratch.moved[k] * dt;
            self.particles.velocity[k] = self.scratch.velocity[k] + self.scratch.kicked[k] * dt;
        }
        self.now = start + dt;
        if self.rotates() {
            self.end_turning(dt);
        }
        rates
    }

    fn accelerations(&mut self, time: f64, dt: f64, stage: &RungeKuttaStage, rates: &mut Rates) {
        self.scratch.acceleration.fill(Vector3::zeros());
        self.scratch.turning.fill(Vector3::zeros());
        self.island.force_evaluations += self.scratch.contacts.len() as u64;
        for k in 0..self.scratch.contacts.len() {
            let Contact { slot, touch, .. } = self.scratch.contacts[k];
            let moment = FrameTime::in_free_fall(time);
            let met = self.encounter(slot as usize, &touch.couple, moment);
            let force = if self.rotates() {
                self.force_at_stage(k, &touch, &met, (moment, dt, stage.weight))
            } else {
                touch.force(&self.engine.law, &met, (self.particles, self.scene), moment, [dt, 0.0])
            };
            rates.count(&touch.couple, &force, [stage.weight, stage.moment]);
            let i = touch.couple.i as usize;
            self.scratch.acceleration[i] += force.on_i / self.particles.mass[i];
            if let Some(j) = touch.couple.j() {
                self.scratch.acceleration[j as usize] -= force.on_i / self.particles.mass[j as usize];
            }
        }
    }
}

/// Fraction [-] of a step of `dt` [s] at which a gap changes sign. It is a root of the cubic polynomial that has the
/// given gaps [m] and rates [m/s] at both ends of the step.
pub fn crossing((gap0, rate0): (f64, f64), (gap1, rate1): (f64, f64), dt: f64) -> f64 {
    let value = |t: f64| {
        let (u, t2) = (1.0 - t, t * t);
        (1.0 + 2.0 * t) * u * u * gap0 + t * u * u * dt * rate0 + t2 * (3.0 - 2.0 * t) * gap1 - t2 * u * dt * rate1
    };
    let (mut low, mut high) = (0.0, 1.0);
    // bisection to the accuracy of the cubic polynomial; Newton's method on the computed motion then improves the
    // result
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if (value(middle) > 0.0) == (gap1 > 0.0) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}
