//! The inside of a wall, also of an open one.

use super::{Frustum, Geometry, Mesh, Sides, WallGeometry};
use nalgebra::Vector3;
use std::f64::consts::PI;

impl WallGeometry {
    /// True if the wall has an inside: a vessel, a shell that is open at its ends, or a sheet of triangles.
    pub fn has_inside(&self) -> bool {
        match self {
            Self::Hollow(_) => true,
            Self::Frustum(frustum) => !frustum.solid,
            Self::Mesh(mesh) => mesh.sides() != Sides::Outside,
            Self::Repeated(body) => body.shape().has_inside(),
            Self::Plane(_) | Self::Obstacle(_) | Self::Other(_) => false,
        }
    }

    /// True if `point` [m] is inside the wall. An open surface encloses points up to its rim: a point is inside a
    /// sheet of triangles that covers more than half of the field of view from this point.
    pub fn encloses(&self, point: &Vector3<f64>) -> bool {
        match self {
            Self::Hollow(hollow) => hollow.nearest(point).distance > 0.0,
            Self::Frustum(frustum) => !frustum.solid && frustum.encloses(point),
            Self::Mesh(mesh) => mesh.sides() != Sides::Outside && mesh.encloses(point),
            Self::Repeated(body) => body.shape().encloses(&body.near(point)),
            Self::Plane(_) | Self::Obstacle(_) | Self::Other(_) => false,
        }
    }

    /// [m] corners of the box around the wall; `None` for an endless wall.
    pub fn extent(&self) -> Option<[Vector3<f64>; 2]> {
        match self {
            Self::Mesh(mesh) => Some(mesh.bounds()),
            Self::Hollow(_) => self.room_corners(),
            Self::Repeated(body) => body.shape().extent(),
            shape => shape.bounds(),
        }
    }

    /// [m] corners of a box that holds all particles, infinite where the wall sets no limit: for flat walls across an
    /// axis, and for vessels.
    pub fn room_corners(&self) -> Option<[Vector3<f64>; 2]> {
        /// [-] component of a normal below which it counts as rounding.
        const ALIGNED: f64 = 1e-9;
        match self {
            Self::Plane(plane) => {
                let axis = (0..3).find(|&axis| plane.normal[axis].abs() > 1.0 - ALIGNED)?;
                let [mut low, mut high] = [f64::NEG_INFINITY, f64::INFINITY].map(Vector3::repeat);
                let side = if plane.normal[axis] > 0.0 { &mut low } else { &mut high };
                side[axis] = plane.point[axis];
                Some([low, high])
            }
            Self::Hollow(hollow) => Some(hollow.corners()),
            Self::Mesh(mesh) if mesh.sides() == Sides::Inside => Some(mesh.bounds()),
            Self::Repeated(body) => body.shape().room_corners(),
            Self::Mesh(_) | Self::Obstacle(_) | Self::Frustum(_) | Self::Other(_) => None,
        }
    }
}

impl Frustum {
    /// True if a point [m] is between the ends and nearer to the axis than the side.
    fn encloses(&self, point: &Vector3<f64>) -> bool {
        let from = point - self.axle.center;
        let along = from[self.axle.axis];
        let share = 0.5 + 0.5 * along / self.half_height;
        let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * share;
        along.abs() < self.half_height && self.axle.across(&from).norm() < radius
    }
}

impl Mesh {
    /// True if the triangles cover more than half of the field of view from `point` [m]. Each triangle covers the
    /// solid angle Ω with tan(Ω/2) = a·(b × c)/(1 + a·b + b·c + c·a). Here a, b, c are the directions of its corners
    /// (van Oosterom and Strackee 1983, IEEE Trans. Biomed. Eng. 30, 125).
    fn encloses(&self, point: &Vector3<f64>) -> bool {
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
}
