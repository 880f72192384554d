//! The time of touch of a shape of which only the nearest point is known.

use super::{Flight, Geometry};

/// [-] gap, as a share of the sphere's radius, below which the tangent plane stands for the wall.
///
/// The centre of a sphere of radius r stays outside a body that is a union of balls of radius r, so on a way of length s between two
/// free places it can have sunk in by s²/(8 r) at most: with this share by 1e-17 r, which is below rounding.
const CLOSE: f64 = 1e-8;
/// Steps before giving up. An approach at an angle a to the surface takes some ln(1/CLOSE)/(2 sin a) steps, so that this many
/// reach the surface at angles down to 1e-3; flatter ones have a normal speed of less than a thousandth.
const STEPS: usize = 10_000;

/// [s] as [`Geometry::touch_time`], by conservative advancement (Mirtich 1996, Impulse-based Dynamic Simulation, section 2.3):
/// a sphere with the gap g goes on until it may have covered the way g in any direction, because no wall can be nearer. Within
/// a very small gap the tangent plane gives the time of touch.
pub(super) fn touch_time<G: Geometry + ?Sized>(shape: &G, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
    within(shape, flight, radius, (until, STEPS)).flatten()
}

/// The same in so many `steps` at most; `None` if that is not enough to tell.
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

/// [s] the least time in which a flight can cover the way `length` [m]: |v| t + |g| t²/2 = length; infinite at rest without gravity.
fn time_to_cover(length: f64, flight: &Flight) -> f64 {
    let (speed, gravity) = (flight.velocity.norm(), flight.gravity.norm());
    // the positive root, in the form that does not cancel
    2.0 * length / (speed + (speed * speed + 2.0 * gravity * length).sqrt())
}
