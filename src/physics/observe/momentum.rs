//! Streamwise (z) forces on all particles together: drag, weight and wall shear, and the momentum that particles bring
//! in or take out.

use super::{Needs, Observer, plain_data};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::{Estimate, estimate};
use serde::{Deserialize, Serialize};

/// Mean streamwise (z) forces on all particles together [N], positive along z, over the averaging period. A force is
/// `None` if the period contains fewer than two instants of measurement. In a steady flow the forces, together with
/// the momentum per time through inlets and outlets, add up to zero.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Balance {
    /// [N] mean drag force of the gas on all particles along z.
    pub drag: Option<Estimate>,
    /// [N] mean weight minus buoyancy of all particles, along z; negative if it points along -z.
    pub weight: f64,
    /// [N] mean force of the walls on all particles along z, in a channel the shear force.
    pub wall: Option<Estimate>,
    /// [N] mean momentum per time along z that particles bring in through inlets, less that which particles take out
    /// through outlets; 0 without inlets and outlets.
    pub flow: Option<Estimate>,
    /// [N] sum of drag, weight, wall force and the momentum per time through inlets and outlets; zero on average in a
    /// steady flow.
    pub residual: Option<Estimate>,
}

/// Streamwise (z) momentum that all particles have received from the start to every sample (instant of measurement).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MomentumBooks {
    /// [s] time between two samples (instants of measurement).
    interval: f64,
    /// [N] weight minus buoyancy of all particles, along z; `None` if it changes, because particles come and go or
    /// species differ in buoyancy.
    weight: Option<f64>,
    /// [kg m/s] momentum along z that weight and buoyancy have given to particles, from the start to every
    /// measurement.
    gravity: Vec<f64>,
    /// [kg m/s] momentum along z that drag has given to particles, from the start to every measurement.
    drag: Vec<f64>,
    /// [kg m/s] momentum along z that walls have given to particles, from the start to every measurement.
    wall: Vec<f64>,
    /// [kg m/s] momentum along z that particles have brought in through inlets, minus that taken out through outlets,
    /// from the start to every measurement.
    flow: Vec<f64>,
}

impl MomentumBooks {
    /// Creates the observer before the start of a run. `schedule` contains the instants of measurement.
    pub fn new(schedule: &Schedule) -> Self {
        let interval = schedule.interval();
        let [gravity, drag, wall, flow] = [const { Vec::new() }; 4];
        Self { interval, weight: Some(0.0), gravity, drag, wall, flow }
    }

    /// Mean streamwise forces on all particles from the sample (instant of measurement) with the index `first` to the
    /// end.
    pub fn balance(&self, first: usize) -> Balance {
        let forces = |impulses: &[f64]| -> Vec<f64> {
            impulses.windows(2).skip(first).map(|pair| (pair[1] - pair[0]) / self.interval).collect()
        };
        let [gravity, drag, wall, flow] = [&self.gravity, &self.drag, &self.wall, &self.flow].map(|list| forces(list));
        // a weight that changes is averaged with the other forces, sample by sample
        let changing = |k: usize| if self.weight.is_none() { gravity[k] } else { 0.0 };
        let sum = estimate(&(0..drag.len()).map(|k| drag[k] + wall[k] + flow[k] + changing(k)).collect::<Vec<f64>>());
        let constant = self.weight.unwrap_or(0.0);
        Balance {
            drag: estimate(&drag),
            weight: self.weight.unwrap_or_else(|| gravity.iter().sum::<f64>() / gravity.len().max(1) as f64),
            wall: estimate(&wall),
            flow: estimate(&flow),
            residual: sum.map(|sum| Estimate { value: sum.value + constant, ..sum }),
        }
    }
}

impl Balance {
    /// True if drag, weight, wall force and the momentum through inlets and outlets along z are exactly zero. If one of
    /// them is unknown, the result is false.
    pub fn is_idle(&self) -> bool {
        let none = |force: Option<Estimate>| force.is_some_and(|force| force.value == 0.0);
        none(self.drag) && self.weight == 0.0 && none(self.wall) && none(self.flow)
    }
}

impl Observer for MomentumBooks {
    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        let ledger = &simulation.record.ledger;
        self.gravity.push(ledger.gravity_impulse.z);
        self.drag.push(ledger.drag_impulse.z);
        self.wall.push(ledger.wall_impulse.z);
        self.flow.push(ledger.flow_impulse.z);
    }

    fn end(&mut self, simulation: &Simulation) {
        self.weight = simulation.has_constant_weight().then(|| simulation.weight().z);
    }

    plain_data!();
}
