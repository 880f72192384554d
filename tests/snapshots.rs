//! The state between two windows (pieces of a run) is one value. A run that is stored in the middle and restored has
//! the same bits as an uninterrupted run.

use crate::support::{edge, empty, experiment, plane, small, surface};
use diptych::clock::Clock;
use diptych::contact_law::{ContactLaw, Hertz};
use diptych::drag::{Drag, SchillerNaumann};
use diptych::experiment::{
    Amount, ClustersSettings, DiffusionSettings, Experiment, FieldsSettings, HardStepping, Integrator, Model,
    PairDistributionSettings, Population, SoftStepping, Spheres, StructureFactorSettings, TimeStep,
    VelocityDistributionSettings, ViscositySettings,
};
use diptych::fluid::{Fluid, Profile};
use diptych::observe::{
    ContactNetwork, Diffusion, EnergyBooks, Fields, Flows, ImpactSeries, Kinds, Mixing, MomentumBooks, Motion,
    Observer, PairDistribution, ParticleClusters, Paths, Pause, Rings, RunLoop, SeenGas, Series, Stresses,
    StructureFactor, VelocityDistribution, Viscosity,
};
use diptych::placement::initial_state;
use diptych::scene::{Elasticity, Inlet, Outlet, OutletShape, Species, Thermostat};
use diptych::schedule::Schedule;
use diptych::simulation::{Simulation, Snapshot};
use diptych::statistics::Accumulator;
use diptych::walls::{Cavity, Hollow};
use diptych::{Dsmc, Engine, Record, Stored, Vector3, Window};

/// [s] length of a window (piece of a run): about 130 soft steps.
const WINDOW: f64 = 5e-5;

/// Experiment of spheres of 406 µm with friction in a periodic cube with the volume fraction `phi`.
fn crowd(count: usize, phi: f64, fluctuation: f64) -> Experiment {
    let cube = [edge(count, small().diameter, phi); 3];
    let scene = empty(cube, [true; 3], small(), surface(0.8, 0.2));
    experiment(scene, count, [0.0; 3], fluctuation, Model::Hard, 5)
}

/// A gas of spheres between a floor and a lid. Gravity brings them to the floor within some windows.
fn falling() -> Experiment {
    let mut falling = crowd(150, 0.2, 0.3);
    let scene = &mut falling.scene;
    let height = scene.domain.size.y;
    scene.domain = diptych::Domain::new(scene.domain.size, [true, false, true]);
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.5, 0.3)),
        plane([0.0, height, 0.0], [0.0, -1.0, 0.0], surface(0.5, 0.3)),
    ];
    scene.gravity = Vector3::new(0.3, -500.0, 0.0);
    falling
}

/// Mixture of two sizes with a ratio of three.
fn mixture() -> Experiment {
    let mut mixture = crowd(200, 0.25, 0.4);
    mixture.scene.species.push(Species { name: "L".into(), diameter: 3.0 * small().diameter, ..small() });
    mixture.start.push(Population { species: 1, amount: Amount::Count(4), ..mixture.start[0].clone() });
    mixture
}

/// Experiment of so many spheres that drag comes from a table, in a gas that carries the spheres along.
fn blown() -> Experiment {
    let mut blown = crowd(1100, 0.02, 0.5);
    let drag = Some(Drag::SchillerNaumann(SchillerNaumann));
    let profile = Profile::Uniform(10.0);
    blown.scene.fluid = Some(Fluid::new(1.205, 1.515e-5, profile, drag));
    blown.scene.gravity = Vector3::new(0.0, 0.0, -9.81);
    blown
}

/// A dense group of spheres in a sheared box, whose images slide by a tenth of the box in a window (piece of the run).
fn sheared() -> Experiment {
    let mut sheared = crowd(200, 0.2, 0.5);
    let domain = sheared.scene.domain;
    sheared.scene.domain = domain.sheared(0.1 / WINDOW, 0.0);
    sheared
}

/// A dense gas that a thermostat heats by random accelerations.
fn heated() -> Experiment {
    let mut heated = crowd(200, 0.2, 0.5);
    heated.scene.thermostat = Some(Thermostat::Stochastic { heating: 100.0 });
    heated
}

/// A dense group of spheres that come in on one side and leave on the other, a few in each window (piece of the run).
fn passing() -> Experiment {
    let mut passing = crowd(200, 0.1, 0.5);
    let edges = passing.scene.domain.size;
    let middle = |share: f64| Vector3::new(0.5 * edges.x, 0.5 * edges.y, share * edges.z);
    let half_extents = Vector3::new(0.5 * edges.x, 0.5 * edges.y, 0.2 * edges.z);
    let region = |share: f64| Hollow::new(Cavity::Box { center: middle(share), half_extents });
    passing.scene.outlets = vec![Outlet { name: "out".into(), shape: OutletShape::Body(region(0.8)) }];
    passing.scene.inlets = vec![Inlet {
        name: "in".into(),
        species: 0,
        region: region(0.2),
        rate: 3.0 / WINDOW,
        start: 0.0,
        end: f64::INFINITY,
        velocity_mean: Vector3::z(),
        velocity_fluctuation: Vector3::repeat(1.0),
        spin_mean: Vector3::zeros(),
        spin_fluctuation: 0.0,
    }];
    passing
}

fn scenes() -> Vec<(&'static str, Experiment)> {
    vec![
        ("dilute", crowd(200, 0.01, 0.5)),
        ("middling", crowd(200, 0.15, 1.0)),
        ("dense", crowd(200, 0.45, 0.5)),
        ("mixture", mixture()),
        ("falling", falling()),
        ("blown", blown()),
        ("sheared", sheared()),
        ("heated", heated()),
        ("passing", passing()),
    ]
}

/// Copies of the experiment `of` with every model and kind of stepping, each with its name.
fn ways(of: &Experiment) -> Vec<(String, Experiment)> {
    let mut ways = Vec::new();
    for (name, stepping, contact_time) in [
        ("hard", HardStepping::Events, None),
        ("hard, contact time", HardStepping::Events, Some(2e-6)),
        ("stepped hard", HardStepping::Steps { theta: 0.05 }, None),
    ] {
        let mut way = of.clone();
        (way.hard.stepping, way.hard.contact_time) = (stepping, contact_time);
        ways.push((name.to_owned(), way));
    }
    let mut way = of.clone();
    // in the dilute scene two windows share a step of collisions by chance, so that a half-completed step is stored too
    (way.run.spheres, way.dsmc.step) = (Spheres::Dsmc, 0.02);
    ways.push(("dsmc".to_owned(), way));
    let elasticity = Elasticity { youngs_modulus: 2e6, poissons_ratio: 0.3 };
    for law in [ContactLaw::linear(3000.0), ContactLaw::Hertz(Hertz { elasticity })] {
        for stepping in [SoftStepping::Uniform, SoftStepping::Local, SoftStepping::Auto] {
            for integrator in [Integrator::VelocityVerlet, Integrator::Rk2] {
                let mut way = of.clone();
                (way.soft.law, way.run.spheres) = (Some(law), Spheres::Soft(law));
                (way.soft.stepping, way.soft.integrator) = (stepping, integrator);
                ways.push((format!("{law:?}, {stepping:?}, {integrator:?}"), way));
            }
        }
        let mut way = of.clone();
        (way.soft.law, way.run.spheres, way.soft.stepping) = (Some(law), Spheres::Hybrid(law), SoftStepping::Auto);
        ways.push((format!("{law:?}, hybrid"), way));
    }
    ways
}

/// All bits of the state between two windows (pieces of a run), as stored.
fn bits(simulation: &Simulation) -> Stored {
    Stored::of(&simulation.snapshot().unwrap()).unwrap()
}

#[test]
fn a_run_stored_between_two_windows_goes_on_with_the_same_bits() {
    for (scene, experiment) in scenes() {
        let start = initial_state(&experiment).unwrap();
        for (way, experiment) in ways(&experiment) {
            let name = format!("{scene}, {way}");
            let mut straight = Simulation::new(&experiment, start.clone());
            // an odd number of windows, so that both states are stored of data that change every other window
            let mut stored = Vec::new();
            for windows in [0, 1, 2, 4] {
                straight.run(windows, WINDOW).unwrap_or_else(|why| panic!("{name}: {why}"));
                stored.push((windows, bits(&straight)));
            }
            assert!(straight.record.pairs.count > 0, "{name}: nothing has happened");
            for (k, (_, half)) in stored.iter().enumerate().take(3) {
                let snapshot: Snapshot = half.read().unwrap();
                let mut resumed = Simulation::restore(&experiment, snapshot).unwrap();
                assert!(bits(&resumed) == *half, "{name}: changed by storing");
                for (windows, then) in &stored[k + 1..] {
                    resumed.run(*windows, WINDOW).unwrap();
                    assert!(bits(&resumed) == *then, "{name}: {windows} windows after part {k}");
                }
                assert_eq!(resumed.counters(), straight.counters(), "{name}");
                assert_eq!(resumed.state().fingerprint(), straight.state().fingerprint(), "{name}");
            }
        }
    }
}

/// Heun's method heats an elastic gas: the energy grows by a fifth in the second part of this run. The check that the
/// energy grows by no more than the errors of the method passes before and after a pause.
#[test]
fn a_resumed_run_explains_the_gain_of_its_scheme() {
    let mut gas = crowd(200, 0.2, 0.5);
    gas.scene.contact = surface(1.0, 0.0);
    gas.run.spheres = Spheres::Soft(ContactLaw::linear(3000.0));
    gas.soft.integrator = Integrator::Rk2;
    gas.soft.time_step = TimeStep::PerContact(8.0);
    let start = initial_state(&gas).unwrap();
    let mut simulation = Simulation::new(&gas, start);
    simulation.run(20, WINDOW).unwrap();
    let stored: Snapshot = bits(&simulation).read().unwrap();
    let mut resumed = Simulation::restore(&gas, stored).unwrap();
    resumed.run(40, WINDOW).unwrap();
    let [before, after] = [simulation.energy(), resumed.energy()];
    assert!(after > 1.1 * before, "from {before} J to {after} J");
}

#[test]
fn a_snapshot_of_another_engine_is_refused() {
    let crowd = crowd(50, 0.1, 0.5);
    let start = initial_state(&crowd).unwrap();
    let mut refused = 0;
    for (_, taken) in ways(&crowd) {
        let mut simulation = Simulation::new(&taken, start.clone());
        simulation.run(3, WINDOW).unwrap();
        for (_, other) in ways(&crowd).into_iter().filter(|(_, other)| other.run.spheres != taken.run.spheres) {
            refused += usize::from(Simulation::restore(&other, simulation.snapshot().unwrap()).is_err());
        }
    }
    assert!(refused > 50, "{refused}");
}

#[test]
fn a_snapshot_whose_particles_do_not_fit_is_refused() {
    let crowd = crowd(50, 0.1, 0.5);
    let simulation = Simulation::new(&crowd, initial_state(&crowd).unwrap());
    let damaged = |damage: &dyn Fn(&mut diptych::Particles)| {
        let mut snapshot = simulation.snapshot().unwrap();
        damage(&mut snapshot.particles);
        Simulation::restore(&crowd, snapshot).is_err()
    };
    assert!(!damaged(&|_| ()), "a whole one is taken");
    assert!(damaged(&|particles| particles.mass.truncate(49)), "a column too short");
    assert!(damaged(&|particles| particles.position.clear()), "no positions");
    assert!(damaged(&|particles| particles.species[7] = 9), "a kind that is not in the scene");
}

/// Observers of every kind.
fn observers(experiment: &Experiment, schedule: &Schedule) -> Vec<Box<dyn Observer>> {
    vec![
        Box::new(Accumulator::new(4, experiment.scene.domain.size.y)),
        Box::new(Motion::new(experiment)),
        Box::new(ImpactSeries::of_pairs(experiment, schedule)),
        Box::new(ImpactSeries::of_walls(experiment, schedule)),
        Box::new(EnergyBooks::default()),
        Box::new(MomentumBooks::new(schedule)),
        Box::new(Series::new(experiment, schedule)),
        Box::new(Paths::new(schedule)),
        Box::new(Stresses::new(experiment, schedule)),
        Box::new(Kinds::new(experiment, schedule)),
        Box::new(Flows::new(experiment, schedule)),
        Box::new(Rings::new(experiment)),
        Box::new(Mixing::new(experiment, schedule)),
        Box::new(PairDistribution::new(experiment, schedule, PairDistributionSettings { reach: 1e-3, bins: 7 })),
        Box::new(StructureFactor::new(experiment, schedule, StructureFactorSettings { wavelength: 1e-3, bins: 3 })),
        Box::new(ContactNetwork::new(experiment, schedule)),
        Box::new(SeenGas::new(experiment, schedule)),
        Box::new(Viscosity::new(schedule, ViscositySettings { duration: Some(1e-3) })),
        Box::new(ParticleClusters::new(schedule, ClustersSettings { gap: 1e-5 })),
        Box::new(Fields::new(experiment, schedule, FieldsSettings { width: 1e-3, cells: [2, 1, 3] })),
        Box::new(Diffusion::new(experiment, schedule, DiffusionSettings { duration: 2.0 * schedule.interval() })),
        Box::new(VelocityDistribution::new(
            experiment,
            schedule,
            VelocityDistributionSettings { largest_speed: 3.0, bins: 5 },
        )),
    ]
}

/// Number of the storage layout, and checksum of the stored data of a run before its first window, with every model and
/// observer. Only the types define the meaning of these bytes. If the types change without the number, older files are
/// misread.
const LAYOUT: (&str, u32) = ("45", 3_784_286_569);

#[test]
fn types_that_are_stored_change_with_the_number_of_the_layout_only() {
    let still = crowd(3, 0.01, 0.0);
    let mut bytes = Vec::new();
    for (_, experiment) in ways(&still) {
        let simulation = Simulation::new(&experiment, initial_state(&experiment).unwrap());
        bytes.extend_from_slice(bits(&simulation).as_bytes());
        for observer in observers(&experiment, &Schedule::new(&experiment)) {
            bytes.extend_from_slice(observer.stored().unwrap().as_bytes());
        }
    }
    let sealed = diptych::checkpoint::seal(&0u8).unwrap();
    let head = String::from_utf8_lossy(&sealed);
    let (_, layout) = head.split_once("layout ").unwrap();
    assert_eq!(
        (layout.lines().next().unwrap(), crc32fast::hash(&bytes)),
        LAYOUT,
        "raise LAYOUT in src/checkpoint/envelope.rs, and write both numbers here"
    );
}

/// Wall-clock times of collisions by chance count from the start of the run, also after it was stored and restored.
#[test]
fn times_of_collisions_by_chance_are_stored() {
    let experiment = crowd(200, 0.15, 1.0);
    let mut particles = initial_state(&experiment).unwrap();
    let mut engine = Dsmc::new(experiment.dsmc, 1);
    engine.use_clock(Clock::wall());
    let window = Window { start: 0.0, duration: WINDOW };
    engine.advance(&mut particles, &experiment.scene, window, &mut Record::default()).unwrap();
    let mut restored = Dsmc::new(experiment.dsmc, 1);
    restored.restore(&engine.stored().unwrap()).unwrap();
    let [(_, before), (_, after)] = [engine.work_done(), restored.work_done()];
    assert!(!before.flight.is_zero() && !before.neighbours.is_zero(), "{before:?}");
    assert_eq!([after.flight, after.neighbours], [before.flight, before.neighbours]);
}

fn lent(observers: &mut [Box<dyn Observer>]) -> Vec<&mut dyn Observer> {
    observers.iter_mut().map(|observer| &mut **observer as &mut dyn Observer).collect()
}

/// All bits of a run and its observers at the end. The run is stopped after every `every` windows (pieces of the run),
/// stored and resumed. Also returns the number of stops.
fn in_parts(experiment: &Experiment, every: u64) -> (Stored, u64) {
    let schedule = Schedule::new(experiment);
    let mut simulation = Simulation::new(experiment, initial_state(experiment).unwrap());
    let mut watching = observers(experiment, &schedule);
    let mut course = RunLoop::new(&schedule, watching.len());
    let (mut window, mut left) = (0, 0);
    let mut pause = || {
        window += 1;
        window % every == 0
    };
    while !course.run(&mut simulation, &mut lent(&mut watching), &mut pause).unwrap() {
        left += 1;
        let bytes = Stored::of(&course.store(&simulation, &lent(&mut watching)).unwrap()).unwrap();
        let pause: Pause = bytes.read().unwrap();
        watching = observers(experiment, &schedule);
        (simulation, course) = pause.resume(experiment, &mut lent(&mut watching)).unwrap();
    }
    let pause = course.store(&simulation, &lent(&mut watching)).unwrap();
    (Stored::of(&pause).unwrap(), left)
}

#[test]
fn a_run_left_within_a_sample_goes_on_with_the_same_bits_and_so_do_its_observers() {
    for mut experiment in [blown(), falling()] {
        (experiment.run.duration, experiment.run.window) = (12.0 * WINDOW, Some(WINDOW));
        experiment.statistics.sample_interval = Some(4.0 * WINDOW);
        // spheres that collide by chance cannot rest on the floor of the second scene
        let rests = |name: &str| name == "dsmc" && !experiment.scene.walls.is_empty();
        for (name, way) in ways(&experiment).into_iter().filter(|(name, _)| !name.contains("Hertz") && !rests(name)) {
            let (whole, never) = in_parts(&way, 1 << 40);
            let (parts, left) = in_parts(&way, 3);
            // stops after every 11 windows, unless the run is over
            assert_eq!((never, left), (0, 3), "{name}");
            assert!(whole == parts, "{name}");
        }
    }
}
