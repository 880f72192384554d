//! Sheared boxes on an orbit: free motion against its closed form, the balance of energy, and the same bits.

use crate::support::*;
use diptych::domain::Orbit;
use diptych::engine::Engine;
use diptych::engine::dsmc::Dsmc;
use diptych::engine::hard::Hard;
use diptych::experiment::{DsmcSettings, Integrator, Model};
use diptych::scene::Thermostat;
use diptych::simulation::Simulation;
use diptych::{Domain, Particles, Scene, Vector3};

/// A cube of spheres of unit diameter and mass that orbits a point mass with the angular frequency 1 rad/s.
fn sheet(edge: f64, restitution: f64) -> Scene {
    let mut scene = empty([edge; 3], [true; 3], unit(), surface(restitution, 0.0));
    scene.domain = scene.domain.sheared(-1.5, 0.0).on_orbit(Orbit { rate: 1.0, vertical_frequency: 1.0 });
    scene
}

/// `count` random spheres in a cube, agitated and at rest relative to the mean flow.
fn ring(count: usize, edge: f64, restitution: f64) -> (Scene, Particles) {
    let scene = sheet(edge, restitution);
    let particles = random(&scene, count, 0.5, 1);
    (scene, particles)
}

/// Largest error of position [m] and velocity [m/s] of one free sphere after two orbits with windows (pieces) of
/// `window` [s].
fn error_of_free_motion(window: f64) -> f64 {
    let scene = sheet(40.0, 1.0);
    let (y, height) = (3.0, 2.0);
    let (radial, along, vertical) = (0.7, -0.4, 0.3);
    let velocity = [vertical, radial, along - 1.5 * (20.0 + y)];
    let particles = placed(&scene, &[([20.0 + height, 20.0 + y, 20.0], velocity)]);
    let mut simulation = Simulation::with_engine(scene, particles, Box::new(Hard::new()));
    let time = 12.5;
    simulation.run((time / window).round() as u64, window).unwrap();
    let (sin, cos) = f64::sin_cos(time);
    let (at, velocity) = (simulation.particles.position[0], simulation.particles.velocity[0]);
    let errors = [
        at.x - 20.0 - (height * cos + vertical * sin),
        at.y - 20.0 - (y + radial * sin + 2.0 * along * (1.0 - cos)),
        velocity.x - (vertical * cos - height * sin),
        velocity.y - (radial * cos + 2.0 * along * sin),
        velocity.z + 1.5 * at.y - (along * cos - 0.5 * radial * sin),
    ];
    errors.into_iter().fold(0.0, |largest, error| error.abs().max(largest))
}

#[test]
fn a_free_sphere_moves_on_an_epicycle() {
    let [coarse, fine] = [0.05, 0.025].map(error_of_free_motion);
    // the phase is late by (2 h)²/24 of it: 12.5 * 4.2e-4 of amplitudes of about 2
    assert!(coarse < 0.011, "{coarse}");
    let ratio = coarse / fine;
    assert!((ratio - 4.0).abs() < 0.1, "the error is not of second order: {coarse} {fine}");
}

#[test]
fn the_mean_flow_is_a_free_motion() {
    let scene = sheet(20.0, 1.0);
    let at = [[10.0, 3.0, 5.0], [10.0, 17.0, 5.0]];
    let particles = placed(&scene, &at.map(|place| (place, [0.0, 0.0, -1.5 * place[1]])));
    let mut simulation = Simulation::with_engine(scene, particles, Box::new(Hard::new()));
    simulation.run(500, 0.05).unwrap();
    for (index, place) in at.into_iter().enumerate() {
        let (x, v) = (simulation.particles.position[index], simulation.particles.velocity[index]);
        assert_eq!([x.x, x.y], [place[0], place[1]]);
        assert!((v - Vector3::new(0.0, 0.0, -1.5 * place[1])).norm() < 1e-12, "{v}");
    }
}

#[test]
fn work_of_tides_and_shear_balances_the_energy() {
    let makers: [(&str, Box<dyn Engine>, f64); 4] = [
        ("hard", Box::new(Hard::new()), 1e-12),
        ("dsmc", Box::new(Dsmc::new(DsmcSettings::default(), 1)), 1e-12),
        ("one calendar", Box::new(Hard::with_one_calendar()), 1e-12),
        ("soft", local(1e4, 5.5e-4, Integrator::VelocityVerlet), 1e-6),
    ];
    for (name, engine, tolerance) in makers {
        let (scene, particles) = ring(300, 12.0, 0.6);
        let before = particles.kinetic_energy();
        let mut simulation = Simulation::with_engine(scene, particles, engine).with_seed(1);
        simulation.run(300, 0.02).unwrap();
        let ledger = &simulation.record.ledger;
        assert!(simulation.record.pairs.count > 100, "{name}: {}", simulation.record.pairs.count);
        assert!(ledger.gravity_work.abs() > 1.0, "{name}: tides do work");
        let given = ledger.gravity_work + ledger.shear_work - ledger.dissipated();
        let through = before + ledger.gravity_work.abs() + ledger.shear_work.abs();
        let open = (simulation.energy() - before - given) / through;
        assert!(open.abs() < tolerance, "{name}: {open}");
    }
}

/// The velocity of a particle beyond a sheared side differs from that of its image in the box. The kicks of a
/// thermostat must use the velocity of the particle.
#[test]
fn a_thermostat_balances_the_energy_of_a_sheared_box() {
    let makers: [(&str, Box<dyn Engine>); 2] =
        [("islands", Box::new(Hard::new())), ("one calendar", Box::new(Hard::with_one_calendar()))];
    for (name, engine) in makers {
        let (mut scene, particles) = ring(300, 12.0, 0.9);
        scene.domain = Domain::new(scene.domain.size, [true; 3]).sheared(1.0, 0.0);
        scene.thermostat = Some(Thermostat::Stochastic { heating: 0.1 });
        let mut particles = particles;
        particles.velocity.iter_mut().zip(&particles.position).for_each(|(v, x)| v.z += 2.5 * x.y);
        let before = particles.kinetic_energy();
        let mut simulation = Simulation::with_engine(scene, particles, engine).with_seed(1);
        simulation.run(100, 0.02).unwrap();
        let ledger = &simulation.record.ledger;
        assert!(ledger.shear_work.abs() > 1.0 && ledger.thermostat_work > 1.0, "{name}");
        let given = ledger.thermostat_work + ledger.shear_work - ledger.dissipated();
        let open = (simulation.energy() - before - given) / (before + ledger.shear_work.abs());
        assert!(open.abs() < 1e-12, "{name}: {open}");
    }
}

#[test]
fn an_orbit_has_the_same_bits_on_any_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (scene, particles) = ring(500, 12.0, 0.6);
        let mut simulation = Simulation::with_engine(scene, particles, Box::new(Hard::new()));
        pool.install(|| simulation.run(60, 0.02)).unwrap();
        let state = simulation.state();
        (state.position, state.velocity, simulation.record.ledger.gravity_work)
    };
    let one = run(1);
    assert!(run(3) == one);
}

#[test]
fn an_orbit_without_restoring_force_is_refused() {
    let text = |orbit: &str| {
        format!(
            "[domain]\nsize = [\"40 m\", \"60 m\", \"60 m\"]\nperiodic = [\"x\", \"y\", \"z\"]\n\
             [domain.shear]\nrate = \"-2e-4 1/s\"\n[domain.shear.orbit]\n{orbit}\n\
             [[particles]]\nname = \"ice\"\ndiameter = \"1 m\"\ndensity = \"900 kg/m^3\"\ncount = 100\n\
             [contact]\nrestitution = 0.5\nfriction = 0.0\n[run]\nduration = \"1e5 s\"\n"
        )
    };
    for (orbit, why) in [
        ("rate = \"0 1/s\"", "is no orbit"),
        ("rate = \"1e-4 1/s\"", "makes free motion unstable"),
        ("rate = \"-1e-4 1/s\"\nvertical_frequency = \"-1 1/s\"", "vertical_frequency"),
        ("vertical_frequency = \"1e-4 1/s\"", "domain.shear.orbit.rate"),
    ] {
        let said = case(&text(orbit), Model::Hard, &[]).unwrap_err();
        assert!(said.contains(why), "{said}");
    }
    let experiment = case(&text("rate = \"1.5e-4 1/s\""), Model::Hard, &[]).unwrap();
    let orbit = experiment.scene.domain.orbit().unwrap();
    assert_eq!([orbit.rate, orbit.vertical_frequency], [1.5e-4; 2]);
    // windows resolve an orbit: (2 Ω h)²/24 is at most 1e-4
    let schedule = diptych::schedule::Schedule::new(&experiment);
    assert!(schedule.longest() * 3e-4 < 0.049_f64, "{}", schedule.longest());
}
