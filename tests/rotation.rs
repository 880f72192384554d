//! Rotating spheres: reference values computed independently (sections RA to RG of the catalogue of reference values),
//! balances, and equal bits.

mod closed_forms;
mod gases;
mod grooves;
mod heap;
mod losses;
mod mindlin;
mod pairs;
mod profiles;
mod rolling;
mod slips;
mod soak;
mod surfaces;
mod turning;

use crate::support::*;
use diptych::contact_law::{Bodies, ContactLaw, damping_ratio};
use diptych::engine::Engine;
use diptych::engine::hard::{Hard, SteppedHard};
use diptych::engine::hybrid::Hybrid;
use diptych::engine::soft::Soft;
use diptych::experiment::{Experiment, Integrator, Model, SoftStepping};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::rotation::{
    ImpactRule, LinearTangential, ObliqueImpact, ReboundTable, RollingLaw, Rotation, TangentialLaw, TwistingLaw,
};
use diptych::scene::{Scene, Species};
use diptych::simulation::Simulation;
use nalgebra::Vector3;
use std::sync::Arc;

/// Restitution, friction and constants of the tangential law in a reference case.
#[derive(Clone, Copy)]
struct Surfaces {
    restitution: f64,
    friction: f64,
    /// [-] ratio k_t/k_n of the tangential to the normal stiffness.
    stiffness: f64,
    /// [-] tangential dashpot c_t, divided by the effective mass and the normal frequency of the contact.
    dashpot: f64,
    /// [-] tangential restitution β_0 of Walton's rule, which is compared with the spring.
    walton: f64,
}

const W1: Surfaces = Surfaces { restitution: 1.0, friction: 0.092, stiffness: 0.8604651163, dashpot: 0.0, walton: 0.3 };
const W2: Surfaces =
    Surfaces { restitution: 0.9, friction: 0.3, stiffness: 0.2857142857, dashpot: 0.0, walton: 0.999998440 };
const W3: Surfaces =
    Surfaces { restitution: 0.8, friction: 0.25, stiffness: 0.3036939499, dashpot: 0.1489540016, walton: 0.44 };
const W4: Surfaces =
    Surfaces { restitution: 0.9, friction: 0.3, stiffness: 0.2857142857, dashpot: 0.01915339949, walton: 0.9 };

impl Surfaces {
    fn tangential(&self) -> TangentialLaw {
        // c_n/(M ω_0) = 2 ζ
        let dashpot = if self.dashpot > 0.0 { self.dashpot / (2.0 * damping_ratio(self.restitution)) } else { 0.0 };
        TangentialLaw::Linear(LinearTangential::Ratios { stiffness: self.stiffness, dashpot })
    }

    fn of_spring(&self) -> ImpactRule {
        let (damping_ratio, mass) = (damping_ratio(self.restitution), 2.0 / 7.0);
        let impact = ObliqueImpact::linear(damping_ratio, self.stiffness, self.dashpot, mass);
        ImpactRule::OfSpring(Arc::new([ReboundTable::new(self.restitution, impact)]))
    }

    fn walton(&self) -> ImpactRule {
        ImpactRule::Walton { tangential_restitution: self.walton }
    }
}

const RADIUS: f64 = 2.5e-3;
const SPEED: f64 = 3.9;
/// [N/m] normal stiffness of the contacts.
const STIFFNESS: f64 = 1.72e7;

fn ball() -> Species {
    Species { diameter: 2.0 * RADIUS, density: 4000.0, ..small() }
}

/// Ball thrown with the speed V at a floor at an angle [°] from the normal, with a forward spin R ω/V [-] (radius R,
/// spin ω).
fn thrown(surfaces: &Surfaces, impact: ImpactRule, (angle, spin): (f64, f64)) -> (Scene, Particles) {
    let of = surface(surfaces.restitution, surfaces.friction);
    let mut scene = empty([0.1; 3], [true, false, true], ball(), of);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], of)];
    scene.rotation = Some(Rotation::new(surfaces.tangential(), impact));
    let (sin, cos) = f64::to_radians(angle).sin_cos();
    let mut particles = placed(&scene, &[([0.05, RADIUS + 1e-6, 0.05], [SPEED * sin, -SPEED * cos, 0.0])]);
    scene.let_rotate(&mut particles);
    // a forward spin along x over a floor is negative about z
    particles.spin.as_mut().unwrap()[0] = Vector3::new(0.0, 0.0, -spin * SPEED / RADIUS);
    (scene, particles)
}

/// Velocity along the floor, radius times spin, and velocity normal to the floor after the bounce [-], divided by the
/// speed before it.
fn bounced(scene: Scene, particles: Particles, engine: Box<dyn Engine>) -> [f64; 3] {
    let mut simulation = Simulation::with_engine(scene, particles, engine);
    simulation.run(20, 1e-5).unwrap();
    let (v, w) = (simulation.particles.velocity[0], simulation.particles.spin.as_ref().unwrap()[0]);
    [v.x / SPEED, -w.z * RADIUS / SPEED, v.y / SPEED]
}

fn contact_time(restitution: f64) -> f64 {
    let law = ContactLaw::linear(STIFFNESS);
    law.contact_time(&law.between(&Bodies::of_wall(&ball(), &surface(restitution, 0.0), None)), 1.0)
}

fn soft(restitution: f64, steps: f64, stepping: SoftStepping) -> Box<dyn Engine> {
    let step = contact_time(restitution) / steps;
    Box::new(Soft::new(ContactLaw::linear(STIFFNESS), Integrator::VelocityVerlet, step, stepping))
}

/// Reference values of one bounce (section RA of the catalogue): surfaces, angle of impact [°], and radius times spin
/// before the bounce. Then the velocity along the floor and radius times spin after it, first with a spring whose
/// force is at most μ max(f_n, 0), then with Walton's rule. All speeds are divided by the speed before the bounce.
const AT_WALL: &[(Surfaces, f64, f64, [f64; 2], [f64; 2])] = &[
    (W1, 2.0, 0.0, [0.030541524, 0.010894932], [0.021936826, 0.032406676]),
    (W1, 5.0, 0.0, [0.070284542, 0.042178002], [0.054783610, 0.080930333]),
    (W1, 10.0, 0.0, [0.113186073, 0.151155261], [0.109150283, 0.161244736]),
    (W1, 20.0, 0.0, [0.202859623, 0.347901301], [0.214984090, 0.317590133]),
    (W1, 30.0, 0.0, [0.340651326, 0.398371686], [0.340651326, 0.398371686]),
    (W1, 60.0, 0.0, [0.774025404, 0.230000000], [0.774025404, 0.230000000]),
    (W2, 2.0, 0.0, [0.014979006, 0.049801228], [0.014956943, 0.049856385]),
    (W2, 20.0, 0.0, [0.146917981, 0.487755407], [0.146580214, 0.488599824]),
    (W2, 40.0, 0.0, [0.278501561, 0.910715121], [0.275480691, 0.918267298]),
    (W2, 50.0, 0.0, [0.402045013, 0.909998575], [0.399655506, 0.915972344]),
    (W2, 80.0, 0.0, [0.885749310, 0.247646107], [0.885828292, 0.247448653]),
    (W2, 20.0, -1.0, [-0.192471297, 0.336228600], [-0.193604651, 0.339061985]),
    (W2, 20.0, 1.5, [0.874908533, 0.167779026], [0.877644937, 0.160938015]),
    (W2, 50.0, 0.25, [0.473079263, 0.982412951], [0.471162134, 0.987205772]),
    (W3, 5.0, 0.0, [0.050532645, 0.091557745], [0.051297380, 0.089645907]),
    (W3, 30.0, 0.0, [0.290908042, 0.522729896], [0.294285714, 0.514285714]),
    (W3, 50.0, 0.0, [0.475488481, 0.726389906], [0.476790019, 0.723136061]),
    (W3, 80.0, 0.0, [0.906314464, 0.196233222], [0.906666073, 0.195354200]),
    (W4, 20.0, 0.0, [0.156154078, 0.464665163], [0.156352066, 0.464170195]),
    (W4, 46.0, 0.0, [0.328424642, 0.977287895], [0.328841052, 0.976246872]),
    (W4, 60.0, 0.0, [0.580721493, 0.713259776], [0.581025404, 0.712500000]),
];

fn worst(expected: &[f64; 2], found: &[f64; 3]) -> f64 {
    (expected[0] - found[0]).abs().max((expected[1] - found[1]).abs())
}

#[test]
fn hard_impacts_follow_waltons_rule() {
    for (surfaces, angle, spin, _, walton) in AT_WALL {
        for engine in [Box::new(Hard::new()) as Box<dyn Engine>, Box::new(SteppedHard::new(0.3))] {
            let (scene, particles) = thrown(surfaces, surfaces.walton(), (*angle, *spin));
            let found = bounced(scene, particles, engine);
            assert!(worst(walton, &found) < 2e-9, "{angle}°: {found:?} for {walton:?}");
        }
    }
}

#[test]
fn hard_impacts_by_the_rule_of_a_spring_are_those_of_stiff_soft_spheres_at_every_angle() {
    for (surfaces, angle, spin, spring, _) in AT_WALL {
        let (scene, particles) = thrown(surfaces, surfaces.of_spring(), (*angle, *spin));
        let found = bounced(scene, particles, Box::new(Hard::new()));
        assert!(worst(spring, &found) < 1e-6, "{angle}°: {found:?} for {spring:?}");
    }
}

#[test]
fn soft_impacts_by_local_stepping_are_those_of_the_reference() {
    let mut all: f64 = 0.0;
    for (surfaces, angle, spin, spring, _) in AT_WALL {
        let (scene, particles) = thrown(surfaces, surfaces.walton(), (*angle, *spin));
        let found = bounced(scene, particles, soft(surfaces.restitution, 200.0, SoftStepping::Local));
        let off = worst(spring, &found);
        println!("e {} {angle}° {spin}: {off:.1e}", surfaces.restitution);
        all = all.max(off);
    }
    assert!(all < 1e-5, "{all:.1e}");
}

#[test]
fn soft_impacts_by_uniform_stepping_converge() {
    for steps in [100.0, 200.0, 400.0] {
        let mut all: f64 = 0.0;
        for (surfaces, angle, spin, spring, _) in AT_WALL {
            let (scene, particles) = thrown(surfaces, surfaces.walton(), (*angle, *spin));
            let found = bounced(scene, particles, soft(surfaces.restitution, steps, SoftStepping::Uniform));
            let off = worst(spring, &found);
            println!("{steps}: e {} {angle}° {spin}: {off:.1e}", surfaces.restitution);
            all = all.max(off);
        }
        println!("{steps}: {all:.1e}");
        assert!(all < 2e-3 * 100.0 / steps, "{steps} steps in a contact: {all:.1e}");
    }
}

#[test]
fn hybrid_impacts_are_hard_ones() {
    let (scene, particles) = thrown(&W3, W3.walton(), (30.0, 0.0));
    let step = contact_time(0.8) / 50.0;
    let hybrid = Hybrid::new(ContactLaw::linear(STIFFNESS), Integrator::VelocityVerlet, step, 2.0);
    let found = bounced(scene, particles, Box::new(hybrid));
    assert!(worst(&[0.294285714, 0.514285714], &found) < 2e-9, "{found:?}");
}

/// A ball dropped with spin (section RE of the catalogue). Each entry has v_0, R ω_0, the speed of the first impact,
/// e, μ and β_0, then v and R ω after each bounce. Here v is the velocity along the floor, R the radius and ω the
/// spin. The final velocity is (5 v_0 + 2 R ω_0)/7.
#[test]
fn a_ball_dropped_with_spin_bounces_as_it_must() {
    let bounces = [
        ([0.0, 2.0, 1.0, 0.8, 0.25, 0.44], [[0.45, 0.875], [0.624857143, 0.437857143], [0.54792, 0.6302]]),
        ([0.0, 2.0, 1.0, 0.8, 0.1, 0.44], [[0.18, 1.55], [0.324, 1.19], [0.4392, 0.902]]),
        ([0.6, -1.0, 0.7, 0.9, 0.3, 0.0], [[0.201, -0.0025], [0.142857143, 0.142857143], [0.142857143, 0.142857143]]),
    ];
    for ([v0, w0, u, e, mu, beta], expected) in bounces {
        let of = surface(e, mu);
        let mut scene = empty([1.0; 3], [true, false, true], ball(), of);
        scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], of)];
        scene.gravity = Vector3::new(0.0, -9.81, 0.0);
        let impact = ImpactRule::Walton { tangential_restitution: beta };
        scene.rotation = Some(Rotation::new(TangentialLaw::Coulomb, impact));
        let height = u * u / (2.0 * 9.81);
        let mut particles = placed(&scene, &[([0.5, RADIUS + height, 0.5], [v0, 0.0, 0.0])]);
        scene.let_rotate(&mut particles);
        particles.spin.as_mut().unwrap()[0].z = -w0 / RADIUS;
        let mut simulation = Simulation::with_engine(scene, particles, Box::new(Hard::new()));
        let mut time = u / 9.81;
        let mut now = 0.0;
        for (k, [v, w]) in expected.into_iter().enumerate() {
            let flight = 2.0 * u * e.powi(k as i32 + 1) / 9.81;
            let middle = time + 0.5 * flight;
            simulation.run(10, (middle - now) / 10.0).unwrap();
            (now, time) = (middle, time + flight);
            let (velocity, spin) = (simulation.particles.velocity[0].x, -simulation.particles.spin_of(0).z * RADIUS);
            assert!(
                (velocity - v).abs() < 1e-9 && (spin - w).abs() < 1e-9,
                "bounce {k}: {velocity}, {spin} for {v}, {w}"
            );
        }
    }
}

/// A soft ball on an incline rolls or slips (section RE of the catalogue). From rest, without a tangential dashpot, it
/// oscillates about the rolling motion.
#[test]
fn a_soft_ball_rolls_down_an_incline() {
    for (stepping, tolerance) in [(SoftStepping::Local, 1e-6), (SoftStepping::Uniform, 2e-3)] {
        let of = surface(0.5, 0.3);
        let species = Species { diameter: 1e-3, density: 2500.0, ..small() };
        let mut scene = empty([1.0; 3], [true, false, true], species.clone(), of);
        scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], of)];
        let (sin, cos) = f64::to_radians(10.0).sin_cos();
        scene.gravity = Vector3::new(9.81 * sin, -9.81 * cos, 0.0);
        let tangential = TangentialLaw::Linear(LinearTangential::Ratios { stiffness: 2.0 / 7.0, dashpot: 0.0 });
        scene.rotation = Some(Rotation::new(tangential, ImpactRule::COULOMB));
        let stiffness = 3.5e3;
        let sunk = species.mass() * 9.81 * cos / stiffness;
        let mut particles = placed(&scene, &[([0.5, 0.5e-3 - sunk, 0.5], [0.0; 3])]);
        scene.let_rotate(&mut particles);
        let law = ContactLaw::linear(stiffness);
        let bodies = Bodies::of_wall(&species, &of, None);
        let step = law.contact_time(&law.between(&bodies), 1.0) / 50.0;
        let engine = Soft::new(law, Integrator::VelocityVerlet, step, stepping);
        let mut simulation = Simulation::with_engine(scene, particles, Box::new(engine));
        simulation.run(20, 5e-5).unwrap();
        // k_t = 1000 N/m: v = g sin α (5 t/7 + (2/7) sin(w t)/w), w = sqrt(3.5 k_t/m), at 1 ms
        let frequency = (3.5e3 / species.mass()).sqrt();
        let swing = 2.0 / 7.0 * (frequency * 1e-3).sin() / frequency;
        let expected = 9.81 * sin * (5.0 / 7.0 * 1e-3 + swing);
        let velocity = simulation.particles.velocity[0].x;
        assert!((velocity / expected - 1.0).abs() < tolerance, "{stepping:?}: {velocity} for {expected}");
        let spin = -simulation.particles.spin_of(0).z * 0.5e-3;
        let rolls = 9.81 * sin * (5.0 / 7.0) * (1e-3 - (frequency * 1e-3).sin() / frequency);
        assert!((spin / rolls - 1.0).abs() < tolerance, "{stepping:?}: {spin} for {rolls}");
    }
}

/// Without friction, spins do not change in any bit, and everything else is as without rotation (section RG 2 of the
/// catalogue).
#[test]
fn without_friction_rotation_changes_nothing() {
    for model in [Model::Soft, Model::Hard, Model::Hybrid, Model::Dsmc] {
        let scene = empty([3e-3; 3], [true; 3], small(), surface(0.9, 0.0));
        let plain = experiment(scene, 60, [0.0; 3], 0.5, model, 3);
        let mut rotating = plain.clone();
        rotating.scene.rotation = Some(Rotation::new(W3.tangential(), W3.of_spring()));
        rotating.start[0].spin_fluctuation = 1000.0;
        let (mut smooth, mut spun) = (
            Simulation::new(&plain, initial_state(&plain).unwrap()),
            Simulation::new(&rotating, initial_state(&rotating).unwrap()),
        );
        let before = spun.state().spin;
        smooth.run(20, 1e-4).unwrap();
        spun.run(20, 1e-4).unwrap();
        let (smooth, spun) = (smooth.state(), spun.state());
        assert_eq!(spun.spin, before, "{model:?}");
        assert_eq!((smooth.position, smooth.velocity), (spun.position, spun.velocity), "{model:?}");
    }
}

/// A gas of rough spheres at the volume fraction φ in a periodic box.
fn rough_gas(
    model: Model,
    rotation: Rotation,
    (restitution, friction): (f64, f64),
    fraction: f64,
    count: usize,
) -> Experiment {
    let species = Species { diameter: 1e-3, density: 2500.0, ..small() };
    let edge = (count as f64 * species.volume() / fraction).cbrt();
    let scene = empty([edge; 3], [true; 3], species.clone(), surface(restitution, friction));
    let mut gas = experiment(scene, count, [0.0; 3], 1.0, model, 5);
    gas.scene.rotation = Some(rotation);
    // I ω² = m v² in each component
    gas.start[0].spin_fluctuation = 1.0 / (0.5e-3 * 0.4f64.sqrt());
    gas
}

/// State of a rough scene with walls, gravity and two species, computed by every engine, from a snapshot in the middle,
/// and on three threads.
#[test]
fn rough_scenes_have_the_same_bits_from_a_snapshot_and_on_any_threads() {
    for (model, stepping) in [
        (Model::Soft, SoftStepping::Local),
        (Model::Soft, SoftStepping::Uniform),
        (Model::Soft, SoftStepping::Auto),
        (Model::Hard, SoftStepping::Auto),
        (Model::Hybrid, SoftStepping::Auto),
    ] {
        let mut scene = empty([3e-3; 3], [true, false, true], small(), surface(0.8, 0.4));
        scene.walls = vec![
            plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.3)),
            plane([0.0, 3e-3, 0.0], [0.0, -1.0, 0.0], surface(0.9, 0.3)),
        ];
        let mut rough = experiment(scene, 80, [0.0; 3], 0.5, model, 4);
        // gravity by which spheres settle on the floor, and roll and twist there
        rough.scene.gravity = Vector3::new(40.0, -800.0, 0.0);
        let rolling = Some(RollingLaw::Spring { friction: 0.1, stiffness: None, damping: 0.3 });
        let twisting = Some(TwistingLaw { damping: 0.1 });
        rough.scene.rotation = Some(Rotation { rolling, twisting, ..Rotation::new(W3.tangential(), W3.walton()) });
        rough.start[0].spin_fluctuation = 2000.0;
        rough.soft.stepping = stepping;
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut simulation = Simulation::new(&rough, initial_state(&rough).unwrap());
                simulation.run(16, 1e-4).unwrap();
                simulation.state()
            })
        };
        let whole = run(1);
        assert_eq!(whole, run(3), "{model:?} {stepping:?} on three threads");
        let mut first = Simulation::new(&rough, initial_state(&rough).unwrap());
        first.run_while(16, 1e-4, &mut |_, done| done < 7).unwrap();
        let stored = first.snapshot().unwrap();
        let mut second = Simulation::restore(&rough, stored).unwrap();
        second.run_while(9, 1e-4, &mut |_, _| true).unwrap();
        second.end();
        assert_eq!(whole, second.particles, "{model:?} {stepping:?} from a snapshot");
    }
}
