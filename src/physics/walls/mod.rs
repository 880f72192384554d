//! Walls: all bodies other than spheres. Spheres collide with them.
//!
//! For any point in space, a wall finds the nearest point of its surface and describes it by a signed distance and a
//! normal. The gap between a sphere and a wall is the distance of the sphere's centre minus the radius. For soft
//! spheres a negative gap is an overlap. For hard spheres the engine computes the time in a flight at which the gap
//! becomes zero.
//!
//! To add a shape, write one file with `impl Geometry`, then add a `mod` line, a variant of [`WallGeometry`] and an arm
//! of [`WallGeometry::law`].

mod advancement;
mod convex;
mod drawing;
mod hollow;
mod inside;
mod mesh;
mod moving;
mod near;
mod plane;
mod polynomial;
mod repeated;
mod roughness;
mod round;
mod shape;
mod shell;
mod thermal;
mod turning;

pub use drawing::Drawing;
pub use hollow::{Cavity, Hollow};
pub use mesh::{Continued, Fault, Findings, Mesh, Mismatch, Nested, Sides, continued};
pub use moving::{MovingShape, PiecewisePath, PrescribedMotion, ServoMotion, ServoState};
pub use near::NearWalls;
pub use plane::Plane;
pub use repeated::Repeated;
pub use roughness::{WallApproach, WallRoughness, perpendicular};
pub use round::{Frustum, RoundAxis};
pub use shape::Obstacle;
pub use thermal::ThermalWall;
pub use turning::Turning;

use crate::rotation::ResistanceFriction;
use crate::scene::{Elasticity, Surface};
use nalgebra::Vector3;
use serde::Serialize;
use std::sync::Arc;

/// Point of a wall that is nearest to a given point, described by its distance and its normal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nearest {
    /// [m] signed distance from the surface to the given point; positive on the side of the particles.
    pub distance: f64,
    /// [-] unit normal at the nearest point, from the wall towards the particles.
    pub normal: Vector3<f64>,
}

impl Nearest {
    /// Plane that is tangent to the wall at this nearest point. `point` [m] is the given point, from which the
    /// distance is measured.
    fn tangent(&self, point: &Vector3<f64>) -> Plane {
        Plane { point: point - self.normal * self.distance, normal: self.normal }
    }
}

/// Predicted touch of a sphere and a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// [s] time of the touch, from the beginning of the flight.
    pub time: f64,
    /// Number of the surface feature that is touched, such as a triangle. Each shape numbers its features in its own
    /// way. The number is 0 if the surface is not divided into features.
    pub feature: u32,
}

impl Touch {
    /// Touch at `time` [s] from the beginning of the flight, of a surface that is not divided into features.
    pub fn at(time: f64) -> Self {
        Self { time, feature: 0 }
    }
}

/// Shape of a wall. Only [`nearest`](Self::nearest) is required. A shape with a faster method for the time of touch
/// also implements [`touch_time`](Self::touch_time). A shape that case files can contain also implements the methods
/// for its bounds, its inside and its drawing.
pub trait Geometry: std::fmt::Debug + Send + Sync {
    /// Point of the surface that is nearest to `point` [m].
    fn nearest(&self, point: &Vector3<f64>) -> Nearest;

    /// [s] first time in `(0, until]` at which the gap between the wall and a sphere of `radius` [m] becomes zero. The
    /// flight of the centre is x(t) = position + velocity t + gravity t²/2 (SI units). The time is 0 if the sphere
    /// already overlaps the wall and still approaches it. `None` if the sphere does not touch. The default method is
    /// conservative advancement (steps in which the sphere certainly touches nothing), which needs only nearest
    /// points.
    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        advancement::touch_time(self, flight, radius, until)
    }

    /// Largest number of simultaneous contacts of the wall with one sphere. A sphere in a corner has several contacts.
    /// The contacts are numbered from 0.
    fn contacts(&self) -> u32 {
        1
    }

    /// Nearest point of the wall in contact number `which` (from 0) of a sphere with the centre `point` [m] and the
    /// radius `radius` [m].
    fn contact(&self, which: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        let _ = (which, radius);
        self.nearest(point)
    }

    /// True if the normal of contact number `which` (from 0) does not depend on the position of the sphere.
    fn is_flat_at(&self, which: u32) -> bool {
        let _ = which;
        false
    }

    /// [-] largest jump |n - n'| of the unit normal of a contact, from n to n', while a sphere slides along the wall. 0
    /// if the normal turns continuously.
    fn seam(&self) -> f64 {
        0.0
    }

    /// First touch of a sphere with the wall in contact number `which`, with the surface feature that is touched. The
    /// time and the arguments are defined as in [`touch_time`](Self::touch_time); `None` without a touch.
    fn first_touch(&self, which: u32, flight: &Flight, radius: f64, until: f64) -> Option<Touch> {
        let _ = which;
        self.touch_time(flight, radius, until).map(Touch::at)
    }

    /// Nearest point of the wall to the centre `point` [m] of a sphere of `radius` [m], at the instant at which the
    /// sphere touches the wall in contact number `which`. `feature` is the number of the touched surface feature (such
    /// as a triangle), from [`first_touch`](Self::first_touch).
    fn struck(&self, which: u32, feature: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        let _ = feature;
        self.contact(which, point, radius)
    }

    /// True if contact number `which` of a sphere of `radius` [m] may begin while the centre of the sphere moves by
    /// less than half of `skin` [m] from `point` [m].
    fn may_touch(&self, which: u32, point: &Vector3<f64>, radius: f64, skin: f64) -> bool {
        self.contact(which, point, radius).distance - radius < skin
    }

    /// True if the gap may become positive again after the centre of a sphere has passed through the surface. This
    /// holds for a thin sheet, and for a surface that is searched only near the sphere.
    fn is_thin(&self) -> bool {
        false
    }

    /// True if the surface may be within `distance` [m] of `point` [m]. Also true for a point behind the surface,
    /// unless the surface is [thin](Self::is_thin). The test should be fast, because it is done for all particles.
    fn is_within(&self, point: &Vector3<f64>, distance: f64) -> bool {
        self.nearest(point).distance <= distance
    }

    /// True if `point` [m] is certainly on the particles' side and farther than `distance` [m] from the surface. The
    /// result is false for some such points too, because the test does not compute the nearest point.
    fn is_clear(&self, point: &Vector3<f64>, distance: f64) -> bool {
        let _ = (point, distance);
        false
    }

    /// True if the contacts of a sphere are numbered by their distance from its centre, the nearest first. Then
    /// [`first_touch`](Self::first_touch) finds every touch for contact 0, and returns `None` for the other contacts.
    fn is_nearest_first(&self) -> bool {
        false
    }

    /// True if the surface can move along itself with `velocity` [m/s], like a conveyor belt. The velocity must be
    /// perpendicular to all normals.
    fn slides(&self, velocity: &Vector3<f64>) -> bool {
        let _ = velocity;
        false
    }

    /// True if the surface can turn while the shape stays in position. This requires a body of revolution about the
    /// axis of `turning`.
    fn turns(&self, turning: &Turning) -> bool {
        let _ = turning;
        false
    }

    /// [m] lowest and highest corner of a box around the body. `None` for endless shapes, and for vessels (walls around
    /// all particles).
    fn bounds(&self) -> Option<[Vector3<f64>; 2]> {
        None
    }

    /// [m] lowest and highest corner of a box around the wall, also for a vessel (a wall around all particles). `None`
    /// for a plane; infinite along the axis of a pipe without ends.
    fn extent(&self) -> Option<[Vector3<f64>; 2]> {
        self.bounds()
    }

    /// [m] lowest and highest corner of a box that contains all particles, infinite in directions without a limit.
    /// `None` unless the wall is a vessel (a wall around all particles) or a plane perpendicular to an axis.
    fn room_corners(&self) -> Option<[Vector3<f64>; 2]> {
        None
    }

    /// True if the wall is a vessel (a wall around all particles) that limits the positions of the particles along the
    /// axis `axis` (0, 1 or 2).
    fn holds_along(&self, axis: usize) -> bool {
        let _ = axis;
        false
    }

    /// [m³] volume inside a vessel (a wall around all particles); `None` if the wall is not a vessel. `size` [m]
    /// contains the edges of the domain, which limit the volume of a vessel without ends.
    fn vessel_volume(&self, size: &Vector3<f64>) -> Option<f64> {
        let _ = size;
        None
    }

    /// True if the wall has an inside: it is a vessel (a wall around all particles), a thin round shell with open ends,
    /// or a sheet of triangles.
    fn has_inside(&self) -> bool {
        false
    }

    /// True if `point` [m] is inside the wall. If the surface has open ends, its inside is the space between the rims
    /// of these ends.
    fn encloses(&self, point: &Vector3<f64>) -> bool {
        let _ = point;
        false
    }

    /// Name of the shape for a description of the scene.
    fn in_words(&self) -> String {
        "shape of the caller's".into()
    }

    /// Surface of the wall as triangles, for pictures. A pipe without ends is drawn as long as the domain, whose edges
    /// are `size` [m]. The result is empty for planes, which are drawn separately up to the sides of the domain.
    fn drawing(&self, size: &Vector3<f64>) -> Drawing {
        let _ = size;
        Drawing::default()
    }
}

/// Flight of a sphere's centre between contacts, in uniform gravity: a parabola.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Flight {
    /// [m] position of the centre at time 0.
    pub position: Vector3<f64>,
    /// [m/s] velocity of the centre at time 0.
    pub velocity: Vector3<f64>,
    /// [m/s²] acceleration by gravity.
    pub gravity: Vector3<f64>,
}

impl Flight {
    /// [m] position of the centre at time `t` [s].
    pub fn position_at(&self, t: f64) -> Vector3<f64> {
        self.position + (self.velocity + 0.5 * t * self.gravity) * t
    }

    /// [m/s] velocity of the centre at time `t` [s].
    pub fn velocity_at(&self, t: f64) -> Vector3<f64> {
        self.velocity + self.gravity * t
    }

    /// [s] shortest time in which the centre can cover the distance `length` [m]: the root t of |v| t + |g| t²/2 =
    /// `length`, with the velocity v and gravity g of the flight. Infinite at rest without gravity.
    pub fn time_to_cover(&self, length: f64) -> f64 {
        let (speed, gravity) = (self.velocity.norm(), self.gravity.norm());
        // the positive root, in a form without cancellation
        2.0 * length / (speed + (speed * speed + 2.0 * gravity * length).sqrt())
    }

    /// Returns this flight with its time counted from `t` [s] on: position and velocity are those at `t`.
    pub fn from(&self, t: f64) -> Self {
        Self { position: self.position_at(t), velocity: self.velocity_at(t), gravity: self.gravity }
    }
}

/// Shape of a wall, either of a type that a case (input file) can contain or defined by the calling program, which uses
/// this library.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WallGeometry {
    /// A half-space, for which times of touch are computed in closed form.
    Plane(Plane),
    /// A solid convex body inside the domain, with nearest points from the library parry.
    Obstacle(Obstacle),
    /// A solid truncated cone, or a thin round shell.
    Frustum(Frustum),
    /// A hollow body with the particles inside.
    Hollow(Hollow),
    /// A surface made of triangles.
    Mesh(Arc<Mesh>),
    /// A body with its images across periodic sides. In a periodic domain, a simulation uses this form for every body.
    Repeated(Arc<Repeated>),
    /// A moving shape, at its place at one instant. A plane that moves without rotation is a [`Plane`](Self::Plane)
    /// instead, at its place at this instant.
    Moving(Arc<MovingShape>),
    /// A shape that the calling program defines; a case cannot contain it.
    #[serde(skip)]
    Other(Arc<dyn Geometry>),
}

impl WallGeometry {
    /// Nearest point of the surface to `point` [m]. For planes, the most frequent walls, no virtual function is
    /// called, which is faster.
    #[inline]
    pub fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        self.plane().map_or_else(|| self.law().nearest(point), |plane| plane.nearest(point))
    }

    /// Plane of the wall, if its shape is a plane; otherwise `None`.
    #[inline]
    pub fn plane(&self) -> Option<&Plane> {
        if let Self::Plane(plane) = self { Some(plane) } else { None }
    }

    /// True if the shape is a plane, so that its normal is constant.
    #[inline]
    pub fn is_flat(&self) -> bool {
        self.plane().is_some()
    }

    /// Largest number of simultaneous contacts of the wall with one sphere.
    #[inline]
    pub fn contacts(&self) -> u32 {
        if self.is_flat() { 1 } else { self.law().contacts() }
    }

    /// Nearest point of the wall in contact number `which` (from 0) of a sphere with the centre `point` [m] and the
    /// radius `radius` [m].
    #[inline]
    pub fn contact(&self, which: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        self.plane().map_or_else(|| self.law().contact(which, point, radius), |plane| plane.nearest(point))
    }

    /// True if the normal of contact number `which` (from 0) does not depend on the position of the sphere.
    #[inline]
    pub fn is_flat_at(&self, which: u32) -> bool {
        self.is_flat() || self.law().is_flat_at(which)
    }

    /// [-] largest jump of the normal of a contact, as [`Geometry::seam`] defines it.
    pub fn seam(&self) -> f64 {
        if self.is_flat() { 0.0 } else { self.law().seam() }
    }

    /// First touch for contact number `which`, as [`Geometry::first_touch`] defines it; `None` without a touch.
    #[inline]
    pub fn first_touch(&self, which: u32, flight: &Flight, radius: f64, until: f64) -> Option<Touch> {
        self.law().first_touch(which, flight, radius, until)
    }

    /// Nearest point at the instant of a touch, as [`Geometry::struck`] defines it. For planes no virtual function is
    /// called, which is faster.
    #[inline]
    pub fn struck(&self, which: u32, feature: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        self.plane().map_or_else(|| self.law().struck(which, feature, point, radius), |plane| plane.nearest(point))
    }

    /// True if contact number `which` (from 0) of a sphere may begin, as [`Geometry::may_touch`] defines it.
    pub fn may_touch(&self, which: u32, point: &Vector3<f64>, radius: f64, skin: f64) -> bool {
        self.law().may_touch(which, point, radius, skin)
    }

    /// True if the surface may be within `distance` [m] of `point` [m], as [`Geometry::is_within`] defines it. For
    /// planes no virtual function is called, which is faster.
    #[inline]
    pub fn is_within(&self, point: &Vector3<f64>, distance: f64) -> bool {
        self.plane()
            .map_or_else(|| self.law().is_within(point, distance), |plane| plane.nearest(point).distance <= distance)
    }

    /// Shape of the wall as a trait object, through which the functions of [`Geometry`] are called.
    #[inline]
    pub fn law(&self) -> &dyn Geometry {
        match self {
            Self::Plane(plane) => plane,
            Self::Obstacle(obstacle) => obstacle,
            Self::Frustum(frustum) => frustum,
            Self::Hollow(hollow) => hollow,
            Self::Mesh(mesh) => mesh.as_ref(),
            Self::Repeated(body) => body.as_ref(),
            Self::Moving(moving) => moving.as_ref(),
            Self::Other(shape) => shape.as_ref(),
        }
    }
}

impl WallGeometry {
    /// [m] lowest and highest corner of the box around the body. For a body with periodic images, the list also has
    /// the boxes around its nearest images. The list is empty if the shape has no bounds.
    pub fn boxes(&self) -> Vec<[Vector3<f64>; 2]> {
        match self {
            Self::Repeated(body) => body.boxes(),
            shape => shape.law().bounds().into_iter().collect(),
        }
    }

    /// True if the centre of a sphere of `radius` [m] crosses a thin surface on the straight line from `from` to `to`
    /// [m]. False for surfaces that are not thin.
    pub fn is_passed(&self, from: &Vector3<f64>, to: &Vector3<f64>, radius: f64) -> bool {
        /// [-] distance from the surface over the radius of the sphere. A centre that comes nearer counts as having
        /// crossed.
        const TOUCH: f64 = 1e-6;
        let flight = Flight { position: *from, velocity: to - from, gravity: Vector3::zeros() };
        self.law().is_thin() && self.law().touch_time(&flight, TOUCH * radius, 1.0).is_some()
    }
}

/// A wall: a shape with its position at an instant, and the properties of its surface.
#[derive(Clone, Debug, Serialize)]
pub struct Wall {
    /// Shape of the wall at its place at one instant, that of the scene.
    pub geometry: WallGeometry,
    /// Restitution and friction between the wall and every particle.
    pub surface: Surface,
    /// Elasticity of the wall; `None` if the elasticity of the contact law applies.
    pub elasticity: Option<Elasticity>,
    /// [m/s] velocity of the surface along itself, as of a conveyor belt. The shape does not move.
    #[serde(skip_serializing_if = "is_still")]
    pub velocity: Vector3<f64>,
    /// Rotation of the surface, as of a drum or a turntable, while the shape stays in position; `None` without
    /// rotation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turning: Option<Turning>,
    /// Motion of the shape; `None`: the shape stays in position. [`Wall::moving`] sets it together with `geometry`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moving: Option<MovingShape>,
    /// Coefficients of rolling and twisting friction at the wall. A coefficient that is missing is taken from the
    /// rolling or twisting law.
    #[serde(skip_serializing_if = "ResistanceFriction::is_of_law")]
    pub resistance: ResistanceFriction,
    /// Roughness; `None`: the wall is smooth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness: Option<WallRoughness>,
    /// Temperature of the wall, which gives each sphere that hits it a random new velocity. A temperature requires a
    /// model with instantaneous impacts. `None`: rebounds follow the restitution and friction of `surface`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thermal: Option<ThermalWall>,
}

impl Wall {
    /// Makes a wall with a shape and a surface; neither of them moves.
    pub fn new(geometry: WallGeometry, surface: Surface) -> Self {
        let (velocity, resistance) = (Vector3::zeros(), ResistanceFriction::default());
        let (turning, moving, roughness, thermal) = (None, None, None, None);
        Self { geometry, surface, elasticity: None, velocity, turning, moving, resistance, roughness, thermal }
    }

    /// True if the surface moves along itself (a belt or a drum) or together with the shape of the wall.
    pub fn surface_moves(&self) -> bool {
        self.moving.is_some() || self.turning.is_some() || self.velocity != Vector3::zeros()
    }
}

fn is_still(velocity: &Vector3<f64>) -> bool {
    *velocity == Vector3::zeros()
}

/// True if two spheres in straight flight approach each other, and the smallest distance of their centres is at most
/// `reach` [m], the sum of their radii. If the result is false, [`first_touch`] finds no time. `apart` [m] and
/// `velocity` [m/s] are the relative position and the relative velocity. The test has no branches, so that a processor
/// can test several pairs at once.
#[inline(always)]
pub fn may_touch(apart: &Vector3<f64>, velocity: &Vector3<f64>, reach: f64) -> bool {
    let closing = -apart.dot(velocity);
    let gap_square = apart.norm_squared() - reach * reach;
    (closing > 0.0) & (closing * closing - velocity.norm_squared() * gap_square >= 0.0)
}

/// [s] first time at which two spheres in straight flight touch: the smaller root t of |r + u t| = `reach`. The
/// relative position r [m] is `apart`, the relative velocity u [m/s] is `velocity`, and `reach` [m] is the sum of the
/// radii. The time is 0 for spheres that overlap (by rounding) and approach. `None` for spheres that separate or miss
/// each other. `speeds` [m/s] is the sum of both speeds; an approach slower than the rounding of this sum is ignored.
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
