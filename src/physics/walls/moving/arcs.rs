//! First touch of a sphere and a moving shape, by arcs of parabolas.
//!
//! In the frame of the shape the flight is no parabola. On an arc (a short piece of the flight) of the duration τ, the
//! flight differs by at most J τ³/6 from the parabola with the same position, velocity and acceleration at the
//! beginning. Here J bounds the third derivative of the position. The method moves an enlarged sphere, whose radius is
//! greater by this distance, along the parabola. The enlarged sphere touches no later than the sphere itself, so there
//! is no contact before this touch. The next arc begins at the instant of this touch.

use super::MovingShape;
use crate::walls::{Flight, Touch};

/// [-] gap over the radius of a sphere, below which the sphere counts as touching. A touch may be found while a gap of
/// this size is left, and a touch with a smaller overlap may be missed. The rounding of coordinates is of this order if
/// the box is 10⁴ radii long.
const CLOSE: f64 = 1e-12;

/// [-] gap that counts as zero, in units of the rounding error of the largest coordinate.
const ROUNDINGS: f64 = 16.0;

/// [-] largest length by which a sphere is enlarged on an arc (short piece of its flight), over its gap to the shape.
const SHARE: f64 = 0.125;

/// [-] largest enlargement of a sphere, over its gap to the shape, with which one arc (piece of the flight) covers all
/// the time that remains. The number must be below 1.
const WHOLE: f64 = 0.5;

/// [-] largest duration of an arc (short piece of a flight), over the time in which the gap would close at the present
/// speed.
const AHEAD: f64 = 1.5;

/// [rad] largest rotation of a shape during one arc (short piece of a flight). For larger rotations the bound of the
/// third derivative of the position would be far too large.
const TURN: f64 = 0.5;

/// First touch for contact number `which` of a moving shape, as
/// [`Geometry::first_touch`](crate::walls::Geometry::first_touch) defines it. The flight begins at the simulated time
/// `start` [s], and its duration `until` [s] must be finite. `None` without a touch.
pub(super) fn first_touch(
    moving: &MovingShape,
    which: u32,
    (flight, start): (&Flight, f64),
    radius: f64,
    until: f64,
) -> Option<Touch> {
    let shape = &moving.shape;
    // a shape that numbers its contacts by distance finds every touch for contact 0
    if which > 0 && shape.law().is_nearest_first() {
        return None;
    }
    let longest = moving.motion.spin().map_or(f64::INFINITY, |spin| TURN / spin.norm());
    let mut t = 0.0;
    let mut enlarged: Option<EnlargedTouch> = None;
    while t <= until {
        let real = flight.from(t);
        let seen = moving.motion.seen(&real, start + t);
        let close = CLOSE * radius + ROUNDINGS * f64::EPSILON * seen.position.amax();
        let most = (until - t).min(longest);
        let jerk = moving.motion.jerk(&real, most);
        let deviation = |time: f64| jerk * time.powi(3) / 6.0;
        let arc = |error: f64| (6.0 * error / jerk).cbrt().min(most);
        // after the touch of an enlarged sphere, only the touched feature is evaluated
        let (nearest, least) = match enlarged.take() {
            Some(EnlargedTouch { feature, gap }) => (shape.struck(which, feature, &seen.position, radius), Some(gap)),
            None => (shape.contact(which, &seen.position, radius), None),
        };
        let expected = nearest.distance - radius;
        let gap = least.unwrap_or(expected);
        let (error, length) = if gap <= 2.0 * close {
            (0.0, arc(close))
        } else if deviation(most) <= WHOLE * gap {
            // one search covers all the time that remains, as for a shape at rest
            (deviation(most), most)
        } else {
            let closing = -seen.velocity.dot(&nearest.normal);
            let wanted = if closing > 0.0 { AHEAD * expected.max(gap) / closing } else { f64::INFINITY };
            let length = arc(SHARE * gap).min(wanted.max(arc(close)));
            (deviation(length).min(SHARE * gap), length)
        };
        match shape.first_touch(which, &seen, radius + error, length) {
            Some(touch) if error <= close && touch.time <= length => {
                return (t + touch.time <= until).then_some(Touch { time: t + touch.time, ..touch });
            }
            Some(touch) if touch.time <= length => {
                // time advances at least by the time in which the gap cannot close
                let free = seen.time_to_cover(gap - error);
                if touch.time >= free {
                    enlarged = Some(EnlargedTouch { feature: touch.feature, gap: error - deviation(touch.time) });
                }
                t += touch.time.max(free);
            }
            _ if length >= until - t => return None,
            _ => t += length,
        }
    }
    None
}

/// First touch of an enlarged sphere on an arc (short piece of a flight). The sphere is enlarged by the largest
/// deviation of the flight from a parabola.
struct EnlargedTouch {
    /// Number of the piece of the surface that is touched, such as a triangle; 0 if the surface has no pieces.
    feature: u32,
    /// [m] lower limit of the gap between the sphere itself and the shape: the enlargement of the sphere minus the
    /// deviation of the flight from the parabola at the touch.
    gap: f64,
}
