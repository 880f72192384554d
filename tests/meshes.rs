//! Walls of triangles: seams have no effect, corners are detected, and particles do not leave closed vessels.

mod gas;
pub mod heaps;

use crate::support::*;
use diptych::engine::{Engine, Failure};
use diptych::experiment::Integrator::{Rk2, VelocityVerlet};
use diptych::simulation::Simulation;
use diptych::walls::{Cavity, Fault, Flight, Geometry, Hollow, Mesh, Obstacle, Plane, Sides, Wall, WallGeometry};
use gas::vessels;
use heaps::{Heap, ball, block, floor};
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

fn mesh(heap: &Heap, sides: Option<Sides>) -> Mesh {
    Mesh::new("test", heap, sides).unwrap().0
}

fn wall(mesh: Mesh, e: f64, mu: f64) -> Wall {
    Wall::new(WallGeometry::Mesh(Arc::new(mesh)), surface(e, mu))
}

fn random_vector(random: &mut Xoshiro256PlusPlus, half: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| half * (2.0 * random.random::<f64>() - 1.0))
}

#[test]
fn a_plane_of_triangles_is_a_plane_to_every_engine() {
    // a ball thrown along the floor touches it inside a triangle, on an edge and at a corner; the floor must act as a
    // plane
    let (size, e, mu, k) = (18.0, 0.8, 0.05, 1e4_f64);
    let dt = PI / k.sqrt() / 40.0;
    type Make<'a> = Box<dyn Fn() -> Box<dyn Engine> + 'a>;
    // Local stepping has one coordinate for a plane and three for a mesh. Instants are found to 1e-11 of a diameter,
    // and these errors add up over at most ten bounces
    let engines: [(&str, Make, f64); 6] = [
        ("hard", Box::new(hard), 1e-12),
        ("stepped", Box::new(|| stepped(0.02)), 1e-12),
        ("verlet", Box::new(|| soft(k, dt, VelocityVerlet)), 1e-12),
        ("rk2", Box::new(|| soft(k, dt, Rk2)), 1e-12),
        ("local", Box::new(|| local(k, dt, VelocityVerlet)), 1e-9),
        ("local rk2", Box::new(|| local(k, dt, Rk2)), 1e-9),
    ];
    for (name, engine, tolerance) in engines {
        // paths over the middle of triangles, along a row of edges, and from corner to corner
        for (x, z, along) in [(2.13, 2.71, [1.0, 0.3]), (2.0, 2.0, [1.0, 0.0]), (2.0, 2.0, [1.0, 1.0])] {
            let end = |wall: Wall| {
                let mut scene = empty([size; 3], [false; 3], unit(), surface(1.0, 0.0));
                scene.gravity = Vector3::new(0.0, -1.0, 0.0);
                // with a body, even out of reach, no engine uses velocities relative to the mean velocity along planes
                let body = WallGeometry::Obstacle(Obstacle::sphere(Vector3::repeat(17.0), 0.5));
                scene.walls = vec![wall, Wall::new(body, surface(1.0, 0.0))];
                let start = placed(&scene, &[([x, 1.2, z], [along[0], -0.3, along[1]])]);
                run(&scene, start, engine(), 6.0, 5)
            };
            let want = end(plane([0.0; 3], [0.0, 1.0, 0.0], surface(e, mu)));
            assert!(want.record.walls.count >= 3);
            for n in [1, 10, 100] {
                let found = end(wall(mesh(&floor(size, n), None), e, mu));
                assert_eq!(found.record.walls.count, want.record.walls.count, "{name}, {n}");
                let place = (found.particles.position[0] - want.particles.position[0]).norm();
                let speed = (found.particles.velocity[0] - want.particles.velocity[0]).norm();
                println!("{name}, {} triangles: {place:.1e} m, {speed:.1e} m/s", 2 * n * n);
                assert!(place < tolerance && speed < tolerance, "{name}, {n}: {place:e} {speed:e}");
            }
        }
    }
}

#[test]
fn a_ball_that_rolls_over_seams_feels_nothing() {
    // The overlap of the sphere with the floor balances its weight, and the sphere slides without friction over 100
    // seams. There must be one contact all the time, and no other force than the weight.
    let (size, k) = (18.0, 1e3);
    let mut scene = empty([size; 3], [false; 3], unit(), surface(1.0, 0.0));
    scene.gravity = Vector3::new(0.0, -1.0, 0.0);
    for (name, heap) in [("200 triangles", floor(size, 10)), ("20,000 triangles", floor(size, 100))] {
        scene.walls = vec![wall(mesh(&heap, None), 1.0, 0.0)];
        let height = 0.5 - 1.0 / k;
        for engine in [soft(k, 1e-3, VelocityVerlet), local(k, 1e-3, VelocityVerlet)] {
            let start = placed(&scene, &[([2.13, height, 2.0], [2.0, 0.0, 2.0])]);
            let end = run(&scene, start, engine, 6.0, 12);
            let (x, v) = (end.particles.position[0], end.particles.velocity[0]);
            let off = (x - Vector3::new(14.13, height, 14.0)).norm() + (v - Vector3::new(2.0, 0.0, 2.0)).norm();
            println!("{name}: {off:.1e}");
            // rounding errors of 6000 steps, without damping
            assert!(off < 1e-9, "{name}: {off:e}");
            assert_eq!(end.record.walls.count, 0, "{name}");
        }
    }
}

#[test]
fn overlaps_on_a_tilted_plane_of_triangles_are_those_of_the_plane() {
    let turn = Rotation3::from_euler_angles(0.3, -0.2, 0.7);
    let heap: Heap = floor(2.0, 20).iter().map(|triangle| triangle.map(|corner| turn * corner)).collect();
    let (sheet, plane) = (mesh(&heap, None), Plane { point: Vector3::zeros(), normal: turn * Vector3::y() });
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    for k in 0..2000 {
        // over faces, edges and corners of the grid with a spacing of 0.2
        let round = |x: f64| if k % 3 == 0 { (x / 0.2).round() * 0.2 } else { x };
        let [x, z] = [round(2.0 * random.random::<f64>()), 2.0 * random.random::<f64>()];
        let point = turn * Vector3::new(x, 0.4 + 0.09 * random.random::<f64>(), if k % 6 == 0 { round(z) } else { z });
        let (want, found) = (plane.nearest(&point), sheet.contact(0, &point, 0.5));
        assert!((found.distance - want.distance).abs() < 1e-12 * (0.5 - want.distance), "{k}");
        assert!((found.normal - want.normal).norm() < 1e-12);
        assert!(sheet.contact(1, &point, 0.5).distance > 0.5);
    }
}

#[test]
fn a_block_of_triangles_is_hit_when_a_block_is() {
    // impacts on faces, edges and corners, in straight flight and in falls, against the closed form of the solid block
    let (center, half, radius) = (Vector3::new(0.3, -0.2, 0.1), Vector3::new(1.0, 0.7, 1.2), 0.25);
    let body = Obstacle::cuboid(center, half);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
    for n in [1, 4] {
        let triangles = mesh(&block(center, half, n), None);
        assert_eq!(triangles.sides(), Sides::Outside);
        let (mut touched, mut missed, mut worst) = (0, 0, 0.0f64);
        for k in 0..4000 {
            let position = center + random_vector(&mut random, 3.0);
            if body.nearest(&position).distance < radius {
                continue;
            }
            let nearest = triangles.nearest(&position);
            assert!((nearest.distance - body.nearest(&position).distance).abs() < 1e-13);
            let target = center + random_vector(&mut random, 1.4);
            let gravity = if k % 2 == 0 { Vector3::zeros() } else { Vector3::new(0.1, -0.9, 0.2) };
            let flight = Flight { position, velocity: (target - position).normalize(), gravity };
            let (want, found) = (body.touch_time(&flight, radius, 6.0), triangles.touch_time(&flight, radius, 6.0));
            let (Some(want), Some(found)) = (want, found) else {
                assert_eq!(want, found, "{n} {flight:?}");
                missed += 1;
                continue;
            };
            touched += 1;
            let normal = body.nearest(&flight.position_at(want)).normal;
            let along = flight.velocity_at(want).dot(&normal).abs();
            worst = worst.max((want - found).abs() * along);
            assert!((want - found).abs() < 1e-12 / along.max(1e-6), "{n}: {want} {found} {flight:?}");
            // the point of touch that is found lies on the surface
            let touch = triangles.first_touch(0, &flight, radius, 6.0).unwrap();
            let struck = triangles.struck(0, touch.feature, &flight.position_at(touch.time), radius);
            assert!((struck.distance - radius).abs() < 1e-12, "{:e}", struck.distance - radius);
            assert!((struck.normal - normal).norm() < 1e-6, "{} {normal}", struck.normal);
        }
        println!("{touched} touched, {missed} missed, worst {worst:.1e}");
        assert!(touched > 1000 && missed > 500, "{touched} touched, {missed} missed");
    }
}

#[test]
fn contacts_in_the_corners_of_a_vessel_are_those_of_its_sides() {
    let (center, half, radius) = (Vector3::new(0.3, -0.2, 0.1), Vector3::new(1.0, 0.7, 1.2), 0.3);
    let room = Hollow::new(Cavity::Box { center, half_extents: half });
    let mut random = Xoshiro256PlusPlus::seed_from_u64(12);
    let mut several = [0; 4];
    for n in [1, 5, 20] {
        let triangles = mesh(&block(center, half, n), Some(Sides::Inside));
        for _ in 0..2000 {
            // centres near corners and edges, where the overlap of the sphere is up to a quarter of its diameter
            let mut point = center + random_vector(&mut random, 1.0).component_mul(&half);
            for axis in 0..3 {
                if random.random::<f64>() < 0.7 {
                    let side = if random.random::<bool>() { 1.0 } else { -1.0 };
                    let depth = radius * (0.5 + 0.6 * random.random::<f64>());
                    point[axis] = center[axis] + side * (half[axis] - depth);
                }
            }
            let mut want: Vec<_> = (0..6).map(|side| room.contact(side, &point, radius)).collect();
            want.retain(|nearest| nearest.distance < radius);
            want.sort_by(|a, b| a.distance.total_cmp(&b.distance));
            let found = (0..3).map(|which| triangles.contact(which, &point, radius));
            let found: Vec<_> = found.filter(|nearest| nearest.distance < radius).collect();
            assert_eq!(want.len(), found.len(), "{n} {point} {want:?} {found:?}");
            several[want.len()] += 1;
            for (want, found) in want.iter().zip(&found) {
                assert!((want.distance - found.distance).abs() < 1e-13 && (want.normal - found.normal).norm() < 1e-12);
            }
        }
    }
    assert!(several.iter().all(|count| *count > 100), "{several:?}");
}

#[test]
fn both_sides_of_a_thin_plate_are_one_contact() {
    let plate = mesh(&block(Vector3::zeros(), Vector3::new(2.0, 0.05, 2.0), 3), None);
    let above = plate.contact(0, &Vector3::new(0.1, 0.45, 0.2), 0.5);
    assert!((above.distance - 0.4).abs() < 1e-15 && above.normal == Vector3::y());
    assert!(plate.contact(1, &Vector3::new(0.1, 0.45, 0.2), 0.5).distance > 0.5);
    // within the plate, the centre is behind the surface: the overlap exceeds a radius
    assert!(plate.contact(0, &Vector3::new(0.1, 0.04, 0.2), 0.5).distance < 0.0);
    // a sphere below the plate meets the lower side if it flies up, and nothing if it flies down
    let flight = |y: f64, v: f64| Flight {
        position: Vector3::new(0.1, y, 0.2),
        velocity: Vector3::new(0.0, v, 0.0),
        gravity: Vector3::zeros(),
    };
    assert!((plate.touch_time(&flight(-1.0, 1.0), 0.5, 9.0).unwrap() - 0.45).abs() < 1e-15);
    assert_eq!(plate.touch_time(&flight(-0.55, -1.0), 0.5, 9.0), None);
    assert_eq!(plate.touch_time(&flight(-0.55 + 1e-17, -1.0), 0.5, 9.0), None);
}

/// A body of triangles has the same periodic images as the solid block: in the middle of the box, in a side and in an
/// edge.
#[test]
fn a_body_of_triangles_stands_again_across_periodic_sides() {
    let (size, half, k) = (6.0, Vector3::new(1.0, 1.5, 2.2), 1e4);
    for centre in [Vector3::repeat(3.0), Vector3::new(0.3, 3.0, 2.0), Vector3::new(0.4, 5.9, 3.0)] {
        let scene_of = |shape: WallGeometry| {
            let mut scene = empty([size; 3], [true; 3], unit(), surface(1.0, 0.0));
            scene.walls = vec![Wall::new(shape, surface(1.0, 0.0))];
            scene
        };
        let solid = scene_of(WallGeometry::Obstacle(Obstacle::cuboid(centre, half)));
        let triangles = scene_of(WallGeometry::Mesh(Arc::new(mesh(&block(centre, half, 3), None))));
        let start = random(&triangles, 20, 1.0, 6);
        assert!(start.position == random(&solid, 20, 1.0, 6).position, "starts know the images of both");
        let engines: [fn(f64) -> Box<dyn Engine>; 4] =
            [|_| hard(), |_| islands(), |k| soft(k, 5e-4, VelocityVerlet), |k| local(k, 5e-4, VelocityVerlet)];
        for (number, engine) in engines.into_iter().enumerate() {
            let want = run(&solid, start.clone(), engine(k), 1.5, 5);
            let found = run(&triangles, start.clone(), engine(k), 1.5, 5);
            assert!(want.record.walls.count > 2, "{}", want.record.walls.count);
            assert_eq!(found.record.walls.count, want.record.walls.count, "{centre}, {number}");
            let off = found.particles.position.iter().zip(&want.particles.position).map(|(a, b)| (a - b).norm());
            let off = off.fold(0.0, f64::max);
            println!("{number}: {off:.1e}");
            // local stepping has one coordinate for a plane and three for triangles; differences grow with each impact
            assert!(off < 1e-5, "{centre}, {number}: {off:e}");
        }
    }
}

/// For most positions, bounds show that a sphere is far from a surface, on its free side. No distances to triangles
/// are then computed. The test checks that these answers are right.
#[test]
fn what_is_clear_of_triangles_is_so() {
    let centre = Vector3::repeat(8.0);
    let mut all = vec![
        ("block", mesh(&block(centre, Vector3::new(4.0, 3.0, 5.0), 4), None)),
        ("sheet", mesh(&block(centre, Vector3::new(4.0, 3.0, 5.0), 4)[8..].to_vec(), None)),
    ];
    all.extend(vessels(1.0));
    let mut random = Xoshiro256PlusPlus::seed_from_u64(17);
    for (name, mesh) in all {
        let (mut free, mut known) = (0, 0);
        for _ in 0..4000 {
            let point = centre + random_vector(&mut random, 9.0);
            let distance = mesh.nearest(&point).distance;
            free += u32::from(distance > 1.5);
            if mesh.is_clear(&point, 0.5) {
                known += u32::from(distance > 1.5);
                assert!(distance > 0.5, "{name}: {point} is at {distance}");
            }
        }
        assert!(free > 40 && 10 * known > 9 * free, "{name}: {known} known of {free}");
    }
}

#[test]
fn fast_spheres_do_not_get_out_through_corners_and_edges() {
    // No hard sphere leaves the vessel, at any speed. No soft sphere leaves it without a message: a sphere too fast for
    // its stiffness is a failure.
    let vessel = mesh(&block(Vector3::repeat(4.0), Vector3::repeat(3.0), 6), Some(Sides::Inside));
    let mut scene = empty([8.0; 3], [false; 3], unit(), surface(1.0, 0.0));
    scene.walls = vec![wall(vessel.clone(), 1.0, 0.0)];
    let k = 1e4;
    let dt = PI / f64::sqrt(k) / 30.0;
    let mut ends: BTreeMap<(&str, &str), u32> = BTreeMap::new();
    for (number, corner) in (0..8).cycle().take(80).enumerate() {
        let towards = Vector3::from_fn(|axis, _| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 });
        // directions to corners, to edges, and to points near them
        let mut aim = towards * 2.5 + Vector3::new(0.1, -0.05, 0.03) * (number / 8) as f64 * 0.3;
        if number % 3 == 0 {
            aim.x = 0.2;
        }
        for speed in [1.0, 30.0, 1000.0] {
            let start = placed(&scene, &[([4.0, 4.0, 4.0], (aim.normalize() * speed).into())]);
            for (engine, what) in
                [(hard(), "hard"), (soft(k, dt, VelocityVerlet), "soft"), (local(k, dt, VelocityVerlet), "local")]
            {
                let (end, result) = try_run(&scene, start.clone(), engine, 20.0 / speed, 3);
                let inside = vessel.nearest(&end.particles.position[0]).distance;
                match result {
                    Ok(()) => {
                        assert!(inside > 0.0, "{what} at {speed}: escaped, {inside}");
                        *ends.entry((what, "inside")).or_default() += 1;
                    }
                    Err(Failure::OverlapTooLarge { .. }) if what != "hard" => {
                        *ends.entry((what, "failed")).or_default() += 1;
                    }
                    Err(why) => panic!("{what} at {speed}: {why}"),
                }
            }
        }
    }
    println!("{ends:?}");
    // all slow spheres stay inside
    assert!(ends[&("hard", "inside")] == 240 && ends[&("soft", "inside")] >= 80 && ends[&("local", "inside")] >= 80);
}

#[test]
fn what_is_wrong_with_triangles_is_counted_and_put_right_or_refused() {
    let cube = block(Vector3::zeros(), Vector3::repeat(1.0), 2);
    let (clean, found) = Mesh::new("cube", &cube, None).unwrap();
    // half of the faces of `block` have the wrong orientation, and are turned around when read
    assert!(found.is_closed() && found.degenerate.0 == 0 && found.duplicate.0 == 0);
    assert_eq!((clean.sides(), found.turned.0 > 0), (Sides::Outside, true));

    let mut worse = cube.clone();
    worse.insert(3, [cube[0][0], cube[0][1], cube[0][0]]);
    worse.insert(7, [cube[0][0], cube[0][1], 0.5 * (cube[0][0] + cube[0][1])]);
    worse.push(cube[5]);
    let (same, found) = Mesh::new("worse", &worse, None).unwrap();
    assert_eq!((found.degenerate, found.duplicate), ((2, 4), (1, worse.len())));
    assert!(found.is_closed());
    let point = Vector3::new(1.5, 0.3, 0.2);
    assert_eq!(same.nearest(&point), clean.nearest(&point));

    // all triangles turned inside out, and a single triangle turned around
    let turned = |[a, b, c]: [Vector3<f64>; 3]| [a, c, b];
    let round = mesh(&ball(Vector3::zeros(), 1.0, 2), None);
    let (points, triangles) = round.triangles();
    let mut one: Heap = triangles.map(|corners| corners.map(|corner| points[corner as usize])).collect();
    let (_, found) = Mesh::new("ball", &one, None).unwrap();
    assert_eq!((found.turned, found.inside_out), ((0, 0), false));
    let (_, found) = Mesh::new("ball", &one.iter().copied().map(turned).collect::<Heap>(), None).unwrap();
    assert_eq!((found.turned, found.inside_out), ((0, 0), true));
    one[17] = turned(one[17]);
    let (_, found) = Mesh::new("ball", &one, None).unwrap();
    assert_eq!((found.turned, found.inside_out), ((1, 18), false));

    // a hole
    let open: Heap = cube[1..].to_vec();
    assert!(
        matches!(Mesh::new("open", &open, Some(Sides::Inside)), Err(Fault::NotClosed(found)) if found.open_edges == 3)
    );
    let (sheet, found) = Mesh::new("open", &open, None).unwrap();
    assert_eq!((sheet.sides(), found.open_edges), (Sides::Both, 3));

    // coordinates that are not finite
    let mut bad = cube.clone();
    bad[4][1].x = f64::NAN;
    bad[9][2].z = f64::INFINITY;
    assert_eq!(Mesh::new("bad", &bad, None).unwrap_err(), Fault::NotFinite { count: 2, given: bad.len(), first: 5 });
    assert_eq!(Mesh::new("none", &[], None).unwrap_err(), Fault::Empty { given: 0 });
}

#[test]
#[ignore = "a measurement of time, for a quiet machine: cargo test --release -- --ignored --nocapture cost_of_triangles"]
fn cost_of_triangles_is_at_most_twice_that_of_the_round_shape() {
    // 50,000 spheres at a volume fraction of 0.01 in a ball, given as a closed form and as 20,480 triangles
    let (count, fraction) = (50_000, 0.01);
    let radius = 0.5 * (f64::from(count) / fraction).cbrt();
    let center = Vector3::repeat(radius + 1.0);
    let bowl = WallGeometry::Hollow(Hollow::new(Cavity::Sphere { center, radius }));
    let sphere = WallGeometry::Mesh(Arc::new(mesh(&ball(center, radius, 5), Some(Sides::Inside))));
    let mut scene = empty([2.0 * radius + 2.0; 3], [false; 3], unit(), surface(0.95, 0.1));
    // a ball within the triangles
    let small = Hollow::new(Cavity::Sphere { center, radius: 0.99 * radius });
    scene.walls = vec![Wall::new(WallGeometry::Hollow(small), surface(0.9, 0.1))];
    let start = random(&scene, count as usize, 1.0, 4);
    let k = 1e4;
    let dt = PI * (0.5f64 / k).sqrt() / 20.0;
    type Make = Box<dyn Fn() -> Box<dyn Engine>>;
    let engines: [(&str, Make, f64); 3] = [
        ("hard", Box::new(hard), 0.5),
        ("local", Box::new(move || local(k, dt, VelocityVerlet)), 0.5),
        ("uniform", Box::new(move || soft(k, dt, VelocityVerlet)), 0.05),
    ];
    for (name, engine, window) in engines {
        let mut ratios = Vec::new();
        for _ in 0..5 {
            let time = |geometry: &WallGeometry| {
                let mut scene = scene.clone();
                scene.walls = vec![Wall::new(geometry.clone(), surface(0.9, 0.1))];
                let mut simulation = Simulation::with_engine(scene, start.clone(), engine());
                let began = std::time::Instant::now();
                simulation.run(6, window).unwrap();
                (began.elapsed().as_secs_f64(), simulation.record.walls.count)
            };
            let (shape, triangles) = (time(&bowl), time(&sphere));
            println!("{name}: {shape:?} {triangles:?}");
            ratios.push(triangles.0 / shape.0);
        }
        ratios.sort_by(f64::total_cmp);
        println!("{name}: triangles take {:.2} ({:.2} - {:.2}) times as long", ratios[2], ratios[0], ratios[4]);
        assert!(ratios[2] < 2.0);
    }
}
