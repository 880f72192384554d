//! Standard observers: the measurements of every run, from which its outcome is made.

use crate::engine::Failure;
use crate::experiment::{Experiment, Model, SoftStepping};
use crate::observe::{
    EnergyBooks, Flows, GasFlows, ImpactSeries, Kinds, Measurements, Mixing, MomentumBooks, Motion, Observer, Paths,
    Rings, Series, Stresses,
};
use crate::outcome::{Averaged, Outcome, Timing};
use crate::schedule::Schedule;
use crate::simulation::{Simulation, soft_step};
use crate::statistics::Accumulator;

/// Standard observers of one run: the measurements from which its outcome is made.
#[derive(Clone)]
pub(crate) struct StandardObservers<'a> {
    experiment: &'a Experiment,
    initial_state_hash: u64,
    /// Times of the windows (times between two exchanges with the gas) and of the samples (instants of measurement) of
    /// the run.
    pub schedule: Schedule,
    profiles: Accumulator,
    motion: Motion,
    pairs: ImpactSeries,
    walls: ImpactSeries,
    energy: EnergyBooks,
    momentum: MomentumBooks,
    stresses: Stresses,
    gas: GasFlows,
    flows: Flows,
    series: Series,
    paths: Paths,
    kinds: Kinds,
    rings: Rings,
    mixing: Mixing,
    measurements: Measurements,
}

impl<'a> StandardObservers<'a> {
    /// Creates the standard observers of a run that has not started. `initial_state_hash` is the hash of its initial
    /// state.
    pub fn new(experiment: &'a Experiment, initial_state_hash: u64) -> Self {
        let schedule = Schedule::new(experiment);
        Self {
            experiment,
            initial_state_hash,
            schedule,
            profiles: Accumulator::new(experiment.statistics.slices, experiment.scene.domain.size.y),
            motion: Motion::new(experiment),
            pairs: ImpactSeries::of_pairs(experiment, &schedule),
            walls: ImpactSeries::of_walls(experiment, &schedule),
            energy: EnergyBooks::default(),
            momentum: MomentumBooks::new(&schedule),
            stresses: Stresses::new(experiment, &schedule),
            gas: GasFlows::new(&schedule),
            flows: Flows::new(experiment, &schedule),
            series: Series::new(experiment, &schedule),
            paths: Paths::new(&schedule),
            kinds: Kinds::new(experiment, &schedule),
            rings: Rings::new(experiment),
            mixing: Mixing::new(experiment, &schedule),
            measurements: Measurements::new(experiment, &schedule),
        }
    }

    /// List of all standard observers, then the measurements that the case requests, then the observers `others`. An
    /// observer is a measurement during a run.
    pub fn with<'b>(&'b mut self, others: &'b mut [&mut dyn Observer]) -> Vec<&'b mut dyn Observer> {
        let Self { profiles, motion, pairs, walls, energy, momentum, .. } = self;
        let Self { stresses, gas, flows, series, paths, kinds, rings, mixing, measurements, .. } = self;
        let own: [&mut dyn Observer; 14] = [
            profiles, motion, pairs, walls, energy, momentum, stresses, gas, flows, series, paths, kinds, rings, mixing,
        ];
        let asked = measurements.each().map(|measurement| measurement as &mut dyn Observer);
        own.into_iter().chain(asked).chain(others.iter_mut().map(|other| &mut **other as &mut dyn Observer)).collect()
    }

    /// Outcome of a run that has ended or failed, made from the measurements of the observers. `failure` is the reason
    /// why the run failed; `None` if it reached its end. `final_state_hash` is the hash of its final state.
    pub fn outcome(self, simulation: &Simulation, failure: Option<Failure>, final_state_hash: u64) -> Outcome {
        let steadiness =
            self.motion.steadiness(self.experiment.run.average_from, self.kinds.series(&self.experiment.scene));
        // the interval with index k lies between sample k and sample k + 1 (instants of measurement). Averages begin
        // with the first interval that lies entirely within the averaging period
        let first = self.motion.first(steadiness.from);
        Outcome {
            experiment: self.experiment.clone(),
            failure,
            particles: simulation.count(),
            initial_state_hash: self.initial_state_hash,
            final_state_hash,
            simulated_seconds: simulation.time,
            windows: simulation.windows,
            window: self.schedule.window,
            sample_interval: self.schedule.interval(),
            time_step: time_step(self.experiment, simulation, self.schedule.window),
            profiles: self.profiles.table(steadiness.from),
            kinds: self.kinds.averages(&self.experiment.scene, first, steadiness.from),
            rings: self.rings.averages(&self.experiment.scene, steadiness.from),
            pair_rate: self.pairs.rate(first),
            wall_rate: self.walls.rate(first),
            pair_restitution: self.pairs.restitution(),
            wall_restitution: self.walls.restitution(),
            pairs: self.pairs.since(steadiness.from, &simulation.record),
            walls: self.walls.since(steadiness.from, &simulation.record),
            temperature: self.motion.temperature(first),
            averaged: Averaged {
                pair_rate: self.pairs.batches(first, steadiness.from),
                wall_rate: self.walls.batches(first, steadiness.from),
                temperature: self.motion.batches(first),
                shear_stress: self.motion.stress_batches(first),
                replicas: None,
            },
            places_kept: self.mixing.remembered(steadiness.from),
            steadiness,
            energy_residual: self.energy.residual(),
            energy_at_start: self.energy.at_start,
            energy_at_end: self.energy.at_end,
            balance: self.momentum.balance(first),
            stress: self.stresses.averages(first),
            gas: self.gas.averages(self.experiment.scene.fluid.as_ref(), steadiness.from),
            flows: self.flows.averages(self.experiment, steadiness.from),
            observations: self.measurements.results(self.experiment, steadiness.from),
            series: self.series,
            paths: self.paths,
            counters: simulation.counters(),
            timing: timing(simulation),
            record: simulation.record.clone(),
        }
    }
}

/// Wall times [s] of the parts of a run, such as engine and sampling, and the number of threads of the run.
fn timing(simulation: &Simulation) -> Timing {
    let (spent, parts) = (simulation.spent, simulation.engine_spent());
    Timing {
        wall_seconds: spent.whole.as_secs_f64(),
        engine: spent.engine.as_secs_f64(),
        neighbours: parts.neighbours.as_secs_f64(),
        flight: parts.flight.as_secs_f64(),
        drag: spent.drag.as_secs_f64(),
        statistics: spent.observers.as_secs_f64(),
        threads: rayon::current_num_threads(),
    }
}

/// [s] time step of the run. It is the mean step if all particles move in common steps (soft spheres with uniform
/// steps, hard spheres in steps, DSMC), otherwise the step of soft contacts, which is at most `window` [s]. `None` if
/// the run has no time steps.
fn time_step(experiment: &Experiment, simulation: &Simulation, window: f64) -> Option<f64> {
    let steps = simulation.counters().steps;
    match (experiment.model(), experiment.soft.stepping) {
        (Model::Soft, SoftStepping::Uniform) | (Model::Hard | Model::Dsmc, _) if steps > 0 => {
            Some(simulation.time / steps as f64)
        }
        (Model::Soft | Model::Hybrid, _) => {
            Some(soft_step(experiment, experiment.most_that_touch(simulation.count())).min(window))
        }
        (Model::Hard | Model::Dsmc, _) => None,
    }
}
