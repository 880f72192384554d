//! Verdict of a comparison: rates of wrong verdicts, smallest differences that are found, and answers for all kinds of
//! scenes.

use crate::support::{diptych, words};
use diptych::case::Case;
use diptych::observe::{Observer, Row};
use diptych::outcome::Outcome;
use diptych::output::Basis;
use diptych::placement::initial_state;
use diptych::simulation::Simulation;
use diptych::statistics::{Answer, Batches, Comparison, ErrorLevels, Observable, Parity, compare, holm};
use diptych::study::{execute, judge};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde_json::Value;
use std::borrow::Cow;
use std::path::Path;

const SLICES: usize = 20;
/// Number of samples (measured values) of a run: 24 blocks of 20.
const SAMPLES: usize = 480;

/// Random series with variance 1. Its correlation falls by the factor e in `relaxation` samples.
fn noise(relaxation: f64, random: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    let rho = if relaxation > 0.0 { (-1.0 / relaxation).exp() } else { 0.0 };
    let mut slow: f64 = StandardNormal.sample(random);
    let mut next = || {
        let kick: f64 = StandardNormal.sample(random);
        let later = rho * slow + (1.0 - rho * rho).sqrt() * kick;
        std::mem::replace(&mut slow, later)
    };
    (0..SAMPLES).map(|_| next()).collect()
}

/// Shape of the difference between two systems, as a function of a position y from -1 to 1.
type Shape = fn(f64) -> f64;

const NOTHING: Shape = |_| 0.0;
const SHAPES: [(&str, Shape); 3] =
    [("uniform", |_| 1.0), ("slope", |y| 1.0 - 2.0 * y.abs()), ("wall", |y| f64::from(u8::from(y.abs() > 0.9)))];

/// Six profiles with mean 10, and two numbers. A profile fluctuates as a whole, and each slice by itself with 0.3 of
/// the relaxation time. The first profile is shifted by `size` times `shape`.
fn run(relaxation: f64, size: f64, shape: Shape, random: &mut Xoshiro256PlusPlus) -> Vec<Observable> {
    let y: Vec<f64> = (0..SLICES).map(|k| (2 * k + 1) as f64 / SLICES as f64 - 1.0).collect();
    let of = |name, places, parity, parts| Observable {
        name: Cow::Borrowed(name),
        unit: "",
        places,
        parity,
        fixed_mean: false,
        scale: 10.0,
        scale_is: "10",
        parts,
    };
    let mut all = Vec::new();
    for name in ["number_density_ratio", "U", "uu", "vv", "ww", "uv"] {
        let common = noise(relaxation, random);
        let part = |&y: &f64| {
            let shift = 10.0 + if all.is_empty() { size * shape(y) } else { 0.0 };
            let own = noise(0.3 * relaxation, random);
            let samples: Vec<f64> = common.iter().zip(&own).map(|(common, own)| shift + 0.5 * common + own).collect();
            Batches::of_series(&samples, 1.0, 0.0)
        };
        let parts = y.iter().map(part).collect();
        let parity = if name == "uv" { Parity::Odd } else { Parity::Even };
        all.push(of(name, y.clone(), parity, parts));
    }
    for name in ["granular temperature", "pair impacts per time"] {
        let parts = vec![Batches::of_series(&noise(relaxation, random), 1.0, 0.0)];
        all.push(of(name, Vec::new(), Parity::Even, parts));
    }
    all
}

/// Comparisons of many pairs of invented runs. One run of each pair is shifted by `size` times `shape`.
fn comparisons(pairs: u64, relaxation: f64, size: f64, shape: Shape) -> Vec<Comparison> {
    let one = |pair: u64| {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1000 * pair + relaxation as u64);
        let shifted = run(relaxation, size, shape, &mut random);
        compare(&shifted, &run(relaxation, 0.0, NOTHING, &mut random), 0.01, ErrorLevels::default())
    };
    (0..pairs).into_par_iter().map(one).collect()
}

fn share(comparisons: &[Comparison], of: impl Fn(&Comparison) -> bool) -> f64 {
    comparisons.iter().filter(|one| of(one)).count() as f64 / comparisons.len() as f64
}

fn found(comparison: &Comparison) -> bool {
    !comparison.detected().is_empty()
}

/// Mean standard errors of the first profile in comparisons of equal systems: of its mean, and of its most significant
/// slice.
fn errors(equal: &[Comparison]) -> [f64; 2] {
    let mean = |of: &dyn Fn(&Comparison) -> f64| equal.iter().map(of).sum::<f64>() / equal.len() as f64;
    [mean(&|one| one.judged[0].tested.mean.unwrap().error), mean(&|one| one.judged[0].tested.largest.unwrap().error)]
}

#[test]
fn equal_systems_are_seldom_called_different_and_a_shift_is_found() {
    // relaxation times of 0, 1 % and 3 % of the run
    let mut wrong = 0.0;
    for relaxation in [0.0, 4.8, 16.0] {
        let equal = comparisons(300, relaxation, 0.0, NOTHING);
        let false_findings = share(&equal, found);
        wrong += false_findings * 300.0;
        let [mean, slice] = errors(&equal);
        for ((name, shape), unit) in SHAPES.into_iter().zip([mean, mean, slice]) {
            // a shift of 6 standard errors; docs/theory/statistics.md lists the differences that are found in 80 % of
            // cases
            let power = share(&comparisons(50, relaxation, 6.0 * unit, shape), found);
            println!("relaxation {relaxation}: {false_findings:.3} false; {name} of 6 SE found in {power:.2}");
            assert!(power >= 0.7, "{name}: {power}");
        }
    }
    // 1 % of 900 is 9, with a standard deviation of 3
    assert!(wrong <= 18.0, "{wrong} of 900 equal pairs are called different");
}

#[test]
fn equivalence_is_seldom_claimed_at_the_margin_and_often_of_equal_systems() {
    // The margin of 1 % of 10 is 0.1. With white noise, the mean of the channel has the standard error 0.035, too large
    // for equivalence within 0.1 in every slice. With a tenth of the noise, this corresponds to a margin of 10 %
    let claimed = |size: f64| {
        let one = |pair: u64| {
            let mut random = Xoshiro256PlusPlus::seed_from_u64(pair);
            let shifted = run(4.8, size, |_| 1.0, &mut random);
            let comparison = compare(&shifted, &run(4.8, 0.0, NOTHING, &mut random), 0.06, ErrorLevels::default());
            comparison.judged[0].answer == Answer::Equivalent
        };
        (0..300_u64).into_par_iter().filter(|pair| one(*pair)).count()
    };
    let [edge, none] = [0.6, 0.0].map(claimed);
    println!("equivalent: {edge} of 300 at the margin, {none} of 300 without a difference");
    // 5 % of 300 is 15, with a standard deviation of 4
    assert!(edge <= 27 && none >= 200, "{edge} {none}");
}

#[test]
fn holm_goes_from_the_smallest_chance_up() {
    assert_eq!(holm(&[0.004, 0.5, 0.002], 0.01), [true, false, true]);
    assert_eq!(holm(&[0.006, 0.5, 0.002], 0.01), [false, false, true]);
    // the first probability above its bound ends the procedure
    assert_eq!(holm(&[0.004, 0.004, 0.004], 0.01), [false; 3]);
    assert!(holm(&[], 0.01).is_empty());
}

/// Prints the table of docs/theory/statistics.md: smallest differences that are found in 80 % of cases.
#[test]
#[ignore = "a minute of synthetic runs: cargo test -- --ignored --nocapture power_of_the_verdict"]
fn power_of_the_verdict() {
    for relaxation in [0.0, 4.8, 16.0, 32.0] {
        let equal = comparisons(2000, relaxation, 0.0, NOTHING);
        let [mean, slice] = errors(&equal);
        print!("relaxation {:4.1} % of the run: {:.2} % false", relaxation / 4.8, 100.0 * share(&equal, found));
        for ((name, shape), unit) in SHAPES.into_iter().zip([mean, mean, slice]) {
            let power =
                |tenths: &u32| share(&comparisons(300, relaxation, 0.1 * f64::from(*tenths) * unit, shape), found);
            let sizes: Vec<u32> = (15..=90).step_by(3).collect();
            let least = sizes.iter().find(|tenths| power(tenths) >= 0.8);
            print!("; {name} {:.1} SE", least.map_or(f64::NAN, |tenths| 0.1 * f64::from(*tenths)));
        }
        let said = equal.iter().map(|one| one.judged[0].detectable * 10.0 / mean).sum::<f64>() / equal.len() as f64;
        println!("; said to be found: {said:.1} SE");
    }
}

/// Outcome of a channel with 71 particles, for one seed.
fn small_channel(seed: u64) -> Outcome {
    let sets = [
        "domain.size=[\"4.2 mm\", \"40 mm\", \"6 mm\"]",
        "particles[0].volume_fraction=2.5e-3",
        "run.duration=3 s",
        "run.average_from=0.4 s",
        "statistics.slices=10",
    ]
    .map(String::from);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/channel-d.toml");
    let (mut experiment, _) = Case::read(&path, &sets).unwrap().experiment(None, Some(seed)).unwrap();
    experiment.name = format!("seed {seed}");
    let (mut outcome, _) = execute(&experiment, initial_state(&experiment).unwrap(), &mut []);
    outcome.series.rows.clear();
    outcome
}

/// Compares the variants of a case of the project. Returns the exit code, the first line and the summary.
fn compared(name: &str, arguments: &[&str]) -> (Option<i32>, String, Value) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    let common = ["compare", case.to_str().unwrap(), "--exit-code", "--out", out.to_str().unwrap()];
    let output = diptych(&[&common[..], arguments].concat()).output().unwrap();
    let said = words(&output.stdout);
    let first = said.lines().next().unwrap_or_default().to_owned();
    let summary =
        std::fs::read_to_string(out.join("summary.json")).unwrap_or_else(|_| panic!("{}", words(&output.stderr)));
    (output.status.code(), first, serde_json::from_str(&summary).unwrap())
}

#[test]
fn the_cradle_is_different_and_the_report_says_by_how_much() {
    let (code, first, summary) = compared("cases/cradle.toml", &[]);
    assert_eq!((code, summary["verdict"].as_str()), (Some(3), Some("different")), "{first}");
    // touching spheres: the fourth sphere gets 0.2962 m/s of 1 m/s
    assert!(
        first.starts_with(
            "\"soft\" against \"hard\": different: the paths are apart by at most 0.296 m/s, 30 % of the largest speed"
        ),
        "{first}"
    );
    let comparison = &summary["comparisons"][0];
    assert_eq!((comparison["basis"].as_str(), comparison["verdict"].as_str()), (Some("paths"), Some("different")));
    assert_eq!(summary["variants"][0]["verdict"].as_str(), Some("different"));
    assert_eq!(summary["variants"][1]["verdict"], Value::Null);
    // statements about the effect of softness in a gas do not apply to five bodies
    let said = format!("{} {}", summary["verdicts"], summary["notes"]);
    assert!(!said.contains("press and crowd") && !said.contains("as if smaller"), "{said}");
}

#[test]
fn what_is_not_steady_is_judged_by_curves_and_needs_replicas() {
    // 308 particles in a smaller box, instead of 2000 particles in the whole box
    let small = ["--set", "domain.size=[\"6 mm\", \"6 mm\", \"6 mm\"]"];
    let (code, first, _) = compared("tests/inputs/good/two_restitutions.toml", &small);
    assert_eq!(code, Some(4), "{first}");
    assert!(first.contains("unresolved") && first.contains("not steady") && first.contains("--replicas"), "{first}");
    let (code, first, summary) =
        compared("tests/inputs/good/two_restitutions.toml", &[&small[..], &["--replicas", "4"]].concat());
    assert_eq!(code, Some(3), "{first}");
    let comparison = &summary["comparisons"][0];
    assert_eq!(comparison["basis"].as_str(), Some("curves"));
    // Haff's law: after 20 ms, T/T0 is 0.07 for e = 0.8 and 0.8 for e = 0.99
    let judged = comparison["comparison"]["judged"].as_array().unwrap();
    let energy = judged.iter().find(|one| one["name"] == "energy").unwrap();
    let share = energy["mean"]["difference"].as_f64().unwrap() / energy["scale"].as_f64().unwrap();
    // the mean of (1 + a t)^-2 over 20 ms is 1/(1 + 20 ms a): 0.28 and 0.89 of the start
    assert!(energy["detected"] == true && (-0.75..-0.45).contains(&share), "{energy}");
    assert_eq!(summary["variants"][0]["averaging"]["replicas"]["count"], 4);
    assert!(summary["variants"][1]["set"].as_str().unwrap().contains("contact.restitution = 0.8"));
    // large differences in a large gas need no replicas: 2000 particles count as 20 groups of a hundred
    let (code, first, _) = compared("tests/inputs/good/two_restitutions.toml", &[]);
    assert_eq!(code, Some(3), "{first}");
    assert!(first.contains("moved as one"), "{first}");
}

#[test]
fn a_scene_at_rest_and_a_run_that_is_too_short_say_so() {
    let still = ["--set", "particles[0].velocity_fluctuation=0 m/s", "--set", "run.duration=1 ms"];
    let (code, first, _) = compared("cases/cooling-gas.toml", &still);
    assert_eq!(code, Some(0), "{first}");
    assert!(first.contains("equivalent: both end in the same state"), "{first}");
    let short =
        ["--set", "run.duration=2 ms", "--set", "run.average_from=1 ms", "--set", "statistics.sample_interval=0.5 ms"];
    let (code, first, _) = compared("cases/cooling-gas.toml", &short);
    assert_eq!(code, Some(4), "{first}");
    assert!(first.contains("too few samples") && first.contains("error bars"), "{first}");
}

#[test]
fn margins_beyond_one_and_replicas_of_placed_particles_are_refused() {
    let output = diptych(&["compare", "cases/cradle.toml", "--margin", "2"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", words(&output.stderr));
    let placed = diptych(&["compare", "cases/cradle.toml", "--replicas", "3"]).output().unwrap();
    assert_eq!(placed.status.code(), Some(2));
    assert!(words(&placed.stderr).contains("would be the same run"), "{}", words(&placed.stderr));
}

#[test]
fn a_bed_of_three_particles_is_judged_by_paths() {
    let (code, first, summary) = compared("tests/inputs/good/three_particles.toml", &[]);
    assert_eq!(summary["comparisons"][0]["basis"].as_str(), Some("paths"), "{first}");
    // soft contacts of 7 µs delay the paths by 7 µm at 1 m/s, less than 1 % of the distance of 4 mm
    assert_eq!(code, Some(0), "{first}");
    assert!(first.contains("equivalent within 1 %: the paths are apart by"), "{first}");
}

#[test]
fn paths_are_compared_in_velocity_and_place_where_nothing_touches() {
    const THREE: &str = "tests/inputs/good/three_particles.toml";
    let soft = ["--set", "soft.linear_spring_dashpot.stiffness=30 N/m"];
    // two contacts of 77 µs each delay the last of three spheres by 2 % of its path; its final velocity is equal
    let (code, first, _) = compared(THREE, &soft);
    assert_eq!(code, Some(3), "{first}");
    assert!(first.contains("0.057 % of the largest speed") && first.contains("0.19 diameters in place"), "{first}");
    // the run ends during the first contact, which begins at 594 µs
    let (code, first, _) = compared(THREE, &[&soft[..], &["--set", "run.duration=0.63 ms"]].concat());
    assert_eq!(code, Some(0), "{first}");
    assert!(first.contains("0 diameters in place"), "{first}");
    // different starts lead to different paths
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("starts.toml");
    let variants = "\n[[compare]]\nname = \"hard\"\nmodel = \"hard\"\n\n[[compare]]\nname = \"slower\"\nmodel = \"hard\"\n\
                    set = { \"particles[0].at[0].velocity\" = [\"0.5 m/s\", \"0 m/s\", \"0 m/s\"] }\n";
    let three = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(THREE)).unwrap();
    std::fs::write(&path, three + variants).unwrap();
    let (code, first, _) = compared(path.to_str().unwrap(), &[]);
    assert_eq!(code, Some(4), "{first}");
    assert!(first.contains("do not start from the same state"), "{first}");
}

/// A ball that slides on a floor touches it at every instant. Its path must be compared all the same, and not left out
/// as during an impact.
#[test]
fn paths_of_bodies_that_touch_all_the_time_are_compared() {
    let (code, first, summary) = compared("cases/rotation/slide-to-roll.toml", &[]);
    assert_eq!(code, Some(3), "{first}");
    let answers: Vec<&str> =
        summary["comparisons"].as_array().unwrap().iter().filter_map(|one| one["verdict"].as_str()).collect();
    assert_eq!(answers, ["equivalent", "different"], "{first}");
}

#[test]
fn paths_that_cannot_be_foretold_are_not_compared() {
    const GAS: &str = "cases/cooling-gas.toml";
    // a gas of inelastic spheres is not steady, so that only paths can be compared
    let few = ["--set", "particles[0].count=20"];
    let (_, first, summary) = compared(GAS, &few);
    assert_eq!(summary["comparisons"][0]["basis"].as_str(), Some("paths"), "{first}");
    assert!(first.contains("up to t = 11.1 ms, the last instant before a disturbance of 10⁻⁶ has grown"), "{first}");
    // a gas of elastic spheres is steady; averages are compared, because paths soon become unpredictable
    let elastic = ["--set", "contact.restitution=1", "--set", "run.duration=200 ms"];
    let (_, first, summary) = compared(GAS, &[&few[..], &elastic].concat());
    assert_eq!(summary["comparisons"][0]["basis"].as_str(), Some("averages"), "{first}");
}

#[test]
fn what_is_compared_depends_on_the_scene_and_ends_with_the_shorter_run() {
    let names =
        |comparison: &Comparison| comparison.judged.iter().map(|one| one.tested.name.to_string()).collect::<Vec<_>>();
    let (_, _, summary) = compared(
        "cases/cooling-gas.toml",
        &[
            "--set",
            "contact.restitution=1",
            "--set",
            "particles[0].volume_fraction=0.01",
            "--set",
            "run.duration=60 ms",
        ],
    );
    let judged = summary["comparisons"][0]["comparison"]["judged"].as_array().unwrap();
    let of_a_gas: Vec<&str> = judged.iter().filter_map(|one| one["name"].as_str()).collect();
    assert_eq!(of_a_gas, ["uu", "vv", "ww", "granular temperature", "pair impacts per time"]);
    let mut pair = [1, 2].map(small_channel);
    pair.iter_mut().for_each(|one| one.steadiness.steady = true);
    let whole = judge(&pair, &[], 0.01)[0].comparison.clone().unwrap();
    let all = ["number_density_ratio", "U", "uu", "vv", "ww", "uv"];
    let numbers = ["granular temperature", "pair impacts per time", "wall impacts per time"];
    assert_eq!(names(&whole), [&all[..], &numbers].concat());
    // the scale of n is 1; that of U is the mean slip speed, which is near the terminal velocity of 1.5 m/s, and larger
    // near the walls
    assert_eq!(whole.judged[0].tested.scale, 1.0);
    assert!((1.0..3.0).contains(&whole.judged[1].tested.scale), "{}", whole.judged[1].tested.scale);
    // the first variant is the reference; a variant that stops half-way is compared with the first half of the other
    // variant
    pair[0].profiles.until = 1.7;
    let half = judge(&pair, &[], 0.01)[0].comparison.clone().unwrap();
    let temperature = |comparison: &Comparison| comparison.judged[6].tested.mean.unwrap().difference;
    let blocks = |one: &Outcome| one.averaged.temperature.as_ref().unwrap().until(1.7).values[0];
    assert!((temperature(&half) - (blocks(&pair[1]) - blocks(&pair[0]))).abs() < 1e-12);
    assert!(temperature(&half) != temperature(&whole));
}

/// Observer that stops a run at a time [s].
struct Stop(f64, bool);

impl Observer for Stop {
    fn see(&mut self, simulation: &Simulation) {
        self.1 = simulation.time >= self.0 * (1.0 - 1e-9);
    }

    fn stop(&self) -> Option<String> {
        self.1.then(|| "as the test wants it".into())
    }
}

/// Outcomes of a case for several seeds. Each run ends at the time `until` [s] at the latest.
fn runs(case: &str, sets: &[&str], name: &str, seeds: std::ops::Range<u64>, until: f64) -> Vec<Outcome> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(case);
    let read = Case::read(&path, &sets).unwrap();
    let one = |seed: u64| {
        let (mut experiment, _) = read.experiment(None, Some(seed)).unwrap();
        experiment.name = name.into();
        let start = initial_state(&experiment).unwrap();
        execute(&experiment, start, &mut [&mut Stop(until, false)]).0
    };
    seeds.into_par_iter().map(one).collect()
}

#[test]
fn a_variant_that_stopped_is_compared_over_the_common_time() {
    // a cooling gas that is stopped half-way is warmer than at its end, which must not count as a difference
    let small = "domain.size=[\"5 mm\", \"5 mm\", \"5 mm\"]";
    let case = "cases/cooling-gas.toml";
    let whole = runs(case, &[small], "whole", 1..6, 1.0);
    let cut = runs(case, &[small], "cut", 11..16, 10e-3);
    let lossy = runs(case, &[small, "contact.restitution=0.6"], "lossy", 21..26, 10e-3);
    let judged = |runs: &[Outcome]| {
        let pair = [runs[0].clone(), whole[0].clone()];
        judge(&pair, &[runs[1..].to_vec(), whole[1..].to_vec()], 0.05).remove(0)
    };
    let ends = |run: &Outcome| run.profiles.until;
    assert!(cut.iter().all(|run| run.failure.is_some() && run.simulated_seconds < 11e-3) && ends(&whole[0]) > 19e-3);
    for (runs, different) in [(&cut, false), (&lossy, true)] {
        let verdict = judged(runs);
        assert_eq!(
            (verdict.basis, verdict.answer == Answer::Different),
            (Basis::Curves, different),
            "{}",
            verdict.sentence
        );
        let times = verdict.comparison.unwrap().judged.into_iter().filter_map(|one| one.tested.largest?.place);
        assert!(times.fold(0.0, f64::max) < 10.5e-3);
        let further = verdict.further.join(" ");
        assert!(further.contains("stopped after 10") && further.contains("compared up to there"), "{further}");
        assert!(!further.contains("wall time"), "a part of a run has a cost: {further}");
    }
}

#[test]
fn replicas_of_a_steady_flow_have_smaller_errors_that_the_runs_agree_with() {
    let small = [
        "--set",
        "domain.size=[\"4.2 mm\", \"40 mm\", \"6 mm\"]",
        "--set",
        "particles[0].volume_fraction=2.5e-3",
        "--set",
        "run.duration=3 s",
        "--set",
        "run.average_from=0.4 s",
        "--set",
        "statistics.slices=10",
    ];
    let errors = |replicas: &str| {
        let (_, first, summary) = compared("cases/channel-d.toml", &[&small[..], &["--replicas", replicas]].concat());
        let comparison = &summary["comparisons"][0];
        assert_eq!(comparison["basis"].as_str(), Some("averages"), "{first}");
        assert_ne!(comparison["verdict"].as_str(), Some("different"), "{first}");
        let judged = comparison["comparison"]["judged"].as_array().unwrap().clone();
        let of = |name: &str| judged.iter().find(|one| one["name"] == name).unwrap()["mean"]["error"].as_f64().unwrap();
        (["U", "granular temperature", "pair impacts per time"].map(of), summary)
    };
    let (one, _) = errors("1");
    let (nine, summary) = errors("9");
    // the standard error should be a third; but an error from 20 blocks is uncertain by a fifth, and an error from nine
    // runs by a quarter
    for (one, nine) in one.iter().zip(nine) {
        assert!((1.5..6.0).contains(&(one / nine)), "{one} {nine}");
    }
    let replicas = &summary["variants"][1]["averaging"]["replicas"];
    let ratio = replicas["scatter_over_errors"].as_f64().unwrap();
    assert!(replicas["count"] == 9 && (0.5..2.0).contains(&ratio), "{replicas}");
}

/// Prints the number of particles that move together, from the variation of the granular temperature T between seeds.
/// For N independent particles, the relative variance of T is 2/(3 N).
#[test]
#[ignore = "runs from many seeds: cargo test -- --ignored --nocapture scatter_of_single_runs"]
fn scatter_of_single_runs_of_transients() {
    let scenes: [(&str, &str, &[&str]); 5] = [
        ("cooling, e = 0.9", "cases/cooling-gas.toml", &["particles[0].volume_fraction=0.02"]),
        ("cooling, e = 0.6", "cases/cooling-gas.toml", &["contact.restitution=0.6", "run.duration=100 ms"]),
        ("cooling, e = 0.9, denser", "cases/cooling-gas.toml", &["particles[0].volume_fraction=0.2"]),
        ("beads in air", "cases/beads-in-air.toml", &[]),
        (
            "beads in air, 800",
            "cases/beads-in-air.toml",
            &["domain.size[0]=60 mm", "domain.size[2]=60 mm", "particles[0].count=800"],
        ),
    ];
    for (name, case, sets) in scenes {
        let runs = runs(case, sets, name, 1..31, f64::INFINITY);
        let particles = runs[0].particles as f64;
        let count = runs[0].series.rows.len();
        print!("{name}, {particles} particles:");
        for place in [count / 8, count / 4, count / 2, count - 1] {
            let of: [fn(&Row) -> f64; 2] =
                [|row| row.granular_temperature().unwrap(), |row| row.kinetic_energy + row.elastic_energy];
            let clump = of.map(|of| {
                let values: Vec<f64> = runs.iter().map(|run| of(&run.series.rows[place])).collect();
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64;
                square / (mean * mean) / (2.0 / (3.0 * particles))
            });
            let time = runs[0].series.rows[place].time;
            print!(" t = {:.0} ms: {:.1} in T, {:.1} in energy;", 1e3 * time, clump[0], clump[1]);
            // the rule for a single run assumes 100 particles
            assert!(clump.iter().all(|clump| *clump < 50.0), "{name}: {clump:?}");
        }
        println!();
    }
}
