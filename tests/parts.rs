//! Starts that several processes make in parts, and runs from such starts. In the tests, threads take the place of
//! processes.

use crate::support::*;
use diptych::Ledger;
use diptych::Vector3;
use diptych::checkpoint::{RunIdentity, Store, StoredRun};
use diptych::communicator::Communicator;
use diptych::contact_law::ContactLaw;
use diptych::experiment::{Amount, Experiment, HardStepping, Model, SoftStepping, Spheres};
use diptych::observe::RunLoop;
use diptych::particles::{Particles, fingerprint_of, for_each_slice};
use diptych::placement::{Start, comes_in_parts, initial_state};
use diptych::scene::Inlet;
use diptych::schedule::Schedule;
use diptych::simulation::{Simulation, Snapshot};
use diptych::walls::{Cavity, Hollow};
use std::sync::Arc;

/// Results of `work` in each of `size` processes.
fn over<T: Send>(size: usize, work: impl Fn(Arc<dyn Communicator>) -> T + Sync) -> Vec<T> {
    std::thread::scope(|scope| {
        let work = &work;
        let crew: Vec<_> = Crew::of(size).into_iter().map(|one| scope.spawn(move || work(one))).collect();
        crew.into_iter().map(|one| one.join().unwrap()).collect()
    })
}

/// All particles of several parts, in the order of their ids.
fn together(parts: &[Particles]) -> Particles {
    let mut all = Particles::default();
    parts.iter().for_each(|part| all.copy_from(part, &(0..part.len() as u32).collect::<Vec<u32>>()));
    all.sort_by_id();
    all
}

fn pipe(model: Model) -> Experiment {
    case(include_str!("../cases/walls/pipe.toml"), model, &["particles.0.count=1500"]).unwrap()
}

fn two_kinds(model: Model) -> Experiment {
    let small = ["domain.size=[\"20 mm\", \"40 mm\", \"16 mm\"]", "statistics.slices=8"];
    case(include_str!("../cases/mixtures/binary-channel.toml"), model, &small).unwrap()
}

/// Experiment of spheres that rotate, with random spins at the start.
fn rough(model: Model) -> Experiment {
    let small = ["domain.size=[\"8 mm\", \"8 mm\", \"8 mm\"]"];
    case(include_str!("../cases/rotation/rough-gas.toml"), model, &small).unwrap()
}

/// Experiment of a gas so dense that half of the particles overlap another particle in their first random positions.
fn crowded() -> Experiment {
    let edge = edge(3000, small().diameter, 0.19);
    let mut scene = empty([edge; 3], [true, false, true], small(), surface(0.9, 0.0));
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.0)),
        plane([0.0, edge, 0.0], [0.0, -1.0, 0.0], surface(0.9, 0.0)),
    ];
    experiment(scene, 3000, [0.0, 0.0, 0.1], 0.5, Model::Hard, 5)
}

/// Experiment of the dense gas, with an inlet in its middle. The ids of new particles follow those of all parts.
fn fed() -> Experiment {
    let mut fed = crowded();
    let (middle, half) = (0.5 * fed.scene.domain.size, Vector3::repeat(2.0 * small().diameter));
    fed.scene.inlets = vec![Inlet {
        name: "feed".into(),
        species: 0,
        region: Hollow::new(Cavity::Box { center: middle, half_extents: half }),
        rate: 2e4,
        start: 0.0,
        end: f64::INFINITY,
        velocity_mean: Vector3::zeros(),
        velocity_fluctuation: Vector3::repeat(0.5),
        spin_mean: Vector3::zeros(),
        spin_fluctuation: 0.0,
    }];
    fed
}

#[test]
fn parts_of_a_start_are_the_start_that_one_process_makes() {
    let starts = [
        ("pipe", pipe(Model::Hard)),
        ("two kinds", two_kinds(Model::Soft)),
        ("rough", rough(Model::Soft)),
        ("crowded", crowded()),
    ];
    for (name, experiment) in &starts {
        assert!(comes_in_parts(experiment), "{name}");
        let whole = initial_state(experiment).unwrap();
        for size in [1, 2, 3, 5, 12] {
            let starts = over(size, |communicator| Start::part(experiment, &*communicator).unwrap());
            for start in &starts {
                assert!(start.is_part && start.particles.id.is_sorted(), "{name} on {size}");
                assert_eq!((start.count, start.fingerprint), (whole.len(), whole.fingerprint()), "{name} on {size}");
            }
            let parts: Vec<Particles> = starts.into_iter().map(|start| start.particles).collect();
            assert!(size == 1 || parts.iter().all(|part| part.len() < whole.len()), "{name} on {size}");
            assert!(together(&parts) == whole, "{name} on {size}");
        }
    }
}

#[test]
fn a_start_that_needs_all_particles_is_made_whole_by_every_process() {
    let (mut dense, mut placed) = (crowded(), crowded());
    dense.scene.domain.size *= 0.9;
    placed.start[0].amount = Amount::Placed(initial_state(&crowded()).unwrap());
    for experiment in [dense, placed] {
        let whole = initial_state(&experiment).unwrap();
        for start in over(3, |communicator| Start::part(&experiment, &*communicator).unwrap()) {
            assert!(!start.is_part && start.particles == whole && start.fingerprint == whole.fingerprint());
        }
    }
}

#[test]
fn too_many_particles_are_refused_by_all_processes_alike() {
    let mut full = crowded();
    // three spheres in less room than a single sphere needs
    full.start[0].amount = Amount::Count(3);
    let height = 0.9 * full.scene.species[0].diameter;
    full.scene.walls.push(plane([0.0, height, 0.0], [0.0, -1.0, 0.0], surface(0.9, 0.0)));
    let why = initial_state(&full).unwrap_err();
    assert!(comes_in_parts(&full));
    for other in over(2, |communicator| Start::part(&full, &*communicator).unwrap_err()) {
        assert_eq!(other, why);
    }
}

#[test]
fn slices_of_parts_are_all_particles_in_order() {
    let particles = random(&crowded().scene, 3000, 0.5, 7);
    let seen = over(3, |communicator| {
        let own: Vec<u32> = (0..3000).rev().filter(|id| id * id % 7 % 3 == communicator.rank() as u32).collect();
        let mut part = particles.clone();
        part.reorder(&own);
        let mut seen = Vec::new();
        for_each_slice(&part, Some(&*communicator), &mut |slice| seen.extend(slice.id.clone()));
        assert_eq!(fingerprint_of(&part, Some(&*communicator)), particles.fingerprint());
        seen
    });
    assert_eq!(seen, [(0..3000).collect::<Vec<u32>>(), Vec::new(), Vec::new()]);
}

/// Checksum of the state and sums over all particles, after some windows of a run that `size` processes begin in
/// parts.
fn run_in_parts(experiment: &Experiment, size: usize) -> (u64, String) {
    let run = |communicator: Arc<dyn Communicator>| {
        let start = Start::part(experiment, &*communicator).unwrap();
        let simulation = Simulation::part(experiment, start.particles, &*communicator);
        let simulation = simulation.shared_in_parts(communicator.clone(), 0);
        if communicator.is_lead() {
            return Some(moved(simulation));
        }
        simulation.follow(&mut |_, _, _| {});
        None
    };
    over(size, run).swap_remove(0).unwrap()
}

fn moved(simulation: Simulation) -> (u64, String) {
    moved_by(simulation, 12, 2e-4)
}

fn moved_by(mut simulation: Simulation, windows: u64, window: f64) -> (u64, String) {
    simulation.run_while(windows, window, &mut |_, _| true).unwrap();
    let hash = simulation.fingerprint();
    let known = (simulation.count(), simulation.total_mass(), simulation.mean_velocity(), simulation.mean_radius());
    simulation.gather(1);
    assert_eq!(simulation.state().fingerprint(), hash);
    let record = &simulation.record;
    let ledger: &Ledger = &record.ledger;
    (hash, format!("{known:?} {} {} {ledger:?}", record.pairs.count, record.walls.count))
}

#[test]
fn runs_that_begin_in_parts_give_the_bits_of_one_process() {
    let mut stepped = two_kinds(Model::Hard);
    stepped.hard.stepping = HardStepping::Steps { theta: 0.2 };
    let mut uniform = pipe(Model::Soft);
    uniform.soft.stepping = SoftStepping::Uniform;
    let mut rough_uniform = rough(Model::Soft);
    rough_uniform.soft.stepping = SoftStepping::Uniform;
    let runs = [
        ("pipe, soft", pipe(Model::Soft)),
        ("two kinds, hard", two_kinds(Model::Hard)),
        ("two kinds, hybrid", two_kinds(Model::Hybrid)),
        ("crowded, hard", crowded()),
        ("inlet", fed()),
        ("stepped", stepped),
        ("all at once", uniform),
        ("rough, soft", rough(Model::Soft)),
        ("rough, hybrid", rough(Model::Hybrid)),
        ("rough, all at once", rough_uniform),
    ];
    for (name, experiment) in &runs {
        let alone = moved(Simulation::new(experiment, initial_state(experiment).unwrap()));
        for size in [2, 3, 5] {
            assert_eq!(run_in_parts(experiment, size), alone, "{name} on {size}");
        }
    }
}

/// A column of ten spheres is moved by the lead process alone until islands are tried again. The contacts in progress
/// are then all in the lead process; the other processes must take the same decisions as if they had them too.
#[test]
fn processes_decide_alike_while_one_process_has_all_contacts() {
    let column = case(include_str!("../cases/column.toml"), Model::Hybrid, &[]).unwrap();
    let start = || Simulation::new(&column, initial_state(&column).unwrap());
    let alone = moved_by(start(), 20, 3e-4);
    for size in [2, 3] {
        let run = |communicator: Arc<dyn Communicator>| {
            let simulation = start().shared(communicator.clone(), 0);
            if communicator.is_lead() {
                return Some(moved_by(simulation, 20, 3e-4));
            }
            simulation.follow(&mut |_, _, _| {});
            None
        };
        assert_eq!(over(size, run).swap_remove(0).unwrap(), alone, "on {size}");
    }
}

/// Experiment of a gas of soft spheres with contacts that last for many windows.
fn lingering() -> Experiment {
    let edge = edge(3000, small().diameter, 0.03);
    let mut scene = empty([edge; 3], [true, false, true], small(), surface(0.9, 0.2));
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.2)),
        plane([0.0, edge, 0.0], [0.0, -1.0, 0.0], surface(0.9, 0.2)),
    ];
    let mut experiment = experiment(scene, 3000, [0.0, 0.0, 0.1], 0.5, Model::Soft, 5);
    experiment.run.spheres = Spheres::Soft(ContactLaw::linear(30.0));
    experiment.soft.stepping = SoftStepping::Local;
    experiment
}

/// Stored state of a run in progress: the parts of the particles of all processes, and the rest, which is common.
type Left = (Vec<Vec<u8>>, Snapshot);

fn leave(simulation: &mut Simulation) -> Left {
    simulation.run_while(11, 1e-5, &mut |_, ran| ran < 8).unwrap();
    let (count, mut parts) = (simulation.parts_of_state(), Vec::new());
    simulation.give_parts(&mut |part| parts.push(part));
    assert_eq!(parts.len(), count);
    (parts, simulation.snapshot().unwrap())
}

fn go_on(simulation: &mut Simulation) -> (u64, u64, f64) {
    simulation.run_while(3, 1e-5, &mut |_, _| true).unwrap();
    let hash = simulation.fingerprint();
    simulation.gather(1);
    (hash, simulation.record.pairs.count, simulation.energy())
}

/// Runs a simulation that begins in parts, in `size` processes. Returns the result of the function `lead` in the lead
/// process. If `dealt` is true, the other processes take parts that the lead gives out.
fn led<T: Send>(size: usize, experiment: &Experiment, dealt: bool, lead: impl Fn(Simulation) -> T + Sync) -> T {
    let work = |communicator: Arc<dyn Communicator>| {
        let start = Start::part(experiment, &*communicator).unwrap();
        let simulation = Simulation::part(experiment, start.particles, &*communicator);
        let mut simulation = simulation.shared_in_parts(communicator.clone(), 0);
        if communicator.is_lead() {
            return Some(lead(simulation));
        }
        if dealt {
            simulation.take_dealt().unwrap();
        }
        simulation.follow(&mut |_, _, _| {});
        None
    };
    over(size, work).swap_remove(0).unwrap()
}

#[test]
fn a_state_in_parts_goes_on_on_any_number_of_processes() {
    let mut hard = lingering();
    hard.run.spheres = Spheres::Hard;
    for (name, experiment) in [("soft", lingering()), ("hard", hard), ("pipe, with drag", pipe(Model::Hard))] {
        let alone = || Simulation::new(&experiment, initial_state(&experiment).unwrap());
        let mut simulation = alone();
        let (no_parts, whole) = leave(&mut simulation);
        let held = simulation.contacts().len();
        assert!(no_parts.is_empty() && (name != "soft" || held > 30), "{name}: {held} in contact");
        let after = go_on(&mut simulation);
        for from in [2, 3, 5] {
            let (parts, snapshot): Left = led(from, &experiment, false, |mut simulation| leave(&mut simulation));
            assert_eq!((parts.len(), snapshot.parts, snapshot.particles.len()), (from, from, 0), "{name}");
            assert_eq!(snapshot.record.pairs.count, whole.record.pairs.count, "{name}");
            let resume = |simulation: Simulation| {
                let mut simulation = simulation.resume(snapshot.clone()).unwrap();
                simulation.take_parts(parts.len(), &mut |number| parts[number].clone()).unwrap();
                go_on(&mut simulation)
            };
            assert_eq!(resume(alone()), after, "{name}, from {from} to one");
            for to in [2, 3, 4] {
                assert_eq!(led(to, &experiment, true, resume), after, "{name}, from {from} to {to}");
            }
        }
    }
}

#[test]
fn parts_that_are_not_all_particles_are_refused() {
    let experiment = lingering();
    let (parts, snapshot) = led(3, &experiment, false, |mut simulation| leave(&mut simulation));
    let fresh = Simulation::new(&experiment, initial_state(&experiment).unwrap());
    let mut simulation = fresh.resume(snapshot).unwrap();
    let without_one = |number: usize| if number == 1 { Vec::new() } else { parts[number].clone() };
    assert!(simulation.take_parts(3, &mut { without_one }).is_err());
}

#[test]
fn a_checkpoint_with_a_part_that_is_damaged_or_of_another_time_is_not_used() {
    let experiment = lingering();
    let (parts, pause) = led(2, &experiment, false, |mut simulation| {
        let (parts, _) = leave(&mut simulation);
        (parts, RunLoop::new(&Schedule::even(1e-5, 1, 11), 0).store(&simulation, &[]).unwrap())
    });
    let folder = tempfile::tempdir().unwrap();
    let (run, kept) = (RunIdentity::new(&experiment, 7).unwrap(), StoredRun { pause, over: None });
    let mut store = Store::of(folder.path());
    let write = |store: &Store| {
        parts.iter().enumerate().for_each(|(number, part)| store.keep_part(&run, false, number, part).unwrap());
    };
    for _ in 0..2 {
        write(&store);
        store.keep(&run, &kept).unwrap();
    }
    let newest = || {
        let mut store = Store::of(folder.path());
        let newest = store.newest();
        let refused: Vec<String> =
            newest.refused.iter().map(|(path, _)| path.file_name().unwrap().to_str().unwrap().to_owned()).collect();
        assert!(newest.found.is_some() && store.part(&run, false, 1).unwrap() == parts[1]);
        (store, refused)
    };
    let (mut store, refused) = newest();
    assert!(refused.is_empty());
    // instead of the first state, a third state was begun but not finished
    write(&store);
    assert_eq!(newest().1, ["a-part-0"]);
    store.keep(&run, &kept).unwrap();
    assert!(newest().1.is_empty());
    let part = folder.path().join("checkpoint/a-part-1");
    let mut bytes = std::fs::read(&part).unwrap();
    bytes[1000] ^= 1;
    std::fs::write(&part, bytes).unwrap();
    assert_eq!(newest().1, ["a-part-1"]);
    store.finish(&run, &kept).unwrap();
    assert!(store.finished(&run).is_err(), "its parts are not there");
    store.remove().unwrap();
    assert!(!folder.path().join("checkpoint").exists());
}
