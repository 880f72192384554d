//! Stress in the particles, mean number of contacts per particle, and volume fraction of particles in each slice.

use super::{Needs, Observer, plain_data};
use crate::domain::Domain;
use crate::exact::ExactSum;
use crate::experiment::Experiment;
use crate::particles::{CHUNK, Sample};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::{Estimate, estimate};
use crate::work_sharing;
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::ops::Range;

/// Largest number of samples (instants of measurement) that are used. More samples would improve neither averages nor
/// errors.
const MOST_SAMPLES: u64 = 400;

/// Time averages of the stress in the particles, with components in the order xx, yy, zz, xy, xz, yz. Compression is
/// positive. An average is `None` if the run has too few instants of measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Stress {
    /// [Pa] kinetic part: Σ m c c over all particles, divided by the volume of the box. m is the mass of a particle,
    /// and c its velocity relative to the mean velocity of its slice at the same instant.
    pub kinetic: [Option<Estimate>; 6],
    /// [Pa] contact part: time average of Σ r f divided by the volume of the box. r is the vector between the centres
    /// of two particles in contact, and f is the force between them. For hard spheres, the time integral of f is the
    /// impulse of a collision.
    pub contact: [Option<Estimate>; 6],
    /// [Pa] sum of the kinetic and the contact part, component by component.
    pub total: [Option<Estimate>; 6],
    /// [Pa] pressure: a third of the trace of the total stress, kinetic part plus contact part.
    pub pressure: Option<Estimate>,
    /// [-] ratio of the pressure to its kinetic part. For a gas without mean flow it is the compressibility factor Z.
    pub compressibility: Option<Estimate>,
    /// [-] mean number of bodies in contact with a particle at an instant, including walls. `None` for models without
    /// lasting contacts: hard spheres and collisions by chance (DSMC).
    pub coordination: Option<Estimate>,
    /// [-] volume fraction of the particles in each slice, in the order of increasing y.
    pub volume_fraction: Vec<Option<Estimate>>,
}

/// Sums over all particles from which the stress at one instant is computed.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct StressSample {
    /// [J] kinetic sum Σ m c c over all particles, with the mass m and the velocity c relative to the mean velocity of
    /// the slice. The order of the components is xx, yy, zz, xy, xz, yz.
    kinetic: [f64; 6],
    /// [J s] time integral of the contact sum Σ r f since the start, with the vector r between two centres and the
    /// force f. The order of the components is xx, yy, zz, xy, xz, yz.
    contact: [f64; 6],
    /// [-] mean number of bodies in contact with a particle at this instant.
    touched: f64,
    /// [m³] volume of the parts of particles that lie within each slice.
    filled: Vec<f64>,
}

/// Measurement of the stress and the volume fraction at several instants of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Stresses {
    /// Number n: every n-th sample (instant of measurement) of the run is used.
    every: u64,
    /// [s] time between two used samples (instants of measurement).
    interval: f64,
    slices: usize,
    /// [m³] volume of the box, by which the sums are divided.
    volume: f64,
    lasts: bool,
    samples: Vec<StressSample>,
}

impl Stresses {
    /// Creates the observer for a run of `experiment`. `schedule` contains the instants of measurement.
    pub fn new(experiment: &Experiment, schedule: &Schedule) -> Self {
        let every = schedule.samples.div_ceil(MOST_SAMPLES).max(1);
        Self {
            every,
            interval: every as f64 * schedule.interval(),
            slices: experiment.statistics.slices,
            volume: experiment.scene.domain.volume(),
            lasts: experiment.model().has_contacts(),
            samples: Vec::new(),
        }
    }

    /// Time averages of the stress from the sample (instant of measurement) of the run with the index `first` to the
    /// end.
    pub fn averages(&self, first: usize) -> Stress {
        let samples = self.samples.get(first.div_ceil(self.every as usize)..).unwrap_or_default();
        let kinetic = |k: usize| samples.iter().map(|sample| sample.kinetic[k] / self.volume).collect::<Vec<_>>();
        let contact = |k: usize| {
            let within =
                |pair: &[StressSample]| (pair[1].contact[k] - pair[0].contact[k]) / (self.interval * self.volume);
            samples.windows(2).map(within).collect::<Vec<_>>()
        };
        // per interval between samples: the kinetic part is the mean of the values at both ends, the contact part the
        // change within the interval
        let total = |k: usize| {
            let moving = samples.windows(2).map(|pair| 0.5 * (pair[0].kinetic[k] + pair[1].kinetic[k]) / self.volume);
            moving.zip(contact(k)).map(|(moving, pushing)| moving + pushing).collect::<Vec<_>>()
        };
        let traces: Vec<(f64, f64)> = samples
            .windows(2)
            .map(|pair| {
                let trace = |six: &[f64; 6]| (six[0] + six[1] + six[2]) / (3.0 * self.volume);
                let moving = 0.5 * (trace(&pair[0].kinetic) + trace(&pair[1].kinetic));
                (moving, (trace(&pair[1].contact) - trace(&pair[0].contact)) / self.interval)
            })
            .collect();
        let pressure: Vec<f64> = traces.iter().map(|(moving, pushing)| moving + pushing).collect();
        let moving = traces.iter().map(|(moving, _)| moving).sum::<f64>() / traces.len().max(1) as f64;
        let over: Vec<f64> = pressure.iter().map(|pressure| pressure / moving).collect();
        let touched: Vec<f64> = samples.iter().map(|sample| sample.touched).collect();
        let layer = self.volume / self.slices as f64;
        let filled = |slice: usize| samples.iter().map(|sample| sample.filled[slice] / layer).collect::<Vec<_>>();
        Stress {
            kinetic: std::array::from_fn(|k| estimate(&kinetic(k))),
            contact: std::array::from_fn(|k| estimate(&contact(k))),
            total: std::array::from_fn(|k| estimate(&total(k))),
            pressure: estimate(&pressure),
            compressibility: estimate(&over).filter(|_| moving > 0.0),
            coordination: estimate(&touched).filter(|_| self.lasts),
            volume_fraction: (0..self.slices).map(|slice| estimate(&filled(slice))).collect(),
        }
    }
}

impl Observer for Stresses {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        Some(now + self.interval)
    }

    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        let relative = simulation.relative_to_flow();
        let sample = simulation.sample().with(&relative);
        let (kinetic, filled) = sums(sample, &simulation.scene().domain, self.slices);
        let contact = six(&simulation.record.ledger.pair_virial);
        let touched =
            if self.lasts { simulation.touching().ends as f64 / simulation.count().max(1) as f64 } else { 0.0 };
        self.samples.push(StressSample { kinetic, contact, touched, filled });
    }

    plain_data!();
}

/// Six components of the symmetric part of a tensor, in the order xx, yy, zz, xy, xz, yz. For example, xy is the mean
/// of the elements xy and yx.
fn six(m: &Matrix3<f64>) -> [f64; 6] {
    let mean = |i: usize, j: usize| 0.5 * (m[(i, j)] + m[(j, i)]);
    [mean(0, 0), mean(1, 1), mean(2, 2), mean(0, 1), mean(0, 2), mean(1, 2)]
}

/// Kinetic sums Σ m c c [J] in the order xx, yy, zz, xy, xz, yz, and the volume of the particles [m³] in each slice. m
/// is the mass of a particle, and c its velocity relative to the mean velocity of its slice. The results depend
/// neither on the number of threads nor on the order of the particles.
fn sums(all: Sample, domain: &Domain, slices: usize) -> ([f64; 6], Vec<f64>) {
    let particles = all.particles;
    let thickness = domain.size.y / slices as f64;
    let per_length = 1.0 / thickness;
    let layers = |place: usize| {
        let y = particles.position[place].y;
        per_length * if domain.periodic[1] { y.rem_euclid(domain.size.y) } else { y }
    };
    let sums = all.sums_in_groups(slices, |place| {
        let (v, m) = (&particles.velocity[place], particles.mass[place]);
        let p = v * m;
        let products = [p.x * v.x, p.y * v.y, p.z * v.z, p.x * v.y, p.x * v.z, p.y * v.z];
        let [xx, yy, zz, xy, xz, yz] = products;
        ((layers(place) as u32 as usize).min(slices - 1), [1.0, m, p.x, p.y, p.z, xx, yy, zz, xy, xz, yz, 0.0])
    });
    let piece = |range: Range<usize>| {
        let mut filled = vec![ExactSum::default(); slices];
        for place in range {
            fill(&mut filled, layers(place), particles.radius[place] * per_length, domain.periodic[1]);
        }
        filled
    };
    // the number of pieces is limited, since each piece has a copy of all sums
    let pieces = particles.len().div_ceil(CHUNK).clamp(1, 2 * rayon::current_num_threads());
    let start = |k: usize| particles.len() * k / pieces;
    let mut filled = vec![ExactSum::default(); slices];
    for some in work_sharing::map(0..pieces, |k| piece(start(k)..start(k + 1))) {
        filled.iter_mut().zip(&some).for_each(|(all, some)| all.merge(some));
    }
    all.total(&mut filled.iter_mut().collect::<Vec<_>>());
    let mut kinetic = [0.0; 6];
    for [count, mass, x, y, z, products @ .., _] in sums {
        // a single particle in a slice does not move relative to the mean velocity of the slice
        if count > 1.0 {
            // the sum of squares about the mean of n velocities is too small by the factor (n - 1)/n
            let whole = count / (count - 1.0);
            let of_mean = [x * x, y * y, z * z, x * y, x * z, y * z];
            for (sum, (product, mean)) in kinetic.iter_mut().zip(products.iter().zip(of_mean)) {
                *sum += (product - mean / mass) * whole;
            }
        }
    }
    (kinetic, filled.iter().map(|layers| layers.value() * thickness.powi(3)).collect())
}

/// Adds to each layer the volume of the part of a sphere that lies in this layer. `y` is the coordinate of the centre.
/// Lengths are in units of the thickness of a layer; layer k extends from k to k + 1. If `periodic` is true, parts
/// beyond one end are added at the other end. If it is false, they are left out.
fn fill(filled: &mut [ExactSum], y: f64, radius: f64, periodic: bool) {
    let whole = 4.0 / 3.0 * PI * (radius * radius * radius);
    // most spheres are within one layer; the cast turns negative numbers into 0
    if y >= radius
        && (y - radius) as u32 == (y + radius) as u32
        && let Some(volume) = filled.get_mut(y as u32 as usize)
    {
        volume.add(whole);
        return;
    }
    let (low, high) = ((y - radius).floor(), (y + radius).floor());
    // the part of a sphere below a height h over its lowest point has the volume π h² (3 r - h)/3
    let below = |level: f64| {
        let h = (level - (y - radius)).clamp(0.0, 2.0 * radius);
        PI * h * h * (3.0 * radius - h) / 3.0
    };
    let mut already = 0.0;
    let count = filled.len() as i64;
    for layer in low as i64..=high as i64 {
        let until = if layer == high as i64 { whole } else { below(layer as f64 + 1.0) };
        let place = if periodic { layer.rem_euclid(count) } else { layer };
        // the part of the sphere outside the box is not counted
        if let Some(volume) = usize::try_from(place).ok().and_then(|place| filled.get_mut(place)) {
            volume.add(until - already);
        }
        already = until;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::values;

    #[test]
    fn a_sphere_fills_what_it_covers() {
        // first a hemisphere in each of two layers, the second one across the periodic side; caps of height r/2 contain
        // 5/32 of the volume of a sphere
        let ball = 4.0 / 3.0 * PI;
        for (y, radius, periodic, want) in [
            (1.0, 0.5, false, [0.5, 0.5, 0.0]),
            (0.0, 0.5, true, [0.5, 0.0, 0.5]),
            (0.0, 0.5, false, [0.5, 0.0, 0.0]),
            (1.5, 0.25, false, [0.0, 1.0, 0.0]),
            (1.5, 1.0, false, [5.0 / 32.0, 22.0 / 32.0, 5.0 / 32.0]),
        ] {
            let mut filled: [ExactSum; 3] = Default::default();
            fill(&mut filled, y, radius, periodic);
            let filled = values(&filled);
            for (got, want) in filled.iter().zip(want) {
                assert!((got / (ball * radius.powi(3)) - want).abs() < 1e-12, "{y} {radius}: {filled:?}");
            }
        }
    }
}
