//! Kicks of a thermostat: heating changes the velocities of all particles and leaves their positions as they are.

use super::Simulation;
use super::weight::accelerate;
use crate::noise::{Noise, NoiseUse};
use crate::particles::CHUNK;
use crate::record::Ledger;
use crate::scene::Thermostat;
use crate::work_sharing;
use nalgebra::Vector3;

impl Simulation {
    /// Heats the particles for `duration` [s]. `number` is the number of this change of velocities, which determines
    /// its random numbers.
    pub(super) fn heat(&mut self, duration: f64, number: u64) {
        let Some(thermostat) = self.scene.thermostat else { return };
        let began = self.clock.now();
        let mut changes = match thermostat {
            Thermostat::Stochastic { heating } => self.random_changes((heating * duration).sqrt(), number),
            Thermostat::Gaussian { rate } => self.grown_changes((rate * duration).exp_m1()),
        };
        // the mean change is subtracted, so that the heating gives no momentum
        let mass = &self.particles.mass;
        let [all, x, y, z] = self.sample().sums(|index| {
            let momentum = changes[index] * mass[index];
            [mass[index], momentum.x, momentum.y, momentum.z]
        });
        if all > 0.0 {
            let mean = Vector3::new(x, y, z) / all;
            work_sharing::for_each(changes.chunks_mut(CHUNK), |chunk| chunk.iter_mut().for_each(|one| *one -= mean));
        }
        let sums = accelerate(&mut self.particles, |index, _| changes[index]);
        self.book_kick(sums, |thermostat_impulse, thermostat_work| Ledger {
            thermostat_work,
            thermostat_impulse,
            ..Ledger::default()
        });
        self.spent.drag += self.clock.now() - began;
    }

    /// [m/s] independent Gaussian changes of velocity, one per particle. Each component has the standard deviation
    /// `deviation` [m/s]. `number` is the number of the change, which determines its random numbers.
    fn random_changes(&self, deviation: f64, number: u64) -> Vec<Vector3<f64>> {
        let seed = self.seed;
        let draw = |ids: &[u32]| -> Vec<Vector3<f64>> {
            let mut noise = Noise::new(seed, NoiseUse::Thermostat, number);
            ids.iter().map(|&id| noise.normals::<1>(id)[0] * deviation).collect()
        };
        work_sharing::map(self.particles.id.chunks(CHUNK), draw).concat()
    }

    /// [m/s] changes of velocity: the velocities relative to the mean flow of a sheared box, times `growth` [-].
    fn grown_changes(&self, growth: f64) -> Vec<Vector3<f64>> {
        self.relative_to_flow().velocity.iter().map(|velocity| velocity * growth).collect()
    }
}
