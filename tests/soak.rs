//! Many random dense gases (crowds), each with every engine and kind of time steps. Energy and momentum may change
//! only by the errors that the schemes can explain.

use crate::support::*;
use diptych::contact_law::ContactLaw;
use diptych::engine::Engine;
use diptych::engine::hard::Hard;
use diptych::engine::soft::Soft;
use diptych::experiment::{Integrator, SoftStepping};
use diptych::particles::Particles;
use diptych::scene::Scene;
use diptych::simulation::Simulation;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::PI;

/// Largest number of simultaneous contacts of a sphere in these dense gases, which is a factor on squared frequencies.
/// A sphere with n springs raises the largest squared frequency of the linear system at most n-fold (row sums of
/// Gershgorin's theorem).
pub const TOGETHER: f64 = 3.0;

/// Dense gas (crowd) of spheres of at most unit mass, with stiffness and time step.
pub struct Crowd {
    pub scene: Scene,
    pub start: Particles,
    pub stiffness: f64,
    /// [s] time step.
    pub step: f64,
    /// [s] length of a window (piece of the run).
    pub window: f64,
    pub windows: u64,
    /// Description of the crowd, for messages.
    pub words: String,
}

/// Dense gas (crowd) with this seed: volume fraction 0.15 to 0.5, overlaps of 0.2 to 2 % of a diameter, 8 to 25 steps
/// per contact, windows (pieces of the run) of 0.5 to 10 contact times. Every third one has walls and gravity, every
/// second is inelastic, every fourth has friction.
pub fn crowd(seed: u64) -> Crowd {
    let mut draw = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut log = |low: f64, high: f64| low * (high / low).powf(draw.random::<f64>());
    let count = log(30.0, 1000.0) as usize;
    let phi = log(0.15, 0.5);
    let contact_time = PI * log(2e-3, 2e-2);
    let (steps, windows) = (log(8.0, 25.0), log(0.5, 10.0));
    let restitution = if seed.is_multiple_of(2) { 1.0 } else { log(0.5, 1.0) };
    let contact = surface(restitution, if seed % 4 == 1 { 0.3 } else { 0.0 });
    let size = edge(count, 1.0, phi);
    let mut scene = empty([size; 3], [true; 3], unit(), contact);
    if seed.is_multiple_of(3) {
        scene.domain.periodic[1] = false;
        scene.gravity = Vector3::new(0.0, -3.0, 1.0);
        scene.walls =
            vec![plane([0.0; 3], [0.0, 1.0, 0.0], contact), plane([0.0, size, 0.0], [0.0, -1.0, 0.0], contact)];
    }
    let start = random(&scene, count, 1.0, seed);
    // T_c² = π²M/k for e = 1; damping makes T_c slightly longer
    let stiffness = PI * PI * 0.5 / (contact_time * contact_time);
    let window = windows * contact_time;
    Crowd {
        words: format!(
            "seed {seed}: N {count}, phi {phi:.2}, Tc {contact_time:.4}, Nc {steps:.1}, window {windows:.1}, e {restitution:.2}"
        ),
        start,
        stiffness,
        step: contact_time / steps,
        window,
        windows: (0.3 / window).ceil() as u64,
        scene,
    }
}

/// Unexplained energy [J] and momentum [kg m/s] in the worst window (piece of a run), and the errors in this window
/// that the scheme and rounding explain.
pub struct Books {
    pub energy: f64,
    pub energy_allowed: f64,
    pub momentum: f64,
    pub momentum_allowed: f64,
}

/// [J] sum of M u_n²/2 over all impacts of a simulation with spheres of at most unit mass (effective mass M, normal
/// speed u_n). M/2 is at most 1/4 for a pair and 1/2 at a wall.
pub fn energy_of_impacts(simulation: &Simulation) -> f64 {
    let record = &simulation.record;
    0.25 * record.pairs.normal_speed.sum_of_squares() + 0.5 * record.walls.normal_speed.sum_of_squares()
}

/// Runs a dense gas through its windows (pieces of the run). `explained` returns the energy [J] that the scheme may
/// have added or removed up to the present time.
pub fn books(
    crowd: &Crowd,
    engine: Box<dyn Engine>,
    explained: &dyn Fn(&Simulation) -> f64,
) -> Result<(Books, Simulation), String> {
    let mut simulation = Simulation::with_engine(crowd.scene.clone(), crowd.start.clone(), engine);
    let (energy, momentum) = (simulation.energy(), simulation.particles.momentum());
    let mut worst =
        Books { energy: 0.0, energy_allowed: f64::INFINITY, momentum: 0.0, momentum_allowed: f64::INFINITY };
    for _ in 0..crowd.windows {
        simulation.run(1, crowd.window).map_err(|failure| format!("{}: {failure}", crowd.words))?;
        let (record, counters) = (&simulation.record, simulation.counters());
        let (now, ledger) = (simulation.energy(), &record.ledger);
        let fastest = simulation.particles.largest_speed(Vector3::zeros());
        // number of changes of a velocity up to now: forces and impulses on two bodies, entering and leaving an island,
        // gravity, changes of the frame of reference
        let bodies = simulation.windows * crowd.start.len() as u64 + counters.island_members;
        let changes = 2 * (counters.force_evaluations + counters.events) + 4 * bodies;
        let rounding = 2.0 * f64::EPSILON * changes as f64;
        let through = ledger.through(energy) + ledger.dissipated();
        let residual = ledger.residual(energy, now).abs();
        let allowed = explained(&simulation) + rounding * through;
        if residual / allowed > worst.energy / worst.energy_allowed {
            (worst.energy, worst.energy_allowed) = (residual, allowed);
        }
        let given = ledger.wall_impulse + ledger.gravity_impulse + ledger.drag_impulse;
        let miss = simulation.particles.momentum() - momentum - given;
        let allowed = rounding * fastest;
        if miss.norm() / allowed > worst.momentum / worst.momentum_allowed {
            (worst.momentum, worst.momentum_allowed) = (miss.norm(), allowed);
        }
    }
    Ok((worst, simulation))
}

/// Engines and kinds of time steps by name, with the fraction of M u_n²/2 (effective mass M, normal speed u_n) that
/// the scheme may add or remove in an impact.
///
/// With x = ω_0 Δt of the stiffest motion ([`TOGETHER`]), the fraction is 1/(1 - x²/4) - 1 for Verlet's method in
/// uniform steps (see `predict::energy::Bound`). The classical Runge-Kutta method has an error of x⁵/120 of the
/// amplitude of x'' = -x in each of its π/x steps. The error of the energy is therefore 2 π x⁴/120, and that of the
/// recorded losses is as large. Hard collisions are exact.
pub fn engines(crowd: &Crowd) -> Vec<(&'static str, Box<dyn Engine>, f64)> {
    let law = LinearSpring { stiffness: crowd.stiffness };
    let x = (TOGETHER * crowd.stiffness / 0.5).sqrt() * crowd.step;
    let (verlet, classical) = (1.0 / (1.0 - 0.25 * x * x) - 1.0, 4.0 * PI * x.powi(4) / 120.0);
    // local stepping uses uniform steps too if islands become too large
    let either = verlet.max(classical);
    let soft = |stepping| -> Box<dyn Engine> {
        Box::new(Soft::new(ContactLaw::linear(law.stiffness), Integrator::VelocityVerlet, crowd.step, stepping))
    };
    vec![
        ("uniform", soft(SoftStepping::Uniform), verlet),
        ("local", soft(SoftStepping::Local), either),
        ("auto", soft(SoftStepping::Auto), either),
        ("hard", Box::new(Hard::new().with_contact_time(Some(crowd.step))), 0.0),
        ("stepped", stepped(0.1), 0.0),
    ]
}

/// Runs the dense gases with these seeds, prints the worst case of each engine, and returns the faults.
fn soak(seeds: std::ops::Range<u64>) -> Vec<String> {
    let mut faults = Vec::new();
    let mut summary: Vec<(&str, u64, u64, f64, f64)> = Vec::new();
    for seed in seeds {
        let crowd = crowd(seed);
        for (index, (name, engine, gain)) in engines(&crowd).into_iter().enumerate() {
            if summary.len() == index {
                summary.push((name, 0, 0, 0.0, 0.0));
            }
            let line = &mut summary[index];
            // the energy of contacts in progress is at most the total energy
            let explained = |simulation: &Simulation| gain * (energy_of_impacts(simulation) + simulation.energy());
            match books(&crowd, engine, &explained) {
                Ok((worst, simulation)) => {
                    let energy = worst.energy / worst.energy_allowed;
                    let momentum = worst.momentum / worst.momentum_allowed;
                    line.1 += 1;
                    line.2 += simulation.record.pairs.count + simulation.record.walls.count;
                    (line.3, line.4) = (line.3.max(energy), line.4.max(momentum));
                    if energy > 1.0 || momentum > 1.0 {
                        faults.push(format!("{name}, {}: energy {energy:.2}, momentum {momentum:.2}", crowd.words));
                    }
                }
                Err(failure) => faults.push(format!("{name}, {failure}")),
            }
        }
    }
    for (name, runs, impacts, energy, momentum) in summary {
        println!(
            "{name:8} {runs} runs, {impacts} impacts; worst of what is allowed: energy {energy:.3}, momentum {momentum:.3}"
        );
    }
    faults
}

#[test]
fn books_balance_in_a_few_random_crowds() {
    // seeds 53 and 59 contain an event at the start of a step, which must not be searched for at its end
    let faults = soak(50..62);
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
#[ignore = "minutes: 500 random crowds in five ways of stepping; `cargo test -- --ignored soak --nocapture` prints the counts"]
fn books_balance_in_500_random_crowds() {
    let faults = soak(0..500);
    assert!(faults.is_empty(), "{} faults: {faults:#?}", faults.len());
}
