//! Gas velocity at the particles (that they "see") in scenes with `[fluid.turbulence]`: its fluctuation **u** in
//! slices of y. If the mean of a component of **u** perpendicular to the flow is not zero, the gas at the particles
//! drifts. If particles sample the turbulence evenly, a component of **u** has the mean square 2k/3 of the gas, with
//! its turbulent kinetic energy k.

use super::measurements::{Measurement, Observation, ObservedCurve, ObservedQuantity};
use super::{Needs, Observer, plain_data};
use crate::experiment::Experiment;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::{Estimate, estimate};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Largest number of samples (instants of measurement) that are used; in a longer run the used samples are further
/// apart.
const MOST_SAMPLES: u64 = 1000;
/// Number of sums over the particles of a slice: the number of particles, two of velocities and five of products of
/// velocities.
const SUMS: usize = 8;

/// Sums over the particles of each slice along y at one instant, for means of the gas velocity at the particles.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct SeenGasSample {
    /// [s] simulated time at which the particles are measured.
    time: f64,
    /// For each slice, sums over its particles: the number 1; u along z and y [m/s]; u² along z, y and x, 2k/3 and
    /// **u**·(**v** - **U**)/3 [m²/s²]. **u** is the fluctuation of the gas velocity at a particle, k the turbulent
    /// kinetic energy, **v** the velocity of the particle, and **U** the mean velocity of the gas.
    slices: Vec<[f64; SUMS]>,
}

/// Measurement of the fluctuation of the gas velocity at the particles.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SeenGas {
    /// [s] time between two instants of measurement.
    interval: f64,
    /// Number of slices of equal width along y.
    slices: usize,
    samples: Vec<SeenGasSample>,
}

impl SeenGas {
    /// Creates the measurement for a run of `experiment`. Its slices are those of `profiles.csv`. `schedule` contains
    /// the instants of measurement.
    pub fn new(experiment: &Experiment, schedule: &Schedule) -> Self {
        let slices = experiment.statistics.slices;
        Self { interval: schedule.spacing(MOST_SAMPLES), slices, samples: Vec::new() }
    }
}

impl Measurement for SeenGas {
    fn result(&self, experiment: &Experiment, from: f64) -> Observation {
        let samples: Vec<&SeenGasSample> = self.samples.iter().filter(|sample| sample.time >= from).collect();
        let mean = |slice: usize, sum: usize| -> Option<Estimate> {
            let rows = samples.iter().map(|sample| &sample.slices[slice]).filter(|row| row[0] > 0.0);
            estimate(&rows.map(|row| row[sum] / row[0]).collect::<Vec<_>>())
        };
        let curve = |sum: usize, column: &str, symbol: &str, unit: &'static str| ObservedCurve {
            quantity: ObservedQuantity::new(column, symbol, unit),
            values: (0..self.slices).map(|slice| mean(slice, sum)).collect(),
            theory: None,
            is_logarithmic: false,
        };
        let width = experiment.scene.domain.size.y / self.slices as f64;
        Observation {
            name: "seen_gas",
            title: "Gas that the particles see",
            axis: ObservedQuantity::new("y_m", "y", "m"),
            places: (0..self.slices).map(|slice| (slice as f64 + 0.5) * width).collect(),
            curves: vec![
                curve(1, "u_seen_m_s", "<u> along the flow", "m/s"),
                curve(2, "v_seen_m_s", "<u> along y", "m/s"),
                curve(3, "uu_seen_m2_s2", "<u²> along the flow", "m²/s²"),
                curve(4, "vv_seen_m2_s2", "<u²> along y", "m²/s²"),
                curve(5, "ww_seen_m2_s2", "<u²> along x", "m²/s²"),
                curve(6, "gas_variance_m2_s2", "2k/3 of the gas", "m²/s²"),
                curve(7, "covariance_m2_s2", "<u·(v - U)>/3", "m²/s²"),
            ],
            ..Observation::default()
        }
    }
}

impl Observer for SeenGas {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        Some(now + self.interval)
    }

    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        let scene = simulation.scene();
        let Some(fluid) = &scene.fluid else { return };
        let Some(turbulence) = &fluid.turbulence else { return };
        let sample = simulation.sample();
        let particles = sample.particles;
        let eddies = particles.eddies.as_deref().unwrap_or_default();
        let (height, slices) = (scene.domain.size.y, self.slices);
        let rows = sample.sums_in_groups(slices, |place| {
            let position = &particles.position[place];
            let local = turbulence.at(&fluid.profile, position);
            let u = eddies.get(place).map_or_else(Vector3::zeros, |eddy| turbulence.seen(eddy, &local));
            let gas = Vector3::new(0.0, 0.0, fluid.profile.velocity_at(position));
            let covariance = u.dot(&(particles.velocity[place] - gas)) / 3.0;
            let slice = (position.y / height * slices as f64).max(0.0) as usize;
            let row = [1.0, u.z, u.y, u.z * u.z, u.y * u.y, u.x * u.x, local.deviation.powi(2), covariance];
            (slice.min(slices - 1), row)
        });
        self.samples.push(SeenGasSample { time: simulation.time, slices: rows });
    }

    plain_data!();
}
