//! Walls whose surface turns about an axis while their shape stays in position.

use super::{Wall, WallGeometry};
use nalgebra::Vector3;
use serde::Serialize;

/// [-] limit below which a value counts as rounding: the sine of an angle, or a distance over a length.
const ROUNDING: f64 = 1e-9;

/// Rotation of a wall's surface about an axis. The velocity of a point x is ω × (x - c).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Turning {
    /// [m] a point c of the axis.
    pub center: Vector3<f64>,
    /// [rad/s] angular velocity ω.
    pub spin: Vector3<f64>,
}

impl Turning {
    /// True if the axis is parallel to the vector `along`, which may have any length.
    pub(super) fn is_about(&self, along: &Vector3<f64>) -> bool {
        self.spin.cross(along).norm() <= ROUNDING * self.spin.norm() * along.norm()
    }

    /// True if the axis goes through `point` [m] in the direction of axis 0, 1 or 2.
    pub(super) fn is_axis(&self, point: &Vector3<f64>, axis: usize) -> bool {
        let along = Vector3::from_fn(|k, _| if k == axis { 1.0 } else { 0.0 });
        let offset = (self.center - point).cross(&along);
        self.is_about(&along) && offset.norm() <= ROUNDING * (self.center.norm() + point.norm())
    }

    /// True if the axis goes through `point` [m].
    pub(super) fn is_through(&self, point: &Vector3<f64>) -> bool {
        let offset = (self.center - point).cross(&self.spin);
        offset.norm() <= ROUNDING * self.spin.norm() * (self.center.norm() + point.norm())
    }
}

impl Wall {
    /// [m/s] velocity of the surface at `point` [m].
    #[inline(always)]
    pub fn surface_velocity(&self, point: &Vector3<f64>) -> Vector3<f64> {
        match &self.turning {
            None => self.velocity,
            Some(turning) => self.velocity + self.turning_velocity(turning, point),
        }
    }

    /// [m/s] part of the velocity at `point` [m] by rotation. Each periodic image of a body turns about its own axis.
    fn turning_velocity(&self, turning: &Turning, point: &Vector3<f64>) -> Vector3<f64> {
        let near = match &self.geometry {
            WallGeometry::Repeated(body) => body.near(point),
            _ => *point,
        };
        turning.spin.cross(&(near - turning.center))
    }

    /// [rad/s] angular velocity of the surface.
    #[inline(always)]
    pub fn spin(&self) -> Vector3<f64> {
        self.turning.map_or_else(Vector3::zeros, |turning| turning.spin)
    }
}
