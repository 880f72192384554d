//! What choices between ways of moving particles must know of their sizes. It is the same for every order of the store, and on every
//! process that shares a run.

use crate::neighbours::levels::Census;
use crate::particles::Particles;
use crate::scene::Scene;
use std::f64::consts::PI;

/// All particles of a run in a few numbers.
pub struct Population {
    /// How many.
    pub count: usize,
    /// [m] the largest radius.
    pub largest: f64,
    /// [kg] the mass of the lightest.
    pub lightest: f64,
    /// [m], [m²] means of the radius and of its square.
    pub mean_radius: [f64; 2],
    /// [-] volume fraction of the box.
    pub filled: f64,
    /// Whether there are radii that differ.
    pub mixed: bool,
    /// Where sizes are very different: how many of each.
    pub census: Option<Census>,
    /// [1/m³] number density.
    pub density: f64,
}

impl Population {
    /// Of all particles of a run.
    pub fn of(particles: &Particles, scene: &Scene) -> Self {
        let (radius, volume) = (&particles.radius, scene.domain.volume());
        let [mean, square, cube] = particles.mean_radii(1.0);
        Self {
            count: radius.len(),
            largest: radius.iter().copied().fold(0.0, f64::max),
            lightest: particles.mass.iter().copied().fold(f64::INFINITY, f64::min),
            mean_radius: [mean, square],
            filled: cube * radius.len() as f64 * 4.0 / 3.0 * PI / volume,
            mixed: radius.windows(2).any(|pair| pair[0] != pair[1]),
            census: Census::of(radius, volume),
            density: radius.len() as f64 / volume,
        }
    }
}
