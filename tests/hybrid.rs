//! Hybrid spheres: instantaneous collisions of two spheres without others nearby, and lasting contacts elsewhere.

use crate::support::*;
use diptych::case::Case;
use diptych::contact_law::ContactLaw;
use diptych::engine::hybrid::Hybrid;
use diptych::engine::{Engine, Failure};
use diptych::experiment::{Integrator, Model};
use diptych::particles::Particles;
use diptych::scene::Scene;
use diptych::simulation::Simulation;
use nalgebra::Vector3;

/// Hybrid engine with stiffness k [N/m], time step dt [s], and clearance [-]: time for which no third body may come
/// near an impact, divided by the contact time.
fn hybrid(k: f64, dt: f64, clearance: f64) -> Box<dyn Engine> {
    Box::new(Hybrid::new(ContactLaw::linear(k), Integrator::VelocityVerlet, dt, clearance))
}

/// [s] duration of a contact of two small spheres of the paper (docs/paper.md), with the stiffness `k` [N/m].
fn contact_time(k: f64) -> f64 {
    std::f64::consts::PI * (0.5 * small().mass() / k).sqrt()
}

/// [-] momentum that the ledger (sum of all known gains and losses) does not explain, divided by the largest momentum
/// that was transferred.
fn momentum_residual(simulation: &Simulation, before: Vector3<f64>) -> f64 {
    let ledger = &simulation.record.ledger;
    let given = ledger.gravity_impulse + ledger.wall_impulse + ledger.drag_impulse;
    let scale = simulation.particles.mass.iter().zip(&simulation.particles.velocity).map(|(m, v)| m * v.norm());
    let scale = scale.sum::<f64>() + ledger.gravity_impulse.norm() + ledger.wall_impulse.norm();
    (simulation.particles.momentum() - before - given).norm() / scale
}

/// [-] energy that the ledger (sum of all known gains and losses) does not explain, divided by the energy `before` [J]
/// at the start.
fn energy_residual(simulation: &Simulation, before: f64) -> f64 {
    simulation.record.ledger.residual(before, simulation.energy()) / simulation.record.ledger.through(before)
}

#[test]
fn two_that_meet_alone_are_hard_spheres() {
    let species = small();
    let edge = (2000.0 * species.volume() / 0.01).cbrt();
    let mut scene = empty([edge; 3], [true, false, true], species, surface(0.9, 0.2));
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.8, 0.3)),
        plane([0.0, edge, 0.0], [0.0, -1.0, 0.0], surface(0.8, 0.3)),
    ];
    scene.gravity = Vector3::new(0.0, -3.0, -9.81);
    let particles = random(&scene, 2000, 0.5, 7);
    let (before, energy) = (particles.momentum(), particles.kinetic_energy());
    let k = 1e9;
    let hard = run(&scene, particles.clone(), hard(), 2e-3, 20);
    let both = run(&scene, particles, hybrid(k, contact_time(k) / 20.0, 5.0), 2e-3, 20);
    assert!(hard.record.pairs.count > 100, "{}", hard.record.pairs.count);
    assert_eq!(both.record.pairs.count, hard.record.pairs.count);
    assert_eq!(both.record.pairs.instants.count, both.record.pairs.count);
    assert_eq!(both.record.walls.instants.count, hard.record.walls.count);
    // islands that are solved several times count several times
    assert!(both.counters().events >= both.record.pairs.count + both.record.walls.count);
    // rounding differs, and each collision may amplify the difference by a mean free path over a radius, as between
    // islands and an event queue
    for (x, y) in both.particles.velocity.iter().zip(&hard.particles.velocity) {
        assert!((x - y).norm() < 1e-6, "{x} {y}");
    }
    assert!(momentum_residual(&both, before) < 1e-12);
    assert!(energy_residual(&both, energy).abs() < 1e-12);
    // the neglected time and overlap of instantaneous impacts are those of the law for the mean impact: the contact
    // time of the two spheres, and an overlap of u/ω_0
    let instants = &both.record.pairs.instants;
    let mean = instants.duration() / instants.count as f64;
    close("contact time left out", mean / contact_time(k), 1.0, 2e-3);
}

/// Number of impacts that are instantaneous, and number of all impacts. The first of three spheres in a row arrives at
/// 0.1 m/s, and the third is `gap` [m] behind the second.
fn in_a_row(gap: f64) -> (u64, u64) {
    let d = small().diameter;
    let scene = empty([20.0 * d; 3], [true; 3], small(), surface(1.0, 0.0));
    let y = 10.0 * d;
    let at = |x: f64, u: f64| ([x, y, y], [u, 0.0, 0.0]);
    let particles = placed(&scene, &[at(5.0 * d, 0.1), at(6.5 * d, 0.0), at(7.5 * d + gap, 0.0)]);
    let done = run(&scene, particles, hybrid(3000.0, contact_time(3000.0) / 50.0, 1.0), 0.02, 1);
    assert!((done.particles.velocity[2].x - 0.1).abs() < 1e-2);
    (done.record.pairs.instants.count, done.record.pairs.count)
}

#[test]
fn who_may_come_before_a_contact_is_over_makes_it_last() {
    // an impulse changes the velocity of one of two equal spheres by at most the approach velocity, here 0.1 m/s
    let reached = 0.1 * contact_time(3000.0);
    assert_eq!(in_a_row(1.01 * reached), (2, 2));
    assert_eq!(in_a_row(0.99 * reached).0, 1, "the second impact of the two is alone");
    assert_eq!(in_a_row(0.0).0, 0);
}

#[test]
fn a_cradle_is_that_of_soft_spheres() {
    // the solution for five spheres in a row with linear springs, to four digits (cases/cradle.toml)
    let d = small().diameter;
    let scene = empty([6e-3, 4e-3, 4e-3], [false; 3], small(), surface(1.0, 0.0));
    let at = |k: usize| ([1.506e-3 + k as f64 * d, 2e-3, 2e-3], [0.0; 3]);
    let mut list = vec![([1e-3, 2e-3, 2e-3], [1.0, 0.0, 0.0])];
    list.extend((0..4).map(at));
    let particles = placed(&scene, &list);
    let done = run(&scene, particles, hybrid(3000.0, contact_time(3000.0) / 200.0, 5.0), 3e-4, 3);
    for (v, want) in done.particles.velocity.iter().zip([-0.1323, -0.0753, -0.0310, 0.2962, 0.9424]) {
        close("velocity", v.x, want, 1e-4);
    }
}

#[test]
fn a_ball_bounces_to_rest() {
    let (k, d, g) = (100.0, small().diameter, 9.81);
    let mut scene = empty([20.0 * d; 3], [true, false, true], small(), surface(1.0, 0.0));
    scene.gravity = Vector3::new(0.0, -g, 0.0);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.5, 0.0))];
    let ball = placed(&scene, &[([10.0 * d, 5.5 * d, 10.0 * d], [0.0; 3])]);
    let (_, alone) = try_run(&scene, ball.clone(), hard(), 0.1, 50);
    assert!(matches!(alone, Err(Failure::InelasticCollapse { .. })), "{alone:?}");
    let (before, step) = (ball.momentum(), contact_time(k) / 20.0);
    let done = run(&scene, ball, hybrid(k, step, 5.0), 0.1, 50);
    let walls = &done.record.walls;
    assert!(walls.instants.count >= 3, "{}", walls.instants.count);
    close("e of the instants", walls.instants.restitution().unwrap(), 0.5, 1e-12);
    assert!(done.particles.velocity[0].norm() < 1e-6, "{}", done.particles.velocity[0]);
    let overlap = 0.5 * d - done.particles.position[0].y;
    close("overlap under the weight", overlap / (small().mass() * g / k), 1.0, 1e-3);
    assert_eq!(done.contacts().len(), 1);
    assert!(momentum_residual(&done, before) < 1e-9, "{}", momentum_residual(&done, before));
    assert!(energy_residual(&done, 0.0).abs() < 1e-4, "{}", energy_residual(&done, 0.0));
}

/// Bed of three touching layers below `gas` flying spheres. The bed has too many particles for one island (group of
/// particles that may meet) of local time steps.
fn gas_over_bed(gas: usize) -> (Scene, Particles) {
    let d = small().diameter;
    let (side, height) = (12.0 * d * (1.0 + 1e-6), 80.0 * d);
    let mut scene = empty([side, height, side], [true, false, true], small(), surface(0.6, 0.2));
    scene.gravity = Vector3::new(0.0, -9.81, 0.0);
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.6, 0.2)),
        plane([0.0, height, 0.0], [0.0, -1.0, 0.0], surface(0.6, 0.2)),
    ];
    let at = |k: usize| (k as f64 + 0.5) * d * (1.0 + 1e-6);
    let cells = |n: usize| [at(n % 12), at(n / 144), at(n / 12 % 12)];
    let mut list: Vec<_> = (0..432).map(|n| (cells(n), [0.0; 3])).collect();
    // the gas takes every third position of the layers above; all velocities differ
    for n in 0..gas {
        let x = [n % 4, 2 + n / 16, n / 4 % 4].map(|k| 3.0 * d * (k as f64 + 0.5));
        let v = [1, 2, 3].map(|axis| ((n * n * axis + n + axis) as f64).sin());
        list.push((x, v));
    }
    let particles = placed(&scene, &list);
    (scene, particles)
}

#[test]
fn a_bed_is_stepped_while_the_gas_above_it_collides() {
    let k = 300.0;
    let step = contact_time(k) / 20.0;
    let (scene, particles) = gas_over_bed(384);
    let (before, energy) = (particles.momentum(), particles.kinetic_energy());
    let with = || run(&scene, particles.clone(), hybrid(k, step, 2.0), 6e-3, 6);
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| with().particles.fingerprint())
    };
    let done = with();
    let counters = done.counters();
    assert!(counters.largest_island >= 432, "the bed is one island: {counters:?}");
    assert!(counters.uniform_steps > 0 && counters.uniform_steps < 10 * 6000, "{counters:?}");
    let pairs = &done.record.pairs;
    assert!(pairs.instants.count > 50 && pairs.count > pairs.instants.count, "{pairs:?}");
    assert_eq!(bits(1), done.particles.fingerprint());
    assert_eq!(bits(2), bits(1));
    assert!(momentum_residual(&done, before) < 1e-12, "{}", momentum_residual(&done, before));
    // the energy error of dashpot and friction with Verlet's method at 20 steps per contact, as for uniform soft steps
    let residual = energy_residual(&done, energy);
    let soft = run(&scene, particles.clone(), soft(k, step, Integrator::VelocityVerlet), 6e-3, 6);
    assert!(residual.abs() < 2e-3 + energy_residual(&soft, energy).abs(), "{residual}");
    // the number of impacts and the energy equal those of soft spheres, within the variation of so few spheres
    let ratio = done.record.pairs.count as f64 / soft.record.pairs.count as f64;
    close("impacts between particles", ratio, 1.0, 0.15);
    close("energy", done.particles.kinetic_energy() / soft.particles.kinetic_energy(), 1.0, 0.05);
    // no sphere has fallen through the floor
    assert!(done.particles.position.iter().all(|x| x.y > 0.4 * small().diameter));
}

#[test]
fn a_bed_comes_to_rest_where_hard_spheres_stop() {
    assert!(comes_to_rest(0.5).record.pairs.instants.count > 100);
}

#[test]
fn a_bed_without_restitution_comes_to_rest() {
    let done = comes_to_rest(0.0);
    println!("{} of {} impacts were instants", done.record.pairs.instants.count, done.record.pairs.count);
}

/// Hybrid spheres under their weight come to rest like soft spheres.
fn comes_to_rest(restitution: f64) -> Simulation {
    const COUNT: usize = 150;
    let d = small().diameter;
    let side = 6.0 * d;
    let surface = surface(restitution, 0.3);
    let mut scene = empty([side, 30.0 * d, side], [true, false, true], small(), surface);
    scene.gravity = Vector3::new(0.0, -50.0, 0.0);
    scene.walls =
        vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface), plane([0.0, 30.0 * d, 0.0], [0.0, -1.0, 0.0], surface)];
    let particles = random(&scene, COUNT, 0.1, 3);
    let (_, alone) = try_run(&scene, particles.clone(), hard(), 0.08, 40);
    assert!(matches!(alone, Err(Failure::InelasticCollapse { .. })), "{alone:?}");
    let k = 100.0;
    let done = run(&scene, particles.clone(), hybrid(k, contact_time(k) / 20.0, 5.0), 0.08, 40);
    let soft = run(&scene, particles, soft(k, contact_time(k) / 20.0, Integrator::VelocityVerlet), 0.08, 40);
    let speed =
        |done: &Simulation| (2.0 * done.particles.kinetic_energy() / done.particles.mass.iter().sum::<f64>()).sqrt();
    assert!(speed(&done) < 5e-3 && speed(&soft) < 5e-3, "{} {} m/s", speed(&done), speed(&soft));
    let height = |done: &Simulation| done.particles.position.iter().map(|x| x.y).sum::<f64>() / COUNT as f64;
    // both beds are random: the heights of the centres of so few spheres agree within a few hundredths
    close("height of the bed", height(&done) / height(&soft), 1.0, 0.05);
    done
}

#[test]
fn contacts_that_last_are_one_crowd_wherever_they_are() {
    // nine stacks of three spheres on the floor, three diameters apart; each sphere overlaps the next one as required
    // by the weight
    let (d, k) = (small().diameter, 300.0);
    let (side, height) = (9.0 * d, 60.0 * d);
    let mut scene = empty([side, height, side], [true, false, true], small(), surface(0.6, 0.0));
    scene.gravity = Vector3::new(0.0, -9.81, 0.0);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.6, 0.0))];
    let sunk = small().mass() * 9.81 / k;
    let layer = [0.5 * d - 3.0 * sunk, 1.5 * d - 5.0 * sunk, 2.5 * d - 6.0 * sunk];
    let at = |n: usize| 3.0 * d * (n as f64 + 0.5);
    let mut list: Vec<_> = (0..27).map(|n| ([at(n % 3), layer[n / 9], at(n / 3 % 3)], [0.0; 3])).collect();
    for n in 0..90 {
        let v = [1, 2, 3].map(|axis| 0.1 * ((n * n * axis + n + axis) as f64).sin());
        list.push(([at(n % 3), (20.0 + 3.0 * (n / 9) as f64) * d, at(n / 3 % 3)], v));
    }
    let particles = placed(&scene, &list);
    let step = contact_time(k) / 20.0;
    let done = run(&scene, particles.clone(), hybrid(k, step, 2.0), 2e-3, 4);
    let counters = done.counters();
    assert!(counters.largest_island >= 27 && counters.uniform_steps > 0, "{counters:?}");
    // no sphere of the bed moves, as for soft spheres: each stack is in balance
    for (x, y) in done.particles.position.iter().zip(&done.particles.id).filter(|(_, id)| **id < 27) {
        assert!((x.y - list[*y as usize].0[1]).abs() < 1e-3 * sunk, "{x:?}");
    }
    let soft = run(&scene, particles, soft(k, step, Integrator::VelocityVerlet), 2e-3, 4);
    close("energy", done.energy() / soft.energy(), 1.0, 1e-3);
}

/// If all particles are stepped at once, contacts remain from window to window. All contacts and their stored energy
/// must be readable between windows. A lattice of spheres at rest with equal overlaps does not move, and its energy is
/// known.
#[test]
fn contacts_that_are_stepped_with_all_others_are_seen_between_windows() {
    let (side, overlap, k) = (6usize, 1e-3, 1e4);
    let spacing = 1.0 - overlap;
    let scene = empty([side as f64 * spacing; 3], [true; 3], unit(), surface(1.0, 0.0));
    let at = |n: usize| [n % side, n / side % side, n / (side * side)].map(|m| (m as f64 + 0.5) * spacing);
    let list: Vec<_> = (0..side.pow(3)).map(|n| (at(n), [0.0; 3])).collect();
    let contacts = 3 * list.len();
    let stored = contacts as f64 * 0.5 * k * overlap * overlap;
    let dt = std::f64::consts::PI * (0.5 * unit().mass() / k).sqrt() / 20.0;
    let engines: [(&str, Box<dyn Engine>); 2] =
        [("soft", soft(k, dt, Integrator::VelocityVerlet)), ("hybrid", hybrid(k, dt, 2.0))];
    for (name, engine) in engines {
        let mut simulation = Simulation::with_engine(scene.clone(), placed(&scene, &list), engine);
        for window in 1..=4 {
            simulation.run(1, 40.0 * dt).unwrap();
            assert_eq!(simulation.contacts().len(), contacts, "{name}, window {window}");
            close(name, simulation.energy() / stored, 1.0, 1e-9);
        }
        assert!(simulation.counters().uniform_steps > 0, "{name}: {:?}", simulation.counters());
    }
}

/// [-] variance over mean of the numbers of centres in 12³ equal parts of a cube. For random hard spheres this ratio
/// equals their compressibility, about 0.5 at a volume fraction of 0.1. Clusters increase it.
fn unevenness(scene: &Scene, particles: &Particles) -> f64 {
    const PARTS: usize = 12;
    let mut counts = vec![0.0; PARTS * PARTS * PARTS];
    for x in &particles.position {
        let x = scene.domain.wrap(x).component_div(&scene.domain.size) * PARTS as f64;
        let [a, b, c] = [x.x, x.y, x.z].map(|x| (x as usize).min(PARTS - 1));
        counts[a + PARTS * (b + PARTS * c)] += 1.0;
    }
    let mean = counts.iter().sum::<f64>() / counts.len() as f64;
    counts.iter().map(|count: &f64| (count - mean).powi(2)).sum::<f64>() / counts.len() as f64 / mean
}

/// Mean over several starts, and its standard error.
type Estimate = [f64; 2];

/// [-] ln(T/T0) and the [`unevenness`] at given times, in the units of a gas of unit spheres at T0 = 1.
fn cooling(engine: &dyn Fn() -> Box<dyn Engine>, times: &[f64], starts: u64) -> Vec<[Estimate; 2]> {
    let count = 64_000;
    let scene = empty([edge(count, 1.0, 0.1); 3], [true; 3], unit(), surface(0.8, 0.0));
    let mut all = vec![[Vec::new(), Vec::new()]; times.len()];
    for seed in 1..=starts {
        let particles = random(&scene, count, 1.0, seed);
        let start = temperature(&particles);
        let mut simulation = Simulation::with_engine(scene.clone(), particles, engine());
        for (time, [cooled, uneven]) in times.iter().zip(&mut all) {
            while simulation.time < time - 1e-9 {
                // windows of about 0.4 collisions per particle during the cooling
                let window = (0.1 * (1.0 + simulation.time / 6.0)).min(time - simulation.time);
                simulation.run(1, window).unwrap();
            }
            cooled.push((temperature(&simulation.particles) / start).ln());
            uneven.push(unevenness(&scene, &simulation.particles));
        }
    }
    let n = starts as f64;
    let statistics = |values: &Vec<f64>| {
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
        [mean, (variance / n).sqrt()]
    };
    all.iter().map(|values| values.each_ref().map(statistics)).collect()
}

/// Runs until soft spheres form clusters: at 3000 d/sqrt(T0) the numbers in parts of the cube are several times as
/// uneven as initially.
#[test]
#[ignore = "long: a gas that clusters, 64,000 spheres from four starts with two engines; cargo test -- --ignored --nocapture cools_through_clustering"]
fn a_gas_cools_through_clustering_as_soft_spheres_do() {
    // softness at the start: sqrt(mT/k) = 0.004 d
    let k: f64 = 1.0 / (0.004 * 0.004);
    let dt = std::f64::consts::PI * (0.5 / k).sqrt() / 20.0;
    let times = [3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0];
    let mixed = cooling(&|| hybrid(k, dt, 2.0), &times, 4);
    println!("hybrid {mixed:.4?}");
    let contacts = cooling(&|| local(k, dt, Integrator::VelocityVerlet), &times, 4);
    for ((time, mixed), contacts) in times.iter().zip(&mixed).zip(&contacts) {
        println!("t {time}: ln T/T0, unevenness: hybrid {mixed:.4?}, soft {contacts:.4?}");
    }
    for ((time, mixed), contacts) in times.iter().zip(&mixed).zip(&contacts) {
        for (mixed, contacts) in mixed.iter().zip(contacts) {
            let error = mixed[1].hypot(contacts[1]);
            // two numbers at several times: the tolerance is four standard errors from four starts, and these errors
            // are themselves uncertain by two fifths
            assert!((mixed[0] - contacts[0]).abs() < 4.0 * error.max(5e-3), "{time}: {mixed:?} {contacts:?}");
        }
    }
    let [first, last] = [0, times.len() - 1].map(|k| contacts[k][1][0]);
    assert!(last > 2.0 * first, "soft spheres have not clustered: {first} and {last}");
}

/// Simulation of `cases/hybrid/intruder.toml` at its start, with the given keys.
fn intruder_with(model: Model, sets: &[String]) -> Simulation {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/hybrid/intruder.toml");
    let (experiment, _) = Case::read(&path, sets).and_then(|case| case.experiment(Some(model), None)).unwrap();
    Simulation::new(&experiment, diptych::placement::initial_state(&experiment).unwrap())
}

fn intruder(model: Model) -> Simulation {
    intruder_with(model, &[])
}

/// `cases/hybrid/intruder.toml`: a steel ball penetrates a bed of glass beads and stops at the same depth in both
/// models. At six other positions the depths differed by 0.003 ± 0.006 mm, and by 0.014 mm between two runs.
#[test]
fn an_intruder_sinks_as_deep_as_among_soft_spheres() {
    let sink = |model: Model, windows: &[u64]| {
        let mut simulation = intruder(model);
        let (momentum, energy) = (simulation.particles.momentum(), simulation.energy());
        let heights: Vec<f64> = windows
            .iter()
            .map(|&windows| {
                simulation.run(windows, 5e-5).unwrap();
                let ball = simulation.particles.species.iter().position(|&species| species == 1).unwrap();
                simulation.particles.position[ball].y
            })
            .collect();
        assert!(momentum_residual(&simulation, momentum) < 1e-12);
        // the work of sliding friction is computed without the effect of other forces on the two spheres, as for a
        // dashpot (docs/theory/model.md)
        assert!(energy_residual(&simulation, energy).abs() < 0.05, "{}", energy_residual(&simulation, energy));
        heights
    };
    // heights at 2, 17 and 18 ms; soft spheres, which take most of the computing time, at 2 ms only
    let (soft, heights) = (sink(Model::Soft, &[40]), sink(Model::Hybrid, &[40, 300, 20]));
    // heights at 2 ms, before small differences have grown
    assert!((soft[0] - heights[0]).abs() < 1e-7, "{} {}", soft[0], heights[0]);
    // the depth is 3.2 mm, as among soft spheres. The ball has stopped: in the last millisecond it moves less than a
    // fiftieth of its motion per millisecond at first
    assert!((heights[2] - 13.25e-3).abs() < 1e-4, "{}", heights[2]);
    assert!(heights[1] - heights[2] < 0.02 * 0.5 * (16.45e-3 - heights[0]), "{heights:?}");
}

/// The work of sliding friction is computed without the effect of other forces on the two spheres. Its error is of
/// first order in the time step: with three times as many steps, a third remains unexplained, plus chance. Measured:
/// 3.8 % and 1.7 % of the energy after 5 ms. The test ends after 2 ms.
#[test]
fn the_unexplained_energy_of_an_intruder_falls_with_the_time_step() {
    let residual = |steps: f64| {
        let mut simulation = intruder_with(Model::Soft, &[format!("soft.steps_per_contact={steps}")]);
        let energy = simulation.energy();
        simulation.run(40, 5e-5).unwrap();
        energy_residual(&simulation, energy).abs()
    };
    let (coarse, fine) = (residual(20.0), residual(60.0));
    assert!(coarse < 0.05 && fine < 0.6 * coarse, "{coarse} {fine}");
}

/// `cases/hybrid/intruder.toml` in windows of 0.2 ms: the ball pushes hundreds of beads of the bed in one window. All
/// of these beads join the particles that are stepped together with a single search, so that the first 2 ms take 1.1
/// times as long as with soft spheres. With a search per bead they would take 240 times as long.
#[test]
fn a_bed_that_is_struck_costs_about_what_it_costs_soft_spheres() {
    let (mut soft, mut hybrid) = (intruder(Model::Soft), intruder(Model::Hybrid));
    let seconds = |simulation: &mut Simulation, windows: u64| {
        let began = std::time::Instant::now();
        simulation.run(windows, 2e-4).unwrap();
        began.elapsed().as_secs_f64()
    };
    let limit = 10.0 * seconds(&mut soft, 10);
    let mut taken = 0.0;
    for window in 1..=10 {
        taken += seconds(&mut hybrid, 1);
        // the tolerance is a factor of ten, because other tests use the processor cores at the same time
        assert!(
            taken < limit,
            "{window} windows: {taken} s hybrid; ten times what soft spheres took for ten: {limit} s"
        );
    }
}
