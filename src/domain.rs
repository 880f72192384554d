//! Box of a scene: its size and its periodic sides.

pub mod blocks;

use nalgebra::Vector3;
use serde::Serialize;

/// A rectangular box with one corner at the origin, periodic along any of its axes.
///
/// Axes: x spanwise, y wall-normal, z streamwise (the paper's section 2.1).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Domain {
    /// [m] edge lengths of the box along x, y, z.
    pub size: Vector3<f64>,
    /// True for each axis along which the box is periodic.
    pub periodic: [bool; 3],
    /// [m] half the edge length along periodic axes, infinite along other axes. If the coordinates of two
    /// particles differ by more, another image is nearer.
    #[serde(skip)]
    pub(crate) half: Vector3<f64>,
    /// [m²] square of the shortest half edge. For particles within this distance of each other, no other images are
    /// nearer.
    #[serde(skip)]
    direct: f64,
}

impl Domain {
    /// Makes a box with the given edge lengths [m].
    pub fn new(size: Vector3<f64>, periodic: [bool; 3]) -> Self {
        let half = Vector3::from_fn(|axis, _| if periodic[axis] { 0.5 * size[axis] } else { f64::INFINITY });
        Self { size, periodic, half, direct: half.min().powi(2) }
    }

    /// [m³] volume of the box.
    pub fn volume(&self) -> f64 {
        self.size.x * self.size.y * self.size.z
    }

    /// [m] vector from `b` to the nearest image of `a`. Both positions must be within 1.5 periods of the box, as they
    /// are between two calls of [`Domain::wrap`].
    #[inline(always)]
    pub fn separation(&self, a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
        let mut d = a - b;
        // most pairs are near, and need this one comparison instead of one per axis
        if d.norm_squared() < self.direct {
            return d;
        }
        for axis in 0..3 {
            if d[axis] > self.half[axis] {
                d[axis] -= self.size[axis];
            } else if d[axis] < -self.half[axis] {
                d[axis] += self.size[axis];
            }
        }
        d
    }

    /// [m] image of `position` [m] that lies in the box along all periodic axes.
    #[inline]
    pub fn wrap(&self, position: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| {
            let (x, l) = (position[axis], self.size[axis]);
            if !self.periodic[axis] || (0.0..l).contains(&x) {
                return x;
            }
            let wrapped = x - l * (x / l).floor();
            // the result is checked, because x + l rounds to l for x slightly below zero
            if wrapped < l { wrapped } else { 0.0 }
        })
    }

    /// True if `position` [m] is within the box along every axis that is not periodic.
    #[inline]
    pub fn contains(&self, position: &Vector3<f64>) -> bool {
        (0..3).all(|axis| self.periodic[axis] || (0.0..=self.size[axis]).contains(&position[axis]))
    }
}
