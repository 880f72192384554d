//! Sums over the particles of a simulation in all processes.

use crate::particles::Sample;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Number, mean radius, mass and momentum of all particles of a simulation.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct SimulationTotals {
    /// Number of particles in all processes.
    pub count: usize,
    /// [m] mean radius of all particles in all processes.
    pub mean_radius: f64,
    /// [kg] mass of all particles in all processes.
    pub mass: f64,
    /// [kg m/s] momentum of all particles: the sum at the start, or after the latest particles came or left, plus all
    /// changes since.
    pub momentum: Vector3<f64>,
}

impl SimulationTotals {
    /// Computes the sums over the particles of a sample, including particles of other processes.
    pub fn of(sample: &Sample) -> Self {
        let [mean_radius, ..] = sample.mean_radii(1.0);
        Self { count: sample.count(), mean_radius, mass: sample.total_mass(), momentum: sample.momentum() }
    }
}
