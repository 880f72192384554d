//! Dense soft scenes: uniform steps against the simplest possible program, and equal bits for any number of threads.

use crate::support::*;
use diptych::experiment::Integrator;
use diptych::particles::Particles;
use diptych::scene::{Kind, Scene};
use nalgebra::Vector3;
use std::f64::consts::PI;

const STIFFNESS: f64 = 1e4;

/// Spheres of unit diameter and mass in a periodic cube, with the restitution 0.9 and without friction.
fn crowd(count: usize, fraction: f64) -> (Scene, Particles) {
    let scene = empty([edge(count, 1.0, fraction); 3], [true; 3], unit(), surface(0.9, 0.0));
    let start = random(&scene, count, 1.0, 5);
    (scene, start)
}

/// Velocity Verlet over all pairs, without neighbour lists. The dashpot force depends on the half-step velocity.
fn all_pairs(scene: &Scene, start: &Particles, dt: f64, steps: usize) -> Vec<Vector3<f64>> {
    let (mut x, mut v) = (start.position.clone(), start.velocity.clone());
    let mass = &start.mass;
    let ratio = |i: usize, j: usize| {
        let meeting = scene.meeting(start.species[i], Kind::Species(start.species[j]));
        let ln = meeting.surface.restitution.ln();
        -ln / (PI * PI + ln * ln).sqrt()
    };
    let accelerations = |x: &[Vector3<f64>], v: &[Vector3<f64>]| {
        let mut all = vec![Vector3::zeros(); x.len()];
        for i in 0..x.len() {
            for j in 0..i {
                let apart = scene.domain.separation(&x[i], &x[j]);
                let distance = apart.norm();
                if distance < 1.0 {
                    let n = apart / distance;
                    let damping = 2.0 * ratio(i, j) * (STIFFNESS / (1.0 / mass[i] + 1.0 / mass[j])).sqrt();
                    let force = STIFFNESS * (1.0 - distance) - damping * (v[i] - v[j]).dot(&n);
                    all[i] += n * (force / mass[i]);
                    all[j] -= n * (force / mass[j]);
                }
            }
        }
        all
    };
    let mut a = accelerations(&x, &v);
    for _ in 0..steps {
        for k in 0..x.len() {
            v[k] += a[k] * (0.5 * dt);
            x[k] += v[k] * dt;
        }
        a = accelerations(&x, &v);
        for k in 0..x.len() {
            v[k] += a[k] * (0.5 * dt);
        }
    }
    x
}

#[test]
fn dense_steps_are_those_of_all_pairs() {
    let (scene, start) = crowd(400, 0.45);
    compare_with_all_pairs(&scene, &start);
}

#[test]
fn dense_steps_of_spheres_that_differ_in_mass_alone_are_those_of_all_pairs() {
    let (scene, mut start) = crowd(400, 0.45);
    start.mass.iter_mut().step_by(3).for_each(|mass| *mass = 2.5);
    compare_with_all_pairs(&scene, &start);
}

#[test]
fn dense_steps_of_spheres_that_differ_in_restitution_alone_are_those_of_all_pairs() {
    let (mut scene, mut start) = crowd(400, 0.45);
    scene.species.push(unit());
    scene.pairs.set(0, Kind::Species(1), surface(0.6, 0.0).into());
    start.species.iter_mut().step_by(3).for_each(|species| *species = 1);
    compare_with_all_pairs(&scene, &start);
}

/// Runs a start in uniform steps (equal time steps for all particles), in few windows (pieces of the run) and in many.
/// Compares the final positions with those of [`all_pairs`].
fn compare_with_all_pairs(scene: &Scene, start: &Particles) {
    // a contact detected one step late changes a velocity by k δ dt, about 1e-3; a rounding error grows tenfold per
    // collision, and each sphere has two or three collisions
    let dt = PI * (0.5 / STIFFNESS).sqrt() / 20.0;
    let steps = 600;
    let exact = all_pairs(scene, start, dt, steps);
    // with many windows, neighbour lists are built between them, while the velocities lack half a kick of the contacts
    for windows in [2, 60] {
        let engine = soft(STIFFNESS, dt, Integrator::VelocityVerlet);
        let mut end = run(scene, start.clone(), engine, steps as f64 * dt, windows);
        assert!(end.record.pairs.count > 1000, "{}", end.record.pairs.count);
        assert!(end.counters().neighbour_builds >= 5, "{}", end.counters().neighbour_builds);
        end.particles.sort_by_id();
        let worst = exact.iter().zip(&end.particles.position).map(|(a, b)| scene.domain.separation(a, b).norm());
        let worst = worst.fold(0.0, f64::max);
        println!(
            "{windows} windows: largest difference {worst:.1e} diameters, {} lists",
            end.counters().neighbour_builds
        );
        assert!(worst < 1e-9, "{windows} windows: {worst:.1e}");
    }
}

#[test]
fn dense_steps_give_the_same_bits_on_any_number_of_threads() {
    // enough contacts for the threads to share the work on lists, forces and kicks
    let (scene, start) = crowd(16_000, 0.5);
    let dt = PI * (0.5 / STIFFNESS).sqrt() / 20.0;
    let once = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let end = run(&scene, start.clone(), soft(STIFFNESS, dt, Integrator::VelocityVerlet), 100.0 * dt, 2);
            let forces = end.counters().force_evaluations / 100;
            assert!(forces > 4500, "{forces} contacts at a time: the kicks are not shared out");
            let sum = end.record.pairs.normal_speed.sum().to_bits();
            (end.particles.fingerprint(), end.record.ledger, end.record.pairs.count, sum)
        })
    };
    let first = once(1);
    for threads in [2, 3] {
        assert_eq!(once(threads), first, "{threads} threads");
    }
}
