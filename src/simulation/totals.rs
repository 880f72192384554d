//! What a simulation knows of all particles, whoever has them.

use crate::particles::Sample;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// All particles of a run in a few numbers.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct SimulationTotals {
    /// How many there are, in all processes.
    pub count: usize,
    /// [m] the mean of their radii.
    pub mean_radius: f64,
    /// [kg] as the start added it up.
    pub mass: f64,
    /// [kg m/s] as it has been added up since the start.
    pub momentum: Vector3<f64>,
}

impl SimulationTotals {
    /// Of particles of which others may have a part.
    pub fn of(sample: &Sample) -> Self {
        let [mean_radius, ..] = sample.mean_radii(1.0);
        Self { count: sample.count(), mean_radius, mass: sample.total_mass(), momentum: sample.momentum() }
    }
}
