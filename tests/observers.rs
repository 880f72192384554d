//! Observers: each sees the simulation at its own times, costs nothing where there is none, and can be stored.

use crate::support::{empty, experiment, small, surface};
use diptych::experiment::{Experiment, Model};
use diptych::observe::{EnergyBooks, ImpactSeries, MomentumBooks, Motion, Observer, run};
use diptych::placement::initial_state;
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;
use diptych::statistics::Accumulator;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// 100 spheres in a periodic box for 200 windows of 0.1 ms, a sample every tenth.
fn gas() -> Experiment {
    let edge = (100.0 * small().volume() / 0.05).cbrt();
    let mut gas =
        experiment(empty([edge; 3], [true; 3], small(), surface(0.9, 0.0)), 100, [0.0; 3], 0.5, Model::Hard, 7);
    gas.run.duration = 0.02;
    gas.run.window = Some(1e-4);
    gas.statistics.sample_interval = Some(1e-3);
    gas
}

fn simulation(experiment: &Experiment) -> Simulation {
    Simulation::new(experiment, initial_state(experiment).unwrap())
}

/// Notes when it saw the simulation, and asks for `times` [s] one after another.
#[derive(Default)]
struct Visitor {
    times: Vec<f64>,
    seen: Vec<f64>,
    ended: Option<f64>,
}

impl Observer for Visitor {
    fn next(&self, now: f64, _: &Schedule) -> Option<f64> {
        self.times.iter().copied().find(|time| *time > now)
    }

    fn see(&mut self, simulation: &Simulation) {
        self.seen.push(simulation.time);
    }

    fn end(&mut self, simulation: &Simulation) {
        self.ended = Some(simulation.time);
    }
}

fn agree(seen: &[f64], expected: &[f64]) {
    assert_eq!(seen.len(), expected.len(), "{seen:?} {expected:?}");
    for (seen, expected) in seen.iter().zip(expected) {
        // a sum of at most 200 windows
        assert!((seen - expected).abs() < 200.0 * f64::EPSILON * 0.02, "{seen} {expected}");
    }
}

#[test]
fn each_observer_is_shown_the_simulation_at_its_own_times() {
    let gas = gas();
    let schedule = Schedule::new(&gas);
    assert_eq!((schedule.windows(), schedule.windows_per_sample), (200, 10));
    let mut samples = Vec::new();
    // at an end of a window, within one, twice within one, never since it lies beyond the end
    let mut visitor = Visitor { times: vec![0.0003, 0.000_55, 0.007_01, 0.007_05, 1.0], ..Visitor::default() };
    let mut sampler = |simulation: &Simulation| samples.push(simulation.time);
    let mut simulation = simulation(&gas);
    run(&mut simulation, &schedule, &mut [&mut visitor, &mut sampler]).unwrap();
    agree(&visitor.seen, &[0.0, 0.0003, 0.0006, 0.0071]);
    agree(&samples, &(0..=20).map(|k| f64::from(k) * 1e-3).collect::<Vec<f64>>());
    assert_eq!(visitor.ended, Some(simulation.time));
    assert_eq!(simulation.windows, 200);
}

#[test]
fn samples_of_long_runs_stay_where_they_belong() {
    for window in [1e-4, 1.0 / 3.0, 7.7e-7, 0.1] {
        let schedule = Schedule { window, windows_per_sample: 7, samples: 1 << 30 };
        for done in [0u64, 1, 6, 7, 1000, 999_999, 123_456_789, 1_000_000_000] {
            let next = done as f64 * schedule.window + schedule.interval();
            assert_eq!(schedule.windows_to(next), done + 7, "{window} s, {done}");
        }
    }
}

#[test]
fn who_observes_does_not_change_the_result() {
    let gas = gas();
    let schedule = Schedule::new(&gas);
    let mut alone = simulation(&gas);
    run(&mut alone, &schedule, &mut []).unwrap();
    let mut observed = simulation(&gas);
    let mut often = Visitor { times: (0..200).map(|k| f64::from(k) * 1e-4).collect(), ..Visitor::default() };
    run(&mut observed, &schedule, &mut [&mut often]).unwrap();
    assert!(alone.record.pairs.count > 100);
    // without gas the windows are the same bits wherever the run is looked at
    assert_eq!(alone.state(), observed.state());
    // no clock was lent
    assert!(observed.spent.whole.is_zero() && observed.spent.engine.is_zero());
}

#[test]
fn a_failure_ends_the_run_for_all_observers() {
    let mut gas = gas();
    gas.scene.domain.periodic = [false; 3];
    let mut visitor = Visitor::default();
    let mut simulation = simulation(&gas);
    let failure = run(&mut simulation, &Schedule::new(&gas), &mut [&mut visitor]).unwrap_err();
    assert_eq!(visitor.ended, Some(failure.time()));
    assert_eq!(visitor.seen, [0.0]);
}

#[test]
fn what_observers_keep_can_be_stored_and_read_back() {
    fn same<T: Serialize + DeserializeOwned>(observer: &T) {
        let stored = serde_json::to_value(observer).unwrap();
        let read: T = serde_json::from_value(stored.clone()).unwrap();
        assert!(stored.to_string().len() > 100);
        assert!(serde_json::to_value(&read).unwrap() == stored, "{}", std::any::type_name::<T>());
    }
    let gas = gas();
    let schedule = Schedule::new(&gas);
    let mut profiles = Accumulator::new(4, gas.scene.domain.size.y);
    let mut motion = Motion::new(&gas);
    let mut pairs = ImpactSeries::of_pairs(&gas, &schedule);
    let mut energy = EnergyBooks::default();
    let mut momentum = MomentumBooks::new(&schedule);
    let observers: &mut [&mut dyn Observer] = &mut [&mut profiles, &mut motion, &mut pairs, &mut energy, &mut momentum];
    run(&mut simulation(&gas), &schedule, observers).unwrap();
    same(&profiles);
    same(&motion);
    same(&pairs);
    same(&energy);
    same(&momentum);
}
