//! Time at which a sphere touches a convex body, found from a sequence of tangent planes.

use super::{Flight, Geometry, Nearest};
use nalgebra::Vector3;

/// Number of steps before the search stops: for grazing flights each step halves the error, and 64 reach rounding.
const STEPS: usize = 64;

/// [s] time of touch as [`Geometry::touch_time`] defines it, for a convex body whose nearest points `nearest` returns.
///
/// The body is behind the tangent plane at its nearest point, so a flight reaches that plane before the body. Each step
/// goes to the next tangent plane and approaches the touch from before, quadratically unless the flight grazes. A
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
