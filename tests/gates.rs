//! Inlets and outlets against closed forms: sums over the particles that pass an outlet, ids of starts with gaps, and
//! a gate that opens at a time.

use crate::support::*;
use diptych::Vector3;
use diptych::engine::Engine;
use diptych::rotation::{ImpactRule, Rotation, TangentialLaw};
use diptych::scene::{Inlet, Outlet, OutletShape};
use diptych::simulation::Simulation;
use diptych::walls::{Cavity, Hollow, PiecewisePath, Plane, PrescribedMotion};
use diptych::{Particles, Scene};

/// Outlet behind a plane across z, for particles beyond `z` [m].
fn end(z: f64) -> Outlet {
    let plane = Plane { point: Vector3::new(0.0, 0.0, z), normal: Vector3::new(0.0, 0.0, -1.0) };
    Outlet { name: "end".into(), shape: OutletShape::Behind(plane) }
}

/// Two spheres fall freely and pass the outlet in different windows (pieces of the run); a third one stays. All sums
/// are those of the states at the ends of the windows in which the spheres pass.
#[test]
fn an_outlet_sums_what_passes_it() {
    let g = Vector3::new(0.3, -0.2, 0.5);
    let scene = empty([10.0, 10.0, 40.0], [true, true, false], unit(), surface(1.0, 0.0));
    let rotation = Some(Rotation::new(TangentialLaw::Coulomb, ImpactRule::COULOMB));
    let scene = Scene { gravity: g, rotation, outlets: vec![end(10.0)], ..scene };
    let list = [([2.0, 2.0, 9.0], [0.1, 0.2, 3.0]), ([6.0, 6.0, 6.5], [0.0, -0.4, 4.0]), ([4.0, 4.0, 2.0], [0.0; 3])];
    let mut start = placed(&scene, &list);
    scene.let_rotate(&mut start);
    let spins = [[0.5, 0.0, 1.0], [0.0, 2.0, 0.0], [0.0; 3]].map(Vector3::from);
    start.spin.as_mut().unwrap().copy_from_slice(&spins);
    let mut simulation = Simulation::with_engine(scene.clone(), start.clone(), hard());
    simulation.run(10, 0.1).unwrap();
    // z = 9 + 3 t + t²/4 passes 10 at 0.33 s, z = 6.5 + 4 t + t²/4 at 0.83 s
    let passed = [(0, 0.4), (1, 0.9)].map(|(k, t): (usize, f64)| {
        let (x, v) = (Vector3::from(list[k].0), Vector3::from(list[k].1));
        (x + v * t + 0.5 * t * t * g, v + t * g, spins[k])
    });
    let found = simulation.through_flow().unwrap().outlets[0].totals();
    let mass = scene.species[0].mass();
    // 2/5 m r² of a solid sphere
    let inertia = 0.4 * mass * 0.25;
    let sum = |of: &dyn Fn(&(Vector3<f64>, Vector3<f64>, Vector3<f64>)) -> f64| passed.iter().map(of).sum::<f64>();
    assert_eq!(found.count, 2);
    // rounding of ten windows
    for (what, found, exact) in [
        ("mass", found.mass, 2.0 * mass),
        ("momentum along x", found.momentum.x, sum(&|(_, v, _)| mass * v.x)),
        ("momentum along y", found.momentum.y, sum(&|(_, v, _)| mass * v.y)),
        ("momentum along z", found.momentum.z, sum(&|(_, v, _)| mass * v.z)),
        ("kinetic energy", found.kinetic_energy, sum(&|(_, v, _)| 0.5 * mass * v.norm_squared())),
        ("rotational energy", found.rotational_energy, sum(&|(_, _, w)| 0.5 * inertia * w.norm_squared())),
        ("potential energy", found.potential_energy, sum(&|(x, _, _)| -mass * g.dot(x))),
        ("sum of speeds", found.speed, sum(&|(_, v, _)| v.norm())),
    ] {
        close(what, found, exact, 1e-12 * mass.max(1.0) * exact.abs().max(1.0));
    }
}

/// New particles get ids above the largest one of the start, also where that start has gaps in its ids.
#[test]
fn ids_of_new_particles_are_above_those_of_the_start() {
    let scene = empty([10.0; 3], [true; 3], unit(), surface(1.0, 0.0));
    let region = Hollow::new(Cavity::Box { center: Vector3::repeat(5.0), half_extents: Vector3::repeat(4.0) });
    let none = Vector3::zeros();
    let inlet = Inlet {
        name: "feed".into(),
        species: 0,
        region,
        rate: 10.0,
        start: 0.0,
        end: f64::INFINITY,
        velocity_mean: none,
        velocity_fluctuation: none,
        spin_mean: none,
        spin_fluctuation: 0.0,
    };
    let scene = Scene { inlets: vec![inlet], ..scene };
    let ids = |start: &[u32]| {
        let places = [([0.6, 0.6, 0.6], [0.0; 3]), ([9.4, 9.4, 9.4], [0.0; 3])];
        let mut particles: Particles = placed(&scene, &places[..start.len()]);
        particles.id.copy_from_slice(start);
        let mut simulation = Simulation::with_engine(scene.clone(), particles, hard()).with_seed(3);
        simulation.run(2, 0.1).unwrap();
        simulation.particles.id.clone()
    };
    // particles are due at 0, 0.1 and 0.2 s
    assert_eq!(ids(&[3, 41]), [3, 41, 42, 43, 44]);
    assert_eq!(ids(&[]), [0, 1, 2]);
    // no id is left after the largest one, and nothing comes in
    assert_eq!(ids(&[7, u32::MAX - 1]), [7, u32::MAX - 1, u32::MAX]);
}

/// A sphere that has just crossed a periodic side is in an outlet at the other side, although its stored position is
/// still beyond the side it has crossed.
#[test]
fn an_outlet_takes_what_has_crossed_a_periodic_side() {
    let scene = empty([10.0, 10.0, 10.0], [true, true, false], unit(), surface(1.0, 0.0));
    let first =
        Hollow::new(Cavity::Box { center: Vector3::new(0.5, 5.0, 5.0), half_extents: Vector3::new(0.5, 5.0, 5.0) });
    let outlets = vec![Outlet { name: "first".into(), shape: OutletShape::Body(first) }];
    // the sphere is at x = 10.2 after the window
    let start = placed(&scene, &[([9.9, 5.0, 5.0], [3.0, 0.0, 0.0]), ([5.0, 5.0, 2.0], [0.0; 3])]);
    let mut simulation = Simulation::with_engine(Scene { outlets, ..scene }, start, hard());
    simulation.run(1, 0.1).unwrap();
    assert_eq!(simulation.particles.id, [1]);
}

/// A gate moves away at 1.5 s. A sphere that reaches it 0.01 s before this time comes back; a sphere that reaches it
/// 0.02 s after this time leaves.
#[test]
fn a_gate_opens_at_its_time() {
    let soft: fn() -> Box<dyn Engine> = || soft(4e6, 5e-6, diptych::experiment::Integrator::VelocityVerlet);
    for (name, engine) in [("hard", hard as fn() -> Box<dyn Engine>), ("soft", soft)] {
        let away = Vector3::new(0.0, 0.0, 500.0);
        let open = PiecewisePath::new(vec![(1.5, Vector3::zeros()), (1.501, away)]).unwrap();
        let gate = plane([0.0, 0.0, 8.0], [0.0, 0.0, -1.0], surface(1.0, 0.0));
        let gate = gate.moving(PrescribedMotion::Path(open.into())).unwrap();
        let scene = empty([10.0, 10.0, 600.0], [true, true, false], unit(), surface(1.0, 0.0));
        let scene = Scene { walls: vec![gate], outlets: vec![end(9.0)], ..scene };
        // spheres touch the gate at z = 7.5
        let at = |x: f64, speed: f64, time: f64| ([x, 5.0, 7.5 - speed * time], [0.0, 0.0, speed]);
        let start = placed(&scene, &[at(2.0, 3.0, 1.49), at(6.0, 3.0, 1.52)]);
        let mut simulation = Simulation::with_engine(scene, start, engine());
        simulation.run(11, 0.2).unwrap();
        let flow = simulation.through_flow().unwrap().outlets[0].totals();
        assert_eq!((flow.count, simulation.particles.id.as_slice()), (1, &[0][..]), "{name}");
        // 2.2 s: 0.71 s after the touch; a soft contact lasts π sqrt(m/k) = 1.6 ms
        let (position, velocity) = (simulation.particles.position[0].z, simulation.particles.velocity[0].z);
        close(name, velocity, -3.0, 1e-3);
        close(name, position, 7.5 - 3.0 * 0.71, 6e-3);
    }
}
