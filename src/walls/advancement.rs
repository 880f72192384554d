//! Time of touch of a shape for which only the nearest point is known.

use super::{Flight, Geometry};

/// [-] gap, as a share of the sphere's radius, below which the tangent plane replaces the wall.
///
/// The centre of a sphere of radius r stays outside a body that is a union of balls of radius r. So on a path of
/// length s between two free positions it can sink in by at most s²/(8 r). With this share that is 1e-17 r, which is
/// below rounding.
const CLOSE: f64 = 1e-8;
/// Steps before giving up. An approach at an angle a to the surface takes some ln(1/CLOSE)/(2 sin a) steps. So this
/// many steps reach the surface at angles down to 1e-3; flatter approaches have a normal speed below a thousandth.
const STEPS: usize = 10_000;

/// [s] as [`Geometry::touch_time`], by conservative advancement (Mirtich 1996, Impulse-based Dynamic Simulation,
/// section 2.3). A sphere with the gap g advances until it may have covered the distance g in any direction, because
/// no wall can be nearer. Within a very small gap the tangent plane gives the time of touch.
pub(super) fn touch_time<G: Geometry + ?Sized>(shape: &G, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
    within(shape, flight, radius, (until, STEPS)).flatten()
}

/// Time of touch as [`touch_time`], in at most `steps` steps; `None` if these are not enough to decide.
pub(super) fn within<G: Geometry + ?Sized>(
    shape: &G,
    flight: &Flight,
    radius: f64,
    (until, steps): (f64, usize),
) -> Option<Option<f64>> {
    let mut t = 0.0;
    for _ in 0..steps {
        let now = flight.from(t);
        let nearest = shape.nearest(&now.position);
        let gap = nearest.distance - radius;
        let free = time_to_cover(gap.max(CLOSE * radius), &now);
        let plane = nearest.tangent(&now.position);
        let touch = if gap <= CLOSE * radius { plane.touch_time(&now, radius, free) } else { None };
        match touch {
            Some(step) if t + step > until => return Some(None),
            Some(step) if step <= 2.0 * f64::EPSILON * t || gap <= 0.0 => return Some(Some(t + step)),
            Some(step) => t += step,
            None => t += free,
        }
        if t > until {
            return Some(None);
        }
    }
    None
}

/// [s] least time in which a flight can cover the distance `length` [m]: |v| t + |g| t²/2 = length; infinite at rest
/// without gravity.
fn time_to_cover(length: f64, flight: &Flight) -> f64 {
    let (speed, gravity) = (flight.velocity.norm(), flight.gravity.norm());
    // the positive root, in a form without cancellation
    2.0 * length / (speed + (speed * speed + 2.0 * gravity * length).sqrt())
}
