//! Trust sheet of a report: each measured number beside its expected value, and the effect of half the time step.

use crate::made_up::outcome;
use crate::support::{empty, experiment, plane, random, small, surface};
use diptych::contact_law::ContactLaw;
use diptych::experiment::{AverageFrom, Experiment, HardStepping, Integrator, Model, Population, Spheres, TimeStep};
use diptych::outcome::Outcome;
use diptych::output::{Expected, HalvedStep, Judgement, TrustCheck, TrustSheet};
use diptych::placement::initial_state;
use diptych::scene::{Kind, Meeting, Species};
use diptych::study::{execute, trust_sheet, verify};

/// Experiment of 200 small spheres (volume fraction 3 %) with velocities of 0.5 m/s, in a box of 6 mm between two
/// walls, for 10 ms. `pair` and `wall` are restitutions.
fn gas(model: Model, pair: f64, wall: f64) -> Experiment {
    let size = [6e-3; 3];
    let mut scene = empty(size, [true, false, true], small(), surface(pair, 0.0));
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(wall, 0.0)),
        plane([0.0, size[1], 0.0], [0.0, -1.0, 0.0], surface(wall, 0.0)),
    ];
    let mut experiment = experiment(scene, 200, [0.0; 3], 0.5, model, 3);
    experiment.run.duration = 10e-3;
    experiment.run.average_from = AverageFrom::Time(0.0);
    experiment.statistics.slices = 3;
    experiment
}

fn sheet(experiment: &Experiment, verified: bool) -> TrustSheet {
    let start = random(&experiment.scene, 200, 0.5, 3);
    let (outcome, end) = execute(experiment, start, &mut []);
    let halved = if verified { verify(&outcome, &end, true) } else { HalvedStep::Unknown("not asked for".into()) };
    trust_sheet(&outcome, halved)
}

fn find<'a>(sheet: &'a TrustSheet, name: &str) -> &'a TrustCheck {
    sheet.checks.iter().find(|check| check.name.starts_with(name)).unwrap_or_else(|| panic!("{name}: {sheet:#?}"))
}

#[test]
fn a_sound_run_is_found_sound_and_missing_numbers_say_why() {
    for (model, pair, wall) in [(Model::Soft, 0.9, 0.8), (Model::Hard, 0.9, 0.8)] {
        let mut gas = gas(model, pair, wall);
        // at N_c = 20, the energy error of each damped impact is 1e-3, which is too large here
        gas.soft.time_step = TimeStep::PerContact(60.0);
        let sheet = sheet(&gas, false);
        for (name, asked) in [("restitution, pairs", pair), ("restitution, walls", wall)] {
            let check = find(&sheet, name);
            assert_eq!((check.expected, check.judgement), (Expected::Equals(asked), Judgement::Good), "{check:?}");
            // at N_c = 60, the phase changes the restitution with Verlet's method by about 0.2 % in each impact
            assert!(check.found.unwrap().error.is_some_and(|error| error < 0.004), "{check:?}");
        }
        assert_eq!(find(&sheet, "escapes").judgement, Judgement::Good);
        assert_eq!(find(&sheet, "energy").judgement, Judgement::Good);
        assert_eq!(find(&sheet, "simulated").judgement, Judgement::Good);
        // without drag and gravity, no balance can be checked
        assert_eq!(find(&sheet, "streamwise").judgement, Judgement::Unknown);
        // the gas cools, and is therefore not steady
        assert_eq!(find(&sheet, "drift").judgement, Judgement::Suspect);
        assert!(find(&sheet, "threads").found.unwrap().value >= 1.0);
        for check in &sheet.checks {
            let missing = check.found.is_none();
            assert_eq!(missing, check.judgement == Judgement::Unknown, "{check:?}");
            assert!(!missing || !check.remark.is_empty(), "a missing number says why: {check:?}");
        }
        let soft = model == Model::Soft;
        assert_eq!(find(&sheet, "mean overlap").judgement == Judgement::Unknown, !soft);
        assert_eq!(find(&sheet, "softness").judgement == Judgement::Unknown, !soft);
    }
}

#[test]
fn what_is_not_as_asked_is_suspect() {
    // Heun's method gains energy at N_c = 5 and e = 1: the restitution is 1.0776 on average (tests/analytic.rs); with
    // k_n = 30 N/m, overlaps are large
    let mut gains = gas(Model::Soft, 1.0, 1.0);
    gains.soft.integrator = Integrator::Rk2;
    gains.soft.time_step = TimeStep::PerContact(5.0);
    gains.run.spheres = Spheres::Soft(ContactLaw::linear(30.0));
    gains.run.duration = 20e-3;
    let sheet = sheet(&gains, false);
    let pairs = find(&sheet, "restitution, pairs");
    assert_eq!(pairs.judgement, Judgement::Suspect, "{pairs:?}");
    assert!((1.03..1.13).contains(&pairs.found.unwrap().value) && pairs.in_errors() > Some(3.0), "{pairs:?}");
    for name in ["energy", "mean overlap", "softness"] {
        assert_eq!(find(&sheet, name).judgement, Judgement::Suspect, "{name}: {:?}", find(&sheet, name));
    }
}

/// If no hybrid sphere collided in an instant, the trust sheet gives the softness as for soft spheres; otherwise the
/// share of impacts that were instantaneous.
#[test]
fn the_sheet_counts_the_instants_of_hybrid_spheres() {
    let mut outcome = outcome("hybrid", Model::Hybrid, 1);
    outcome.experiment.start = gas(Model::Hybrid, 0.9, 0.9).start;
    let softness = |outcome: &Outcome| {
        let unasked = HalvedStep::Unknown("not asked for".into());
        find(&trust_sheet(outcome, unasked), "softness").clone()
    };
    assert_eq!(outcome.record.pairs.instants.count, 0);
    assert!(softness(&outcome).found.is_some_and(|found| found.value > 0.0), "{:?}", softness(&outcome));
    outcome.record.pairs.instants.count = outcome.record.pairs.count / 10;
    let some = softness(&outcome);
    assert!(some.found.is_none() && some.remark.starts_with("10 % of the impacts"), "{some:?}");
}

/// The softness in the trust sheet is that of the softest pair of species, for any order of the species. Springs of a
/// hundredth of the stiffness have overlaps that are ten times as deep.
#[test]
fn softness_is_that_of_the_softest_pair() {
    let found = |ratio: f64| {
        let mut gas = gas(Model::Soft, 0.9, 0.9);
        gas.scene.species.push(Species { name: "second".into(), ..small() });
        let soft = Meeting { stiffness_ratio: ratio, ..surface(0.9, 0.0).into() };
        gas.scene.pairs.set(1, Kind::Species(1), soft);
        let second = Population { species: 1, ..gas.start[0].clone() };
        gas.start.push(second);
        gas.run.duration = 2e-3;
        let start = initial_state(&gas).unwrap();
        let (outcome, _) = execute(&gas, start, &mut []);
        let sheet = trust_sheet(&outcome, HalvedStep::Unknown("not asked for".into()));
        find(&sheet, "softness").found.unwrap().value
    };
    // the temperatures of the two runs differ by the losses of 2 ms
    let times = found(0.01) / found(1.0);
    assert!((times - 10.0).abs() < 1.0, "{times}");
}

#[test]
fn half_the_step_is_half_the_step_and_costs_a_fifth() {
    // restitution of Heun's method at N_c = 5 and N_c = 10 for e = 1: 1.0776 and 1.0109
    let mut coarse = gas(Model::Soft, 1.0, 1.0);
    coarse.soft.integrator = Integrator::Rk2;
    coarse.soft.time_step = TimeStep::PerContact(5.0);
    coarse.run.duration = 30e-3;
    let halved = |experiment: &Experiment| match sheet(experiment, true).halved_step {
        HalvedStep::Verified(found) => found,
        HalvedStep::Unknown(why) => panic!("{why}"),
    };
    let found = halved(&coarse);
    assert!((found.stretch - 2e-3).abs() < 1e-12, "{found:?}");
    let pairs = found.quantities.iter().find(|row| row.name == "restitution, pairs").unwrap();
    println!("{found:#?}");
    // the normal motion in oblique impacts of a gas is that of the linear oscillator
    assert!((pairs.as_run.value - 1.0776).abs() < 0.01 + 3.0 * pairs.as_run.error.unwrap(), "{pairs:?}");
    assert!((pairs.halved.value - 1.0109).abs() < 0.01 + 3.0 * pairs.halved.error.unwrap(), "{pairs:?}");
    assert!(pairs.in_errors().is_some_and(|errors| errors < -3.0), "{pairs:?}");
    let energy = found.quantities.iter().find(|row| row.name.starts_with("energy")).unwrap();
    assert!(energy.as_run.value > 3.0 * energy.halved.value && energy.halved.value > 0.0, "{energy:?}");

    let mut stepped = gas(Model::Hard, 1.0, 1.0);
    stepped.hard.stepping = HardStepping::Steps { theta: 0.05 };
    let found = halved(&stepped);
    assert!(found.time_step.is_some_and(|step| step > 0.0) && found.quantities.len() >= 4, "{found:?}");

    // without simulated time there is no step to be tested, and the sheet contains this reason
    let mut none = gas(Model::Hard, 1.0, 1.0);
    none.run.duration = 0.0;
    assert!(matches!(sheet(&none, true).halved_step, HalvedStep::Unknown(why) if why.contains("nothing")));
}

#[test]
fn reports_and_summaries_end_with_the_sheet() {
    let keep = tempfile::tempdir().unwrap();
    let out = keep.path().join("run");
    let arguments = ["compare", "tests/inputs/good/base.toml", "--verify", "--quiet", "--out", out.to_str().unwrap()];
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_diptych"));
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let html = std::fs::read_to_string(out.join("report.html")).unwrap();
    let place = |title: &str| html.find(&format!("<h2>{title}</h2>")).unwrap_or_else(|| panic!("{title}"));
    assert!(place("Profiles") < place("How far to trust this"), "the sheet follows the results");
    assert!(place("How far to trust this") < place("To get the same again"));
    // one table contains all variants next to each other
    assert_eq!(html.matches("particles outside the box at a sample").count(), 1);
    let text = std::fs::read(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let variants = summary["variants"].as_array().unwrap();
    for (variant, sheet) in variants.iter().zip(summary["trust"].as_array().unwrap()) {
        assert_eq!(variant["name"], sheet["variant"]);
        assert!(sheet["checks"].as_array().unwrap().len() >= 9, "{sheet:#}");
        let halved = &sheet["halved_step"]["verified"];
        assert!(halved["stretch"].as_f64().unwrap() > 0.0 && halved["cost"].as_f64().unwrap() > 0.0, "{sheet:#}");
    }
}

#[test]
fn the_ledger_closes_where_stepping_is_chosen_by_cost() {
    // two spheres, 200 steps per contact, 210 windows: in each window, islands turn out to cost more, and uniform steps
    // continue the motion
    let keep = tempfile::tempdir().unwrap();
    let out = keep.path().join("run");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_diptych"));
    let arguments = ["run", "cases/impact.toml", "--quiet", "--out", out.to_str().unwrap()];
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    // energy error of Verlet's method: 1.1e-5 at N_c = 200 over all phases, 1.5e-5 at most (docs/chart.md: order 2)
    let residual = summary["variants"][0]["energy"]["residual_relative"].as_f64().unwrap();
    assert!(residual.abs() < 3e-5, "{residual}");
}
