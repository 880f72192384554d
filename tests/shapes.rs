//! Walls of all shapes: closed forms compared with conservative advancement, corners, hollow bodies, and the pressure
//! of a gas on walls.

use crate::support::*;
use diptych::scene::Scene;
use diptych::simulation::Simulation;
use diptych::walls::{Cavity, Flight, Frustum, Geometry, Hollow, Mesh, Nearest, RoundAxis, Sides, Wall, WallGeometry};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::PI;
use std::sync::Arc;

/// Shape of this library that gives only its nearest point, and no closed form for the time of touch.
#[derive(Debug)]
struct Nearby<G>(G);

impl<G: Geometry> Geometry for Nearby<G> {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        self.0.nearest(point)
    }
}

fn wall(geometry: WallGeometry, e: f64, mu: f64) -> Wall {
    Wall::new(geometry, surface(e, mu))
}

fn random_vector(random: &mut Xoshiro256PlusPlus, half: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| half * (2.0 * random.random::<f64>() - 1.0))
}

/// Round shapes about an axis, with the given centre and the direction of the axis.
fn round(center: Vector3<f64>, axis: usize) -> Vec<(&'static str, WallGeometry)> {
    let axle = RoundAxis { center, axis };
    let frustum = |radii, solid| Frustum { axle, radii, half_height: 1.5, solid };
    let hollow = |room| WallGeometry::Hollow(Hollow::new(room));
    vec![
        ("pipe", hollow(Cavity::Pipe { axle, radius: 2.0 })),
        ("bowl", hollow(Cavity::Sphere { center, radius: 2.0 })),
        ("can", hollow(Cavity::ClosedCylinder(frustum([2.0, 2.0], true)))),
        ("vessel", hollow(Cavity::ClosedCylinder(frustum([2.0, 1.2], true)))),
        ("cone", WallGeometry::Frustum(frustum([1.1, 0.6], true))),
        ("funnel", WallGeometry::Frustum(frustum([1.1, 0.6], false))),
    ]
}

#[test]
fn closed_forms_of_round_walls_agree_with_advancement() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let (radius, fall) = (0.2, Vector3::new(0.1, -0.9, 0.2));
    let mut touched = 0;
    for axis in 0..3 {
        let center = Vector3::new(0.3, -0.2, 0.1);
        for (name, shape) in round(center, axis) {
            let mut own = 0;
            for _ in 0..200 {
                let (position, velocity) = (center + random_vector(&mut random, 2.5), random_vector(&mut random, 1.0));
                let gravity = if random.random::<bool>() { Vector3::zeros() } else { fall };
                if shape.nearest(&position).distance < radius {
                    continue;
                }
                let flight = Flight { position, velocity, gravity };
                let want = Nearby(Shape(&shape)).touch_time(&flight, radius, 8.0);
                let found = shape.law().touch_time(&flight, radius, 8.0);
                let (Some(want), Some(found)) = (want, found) else {
                    assert_eq!(want, found, "{name} {flight:?}");
                    continue;
                };
                let nearest = shape.nearest(&flight.position_at(found));
                assert!((nearest.distance - radius).abs() < 1e-12, "{name}: {:e}", nearest.distance - radius);
                let along = flight.velocity_at(want).dot(&nearest.normal).abs();
                assert!((want - found).abs() < 1e-12 / along.max(1e-6), "{name}: {want} {found} {flight:?}");
                own += 1;
            }
            assert!(own > 15, "{name}: {own}");
            touched += own;
        }
    }
    println!("{touched} touches");
}

/// Shape whose name appears in messages.
#[derive(Debug)]
struct Shape<'a>(&'a WallGeometry);

impl Geometry for Shape<'_> {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        self.0.nearest(point)
    }
}

#[test]
fn nearest_points_of_round_walls_are_on_the_surface_and_nearest() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(6);
    let center = Vector3::new(0.3, -0.2, 0.1);
    for axis in 0..3 {
        for (name, shape) in round(center, axis) {
            for _ in 0..300 {
                let point = center + random_vector(&mut random, 3.0);
                let here = shape.nearest(&point);
                assert!((here.normal.norm() - 1.0).abs() < 1e-12, "{name}");
                // a distance changes by at most the length of a step, and by the whole length along the normal
                let step = random_vector(&mut random, 0.1);
                let there = shape.nearest(&(point + step)).distance;
                assert!((there - here.distance).abs() <= step.norm() + 1e-12, "{name}");
                if here.distance > 0.0 {
                    let foot = shape.nearest(&(point - here.normal * here.distance)).distance;
                    assert!(foot.abs() < 1e-12, "{name}: {foot:e}");
                }
            }
        }
    }
}

#[test]
fn a_sphere_in_a_corner_has_a_contact_with_every_side() {
    // a hollow box has the bits of three planes in every engine, for the same bounces in its corner
    let (size, e, mu) = (10.0, 0.8, 0.1);
    let planes: Vec<Wall> = (0..3)
        .flat_map(|axis| {
            let normal = |sign: f64| Vector3::from_fn(|k, _| if k == axis { sign } else { 0.0 });
            let far = Vector3::repeat(size);
            [
                plane([0.0; 3], normal(1.0).into(), surface(e, mu)),
                plane(far.into(), normal(-1.0).into(), surface(e, mu)),
            ]
        })
        .collect();
    let half = Vector3::repeat(0.5 * size);
    let room = Hollow::new(Cavity::Box { center: half, half_extents: half });
    let (v, dt) = (Vector3::new(-1.0, -1.1, -0.9), 1e-3);
    let start = Vector3::new(1.5, 1.6, 1.4);
    for (name, engine) in engines(1e4, dt) {
        let end = |walls: Vec<Wall>| {
            let mut scene = empty([size; 3], [false; 3], unit(), surface(1.0, 0.0));
            scene.gravity = Vector3::new(0.0, -1.0, 0.0);
            scene.walls = walls;
            run(&scene, placed(&scene, &[(start.into(), v.into())]), engine(), 3.0, 6)
        };
        let (want, found) = (end(planes.clone()), end(vec![wall(WallGeometry::Hollow(room.clone()), e, mu)]));
        assert!(want.record.walls.count >= 3, "{name}");
        assert_eq!(want.record.walls.count, found.record.walls.count, "{name}");
        let off = (want.particles.position[0] - found.particles.position[0]).norm();
        assert!(off < 1e-12, "{name}: {off:e}");
    }
}

/// Engines of hard spheres, and of soft spheres (stiffness `k`, time step `dt`) with each kind of time steps and
/// integrator.
fn engines(k: f64, dt: f64) -> [(&'static str, Box<dyn Fn() -> Box<dyn diptych::engine::Engine>>); 6] {
    use diptych::experiment::Integrator::{Rk2, VelocityVerlet};
    [
        ("hard", Box::new(hard)),
        ("stepped", Box::new(|| stepped(0.02))),
        ("verlet", Box::new(move || soft(k, dt, VelocityVerlet))),
        ("rk2", Box::new(move || soft(k, dt, Rk2))),
        ("local", Box::new(move || local(k, dt, VelocityVerlet))),
        ("local rk2", Box::new(move || local(k, dt, Rk2))),
    ]
}

/// Faces of a cube from 0 to `edge`, each of 2 n² triangles.
fn cube_of_triangles(edge: f64, n: u32) -> Vec<[Vector3<f64>; 3]> {
    let mut heap = Vec::new();
    let step = edge / f64::from(n);
    for axis in 0..3 {
        for side in [0.0, edge] {
            let at = |i: u32, j: u32| {
                let mut point = Vector3::zeros();
                point[axis] = side;
                point[(axis + 1) % 3] = if i == n { edge } else { f64::from(i) * step };
                point[(axis + 2) % 3] = if j == n { edge } else { f64::from(j) * step };
                point
            };
            for i in 0..n {
                for j in 0..n {
                    heap.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                    heap.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    heap
}

/// Checks that a sphere of radius 0.5 touches the inner side of a room again when it slides along it. The sphere
/// starts at the position `place`, where the wall has the normal `normal`, and moves fast in the direction `down`. It
/// leaves the wall slowly, or not at all. A sphere that lies on the wall touches it at once.
fn stays_on(wall: &dyn Geometry, place: Vector3<f64>, [normal, down]: [Vector3<f64>; 2], fastest: f64) {
    for (gap, sideways) in [(0.0, 0.0), (1e-15, 0.0), (1e-10, 0.3), (1e-5, 0.3)] {
        for leaves in [1.0, 1e-2, 1e-4, 1e-6, 0.0].map(|leaves| leaves * fastest) {
            let position = place + normal * (0.5 + gap);
            let velocity = down + normal * leaves + Vector3::y() * sideways;
            for gravity in [Vector3::new(0.0, 0.0, -1.0), Vector3::new(0.3, 0.2, -1.0)] {
                let flight = Flight { position, velocity, gravity };
                let gap_at = |t: f64| wall.contact(0, &flight.position_at(t), 0.5).distance - 0.5;
                let touch = wall.first_touch(0, &flight, 0.5, 20.0);
                let Some(touch) = touch else { panic!("gap {gap:e}, leaves with {leaves:e}: {touch:?}") };
                assert!(gap_at(touch.time).abs() < 1e-14, "{:e} at {touch:?}", gap_at(touch.time));
                let least = (1..200).map(|k| gap_at(touch.time * f64::from(k) / 200.0)).fold(f64::INFINITY, f64::min);
                assert!(least > -1e-14, "gap {gap:e}, leaves with {leaves:e}: {least:e} before {touch:?}");
                // not much later than the touch of a plane to which gravity pulls the sphere; curvature makes the touch
                // earlier
                let pull = -gravity.dot(&normal);
                let plane = (leaves + (leaves * leaves + 2.0 * pull * gap).sqrt()) / pull;
                // gravity closes a gap of 1e-15, a rounding error, in 1e-7
                assert!(touch.time <= plane * (1.0 + 1e-6) + 1e-7, "{touch:?}, {plane:e}");
            }
        }
    }
}

#[test]
fn a_sphere_that_slides_down_a_cone_stays_on_it() {
    let (axle, slope) = (RoundAxis { center: Vector3::zeros(), axis: 2 }, 7.0 / 22.0_f64);
    let length = 1.0f64.hypot(slope);
    let (normal, down) = (Vector3::new(-1.0, 0.0, slope) / length, Vector3::new(-slope, 0.0, -1.0) / length);
    let cone = Frustum { axle, radii: [2.0, 9.0], half_height: 11.0, solid: true };
    let place = Vector3::new(5.5, 0.0, 0.0);
    stays_on(&Hollow::new(Cavity::ClosedCylinder(cone)), place, [normal, down], 1.0);
    // the same shape as a thin shell, which has an end
    stays_on(&Frustum { solid: false, ..cone }, place, [normal, down], 0.1);
}

#[test]
fn a_sphere_that_slides_down_the_outside_of_a_thin_cone_stays_on_it() {
    // the sphere slides along a line of the cone, as on a plane to which gravity pulls it
    let (axle, slope) = (RoundAxis { center: Vector3::zeros(), axis: 2 }, 7.0 / 22.0_f64);
    let length = 1.0f64.hypot(slope);
    let (normal, down) = (Vector3::new(1.0, 0.0, slope) / length, Vector3::new(slope, 0.0, -1.0) / length);
    let shell = Frustum { axle, radii: [9.0, 2.0], half_height: 11.0, solid: false };
    let gravity = Vector3::new(0.0, 0.0, -1.0);
    let pull = -gravity.dot(&normal);
    for gap in [0.0, 1e-15, 1e-10, 1e-5] {
        for leaves in [0.1, 1e-2, 1e-4, 1e-6] {
            let position = Vector3::new(5.5, 0.0, 0.0) + normal * (0.5 + gap);
            let flight = Flight { position, velocity: down + normal * leaves, gravity };
            let want = (leaves + f64::sqrt(leaves * leaves + 2.0 * pull * gap)) / pull;
            let found = shell.touch_time(&flight, 0.5, 20.0).unwrap();
            // the tolerance is the square root of the rounding error
            assert!(
                (found - want).abs() < 1e-9 * want + 1e-7,
                "gap {gap:e}, leaves with {leaves:e}: {found} for {want}"
            );
            let off = shell.nearest(&flight.position_at(found)).distance - 0.5;
            assert!(off.abs() < 1e-13, "gap {gap:e}, leaves with {leaves:e}: {off:e}");
        }
    }
}

#[test]
fn the_roots_of_a_thin_shell_are_the_touches() {
    // flights nearly parallel to the shell: inside, outside, past the rims, and straight at the rims
    let mut random = Xoshiro256PlusPlus::seed_from_u64(21);
    let (radius, fall) = (0.2, Vector3::new(0.1, -0.9, 0.2));
    let axle = RoundAxis { center: Vector3::new(0.3, -0.2, 0.1), axis: 2 };
    for radii in [[1.1, 0.6], [0.9, 0.9], [1.2, 0.0]] {
        let shell = Frustum { axle, radii, half_height: 1.5, solid: false };
        let (mut touched, mut missed) = (0, 0);
        for k in 0..3000 {
            let place = axle.center + random_vector(&mut random, 2.2);
            let here = shell.nearest(&place);
            // gaps from 1e-3 of the radius down to rounding errors
            let gap = if k % 4 == 0 { 0.0 } else { 10f64.powf(-3.0 - 9.0 * random.random::<f64>()) };
            let position = place - here.normal * (here.distance - radius - gap);
            let now = shell.nearest(&position);
            if (now.distance - radius - gap).abs() > 1e-12 {
                continue;
            }
            let velocity = random_vector(&mut random, 1.0);
            let away = velocity.dot(&now.normal) - gap * (2.0 * random.random::<f64>() - 1.0);
            let velocity = velocity - now.normal * away;
            let gravity = if k % 2 == 0 { fall } else { Vector3::zeros() };
            let flight = Flight { position, velocity, gravity };
            let gap_at = |t: f64| shell.nearest(&flight.position_at(t)).distance - radius;
            let found = shell.touch_time(&flight, radius, 3.0);
            let until = found.unwrap_or(3.0);
            let least = (0..=3000).map(|k| gap_at(until * f64::from(k) / 3000.0)).fold(f64::INFINITY, f64::min);
            assert!(least > -1e-11, "{radii:?}, gap {gap:e}: {least:e} before {found:?}, {flight:?}");
            if let Some(found) = found {
                assert!(gap_at(found).abs() < 1e-12, "{radii:?}: {:e} at {found}", gap_at(found));
                touched += 1;
            } else {
                missed += 1;
            }
        }
        println!("{radii:?}: {touched} touched, {missed} missed");
        assert!(touched > 300 && missed > 300, "{radii:?}: {touched} touched, {missed} missed");
    }
}

#[test]
fn a_sphere_bounces_along_the_bottom_of_a_thin_shell_as_in_a_pipe() {
    // bounces of 1e-8 of a diameter, while the sphere slides by 2 diameters per second and rolls from side to side
    let (center, k) = (Vector3::new(4.0, 4.0, 6.0), 1.0);
    let axle = RoundAxis { center, axis: 2 };
    let shell = WallGeometry::Frustum(Frustum { axle, radii: [3.0, 3.0], half_height: 5.0, solid: false });
    let pipe = WallGeometry::Hollow(Hollow::new(Cavity::Pipe { axle, radius: 3.0 }));
    let ends = [shell, pipe].map(|geometry| {
        let mut scene = empty([8.0, 8.0, 12.0], [false; 3], unit(), surface(1.0, 0.0));
        scene.gravity = Vector3::new(0.0, -k, 0.0);
        scene.walls = vec![wall(geometry, 1.0, 0.0)];
        let start = placed(&scene, &[([4.0, 1.5 + 1e-8, 2.0], [0.5, 0.0, 2.0])]);
        run(&scene, start, hard(), 0.1, 5)
    });
    let counts = ends.each_ref().map(|end| end.record.walls.count);
    let off = (ends[0].particles.position[0] - ends[1].particles.position[0]).norm();
    println!("{counts:?} impacts, {off:e} m");
    assert!(counts[0] > 300 && counts[0].abs_diff(counts[1]) <= 1, "{counts:?}");
    assert!(off < 1e-9, "{off:e}");
}

#[test]
fn a_sphere_that_slides_down_a_bowl_stays_on_it() {
    // at a point where the slope of the bowl is 3 to 4
    let (center, radius) = (Vector3::new(0.1, 0.2, 0.3), 7.0);
    let (normal, down) = (Vector3::new(-0.6, 0.0, 0.8), Vector3::new(-0.8, 0.0, -0.6));
    stays_on(&Hollow::new(Cavity::Sphere { center, radius }), center - normal * radius, [normal, down], 1.0);
}

#[test]
fn pressure_on_walls_is_that_of_the_gas() {
    // Oracle D2: the pressure on a hard wall is n_b Z m T, with the density n_b far from the wall. Z = 1.08493 at a
    // volume fraction of 0.02 (Carnahan and Starling 1969). The higher density near the edges of the box affects less
    // than 0.5 % of the area.
    let (count, fraction) = (300, 0.02);
    let edge = edge(count, 1.0, fraction);
    let half = Vector3::repeat(0.5 * edge);
    let hollow = |room| WallGeometry::Hollow(Hollow::new(room));
    let (mesh, _) = Mesh::new("cube", &cube_of_triangles(edge, 8), Some(Sides::Inside)).unwrap();
    let (radius, inner) = (0.5 * edge, edge - 1.0);
    let axle = RoundAxis { center: half, axis: 2 };
    let box_area = 6.0 * inner * inner;
    for (name, geometry, area) in [
        ("box", hollow(Cavity::Box { center: half, half_extents: half }), box_area),
        ("mesh cube", WallGeometry::Mesh(Arc::new(mesh)), box_area),
        ("pipe", hollow(Cavity::Pipe { axle, radius }), 2.0 * PI * (radius - 0.5) * edge),
    ] {
        let mut scene = empty([edge; 3], [false, false, name == "pipe"], unit(), surface(1.0, 0.0));
        scene.walls = vec![wall(geometry, 1.0, 0.0)];
        let (ratio, error, hits) = pressure_ratio(&scene, count, area);
        println!("{name}: P/(n Z T) = {ratio:.4} +- {error:.4}, {hits} hits");
        assert!(error < 0.012, "{name}: {error}");
        close(name, ratio, 1.0, 3.0 * error + 0.005);
    }
}

/// Pressure P of a gas of hard spheres in a vessel over its theoretical value n_b Z m T (number density n_b in the
/// interior, compressibility factor Z). Then its standard error, and the number of impacts on walls.
fn pressure_ratio(scene: &Scene, count: usize, area: f64) -> (f64, f64, u64) {
    let particles = random(scene, count, 1.0, 9);
    let temperature = 2.0 * particles.kinetic_energy() / (3.0 * count as f64);
    let energy = particles.kinetic_energy();
    let mut simulation = Simulation::with_engine(scene.clone(), particles, hard());
    simulation.run(20, 1.0).unwrap();
    let middle = 0.5 * scene.domain.size;
    let (mut ratios, window) = (Vec::new(), 0.5);
    for _ in 0..20 {
        let (before, mut central, samples) = (simulation.record.ledger.wall_normal_impulse, 0u64, 200);
        for _ in 0..samples {
            simulation.run(1, window).unwrap();
            let near = |x: &&Vector3<f64>| (*x - middle).amax() < 0.25 * scene.domain.size.x;
            central += simulation.particles.position.iter().filter(near).count() as u64;
        }
        let volume = (0.5 * scene.domain.size.x).powi(3);
        let density = central as f64 / (f64::from(samples) * volume);
        let phi = density * PI / 6.0;
        let z = (1.0 + phi + phi * phi - phi.powi(3)) / (1.0 - phi).powi(3);
        let pressure = (simulation.record.ledger.wall_normal_impulse - before) / (area * window * f64::from(samples));
        ratios.push(pressure / (density * z * temperature));
    }
    close("energy", simulation.particles.kinetic_energy() / energy, 1.0, 1e-11);
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    let square = ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>();
    let error = (square / (ratios.len() * (ratios.len() - 1)) as f64).sqrt();
    (mean, error, simulation.record.walls.count)
}

#[test]
fn a_surface_that_moves_is_one_at_rest_to_whoever_moves_with_it() {
    // The motion in the frame of the moving surface must be equal: velocities differ by that of the surface, and
    // positions by its path. The ledger contains the energy from the surface. Its residual is rounding (hard spheres),
    // or due to the end of the last step (soft spheres).
    let (size, e, mu, belt) = (40.0, 0.8, 0.2, Vector3::new(2.0, 0.0, 0.5));
    let corners = [[-99.0, -99.0], [-99.0, 99.0], [99.0, 99.0], [99.0, -99.0]].map(|[x, z]| Vector3::new(x, 0.0, z));
    let sheet = [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]];
    let sheet = Mesh::new("belt", &sheet, None).unwrap().0;
    let floors = [plane([0.0; 3], [0.0, 1.0, 0.0], surface(e, mu)), wall(WallGeometry::Mesh(Arc::new(sheet)), e, mu)];
    let start = Vector3::new(10.0, 1.5, 10.0);
    for floor in floors {
        assert!(floor.geometry.law().slides(&belt) && !floor.geometry.law().slides(&Vector3::y()));
        for (name, engine) in engines(1e4, 5e-4) {
            let end = |velocity: Vector3<f64>, v: Vector3<f64>| {
                let mut scene = empty([size; 3], [false; 3], unit(), surface(1.0, 0.0));
                scene.gravity = Vector3::new(0.0, -1.0, 0.0);
                scene.walls = vec![Wall { velocity, ..floor.clone() }];
                // with a body in the scene, no velocities are relative to the mean velocity
                let body = Cavity::Sphere { center: Vector3::repeat(20.0), radius: 20.0 * 3.0 };
                scene.walls.push(wall(WallGeometry::Hollow(Hollow::new(body)), 1.0, 0.0));
                run(&scene, placed(&scene, &[(start.into(), v.into())]), engine(), 4.0, 4)
            };
            let (moving, still) = (end(belt, Vector3::zeros()), end(Vector3::zeros(), -belt));
            let off = (moving.particles.velocity[0] - belt - still.particles.velocity[0]).norm();
            assert!(off < 1e-9 || name == "stepped", "{name}: {off:e}");
            let ledger = &moving.record.ledger;
            assert!(ledger.wall_work > 0.1 && still.record.ledger.wall_work == 0.0, "{name}");
            let residual = |run: &Simulation| {
                let energy = run.particles.kinetic_energy() + run.elastic_energy();
                let at_start = if run.record.ledger.wall_work > 0.0 { 0.0 } else { 0.5 * belt.norm_squared() };
                run.record.ledger.residual(at_start, energy)
            };
            println!("{name}: {off:.1e}, residual {:.1e}, at rest {:.1e}", residual(&moving), residual(&still));
            let rounding = if name == "hard" || name == "stepped" { 1e-12 } else { 5e-3 };
            assert!(residual(&moving).abs() < rounding, "{name}: {:e}", residual(&moving));
        }
    }
}
