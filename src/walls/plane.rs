//! A half-space.

use super::{Flight, Geometry, Nearest};
use nalgebra::Vector3;
use serde::Serialize;

/// A half-space: all points with (x - point)·normal < 0 are wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Plane {
    /// [m] a point of the surface.
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

    /// Closed form: the gap is g0 + v t + a t²/2 with v, a the normal components of velocity and gravity.
    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        let gap = self.nearest(&flight.position).distance - radius;
        let speed = flight.velocity.dot(&self.normal);
        let acceleration = flight.gravity.dot(&self.normal);
        // an approach slower than rounding of the velocity does not count
        let resolution = 4.0 * f64::EPSILON * flight.velocity.norm();
        if gap <= 0.0 && speed < -resolution {
            return Some(0.0);
        }
        let speed = if gap <= 0.0 { speed.max(0.0) } else { speed };
        let t = first_closing(gap, speed, acceleration)?;
        (t <= until).then_some(t)
    }
}

/// [s] first t > 0 at which g0 + v t + a t²/2 falls through zero; a gap that is already closed (rounding) while it
/// opens counts as zero.
fn first_closing(gap: f64, speed: f64, acceleration: f64) -> Option<f64> {
    let gap = gap.max(0.0);
    let discriminant = speed * speed - 2.0 * acceleration * gap;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let t = if speed < 0.0 {
        // approaching: the nearer root, in a form without cancellation
        2.0 * gap / (root - speed)
    } else if acceleration < 0.0 {
        // moving away from the wall and falling back: the later root
        (speed + root) / -acceleration
    } else {
        return None;
    };
    Some(t)
}
