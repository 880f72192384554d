//! How fast all particles move, and whether that is steady.

use super::{Observer, Sight, plain_data};
use crate::experiment::{AverageFrom, Experiment};
use crate::simulation::Simulation;
use crate::statistics::{Batches, Estimate, Series, Spread, Steadiness, estimate, judge};
use serde::{Deserialize, Serialize};

/// Means over all particles at every sample.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Motion {
    /// Slices that the temperature is taken in.
    slices: usize,
    /// [s] of the samples.
    times: Vec<f64>,
    /// [m/s] mean streamwise velocity.
    velocity: Vec<f64>,
    /// [m²/s²] mean square of the velocity about that mean: drifts as long as the agitation or the profile does.
    agitation: Vec<f64>,
    /// [m²/s²] granular temperature, where there are particles enough for one.
    temperature: Vec<Option<f64>>,
}

impl Motion {
    /// The motion of an experiment's particles, before any sample.
    pub fn new(experiment: &Experiment) -> Self {
        Self {
            slices: experiment.statistics.slices,
            times: Vec::new(),
            velocity: Vec::new(),
            agitation: Vec::new(),
            temperature: Vec::new(),
        }
    }

    /// Where averaging starts, as asked for or found, and whether the motion is steady from there.
    pub fn steadiness(&self, asked: AverageFrom) -> Steadiness {
        let from = match asked {
            AverageFrom::Time(from) => Some(from),
            AverageFrom::Steady => None,
        };
        // the mean velocity is measured by the agitation: where momentum is conserved, nothing but rounding is left of it
        let agitation = self.agitation.iter().copied().fold(0.0, f64::max);
        let series = [
            Series { values: &self.velocity, scale: agitation.sqrt() },
            Series { values: &self.agitation, scale: agitation },
        ];
        judge(&self.times, &series, from)
    }

    /// The first sample at `from` [s] or later, or how many there are if all came before.
    pub fn first(&self, from: f64) -> usize {
        self.times.iter().position(|time| *time >= from).unwrap_or(self.times.len())
    }

    /// [m²/s²] granular temperature from sample `first` on; not known if it is not at one of them.
    pub fn temperature(&self, first: usize) -> Option<Estimate> {
        estimate(&self.temperatures(first)?)
    }

    fn temperatures(&self, first: usize) -> Option<Vec<f64>> {
        self.temperature.iter().skip(first).copied().collect()
    }

    /// The granular temperature by blocks of time from sample `first` on; `None` if it is not known.
    pub fn batches(&self, first: usize) -> Option<Batches> {
        let interval = self.times.get(1)? - self.times.first()?;
        Batches::of_series(&self.temperatures(first)?, interval, *self.times.get(first)?)
    }
}

impl Observer for Motion {
    fn sight(&self) -> Sight {
        Sight::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        let (mean, height) = (simulation.mean_velocity(), simulation.scene().domain.size.y);
        let spread = Spread::about(mean, simulation.sample(), self.slices, height);
        self.times.push(simulation.time);
        self.velocity.push(spread.mean().z);
        self.agitation.push(spread.variance());
        self.temperature.push(spread.temperature());
    }

    plain_data!();
}
