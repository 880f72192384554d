//! Many random scenes of rough spheres with every engine and kind of time steps: energy, momentum and angular momentum
//! compared with the errors that the schemes can explain.

use super::*;
use crate::meshes::heaps;
use crate::soak::{Crowd, TOGETHER, books, energy_of_impacts};
use diptych::contact_law::Hertz;
use diptych::domain::Domain;
use diptych::drag::{Drag, Stokes};
use diptych::fluid::{Fluid, Profile};
use diptych::rotation::SpringHistory;
use diptych::scene::Elasticity;
use diptych::walls::{Cavity, Hollow, Mesh, RoundAxis, Wall, WallGeometry};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::PI;

/// Contact springs of a dense group of spheres: linear ones, or those of Hertz and Mindlin.
#[derive(Clone, Copy, PartialEq)]
enum Springs {
    Linear,
    Mindlin,
}

/// Dense group of rough spheres. `spring` is the ratio of the tangential to the normal stiffness, `steps` the number
/// of steps per contact.
struct RoughCrowd {
    crowd: Crowd,
    law: ContactLaw,
    spring: f64,
    steps: f64,
    /// True if no walls, periodic images or gas act on the spheres, so that angular momentum is conserved.
    free: bool,
}

/// Two species of spheres: solid spheres of unit mass, and light shells of another size.
fn kinds(ratio: f64) -> [Species; 2] {
    let shell = Species { name: "shell".into(), diameter: ratio, inertia_factor: 2.0 / 3.0, ..unit() };
    let lighter = Species { density: shell.density * (0.9 / shell.mass()).min(1.0), ..shell };
    [unit(), lighter]
}

/// Surroundings of the dense group with this seed: periodic box, plates, pipe, floor of triangles, or free space. The
/// flags tell the periodic sides.
fn walls(seed: u64, size: f64, of: diptych::scene::Surface) -> ([bool; 3], Vec<Wall>) {
    let half = 0.5 * size;
    match seed % 5 {
        1 => (
            [true, false, true],
            vec![plane([0.0; 3], [0.0, 1.0, 0.0], of), plane([0.0, size, 0.0], [0.0, -1.0, 0.0], of)],
        ),
        2 => {
            let axle = RoundAxis { center: Vector3::repeat(half), axis: 2 };
            let pipe = Hollow::new(Cavity::Pipe { axle, radius: half });
            ([false, false, true], vec![Wall::new(WallGeometry::Hollow(pipe), of)])
        }
        3 => {
            let (mesh, _) = Mesh::new("floor", &heaps::floor(size, 6), None).unwrap();
            let lid = plane([0.0, size, 0.0], [0.0, -1.0, 0.0], of);
            ([true, false, true], vec![Wall::new(WallGeometry::Mesh(Arc::new(mesh)), of), lid])
        }
        _ => ([true; 3], Vec::new()),
    }
}

/// Dense group of spheres with this seed: volume fraction 0.1 to 0.4 (less in a pipe), overlaps of 0.2 to 2 % of a
/// diameter, 8 to 25 steps per contact. Every third one is a mixture, every seventh is in a gas, every second has
/// rolling resistance. Groups with walls have gravity. Mindlin's springs have Poisson's ratio 0.3, and their stiffness
/// follows from a random contact time at a relative speed of 1 m/s.
fn rough_crowd(seed: u64, springs: Springs) -> RoughCrowd {
    let mut draw = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut log = |low: f64, high: f64| low * (high / low).powf(draw.random::<f64>());
    let count = log(30.0, 300.0) as usize;
    let phi = log(0.1, 0.4);
    let contact_time = PI * log(2e-3, 2e-2);
    let (steps, windows) = (log(8.0, 25.0), log(0.5, 10.0));
    let of = surface(log(0.5, 1.0), log(0.1, 1.0));
    let spring = log(0.1, 0.9);
    let ratio = log(0.6, 1.6);
    let size = edge(count, if seed.is_multiple_of(3) { ratio.max(1.0) } else { 1.0 }, phi);
    let (periodic, walls) = walls(seed, size, of);
    let mut scene = empty([size; 3], periodic, unit(), of);
    scene.walls = walls;
    let mut tangential = LinearTangential::Ratios { stiffness: spring, dashpot: 0.0 };
    if seed.is_multiple_of(4) {
        tangential = LinearTangential::Ratios { stiffness: spring, dashpot: 0.3 };
    }
    let impact = ImpactRule::Walton { tangential_restitution: 2.0 * spring - 1.0 };
    // T_c² = π²M/k for e = 1 and two unit spheres
    let stiffness = PI * PI * 0.5 / (contact_time * contact_time);
    let (law, stiffness, tangential, spring) = match springs {
        Springs::Linear => (ContactLaw::linear(stiffness), stiffness, TangentialLaw::Linear(tangential), spring),
        Springs::Mindlin => {
            let tangential = TangentialLaw::Mindlin { history: SpringHistory::Rescaled, dashpot: 0.0 };
            // 8 G* a over 2 E* a, with G* = G/(2(2-ν)) and E* = G/(1-ν) of two equal spheres
            let ratio = 2.0 * (1.0 - POISSONS_RATIO) / (2.0 - POISSONS_RATIO);
            // At its largest overlap δ = 1/2.94 u T_c, Hertz's law has the stiffness 15/8 M u²/δ². This is 1.64 times
            // that of the linear law with this T_c, and goes as u^(2/5). No two spheres meet at more than 8 units.
            (hertz(contact_time), 1.64 * 8f64.powf(0.4) * stiffness, tangential, ratio)
        }
    };
    let mut rotation = Rotation::new(tangential, impact);
    if seed.is_multiple_of(2) {
        rotation.rolling = Some(RollingLaw::Spring { friction: 0.1, stiffness: None, damping: 0.3 });
        rotation.twisting = Some(TwistingLaw { damping: 0.1 });
    }
    scene.rotation = Some(rotation);
    let gas = seed.is_multiple_of(7);
    if gas {
        let profile = Profile::Uniform(0.5);
        // a response time of a few units of time
        scene.fluid = Some(Fluid::new(1e-3, 10.0, profile, Some(Drag::Stokes(Stokes))));
    }
    if !scene.walls.is_empty() {
        scene.gravity = Vector3::new(0.5, -3.0, 1.0);
    }
    let mut gas_of = experiment(scene.clone(), count, [0.0; 3], 1.0, Model::Hard, seed);
    gas_of.start[0].spin_fluctuation = 3.0;
    if seed.is_multiple_of(3) {
        scene.species = kinds(ratio).into();
        let shells = diptych::experiment::Population {
            species: 1,
            amount: diptych::experiment::Amount::Count(count / 2),
            ..gas_of.start[0].clone()
        };
        gas_of.start[0].amount = diptych::experiment::Amount::Count(count - count / 2);
        gas_of.start.push(shells);
    }
    gas_of.scene = scene.clone();
    let mut start = initial_state(&gas_of).unwrap();
    let free = seed % 5 == 4;
    if free {
        // the spheres are in the middle of a box that they do not leave
        scene.domain = Domain::new(Vector3::repeat(100.0 * size), [false; 3]);
        start.position.iter_mut().for_each(|position| *position += Vector3::repeat(50.0 * size));
    }
    let window = windows * contact_time;
    let words =
        format!("seed {seed}: N {count}, phi {phi:.2}, Nc {steps:.1}, k_t/k_n {spring:.2}, window {windows:.1}");
    let windows = (0.3 / window).ceil() as u64;
    let crowd = Crowd { scene, start, stiffness, step: contact_time / steps, window, windows, words };
    RoughCrowd { crowd, law, spring, steps, free: free && !gas }
}

/// [-] Poisson's ratio of the spheres with Mindlin's springs.
const POISSONS_RATIO: f64 = 0.3;

/// Hertz's law with this contact time [s] of two unit spheres that meet at a relative speed of 1.
fn hertz(contact_time: f64) -> ContactLaw {
    let law = |youngs_modulus| {
        ContactLaw::Hertz(Hertz { elasticity: Elasticity { youngs_modulus, poissons_ratio: POISSONS_RATIO } })
    };
    let soft = law(1.0);
    let elastic = Bodies::alike(&unit(), &surface(1.0, 0.0));
    // T_c goes as E^(-2/5)
    law((soft.contact_time(&soft.between(&elastic), 1.0) / contact_time).powf(2.5))
}

/// Engines and kinds of time steps by name, with a flag that is true for soft spheres.
fn engines(rough: &RoughCrowd) -> Vec<(&'static str, Box<dyn Engine>, bool)> {
    let crowd = &rough.crowd;
    let soft = |stepping| -> Box<dyn Engine> {
        Box::new(Soft::new(rough.law, Integrator::VelocityVerlet, crowd.step, stepping))
    };
    vec![
        ("uniform", soft(SoftStepping::Uniform), true),
        ("local", soft(SoftStepping::Local), true),
        ("auto", soft(SoftStepping::Auto), true),
        ("hybrid", Box::new(Hybrid::new(rough.law, Integrator::VelocityVerlet, crowd.step, 2.0)), true),
        ("hard", Box::new(Hard::new().with_contact_time(Some(crowd.step))), false),
        ("stepped", stepped(0.1), false),
    ]
}

impl RoughCrowd {
    /// [J] energy that uniform steps may add or remove. The spring with the highest frequency is the normal spring
    /// (ω_0), or the tangential one with ω_t² = (7/2) κ ω_0² (stiffness ratio κ). With x = ω Δt of this spring,
    /// Verlet's method shifts 1/(1 - x²/4) - 1 of its energy (see `soak`). A contact begins to slide or to stick
    /// anywhere within a step. In this step, friction does at most π/(2 N_c) of the work of an impact (N_c: steps per
    /// contact).
    fn explained(&self, simulation: &Simulation) -> f64 {
        let lightest = self.crowd.scene.species.iter().map(Species::mass).fold(1.0, f64::min);
        let stiffest = (3.5 * self.spring).max(1.0) * TOGETHER * self.crowd.stiffness / (0.5 * lightest);
        let x = stiffest.sqrt() * self.crowd.step;
        let verlet = 1.0 / (1.0 - 0.25 * x * x) - 1.0;
        let ledger = &simulation.record.ledger;
        let friction = ledger.pair_friction_loss + ledger.wall_friction_loss;
        verlet * (energy_of_impacts(simulation) + simulation.energy()) + 0.5 * PI / self.steps * friction
    }

    /// [-] change of the angular momentum, divided by the change that the errors of the scheme and of rounding
    /// explain.
    fn turned(&self, simulation: &Simulation, soft: bool) -> f64 {
        let size = self.crowd.scene.domain.size;
        let about = |particles: &Particles| {
            let mut moved = particles.clone();
            moved.position.iter_mut().for_each(|position| *position -= 0.5 * size);
            pairs::angular_momentum(&moved)
        };
        let miss = (about(&simulation.particles) - about(&self.crowd.start)).norm();
        let counters = simulation.counters();
        // a step of hard spheres moves all of them, and each position is rounded
        let moves = if soft { 0 } else { counters.steps * simulation.count() as u64 };
        let changes = counters.force_evaluations + counters.events + counters.island_members + moves;
        let speed = simulation.particles.largest_speed(Vector3::zeros());
        // positions have the rounding error of the size of the box
        let rounding = f64::EPSILON * changes as f64 * size.x * speed;
        // the classical Runge-Kutta method does not conserve products of position and velocity: its error per contact
        // is that of the energy (see `soak`) over the frequency
        let frequency = (self.crowd.stiffness / 0.5).sqrt() * (3.5 * self.spring).max(1.0).sqrt();
        let classical = 4.0 * PI * (frequency * self.crowd.step).powi(4) / 120.0;
        let method = if soft { classical * energy_of_impacts(simulation) / frequency } else { 0.0 };
        miss / (rounding + method)
    }
}

/// Runs the dense groups with these seeds, prints the worst case of each engine, and returns the faults.
fn soak(seeds: std::ops::Range<u64>, springs: Springs) -> Vec<String> {
    let mut faults = Vec::new();
    let mut worst = std::collections::BTreeMap::<&str, [f64; 4]>::new();
    for seed in seeds {
        let rough = rough_crowd(seed, springs);
        for (name, engine, soft) in engines(&rough) {
            let explained = |simulation: &Simulation| if soft { rough.explained(simulation) } else { 0.0 };
            let (books, simulation) = match books(&rough.crowd, engine, &explained) {
                Ok(books) => books,
                Err(failure) => {
                    faults.push(format!("{name}, {failure}"));
                    continue;
                }
            };
            let turned = if rough.free { rough.turned(&simulation, soft) } else { 0.0 };
            let impacts = (simulation.record.pairs.count + simulation.record.walls.count) as f64;
            let shares =
                [books.energy / books.energy_allowed, books.momentum / books.momentum_allowed, turned, impacts];
            if shares[..3].iter().any(|share| share.is_nan() || *share > 1.0) {
                faults.push(format!("{name}, {}: {shares:.3?}", rough.crowd.words));
            }
            let all = worst.entry(name).or_default();
            (0..3).for_each(|k| all[k] = all[k].max(shares[k]));
            all[3] += shares[3];
        }
    }
    for (name, [energy, momentum, turned, impacts]) in worst {
        println!(
            "{name:8} {impacts} impacts; worst of what is allowed: energy {energy:.3}, momentum {momentum:.3}, angular momentum {turned:.3}"
        );
    }
    faults
}

#[test]
fn books_balance_in_a_few_random_crowds_of_rough_spheres() {
    let faults = soak(20..35, Springs::Linear);
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn books_balance_in_a_few_random_crowds_with_mindlins_springs() {
    let faults = soak(0..10, Springs::Mindlin);
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Defines an ignored test of the dense groups with a range of seeds, so that five such tests can run side by side.
macro_rules! hundred_crowds {
    ($($name:ident: $springs:ident $seeds:expr),*) => {
        $(
            #[test]
            #[ignore = "some four minutes of processor time in all, in a release build: 700 random crowds in six ways of stepping; `cargo test --release -- --ignored crowds_ --nocapture` prints the counts"]
            fn $name() {
                let faults = soak($seeds, Springs::$springs);
                assert!(faults.is_empty(), "{} faults: {faults:#?}", faults.len());
            }
        )*
    };
}

hundred_crowds!(
    books_balance_in_crowds_0_to_99: Linear 0..100,
    books_balance_in_crowds_100_to_199: Linear 100..200,
    books_balance_in_crowds_200_to_299: Linear 200..300,
    books_balance_in_crowds_300_to_399: Linear 300..400,
    books_balance_in_crowds_400_to_499: Linear 400..500,
    books_balance_in_crowds_of_mindlin_0_to_99: Mindlin 0..100,
    books_balance_in_crowds_of_mindlin_100_to_199: Mindlin 100..200
);
