//! What stops a sphere that is not another sphere?
//!
//! A wall is asked one question: where is your nearest point to here? The answer is a signed distance and a normal;
//! the gap to a sphere is that distance less its radius. The soft engine turns a negative gap into an overlap; the
//! hard engine finds the instant at which the gap along a flight becomes zero.
//!
//! To add a shape: one file with `impl Geometry`, then a `mod` line, a variant of [`WallGeometry`] and an arm of `law`.

mod advancement;
mod plane;
mod shape;

pub use plane::Plane;
pub use shape::Obstacle;

use crate::scene::{Elasticity, Surface};
use nalgebra::Vector3;
use serde::Serialize;
use std::sync::Arc;

/// The nearest point of a wall, seen from some point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nearest {
    /// [m] signed distance to the surface: positive on the particles' side.
    pub distance: f64,
    /// [-] unit normal at the nearest point, from the wall towards the particles.
    pub normal: Vector3<f64>,
}

impl Nearest {
    /// The plane that touches the wall at the nearest point to `point` [m].
    fn tangent(&self, point: &Vector3<f64>) -> Plane {
        Plane { point: point - self.normal * self.distance, normal: self.normal }
    }
}

/// The shape of a wall. One answer is needed, the nearest point; a shape that knows its time of touch better gives it too.
pub trait Geometry: std::fmt::Debug + Send + Sync {
    /// The nearest point of the surface to `point` [m].
    fn nearest(&self, point: &Vector3<f64>) -> Nearest;

    /// [s] first instant in `(0, until]` at which the gap of a sphere of `radius` [m] closes on the flight
    /// x(t) = position + velocity t + gravity t²/2 (SI units); 0 if it overlaps and approaches already; `None` if not in that
    /// time. By default found by conservative advancement, which needs nothing but the nearest point.
    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        advancement::touch_time(self, flight, radius, until)
    }
}

/// Ballistic motion in uniform gravity.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Flight {
    /// [m] position at time 0.
    pub position: Vector3<f64>,
    /// [m/s] velocity at time 0.
    pub velocity: Vector3<f64>,
    /// [m/s²] gravity.
    pub gravity: Vector3<f64>,
}

impl Flight {
    /// [m] position at time `t` [s].
    pub fn position_at(&self, t: f64) -> Vector3<f64> {
        self.position + (self.velocity + 0.5 * t * self.gravity) * t
    }

    /// [m/s] velocity at time `t` [s].
    pub fn velocity_at(&self, t: f64) -> Vector3<f64> {
        self.velocity + self.gravity * t
    }

    /// The same flight with its time counted from `t` [s] on.
    pub fn from(&self, t: f64) -> Self {
        Self { position: self.position_at(t), velocity: self.velocity_at(t), gravity: self.gravity }
    }
}

/// The shapes a case can name.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WallGeometry {
    /// A half-space, in closed form.
    Plane(Plane),
    /// A solid body inside the domain, through parry.
    Obstacle(Obstacle),
    /// A shape of the caller's; a case cannot name it.
    #[serde(skip)]
    Other(Arc<dyn Geometry>),
}

impl WallGeometry {
    /// The nearest point of the surface to `point` [m]; of planes, which most scenes have, without a detour.
    #[inline]
    pub fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        self.plane().map_or_else(|| self.law().nearest(point), |plane| plane.nearest(point))
    }

    /// The plane, if it is one: its normal is the same everywhere.
    #[inline]
    pub fn plane(&self) -> Option<&Plane> {
        if let Self::Plane(plane) = self { Some(plane) } else { None }
    }

    /// Whether its normal is the same everywhere.
    #[inline]
    pub fn is_flat(&self) -> bool {
        self.plane().is_some()
    }

    /// The shape behind the name.
    #[inline]
    pub fn law(&self) -> &dyn Geometry {
        match self {
            Self::Plane(plane) => plane,
            Self::Obstacle(obstacle) => obstacle,
            Self::Other(shape) => shape.as_ref(),
        }
    }
}

/// A wall at rest: a shape and how its surface answers an impact.
#[derive(Clone, Debug, Serialize)]
pub struct Wall {
    /// Where it is.
    pub geometry: WallGeometry,
    /// Restitution and friction against every particle.
    pub surface: Surface,
    /// Its own elasticity; `None`: that of the contact law.
    pub elasticity: Option<Elasticity>,
}
