//! Work-precision chart: catalogue values for one impact, orders of convergence, Pareto fronts, failures, and floors
//! (errors that the reference has by chance).

use crate::support::{experiment, small, surface};
use diptych::case::Case;
use diptych::contact_law::Bodies;
use diptych::engine::{Counters, Failure, Partner};
use diptych::experiment::Model;
use diptych::output::*;
use diptych::statistics::Estimate;
use diptych::study::chart::{Crowd, HeadOn, MethodSweep, Outlook, PHASES, STARTS, Stretch, measure, sentences, slopes};
use std::path::Path;
use std::process::Command;

/// Head-on impact of two small spheres of the paper (docs/paper.md) at 1 m/s, with the stiffness 3000 N/m and the
/// restitution `e`.
fn head_on(e: f64) -> HeadOn {
    let scene = crate::support::empty([1e-2; 3], [false; 3], small(), surface(e, 0.0));
    HeadOn {
        experiment: experiment(scene, 2, [0.0; 3], 0.0, Model::Soft, 1),
        bodies: (small(), Some(small())),
        contact: Bodies::alike(&small(), &surface(e, 0.0)),
        surface: surface(e, 0.0),
        approach: 1.0,
        touch: 4e-6,
        duration: 40e-6,
    }
}

/// Points of the chart of one impact for the method called `name`, one for each value of its parameter.
fn swept(head_on: &HeadOn, name: &str) -> Vec<ChartPoint> {
    let sweeps = MethodSweep::all(&head_on.experiment, head_on.duration, &HeadOn::values(false));
    let (place, sweep) = sweeps.iter().enumerate().find(|(_, sweep)| sweep.name == name).unwrap();
    sweep.values.iter().map(|value| head_on.point(sweep, place, *value)).collect()
}

fn at(points: &[ChartPoint], knob: f64) -> &ChartPoint {
    points.iter().find(|point| point.knob == knob).unwrap()
}

#[test]
fn rows_of_the_catalogue_of_one_impact() {
    // mean, smallest and largest realised restitution over 200 phases of first touch; contacts are detected only at the
    // ends of steps. The values come from an independent integration of the linear spring-dashpot by Heun's method, and
    // by Verlet's method with the half-step velocity
    let rows: [(&str, f64, [(f64, f64, Option<(f64, f64)>); 4]); 6] = [
        (
            "soft uniform, RK2",
            1.0,
            [
                (5.0, 1.0776, Some((1.0470, 1.1129))),
                (10.0, 1.01089, Some((1.0052, 1.0168))),
                (15.0, 1.00335, Some((1.0015, 1.0053))),
                (50.0, 1.00010, Some((1.0000, 1.0002))),
            ],
        ),
        (
            "soft uniform, RK2",
            0.94,
            [
                (5.0, 1.0078, Some((0.9718, 1.0643))),
                (10.0, 0.94857, Some((0.9414, 0.9646))),
                (15.0, 0.94237, Some((0.9397, 0.9513))),
                (50.0, 0.94001, Some((0.9399, 0.9423))),
            ],
        ),
        (
            "soft uniform, RK2",
            0.5,
            [
                (5.0, 0.5146, Some((0.434, 0.653))),
                (10.0, 0.4962, Some((0.479, 0.560))),
                (15.0, 0.4972, Some((0.490, 0.541))),
                (50.0, 0.49957, Some((0.499, 0.513))),
            ],
        ),
        (
            "soft uniform, Verlet",
            1.0,
            [
                (5.0, 1.0001, Some((0.984, 1.016))),
                (10.0, 1.0, Some((0.9980, 1.0020))),
                (15.0, 1.0, Some((0.9994, 1.0006))),
                (50.0, 1.0, None),
            ],
        ),
        (
            "soft uniform, Verlet",
            0.94,
            [
                (5.0, 0.9410, Some((0.918, 0.982))),
                (10.0, 0.94009, Some((0.936, 0.954))),
                (15.0, 0.94, None),
                (50.0, 0.93998, None),
            ],
        ),
        (
            "soft uniform, Verlet",
            0.5,
            [
                (5.0, 0.4926, Some((0.387, 0.607))),
                (10.0, 0.4909, Some((0.454, 0.542))),
                (15.0, 0.4930, None),
                (50.0, 0.4976, None),
            ],
        ),
    ];
    const { assert!(PHASES >= 100) };
    for (method, e, row) in rows {
        let points = swept(&head_on(e), method);
        for (steps, mean, range) in row {
            let found = at(&points, steps).errors[0].unwrap();
            let text = format!("{method} e={e} N_c={steps}: {found:?}, catalogue {mean} {range:?}");
            // the catalogue's tolerance for the mean is 0.01 at N_c = 5, else 0.002; for the range it is 0.002
            assert!((found.value - mean).abs() <= if steps < 10.0 { 0.01 } else { 0.002 }, "{text}");
            assert!((found.error - (found.value - e).abs() / e).abs() < 1e-15, "{text}");
            if let Some((low, high)) = range {
                assert!(
                    found.range.is_some_and(|(least, most)| low - 0.002 <= least && most <= high + 0.002),
                    "{text}"
                );
            }
        }
    }
}

#[test]
fn orders_of_convergence_come_out_as_slopes() {
    let fitted = |e: f64, method: &str, quantity: usize| {
        let head_on = head_on(e);
        let points: Vec<ChartPoint> =
            swept(&head_on, method).into_iter().map(|point| ChartPoint { method: 0, ..point }).collect();
        let found = slopes(&head_on.quantities(), 1, &points);
        let slope = found.iter().find(|slope| slope.quantity == quantity).unwrap().law;
        println!("{method}, e = {e}, {}: {slope:?}", head_on.quantities()[quantity].key);
        slope
    };
    const MEAN: usize = 0;
    const SINGLE: usize = 1;
    const ENERGY: usize = 2;
    const DISPLACEMENT: usize = 3;
    // Heun's method for an undamped spring is the linear map e = 1 + (π/N_c)⁴ N_c/8, of order 3. The first omitted term
    // is smaller by (π/N_c)⁴ N_c/16: 4 % at N_c = 5, negligible from 30 on. The late detection of the touch adds an
    // error of the same order
    let close = |what: &str, slope: diptych::statistics::PowerLaw, order: f64, by: f64| {
        assert!((slope.exponent - order).abs() <= by && slope.error <= by, "{what}: {slope:?}, should be {order}");
    };
    close("Heun, elastic", fitted(1.0, "soft uniform, RK2", MEAN), -3.0, 0.1);
    // Verlet's method conserves the energy of a spring; its error is of order Δt³, because the slope of the force jumps
    // within a step
    close("Verlet, elastic", fitted(1.0, "soft uniform, Verlet", SINGLE), -3.0, 0.15);
    // the force of a dashpot itself jumps at the touch, so that the impulse of a part of a step is missing
    close("Verlet, damped", fitted(0.5, "soft uniform, Verlet", SINGLE), -1.0, 0.1);
    close("Verlet, ledger", fitted(0.9, "soft uniform, Verlet", ENERGY), -2.0, 0.1);
    // with exact instants of touch, the order is that of the Runge-Kutta method. Terms of order 5 are smaller by the
    // factor π/N_c times a number of order one, 3 % at N_c = 100
    close("local", fitted(0.9, "soft local, RK4", SINGLE), -4.0, 0.2);
    // a contact lasts T_c ∝ k_n^(-1/2); with time steps, a collision is detected half a step late on average
    close("stiffness", fitted(0.9, "soft local, RK4, stiffness", DISPLACEMENT), -0.5, 0.001);
    close("hard steps", fitted(0.9, "hard, steps", DISPLACEMENT), 1.0, 0.02);
}

#[test]
fn exact_instants_have_no_error_but_rounding_and_counts_do_not_change() {
    let head_on = head_on(0.9);
    let events = swept(&head_on, "hard, events");
    for point in &events {
        // positions of about 1e-3 m have an error of 1e-19 m, and a diameter is 4e-4 m
        assert!((0..4).all(|quantity| point.error(quantity).is_some_and(|error| error < 1e-14)), "{point:?}");
        assert_eq!(point.counters.events, PHASES as u64);
    }
    let again = swept(&head_on, "soft local, RK4");
    for (a, b) in swept(&head_on, "soft local, RK4").iter().zip(&again) {
        assert_eq!((&a.counters, a.work, &a.errors), (&b.counters, b.work, &b.errors));
        assert_eq!(a.work * PHASES as f64, (a.counters.pair_checks + a.counters.force_evaluations) as f64);
        assert!(a.wall.lowest <= a.wall.median && a.wall.median <= a.wall.highest);
    }
}

#[test]
fn a_wall_is_an_impact_too() {
    let pair = head_on(0.94);
    let contact = Bodies::of_wall(&small(), &pair.surface, None);
    let wall = HeadOn { bodies: (small(), None), contact, duration: 60e-6, ..pair.clone() };
    for name in ["soft uniform, RK2", "soft local, RK4"] {
        let (a, b) = (swept(&pair, name), swept(&wall, name));
        let (a, b) = (at(&a, 10.0).errors[0].unwrap(), at(&b, 10.0).errors[0].unwrap());
        // both are the same oscillator in units of its contact time; only the rounding of coordinates differs
        assert!((a.value - b.value).abs() < 1e-9, "{name}: {a:?} {b:?}");
    }
}

fn made_up(points: &[(usize, f64, f64, f64)]) -> Vec<ChartPoint> {
    let point = |&(method, knob, cost, error): &(usize, f64, f64, f64)| ChartPoint {
        method,
        knob,
        samples: 1,
        wall: CostSpread { median: 1e-3 * cost, lowest: 1e-3 * cost, highest: 1e-3 * cost },
        counters: Counters::default(),
        work: cost,
        errors: vec![Some(PointError { value: 1.0 + error, error: error.abs(), uncertainty: Some(1e-6), range: None })],
        failure: None,
    };
    points.iter().map(point).collect()
}

fn methods() -> Vec<ChartMethod> {
    let method = |name: &str, model| ChartMethod { name: name.into(), model, knob: "N_c", unit: "" };
    vec![method("A", Model::Soft), method("B", Model::Soft), method("C", Model::Hard)]
}

fn quantity(floor: f64) -> ChartQuantity {
    let reference = Estimate::exact(1.0);
    ChartQuantity { key: "error", name: "error of something", axis: "error", reference, unit: "", floor }
}

/// Made-up points of three methods. Method A converges with second order; the sign of its error changes after the
/// first point. Method B has a larger error than the others at every cost. Method C has one point that succeeds and
/// one that fails.
fn example() -> Vec<ChartPoint> {
    let mut points = made_up(&[
        (0, 2.0, 5.0, -0.3),
        (0, 5.0, 10.0, 0.08),
        (0, 10.0, 20.0, 0.02),
        (0, 20.0, 40.0, 0.005),
        (0, 40.0, 80.0, 0.00125),
        (0, 80.0, 160.0, 0.0003125),
        (1, 5.0, 50.0, 0.09),
        (1, 10.0, 100.0, 0.05),
        (2, 1.0, 15.0, 0.03),
        (2, 2.0, 1.0, 0.0),
    ]);
    points[9].errors.clear();
    points[9].failure =
        Some(ChartFailure::Engine(Failure::Escaped { time: 0.5, particle: 3, x: -1.0, y: 0.0, z: 0.0 }));
    points
}

#[test]
fn conclusions_follow_from_the_points() {
    let (methods, quantities, points) = (methods(), vec![quantity(0.0)], example());
    let fits = slopes(&quantities, methods.len(), &points);
    assert_eq!(fits.len(), 1, "B and C have too few points: {fits:?}");
    assert!((fits[0].law.exponent + 2.0).abs() < 1e-12 && fits[0].range.1 == 80.0, "{fits:?}");
    let text = sentences(&methods, &quantities, &points, &fits).join("\n");
    assert!(text.contains("within 1 % the cheapest is A (N_c = 20.0): 40 operations, 40 ms"), "{text}");
    assert!(text.contains("within 0.1 % the cheapest is A (N_c = 80.0): 160 operations"), "{text}");
    assert!(text.contains("Failed: C (N_c = 2.00): escaped."), "{text}");
    // with a floor of 0.5 %, no method can be within 0.1 %, and points near the floor determine no slope
    let noisy = vec![quantity(0.005)];
    let fits = slopes(&noisy, methods.len(), &points);
    assert!(fits.is_empty(), "{fits:?}");
    let text = sentences(&methods, &noisy, &points, &fits).join("\n");
    assert!(text.contains("within 0.1 % nothing can be told, since chance alone moves one run by 0.50 %"), "{text}");
}

#[test]
fn files_hold_every_point_and_failures_stand_on_the_frame_with_their_cause() {
    let (methods, quantities, points) = (methods(), vec![quantity(0.004)], example());
    let fits = slopes(&quantities, methods.len(), &points);
    let provenance = Provenance::default();
    let study = ChartStudy {
        provenance: &provenance,
        reference: "made up",
        setting: "made up",
        methods: &methods,
        quantities: &quantities,
        points: &points,
        slopes: &fits,
        verdicts: &["A is best.".to_string()],
        notes: &[],
    };
    let both = [Model::Soft, Model::Hard];
    // errors below the floor of 0.4 % count as equal: of the points at 80 and 160, only the cheaper one is on the front
    assert_eq!(study.front(0, CostMeasure::Work, &both), [0, 1, 8, 2, 3, 4]);
    assert_eq!(study.front(0, CostMeasure::Wall, &[Model::Hard]), [8]);
    let folder = tempfile::tempdir().unwrap();
    let folder = Folder::create(folder.path(), false).unwrap();
    write_chart(&folder, &study).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let csv = read("chart.csv");
    let rows: Vec<::csv::StringRecord> =
        ::csv::Reader::from_reader(csv.as_bytes()).records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), points.len());
    assert_eq!((&rows[9][24], rows[9][25].contains("outside the domain")), ("escaped", true));
    assert_eq!((&rows[3][19], &rows[3][23], &rows[6][23]), ("0.005", "true", "false"));
    let figure = read("figures/error-operations.svg");
    assert!(figure.contains("failed (colour: method)") && figure.contains("chance") && figure.contains("not beaten"));
    assert!(!figure.contains("NaN") && !figure.contains("inf"));
    let html = read("report.html");
    assert!(html.contains("outside the domain") && html.contains("0.0040"));
    // the name and the mark belong to the cheapest method whose error is within 1 %
    assert!(html.contains("Within 1 % soft spheres win, by A, N_c = 20.00; no hard method gets there for certain."));
    assert!(figure.contains("cheapest within 1 %") && html.matches("Operations: pair checks").count() == 1);
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).unwrap();
    assert_eq!(summary["points"][9]["failure"]["engine"]["escaped"]["particle"], 3);
    let deep = Failure::OverlapTooLarge {
        time: 0.0,
        particle: 0,
        partner: Partner::Wall(0),
        ratio: 1.0,
        limit: 0.5,
        way: None,
    };
    assert_eq!(ChartFailure::Engine(deep).kind(), "overlap_too_large");
    assert_eq!(ChartFailure::Unfinished.kind(), "unfinished");
}

#[test]
fn the_floor_of_a_gas_is_the_scatter_of_its_own_samples() {
    // 100 elastic spheres at 5 %: in a time t, the collision rate of N spheres varies by chance by about
    // 1/sqrt(collisions)
    let scene = crate::support::empty([4e-3, 4e-3, 4e-3], [true; 3], small(), surface(1.0, 0.0));
    let mut base = experiment(scene, 100, [0.0; 3], 0.5, Model::Hard, 7);
    base.run.duration = 0.2;
    base.statistics.slices = 1;
    let crowd = Crowd::new(Stretch::of(&base, false).unwrap(), &mut Outlook::new(None)).unwrap();
    let quantities = crowd.quantities();
    let rate = quantities.iter().find(|quantity| quantity.key == "collision_rate").unwrap();
    let collisions = rate.reference.value * crowd.stretch.experiment.run.duration;
    let poisson = (1.0 / collisions).sqrt();
    println!("floor {:.4}, 1/sqrt(collisions) {poisson:.4}", rate.floor);
    // The standard deviation of eight samples is known to about a quarter. Collisions of hard spheres vary less than
    // independent events. They also vary because the energy of each start differs by chance: sqrt(2/300) in T, half of
    // this in the rate
    let starts = (poisson * poisson + (0.5 * (2.0f64 / 300.0).sqrt()).powi(2)).sqrt();
    assert!((0.4 * starts..2.0 * starts).contains(&rate.floor), "{} {starts}", rate.floor);
    let scatter = rate.reference.error.unwrap() * (STARTS as f64).sqrt() / rate.reference.value;
    assert!((rate.floor / scatter - (1.0 + 1.0 / STARTS as f64).sqrt()).abs() < 1e-12);
    // soft spheres with a thousandth of the stiffness collide less often, or their overlap becomes too large
    let results = measure(&base, None, true, &mut Outlook::new(None)).unwrap();
    assert!(results.points.iter().filter(|point| point.failure.is_none()).all(|point| point.work > 0.0));
    let name = |point: &ChartPoint| results.methods[point.method].name.as_str();
    let sunk = results.points.iter().find(|point| name(point) == "soft local, RK4, stiffness" && point.knob < 1.0);
    assert!(sunk.unwrap().failure.is_some(), "{sunk:?}");
}

/// Message that runs of a chart of the case `path` are too short for error bars, and the `--set` arguments that the
/// message recommends. `None` if they are long enough.
fn shortfall(path: &str, set: &[String]) -> Option<(String, Vec<String>)> {
    let case = Case::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path), set).unwrap();
    let (base, _) = case.experiment(None, None).unwrap();
    let text = Stretch::of(&base, true).unwrap().shortfall(&base, true)?;
    let sets = text.split("--set ").skip(1).map(|rest| rest.split('"').take(2).collect::<Vec<_>>().join("\""));
    let sets = sets.map(|set| set + "\"").collect();
    Some((text, sets))
}

#[test]
fn a_stretch_too_short_for_error_bars_names_the_shortest_that_will_do() {
    // without a gas, the window is a part of the duration, so that a longer duration alone is not enough; with a gas,
    // drag determines the windows
    let driven = ["run.duration=\"1.51 s\"".to_owned()];
    for (path, set, windows) in [("cases/glass-beads.toml", &[][..], true), ("cases/quick.toml", &driven[..], false)] {
        let (text, named) = shortfall(path, set).unwrap();
        assert_eq!(named.iter().any(|set| set.starts_with("run.window")), windows, "{text}");
        assert!(named[0].starts_with("run.duration"), "{text}");
        assert_eq!(text.contains("no --quick"), windows, "{text}");
        assert!(shortfall(path, &named).is_none(), "{text}");
        // the recommended duration has three digits; a duration smaller by one in the last digit is too short
        let duration: f64 = named[0].split(['"', ' ']).nth(1).unwrap().parse().unwrap();
        let mut shorter = named.clone();
        shorter[0] = format!("run.duration={} s", duration - 10f64.powi(duration.log10().floor() as i32 - 2));
        assert!(shortfall(path, &shorter).is_some(), "{text}");
        // no window in the chart is longer than possible, and every run in the chart has enough samples
        let (base, _) = Case::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path), &named)
            .and_then(|case| case.experiment(None, None))
            .unwrap();
        let stretch = Stretch::of(&base, true).unwrap();
        for sweep in stretch.sweeps(true) {
            for &value in &sweep.values {
                let run = stretch.run_of(&sweep, value);
                let schedule = diptych::schedule::Schedule::new(&run);
                assert!(schedule.samples >= 8, "{} {value}: {schedule:?}", sweep.name);
            }
        }
    }
    assert!(shortfall("cases/quick.toml", &[]).is_none());
}

#[test]
fn the_command_tells_what_it_will_take_and_what_the_averaging_is_too_short_for() {
    let keep = tempfile::tempdir().unwrap();
    let out = keep.path().join("chart");
    let run = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_diptych"));
        command.current_dir(env!("CARGO_MANIFEST_DIR")).args(["chart", "cases/glass-beads.toml", "--quick", "--out"]);
        let output = command.arg(&out).args(more).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let told = run(&[]);
    let lines: Vec<&str> = told.lines().collect();
    assert!(lines[0].starts_with("Too short") && lines[1].contains(" runs, "), "{told}");
    // the number of runs announced in these two lines is the number of lines that follow
    let runs: usize = lines[1].split(' ').next().unwrap().parse().unwrap();
    assert_eq!(lines.len(), 2 + runs, "{told}");
    assert!(std::fs::read_to_string(out.join("report.html")).unwrap().contains("Too short"));
    assert!(run(&["--overwrite", "--quiet"]).is_empty());
}

#[test]
fn the_command_charts_the_case_of_one_impact() {
    let keep = tempfile::tempdir().unwrap();
    let out = keep.path().join("chart");
    let run = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_diptych"))
            .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")))
            .args(arguments)
            .output()
            .unwrap()
    };
    let folder = out.to_str().unwrap();
    let output = run(&["chart", "cases/impact.toml", "--quick", "--set", "contact.restitution=0.94", "--out", folder]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.trim_start().starts_with("quantity") && text.contains("0.1 %") && text.contains("report.html"),
        "{text}"
    );
    let csv = std::fs::read_to_string(out.join("chart.csv")).unwrap();
    let rows: Vec<::csv::StringRecord> =
        ::csv::Reader::from_reader(csv.as_bytes()).records().map(Result::unwrap).collect();
    let wanted = ["soft uniform, RK2", "N_c", "10"];
    let row = rows.iter().find(|row| (0..3).all(|k| row[k] == *wanted[k]) && &row[12] == "restitution_mean").unwrap();
    // as above: 0.94857 for Heun at N_c = 10
    assert!((row[14].parse::<f64>().unwrap() - 0.94857).abs() < 0.002, "{row:?}");
    // refusals have exit code 2, and write nothing
    for set in ["run.duration=5 us", "particles[0].at[0].velocity=[0.0, 0.0, -3.0]"] {
        let folder = keep.path().join("refused");
        let output = run(&["chart", "cases/impact.toml", "--set", set, "--out", folder.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2), "{set}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(!folder.exists() && String::from_utf8_lossy(&output.stderr).contains("help:"));
    }
}
