//! Beads that flow out of a vessel, compared with Beverloo's law.

use diptych::case::Case;
use diptych::engine::Failure;
use diptych::experiment::Model;
use diptych::placement::initial_state;
use diptych::simulation::Simulation;
use std::path::Path;

/// Flow rate [kg/s] of beads of diameter d through a hole of diameter D by Beverloo, Leniger and van de Velde 1961,
/// Chem. Eng. Sci. 15, 260: W = C ρ_b sqrt(g) (D - k d)^2.5. Here C = 0.58, k = 1.4, g is gravity, and the bulk
/// density ρ_b is 0.6 of the density of the beads.
fn beverloo(hole: f64) -> f64 {
    0.58 * 0.6 * 2500.0 * 9.81_f64.sqrt() * (hole - 1.4 * 2e-3).powf(2.5)
}

fn case(model: Model, sets: &[&str]) -> Simulation {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/walls/discharge.toml");
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
    let (experiment, _) = Case::read(&path, &sets).unwrap().experiment(Some(model), None).unwrap();
    Simulation::new(&experiment, initial_state(&experiment).unwrap())
}

/// [kg/s] measured flow rate from 0.3 s to `until` [s]: mean momentum of the beads along the fall, divided by the
/// height of the box. `scale` is a factor on the size of the vessel and its hole.
fn rate(model: Model, scale: f64, until: f64) -> f64 {
    let mut simulation = case(model, &[&format!("walls[1].mesh.scale={scale}")]);
    simulation.run(50, 6e-3).unwrap();
    let (mut sum, mut samples) = (0.0, 0.0);
    while simulation.time < until {
        simulation.run(1, 6e-3).unwrap();
        sum -= simulation.particles.momentum().z / 0.12;
        samples += 1.0;
    }
    sum / samples
}

/// The flow rate of beads that do not rotate is between half and all of Beverloo's law with k = 1.4, since these beads
/// flow as by a larger k. Soft and hybrid spheres have equal rates. A run of hard spheres stops when beads come to
/// rest.
#[test]
#[ignore = "minutes: 3000 beads for a second, four times"]
fn flow_rates_follow_beverloo() {
    let soft = [0.75, 1.0, 1.25].map(|scale| rate(Model::Soft, scale, 1.2));
    let ratios: Vec<f64> = [0.009, 0.012, 0.015].iter().zip(&soft).map(|(hole, rate)| rate / beverloo(*hole)).collect();
    let hybrid = rate(Model::Hybrid, 1.0, 1.2);
    println!("soft {soft:?} kg/s, over Beverloo's {ratios:?}; hybrid {hybrid} kg/s");
    assert!(ratios.iter().all(|ratio| (0.5..1.0).contains(ratio)), "{ratios:?}");
    assert!(ratios[0] < ratios[1] && ratios[1] < ratios[2], "the smallest hole is hindered most: {ratios:?}");
    assert!((hybrid / soft[1] - 1.0).abs() < 0.1, "{hybrid} and {}", soft[1]);
}

#[test]
fn hard_beads_stop_when_they_come_to_rest() {
    let mut simulation = case(Model::Hard, &["particles[0].count=300"]);
    let why = simulation.run(200, 6e-3).unwrap_err();
    assert!(matches!(why, Failure::InelasticCollapse { .. }), "{why}");
    // no earlier than the first beads fall from the middle of the box onto the bottom
    assert!(simulation.time > 0.02 && simulation.time < 0.5, "{}", simulation.time);
}
