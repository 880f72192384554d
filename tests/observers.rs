//! Observers are called at the times that they request, change no results, and can be stored.

use crate::support::{empty, experiment, placed, plane, small, surface};
use diptych::drag::{Drag, SchillerNaumann, Stokes};
use diptych::experiment::{Amount, Experiment, Model, SoftStepping, Spheres};
use diptych::fluid::{Fluid, Profile};
use diptych::observe::{
    Budgets, EnergyBooks, ImpactSeries, MomentumBooks, Motion, Observer, Paths, SecondMoments, Series, run,
};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;
use diptych::statistics::Accumulator;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Experiment of 100 spheres in a periodic box for 200 windows of 0.1 ms, with a sample every ten windows.
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

/// Experiment like that of `gas`, with only two spheres.
fn few() -> Experiment {
    let mut few = gas();
    let amount = placed(&few.scene, &[([0.0; 3], [1.0, 0.0, 0.0]), ([1e-3; 3], [0.0; 3])]);
    few.start[0].amount = Amount::Placed(amount);
    few
}

/// Observer that records the times of its calls, and requests `times` [s] one after another.
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
        // rounding errors of a sum of at most 200 windows
        assert!((seen - expected).abs() < 200.0 * f64::EPSILON * 0.02, "{seen} {expected}");
    }
}

#[test]
fn each_observer_is_shown_the_simulation_at_its_own_times() {
    let gas = gas();
    let schedule = Schedule::new(&gas);
    assert_eq!((schedule.windows(), schedule.windows_per_sample), (200, 10));
    let mut samples = Vec::new();
    // requests at the end of a window, within a window, twice within one window, and beyond the end, which is never
    // reached
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
        let schedule = Schedule::even(window, 7, 1 << 30);
        for done in [0u64, 1, 6, 7, 1000, 999_999, 123_456_789, 1_000_000_000] {
            let next = done as f64 * schedule.window + schedule.interval();
            // the time is reached at the seventh window, not at the sixth
            let reaches = |windows: u64| windows as f64 * window + schedule.rounding() >= next;
            assert!(reaches(done + 7) && !reaches(done + 6), "{window} s, {done}");
        }
    }
}

#[test]
fn who_observes_does_not_change_the_result() {
    let mut dragged = gas();
    dragged.scene.fluid =
        Some(Fluid::new(1.205, 1.515e-5, Profile::Uniform(3.0), Some(Drag::SchillerNaumann(SchillerNaumann))));
    for gas in [gas(), dragged] {
        let schedule = Schedule::new(&gas);
        let mut alone = simulation(&gas);
        run(&mut alone, &schedule, &mut []).unwrap();
        let mut observed = simulation(&gas);
        let mut often = Visitor { times: (0..200).map(|k| f64::from(k) * 1e-4).collect(), ..Visitor::default() };
        // a kick that is not reversed would appear in the momentum given by drag
        let mut momenta = vec![0.0];
        let mut drag = |simulation: &Simulation| momenta.push(simulation.record.ledger.drag_impulse.z);
        run(&mut observed, &schedule, &mut [&mut often, &mut drag]).unwrap();
        assert_eq!(often.seen.len(), 200);
        assert!(alone.record.pairs.count > 100);
        assert!(alone.state() == observed.state() && alone.record.ledger == observed.record.ledger);
        assert_eq!(momenta.last(), Some(&alone.record.ledger.drag_impulse.z));
        // the simulation has no clock
        assert!(observed.spent.whole.is_zero() && observed.spent.engine.is_zero());
    }
}

/// Between samples, as at samples (instants of measurement), the state belongs to one instant: velocities contain the
/// kicks (changes by drag) up to this instant.
#[test]
fn looks_between_samples_see_what_samples_there_would() {
    let mut gas = gas();
    gas.start[0].amount = Amount::Placed(placed(&gas.scene, &[([0.0; 3], [1.0, 0.0, 0.0])]));
    gas.scene.fluid =
        Some(Fluid::new(1.205, 1.515e-5, Profile::Uniform(3.0), Some(Drag::SchillerNaumann(SchillerNaumann))));
    let seen = |windows_per_sample: u64| {
        let mut velocities = Vec::new();
        let schedule = Schedule::even(1e-4, windows_per_sample, 200 / windows_per_sample);
        let mut series = Series::new(&gas, &schedule);
        run(&mut simulation(&gas), &schedule, &mut [&mut series]).unwrap();
        series.rows.iter().for_each(|row| velocities.push(row.velocity));
        velocities
    };
    let (often, seldom) = (seen(1), seen(20));
    assert_eq!((often.len(), seldom.len()), (201, 201));
    // two half-kicks and one whole kick differ by rounding
    assert!(often.iter().zip(&seldom).all(|(a, b)| (a - b).norm() < 1e-12));
}

#[test]
fn a_series_is_what_the_particles_say() {
    let mut gas = gas();
    gas.scene.domain.periodic = [true, false, true];
    let height = gas.scene.domain.size.y;
    gas.scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(1.0, 0.0)),
        plane([0.0, height, 0.0], [0.0, -1.0, 0.0], surface(1.0, 0.0)),
    ];
    let schedule = Schedule::new(&gas);
    let mut series = Series::new(&gas, &schedule);
    let mut simulation = simulation(&gas);
    run(&mut simulation, &schedule, &mut [&mut series]).unwrap();
    assert_eq!(series.rows.len(), 201);
    agree(
        &series.rows.iter().map(|row| row.time).collect::<Vec<f64>>(),
        &(0..=200).map(|k| f64::from(k) * 1e-4).collect::<Vec<f64>>(),
    );
    let (row, particles, record) = (series.rows.last().unwrap(), &simulation.particles, &simulation.record);
    assert_eq!((row.pair_impacts, row.wall_impacts), (record.pairs.count, record.walls.count));
    assert!(record.pairs.count > 100 && record.walls.count > 10);
    // sums of 100 numbers in different orders differ by rounding
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
    assert!(
        near(row.kinetic_energy, particles.kinetic_energy()) && (row.momentum - particles.momentum()).norm() < 1e-18
    );
    assert!(near(row.velocity.y, particles.mean_velocity().y));
    let middle = particles.position.iter().map(|x| x.y).sum::<f64>() / 100.0;
    assert!(row.centre[0].is_none() && row.centre[2].is_none() && near(row.centre[1].unwrap(), middle));
    assert_eq!((row.coordination, row.largest_overlap, row.elastic_energy), (0.0, 0.0, 0.0));
    let components = row.temperature.unwrap();
    assert!(near(row.granular_temperature().unwrap(), components.sum() / 3.0) && components.min() > 0.0);
}

/// Two spheres pressed together, and a sphere pressed against a wall, from the first row on. The energy of each contact
/// is half the stiffness times the squared overlap.
#[test]
fn contacts_in_progress_are_in_the_series_and_in_the_paths() {
    let (d, stiffness) = (small().diameter, 3000.0);
    let mut scene = empty([0.01; 3], [true, false, true], small(), surface(0.9, 0.0));
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.0))];
    for stepping in [SoftStepping::Uniform, SoftStepping::Local] {
        let mut pressed = experiment(scene.clone(), 0, [0.0; 3], 0.0, Model::Soft, 1);
        let places = [[2e-3, 5e-3, 5e-3], [2e-3 + 0.99 * d, 5e-3, 5e-3], [5e-3, 0.49 * d, 5e-3]];
        let particles = placed(&scene, &places.map(|place| (place, [0.0; 3])));
        pressed.start[0].amount = Amount::Placed(particles);
        pressed.soft.stepping = stepping;
        pressed.run.duration = 2e-5;
        assert_eq!(pressed.run.spheres, Spheres::Soft(diptych::contact_law::ContactLaw::linear(stiffness)));
        let schedule = Schedule::new(&pressed);
        let (mut series, mut paths) = (Series::new(&pressed, &schedule), Paths::new(&schedule));
        run(&mut simulation(&pressed), &schedule, &mut [&mut series, &mut paths]).unwrap();
        assert_eq!((series.rows.len(), paths.points.len()), (201, 603));
        let rows = series.rows.iter().zip(paths.points.chunks(3));
        let mut touching = 0;
        for (row, points) in rows {
            assert!(points.iter().zip(0..).all(|(point, id)| point.id == id && point.time == row.time));
            assert_eq!(points[0].overlap, points[1].overlap);
            let overlaps = [points[0].overlap, points[2].overlap];
            let energy: f64 = overlaps.iter().map(|overlap| 0.5 * stiffness * overlap * overlap).sum();
            assert!((row.elastic_energy - energy).abs() <= 1e-9 * energy, "{stepping:?} {row:?} {points:?}");
            assert!((row.largest_overlap - overlaps[0].max(overlaps[1]) / d).abs() < 1e-15);
            let ends = 2.0 * f64::from(u8::from(overlaps[0] > 0.0)) + f64::from(u8::from(overlaps[1] > 0.0));
            assert_eq!(row.coordination, ends / 3.0);
            touching += usize::from(ends == 3.0);
        }
        // both contacts exist for some rows, and then end
        assert!(series.rows[0].coordination == 1.0 && (20..180).contains(&touching), "{stepping:?} {touching}");
    }
}

#[test]
fn series_are_short_for_long_runs_and_end_with_the_run() {
    let mut gas = gas();
    let rows = |gas: &Experiment| {
        let schedule = Schedule::new(gas);
        let (mut series, mut paths) = (Series::new(gas, &schedule), Paths::new(&schedule));
        let mut simulation = simulation(gas);
        let result = run(&mut simulation, &schedule, &mut [&mut series, &mut paths]);
        assert_eq!(series.rows.last().unwrap().time, simulation.time);
        // with 100 spheres there are no paths
        assert!(paths.points.is_empty());
        (series.rows.len(), result.is_err())
    };
    gas.statistics.sample_interval = Some(1e-4);
    gas.run.duration = 0.1001;
    // of 1001 samples, every second one gives a row; the end gives another row
    assert_eq!(rows(&gas), (502, false));
    gas.run.duration = 0.02;
    gas.scene.domain.periodic = [false; 3];
    let (seen, failed) = rows(&gas);
    assert!(failed && seen >= 2, "{seen}");
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
    let (mut series, mut paths) = (Series::new(&gas, &schedule), Paths::default());
    paths.see(&simulation(&few()));
    let observers: &mut [&mut dyn Observer] =
        &mut [&mut profiles, &mut motion, &mut pairs, &mut energy, &mut momentum, &mut series];
    run(&mut simulation(&gas), &schedule, observers).unwrap();
    same(&profiles);
    same(&motion);
    same(&pairs);
    same(&energy);
    same(&momentum);
    same(&series);
    same(&paths);
}

/// First two spheres that do not collide, in a gas at rest with Stokes drag and the response time τ = 0.52 s. Drag
/// reduces every second moment of velocity at the rate 2/τ, and the other terms of the budget are zero. Then hard
/// spheres with the restitution 0.9 without gas: impacts remove the energy that the ledger (energy balance) counts as
/// dissipated.
#[test]
fn budgets_of_second_moments_tell_drag_and_impacts() {
    let edge = 0.01;
    let mut free =
        experiment(empty([edge; 3], [true; 3], small(), surface(1.0, 0.0)), 2, [0.0; 3], 0.5, Model::Hard, 3);
    free.scene.fluid = Some(Fluid::new(1.205, 1.515e-5, Profile::Uniform(0.0), Some(Drag::Stokes(Stokes))));
    free.run.duration = 0.02;
    free.run.window = Some(1e-4);
    free.statistics.sample_interval = Some(1e-3);
    // the spheres fly in different columns along z, and never meet
    let state = placed(&free.scene, &[([2e-3, 5e-3, 2e-3], [0.0, 0.0, 0.4]), ([7e-3, 5e-3, 2e-3], [0.0, 0.0, -0.2])]);
    let (budgets, second) = budgets_of(&free, state);
    // <u″u″> is (0.3 m/s)² at the start and falls by exp(-2t/τ). The expected value is its mean over 20 ms at the ends
    // of windows, with an error of (h/τ)²
    let tau = free.scene.fluid.as_ref().unwrap().sphere(&small()).stokes_time;
    let mean = 0.09 * tau / (2.0 * 0.02) * -f64::exp_m1(-2.0 * 0.02 / tau);
    let uu = &second.whole[0];
    assert!((uu.drag.value / (-2.0 / tau * mean) - 1.0).abs() < 1e-3, "{uu:?}");
    assert!(uu.impacts.value.abs() < 1e-6 * uu.drag.value.abs(), "{uu:?}");
    assert!(budgets.record.pairs.count == 0);

    let cooling = gas();
    let (simulation, second) = budgets_of(&cooling, initial_state(&cooling).unwrap());
    let mass: f64 = simulation.particles.mass.iter().sum();
    let lost = 2.0 * simulation.record.ledger.dissipated() / (mass * cooling.run.duration);
    let impacts: f64 = second.whole[..3].iter().map(|terms| terms.impacts.value).sum();
    // the mean velocity of the slice does not change: momentum is conserved, and no particle leaves the slice
    assert!((impacts / -lost - 1.0).abs() < 1e-9, "{impacts} {lost}");
    assert!(second.whole.iter().all(|terms| terms.drag.value == 0.0));
}

/// Runs an experiment that measures budgets (rates of change of the second moments of velocity) in a single slice of
/// the box.
fn budgets_of(experiment: &Experiment, start: Particles) -> (Simulation, Budgets) {
    let schedule = Schedule::new(experiment);
    let mut moments = SecondMoments::new(1, &schedule);
    let mut simulation = Simulation::new(experiment, start);
    run(&mut simulation, &schedule, &mut [&mut moments]).unwrap();
    (simulation, moments.budgets(0.0).unwrap())
}
