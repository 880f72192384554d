//! Walls with a surface that turns in place: turntables, drums, spheres.

use super::*;
use diptych::walls::{Cavity, Hollow, Obstacle, RoundAxis, Turning, Wall, WallGeometry};

/// Engines for spheres of [`ball`], with the fraction of the energy that their ledger may leave unexplained.
fn engines() -> Vec<(&'static str, f64, Box<dyn Engine>)> {
    let step = contact_time(0.8) / 100.0;
    let hybrid = Hybrid::new(ContactLaw::linear(STIFFNESS), Integrator::VelocityVerlet, step, 2.0);
    vec![
        ("hard", 1e-10, Box::new(Hard::new())),
        ("hard with one calendar", 1e-10, Box::new(Hard::with_one_calendar())),
        ("stepped", 1e-10, Box::new(SteppedHard::new(0.1))),
        ("local", 1e-5, soft(0.8, 100.0, SoftStepping::Local)),
        ("uniform", 2e-2, soft(0.8, 100.0, SoftStepping::Uniform)),
        ("hybrid", 1e-5, Box::new(hybrid)),
    ]
}

/// A solid sphere that rolls on a turntable moves on circles with 2/7 of the rate of the table, for any position of
/// the axis. Friction gives a sphere of velocity v the acceleration dv/dt = (2/7) Ω × v, with the angular velocity Ω
/// of the table.
#[test]
fn a_ball_on_a_turntable_moves_on_circles() {
    let of = surface(0.5, 0.9);
    let (rate, radius, stiffness) = (12.0, 1e-3, 1e4);
    let species = Species { diameter: 2.0 * radius, density: 2500.0, ..small() };
    for stepping in [SoftStepping::Local, SoftStepping::Uniform] {
        let mut scene = empty([0.5; 3], [false; 3], species.clone(), of);
        let axis = Vector3::new(0.27, 0.0, 0.2);
        let spin = Vector3::y() * rate;
        let table = plane([axis.x, 0.0, axis.z], [0.0, 1.0, 0.0], of);
        scene.walls = vec![Wall { turning: Some(Turning { center: axis, spin }), ..table }];
        scene.gravity = Vector3::new(0.0, -9.81, 0.0);
        let tangential = TangentialLaw::Linear(LinearTangential::Ratios { stiffness: 0.8, dashpot: 0.5 });
        scene.rotation = Some(Rotation::new(tangential, ImpactRule::COULOMB));
        let sunk = species.mass() * 9.81 / stiffness;
        let start = Vector3::new(0.25, radius - sunk, 0.25);
        let velocity = Vector3::new(0.08, 0.0, 0.02);
        let mut particles = placed(&scene, &[([start.x, start.y, start.z], [velocity.x, 0.0, velocity.z])]);
        scene.let_rotate(&mut particles);
        // without slip, R ω × n is the velocity relative to the table
        let slip = velocity - spin.cross(&(start - axis));
        particles.spin.as_mut().unwrap()[0] = Vector3::y().cross(&slip) / radius;
        let law = ContactLaw::linear(stiffness);
        let step = law.contact_time(&law.between(&Bodies::of_wall(&species, &of, None)), 1.0) / 40.0;
        let engine = Soft::new(law, Integrator::VelocityVerlet, step, stepping);
        let mut simulation = Simulation::with_engine(scene, particles, Box::new(engine));
        let energy = simulation.energy() + 0.5 * stiffness * sunk * sunk;
        let time = 0.2;
        simulation.run(100, time / 100.0).unwrap();
        let turn = 2.0 / 7.0 * rate * time;
        let (sin, cos) = turn.sin_cos();
        let turned = |v: Vector3<f64>| Vector3::new(v.x * cos + v.z * sin, 0.0, v.z * cos - v.x * sin);
        let along = simulation.particles.velocity[0];
        let off = (along - turned(velocity)).norm() / velocity.norm();
        assert!(off < 2e-3, "{stepping:?}: {along} for {}, {off:.1e}", turned(velocity));
        // the circle: x - x_0 is (v' - v), turned by 90 degrees, over the rate
        let change = (turned(velocity) - velocity) / (2.0 / 7.0 * rate);
        let place = start + Vector3::new(-change.z, 0.0, change.x);
        let missed = (simulation.particles.position[0] - place).norm();
        assert!(missed < 2e-3 * velocity.norm() * time, "{stepping:?}: {missed:.1e}");
        let ledger = &simulation.record.ledger;
        let residual = ledger.residual(energy, simulation.energy());
        assert!(ledger.wall_work.abs() > 1e-2 * energy, "{stepping:?}: the table does no work");
        assert!(residual.abs() < 1e-3 * energy, "{stepping:?}: {residual:.1e} of {energy:.1e}");
    }
}

/// Surfaces with the same velocity at the point of impact: a belt, a turntable with a distant axis, and the sides of a
/// drum and of a ball so large that they are practically flat.
fn walls_like_a_belt(of: diptych::Surface, at: Vector3<f64>, velocity: Vector3<f64>) -> [Wall; 4] {
    let far = 1e3;
    let belt = Wall { velocity, ..plane([0.0; 3], [0.0, 1.0, 0.0], of) };
    let turning = |center: Vector3<f64>| {
        let arm = at - center;
        Some(Turning { center, spin: arm.cross(&velocity) / arm.norm_squared() })
    };
    let table = Wall { velocity: Vector3::zeros(), turning: turning(at + Vector3::z() * far), ..belt.clone() };
    // the axis is along z, and the surface moves along x
    let center = at + Vector3::y() * far;
    let pipe = Cavity::Pipe { axle: RoundAxis { center, axis: 2 }, radius: far };
    let drum = Wall { geometry: WallGeometry::Hollow(Hollow::new(pipe)), turning: turning(center), ..table.clone() };
    let center = at - Vector3::y() * far;
    let geometry = WallGeometry::Obstacle(Obstacle::sphere(center, far));
    let globe = Wall { geometry, turning: turning(center), ..table.clone() };
    [belt, table, drum, globe]
}

/// An impact depends only on the velocity of the surface at the contact, in every engine, with and without rotation.
#[test]
fn an_impact_on_a_turning_wall_is_one_on_a_belt() {
    for rotates in [true, false] {
        let of = surface(W3.restitution, W3.friction);
        let velocity = Vector3::new(2.0, 0.0, 0.0);
        for count in 0..engines().len() {
            let mut ends: Vec<[f64; 5]> = Vec::new();
            for wall in walls_like_a_belt(of, Vector3::new(0.05, 0.0, 0.05), velocity) {
                let (name, closes, engine) = engines().swap_remove(count);
                let (mut scene, mut particles) = thrown(&W3, W3.walton(), (30.0, 0.3));
                if !rotates {
                    (scene.rotation, particles.spin, particles.inertia) = (None, None, None);
                }
                scene.walls = vec![wall];
                let mut simulation = Simulation::with_engine(scene, particles, engine);
                let energy = simulation.energy();
                simulation.run(20, 1e-5).unwrap();
                let ledger = &simulation.record.ledger;
                let residual = ledger.residual(energy, simulation.energy());
                let through = ledger.through(energy);
                assert!(residual.abs() < closes * through, "{name}: {residual:.1e} of {through:.1e}");
                assert!(ledger.wall_work > 1e-2 * energy, "{name}: the wall does no work");
                let spin = simulation.particles.spin.as_ref().map_or(0.0, |spins| spins[0].z * RADIUS);
                let v = simulation.particles.velocity[0];
                ends.push([v.x, v.y, v.z, spin, ledger.wall_work / energy]);
            }
            for end in &ends {
                let off = end.iter().zip(&ends[0]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 1e-4, "engine {count}, rotates {rotates}: {ends:?}");
            }
        }
    }
}

/// Spheres in a turning drum that contains a turning ball. The ledger (sums of all gains and losses) explains energy
/// and momentum in every engine.
#[test]
fn the_balance_of_a_turning_drum_closes() {
    let of = surface(W3.restitution, W3.friction);
    for (name, closes, engine) in engines() {
        let mut scene = empty([0.06; 3], [false; 3], ball(), of);
        let center = Vector3::repeat(0.03);
        let axle = RoundAxis { center, axis: 2 };
        let can = Cavity::ClosedCylinder(diptych::walls::Frustum {
            axle,
            radii: [0.028; 2],
            half_height: 0.028,
            solid: true,
        });
        let drum = Wall::new(WallGeometry::Hollow(Hollow::new(can)), of);
        let globe = Wall::new(WallGeometry::Obstacle(Obstacle::sphere(center, 5e-3)), of);
        let turning = |spin| Some(Turning { center, spin });
        scene.walls = vec![
            Wall { turning: turning(Vector3::z() * 60.0), ..drum },
            Wall { turning: turning(Vector3::new(300.0, -200.0, 100.0)), ..globe },
        ];
        scene.gravity = Vector3::new(0.0, -9.81, 0.0);
        scene.rotation = Some(Rotation::new(W3.tangential(), W3.of_spring()));
        let places: Vec<([f64; 3], [f64; 3])> = (0..24)
            .map(|k| {
                let (x, z) = (f64::from(k % 6), f64::from(k / 6));
                ([0.016 + 0.0056 * x, 0.042, 0.02 + 0.0056 * z], [0.3 * (x - 2.0), -0.5 - 0.1 * z, 0.2 * (1.5 - z)])
            })
            .collect();
        let mut particles = placed(&scene, &places);
        scene.let_rotate(&mut particles);
        let mut simulation = Simulation::with_engine(scene, particles, engine);
        let (energy, momentum) = (simulation.energy(), simulation.particles.momentum());
        simulation.run(50, 1e-3).unwrap();
        let ledger = &simulation.record.ledger;
        let through = ledger.through(energy);
        let residual = ledger.residual(energy, simulation.energy());
        assert!(simulation.record.walls.count > 10, "{name}: {}", simulation.record.walls.count);
        assert!(residual.abs() < closes * through, "{name}: {residual:.1e} of {through:.1e}");
        assert!(ledger.wall_work.abs() > 1e-3 * energy, "{name}");
        let drift = simulation.particles.momentum() - momentum - ledger.gravity_impulse - ledger.wall_impulse;
        assert!(drift.norm() < 1e-10 * ledger.wall_normal_impulse, "{name}: {drift}");
    }
}

/// A ball lies on the axis of a turntable. Its twisting spring turns the ball with the table, and the work is that of
/// the table.
#[test]
fn a_turntable_turns_the_ball_on_its_axis() {
    for stepping in [SoftStepping::Local, SoftStepping::Uniform] {
        let law = RollingLaw::Spring { friction: 0.05, stiffness: None, damping: 0.3 };
        let mut floor = rolling::OnFloor::new(law, stepping);
        (floor.stiffness, floor.twisting) = (1000.0, Some(TwistingLaw { damping: 0.3 }));
        let mut still = floor.simulation(0.0, Vector3::y() * -50.0, 30.0);
        let turning = Some(Turning { center: Vector3::new(0.1, 0.0, 0.1), spin: Vector3::y() * 50.0 });
        let mut turned = floor.turned(turning, 30.0);
        let energies = [still.energy(), turned.energy()];
        for simulation in [&mut still, &mut turned] {
            simulation.run(50, 2e-4).unwrap();
        }
        let [slowed, driven] = [&still, &turned].map(|simulation| simulation.particles.spin_of(0).y);
        assert!((driven - (slowed + 50.0)).abs() < 1e-6, "{stepping:?}: {driven} and {slowed}");
        assert!(driven > 0.1, "{stepping:?}: {driven}");
        let gained = turned.energy() - energies[1];
        let ledger = &turned.record.ledger;
        let sunk = turned.particles.mass[0] * 9.81 / 1000.0;
        let residual = ledger.residual(energies[1] + 500.0 * sunk * sunk, turned.energy());
        assert!(ledger.wall_work > gained.abs() * 0.5, "{stepping:?}: {:e} {gained:e}", ledger.wall_work);
        assert!(residual.abs() < 1e-2 * ledger.wall_work, "{stepping:?}: {residual:e} of {:e}", ledger.wall_work);
    }
}

/// A wall can turn only about an axis of symmetry of its shape.
#[test]
fn only_round_shapes_turn_in_their_place() {
    let center = Vector3::new(0.3, 0.4, 0.5);
    let about = |center: Vector3<f64>, axis: Vector3<f64>| Turning { center, spin: axis * 7.0 };
    let shapes = [
        (WallGeometry::Obstacle(Obstacle::cylinder(center, 2, 0.1, 0.2)), [true, false, false]),
        (WallGeometry::Obstacle(Obstacle::sphere(center, 0.1)), [true, true, false]),
        (WallGeometry::Obstacle(Obstacle::cuboid(center, Vector3::repeat(0.1))), [false; 3]),
        (plane([0.0; 3], [0.0, 0.0, 1.0], surface(1.0, 0.0)).geometry, [true, false, true]),
    ];
    for (shape, expected) in shapes {
        let cases = [
            about(center + Vector3::z(), Vector3::z()),
            about(center, Vector3::x()),
            about(center + Vector3::x(), Vector3::z()),
        ];
        let found = cases.map(|turning| shape.law().turns(&turning));
        assert_eq!(found, expected, "{shape:?}");
    }
}

/// The output of `check` contains the motion of the surfaces of walls.
#[test]
fn check_names_the_motion_of_walls() {
    let said = |case: &str, sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|set| format!("--set={set}")).collect();
        let arguments: Vec<&str> = ["check", case].into_iter().chain(sets.iter().map(String::as_str)).collect();
        words(&diptych(&arguments).output().unwrap().stdout)
    };
    let belt = said("cases/walls/sheared-cell.toml", &[]);
    assert!(belt.contains("friction 0.3, its surface moves at (0, 0, -1) m/s."), "{belt}");
    let drum = said("cases/walls/pipe.toml", &["walls[0].rotation.rate=3 rad/s"]);
    assert!(drum.contains(", its surface turns at (0, 0, 3) rad/s."), "{drum}");
}
