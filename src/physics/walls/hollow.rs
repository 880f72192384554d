//! Hollow bodies with particles inside: a box, a sphere, a closed cylinder or cone, a pipe without ends. Each side is
//! a separate contact, so a sphere in a corner has one contact for each side that it touches. A round side has a
//! second contact, opposite to the nearest point, for spheres as wide as the body: they touch both sides at once.

use super::drawing::turned;
use super::round::{Bowl, Frustum, OppositeBowl, OppositeTube, RoundAxis, Tube};
use super::{Drawing, Flight, Geometry, Nearest, Obstacle, Plane, Touch, Turning};
use nalgebra::{Vector2, Vector3};
use serde::Serialize;
use std::f64::consts::PI;
use std::fmt;

/// One side of a hollow body. The normal of the side points into the body, to the particles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
enum InnerSide {
    Plane(Plane),
    Bowl(Bowl),
    Tube(Tube),
    OppositeBowl(OppositeBowl),
    OppositeTube(OppositeTube),
}

impl InnerSide {
    fn law(&self) -> &dyn Geometry {
        match self {
            Self::Plane(plane) => plane,
            Self::Bowl(bowl) => bowl,
            Self::Tube(tube) => tube,
            Self::OppositeBowl(bowl) => bowl,
            Self::OppositeTube(tube) => tube,
        }
    }
}

/// Shape of a hollow body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cavity {
    /// A box with edges along the axes.
    Box {
        /// [m] centre of the box.
        center: Vector3<f64>,
        /// [m] half the lengths of the edges along x, y, z.
        half_extents: Vector3<f64>,
    },
    /// A sphere.
    Sphere {
        /// [m] centre of the sphere.
        center: Vector3<f64>,
        /// [m] radius of the sphere.
        radius: f64,
    },
    /// A closed cylinder or truncated cone.
    ClosedCylinder(Frustum),
    /// A pipe without ends.
    Pipe {
        /// Axis of the pipe.
        axle: RoundAxis,
        /// [m] inner radius of the pipe.
        radius: f64,
    },
}

/// A convex hollow body with the particles inside.
#[derive(Clone, PartialEq, Serialize)]
pub struct Hollow {
    room: Cavity,
    sides: Vec<InnerSide>,
}

impl Hollow {
    /// Makes a hollow body of the shape `room`, with its sides.
    pub fn new(room: Cavity) -> Self {
        let end = |center: Vector3<f64>, axis: usize, offset: f64| {
            let along = Vector3::from_fn(|k, _| if k == axis { 1.0 } else { 0.0 });
            InnerSide::Plane(Plane { point: center + along * offset, normal: along * -offset.signum() })
        };
        let sides = match room {
            Cavity::Box { center, half_extents } => {
                (0..3).flat_map(|k| [-1.0, 1.0].map(|sign| end(center, k, sign * half_extents[k]))).collect()
            }
            Cavity::Sphere { center, radius } => {
                let bowl = Bowl { center, radius };
                vec![InnerSide::Bowl(bowl), InnerSide::OppositeBowl(OppositeBowl(bowl))]
            }
            Cavity::ClosedCylinder(Frustum { axle, radii: [low, high], half_height, .. }) => {
                let slope = 0.5 * (high - low) / half_height;
                let tube = Tube { axle, radius: 0.5 * (low + high), slope };
                vec![
                    InnerSide::Tube(tube),
                    end(axle.center, axle.axis, -half_height),
                    end(axle.center, axle.axis, half_height),
                    InnerSide::OppositeTube(OppositeTube(tube)),
                ]
            }
            Cavity::Pipe { axle, radius } => {
                let tube = Tube { axle, radius, slope: 0.0 };
                vec![InnerSide::Tube(tube), InnerSide::OppositeTube(OppositeTube(tube))]
            }
        };
        Self { room, sides }
    }

    /// Shape and size of the hollow body.
    pub fn room(&self) -> &Cavity {
        &self.room
    }

    /// [m] lowest and highest corner of the smallest box around the body; infinite along the axis of a pipe.
    pub fn corners(&self) -> [Vector3<f64>; 2] {
        let round = |axle: &RoundAxis, radius: f64, half_height: f64| {
            (axle.center, Vector3::from_fn(|axis, _| if axis == axle.axis { half_height } else { radius }))
        };
        let (center, half) = match &self.room {
            Cavity::Box { center, half_extents } => (*center, *half_extents),
            Cavity::Sphere { center, radius } => (*center, Vector3::repeat(*radius)),
            Cavity::ClosedCylinder(Frustum { axle, radii: [low, high], half_height, .. }) => {
                round(axle, low.max(*high), *half_height)
            }
            Cavity::Pipe { axle, radius } => round(axle, *radius, f64::INFINITY),
        };
        [center - half, center + half]
    }

    /// [m³] volume inside the body; for a pipe, the volume inside a domain whose edges are `size` [m].
    pub fn volume(&self, size: &Vector3<f64>) -> f64 {
        match &self.room {
            Cavity::Box { half_extents, .. } => 8.0 * half_extents.product(),
            Cavity::Sphere { radius, .. } => 4.0 / 3.0 * PI * radius.powi(3),
            Cavity::ClosedCylinder(Frustum { radii: [low, high], half_height, .. }) => {
                2.0 / 3.0 * PI * half_height * (low * low + low * high + high * high)
            }
            Cavity::Pipe { axle, radius } => PI * radius * radius * size[axle.axis],
        }
    }

    fn side(&self, which: u32) -> &dyn Geometry {
        self.sides[which as usize].law()
    }
}

impl Geometry for Hollow {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let each = self.sides.iter().map(|side| side.law().nearest(point));
        let none = Nearest { distance: f64::INFINITY, normal: Vector3::y() };
        each.reduce(|a, b| if b.distance < a.distance { b } else { a }).unwrap_or(none)
    }

    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        self.sides.iter().filter_map(|side| side.law().touch_time(flight, radius, until)).reduce(f64::min)
    }

    fn contacts(&self) -> u32 {
        self.sides.len() as u32
    }

    fn contact(&self, which: u32, point: &Vector3<f64>, _radius: f64) -> Nearest {
        self.side(which).nearest(point)
    }

    fn is_flat_at(&self, which: u32) -> bool {
        matches!(self.sides[which as usize], InnerSide::Plane(_))
    }

    fn first_touch(&self, which: u32, flight: &Flight, radius: f64, until: f64) -> Option<Touch> {
        self.side(which).touch_time(flight, radius, until).map(Touch::at)
    }

    fn slides(&self, velocity: &Vector3<f64>) -> bool {
        match &self.room {
            Cavity::Pipe { axle, .. } => (0..3).all(|k| k == axle.axis || velocity[k] == 0.0),
            Cavity::Box { .. } | Cavity::Sphere { .. } | Cavity::ClosedCylinder(_) => false,
        }
    }

    fn turns(&self, turning: &Turning) -> bool {
        match &self.room {
            Cavity::Pipe { axle, .. } | Cavity::ClosedCylinder(Frustum { axle, .. }) => {
                turning.is_axis(&axle.center, axle.axis)
            }
            Cavity::Sphere { center, .. } => turning.is_through(center),
            Cavity::Box { .. } => false,
        }
    }

    fn extent(&self) -> Option<[Vector3<f64>; 2]> {
        self.room_corners()
    }

    fn room_corners(&self) -> Option<[Vector3<f64>; 2]> {
        Some(self.corners())
    }

    fn holds_along(&self, axis: usize) -> bool {
        match &self.room {
            Cavity::Pipe { axle, .. } => axle.axis != axis,
            Cavity::Box { .. } | Cavity::Sphere { .. } | Cavity::ClosedCylinder(_) => true,
        }
    }

    fn vessel_volume(&self, size: &Vector3<f64>) -> Option<f64> {
        Some(self.volume(size))
    }

    fn has_inside(&self) -> bool {
        true
    }

    fn encloses(&self, point: &Vector3<f64>) -> bool {
        self.nearest(point).distance > 0.0
    }

    fn in_words(&self) -> String {
        let shape = match &self.room {
            Cavity::Box { .. } => "hollow box",
            Cavity::Sphere { .. } => "hollow sphere",
            Cavity::ClosedCylinder(_) => "closed round vessel",
            Cavity::Pipe { .. } => "pipe without ends",
        };
        format!("{shape} with the particles inside")
    }

    fn drawing(&self, size: &Vector3<f64>) -> Drawing {
        match self.room {
            Cavity::Box { center, half_extents } => Obstacle::cuboid(center, half_extents).triangles(),
            Cavity::Sphere { center, radius } => Obstacle::sphere(center, radius).triangles(),
            Cavity::ClosedCylinder(can) => turned(&can.axle, &Frustum { solid: true, ..can }.outline()),
            Cavity::Pipe { axle, radius } => {
                let at = axle.center[axle.axis];
                turned(&axle, &[Vector2::new(radius, -at), Vector2::new(radius, size[axle.axis] - at)])
            }
        }
    }
}

impl fmt::Debug for Hollow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "hollow {:?}", self.room)
    }
}
