//! Summary of the particles' sizes, by which engines choose between methods. The summary does not depend on the order
//! of the particles in the store, and is equal in all processes that share a run.

use crate::neighbours::levels::Census;
use crate::particles::{CHUNK, Sample};
use crate::scene::Scene;
use crate::work_sharing;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Summary of the sizes of all particles of a run in a few numbers.
#[derive(Clone, Serialize, Deserialize)]
pub struct PopulationSummary {
    /// Number of particles of the run.
    pub count: usize,
    /// [m] largest radius of any particle.
    pub largest: f64,
    /// [kg] mass of the lightest particle.
    pub lightest: f64,
    /// Means over all particles of the radius [m] and of its square [m²].
    pub mean_radius: [f64; 2],
    /// [-] volume fraction: volume of the particles divided by the volume open to them.
    pub filled: f64,
    /// True if not all particles have equal radii.
    pub mixed: bool,
    /// Number of particles in each range of sizes; `None` if the sizes differ so little that a single grid of cells
    /// serves for all.
    pub census: Option<Census>,
    /// [1/m³] number density: number of particles per volume open to them.
    pub density: f64,
}

impl PopulationSummary {
    /// Summary of all particles of a run, some of which may be stored by other processes.
    pub fn of(sample: &Sample, scene: &Scene) -> Self {
        let (radius, mass, volume) = (&sample.particles.radius, &sample.particles.mass, scene.room());
        let ([mean, square, cube], count) = (sample.mean_radii(1.0), sample.count());
        // the smallest value is found as the largest of the values with opposite sign
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
