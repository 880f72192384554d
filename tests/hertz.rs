//! Hertzian contacts: restitution, contact time and overlap of single impacts, both ways of stepping, and the studies.

use crate::support::*;
use diptych::case::Case;
use diptych::contact_law::{Bodies, ContactLaw, Hertz};
use diptych::engine::soft::Soft;
use diptych::experiment::{Integrator, Model, SoftStepping, Spheres};
use diptych::placement::initial_state;
use diptych::scene::Elasticity;
use diptych::simulation::Simulation;
use diptych::study::{execute, plan_of};
use std::path::Path;
use std::process::{Command, Output};

/// Contact law of polystyrene, softened by a factor of a hundred, so that overlaps are as large as in the paper
/// (docs/paper.md).
const SOFTENED: ContactLaw =
    ContactLaw::Hertz(Hertz { elasticity: Elasticity { youngs_modulus: 30e6, poissons_ratio: 0.3 } });

/// Head-on impact at a relative speed [m/s]: restitution in the run, then duration and largest overlap, both divided
/// by those of theory.
fn impact(restitution: f64, speed: f64, steps: f64, stepping: SoftStepping) -> [f64; 3] {
    let scene = empty([4e-3; 3], [false; 3], small(), surface(restitution, 0.0));
    let gap = 1e-6;
    let right = 2e-3 + 406e-6 + gap;
    let start = [([2e-3; 3], [0.5 * speed, 0.0, 0.0]), ([right, 2e-3, 2e-3], [-0.5 * speed, 0.0, 0.0])];
    let particles = placed(&scene, &start);
    let spring = SOFTENED.between(&Bodies::alike(&small(), &scene.contact));
    let time = SOFTENED.contact_time(&spring, speed);
    let engine = Soft::new(SOFTENED, Integrator::VelocityVerlet, time / steps, stepping);
    let mut simulation = Simulation::with_engine(scene, particles, Box::new(engine));
    simulation.run(1, gap / speed + 1.5 * time).unwrap();
    let pairs = simulation.record.pairs.summary();
    assert_eq!(pairs.count, 1);
    let deepest = SOFTENED.greatest_overlap(&spring, speed);
    [
        pairs.mean_restitution.unwrap(),
        pairs.mean_duration.unwrap() / time,
        pairs.largest_overlap.unwrap() * 406e-6 / deepest,
    ]
}

/// Theory of Antypov and Elliott: the prescribed restitution at every speed, and closed forms of contact time and
/// overlap.
///
/// The viscous force begins as the fourth root of the overlap, and therefore of time. A step that begins at the touch
/// misses a part of its impulse. This part is of order 1 + 1/4 in the step, for any order of the method. With 200
/// steps per contact and the restitution 0.5 it is 2e-4.
#[test]
fn single_impacts_are_those_of_theory() {
    for restitution in [1.0, 0.9, 0.5] {
        for speed in [0.01, 0.1, 1.0] {
            let [e, time, depth] = impact(restitution, speed, 200.0, SoftStepping::Local);
            assert!((e - restitution).abs() < 2.5e-4, "e = {restitution}, u = {speed}: {e}");
            assert!(
                (time - 1.0).abs() < 2.5e-4 && (depth - 1.0).abs() < 2.5e-4,
                "{restitution} {speed}: {time} {depth}"
            );
            // with uniform steps, the touch is detected up to a step late: an error of first order in restitution and
            // contact time
            let [e, time, depth] = impact(restitution, speed, 200.0, SoftStepping::Uniform);
            assert!((e - restitution).abs() < 5e-3, "uniform, e = {restitution}, u = {speed}: {e}");
            assert!((time - 1.0).abs() < 2.0 / 200.0 && (depth - 1.0).abs() < 5e-3, "{time} {depth}");
        }
    }
}

#[test]
fn the_order_at_the_touch_is_five_quarters() {
    let miss = |steps: f64| (impact(0.5, 0.1, steps, SoftStepping::Local)[0] - 0.5).abs();
    for steps in [25.0, 100.0] {
        let order = (miss(steps) / miss(4.0 * steps)).log2() / 2.0;
        assert!((order - 1.25).abs() < 0.15, "{steps}: {order}");
    }
}

#[test]
fn contacts_last_longer_the_slower_they_are() {
    let spring = SOFTENED.between(&Bodies::alike(&small(), &surface(0.8, 0.0)));
    let ratio = SOFTENED.contact_time(&spring, 0.01) / SOFTENED.contact_time(&spring, 1.0);
    assert!((ratio / 100f64.powf(0.2) - 1.0).abs() < 1e-12, "{ratio}");
    let depth = SOFTENED.greatest_overlap(&spring, 1.0) / SOFTENED.greatest_overlap(&spring, 0.01);
    assert!((depth / 100f64.powf(0.8) - 1.0).abs() < 1e-12, "{depth}");
}

/// A wall or a species may have its own elasticity. With a rigid wall, only the sphere is compliant.
#[test]
fn a_wall_may_have_its_own_elasticity() {
    let mut wall = plane([0.0; 3], [0.0, 1.0, 0.0], surface(1.0, 0.0));
    let alike = SOFTENED.between(&Bodies::of_wall(&small(), &wall.surface, wall.elasticity));
    wall.elasticity = Some(Elasticity { youngs_modulus: 30e15, poissons_ratio: 0.3 });
    let rigid = SOFTENED.between(&Bodies::of_wall(&small(), &wall.surface, wall.elasticity));
    assert!((rigid.stiffness / alike.stiffness - 2.0).abs() < 1e-8);
}

/// The command `plan` and the engine use the same contact law. Predicted overlaps are those of the run within 8 %,
/// which allows for oblique contacts and contacts of three bodies.
#[test]
fn a_gas_of_hertzian_spheres_is_planned_and_run() {
    let path = root().join("cases/dense-gas.toml");
    let sets = ["run.duration=2 ms", "run.average_from=0 s", "particles[0].volume_fraction=0.1"].map(String::from);
    let (mut gas, _) = Case::read(&path, &sets).and_then(|case| case.experiment(None, None)).unwrap();
    gas.soft.law = Some(SOFTENED);
    gas.run.spheres = Spheres::Soft(SOFTENED);
    let plan = plan_of(&gas, 0.01, false).unwrap();
    assert!(plan.recommendation.law.is_some_and(|law| law.title() == "Hertz"), "{:?}", plan.recommendation);
    for stepping in [SoftStepping::Local, SoftStepping::Uniform] {
        gas.soft.stepping = stepping;
        let outcome = execute(&gas, initial_state(&gas).unwrap(), &mut []).0;
        assert!(outcome.failure.is_none(), "{:?}", outcome.failure);
        let pairs = outcome.record.pairs.summary();
        assert!(pairs.count > 500, "{pairs:?}");
        let predicted = &plan.plan.contacts[0];
        assert!(
            (predicted.mean_overlap / pairs.mean_maximum_overlap.unwrap() - 1.0).abs() < 0.08,
            "{predicted:?} {pairs:?}"
        );
        assert!(
            (predicted.overlap_99 / pairs.p99_maximum_overlap.unwrap() - 1.0).abs() < 0.15,
            "{predicted:?} {pairs:?}"
        );
        // elastic spheres conserve their energy; gains that depend on the phase of an impact average out over all
        // impacts
        let kept = outcome.energy_at_end / outcome.energy_at_start - 1.0;
        assert!(kept.abs() < 1e-3, "{stepping:?}: {kept}");
    }
}

/// The case `cases/hertz.toml` of one impact gives the numbers that its heading states.
#[test]
fn the_case_of_one_impact() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("impact");
    let output = diptych(&["impact", "cases/hertz.toml", "--quiet", "--out", out.to_str().unwrap()]);
    assert!(output.status.success(), "{output:?}");
    let summary: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
    for (variant, time) in [(1, 2.9e-6), (2, 7.7e-6)] {
        let variant = &summary["variants"][variant];
        let value = |key: &str| variant[key].as_f64().unwrap_or_else(|| panic!("{key}: {variant}"));
        assert!((value("restitution") - 0.9).abs() < 1e-4);
        assert!((value("contact_time") / time - 1.0).abs() < 0.02, "{variant}");
    }
}

/// A message about a bad Hertzian contact contains the line in the case.
#[test]
fn bad_elasticity_is_refused() {
    let path = root().join("cases/hertz.toml");
    let refused = |set: &str| {
        let case = Case::read(&path, &[set.to_owned()]).and_then(|case| case.experiment(None, None));
        case.unwrap_err().to_string()
    };
    assert!(refused("soft.hertz.youngs_modulus=0 Pa").contains("greater than 0 Pa"));
    assert!(refused("soft.hertz.poissons_ratio=0.6").contains("up to 0.5"));
    assert!(refused("soft.hertz.youngs_modulus=3000 N/m").contains("pressure"));
    let both = std::fs::read_to_string(&path).unwrap() + "\n[soft.linear_spring_dashpot]\nstiffness = \"3000 N/m\"\n";
    let both = Case::from_text(&path, both.into(), &[]).and_then(|case| case.experiment(None, None)).unwrap_err();
    assert!(both.to_string().contains("keep one of `linear_spring_dashpot`, `hertz` and `kuwabara_kono`"), "{both}");
    // a law on the command line replaces that of the case
    let other = Case::read(&path, &["soft.linear_spring_dashpot.stiffness=3000 N/m".into()]).unwrap();
    assert!(other.experiment(Some(Model::Soft), None).unwrap().0.law().unwrap().is_linear());
    assert!(
        refused("particles[0].elasticity.poissons_ratio=0.3")
            .contains("missing: `particles[0].elasticity.youngs_modulus`")
    );
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn diptych(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_diptych")).current_dir(root()).args(arguments).output().unwrap()
}
