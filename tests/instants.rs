//! A run has instants at which all particles are written. Windows end at these instants, which are equal in every
//! variant.

use crate::support::*;
use diptych::case::Case;
use diptych::experiment::{Experiment, Model};
use diptych::observe::{Observer, Pause, RunLoop, Series};
use diptych::placement::initial_state;
use diptych::schedule::{Schedule, ScheduleStep};
use diptych::simulation::Simulation;
use std::path::Path;

/// [s] times of the frames in an index.
fn listed(index: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(index).unwrap();
    let times = text.split("timestep=\"").skip(1).map(|rest| rest.split_once('"').unwrap());
    times.filter(|(_, rest)| rest.starts_with(" part=\"0\"")).map(|(time, _)| time.parse().unwrap()).collect()
}

/// [s] first column of a table, which must be named `t_s`.
fn times(table: &Path, variant: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(table).unwrap();
    let column = reader.headers().unwrap().iter().position(|name| name == "t_s").unwrap();
    let rows = reader.records().map(Result::unwrap).filter(|row| &row[0] == variant);
    rows.map(|row| row[column].parse().unwrap()).collect()
}

fn agree(found: &[f64], wanted: &[f64]) {
    assert_eq!(found.len(), wanted.len(), "{found:?}");
    for (found, wanted) in found.iter().zip(wanted) {
        assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
    }
}

/// Experiment of the small case for 10 ms, with instants every `every` seconds.
fn with_instants(every: Option<&str>, model: Model) -> Experiment {
    let mut sets = vec!["run.duration=10 ms".to_owned(), "run.average_from=0 s".to_owned()];
    sets.extend(every.map(|every| format!("output.every={every}")));
    let case = Case::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(BASE), &sets).unwrap();
    case.experiment(Some(model), None).unwrap().0
}

#[test]
fn frames_come_at_the_times_asked_for_in_every_variant() {
    let place = tempfile::tempdir().unwrap();
    let run = ["run", "walls/settling-box", "--model", "soft", "--every", "1 ms", "--set", "run.duration=\"0.02 s\""];
    let output = diptych(&run).args(["--quiet", "--out"]).arg(place.path()).output().unwrap();
    assert!(output.status.success(), "{}", words(&output.stderr));
    let milliseconds: Vec<f64> = (0..=20).map(|k| f64::from(k) * 1e-3).collect();
    agree(&listed(&place.path().join("trajectory/soft.pvd")), &milliseconds);
    agree(&times(&place.path().join("series.csv"), "soft"), &milliseconds);

    let place = tempfile::tempdir().unwrap();
    let compare =
        ["compare", BASE, "--every", "0.7 ms", "--set", "run.duration=10 ms", "--set", "run.average_from=0 s"];
    let output = diptych(&compare).args(["--quiet", "--out"]).arg(place.path()).output().unwrap();
    assert!(output.status.success(), "{}", words(&output.stderr));
    // every trajectory also contains the end of the run
    let wanted: Vec<f64> = (0..15).map(|k| f64::from(k) * 0.7e-3).chain([10e-3]).collect();
    for variant in ["soft", "hard"] {
        agree(&listed(&place.path().join(format!("trajectory/{variant}.pvd"))), &wanted);
    }
    agree(&times(&place.path().join("series.csv"), "soft"), &times(&place.path().join("series.csv"), "hard"));
}

/// The schedule cuts a run into pieces, which follow one another to its end. Each piece ends at the end of a window or
/// at an instant (time at which all particles are written). None is as short as a rounding error.
#[test]
fn windows_are_cut_at_instants_only() {
    for (window, per_sample, samples, every) in [
        (1e-3, 10, 20, 0.7e-3),
        (5e-3, 1, 4, 1e-3),
        (1.0 / 3.0, 7, 5, 0.1),
        (1e-4, 5, 40, 1e-3),
        (2e-3, 3, 9, 5.000_000_001e-3),
    ] {
        let schedule = Schedule { instants: Some(every), ..Schedule::even(window, per_sample, samples) };
        let (mut done, mut now, mut ends) = (0, 0.0, Vec::new());
        while done < schedule.length() {
            let before = now;
            match schedule.piece(done, now) {
                ScheduleStep::Windows(windows) => {
                    done += windows;
                    now = done as f64 * window;
                }
                ScheduleStep::ToInstant(instant) => now = instant,
                ScheduleStep::ToEnd(end) => {
                    done += 1;
                    now = end;
                }
            }
            assert!(now - before > schedule.rounding(), "{before} {now}");
            ends.push(now);
        }
        let duration = schedule.length() as f64 * window;
        assert!((now - duration).abs() < 1e-12);
        let instants = (1..).map(|k| f64::from(k) * every).take_while(|instant| *instant < duration);
        for instant in instants {
            let is_end = |end: &f64| (end - instant).abs() <= schedule.rounding();
            // an instant is at the end of a window or of a piece of a window
            let ratio = instant / window;
            assert!(ends.iter().any(is_end) || (ratio - ratio.round()).abs() < 1e-5, "{instant}");
        }
        assert_eq!(schedule.is_cut(), every != 1e-3 || window != 1e-4, "{window} {every}");
    }
}

#[test]
fn instants_at_ends_of_windows_change_no_bit() {
    for model in [Model::Soft, Model::Hard] {
        let hash = |experiment: &Experiment| {
            let start = initial_state(experiment).unwrap();
            let mut simulation = Simulation::new(experiment, start);
            let schedule = Schedule::new(experiment);
            diptych::observe::run(&mut simulation, &schedule, &mut []).unwrap();
            (simulation.fingerprint(), schedule.window)
        };
        let (without, window) = hash(&with_instants(None, model));
        let every = format!("{:?} s", 4.0 * window);
        assert_eq!(hash(&with_instants(Some(&every), model)).0, without);
        let cut = with_instants(Some("0.7 ms"), model);
        assert!(Schedule::new(&cut).is_cut());
        assert_eq!(hash(&cut).0, hash(&cut).0);
    }
}

/// A run that is stopped after every window and every piece of a window, stored, and resumed has identical bits.
#[test]
fn a_run_that_is_left_between_cuts_goes_on_with_the_same_bits() {
    for model in [Model::Soft, Model::Hard, Model::Hybrid, Model::Dsmc] {
        let experiment = with_instants(Some("0.7 ms"), model);
        let (schedule, start) = (Schedule::new(&experiment), initial_state(&experiment).unwrap());
        let run = |leave: bool| {
            let mut series = Series::new(&experiment, &schedule);
            let mut simulation = Simulation::new(&experiment, start.clone());
            let mut course = RunLoop::new(&schedule, 1);
            let mut left = 0;
            loop {
                let over = course.run(&mut simulation, &mut [&mut series as &mut dyn Observer], &mut || leave).unwrap();
                if over {
                    break;
                }
                left += 1;
                let pause: Pause = course.store(&simulation, &[&mut series as &mut dyn Observer]).unwrap();
                series = Series::new(&experiment, &schedule);
                (simulation, course) = pause.resume(&experiment, &mut [&mut series as &mut dyn Observer]).unwrap();
            }
            (simulation.fingerprint(), series.rows, left)
        };
        let (whole, in_parts) = (run(false), run(true));
        assert!(in_parts.2 as u64 > schedule.windows());
        assert_eq!((whole.0, whole.1), (in_parts.0, in_parts.1), "{model:?}");
    }
}

#[test]
fn samples_come_as_often_as_is_asked() {
    let sets = ["run.duration=10 ms", "run.average_from=0 s", "run.window=1 ms", "statistics.sample_interval=0.25 ms"];
    let case = Case::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(BASE), &sets.map(str::to_owned)).unwrap();
    let schedule = Schedule::new(&case.experiment(None, None).unwrap().0);
    assert_eq!((schedule.samples, schedule.windows_per_sample), (40, 1));
    assert!((schedule.interval() - 0.25e-3).abs() < 1e-15);
}

#[test]
fn budgets_are_not_summed_over_windows_that_are_cut() {
    let place = tempfile::tempdir().unwrap();
    let run = ["run", BASE, "--budgets", "--every", "0.7 ms", "--set", "run.duration=10 ms"];
    let output = diptych(&run).arg("--out").arg(place.path().join("o")).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(words(&output.stderr).contains("--every ends some of them between"), "{}", words(&output.stderr));
}
