//! Balls that roll, slide and bounce, against closed forms and a quadrature (section RE of the catalogue of reference
//! values), and test 8 of Chung and Ooi (2011).

use super::*;
use diptych::scene::Surface;
use diptych::walls::{Obstacle, Wall, WallGeometry};

/// A ball of radius 1 mm and 2500 kg/m³.
fn bead() -> Species {
    Species { diameter: 2e-3, density: 2500.0, ..small() }
}

/// [s] contact time of a bead at a wall, divided by a number of steps.
fn step_of(stiffness: f64, of: &Surface, steps: f64) -> f64 {
    let law = ContactLaw::linear(stiffness);
    law.contact_time(&law.between(&Bodies::of_wall(&bead(), of, None)), 1.0) / steps
}

/// Soft engine whose step is the contact time of a bead at a wall, divided by `steps`.
fn soft_beads(stiffness: f64, of: &Surface, steps: f64, stepping: SoftStepping) -> Box<dyn Engine> {
    let step = step_of(stiffness, of, steps);
    Box::new(Soft::new(ContactLaw::linear(stiffness), Integrator::VelocityVerlet, step, stepping))
}

fn sticking_spring() -> TangentialLaw {
    TangentialLaw::Linear(LinearTangential::Ratios { stiffness: 2.0 / 7.0, dashpot: 2.0 / 7.0 })
}

/// A ball on a fixed sphere starts 10° from the top, rolls, begins to slip and leaves the sphere (section RE of the
/// catalogue). The normal turns by more than 40° within one contact, and the tangential spring must turn with it.
#[test]
fn a_ball_rolls_off_a_fixed_sphere() {
    // friction; angle [°] at which the ball leaves, time in units of sqrt(D/g), speed of the centre over sqrt(D g), and
    // r ω over sqrt(D g)
    for (friction, angle, time, speed, spin) in
        [(0.2, 52.1130739, 2.76856667, 0.7836486, 0.553726622), (1.0, 53.9504557, 2.83040095, 0.767127498, 0.713927194)]
    {
        let of = surface(0.3, friction);
        let stiffness = 5e5 * bead().mass() * 9.81 / bead().diameter;
        let mut scene = empty([0.04; 3], [false; 3], bead(), of);
        scene.gravity = Vector3::new(0.0, -9.81, 0.0);
        let (center, apart) = (Vector3::repeat(0.02), 4e-3);
        scene.walls = vec![Wall::new(WallGeometry::Obstacle(Obstacle::sphere(center, apart - 1e-3)), of)];
        scene.rotation = Some(Rotation::new(sticking_spring(), ImpactRule::COULOMB));
        // rotation about an axis that is not one of the axes of the box
        let out = Vector3::new(3.0, 0.0, 4.0) / 5.0;
        let (sin, cos) = f64::to_radians(10.0).sin_cos();
        let sunk = bead().mass() * 9.81 * cos / stiffness;
        let start = center + (out * sin + Vector3::y() * cos) * (apart - sunk);
        let mut particles = placed(&scene, &[(start.into(), [0.0; 3])]);
        scene.let_rotate(&mut particles);
        let engine = soft_beads(stiffness, &of, 20.0, SoftStepping::Local);
        let mut simulation = Simulation::with_engine(scene, particles, engine);
        let (unit, window) = ((apart / 9.81).sqrt(), 2e-5);
        let mut windows = 0;
        let distance = |simulation: &Simulation| (simulation.particles.position[0] - center).norm();
        while distance(&simulation) < apart {
            simulation.run(1, window).unwrap();
            windows += 1;
            assert!(windows < 10_000, "the ball stays on the sphere");
        }
        let off = simulation.particles.position[0] - center;
        let found = [
            (off.dot(&out)).atan2(off.y).to_degrees(),
            f64::from(windows) * window / unit,
            simulation.particles.velocity[0].norm() / (apart * 9.81).sqrt(),
            simulation.particles.spin_of(0).norm() * 1e-3 / (apart * 9.81).sqrt(),
        ];
        let steps = simulation.counters().steps;
        println!("μ {friction}: {found:?} for {:?}, {steps} steps", [angle, time, speed, spin]);
        // tolerance of the reference for k d/(m g) >= 1e5
        assert!((found[0] - angle).abs() < 0.1, "{friction}: {found:?}");
        for (found, expected) in found[1..].iter().zip([time, speed, spin]) {
            assert!((found / expected - 1.0).abs() < 2e-3, "{friction}: {found} for {expected}");
        }
        assert!(off.dot(&Vector3::new(-4.0, 0.0, 3.0)).abs() < 1e-12, "it leaves its plane: {off}");
        // it begins to slip once, so that few steps are shortened
        assert!(steps < 30_000, "{steps} steps");
    }
}

/// From time 0 on, a floor that moves with the velocity U accelerates a ball at rest (section RE of the catalogue).
/// The ball slides until the time 2U/(7 μ g), and then rolls with the velocity 2U/7.
#[test]
fn a_belt_takes_a_ball_along() {
    let (belt, friction, ends) = (0.5, 0.3, 0.048541332945002666);
    let engines: [(&str, fn(&Surface) -> Box<dyn Engine>); 3] = [
        ("local", |of| soft_beads(1e5, of, 30.0, SoftStepping::Local)),
        ("uniform", |of| soft_beads(1e5, of, 30.0, SoftStepping::Uniform)),
        ("hybrid", |of| {
            let step = step_of(1e5, of, 30.0);
            Box::new(Hybrid::new(ContactLaw::linear(1e5), Integrator::VelocityVerlet, step, 2.0))
        }),
    ];
    for (name, engine) in engines {
        let of = surface(0.5, friction);
        let mut scene = empty([0.1; 3], [true, false, true], bead(), of);
        scene.gravity = Vector3::new(0.0, -9.81, 0.0);
        scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], of)];
        scene.walls[0].velocity = Vector3::new(0.0, 0.0, belt);
        scene.rotation = Some(Rotation::new(sticking_spring(), ImpactRule::COULOMB));
        let sunk = bead().mass() * 9.81 / 1e5;
        let mut particles = placed(&scene, &[([0.05, 1e-3 - sunk, 0.05], [0.0; 3])]);
        scene.let_rotate(&mut particles);
        let mut simulation = Simulation::with_engine(scene, particles, engine(&of));
        let energy = simulation.energy() + 0.5 * 1e5 * sunk * sunk;
        let window = ends / 200.0;
        simulation.run(100, window).unwrap();
        let speed = simulation.particles.velocity[0].z;
        let slides = friction * 9.81 * 0.5 * ends;
        assert!((speed / slides - 1.0).abs() < 1e-3, "{name}: {speed} for {slides} while it slides");
        simulation.run(150, window).unwrap();
        let (speed, spin) = (simulation.particles.velocity[0].z, simulation.particles.spin_of(0).x * 1e-3);
        assert!((speed / (2.0 / 7.0 * belt) - 1.0).abs() < 1e-3, "{name}: {speed}");
        // a forward motion along z belongs to a positive spin about x; this spin is backwards
        assert!((spin / (-5.0 / 7.0 * belt) - 1.0).abs() < 1e-3, "{name}: {spin}");
        // the work of the belt is μ m g U times this time; sliding dissipates half of it
        let work = friction * bead().mass() * 9.81 * belt * ends;
        let ledger = &simulation.record.ledger;
        assert!((ledger.wall_work / work - 1.0).abs() < 2e-3, "{name}: {} for {work}", ledger.wall_work);
        let residual = ledger.residual(energy, simulation.energy());
        assert!(residual.abs() < 2e-3 * work, "{name}: {residual:.1e} of {work:.1e}");
    }
}

/// Hard ball that bounces between two plates normal to y, with a velocity and a surface speed (radius times spin)
/// along x.
struct BetweenPlates {
    simulation: Simulation,
    /// [s] time of flight from one plate to the other.
    flight: f64,
}

impl BetweenPlates {
    /// `gravity` [m/s²] acts along x, and the speed across the gap is 1 m/s. The ball starts half a flight before its
    /// impact on the lower plate, with the velocity `along` [m/s] and radius times spin `rolls` [m/s].
    fn new(tangential_restitution: f64, gravity: f64, [along, rolls]: [f64; 2]) -> Self {
        let of = surface(1.0, 1e3);
        let mut scene = empty([0.1, 0.012, 0.1], [true, false, true], bead(), of);
        scene.gravity = Vector3::new(gravity, 0.0, 0.0);
        scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], of), plane([0.0, 0.012, 0.0], [0.0, -1.0, 0.0], of)];
        let impact = ImpactRule::Walton { tangential_restitution };
        scene.rotation = Some(Rotation::new(TangentialLaw::Coulomb, impact));
        let mut particles = placed(&scene, &[([0.05, 0.006, 0.05], [along, -1.0, 0.0])]);
        scene.let_rotate(&mut particles);
        particles.spin.as_mut().unwrap()[0].z = -rolls / 1e-3;
        Self { simulation: Simulation::with_engine(scene, particles, Box::new(Hard::new())), flight: 0.01 }
    }

    /// Velocity along x, and R ω (positive: forward on the lower plate), half a flight after the next bounce.
    fn bounce(&mut self) -> [f64; 2] {
        self.simulation.run(1, self.flight).unwrap();
        [self.simulation.particles.velocity[0].x, -self.simulation.particles.spin_of(0).z * 1e-3]
    }
}

/// An elastic ball sticks to both plates in turn, with the tangential restitution β. Expected are velocities after the
/// first six bounces as fractions (section RE of the catalogue).
#[test]
fn a_ball_bounces_between_plates() {
    for (beta, expected) in [
        (0.0, [(5, 5, 7), (15, -15, 49), (45, 45, 343), (135, -135, 2401), (405, 405, 16807), (1215, -1215, 117649)]),
        (
            1.0,
            [
                (3, 10, 7),
                (-31, -60, 49),
                (-333, -130, 343),
                (-479, 3720, 2401),
                (13443, -15950, 16807),
                (104129, -86580, 117649),
            ],
        ),
        (0.4, [(3, 5, 5), (-1, -15, 25), (-33, -5, 125), (-89, 165, 625), (63, -445, 3125), (1079, -315, 15625)]),
    ] {
        let mut plates = BetweenPlates::new(beta, 0.0, [1.0, 0.0]);
        for (k, (v, w, of)) in expected.into_iter().enumerate() {
            let [velocity, spin] = plates.bounce();
            let [v, w] = [v, w].map(|share| f64::from(share) / f64::from(of));
            assert!(
                (velocity - v).abs() < 1e-12 && (spin - w).abs() < 1e-12,
                "β {beta}, bounce {k}: {velocity}, {spin} for {v}, {w}"
            );
        }
    }
}

/// A ball that falls between vertical plates approaches a steady speed (section RE of the catalogue). Its spin changes
/// sign at every bounce.
#[test]
fn a_ball_falls_between_vertical_plates_at_a_limit_speed() {
    for (beta, limit) in [(0.0, 1.25), (0.4, 0.25), (0.8, -11.0 / 36.0)] {
        let mut plates = BetweenPlates::new(beta, 9.81, [0.0, 0.0]);
        // G = g T, with the time T of a flight; half a flight after a bounce, the ball is faster by G/2
        let gain = 9.81 * plates.flight;
        let last = (0..400).map(|_| plates.bounce()).last().unwrap();
        assert!((last[0] / gain - limit - 0.5).abs() < 1e-9, "β {beta}: {} for {limit}", last[0] / gain - 0.5);
        assert!((last[1].abs() / gain - 1.25).abs() < 1e-9, "β {beta}: {}", last[1] / gain);
    }
}
