//! Clusters: groups of particles that are connected by pairs whose gap is below a given length.
//!
//! The gap of two spheres is the distance of their centres minus both radii, measured to the nearest image across
//! periodic sides. A particle without such a pair is a cluster of one. Averaged over all particles, the size of the
//! cluster to which a particle belongs is Σ s² n_s/Σ s n_s. Here n_s is the number of clusters of s particles (Stauffer
//! and Aharony, Introduction to Percolation Theory, 2nd edition 1994).

use super::measurements::{Measurement, Observation, ObservedCurve, ObservedNumber, ObservedQuantity};
use super::{Needs, Observer, plain_data};
use crate::experiment::{ClustersSettings, Experiment};
use crate::neighbours::pairs_with_gap;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::estimate;
use serde::{Deserialize, Serialize};

/// Largest number of samples (instants of measurement) that are used. In a run with more samples, only every n-th
/// sample is used.
const MOST_SAMPLES: u64 = 1000;
/// Number of sizes in the size distribution. The last size also stands for all larger clusters.
const SIZES: usize = 50;

/// Numbers and sizes of the clusters (groups of connected particles) at one instant.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct ClusterSample {
    /// [s] simulated time at which the clusters are counted.
    time: f64,
    /// Number of all particles at this instant.
    particles: u64,
    /// Number of clusters, those of one particle included.
    clusters: u64,
    /// Number of particles in the largest cluster.
    largest: u64,
    /// Sum over all clusters of the squared number of their particles.
    squares: u64,
    /// Number of particles in clusters of s particles, in the entry s - 1. The last entry also counts particles in
    /// larger clusters.
    by_size: Vec<u64>,
}

/// Measurement of clusters (groups of particles whose gaps are small) at several instants of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ParticleClusters {
    /// [s] time between two instants at which clusters are counted.
    interval: f64,
    /// [m] gap from surface to surface below which two particles are connected.
    gap: f64,
    samples: Vec<ClusterSample>,
}

impl ParticleClusters {
    /// Creates the measurement for a run. `schedule` contains the instants of measurement.
    pub fn new(schedule: &Schedule, settings: ClustersSettings) -> Self {
        Self { interval: schedule.spacing(MOST_SAMPLES), gap: settings.gap, samples: Vec::new() }
    }

    /// Number of particles in each cluster at the present instant.
    fn sizes(&self, simulation: &Simulation) -> Vec<u64> {
        let particles = &simulation.particles;
        let mut forest: Vec<usize> = (0..particles.len()).collect();
        for [one, other] in pairs_with_gap(particles, simulation.scene(), self.gap) {
            let (one, other) = (root(&mut forest, one), root(&mut forest, other));
            forest[one.max(other)] = one.min(other);
        }
        let mut sizes = vec![0; particles.len()];
        for place in 0..forest.len() {
            sizes[root(&mut forest, place)] += 1;
        }
        sizes.retain(|size| *size > 0);
        sizes
    }
}

/// Index of the particle that represents the cluster of the particle at `place`. `forest` holds, for each particle, the
/// index of another particle of its cluster, and for the representative its own index. The chain of indices from
/// `place` to the representative is halved, so that later searches are shorter.
fn root(forest: &mut [usize], mut place: usize) -> usize {
    while forest[place] != place {
        forest[place] = forest[forest[place]];
        place = forest[place];
    }
    place
}

impl ClusterSample {
    fn of(time: f64, sizes: &[u64]) -> Self {
        let mut by_size = vec![0; SIZES];
        sizes.iter().for_each(|size| by_size[(*size as usize).min(SIZES) - 1] += size);
        Self {
            time,
            particles: sizes.iter().sum(),
            clusters: sizes.len() as u64,
            largest: sizes.iter().copied().max().unwrap_or(0),
            squares: sizes.iter().map(|size| size * size).sum(),
            by_size,
        }
    }
}

impl Measurement for ParticleClusters {
    fn result(&self, _experiment: &Experiment, from: f64) -> Observation {
        // an empty scene has no clusters
        let is_used = |sample: &&ClusterSample| sample.time >= from && sample.particles > 0;
        let samples: Vec<&ClusterSample> = self.samples.iter().filter(is_used).collect();
        let mean =
            |of: &dyn Fn(&ClusterSample) -> f64| estimate(&samples.iter().map(|sample| of(sample)).collect::<Vec<_>>());
        let clock = [samples.first().map_or(from, |sample| sample.time), self.interval];
        let number = |column: &str, symbol: &str, of: &dyn Fn(&ClusterSample) -> f64| {
            let series: Vec<f64> = samples.iter().map(|sample| of(sample)).collect();
            ObservedNumber::of_series(ObservedQuantity::new(column, symbol, ""), &series, clock, None)
        };
        let share = |k: usize| mean(&|sample| sample.by_size[k] as f64 / sample.particles as f64);
        Observation {
            name: "clusters",
            title: "Clusters",
            axis: ObservedQuantity::new("size", "particles of a cluster", ""),
            places: (1..=SIZES).map(|size| size as f64).collect(),
            curves: vec![ObservedCurve {
                quantity: ObservedQuantity::new("share", "share of the particles", ""),
                values: (0..SIZES).map(share).collect(),
                theory: None,
                is_logarithmic: false,
            }],
            numbers: vec![
                number("clusters", "number of clusters", &|sample| sample.clusters as f64),
                number("largest", "particles in the largest cluster", &|sample| sample.largest as f64),
                number("mean_size", "particles per cluster", &|sample| {
                    sample.particles as f64 / sample.clusters as f64
                }),
                number("mean_size_of_a_particle", "size of the cluster of a particle", &|sample| {
                    sample.squares as f64 / sample.particles as f64
                }),
            ],
            ..Observation::default()
        }
    }
}

impl Observer for ParticleClusters {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        Some(now + self.interval)
    }

    fn needs(&self) -> Needs {
        Needs::Every(1)
    }

    fn see(&mut self, simulation: &Simulation) {
        self.samples.push(ClusterSample::of(simulation.time, &self.sizes(simulation)));
    }

    plain_data!();
}
