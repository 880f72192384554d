//! Spheres in grooves and corners of meshes, where they touch several faces, and now one face, now another is the
//! nearest. Each spring belongs to its face, so that a mesh acts as the planes of its faces.

use super::*;
use diptych::walls::{Mesh, Sides, Wall, WallGeometry};

/// [N/m] normal stiffness of the contacts.
const STIFFNESS: f64 = 1e4;
/// [m] radius of the ball.
const RADIUS: f64 = 1e-3;
/// [m] distance of the ball from the middle at the start, so that it touches the faces one after the other.
const ASIDE: f64 = 1e-6;
/// [m] lowest point of the groove or corner.
const BOTTOM: [f64; 3] = [0.1, 0.1, 0.1];

/// Faces at the bottom with the given normals, as planes or as one mesh.
fn walls(normals: &[Vector3<f64>], as_mesh: bool, of: diptych::Surface) -> Vec<Wall> {
    if !as_mesh {
        return normals.iter().map(|normal| plane(BOTTOM, (*normal).into(), of)).collect();
    }
    let bottom = Vector3::from(BOTTOM);
    let triangles: Vec<[Vector3<f64>; 3]> = normals.iter().flat_map(|normal| face(&bottom, normal, normals)).collect();
    let mesh = Mesh::new("faces", &triangles, Some(Sides::Both)).unwrap().0;
    vec![Wall::new(WallGeometry::Mesh(Arc::new(mesh)), of)]
}

/// Part of a plane through `bottom` that is in front of the planes with the other `normals`, as triangles.
fn face(bottom: &Vector3<f64>, normal: &Vector3<f64>, normals: &[Vector3<f64>]) -> Vec<[Vector3<f64>; 3]> {
    let size = 0.05;
    let edges: Vec<Vector3<f64>> = normals.iter().filter(|other| *other != normal).map(|o| normal.cross(o)).collect();
    match edges.as_slice() {
        // a groove: a rectangle next to the edge
        [edge] => {
            let along = edge.normalize() * size;
            let beside = along.cross(normal).normalize() * size;
            let beside = if normals.iter().any(|other| beside.dot(other) < -1e-9) { -beside } else { beside };
            let [a, b, c, d] = [bottom - along, bottom + along, bottom + along + beside, bottom - along + beside];
            vec![[a, b, c], [a, c, d]]
        }
        // a corner: a triangle between two edges
        [one, other] => {
            let up = |edge: &Vector3<f64>| edge.normalize() * size * edge.y.signum();
            vec![[*bottom, bottom + up(one), bottom + up(other)]]
        }
        _ => Vec::new(),
    }
}

/// Motion of a ball that is thrown at `speed` [m/s] from its rest position: position, velocity and surface speed by the
/// spin. Also its losses to friction [J], the losses of springs of contacts that end, mean duration of an impact [s],
/// and number of impacts.
fn thrown(
    normals: &[Vector3<f64>],
    as_mesh: bool,
    stepping: SoftStepping,
    speed: f64,
) -> ([Vector3<f64>; 3], [f64; 3], u64) {
    let of = surface(0.6, 0.4);
    let species = Species { diameter: 2.0 * RADIUS, density: 2500.0, ..small() };
    let mut scene = empty([0.2; 3], [false; 3], species.clone(), of);
    scene.walls = walls(normals, as_mesh, of);
    scene.gravity = Vector3::new(0.0, -9.81, 0.0);
    let tangential = TangentialLaw::Linear(LinearTangential::Ratios { stiffness: 2.0 / 7.0, dashpot: 0.3 });
    scene.rotation = Some(Rotation::new(tangential, ImpactRule::COULOMB));
    // all faces have the same inclination
    let height = RADIUS / normals[0].y + 2.0 * ASIDE;
    let velocity = [0.3 * speed, 0.1 * speed, speed];
    let start = [BOTTOM[0] + ASIDE, BOTTOM[1] + height, BOTTOM[2] + 0.7 * ASIDE];
    let mut particles = placed(&scene, &[(start, velocity)]);
    scene.let_rotate(&mut particles);
    particles.spin.as_mut().unwrap()[0] = Vector3::new(20.0, 50.0, -30.0);
    let law = ContactLaw::linear(STIFFNESS);
    let step = law.contact_time(&law.between(&Bodies::of_wall(&species, &of, None)), 1.0) / 50.0;
    let engine = Soft::new(law, Integrator::VelocityVerlet, step, stepping);
    let mut simulation = Simulation::with_engine(scene, particles, Box::new(engine));
    simulation.run(200, 1e-4).unwrap();
    let Particles { position, velocity, .. } = &simulation.particles;
    let (ledger, impacts) = (&simulation.record.ledger, &simulation.record.walls);
    let duration = impacts.summary().mean_duration.unwrap_or_default();
    (
        [position[0], velocity[0], simulation.particles.spin_of(0) * RADIUS],
        [ledger.wall_friction_loss, ledger.friction.separation, duration],
        impacts.count,
    )
}

/// Normals of faces that are inclined to the vertical by `angle` [°], at equal angles about the vertical.
fn inclined(count: usize, angle: f64) -> Vec<Vector3<f64>> {
    let (sin, cos) = angle.to_radians().sin_cos();
    let around = |k: usize| std::f64::consts::TAU * k as f64 / count as f64;
    (0..count).map(|k| Vector3::new(sin * around(k).cos(), cos, sin * around(k).sin())).collect()
}

/// While the ball oscillates for 20 ms, the order of its contacts (nearest face first) changes some hundred times. The
/// normals of a mesh and of planes differ by rounding of 1e-16, which grows with the number of contacts.
#[test]
fn a_ball_in_a_groove_or_corner_of_a_mesh_moves_as_between_planes() {
    for (count, angle) in [(2, 30.0), (2, 50.0), (3, 40.0)] {
        let normals = inclined(count, angle);
        for stepping in [SoftStepping::Local, SoftStepping::Uniform] {
            for speed in [1e-3, 3e-2] {
                let (planes, lost, impacts) = thrown(&normals, false, stepping, speed);
                let (mesh, lost_at_mesh, at_mesh) = thrown(&normals, true, stepping, speed);
                let name = format!("{count} faces, {angle}°, {stepping:?}, {speed} m/s");
                for ((found, expected), scale) in mesh.iter().zip(&planes).zip([RADIUS, speed, speed]) {
                    let apart = (found - expected).norm();
                    assert!(apart < 1e-6 * scale, "{name}: {found:?} and {expected:?}");
                }
                for (found, expected) in lost_at_mesh.iter().zip(lost) {
                    assert!((found - expected).abs() <= 1e-6 * lost[0].max(expected), "{name}: {found} and {expected}");
                }
                assert_eq!(at_mesh, impacts, "{name}");
            }
        }
    }
}
