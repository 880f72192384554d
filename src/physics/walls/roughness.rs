//! Roughness of walls: each impact meets a facet that is inclined at random.

use crate::noise::{Noise, NoiseUse, mixed};
use nalgebra::Vector3;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;

/// Roughness of a wall, small compared with the spheres. A sphere meets a plane facet (the virtual wall), whose normal
/// is tilted at random (Sommerfeld and Huber 1999, Int. J. Multiphase Flow 25, 1457).
///
/// The tilts γ_1 and γ_2 in two perpendicular directions along the wall are Gaussian, with the standard deviation Δγ
/// each. The normal is turned by sqrt(γ_1² + γ_2²) towards (γ_1, γ_2). The probability of a facet is proportional to
/// the area that it shows to the sphere: max(0, -û·n'), with the direction û of the flight and the normal n' of the
/// facet. This is the shadow effect. For tilts in the plane of the flight at the angle α to the wall, the density is
/// then that of Sommerfeld and Huber, sin(α + γ)/sin α times the Gaussian. No facet is met from behind.
///
/// A sphere that would move into the wall after the impact would hit a further facet (Konan, Kannengieser and Simonin
/// 2009, Int. J. Multiphase Flow 35, 1). In place of such a facet another one is chosen at random, so that an impact
/// remains a single impact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WallRoughness {
    /// [rad] standard deviation Δγ of the tilt in each of two directions, > 0.
    pub deviation: f64,
    /// Seed of the random numbers that determine the tilts.
    pub seed: u64,
}

/// Data of an impact on a rough or thermal wall, on which the random rebound depends.
#[derive(Clone, Copy, Debug)]
pub struct WallApproach {
    /// [m/s] velocity of the particle relative to the wall.
    pub velocity: Vector3<f64>,
    /// [-] unit normal of the smooth wall towards the particle.
    pub normal: Vector3<f64>,
    /// Id of the particle that hits the wall.
    pub id: u32,
    /// Index of the wall in the scene.
    pub wall: u32,
}

impl WallRoughness {
    /// [-] unit normal of the facet that an impact meets. `restitution` gives the restitution e >= 0 [-] for a normal
    /// speed [m/s]. The random choice depends only on the seed, the wall, the particle and its velocity. The result is
    /// the normal of the smooth wall if the sphere does not approach. The normal of the smooth wall is also the result
    /// if none of `MOST` random facets makes the sphere leave the wall, as at normal incidence with e = 0.
    pub fn facet(&self, impact: &WallApproach, restitution: impl Fn(f64) -> f64) -> Vector3<f64> {
        /// [-] tilt over Δγ that is taken as the largest expected one: the probability of larger tilts is exp(-50).
        const FAR: f64 = 10.0;
        /// Largest number of random facets that are tried for one impact. Even at normal incidence with e = 0.01 and Δγ
        /// = 0.6, one facet in 72 lets the sphere leave the wall.
        const MOST: u32 = 100_000;
        let WallApproach { velocity, normal, id, wall } = *impact;
        if velocity.dot(&normal) >= 0.0 {
            return normal;
        }
        let speed = velocity.norm();
        let toward = -velocity / speed;
        let (first, second) = perpendicular(&normal);
        // upper limit of -û·n', with the direction û of the flight and the normal n' of a facet: a tilt changes this
        // cosine by at most the tilt [rad]
        let most = (toward.dot(&normal) + FAR * self.deviation).min(1.0);
        let words = [velocity.x.to_bits(), velocity.y.to_bits(), velocity.z.to_bits(), u64::from(wall)];
        let mut noise = Noise::new(self.seed, NoiseUse::Facets, mixed(&words));
        let random = noise.of(id);
        for _ in 0..MOST {
            let [a, b]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(random));
            let tilt = self.deviation * a.hypot(b);
            let turn = if tilt > 0.0 { tilt.sin() / tilt } else { 1.0 };
            let facet = normal * tilt.cos() + (first * a + second * b) * (self.deviation * turn);
            let shown = toward.dot(&facet);
            let is_met = random.random::<f64>() * most < shown;
            let approach = shown * speed;
            if is_met && (velocity + facet * ((1.0 + restitution(approach)) * approach)).dot(&normal) > 0.0 {
                return facet;
            }
        }
        normal
    }
}

/// Two unit vectors that are perpendicular to a unit vector and to each other.
pub fn perpendicular(along: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    // the axis that is farthest from the vector keeps the cross product away from 0
    let mut axis = Vector3::zeros();
    axis[along.iamin()] = 1.0;
    let aside = along.cross(&axis).normalize();
    (aside, along.cross(&aside))
}
