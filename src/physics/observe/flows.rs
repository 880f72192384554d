//! Flow of particles through inlets and outlets: sums over time, and rates in the averaging period.

use super::{Needs, Observer, plain_data};
use crate::experiment::Experiment;
use crate::schedule::Schedule;
use crate::simulation::{FlowTotals, OpeningFlow, Simulation};
use crate::statistics::{Estimate, estimate};
use serde::{Deserialize, Serialize};

/// Largest number of samples (instants of measurement) of the flow that are stored.
const MOST_SAMPLES: u64 = 1000;

/// Flow of particles through one inlet or outlet: averages over the averaging period, and sums over time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlowAverages {
    /// Name of the inlet or outlet.
    pub name: String,
    /// True for an inlet, false for an outlet.
    pub is_inlet: bool,
    /// [kg/s] mass of the particles that pass per time, averaged over the averaging period. `None` if the flow was
    /// measured less than twice.
    pub mass_rate: Option<Estimate>,
    /// [1/s] number of particles that pass per time, averaged over the averaging period. `None` if the flow was
    /// measured less than twice.
    pub rate: Option<Estimate>,
    /// Number, mass, momentum and energy of the particles that have passed this inlet or outlet in the whole run.
    pub totals: FlowTotals,
    /// Number of particles that wait at an inlet for free space: at the end of the run, and the largest number at any
    /// time. Both are 0 for an outlet.
    pub waiting: [u64; 2],
    /// Number, mass, momentum and energy of the particles that have passed since the start, at several instants.
    #[serde(skip)]
    pub over_time: Vec<FlowSample>,
}

/// Number, mass, momentum and energy of the particles that have passed an inlet or outlet from the start to one
/// instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowSample {
    /// [s] simulated time of this instant.
    pub time: f64,
    /// Number, mass, momentum and energy of the particles that have passed since the start.
    pub totals: FlowTotals,
}

/// Measurement of the flow through all inlets and outlets of a scene.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Flows {
    /// [s] time between two instants at which the flow is measured.
    interval: f64,
    /// Measured flow through each outlet, then through each inlet. The list is empty in a scene without inlets and
    /// outlets.
    samples: Vec<Vec<FlowSample>>,
    /// For each outlet, then each inlet: number of particles that wait for free space at present, and the largest
    /// number at any time. Both are 0 for an outlet.
    waiting: Vec<[u64; 2]>,
}

impl Flows {
    /// Creates the measurement for a run of `experiment`. `schedule` contains the instants of measurement.
    pub fn new(experiment: &Experiment, schedule: &Schedule) -> Self {
        let openings = experiment.scene.outlets.len() + experiment.scene.inlets.len();
        let (samples, waiting) = (vec![Vec::new(); openings], vec![[0; 2]; openings]);
        Self { interval: schedule.spacing(MOST_SAMPLES), samples, waiting }
    }

    /// Returns the flow through each outlet and inlet of an experiment, averaged from the time `from` [s] to the end.
    pub fn averages(&self, experiment: &Experiment, from: f64) -> Vec<FlowAverages> {
        let scene = &experiment.scene;
        let outlets = scene.outlets.iter().map(|outlet| (&outlet.name, false));
        let named = outlets.chain(scene.inlets.iter().map(|inlet| (&inlet.name, true)));
        let of = |(k, (name, is_inlet)): (usize, (&String, bool))| {
            let (samples, waiting) = (&self.samples[k], self.waiting[k]);
            let used: Vec<&FlowSample> = samples.iter().filter(|sample| sample.time >= from).collect();
            let rate = |of: fn(&FlowTotals) -> f64| self.rate(&used, of);
            FlowAverages {
                name: name.clone(),
                is_inlet,
                mass_rate: rate(|totals| totals.mass),
                rate: rate(|totals| totals.count as f64),
                totals: samples.last().map(|sample| sample.totals).unwrap_or_default(),
                waiting,
                over_time: samples.clone(),
            }
        };
        named.enumerate().map(of).collect()
    }

    /// Rate of the quantity `of` per second from the first to the last of the samples `used`. The error is that of the
    /// rates between successive samples. The run may end shortly after the last regular sample; a rate over less than
    /// half an interval scatters too much, so it is left out of the error. `None` with fewer than two samples.
    fn rate(&self, used: &[&FlowSample], of: fn(&FlowTotals) -> f64) -> Option<Estimate> {
        let over = |a: &FlowSample, b: &FlowSample| (of(&b.totals) - of(&a.totals)) / (b.time - a.time);
        let [first, .., last] = used else { return None };
        let regular = used.windows(2).filter(|two| two[1].time - two[0].time > 0.5 * self.interval);
        let each: Vec<f64> = regular.map(|two| over(two[0], two[1])).collect();
        let value = over(first, last);
        Some(estimate(&each).map_or(Estimate::without_error(value), |regular| Estimate { value, ..regular }))
    }

    fn take(&mut self, simulation: &Simulation) {
        let Some(flow) = simulation.through_flow() else { return };
        let all = flow.outlets.iter().chain(&flow.inlets);
        self.waiting = all.clone().map(OpeningFlow::waiting).collect();
        for (samples, opening) in self.samples.iter_mut().zip(all) {
            samples.push(FlowSample { time: simulation.time, totals: opening.totals() });
        }
    }
}

impl Observer for Flows {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        (!self.samples.is_empty()).then_some(now + self.interval)
    }

    fn needs_velocities(&self) -> bool {
        false
    }

    fn needs(&self) -> Needs {
        Needs::Nothing
    }

    fn see(&mut self, simulation: &Simulation) {
        self.take(simulation);
    }

    fn end(&mut self, simulation: &Simulation) {
        let last = self.samples.first().and_then(|samples| samples.last());
        if last.is_some_and(|last| last.time < simulation.time) {
            self.take(simulation);
        }
    }

    plain_data!();
}
