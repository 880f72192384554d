//! One run divided into domains (blocks of the box, one per process), with threads in place of processes. The results
//! must not depend on the order of the particle store.

mod uniform;

use crate::support::*;
use diptych::contact_law::ContactLaw;
use diptych::encounter::Couple;
use diptych::engine::Counters;
use diptych::engine::distributed::Distributed;
use diptych::engine::hard::Hard;
use diptych::engine::hybrid::Hybrid;
use diptych::engine::soft::Soft;
use diptych::experiment::{Integrator, SoftStepping};
use diptych::fluid::{Fluid, Profile};
use diptych::observe::{self, Needs, Observer};
use diptych::particles::Particles;
use diptych::rotation::{ImpactRule, LinearTangential, Rotation, TangentialLaw};
use diptych::scene::Scene;
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;
use diptych::statistics::Accumulator;
use diptych::stored::Stored;
use diptych::walls::{Obstacle, Turning, Wall, WallGeometry};
use diptych::{Drag, SchillerNaumann};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use std::sync::{Arc, Mutex};

/// Gas of spheres of two sizes that falls between walls with friction. It is so dense that islands have many members.
fn scene(count: usize, volume_fraction: f64) -> (Scene, Particles) {
    let species = small();
    let edge = (count as f64 * species.volume() / volume_fraction).cbrt();
    let mut scene = empty([edge; 3], [true, false, true], species, surface(0.9, 0.2));
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.2)),
        plane([0.0, edge, 0.0], [0.0, -1.0, 0.0], surface(0.9, 0.2)),
    ];
    scene.gravity = Vector3::new(0.0, -3.0, -9.81);
    let mut particles = random(&scene, count, 0.5, 11);
    for place in (0..count).step_by(3) {
        particles.radius[place] *= 0.7;
        particles.mass[place] *= 0.7f64.powi(3);
    }
    (scene, particles)
}

/// Makes the spheres of a scene rotate, with tangential springs that remain from step to step.
fn rough((mut scene, mut particles): (Scene, Particles)) -> (Scene, Particles) {
    let law = LinearTangential::Ratios { stiffness: 0.8, dashpot: 0.3 };
    let impact = ImpactRule::Walton { tangential_restitution: 0.4 };
    scene.rotation = Some(Rotation::new(TangentialLaw::Linear(law), impact));
    scene.let_rotate(&mut particles);
    // spins of about 1000 rad/s along the velocities of other particles
    let other: Vec<_> = particles.velocity.iter().rev().map(|velocity| velocity * 2000.0).collect();
    particles.spin = Some(other);
    (scene, particles)
}

/// Adds a ball that rotates in place, in the largest gap between the particles, found on a grid of positions.
fn with_turning_ball((mut scene, particles): (Scene, Particles)) -> (Scene, Particles) {
    let size = scene.domain.size;
    let place = |k: usize| {
        let share = |part: usize| (part as f64 + 0.5) / 12.0;
        Vector3::new(share(k % 12), share(k / 12 % 12), share(k / 144)).component_mul(&size)
    };
    let room = |center: &Vector3<f64>| {
        let gap = |(x, r): (&Vector3<f64>, &f64)| scene.domain.separation(x, center).norm() - r;
        let nearest = particles.position.iter().zip(&particles.radius).map(gap).fold(f64::INFINITY, f64::min);
        nearest.min(center.y).min(size.y - center.y)
    };
    let best = (0..1728).map(place).max_by(|a, b| room(a).total_cmp(&room(b))).unwrap();
    let geometry = WallGeometry::Obstacle(Obstacle::sphere(best, 0.9 * room(&best)));
    let turning = Some(Turning { center: best, spin: Vector3::new(300.0, 2000.0, -900.0) });
    scene.walls.push(Wall { turning, ..Wall::new(geometry, surface(0.9, 0.4)) });
    (scene, particles)
}

/// Copy of the particles with their ids, in another order of the store.
fn shuffled(particles: &Particles, seed: u64) -> Particles {
    let mut order: Vec<u32> = (0..particles.len() as u32).collect();
    order.shuffle(&mut rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed));
    let mut shuffled = particles.clone();
    shuffled.reorder(&order);
    shuffled
}

fn same_bits(
    name: &str,
    (scene, start): &(Scene, Particles),
    engine: &dyn Fn() -> Box<dyn Distributed>,
    islands: bool,
) {
    let run = |start: Particles| -> (u64, Simulation) {
        let simulation = run(scene, start, engine(), 1e-3, 40);
        (simulation.particles.fingerprint(), simulation)
    };
    let (bits, plain) = run(start.clone());
    let counters = plain.counters();
    assert_eq!(counters.islands > 1000 && counters.islands_redone > 0, islands, "{name}: {counters:?}");
    assert!(plain.record.pairs.count > 1000, "{name}");
    for seed in 1..4 {
        let (other, simulation) = run(shuffled(start, seed));
        let counts = simulation.counters();
        assert_eq!(
            (counts.islands, counts.island_members, counts.islands_redone, counts.events, counts.steps),
            (counters.islands, counters.island_members, counters.islands_redone, counters.events, counters.steps),
            "{name}"
        );
        assert_eq!(simulation.record.pairs.count, plain.record.pairs.count, "{name}");
        assert_eq!(other, bits, "{name}, order {seed}");
    }
}

#[test]
fn islands_give_the_same_bits_in_any_order_of_the_store() {
    let crowded = scene(3000, 0.06);
    let stiffness = 3000.0;
    let soft = || local(stiffness, 2e-7, Integrator::VelocityVerlet);
    let law = ContactLaw::linear(stiffness);
    same_bits("hard", &crowded, &|| Box::new(Hard::with_islands()), true);
    same_bits("soft", &crowded, &soft, true);
    same_bits("hybrid", &crowded, &|| Box::new(Hybrid::new(law, Integrator::VelocityVerlet, 2e-7, 1.0)), true);
}

#[test]
fn everyone_at_once_gives_the_same_bits_in_any_order_of_the_store() {
    let dense = scene(3000, 0.3);
    same_bits("hard", &dense, &|| Box::new(Hard::with_one_calendar()), false);
    same_bits("soft", &dense, &|| support_soft(Integrator::VelocityVerlet), false);
    same_bits("soft, Heun", &dense, &|| support_soft(Integrator::Rk2), false);
}

fn support_soft(integrator: Integrator) -> Box<dyn Distributed> {
    soft(3000.0, 5e-7, integrator)
}

fn soft(stiffness: f64, step: f64, integrator: Integrator) -> Box<dyn Distributed> {
    Box::new(Soft::new(ContactLaw::linear(stiffness), integrator, step, SoftStepping::Uniform))
}

fn local(stiffness: f64, step: f64, integrator: Integrator) -> Box<dyn Distributed> {
    Box::new(Soft::new(ContactLaw::linear(stiffness), integrator, step, SoftStepping::Local))
}

fn islands() -> Box<dyn Distributed> {
    Box::new(Hard::with_islands())
}

fn same_bits_over_processes(
    name: &str,
    of: &(Scene, Particles),
    engine: &(dyn Fn() -> Box<dyn Distributed> + Sync),
    (duration, windows): (f64, u64),
) {
    let alone = run(&of.0, of.1.clone(), engine(), duration, windows);
    let (bits, counts) = (alone.state().fingerprint(), counts(&alone.counters()));
    println!("{name}: {:?}", alone.counters());
    for size in [1, 2, 3, 4, 12] {
        let (particles, counters) = shared(size, of, engine, (duration, windows), |end| (end.state(), end.counters()));
        assert_eq!(self::counts(&counters), counts, "{name} on {size}");
        assert_eq!(particles.len(), of.1.len());
        assert_eq!(particles.fingerprint(), bits, "{name} on {size}");
    }
}

/// Observer that records the states of three groups: every n-th particle by id, the particles in contact with these,
/// and all particles.
#[derive(Default)]
struct Glances {
    every: u32,
    seen: Vec<String>,
}

impl Observer for Glances {
    fn next(&self, now: f64, schedule: &Schedule) -> Option<f64> {
        // all particles are recorded every ten windows; a part of the particles is recorded every three windows
        Some(now + schedule.window * if self.every == 1 { 10.0 } else { 3.0 })
    }

    fn needs_velocities(&self) -> bool {
        self.every == 1
    }

    fn needs(&self) -> Needs {
        Needs::Every(self.every)
    }

    fn see(&mut self, simulation: &Simulation) {
        let (particles, id) = (&simulation.particles, &simulation.particles.id);
        let is_followed = |place: &u32| id[*place as usize].is_multiple_of(self.every);
        let mut followed: Vec<u32> = (0..particles.len() as u32).filter(is_followed).collect();
        followed.sort_unstable_by_key(|place| id[*place as usize]);
        let state = |place: &u32| particles.state_numbers(*place as usize);
        let states: Vec<f64> = followed.iter().flat_map(state).collect();
        let with_ids = |couple: Couple| couple.indices().map(|place| place.map(|place| id[place as usize]));
        let contacts = simulation.contacts().into_iter();
        let contacts = contacts.filter(|(couple, _)| couple.indices().iter().flatten().any(is_followed));
        let mut contacts: Vec<_> = contacts.map(|(couple, overlap)| (with_ids(couple), overlap.to_bits())).collect();
        contacts.sort_unstable();
        let members = simulation.in_islands().map(|members| {
            let mut ids: Vec<u32> =
                members.iter().filter(|place| is_followed(place)).map(|k| id[*k as usize]).collect();
            ids.sort_unstable();
            ids
        });
        let all = (simulation.count(), simulation.fluctuation_speed(), simulation.mean_radius(), simulation.time);
        let of_all = (self.every == 1).then(|| (simulation.energy(), simulation.record.pairs.count));
        self.seen.push(format!("{all:?} {of_all:?} {members:?} {contacts:?} {states:?}"));
    }
}

/// Air that flows upwards.
fn air() -> Fluid {
    Fluid::new(1.2, 1.5e-5, Profile::Uniform(0.5), Some(Drag::SchillerNaumann(SchillerNaumann)))
}

/// Records of observers of some and of all particles, in a run that `size` threads share in place of processes. `None`
/// means a run of one process.
fn glances(
    size: Option<usize>,
    (scene, start): &(Scene, Particles),
    engine: &(dyn Fn() -> Box<dyn Distributed> + Sync),
    duration: f64,
) -> Vec<String> {
    let schedule = Schedule::even(duration / 60.0, 20, 3);
    let [mut few, mut others, mut all] = [5, 7, 1].map(|every| Glances { every, seen: Vec::new() });
    let simulation = || Simulation::with_distributed_engine(scene.clone(), start.clone(), engine());
    let mut crew = Crew::of(size.unwrap_or(1));
    let lead = crew.remove(0);
    std::thread::scope(|scope| {
        for communicator in crew {
            scope.spawn(|| simulation().shared(communicator, 0).follow(&mut |_, _, _| {}));
        }
        let mut simulation = if size.is_some() { simulation().shared(lead, 0) } else { simulation() };
        observe::run(&mut simulation, &schedule, &mut [&mut few]).unwrap();
        observe::run(&mut simulation, &schedule, &mut [&mut few, &mut others, &mut all]).unwrap();
    });
    [few, others, all].into_iter().flat_map(|glances| glances.seen).collect()
}

#[test]
fn who_looks_at_a_shared_run_sees_what_one_process_shows() {
    let mut of = scene(3000, 0.03);
    of.0.fluid = Some(air());
    let soft = || local(300.0, 6e-7, Integrator::VelocityVerlet);
    for (name, engine) in [("hard", &islands as &(dyn Fn() -> Box<dyn Distributed> + Sync)), ("soft", &soft)] {
        let alone = glances(None, &of, engine, 2e-3);
        assert!(
            alone.len() > 60 && (name == "hard" || alone.iter().filter(|seen| seen.contains("([Some")).count() > 30)
        );
        for size in [1, 2, 3, 5] {
            let seen = glances(Some(size), &of, engine, 2e-3);
            let differs = seen.iter().zip(&alone).position(|(seen, alone)| seen != alone);
            assert_eq!((seen.len(), differs), (alone.len(), None), "{name} on {size}");
        }
    }
}

/// Sums over all particles at each sample (instant of measurement), as the first of `size` processes records them.
/// `None` means a run of one process.
fn sums(
    size: Option<usize>,
    (scene, start): &(Scene, Particles),
    engine: &(dyn Fn() -> Box<dyn Distributed> + Sync),
    duration: f64,
) -> Vec<String> {
    let schedule = Schedule::even(duration / 60.0, 3, 20);
    let simulation = || Simulation::with_distributed_engine(scene.clone(), start.clone(), engine());
    let observer = || (Accumulator::new(7, scene.domain.size.y), Books::default());
    let mut crew = Crew::of(size.unwrap_or(1));
    let lead = crew.remove(0);
    let (mut profiles, mut books) = observer();
    std::thread::scope(|scope| {
        for communicator in crew {
            scope.spawn(|| {
                let (mut profiles, mut books) = observer();
                let mut see = |simulation: &Simulation, place: usize, kept: Option<&Stored>| {
                    let observer: &mut dyn Observer = if place == 0 { &mut profiles } else { &mut books };
                    kept.into_iter().for_each(|kept| observer.restore(kept).unwrap());
                    observer.see(simulation);
                };
                simulation().shared(communicator, 2).follow(&mut see);
            });
        }
        let mut simulation = if size.is_some() { simulation().shared(lead, 2) } else { simulation() };
        observe::run(&mut simulation, &schedule, &mut [&mut profiles, &mut books]).unwrap();
        assert_eq!(simulation.count(), start.len());
    });
    books.seen.push(format!("{profiles:?}"));
    books.seen
}

/// Observer that records energies, contacts and impacts of all particles.
#[derive(Default)]
struct Books {
    seen: Vec<String>,
}

impl Observer for Books {
    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        let (sample, record) = (simulation.sample(), &simulation.record);
        let moving = (sample.count(), sample.mean_velocity(), sample.fluctuation_speed(), simulation.mean_velocity());
        let held = (simulation.energy(), simulation.elastic_energy(), simulation.touching());
        let ledger = &record.ledger;
        let given = (ledger.drag_impulse, ledger.wall_impulse, ledger.pair_virial, ledger.residual(0.0, held.0));
        self.seen.push(format!("{} {moving:?} {held:?} {} {given:?}", simulation.time, record.pairs.count));
    }
}

#[test]
fn sums_over_the_parts_of_a_shared_run_are_those_of_one_process() {
    let mut of = scene(3000, 0.03);
    of.0.fluid = Some(air());
    let soft = || local(300.0, 6e-7, Integrator::VelocityVerlet);
    for (name, engine) in [("hard", &islands as &(dyn Fn() -> Box<dyn Distributed> + Sync)), ("soft", &soft)] {
        let alone = sums(None, &of, engine, 2e-3);
        assert!(
            alone.len() == 22 && (name == "hard" || alone.iter().filter(|seen| !seen.contains("ends: 0")).count() > 15)
        );
        for size in [1, 2, 3, 5] {
            let seen = sums(Some(size), &of, engine, 2e-3);
            let differs = seen.iter().zip(&alone).position(|(seen, alone)| seen != alone);
            let pair = differs.map(|at| (&seen[at], &alone[at]));
            assert_eq!((seen.len(), pair), (alone.len(), None), "{name} on {size}");
        }
    }
}

/// Observer that records, in the order of its calls, the number of particles of a process at a sample (instant of
/// measurement).
#[derive(Clone, Default)]
struct Heads(Arc<Mutex<Vec<usize>>>);

impl Observer for Heads {
    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        self.0.lock().unwrap().push(simulation.particles.len());
    }
}

#[test]
fn a_shared_run_is_cut_anew_where_particles_gather() {
    let (scene, mut start) = scene(3000, 0.03);
    let edge = scene.domain.size.z;
    for place in 0..start.len() {
        // all particles are in a cloud that is dense in its middle and moves from block to block
        let z = start.position[place].z / edge;
        start.position[place].z = edge * (z - (2.0 * std::f64::consts::PI * z).sin() / 9.0);
        start.velocity[place].z += 2.0;
    }
    let (heads, schedule) = (Heads::default(), Schedule::even(1e-5, 10, 20));
    let simulation = |communicator| {
        Simulation::with_distributed_engine(scene.clone(), start.clone(), islands()).shared(communicator, 1)
    };
    let mut crew = Crew::of(2);
    let lead = crew.remove(0);
    std::thread::scope(|scope| {
        let mut own = heads.clone();
        let follower = crew.remove(0);
        scope.spawn(move || simulation(follower).follow(&mut |simulation, _, _| own.see(simulation)));
        observe::run(&mut simulation(lead), &schedule, &mut [&mut heads.clone()]).unwrap();
    });
    let heads = heads.0.lock().unwrap();
    println!("{heads:?}");
    assert!(heads[0] == start.len() && heads.len() == 41, "{heads:?}");
    // a process may have many more than half of the particles at one sample, but not at two successive samples
    let is_uneven = |two: &[usize]| two.iter().any(|count| *count as f64 > 1.1 * 0.5 * start.len() as f64);
    let uneven: Vec<bool> = heads[1..].chunks(2).map(is_uneven).collect();
    assert!(uneven.contains(&true) && !uneven.windows(2).any(|two| two == [true, true]), "{heads:?}");
}

/// Counters that do not depend on the number of processes that share a run. The number of examined pairs does depend
/// on it, and is set to 0.
fn counts(counters: &Counters) -> Counters {
    Counters { pair_checks: 0, ..*counters }
}

#[test]
fn processes_that_share_a_run_give_the_bits_of_one() {
    let law = ContactLaw::linear(3000.0);
    // few windows mean long windows: islands are solved several times, and extend over several domains
    for (name, of, time) in [("dilute", scene(3000, 0.02), (1e-3, 40)), ("crowded", scene(12_000, 0.05), (2e-3, 4))] {
        let hybrid = || -> Box<dyn Distributed> { Box::new(Hybrid::new(law, Integrator::VelocityVerlet, 2e-7, 1.0)) };
        same_bits_over_processes(&format!("{name} hard"), &of, &|| Box::new(Hard::with_islands()), time);
        same_bits_over_processes(
            &format!("{name} soft"),
            &of,
            &|| local(3000.0, 2e-7, Integrator::VelocityVerlet),
            time,
        );
        same_bits_over_processes(&format!("{name} hybrid"), &of, &hybrid, time);
    }
}

#[test]
fn rough_spheres_have_the_same_bits_in_any_order_of_the_store_and_on_any_number_of_processes() {
    let law = ContactLaw::linear(3000.0);
    let local = || local(3000.0, 2e-7, Integrator::VelocityVerlet);
    let hybrid = || -> Box<dyn Distributed> { Box::new(Hybrid::new(law, Integrator::VelocityVerlet, 2e-7, 1.0)) };
    let uniform = || support_soft(Integrator::VelocityVerlet);
    let crowded = with_turning_ball(rough(scene(3000, 0.06)));
    same_bits("hard", &crowded, &|| Box::new(Hard::with_islands()), true);
    same_bits("soft", &crowded, &local, true);
    same_bits("hybrid", &crowded, &hybrid, true);
    let dense = rough(scene(3000, 0.3));
    same_bits("hard", &dense, &|| Box::new(Hard::with_one_calendar()), false);
    same_bits("soft", &dense, &uniform, false);
    same_bits_over_processes("hard", &crowded, &|| Box::new(Hard::with_islands()), (1e-3, 10));
    same_bits_over_processes("soft", &crowded, &local, (1e-3, 10));
    same_bits_over_processes("hybrid", &crowded, &hybrid, (1e-3, 10));
    same_bits_over_processes("uniform", &dense, &uniform, (1e-3, 10));
    let alone = uniform::left_and_resumed([None, None], &dense);
    for sizes in [[Some(2), None], [None, Some(3)], [Some(3), Some(2)]] {
        assert_eq!(uniform::left_and_resumed(sizes, &dense), alone, "{sizes:?}");
    }
}

#[test]
fn where_all_are_moved_at_once_every_process_moves_all() {
    let dense = scene(2000, 0.25);
    let auto = || -> Box<dyn Distributed> {
        Box::new(Soft::new(ContactLaw::linear(3000.0), Integrator::VelocityVerlet, 5e-7, SoftStepping::Auto))
    };
    same_bits_over_processes("hard", &dense, &|| Box::new(Hard::new()), (1e-3, 10));
    same_bits_over_processes("soft", &dense, &auto, (1e-3, 10));
}

#[test]
fn islands_are_given_up_by_all_processes_or_by_none() {
    // stiff spheres and short windows: islands are solved, given up because of their cost, and solved again; only the
    // lead process decides on the limit of the cost
    let side = edge(2000, small().diameter, 0.3);
    let gas = empty([side; 3], [true; 3], small(), surface(1.0, 0.0));
    let start = random(&gas, 2000, 0.5, 1);
    let dense = (gas, start);
    let auto = || -> Box<dyn Distributed> {
        Box::new(Soft::new(ContactLaw::linear(30_000.0), Integrator::VelocityVerlet, 1.2e-7, SoftStepping::Auto))
    };
    let time = (2e-4, 40);
    let counters = run(&dense.0, dense.1.clone(), auto(), time.0, time.1).counters();
    assert!(counters.uniform_steps > 50 && counters.islands > 1000, "{counters:?}");
    same_bits_over_processes("soft", &dense, &auto, time);
}

#[test]
fn an_island_that_grows_over_borders_is_that_of_one_process() {
    // a row of spheres in which each hits the next within one window, divided into blocks of two or three spheres
    let scene = empty([0.05, 0.01, 0.01], [false; 3], small(), surface(0.95, 0.0));
    let row = |k: usize| ([0.002 + 1.01 * 406e-6 * k as f64, 0.005, 0.005], [if k == 0 { 1.0 } else { 0.0 }, 0.0, 0.0]);
    let of = (scene.clone(), placed(&scene, &(0..12).map(row).collect::<Vec<_>>()));
    let soft = || local(3000.0, 2e-7, Integrator::VelocityVerlet);
    same_bits_over_processes("hard", &of, &islands, (4e-4, 2));
    same_bits_over_processes("soft", &of, &soft, (4e-4, 2));
}
