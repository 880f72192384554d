//! Mean squared displacement, autocorrelation of the velocities, and the coefficient of self-diffusion D.
//!
//! After the time t from an origin, M(t) = <|Δ|²> and C(t) = <v(0)·v(t)>/3 are means over the particles of a species.
//! Displacements Δ and velocities v are relative to the mean of the species at the same time. M and C are multiplied by
//! N/(N - 1) for the N particles of the species, because the mean that is subtracted is that of the same particles.
//! With the longest time t₁, D is the slope (M(t₁) - M(t₁/2))/(3 t₁) (Einstein). D is also the integral ∫ C dt from 0
//! to t₁ (Green and Kubo; Allen and Tildesley, Computer Simulation of Liquids, 2nd edition 2017, section 2.7).
//!
//! **Unwrapped displacements.** The displacement of a particle is the sum of its displacements between samples, each to
//! the nearest image. The nearest image is the right one if the particle has moved less than half a period between two
//! samples. The speed at a sample may change before the next sample. It must therefore not exceed a quarter of a period
//! per interval between samples. Otherwise the displacements count as unknown, and the result has a remark.

use super::measurements::{Measurement, Observation, ObservedCurve, ObservedNumber, ObservedQuantity};
use super::{Needs, Observer, plain_data};
use crate::exact::sums_in_groups;
use crate::experiment::{DiffusionSettings, Experiment};
use crate::kinetic_theory::{contact_value, enskog_self_diffusion};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::{Estimate, estimate};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Largest number of times t at which the curves of the mean squared displacement M(t) and the autocorrelation C(t) of
/// the velocities have values. If the longest time contains more samples (instants of measurement), only every n-th is
/// used.
const MOST_TIMES: u64 = 1000;

/// Means over the particles of a species at one time t after the start of a block of time.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct MotionSample {
    /// [m²] mean squared displacement M(t) since the start of the block of time.
    displacement: f64,
    /// [m²/s²] autocorrelation C(t) of the velocities: the mean of v(0)·v(t)/3 over the particles.
    correlation: f64,
}

/// Velocities of the particles at the start of a block of time (its origin), and positions and displacements at the
/// latest sample (instant of measurement). Each list is in the order of the ids of the particles.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct TrackedParticles {
    /// [m/s] velocities of the particles at the start of the present block of time.
    velocity: Vec<Vector3<f64>>,
    /// [m] positions of the particles in the box at the latest sample (instant of measurement).
    position: Vec<Vector3<f64>>,
    /// [m] displacements of the particles, across periodic sides, from the start of the present block of time to the
    /// latest sample (instant of measurement).
    displacement: Vec<Vector3<f64>>,
}

/// Means over the particles in one block of time, at each sample (instant of measurement) from the start of the block
/// to its end.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct MotionBlock {
    /// [s] simulated time at which the block of time begins.
    origin: f64,
    /// For each species, the mean squared displacement and the autocorrelation of the velocities at each time after
    /// the start of the block.
    samples: Vec<Vec<MotionSample>>,
}

/// Measurement of displacements and velocity correlations of the particles. The run is divided into blocks of time of
/// equal length.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Diffusion {
    /// [s] time between two instants of measurement.
    interval: f64,
    /// Number of intervals between instants of measurement in a block of time.
    intervals: usize,
    species: usize,
    tracked: TrackedParticles,
    blocks: Vec<MotionBlock>,
    /// True if at some instant of measurement a particle was so fast that its nearest periodic image at the next
    /// instant may be the wrong one.
    is_ambiguous: bool,
}

impl Diffusion {
    /// Creates the measurement for a run of `experiment`. `schedule` contains the instants of measurement.
    pub fn new(experiment: &Experiment, schedule: &Schedule, settings: DiffusionSettings) -> Self {
        let samples = (settings.duration / schedule.interval()).round().max(1.0);
        let every = (samples as u64).div_ceil(MOST_TIMES).max(1);
        Self {
            interval: every as f64 * schedule.interval(),
            intervals: (samples / every as f64).round() as usize,
            species: experiment.scene.species.len(),
            tracked: TrackedParticles::default(),
            blocks: Vec::new(),
            is_ambiguous: false,
        }
    }

    /// Begins a block of time, whose origin is the present instant. `by_id[k]` is the index of the particle with the
    /// id k in the particles of the simulation.
    fn begin(&mut self, simulation: &Simulation, by_id: &[u32]) {
        let particles = &simulation.particles;
        let domain = &simulation.scene().domain;
        let each = || by_id.iter().map(|place| *place as usize);
        self.tracked = TrackedParticles {
            velocity: each().map(|place| particles.velocity[place]).collect(),
            position: each().map(|place| domain.wrap(&particles.position[place])).collect(),
            displacement: vec![Vector3::zeros(); by_id.len()],
        };
        self.blocks.push(MotionBlock { origin: simulation.time, samples: vec![Vec::new(); self.species] });
    }

    /// Adds the displacement of each particle since the previous instant of measurement to its displacement since the
    /// start of the block of time. `by_id[k]` is the index of the particle with the id k in the particles of the
    /// simulation.
    fn track(&mut self, simulation: &Simulation, by_id: &[u32]) {
        let domain = &simulation.scene().domain;
        let TrackedParticles { position, displacement, .. } = &mut self.tracked;
        for ((last, moved), place) in position.iter_mut().zip(displacement).zip(by_id) {
            let now = domain.wrap(&simulation.particles.position[*place as usize]);
            *moved += domain.separation(&now, last);
            *last = now;
        }
    }

    /// True if some particle, at its present velocity, would move further than a quarter of a period between two
    /// instants of measurement. The nearest image of that particle may then be the wrong one.
    fn is_too_fast(&self, simulation: &Simulation) -> bool {
        let furthest = 0.5 * simulation.scene().domain.half;
        let reaches = |v: &Vector3<f64>| (0..3).any(|axis| (v[axis] * self.interval).abs() > furthest[axis]);
        simulation.particles.velocity.iter().any(reaches)
    }

    /// Adds the mean squared displacement and the autocorrelation of each species at the present time to the latest
    /// block. `by_id[k]` is the index of the particle with the id k in the particles of the simulation.
    fn measure(&mut self, simulation: &Simulation, by_id: &[u32]) {
        let (particles, tracked) = (&simulation.particles, &self.tracked);
        let sums = sums_in_groups(self.species, by_id.len(), |id| {
            let place = by_id[id] as usize;
            let (moved, first, now) = (tracked.displacement[id], tracked.velocity[id], particles.velocity[place]);
            let [x, y, z] = moved.into();
            let row =
                [1.0, x, y, z, moved.norm_squared(), first.x, first.y, first.z, now.x, now.y, now.z, first.dot(&now)];
            (usize::from(particles.species[place]), row)
        });
        let Some(block) = self.blocks.last_mut() else { return };
        for (samples, sums) in block.samples.iter_mut().zip(sums.values()) {
            let [count, x, y, z, square, fx, fy, fz, nx, ny, nz, product] = sums;
            let (moved, first, now) = (Vector3::new(x, y, z), Vector3::new(fx, fy, fz), Vector3::new(nx, ny, nz));
            let freedom = (count - 1.0).max(1.0);
            samples.push(MotionSample {
                displacement: (square - moved.norm_squared() / count.max(1.0)) / freedom,
                correlation: (product - first.dot(&now) / count.max(1.0)) / freedom / 3.0,
            });
        }
    }

    /// Complete blocks of time that begin at `from` [s] or later. The list is empty if displacements are unknown
    /// because a particle moved too far between two instants of measurement.
    fn complete(&self, from: f64) -> Vec<&MotionBlock> {
        let is_used = |block: &&MotionBlock| {
            block.origin >= from && block.samples.iter().all(|samples| samples.len() == self.intervals + 1)
        };
        if self.is_ambiguous { Vec::new() } else { self.blocks.iter().filter(is_used).collect() }
    }
}

/// [m²/s] coefficient of self-diffusion of a gas of equal elastic spheres without forces, by Enskog's theory.
/// `temperature` [m²/s²] is the granular temperature. `None` if the scene is not such a gas.
fn theory(experiment: &Experiment, temperature: f64) -> Option<f64> {
    let scene = &experiment.scene;
    let ([species], false) = (scene.species.as_slice(), scene.has_sizes()) else { return None };
    if !experiment.is_in_equilibrium() {
        return None;
    }
    let density = experiment.count() as f64 / scene.domain.volume();
    let d = species.diameter;
    let contact = contact_value(d, d, density * species.volume(), PI / 6.0 * density * d * d);
    Some(enskog_self_diffusion(density, d, temperature, contact))
}

impl Measurement for Diffusion {
    fn result(&self, experiment: &Experiment, from: f64) -> Observation {
        let (blocks, interval) = (self.complete(from), self.interval);
        let times: Vec<f64> = (0..=self.intervals).map(|k| k as f64 * interval).collect();
        let (longest, middle) = (self.intervals, self.intervals / 2);
        // the value of a block is known at its end, where the next block begins
        let length = longest as f64 * interval;
        let clock = [blocks.first().map_or(from, |block| block.origin) + length, length];
        let over_blocks = |of: &dyn Fn(&MotionBlock) -> f64| -> Option<Estimate> {
            estimate(&blocks.iter().map(|block| of(block)).collect::<Vec<_>>())
        };
        let (mut curves, mut numbers) = (Vec::new(), Vec::new());
        for (index, species) in experiment.scene.species.iter().enumerate() {
            let quantity = |column: &str, symbol: &str, unit: &'static str| match experiment.scene.species.len() {
                1 => ObservedQuantity::new(column, symbol, unit),
                _ => ObservedQuantity::new(
                    format!("{column} {}", species.name),
                    format!("{symbol} {}", species.name),
                    unit,
                ),
            };
            let mut curve = |quantity: ObservedQuantity, of: fn(&MotionSample) -> f64| {
                let values = (0..times.len()).map(|k| over_blocks(&|block| of(&block.samples[index][k]))).collect();
                curves.push(ObservedCurve { quantity, values, theory: None, is_logarithmic: false });
            };
            curve(quantity("displacement_m2", "M", "m²"), |sample| sample.displacement);
            curve(quantity("correlation_m2_s2", "C", "m²/s²"), |sample| sample.correlation);
            let einstein = |block: &MotionBlock| {
                let at = |k: usize| block.samples[index][k].displacement;
                (at(longest) - at(middle)) / (6.0 * (longest - middle) as f64 * interval)
            };
            let green_kubo = |block: &MotionBlock| {
                let of = &block.samples[index];
                of.windows(2).map(|pair| 0.5 * interval * (pair[0].correlation + pair[1].correlation)).sum()
            };
            let temperature = over_blocks(&|block| block.samples[index][0].correlation);
            let exact = temperature.and_then(|found| theory(experiment, found.value)).map(|d| ("Enskog", d));
            let mut number = |column: &str, symbol: &str, of: &dyn Fn(&MotionBlock) -> f64| {
                let series: Vec<f64> = blocks.iter().map(|block| of(block)).collect();
                numbers.push(ObservedNumber::of_series(quantity(column, symbol, "m²/s"), &series, clock, exact));
            };
            number("D_einstein_m2_s", "D by displacements", &einstein);
            number("D_green_kubo_m2_s", "D by velocities", &green_kubo);
        }
        let remark = self.is_ambiguous.then_some(
            "Displacements are unknown: some particles move further than a quarter of a period between samples. \
             Give a shorter statistics.sample_interval.",
        );
        Observation {
            name: "diffusion",
            title: "Mean squared displacement and autocorrelation of the velocities",
            axis: ObservedQuantity::new("t_s", "t", "s"),
            places: times,
            curves,
            numbers,
            remark,
            ..Observation::default()
        }
    }
}

impl Observer for Diffusion {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        Some(now + self.interval)
    }

    fn needs(&self) -> Needs {
        Needs::Every(1)
    }

    fn see(&mut self, simulation: &Simulation) {
        self.is_ambiguous |= self.is_too_fast(simulation);
        let mut by_id: Vec<u32> = vec![0; simulation.particles.len()];
        for (place, id) in (0..).zip(&simulation.particles.id) {
            by_id[*id as usize] = place;
        }
        if !self.blocks.is_empty() {
            self.track(simulation, &by_id);
            self.measure(simulation, &by_id);
        }
        let is_full = |block: &MotionBlock| block.samples.first().is_none_or(|samples| samples.len() > self.intervals);
        if self.blocks.last().is_none_or(is_full) {
            self.begin(simulation, &by_id);
            self.measure(simulation, &by_id);
        }
    }

    plain_data!();
}
