//! Walls whose shape moves: times of touch against an independent solver, period doubling of a bouncing ball, no missed
//! touch, other frames of reference, the ledger, forced oscillations of soft spheres, the same bits, and messages.

mod in_cases;

use crate::support::*;
use diptych::contact_law::ContactLaw;
use diptych::engine::hard::Hard;
use diptych::engine::hybrid::Hybrid;
use diptych::engine::{Engine, Failure};
use diptych::experiment::Integrator;
use diptych::simulation::Simulation;
use diptych::walls::{PiecewisePath, PrescribedMotion};
use diptych::{Particles, Scene, Vector3};
use std::f64::consts::{PI, TAU};

/// [N/m] stiffness of soft spheres of unit mass: a contact with a wall lasts π/sqrt(k) = 0.0099 s.
const STIFFNESS: f64 = 1e5;

/// [s] step of soft spheres, a fiftieth of a contact.
const STEP: f64 = 2e-4;

/// A name and a function that makes an engine.
type Maker = (&'static str, fn() -> Box<dyn Engine>);

/// Engines that find each collision of hard spheres at its exact instant.
const EXACT: [Maker; 2] = [("one calendar", || Box::new(Hard::with_one_calendar())), ("islands", islands)];

/// Engines in which contacts last for some time steps.
const SOFT: [Maker; 4] = [
    ("uniform", || soft(STIFFNESS, STEP, Integrator::VelocityVerlet)),
    ("uniform, Heun", || soft(STIFFNESS, STEP, Integrator::Rk2)),
    ("local", || local(STIFFNESS, STEP, Integrator::VelocityVerlet)),
    ("hybrid", || Box::new(Hybrid::new(ContactLaw::linear(STIFFNESS), Integrator::VelocityVerlet, STEP, 2.0))),
];

/// Engine that finds collisions of hard spheres as overlaps at the ends of time steps.
const STEPPED: Maker = ("stepped", || stepped(0.1));

fn up(y: f64) -> Vector3<f64> {
    Vector3::new(0.0, y, 0.0)
}

fn vibration(amplitude: Vector3<f64>, frequency: f64, phase: f64) -> PrescribedMotion {
    PrescribedMotion::Vibration { amplitude, frequency, phase }
}

fn path(knots: &[(f64, Vector3<f64>)]) -> PrescribedMotion {
    PrescribedMotion::Path(PiecewisePath::new(knots.to_vec()).unwrap().into())
}

/// Height [m] of the plate without displacement.
const PLATE: f64 = 5.0;

/// A ball of unit diameter and mass under gravity 1 m/s², `gap` [m] above a plate with the given motion, with the
/// velocity `speed` [m/s] upwards.
fn above(motion: &PrescribedMotion, restitution: f64, gap: f64, speed: f64) -> (Scene, Particles) {
    let mut scene = empty([10.0, 40.0, 10.0], [false; 3], unit(), surface(1.0, 0.0));
    scene.gravity = up(-1.0);
    let plate = plane([0.0, PLATE, 0.0], [0.0, 1.0, 0.0], surface(restitution, 0.0));
    scene.walls = vec![plate.moving(motion.clone()).unwrap()];
    let height = PLATE + motion.displacement(0.0).y + 0.5 + gap;
    (scene.clone(), placed(&scene, &[([5.0, height, 5.0], [0.0, speed, 0.0])]))
}

/// Ball on a moving plate, computed by a solver that is independent of the library. It finds the next impact in steps
/// of 1e-4 s and by bisection.
struct Bouncing<'a> {
    /// Displacement and velocity of the plate at a time.
    plate: &'a dyn Fn(f64) -> (f64, f64),
    restitution: f64,
    /// Time, height over the plate without displacement, and velocity of the last impact.
    flight: (f64, f64, f64),
    impacts: u64,
}

impl Bouncing<'_> {
    fn at(&self, time: f64) -> (f64, f64) {
        let (from, height, velocity) = self.flight;
        let t = time - from;
        (height + velocity * t - 0.5 * t * t, velocity - t)
    }

    /// Moves the ball to a time; returns its height and velocity there.
    fn to(&mut self, time: f64) -> (f64, f64) {
        let touches = |this: &Self, t: f64| this.at(t).0 <= (this.plate)(t).0;
        let mut low = self.flight.0;
        loop {
            let high = low + 1e-4;
            if low >= time {
                return self.at(time);
            }
            if !touches(self, high) || low == self.flight.0 {
                low = high;
                continue;
            }
            let (mut before, mut after) = (low, high);
            while 0.5 * (before + after) > before && 0.5 * (before + after) < after {
                let middle = 0.5 * (before + after);
                if touches(self, middle) { after = middle } else { before = middle }
            }
            if after > time {
                return self.at(time);
            }
            let ((height, velocity), (_, plate)) = (self.at(after), (self.plate)(after));
            self.flight = (after, height, plate - self.restitution * (velocity - plate));
            self.impacts += 1;
            low = after;
        }
    }
}

#[test]
fn a_ball_on_a_plate_follows_the_exact_map() {
    // Times up to 20 and heights of 6 are rounded by 4e-15 and 9e-16. An impact passes on errors multiplied by e and by
    // the acceleration of the plate divided by the speed. On the stable orbits they do not grow. At an acceleration Γ the
    // others grow by (1+e) Γ per impact or a little more, 5 at most here: 1e-15 becomes 1e-9 in some ten impacts.
    let knots = [(0.0, up(0.0)), (1.0, up(0.3)), (1.7, up(-0.2)), (4.0, up(0.1)), (11.0, up(0.0))];
    let wave = |gamma: f64, phase: f64| vibration(up(gamma / (TAU * TAU)), 1.0, phase);
    let translation = PrescribedMotion::Translation { velocity: Vector3::new(0.3, 0.05, 0.0) };
    for (what, motion, restitution, (speed, duration), tolerance) in [
        ("period one", wave(1.3, 0.634), 0.5, (0.5, 20.0), 1e-12),
        ("period two", wave(1.6, 0.857), 0.5, (0.5, 20.0), 1e-12),
        ("fast", vibration(up(2e-5), 40.0, 2.0), 0.9, (0.05, 0.8), 1e-9),
        ("high", wave(3.0, 0.0), 0.8, (0.5, 12.0), 1e-9),
        ("translation", translation, 0.95, (0.5, 12.0), 1e-12),
        ("path", path(&knots), 0.95, (0.5, 12.0), 1e-12),
    ] {
        for (name, engine) in EXACT {
            let (scene, start) = above(&motion, restitution, 0.002, speed);
            let still = Vector3::zeros();
            let plate = |t: f64| (motion.displacement(t).y, motion.velocity(&still, t).y);
            let flight = (0.0, plate(0.0).0 + 0.002, speed);
            let mut known = Bouncing { plate: &plate, restitution, flight, impacts: 0 };
            let mut simulation = Simulation::with_engine(scene, start, engine());
            // windows that are no divisor of the period
            let mut worst: f64 = 0.0;
            for window in 1..=83 {
                simulation.run(1, duration / 83.0).unwrap();
                let (height, velocity) = known.to(duration / 83.0 * f64::from(window));
                let (x, v) = (simulation.particles.position[0], simulation.particles.velocity[0]);
                worst = worst.max((x.y - PLATE - 0.5 - height).abs()).max((v.y - velocity).abs());
            }
            assert!(worst < tolerance, "{what}, {name}: {worst:e}");
            assert_eq!(simulation.record.walls.count, known.impacts, "{what}, {name}");
            assert!(known.impacts >= 5, "{what}: {} impacts", known.impacts);
        }
    }
}

#[test]
fn the_period_doubles_at_the_amplitude_of_the_linear_analysis() {
    // An orbit with one impact in k periods T leaves the plate at v = g k T/2 at the phase φ with
    // Γ cos φ = π k (1-e)/(1+e). Small deviations of time and speed at an impact are multiplied by a matrix with the
    // determinant e² and the trace 1 + e² - (1+e)² Γ sin φ (docs/design/moving-walls.md). So its eigenvalue is -1 at
    // Γ sin φ = 2 (1+e²)/(1+e)². At 3 % less the deviations decay by more than 0.85 per period, in 400 periods to 0.
    for e in [0.5_f64, 0.8] {
        let along = PI * (1.0 - e) / (1.0 + e);
        let critical = along.hypot(2.0 * (1.0 + e * e) / (1.0 + e).powi(2));
        for (gamma, doubled) in [(0.97 * critical, false), (1.03 * critical, true)] {
            let phase = (along / gamma).acos();
            let motion = vibration(up(gamma / (TAU * TAU)), 1.0, phase);
            let (scene, start) = above(&motion, e, 1e-4, 0.5);
            let mut simulation = Simulation::with_engine(scene, start, hard());
            // not at an impact, which is at whole periods
            simulation.run(400, 1.0).unwrap();
            simulation.run(1, 0.37).unwrap();
            let mut speeds = [0.0; 3];
            for speed in &mut speeds {
                simulation.run(1, 1.0).unwrap();
                *speed = simulation.particles.velocity[0].y;
            }
            assert!((speeds[2] - speeds[0]).abs() < 1e-6, "{e} {gamma}: {speeds:?}");
            assert_eq!((speeds[1] - speeds[0]).abs() > 1e-2, doubled, "{e} {gamma}: {speeds:?}");
        }
    }
}

/// Eight spheres in a box all of whose sides move: a floor that vibrates obliquely, a lid on a path, sides in
/// translation and in vibration. The room is 3 to 4 wide along each axis.
pub fn shaken(restitution: f64, friction: f64) -> (Scene, Particles) {
    let contact = surface(restitution, friction);
    let mut scene = empty([12.0; 3], [false; 3], unit(), surface(1.0, friction));
    let side = |point: [f64; 3], normal: [f64; 3], motion: PrescribedMotion| {
        plane(point, normal, contact).moving(motion).unwrap()
    };
    let lid: Vec<_> = (0..400).map(|k| (2.5 * f64::from(k), up(if k % 2 == 0 { 0.2 } else { -0.1 }))).collect();
    scene.walls = vec![
        side([4.0; 3], [0.0, 1.0, 0.0], vibration(Vector3::new(0.02, 0.05, 0.01), 3.0, 0.4)),
        side([4.0, 7.5, 4.0], [0.0, -1.0, 0.0], path(&lid)),
        side([4.0; 3], [1.0, 0.0, 0.0], PrescribedMotion::Translation { velocity: Vector3::new(-1e-6, 0.1, 0.0) }),
        side([7.5, 4.0, 4.0], [-1.0, 0.0, 0.0], vibration(Vector3::new(0.1, 0.0, 0.0), 0.7, 1.0)),
        side([4.0; 3], [0.0, 0.0, 1.0], vibration(Vector3::new(0.0, 0.0, 3e-4), 90.0, 0.0)),
        plane([4.0, 4.0, 7.5], [0.0, 0.0, -1.0], contact),
    ];
    let spots = (0..8).map(|k| {
        let along = |bit: i32| 4.8 + 1.7 * f64::from(k >> bit & 1);
        let speed = |bit: i32| 1.2 * f64::from(1 - 2 * (k >> bit & 1)) + 0.1 * f64::from(k);
        ([along(0), along(1), along(2)], [speed(0), speed(1), speed(2)])
    });
    let start = placed(&scene, &spots.collect::<Vec<_>>());
    (scene, start)
}

/// Runs until `impacts` impacts on moving walls have occurred. Checks after each window (piece of the run) that no
/// sphere is behind a wall.
fn bounce(name: &str, engine: Box<dyn Engine>, impacts: u64) {
    let (scene, start) = shaken(0.95, 0.0);
    let mut simulation = Simulation::with_engine(scene, start, engine);
    while simulation.record.walls.count < impacts {
        simulation.run(1, 0.3).unwrap_or_else(|why| panic!("{name}: {why}"));
        for wall in &simulation.scene().walls {
            for x in &simulation.particles.position {
                let gap = wall.geometry.nearest(x).distance - 0.5;
                // coordinates of 8 and times up to 1e5 are rounded by 1e-15 and 1e-11, at speeds of about 1
                assert!(gap > -1e-10, "{name} at {}: {gap:e} behind {:?}", simulation.time, wall.geometry);
            }
        }
    }
}

#[test]
fn no_touch_is_missed_in_a_hundred_thousand_impacts() {
    for (name, engine) in EXACT {
        bounce(name, engine(), 100_000);
    }
}

#[test]
#[ignore = "takes minutes"]
fn no_touch_is_missed_in_a_million_impacts() {
    for (name, engine) in EXACT {
        bounce(name, engine(), 1_000_000);
    }
}

#[test]
fn a_box_that_moves_with_its_spheres_is_a_box_at_rest() {
    // rounding of 1e-15 grows by about ten per collision of a sphere; each has about ten in the time of the run
    let engines = EXACT.iter().map(|engine| (engine, 1e-7)).chain(SOFT.iter().map(|engine| (engine, 1e-6)));
    for ((name, engine), tolerance) in engines {
        let (mut still, start) = shaken(0.9, 0.2);
        still.gravity = Vector3::new(0.0, -1.0, 0.2);
        for wall in &mut still.walls {
            *wall = plane(
                wall.geometry.plane().unwrap().point.into(),
                wall.geometry.plane().unwrap().normal.into(),
                wall.surface,
            );
        }
        let velocity = Vector3::new(0.3, -0.4, 0.1);
        let (mut moving, mut carried) = (still.clone(), start.clone());
        for wall in &mut moving.walls {
            *wall = wall.clone().moving(PrescribedMotion::Translation { velocity }).unwrap();
        }
        carried.velocity.iter_mut().for_each(|v| *v += velocity);
        let [first, second] =
            [(still, start), (moving, carried)].map(|(scene, start)| run(&scene, start, engine(), 3.0, 7));
        assert!(first.record.walls.count > 20 && first.record.pairs.count > 2, "{name}: {}", first.record.walls.count);
        assert_eq!(first.record.walls.count, second.record.walls.count, "{name}");
        for k in 0..8 {
            let apart = second.particles.position[k] - first.particles.position[k] - velocity * 3.0;
            let change = second.particles.velocity[k] - first.particles.velocity[k] - velocity;
            assert!(apart.norm() < tolerance && change.norm() < tolerance, "{name} {k}: {apart} {change}");
        }
        // the walls have given the momentum and the energy of the other frame
        let (ledger, other) = (&first.record.ledger, &second.record.ledger);
        let given = other.wall_work - ledger.wall_impulse.dot(&velocity) - ledger.wall_work;
        assert!(given.abs() < 100.0 * tolerance, "{name}: {given:e}");
    }
}

#[test]
fn a_sphere_at_rest_is_met_by_a_wall_from_afar() {
    // it never leaves the place for which its walls were found; the wall comes over four diameters at 0.5, and the sphere
    // leaves it at twice its velocity
    let away = Vector3::new(0.5, 0.0, 0.0);
    let motions = [
        PrescribedMotion::Translation { velocity: away },
        path(&[(1.0, Vector3::zeros()), (21.0, away * 20.0)]),
        vibration(Vector3::new(5.0, 0.0, 0.0), 0.1 / TAU, 0.0),
    ];
    for (name, engine) in EXACT.iter().chain(&SOFT).chain([&STEPPED]) {
        for motion in &motions {
            let mut scene = empty([40.0; 3], [false; 3], unit(), surface(1.0, 0.0));
            let wall = plane([14.0, 0.0, 0.0], [1.0, 0.0, 0.0], surface(1.0, 0.0));
            scene.walls = vec![wall.moving(motion.clone()).unwrap()];
            // a crowd at rest aside makes the calendar of all particles choose small shells
            let crowd = (0..64).map(|k| {
                [28.5 + 1.5 * f64::from(k / 16), 3.0 + 1.5 * f64::from(k / 4 % 4), 3.0 + 1.5 * f64::from(k % 4)]
            });
            let list: Vec<_> = std::iter::once([18.5, 20.0, 20.0]).chain(crowd).map(|x| (x, [0.0; 3])).collect();
            let start = placed(&scene, &list);
            let simulation = run(&scene, start, engine(), 24.0, 40);
            assert!(simulation.record.walls.count >= 1, "{name}: {motion:?}");
            // a vibrating wall is at its mean place after half a period, with its largest speed of 0.5
            if !matches!(motion, PrescribedMotion::Vibration { .. }) {
                let met = simulation.particles.id.iter().position(|id| *id == 0).unwrap();
                let speed = simulation.particles.velocity[met].x;
                assert!((speed - 1.0).abs() < 1e-3, "{name}: {speed}, {motion:?}");
            }
        }
    }
}

#[test]
fn the_books_close() {
    // hard spheres: rounding of the sums. Local steps of fourth order: (ω Δt)⁴ = 2e-5 of the energy of a contact. Steps of
    // second order, with friction of a step's delay: (ω Δt)² = 4e-3. Friction of rotating spheres changes its direction
    // within a step, which costs an order
    let engines = EXACT.iter().map(|engine| (engine, 1e-12));
    let engines = engines.chain([(&SOFT[0], 4e-3), (&SOFT[1], 4e-3), (&SOFT[2], 2e-5), (&SOFT[3], 2e-5)]);
    for ((name, engine), tolerance) in engines.chain([(&STEPPED, 1e-12)]) {
        for rotating in [false, true] {
            if rotating && *name == "uniform, Heun" {
                continue;
            }
            let (mut scene, start) = shaken(0.9, 0.3);
            scene.gravity = up(-1.0);
            if rotating {
                scene.rotation = Some(made_up_rotation());
            }
            let before = start.momentum();
            let mut simulation = Simulation::with_engine(scene, start, engine());
            let energy = simulation.energy();
            simulation.run(20, 0.25).unwrap_or_else(|why| panic!("{name}: {why}"));
            let ledger = simulation.record.ledger.clone();
            let residual = ledger.residual(energy, simulation.energy()) / ledger.through(energy);
            let tolerance = if rotating && tolerance > 1e-6 { 5.0 * tolerance } else { tolerance };
            assert!(residual.abs() < tolerance, "{name} {rotating}: {residual:e}");
            // the walls have done work that the balance needs
            assert!(ledger.wall_work.abs() > 0.05 * ledger.through(energy), "{name}: {}", ledger.wall_work);
            let given = simulation.particles.momentum() - before - ledger.wall_impulse - ledger.gravity_impulse;
            assert!(given.norm() < 1e-11, "{name} {rotating}: {given}");
        }
    }
}

/// Friction law of spheres that rotate, without a tangential spring.
fn made_up_rotation() -> diptych::rotation::Rotation {
    use diptych::rotation::{ImpactRule, Rotation, TangentialLaw};
    Rotation::new(TangentialLaw::Coulomb, ImpactRule::COULOMB)
}

#[test]
fn a_soft_ball_that_never_leaves_the_plate_is_a_forced_oscillator() {
    // relative to the plate x'' = -ω0² x - 2γ x' - g + A ω² sin(ωt + φ); after the transients the vibration has the
    // amplitude A ω²/|ω0² - ω² + 2iγω|. The contact lasts 0.0099 s and the period 0.05 s, so the factor over A ω²/ω0² is
    // 1.05. The dashpot of Verlet's steps has the velocity of half a step before, which adds γ Δt of the inertia: 2.9 % of a
    // share (ω/ω0)² = 0.16 of the forces, 4.6e-3. With the wall's velocity of the whole step it would be 2.9 %. Heun's method
    // has errors of (ω0 Δt)² = 4e-3, Runge-Kutta's (ω0 Δt)⁴ = 2e-5. The hybrid engine makes Verlet's steps here.
    let (frequency, gamma, e) = (20.0, 0.5, 0.2_f64);
    let omega = TAU * frequency;
    let amplitude = gamma / (omega * omega);
    let natural = STIFFNESS.sqrt();
    let damping = -e.ln() / (PI * PI + e.ln().powi(2)).sqrt() * natural;
    let (real, imaginary) = (natural * natural - omega * omega, 2.0 * damping * omega);
    let response = gamma / real.hypot(imaginary);
    let lag = imaginary.atan2(real);
    let rest = -1.0 / (natural * natural);
    for ((name, engine), tolerance) in SOFT.into_iter().zip([6e-3, 4e-3, 1e-4, 6e-3]) {
        let (scene, start) = above(&vibration(up(amplitude), frequency, 0.0), e, rest, 0.0);
        let mut simulation = Simulation::with_engine(scene.clone(), start, engine());
        simulation.run(40, 0.025 * (1.0 + 0.013)).unwrap();
        let mut worst: f64 = 0.0;
        for _ in 0..20 {
            simulation.run(1, 0.0071).unwrap();
            let angle = omega * simulation.time;
            let overlap = rest + response * (angle - lag).sin();
            let got = simulation.particles.position[0].y - 0.5 - PLATE - amplitude * angle.sin();
            worst = worst.max((got - overlap).abs() / response);
        }
        assert!(worst < tolerance, "{name}: {worst:e}");
    }
}

#[test]
fn a_stored_run_continues_with_the_same_bits() {
    for (name, engine) in EXACT.iter().chain(&SOFT).chain([&STEPPED]) {
        let (mut scene, start) = shaken(0.9, 0.3);
        scene.gravity = up(-1.0);
        let of = || Simulation::with_engine(scene.clone(), start.clone(), engine());
        let (mut whole, mut half) = (of(), of());
        whole.run(12, 0.11).unwrap();
        half.run(5, 0.11).unwrap();
        whole.particles.sort_by_id();
        let snapshot = half.snapshot().unwrap();
        let mut rest = of().resume(snapshot).unwrap();
        rest.run(7, 0.11).unwrap();
        rest.particles.sort_by_id();
        assert_eq!(whole.particles.position, rest.particles.position, "{name}");
        assert_eq!(whole.particles.velocity, rest.particles.velocity, "{name}");
    }
}

#[test]
fn balls_rest_on_a_vibrating_plate_with_a_contact_time_only() {
    // below g the plate never throws the balls off: a ball that loses energy comes to rest on it, after infinitely many
    // impacts in finite time
    let motion = vibration(up(0.5 / (TAU * TAU)), 1.0, 0.0);
    for (name, one) in [("one calendar", Hard::with_one_calendar as fn() -> Hard), ("islands", Hard::with_islands)] {
        // without any rebound the ball is held at rest, with the velocity of the plate
        for e in [0.4, 0.0] {
            let (scene, start) = above(&motion, e, 0.1, 0.0);
            let (_, stopped) = try_run(&scene, start.clone(), Box::new(one()), 10.0, 20);
            assert!(matches!(stopped, Err(Failure::InelasticCollapse { .. })), "{name}: {stopped:?}");
            // with a contact time t_c it hops by (g + a) t_c²/32 at most, 5e-8 here, with the plate
            let engine = Box::new(one().with_contact_time(Some(1e-3)));
            let mut simulation = Simulation::with_engine(scene.clone(), start, engine);
            let energy = simulation.energy();
            simulation.run(20, 0.5).unwrap();
            let plate = simulation.scene().walls[0].geometry.nearest(&simulation.particles.position[0]).distance;
            assert!((plate - 0.5).abs() < 1e-7, "{name}: {plate}");
            let velocity = motion.velocity(&Vector3::zeros(), simulation.time).y;
            assert!((simulation.particles.velocity[0].y - velocity).abs() < 1e-3, "{name}");
            let ledger = &simulation.record.ledger;
            let residual = ledger.residual(energy, simulation.energy());
            // 18,000 hops, each with some roundings of 1e-16
            assert!(residual.abs() < 1e-11 * ledger.through(energy), "{name}: {residual:e}");
        }
    }
}
