//! Every case of the project runs for a few windows, with each engine.

use diptych::case::Case;
use diptych::contact_law::ContactLaw;
use diptych::domain::Domain;
use diptych::engine::Failure;
use diptych::experiment::{Amount, Experiment, Model, SoftStepping, Spheres};
use diptych::placement::initial_state;
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;
use std::path::{Path, PathBuf};

/// Largest number of particles in a run of these tests.
const FEW: usize = 500;

fn cases() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    for folder in
        ["cases", "cases/driven", "cases/mixtures", "cases/paper", "cases/rotation", "cases/turbulence", "cases/walls"]
    {
        let files = std::fs::read_dir(root.join(folder)).unwrap().map(|entry| entry.unwrap().path());
        found.extend(files.filter(|path| path.extension().is_some_and(|extension| extension == "toml")));
    }
    found.sort();
    found
}

/// Puts the case into a smaller box: periodic sides are shortened to no less than eight diameters, until few particles
/// are left.
fn smaller(experiment: &mut Experiment) {
    let (all, scene) = (experiment.count(), &mut experiment.scene);
    let placed = |amount: &Amount| matches!(amount, Amount::Placed(_));
    // a body inside the box has a fixed position
    let bodies = scene.walls.iter().any(|wall| wall.geometry.law().bounds().is_some());
    if all <= FEW || bodies || experiment.start.iter().any(|population| placed(&population.amount)) {
        return;
    }
    let diameter = scene.species.iter().map(|species| species.diameter).fold(0.0, f64::max);
    let sides: Vec<usize> = (0..3).filter(|axis| scene.domain.periodic[*axis]).collect();
    let factor = (FEW as f64 / all as f64).powf(1.0 / sides.len() as f64);
    let (mut size, mut share) = (scene.domain.size, 1.0);
    for axis in sides {
        let side = size[axis];
        let shorter = (factor * side).max(8.0 * diameter).min(side);
        size[axis] = shorter;
        share *= shorter / side;
    }
    scene.domain = Domain::new(size, scene.domain.periodic);
    for population in &mut experiment.start {
        population.amount = Amount::Count((population.amount.count() as f64 * share).ceil() as usize);
    }
}

/// Cases whose particles come to rest on a wall in the first windows of the engine with collisions by chance.
const RESTS: [&str; 4] = ["column.toml", "slide-to-roll.toml", "incline.toml", "three-balls.toml"];

/// Runs three windows (pieces of a run) of at most about 20 contact times. Longer windows would take too many time
/// steps of soft spheres.
fn few_windows(name: &str, experiment: &Experiment) {
    let start = initial_state(experiment).unwrap_or_else(|why| panic!("{name}: {why}"));
    let (count, mut simulation) = (start.len(), Simulation::new(experiment, start));
    let window = Schedule::new(experiment).window.min(2e-4);
    let result = simulation.run(3, window);
    if ["column.toml, Hard", "slide-to-roll.toml, Hard", "incline.toml, Hard", "three-balls.toml, Hard"]
        .iter()
        .any(|stops| name.contains(stops))
    {
        // as these cases say, spheres on the floor cannot rest without a contact time
        return assert!(matches!(result, Err(Failure::InelasticCollapse { .. })), "{name}: {result:?}");
    }
    if RESTS.iter().any(|stops| name.contains(&format!("{stops}, Dsmc"))) {
        // the same cases, and beds of particles on the floor
        return assert!(matches!(result, Err(Failure::RestOnWall { .. })), "{name}: {result:?}");
    }
    result.unwrap_or_else(|why| panic!("{name}: {why}"));
    let stays = !experiment.scene.has_openings();
    assert_eq!((stays && simulation.particles.len() != count, simulation.windows), (false, 3), "{name}");
    assert!((simulation.time / (3.0 * window) - 1.0).abs() < 1e-12, "{name}");
    let finite = simulation.particles.position.iter().chain(&simulation.particles.velocity);
    assert!(finite.flatten().all(|value| value.is_finite()), "{name}");
}

#[test]
fn every_case_runs_with_each_engine() {
    let (mut runs, mut refused) = (0, 0);
    for path in cases() {
        let case = Case::read(&path, &[]).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
        let variants = case.variants(None).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
        // one variant of each model in the case, and the case itself with the other engines
        for model in [Model::Soft, Model::Hard, Model::Hybrid, Model::Dsmc] {
            let own = variants.iter().map(|(experiment, _)| experiment).find(|one| one.model() == model);
            let Some(mut experiment) = own.cloned().or_else(|| other(&variants[0].0, model)) else { continue };
            let servo = experiment.scene.walls.iter().any(|wall| wall.servo().is_some());
            if (model == Model::Dsmc && experiment.scene.has_moving_walls()) || (model == Model::Hard && servo) {
                // the reader refuses walls that move with collisions by chance, and servo walls without contacts
                refused += 1;
                continue;
            }
            smaller(&mut experiment);
            let steppings: &[SoftStepping] = match model {
                Model::Soft => &[SoftStepping::Uniform, SoftStepping::Local, SoftStepping::Auto],
                Model::Hard | Model::Hybrid | Model::Dsmc => &[SoftStepping::Auto],
            };
            for &stepping in steppings {
                experiment.soft.stepping = stepping;
                few_windows(&format!("{}, {model:?}, {stepping:?}", path.display()), &experiment);
                runs += 1;
            }
        }
    }
    // four engines, one of them in three ways
    assert_eq!(runs + refused, 6 * cases().len());
    assert_eq!(refused, 8);
}

/// Experiment of the case with another model; `None` if the case has no contact law for soft spheres.
fn other(experiment: &Experiment, model: Model) -> Option<Experiment> {
    let mut experiment = experiment.clone();
    experiment.run.spheres = match model {
        Model::Soft => Spheres::Soft(experiment.soft.law.unwrap_or(ContactLaw::linear(3000.0))),
        Model::Hard => Spheres::Hard,
        Model::Dsmc => Spheres::Dsmc,
        Model::Hybrid => Spheres::Hybrid(experiment.soft.law.unwrap_or(ContactLaw::linear(3000.0))),
    };
    Some(experiment)
}

/// The parameters that are written for a run contain inlets, outlets, two-way coupling, and the settings of the model.
#[test]
fn parameters_name_what_the_case_sets() {
    let rows = [
        (
            "driven/chute.toml",
            "run.seed=1",
            None,
            &["/inlets/0/species", "/inlets/0/region/box/center", "/outlets/0/name"][..],
        ),
        ("coupling/channel-d.toml", "fluid.coupling.modulation=none", None, &["/fluid/coupling/slices"]),
        ("dense-gas.toml", "run.seed=1", Some(Model::Dsmc), &["/dsmc/enskog"]),
        ("dense-gas.toml", "run.seed=1", Some(Model::Hybrid), &["/hybrid/clearance"]),
    ];
    for (name, set, model, wanted) in rows {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases").join(name);
        let case = Case::read(&path, &[set.to_owned()]).unwrap();
        let (experiment, _) = case.experiment(model, None).unwrap();
        let value = diptych::case::parameters(&experiment);
        assert!(wanted.iter().all(|place| value.pointer(place).is_some_and(|found| !found.is_null())), "{value:#}");
    }
}
