//! Stress, contacts per particle and volume fraction: one impact in closed form, and a gas against its equation of
//! state.

use crate::support::*;
use diptych::contact_law::ContactLaw;
use diptych::engine::Engine;
use diptych::experiment::{AverageFrom, Integrator, Model, Spheres};
use diptych::outcome::Outcome;
use diptych::placement::initial_state;
use diptych::study::execute;
use nalgebra::Matrix3;
use std::f64::consts::PI;

#[test]
fn the_virial_of_one_impact() {
    // unit spheres in a head-on impact at u = 2 along x + y: M = 1/2, impulse 2 M u. The spring force acts over the
    // distance 1 - δ, and k ∫ δ² dt = M u² π/(2 ω)
    let (u, k, mass) = (2.0f64, 1e4f64, 0.5f64);
    let scene = empty([10.0; 3], [true; 3], unit(), surface(1.0, 0.0));
    let along = std::f64::consts::FRAC_1_SQRT_2;
    let (near, far) = (5.0 - 0.55 * along, 5.0 + 0.55 * along);
    let v = 0.5 * u * along;
    let start = placed(&scene, &[([near, near, 5.0], [v, v, 0.0]), ([far, far, 5.0], [-v, -v, 0.0])]);
    let dt = PI * (mass / k).sqrt() / 100.0;
    let sharp = 2.0 * mass * u;
    let blunt = sharp - mass * u * u * PI / (2.0 * (k / mass).sqrt());
    let engines: [(&str, Box<dyn Engine>, f64, f64); 4] = [
        ("hard", hard(), sharp, 1e-12),
        ("islands", islands(), sharp, 1e-12),
        ("uniform", soft(k, dt, Integrator::VelocityVerlet), blunt, 1e-3),
        ("local", local(k, dt, Integrator::Rk2), blunt, 1e-3),
    ];
    for (name, engine, trace, tolerance) in engines {
        let end = run(&scene, start.clone(), engine, 0.2, 4);
        assert_eq!(end.record.pairs.count, 1, "{name}");
        let got = end.record.ledger.pair_virial;
        let want = 0.5 * trace * Matrix3::new(1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0);
        assert!((got - want).amax() < tolerance * trace, "{name}: {got} {want}");
    }
}

/// Outcome of a gas of unit spheres at the granular temperature 1 m²/s² in a periodic cube. It runs for `duration` [s]
/// and is averaged from the time `from` [s] on.
fn gas(phi: f64, spheres: Spheres, (duration, from): (f64, f64)) -> Outcome {
    let scene = empty([edge(1000, 1.0, phi); 3], [true; 3], unit(), surface(1.0, 0.0));
    let mut experiment = experiment(scene, 1000, [0.0; 3], 1.0, Model::Hard, 3);
    experiment.run.spheres = spheres;
    experiment.run.duration = duration;
    experiment.run.average_from = AverageFrom::Time(from);
    let outcome = execute(&experiment, initial_state(&experiment).unwrap(), &mut []).0;
    assert!(outcome.failure.is_none(), "{:?}", outcome.failure);
    outcome
}

#[test]
fn pressure_of_a_gas_is_that_of_its_equation_of_state() {
    // oracle D1 (Kolafa, Labik & Malijevsky); N particles have (N-1)/N of the pair density; the tolerance is 3 standard
    // errors + 0.5 %
    for (phi, z) in [(0.01, 1.041019), (0.3, 3.983983), (0.45, 9.404114)] {
        let outcome = gas(phi, Spheres::Hard, (60.0, 5.0));
        let stress = &outcome.stress;
        let got = stress.compressibility.unwrap();
        println!("phi {phi}: Z {} +- {:?}, oracle {z}", got.value, got.error);
        let tolerance = 3.0 * got.error.unwrap() + 0.005 * (z - 1.0);
        close("Z", got.value - 1.0, (z - 1.0) * 0.999, tolerance);
        assert_eq!(stress.coordination, None);
        let density = 6.0 * phi / PI;
        for part in &stress.kinetic[..3] {
            close("n m T", part.unwrap().value, density, 0.1 * density);
        }
        for part in &stress.contact[3..] {
            let part = part.unwrap();
            close("shear", part.value, 0.0, 5.0 * part.error.unwrap());
        }
        let filled = stress.volume_fraction.iter().map(|slice| slice.unwrap().value).sum::<f64>();
        close("volume fraction", filled / stress.volume_fraction.len() as f64, phi, 1e-12);
    }
}

#[test]
fn pressure_and_contacts_of_soft_spheres() {
    // the pressure is that of hard spheres with Barker and Henderson's diameter at the kinetic temperature (Carnahan
    // and Starling); the tolerance is 3 standard errors + 2 %
    let (phi, k) = (0.3f64, 1e5f64);
    let outcome = gas(phi, Spheres::Soft(ContactLaw::linear(k)), (4.0, 1.0));
    let stress = &outcome.stress;
    let diameter = 1.0 - (0.5 * PI / k).sqrt();
    let eta = phi * diameter.powi(3);
    let z = (1.0 + eta + eta * eta - eta.powi(3)) / (1.0 - eta).powi(3);
    let got = stress.compressibility.unwrap();
    println!("Z {} +- {:?}, theory {z}", got.value, got.error);
    close("Z", got.value, z, 3.0 * got.error.unwrap() + 0.02 * z);
    // during its contact time, each impact adds two to the contacts of particles
    let joined = 2.0 * outcome.pair_rate.unwrap().value * outcome.pairs.summary().mean_duration.unwrap() / 1000.0;
    let touching = stress.coordination.unwrap();
    println!("contacts per particle {} +- {:?}, by impacts {joined}", touching.value, touching.error);
    close("contacts per particle", touching.value, joined, 3.0 * touching.error.unwrap() + 0.02 * joined);
}

#[test]
fn dense_starts_by_relaxation() {
    for (phi, walls) in [(0.62, false), (0.57, true)] {
        let mut scene = empty([edge(1000, 1.0, phi); 3], [true, !walls, true], unit(), surface(1.0, 0.0));
        if walls {
            let top = scene.domain.size.y;
            scene.walls = vec![
                plane([0.0; 3], [0.0, 1.0, 0.0], surface(1.0, 0.0)),
                plane([0.0, top, 0.0], [0.0, -1.0, 0.0], surface(1.0, 0.0)),
            ];
        }
        let go = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| random(&scene, 1000, 1.0, 9))
        };
        let start = go(1);
        let gap = smallest_gap(&scene, &start);
        println!("phi {phi}: smallest gap {gap:.1e}");
        assert!(gap > 0.0, "{gap:.1e}");
        assert_eq!(start.fingerprint(), go(2).fingerprint());
        assert!((temperature(&start) - 1.0).abs() < 0.01);
    }
}
