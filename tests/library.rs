//! Programs that use the library: defaults, random starts, `run_until`, files of triangles.

use crate::support::*;
use diptych::case::Case;
use diptych::experiment::{Experiment, Model, Population, Spheres};
use diptych::observe::run;
use diptych::placement::{initial_state, random_start};
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;
use diptych::triangles::TriangleFile;
use diptych::{Domain, Scene, Species, Surface, Vector3};
use std::path::Path;

/// Experiment of the built-in case `quick`, in which gas drags the particles, for 20 ms.
fn blown(model: Model) -> Experiment {
    let sets = ["run.duration=20 ms", "particles[0].volume_fraction=2e-3", "statistics.sample_interval=3 ms"];
    let sets = sets.map(String::from);
    let case = Case::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/quick.toml"), &sets).unwrap();
    case.experiment(Some(model), None).unwrap().0
}

/// Checksum of the particles after all windows of the schedule, run as the program runs them.
fn by_the_program(experiment: &Experiment) -> u64 {
    let mut simulation = Simulation::from_start(experiment).unwrap();
    run(&mut simulation, &Schedule::new(experiment), &mut []).unwrap();
    simulation.state().fingerprint()
}

#[test]
fn run_until_has_the_bits_of_the_program() {
    for model in [Model::Soft, Model::Hard, Model::Hybrid] {
        let experiment = blown(model);
        let schedule = Schedule::new(&experiment);
        assert!(schedule.samples > 4 && schedule.windows_per_sample > 1, "{schedule:?}");
        let expected = by_the_program(&experiment);
        let mut simulation = Simulation::from_start(&experiment).unwrap();
        // the second stop is at a sample; a time in the past changes nothing
        for time in [3.0 * schedule.interval(), 0.0, f64::NAN, experiment.run.duration] {
            simulation.run_until(time).unwrap();
        }
        assert_eq!(simulation.state().fingerprint(), expected, "{model:?}");
        assert_eq!(simulation.windows, schedule.windows());
    }
}

#[test]
fn run_until_stops_within_windows_and_comes_back_to_their_ends() {
    let experiment = blown(Model::Hard);
    let schedule = Schedule::new(&experiment);
    let window = schedule.window;
    let mut simulation = Simulation::from_start(&experiment).unwrap();
    simulation.run_until(2.25 * window).unwrap();
    assert!((simulation.time / window - 2.25).abs() < 1e-9);
    simulation.run_until(2.5 * window).unwrap();
    assert!((simulation.end_of_window().unwrap() / window - 3.0).abs() < 1e-9);
    simulation.run_until(7.0 * window).unwrap();
    // two whole windows, three parts of the third, and four whole ones
    assert_eq!(simulation.windows, 2 + 3 + 4);
    // other methods may move the simulation as well
    simulation.run(1, 0.5 * window).unwrap();
    assert!((simulation.end_of_window().unwrap() / window - 8.0).abs() < 1e-9);
    // beyond the schedule windows keep their length
    simulation.run_until(experiment.run.duration).unwrap();
    let windows = simulation.windows;
    simulation.run_until(experiment.run.duration + 3.0 * schedule.longest()).unwrap();
    assert_eq!(simulation.windows, windows + 3);
}

#[test]
fn a_run_that_is_stopped_can_go_on() {
    let experiment = blown(Model::Hard);
    // a run that is stopped after some windows
    let stopped_after = |windows: u64| {
        let mut simulation = Simulation::from_start(&experiment).unwrap();
        let mut go_on = |simulation: &mut Simulation| simulation.windows < windows;
        assert!(!simulation.run_until_while(experiment.run.duration, &mut go_on).unwrap());
        assert_eq!(simulation.windows, windows);
        simulation
    };
    let mut simulation = stopped_after(2);
    // a stop that nothing looks at changes no bit
    assert!(simulation.run_until_while(experiment.run.duration, &mut |_| true).unwrap());
    assert_eq!(simulation.state().fingerprint(), by_the_program(&experiment));
    // with the half-kick, velocities are those of a run to the time of the stop
    let (mut stopped, mut other) = (stopped_after(2), Simulation::from_start(&experiment).unwrap());
    other.run_until(stopped.time).unwrap();
    assert_ne!(stopped.state().fingerprint(), other.state().fingerprint());
    let within = stopped.time + 0.3 * Schedule::new(&experiment).window;
    stopped.run_until(stopped.time).unwrap();
    assert_eq!(stopped.state().fingerprint(), other.state().fingerprint());
    // a shorter window that follows a stop begins with half-kicks of both lengths
    let mut third = stopped_after(2);
    third.run_until(within).unwrap();
    other.run_until(within).unwrap();
    assert_eq!(third.state().fingerprint(), other.state().fingerprint());
}

#[test]
fn an_engine_of_the_program_gets_windows_of_its_particles() {
    let mut experiment = blown(Model::Hard);
    let start = initial_state(&experiment).unwrap();
    let engine = Box::new(diptych::Hard::new());
    let mut simulation = Simulation::with_engine(experiment.scene.clone(), start.clone(), engine);
    assert_eq!(simulation.end_of_window(), None);
    simulation.run_until(experiment.run.duration).unwrap();
    // the same windows as those of an experiment that starts from the particles
    experiment.start = vec![Population::placed(0, start)];
    let plain = Experiment::new(experiment.scene, experiment.start, Spheres::Hard, experiment.run.duration);
    let schedule = Schedule { longer: Default::default(), ..Schedule::new(&plain) };
    assert!(schedule.windows() > 10);
    assert_eq!(simulation.windows, schedule.windows());
}

#[test]
fn defaults_are_those_of_a_case() {
    let text = "[domain]\nsize = [\"2 mm\", \"2 mm\", \"2 mm\"]\nperiodic = [\"x\", \"y\", \"z\"]\n\
                [[particles]]\nname = \"glass\"\ndiameter = \"200 um\"\ndensity = \"2500 kg/m^3\"\ncount = 125\n\
                velocity_fluctuation = \"0.1 m/s\"\n[contact]\nrestitution = 0.9\n\
                [soft.linear_spring_dashpot]\nstiffness = \"1000 N/m\"\n[run]\nduration = \"10 ms\"\n";
    for model in [Model::Soft, Model::Hard, Model::Hybrid, Model::Dsmc] {
        let of_case = case(text, model, &[]).unwrap();
        let start = vec![Population::random(0, 125, 0.1)];
        let mut made = Experiment::new(of_case.scene.clone(), start, of_case.run.spheres, 0.01);
        // only a case can name a law that its model does not use
        made.soft.law = of_case.soft.law;
        assert_eq!(serde_json::to_value(&made).unwrap(), serde_json::to_value(&of_case).unwrap());
        let particles = random_start(&made.scene, &made.start, 1).unwrap();
        assert_eq!(particles.fingerprint(), initial_state(&of_case).unwrap().fingerprint());
        assert_ne!(particles.fingerprint(), random_start(&made.scene, &made.start, 2).unwrap().fingerprint());
    }
}

#[test]
fn files_of_triangles_are_read_or_refused_with_their_name() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let file = TriangleFile::read(folder.join("cases/walls/hopper.stl")).unwrap();
    assert_eq!(file.heap.len(), 192);
    let largest = |file: &TriangleFile| file.heap.iter().flatten().map(|corner| corner.amax()).fold(0.0, f64::max);
    let in_metres = 1e-3 * largest(&file);
    assert_eq!(largest(&file.scaled(1e-3)), in_metres);
    for (path, why) in [
        ("cases/quick.toml", "quick.toml is neither an STL nor an OBJ file"),
        ("no/such.obj", "no/such.obj: "),
        ("tests/inputs/bad/far.obj", "far.obj is no OBJ file that can be read: line 5: "),
    ] {
        let said = TriangleFile::read(folder.join(path)).unwrap_err().to_string();
        assert!(said.contains(why), "{said}");
    }
}

#[test]
fn forces_of_a_program_are_in_the_books() {
    let domain = Domain::new(Vector3::repeat(2e-3), [true; 3]);
    let gravity = Vector3::new(0.0, -9.81, 3.0);
    let species = vec![Species::new("glass", 2e-4, 2500.0)];
    let scene = Scene { gravity, ..Scene::new(domain, Surface::new(0.9, 0.1), species) };
    let experiment = Experiment::new(scene, vec![Population::random(0, 125, 0.3)], Spheres::Hard, 0.02);
    let mut simulation = Simulation::from_start(&experiment).unwrap();
    let (at_start, window) = (simulation.energy(), 2e-4);
    for _ in 0..100 {
        for half in 0..2 {
            let velocity = simulation.particles.velocity.clone();
            let acceleration = |place: usize| Vector3::new(0.0, 9.0, 0.0) - velocity[place] / 0.01;
            simulation.accelerate(acceleration, 0.5 * window);
            for (place, (now, before)) in simulation.particles.velocity.iter().zip(&velocity).enumerate() {
                assert_eq!(*now, before + acceleration(place) * (0.5 * window), "{place}");
            }
            if half == 0 {
                simulation.run(1, window).unwrap();
            }
        }
    }
    let ledger = &simulation.record.ledger;
    assert!(ledger.drag_work.abs() > 0.1 * at_start && ledger.dissipated() > 0.01 * at_start);
    // some thousand sums, each rounded to 1e-16 of the energies that went through
    let residual = ledger.residual(at_start, simulation.energy()) / ledger.through(at_start);
    assert!(residual.abs() < 1e-12, "{residual:e}");
    // gravity is counted by a sum of momentum that every change of velocity must reach
    let mean = simulation.particles.momentum() / simulation.total_mass();
    let differs = (mean - simulation.mean_velocity()).norm() / mean.norm();
    assert!(differs < 1e-12, "{differs:e}");
    let impulse = (ledger.drag_impulse + ledger.gravity_impulse - simulation.particles.momentum()).norm();
    assert!(impulse < 1e-12 * ledger.gravity_impulse.norm(), "{impulse:e}");
}
