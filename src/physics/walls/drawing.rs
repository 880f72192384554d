//! Surfaces of walls as triangles, for pictures.

use super::RoundAxis;
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// Number of flat sides with which round bodies are drawn.
const SIDES: u32 = 64;

/// Surface as triangles, for pictures: corner points [m], and for each triangle the indices of its three corners.
pub type Drawing = (Vec<Vector3<f64>>, Vec<[u32; 3]>);

/// Surface of revolution, made by rotating a line about an axis. The points of the line [m] are given by their
/// distance from the axis and their coordinate along the axis.
pub(super) fn turned(axle: &RoundAxis, outline: &[Vector2<f64>]) -> Drawing {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for point in outline {
        for side in 0..SIDES {
            let (sin, cos) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
            let mut corner = axle.center;
            corner[(axle.axis + 1) % 3] += point.x * cos;
            corner[(axle.axis + 2) % 3] += point.x * sin;
            corner[axle.axis] += point.y;
            corners.push(corner);
        }
    }
    for (ring, ends) in outline.windows(2).enumerate() {
        for side in 0..SIDES {
            let next = (side + 1) % SIDES;
            let [low, high] = [ring as u32 * SIDES, (ring as u32 + 1) * SIDES];
            // all corners of a ring on the axis coincide, so the ring is a single point
            if ends[0].x > 0.0 {
                triangles.push([low + side, low + next, high + next]);
            }
            if ends[1].x > 0.0 {
                triangles.push([low + side, high + next, high + side]);
            }
        }
    }
    (corners, triangles)
}
