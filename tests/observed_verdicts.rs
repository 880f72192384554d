//! Verdicts on the numbers that two steady runs measure because their case has a table `[observe]`: made-up numbers,
//! rates of wrong answers, and rows of a real comparison.

use crate::support::*;
use diptych::observe::{Observation, ObservedNumber, ObservedQuantity};
use diptych::output::ObservedDifference;
use diptych::statistics::{Answer, ErrorLevels, Estimate};
use diptych::study::{Criteria, observed_differences};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde_json::Value;

const ASKED: Criteria = Criteria { margin: 0.01, levels: ErrorLevels { difference: 0.01, equivalence: 0.05 } };

/// Made-up number of a run: the mean of `count` normally distributed values with the given mean and standard
/// deviation.
fn noisy(name: &str, count: usize, [mean, deviation]: [f64; 2], random: &mut Xoshiro256PlusPlus) -> ObservedNumber {
    let mut value = || -> f64 { StandardNormal.sample(random) };
    let samples: Vec<f64> = (0..count).map(|_| mean + deviation * value()).collect();
    ObservedNumber::of_series(ObservedQuantity::new(name, name, "m"), &samples, [0.0, 1.0], None)
}

/// Made-up number of a run with a stated value and standard error.
fn stated(name: &str, value: f64, error: f64) -> ObservedNumber {
    let (quantity, value) = (ObservedQuantity::new(name, name, "m"), Some(Estimate::new(value, error)));
    ObservedNumber { quantity, value, theory: None, batches: None }
}

fn measured(numbers: Vec<ObservedNumber>) -> [Observation; 1] {
    [Observation { name: "made_up", numbers, ..Observation::default() }]
}

/// Differences between the numbers of two runs, with an answer for each.
fn compared(own: Vec<ObservedNumber>, other: Vec<ObservedNumber>) -> Vec<ObservedDifference> {
    observed_differences([&measured(own), &measured(other)], f64::INFINITY, ASKED)
}

#[test]
fn made_up_numbers_get_the_answers_that_they_must_get() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    // standard errors of 400 values are a twentieth of the deviation
    let mut pair = |name: &str, own: [f64; 2], other: [f64; 2], count: usize| {
        [own, other].map(|of| noisy(name, count, of, &mut random))
    };
    let numbers = [
        pair("equal", [-2.0, 0.04], [-2.0, 0.04], 400),
        pair("apart", [2.1, 0.04], [2.0, 0.04], 400),
        pair("seen within", [2.01, 0.01], [2.0, 0.01], 400),
        pair("coarse", [2.0, 1.0], [2.0, 1.0], 400),
        pair("zero", [0.0, 1.0], [0.0, 1.0], 400),
        pair("only the reference is zero", [1.0, 1.0], [0.0, 1.0], 400),
        pair("still", [2.0, 0.0], [3.0, 0.0], 400),
        pair("short", [2.0, 1.0], [2.0, 1.0], 7),
        [stated("exact", 3.0, 0.0), stated("exact", 3.0, 0.0)],
        [stated("stated", 3.1, 0.01), stated("stated", 3.0, 0.01)],
    ];
    let [mut own, mut other]: [Vec<ObservedNumber>; 2] = [0, 1].map(|k| numbers.iter().map(|n| n[k].clone()).collect());
    // without a partner, or without a value, there is no row
    own.push(stated("lonely", 1.0, 0.1));
    other.push(ObservedNumber { value: None, ..stated("unknown", 1.0, 0.1) });
    own.push(stated("unknown", 1.0, 0.1));
    let found = compared(own, other);
    let words: Vec<(&str, &str)> = found.iter().map(|one| (one.quantity.as_str(), one.word())).collect();
    let wanted = [
        ("equal", "equivalent"),
        ("apart", "different"),
        ("seen within", "equivalent"),
        ("coarse", "unresolved"),
        ("zero", "no answer"),
        ("only the reference is zero", "different"),
        ("still", "no answer"),
        ("short", "no answer"),
        ("exact", "equivalent"),
        ("stated", "different"),
    ];
    assert_eq!(words, wanted);
    let of = |name: &str| found.iter().find(|one| one.quantity == name).unwrap();
    let apart = of("apart").percent.unwrap();
    // the standard error of the difference is √2 · 0.04/20 = 2.8e-3, which is 0.14 % of 2; four of them are allowed
    close("per cent", apart.value, 5.0, 4.0 * 0.14);
    close("its error", apart.error.unwrap(), 0.14, 0.05);
    close("sign of a negative number", of("equal").percent.unwrap().value * of("equal").difference.value, 0.0, 0.01);
    assert!(of("seen within").chance.unwrap() < 1e-3, "a difference is seen: {:?}", of("seen within"));
    for name in ["zero", "only the reference is zero"] {
        assert!(of(name).percent.is_none() && of(name).reached.is_none(), "{name}");
        assert!(of(name).remark.contains("zero within its error"), "{name}");
    }
    assert!(of("short").difference.error.is_none() && of("short").remark.contains("too few samples"));
    assert!(of("still").remark.contains("--replicas") && of("still").difference.value == -1.0);
    assert!(of("stated").remark.contains("normal distribution") && of("exact").remark.is_empty());
    assert!(of("coarse").reached.unwrap() > 0.05, "{:?}", of("coarse"));
}

/// Two runs of different lengths are compared up to the end of the shorter one.
#[test]
fn samples_after_the_common_time_do_not_count() {
    let series = |late: f64| {
        let samples: Vec<f64> = (0..400).map(|k| if k < 200 { 2.0 + 0.01 * f64::from(k % 3) } else { late }).collect();
        vec![ObservedNumber::of_series(ObservedQuantity::new("a", "a", "m"), &samples, [0.0, 1.0], None)]
    };
    let [own, other] = [series(5.0), series(2.01)].map(measured);
    let difference = |until: f64| observed_differences([&own, &other], until, ASKED)[0].difference.value;
    // the samples have the times 0, 1, 2, ...
    assert!(difference(199.0).abs() < 1e-12, "{}", difference(199.0));
    close("all", difference(f64::INFINITY), 0.5 * (5.0 - 2.01), 0.02);
    // no block of samples ends so early
    let none = &observed_differences([&own, &other], 0.5, ASKED)[0];
    assert!(none.answer.is_none() && none.remark.contains("too few samples"), "{none:?}");
    assert!(none.difference.value.is_finite(), "{none:?}");
}

/// Shares of the answers "different" and "equivalent" for many pairs of runs with three numbers each, of which the last
/// differs by `shift` [-] of its value.
fn shares(count: usize, deviation: f64, shift: f64, pairs: u64) -> [f64; 2] {
    let (mut different, mut equivalent) = (0, 0);
    for pair in 0..pairs {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(pair);
        let names = ["a", "b", "c"];
        let mut run = |shift: f64| {
            let mean = |name: &str| if name == "c" { 1.0 + shift } else { 1.0 };
            names.map(|name| noisy(name, count, [mean(name), deviation], &mut random)).to_vec()
        };
        let found = compared(run(shift), run(0.0));
        different += u32::from(found.iter().any(|one| one.answer == Some(Answer::Different)));
        equivalent += u32::from(found[2].answer == Some(Answer::Equivalent));
    }
    [different, equivalent].map(|number| f64::from(number) / pairs as f64)
}

/// With 20 blocks, the normal distribution would call 3 % of equal pairs different (three numbers at a level of 1 %
/// together), since Student's t has wider tails.
#[test]
fn wrong_answers_are_as_rare_as_the_levels_say() {
    let pairs = 1500;
    let sure = |level: f64| level + 3.0 * (level * (1.0 - level) / pairs as f64).sqrt();
    let [different, equivalent] = shares(20, 0.01, 0.0, pairs);
    println!("equal: {different} different, {equivalent} equivalent");
    assert!(different <= sure(0.01), "{different}");
    // the difference has the standard error √2 · 0.01/√20 = 0.3 %, so that 1 % is three errors away
    assert!(equivalent > 0.8, "{equivalent}");
    let [different, equivalent] = shares(20, 0.01, 0.01, pairs);
    println!("apart by the margin: {different} different, {equivalent} equivalent");
    assert!(equivalent <= sure(0.05), "{equivalent}");
    let [different, _] = shares(20, 0.01, 0.03, pairs);
    println!("apart by three margins: {different} different");
    assert!(different > 0.95, "{different}");
}

/// A gas with measurements, of hard spheres and of soft ones with deep overlaps.
const CASE: &str = r#"
[domain]
size = ["3 mm", "3 mm", "3 mm"]
periodic = ["x", "y", "z"]
[[particles]]
diameter = "406 um"
density = "1038 kg/m^3"
count = 80
velocity_fluctuation = "0.5 m/s"
[contact]
restitution = 1.0
friction = 0.0
[soft.linear_spring_dashpot]
stiffness = "300 N/m"
[run]
model = "hard"
duration = "80 ms"
average_from = "4 ms"
seed = 1
[statistics]
slices = 1
sample_interval = "0.1 ms"
[observe.pair_distribution]
reach = "1 mm"
[observe.velocity_distribution]
[observe.clusters]
gap = "20 um"
[observe.contact_network]
[[compare]]
name = "hard"
model = "hard"
[[compare]]
name = "soft"
model = "soft"
against = "hard"
"#;

#[test]
fn a_comparison_has_rows_for_what_both_variants_measure() {
    let folder = tempfile::tempdir().unwrap();
    let (case, out) = (folder.path().join("case.toml"), folder.path().join("out"));
    std::fs::write(&case, CASE).unwrap();
    let arguments = ["compare", case.to_str().unwrap(), "--margin", "10%", "--out", out.to_str().unwrap()];
    let done = diptych(&arguments).output().unwrap();
    assert!(done.status.success(), "{}", words(&done.stderr));
    let told = words(&done.stdout) + &words(&done.stderr);
    assert!(told.contains("what is measured under [observe], judged by itself, is"), "{told}");
    let summary: Value = serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    let pair = &summary["comparisons"][0];
    assert_eq!(pair["basis"], "averages", "{pair}");
    let rows = pair["observe"].as_array().unwrap();
    let names: Vec<&str> = rows.iter().map(|row| row["quantity"].as_str().unwrap()).collect();
    // hard spheres have no contacts, so that the contact network has no rows
    let wanted = ["contact_value", "a2", "a3", "clusters", "largest", "mean_size", "mean_size_of_a_particle"];
    assert_eq!(names, wanted);
    let csv = std::fs::read_to_string(out.join("observed-differences.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 1 + wanted.len(), "{csv}");
    let values =
        |variant: usize, of: [&str; 2]| summary["variants"][variant]["observe"][of[0]][of[1]]["value"].as_f64();
    for (row, line) in rows.iter().zip(&lines[1..]) {
        let name = row["quantity"].as_str().unwrap();
        let measurement = row["measurement"].as_str().unwrap();
        assert!(line.starts_with(&format!("soft,hard,{measurement},{name},")), "{line}");
        let difference = row["difference"]["value"].as_f64().unwrap();
        let [hard, soft] = [0, 1].map(|variant| values(variant, [measurement, name]).unwrap());
        // the verdict leaves out samples that do not fill a block of time, so that it may differ by a part of its error
        let error = row["difference"]["error"].as_f64().unwrap();
        close(name, difference, soft - hard, 0.5 * error);
        match row["percent"]["value"].as_f64() {
            Some(percent) => close(name, percent, 100.0 * difference / hard.abs(), 1e-6 * percent.abs() + 1e-9),
            None => assert!(line.contains("zero within its error"), "{line}"),
        }
    }
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(report.contains("measured under [observe]") && report.contains("g at contact [observe]"));
}
