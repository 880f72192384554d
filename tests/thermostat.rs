//! Thermostats and thermal walls: heat without collisions, momentum and ledger, steady states against kinetic theory, bits,
//! messages.

use crate::support::*;
use diptych::engine::distributed::Distributed;
use diptych::engine::dsmc::Dsmc;
use diptych::engine::hard::Hard;
use diptych::engine::soft::Soft;
use diptych::experiment::{DsmcSettings, Integrator, Model, SoftStepping};
use diptych::placement::initial_state;
use diptych::scene::Thermostat;
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;
use diptych::walls::{ThermalWall, WallApproach};
use diptych::{ContactLaw, Particles, Scene, Vector3, Wall};
use std::f64::consts::PI;

const STOCHASTIC: Thermostat = Thermostat::Stochastic { heating: 0.1 };
const GAUSSIAN: Thermostat = Thermostat::Gaussian { rate: 0.05 };

/// Spheres of unit mass and diameter at a volume fraction in a periodic cube.
fn gas(count: usize, phi: f64, restitution: f64, thermostat: Thermostat) -> Scene {
    let scene = empty([edge(count, 1.0, phi); 3], [true; 3], unit(), surface(restitution, 0.0));
    Scene { thermostat: Some(thermostat), ..scene }
}

fn at_random(scene: &Scene, count: usize, fluctuation: f64) -> Particles {
    random(scene, count, fluctuation, 4)
}

/// Elastic collisions keep the granular temperature T, so the thermostat alone changes it. Random accelerations add to
/// each of 3 N velocity components v a number w of variance w_0 = 1, so T gains the mean of 2 v w + w². The variance
/// of this mean is (4 T_0 w_0 + 2 w_0²)/(3 N) with T_0 = 1 at the start; five standard errors are allowed. The
/// thermostat that lets velocities grow draws no random number.
#[test]
fn heat_without_losses() {
    let count = 4000;
    let (time, windows) = (10.0, 50);
    let scene = gas(count, 0.05, 1.0, STOCHASTIC);
    let start = at_random(&scene, count, 1.0);
    let heated = run(&scene, start.clone(), hard(), time, windows);
    let gained = temperature(&heated.particles) / temperature(&start) - 1.0;
    let sum = (2.0_f64 + 4.0).sqrt() / (3.0 * count as f64).sqrt();
    close("stochastic", gained, 0.1 * time, 5.0 * sum);
    let grown = run(&gas(count, 0.05, 1.0, GAUSSIAN), start.clone(), hard(), time, windows);
    // rounding of 50 kicks and of some collisions of 4000 spheres
    close("gaussian", temperature(&grown.particles) / temperature(&start), (2.0 * 0.05 * time).exp(), 1e-12);
}

/// A thermostat does not change the momentum. The energy is that of the start plus the work of the thermostat minus
/// the losses, up to rounding.
#[test]
fn momentum_and_energy_are_in_the_books() {
    for thermostat in [STOCHASTIC, GAUSSIAN] {
        let scene = gas(500, 0.2, 0.8, thermostat);
        let mut start = at_random(&scene, 500, 1.0);
        // a mixture: every fifth sphere is heavier
        start.mass.iter_mut().step_by(5).for_each(|mass| *mass *= 4.0);
        start.velocity.iter_mut().for_each(|v| *v += Vector3::new(3.0, -1.0, 2.0));
        let momentum = start.momentum();
        let energy = start.kinetic_energy();
        for engine in [
            hard(),
            islands(),
            soft(1e4, 5e-4, Integrator::VelocityVerlet),
            Box::new(Dsmc::new(DsmcSettings::default(), 1)),
        ] {
            let after = run(&scene, start.clone(), engine, 0.3, 30);
            let ledger = &after.record.ledger;
            // 500 velocities of 10 are rounded in 30 kicks and some thousand collisions
            assert!((after.particles.momentum() - momentum).norm() < 1e-9, "{:?}", after.particles.momentum());
            assert!(ledger.thermostat_impulse.norm() < 1e-10 && ledger.thermostat_work > 1.0, "{ledger:?}");
            let elastic = after.elastic_energy();
            let residual = ledger.residual(energy, after.particles.kinetic_energy() + elastic);
            // soft contacts of 44 steps gain or lose a thousandth of their energy
            let tolerance = if elastic > 0.0 { 1e-2 * ledger.dissipated() } else { 1e-12 * energy };
            assert!(residual.abs() < tolerance, "{thermostat:?}: {residual} of {energy}");
        }
    }
}

/// Particles that move with the mean flow of a sheared box have no velocities relative to this flow, so a thermostat
/// makes nothing grow. Each velocity is off by the rounding of a velocity of 10 m/s times exp(0.5).
#[test]
fn the_mean_flow_of_a_sheared_box_is_not_heated() {
    let mut scene = gas(100, 0.01, 0.9, Thermostat::Gaussian { rate: 5.0 });
    scene.domain = scene.domain.sheared(0.5, 0.0);
    let mut particles = at_random(&scene, 100, 0.0);
    let mean = particles.relative_to_flow(&scene.domain).mean_velocity();
    particles.velocity.iter_mut().for_each(|v| *v -= mean);
    let after = run(&scene, particles, hard(), 0.1, 10);
    assert!(after.record.pairs.count == 0, "spheres in layers of one velocity meet");
    assert!(temperature(&after.relative_to_flow()).sqrt() < 1e-13);
}

/// Second Sonine coefficient of a gas with the restitution `e` that random accelerations heat (van Noije and Ernst
/// 1998, Granular Matter 1, 57, in three dimensions). If a thermostat lets all velocities grow, the coefficient is
/// that of a cooling gas.
fn sonine(thermostat: Thermostat, e: f64) -> f64 {
    let (d, numerator) = (3.0, 16.0 * (1.0 - e) * (1.0 - 2.0 * e * e));
    numerator
        / match thermostat {
            Thermostat::Stochastic { .. } => 73.0 + 56.0 * d - 24.0 * e * d - 105.0 * e + 30.0 * (1.0 - e) * e * e,
            Thermostat::Gaussian { .. } => 9.0 + 24.0 * d + 8.0 * e * d - 41.0 * e + 30.0 * (1.0 - e) * e * e,
        }
}

/// Granular temperature T of the steady state by kinetic theory. A collision of a sphere takes (1 - e²)/3 of T
/// (restitution e). The collision rate is Enskog's, and the losses have the first Sonine correction 1 + 3/16 a_2.
fn steady(thermostat: Thermostat, phi: f64, e: f64) -> f64 {
    let chi = (1.0 - 0.5 * phi) / (1.0 - phi).powi(3); // Carnahan and Starling 1969
    let rate = 4.0 * (6.0 * phi / PI) * chi * PI.sqrt();
    thermostat.steady_temperature(rate * (1.0 - e * e) / 3.0 * (1.0 + 3.0 / 16.0 * sonine(thermostat, e)))
}

/// Mean granular temperature over the second half of a run, and its standard error. The first half is several times as
/// long as the run needs to become steady. `at_start` is the temperature at the start.
fn measured(scene: &Scene, count: usize, engine: Box<dyn diptych::engine::Engine>, at_start: f64) -> [f64; 2] {
    let mut simulation = Simulation::with_engine(scene.clone(), at_random(scene, count, at_start.sqrt()), engine);
    let (window, each, blocks) = (0.05, 25, 30);
    simulation.run(each * blocks, window).unwrap();
    let means: Vec<f64> = (0..blocks)
        .map(|_| {
            let sums = (0..each).map(|_| {
                simulation.run(1, window).unwrap();
                temperature(&simulation.particles)
            });
            sums.sum::<f64>() / each as f64
        })
        .collect();
    let mean = means.iter().sum::<f64>() / blocks as f64;
    let variance = means.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / (blocks - 1) as f64;
    // blocks last as long as T remembers; twice the variance allows for the correlation of neighbours
    [mean, (2.0 * variance / blocks as f64).sqrt()]
}

/// Granular temperature of hard spheres, soft spheres and collisions by chance. Theory neglects correlations of
/// velocities, which lower the collision rate by about a per cent at this density and restitution; further terms of
/// Sonine's series are below 0.1 %.
#[test]
fn steady_states_are_those_of_kinetic_theory() {
    let (count, phi, e) = (500, 0.1, 0.9);
    for thermostat in [STOCHASTIC, GAUSSIAN] {
        let scene = gas(count, phi, e, thermostat);
        let theory = steady(thermostat, phi, e);
        let dsmc = || Box::new(Dsmc::new(DsmcSettings::default(), 1));
        for (name, engine) in
            [("hard", hard()), ("soft", local(1e5, 1e-4, Integrator::VelocityVerlet)), ("dsmc", dsmc())]
        {
            let [mean, error] = measured(&scene, count, engine, 0.8 * theory);
            println!("{thermostat:?} {name}: {mean:.4} ± {error:.4}, theory {theory:.4}");
            assert!(error < 0.02 * theory, "{name}: {error} of {theory}");
            close(name, mean, theory, 5.0 * error + 0.015 * theory);
        }
    }
}

/// Without collisions, Stokes drag and random accelerations balance at the granular temperature ξ² τ/2 (heating rate
/// ξ², response time τ). Five standard errors of 3 N squares are allowed.
#[test]
fn drag_and_heat_balance() {
    let text = CASE.replace(
        "[contact]",
        "[fluid]\ndensity = \"1 kg/m^3\"\nkinematic_viscosity = \"1e-5 m^2/s\"\n\
         [fluid.profile.uniform]\nvelocity = \"0 m/s\"\n[drag.stokes]\n[contact]",
    );
    let experiment = case(&text, Model::Hard, &["run.duration=\"2 s\"", "particles[0].diameter=\"10 um\""]).unwrap();
    let mut simulation = Simulation::new(&experiment, initial_state(&experiment).unwrap());
    let window = Schedule::new(&experiment).window;
    // τ = ρ_p d²/(18 ρ ν) = 1.39 ms; the window is a quarter of it, so that an error of first order would be seen
    let tau = 2500.0 * 1e-10 / (18.0 * 1e-5);
    simulation.run((10.0 * tau / window).ceil() as u64, window).unwrap();
    simulation.run(40, 0.25 * tau).unwrap();
    let count = simulation.count() as f64;
    let expected = 0.5 * 10.0 * tau;
    // with x = h/τ the splitting gives x coth x of it, which is 1 + x²/3 = 1.021
    close(
        "balance",
        temperature(&simulation.particles),
        expected,
        expected * (5.0 * (2.0 / (3.0 * count)).sqrt() + 0.021),
    );
}

const CASE: &str = r#"
[domain]
size = ["10 mm", "10 mm", "10 mm"]
periodic = ["x", "y", "z"]
[thermostat.stochastic]
heating = "10 m^2/s^3"
[[particles]]
name = "bead"
diameter = "0.5 mm"
density = "2500 kg/m^3"
count = 1200
velocity_fluctuation = "0.2 m/s"
[contact]
restitution = 0.9
[soft.linear_spring_dashpot]
stiffness = "1000 N/m"
[run]
model = "hard"
duration = "0.2 s"
seed = 3
"#;

#[test]
fn random_accelerations_are_the_same_on_processes_after_a_snapshot_and_in_any_order() {
    let experiment = case(CASE, Model::Soft, &[]).unwrap();
    let window = Schedule::new(&experiment).window;
    let start = initial_state(&experiment).unwrap();
    let mut whole = Simulation::new(&experiment, start.clone());
    whole.run(40, window).unwrap();
    let mut first = Simulation::new(&experiment, start.clone());
    let mut done = 0;
    first
        .run_while(40, window, &mut |simulation, windows| {
            done = windows;
            simulation.with_synchronised_velocities(0.5 * window, |_| ());
            windows < 17
        })
        .unwrap();
    let mut second = Simulation::restore(&experiment, first.snapshot().unwrap()).unwrap();
    second.run(40 - done, window).unwrap();
    assert_eq!(whole.fingerprint(), second.fingerprint());
    let mut backwards = Particles::default();
    let order: Vec<u32> = (0..start.len() as u32).rev().collect();
    backwards.copy_from(&start, &order);
    let mut turned = Simulation::new(&experiment, backwards);
    turned.run(40, window).unwrap();
    assert_eq!(whole.fingerprint(), turned.fingerprint());
    let of = (experiment.scene.clone(), start);
    for stepping in [SoftStepping::Local, SoftStepping::Uniform] {
        let engine = || {
            let law = ContactLaw::linear(1000.0);
            Box::new(Soft::new(law, Integrator::VelocityVerlet, 1e-6, stepping)) as Box<dyn Distributed>
        };
        let on = |size| shared(size, &of, &engine, (4e-3, 12), |simulation| simulation.fingerprint());
        let alone = on(1);
        for size in [2, 3] {
            assert_eq!(on(size), alone, "{size} processes");
        }
    }
}

#[test]
fn a_seed_changes_the_accelerations_and_nothing_else_does() {
    let experiment = case(CASE, Model::Hard, &[]).unwrap();
    let start = initial_state(&experiment).unwrap();
    let of = |seed: u64, windows: u64| {
        let engine = Box::new(Hard::new());
        let mut simulation = Simulation::with_engine(experiment.scene.clone(), start.clone(), engine).with_seed(seed);
        simulation.run(windows, 1e-3).unwrap();
        simulation.particles.velocity[simulation.particles.id.iter().position(|id| *id == 0).unwrap()]
    };
    assert_eq!(of(1, 1), of(1, 1));
    assert_ne!(of(1, 1), of(2, 1));
}

/// A box of elastic spheres between two thermal walls at y = 0 and y = 12 m. `temperatures` [m²/s²] are the granular
/// temperatures of these walls.
fn between(temperatures: [f64; 2]) -> Scene {
    let mut scene = empty([12.0; 3], [true, false, true], unit(), surface(1.0, 0.0));
    let walls = [(0.0, 1.0), (12.0, -1.0)].into_iter().zip(temperatures);
    scene.walls = walls
        .map(|((y, n), temperature)| Wall {
            thermal: Some(ThermalWall { temperature, seed: 5 }),
            ..plane([0.0, y, 0.0], [0.0, n, 0.0], surface(1.0, 0.0))
        })
        .collect();
    scene
}

/// Velocities after an impact on a thermal wall. Means and variances of their components agree with Maxwell's density
/// within five standard errors, at any angle of approach.
#[test]
fn spheres_leave_a_thermal_wall_as_from_an_opening() {
    let (wall, count) = (ThermalWall { temperature: 2.0, seed: 1 }, 100_000);
    for velocity in [[0.0, -1.0, 0.0], [30.0, -0.1, 2.0]] {
        let of = |id| {
            let velocity = Vector3::from(velocity);
            wall.rebound(&WallApproach { velocity, normal: Vector3::y(), id, wall: 0 }) / 2.0_f64.sqrt()
        };
        let mean =
            |what: &dyn Fn(Vector3<f64>) -> f64| (0..count).map(|id| what(of(id))).sum::<f64>() / f64::from(count);
        let root = f64::from(count).sqrt();
        for axis in [0, 2] {
            close("along", mean(&|v| v[axis]), 0.0, 5.0 / root);
            close("variance along", mean(&|v| v[axis] * v[axis]), 1.0, 5.0 * 2.0_f64.sqrt() / root);
        }
        // u has the mean sqrt(π/2) and the mean square 2; u² is exponential with the standard deviation 2
        close("normal", mean(&|v| v.y), (0.5 * PI).sqrt(), 5.0 * (2.0 - 0.5 * PI).sqrt() / root);
        close("square", mean(&|v| v.y * v.y), 2.0, 5.0 * 2.0 / root);
    }
}

/// Spheres that meet no others between walls of the temperatures T_1 and T_2. Half of the flux comes from each wall,
/// so the densities of spheres from the two walls are as 1/sqrt(T). Their temperature is sqrt(T_1 T_2) (Knudsen's
/// limit of heat conduction). Walls of one temperature give an ordinary gas of this temperature, dense or not. The
/// energy balance closes to rounding.
#[test]
fn gases_between_thermal_walls() {
    let dsmc = || Box::new(Dsmc::new(DsmcSettings::default(), 1)) as Box<dyn diptych::engine::Engine>;
    for (temperatures, count, wanted) in [([1.0, 4.0], 1, 2.0), ([0.5, 0.5], 300, 0.5)] {
        let engines: Vec<(&str, Box<dyn diptych::engine::Engine>)> =
            vec![("islands", islands()), ("calendar", Box::new(Hard::with_one_calendar())), ("dsmc", dsmc())];
        for (name, engine) in engines {
            let scene = between(temperatures);
            let mut simulation = Simulation::with_engine(scene.clone(), at_random(&scene, count, 1.0), engine);
            let energy = simulation.particles.kinetic_energy();
            // a sphere crosses the gap in some 10, and each of these times gives a new velocity
            let (blocks, each) = if count == 1 { (400, 100) } else { (20, 10) };
            simulation.run(20, 2.0).unwrap();
            let sampled = |simulation: &mut Simulation| {
                simulation.run(1, 2.0).unwrap();
                simulation.particles.velocity.iter().map(|v| v.norm_squared() / 3.0).sum::<f64>() / count as f64
            };
            let means: Vec<f64> = (0..blocks)
                .map(|_| (0..each).map(|_| sampled(&mut simulation)).sum::<f64>() / f64::from(each))
                .collect();
            let mean = means.iter().sum::<f64>() / f64::from(blocks);
            let variance = means.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / f64::from(blocks - 1);
            close(name, mean, wanted, 5.0 * (variance / f64::from(blocks)).sqrt());
            assert!(variance.sqrt() < f64::from(blocks).sqrt() * 0.02 * wanted, "{name}: scatter {}", variance.sqrt());
            let ledger = &simulation.record.ledger;
            let residual = ledger.residual(energy, simulation.particles.kinetic_energy());
            // each of some 1e4 impacts rounds an energy of the size of that of all spheres
            assert!(residual.abs() < 1e-11 * energy.max(count as f64) * 10.0, "{name}: {residual}");
            assert!(ledger.wall_restitution_loss == 0.0 && ledger.thermostat_work != 0.0);
        }
    }
}

#[test]
fn thermal_walls_give_the_same_bits_for_any_seed_order_and_snapshot_and_are_refused_for_contacts() {
    let text = CASE.replace("periodic = [\"x\", \"y\", \"z\"]", "periodic = [\"x\", \"z\"]").replace(
        "[thermostat.stochastic]\nheating = \"10 m^2/s^3\"\n",
        "[[walls]]\nrestitution = 1\ntemperature = \"0.1 m^2/s^2\"\nplane = { point = [0, 0, 0], normal = [0, 1, 0] }\n\
         [[walls]]\nrestitution = 1\ntemperature = \"0.2 m^2/s^2\"\nplane = { point = [0, \"10 mm\", 0], normal = [0, -1, 0] }\n",
    );
    let experiment = case(&text, Model::Hard, &[]).unwrap();
    let start = initial_state(&experiment).unwrap();
    let mut whole = Simulation::new(&experiment, start.clone());
    whole.run(40, 1e-3).unwrap();
    let mut first = Simulation::new(&experiment, start.clone());
    first.run(17, 1e-3).unwrap();
    let mut second = Simulation::restore(&experiment, first.snapshot().unwrap()).unwrap();
    second.run(23, 1e-3).unwrap();
    assert_eq!(whole.fingerprint(), second.fingerprint());
    let mut backwards = Particles::default();
    backwards.copy_from(&start, &(0..start.len() as u32).rev().collect::<Vec<u32>>());
    let mut turned = Simulation::new(&experiment, backwards);
    turned.run(40, 1e-3).unwrap();
    assert_eq!(whole.fingerprint(), turned.fingerprint());
    for (model, set, wanted) in [
        (Model::Soft, "run.seed=1", "is for impacts without duration"),
        (Model::Hard, "walls[0].restitution=0.9", "replaces restitution, friction and roughness"),
        (Model::Hard, "walls[1].friction=0.1", "replaces restitution, friction and roughness"),
        (Model::Dsmc, "walls[1].roughness.deviation=5 deg", "replaces restitution, friction and roughness"),
        (Model::Hard, "walls[0].temperature=0 m^2/s^2", "greater than 0"),
    ] {
        let message = case(&text, model, &[set]).unwrap_err();
        assert!(message.contains(wanted), "{set}: {message}");
    }
}

#[test]
fn thermostats_that_cannot_be_are_refused_or_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.toml");
    let say = |text: &str| {
        std::fs::write(&file, text).unwrap();
        let output = diptych(&["check", file.to_str().unwrap()]).output().unwrap();
        (output.status.code(), words(&output.stdout) + &words(&output.stderr))
    };
    let gaussian =
        CASE.replace("[thermostat.stochastic]\nheating = \"10 m^2/s^3\"", "[thermostat.gaussian]\nrate = \"5 1/s\"");
    for (text, code, wanted) in [
        (CASE.replace("\"10 m^2/s^3\"", "\"0 m^2/s^3\""), 2, "greater than 0"),
        (CASE.replace("\"10 m^2/s^3\"", "\"10 m/s\""), 2, "m^2/s^3"),
        (CASE.replace("heating = \"10 m^2/s^3\"", ""), 2, "thermostat.stochastic.heating"),
        (CASE.replace("[contact]", "[thermostat.gaussian]\nrate = 1\n[contact]"), 2, "thermostat"),
        (CASE.replace("restitution = 0.9", "restitution = 1"), 0, "nothing takes away the heat"),
        (CASE.replace("seed = 3", "seed = 3\nwindow = \"20 ms\""), 0, "the window is longer"),
        (gaussian.replace("velocity_fluctuation = \"0.2 m/s\"", ""), 0, "heats nothing"),
        (gaussian, 0, "grow exponentially at 5"),
    ] {
        let (status, message) = say(&text);
        assert!(status == Some(code) && message.contains(wanted), "{status:?} {wanted}: {message}");
    }
}
