//! Static structure factor S(k) = <|Σ exp(-i k·x)|²>/N of the N centres x, for wave vectors that fit into the periodic
//! box: k = 2π (n_x/L_x, n_y/L_y, n_z/L_z) with the edges L of the box and whole numbers n (Hansen and McDonald,
//! Theory of Simple Liquids, 4th edition 2013, section 4.1). S of an ideal gas is 1.

use super::measurements::{Measurement, Observation, ObservedCurve, ObservedNumber, ObservedQuantity};
use super::{Needs, Observer, plain_data};
use crate::domain::Domain;
use crate::exact;
use crate::experiment::{Experiment, Model, StructureFactorSettings};
use crate::kinetic_theory::{compressibility, percus_yevick};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::estimate;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Largest number of samples (instants of measurement) that are used. In a run with more samples, only every n-th
/// sample is used.
const MOST_SAMPLES: u64 = 400;
/// Largest number of wave vectors that are used in a bin of the wave number. More vectors at one instant would hardly
/// be statistically independent.
const MOST_VECTORS: usize = 24;

/// Structure factor S at one instant, averaged over the wave vectors of each bin of the wave number.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct StructureSample {
    /// [s] simulated time at which the structure factor is measured.
    time: f64,
    bins: Vec<f64>,
}

/// Measurement of the static structure factor S(k) at several instants of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StructureFactor {
    /// [s] time between two instants of measurement.
    interval: f64,
    /// [1/m] wave vectors of each bin of the wave number, in increasing order of the bins. Bins without a vector are
    /// left out.
    vectors: Vec<Vec<Vector3<f64>>>,
    samples: Vec<StructureSample>,
}

/// Wave vectors [1/m] of each of `bins` bins of equal width up to the wave number `largest` [1/m]. Vectors k and -k
/// have the same S, so the list contains one of them. If a bin has more than `MOST_VECTORS` vectors, this number of
/// vectors, evenly spread over its list, is used.
fn wave_vectors(domain: &Domain, largest: f64, bins: usize) -> Vec<Vec<Vector3<f64>>> {
    let unit = domain.size.map(|edge| 2.0 * PI / edge);
    let most = unit.map(|unit| (largest / unit).floor() as i32);
    let mut all = vec![Vec::new(); bins];
    for x in 0..=most.x {
        for y in -most.y..=most.y {
            for z in -most.z..=most.z {
                if [x, y, z] <= [0, 0, 0] {
                    continue;
                }
                let vector = Vector3::new(f64::from(x), f64::from(y), f64::from(z)).component_mul(&unit);
                let bin = (vector.norm() / largest * bins as f64) as usize;
                if let Some(own) = all.get_mut(bin) {
                    own.push(vector);
                }
            }
        }
    }
    let some = |own: Vec<Vector3<f64>>| {
        let count = own.len().min(MOST_VECTORS);
        (0..count).map(|k| own[k * own.len() / count]).collect::<Vec<_>>()
    };
    all.into_iter().map(some).filter(|own| !own.is_empty()).collect()
}

impl StructureFactor {
    /// Creates the measurement for a run of `experiment`. `schedule` contains the instants of measurement.
    pub fn new(experiment: &Experiment, schedule: &Schedule, settings: StructureFactorSettings) -> Self {
        let largest = 2.0 * PI / settings.wavelength;
        Self {
            interval: schedule.spacing(MOST_SAMPLES),
            vectors: wave_vectors(&experiment.scene.domain, largest, settings.bins),
            samples: Vec::new(),
        }
    }
}

impl Measurement for StructureFactor {
    fn result(&self, experiment: &Experiment, from: f64) -> Observation {
        let scene = &experiment.scene;
        let samples: Vec<&StructureSample> = self.samples.iter().filter(|sample| sample.time >= from).collect();
        let value = |bin: usize| estimate(&samples.iter().map(|sample| sample.bins[bin]).collect::<Vec<_>>());
        let values: Vec<_> = (0..self.vectors.len()).map(value).collect();
        let mean = |own: &Vec<Vector3<f64>>| own.iter().map(|k| k.norm()).sum::<f64>() / own.len() as f64;
        // theories of spheres of one size
        let fraction = match scene.species.as_slice() {
            // spheres that collide by chance do not exclude each other
            [species] if !scene.has_sizes() && experiment.model() != Model::Dsmc => {
                Some((species.diameter, experiment.count() as f64 * species.volume() / scene.domain.volume()))
            }
            _ => None,
        };
        let theory = fraction.map(|(d, fraction)| {
            let of = |own: &Vec<Vector3<f64>>| {
                own.iter().map(|k| percus_yevick(k.norm() * d, fraction)).sum::<f64>() / own.len() as f64
            };
            ("Percus-Yevick", self.vectors.iter().map(of).collect())
        });
        Observation {
            name: "structure_factor",
            title: "Structure factor",
            axis: ObservedQuantity::new("k_1_m", "k", "1/m"),
            places: self.vectors.iter().map(mean).collect(),
            numbers: vec![ObservedNumber::of_series(
                ObservedQuantity::new("smallest_k", "S at the smallest k", ""),
                &samples.iter().filter_map(|sample| sample.bins.first().copied()).collect::<Vec<_>>(),
                [samples.first().map_or(from, |sample| sample.time), self.interval],
                fraction.map(|(_, fraction)| ("S(0), Carnahan and Starling 1969", compressibility(fraction))),
            )],
            curves: vec![ObservedCurve {
                quantity: ObservedQuantity::new("S", "S(k)", ""),
                values,
                theory,
                is_logarithmic: false,
            }],
            ..Observation::default()
        }
    }
}

impl Observer for StructureFactor {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        Some(now + self.interval)
    }

    fn needs_velocities(&self) -> bool {
        false
    }

    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        let (sample, domain) = (simulation.sample(), &simulation.scene().domain);
        // the phase of a position and of its image in the box differ by rounding
        let positions: Vec<Vector3<f64>> = sample.particles.position.iter().map(|x| domain.wrap(x)).collect();
        let waves = self.vectors.iter().flatten();
        let mut sums: Vec<_> = waves
            .flat_map(|k| {
                exact::sums(positions.len(), |place| {
                    let (sin, cos) = k.dot(&positions[place]).sin_cos();
                    [cos, sin]
                })
            })
            .collect();
        sample.total(&mut sums.iter_mut().collect::<Vec<_>>());
        let count = simulation.count().max(1) as f64;
        let mut each = sums.chunks_exact(2).map(|pair| (pair[0].value().powi(2) + pair[1].value().powi(2)) / count);
        let mean = |own: &Vec<Vector3<f64>>| each.by_ref().take(own.len()).sum::<f64>() / own.len() as f64;
        let bins = self.vectors.iter().map(mean).collect();
        self.samples.push(StructureSample { time: simulation.time, bins });
    }

    plain_data!();
}
