//! Time of touch of a convex body: from tangent plane to tangent plane.

use super::{Flight, Geometry, Nearest};
use nalgebra::Vector3;

/// Steps before giving up: grazing flights converge linearly, by a factor of two, and this many steps reach rounding.
const STEPS: usize = 64;

/// [s] as [`Geometry::touch_time`], for a convex body whose nearest point `nearest` gives.
///
/// The body lies behind the tangent plane at its nearest point, so a flight cannot reach the body before it reaches
/// that plane. Going from plane to plane approaches the touch from before, quadratically unless the flight grazes. A
/// flight that never reaches one of the planes misses the body.
pub(super) fn touch_time(
    nearest: impl Fn(&Vector3<f64>) -> Nearest,
    flight: &Flight,
    radius: f64,
    until: f64,
) -> Option<f64> {
    let mut t = 0.0;
    for _ in 0..STEPS {
        let now = flight.from(t);
        let step = nearest(&now.position).tangent(&now.position).touch_time(&now, radius, until - t)?;
        t += step;
        if step <= 2.0 * f64::EPSILON * t {
            break;
        }
    }
    Some(t)
}
