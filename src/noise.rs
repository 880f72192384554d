//! Random numbers as a function of a seed, a step and a particle or cell. They do not depend on the order in which they
//! are drawn.
//!
//! The generator is ChaCha with eight rounds, used as a counter. The key consists of the seed and the use, the stream
//! is the number of the step, and the position in the stream is that of the particle or cell. Results are therefore
//! equal for any number of threads and processes, for any order of the particle store, and after a stopped run is
//! continued.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Binary logarithm of the number of blocks of 64 bytes for one particle or cell in one step, which is more than is
/// ever drawn. Together with ids of 32 bits, it fits into the block counter of 64 bits.
const BLOCKS: u32 = 32;

/// Purpose of random numbers. For equal seeds, different purposes have independent numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseUse {
    /// Initial fluctuations of the gas that particles see.
    FirstEddies = 1,
    /// Later fluctuations of the gas that particles see.
    Eddies = 2,
    /// Random collisions (DSMC), with separate numbers for each cell.
    Collisions = 3,
}

/// Random numbers of all particles or cells in one step.
pub struct Noise(ChaCha8Rng);

impl Noise {
    /// Random numbers for a purpose in the step with the number `step`, of a run with the seed `seed`.
    pub fn new(seed: u64, purpose: NoiseUse, step: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&(purpose as u64).to_le_bytes());
        let mut random = ChaCha8Rng::from_seed(key);
        random.set_stream(step);
        Self(random)
    }

    /// Generator at the first number of the particle or cell `id`.
    #[inline]
    pub fn of(&mut self, id: u32) -> &mut ChaCha8Rng {
        self.0.set_block_pos(u64::from(id) << BLOCKS);
        &mut self.0
    }

    /// [-] first `N` vectors of the particle `id`. Their components are independent Gaussian numbers with mean 0 and
    /// variance 1.
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

    /// Means over 1e5 numbers have standard errors of 3.2e-3, means of squares 4.5e-3; the test allows five standard
    /// errors.
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
