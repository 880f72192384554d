//! What choices between ways of moving particles must know of their sizes. It is the same for every order of the store, and on every
//! process that shares a run.

use crate::neighbours::levels::Census;
use crate::particles::{CHUNK, Sample};
use crate::scene::Scene;
use crate::work_sharing;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// All particles of a run in a few numbers.
#[derive(Clone, Serialize, Deserialize)]
pub struct PopulationSummary {
    /// How many.
    pub count: usize,
    /// [m] the largest radius.
    pub largest: f64,
    /// [kg] the mass of the lightest.
    pub lightest: f64,
    /// [m], [m²] means of the radius and of its square.
    pub mean_radius: [f64; 2],
    /// [-] volume fraction of the room that the particles have.
    pub filled: f64,
    /// Whether there are radii that differ.
    pub mixed: bool,
    /// Where sizes are very different: how many of each.
    pub census: Option<Census>,
    /// [1/m³] number density.
    pub density: f64,
}

impl PopulationSummary {
    /// Of all particles of a run, of which others may have a part.
    pub fn of(sample: &Sample, scene: &Scene) -> Self {
        let (radius, mass, volume) = (&sample.particles.radius, &sample.particles.mass, scene.room());
        let ([mean, square, cube], count) = (sample.mean_radii(1.0), sample.count());
        // of the negative of a number the largest is that of the least
        let wider = |[a, b, c]: [f64; 3], [d, e, f]: [f64; 3]| [a.max(d), b.max(e), c.max(f)];
        let none = [0.0, f64::NEG_INFINITY, f64::NEG_INFINITY];
        let of_some = |(radius, mass): (&[f64], &[f64])| {
            radius.iter().zip(mass).map(|(&radius, &mass)| [radius, -radius, -mass]).fold(none, wider)
        };
        let parts = work_sharing::map(radius.chunks(CHUNK).zip(mass.chunks(CHUNK)), of_some);
        let [largest, smallest, lightest] = sample.largest(parts.into_iter().fold(none, wider));
        Self {
            count,
            largest,
            lightest: -lightest,
            mean_radius: [mean, square],
            filled: cube * count as f64 * 4.0 / 3.0 * PI / volume,
            mixed: count > 0 && -smallest != largest,
            census: Census::of(sample, [largest, -smallest], volume),
            density: count as f64 / volume,
        }
    }
}
