//! Tests whether a point is inside an open wall (a round shell that is open at its ends, or a sheet of triangles), or
//! inside a closed surface of triangles.

use super::{Frustum, Geometry, Mesh, Sides};
use nalgebra::Vector3;
use std::f64::consts::PI;

impl Frustum {
    /// True if `point` [m] is inside this shell (a round wall that is open at both ends). The point must be between the
    /// two ends, and nearer to the axis than the shell at the same height.
    pub(super) fn surrounds(&self, point: &Vector3<f64>) -> bool {
        let from = point - self.axle.center;
        let along = from[self.axle.axis];
        let share = 0.5 + 0.5 * along / self.half_height;
        let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * share;
        along.abs() < self.half_height && self.axle.across(&from).norm() < radius
    }
}

impl Mesh {
    /// True if `point` [m] is inside this surface of triangles, which may have openings. The triangles must then cover
    /// more than half of the full solid angle 4π, seen from the point. False for a point outside the box around the
    /// triangles.
    ///
    /// A triangle with corners in the directions a, b, c covers the solid angle Ω with tan(Ω/2) = a·(b × c)/(1 + a·b +
    /// b·c + c·a) (van Oosterom and Strackee 1983, IEEE Trans. Biomed. Eng. 30, 125).
    pub(super) fn surrounds(&self, point: &Vector3<f64>) -> bool {
        let [low, high] = self.bounds();
        if (0..3).any(|axis| point[axis] < low[axis] || point[axis] > high[axis]) {
            return false;
        }
        let covered: f64 = self
            .corners()
            .map(|corners| {
                let [a, b, c] = corners.map(|corner| (corner - point).try_normalize(0.0).unwrap_or_default());
                2.0 * a.dot(&b.cross(&c)).atan2(1.0 + a.dot(&b) + b.dot(&c) + c.dot(&a))
            })
            .sum();
        covered.abs() > 2.0 * PI
    }

    /// True if `point` [m] is inside a closed surface but not in one of its cavities; an open surface has no inside.
    /// For a point outside the box around the surface the result is false at once. Otherwise the side of the nearest
    /// triangle decides. The search for this triangle takes a number of steps that grows like the logarithm of the
    /// number of triangles.
    pub fn interior_contains(&self, point: &Vector3<f64>) -> bool {
        let [low, high] = self.bounds();
        let is_near = (0..3).all(|axis| (low[axis]..=high[axis]).contains(&point[axis]));
        is_near
            && match self.sides() {
                Sides::Outside => self.nearest(point).distance < 0.0,
                Sides::Inside => self.nearest(point).distance > 0.0,
                Sides::Both => false,
            }
    }
}
