//! Inlets and outlets: where particles come into a scene and where they leave it.

use super::Scene;
use crate::walls::{Geometry, Hollow, Mesh, Plane};
use nalgebra::Vector3;
use serde::Serialize;
use std::sync::Arc;

/// Part of space in which particles leave the scene. A particle leaves at the first end of a window (time between two
/// exchanges with the gas) at which its centre is in this part.
#[derive(Clone, Debug, Serialize)]
pub struct Outlet {
    /// Name of the outlet in results.
    pub name: String,
    /// Shape of the part of space in which particles leave.
    pub shape: OutletShape,
}

/// Shape of an outlet.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OutletShape {
    /// The half-space behind a plane, whose normal points to the particles that stay. A side of the box is such a
    /// plane.
    Behind(Plane),
    /// The interior of a hollow body.
    Body(Hollow),
    /// The interior of a closed surface of triangles, without its cavities. An open surface has no interior.
    Mesh(Arc<Mesh>),
}

impl Outlet {
    /// True if a particle with its centre at `position` [m] leaves the scene in this outlet. The position must be
    /// inside the box along periodic axes.
    pub fn takes(&self, position: &Vector3<f64>) -> bool {
        match &self.shape {
            OutletShape::Behind(plane) => plane.nearest(position).distance < 0.0,
            OutletShape::Body(body) => body.encloses(position),
            OutletShape::Mesh(mesh) => mesh.interior_contains(position),
        }
    }
}

/// Part of space in which particles come into the scene at random positions, at a constant rate. Velocities and spins
/// are normally distributed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inlet {
    /// Name of the inlet in results.
    pub name: String,
    /// Index of the species of the particles in [`Scene::species`].
    pub species: u16,
    /// Body that contains each new particle wholly.
    pub region: Hollow,
    /// [1/s] number of particles that come in per second while the inlet is open.
    pub rate: f64,
    /// [s] time at which the inlet opens.
    pub start: f64,
    /// [s] time at which the inlet closes; infinite if it stays open.
    pub end: f64,
    /// [m/s] mean velocity of new particles.
    pub velocity_mean: Vector3<f64>,
    /// [m/s] standard deviation of each velocity component of new particles.
    pub velocity_fluctuation: Vector3<f64>,
    /// [rad/s] mean spin of new particles.
    pub spin_mean: Vector3<f64>,
    /// [rad/s] standard deviation of each spin component of new particles.
    pub spin_fluctuation: f64,
}

impl Inlet {
    /// Number of particles that must have come in from the start of the run to the time `time` [s]. The first particle
    /// comes in at the opening, and each further one 1/`rate` after the one before.
    pub fn due(&self, time: f64) -> u64 {
        // a millionth of an interval is added, since the time is a sum of windows with rounding errors
        let open = time.min(self.end) - self.start;
        if open < 0.0 { 0 } else { (open * self.rate + 1e-6).floor() as u64 + 1 }
    }
}

impl Scene {
    /// True if particles come into the scene or leave it.
    pub fn has_openings(&self) -> bool {
        !(self.inlets.is_empty() && self.outlets.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walls::Cavity;

    #[test]
    fn particles_are_due_at_equal_intervals_while_the_inlet_is_open() {
        let region = Hollow::new(Cavity::Sphere { center: Vector3::zeros(), radius: 1.0 });
        let (zero, none) = (Vector3::zeros(), String::new());
        let inlet = Inlet {
            name: none,
            species: 0,
            region,
            rate: 10.0,
            start: 1.0,
            end: 2.05,
            velocity_mean: zero,
            velocity_fluctuation: zero,
            spin_mean: zero,
            spin_fluctuation: 0.0,
        };
        let due = [0.99, 1.0, 1.09, 1.1, 2.0, 2.05, 9.0].map(|time| inlet.due(time));
        assert_eq!(due, [0, 1, 1, 2, 11, 11, 11]);
    }

    #[test]
    fn an_outlet_takes_what_is_behind_its_plane_or_in_its_body() {
        let plane = Plane { point: Vector3::new(0.0, 0.0, 2.0), normal: Vector3::z() };
        let behind = Outlet { name: String::new(), shape: OutletShape::Behind(plane) };
        assert!(behind.takes(&Vector3::new(5.0, 5.0, 1.999)) && !behind.takes(&Vector3::new(5.0, 5.0, 2.0)));
        let body = Hollow::new(Cavity::Box { center: Vector3::zeros(), half_extents: Vector3::new(1.0, 2.0, 3.0) });
        let inside = Outlet { name: String::new(), shape: OutletShape::Body(body) };
        assert!(inside.takes(&Vector3::new(0.9, -1.9, 2.9)) && !inside.takes(&Vector3::new(1.1, 0.0, 0.0)));
    }
}
