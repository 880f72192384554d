//! Time at which a sphere touches a wall, computed by steps that use only the nearest point of the wall.

use super::{Flight, Geometry};

/// [-] ratio of the gap to the radius of the sphere, below which the tangent plane is used in place of the wall.
///
/// The centre of a sphere of radius r cannot be nearer to the wall than r. So the centre cannot enter the balls of
/// radius r about the points of the wall. If both ends of a straight path of length s lie outside these balls, no
/// point of the path lies deeper inside a ball than s²/(8 r). For a path as long as this gap, the depth is 1e-17 r,
/// which is below rounding.
const CLOSE: f64 = 1e-8;
/// Largest number of steps of a search for a touch. A flight at an angle a to the surface needs about ln(1/CLOSE)/(2
/// sin a) steps, so this number is enough for angles down to 1e-3 rad. At smaller angles the normal speed is below a
/// thousandth of the speed.
const STEPS: usize = 10_000;

/// [s] time of touch as [`Geometry::touch_time`] defines it, by conservative advancement (Mirtich 1996, Impulse-based
/// Dynamic Simulation, section 2.3). `None` without a touch until `until` [s], or if `STEPS` steps do not suffice. In
/// each step the sphere advances by the shortest time in which it can cover the gap to the wall. If the gap over the
/// radius is below [`CLOSE`], the tangent plane gives the time of touch.
pub(super) fn touch_time<G: Geometry + ?Sized>(shape: &G, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
    within(shape, flight, radius, (until, STEPS)).flatten()
}

/// [s] time of touch as [`touch_time`] returns it, but with at most `steps` steps. The outer `None` means that more
/// steps are needed, the inner `None` that the sphere does not touch until `until` [s].
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
        let free = now.time_to_cover(gap.max(CLOSE * radius));
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
