//! A gas in vessels of triangles: no sphere leaves, and the energy is conserved.

use super::heaps::{Heap, ball, torus};
use super::{mesh, wall};
use crate::support::*;
use diptych::engine::Engine;
use diptych::experiment::Integrator::VelocityVerlet;
use diptych::simulation::Simulation;
use diptych::walls::{Geometry, Mesh, Sides};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Closed vessels of at least 10,000 triangles, in a box of 16 m, or larger by the factor `times`.
pub fn vessels(times: f64) -> [(&'static str, Mesh); 2] {
    let center = Vector3::repeat(8.0 * times);
    let round = |heap: Heap| mesh(&heap, Some(Sides::Inside));
    [
        ("sphere", round(ball(center, 6.0 * times, 5))),
        ("torus", round(torus(center, [5.0 * times, 2.5 * times], 120, 60))),
    ]
}

/// Elastic gas in a vessel, with m = kT = 1.
struct Gas<'a> {
    vessel: &'a Mesh,
    /// [m] edge of the box around the vessel.
    edge: f64,
    spheres: usize,
    /// Stiffness [N/m] of the contacts.
    stiffness: f64,
    /// Number of time steps in the shortest contact, which is the contact of two spheres.
    steps_per_contact: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Hard,
    Local,
    Uniform,
}

impl Gas<'_> {
    fn time_step(&self) -> f64 {
        PI * (0.5 / self.stiffness).sqrt() / self.steps_per_contact
    }

    fn engine(&self, way: Way) -> Box<dyn Engine> {
        match way {
            Way::Hard => hard(),
            Way::Local => local(self.stiffness, self.time_step(), VelocityVerlet),
            Way::Uniform => soft(self.stiffness, self.time_step(), VelocityVerlet),
        }
    }

    /// [1/m] sum over all seams of the vessel, divided by its area. The term of a seam (edge between two triangles) is
    /// its length times the square of the angle between the triangles.
    fn seams(&self) -> f64 {
        let (points, triangles) = self.vessel.triangles();
        let (mut area, mut sum, mut open) = (0.0, 0.0, BTreeMap::new());
        for (corners, normal) in triangles.zip(self.vessel.normals()) {
            let [a, b, c] = corners.map(|corner| points[corner as usize]);
            area += 0.5 * (b - a).cross(&(c - a)).norm();
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                if let Some(other) = open.insert((a.min(b), a.max(b)), normal) {
                    sum += (points[a as usize] - points[b as usize]).norm() * normal.angle(other).powi(2);
                }
            }
        }
        sum / area
    }

    /// [J] largest change of the energy that the methods explain, for the given numbers of impacts.
    ///
    /// Hard spheres: each impact has a rounding error, on average at most 1e-15 of its energy.
    ///
    /// Soft spheres, each impact alone: its energy M u²/2 has the mean kT and the mean square 2 (kT)². The Runge-Kutta
    /// scheme of fourth order loses (ω dt)⁶/72 of the energy of an oscillator in a step, and π⁶/(72 N⁵) in a contact of
    /// N steps; a wall has √2 times the steps of a pair. The change by Verlet's scheme depends on the phase;
    /// `gain_of_an_impact` computes its mean and deviation.
    ///
    /// Soft spheres, at seams: the direction of a force F jumps by the angle θ, and the power by F θ v, with the speed
    /// v across the seam. In the step with the seam, one of the two values acts for a wrong fraction of the step. The
    /// root mean square error of this fraction is 1/6 (weights 1/6, 2/3, 1/6) or √(1/12) (weights 1/2, 1/2), with the
    /// mean 0. A contact lasts π/√k with <F²> = k. Seams are passed at the rate <|v|> per length and area, and <|v|³> =
    /// 2 √(2/π).
    fn may_be_off(&self, way: Way, walls: f64, pairs: f64) -> f64 {
        let (n, k) = (self.steps_per_contact, self.stiffness);
        let (mean, square, share) = match way {
            Way::Hard => return 1e-15 * (walls + pairs),
            Way::Local => (PI.powi(6) / (72.0 * n.powi(5)) * (pairs + walls / 2f64.powf(2.5)), 0.0, 1.0 / 36.0),
            Way::Uniform => {
                let (pair, wall) =
                    (gain_of_an_impact(VelocityVerlet, n), gain_of_an_impact(VelocityVerlet, n * 2f64.sqrt()));
                let square = 2.0 * (pair.1.powi(2) * pairs + wall.1.powi(2) * walls);
                ((pair.0 * pairs + wall.0 * walls).abs(), square, 1.0 / 12.0)
            }
        };
        let cubed = 2.0 * (2.0 / PI).sqrt();
        let seam = self.seams() * cubed * PI / k.sqrt() * k * self.time_step().powi(2) * share;
        mean + 4.0 * (square + seam * walls).sqrt()
    }

    /// Runs until there are `hits` impacts on walls. All spheres must then be inside, and the energy must be unchanged.
    fn stays(&self, name: &str, way: Way, hits: u64) {
        let mut scene = empty([self.edge; 3], [false; 3], unit(), surface(1.0, 0.0));
        scene.walls = vec![wall(self.vessel.clone(), 1.0, 0.0)];
        let start = random(&scene, self.spheres, 1.0, 4);
        let energy = start.kinetic_energy();
        let mut simulation = Simulation::with_engine(scene, start, self.engine(way));
        // overlaps of soft spheres are at most 6/√k, because no impact of 10^8 on a wall is faster than 6
        let sunk = if way == Way::Hard { 1e-11 } else { 6.0 / self.stiffness.sqrt() };
        let mut deepest = f64::INFINITY;
        while simulation.record.walls.count < hits {
            simulation.run(10, 0.5).unwrap();
            let gap = |x: &Vector3<f64>| self.vessel.nearest(x).distance - 0.5;
            deepest = simulation.particles.position.iter().map(gap).fold(deepest, f64::min);
            assert!(deepest > -sunk, "{name}, {way:?}: {deepest:e}");
        }
        let off = simulation.particles.kinetic_energy() + simulation.elastic_energy() - energy;
        let [walls, pairs] = [&simulation.record.walls, &simulation.record.pairs].map(|of| of.count as f64);
        let (off, bound) = (off / energy, self.may_be_off(way, walls, pairs) / energy);
        println!(
            "{name}, {way:?}: {walls} at walls, {pairs} of pairs, energy off by {off:.1e} of {bound:.1e}, {deepest:.1e} deep"
        );
        assert!(off.abs() < bound, "{name}, {way:?}: {off:e} of {bound:e}");
    }
}

#[test]
fn a_gas_stays_in_a_vessel_of_triangles_and_keeps_its_energy() {
    for (name, vessel) in vessels(1.0) {
        let gas = Gas { vessel: &vessel, edge: 16.0, spheres: 40, stiffness: 2e4, steps_per_contact: 40.0 };
        gas.stays(name, Way::Hard, 5_000);
        gas.stays(name, Way::Local, 5_000);
        // uniform steps cost more, and fewer impacts are sufficient
        gas.stays(name, Way::Uniform, 500);
    }
}

/// Runs one part of the long test, so that each part can be run alone.
fn a_million(which: usize, way: Way) {
    // the vessel is larger, so that fewer triangles are within reach of a sphere; the spheres are softer, so that
    // contacts have longer steps
    let (name, vessel) = &vessels(2.0)[which];
    let gas = Gas { vessel, edge: 32.0, spheres: 100, stiffness: 1e3, steps_per_contact: 30.0 };
    gas.stays(name, way, 1_000_000);
}

#[test]
#[ignore = "a million impacts on walls take minutes: cargo test -- --ignored --nocapture a_million_impacts"]
fn a_million_impacts_in_a_sphere_of_triangles_hard() {
    a_million(0, Way::Hard);
}

#[test]
#[ignore = "a million impacts on walls take minutes: cargo test -- --ignored --nocapture a_million_impacts"]
fn a_million_impacts_in_a_sphere_of_triangles_local() {
    a_million(0, Way::Local);
}

#[test]
#[ignore = "a million impacts on walls take minutes: cargo test -- --ignored --nocapture a_million_impacts"]
fn a_million_impacts_in_a_sphere_of_triangles_uniform() {
    a_million(0, Way::Uniform);
}

#[test]
#[ignore = "a million impacts on walls take minutes: cargo test -- --ignored --nocapture a_million_impacts"]
fn a_million_impacts_in_a_torus_of_triangles_hard() {
    a_million(1, Way::Hard);
}

#[test]
#[ignore = "a million impacts on walls take minutes: cargo test -- --ignored --nocapture a_million_impacts"]
fn a_million_impacts_in_a_torus_of_triangles_local() {
    a_million(1, Way::Local);
}

#[test]
#[ignore = "a million impacts on walls take minutes: cargo test -- --ignored --nocapture a_million_impacts"]
fn a_million_impacts_in_a_torus_of_triangles_uniform() {
    a_million(1, Way::Uniform);
}
