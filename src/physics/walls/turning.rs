//! Walls whose surface turns about an axis while their shape stays in position.

use super::{MovingShape, Wall, WallGeometry};
use nalgebra::Vector3;
use serde::Serialize;

/// [-] limit below which a value counts as rounding: the sine of an angle, or a distance over a length.
const ROUNDING: f64 = 1e-9;

/// Rotation of a wall's surface about an axis. The velocity of a point x is ω × (x - c).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Turning {
    /// [m] a point c on the axis of the rotation.
    pub center: Vector3<f64>,
    /// [rad/s] angular velocity ω of the surface about the axis.
    pub spin: Vector3<f64>,
}

impl Turning {
    /// True if the axis is parallel to the vector `along`, which may have any length.
    pub(super) fn is_about(&self, along: &Vector3<f64>) -> bool {
        self.spin.cross(along).norm() <= ROUNDING * self.spin.norm() * along.norm()
    }

    /// True if the axis of rotation goes through `point` [m] and is parallel to the coordinate axis `axis` (0, 1, 2 for
    /// x, y, z).
    pub(super) fn is_axis(&self, point: &Vector3<f64>, axis: usize) -> bool {
        let along = Vector3::from_fn(|k, _| if k == axis { 1.0 } else { 0.0 });
        let offset = (self.center - point).cross(&along);
        self.is_about(&along) && offset.norm() <= ROUNDING * (self.center.norm() + point.norm())
    }

    /// True if the axis of rotation goes through `point` [m].
    pub(super) fn is_through(&self, point: &Vector3<f64>) -> bool {
        let offset = (self.center - point).cross(&self.spin);
        offset.norm() <= ROUNDING * self.spin.norm() * (self.center.norm() + point.norm())
    }
}

impl Wall {
    /// [m/s] velocity of the wall's surface at `point` [m], at the time `ahead` [s] after the instant of the wall's
    /// scene.
    #[inline(always)]
    pub fn surface_velocity(&self, point: &Vector3<f64>, ahead: f64) -> Vector3<f64> {
        match &self.moving {
            None => self.sliding_velocity(point),
            Some(moving) => {
                let time = moving.time() + ahead;
                self.sliding_velocity(&moving.to_shape(point, time)) + moving.motion().velocity(point, time)
            }
        }
    }

    /// [m/s] velocity of the surface along itself, relative to the shape. `point` [m] is a point of the shape at the
    /// place where the case (input file) puts it.
    #[inline(always)]
    pub fn sliding_velocity(&self, point: &Vector3<f64>) -> Vector3<f64> {
        match &self.turning {
            None => self.velocity,
            Some(turning) => self.velocity + self.turning_velocity(turning, point),
        }
    }

    /// [m/s] part of the surface velocity at `point` [m] that comes from the rotation `turning` of the surface. Each
    /// periodic image of a body turns about its own axis.
    fn turning_velocity(&self, turning: &Turning, point: &Vector3<f64>) -> Vector3<f64> {
        let near = match self.moving.as_ref().map_or(&self.geometry, MovingShape::shape) {
            WallGeometry::Repeated(body) => body.near(point),
            _ => *point,
        };
        turning.spin.cross(&(near - turning.center))
    }

    /// [rad/s] angular velocity of the wall's surface; `None` if neither the surface nor the shape turns.
    #[inline(always)]
    pub fn spin(&self) -> Option<Vector3<f64>> {
        let shape = self.moving.as_ref().and_then(|moving| moving.motion().spin());
        match (&self.turning, shape) {
            (None, shape) => shape,
            (Some(turning), shape) => Some(shape.map_or(turning.spin, |spin| turning.spin + spin)),
        }
    }
}
