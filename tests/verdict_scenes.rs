//! Verdicts on scenes that are not steady or do not mix, that stop, or whose variants are sampled at different times.

use crate::support::{diptych, words};
use diptych::case::Case;
use diptych::engine::Failure;
use diptych::outcome::Outcome;
use diptych::output::Basis;
use diptych::placement::initial_state;
use diptych::statistics::Answer;
use diptych::study::{execute, judge, pool};
use serde_json::Value;
use std::path::Path;

const BED: &str = "tests/inputs/verdict/bed.toml";
const GAS: &str = "tests/inputs/verdict/gas.toml";
const MIXTURE: &str = "tests/inputs/verdict/mixture.toml";

fn run(case: &str, sets: &[&str], seed: u64) -> Outcome {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(case);
    let (mut experiment, _) = Case::read(&path, &sets).unwrap().experiment(None, Some(seed)).unwrap();
    experiment.name = format!("seed {seed}");
    execute(&experiment, initial_state(&experiment).unwrap(), &mut []).0
}

/// Compares a case to which the text `variants` is appended. Returns the exit code and the summary.
fn compared(case: &str, variants: &str, arguments: &[&str]) -> (Option<i32>, Value) {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(case)).unwrap();
    let path = folder.path().join("case.toml");
    std::fs::write(&path, text + variants).unwrap();
    let out = folder.path().join("out");
    let head = ["compare", path.to_str().unwrap(), "--out", out.to_str().unwrap(), "--exit-code"];
    let output = diptych(&head).args(arguments).output().unwrap();
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap_or_else(|_| words(&output.stderr));
    (output.status.code(), serde_json::from_str(&summary).unwrap())
}

fn sentence(summary: &Value) -> String {
    summary["comparisons"][0]["sentence"].as_str().unwrap().to_owned()
}

const SEEDS: &str = "
[[compare]]
name = \"one\"
[[compare]]
name = \"other\"
set = { \"run.seed\" = 1001 }
against = \"one\"
";

#[test]
fn a_bed_at_rest_says_nothing_of_other_beds_unless_there_are_replicas() {
    let (code, summary) = compared(BED, SEEDS, &["--set", "run.duration=0.4 s", "--set", "run.average_from=0.3 s"]);
    assert_eq!(code, Some(4), "{}", sentence(&summary));
    assert!(sentence(&summary).contains("of the particles are in the same layer"), "{}", sentence(&summary));
    let beds = [1, 2].map(|seed| run(BED, &["run.duration=0.4 s", "run.average_from=0.3 s"], seed));
    for bed in beds {
        assert!(bed.places_kept.unwrap() > 0.5 && bed.steadiness.steady, "{:?} {:?}", bed.places_kept, bed.steadiness);
    }
    let gas = run(GAS, &[], 1);
    assert!(gas.places_kept.unwrap() < 0.2 && gas.steadiness.steady, "{:?} {:?}", gas.places_kept, gas.steadiness);
}

#[test]
fn what_relaxes_in_any_way_is_not_steady() {
    let unsteady = |case: &str, sets: &[&str]| {
        let steadiness = run(case, sets, 1).steadiness;
        assert!(!steadiness.steady, "{case} {sets:?}: {steadiness:?}");
    };
    unsteady(BED, &["run.average_from=0 s"]);
    unsteady(BED, &["run.duration=0.05 s"]);
    unsteady(GAS, &["contact.restitution=0.9"]);
    // a fall along y, without walls and without agitation
    let fall = ["gravity.acceleration=[\"0 m/s^2\", \"-9.81 m/s^2\", \"0 m/s^2\"]", "run.duration=20 ms"];
    unsteady(GAS, &[&fall[..], &["particles[0].velocity_fluctuation=0 m/s"]].concat());
    unsteady("cases/anisotropy.toml", &[]);
}

#[test]
fn species_of_a_mixture_are_compared() {
    let denser = "
[[compare]]
name = \"as light\"
set = { \"particles[1].density\" = \"1000 kg/m^3\", \"particles[1].velocity_fluctuation\" = \"1 m/s\" }
[[compare]]
name = \"heavy\"
against = \"as light\"
";
    let (code, summary) = compared(MIXTURE, denser, &["--margin", "8%", "--set", "run.duration=400 ms"]);
    assert_eq!(code, Some(3), "{}", sentence(&summary));
    // a heavy sphere is slow: its impact rate is smaller by a factor of about sqrt(21/40), the ratio of mean relative
    // speeds
    assert!(sentence(&summary).contains("in impacts per time of heavy"), "{}", sentence(&summary));
    let judged = summary["comparisons"][0]["comparison"]["judged"].as_array().unwrap();
    let rate = judged.iter().find(|one| one["name"] == "impacts per time of heavy").unwrap();
    let [difference, error] = ["difference", "error"].map(|key| rate["mean"][key].as_f64().unwrap());
    let [share, error] = [difference, error].map(|value| value / rate["scale"].as_f64().unwrap());
    let expected = (21.0_f64 / 40.0).sqrt() - 1.0;
    assert!((share - expected).abs() < 4.0 * error, "{share} ± {error}, {expected}");
}

#[test]
fn variants_with_other_windows_are_compared_at_common_instants() {
    let air = "
[fluid]
use = \"fluids/air\"
[fluid.profile.uniform]
velocity = \"0 m/s\"
[drag.stokes]
[[compare]]
name = \"as it is\"
[[compare]]
name = \"thicker\"
set = { \"fluid.kinematic_viscosity\" = \"1.56e-5 m^2/s\" }
against = \"as it is\"
";
    let sets = ["--set", "run.duration=65 ms", "--set", "particles[0].diameter=100 um", "--replicas", "3"];
    let (_, summary) = compared(GAS, air, &sets);
    let judged = summary["comparisons"][0]["comparison"]["judged"].as_array().unwrap();
    let energy = judged.iter().find(|one| one["name"] == "energy").unwrap();
    // both runs have the same start, and their energy falls by exp(-2t/τ), with τ 3 % shorter in one run. The
    // difference is at most 0.37 * 3 % of the initial energy, at t = τ/2
    let largest = &energy["largest"];
    let share = largest["difference"].as_f64().unwrap() / energy["scale"].as_f64().unwrap();
    assert!(share < 0.0 && share > -0.0115, "{share} at {}", largest["place"]);
}

#[test]
fn replicas_that_stopped_are_left_out_and_what_stopped_is_never_equivalent() {
    let runs: Vec<Outcome> =
        (1..=6).map(|seed| run(GAS, &["contact.restitution=0.9", "run.duration=20 ms"], seed)).collect();
    let mut stopped = runs[1].clone();
    stopped.failure = Some(Failure::Stopped { time: 0.01 });
    stopped.series.rows.truncate(10);
    let (pooled, rest) = pool(runs[0].clone(), vec![stopped.clone(), runs[2].clone()]);
    assert!(pooled.failure.is_some() && rest.len() == 1 && rest[0].final_state_hash == runs[2].final_state_hash);
    let mean = |of: fn(&Outcome) -> f64| 0.5 * (of(&runs[0]) + of(&runs[2]));
    let temperature = |one: &Outcome| one.temperature.unwrap().value;
    assert!((temperature(&pooled) - mean(temperature)).abs() < 1e-12);
    // the result does not depend on the order of the runs
    let (pooled, rest) = pool(stopped.clone(), vec![runs[0].clone(), runs[2].clone()]);
    assert!((temperature(&pooled) - mean(temperature)).abs() < 1e-12 && rest.len() == 1);
    let (alone, rest) = pool(stopped.clone(), Vec::new());
    assert!(alone.failure.is_some() && rest.is_empty());
    // three runs against three runs, one of which stopped: the two remaining runs give no errors
    let side = |first: &Outcome, others: Vec<Outcome>| pool(first.clone(), others);
    let (a, others_a) = side(&runs[0], vec![stopped, runs[2].clone()]);
    let (b, others_b) = side(&runs[3], vec![runs[4].clone(), runs[5].clone()]);
    let verdict = judge(&[b, a], &[others_b, others_a], 0.5).remove(0);
    assert_eq!(verdict.basis, Basis::Curves);
    assert_ne!(verdict.answer, Answer::Equivalent, "{}", verdict.sentence);
    assert!(verdict.further.iter().any(|one| one.starts_with("A replica of ")), "{:?}", verdict.further);
}

#[test]
fn paths_that_differ_on_the_way_are_different_even_if_they_meet_at_the_end() {
    // a sphere between two walls: 17 impacts with a spring, 19 instantaneous impacts, and the same final position
    let between = "
[domain]
size = [\"10 mm\", \"20 mm\", \"10 mm\"]
periodic = [\"x\", \"z\"]
[[particles]]
use = \"particles/polystyrene-406um\"
at = [{ position = [\"5 mm\", \"10 mm\", \"5 mm\"], velocity = [\"0 m/s\", \"1 m/s\", \"0 m/s\"] }]
[[walls]]
plane = { point = [\"0 m\", \"5 mm\", \"0 m\"], normal = [0, 1, 0] }
restitution = 1
[[walls]]
plane = { point = [\"0 m\", \"15 mm\", \"0 m\"], normal = [0, -1, 0] }
restitution = 1
[contact]
restitution = 1.0
friction = 0.0
[soft.linear_spring_dashpot]
stiffness = \"0.315907118763325 N/m\"
[soft]
steps_per_contact = 50
[run]
duration = \"186.1236 ms\"
";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("between.toml");
    std::fs::write(&path, between).unwrap();
    let case = Case::read(&path, &[]).unwrap();
    let outcomes: Vec<Outcome> = case
        .variants(None)
        .unwrap()
        .iter()
        .map(|(experiment, _)| execute(experiment, initial_state(experiment).unwrap(), &mut []).0)
        .collect();
    let verdict = judge(&outcomes, &[], 0.01).remove(0);
    assert_eq!((verdict.basis, verdict.answer), (Basis::Paths, Answer::Different), "{}", verdict.sentence);
}

#[test]
fn fifty_bodies_with_replicas_are_judged_by_curves() {
    let other = "
[[compare]]
name = \"e9\"
set = { \"contact.restitution\" = 0.9 }
[[compare]]
name = \"e8\"
set = { \"contact.restitution\" = 0.8 }
against = \"e9\"
";
    let sets = ["--set", "particles[0].count=50", "--set", "run.duration=40 ms"];
    let (code, summary) = compared(GAS, other, &[&sets[..], &["--replicas", "8"]].concat());
    assert_eq!(summary["comparisons"][0]["basis"], "curves");
    assert_eq!(code, Some(4 - i32::from(summary["verdict"] == "different")), "{}", sentence(&summary));
}

#[test]
fn replicas_are_run_until_every_answer_is_given() {
    let other = "
[[compare]]
name = \"e9\"
set = { \"contact.restitution\" = 0.9 }
[[compare]]
name = \"e7\"
set = { \"contact.restitution\" = 0.7 }
against = \"e9\"
[[compare]]
name = \"e9 again\"
set = { \"contact.restitution\" = 0.9, \"run.seed\" = 5001 }
against = \"e9\"
";
    let sets = ["--set", "run.duration=20 ms", "--set", "particles[0].count=200", "--until-decided", "--margin", "30%"];
    let (_, summary) = compared(GAS, other, &sets);
    let answers: Vec<&str> =
        summary["comparisons"].as_array().unwrap().iter().map(|one| one["verdict"].as_str().unwrap()).collect();
    assert_eq!(answers, ["different", "equivalent"], "{}", summary["verdicts"]);
    let looks =
        summary["verdicts"].as_array().unwrap().iter().find(|one| one.as_str().unwrap().starts_with("Judged with"));
    assert!(looks.unwrap().as_str().unwrap().contains("of at most 64 replicas of each"), "{}", summary["verdicts"]);
    // the limit on the number of replicas ends the comparison
    let tight = ["--set", "run.duration=20 ms", "--until-decided", "--replicas", "6", "--margin", "0.1%"];
    let (code, summary) = compared(GAS, SEEDS, &tight);
    assert_eq!(code, Some(4), "{}", summary["verdicts"]);
    assert!(summary["verdicts"].to_string().contains("Judged with 6 of at most 6 replicas of each, at look 2 of 2"));
}

#[test]
fn averages_of_a_sweep_have_no_errors_where_nothing_is_steady() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let arguments =
        ["sweep", GAS, "--sweep", "contact.restitution=0.8,1", "--only", "hard", "--out", out.to_str().unwrap()];
    let output = diptych(&arguments).output().unwrap();
    assert!(output.status.success(), "{}", words(&output.stderr));
    let table = std::fs::read_to_string(out.join("sweep.csv")).unwrap();
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(table.as_bytes());
    let head = reader.headers().unwrap().clone();
    let place = head.iter().position(|name| name == "temperature_m2_s2").unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let errors: Vec<bool> = rows.iter().map(|row| !row[place + 1].is_empty()).collect();
    assert!(rows.iter().all(|row| !row[place].is_empty()), "{table}");
    assert_eq!(errors, [false, true], "{head:?}\n{table}");
}
