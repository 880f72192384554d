//! Event queue of all particles. It remains from one window (time between two drag kicks) to the next. The results must
//! not depend on the windows, the order of the store or the number of threads.

use crate::support::*;
use diptych::engine::hard::Hard;
use diptych::simulation::Simulation;
use diptych::walls::PrescribedMotion;
use diptych::{Particles, Scene, Vector3};

fn calendar(scene: &Scene, particles: &Particles) -> Simulation {
    Simulation::with_engine(scene.clone(), particles.clone(), Box::new(Hard::with_one_calendar()))
}

/// Gas of elastic spheres of unit diameter and mass in a periodic cube with the volume fraction `phi`. The centre of
/// mass is at rest.
fn gas(count: usize, phi: f64, seed: u64) -> (Scene, Particles) {
    let scene = empty([edge(count, 1.0, phi); 3], [true; 3], unit(), surface(1.0, 0.0));
    let mut particles = random(&scene, count, 1.0, seed);
    let mean = particles.mean_velocity();
    particles.velocity.iter_mut().for_each(|v| *v -= mean);
    (scene, particles)
}

fn velocities(simulation: &Simulation) -> Vec<Vector3<f64>> {
    simulation.state().velocity
}

#[test]
fn windows_leave_no_trace() {
    let (scene, start) = gas(1500, 0.4, 3);
    let mut whole = calendar(&scene, &start);
    whole.run(1, 1.0).unwrap();
    let mut parts = calendar(&scene, &start);
    parts.run(64, 1.0 / 64.0).unwrap();
    assert!(whole.record.pairs.count > 15_000);
    assert_eq!(whole.record.pairs.count, parts.record.pairs.count);
    // no event was computed again at the ends of windows, so that not even rounding errors differ
    assert!(velocities(&whole) == velocities(&parts));
    assert_eq!(whole.counters().neighbour_builds, 1);
    assert_eq!(parts.counters().neighbour_builds, 1);
    // if velocities change between windows, all events must be computed again; otherwise spheres would miss their new
    // partners
    let mut kicked = calendar(&scene, &start);
    kicked.run(32, 1.0 / 64.0).unwrap();
    kicked.particles.velocity.iter_mut().for_each(|v| *v = -*v);
    let before = kicked.record.pairs.count;
    kicked.run(32, 1.0 / 64.0).unwrap();
    let back = kicked.record.pairs.count - before;
    assert!((back as f64 / before as f64 - 1.0).abs() < 0.05, "{before} there, {back} back");
    let gap = smallest_gap(&scene, &kicked.particles);
    assert!(gap > -1e-12, "{gap}");
}

#[test]
fn equal_times_go_by_id() {
    // four spheres at the corners of a square meet in its middle at one instant; the second run has the reversed order
    // of the store
    let scene = empty([10.0; 3], [true; 3], unit(), surface(1.0, 0.0));
    let at = |x: f64, y: f64| ([5.0 + x, 5.0 + y, 5.0], [-x, -y, 0.0]);
    let list = [at(2.0, 0.0), at(-2.0, 0.0), at(0.0, 2.0), at(0.0, -2.0)];
    let mut runs = Vec::new();
    for turned in [false, true] {
        let mut particles = placed(&scene, &list);
        if turned {
            particles.reorder(&[3, 2, 1, 0]);
        }
        let mut simulation = calendar(&scene, &particles);
        simulation.run(3, 1.0).unwrap();
        assert!(simulation.record.pairs.count >= 2);
        runs.push(simulation.state().fingerprint());
    }
    assert_eq!(runs[0], runs[1]);
}

/// Compares the collision rate of a particle, times diameter over thermal speed, with a reference value at the volume
/// fraction 0.3 (Kolafa, Labik and Malijevsky 2004). Also checks that a run of `collisions` collisions conserves
/// energy and momentum.
fn keep_energy_momentum_and_order(collisions: u64) {
    let (scene, start) = gas(1000, 0.3, 5);
    let mut simulation = calendar(&scene, &start);
    let energy = start.kinetic_energy();
    let thermal = (2.0 * energy / (3.0 * 999.0)).sqrt();
    simulation.run(1, 10.0 / thermal).unwrap();
    let (began, count) = (simulation.time, simulation.record.pairs.count);
    while simulation.record.pairs.count < collisions {
        simulation.run(1, 400.0 / thermal).unwrap();
        assert!(smallest_gap(&scene, &simulation.particles) > -1e-12);
    }
    let counted = (simulation.record.pairs.count - count) as f64;
    let rate = 2.0 * counted / 1000.0 / ((simulation.time - began) * thermal);
    // a finite number N of particles lowers the rate by 1/N
    close("rate", rate, 10.1012 * (1.0 - 1e-3), 0.005 * 10.1);
    close("energy", simulation.particles.kinetic_energy() / energy, 1.0, 1e-10);
    let momentum = (simulation.particles.momentum() - start.momentum()).norm();
    assert!(momentum < 1e-12 * 1000.0 * thermal, "{momentum}");
    // overlaps at impacts are rounding errors, and do not grow during the run
    let largest = simulation.record.pairs.summary().largest_overlap.unwrap();
    assert!(largest < 1e-12, "{largest}");
    println!("{counted} collisions: rate {rate}, momentum {momentum:.1e}, largest overlap {largest:.1e}");
}

#[test]
fn ten_million_collisions_keep_energy_momentum_and_order() {
    keep_energy_momentum_and_order(10_000_000);
}

#[test]
#[ignore = "an hour: 10^9 collisions; cargo test -- --ignored --nocapture a_billion_collisions"]
fn a_billion_collisions_keep_energy_momentum_and_order() {
    keep_energy_momentum_and_order(1_000_000_000);
}

#[test]
fn a_stream_and_a_fall_do_not_matter_to_pairs() {
    let (mut scene, start) = gas(800, 0.2, 8);
    let mut at_rest = calendar(&scene, &start);
    at_rest.run(8, 0.05).unwrap();
    scene.gravity = Vector3::new(3.0, -7.0, 20.0);
    let mut moved = start.clone();
    moved.velocity.iter_mut().for_each(|v| *v += Vector3::new(30.0, 0.0, -50.0));
    let mut stream = calendar(&scene, &moved);
    stream.run(8, 0.05).unwrap();
    assert_eq!(at_rest.record.pairs.count, stream.record.pairs.count);
    assert_eq!(stream.counters().neighbour_builds, 1, "it goes on falling");
    let mean = Vector3::new(30.0, 0.0, -50.0) + scene.gravity * 0.4;
    for (a, b) in velocities(&at_rest).iter().zip(velocities(&stream)) {
        // rounding of 1e-14, amplified by a factor of about ten at each of up to a dozen collisions
        assert!((a + mean - b).norm() < 1e-3, "{a} {b}");
    }
}

#[test]
fn the_calendar_gives_the_same_bits_on_any_number_of_threads() {
    let (scene, start) = gas(20_000, 0.3, 4);
    let fingerprint = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut simulation = calendar(&scene, &start);
            simulation.run(3, 0.1).unwrap();
            // changed velocities require that all events are computed again, in parallel
            simulation.particles.velocity.iter_mut().for_each(|v| *v *= 1.5);
            simulation.run(3, 0.1).unwrap();
            assert!(simulation.record.pairs.count > 10_000);
            simulation.state().fingerprint()
        })
    };
    let one = fingerprint(1);
    assert_eq!(one, fingerprint(2));
    assert_eq!(one, fingerprint(5));
}

/// Runs on one thread and on more. Returns the simulations at the end, whose particles and ledgers (balances of energy
/// and momentum) must have equal bits.
fn on_threads(scene: &Scene, start: &Particles, duration: f64) -> Vec<Simulation> {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut simulation = calendar(scene, start);
            simulation.run(2, 0.5 * duration).unwrap();
            simulation
        })
    };
    let simulations: Vec<Simulation> = [1, 2, 3].into_iter().map(run).collect();
    let [one, more @ ..] = simulations.as_slice() else { unreachable!() };
    for other in more {
        assert_eq!(one.state().fingerprint(), other.state().fingerprint());
        assert_eq!(one.record.pairs.count, other.record.pairs.count);
        assert_eq!(one.record.walls.count, other.record.walls.count);
        assert!(one.record.ledger == other.record.ledger);
        assert!(one.record.pairs == other.record.pairs);
        assert_eq!(one.counters().events, other.counters().events);
    }
    simulations
}

#[test]
fn threads_that_share_the_events_leave_no_trace() {
    // three parts of 10,000 spheres; the walls are at the ends of the parts
    let (mut scene, start) = gas(30_000, 0.5, 6);
    scene.contact = surface(0.9, 0.1);
    let simulations = on_threads(&scene, &start, 0.2);
    assert!(simulations[0].record.pairs.count > 50_000, "{}", simulations[0].record.pairs.count);
    let work = simulations.iter().map(|simulation| simulation.counters().pair_checks);
    // rounds test some neighbours twice, so the events were shared
    assert!(work.collect::<std::collections::BTreeSet<_>>().len() > 1);
}

#[test]
fn threads_share_the_events_of_spheres_of_two_sizes() {
    // up to a ratio of two all shells are in one grid, in which each thread has cells of its own
    for small in [0.6, 0.3] {
        let (scene, mut start) = gas(20_000, 0.45, 9);
        for index in (0..start.len()).step_by(2) {
            start.radius[index] *= small;
            start.mass[index] *= f64::powi(small, 3);
        }
        let simulations = on_threads(&scene, &start, 0.1);
        assert!(simulations[0].record.pairs.count > 5_000, "{}", simulations[0].record.pairs.count);
    }
}

#[test]
fn threads_keep_apart_when_their_spheres_mix() {
    // in a dilute gas, spheres soon fly into the cells of the other part
    let (scene, start) = gas(20_000, 0.1, 3);
    let simulations = on_threads(&scene, &start, 2.0);
    assert!(simulations[0].record.pairs.count > 20_000, "{}", simulations[0].record.pairs.count);
}

#[test]
fn a_round_is_repeated_if_a_sphere_becomes_too_fast() {
    let edge = edge(20_000, 1.0, 0.45);
    let mut scene = empty([edge; 3], [true, false, true], unit(), surface(0.95, 0.0));
    scene.gravity = Vector3::new(0.0, -2.0, 0.5);
    let sides = [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]
        .map(|normal| plane([0.0, if normal[1] > 0.0 { 0.0 } else { edge }, 0.0], normal, surface(0.8, 0.1)));
    scene.walls = sides.into();
    let mut start = random(&scene, 20_000, 1.0, 7);
    // a light sphere that such a heavy one hits becomes up to twice as fast
    (start.mass[0], start.velocity[0]) = (1000.0, Vector3::new(3.0, 8.0, 2.0));
    let before = start.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let simulations = on_threads(&scene, &start, 0.1);
    let record = &simulations[0].record;
    let fastest = record.pairs.normal_speed.largest().unwrap();
    assert!(fastest > 1.25 * before, "{before} {fastest}");
    assert!(record.walls.count > 500 && record.pairs.count > 10_000, "{} {}", record.walls.count, record.pairs.count);
}

/// A layer of spheres that falls as a whole on a vibrating plate, in a box of the given height. The mean volume
/// fraction says little about the layer if the box is high.
fn layer(height: f64) -> (Scene, Particles) {
    let of_height = |height: f64| empty([16.0, height, 16.0], [true, false, true], unit(), surface(0.9, 0.0));
    // with one seed in ten, a sphere on the plate comes to rest, and the run stops
    let mut start = random(&of_height(7.0), 1000, 0.05, 5);
    for (position, velocity) in start.position.iter_mut().zip(&mut start.velocity) {
        position.y += 3.0;
        velocity.y -= 3.0;
    }
    let mut scene = of_height(height);
    scene.gravity = Vector3::new(0.0, -1.0, 0.0);
    let vibration = PrescribedMotion::Vibration { amplitude: Vector3::new(0.0, 0.5, 0.0), frequency: 0.3, phase: 0.0 };
    let plate = plane([0.0, 2.0, 0.0], [0.0, 1.0, 0.0], surface(0.9, 0.0)).moving(vibration).unwrap();
    let lid = plane([0.0, height, 0.0], [0.0, -1.0, 0.0], surface(0.9, 0.0));
    scene.walls = vec![plate, lid];
    (scene, start)
}

#[test]
fn a_layer_costs_the_same_in_a_high_box_and_loses_no_touch() {
    let [low, high] = [12.0, 200.0].map(|height| {
        let (scene, start) = layer(height);
        let mut simulation = calendar(&scene, &start);
        for _ in 0..60 {
            simulation.run(1, 0.1).unwrap();
            let gap = smallest_gap(&scene, &simulation.particles);
            assert!(gap > -1e-12, "{gap} at {}", simulation.time);
        }
        // spheres are above the plate, which is at 2.5 m at most
        assert!(simulation.particles.position.iter().all(|x| x.y > 1.5 + 0.5 - 1e-12 && x.y < height));
        let counters = simulation.counters();
        assert!(counters.events > 20_000, "{}", counters.events);
        counters.pair_checks as f64 / counters.events as f64
    });
    assert!(high < 1.5 * low, "{high} checks per collision in a high box, {low} in a low one");
}

#[test]
fn a_layer_that_is_followed_moves_as_in_islands() {
    let (scene, start) = layer(60.0);
    let mut islands = Simulation::with_engine(scene.clone(), start.clone(), Box::new(Hard::with_islands()));
    let mut calendar = calendar(&scene, &start);
    // the layer reaches the plate after 0.2 s; later, rounding errors have grown by the collisions of each sphere
    for simulation in [&mut islands, &mut calendar] {
        simulation.run(12, 0.05).unwrap();
        assert!(simulation.record.walls.count > 100 && simulation.record.pairs.count > 1000);
    }
    assert_eq!(islands.record.pairs.count, calendar.record.pairs.count);
    assert_eq!(islands.record.walls.count, calendar.record.walls.count);
    let [of_islands, of_calendar] = [islands, calendar].map(|simulation| simulation.state().position);
    let apart = of_islands.iter().zip(&of_calendar).map(|(a, b)| (a - b).norm());
    let furthest = apart.fold(0.0, f64::max);
    assert!(furthest < 1e-9, "{furthest}");
}
