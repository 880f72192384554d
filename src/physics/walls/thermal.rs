//! Thermal walls: spheres leave them as if they came from a gas of the wall's temperature.

use super::roughness::{WallApproach, perpendicular};
use crate::noise::{Noise, NoiseUse, mixed};
use nalgebra::Vector3;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;

/// Diffuse reflection at a wall, for instantaneous impacts (Maxwell 1879, Phil. Trans. R. Soc. 170, 231, with the
/// accommodation coefficient 1). The velocity after an impact does not depend on the velocity before. The new
/// components along the wall are Gaussian with the variance T_w. The new normal component u has the density u/T_w
/// exp(-u²/(2 T_w)), which is that of spheres that leave a gas of the temperature T_w through an opening.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ThermalWall {
    /// [m²/s²] temperature T_w of the wall, as the variance of a velocity component of any sphere, > 0.
    pub temperature: f64,
    /// Seed of the random numbers that determine the velocities after impacts.
    pub seed: u64,
}

impl ThermalWall {
    /// [m/s] velocity of the particle after an impact, relative to the wall. The random choice depends only on the
    /// seed, the wall, the particle and its velocity.
    pub fn rebound(&self, impact: &WallApproach) -> Vector3<f64> {
        let (first, second) = perpendicular(&impact.normal);
        let velocity = impact.velocity.map(f64::to_bits);
        let words = [velocity.x, velocity.y, velocity.z, u64::from(impact.wall)];
        let mut noise = Noise::new(self.seed, NoiseUse::ThermalWalls, mixed(&words));
        let random = noise.of(impact.id);
        let [a, b]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(random));
        // a random number is in 0 ..= 1 - 2^-53, so that the logarithm is finite
        let normal = (-2.0 * (-random.random::<f64>()).ln_1p()).sqrt();
        (first * a + second * b + impact.normal * normal) * self.temperature.sqrt()
    }
}
