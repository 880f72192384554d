//! What stops a sphere that is not another sphere?
//!
//! A wall is asked one question: where is your nearest point to here? The answer is a signed distance and a normal;
//! the gap to a sphere is that distance less its radius. The soft engine turns a negative gap into an overlap; the
//! hard engine finds the instant at which the gap along a flight becomes zero.
//!
//! To add a shape: one file with `impl Geometry`, then a `mod` line, a variant of [`WallGeometry`] and an arm of `law`.

mod advancement;
mod convex;
mod drawing;
mod hollow;
mod inside;
mod mesh;
mod near;
mod plane;
mod polynomial;
mod repeated;
mod round;
mod shape;
mod shell;

pub use hollow::{Cavity, Hollow};
pub use mesh::{Continued, Fault, Findings, Mesh, Mismatch, Nested, Sides, continued};
pub use near::NearWalls;
pub use plane::Plane;
pub use repeated::Repeated;
pub use round::{Frustum, RoundAxis};
pub use shape::Obstacle;

use crate::scene::{Elasticity, Surface};
use nalgebra::Vector3;
use serde::Serialize;
use std::sync::Arc;

/// The nearest point of a wall, seen from some point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nearest {
    /// [m] signed distance to the surface: positive on the particles' side.
    pub distance: f64,
    /// [-] unit normal at the nearest point, from the wall towards the particles.
    pub normal: Vector3<f64>,
}

impl Nearest {
    /// The plane that touches the wall at the nearest point to `point` [m].
    fn tangent(&self, point: &Vector3<f64>) -> Plane {
        Plane { point: point - self.normal * self.distance, normal: self.normal }
    }
}

/// A touch foreseen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// [s] when.
    pub time: f64,
    /// Which part of the surface, where that has parts; the shape knows what the number means.
    pub place: u32,
}

impl Touch {
    /// Of a surface without parts at `time` [s].
    pub fn at(time: f64) -> Self {
        Self { time, place: 0 }
    }
}

/// The shape of a wall. One answer is needed, the nearest point; a shape that knows its time of touch better gives it too.
pub trait Geometry: std::fmt::Debug + Send + Sync {
    /// The nearest point of the surface to `point` [m].
    fn nearest(&self, point: &Vector3<f64>) -> Nearest;

    /// [s] first instant in `(0, until]` at which the gap of a sphere of `radius` [m] closes on the flight
    /// x(t) = position + velocity t + gravity t²/2 (SI units); 0 if it overlaps and approaches already; `None` if not in that
    /// time. By default found by conservative advancement, which needs nothing but the nearest point.
    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        advancement::touch_time(self, flight, radius, until)
    }

    /// How many contacts it may have with one sphere at once: a sphere in a corner has several. They are numbered from 0.
    fn contacts(&self) -> u32 {
        1
    }

    /// The nearest point of contact `which` to the centre `point` [m] of a sphere of `radius` [m].
    fn contact(&self, which: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        let _ = (which, radius);
        self.nearest(point)
    }

    /// Whether the normal of contact `which` is the same everywhere.
    fn is_flat_at(&self, which: u32) -> bool {
        let _ = which;
        false
    }

    /// [-] length of the largest difference between two unit normals between which the normal of one contact can jump while a sphere slides
    /// along; 0 where it turns steadily.
    fn seam(&self) -> f64 {
        0.0
    }

    /// As [`touch_time`](Self::touch_time), for contact `which` alone, and what is touched.
    fn first_touch(&self, which: u32, flight: &Flight, radius: f64, until: f64) -> Option<Touch> {
        let _ = which;
        self.touch_time(flight, radius, until).map(Touch::at)
    }

    /// As [`contact`](Self::contact) at the instant of a touch, of the place that [`first_touch`](Self::first_touch) has named.
    fn struck(&self, which: u32, place: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        let _ = place;
        self.contact(which, point, radius)
    }

    /// Whether contact `which` may come about for a sphere of `radius` [m] before its centre, now at `point` [m], has gone half of
    /// `skin` [m].
    fn may_touch(&self, which: u32, point: &Vector3<f64>, radius: f64, skin: f64) -> bool {
        self.contact(which, point, radius).distance - radius < skin
    }

    /// Whether a sphere whose centre has passed the surface may look free again: a thin sheet, or a surface that is looked for only near by.
    fn is_thin(&self) -> bool {
        false
    }

    /// Whether the surface may be within `distance` [m] of `point` [m], or the point behind it: asked of all particles, so it
    /// should be quick.
    fn is_within(&self, point: &Vector3<f64>, distance: f64) -> bool {
        self.nearest(point).distance <= distance
    }

    /// Whether it is plain, without asking for the nearest point, that `point` [m] is on the particles' side and farther than `distance` [m]
    /// from the surface.
    fn is_clear(&self, point: &Vector3<f64>, distance: f64) -> bool {
        let _ = (point, distance);
        false
    }
}

/// Ballistic motion in uniform gravity.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Flight {
    /// [m] position at time 0.
    pub position: Vector3<f64>,
    /// [m/s] velocity at time 0.
    pub velocity: Vector3<f64>,
    /// [m/s²] gravity.
    pub gravity: Vector3<f64>,
}

impl Flight {
    /// [m] position at time `t` [s].
    pub fn position_at(&self, t: f64) -> Vector3<f64> {
        self.position + (self.velocity + 0.5 * t * self.gravity) * t
    }

    /// [m/s] velocity at time `t` [s].
    pub fn velocity_at(&self, t: f64) -> Vector3<f64> {
        self.velocity + self.gravity * t
    }

    /// The same flight with its time counted from `t` [s] on.
    pub fn from(&self, t: f64) -> Self {
        Self { position: self.position_at(t), velocity: self.velocity_at(t), gravity: self.gravity }
    }
}

/// The shapes a case can name.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WallGeometry {
    /// A half-space, in closed form.
    Plane(Plane),
    /// A solid body inside the domain, through parry.
    Obstacle(Obstacle),
    /// A solid truncated cone, or a thin round shell.
    Frustum(Frustum),
    /// A hollow body with the particles inside.
    Hollow(Hollow),
    /// A surface of triangles.
    Mesh(Arc<Mesh>),
    /// A body with its images across periodic sides; a simulation makes it of every body in a periodic box.
    Repeated(Arc<Repeated>),
    /// A shape of the caller's; a case cannot name it.
    #[serde(skip)]
    Other(Arc<dyn Geometry>),
}

impl WallGeometry {
    /// The nearest point of the surface to `point` [m]; of planes, which most scenes have, without a detour.
    #[inline]
    pub fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        self.plane().map_or_else(|| self.law().nearest(point), |plane| plane.nearest(point))
    }

    /// The plane, if it is one: its normal is the same everywhere.
    #[inline]
    pub fn plane(&self) -> Option<&Plane> {
        if let Self::Plane(plane) = self { Some(plane) } else { None }
    }

    /// Whether its normal is the same everywhere.
    #[inline]
    pub fn is_flat(&self) -> bool {
        self.plane().is_some()
    }

    /// Whether its surface can move along itself with that velocity [m/s] and stay where it is: at right angles to all of its normals.
    pub fn slides(&self, velocity: &Vector3<f64>) -> bool {
        /// [-] what of a direction is rounding.
        const ROUNDING: f64 = 1e-9;
        let across = |normal: &Vector3<f64>| velocity.dot(normal).abs() <= ROUNDING * velocity.norm();
        match self {
            Self::Plane(plane) => across(&plane.normal),
            Self::Hollow(hollow) => match hollow.room() {
                Cavity::Pipe { axle, .. } => (0..3).all(|k| k == axle.axis || velocity[k] == 0.0),
                Cavity::Box { .. } | Cavity::Sphere { .. } | Cavity::ClosedCylinder(_) => false,
            },
            Self::Mesh(mesh) => mesh.normals().all(across),
            Self::Repeated(body) => body.shape().slides(velocity),
            Self::Obstacle(_) | Self::Frustum(_) | Self::Other(_) => false,
        }
    }

    /// Whether its contacts are numbered from the nearest on.
    pub fn is_nearest_first(&self) -> bool {
        match self {
            Self::Repeated(body) => body.shape().is_nearest_first(),
            shape => matches!(shape, Self::Mesh(_) | Self::Frustum(_)),
        }
    }

    /// Whether it holds all particles along axis 0, 1 or 2, being a vessel around them.
    pub fn holds_along(&self, axis: usize) -> bool {
        match self {
            Self::Hollow(hollow) => match hollow.room() {
                Cavity::Pipe { axle, .. } => axle.axis != axis,
                Cavity::Box { .. } | Cavity::Sphere { .. } | Cavity::ClosedCylinder(_) => true,
            },
            Self::Mesh(mesh) => mesh.sides() == Sides::Inside,
            Self::Repeated(body) => body.shape().holds_along(axis),
            Self::Plane(_) | Self::Obstacle(_) | Self::Frustum(_) | Self::Other(_) => false,
        }
    }

    /// [m³] the volume of a vessel that holds all particles, in a domain with those edges [m]; `None` of what is no vessel.
    pub fn vessel_volume(&self, size: &Vector3<f64>) -> Option<f64> {
        match self {
            Self::Hollow(hollow) => Some(hollow.volume(size)),
            Self::Mesh(mesh) if mesh.sides() == Sides::Inside => Some(mesh.volume()),
            Self::Repeated(body) => body.shape().vessel_volume(size),
            Self::Mesh(_) | Self::Plane(_) | Self::Obstacle(_) | Self::Frustum(_) | Self::Other(_) => None,
        }
    }

    /// How many contacts it may have with one sphere at once.
    #[inline]
    pub fn contacts(&self) -> u32 {
        if self.is_flat() { 1 } else { self.law().contacts() }
    }

    /// The nearest point of contact `which` to the centre `point` [m] of a sphere of `radius` [m].
    #[inline]
    pub fn contact(&self, which: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        self.plane().map_or_else(|| self.law().contact(which, point, radius), |plane| plane.nearest(point))
    }

    /// Whether the normal of contact `which` is the same everywhere.
    #[inline]
    pub fn is_flat_at(&self, which: u32) -> bool {
        self.is_flat() || self.law().is_flat_at(which)
    }

    /// As [`Geometry::seam`].
    pub fn seam(&self) -> f64 {
        if self.is_flat() { 0.0 } else { self.law().seam() }
    }

    /// As [`Geometry::first_touch`].
    #[inline]
    pub fn first_touch(&self, which: u32, flight: &Flight, radius: f64, until: f64) -> Option<Touch> {
        self.law().first_touch(which, flight, radius, until)
    }

    /// As [`Geometry::struck`]; of planes without a detour.
    #[inline]
    pub fn struck(&self, which: u32, place: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        self.plane().map_or_else(|| self.law().struck(which, place, point, radius), |plane| plane.nearest(point))
    }

    /// As [`Geometry::may_touch`].
    pub fn may_touch(&self, which: u32, point: &Vector3<f64>, radius: f64, skin: f64) -> bool {
        self.law().may_touch(which, point, radius, skin)
    }

    /// As [`Geometry::is_within`]; of planes without a detour.
    #[inline]
    pub fn is_within(&self, point: &Vector3<f64>, distance: f64) -> bool {
        self.plane()
            .map_or_else(|| self.law().is_within(point, distance), |plane| plane.nearest(point).distance <= distance)
    }

    /// The shape behind the name.
    #[inline]
    pub fn law(&self) -> &dyn Geometry {
        match self {
            Self::Plane(plane) => plane,
            Self::Obstacle(obstacle) => obstacle,
            Self::Frustum(frustum) => frustum,
            Self::Hollow(hollow) => hollow,
            Self::Mesh(mesh) => mesh.as_ref(),
            Self::Repeated(body) => body.as_ref(),
            Self::Other(shape) => shape.as_ref(),
        }
    }
}

impl WallGeometry {
    /// [m] corners of a box around the body; `None` of what has no ends, of vessels, and of shapes of the caller's.
    pub fn bounds(&self) -> Option<[Vector3<f64>; 2]> {
        let about = |center: Vector3<f64>, half: Vector3<f64>| [center - half, center + half];
        match self {
            Self::Obstacle(body) => Some(about(body.center(), body.half_extents())),
            Self::Frustum(body) => {
                let radius = body.radii[0].max(body.radii[1]);
                let half = |k: usize| if k == body.axle.axis { body.half_height } else { radius };
                Some(about(body.axle.center, Vector3::from_fn(|k, _| half(k))))
            }
            Self::Mesh(mesh) if mesh.sides() != Sides::Inside => Some(mesh.bounds()),
            Self::Repeated(body) => body.shape().bounds(),
            Self::Plane(_) | Self::Hollow(_) | Self::Mesh(_) | Self::Other(_) => None,
        }
    }

    /// [m] corners of boxes around the body and its nearest images; none where there are no bounds.
    pub fn boxes(&self) -> Vec<[Vector3<f64>; 2]> {
        match self {
            Self::Repeated(body) => body.boxes(),
            shape => shape.bounds().into_iter().collect(),
        }
    }

    /// Whether the centre of a sphere passes the surface on the straight way from `from` to `to` [m], where that is thin.
    pub fn is_passed(&self, from: &Vector3<f64>, to: &Vector3<f64>, radius: f64) -> bool {
        /// [-] of the radius: what the centre may have come nearer than and have passed.
        const TOUCH: f64 = 1e-6;
        let flight = Flight { position: *from, velocity: to - from, gravity: Vector3::zeros() };
        self.law().is_thin() && self.law().touch_time(&flight, TOUCH * radius, 1.0).is_some()
    }
}

/// A wall: a shape at rest and how its surface answers an impact.
#[derive(Clone, Debug, Serialize)]
pub struct Wall {
    /// Where it is.
    pub geometry: WallGeometry,
    /// Restitution and friction against every particle.
    pub surface: Surface,
    /// Its own elasticity; `None`: that of the contact law.
    pub elasticity: Option<Elasticity>,
    /// [m/s] velocity of its surface along itself, as of a belt: the shape stays where it is.
    #[serde(skip_serializing_if = "is_still")]
    pub velocity: Vector3<f64>,
}

impl Wall {
    /// A wall whose surface is still.
    pub fn new(geometry: WallGeometry, surface: Surface) -> Self {
        Self { geometry, surface, elasticity: None, velocity: Vector3::zeros() }
    }
}

fn is_still(velocity: &Vector3<f64>) -> bool {
    *velocity == Vector3::zeros()
}

/// Whether [`first_touch`] may find a time for two spheres in straight flight: they approach, and pass each other within `reach` [m]. It asks
/// without branches, so that a processor can go on with the next two.
#[inline(always)]
pub fn may_touch(apart: &Vector3<f64>, velocity: &Vector3<f64>, reach: f64) -> bool {
    let closing = -apart.dot(velocity);
    let gap_square = apart.norm_squared() - reach * reach;
    (closing > 0.0) & (closing * closing - velocity.norm_squared() * gap_square >= 0.0)
}

/// [s] when two spheres in straight flight first touch: the smaller root of |r + u t| = reach, separation r [m], relative
/// velocity u [m/s]. Spheres that overlap (by rounding) and approach touch now, 0; those that separate do not touch
/// again. `speeds` [m/s] is the sum of both speeds: an approach slower than its rounding is none.
#[inline]
pub fn first_touch(apart: &Vector3<f64>, velocity: &Vector3<f64>, reach: f64, speeds: f64) -> Option<f64> {
    let closing = -apart.dot(velocity);
    if closing <= 0.0 {
        return None;
    }
    let gap_square = apart.norm_squared() - reach * reach;
    let discriminant = closing * closing - velocity.norm_squared() * gap_square;
    if discriminant < 0.0 || closing <= 4.0 * f64::EPSILON * apart.norm() * speeds {
        return None;
    }
    if gap_square <= 0.0 {
        return Some(0.0);
    }
    Some(gap_square / (closing + discriminant.sqrt()))
}
