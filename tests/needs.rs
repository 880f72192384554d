//! The command `diptych needs` names the models that a scene can do without. It runs in scenes whose answers are known
//! in closed form.

use crate::support::{diptych, words};
use serde_json::Value;

/// Bead that falls in a gas or a liquid at rest, with Stokes drag; `@` stands for the fluid. With a single particle,
/// the model "drag in suspensions" makes no sense.
const FALL: &str = r#"
[domain]
size = ["1 m", "1 m", "1 m"]
periodic = ["x", "y", "z"]
[gravity]
acceleration = ["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"]
[fluid]
@
[fluid.profile.uniform]
velocity = "0 m/s"
[drag.stokes]
[[particles]]
name = "bead"
diameter = "1 mm"
density = "2500 kg/m^3"
at = [{ position = ["200 mm", "500 mm", "500 mm"] }]
[contact]
restitution = 0.9
[soft.linear_spring_dashpot]
stiffness = "1000 N/m"
[run]
model = "soft"
duration = "50 ms"
"#;
const AIR: &str = "density = \"1.2 kg/m^3\"\nkinematic_viscosity = \"1.5e-5 m^2/s\"";
const WATER: &str = "density = \"1000 kg/m^3\"\nkinematic_viscosity = \"1e-6 m^2/s\"";

/// Runs `needs` and returns the exit code, what it says and `summary.json`.
fn needs(text: &str, more: &[&str]) -> (Option<i32>, String, Value) {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("case.toml"), folder.path().join("out"));
    std::fs::write(&file, text).unwrap();
    let arguments = ["needs", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let output = diptych(&[&arguments[..], more].concat()).output().unwrap();
    let said = words(&output.stdout) + &words(&output.stderr);
    let summary = std::fs::read(out.join("summary.json")).map(|bytes| serde_json::from_slice(&bytes).unwrap());
    (output.status.code(), said, summary.unwrap_or_default())
}

fn factor<'a>(summary: &'a Value, name: &str) -> &'a Value {
    summary["factors"].as_array().unwrap().iter().find(|factor| factor["name"] == name).unwrap()
}

/// Without buoyancy and added mass a bead falls from rest with the velocity g τ (1 - exp(-t/τ)), with the response
/// time τ = ρ_p d²/(18 ρ_f ν) (bead: ρ_p, d; fluid: ρ_f, ν). With them τ grows by 1 + ρ_f/(2 ρ_p), and g is multiplied
/// by (1 - ρ_f/ρ_p)/(1 + ρ_f/(2 ρ_p)). So the shift of the final velocity is known; splitting errors are below 1e-4 of
/// the velocity.
#[test]
fn buoyancy_and_added_mass_are_needed_in_water_and_not_in_air() {
    let velocity = |density: f64, viscosity: f64, richest: bool| {
        let ratio = if richest { density / 2500.0 } else { 0.0 };
        let time = 2500.0 * 1e-6 / (18.0 * density * viscosity) * (1.0 + 0.5 * ratio);
        9.81 * (1.0 - ratio) / (1.0 + 0.5 * ratio) * time * (1.0 - (-0.05_f64 / time).exp())
    };
    for (fluid, density, viscosity, needed) in [(AIR, 1.2, 1.5e-5, false), (WATER, 1000.0, 1e-6, true)] {
        let (code, said, summary) = needs(&FALL.replace('@', fluid), &[]);
        assert_eq!(code, Some(0), "{said}");
        let wanted = velocity(density, viscosity, false) / velocity(density, viscosity, true) - 1.0;
        let shifts = factor(&summary, "buoyancy")["shifts"].as_array().unwrap().clone();
        let shift = shifts.iter().find(|shift| shift["observable"].as_str().unwrap().contains("velocity")).unwrap();
        let share = (shift["difference"].as_f64().unwrap() / shift["scale"].as_f64().unwrap()).abs();
        assert!((share - wanted).abs() < 1e-4 + 1e-3 * wanted, "{share} {wanted}");
        let is_needed = said.contains("Needed, since without it something shifts beyond the margin: buoyancy");
        assert_eq!(is_needed, needed, "{said}");
        // nothing touches, so that contacts can be left out in either way; the first sentence names what can be left out
        let first = said.lines().find(|line| line.contains("this scene can do without")).unwrap_or(&said);
        assert!(first.contains("contacts that last") || first.contains("places of collisions"), "{said}");
        assert_eq!(first.contains("buoyancy and added mass"), !needed, "{said}");
        // several models that are left out together get a run of their own
        if !needed {
            assert_eq!(factor(&summary, "cheapest")["verdict"], "equivalent", "{said}");
        }
    }
}

#[test]
fn models_that_a_scene_cannot_have_are_named_with_the_reason() {
    let (code, said, _) = needs(&FALL.replace('@', AIR), &["--plan"]);
    assert_eq!(code, Some(0), "{said}");
    for words in [
        "left out: turbulence, as the gas has no k and ε",
        "left out: two-way, as the gas flow is not computed",
        "left out: friction, as the case gives none",
        "left out: facets, as the case gives none",
        "left out: rotation, as no friction turns a particle",
        "left out: lift, as the gas is not sheared",
        "added: half the displaced gas as added mass",
    ] {
        assert!(said.contains(words), "{words} in {said}");
    }
}

/// Without gravity there is no buoyancy, but a bead that drag accelerates has added mass.
#[test]
fn added_mass_is_studied_without_gravity() {
    let gravity = FALL.find("[gravity]").unwrap()..FALL.find("[fluid]").unwrap();
    let mut weightless = FALL.replace('@', WATER);
    weightless.replace_range(gravity, "");
    let (code, said, _) = needs(&weightless, &["--plan"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("added: half the displaced gas as added mass"), "{said}");
    assert!(!said.contains("left out: buoyancy"), "{said}");
}

/// If a wall of the case has inclined facets (a model of roughness), `needs` also runs the case without facets.
#[test]
fn inclined_facets_are_left_out() {
    let floor = "[[walls]]\nplane = { point = [0, 0, 0], normal = [0, 0, 1] }\nrestitution = 0.9\n\
                 roughness = { deviation = \"10 deg\" }\n[contact]";
    let rough = FALL.replace('@', AIR).replace("[contact]", floor);
    let (code, said, _) =
        needs(&rough.replace("periodic = [\"x\", \"y\", \"z\"]", "periodic = [\"x\", \"y\"]"), &["--plan"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("without inclined facets of walls  (the case has it)"), "{said}");
    assert!(!said.contains("left out: facets"), "{said}");
}

/// If gravity acts across the flow of a gas, two-way coupling (a gas that feels the particles) is impossible.
#[test]
fn a_gas_under_gravity_across_its_flow_does_not_feel_the_particles() {
    let across = FALL
        .replace('@', AIR)
        .replace(
            "[fluid.profile.uniform]\nvelocity = \"0 m/s\"",
            "[fluid.profile.k_epsilon_channel]\nreynolds_number = 600000",
        )
        .replace("periodic = [\"x\", \"y\", \"z\"]", "periodic = [\"x\", \"z\"]")
        .replace("\"0 m/s^2\", \"0 m/s^2\", \"-9.81 m/s^2\"", "\"0 m/s^2\", \"-9.81 m/s^2\", \"0 m/s^2\"");
    let (code, said, _) = needs(&across, &["--plan"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("left out: two-way, as gravity acts across the flow"), "{said}");
    assert!(said.contains("added: k and ε of the k-ε model"), "{said}");
}

/// Hard spheres and collisions by chance stop if a ball slides on a floor. For `needs`, that is an answer and no
/// error.
#[test]
fn a_model_without_which_a_run_stops_cannot_be_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = diptych(&["needs", "rotation/slide-to-roll", "--out", out.to_str().unwrap()]).output().unwrap();
    let said = words(&output.stdout) + &words(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("Contacts that last (hard spheres have none) cannot be left out: \"hard\": "), "{said}");
    assert!(said.contains("something shifts beyond the margin: rotation ("), "{said}");
}
