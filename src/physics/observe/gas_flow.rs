//! Channel or pipe flow of a gas on which the particles act (two-way coupling), over time and averaged.

use super::{Needs, Observer, plain_data};
use crate::fluid::{Fluid, GasBalance, GridNode};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::{Estimate, estimate};
use serde::{Deserialize, Serialize};

/// Largest number of samples (instants of measurement) of the gas that are stored.
const MOST_SAMPLES: u64 = 200;

/// Flow of a gas on which the particles act (two-way coupling), averaged over the averaging period.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GasFlow {
    /// State of the gas without particles at the grid points, from the wall to the centre plane or the axis.
    pub alone: Vec<GridNode>,
    /// Time averages of the gas with particles at the grid points of `alone`.
    pub mean: Vec<GridNode>,
    /// [Pa/m] pressure drop per length of the gas with particles, without the hydrostatic part. `None` if the gas was
    /// measured less than twice.
    pub pressure_gradient: Option<Estimate>,
    /// [Pa/m] pressure drop per length of the gas without particles.
    pub pressure_gradient_alone: f64,
    /// [m/s] flow rate of the gas with particles, divided by the area of the cross-section. `None` if its mean is not
    /// finite.
    pub bulk_velocity: Option<Estimate>,
    /// [m/s] friction velocity; negative if the gas flows backwards at the wall, `None` if its mean is not finite.
    pub friction_velocity: Option<Estimate>,
    /// Momentum balance of the gas along z, from the start to the end of the run.
    pub balance: GasBalance,
}

/// State of a gas on which the particles act, at one instant.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct GasSample {
    /// [s] simulated time of this state.
    time: f64,
    /// [Pa s/m] integral over time, since the start, of the pressure drop per length.
    pressed: f64,
    /// [m/s] flow rate of the gas, divided by the area of the cross-section.
    bulk_velocity: f64,
    /// [m/s] friction velocity of the gas at the wall.
    friction_velocity: f64,
    nodes: Vec<GridNode>,
}

/// Measurement of the flow of a gas on which the particles act (two-way coupling), at several instants.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct GasFlows {
    /// [s] time between two instants at which the gas is measured.
    interval: f64,
    samples: Vec<GasSample>,
    balance: GasBalance,
}

impl GasFlows {
    /// Creates the measurement for a run. `schedule` contains the instants of measurement.
    pub fn new(schedule: &Schedule) -> Self {
        Self { interval: schedule.spacing(MOST_SAMPLES), ..Self::default() }
    }

    /// Averages over the samples (instants of measurement) from the time `from` [s] on. `alone` is the gas without
    /// particles. `None` if the gas has no channel or pipe flow, or if there is no sample.
    pub fn averages(&self, alone: Option<&Fluid>, from: f64) -> Option<GasFlow> {
        let (fluid, flow) = alone.and_then(|fluid| Some((fluid, fluid.profile.channel_flow()?)))?;
        let used: Vec<&GasSample> = self.samples.iter().filter(|sample| sample.time >= from).collect();
        let last = used.last()?;
        let mean = |node: usize, of: fn(&GridNode) -> f64| {
            used.iter().map(|sample| of(&sample.nodes[node])).sum::<f64>() / used.len() as f64
        };
        let nodes = last.nodes.iter().enumerate().map(|(index, node)| GridNode {
            y: node.y,
            u: mean(index, |node| node.u),
            k: mean(index, |node| node.k),
            epsilon: mean(index, |node| node.epsilon),
            nu_t: mean(index, |node| node.nu_t),
        });
        let pressed = used.windows(2).map(|pair| (pair[1].pressed - pair[0].pressed) / (pair[1].time - pair[0].time));
        let over_time = |of: fn(&GasSample) -> f64| used.iter().map(|sample| of(sample)).collect::<Vec<_>>();
        Some(GasFlow {
            alone: flow.nodes.clone(),
            mean: nodes.collect(),
            pressure_gradient: estimate(&pressed.collect::<Vec<_>>()),
            pressure_gradient_alone: flow.pressure_gradient(fluid.density),
            bulk_velocity: estimate(&over_time(|sample| sample.bulk_velocity)),
            friction_velocity: estimate(&over_time(|sample| sample.friction_velocity)),
            balance: self.balance,
        })
    }
}

impl Observer for GasFlows {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        Some(now + self.interval)
    }

    fn needs(&self) -> Needs {
        Needs::Nothing
    }

    fn see(&mut self, simulation: &Simulation) {
        let Some(flow) = simulation.loaded_flow() else { return };
        let Ok(present) = flow.flow() else { return };
        self.balance = flow.balance;
        self.samples.push(GasSample {
            time: simulation.time,
            pressed: flow.balance.by_pressure / flow.box_volume(),
            bulk_velocity: flow.bulk_velocity(),
            friction_velocity: flow.friction_velocity(),
            nodes: present.nodes,
        });
    }

    fn end(&mut self, simulation: &Simulation) {
        if let Some(flow) = simulation.loaded_flow() {
            self.balance = flow.balance;
        }
    }

    plain_data!();
}
