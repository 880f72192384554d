//! Buoyancy: falling spheres against MFIX and closed-form solutions, mixtures of densities, the ledger (balance of
//! energy and momentum), threads and processes.

use crate::soak::{Crowd, books, crowd, energy_of_impacts, engines};
use crate::support::{case, close, diptych, empty, plane, random, shared, small, surface, try_run, words};
use diptych::contact_law::ContactLaw;
use diptych::engine::distributed::Distributed;
use diptych::engine::hard::Hard;
use diptych::engine::hybrid::Hybrid;
use diptych::engine::soft::Soft;
use diptych::experiment::{Experiment, Integrator, Model, SoftStepping};
use diptych::fluid::{Fluid, Profile};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::predict::flow::flows;
use diptych::scene::Scene;
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;
use diptych::{Drag, Stokes};
use nalgebra::Vector3;

/// Case of the falling spheres of MFIX's test DEM06, in a gas that flows upwards.
const DEM06: &str = r#"
[domain]
size = ["10 mm", "10 mm", "200 mm"]
periodic = ["x", "y", "z"]
[gravity]
acceleration = ["0 m/s^2", "0 m/s^2", "-9.80665 m/s^2"]
[fluid]
density = "1.2 kg/m^3"
kinematic_viscosity = "1.5e-5 m^2/s"
[fluid.profile.uniform]
velocity = "0.4 m/s"
[drag.schiller_naumann]
[[particles]]
name = "dem06"
diameter = "100 um"
density = "2000 kg/m^3"
at = [{ position = ["5 mm", "5 mm", "100 mm"] }]
[contact]
restitution = 0.9
[soft.linear_spring_dashpot]
stiffness = "1000 N/m"
[run]
duration = "0.35 s"
window = "0.1 ms"
"#;

const MODELS: [Model; 4] = [Model::Soft, Model::Hard, Model::Hybrid, Model::Dsmc];

/// Velocities along z [m/s] of the single sphere of an experiment at `times` [s], with windows (times between two
/// exchanges with the gas) of 0.1 ms.
fn velocities(experiment: &Experiment, times: &[f64]) -> Vec<f64> {
    let mut simulation = Simulation::new(experiment, initial_state(experiment).unwrap());
    let mut done = 0;
    let mut at = |time: &f64| {
        let windows = (time / 1e-4).round() as u64;
        simulation.run(windows - done, 1e-4).unwrap();
        done = windows;
        simulation.particles.velocity[0].z
    };
    times.iter().map(&mut at).collect()
}

/// Velocities with and without buoyancy from section C6 of the catalogue of reference values (oracle), for g = 9.80665
/// m/s². Drag and flight are computed in turn in windows of h = 0.1 ms. This changes the velocities by up to (h/τ)²/24
/// = 2.6e-7 of the slip of 0.46 m/s, for a relaxation time τ >= 0.04 s.
#[test]
fn the_sphere_of_mfix_falls_with_and_without_buoyancy() {
    let times = [0.01, 0.05, 0.1, 0.35];
    for (key, wanted) in [
        ("fluid.buoyancy=true", [-0.01255261, -0.04078891, -0.05263133, -0.05739251]),
        ("fluid.buoyancy=false", [-0.01260483, -0.04095790, -0.05284818, -0.05762766]),
    ] {
        for model in MODELS {
            let found = velocities(&case(DEM06, model, &[key]).unwrap(), &times);
            for (found, wanted) in found.iter().zip(wanted) {
                assert!((found - wanted).abs() < 1.3e-7, "{key}, {model:?}: {found} {wanted}");
            }
        }
    }
}

/// A glass bead of 2 mm falls in water at 0.268 m/s, and at 0.366 m/s without buoyancy. These are roots of the balance
/// of forces, to three digits. `plan` predicts the speeds, and a warning names the forces that are left out.
#[test]
fn a_bead_sinks_in_water() {
    let water = [
        "gravity.acceleration=[0, 0, -9.81]",
        "fluid.density=998.2 kg/m^3",
        "fluid.kinematic_viscosity=1e-6",
        "fluid.profile.uniform.velocity=0",
        "particles[0].diameter=2 mm",
        "particles[0].density=2500 kg/m^3",
        "run.duration=2 s",
    ];
    for (buoyancy, wanted) in [(true, 0.26788), (false, 0.36579)] {
        let key = format!("fluid.buoyancy={buoyancy}");
        for model in MODELS {
            let bead = case(DEM06, model, &[&water[..], &[&key]].concat()).unwrap();
            close("fall", -velocities(&bead, &[1.5])[0], wanted, 5e-6);
            close("prediction", flows(&bead.scene, &[1])[0].terminal_slip, wanted, 5e-6);
        }
        let mut arguments = vec!["check", "cases/beads-in-air.toml", "--set", &key];
        arguments.extend(["--set", "fluid.density=998.2"]);
        let told = diptych(&arguments).output().unwrap();
        let told = words(&told.stdout) + &words(&told.stderr);
        assert_eq!(told.contains("has 0.601 of its weight"), !buoyancy, "{told}");
        assert_eq!(told.contains("buoyancy."), buoyancy, "{told}");
    }
}

/// [m/s²] gravity in the scenes with spheres of three densities.
const GRAVITY: [f64; 3] = [0.0, -9.81, 2.0];

/// Box with a fluid of 1000 kg/m³ that exerts no drag, and with species of spheres of 1000, 2500 and 800 kg/m³.
fn three_densities() -> Scene {
    let species = |density: f64| diptych::Species { density, diameter: 1e-3, ..small() };
    let mut scene = empty([0.2; 3], [true, false, true], species(1000.0), surface(0.8, 0.0));
    scene.species.extend([species(2500.0), species(800.0)]);
    scene.gravity = Vector3::from(GRAVITY);
    let profile = Profile::Uniform(0.0);
    scene.fluid = Some(Fluid::new(1000.0, 1e-6, profile, None));
    scene
}

/// Appends a sphere at rest, at the position `place` [m], to the particles.
fn add(particles: &mut Particles, scene: &Scene, species: u16, place: [f64; 3]) {
    let kind = &scene.species[usize::from(species)];
    particles.push(place.into(), Vector3::zeros(), 0.5 * kind.diameter, kind.mass(), species);
}

/// Engines with their names: soft, hard and hybrid spheres, with stiffness and time step for masses of a few
/// milligrams.
fn ways() -> Vec<(&'static str, Box<dyn Distributed>)> {
    let (law, step, verlet) = (ContactLaw::linear(1000.0), 2e-6, Integrator::VelocityVerlet);
    let soft = |integrator, stepping| Box::new(Soft::new(law, integrator, step, stepping));
    vec![
        ("soft, uniform", soft(verlet, SoftStepping::Uniform)),
        ("soft, Runge-Kutta", soft(Integrator::Rk2, SoftStepping::Uniform)),
        ("soft, local", soft(verlet, SoftStepping::Local)),
        ("hard", Box::new(Hard::new())),
        ("hard, islands", Box::new(Hard::with_islands())),
        ("hybrid", Box::new(Hybrid::new(law, verlet, step, 2.0))),
    ]
}

/// Without drag, a sphere of density ρ_p in a fluid of density ρ_f falls exactly with g (1 - ρ_f/ρ_p), in every engine
/// and for any window (time between two exchanges with the fluid). Spheres of the density of the fluid stay at rest.
#[test]
fn spheres_of_three_densities_fall_as_they_should() {
    let mut scene = three_densities();
    let mut start = Particles::default();
    (0..3).for_each(|k| add(&mut start, &scene, k, [0.05 + 0.05 * f64::from(k), 0.1, 0.1]));
    scene.add_buoyancy();
    let accelerations = scene.species.iter().map(|species| scene.gravity_of(species)).collect::<Vec<_>>();
    assert_eq!(accelerations[0], Vector3::zeros());
    assert!((accelerations[1] - Vector3::from(GRAVITY) * 0.6).norm() < 1e-15 * 9.81);
    assert!((accelerations[2] + Vector3::from(GRAVITY) * 0.25).norm() < 1e-15 * 9.81);
    for (name, engine) in ways() {
        let (time, windows) = (0.1, 37);
        let mut simulation = Simulation::with_distributed_engine(scene.clone(), start.clone(), engine);
        simulation.run(windows, time / windows as f64).unwrap();
        let state = simulation.state();
        for (k, acceleration) in accelerations.iter().enumerate() {
            // each window, and each soft step of 2 µs, adds a few numbers with a rounding each: of up to 0.2 m, and of
            // up to g t = 1 m/s
            let rounding = 4.0 * f64::EPSILON * (time / 2e-6);
            let way = state.position[k] - start.position[k] - acceleration * (0.5 * time * time);
            let speed = state.velocity[k] - acceleration * time;
            assert!(way.norm() < 0.2 * rounding, "{name}, {k}: {way:?}");
            assert!(speed.norm() < rounding, "{name}, {k}: {speed:?}");
        }
        // the work is that of gravity on the spheres, less their buoyancy
        let work: f64 = (0..3).map(|k| 0.5 * start.mass[k] * (accelerations[k] * time).norm_squared()).sum();
        close("work", simulation.record.ledger.gravity_work, work, 1e-10 * work);
        let weight: Vector3<f64> = (0..3).map(|k| start.mass[k] * accelerations[k]).sum();
        assert!((simulation.weight() - weight).norm() < 1e-10 * weight.norm(), "{name}");
    }
}

/// A sphere of the density of the water stays at rest, also on a floor. No bit of its state changes.
#[test]
fn a_sphere_as_heavy_as_the_water_stays_where_it_is() {
    let mut scene = three_densities();
    scene.species.truncate(1);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.5, 0.2))];
    let mut start = Particles::default();
    add(&mut start, &scene, 0, [0.1, 0.1, 0.1]);
    add(&mut start, &scene, 0, [0.05, 5e-4, 0.1]);
    scene.add_buoyancy();
    for (name, engine) in ways() {
        let mut simulation = Simulation::with_distributed_engine(scene.clone(), start.clone(), engine);
        simulation.run(20, 1e-3).unwrap();
        let state = simulation.state();
        assert_eq!((&state.position, &state.velocity), (&start.position, &start.velocity), "{name}");
    }
}

/// Random dense gases (the crowds of module `soak`) of two densities in a fluid: balances of kinetic and elastic
/// energy, losses and work, and of momentum.
#[test]
fn the_ledger_closes_in_a_mixture_with_buoyancy() {
    for seed in [51, 54, 57] {
        let mut crowd: Crowd = crowd(seed);
        let heavy = crowd.scene.species[0].clone();
        crowd.scene.species.push(diptych::Species { density: 0.4 * heavy.density, ..heavy.clone() });
        for k in (0..crowd.start.len()).step_by(2) {
            crowd.start.species[k] = 1;
            crowd.start.mass[k] *= 0.4;
        }
        // the heavy spheres have a response time of a hundred windows, and buoyancy carries half of the weight of the
        // light spheres
        let density = 0.2 * heavy.density;
        let kinematic_viscosity = heavy.density / (18.0 * density * 100.0 * crowd.window);
        let (profile, drag) = (Profile::Uniform(0.5), Some(Drag::Stokes(Stokes)));
        crowd.scene.fluid = Some(Fluid::new(density, kinematic_viscosity, profile, drag));
        crowd.scene.add_buoyancy();
        for (name, engine, gain) in engines(&crowd) {
            // lighter spheres have a higher frequency; the gain of energy is at most proportional to its fourth power
            let gain = gain / 0.4_f64.powi(2);
            let explained = |simulation: &Simulation| gain * (energy_of_impacts(simulation) + simulation.energy());
            let (worst, simulation) = books(&crowd, engine, &explained).unwrap();
            let [energy, momentum] = [worst.energy / worst.energy_allowed, worst.momentum / worst.momentum_allowed];
            println!("{name}, seed {seed}: of what is allowed, energy {energy:.3}, momentum {momentum:.3}");
            assert!(energy < 1.0 && momentum < 1.0, "{name}, {}: energy {energy}, momentum {momentum}", crowd.words);
            assert!(simulation.record.pairs.count > 100);
        }
    }
}

/// Gas of spheres of two densities that falls between two walls, with or without drag.
fn mixture(drag: Option<Drag>, count: usize, fraction: f64) -> (Scene, Particles) {
    let species = small();
    let edge = (count as f64 * species.volume() / fraction).cbrt();
    let mut scene = empty([edge; 3], [true, false, true], species, surface(0.9, 0.1));
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.1)),
        plane([0.0, edge, 0.0], [0.0, -1.0, 0.0], surface(0.9, 0.1)),
    ];
    scene.gravity = Vector3::new(0.0, -9.81, -1.0);
    let mut start = random(&scene, count, 0.5, 3);
    scene.species.push(diptych::Species { density: 500.0, ..small() });
    for k in (0..count).step_by(3) {
        start.species[k] = 1;
        start.mass[k] = scene.species[1].mass();
    }
    let profile = Profile::Uniform(0.3);
    scene.fluid = Some(Fluid::new(300.0, 1e-6, profile, drag));
    scene.add_buoyancy();
    (scene, start)
}

#[test]
fn buoyancy_gives_the_same_bits_on_any_number_of_threads_and_processes() {
    let stokes = Some(Drag::Stokes(Stokes));
    let law = ContactLaw::linear(3000.0);
    let local =
        || Box::new(Soft::new(law, Integrator::VelocityVerlet, 3e-7, SoftStepping::Local)) as Box<dyn Distributed>;
    let islands = || Box::new(Hard::with_islands()) as Box<dyn Distributed>;
    let hybrid = || Box::new(Hybrid::new(law, Integrator::VelocityVerlet, 3e-7, 1.0)) as Box<dyn Distributed>;
    // without drag and at this density, hard spheres have one event queue, which would remain from window to window
    let queue = || Box::new(Hard::new()) as Box<dyn Distributed>;
    let ways: [(&str, &(dyn Fn() -> Box<dyn Distributed> + Sync), _); 4] = [
        ("soft", &local, mixture(stokes.clone(), 3000, 0.03)),
        ("hard", &islands, mixture(stokes.clone(), 3000, 0.03)),
        ("hybrid", &hybrid, mixture(stokes, 3000, 0.03)),
        ("queue", &queue, mixture(None, 800, 0.25)),
    ];
    for (name, engine, of) in ways {
        let on = |size| shared(size, &of, engine, (3e-3, 30), |end| (end.fingerprint(), end.record.ledger.to_array()));
        let alone = on(1);
        for size in [2, 3] {
            assert_eq!(on(size), alone, "{name} on {size}");
        }
        let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for threads in [1, 3] {
            assert_eq!(pool(threads).install(|| on(1)), alone, "{name}, {threads} threads");
        }
    }
}

/// The event queue of all particles predicts all events again after buoyancy has changed the velocities. Its results
/// agree with those of islands (groups of particles that may meet in a window).
#[test]
fn the_event_queue_of_all_particles_sees_kicks_of_buoyancy() {
    let (scene, start) = mixture(None, 800, 0.25);
    let [one, many] = [Hard::new(), Hard::with_islands()].map(|engine| {
        // about 20 collisions, before rounding errors have grown visibly
        try_run(&scene, start.clone(), Box::new(engine), 4e-5, 8).0
    });
    assert!(one.record.pairs.count > 5, "{}", one.record.pairs.count);
    assert_eq!(one.record.pairs.count, many.record.pairs.count);
    for (a, b) in one.particles.velocity.iter().zip(&many.particles.velocity) {
        assert!((a - b).norm() < 1e-9, "{a:?} {b:?}");
    }
}

/// A light sphere bounces on a floor. A dense sphere is present too, so that kicks (changes of velocity once per
/// window) contain the difference of the weights. The height agrees with the closed-form solution to first order in
/// the window h. An impact within a window has a speed wrong by up to (1 + e) b h/2, with the restitution e and the
/// difference b of the accelerations of the two spheres.
#[test]
fn a_light_sphere_bounces_beside_a_dense_one() {
    let mut scene = three_densities();
    scene.species[0].density = 1250.0;
    scene.gravity = Vector3::new(0.0, -10.0, 0.0);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.8, 0.0))];
    let mut start = Particles::default();
    add(&mut start, &scene, 0, [0.05, 0.0105, 0.1]);
    add(&mut start, &scene, 1, [0.15, 0.1, 0.1]);
    scene.add_buoyancy();
    // the sphere falls by 10 mm with 2 m/s², for 0.1 s, and rises for 0.05 s at 0.8 of its speed
    let height = 5e-4 + 0.16 * 0.05 - 0.5 * 2.0 * 0.05 * 0.05;
    let largest = |windows: u64| {
        let error = |engine: Hard| {
            let simulation = try_run(&scene, start.clone(), Box::new(engine), 0.15, windows).0;
            simulation.particles.position[0].y - height
        };
        [Hard::new(), Hard::with_islands()].map(error).into_iter().fold(0.0, |a: f64, b| a.max(b.abs()))
    };
    for windows in [101, 1001, 10_001] {
        let window = 0.15 / windows as f64;
        // b = 6 - 2 m/s²; the wrong speed lasts for 0.05 s
        let allowed = 0.05 * 1.8 * 4.0 * 0.5 * window + 4.0 * window * window;
        assert!(largest(windows) < allowed, "{windows}: {} {allowed}", largest(windows));
    }
    // the schedule of such a scene: the path is within 1e-5 diameters of the parabola
    let mut experiment = crate::support::experiment(scene, 2, [0.0; 3], 0.1, Model::Hard, 1);
    experiment.run.duration = 0.15;
    let window = Schedule::new(&experiment).window;
    assert!(4.8 * window * window / 8.0 <= 1e-8 && window > 1e-5, "{window}");
}

/// A case without the key `fluid.buoyancy` has buoyancy. With the value `false`, the bits are those of a scene without
/// buoyancy. The report names the setting.
#[test]
fn the_key_switches_buoyancy() {
    let scene = |sets: &[&str]| case(DEM06, Model::Hard, sets).unwrap().scene;
    let [with, without] = [scene(&[]), scene(&["fluid.buoyancy=false"])];
    assert!(with.fluid.as_ref().is_some_and(|fluid| fluid.buoyancy.is_some()));
    assert!(without.fluid.as_ref().is_some_and(|fluid| fluid.buoyancy.is_none()));
    assert_eq!(with.gravity_alone(), without.gravity);
    assert_eq!(with.gravity, without.gravity * (1.0 - 1.2 / 2000.0));
    // without gravity there is no buoyancy
    assert!(scene(&["gravity.acceleration=[0, 0, 0]"]).fluid.is_some_and(|fluid| fluid.buoyancy.is_none()));
    let mut twice = with.clone();
    twice.add_buoyancy();
    assert_eq!(twice.gravity, with.gravity);
}
