//! Summary of the particles' sizes, by which engines choose between methods. The summary does not depend on the order
//! of the particles in the store, and is the same in all processes that share a run.

use crate::domain::Domain;
use crate::neighbours::levels::Census;
use crate::particles::{CHUNK, Particles, Sample};
use crate::scene::Scene;
use crate::work_sharing;
use nalgebra::Vector3;
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
    /// [-] volume fraction: volume of the particles over that of the box, or of the smallest hollow wall in it.
    pub filled: f64,
    /// [-] mean volume fraction around a particle. It is larger than `filled` if gravity holds the particles in a layer
    /// that does not fill the box. It equals `filled` if forces outside the engine, such as drag, act between windows,
    /// since no choice then depends on it. It also equals `filled` if each process stores only some of the particles at
    /// the start of a run.
    pub crowded: f64,
    /// True if not all particles have equal radii.
    pub mixed: bool,
    /// Number of particles in each range of sizes; `None` if the sizes differ so little that a single grid of cells
    /// serves for all.
    pub census: Option<Census>,
    /// [1/m³] number density: number of particles per volume of the box, or of the smallest hollow wall in it.
    pub density: f64,
}

impl PopulationSummary {
    /// Summary of all particles of a run, some of which may be stored by other processes; all these processes must call
    /// this function.
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
        let of_all = cube * 4.0 / 3.0 * PI;
        let filled = of_all * count as f64 / volume;
        // counting the particles in cells in every window would cost a tenth of the time of case D on two threads
        let is_layer = scene.gravity != Vector3::zeros() && !scene.is_kicked() && !sample.is_part();
        let crowded = if is_layer { of_all * crowded_density(sample.particles, &scene.domain) } else { filled };
        Self {
            count,
            largest,
            lightest: -lightest,
            mean_radius: [mean, square],
            filled,
            crowded: crowded.max(filled),
            mixed: count > 0 && -smallest != largest,
            census: Census::of(sample, [largest, -smallest], volume),
            density: count as f64 / volume,
        }
    }
}

/// [1/m³] number density around a particle: the mean density of the box, or the local density if it is more than twice
/// the mean, as in a layer on the floor of a high box.
pub fn crowded_density(particles: &Particles, domain: &Domain) -> f64 {
    /// [-] ratio of the local density to the mean density above which the local density is used. In a gas without
    /// clusters the two differ only by chance, and this difference must not change the choice of methods.
    const CROWDED: f64 = 2.0;
    let diameter = 2.0 * particles.radius.iter().fold(0.0, |a: f64, &r| a.max(r));
    let mean = particles.len().max(1) as f64 / domain.volume();
    let local = local_density(&particles.position, domain, diameter);
    if local > CROWDED * mean { local } else { mean }
}

/// [1/m³] number density in the neighbourhood of a particle, averaged over all particles. It exceeds the mean density
/// of the box where particles lie in a layer or in clusters. `diameter` [m] is that of the largest particle.
///
/// The particles are counted in cells with edges of at least about three diameters. A particle in a cell of volume V
/// with n particles has (n - 1)/V neighbours per volume. For points at random positions, the average of this value is
/// the mean density.
fn local_density(positions: &[Vector3<f64>], domain: &Domain, diameter: f64) -> f64 {
    /// Largest number of cells per particle, so that a nearly empty box needs little memory; the cells are larger
    /// there.
    const CELLS: f64 = 4.0;
    let most = (CELLS * positions.len() as f64).max(1.0);
    let edge = (3.0 * diameter).max((domain.volume() / most).cbrt());
    let cells = domain.size.map(|size| (size / edge).floor().clamp(1.0, most));
    let [across, up, along] = [cells.x, cells.y, cells.z].map(|count| count as usize);
    let mut counts = vec![0_u64; across * up * along];
    for position in positions {
        let cell = domain.wrap(position).component_div(&domain.size).component_mul(&cells);
        let [x, y, z] = [(cell.x, across), (cell.y, up), (cell.z, along)]
            .map(|(cell, count)| (cell.max(0.0) as usize).min(count - 1));
        counts[(z * up + y) * across + x] += 1;
    }
    let pairs: u64 = counts.iter().map(|count| count * count.saturating_sub(1)).sum();
    let cell = domain.volume() / counts.len() as f64;
    pairs as f64 / (positions.len().max(1) as f64 * cell)
}
