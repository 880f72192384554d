//! Kinds of contact in a plan: walls of unequal elasticity, and a ball that bounces on.

use crate::support::{plane, surface};
use diptych::case::Case;
use diptych::experiment::Experiment;
use diptych::predict::RunPrediction;
use diptych::scene::Elasticity;
use diptych::study::plan_of;
use std::path::Path;

fn case(name: &str, sets: &[String]) -> Experiment {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases").join(format!("{name}.toml"));
    Case::read(&path, sets).and_then(|case| case.experiment(None, None)).unwrap().0
}

fn planned(experiment: &Experiment) -> RunPrediction {
    plan_of(experiment, 0.01, false).unwrap().plan
}

/// Two walls that differ only in their elasticity are two kinds of contact by Hertz's law, with different contact times.
#[test]
fn walls_of_unequal_elasticity_are_planned_apart() {
    let box_of = |set: &str| {
        let mut hertz = case("hertz", &[]);
        let side = |point: f64, normal: f64| plane([0.0, point, 0.0], [0.0, normal, 0.0], surface(0.9, 0.0));
        hertz.scene.walls = vec![side(0.0, 1.0), side(4e-3, -1.0)];
        hertz.scene.walls[1].elasticity =
            (set == "steel").then_some(Elasticity { youngs_modulus: 2e11, poissons_ratio: 0.3 });
        let kinds = planned(&hertz).contacts;
        kinds.iter().filter(|kind| kind.contact.wall).map(|kind| kind.contact_time).collect::<Vec<f64>>()
    };
    assert_eq!(box_of("alike").len(), 1);
    let [soft, stiff] = box_of("steel")[..] else { panic!("one kind of wall") };
    // the effective modulus of polystyrene against steel is twice that against polystyrene, to 2 %, and Hertz's contact
    // time is proportional to the power -2/5 of the modulus
    assert!((stiff / soft / 2.0_f64.powf(-0.4) - 1.0).abs() < 0.02, "{stiff} {soft}");
}

/// An elastic sphere bounces on during the whole run, and each of its impacts has an error.
#[test]
fn elastic_spheres_are_planned_to_bounce_on() {
    let bounces = |restitution: f64| {
        let bouncing = case("bouncing-sphere", &[format!("walls[0].restitution={restitution}")]);
        let rest = planned(&bouncing).rest.unwrap();
        (rest.bounces(rest.fall + 20.5 * rest.speed / rest.gravity), rest.time.is_finite())
    };
    assert_eq!(bounces(1.0), (11.0, false));
    let (many, ends) = bounces(0.999_999);
    assert!(ends && (many - 11.0).abs() < 1.5, "{many}");
}
