//! Walls whose shape moves: translation, vibration, a path, or rotation about an axis.
//!
//! The motion is an exact function of time. The motion of a servo wall, which moves so that particles press on it with
//! a given pressure, is known only within a window (time between two exchanges with the gas). A
//! [`Scene`](crate::scene::Scene) belongs to an instant, and so does the geometry of its walls ([`Wall::move_to`]).
//! The functions of a wall also give its state at the time `ahead` [s] after that instant.

mod arcs;
mod motion;
mod path;
mod servo;
mod vibrating_plane;

pub use motion::PrescribedMotion;
pub use path::PiecewisePath;
pub use servo::{ServoMotion, ServoState};

use super::{Drawing, Flight, Geometry, Nearest, Plane, Repeated, Touch, Wall, WallGeometry};
use crate::domain::Domain;
use nalgebra::Vector3;
use serde::Serialize;
use std::f64::consts::TAU;
use std::sync::Arc;
use vibrating_plane::VibratingGap;

/// A shape with the law of its motion, and the instant for which the place of the shape is computed.
#[derive(Clone, Debug, Serialize)]
pub struct MovingShape {
    /// Shape of the wall where the case (input file) puts it, without displacement.
    pub(super) shape: Arc<WallGeometry>,
    /// Law of the motion of the shape, as a function of the simulated time.
    motion: PrescribedMotion,
    /// [s] simulated time for which the place of the shape is computed.
    #[serde(skip)]
    time: f64,
    /// [m] upper limit of the distance of a point of the shape from the axis of a rotation; 0 for other motions.
    arm: f64,
}

impl MovingShape {
    /// Makes a moving shape at its place at time 0. `shape` is the shape at the place where the case (input file) puts
    /// it. `None` for the rotation of a shape without an [`extent`](Geometry::extent), such as a plane, and of one that
    /// extends to infinity, such as a pipe without ends, since their points would have no largest speed.
    pub fn new(shape: WallGeometry, motion: PrescribedMotion) -> Option<Self> {
        let arm = match &motion {
            PrescribedMotion::Turning(turning) => {
                let corners = corners(shape.law().extent()?);
                let arm = |corner: &Vector3<f64>| (corner - turning.center).norm();
                corners.iter().map(arm).fold(0.0, f64::max)
            }
            _ => 0.0,
        };
        arm.is_finite().then(|| Self { shape: Arc::new(shape), motion, time: 0.0, arm })
    }

    /// Law of the motion of the shape, as a function of the simulated time.
    pub fn motion(&self) -> &PrescribedMotion {
        &self.motion
    }

    /// [s] simulated time for which the place of the shape is computed.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Shape where the case (input file) puts it, without displacement.
    pub fn shape(&self) -> &WallGeometry {
        &self.shape
    }

    /// [m] position of `point` [m] in the frame that moves with the shape, at the simulated time `time` [s].
    pub fn to_shape(&self, point: &Vector3<f64>, time: f64) -> Vector3<f64> {
        self.motion.to_shape(point, time)
    }

    /// [m/s] upper limit of the speed of any point of the shape at any time.
    pub fn largest_speed(&self) -> f64 {
        self.motion.largest_speed(self.arm)
    }

    /// [m] upper limit of the distance by which a point of the shape moves within `duration` [s].
    pub fn travel(&self, duration: f64) -> f64 {
        let speed = self.largest_speed();
        let way = if speed == 0.0 { 0.0 } else { speed * duration };
        way.min(self.motion.largest_excursion(self.arm))
    }

    /// False if a sphere of `radius` [m] certainly does not touch the shape in a flight of `duration` [s] that begins
    /// at the stored instant `time`.
    ///
    /// Seen from the shape, the distance of the sphere from its position in the middle of the flight is |v| h + |a|
    /// h²/2 + J h³/6 at most. Here h is half the duration; v and a are velocity and acceleration in the middle, and J
    /// bounds the third derivative of the position. On a path, whose velocity jumps, |v| is replaced by the speed of
    /// the sphere plus the largest speed of the shape.
    pub fn may_reach(&self, flight: &Flight, radius: f64, duration: f64) -> bool {
        let half = 0.5 * duration;
        let middle = flight.from(half);
        let seen = self.motion.seen(&middle, self.time + half);
        let speed = match &self.motion {
            PrescribedMotion::Path(path) => middle.velocity.norm() + path.largest_speed(),
            _ => seen.velocity.norm(),
        };
        let third = self.motion.jerk(&middle, half) / 6.0;
        let way = half * (speed + half * (0.5 * seen.gravity.norm() + half * third));
        // the limit is enlarged, so that rounding does not make it too small
        self.shape.is_within(&seen.position, (radius + way) * (1.0 + 1e-12))
    }

    /// Shape at the stored instant `time`: a displaced plane for a plane that does not rotate, otherwise this moving
    /// shape.
    fn geometry(&self) -> WallGeometry {
        match self.shape.plane().filter(|_| self.keeps_directions()) {
            Some(plane) => {
                let point = plane.point + self.motion.displacement(self.time);
                WallGeometry::Plane(Plane { point, ..*plane })
            }
            None => WallGeometry::Moving(Arc::new(self.clone())),
        }
    }

    /// Point of the shape nearest to `point` [m], at the time `ahead` [s] after the stored instant `time`. `find`
    /// returns the nearest point for the shape without displacement.
    fn seen(
        &self,
        point: &Vector3<f64>,
        ahead: f64,
        find: impl Fn(&WallGeometry, &Vector3<f64>) -> Nearest,
    ) -> Nearest {
        let time = self.time + ahead;
        let nearest = find(&self.shape, &self.motion.to_shape(point, time));
        Nearest { normal: self.motion.direction(&nearest.normal, time), ..nearest }
    }

    /// First touch as [`Geometry::first_touch`] defines it, for a flight that begins `ahead` [s] after the stored
    /// instant `time`; `None` without a touch until `until` [s].
    fn touch(&self, which: u32, flight: &Flight, radius: f64, (ahead, until): (f64, f64)) -> Option<Touch> {
        let start = self.time + ahead;
        match &self.motion {
            PrescribedMotion::Translation { .. } | PrescribedMotion::Servo(_) => {
                self.shape.first_touch(which, &self.motion.seen(flight, start), radius, until)
            }
            PrescribedMotion::Path(path) => self.touch_on(path, which, (flight, start), radius, until),
            PrescribedMotion::Vibration { amplitude, frequency, .. } => match self.shape.plane() {
                Some(plane) => {
                    let here = self.motion.to_shape(&flight.position, start);
                    let gap = VibratingGap {
                        gap: plane.nearest(&here).distance - radius,
                        speed: flight.velocity.dot(&plane.normal),
                        acceleration: flight.gravity.dot(&plane.normal),
                        amplitude: amplitude.dot(&plane.normal),
                        frequency: TAU * frequency,
                        phase: self.motion.angle(start),
                    };
                    let speeds = flight.velocity.norm() + self.largest_speed();
                    gap.first_touch(until, 4.0 * f64::EPSILON * speeds).map(Touch::at)
                }
                None => arcs::first_touch(self, which, (flight, start), radius, until),
            },
            PrescribedMotion::Turning(_) => arcs::first_touch(self, which, (flight, start), radius, until),
        }
    }

    /// First touch for a shape on a path, as [`Geometry::first_touch`] defines it. The shape has a constant velocity
    /// between two knots (given instants of the path). `None` without a touch.
    fn touch_on(
        &self,
        path: &PiecewisePath,
        which: u32,
        (flight, start): (&Flight, f64),
        radius: f64,
        until: f64,
    ) -> Option<Touch> {
        // after the first turn of the loop, `time` is exactly the time of a knot, which `start + t` may miss by
        // rounding
        let (mut t, mut time) = (0.0, start);
        loop {
            let knot = path.next_knot(time);
            let end = (knot - start).max(t).min(until);
            let seen = self.motion.seen(&flight.from(t), time);
            if let Some(touch) = self.shape.first_touch(which, &seen, radius, end - t) {
                return Some(Touch { time: t + touch.time, ..touch });
            }
            if end >= until {
                return None;
            }
            (t, time) = (end, knot);
        }
    }
}

/// The corners [m] of a box given by its lowest and highest corner.
fn corners([low, high]: [Vector3<f64>; 2]) -> [Vector3<f64>; 8] {
    std::array::from_fn(|k| Vector3::from_fn(|axis, _| if k >> axis & 1 == 1 { high[axis] } else { low[axis] }))
}

impl MovingShape {
    /// [m] lowest and highest corner of a box around the moved shape, from those of a box around the shape without
    /// displacement.
    fn moved(&self, around: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
        let corners = corners(around).map(|corner| self.motion.to_scene(&corner, self.time));
        let first = corners[0];
        corners.iter().fold([first; 2], |[low, high], corner| [low.inf(corner), high.sup(corner)])
    }

    /// True if the motion is a translation, so that normals do not turn.
    fn keeps_directions(&self) -> bool {
        self.motion.spin().is_none()
    }
}

impl Geometry for MovingShape {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        self.seen(point, 0.0, |shape, point| shape.nearest(point))
    }

    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        self.touch(0, flight, radius, (0.0, until)).map(|touch| touch.time)
    }

    fn contacts(&self) -> u32 {
        self.shape.contacts()
    }

    fn contact(&self, which: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        self.seen(point, 0.0, |shape, point| shape.contact(which, point, radius))
    }

    fn is_flat_at(&self, which: u32) -> bool {
        self.keeps_directions() && self.shape.is_flat_at(which)
    }

    fn seam(&self) -> f64 {
        self.shape.seam()
    }

    fn first_touch(&self, which: u32, flight: &Flight, radius: f64, until: f64) -> Option<Touch> {
        self.touch(which, flight, radius, (0.0, until))
    }

    fn struck(&self, which: u32, feature: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        self.seen(point, 0.0, |shape, point| shape.struck(which, feature, point, radius))
    }

    fn may_touch(&self, which: u32, point: &Vector3<f64>, radius: f64, skin: f64) -> bool {
        self.shape.may_touch(which, &self.motion.to_shape(point, self.time), radius, skin)
    }

    fn is_thin(&self) -> bool {
        self.shape.law().is_thin()
    }

    fn is_within(&self, point: &Vector3<f64>, distance: f64) -> bool {
        self.shape.is_within(&self.motion.to_shape(point, self.time), distance)
    }

    fn is_clear(&self, point: &Vector3<f64>, distance: f64) -> bool {
        self.shape.law().is_clear(&self.motion.to_shape(point, self.time), distance)
    }

    fn is_nearest_first(&self) -> bool {
        self.shape.law().is_nearest_first()
    }

    fn slides(&self, velocity: &Vector3<f64>) -> bool {
        self.keeps_directions() && self.shape.law().slides(velocity)
    }

    fn bounds(&self) -> Option<[Vector3<f64>; 2]> {
        self.shape.law().bounds().map(|around| self.moved(around))
    }

    fn extent(&self) -> Option<[Vector3<f64>; 2]> {
        self.shape.law().extent().map(|around| self.moved(around))
    }

    fn room_corners(&self) -> Option<[Vector3<f64>; 2]> {
        self.shape.law().room_corners().map(|around| self.moved(around))
    }

    fn holds_along(&self, axis: usize) -> bool {
        self.shape.law().holds_along(axis)
    }

    fn vessel_volume(&self, size: &Vector3<f64>) -> Option<f64> {
        self.shape.law().vessel_volume(size)
    }

    fn has_inside(&self) -> bool {
        self.shape.law().has_inside()
    }

    fn encloses(&self, point: &Vector3<f64>) -> bool {
        self.shape.law().encloses(&self.motion.to_shape(point, self.time))
    }

    fn in_words(&self) -> String {
        self.shape.law().in_words()
    }

    fn drawing(&self, size: &Vector3<f64>) -> Drawing {
        let (points, triangles) = self.shape.law().drawing(size);
        (points.iter().map(|point| self.motion.to_scene(point, self.time)).collect(), triangles)
    }
}

impl Wall {
    /// Returns the wall with a shape that moves by the law `motion`, at time 0. `None` if a shape without an
    /// [`extent`](Geometry::extent), such as a plane, would rotate.
    pub fn moving(self, motion: PrescribedMotion) -> Option<Self> {
        let moving = MovingShape::new(self.geometry.clone(), motion)?;
        Some(Self { geometry: moving.geometry(), moving: Some(moving), ..self })
    }

    /// Moves the wall to its place at the simulated time `time` [s]. A wall without motion does not change.
    pub fn move_to(&mut self, time: f64) {
        if let Some(moving) = &mut self.moving {
            moving.time = time;
            self.geometry = moving.geometry();
        }
    }

    /// Returns the wall with images of its body across the periodic sides of the domain.
    pub(super) fn repeated(&self, domain: &Domain) -> Self {
        let Some(moving) = &self.moving else {
            return Self { geometry: Repeated::of(self.geometry.clone(), domain), ..self.clone() };
        };
        let shape = Arc::new(Repeated::of(moving.shape().clone(), domain));
        let moving = MovingShape { shape, ..moving.clone() };
        Self { geometry: moving.geometry(), moving: Some(moving), ..self.clone() }
    }

    /// Servo motion of the wall, by which particles press on it with a given pressure; `None` for other walls.
    pub fn servo(&self) -> Option<&ServoMotion> {
        match self.moving.as_ref()?.motion() {
            PrescribedMotion::Servo(servo) => Some(servo),
            _ => None,
        }
    }

    /// Mutable access to the servo motion of the wall; `None` for other walls.
    pub fn servo_mut(&mut self) -> Option<&mut ServoMotion> {
        match &mut self.moving.as_mut()?.motion {
            PrescribedMotion::Servo(servo) => Some(servo),
            _ => None,
        }
    }

    /// [m/s] upper limit of the speed of any point of the wall's shape; 0 if the shape does not move.
    pub fn largest_speed(&self) -> f64 {
        self.moving.as_ref().map_or(0.0, MovingShape::largest_speed)
    }

    /// [m] upper limit of the distance by which a point of the shape moves within `duration` [s]; 0 if the shape does
    /// not move.
    pub fn travel(&self, duration: f64) -> f64 {
        self.moving.as_ref().map_or(0.0, |moving| moving.travel(duration))
    }

    /// Nearest point of the wall in contact number `which` of a sphere with the centre `point` [m] and the radius
    /// `radius` [m]. The wall is at its place `ahead` [s] after the instant of its scene.
    #[inline(always)]
    pub fn contact(&self, which: u32, point: &Vector3<f64>, radius: f64, ahead: f64) -> Nearest {
        match &self.moving {
            None => self.geometry.contact(which, point, radius),
            Some(moving) => moving.seen(point, ahead, |shape, point| shape.contact(which, point, radius)),
        }
    }

    /// Nearest point at the instant of a touch, as [`Geometry::struck`] defines it. The wall is at its place `ahead`
    /// [s] after the instant of its scene. `touch` contains the number of the contact and that of the surface feature.
    #[inline(always)]
    pub fn struck(&self, touch: [u32; 2], point: &Vector3<f64>, radius: f64, ahead: f64) -> Nearest {
        let [which, feature] = touch;
        match &self.moving {
            None => self.geometry.struck(which, feature, point, radius),
            Some(moving) => moving.seen(point, ahead, |shape, point| shape.struck(which, feature, point, radius)),
        }
    }

    /// First touch as [`Geometry::first_touch`] defines it. The flight begins `ahead` [s] after the instant of the
    /// wall's scene, and lasts for `until` [s]. `None` without a touch in this time.
    #[inline(always)]
    pub fn first_touch(&self, which: u32, flight: &Flight, radius: f64, (ahead, until): (f64, f64)) -> Option<Touch> {
        match &self.moving {
            None => self.geometry.first_touch(which, flight, radius, until),
            Some(moving) => moving.touch(which, flight, radius, (ahead, until)),
        }
    }

    /// True if the centre of a sphere crosses a thin surface on the straight line from `from` to `to` [m]. It is at
    /// these positions at the times `ahead` [s] after the instant of the wall's scene.
    pub fn is_passed(&self, [from, to]: [&Vector3<f64>; 2], radius: f64, ahead: [f64; 2]) -> bool {
        match &self.moving {
            None => self.geometry.is_passed(from, to, radius),
            Some(moving) => {
                let [from, to] = [(from, ahead[0]), (to, ahead[1])]
                    .map(|(point, ahead)| moving.motion.to_shape(point, moving.time + ahead));
                moving.shape.is_passed(&from, &to, radius)
            }
        }
    }
}
