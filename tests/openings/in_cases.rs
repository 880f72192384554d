//! Inlets and outlets of cases: rates, masses, speeds, messages, and a run that empties the box.

use crate::support::*;
use diptych::experiment::Model;
use std::path::Path;

const CASE: &str = r#"
[domain]
size = ["10 mm", "10 mm", "10 mm"]
periodic = ["x", "z"]
[[particles]]
name = "glass"
diameter = "1 mm"
density = "2500 kg/m^3"
count = 0
velocity_mean = ["0 m/s", "-1 m/s", "0 m/s"]
[[outlets]]
side = "-y"
[[inlets]]
particles = "glass"
box = { center = ["5 mm", "9 mm", "5 mm"], half_extents = ["5 mm", "1 mm", "5 mm"] }
mass_rate = "1 g/s"
[contact]
restitution = 0.9
[run]
model = "hard"
duration = "0.1 s"
"#;

#[test]
fn cases_give_rates_and_bad_ones_are_refused_with_a_remedy() {
    let good = case(CASE, Model::Hard, &[]).unwrap();
    let (inlet, mass) = (&good.scene.inlets[0], good.scene.species[0].mass());
    // rounding of a product and a quotient
    close("rate", inlet.rate * mass, 1e-3, 1e-17);
    assert_eq!((inlet.velocity_mean.y, good.scene.outlets.len()), (-1.0, 1));
    for (set, words) in [
        ("outlets[0].side=\"-x\"", "is a periodic side"),
        ("inlets[0].particles=\"steel\"", "names no particles"),
        ("inlets[0].end=\"-1 s\"", "out of range"),
        ("inlets[0].box.half_extents=[\"5 mm\", \"0.4 mm\", \"5 mm\"]", "has no room for a particle"),
        ("observe.diffusion.duration=\"10 ms\"", "needs particles that stay"),
        ("inlets[0].mass_rate=\"1 g\"", "mass per time"),
    ] {
        let why = case(CASE, Model::Hard, &[set]).unwrap_err();
        assert!(why.contains(words), "{set}: {why}");
    }
    // the particles that come in touch one another
    let why = case(&CASE.replace("[contact]\nrestitution = 0.9\n", ""), Model::Hard, &[]).unwrap_err();
    assert!(why.contains("contact.restitution"), "{why}");
}

/// If soft contacts last longer at lower speed, the time step follows from the fastest impact. The speed at which
/// particles come in counts, too.
#[test]
fn the_fastest_impact_includes_particles_that_come_in() {
    let speed = |set: &str| diptych::predict::contact::fastest_impact(&case(CASE, Model::Hard, &[set]).unwrap());
    let still = speed("particles[0].velocity_mean=[\"0 m/s\", \"0 m/s\", \"0 m/s\"]");
    let fast = speed("particles[0].velocity_mean=[\"0 m/s\", \"-100 m/s\", \"0 m/s\"]");
    assert!(still < 1.0 && (200.0..201.0).contains(&fast), "{still}, {fast}");
}

/// With added mass, some water moves with each sphere. The mass that comes in is that of the spheres without this
/// water.
#[test]
fn the_mass_that_comes_in_is_that_of_the_spheres() {
    let water = [
        "gravity.acceleration=[0, -10, 0]",
        "fluid={ density = 1000, kinematic_viscosity = 1e-6, buoyancy = true, added_mass = true, profile = { uniform = { velocity = 0 } } }",
    ];
    let told = diptych::case::describe(&case(CASE, Model::Hard, &water).unwrap());
    assert!(told.contains("come in, 1e-3 kg/s") || told.contains("come in, 0.001 kg/s"), "{told}");
}

/// Hybrid spheres count the contact time that an instantaneous impact leaves out. If all particles leave before the
/// end of the run, this time is divided by the time that particles were in the box.
#[test]
fn the_time_left_out_is_a_share_of_the_mean_number() {
    let all_leave = [
        ("particles[0].count", "50"),
        ("particles[0].velocity_fluctuation", "\"0.5 m/s\""),
        ("inlets[0].end", "\"1 us\""),
        ("outlets", "[{ side = \"-y\" }, { side = \"+y\" }]"),
        ("soft.linear_spring_dashpot.stiffness", "\"1000 N/m\""),
        ("run.average_from", "\"0 s\""),
    ];
    let sets = all_leave.map(|(key, value)| format!("--set={key}={value}"));
    let folder = tempfile::tempdir().unwrap();
    let [path, out] = ["case.toml", "out"].map(|name| folder.path().join(name).display().to_string());
    std::fs::write(&path, CASE).unwrap();
    let mut command = diptych(&["run", &path, "--model", "hybrid", "--threads", "1", "--out", &out]);
    let output = command.args(sets).output().unwrap();
    assert!(output.status.success(), "{}", words(&output.stderr));
    let summary = std::fs::read_to_string(Path::new(&out).join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let (run, of_pairs) = (&summary["variants"][0], &summary["variants"][0]["instants"]["pairs"]);
    let time = 2.0 * of_pairs["instants"].as_f64().unwrap() * of_pairs["mean_duration_left_out"].as_f64().unwrap();
    let share = run["instants"]["share_of_time_left_out"].as_f64().unwrap();
    // the gas leaves within some 10 ms of the 100 ms
    let mean = time / (0.1 * share);
    assert!((4.0..9.0).contains(&mean), "{mean}");
}
