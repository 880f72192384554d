//! A wall that is a half-space.

use super::{Flight, Geometry, Nearest, Turning};
use nalgebra::Vector3;
use serde::Serialize;

/// [-] limit below which a component counts as rounding. The limit applies to components of unit vectors, and of
/// velocities over their magnitude.
const ROUNDING: f64 = 1e-9;

/// A half-space: all points x with (x - point)·normal < 0 belong to the wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Plane {
    /// [m] any point of the surface.
    pub point: Vector3<f64>,
    /// [-] unit normal, towards the particles.
    pub normal: Vector3<f64>,
}

impl Geometry for Plane {
    #[inline]
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        Nearest { distance: (point - self.point).dot(&self.normal), normal: self.normal }
    }

    fn is_flat_at(&self, _which: u32) -> bool {
        true
    }

    /// Returns the time of touch [s] in closed form. The gap is g0 + v t + a t²/2, with the gap g0 at the beginning,
    /// and v and a the components of velocity and gravity along the normal. `None` without a touch until `until` [s].
    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        let gap = self.nearest(&flight.position).distance - radius;
        let speed = flight.velocity.dot(&self.normal);
        let acceleration = flight.gravity.dot(&self.normal);
        // an approach slower than the rounding of the velocity is ignored
        let resolution = 4.0 * f64::EPSILON * flight.velocity.norm();
        if gap <= 0.0 && speed < -resolution {
            return Some(0.0);
        }
        let speed = if gap <= 0.0 { speed.max(0.0) } else { speed };
        let t = first_closing(gap, speed, acceleration)?;
        (t <= until).then_some(t)
    }

    fn slides(&self, velocity: &Vector3<f64>) -> bool {
        is_along(velocity, &self.normal)
    }

    fn turns(&self, turning: &Turning) -> bool {
        turning.is_about(&self.normal)
    }

    fn room_corners(&self) -> Option<[Vector3<f64>; 2]> {
        let axis = (0..3).find(|&axis| self.normal[axis].abs() > 1.0 - ROUNDING)?;
        let [mut low, mut high] = [f64::NEG_INFINITY, f64::INFINITY].map(Vector3::repeat);
        let side = if self.normal[axis] > 0.0 { &mut low } else { &mut high };
        side[axis] = self.point[axis];
        Some([low, high])
    }

    fn in_words(&self) -> String {
        "plane".into()
    }
}

/// True if a velocity [m/s] is perpendicular to a unit normal, up to rounding.
pub(super) fn is_along(velocity: &Vector3<f64>, normal: &Vector3<f64>) -> bool {
    velocity.dot(normal).abs() <= ROUNDING * velocity.norm()
}

/// [s] first time t > 0 at which the gap g0 + v t + a t²/2 of a sphere falls through zero; `None` if it never does. The
/// arguments are g0 [m], v [m/s] and a [m/s²]. A negative g0 counts as zero, because the caller has already treated
/// spheres that overlap and approach.
pub(super) fn first_closing(gap: f64, speed: f64, acceleration: f64) -> Option<f64> {
    let gap = gap.max(0.0);
    let discriminant = speed * speed - 2.0 * acceleration * gap;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let t = if speed < 0.0 {
        // the sphere approaches: the nearer root, in a form without cancellation
        2.0 * gap / (root - speed)
    } else if acceleration < 0.0 {
        // the sphere moves away from the wall and falls back: the later root
        (speed + root) / -acceleration
    } else {
        return None;
    };
    Some(t)
}
