//! Predictions against short real runs, recommendations for the built-in cases, and the command `plan`.

use crate::support::{empty, experiment, large, plane, surface};
use diptych::case::Case;
use diptych::experiment::{Experiment, Integrator, Model, SoftStepping, Spheres, TimeStep};
use diptych::outcome::Outcome;
use diptych::placement::initial_state;
use diptych::predict::integrator::{Scheme, realised_restitution, unit_spring};
use diptych::predict::{EngineChoice, Obstacles, recommend};
use diptych::study::{PlannedExperiment, execute, plan_of};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn case(name: &str, sets: &[&str]) -> Experiment {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases").join(format!("{name}.toml"));
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    Case::read(&path, &sets).and_then(|case| case.experiment(None, None)).unwrap().0
}

fn planned(experiment: &Experiment) -> PlannedExperiment {
    plan_of(experiment, 0.01, false).unwrap()
}

fn run(experiment: &Experiment) -> Outcome {
    execute(experiment, initial_state(experiment).unwrap(), &mut []).0
}

fn diptych(arguments: &[&str]) -> Output {
    let root = env!("CARGO_MANIFEST_DIR");
    let output = Command::new(env!("CARGO_BIN_EXE_diptych")).current_dir(root).args(arguments).output().unwrap();
    assert!(!String::from_utf8_lossy(&output.stderr).contains("panicked"), "{arguments:?}");
    output
}

/// Predicted rates agree with short runs within the 10 % that the plan states for kinetic theory. Effects that the
/// plan neglects (a shorter box, slices, a finite number of particles) are a few per cent.
#[test]
fn collision_rates_of_runs() {
    for (name, sets) in [
        ("dense-gas", &[][..]),
        ("cooling-gas", &[]),
        ("channel-f", &["domain.size[0]=60 mm", "run.duration=2 s", "run.average_from=1 s"]),
    ] {
        let experiment = case(name, sets);
        let predicted = planned(&experiment).plan.gas.unwrap();
        let outcome = run(&experiment);
        let close = |what: &str, predicted: f64, measured: Option<diptych::statistics::Estimate>| {
            let measured = measured.unwrap();
            let slack = 0.1 * measured.value + 2.0 * measured.error.unwrap();
            assert!((predicted - measured.value).abs() < slack, "{name}: {what} {predicted} against {measured:?}");
        };
        close("pairs", predicted.pair_rate, outcome.pair_rate);
        if outcome.wall_rate.unwrap().value > 0.0 {
            close("walls", predicted.wall_rate, outcome.wall_rate);
        }
    }
}

/// Mean and 99 % quantile of about 30 000 overlaps agree with the plan, which states an accuracy of 15 %.
#[test]
fn overlaps_of_a_gas() {
    let mut experiment = case("dense-gas", &["run.duration=3 ms", "run.average_from=0 s"]);
    experiment.run.spheres = Spheres::Soft(experiment.soft.law.unwrap());
    let plan = planned(&experiment).plan;
    let measured = run(&experiment).record.pairs.summary();
    assert!(measured.count > 10_000);
    let row = &plan.contacts[0];
    for (predicted, measured) in [
        (row.mean_overlap, measured.mean_maximum_overlap.unwrap()),
        (row.overlap_99, measured.p99_maximum_overlap.unwrap()),
    ] {
        // at this density, contacts of three bodies add a few per cent to the statistical error
        assert!((predicted / measured - 1.0).abs() < 0.08, "{predicted} against {measured}");
    }
}

/// The linear map of the integrator predicts the restitution in an elastic gas, for the steps per contact of the
/// paper. Compared is the mean square of the restitution, weighted with energy.
#[test]
fn realised_restitution_of_the_engine() {
    let mut experiment = case("dense-gas", &["particles[0].volume_fraction=0.05", "run.duration=8 ms"]);
    let law = experiment.soft.law.unwrap();
    experiment.run.spheres = Spheres::Soft(law);
    experiment.soft.stepping = SoftStepping::Uniform;
    for (integrator, steps) in [(Integrator::Rk2, 7.735), (Integrator::VelocityVerlet, 7.735)] {
        experiment.soft.integrator = integrator;
        experiment.soft.time_step = TimeStep::PerContact(steps);
        let scheme = Scheme::of(integrator, SoftStepping::Uniform);
        let predicted = realised_restitution(scheme, &law, (&unit_spring(1.0), 1.0), steps).unwrap();
        let measured = run(&experiment).record.pairs.summary();
        assert!(measured.count > 1000, "{measured:?}");
        // the phase of a contact changes e by about 0.01; oblique contacts turn by about the overlap, which reduces the
        // gain by 1 %
        let error = 0.01 / (measured.count as f64).sqrt();
        let found = measured.mean_restitution.unwrap() - predicted.mean_square.sqrt();
        assert!(found.abs() < 4.0 * error + 1e-3, "{integrator:?}: {measured:?} against {predicted:?}");
    }
}

#[test]
fn the_lowest_contact_and_the_deepest_bounce() {
    let column = case("column", &[]);
    let plan = planned(&column).plan;
    // static overlap n m g/k: 3.56815e-6 m, over 406 um
    assert!((plan.static_overlap.unwrap() / (3.56814984e-6 / 406e-6) - 1.0).abs() < 1e-6);
    let bouncing = case("bouncing-sphere", &["run.duration=0.1 s"]);
    let plan = planned(&bouncing).plan;
    let rest = plan.rest.unwrap();
    assert!((rest.speed / 0.626418391 - 1.0).abs() < 1e-6, "{rest:?}");
    // (1+e)/(1-e) sqrt(2h/g) for h = 20 mm, e = 0.9
    assert!((rest.time / 1.21324663 - 1.0).abs() < 1e-6, "{rest:?}");
    let mut soft = bouncing;
    soft.run.spheres = Spheres::Soft(soft.soft.law.unwrap());
    let measured = run(&soft).record.walls.summary();
    assert!((plan.contacts[0].overlap_99 / measured.largest_overlap.unwrap() - 1.0).abs() < 0.02, "{measured:?}");
}

#[test]
fn recommendations_for_the_ready_cases() {
    let dilute = ["domain.size[0]=40 mm", "domain.size[2]=32 mm"];
    for name in ["channel-b", "channel-c", "channel-d", "channel-e", "channel-f", "channel-g", "quick"] {
        let found = planned(&case(name, &dilute)).recommendation;
        assert!(matches!(found.engine, Some(EngineChoice::Hard | EngineChoice::SoftLocal)), "{name}: {found:?}");
        assert!(found.doubts.iter().any(|doubt| doubt.starts_with("two-way coupling")), "{name}: {found:?}");
        assert!(!found.adequate && found.headline().contains("no model here is adequate"), "{name}: {found:?}");
    }
    for (name, engine) in [
        ("dense-gas", EngineChoice::Hard),
        ("cooling-gas", EngineChoice::Hard),
        ("glass-beads", EngineChoice::Hard),
        ("bouncing-sphere", EngineChoice::Hard),
        ("impact", EngineChoice::Hard),
        ("column", EngineChoice::SoftUniform),
        // windows of three time steps
        ("cradle", EngineChoice::SoftUniform),
    ] {
        let found = planned(&case(name, &[])).recommendation;
        assert_eq!(found.engine, Some(engine), "{name}: {found:?}");
        assert!(found.adequate && !found.reasons.is_empty(), "{name}");
    }
    let column = planned(&case("column", &[])).recommendation;
    assert!(column.refused.iter().any(|why| why.starts_with("hard spheres: particles lie at rest")), "{column:?}");
    let overlapping = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs/good/14-overlap-soft-small.toml");
    let overlapping =
        Case::read(&overlapping, &[]).and_then(|case| case.experiment(Some(Model::Soft), None)).unwrap().0;
    let found = planned(&overlapping).recommendation;
    assert_eq!(found.engine, Some(EngineChoice::SoftLocal), "{found:?}");
    assert!(found.refused.iter().any(|why| why.contains("overlap")), "{found:?}");
    // after its last bounce the sphere lies on the floor, which hard spheres cannot do
    let lying = planned(&case("bouncing-sphere", &["run.duration=4 s"])).recommendation;
    assert_eq!(lying.engine, Some(EngineChoice::SoftUniform), "{lying:?}");
    assert!(lying.refused.iter().any(|why| why.contains("come to rest")), "{lying:?}");
    // with a contact time, hard spheres keep bouncing slightly there
    let hovering = ["run.duration=4 s", "hard.contact_time=1e-5 s"];
    let hovering = planned(&case("bouncing-sphere", &hovering)).recommendation;
    assert!(!hovering.refused.iter().any(|why| why.starts_with("hard spheres")), "{hovering:?}");
}

#[test]
fn there_may_be_no_adequate_model() {
    let mut column = case("column", &[]);
    column.scene.contact.restitution = 0.0;
    let found = planned(&column).recommendation;
    assert_eq!((found.engine, found.adequate), (None, false));
    assert!(found.headline().starts_with("No model here is adequate: hard spheres: particles lie"), "{found:?}");
    assert!(found.headline().contains("soft spheres: a restitution of 0"), "{found:?}");
}

#[test]
fn a_stricter_target_asks_for_more() {
    let mut beads = case("glass-beads", &[]);
    // a case without a stiffness gets a recommended stiffness
    beads.soft.law = None;
    let [loose, strict] = [0.1, 0.001].map(|target| plan_of(&beads, target, false).unwrap());
    // the stiffness is proportional to the inverse square of the error, unless overlaps require a larger one
    let ratio =
        strict.recommendation.law.unwrap().parameter().value / loose.recommendation.law.unwrap().parameter().value;
    assert!(ratio > 100.0, "{ratio}");
    let channel = case("dense-gas", &[]);
    let [loose, strict] = [0.01, 0.001].map(|target| plan_of(&channel, target, false).unwrap().plan.averaging.unwrap());
    assert!((strict.duration / loose.duration - 100.0).abs() < 1e-6, "{strict:?} {loose:?}");
}

/// Adds to `found` the keys of all numbers in a JSON value that have no entry in `units`.
fn without_unit(value: &Value, key: &str, units: &Value, found: &mut Vec<String>) {
    match value {
        Value::Object(map) => map.iter().for_each(|(key, value)| without_unit(value, key, units, found)),
        Value::Array(list) => list.iter().for_each(|value| without_unit(value, key, units, found)),
        Value::Number(_) if units.get(key).is_none() => found.push(key.to_owned()),
        Value::Number(_) | Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

#[test]
fn json_names_the_unit_of_every_number() {
    for name in ["cases/channel-e.toml", "cases/column.toml", "cases/cooling-gas.toml", "cases/shear/soft-or-hard.toml"]
    {
        let output = diptych(&["plan", name, "--json", "--threads", "1"]);
        assert!(output.status.success(), "{output:?}");
        let document: Value = serde_json::from_slice(&output.stdout).unwrap();
        let mut missing = Vec::new();
        for part in ["plan", "recommendation", "threads"] {
            without_unit(&document[part], part, &document["units"], &mut missing);
        }
        assert!(missing.is_empty(), "{name}: {missing:?}");
        assert!(document["plan"]["costs"].as_array().is_some_and(|costs| costs.len() == 5), "{name}");
    }
}

#[test]
fn plans_do_not_depend_on_threads() {
    let [one, two] = ["1", "2"].map(|threads| {
        let output = diptych(&["plan", "cases/cooling-gas.toml", "--json", "--threads", threads]);
        let mut document: Value = serde_json::from_slice(&output.stdout).unwrap();
        // measured times and memory are left out
        document["plan"]["costs"] = Value::Null;
        document["threads"] = Value::Null;
        document
    });
    assert_eq!(one, two);
}

/// A ball that falls out of an open box. No model is recommended for this reason, although every timing run stops.
#[test]
fn a_run_that_every_model_stops_is_told_first() {
    let place = tempfile::tempdir().unwrap();
    let case = place.path().join("open.toml");
    let text = "[domain]\nsize = [\"1 cm\", \"1 cm\", \"1 cm\"]\nperiodic = [\"x\"]\n[gravity]\nacceleration = [\"0 m/s^2\", \"-9.81 m/s^2\", \"0 m/s^2\"]\n\
                [[particles]]\ndiameter = \"1 mm\"\ndensity = \"2500 kg/m^3\"\n\
                at = [{ position = [\"5 mm\", \"5 mm\", \"5 mm\"] }, { position = [\"5 mm\", \"8 mm\", \"5 mm\"] }]\n\
                [contact]\nrestitution = 0.9\n[soft.linear_spring_dashpot]\nstiffness = \"1 kN/m\"\n[run]\nduration = \"0.2 s\"\n";
    std::fs::write(&case, text).unwrap();
    let output = diptych(&["plan", case.to_str().unwrap()]);
    let told = String::from_utf8(output.stdout).unwrap();
    let (first, _) = told.split_once("\nWhy\n").expect(&told);
    assert!(first.contains("No model comes to the end") && first.contains("is outside the domain"), "{told}");
}

#[test]
fn bad_input_is_refused() {
    for arguments in [
        &["plan", "cases/no-such-case.toml"][..],
        &["plan", "cases/quick.toml", "--target-error", "0"],
        &["plan", "cases/quick.toml", "--target-error", "100%"],
        &["plan", "cases/quick.toml", "--target-error", "-1%"],
        &["plan", "cases/quick.toml", "--target-error", "NaN"],
        &["plan", "cases/quick.toml", "--target-error", "some"],
        &["plan", "cases/quick.toml", "--set", "contact.restitution=2"],
        &["run", "cases/quick.toml", "--model", "automatic"],
    ] {
        let output = diptych(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{arguments:?}");
    }
    let percent = diptych(&["plan", "cases/impact.toml", "--json", "--target-error", "5%"]);
    let share = diptych(&["plan", "cases/impact.toml", "--json", "--target-error", "0.05"]);
    let target =
        |output: &Output| serde_json::from_slice::<Value>(&output.stdout).unwrap()["plan"]["target_error"].clone();
    assert_eq!((target(&percent), target(&share)), (Value::from(0.05), Value::from(0.05)));
}

#[test]
fn auto_follows_the_recommendation_and_says_so() {
    let temporary = tempfile::tempdir().unwrap();
    for (name, model, word) in
        [("column", "soft", "soft spheres, uniform"), ("bouncing-sphere", "hard", "hard spheres")]
    {
        let folder = temporary.path().join(name);
        let path = folder.to_str().unwrap();
        let case = format!("cases/{name}.toml");
        let output = diptych(&["run", &case, "--model", "auto", "--out", path, "--quiet"]);
        assert!(output.status.success(), "{output:?}");
        let summary: Value = serde_json::from_slice(&std::fs::read(folder.join("summary.json")).unwrap()).unwrap();
        assert_eq!(summary["variants"][0]["model"], model);
        let note = summary["notes"][0].as_str().unwrap();
        assert!(note.starts_with("--model auto took") && note.contains(word), "{note}");
        let report = std::fs::read_to_string(folder.join("report.html")).unwrap();
        assert!(report.contains("--model auto took"));
        if model == "soft" {
            assert_eq!(summary["variants"][0]["parameters"]["soft"]["stepping"], "uniform");
        }
    }
    // no model is adequate: the command is refused, and nothing is written
    let folder = temporary.path().join("none");
    let output = diptych(&[
        "run",
        "cases/column.toml",
        "--model",
        "auto",
        "--set",
        "contact.restitution=0",
        "--out",
        folder.to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(!folder.exists());
}

/// Spheres at random positions are no row through which an impulse passes, even if two of them are very near to each
/// other by chance.
#[test]
fn only_a_start_that_was_placed_has_neighbours_in_a_row() {
    let sets = ["particles[0].count=60", "domain.size=[\"2.4 mm\", \"2.4 mm\", \"2.4 mm\"]", "run.duration=1 ms"];
    let weak = "soft.linear_spring_dashpot.stiffness=30 N/m";
    let found = planned(&case("dense-gas", &[&sets[..], &[weak]].concat()));
    assert!(!found.plan.in_a_row && found.plan.gas.is_none(), "{:?}", found.recommendation);
    assert!(!found.recommendation.refused.iter().any(|why| why.contains("neighbours")), "{:?}", found.recommendation);
    assert_eq!(found.recommendation.engine, Some(EngineChoice::Hard));
    assert!(planned(&case("cradle", &[])).plan.in_a_row);
}

/// The cradle runs for 200 windows of three time steps each. There, local stepping (steps only for particles in
/// contact) is slower, because it searches in every window. In windows of many steps it is faster.
#[test]
fn local_stepping_is_for_windows_of_many_steps() {
    let short = planned(&case("cradle", &[])).recommendation;
    assert_eq!(short.engine, Some(EngineChoice::SoftUniform), "{short:?}");
    assert!(short.reasons[0].contains("to step every particle"), "{short:?}");
    let long = planned(&case("cradle", &["run.duration=100 ms"])).recommendation;
    assert_eq!(long.engine, Some(EngineChoice::SoftLocal), "{long:?}");
}

#[test]
fn a_plan_of_no_time_ends() {
    for name in ["quick", "column", "bouncing-sphere"] {
        let output = diptych(&["plan", name, "--set", "run.duration=0 s"]);
        let told = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && told.contains("Cost of 0 s"), "{name}: {told}");
    }
}

/// One window (piece of the run) contains about 10⁹ collisions. A part of a window is timed, and the cost is
/// extrapolated to the whole run.
#[test]
fn a_plan_of_a_very_long_run_ends() {
    let sets = ["run.duration=1e8 s", "contact.restitution=1", "domain.size=[\"2 mm\", \"2 mm\", \"2 mm\"]"];
    let sets = sets.iter().flat_map(|set| ["--set", set]);
    let arguments: Vec<&str> = ["plan", "cases/cooling-gas.toml", "--json"].into_iter().chain(sets).collect();
    let output = diptych(&arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let plan: Value = serde_json::from_slice(&output.stdout).unwrap();
    let costs = plan["plan"]["costs"].as_array().unwrap();
    assert_eq!(costs.len(), 5);
    for cost in costs {
        // at least a tenth of a microsecond of wall time for each of more than 10¹⁰ collisions
        assert!(cost["wall_seconds"].as_f64().unwrap() > 1e3, "{cost}");
    }
}

/// Haff's law with the collision rate at the start, against a run for the predicted time of half of the energy loss.
/// Kinetic theory is accurate to 4 %, and the energy of 2000 particles has a standard deviation of 2 %.
#[test]
fn a_cooling_gas_is_asked_for_its_curve() {
    let mut gas = case("cooling-gas", &[]);
    let plan = planned(&gas).plan;
    assert!(plan.averaging.is_none(), "{:?}", plan.averaging);
    let transient = plan.transient.unwrap();
    // number of replicas: sqrt(2/(3 · 1999)) over 1 %, squared
    assert_eq!((transient.replicas, transient.at_rest), (4, None));
    let half = &transient.losses[0];
    gas.run.duration = half.time;
    let outcome = run(&gas);
    let lost = 1.0 - outcome.energy_at_end / outcome.energy_at_start;
    assert!((lost / half.share - 1.0).abs() < 0.06, "{lost} lost where {} was predicted", half.share);
    // no steady cooling: the first case loses no energy, the gas drives the second, and sliding walls drive the third
    let driven = [
        ("dense-gas", &[][..]),
        ("channel-f", &["domain.size[0]=60 mm", "domain.size[2]=32 mm"]),
        ("walls/sheared-cell", &[]),
    ];
    for (name, sets) in driven {
        assert!(planned(&case(name, sets)).plan.transient.is_none(), "{name}");
    }
    let still = ["walls[0].velocity[2]=0 m/s", "walls[1].velocity[2]=0 m/s"];
    assert!(planned(&case("walls/sheared-cell", &still)).plan.transient.is_some());
}

/// Beads between floor and lid come to rest. The plan recommends no average, no local stepping and no hard spheres.
#[test]
fn a_bed_is_neither_averaged_nor_stepped_locally() {
    let mut scene = empty([0.02, 0.04, 0.02], [true, false, true], large(), surface(0.8, 0.0));
    scene.gravity.y = -9.81;
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.8, 0.0))];
    scene.walls.push(plane([0.0, 0.04, 0.0], [0.0, -1.0, 0.0], surface(0.8, 0.0)));
    let mut beads = experiment(scene, 150, [0.0; 3], 0.3, Model::Soft, 1);
    beads.run.duration = 5.0;
    let planned = plan_of(&beads, 0.01, true).unwrap();
    let (plan, advice) = (&planned.plan, &planned.recommendation);
    assert_eq!(advice.engine, Some(EngineChoice::SoftUniform), "{advice:?}");
    assert!(plan.averaging.is_none() && plan.transient.as_ref().is_some_and(|found| found.at_rest.is_some()));
    let seconds = |model| plan.costs.iter().find(|cost| cost.model == model).and_then(|cost| cost.wall_seconds);
    // the table has a time for the recommended model, and none for models with unknown cost
    assert!(
        seconds(EngineChoice::SoftLocal).is_none() && seconds(EngineChoice::SoftUniform).is_some(),
        "{:?}",
        plan.costs
    );
    assert!(advice.refused[0].starts_with("hard spheres: particles come to rest"), "{:?}", advice.refused);
}

/// The predicted time until the gas comes to rest is longer than the run, so that only the bed rules out hard spheres.
#[test]
fn a_bed_in_a_start_from_a_file_is_seen() {
    let mut experiment = case("hybrid/gas-above-bed", &[]);
    let found = planned(&experiment);
    // 375 beads were poured; some bounce too fast, or are between two neighbours with gaps below the rounding of the
    // file
    assert!((250..=375).contains(&found.plan.lying), "{}", found.plan.lying);
    assert_eq!(found.recommendation.engine, Some(EngineChoice::SoftUniform));
    assert!(found.recommendation.refused[0].contains("lie on something"), "{:?}", found.recommendation.refused);
    // if few particles lie and windows are long, only the particles that lie are stepped
    let found = planned(&case("hybrid/rain-on-a-bed", &[]));
    assert_eq!(found.recommendation.engine, Some(EngineChoice::Hybrid), "{:?}", found.recommendation);
    // with springs softer than glass, as is common
    let mut rain = case("hybrid/rain-on-a-bed", &["soft.linear_spring_dashpot.stiffness=10 kN/m"]);
    assert_eq!(planned(&rain).recommendation.engine, Some(EngineChoice::Hybrid));
    rain.run.duration *= 0.1;
    assert_eq!(planned(&rain).recommendation.engine, Some(EngineChoice::SoftUniform), "windows are too short for it");
    // without weight, no particle lies on another
    experiment.scene.gravity *= 0.0;
    assert_eq!(planned(&experiment).plan.lying, 0);
}

/// For every built-in case, `check` and `plan` agree about the start.
#[test]
fn obstacles_of_the_start_are_those_of_the_plan() {
    let mut some = 0;
    for name in ["bouncing-sphere", "column", "cradle", "impact", "hertz", "cooling-gas", "glass-beads"] {
        let experiment = case(name, &[]);
        let found = Obstacles::of(&experiment, &initial_state(&experiment).unwrap()).against_hard(&experiment);
        let refused = planned(&experiment).recommendation.refused;
        assert_eq!(found.iter().map(|why| format!("hard spheres: {why}")).collect::<Vec<_>>(), refused, "{name}");
        some += usize::from(!found.is_empty());
    }
    assert!(some >= 2, "{some} cases have obstacles");
}

/// Softer spheres are in contact for a longer time. If they are in contact for a tenth of the time or more, stepping
/// only the spheres in contact costs as much as stepping all.
#[test]
fn local_stepping_is_for_those_who_touch_rarely() {
    for (stiffness, engine) in [("30 kN/m", EngineChoice::SoftLocal), ("1 kN/m", EngineChoice::SoftUniform)] {
        let gas = case("dense-gas", &[&format!("soft.linear_spring_dashpot.stiffness={stiffness}"), "run.window=1 ms"]);
        let planned = plan_of(&gas, 0.5, false).unwrap();
        let mut plan = planned.plan;
        // hard spheres are ruled out, as if by overlaps at the start
        plan.starts_overlapping = true;
        let found = recommend(&gas, &plan, &[], &[]);
        assert_eq!(found.engine, Some(engine), "{stiffness}: {:?}", plan.time_in_contact);
    }
}

/// Half the period of a spring over the contact time. It is sqrt((2/7)/κ) for the tangential spring without damping
/// (stiffness ratio κ), and sqrt((2/5)/(2.25 μ_r²)) for the rolling spring (rolling friction μ_r).
#[test]
fn the_spring_that_limits_the_time_step_is_named() {
    let limits = |sets: &[&str]| {
        let planned = planned(&case("rotation/oblique", sets));
        let of = |name: &str| {
            planned.plan.step_limits.iter().find(|limit| limit.name.contains(name)).map(|limit| limit.longest)
        };
        let first = planned.plan.step_limits[0].name.clone();
        let said = planned.recommendation.reasons.iter().any(|reason| reason.contains("tangential spring"));
        let steps = planned.recommendation.steps_per_contact;
        (first, of("contact, T_c/N_c").unwrap(), of("tangential"), of("rolling"), said, steps)
    };
    let (first, contact, tangential, rolling, said, steps) = limits(&[]);
    let share = (2.0 / 7.0 / 0.8604651163_f64).sqrt();
    assert!(first.starts_with("tangential spring, half its period/N_c: ball at a wall"), "{first}");
    assert!((tangential.unwrap() / contact / share - 1.0).abs() < 1e-6 && rolling.is_none());
    let (_, _, _, _, unsaid, fewer) = limits(&["soft.tangential.linear.stiffness_ratio=0.25"]);
    assert!(said && !unsaid && steps == (fewer / share - 0.01).ceil(), "{steps} {fewer}");
    let (first, contact, _, rolling, ..) = limits(&[
        "soft.tangential.linear.stiffness_ratio=0.1",
        "soft.rolling.spring.friction=0.5",
        "soft.rolling.spring.damping_ratio=0",
    ]);
    assert!(
        (rolling.unwrap() / contact / (0.4 / (2.25 * 0.25_f64)).sqrt() - 1.0).abs() < 1e-6,
        "{rolling:?} {contact}"
    );
    assert!(first.starts_with("rolling spring"), "{first}");
}

/// A single particle has no agitation with which the turbulence that it sees could be compared.
#[test]
fn an_effect_without_bound_is_called_so() {
    let output = diptych(&["plan", "channel-f", "--set", "particles[0].volume_fraction=1e-5"]);
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(told.contains("is not small here: without bound") && !told.contains("inf "), "{told}");
}
