//! Bodies and meshes that move: times of touch against a search in small steps, and vibrating vessels against planes.
//! Bodies that turn about their own axis are compared with surfaces that turn. In a turning drum no touch may be
//! missed, and the ledger (energy and momentum balance) must close.

use crate::meshes::heaps::{Heap, block};
use crate::support::*;
use diptych::contact_law::ContactLaw;
use diptych::engine::Engine;
use diptych::engine::hard::Hard;
use diptych::engine::hybrid::Hybrid;
use diptych::experiment::Integrator;
use diptych::rotation::{ImpactRule, Rotation, TangentialLaw};
use diptych::simulation::Simulation;
use diptych::walls::{
    Cavity, Flight, Frustum, Hollow, Mesh, Obstacle, PiecewisePath, PrescribedMotion, RoundAxis, Sides, Turning, Wall,
    WallGeometry,
};
use diptych::{Particles, Scene, Vector3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;
use std::sync::Arc;

/// [N/m] stiffness of soft spheres of unit mass: a contact with a wall lasts π/sqrt(k) = 0.0099 s.
const STIFFNESS: f64 = 1e5;

/// [s] step of soft spheres, a fiftieth of a contact.
const STEP: f64 = 2e-4;

/// A name and a function that makes an engine.
type Maker = (&'static str, fn() -> Box<dyn Engine>);

/// Engines that find each collision of hard spheres at its exact instant.
const EXACT: [Maker; 2] = [("one calendar", || Box::new(Hard::with_one_calendar())), ("islands", islands)];

/// Engines in which contacts last for some time steps.
const SOFT: [Maker; 3] = [
    ("uniform", || soft(STIFFNESS, STEP, Integrator::VelocityVerlet)),
    ("local", || local(STIFFNESS, STEP, Integrator::VelocityVerlet)),
    ("hybrid", || Box::new(Hybrid::new(ContactLaw::linear(STIFFNESS), Integrator::VelocityVerlet, STEP, 2.0))),
];

fn vibration(amplitude: [f64; 3], frequency: f64) -> PrescribedMotion {
    PrescribedMotion::Vibration { amplitude: amplitude.into(), frequency, phase: 0.7 }
}

fn turning(center: Vector3<f64>, spin: [f64; 3]) -> PrescribedMotion {
    PrescribedMotion::Turning(Turning { center, spin: spin.into() })
}

fn mesh(heap: &Heap, sides: Sides) -> WallGeometry {
    WallGeometry::Mesh(Arc::new(Mesh::new("test", heap, Some(sides)).unwrap().0))
}

/// Bodies about the middle of a box with edges of 10 m, and vessels around this middle, with their names. The flag is
/// true for a vessel.
fn bodies() -> Vec<(&'static str, WallGeometry, bool)> {
    let middle = Vector3::repeat(5.0);
    let half = Vector3::new(1.2, 0.7, 0.4);
    let axle = RoundAxis { center: middle, axis: 2 };
    let cone = Frustum { axle, radii: [1.2, 0.5], half_height: 0.9, solid: true };
    let shell = Frustum { axle, radii: [1.1, 0.8], half_height: 0.9, solid: false };
    let wide = Vector3::repeat(2.5);
    let hollow = |cavity| WallGeometry::Hollow(Hollow::new(cavity));
    let closed = Frustum { axle, radii: [2.5, 2.0], half_height: 2.0, solid: true };
    vec![
        ("sphere", WallGeometry::Obstacle(Obstacle::sphere(middle + Vector3::x() * 0.3, 0.8)), false),
        ("block", WallGeometry::Obstacle(Obstacle::cuboid(middle, half)), false),
        ("cone", WallGeometry::Frustum(cone), false),
        ("shell", WallGeometry::Frustum(shell), false),
        ("mesh", mesh(&block(middle, half, 2), Sides::Outside), false),
        ("vessel", hollow(Cavity::Box { center: middle, half_extents: wide }), true),
        ("can", hollow(Cavity::ClosedCylinder(closed)), true),
        ("vessel of triangles", mesh(&block(middle, wide, 2), Sides::Inside), true),
    ]
}

/// First of 20,000 equally spaced times up to `until` at which a sphere on a flight overlaps a wall that moves; `None`
/// without an overlap.
fn by_steps(wall: &Wall, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
    const STEPS: usize = 20_000;
    let contacts = wall.geometry.contacts();
    let overlaps =
        |t: f64| (0..contacts).any(|which| wall.contact(which, &flight.position_at(t), radius, t).distance < radius);
    (1..=STEPS).map(|k| until * k as f64 / STEPS as f64).find(|&t| overlaps(t))
}

#[test]
fn the_time_of_touch_is_that_of_a_search_in_small_steps() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    let mut any = |half: f64| Vector3::from_fn(|_, _| half * (2.0 * random.random::<f64>() - 1.0));
    let (radius, until) = (0.3, 3.0);
    for (name, geometry, is_vessel) in bodies() {
        let mut touched = 0;
        for k in 0..80 {
            let motion = match k % 4 {
                0 => vibration(any(0.3).into(), 2.0),
                1 => turning(Vector3::repeat(5.0) + any(0.4), any(2.0).into()),
                2 => PrescribedMotion::Translation { velocity: any(0.5) },
                _ => {
                    let knots = [0.0, 0.2, 0.3, 3.0].map(|time| (time, any(0.5) * f64::min(time, 1.0)));
                    PrescribedMotion::Path(Arc::new(PiecewisePath::new(knots.to_vec()).unwrap()))
                }
            };
            let wall = Wall::new(geometry.clone(), surface(1.0, 0.0)).moving(motion.clone()).unwrap();
            let far = if is_vessel { 0.8 } else { 4.0 };
            let position = Vector3::repeat(5.0) + any(far);
            // towards the body
            let velocity = (Vector3::repeat(5.0) - position) * 0.5 + any(0.5);
            let flight = Flight { position, velocity, gravity: any(0.2) };
            // the sphere must not overlap at the start
            if wall.geometry.nearest(&position).distance < radius {
                continue;
            }
            let contacts = 0..wall.geometry.contacts();
            let touches = contacts.filter_map(|which| wall.first_touch(which, &flight, radius, (0.0, until)));
            let found = touches.map(|touch| touch.time).filter(|time| *time <= until).reduce(f64::min);
            // the test before the search finds it possible, also if the flight ends at the touch
            for duration in found.into_iter().flat_map(|time| [time, 1.5 * time, until]) {
                assert!(
                    wall.moving.as_ref().unwrap().may_reach(&flight, radius * (1.0 + 1e-9), duration),
                    "{name} {k}"
                );
            }
            // the steps are of 1.5e-4: they see a touch later by a step at most, and miss overlaps shorter than one
            match (found, by_steps(&wall, &flight, radius, until)) {
                (found, Some(seen)) => {
                    let found = found.unwrap_or_else(|| panic!("{name} {k}: missed {seen}, {motion:?} {flight:?}"));
                    assert!(found < seen + 1e-9, "{name} {k}: {found} after {seen}");
                    // at the touch the gap is zero, up to the share of the radius below which a sphere touches
                    let gaps = (0..wall.geometry.contacts())
                        .map(|which| wall.contact(which, &flight.position_at(found), radius, found).distance - radius);
                    let gap = gaps.fold(f64::INFINITY, f64::min);
                    assert!(gap.abs() < 1e-11, "{name} {k}: {gap:e} at {found}");
                    touched += 1;
                }
                (Some(found), None) => {
                    let gap = wall.contact(0, &flight.position_at(found), radius, found).distance - radius;
                    assert!(gap.abs() < 1e-11, "{name} {k}: {gap:e} at {found}");
                }
                (None, None) => {}
            }
        }
        assert!(touched > 5, "{name}: {touched}");
    }
}

/// Spheres in a cubic room with edges of 5 m, about the middle of a box with edges of 10 m, between the given walls.
fn room(walls: Vec<Wall>, friction: f64) -> (Scene, Particles) {
    let mut scene = empty([10.0; 3], [false; 3], unit(), surface(0.9, friction));
    scene.gravity = Vector3::new(0.0, -1.0, 0.1);
    scene.walls = walls;
    let spots = (0..8).map(|k| {
        let along = |bit: i32| 4.1 + 1.8 * f64::from(k >> bit & 1);
        ([along(0), along(1), along(2)], [0.3 * f64::from(k) - 1.0, 0.8, 1.0 - 0.2 * f64::from(k)])
    });
    let start = placed(&scene, &spots.collect::<Vec<_>>());
    (scene, start)
}

#[test]
fn a_vibrating_vessel_is_six_vibrating_planes() {
    // Planes have a search of their own. The other vessels find touches to 1e-12 radii; each sphere has some ten impacts,
    // each of which multiplies errors by about ten. Soft contacts have the same gaps up to rounding.
    let motion = vibration([0.1, 0.15, 0.05], 2.0);
    let (middle, half) = (Vector3::repeat(5.0), Vector3::repeat(2.5));
    let of = surface(0.8, 0.2);
    let vessels = [
        ("box", WallGeometry::Hollow(Hollow::new(Cavity::Box { center: middle, half_extents: half }))),
        ("mesh", mesh(&block(middle, half, 1), Sides::Inside)),
    ];
    for (name, engine) in EXACT.iter().chain(&SOFT) {
        // hybrid spheres have lasting contacts at a curved wall more often than at a plane
        if *name == "hybrid" {
            continue;
        }
        let mut planes = Vec::new();
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let normal = Vector3::ith(axis, -side);
                planes.push(plane((middle - normal * 2.5).into(), normal.into(), of).moving(motion.clone()).unwrap());
            }
        }
        let (scene, start) = room(planes, 0.2);
        let want = run(&scene, start.clone(), engine(), 4.0, 5);
        assert!(want.record.walls.count > 10, "{name}: {}", want.record.walls.count);
        for (shape, geometry) in &vessels {
            let vessel = Wall::new(geometry.clone(), of).moving(motion.clone()).unwrap();
            let (scene, start) = room(vec![vessel], 0.2);
            let got = run(&scene, start, engine(), 4.0, 5);
            assert_eq!(got.record.walls.count, want.record.walls.count, "{name}, {shape}");
            for k in 0..8 {
                let apart = (got.particles.position[k] - want.particles.position[k]).norm();
                assert!(apart < 1e-6, "{name}, {shape}, {k}: {apart:e}");
            }
        }
    }
}

#[test]
fn a_body_that_turns_about_its_own_axis_is_a_surface_that_turns() {
    // the shape of a ball or a cylinder does not change by the rotation, so that only friction tells of it
    let middle = Vector3::repeat(5.0);
    let spin = Vector3::new(0.0, 0.0, 3.0);
    let of = surface(0.8, 0.4);
    let turning = Turning { center: middle, spin };
    let shapes = [
        ("ball", WallGeometry::Obstacle(Obstacle::sphere(middle - Vector3::y() * 0.0, 0.8))),
        ("cylinder", WallGeometry::Obstacle(Obstacle::cylinder(middle, 2, 0.8, 1.0))),
    ];
    for (name, engine) in EXACT.iter().chain(&SOFT) {
        for (shape, geometry) in &shapes {
            let throw = |wall: Wall| {
                let mut scene = empty([10.0; 3], [false; 3], unit(), of);
                scene.gravity = Vector3::new(0.0, -1.0, 0.0);
                scene.rotation = Some(Rotation::new(TangentialLaw::Coulomb, ImpactRule::COULOMB));
                scene.walls = vec![wall];
                let start = placed(&scene, &[([5.1, 7.5, 5.2], [0.1, -0.5, 0.0]), ([7.0, 5.1, 4.9], [-1.5, 0.3, 0.1])]);
                run(&scene, start, engine(), 2.0, 5)
            };
            let still = Wall::new(geometry.clone(), of);
            let want = throw(Wall { turning: Some(turning), ..still.clone() });
            let got = throw(still.moving(PrescribedMotion::Turning(turning)).unwrap());
            assert!(want.record.walls.count >= 2, "{name}, {shape}");
            assert_eq!(got.record.walls.count, want.record.walls.count, "{name}, {shape}");
            for k in 0..2 {
                let apart = (got.particles.position[k] - want.particles.position[k]).norm();
                let spins = (got.particles.spins()[k] - want.particles.spins()[k]).norm();
                assert!(apart < 1e-8 && spins < 1e-7, "{name}, {shape}, {k}: {apart:e} {spins:e}");
            }
            let (work, known) = (got.record.ledger.wall_work, want.record.ledger.wall_work);
            assert!(known.abs() > 1e-2 && (work - known).abs() < 1e-7, "{name}, {shape}: {work} {known}");
        }
    }
}

/// Closed vessel of triangles in the shape of a drum along z, with the given number of flat sides. On every third side
/// it has a lifter (a blade that carries spheres upwards).
fn drum(center: Vector3<f64>, radius: f64, half: f64, sides: u32) -> Heap {
    let corner = |k: u32| {
        let lifted = if k.is_multiple_of(3) { 0.75 } else { 1.0 };
        let (sin, cos) = (TAU * f64::from(k) / f64::from(sides)).sin_cos();
        Vector3::new(cos, sin, 0.0) * (lifted * radius)
    };
    let (low, high) = (Vector3::z() * -half, Vector3::z() * half);
    let mut heap = Heap::new();
    for k in 0..sides {
        let (a, b) = (corner(k), corner((k + 1) % sides));
        heap.push([a + low, b + low, b + high]);
        heap.push([a + low, b + high, a + high]);
        heap.push([low, b + low, a + low]);
        heap.push([high, a + high, b + high]);
    }
    heap.iter().map(|corners| corners.map(|x| x + center)).collect()
}

/// Spheres in a drum with lifters (blades that carry spheres upwards). The drum turns with the angular velocity `spin`
/// [rad/s] about an axis beside its own axis.
fn in_a_drum(restitution: f64, friction: f64, spin: [f64; 3]) -> (Scene, Particles) {
    let middle = Vector3::repeat(5.0);
    let shape = mesh(&drum(middle, 3.5, 2.0, 12), Sides::Inside);
    let motion = turning(middle + Vector3::new(0.2, 0.1, 0.0), spin);
    room(vec![Wall::new(shape, surface(restitution, friction)).moving(motion).unwrap()], friction)
}

/// [rad/s] angular velocity of the drum in most tests, not quite along the axis of the drum.
const SPIN: [f64; 3] = [0.1, 0.0, 1.5];

/// Runs until `impacts` impacts on the drum have occurred. Checks after each window (piece of the run) that no sphere
/// is behind the wall of the drum.
fn tumble(name: &str, engine: Box<dyn Engine>, impacts: u64, spin: [f64; 3]) {
    let (drum, start) = in_a_drum(1.0, 0.0, spin);
    // with gravity or losses spheres would come to rest on the drum, which takes infinitely many impacts
    let mut scene = empty([10.0; 3], [false; 3], unit(), surface(1.0, 0.0));
    scene.walls = drum.walls;
    let mut simulation = Simulation::with_engine(scene, start, engine);
    while simulation.record.walls.count < impacts {
        simulation.run(1, 0.2).unwrap_or_else(|why| panic!("{name}, {spin:?}: {why}"));
        for x in &simulation.particles.position {
            let gap = simulation.scene().walls[0].geometry.nearest(x).distance - 0.5;
            // touches are found to 1e-12 radii; times up to 1e4 are rounded by 2e-12, at speeds of some units
            assert!(gap > -1e-9, "{name}, {spin:?} at {}: {gap:e}", simulation.time);
        }
    }
}

#[test]
fn no_touch_is_missed_in_a_turning_drum() {
    for (name, engine) in EXACT {
        tumble(name, engine(), 2_000, SPIN);
    }
}

#[test]
#[ignore = "takes minutes"]
fn no_touch_is_missed_in_a_million_impacts_on_turning_drums() {
    // a hundred runs, since elastic spheres become faster and faster in a drum that turns
    for k in 0..100 {
        for (name, engine) in EXACT {
            tumble(name, engine(), 10_000, [0.1, 0.02 * f64::from(k), 1.0 + 0.02 * f64::from(k)]);
        }
    }
}

#[test]
fn the_books_of_a_turning_drum_close() {
    // as in tests/moving_walls.rs; the normals of corners turn in a contact, which steps of second order resolve less well
    // hard spheres slide along the drum, which takes infinitely many impacts without a contact time
    let held: [Maker; 2] = [
        ("one calendar", || Box::new(Hard::with_one_calendar().with_contact_time(Some(1e-3)))),
        ("islands", || Box::new(Hard::with_islands().with_contact_time(Some(1e-3)))),
    ];
    let engines = held.iter().map(|engine| (engine, 1e-12));
    for ((name, engine), tolerance) in engines.chain([(&SOFT[0], 1e-2), (&SOFT[1], 5e-4), (&SOFT[2], 5e-4)]) {
        let (scene, start) = in_a_drum(0.8, 0.3, SPIN);
        let before = start.momentum();
        let mut simulation = Simulation::with_engine(scene, start, engine());
        let energy = simulation.energy();
        simulation.run(20, 0.2).unwrap_or_else(|why| panic!("{name}: {why}"));
        let ledger = simulation.record.ledger.clone();
        let residual = ledger.residual(energy, simulation.energy()) / ledger.through(energy);
        assert!(residual.abs() < tolerance, "{name}: {residual:e}");
        assert!(ledger.wall_work > 0.05 * ledger.through(energy), "{name}: {}", ledger.wall_work);
        let given = simulation.particles.momentum() - before - ledger.wall_impulse - ledger.gravity_impulse;
        assert!(given.norm() < 1e-11, "{name}: {given}");
    }
}

#[test]
fn a_body_and_its_images_move_together() {
    // a gas about a block that moves through a periodic box is the gas about a block at rest, seen from another frame
    let velocity = Vector3::new(0.7, 0.0, -0.4);
    let block = WallGeometry::Obstacle(Obstacle::cuboid(Vector3::new(3.0, 5.0, 3.0), Vector3::new(0.8, 0.9, 0.6)));
    let of = surface(0.9, 0.2);
    for (name, engine) in EXACT.iter().chain(&SOFT) {
        let throw = |moves: bool| {
            let mut scene = empty([10.0; 3], [true; 3], unit(), of);
            let wall = Wall::new(block.clone(), of);
            let motion = PrescribedMotion::Translation { velocity };
            scene.walls = vec![if moves { wall.moving(motion).unwrap() } else { wall }];
            let frame = if moves { velocity } else { Vector3::zeros() };
            let spots = (0..6).map(|k| {
                let at = Vector3::new(
                    1.0 + 1.6 * f64::from(k),
                    if k % 2 == 0 { 2.0 } else { 7.0 },
                    8.0 - 1.3 * f64::from(k),
                );
                let speed = (Vector3::new(3.0, 5.0, 3.0) - at) * 0.4 + frame;
                (at.into(), speed.into())
            });
            let start = placed(&scene, &spots.collect::<Vec<_>>());
            (scene.domain.clone(), run(&scene, start, engine(), 6.0, 30))
        };
        let ((domain, first), (_, second)) = (throw(false), throw(true));
        assert!(first.record.walls.count > 3, "{name}: {}", first.record.walls.count);
        assert_eq!(first.record.walls.count, second.record.walls.count, "{name}");
        for k in 0..6 {
            let there = domain.wrap(&(first.particles.position[k] + velocity * 6.0));
            let apart = domain.separation(&second.particles.position[k], &there).norm();
            assert!(apart < 1e-7, "{name} {k}: {apart:e}");
        }
    }
}
