//! Walls other than planes along an axis: bodies of the library parry, and tilted planes.

use crate::support::*;
use diptych::case::Case;
use diptych::engine::Engine;
use diptych::engine::hard::Hard;
use diptych::experiment::Integrator;
use diptych::scene::{Scene, Species};
use diptych::simulation::Simulation;
use diptych::walls::{
    Flight, Frustum, Geometry, NearWalls, Nearest, Obstacle, Repeated, RoundAxis, Wall, WallGeometry,
};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::PI;
use std::path::Path;

/// Scene with an obstacle in a wide box. The surface of the obstacle is frictionless and has the restitution e.
fn obstacle(obstacle: Obstacle, e: f64) -> Scene {
    let mut scene = empty([20.0; 3], [false; 3], unit(), surface(1.0, 0.0));
    scene.walls = vec![Wall::new(WallGeometry::Obstacle(obstacle), surface(e, 0.0))];
    scene
}

#[test]
fn bounces_off_bodies() {
    // v' = v - (1+e)(v.n) n at the point of touch; v is 1 against the normal, and 0.2 along the surface
    let e = 0.8;
    for (body, touch, n, curvature) in touches() {
        let scene = obstacle(body, e);
        let across = if n.x.abs() < 0.9 { Vector3::x() } else { Vector3::z() };
        let across = (across - n * n.dot(&across)).normalize();
        // at t = 1 the sphere of radius 1/2 touches the body at this point
        let v = -1.0 * n + 0.2 * across;
        let start = touch + 0.5 * n - v;
        let want = v - (1.0 + e) * v.dot(&n) * n;
        let check = |what: &str, engine: Box<dyn Engine>, windows: u64, tolerance: f64| {
            let end = run(&scene, placed(&scene, &[(start.into(), v.into())]), engine, 2.0, windows);
            assert_eq!(end.record.walls.count, 1, "{what} {scene:?}");
            let off = (end.particles.velocity[0] - want).norm();
            println!("{what}, curvature {curvature}: {off:.1e} of {tolerance:.1e}");
            assert!(off < tolerance, "{what} {:?}: {off:.1e}, allowed {tolerance:.1e}", scene.walls[0]);
            let impulse = end.record.ledger.wall_impulse;
            assert!((impulse - (end.particles.velocity[0] - v) * end.particles.mass[0]).norm() < 1e-12);
            end.particles.position[0]
        };
        for windows in [1, 7] {
            // Rounding errors: 10 ε for positions of about 10; this error over the radius of curvature for a normal;
            // (1+e) times the error of the normal for the speed. There are about ten operations.
            let rounding = 10.0 * 10.0 * f64::EPSILON * (1.0 + (1.0 + e) * curvature);
            let place = check("hard", hard(), windows, rounding);
            assert!((place - (touch + 0.5 * n + want)).norm() < 2.0 * rounding);
        }
        // Soft spheres: during a contact the normal turns by the path along the surface over the radius of curvature.
        // The change of velocity turns by at most the same angle, and lengthens the path by as much. With ω_0 Δt = x,
        // uniform stepping detects the beginning up to a step late, which adds x² to the energy. It also detects the
        // end late, and until then the dashpot force pulls at a rate of 2 γ. Local stepping has the error x⁴/120 π.
        let (law, steps) = (LinearSpring { stiffness: 1e4 }, 200.0);
        let (contact, verlet) = (law.contact_time(1.0, e), Integrator::VelocityVerlet);
        let dt = contact / steps;
        let x = law.angular_frequency(1.0) * dt;
        let turned = (0.2 + (1.0 + e) * 0.2 * contact * curvature) * contact * curvature;
        check("uniform", soft(1e4, dt, verlet), 7, (1.0 + e) * turned + x * x + 2.0 * law.damping(1.0, e) * dt);
        check("local", local(1e4, dt, verlet), 7, (1.0 + e) * turned + PI * x.powi(4) / 120.0);
    }
}

/// Bodies, each with a point at which a sphere of radius 1/2 may touch it, the normal there, and the largest curvature
/// [1/m] of the surface of possible centres of the sphere. The points are on the face, edge and corner of a box, and on
/// the side and cap of a cylinder along each axis.
fn touches() -> Vec<(Obstacle, Vector3<f64>, Vector3<f64>, f64)> {
    let centre = Vector3::new(10.0, 10.0, 10.0);
    let unit_of = |x: f64, y: f64, z: f64| Vector3::new(x, y, z).normalize();
    let n = unit_of(1.0, 2.0, -0.5);
    let half = Vector3::new(1.0, 2.0, 3.0);
    let cuboid = || Obstacle::cuboid(centre, half);
    let mut touches = vec![
        (Obstacle::sphere(centre, 2.0), centre + 2.0 * n, n, 1.0 / 2.5),
        (cuboid(), centre + Vector3::new(1.0, 0.4, -0.7), Vector3::x(), 0.0),
        (cuboid(), centre + Vector3::new(0.3, -2.0, -0.7), -Vector3::y(), 0.0),
        (cuboid(), centre + Vector3::new(1.0, 2.0, 0.5), unit_of(1.0, 0.6, 0.0), 1.0 / 0.5),
        (cuboid(), centre + half, unit_of(1.0, 0.6, 0.8), 1.0 / 0.5),
    ];
    for axis in 0..3 {
        let along = Vector3::from_fn(|k, _| if k == axis { 1.0 } else { 0.0 });
        let side = Vector3::from_fn(|k, _| if k == axis { 0.0 } else { 0.6 + 0.2 * k as f64 }).normalize();
        let cylinder = || Obstacle::cylinder(centre, axis, 1.5, 2.5);
        touches.push((cylinder(), centre + 1.5 * side + 0.9 * along, side, 1.0 / 2.0));
        touches.push((cylinder(), centre + 0.7 * side + 2.5 * along, along, 0.0));
    }
    touches
}

#[test]
fn a_gas_around_a_body_stays_outside_and_keeps_its_energy() {
    let mut scene = empty([8.0; 3], [true; 3], unit(), surface(1.0, 0.0));
    scene.walls = vec![Wall::new(
        WallGeometry::Obstacle(Obstacle::cuboid(Vector3::repeat(4.0), Vector3::new(1.0, 0.8, 1.2))),
        surface(1.0, 0.0),
    )];
    let start = random(&scene, 80, 1.0, 12);
    let energy = start.kinetic_energy();
    let mut simulation = Simulation::with_engine(scene.clone(), start, hard());
    for _ in 0..50 {
        simulation.run(1, 1.5).unwrap();
        for (x, r) in simulation.particles.position.iter().zip(&simulation.particles.radius) {
            let gap = scene.walls[0].geometry.law().nearest(&scene.domain.wrap(x)).distance - r;
            assert!(gap > -1e-12, "{gap:.1e} inside the body");
        }
        assert!(smallest_gap(&scene, &simulation.particles) > -1e-12);
    }
    close("energy", simulation.particles.kinetic_energy() / energy, 1.0, 1e-12);
    assert!(simulation.record.walls.count > 150, "{}", simulation.record.walls.count);
}

#[test]
fn a_tilted_plane_is_a_plane() {
    // the closed-form solution in the frame of the plane, with gravity; for both engines, and for both steppings of
    // soft spheres
    let n = Vector3::new(0.3, 1.0, -0.2).normalize();
    let point = Vector3::new(10.0, 5.0, 10.0);
    let (e, mu) = (0.7, 0.1);
    let mut scene = empty([20.0; 3], [false; 3], unit(), surface(1.0, 0.0));
    scene.gravity = Vector3::new(0.0, -1.0, 0.0);
    scene.walls = vec![plane(point.into(), n.into(), surface(e, mu))];
    let v = Vector3::new(1.0, 0.0, 0.5);
    let start = point + 1.5 * n;
    // the gap over time is 1 + (v.n) t + (g.n) t²/2
    let (b, a) = (v.dot(&n), scene.gravity.dot(&n));
    let t = (b + (b * b - 2.0 * a).sqrt()) / -a;
    let before = v + scene.gravity * t;
    let along = before.dot(&n);
    let slip = before - n * along;
    let want = slip * (1.0 - mu * (1.0 + e) * along.abs() / slip.norm()) - n * (e * along) + scene.gravity * 0.1;
    let (law, verlet) = (LinearSpring { stiffness: 1e6 }, Integrator::VelocityVerlet);
    let contact = law.contact_time(1.0, e);
    let dt = contact / 400.0;
    // Errors of the normal impulse (1+e) u: gravity acts during the contact, and the beginning and the end are detected
    // late as in `bounces_off_bodies`. Friction is proportional to the normal force at every instant, and adds the
    // fraction μ of these errors.
    let (u, x) = (along.abs(), law.angular_frequency(1.0) * dt);
    let local_error = 2.0 * contact + PI * x.powi(4) / 120.0 * u;
    let uniform_error = local_error + (x * x + 2.0 * law.damping(1.0, e) * dt) * u;
    for (engine, tolerance) in [
        (hard(), 1e-12),
        (soft(1e6, dt, verlet), (1.0 + mu) * uniform_error),
        (local(1e6, dt, verlet), (1.0 + mu) * local_error),
    ] {
        let end = run(&scene, placed(&scene, &[(start.into(), v.into())]), engine, t + 0.1, 4);
        assert_eq!(end.record.walls.count, 1);
        let off = (end.particles.velocity[0] - want).norm();
        println!("{off:.1e} of {tolerance:.1e}");
        assert!(off < tolerance, "{off:.1e}, allowed {tolerance:.1e}");
    }
}

#[test]
fn the_middle_of_a_body_is_as_deep_as_it_gets() {
    let centre = Vector3::zeros();
    let bodies = [
        (Obstacle::sphere(centre, 2.0), 2.0),
        (Obstacle::cuboid(centre, Vector3::new(1.0, 2.0, 3.0)), 1.0),
        (Obstacle::cylinder(centre, 1, 1.5, 2.5), 1.5),
        (Obstacle::cylinder(centre, 2, 1.5, 2.5), 1.5),
    ];
    for (body, depth) in bodies {
        // the exact middle of the body, and points so near it that squares of the distance underflow
        for off in [0.0, 1e-300, 1e-170, 1e-9] {
            let nearest = body.nearest(&(centre + Vector3::new(0.0, off, 0.0)));
            close(&format!("{body:?}"), nearest.distance, -depth, 2e-9);
            close("normal", nearest.normal.norm(), 1.0, 1e-12);
        }
    }
}

#[test]
fn spheres_in_the_middle_of_a_body_are_refused() {
    let bodies = [
        "sphere = { center = CENTRE, radius = \"0.7 mm\" }",
        "cuboid = { center = CENTRE, half_extents = [\"0.7 mm\", \"0.5 mm\", \"0.6 mm\"] }",
        "cylinder = { center = CENTRE, axis = \"z\", radius = \"0.7 mm\", half_height = \"0.6 mm\" }",
    ];
    for body in bodies {
        let case = format!(
            "[domain]\nsize = [\"6 mm\", \"4 mm\", \"6 mm\"]\n[[particles]]\ndiameter = \"0.4 mm\"\ndensity = 1000\n\
             at = [{{ position = CENTRE }}]\n[[walls]]\n{body}\nrestitution = 0.9\n[run]\nmodel = \"hard\"\nduration = \"5 ms\"\n"
        );
        let text = case.replace("CENTRE", "[\"3 mm\", \"2 mm\", \"3 mm\"]");
        let case = Case::from_text(Path::new("case.toml"), text.into(), &[]);
        let refused = case.and_then(|case| case.experiment(None, None)).unwrap_err().to_string();
        assert!(refused.contains("m from walls[0]; allowed: at least its radius"), "{refused}");
    }
}

/// A sphere flies back and forth between a body and the periodic image of the body. Windows (pieces of the run) are
/// longer or shorter than this path, and the parts into which a solver divides a window begin on either side.
#[test]
fn bodies_stand_again_across_periodic_sides() {
    let ball = Species { name: "ball".into(), diameter: 0.2, ..unit() };
    let centre = Vector3::new(8.5, 2.0, 2.0);
    let cone =
        Frustum { axle: RoundAxis { center: centre, axis: 2 }, radii: [0.5, 0.5], half_height: 0.7, solid: true };
    let bodies = [
        WallGeometry::Obstacle(Obstacle::sphere(centre, 0.5)),
        WallGeometry::Obstacle(Obstacle::cuboid(centre, Vector3::new(0.5, 0.7, 0.8))),
        WallGeometry::Obstacle(Obstacle::cylinder(centre, 2, 0.5, 0.9)),
        WallGeometry::Frustum(cone),
    ];
    let (stiffness, step) = (8e4, 2e-5); // a contact lasts 1e-3
    for body in bodies {
        let mut scene = empty([10.0, 4.0, 4.0], [true; 3], ball.clone(), surface(1.0, 0.0));
        scene.walls = vec![Wall::new(body, surface(1.0, 0.0))];
        for windows in [1, 4, 15, 31, 300] {
            let soft_uniform = soft(stiffness, step, Integrator::VelocityVerlet);
            let soft_local = local(stiffness, step, Integrator::VelocityVerlet);
            for (name, engine) in
                [("hard", hard()), ("islands", islands()), ("uniform", soft_uniform), ("local", soft_local)]
            {
                // first 1.9 to the image on the left, then 8.8 between touches: the fourth touch is after 28.3
                let start = placed(&scene, &[([1.0, 2.0, 2.0], [-10.0, 0.0, 0.0])]);
                let what = format!("{:?}, {name}, {windows} windows", scene.walls[0].geometry);
                let (simulation, result) = try_run(&scene, start, engine, 3.0, windows);
                assert!(result.is_ok(), "{what}: {result:?}");
                assert_eq!(simulation.record.walls.count, 4, "{what}");
                let v = simulation.particles.velocity[0].x;
                close(&what, v, -10.0, if name == "uniform" { 0.05 } else { 1e-2 });
            }
        }
    }
}

/// A body may lie across a periodic side or a corner of the box. The motion around it is then the shifted motion around
/// a body in the middle.
#[test]
fn a_body_in_a_periodic_side_is_a_body_in_the_middle() {
    let size = 6.0;
    let scene_with = |centre: Vector3<f64>, body: usize| {
        let shape = match body {
            0 => WallGeometry::Obstacle(Obstacle::sphere(centre, 1.5)),
            1 => WallGeometry::Obstacle(Obstacle::cuboid(centre, Vector3::new(1.0, 1.5, 2.2))),
            _ => {
                // the body is wider at one end: of two images at equal distances of their centres, the one whose wider
                // end is nearer has the nearer surface
                let axle = RoundAxis { center: centre, axis: 0 };
                WallGeometry::Frustum(Frustum { axle, radii: [1.8, 0.3], half_height: 2.2, solid: true })
            }
        };
        let mut scene = empty([size; 3], [true; 3], unit(), surface(1.0, 0.0));
        scene.walls = vec![Wall::new(shape, surface(1.0, 0.0))];
        scene
    };
    let middle = Vector3::repeat(0.5 * size);
    for body in 0..3 {
        for centre in [Vector3::new(0.0, 2.0, 3.0), Vector3::new(0.4, 5.9, 0.0)] {
            let (there, here) = (scene_with(centre, body), scene_with(middle, body));
            // a random start, which must avoid the images of the body too
            let start = random(&there, 24, 1.0, 3);
            let seen = Repeated::all(&there.walls, &there.domain);
            for x in &start.position {
                assert!(seen[0].geometry.nearest(x).distance > 0.5, "{body}: a sphere starts in the body");
            }
            let mut moved = start.clone();
            for x in &mut moved.position {
                *x = here.domain.wrap(&(*x - centre + middle));
            }
            let step = 5e-4;
            let engines: [fn(f64) -> Box<dyn Engine>; 4] = [
                |_| hard(),
                |_| islands(),
                |step| soft(1e4, step, Integrator::VelocityVerlet),
                |step| local(1e4, step, Integrator::VelocityVerlet),
            ];
            for (number, engine) in engines.into_iter().enumerate() {
                let want = run(&here, moved.clone(), engine(step), 2.0, 5);
                let found = run(&there, start.clone(), engine(step), 2.0, 5);
                assert!(want.record.walls.count > 2, "{}", want.record.walls.count);
                let counts = |simulation: &Simulation| [simulation.record.walls.count, simulation.record.pairs.count];
                assert_eq!(counts(&found), counts(&want), "{body}, {number}");
                for (x, y) in found.particles.position.iter().zip(&want.particles.position) {
                    let off = here.domain.separation(&here.domain.wrap(&(x - centre + middle)), &here.domain.wrap(y));
                    // rounding errors, amplified by about ten impacts of each sphere
                    assert!(off.norm() < 1e-6, "{body}, {number}: {:e}", off.norm());
                }
            }
        }
    }
}

/// An [`Obstacle`] that does not tell its bounds (a box that contains it), so that engines compute its distance for
/// every position.
#[derive(Debug)]
struct Unbound(Obstacle);

impl Geometry for Unbound {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        self.0.nearest(point)
    }

    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        self.0.touch_time(flight, radius, until)
    }
}

/// Spheres that fall among pins. A tree of bounds selects the pins whose distance is computed. Start and run must have
/// the same bits as with the distances to all pins.
#[test]
fn what_is_found_in_a_tree_of_walls_is_what_all_walls_say() {
    let scene_of = |pin: fn(Obstacle) -> WallGeometry| {
        let mut scene = empty([12.0; 3], [false; 3], unit(), surface(0.9, 0.1));
        scene.gravity = Vector3::new(0.0, 0.0, -1.0);
        for k in 0..48u32 {
            let at = |k: u32| 1.5 + 3.0 * f64::from(k);
            let centre = Vector3::new(at(k % 4), at(k / 4 % 4), at(k / 16) + 1.0);
            // a block fills its whole box of bounds in the tree
            let body = if k % 2 == 0 {
                Obstacle::sphere(centre, 0.6)
            } else {
                Obstacle::cuboid(centre, Vector3::new(0.6, 0.4, 0.5))
            };
            scene.walls.push(Wall::new(pin(body), surface(0.9, 0.1)));
        }
        for axis in 0..3 {
            let mut normal = [0.0; 3];
            normal[axis] = 1.0;
            scene.walls.push(plane([0.0; 3], normal, surface(0.9, 0.1)));
            scene.walls.push(plane([12.0; 3], normal.map(|n| -n), surface(0.9, 0.1)));
        }
        scene
    };
    let boxed = scene_of(WallGeometry::Obstacle);
    let asked = scene_of(|pin| WallGeometry::Other(std::sync::Arc::new(Unbound(pin))));
    assert!(!NearWalls::of(&boxed.walls).are_few() && NearWalls::of(&asked.walls).are_few());
    let engines: [fn() -> Box<dyn Engine>; 3] = [
        || Box::new(Hard::with_one_calendar()),
        || soft(1e4, 1e-3, Integrator::VelocityVerlet),
        || soft(1e4, 1e-3, Integrator::Rk2),
    ];
    for count in [120, 700] {
        // few spheres are placed again until they do not overlap; many spheres are pushed apart
        let starts = [&boxed, &asked].map(|scene| random(scene, count, 1.0, 5));
        assert!(starts[0].position == starts[1].position, "{count}");
        let [start, _] = starts;
        for (number, engine) in engines.into_iter().enumerate() {
            let [found, want] = [&boxed, &asked].map(|scene| run(scene, start.clone(), engine(), 1.0, 4));
            assert!(want.record.walls.count > 50, "{}", want.record.walls.count);
            assert_eq!(found.record.walls.count, want.record.walls.count, "{number}");
            assert!(found.particles.position == want.particles.position, "{number}");
        }
        // A wall that both computations miss would show as an overlap, because no hard sphere may ever overlap a wall.
        // The calendar does not test walls out of reach. Without gravity, the reach is longer.
        for gravity in [boxed.gravity, Vector3::zeros()] {
            let scene = Scene { gravity, ..boxed.clone() };
            let mut simulation = Simulation::with_engine(scene, start.clone(), Box::new(Hard::with_one_calendar()));
            for _ in 0..40 {
                simulation.run(1, 0.05).unwrap();
                let particles = &simulation.particles;
                let gaps = particles.position.iter().zip(&particles.radius).flat_map(|(place, radius)| {
                    boxed.walls.iter().map(move |wall| wall.geometry.nearest(place).distance - radius)
                });
                let least = gaps.fold(f64::INFINITY, f64::min);
                assert!(least > -1e-12, "{count} spheres, {gravity:?}: {least:e}");
            }
        }
    }
}

/// Among hundreds of pins, a tree of the bounds of the pins finds all pins near a position and few others, also in
/// periodic boxes.
#[test]
fn of_many_bodies_only_those_near_by_are_asked() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut draw = |size: f64| size * random.random::<f64>();
    for periodic in [[false; 3], [true, false, true]] {
        let domain = diptych::Domain::new(Vector3::repeat(20.0), periodic);
        let pin = |_| {
            let centre = Vector3::new(1.0 + draw(18.0), 1.0 + draw(18.0), 1.0 + draw(18.0));
            let pin = WallGeometry::Obstacle(Obstacle::cylinder(centre, 1, 0.2, 0.5));
            Wall::new(Repeated::of(pin, &domain), surface(1.0, 0.0))
        };
        let mut walls: Vec<Wall> = (0..400).map(pin).collect();
        walls.insert(7, plane([0.0; 3], [0.0, 1.0, 0.0], surface(1.0, 0.0)));
        let near = NearWalls::of(&walls);
        let (mut asked, mut found) = (0, 0);
        for _ in 0..500 {
            let place = Vector3::from_fn(|axis, _| if periodic[axis] { draw(24.0) - 2.0 } else { draw(20.0) });
            let mut listed = Vec::new();
            near.for_each(&place, 0.8, |wall| listed.push(wall));
            asked += listed.len();
            for (wall, shape) in (0u32..).zip(&walls) {
                if shape.geometry.is_within(&place, 0.8) {
                    found += 1;
                    assert!(listed.contains(&wall), "{periodic:?}: pin {wall} near {place:?} is not listed");
                }
            }
        }
        assert!(found > 80 && asked < 4 * found + 500, "{periodic:?}: {asked} asked for {found} found");
    }
}
