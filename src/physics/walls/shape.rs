//! Solid convex bodies inside the domain, with nearest points from the library parry.
//!
//! parry computes nearest points accurately at any scale. This program computes times of touch itself, because the
//! absolute tolerances of parry are too large for particles. The double-precision build of parry is used, because
//! overlaps of 1e-6 radii would be lost in single precision.

use super::{Drawing, Flight, Geometry, Nearest, Turning, convex};
use nalgebra::Vector3;
use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{Ball, Cuboid, Cylinder};
use serde::Serialize;
use std::fmt;

/// A solid convex body at rest. Particles are outside.
#[derive(Clone, Serialize)]
pub struct Obstacle {
    center: Vector3<f64>,
    /// Index of the axis of the domain (0, 1, 2 for x, y, z) to which the y axis of the shape is parallel.
    axis: usize,
    shape: RoundBody,
}

#[derive(Clone, Serialize)]
#[serde(rename_all = "snake_case")]
enum RoundBody {
    /// A sphere, given by its radius [m].
    Sphere(f64),
    /// A box, given by half the lengths of its edges [m].
    Cuboid(Vector3<f64>),
    /// A cylinder, given by its radius [m] and half its height [m].
    Cylinder { radius: f64, half_height: f64 },
}

impl Obstacle {
    /// Makes a sphere with a centre [m] and a radius [m].
    pub fn sphere(center: Vector3<f64>, radius: f64) -> Self {
        Self { center, axis: 1, shape: RoundBody::Sphere(radius) }
    }

    /// Makes a box with edges along the axes, with a centre [m] and half the lengths of its edges [m].
    pub fn cuboid(center: Vector3<f64>, half_extents: Vector3<f64>) -> Self {
        Self { center, axis: 1, shape: RoundBody::Cuboid(half_extents) }
    }

    /// Makes a cylinder along axis 0, 1 or 2 (x, y, z), with a centre [m], a radius [m] and half its height [m].
    pub fn cylinder(center: Vector3<f64>, axis: usize, radius: f64, half_height: f64) -> Self {
        Self { center, axis: axis.min(2), shape: RoundBody::Cylinder { radius, half_height } }
    }

    /// [m] centre of the body.
    pub fn center(&self) -> Vector3<f64> {
        self.center
    }

    /// [m] half the edge lengths of the smallest box around the body.
    pub fn half_extents(&self) -> Vector3<f64> {
        let local = match &self.shape {
            RoundBody::Sphere(radius) => Vector3::repeat(*radius),
            RoundBody::Cuboid(half_extents) => *half_extents,
            RoundBody::Cylinder { radius, half_height } => Vector3::new(*radius, *half_height, *radius),
        };
        self.turn(&local)
    }

    /// Surface of the body as triangles, for pictures: corner points [m], and for each triangle the indices of its
    /// three corners. Round bodies have 64 sides.
    pub fn triangles(&self) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
        const SIDES: u32 = 64;
        let (corners, triangles) = match &self.shape {
            RoundBody::Sphere(radius) => Ball::new(*radius).to_trimesh(SIDES, SIDES / 2),
            RoundBody::Cuboid(half_extents) => Cuboid::new(to_parry(half_extents)).to_trimesh(),
            RoundBody::Cylinder { radius, half_height } => Cylinder::new(*half_height, *radius).to_trimesh(SIDES),
        };
        (corners.into_iter().map(|corner| self.center + self.turn(&from_parry(corner))).collect(), triangles)
    }

    /// Exchanges two components of a vector: y, and the component along the body's axis. This converts between the axes
    /// of the domain and those of the shape, in both directions.
    fn turn(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        let mut turned = *vector;
        turned.swap((1, 0), (self.axis, 0));
        turned
    }
}

impl Geometry for Obstacle {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let local = to_parry(&self.turn(&(point - self.center)));
        let projection = match &self.shape {
            // parry divides by the distance to the centre; at the centre, the distance to the surface is equal in all
            // directions
            RoundBody::Sphere(radius) if local.length_squared() == 0.0 => {
                return Nearest { distance: -radius, normal: Vector3::y() };
            }
            RoundBody::Sphere(radius) => Ball::new(*radius).project_local_point(local, false),
            RoundBody::Cuboid(half) => Cuboid::new(to_parry(half)).project_local_point(local, false),
            RoundBody::Cylinder { radius, half_height } => {
                Cylinder::new(*half_height, *radius).project_local_point(local, false)
            }
        };
        let out = self.turn(&from_parry(local - projection.point));
        let length = out.norm();
        let sign = if projection.is_inside { -1.0 } else { 1.0 };
        // for a point on the surface, the direction from the centre of the body is used
        let normal = if length > 0.0 {
            out * (sign / length)
        } else {
            (point - self.center).try_normalize(0.0).unwrap_or_else(Vector3::y)
        };
        Nearest { distance: sign * length, normal }
    }

    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        convex::touch_time(|x| self.nearest(x), flight, radius, until)
    }

    fn turns(&self, turning: &Turning) -> bool {
        match &self.shape {
            RoundBody::Sphere(_) => turning.is_through(&self.center),
            RoundBody::Cylinder { .. } => turning.is_axis(&self.center, self.axis),
            RoundBody::Cuboid(_) => false,
        }
    }

    fn bounds(&self) -> Option<[Vector3<f64>; 2]> {
        Some([self.center - self.half_extents(), self.center + self.half_extents()])
    }

    fn in_words(&self) -> String {
        "solid body".into()
    }

    fn drawing(&self, _size: &Vector3<f64>) -> Drawing {
        self.triangles()
    }
}

impl fmt::Debug for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = match &self.shape {
            RoundBody::Sphere(_) => "sphere",
            RoundBody::Cuboid(_) => "cuboid",
            RoundBody::Cylinder { .. } => "cylinder",
        };
        write!(f, "{kind} at {:?}, half extents {:?}", self.center, self.half_extents())
    }
}

fn to_parry(v: &Vector3<f64>) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}

fn from_parry(v: ParryVector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}
