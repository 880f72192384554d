//! Shear viscosity η of the particles: of a gas in equilibrium, and of a sheared box.
//!
//! * **Equilibrium.** Let G(t) = ∫ V S dt, with the stress S and the volume V. G is the sum of ∫ Σ m c c dt and of the
//!   impulses times the vectors between the two centres. The mean square of a shear component of G grows as
//!   2 V k_B T η t (Helfand 1960, Phys. Rev. 119, 1; Allen and Tildesley, Computer Simulation of Liquids, 2nd edition
//!   2017, section 2.7). The rate of growth at the time t is the integral of the stress autocorrelation up to t (Green
//!   and Kubo). The mean is taken over five components, which are equivalent in an isotropic gas: xy, xz, yz,
//!   (xx - yy)/2 and (xx + yy - 2 zz)/(2 sqrt(3)).
//! * **Sheared box.** η is the negative shear stress σ_yz over the shear rate. The stress is the time average of its
//!   kinetic and its contact part together.
//!
//! m and c are the mass and the velocity of a particle. Velocities are relative to the mean velocity, in a sheared box
//! to the mean flow. The thermal energy k_B T is the kinetic energy per degree of freedom, times two. Impulses are
//! summed exactly; the kinetic part is integrated by the trapezoidal rule over the samples, the instants of
//! measurement.

use super::measurements::{Measurement, Observation, ObservedCurve, ObservedNumber, ObservedQuantity};
use super::{Needs, Observer, plain_data};
use crate::experiment::{Experiment, Model, ViscositySettings};
use crate::kinetic_theory::{GasTransport, collision_frequency};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::{Estimate, estimate};
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

/// Largest number of times t (over which stresses are correlated) at which the viscosity of a gas in equilibrium is
/// given.
const MOST_TIMES: usize = 100;

/// [-] largest relative error of the trapezoidal rule that counts as small. The rule overestimates the integral of the
/// autocorrelation exp(-t/τ) by the fraction (Δ/τ)²/12, with the time Δ between instants of measurement.
const COARSEST: f64 = 0.01;

/// Sums over all particles, at one instant, from which the viscosity follows.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct ViscositySample {
    /// [s] simulated time at which the sums are taken.
    time: f64,
    /// [J] kinetic sum Σ m c c over all particles, with the mass m and the velocity c relative to the mean velocity or
    /// mean flow.
    kinetic: Matrix3<f64>,
    /// [J s] time integral of the contact sum Σ r f since the start, with the vector r between two centres and the
    /// force f.
    contact: Matrix3<f64>,
}

/// Measurement of the shear viscosity.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Viscosity {
    /// [s] time between two samples (instants of measurement).
    interval: f64,
    /// Longest time t over which stresses are correlated, as a number of intervals between samples (instants of
    /// measurement). `None` in a sheared box.
    longest: Option<usize>,
    samples: Vec<ViscositySample>,
}

impl Viscosity {
    /// Creates the measurement for a run. `schedule` contains the instants of measurement.
    pub fn new(schedule: &Schedule, settings: ViscositySettings) -> Self {
        let interval = schedule.interval();
        let longest = settings.duration.map(|duration| (duration / interval).round().max(2.0) as usize);
        Self { interval, longest, samples: Vec::new() }
    }

    /// Samples (sums at instants of measurement) at the time `from` [s] and later.
    fn used(&self, from: f64) -> &[ViscositySample] {
        let first = self.samples.partition_point(|sample| sample.time < from);
        self.samples.get(first..).unwrap_or_default()
    }

    /// Viscosity of a sheared box, and the kinetic part of the viscosity, both in Pa s. `rate` [1/s] is the shear rate.
    fn in_shear(&self, experiment: &Experiment, samples: &[ViscositySample], rate: f64) -> Vec<ObservedNumber> {
        let per_stress = -1.0 / (experiment.scene.domain.volume() * rate);
        let kinetic = |pair: &[ViscositySample]| 0.5 * (shear(&pair[0].kinetic) + shear(&pair[1].kinetic));
        let contact = |pair: &[ViscositySample]| (shear(&pair[1].contact) - shear(&pair[0].contact)) / self.interval;
        let series = |of: &dyn Fn(&[ViscositySample]) -> f64| -> Vec<f64> {
            samples.windows(2).map(|pair| per_stress * of(pair)).collect()
        };
        // the value of an interval is known at its end
        let clock = [samples.first().map_or(0.0, |sample| sample.time) + self.interval, self.interval];
        let number = |column: &str, symbol: &str, series: &[f64], theory| {
            ObservedNumber::of_series(ObservedQuantity::new(column, symbol, "Pa s"), series, clock, theory)
        };
        let exact = temperature(experiment, samples).and_then(|found| theory(experiment, found));
        vec![
            number("viscosity_Pa_s", "viscosity", &series(&|pair| kinetic(pair) + contact(pair)), exact),
            number("kinetic_viscosity_Pa_s", "kinetic part of the viscosity", &series(&kinetic), None),
        ]
    }

    /// Viscosity of a gas in equilibrium: the times t [s] of the curve, the viscosity [Pa s] at these times, and one
    /// viscosity [Pa s] for each origin. An origin is an instant of measurement from which t is counted; its viscosity
    /// is computed from times between half the longest t and the longest t. `longest` is the number of intervals
    /// between instants of measurement in the longest t.
    fn at_rest(
        &self,
        experiment: &Experiment,
        samples: &[ViscositySample],
        longest: usize,
    ) -> (Vec<f64>, Vec<Option<Estimate>>, Vec<f64>) {
        let moments = self.moments(samples);
        let thermal_energy = thermal_energy(experiment, samples);
        let per_square = 0.5 / (experiment.scene.domain.volume() * thermal_energy * self.interval);
        // growth of the mean square from one number of intervals to another, for each origin
        let growth = |[early, late]: [usize; 2]| {
            let since = |origin: usize, count: usize| square(&moments[origin], &moments[origin + count]);
            let origins = 0..moments.len().saturating_sub(late);
            let each = origins.map(|origin| since(origin, late) - since(origin, early));
            each.map(|growth| growth * per_square / (late - early) as f64).collect::<Vec<f64>>()
        };
        let stride = longest.div_ceil(MOST_TIMES);
        let ends = (0..longest / stride).map(|k| [k * stride, (k + 1) * stride]);
        let times = ends.clone().map(|[early, late]| 0.5 * (early + late) as f64 * self.interval).collect();
        (times, ends.map(|ends| estimate(&growth(ends))).collect(), growth([longest / 2, longest]))
    }

    /// [J s] five shear components of G, the time integral of stress times volume, at each instant of measurement. The
    /// integral begins at the first of `samples`.
    fn moments(&self, samples: &[ViscositySample]) -> Vec<[f64; 5]> {
        let mut moment = Matrix3::zeros();
        let mut all: Vec<[f64; 5]> = samples.first().map(|_| components(&moment)).into_iter().collect();
        for pair in samples.windows(2) {
            moment += 0.5 * self.interval * (pair[0].kinetic + pair[1].kinetic) + pair[1].contact - pair[0].contact;
            all.push(components(&moment));
        }
        all
    }

    /// True if the kinetic part of the stress changes so much between two instants of measurement that the trapezoidal
    /// rule for its integral has a noticeable error.
    fn is_coarse(samples: &[ViscositySample]) -> bool {
        let product = |one: &ViscositySample, other: &ViscositySample| -> f64 {
            components(&one.kinetic).iter().zip(components(&other.kinetic)).map(|(one, other)| one * other).sum()
        };
        let (mut same, mut next) = (0.0, 0.0);
        for pair in samples.windows(2) {
            same += product(&pair[0], &pair[0]);
            next += product(&pair[0], &pair[1]);
        }
        // exp(-Δ/τ) with (Δ/τ)²/12 at its limit
        next < same * (-(12.0 * COARSEST).sqrt()).exp()
    }
}

/// Five independent shear components of a symmetric tensor, which have equal variances in an isotropic gas.
fn components(of: &Matrix3<f64>) -> [f64; 5] {
    let mean = |i: usize, j: usize| 0.5 * (of[(i, j)] + of[(j, i)]);
    let (xx, yy, zz) = (of[(0, 0)], of[(1, 1)], of[(2, 2)]);
    [mean(0, 1), mean(0, 2), mean(1, 2), 0.5 * (xx - yy), (xx + yy - 2.0 * zz) / 12.0_f64.sqrt()]
}

/// Component yz of a tensor: the shear stress of a sheared box, whose flow along z changes along y.
fn shear(of: &Matrix3<f64>) -> f64 {
    0.5 * (of[(1, 2)] + of[(2, 1)])
}

/// [J² s²] mean over the five components of the squared difference of two values of G, the time integral of stress
/// times volume.
fn square(one: &[f64; 5], other: &[f64; 5]) -> f64 {
    one.iter().zip(other).map(|(one, other)| (other - one) * (other - one)).sum::<f64>() / 5.0
}

/// [J] thermal energy k_B T: twice the kinetic energy per degree of freedom. One degree of freedom per axis belongs to
/// the mean velocity and does not count.
fn thermal_energy(experiment: &Experiment, samples: &[ViscositySample]) -> f64 {
    let freedom = 3.0 * (experiment.count() as f64 - 1.0);
    samples.iter().map(|sample| sample.kinetic.trace()).sum::<f64>() / (samples.len() as f64 * freedom)
}

/// [m²/s²] granular temperature of particles of one species; `None` with several species, or if sizes differ.
fn temperature(experiment: &Experiment, samples: &[ViscositySample]) -> Option<f64> {
    let ([species], false) = (experiment.scene.species.as_slice(), experiment.scene.has_sizes()) else { return None };
    Some(thermal_energy(experiment, samples) / species.mass()).filter(|found| found.is_finite())
}

/// Name of a kinetic theory, and the viscosity [Pa s] that it predicts at the granular temperature `temperature`
/// [m²/s²]. `None` unless the spheres are equal and smooth and have a constant restitution. `None` also for heated
/// particles, in an orbit, and for collisions by chance (DSMC).
fn theory(experiment: &Experiment, temperature: f64) -> Option<(&'static str, f64)> {
    let scene = &experiment.scene;
    let ([species], false) = (scene.species.as_slice(), scene.has_sizes()) else { return None };
    let restitution = scene.restitution_of_pairs()?;
    let is_smooth = scene.rotation.is_none() && scene.surfaces(2).iter().all(|surface| surface.friction == 0.0);
    if !is_smooth || scene.is_heated() || scene.domain.orbit().is_some() || experiment.model() == Model::Dsmc {
        return None;
    }
    let density = experiment.count() as f64 / scene.domain.volume();
    let transport = GasTransport::of(density * species.volume(), restitution);
    let frequency = collision_frequency(density, species.diameter, temperature);
    let name = if restitution == 1.0 { "Enskog" } else { "Garzó and Dufty" };
    Some((name, density * species.mass() * temperature / frequency * transport.viscosity))
}

impl Measurement for Viscosity {
    fn result(&self, experiment: &Experiment, from: f64) -> Observation {
        let samples = self.used(from);
        let mut result = Observation {
            name: "viscosity",
            title: "Viscosity",
            axis: ObservedQuantity::new("t_s", "t", "s"),
            ..Observation::default()
        };
        if let Some(shear) = experiment.scene.domain.shear {
            result.numbers = self.in_shear(experiment, samples, shear.rate);
            let has_theory = result.numbers.iter().any(|number| number.theory.is_some());
            result.remark = has_theory.then_some(
                "The theory is of first order in the shear rate. In steady shear it holds only for nearly elastic spheres.",
            );
        } else if let Some(longest) = self.longest {
            let exact = temperature(experiment, samples).and_then(|found| theory(experiment, found));
            let (times, values, series) = self.at_rest(experiment, samples, longest);
            // the value of an origin is known after the longest time
            let known = samples.first().map_or(from, |sample| sample.time) + longest as f64 * self.interval;
            let quantity = ObservedQuantity::new("viscosity_Pa_s", "viscosity", "Pa s");
            result.numbers = vec![ObservedNumber::of_series(quantity, &series, [known, self.interval], exact)];
            result.curves = vec![ObservedCurve {
                quantity: ObservedQuantity::new("viscosity_Pa_s", "viscosity by stresses up to t", "Pa s"),
                values,
                theory: exact.map(|(name, value)| (name, vec![value; times.len()])),
                is_logarithmic: false,
            }];
            result.places = times;
            result.remark = Self::is_coarse(samples).then_some(
                "The kinetic stress changes much between two samples, so that its integral is wrong by more than 1 %. \
                 Give a shorter statistics.sample_interval.",
            );
        }
        result
    }
}

impl Observer for Viscosity {
    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        let relative = simulation.relative_to_flow();
        let sample = simulation.sample().with(&relative);
        let particles = sample.particles;
        let [mass, x, y, z, xx, yy, zz, xy, xz, yz] = sample.sums(|place| {
            let (v, m) = (&particles.velocity[place], particles.mass[place]);
            let p = v * m;
            [m, p.x, p.y, p.z, p.x * v.x, p.y * v.y, p.z * v.z, p.x * v.y, p.x * v.z, p.y * v.z]
        });
        let momentum = nalgebra::Vector3::new(x, y, z);
        let products = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        self.samples.push(ViscositySample {
            time: simulation.time,
            kinetic: products - momentum * momentum.transpose() / mass.max(f64::MIN_POSITIVE),
            contact: simulation.record.ledger.pair_virial,
        });
    }

    plain_data!();
}
