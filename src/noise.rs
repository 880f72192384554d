//! Random numbers that are a function of a seed, a step and a particle or cell, and not of the order in which they are
//! drawn.
//!
//! The generator is ChaCha with eight rounds, used as a counter. Its key contains the seed and the use, its stream is
//! the number of the step, and the position in the stream is that of the particle or cell. So results do not depend on
//! the numbers of threads and processes, on the order of the particle store, or on a stop and continuation of the run.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Binary logarithm of the number of 64-byte blocks reserved for one particle or cell in one step; no step draws so
/// many. The block counter has 64 bits, so that 32 bits remain for the number of the particle or cell.
const BLOCKS: u32 = 32;

/// Purpose of random numbers. Different uses have independent numbers for equal seeds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseUse {
    /// Initial fluctuations of the gas that particles see.
    FirstEddies = 1,
    /// Later fluctuations of the gas that particles see.
    Eddies = 2,
    /// Collisions by chance; each cell has separate numbers.
    Collisions = 3,
}

/// Random numbers of all particles or cells in one step.
pub struct Noise(ChaCha8Rng);

impl Noise {
    /// Creates the random numbers of one use, in the step number `step` of a run with the seed `seed`.
    pub fn new(seed: u64, purpose: NoiseUse, step: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&(purpose as u64).to_le_bytes());
        let mut random = ChaCha8Rng::from_seed(key);
        random.set_stream(step);
        Self(random)
    }

    /// Returns the generator, moved to the first random number of the particle or cell `id`.
    #[inline]
    pub fn of(&mut self, id: u32) -> &mut ChaCha8Rng {
        self.0.set_block_pos(u64::from(id) << BLOCKS);
        &mut self.0
    }

    /// [-] first `N` random vectors of the particle `id`. Their components are independent Gaussian numbers of mean 0
    /// and variance 1.
    #[inline]
    pub fn normals<const N: usize>(&mut self, id: u32) -> [Vector3<f64>; N] {
        let random = self.of(id);
        std::array::from_fn(|_| Vector3::from_fn(|_, _| StandardNormal.sample(random)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_do_not_depend_on_the_order_of_draws() {
        let mut noise = Noise::new(7, NoiseUse::Eddies, 3);
        let forwards: Vec<[Vector3<f64>; 2]> = (0..100).map(|id| noise.normals(id)).collect();
        let mut again = Noise::new(7, NoiseUse::Eddies, 3);
        let mut backwards: Vec<[Vector3<f64>; 2]> = (0..100).rev().map(|id| again.normals(id)).collect();
        backwards.reverse();
        assert_eq!(forwards, backwards);
    }

    /// Checks means and squares of 1e5 numbers, whose standard errors are 3.2e-3 and 4.5e-3. Five standard errors are
    /// allowed.
    #[test]
    fn seeds_uses_steps_and_particles_are_independent() {
        let of = |seed, purpose, step, id| Noise::new(seed, purpose, step).normals::<1>(id)[0].x;
        let base: Vec<f64> = (0..100_000).map(|id| of(1, NoiseUse::Eddies, 0, id)).collect();
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / base.len() as f64;
        assert!(mean(&mut base.iter().copied()).abs() < 0.016);
        assert!((mean(&mut base.iter().map(|x| x * x)) - 1.0).abs() < 0.023);
        let others: [&dyn Fn(u32) -> f64; 4] = [
            &|id| of(2, NoiseUse::Eddies, 0, id),
            &|id| of(1, NoiseUse::FirstEddies, 0, id),
            &|id| of(1, NoiseUse::Eddies, 1, id),
            &|id| of(1, NoiseUse::Eddies, 0, id + 1),
        ];
        for (number, other) in others.into_iter().enumerate() {
            let product = mean(&mut (0..).zip(&base).map(|(id, x)| x * other(id)));
            assert!(product.abs() < 0.016, "{number}: {product}");
        }
    }
}
