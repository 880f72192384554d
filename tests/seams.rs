//! Drag laws and wall shapes that a calling program defines. They implement only the methods that a trait requires.

use crate::support::{empty, hard, large, placed, run, small, soft, surface, unit};
use diptych::drag::{Drag, DragLaw, Kick, SchillerNaumann, Sphere, Stokes};
use diptych::experiment::Integrator;
use diptych::fluid::{Fluid, Profile};
use diptych::walls::{Flight, Geometry, Nearest, Obstacle, Plane, Wall, WallGeometry};
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::sync::Arc;

/// Drag law of this library without its closed forms: it gives only the response time.
#[derive(Debug)]
struct Bare<L>(L);

impl<L: DragLaw> DragLaw for Bare<L> {
    fn name(&self) -> &'static str {
        "bare"
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        self.0.parameters()
    }

    fn response_time(&self, sphere: &Sphere, slip: f64) -> f64 {
        self.0.response_time(sphere, slip)
    }
}

/// Law of Clift and Gauvin (1970): C_D = 24/Re (1 + 0.15 Re^0.687) + 0.42/(1 + 42500 Re^-1.16). It has no closed form.
#[derive(Debug)]
struct CliftGauvin;

impl DragLaw for CliftGauvin {
    fn name(&self) -> &'static str {
        "clift_gauvin"
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    fn response_time(&self, sphere: &Sphere, slip: f64) -> f64 {
        let reynolds = sphere.reynolds_per_speed * slip;
        let wake = if reynolds > 0.0 { 0.42 / 24.0 * reynolds / (1.0 + 42_500.0 * reynolds.powf(-1.16)) } else { 0.0 };
        sphere.stokes_time / (1.0 + 0.15 * reynolds.powf(0.687) + wake)
    }
}

fn gas(drag: Drag) -> Fluid {
    Fluid::new(1.205, 1.515e-5, Profile::Uniform(8.0), Some(drag))
}

fn spheres() -> [Sphere; 2] {
    [small(), large()].map(|species| gas(Drag::Stokes(Stokes)).sphere(&species))
}

#[test]
fn a_law_is_integrated_as_well_as_its_closed_form() {
    // The large sphere passes Re = 1000 at 10.1 m/s. The slip speeds of the test are below and above this speed, and
    // some kicks cross the jump of the law.
    let (mut worst, mut relaxation) = (0.0f64, 0.0f64);
    for sphere in spheres() {
        for slip in [0.0, 1e-9, 1e-3, 0.3, 5.0, 10.0, 10.2, 12.0, 18.0, 40.0, 400.0] {
            for duration in [1e-12, 1e-6, 1e-4, 1e-2, 0.5, 3.0, 40.0, 1e4] {
                let exact = SchillerNaumann.log_decay(&sphere, slip, duration);
                let found = Bare(SchillerNaumann).log_decay(&sphere, slip, duration);
                worst = worst.max((found / exact - 1.0).abs());
                let stokes = Bare(Stokes).log_decay(&sphere, slip, duration);
                worst = worst.max((stokes * sphere.stokes_time / duration + 1.0).abs());
            }
            // the differences extend by a thousandth of the slip speed to either side; this interval must not include
            // the jump
            if (sphere.reynolds_per_speed * slip / 1000.0 - 1.0).abs() > 2e-3 {
                let exact = SchillerNaumann.relaxation_time(&sphere, slip);
                relaxation = relaxation.max((Bare(SchillerNaumann).relaxation_time(&sphere, slip) / exact - 1.0).abs());
            }
        }
    }
    // the accuracy promised by the trait
    assert!(worst < 1e-12, "log decay off by {worst:.1e}");
    assert!(relaxation < 1e-10, "relaxation time off by {relaxation:.1e}");
}

#[test]
fn a_law_without_a_closed_form_takes_the_time_of_its_quadrature() {
    // By dw/dt = -w/τ(w), the time between two slip speeds is ∫ τ d(ln w). Simpson's rule on 4000 intervals of ln w has
    // an error (Δ/180 per unit length, fourth power) below 1e-13 here.
    for sphere in spheres() {
        for (slip, duration) in [(0.01, 1e-4), (1.0, 1e-2), (18.0, 1e-6), (18.0, 0.3), (60.0, 1.0)] {
            let log = CliftGauvin.log_decay(&sphere, slip, duration);
            let intervals = 4000;
            let time = |k: usize| CliftGauvin.response_time(&sphere, slip * (log * k as f64 / intervals as f64).exp());
            let weight = |k: usize| {
                if k == 0 || k == intervals {
                    1.0
                } else if k % 2 == 1 {
                    4.0
                } else {
                    2.0
                }
            };
            let sum: f64 = (0..=intervals).map(|k| weight(k) * time(k)).sum();
            let taken = -log / intervals as f64 / 3.0 * sum;
            assert!((taken / duration - 1.0).abs() < 2e-12, "{slip} m/s for {duration} s: {taken} s");
        }
    }
}

#[test]
fn a_law_that_is_no_number_ends() {
    let broken = Bare(Stokes);
    let sphere = Sphere { stokes_time: f64::NAN, reynolds_per_speed: 1.0, fraction: 0.0 };
    assert!(broken.log_decay(&sphere, 1.0, 1.0).is_nan());
    let sphere = Sphere { stokes_time: 0.0, ..sphere };
    assert!(broken.log_decay(&sphere, 1.0, 1.0).is_nan());
}

#[test]
fn a_law_of_the_callers_runs_in_a_simulation() {
    let drag = Drag::Other(Arc::new(CliftGauvin));
    let mut scene = empty([0.1; 3], [true; 3], small(), surface(1.0, 0.0));
    scene.fluid = Some(gas(drag.clone()));
    let sphere = scene.fluid.as_ref().unwrap().sphere(&scene.species[0]);
    let v = [0.3, -0.2, 1.0];
    let slip = Vector3::from(v) - Vector3::new(0.0, 0.0, 8.0);
    let want = slip * CliftGauvin.decay(&sphere, slip.norm(), 0.02);
    for engine in [hard(), soft(3000.0, 1e-5, Integrator::VelocityVerlet)] {
        let end = run(&scene, placed(&scene, &[([0.05; 3], v)]), engine, 0.02, 10);
        let found = end.particles.velocity[0] - Vector3::new(0.0, 0.0, 8.0);
        // ten kicks with an error of 1e-12 each
        assert!((found - want).norm() < 1e-11 * slip.norm(), "{found:?} against {want:?}");
    }
    // the table for many particles also follows from this law
    let (table, exact) = (Kick::tabulated(&drag, &[sphere], 1e-4), Kick::exact(&drag, &[sphere], 1e-4));
    for square in [1e-8, 1e-3, 0.7, 11.0, 300.0] {
        assert!((table.change(0, square) / exact.change(0, square) - 1.0).abs() < 1e-9);
    }
}

/// Shape of this library without its closed form for the time of touch: it gives only the nearest point.
#[derive(Debug)]
struct Nearby<G>(G);

impl<G: Geometry> Geometry for Nearby<G> {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        self.0.nearest(point)
    }
}

/// Inside of a hollow ball. It is not convex, and only its nearest point is given.
#[derive(Debug)]
struct Hollow {
    center: Vector3<f64>,
    radius: f64,
}

impl Geometry for Hollow {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let out = point - self.center;
        let normal = -out.try_normalize(0.0).unwrap_or_else(Vector3::y);
        Nearest { distance: self.radius - out.norm(), normal }
    }
}

/// Directions that are evenly distributed over the sphere (Fibonacci's lattice).
fn directions(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    (0..count).map(move |k| {
        let z = 1.0 - 2.0 * (k as f64 + 0.5) / count as f64;
        let angle = 2.399_963_229_728_653 * k as f64;
        let r = (1.0 - z * z).sqrt();
        Vector3::new(r * angle.cos(), r * angle.sin(), z)
    })
}

#[test]
fn a_shape_that_only_knows_its_nearest_point_is_touched_when_its_closed_form_says() {
    let center = Vector3::new(0.3, -0.2, 0.1);
    let half = Vector3::new(1.0, 0.7, 1.2);
    let (radius, gravity) = (0.25, Vector3::new(0.1, -0.9, 0.2));
    let plane = Plane { point: center, normal: Vector3::new(0.3, 1.0, -0.2).normalize() };
    let shapes: [(Box<dyn Geometry>, Box<dyn Geometry>); 4] = [
        (Box::new(plane), Box::new(Nearby(plane))),
        (Box::new(Obstacle::sphere(center, 0.8)), Box::new(Nearby(Obstacle::sphere(center, 0.8)))),
        (Box::new(Obstacle::cuboid(center, half)), Box::new(Nearby(Obstacle::cuboid(center, half)))),
        (Box::new(Obstacle::cylinder(center, 2, 0.6, 0.9)), Box::new(Nearby(Obstacle::cylinder(center, 2, 0.6, 0.9)))),
    ];
    let (mut touched, mut missed) = (0, 0);
    for (own, bare) in &shapes {
        for (k, from) in directions(60).enumerate() {
            for gravity in [Vector3::zeros(), gravity] {
                let position = center + 3.0 * from;
                if own.nearest(&position).distance < radius {
                    continue;
                }
                // flights to points in and around the body: hits, grazing hits and misses
                let target = center + 1.3 * directions(7).nth(k % 7).unwrap();
                let flight = Flight { position, velocity: (target - position).normalize(), gravity };
                let (want, found) = (own.touch_time(&flight, radius, 6.0), bare.touch_time(&flight, radius, 6.0));
                let (Some(want), Some(found)) = (want, found) else {
                    // if rounding hides the normal speed of a touch, one method may find the touch and the other one
                    // not
                    assert_eq!(want.is_some(), found.is_some(), "{own:?} {flight:?}");
                    missed += 1;
                    continue;
                };
                touched += 1;
                // both flights end within rounding of the surface; in a grazing flight, the error of the time is the
                // rounding of the gap over the normal speed
                let along = flight.velocity_at(want).dot(&own.nearest(&flight.position_at(want)).normal).abs();
                assert!((want - found).abs() < 1e-13 / along.max(1e-7) + 1e-13, "{want} {found} {own:?} {flight:?}");
            }
        }
    }
    assert!(touched > 150 && missed > 50, "{touched} touched, {missed} missed");
}

#[test]
fn a_sphere_that_leaves_a_shape_is_free_and_one_that_presses_touches_at_once() {
    let hollow = Hollow { center: Vector3::zeros(), radius: 2.0 };
    // at the bottom of the bowl, and one rounding error inside or outside of it
    for off in [-1e-16, 0.0, 1e-16] {
        let position = Vector3::new(0.0, -1.5 + off, 0.0);
        let flight = |v: [f64; 3], g: f64| Flight { position, velocity: v.into(), gravity: Vector3::new(0.0, -g, 0.0) };
        // straight up, across the diameter of the region of possible centres
        let across = hollow.touch_time(&flight([0.0, 1.0, 0.0], 0.0), 0.5, 5.0).unwrap();
        assert!((across - 3.0).abs() < 1e-12, "{across}");
        // up and down again, in the time 2 v/g
        let back = hollow.touch_time(&flight([0.0, 1.0, 0.0], 2.0), 0.5, 5.0).unwrap();
        assert!((back - 1.0).abs() < 1e-12, "{back}");
        let pressed = hollow.touch_time(&flight([0.0, -1.0, 0.0], 0.0), 0.5, 5.0).unwrap();
        assert!(pressed < 1e-15, "{pressed}");
        assert_eq!(hollow.touch_time(&flight([0.0, 0.0, 0.0], 0.0), 0.5, 5.0), None);
    }
}

#[test]
fn both_engines_keep_spheres_in_a_bowl_of_the_callers() {
    // Chords of the hollow ball: by symmetry, all flights between two impacts have the same length and the same angle
    // to the normal.
    let (center, reach) = (Vector3::repeat(5.0), 3.0);
    let mut scene = empty([10.0; 3], [false; 3], unit(), surface(1.0, 0.0));
    let hollow = Hollow { center, radius: reach + 0.5 };
    let geometry = WallGeometry::Other(Arc::new(hollow));
    scene.walls = vec![Wall::new(geometry, surface(1.0, 0.0))];
    let v = Vector3::new(0.6, 0.0, 0.8);
    let start = center + Vector3::new(1.0, 1.2, -0.4);
    // |start + v t - center| = reach
    let from = start - center;
    let along = from.dot(&v);
    let first = -along + (along * along + reach * reach - from.norm_squared()).sqrt();
    let chord = 2.0 * (along + first);
    let impacts = 6;
    let duration = first + (f64::from(impacts) - 0.5) * chord;
    let end = run(&scene, placed(&scene, &[(start.into(), v.into())]), hard(), duration, 9);
    assert_eq!(end.record.walls.count, 6);
    let place = end.particles.position[0] - center;
    // in the middle of a chord, the position vector from the centre is perpendicular to the velocity, and the surface
    // is half a chord away
    assert!(place.dot(&end.particles.velocity[0]).abs() < 1e-11);
    assert!((place.norm() - (reach * reach - 0.25 * chord * chord).sqrt()).abs() < 1e-11);
    assert!((end.particles.velocity[0].norm() - 1.0).abs() < 1e-12);

    // Soft spheres: each impact lasts a contact time, with an overlap of less than u/ω. The sphere moves during the
    // contact, which turns the next chord by v T_c/R = 1e-3 per impact.
    let stiffness = 1e6_f64;
    let time = PI / stiffness.sqrt();
    let engine = soft(stiffness, time / 100.0, Integrator::VelocityVerlet);
    let end = run(&scene, placed(&scene, &[(start.into(), v.into())]), engine, duration, 9);
    assert_eq!(end.record.walls.count, 6);
    let place = end.particles.position[0] - center;
    assert!((place.norm() - (reach * reach - 0.25 * chord * chord).sqrt()).abs() < 6.0 * 2.0 * time);
    // A step that begins before the touch misses the spring force over at most half of the step. The missing work is at
    // most k (u Δt/2)²/2, which is (ω Δt)²/4 of the energy of the impact. The end of a contact has the same error, and
    // there are six contacts.
    let most = 6.0 * 2.0 * (PI / 100.0).powi(2) / 4.0;
    let energy = end.particles.velocity[0].norm_squared();
    assert!((energy - 1.0).abs() < most, "{energy}");
}

/// Stokes drag with a factor that the calling program chooses.
#[derive(Debug)]
struct Scaled(f64);

impl DragLaw for Scaled {
    fn name(&self) -> &'static str {
        "scaled_stokes"
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("factor", self.0)]
    }

    fn response_time(&self, sphere: &Sphere, _slip: f64) -> f64 {
        sphere.stokes_time / self.0
    }
}

/// Laws with the same name and different parameters are different laws. Otherwise a sweep over the parameter would be a
/// single run.
#[test]
fn laws_that_differ_in_a_parameter_are_two_laws() {
    let [one, same, other] = [2.0, 2.0, 2.5].map(|factor| Drag::Other(Arc::new(Scaled(factor))));
    assert!(one == same && one != other && one != Drag::Stokes(Stokes));
    let written = |drag: &Drag| serde_json::to_string(drag).unwrap();
    assert_eq!(written(&one), "{\"scaled_stokes\":{\"factor\":2.0}}");
    assert_ne!(written(&one), written(&other));
    assert_eq!(written(&Drag::Stokes(Stokes)), "\"stokes\"");
}
