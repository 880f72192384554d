//! Time at which a sphere touches a convex body, found from a sequence of tangent planes.

use super::{Flight, Geometry, Nearest};
use nalgebra::Vector3;

/// Largest number of steps of the search. If the flight grazes the body, each step halves the error, so that 64 steps
/// reduce the error to rounding.
const STEPS: usize = 64;

/// [s] time of touch as [`Geometry::touch_time`] defines it, for a convex body. `nearest` returns the point of the body
/// that is nearest to a given point. `None` without a touch until `until` [s].
///
/// A convex body lies behind the tangent plane at its nearest point, so a flight reaches this plane before the body.
/// Each step advances to the next tangent plane, so the time never exceeds the time of touch. The convergence is
/// quadratic unless the flight grazes the body. A flight that does not reach one of the planes misses the body.
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
