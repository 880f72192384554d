//! Spheres between several walls. They rest with their weight in balance, which must not be mistaken for passing
//! through a wall. Real passages must be detected. Other tests are about rest on slopes, and rest without damping.

use crate::support::{case, empty, large, local, placed, soft, surface};
use diptych::engine::{Engine, Failure};
use diptych::experiment::{Integrator, Model};
use diptych::placement::initial_state;
use diptych::scene::{Scene, Species};
use diptych::simulation::Simulation;
use diptych::walls::{Cavity, Frustum, Hollow, Mesh, Plane, RoundAxis, Sides, Wall, WallGeometry};
use nalgebra::{Unit, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Edge [m] of the box.
const EDGE: f64 = 0.04;
/// Stiffness [N/m] of the contacts.
const STIFFNESS: f64 = 2e4;

fn ball(diameter: f64) -> Species {
    Species::new("ball", diameter, 2500.0)
}

/// Scene with one wall, or a body of several walls, in its middle.
fn scene(walls: Vec<WallGeometry>, diameter: f64, gravity: Vector3<f64>) -> Scene {
    let contact = surface(0.3, 0.0);
    let walls = walls.into_iter().map(|wall| Wall::new(wall, contact)).collect();
    Scene { walls, gravity, ..empty([EDGE; 3], [false; 3], ball(diameter), contact) }
}

fn middle() -> Vector3<f64> {
    Vector3::repeat(0.5 * EDGE)
}

/// Time step [s]: a twentieth of the contact time at a wall.
fn step(scene: &Scene) -> f64 {
    std::f64::consts::PI * (scene.species[0].mass() / STIFFNESS).sqrt() / 20.0
}

/// Vertical axis through the middle of the box.
fn axle() -> RoundAxis {
    RoundAxis { center: middle(), axis: 2 }
}

/// Groove of two planes of triangles that meet in a line along x. It is open upwards, and each plane is at the angle
/// `half` [rad] from the vertical.
fn groove(half: f64) -> WallGeometry {
    let ([x0, x1], y, z) = ([0.1 * EDGE, 0.9 * EDGE], 0.5 * EDGE, 0.2 * EDGE);
    let side = |sign: f64| {
        let up = Vector3::new(0.0, sign * half.sin(), half.cos()) * (0.7 * EDGE);
        let [a, b] = [x0, x1].map(|x| Vector3::new(x, y, z));
        [[a, b, b + up], [a, b + up, a + up]]
    };
    let triangles: Vec<_> = [-1.0, 1.0].into_iter().flat_map(side).collect();
    WallGeometry::Mesh(Mesh::new("groove", &triangles, Some(Sides::Both)).unwrap().0.into())
}

/// Flat sheet of two triangles across x, at `x` [m].
fn sheet(x: f64) -> [[Vector3<f64>; 3]; 2] {
    let corner = |y: f64, z: f64| Vector3::new(x, y * EDGE, z * EDGE);
    [[corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0)], [corner(0.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]]
}

/// Runs one sphere from `start` [m] for half a second, once with local and once with uniform time steps. Each entry
/// has the force of the walls [N] in the last tenth of a second, and the final position [m].
fn rests(scene: &Scene, start: Vector3<f64>, what: &str) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let dt = step(scene);
    let engines: [(&str, Box<dyn Engine>); 2] = [
        ("local", local(STIFFNESS, dt, Integrator::VelocityVerlet)),
        ("uniform", soft(STIFFNESS, dt, Integrator::VelocityVerlet)),
    ];
    engines
        .into_iter()
        .map(|(how, engine)| {
            let particles = placed(scene, &[(start.into(), [0.0; 3])]);
            let mut simulation = Simulation::with_engine(scene.clone(), particles, engine);
            simulation.run(400, 1e-3).unwrap_or_else(|why| panic!("{what}, {how}: {why}"));
            let before = simulation.record.ledger.wall_impulse;
            simulation.run(100, 1e-3).unwrap_or_else(|why| panic!("{what}, {how}: {why}"));
            ((simulation.record.ledger.wall_impulse - before) / 0.1, simulation.particles.position[0])
        })
        .collect()
}

/// Checks that the walls carry the weight of a resting sphere, to 1e-3 of the weight. The oscillation after 0.4 s is
/// smaller than this tolerance, and the effect of a missing contact is larger.
fn carries_its_weight(scene: &Scene, start: Vector3<f64>, what: &str) {
    let weight = -scene.gravity * scene.species[0].mass();
    for (force, place) in rests(scene, start, what) {
        assert!((force - weight).norm() <= 1e-3 * weight.norm(), "{what}: {force:?} holds {weight:?} at {place:?}");
    }
}

#[test]
fn spheres_in_funnels_tubes_bowls_and_grooves_are_held_in_balance() {
    held_in_balance(40);
}

#[test]
#[ignore = "half a minute: five times as many shapes"]
fn spheres_in_two_hundred_shapes_are_held_in_balance() {
    held_in_balance(200);
}

/// Tests the rest of one sphere in each of `shapes` random shapes.
fn held_in_balance(shapes: u32) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let down = Vector3::new(0.0, 0.0, -9.81);
    for number in 0..shapes {
        let diameter = 0.004 + 0.004 * random.random::<f64>();
        let radius = 0.5 * diameter;
        // up to a hundredth of a diameter from the axis, or on the axis
        let aside = if number % 3 == 0 { 0.0 } else { 0.01 * diameter * random.random::<f64>() };
        let turn = std::f64::consts::TAU * random.random::<f64>();
        let off = Vector3::new(turn.cos(), turn.sin(), 0.0) * aside;
        match number % 4 {
            0 | 1 => {
                let low = radius * (0.3 + 0.4 * random.random::<f64>());
                let cone = Frustum { axle: axle(), radii: [low, radius + 0.006], half_height: 0.008, solid: false };
                let wall = if number % 4 == 0 {
                    WallGeometry::Frustum(cone)
                } else {
                    WallGeometry::Hollow(Hollow::new(Cavity::ClosedCylinder(Frustum { solid: true, ..cone })))
                };
                let start = middle() + Vector3::new(0.0, 0.0, 0.008 - radius) + off;
                carries_its_weight(&scene(vec![wall], diameter, down), start, &format!("cone {number}"));
            }
            2 => {
                let half = (2.0 + 20.0 * random.random::<f64>()).to_radians();
                let height = 1.02 * radius / half.sin();
                let start = Vector3::new(0.5 * EDGE, 0.5 * EDGE + 0.1 * aside, 0.2 * EDGE + height);
                if height < 0.65 * EDGE {
                    let scene = scene(vec![groove(half)], diameter, down);
                    carries_its_weight(&scene, start, &format!("groove {number}, {} degrees", half.to_degrees()));
                }
            }
            _ => {
                // a hollow sphere that is narrower than the sphere inside by up to a thousandth
                let narrow = radius * (1.0 - 1e-3 * random.random::<f64>());
                let bowl = WallGeometry::Hollow(Hollow::new(Cavity::Sphere { center: middle(), radius: narrow }));
                let start = middle() + off * 0.05;
                carries_its_weight(&scene(vec![bowl], diameter, down), start, &format!("bowl {number}"));
            }
        }
    }
}

/// A sphere is slightly wider than the tube around it. Only the ends of a tube could stop a sphere along the axis, so
/// this sphere falls freely, near the axis.
#[test]
fn a_sphere_wider_than_its_tube_falls_through_it() {
    let (diameter, gravity) = (0.005, Vector3::new(0.3, 0.0, -9.81));
    let radius = 0.5 * diameter - 5e-7;
    let shell = Frustum { axle: axle(), radii: [radius; 2], half_height: 0.45 * EDGE, solid: false };
    let pipe = Hollow::new(Cavity::Pipe { axle: axle(), radius });
    for wall in [WallGeometry::Frustum(shell), WallGeometry::Hollow(pipe)] {
        let scene = scene(vec![wall], diameter, gravity);
        for engine in [local, soft] {
            let start = middle() + Vector3::new(0.0, 0.0, 0.3 * EDGE);
            let particles = placed(&scene, &[(start.into(), [0.0; 3])]);
            let engine = engine(STIFFNESS, step(&scene), Integrator::VelocityVerlet);
            let mut simulation = Simulation::with_engine(scene.clone(), particles, engine);
            simulation.run(50, 1e-3).unwrap();
            let (x, v) = (simulation.particles.position[0], simulation.particles.velocity[0]);
            assert!((v.z + 9.81 * 0.05).abs() < 1e-9 && (start.z - x.z - 0.5 * 9.81 * 0.05 * 0.05).abs() < 1e-9);
            // the distance from the axis compresses the near side more than the far side: 2 k ρ = m g_x
            let aside = scene.species[0].mass() * 0.3 / (2.0 * STIFFNESS);
            assert!((x.x - start.x - aside).abs() < 1e-3 * aside, "{} of {aside} m aside", x.x - start.x);
        }
    }
}

/// A sphere between two sheets whose distance is smaller than its diameter, such as the two faces of the wall of a
/// silo.
#[test]
fn a_sphere_between_two_sheets_is_held() {
    for narrow in [1e-4, 1e-3, 5e-3] {
        let diameter = 0.005;
        let half = 0.5 * diameter * (1.0 - narrow);
        let triangles = [sheet(0.5 * EDGE - half), sheet(0.5 * EDGE + half)].concat();
        let mesh = Mesh::new("skins", &triangles, Some(Sides::Both)).unwrap().0;
        let scene = scene(vec![WallGeometry::Mesh(mesh.into())], diameter, Vector3::new(1.0, 0.0, 0.0));
        carries_its_weight(&scene, middle(), &format!("skins narrower by {narrow}"));
    }
}

#[test]
fn spheres_that_pass_thin_walls_are_still_caught() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
    let diameter = 0.004;
    for number in 0..200 {
        let tube = Frustum { axle: axle(), radii: [0.008; 2], half_height: 0.015, solid: false };
        let wall = if number % 2 == 0 {
            WallGeometry::Frustum(tube)
        } else {
            WallGeometry::Mesh(Mesh::new("sheet", &sheet(0.5 * EDGE + 0.008), Some(Sides::Both)).unwrap().0.into())
        };
        let mut scene = scene(vec![wall], diameter, Vector3::zeros());
        scene.walls[0].surface = surface(1.0, 0.0);
        let dt = step(&scene);
        // an elastic sphere whose centre reaches a surface had an impact speed above ω r; here 1.3 to 30 times ω r
        let omega = (STIFFNESS / scene.species[0].mass()).sqrt();
        let speed = omega * 0.5 * diameter * (1.3 + 28.7 * random.random::<f64>().powi(2));
        let axis = Unit::new_normalize(Vector3::z());
        let lean = 0.4 * (random.random::<f64>() - 0.5);
        let direction = UnitQuaternion::from_axis_angle(&axis, lean) * Vector3::x();
        let engine = if number % 4 < 2 { local } else { soft };
        let particles = placed(&scene, &[(middle().into(), (direction * speed / lean.cos()).into())]);
        let engine = engine(STIFFNESS, dt, Integrator::VelocityVerlet);
        let mut simulation = Simulation::with_engine(scene.clone(), particles, engine);
        let result = simulation.run(1, 0.012 / speed);
        let Err(Failure::OverlapTooLarge { ratio, .. }) = result else {
            panic!("{number}: {result:?} at {speed} m/s, now at {:?}", simulation.particles.position[0])
        };
        assert!(ratio >= 0.4, "{number}: overlap {ratio}");
    }
}

/// A sphere that does not rotate stays at rest on an incline below the angle of friction, for any time step.
#[test]
fn what_friction_holds_does_not_creep() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/inputs/incline.toml")).unwrap();
    for model in [Model::Soft, Model::Hybrid] {
        for sets in [
            &[][..],
            &["soft.linear_spring_dashpot.stiffness=\"50 N/m\""],
            &["soft.stepping=\"uniform\""],
            &["soft.stepping=\"local\""],
            &["soft.integrator=\"rk2\"", "soft.stepping=\"local\"", "run.duration=\"0.05 s\""],
        ] {
            let experiment = case(&text, model, sets).unwrap();
            let mut simulation = Simulation::new(&experiment, initial_state(&experiment).unwrap());
            simulation.run(50, 1e-3).unwrap();
            let (x, v) = (simulation.particles.position[0].x, simulation.particles.velocity[0].x);
            // an error of g_t Δt/2 = 1e-5 m/s or more would make the sphere creep for ever; it may slide only at first,
            // until it is pressed in
            assert!(v.abs() < 1e-12, "{model:?} {sets:?}: creeps at {v:e} m/s");
            simulation.run(20, 1e-3).unwrap();
            let crept = simulation.particles.position[0].x - x;
            assert!(crept.abs() < 1e-12, "{model:?} {sets:?}: crept {crept:e} m");
        }
    }
}

/// Above the angle of friction, the sphere slides with the acceleration g_t - μ g_n: gravity along the plane, minus
/// the friction coefficient times gravity normal to the plane.
#[test]
fn what_friction_does_not_hold_slides() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/inputs/incline.toml")).unwrap();
    for model in [Model::Soft, Model::Hybrid] {
        let experiment = case(&text, model, &["walls[0].friction=0.1"]).unwrap();
        let mut simulation = Simulation::new(&experiment, initial_state(&experiment).unwrap());
        simulation.run(50, 1e-3).unwrap();
        let before = simulation.particles.velocity[0].x;
        simulation.run(100, 1e-3).unwrap();
        let gained = simulation.particles.velocity[0].x - before;
        let expected = (1.7035 - 0.1 * 9.661) * 0.1;
        assert!((gained / expected - 1.0).abs() < 1e-6, "{model:?}: {gained} of {expected} m/s");
        let ledger = &simulation.record.ledger;
        assert!(ledger.wall_friction_loss > 0.0);
    }
}

/// Elastic spheres on a floor oscillate for ever with the energy of their weight. The effect of rounding on this energy
/// must not be reported as a fault of the time step.
#[test]
fn elastic_spheres_at_rest_run_on() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/inputs/incline.toml")).unwrap();
    let still = ["gravity.acceleration=[0, -9.81, 0]", "walls[0].restitution=1", "contact.restitution=1"];
    for model in [Model::Soft, Model::Hybrid] {
        for stiffness in ["100 N/m", "5000 N/m", "1e6 N/m"] {
            for steps in [20, 50] {
                let stiff = format!("soft.linear_spring_dashpot.stiffness=\"{stiffness}\"");
                let steps = format!("soft.steps_per_contact={steps}");
                let sets = [&still[..], &["walls[0].friction=0", &stiff, &steps]].concat();
                let experiment = case(&text, model, &sets).unwrap();
                let mut simulation = Simulation::new(&experiment, initial_state(&experiment).unwrap());
                for _ in 0..50 {
                    simulation.run(1, 1e-3).unwrap_or_else(|why| panic!("{model:?} {sets:?}: {why}"));
                }
            }
        }
    }
}

/// Hard spheres that slide along a concave wall and lose energy stop with a message. Along a plane they do not stop.
#[test]
fn sliding_along_a_concave_wall_is_told_from_coming_to_rest() {
    let bowl = WallGeometry::Hollow(Hollow::new(Cavity::Sphere { center: middle(), radius: 0.015 }));
    let contact = surface(0.9, 0.0);
    let scene = Scene { walls: vec![Wall::new(bowl, contact)], ..empty([EDGE; 3], [false; 3], large(), contact) };
    let particles = placed(&scene, &[((middle() + Vector3::new(0.014, 0.0, 0.0)).into(), [0.05, 3.0, 0.0])]);
    let mut simulation =
        Simulation::with_engine(scene.clone(), particles, Box::new(diptych::engine::hard::Hard::new()));
    let why = simulation.run(100, 1e-3).unwrap_err();
    assert!(why.to_string().contains("it slides along the curved wall at 2.9"), "{why}");

    let floor = Wall::new(WallGeometry::Plane(Plane { point: Vector3::zeros(), normal: Vector3::y() }), contact);
    let scene = Scene { walls: vec![floor], gravity: Vector3::new(0.0, -9.81, 0.0), ..scene };
    let particles = placed(&scene, &[([0.01, 0.01, 0.01], [0.01, 0.0, 0.0])]);
    let mut simulation = Simulation::with_engine(scene, particles, Box::new(diptych::engine::hard::Hard::new()));
    let why = simulation.run(1000, 1e-3).unwrap_err();
    assert!(why.to_string().contains("hard spheres cannot rest"), "{why}");
}
