//! Sheared boxes: contacts across a side, translation of the box, balance of energy, agreement of the engines, the same
//! bits, and stress and temperature against kinetic theory.

use crate::support::*;
use diptych::contact_law::ContactLaw;
use diptych::engine::Engine;
use diptych::engine::hard::Hard;
use diptych::engine::hybrid::Hybrid;
use diptych::experiment::Integrator;
use diptych::{Particles, Scene, Vector3};

/// [N/m] stiffness of soft spheres of unit mass: an elastic contact lasts π/sqrt(2 k) = 0.022 s.
const STIFFNESS: f64 = 1e4;

/// [s] step of soft spheres, a fortieth of a contact.
const STEP: f64 = 5.5e-4;

/// A name and a function that makes an engine.
type Maker = (&'static str, fn() -> Box<dyn Engine>);

fn hybrid() -> Box<dyn Engine> {
    Box::new(Hybrid::new(ContactLaw::linear(STIFFNESS), Integrator::VelocityVerlet, STEP, 2.0))
}

/// Engines of hard spheres without time steps.
const EXACT: [Maker; 2] = [("one calendar", || Box::new(Hard::with_one_calendar())), ("islands", islands)];

/// Engines of soft spheres.
const SOFT: [Maker; 4] = [
    ("uniform", || soft(STIFFNESS, STEP, Integrator::VelocityVerlet)),
    ("uniform, Heun", || soft(STIFFNESS, STEP, Integrator::Rk2)),
    ("local", || local(STIFFNESS, STEP, Integrator::VelocityVerlet)),
    ("hybrid", hybrid),
];

/// A sheared cube with spheres of unit diameter and mass.
fn sheared(edge: f64, rate: f64, restitution: f64) -> Scene {
    let mut scene = empty([edge; 3], [true; 3], unit(), surface(restitution, 0.0));
    scene.domain = scene.domain.sheared(rate, 0.0);
    scene
}

/// `count` random spheres that fill a sheared cube to `phi`; their mean velocity relative to the mean flow is zero.
fn gas(count: usize, phi: f64, restitution: f64, seed: u64) -> (Scene, Particles) {
    let scene = sheared(edge(count, 1.0, phi), 1.0, restitution);
    let mut particles = random(&scene, count, 1.0, seed);
    let mean = particles.relative_to_flow(&scene.domain).mean_velocity();
    particles.velocity.iter_mut().for_each(|v| *v -= mean);
    (scene, particles)
}

/// Two spheres that meet across the sheared side, and the same two spheres near the middle of a box at rest, with the
/// upper one replaced by its image.
///
/// The lower sphere is at y = 0.6, the upper one at y = 9.3 in a box of 10; at time t its image is at y = -0.7, displaced
/// by -γ L_y t along z, and slower by γ L_y. Positions are such that the two touch after about 0.3 s.
fn two(rate: f64, at_rest: bool) -> (Scene, Particles) {
    let mut scene = sheared(10.0, rate, 0.8);
    let sliding = rate * 10.0;
    // the image closes in along y at 1.0 and along z at 0.4
    let lower = ([5.0, 0.6, 5.0], [0.1, -0.3, 0.2]);
    let upper = ([5.1, 9.3, 4.8], [0.0, 0.7, 0.6 + sliding]);
    if at_rest {
        scene.domain.shear = None;
        let image = ([5.1, 9.3 - 10.0 + 5.0, 4.8], [0.0, 0.7, 0.6]);
        return (scene.clone(), placed(&scene, &[([5.0, 5.6, 5.0], lower.1), image]));
    }
    (scene.clone(), placed(&scene, &[lower, upper]))
}

#[test]
fn two_spheres_meet_across_a_sheared_side_as_two_beside_each_other() {
    // Positions of 10 are rounded by 2e-15, which a touch magnifies by the curvature of the sphere. A soft contact
    // multiplies them by the stiffness and its duration, 220. The steps are at the same times in both boxes.
    let exact = EXACT.iter().map(|engine| (engine, 1e-12));
    for ((name, engine), tolerance) in exact.chain(SOFT.iter().map(|engine| (engine, 1e-11))) {
        for rate in [0.7, -0.7] {
            let [there, here] = [false, true].map(|at_rest| {
                let (scene, start) = two(rate, at_rest);
                run(&scene, start, engine(), 1.0, 10)
            });
            assert_eq!([there.record.pairs.count, here.record.pairs.count], [1, 1], "{name}");
            let (low, high) = (there.particles.velocity[0], there.particles.velocity[1]);
            let (want_low, want_high) = (here.particles.velocity[0], here.particles.velocity[1]);
            let slide = Vector3::new(0.0, 0.0, 10.0 * rate);
            // after the impact both may have crossed the side, and then have the velocity of their image
            let apart = |got: Vector3<f64>, want: Vector3<f64>| {
                [-1.0, 0.0, 1.0].map(|k| (got - want - slide * k).norm()).into_iter().fold(f64::INFINITY, f64::min)
            };
            assert!(apart(low, want_low) < tolerance, "{name} {rate}: {low} {want_low}");
            assert!(apart(high, want_high) < tolerance, "{name} {rate}: {high} {want_high}");
            assert!((want_low - Vector3::new(0.1, -0.3, 0.2)).norm() > 0.5, "{name}: no impact");
        }
    }
}

#[test]
fn a_translated_box_has_the_same_physics() {
    // every sphere collides some times, which multiplies rounding by about ten each: 1e-15 becomes 1e-9 at most
    for (name, engine) in EXACT.iter().chain(&SOFT) {
        let (scene, start) = gas(80, 0.2, 0.9, 4);
        let (height, duration) = (0.37 * scene.domain.size.y, 0.8);
        let shift = Vector3::new(0.0, height, 0.0);
        let mut moved = start.clone();
        for (x, v) in moved.position.iter_mut().zip(&mut moved.velocity) {
            *x += shift;
            *v += scene.domain.mean_flow(&shift);
            scene.domain.wrap_motion(x, v);
        }
        let [first, second] = [start, moved].map(|start| run(&scene, start, engine(), duration, 8));
        assert!(first.record.pairs.count > 80, "{name}: {} impacts", first.record.pairs.count);
        assert_eq!(first.record.pairs.count, second.record.pairs.count, "{name}");
        let domain = first.scene().domain.clone();
        let flow = domain.mean_flow(&shift);
        for k in 0..80 {
            let (mut x, mut v) = (first.particles.position[k] + shift + flow * duration, first.particles.velocity[k] + flow);
            domain.wrap_motion(&mut x, &mut v);
            let (apart, difference) =
                domain.relative(&x, &second.particles.position[k], v - second.particles.velocity[k], 0.0);
            assert!(apart.norm() < 1e-9 && difference.norm() < 1e-8, "{name} {k}: {apart} {difference}");
        }
    }
}

#[test]
fn the_work_of_shear_balances_dissipation() {
    for (name, engine) in EXACT.iter().chain(&SOFT).chain(&[("steps", (|| stepped(0.02)) as fn() -> _)]) {
        let (scene, start) = gas(200, 0.3, 0.8, 5);
        let before = start.kinetic_energy();
        let moving = start.momentum();
        let simulation = run(&scene, start, engine(), 3.0, 15);
        let ledger = &simulation.record.ledger;
        let (residual, through) = (ledger.residual(before, simulation.energy()), ledger.through(before));
        // hard spheres: rounding of some 10⁵ impulses. Soft spheres: steps of a fortieth of a contact change the energy of
        // an impact by (π/40)²/4 = 0.15 % either way; local steps by much less
        let bound = match *name {
            "uniform" | "uniform, Heun" => 1e-2,
            "local" | "hybrid" => 1e-5,
            _ => 1e-12,
        };
        assert!(residual.abs() < bound * through, "{name}: {residual} of {through}");
        assert!(ledger.dissipated() > 0.3 * before && ledger.shear_work > 0.3 * before, "{name}");
        // momentum changes at the sheared sides only
        let change = simulation.particles.momentum() - moving - ledger.shear_impulse;
        assert!(change.norm() < 1e-9 * before, "{name}: {change}");
        assert!(smallest_gap(simulation.scene(), &simulation.particles) > if bound == 1e-12 && *name != "steps" { -1e-12 } else { -0.2 });
    }
}

#[test]
fn engines_agree_for_as_long_as_rounding_allows() {
    let (scene, start) = gas(150, 0.25, 0.9, 6);
    let [one, other] = EXACT.map(|(_, engine)| run(&scene, start.clone(), engine(), 0.7, 7));
    assert!(one.record.pairs.count > 150);
    assert_eq!(one.record.pairs.count, other.record.pairs.count);
    for k in 0..start.len() {
        let difference = one.particles.velocity[k] - other.particles.velocity[k];
        assert!(difference.norm() < 1e-8, "{k}: {difference}");
    }
    // soft spheres in local and in uniform steps, as far as the steps allow
    let [one, other] = [SOFT[0], SOFT[2]].map(|(_, engine)| run(&scene, start.clone(), engine(), 0.2, 7));
    let worst = (0..start.len()).map(|k| (one.particles.velocity[k] - other.particles.velocity[k]).norm());
    assert!(worst.fold(0.0, f64::max) < 0.2 && one.record.pairs.count > 20);
}
