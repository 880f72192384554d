//! Measures the wall time per particle of the parts of a simulation (kernels): `RAYON_NUM_THREADS=1 cargo bench`. With
//! one thread, the times of the parts add up to the time of the whole.
//!
//! Islands (groups of particles that may meet), straight flight and the event queue cannot be called directly from
//! this program. For each of them, the time of one window of an engine is measured, in a scene in which this part
//! takes most of the time. A window is the time between two exchanges with the gas. The paper is that of
//! docs/paper.md.

use diptych::contact_law::{Bodies, ContactLaw};
use diptych::domain::Domain;
use diptych::drag::{Drag, Kick, SchillerNaumann, Sphere};
use diptych::engine::hard::Hard;
use diptych::engine::soft::Soft;
use diptych::engine::{Engine, Window};
use diptych::experiment::{Integrator, SoftStepping};
use diptych::fluid::{Fluid, Profile, TurbulenceModel};
use diptych::neighbours::NeighbourList;
use diptych::neighbours::cells::CellGrid;
use diptych::neighbours::region::Region;
use diptych::particles::Particles;
use diptych::record::Record;
use diptych::scene::{Scene, Species, Surface};
use diptych::simulation;
use diptych::walls::{Cavity, Frustum, Hollow, RoundAxis, Wall, WallGeometry};
use divan::{Bencher, black_box, counter::ItemsCount};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::sync::atomic::{AtomicBool, Ordering};

/// [m] distance between the walls of the channel.
const HEIGHT: f64 = 0.03;
/// Drag law of the paper (docs/paper.md).
const LAW: Drag = Drag::SchillerNaumann(SchillerNaumann);

fn main() {
    divan::main();
}

fn gas() -> Fluid {
    let nu = 1.515e-5;
    let profile = Profile::k_epsilon_channel(15.9, HEIGHT, nu, TurbulenceModel::WallFunctions).unwrap();
    Fluid::new(1.205, nu, profile, Some(LAW))
}

fn cloud(count: usize) -> Particles {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut particles = Particles::default();
    for i in 0..count {
        let x = Vector3::from_fn(|_, _| HEIGHT * random.random::<f64>());
        let v = Vector3::new(0.0, 0.0, 13.0) + Vector3::from_fn(|_, _| 2.0 * random.random::<f64>() - 1.0);
        particles.push(x, v, 1e-4, 1e-9, (i % 2) as u16);
    }
    particles
}

/// Spheres of the two sizes of the paper (docs/paper.md), with diameters of 406 um and 1.5 mm, in the gas `gas`.
fn spheres(gas: &Fluid) -> [Sphere; 2] {
    [(406e-6, 1038.0), (1.5e-3, 1032.0)].map(|(diameter, density)| gas.sphere(&Species::new("", diameter, density)))
}

/// Measures the time of a thousand round trips of a flag: it is set for another processor core, which resets it. If the
/// two cores share a cache, this time is shorter, and a second thread gains more (docs/design/islands.md). On a virtual
/// machine the time may change from minute to minute.
#[divan::bench]
fn thousand_words_to_another_core_and_back(bencher: Bencher) {
    let (turn, is_over) = (AtomicBool::new(false), AtomicBool::new(false));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !is_over.load(Ordering::Relaxed) {
                if turn.load(Ordering::Acquire) {
                    turn.store(false, Ordering::Release);
                }
                std::hint::spin_loop();
            }
        });
        bencher.bench_local(|| {
            for _ in 0..1000 {
                turn.store(true, Ordering::Release);
                while turn.load(Ordering::Acquire) {
                    std::hint::spin_loop();
                }
            }
        });
        is_over.store(true, Ordering::Relaxed);
    });
}

#[divan::bench(args = [1_000, 8_000, 100_000])]
fn kick_by_table(bencher: Bencher, count: usize) {
    kick(bencher, count, Kick::tabulated);
}

#[divan::bench(args = [8_000])]
fn kick_by_law(bencher: Bencher, count: usize) {
    kick(bencher, count, Kick::exact);
}

#[divan::bench]
fn kick_table(bencher: Bencher) {
    let spheres = spheres(&gas());
    bencher.bench(|| Kick::tabulated(&LAW, black_box(&spheres), 1e-4));
}

fn kick(bencher: Bencher, count: usize, make: impl Fn(&Drag, &[Sphere], f64) -> Kick) {
    let fluid = gas();
    let kick = make(&LAW, &spheres(&fluid), 1e-8);
    let mut particles = cloud(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| simulation::kick(black_box(&mut particles), &fluid.profile, &kick));
}

#[divan::bench(args = [8_000])]
fn profile(bencher: Bencher, count: usize) {
    let fluid = gas();
    let particles = cloud(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| black_box(&particles).position.iter().map(|x| fluid.profile.velocity(x.y)).sum::<f64>());
}

/// [m] diameter of the smaller spheres of the paper (docs/paper.md).
const DIAMETER: f64 = 406e-6;
/// [kg/m³] density of the smaller spheres of the paper (docs/paper.md).
const DENSITY: f64 = 1038.0;
/// [N/m] stiffness of the smaller spheres of the paper (docs/paper.md, Table 1, case D).
const STIFFNESS: f64 = 3000.0;
/// [s] length of the window (time between two exchanges with the gas), about that of case D of the paper
/// (docs/paper.md).
const WINDOW: f64 = 2e-4;

/// [-] fraction of the free space around a lattice site over which spheres are scattered. It is less than 1, so that
/// spheres do not touch.
const JITTER: f64 = 0.999;

/// Periodic cube with `count` spheres at the given volume fraction [-], without gas. Case D of the paper
/// (docs/paper.md) has the volume fraction 0.01.
fn cube(count: usize, volume_fraction: f64) -> Scene {
    let species = Species::new("", DIAMETER, DENSITY);
    let side = (count as f64 * species.volume() / volume_fraction).cbrt();
    Scene::new(Domain::new(Vector3::repeat(side), [true; 3]), Surface::new(1.0, 0.0), vec![species])
}

/// Spheres at scattered positions around the sites of a simple cubic lattice, so that none overlap. `jitter` [-] is the
/// fraction of the free space over which they are scattered. The velocity components are normally distributed with a
/// standard deviation of 0.5 m/s.
fn suspension(scene: &Scene, count: usize, jitter: f64) -> Particles {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let per_side = (count as f64).cbrt().ceil() as usize;
    let spacing = scene.domain.size.x / per_side as f64;
    let room = (spacing - DIAMETER) * jitter;
    let normal = Normal::new(0.0, 0.5).unwrap();
    let mut particles = Particles::default();
    for k in 0..count {
        let site = Vector3::new(k % per_side, k / per_side % per_side, k / (per_side * per_side));
        let corner = site.map(|n| n as f64 * spacing);
        let x = corner + Vector3::from_fn(|_, _| 0.5 * DIAMETER + room * random.random::<f64>());
        let v = Vector3::from_fn(|_, _| normal.sample(&mut random));
        particles.push(x, v, 0.5 * DIAMETER, scene.species[0].mass(), 0);
    }
    particles
}

/// Measures the time of one window of the length `duration` [s] (time between two exchanges with the gas). The engine
/// begins from the same state in each repetition. The time is given per particle.
fn window(bencher: Bencher, scene: &Scene, particles: &Particles, engine: impl Fn() -> Box<dyn Engine>, duration: f64) {
    bencher
        .counter(ItemsCount::new(particles.len()))
        .with_inputs(|| (engine(), particles.clone(), Record::default()))
        .bench_local_values(|(mut engine, mut particles, mut record)| {
            engine.advance(&mut particles, scene, Window { start: 0.0, duration }, &mut record).unwrap();
            (engine, particles, record)
        });
}

fn soft(stepping: SoftStepping) -> Box<dyn Engine> {
    let law = ContactLaw::linear(STIFFNESS);
    let mass = DENSITY * std::f64::consts::PI / 6.0 * DIAMETER.powi(3);
    let bodies = Bodies {
        effective_mass: 0.5 * mass,
        effective_radius: 0.25 * DIAMETER,
        restitution: 1.0,
        by_speed: None,
        elasticity: [None; 2],
        stiffness_ratio: 1.0,
    };
    let step = law.contact_time(&law.between(&bodies), 1.0) / 20.0; // N_c = 20
    Box::new(Soft::new(law, Integrator::VelocityVerlet, step, stepping))
}

fn hard() -> Box<dyn Engine> {
    Box::new(Hard::new())
}

/// Measures the sorting of positions into the cells of a grid, with one particle per cell on average.
#[divan::bench(args = [8_000, 100_000])]
fn cell_grid(bencher: Bencher, count: usize) {
    let scene = cube(count, 0.01);
    let particles = suspension(&scene, count, JITTER);
    let region = Region::from(&scene.domain);
    let edge = scene.domain.size.x / (count as f64).cbrt();
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| CellGrid::new(black_box(&particles.position), &region, edge));
}

/// Measures the making of the neighbour list (pairs that may touch soon) for uniform time steps, with the sorting of
/// the particles by cells. A list is made before the measurement, so the particles already have this order.
#[divan::bench(args = [8_000, 100_000])]
fn neighbour_list(bencher: Bencher, count: usize) {
    let scene = cube(count, 0.01);
    let mut particles = suspension(&scene, count, JITTER);
    let mut list = NeighbourList::default();
    list.build(&mut particles, &scene, WINDOW);
    bencher.counter(ItemsCount::new(count)).bench_local(|| list.build(black_box(&mut particles), &scene, WINDOW));
}

/// Measures the straight flight of particles, with the search for touches, by the hard engine. All velocities are
/// equal, so that no two particles meet.
#[divan::bench(args = [8_000, 100_000])]
fn flight(bencher: Bencher, count: usize) {
    let scene = cube(count, 0.01);
    let mut particles = suspension(&scene, count, JITTER);
    particles.velocity.fill(Vector3::new(0.3, 0.2, 0.5));
    window(bencher, &scene, &particles, hard, WINDOW);
}

/// Pairs of spheres that are about to meet head-on, far from all other pairs. An engine then spends most of the time on
/// the islands (groups of particles that may meet).
fn pairs(count: usize) -> (Scene, Particles) {
    let scene = cube(count, 1e-3);
    let mut particles = suspension(&scene, count / 2, 0.5); // room for the partner
    let own = particles.clone();
    for i in 0..own.len() {
        let (x, v) = (own.position[i], Vector3::new(0.5, 0.0, 0.0));
        particles.velocity[i] = v;
        // this gap closes after a quarter of the window
        let gap = 2.0 * v.x * 0.25 * WINDOW;
        particles.push(x + Vector3::x() * (DIAMETER + gap), -v, own.radius[i], own.mass[i], 0);
    }
    (scene, particles)
}

#[divan::bench]
fn island_soft_pair(bencher: Bencher) {
    let (scene, particles) = pairs(8_000);
    window(bencher, &scene, &particles, || soft(SoftStepping::Local), WINDOW);
}

#[divan::bench]
fn island_hard_pair(bencher: Bencher) {
    let (scene, particles) = pairs(8_000);
    window(bencher, &scene, &particles, hard, WINDOW);
}

/// Measures the event queue of all particles, with the hard engine in a dense gas. The engine spends most of the time
/// on finding the next collisions, and on adding them to the queue and removing them. The volume fraction is 0.25.
#[divan::bench(args = [8_000])]
fn calendar(bencher: Bencher, count: usize) {
    let scene = cube(count, 0.25);
    let particles = suspension(&scene, count, JITTER);
    window(bencher, &scene, &particles, || Box::new(Hard::with_one_calendar()), WINDOW);
}

/// Measures one window (time between two exchanges with the gas) of soft spheres with uniform time steps, which move
/// all particles together.
#[divan::bench(args = [8_000])]
fn soft_uniform_window(bencher: Bencher, count: usize) {
    let scene = cube(count, 0.01);
    let particles = suspension(&scene, count, JITTER);
    window(bencher, &scene, &particles, || soft(SoftStepping::Uniform), WINDOW);
}

/// Measures one window of a dilute gas in a round vessel. The window (time between two exchanges with the gas) is so
/// long that some spheres meet the wall. Most of the time is spent on islands (groups of bodies that may meet) at walls
/// that are not flat.
#[divan::bench(args = ["can", "cone", "sphere", "pipe"])]
fn gas_in_round_vessel(bencher: Bencher, vessel: &str) {
    /// [s] length of the measured window (time between two exchanges with the gas), about a twentieth of the time in
    /// which a sphere crosses the vessel.
    const LONG: f64 = 1e-3;
    let scene = cube(400, 0.002);
    let (center, radius) = (0.5 * scene.domain.size, 0.45 * scene.domain.size.x);
    let axle = RoundAxis { center, axis: 2 };
    let can = |low| Cavity::ClosedCylinder(Frustum { axle, radii: [low, radius], half_height: radius, solid: true });
    let room = match vessel {
        "can" => can(radius),
        "cone" => can(0.7 * radius),
        "sphere" => Cavity::Sphere { center, radius },
        _ => Cavity::Pipe { axle, radius },
    };
    let geometry = WallGeometry::Hollow(Hollow::new(room));
    let mut particles = Particles::default();
    let all = suspension(&scene, 400, JITTER);
    for k in 0..all.len() {
        if geometry.nearest(&all.position[k]).distance > 0.5 * DIAMETER {
            particles.push(all.position[k], all.velocity[k], all.radius[k], all.mass[k], 0);
        }
    }
    let domain = Domain::new(scene.domain.size, [false, false, vessel == "pipe"]);
    let wall = Wall::new(geometry, scene.contact);
    let scene = Scene { domain, walls: vec![wall], ..scene };
    window(bencher, &scene, &particles, || soft(SoftStepping::Local), LONG);
}
