//! Memory of dense scenes: the largest number of bytes in use at one time. This is a program of its own, because its
//! allocator counts the memory of all threads.

#[allow(dead_code)]
mod support;

use diptych::engine::Engine;
use diptych::engine::hard::Hard;
use diptych::experiment::Integrator;
use diptych::simulation::Simulation;
use peak_alloc::PeakAlloc;
use std::f64::consts::PI;
use support::*;

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// Largest number of bytes in use in a run, including its random start of `count` unit spheres at a volume fraction of
/// 0.5. The run has four windows, in which each sphere has about twenty collisions.
fn most_in_use(count: usize, restitution: f64, engine: Box<dyn Engine>) -> usize {
    let before = HEAP.current_usage();
    HEAP.reset_peak_usage();
    let scene = empty([edge(count, 1.0, 0.5); 3], [true; 3], unit(), surface(restitution, 0.0));
    let start = random(&scene, count, 1.0, 5);
    let mut simulation = Simulation::with_engine(scene, start, engine);
    simulation.run(4, 0.125).unwrap();
    assert!(simulation.record.pairs.count > 5 * count as u64);
    simulation.end();
    HEAP.peak_usage() - before
}

/// Bytes in use per particle: from the difference between many and few particles, so that constant amounts cancel.
fn per_particle(restitution: f64, engine: fn() -> Box<dyn Engine>) -> f64 {
    let [few, many] = [4_000, 40_000];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let of = |count: usize| pool.install(|| most_in_use(count, restitution, engine()));
    (of(many) as f64 - of(few) as f64) / (many - few) as f64
}

/// Soft engine with stiffness and step as in benches/peers/dense.toml, in units of diameter, mass and speed.
fn springs() -> Box<dyn Engine> {
    let contact = 0.0095;
    soft(0.5 * (PI / contact).powi(2), contact / 20.0, Integrator::VelocityVerlet)
}

fn calendar() -> Box<dyn Engine> {
    Box::new(Hard::with_one_calendar())
}

#[test]
fn a_particle_of_a_dense_scene_takes_few_bytes() {
    // the program has a single test, because the allocator counts for the whole program
    let soft = per_particle(0.9, springs);
    let hard = per_particle(1.0, calendar);
    println!("bytes per particle: soft {soft:.0}, hard {hard:.0}");
    assert!(soft < 300.0, "soft: {soft:.0} bytes per particle");
    assert!(hard < 345.0, "hard: {hard:.0} bytes per particle");
}
