//! Distribution of the velocities, and its coefficients a₂ and a₃ in Sonine polynomials.
//!
//! Velocities are relative to the mean velocity of their slice at the same instant, and in units of sqrt(2T): c =
//! v/sqrt(2T), with the granular temperature T of the species. The distribution of a nearly Maxwellian gas is f(c) =
//! π^(-3/2) exp(-c²) (1 + a₂ S₂(c²) + a₃ S₃(c²) + ...). Its moments are <c⁴> = 15/4 (1 + a₂) and <c⁶> = 105/8 (1 + 3 a₂
//! - a₃) (Brilliantov and Pöschel 2004, Kinetic Theory of Granular Gases, chapter 8).
//!
//! **Few particles.** The n velocities of a slice are multiplied by sqrt(n/(n - 1)), because the mean of the slice is
//! the mean of the same velocities. T is also computed from the same particles. The N velocities are then a point on a
//! sphere in ν = 3(N - S) dimensions, S being the number of slices. The mean of <c⁴> of a Maxwellian gas is then 15/4
//! ν/(ν + 2), and that of <c⁶> is 105/8 ν²/((ν + 2)(ν + 4)). The moments are divided by ν/(ν + 2) and ν²/((ν + 2)(ν +
//! 4)), so that a₂ and a₃ of a Maxwellian gas are zero on average for any N. With n particles in a slice, a₂ of a gas
//! that is not Maxwellian remains too small by about 2 a₂/n.

use super::measurements::{Measurement, Observation, ObservedCurve, ObservedNumber, ObservedQuantity};
use super::{Needs, Observer, plain_data};
use crate::domain::Domain;
use crate::experiment::{Experiment, VelocityDistributionSettings};
use crate::kinetic_theory::{cooling_a2, heated_a2};
use crate::particles::Sample;
use crate::scene::{Kind, Thermostat};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::estimate;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Largest number of samples (instants of measurement) that are used. In a run with more samples, only every n-th
/// sample is used.
const MOST_SAMPLES: u64 = 1000;

/// Coefficients of the Sonine polynomials in the velocity distribution at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sonine {
    /// [-] coefficient a₂ of the second Sonine polynomial; 0 for a Maxwellian gas.
    pub a2: f64,
    /// [-] coefficient a₃ of the third Sonine polynomial; 0 for a Maxwellian gas.
    pub a3: f64,
}

/// Velocities of all particles at one instant, relative to the mean velocities of slices.
struct PeculiarVelocities<'a> {
    sample: Sample<'a>,
    /// Number of slices per length along y [1/m], and the index of the last slice.
    slices: (f64, f64),
    /// Mean velocity [m/s] of each slice, and the factor sqrt(n/(n - 1)) [-] for its n particles. The factor corrects
    /// the velocities relative to the mean, because the mean is that of the same particles. It is 0 for slices with at
    /// most one particle, whose velocities are not used.
    means: Vec<(Vector3<f64>, f64)>,
    /// [m²/s²] granular temperature of each species; 0 if no particle of the species moves relative to its slice.
    temperatures: Vec<f64>,
    /// Sonine coefficients, averaged over all species with the numbers of their particles as weights; `None` if no
    /// particle moves relative to its slice.
    sonine: Option<Sonine>,
}

impl<'a> PeculiarVelocities<'a> {
    fn of(sample: Sample<'a>, domain: &Domain, slices: usize, species: usize) -> Self {
        let particles = sample.particles;
        let (per_length, last) = (slices as f64 / domain.size.y, (slices - 1) as f64);
        let slice = |place: usize| (particles.position[place].y * per_length).clamp(0.0, last) as usize;
        let sums = sample.sums_in_groups(slices, |place| {
            let v = particles.velocity[place];
            (slice(place), [1.0, v.x, v.y, v.z])
        });
        let used = sums.iter().filter(|[count, ..]| *count > 1.0).count() as f64;
        let all: f64 = sums.iter().map(|[count, ..]| if *count > 1.0 { *count } else { 0.0 }).sum();
        let means = sums.into_iter().map(|[count, x, y, z]| {
            let factor = if count > 1.0 { (count / (count - 1.0)).sqrt() } else { 0.0 };
            (Vector3::new(x, y, z) / count.max(1.0), factor)
        });
        let mut own = Self {
            sample,
            slices: (per_length, last),
            means: means.collect(),
            temperatures: vec![0.0; species],
            sonine: None,
        };
        let sums = sample.sums_in_groups(species, |place| {
            let square = own.velocity(place).map_or(0.0, |v| v.norm_squared());
            let one = if own.velocity(place).is_some() { 1.0 } else { 0.0 };
            let quartic = square * square;
            (usize::from(particles.species[place]), [one, square, quartic, quartic * square])
        });
        let (mut weight, mut total) = (0.0, [0.0; 2]);
        for (temperature, [count, square, quartic, sextic]) in own.temperatures.iter_mut().zip(sums) {
            if count < 1.0 || square <= 0.0 {
                continue;
            }
            *temperature = square / (3.0 * count);
            // number ν of degrees of freedom of this species: its share of those that remain if the mean of each slice
            // is fixed
            let freedom = 3.0 * count * (1.0 - used / all);
            let unit = 2.0 * *temperature;
            let fourth = quartic / count / (unit * unit) * (freedom + 2.0) / freedom;
            let sixth = sextic / count / (unit * unit * unit) * (freedom + 2.0) * (freedom + 4.0) / (freedom * freedom);
            let a2 = fourth / (15.0 / 4.0) - 1.0;
            let a3 = 1.0 + 3.0 * a2 - sixth / (105.0 / 8.0);
            weight += count;
            total = [total[0] + count * a2, total[1] + count * a3];
        }
        own.sonine = (weight > 0.0).then(|| Sonine { a2: total[0] / weight, a3: total[1] / weight });
        own
    }

    /// [m/s] velocity of a particle relative to the mean of the n particles of its slice, times sqrt(n/(n - 1)).
    /// `place` is the index of the particle. `None` if it is alone in its slice.
    fn velocity(&self, place: usize) -> Option<Vector3<f64>> {
        let particles = self.sample.particles;
        let (per_length, last) = self.slices;
        let slice = (particles.position[place].y * per_length).clamp(0.0, last) as usize;
        let (mean, factor) = self.means[slice];
        (factor > 0.0).then(|| (particles.velocity[place] - mean) * factor)
    }

    /// Numbers of particles in each of `bins` bins from 0 to `largest` [-]: first by their speed c, then by their
    /// component |c_x|, both in units of sqrt(2T). The last of the `bins` + 1 entries counts all other particles:
    /// faster ones, and those alone in their slice.
    fn histogram(&self, bins: usize, largest: f64) -> Vec<[f64; 2]> {
        let per_width = bins as f64 / largest;
        let species = &self.sample.particles.species;
        let bin = |place: usize, of: fn(&Vector3<f64>) -> f64| -> Option<usize> {
            let unit = (2.0 * self.temperatures[usize::from(species[place])]).sqrt();
            let number = of(&self.velocity(place)?) / unit * per_width;
            // a particle at rest in a species at rest has no direction: 0/0 is not a number
            (number < bins as f64).then_some(number as usize)
        };
        let count = |of: fn(&Vector3<f64>) -> f64| {
            self.sample.sums_in_groups(bins + 1, |place| (bin(place, of).unwrap_or(bins), [1.0]))
        };
        let (speeds, components) = (count(Vector3::norm), count(|v| v.x.abs()));
        speeds.into_iter().zip(components).map(|([speed], [component])| [speed, component]).collect()
    }
}

impl Sonine {
    /// Sonine coefficients at the present instant; `None` if no particle moves relative to its slice. `slices` is the
    /// number of slices along y whose mean velocities are subtracted.
    pub(super) fn of(simulation: &Simulation, slices: usize) -> Option<Self> {
        let (scene, relative) = (simulation.scene(), simulation.relative_to_flow());
        let sample = simulation.sample();
        PeculiarVelocities::of(sample.with(&relative), &scene.domain, slices, scene.species.len()).sonine
    }
}

/// Histograms of the velocities at one instant. Velocities are relative to the mean velocities of slices, in units of
/// sqrt(2T) with the granular temperature T.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct VelocitySample {
    /// [s] simulated time at which the velocities are measured.
    time: f64,
    sonine: Option<Sonine>,
    /// Share of the particles [-] in each bin: first of the speed c, then of the component |c_x|. Velocities are in
    /// units of sqrt(2T) with the granular temperature T.
    bins: Vec<[f64; 2]>,
}

/// Measurement of the distribution of the velocities at several instants of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct VelocityDistribution {
    /// [s] time between two instants of measurement.
    interval: f64,
    /// Number of slices along y whose mean velocities are subtracted.
    slices: usize,
    /// [-] largest speed in the histograms, in units of sqrt(2T) with the granular temperature T.
    largest: f64,
    bins: usize,
    samples: Vec<VelocitySample>,
}

impl VelocityDistribution {
    /// Creates the measurement for a run of `experiment`. `schedule` contains the instants of measurement.
    pub fn new(experiment: &Experiment, schedule: &Schedule, settings: VelocityDistributionSettings) -> Self {
        Self {
            interval: schedule.spacing(MOST_SAMPLES),
            slices: experiment.statistics.slices,
            largest: settings.largest_speed,
            bins: settings.bins,
            samples: Vec::new(),
        }
    }
}

/// [-] coefficient a₂ of a homogeneous gas by theory, for a gas that cools or that random accelerations heat. The
/// Gaussian thermostat gives the coefficient of a cooling gas. `None` if a side of the box is not periodic, or with
/// walls, inlets, outlets, gas or shear. `None` also with friction, rotation, several species or sizes, or a
/// restitution that depends on the speed.
fn theory(experiment: &Experiment) -> Option<f64> {
    let scene = &experiment.scene;
    let surface = scene.surface(0, Kind::Species(0));
    let is_simple = scene.species.len() == 1
        && !scene.has_sizes()
        && scene.rotation.is_none()
        && surface.friction == 0.0
        && surface.by_speed.is_none();
    let law = if matches!(scene.thermostat, Some(Thermostat::Stochastic { .. })) { heated_a2 } else { cooling_a2 };
    (scene.is_homogeneous() && !scene.has_openings() && is_simple).then(|| law(surface.restitution))
}

impl Measurement for VelocityDistribution {
    fn result(&self, experiment: &Experiment, from: f64) -> Observation {
        let samples: Vec<&VelocitySample> = self.samples.iter().filter(|sample| sample.time >= from).collect();
        let width = self.largest / self.bins as f64;
        let place = |bin: usize| (bin as f64 + 0.5) * width;
        let curve = |which: usize, quantity: ObservedQuantity, name: &'static str, maxwell: fn(f64) -> f64| {
            let density = |bin: usize| {
                let series: Vec<f64> = samples.iter().map(|sample| sample.bins[bin][which] / width).collect();
                estimate(&series)
            };
            let theory = (0..self.bins).map(|bin| maxwell(place(bin))).collect();
            ObservedCurve {
                quantity,
                values: (0..self.bins).map(density).collect(),
                theory: Some((name, theory)),
                is_logarithmic: true,
            }
        };
        let clock = [samples.first().map_or(from, |sample| sample.time), self.interval];
        let number = |column: &str, symbol: &str, of: fn(Sonine) -> f64, theory: Option<(&'static str, f64)>| {
            let series: Option<Vec<f64>> = samples.iter().map(|sample| sample.sonine.map(of)).collect();
            let quantity = ObservedQuantity::new(column, symbol, "");
            ObservedNumber::of_series(quantity, &series.unwrap_or_default(), clock, theory)
        };
        Observation {
            name: "velocity_distribution",
            title: "Distribution of the velocities",
            axis: ObservedQuantity::new("c", "c = v/sqrt(2T)", ""),
            places: (0..self.bins).map(place).collect(),
            curves: vec![
                curve(0, ObservedQuantity::new("speed_density", "PDF of c", ""), "Maxwell", |c| {
                    4.0 / PI.sqrt() * c * c * (-c * c).exp()
                }),
                curve(1, ObservedQuantity::new("component_density", "PDF of |c_x|", ""), "Maxwell", |c| {
                    2.0 / PI.sqrt() * (-c * c).exp()
                }),
            ],
            numbers: vec![
                number("a2", "a₂", |sonine| sonine.a2, theory(experiment).map(|a2| ("van Noije and Ernst 1998", a2))),
                number("a3", "a₃", |sonine| sonine.a3, None),
            ],
            ..Observation::default()
        }
    }
}

impl Observer for VelocityDistribution {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        Some(now + self.interval)
    }

    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        let (scene, relative) = (simulation.scene(), simulation.relative_to_flow());
        let sample = simulation.sample();
        let velocities =
            PeculiarVelocities::of(sample.with(&relative), &scene.domain, self.slices, scene.species.len());
        let mut bins = velocities.histogram(self.bins, self.largest);
        let all = bins.iter().fold([0.0; 2], |all, bin| [all[0] + bin[0], all[1] + bin[1]]);
        bins.truncate(self.bins);
        for bin in &mut bins {
            *bin = [bin[0] / all[0].max(1.0), bin[1] / all[1].max(1.0)];
        }
        self.samples.push(VelocitySample { time: simulation.time, sonine: velocities.sonine, bins });
    }

    plain_data!();
}
