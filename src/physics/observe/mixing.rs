//! Mixing of the particles: share of the particles that stay in one layer. The time averages of one run are valid for
//! other runs of the case only if particles change layers.
//!
//! Every particle has fixed random signs +1 or -1, computed from its id. At two instants the signs are summed in layers
//! along y. The product of the two sums of a layer estimates the number of particles that are in this layer at both
//! instants. A particle in both sums contributes the product 1 of its two equal signs. The products of the signs of two
//! different particles cancel on average.

use super::{Needs, Observer, plain_data};
use crate::experiment::Experiment;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use rand::{Rng, SeedableRng};
use rand_xoshiro::SplitMix64;
use serde::{Deserialize, Serialize};

/// Number of sums per layer: the number of particles, and 31 sums of the random signs +1 or -1 of the particles. With
/// n layers, the measured share of the particles that stay in their layer has a statistical error of 1/sqrt(31 n).
const SUMS: usize = 32;
/// Largest number of layers along y. With 64 layers, the measured share of the particles that stay in their layer has
/// an error of 0.02.
const LAYERS: f64 = 64.0;
/// Smallest number of layers along y for which mixing is measured. With fewer layers, too many particles are by chance
/// in the layer in which they were earlier.
const FEWEST_LAYERS: f64 = 4.0;
/// Number of equal intervals of the run. At the ends of these intervals, the random signs of the particles are summed
/// in each layer. The sums at one of these instants are compared with those at the end of the run.
const MARKS: u64 = 8;

/// Sums of the random signs of the particles in each layer at one instant.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct LayerSample {
    /// [s] simulated time at which the signs were summed.
    time: f64,
    /// Sums of each layer along y: the number of particles, followed by 31 sums of signs.
    rows: Vec<Vec<f64>>,
}

/// Sums of the random signs of the particles in each layer along y, at several instants of a run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Mixing {
    layers: usize,
    height: f64,
    /// [s] time between two instants at which the signs of the particles are summed.
    interval: f64,
    marks: Vec<LayerSample>,
}

impl Mixing {
    /// Creates the observer before the start of the run. `schedule` contains the instants of measurement.
    pub fn new(experiment: &Experiment, schedule: &Schedule) -> Self {
        let height = experiment.scene.domain.size.y;
        let largest = experiment.scene.species.iter().map(|species| species.diameter).fold(0.0, f64::max);
        let layers = (height / largest).min(LAYERS).floor();
        let samples = (schedule.samples / MARKS).max(1);
        Self {
            layers: if layers >= FEWEST_LAYERS { layers as usize } else { 0 },
            height,
            interval: samples as f64 * schedule.interval(),
            marks: Vec::new(),
        }
    }

    /// [-] share of the particles that are in the same layer at two instants, reduced by the share expected by chance.
    /// One instant is the end of the run. The other is the first stored instant at or after `from` [s], or, if there
    /// is none before the end, the latest stored one. The value is 1 for a bed at rest and 0 for a gas that mixes.
    /// `None` if there are too few layers or particles, or if the share expected by chance is 75 % or more.
    pub fn remembered(&self, from: f64) -> Option<f64> {
        let last = self.marks.last()?;
        let mut before = self.marks.iter().filter(|mark| mark.time < last.time);
        let first = before.clone().find(|mark| mark.time >= from * (1.0 - 1e-9)).or(before.next_back())?;
        let count: f64 = first.rows.iter().map(|row| row[0]).sum();
        let both = || first.rows.iter().zip(&last.rows);
        let by_chance = both().map(|(a, b)| a[0] * b[0]).sum::<f64>() / (count * count);
        let products = both().flat_map(|(a, b)| a[1..].iter().zip(&b[1..])).map(|(a, b)| a * b);
        let same = products.sum::<f64>() / (count * (SUMS - 1) as f64);
        (count >= FEWEST_LAYERS && by_chance < 0.75).then(|| ((same - by_chance) / (1.0 - by_chance)).clamp(0.0, 1.0))
    }
}

/// Contribution of the particle with the id `id` to the sums of its layer: the number 1, followed by the 31 random
/// signs of the particle.
fn row(id: u32) -> [f64; SUMS] {
    let bits = SplitMix64::seed_from_u64(u64::from(id)).next_u32();
    std::array::from_fn(|k| if k == 0 || bits >> k & 1 == 0 { 1.0 } else { -1.0 })
}

impl Observer for Mixing {
    fn next(&self, now: f64, schedule: &Schedule) -> Option<f64> {
        let duration = schedule.length() as f64 * schedule.window;
        (self.layers > 0).then_some(if now + 1.5 * self.interval > duration { duration } else { now + self.interval })
    }

    fn needs_velocities(&self) -> bool {
        false
    }

    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        if self.layers == 0 || self.marks.last().is_some_and(|mark| mark.time >= simulation.time) {
            return;
        }
        let (sample, per_length) = (simulation.sample(), self.layers as f64 / self.height);
        let particles = sample.particles;
        let rows = sample.sums_in_groups(self.layers, |place| {
            // the cast turns negative numbers into 0
            let layer = ((particles.position[place].y * per_length) as usize).min(self.layers - 1);
            (layer, row(particles.id[place]))
        });
        self.marks
            .push(LayerSample { time: simulation.time, rows: rows.into_iter().map(|row| row.to_vec()).collect() });
    }

    plain_data!();
}
