//! Random numbers as a function of a seed, a step and a particle or cell. They do not depend on the order in which they
//! are computed.
//!
//! The generator is ChaCha with eight rounds, used as a counter. Its key contains the seed and the purpose of the
//! numbers ([`NoiseUse`]). The step selects one of the streams of the generator, and the number of the particle or cell
//! the position in this stream. So results do not depend on the numbers of threads and processes, on the order of the
//! particle store, or on a stop and continuation of the run.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Binary logarithm of the number of blocks of 64 bytes that are reserved for one particle or cell in one step. No step
/// needs so many. The block counter of the generator has 64 bits, so 32 bits remain for the number of the particle or
/// cell.
const BLOCKS: u32 = 32;

/// Purpose of random numbers. Two purposes have independent numbers, even for the same seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseUse {
    /// Initial fluctuations of the gas velocity at the particles.
    FirstEddies = 1,
    /// Fluctuations of the gas velocity at the particles during the run.
    Eddies = 2,
    /// Collisions of pairs that are chosen at random (direct simulation Monte Carlo); each cell has separate numbers.
    Collisions = 3,
    /// Random inclinations of the facets of rough walls in impacts.
    Facets = 4,
    /// Random accelerations of the particles by a thermostat.
    Thermostat = 5,
    /// Rebounds from thermal walls, which give spheres the velocities of a gas.
    ThermalWalls = 6,
    /// Sizes, velocities and spins of the particles that come in through inlets.
    Inlets = 7,
    /// Positions of the particles that come in through inlets.
    InletPositions = 8,
}

/// One number of 64 bits computed from several numbers, `words`. If any of the words changes, the result is as
/// different as a new random number. The mixing function is that of SplitMix64 (Steele, Lea and Flood 2014, OOPSLA).
pub fn mixed(words: &[u64]) -> u64 {
    let mix = |z: u64, shift: u32, factor: u64| (z ^ (z >> shift)).wrapping_mul(factor);
    words.iter().fold(0, |so_far, word| {
        let z = (so_far ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15); // constants of Steele et al.
        let z = mix(mix(z, 30, 0xbf58_476d_1ce4_e5b9), 27, 0x94d0_49bb_1331_11eb); // Steele et al.
        z ^ (z >> 31)
    })
}

/// Generator of the random numbers that all particles or cells need in one step for one purpose ([`NoiseUse`]).
pub struct Noise(ChaCha8Rng);

impl Noise {
    /// Creates the generator for one purpose, in the step number `step` of a run with the seed `seed`.
    pub fn new(seed: u64, purpose: NoiseUse, step: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&(purpose as u64).to_le_bytes());
        let mut random = ChaCha8Rng::from_seed(key);
        random.set_stream(step);
        Self(random)
    }

    /// Returns the random generator, set to the first number reserved for the particle or cell `id`.
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

    /// Checks that the results of [`mixed`] for successive words differ in half of their 64 bits. The mean over 1000
    /// pairs has a standard error of 4/sqrt(1000) = 0.13 bits, and a deviation of five standard errors is allowed.
    #[test]
    fn mixed_words_differ_in_half_of_their_bits() {
        let differ = |word: u64| (mixed(&[7, word]) ^ mixed(&[7, word + 1])).count_ones();
        let mean = f64::from((0..1000).map(differ).sum::<u32>()) / 1000.0;
        assert!((mean - 32.0).abs() < 0.65, "{mean}");
        assert_ne!(mixed(&[1, 2]), mixed(&[2, 1]));
    }

    /// Checks mean and mean square of 1e5 numbers, whose standard errors are 3.2e-3 and 4.5e-3. Also checks that the
    /// numbers are not correlated with those of another seed, purpose, step or particle. Five standard errors are
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
