//! Laws by which the shape of a wall moves: exact functions of time. Only a servo wall has a state, which changes
//! between two windows (times between two exchanges with the gas).

use super::path::PiecewisePath;
use super::servo::ServoMotion;
use crate::walls::{Flight, Turning};
use nalgebra::{Rotation3, Unit, Vector3};
use serde::Serialize;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Prescribed motion of the shape of a wall. The shape is at the place that its case (input file) gives, displaced by
/// d(t) or turned about an axis. All kinds but [`Turning`](Self::Turning) are translations without rotation. For
/// [`Servo`](Self::Servo) the case prescribes a pressure, and d(t) is known until the end of the present window only.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PrescribedMotion {
    /// Constant velocity V: the displacement is d(t) = V t.
    Translation {
        /// [m/s] constant velocity V of the shape.
        velocity: Vector3<f64>,
    },
    /// Harmonic vibration: the displacement is d(t) = A sin(2π f t + φ), with the amplitude A, frequency f and phase φ.
    Vibration {
        /// [m] amplitude A, along the direction of the vibration.
        amplitude: Vector3<f64>,
        /// [Hz] frequency f of the vibration.
        frequency: f64,
        /// [rad] phase φ at time 0.
        phase: f64,
    },
    /// Displacement that is linear in time between given instants, the knots.
    Path(Arc<PiecewisePath>),
    /// Rotation about an axis at a constant angular velocity. At time 0 the shape is where its case puts it.
    Turning(Turning),
    /// Motion of a plane along its normal, so that particles press on it with a given pressure.
    Servo(ServoMotion),
}

impl PrescribedMotion {
    /// [m] displacement d of the shape at `time` [s]; zero for a rotation.
    pub fn displacement(&self, time: f64) -> Vector3<f64> {
        match self {
            Self::Translation { velocity } => velocity * time,
            Self::Vibration { amplitude, .. } => amplitude * self.angle(time).sin(),
            Self::Path(path) => path.displacement(time),
            Self::Turning(_) => Vector3::zeros(),
            Self::Servo(servo) => servo.direction * servo.displacement(time),
        }
    }

    /// [m/s] velocity, at `time` [s], of the material point of the shape that is then at `point` [m]. At a knot (given
    /// instant) of a path it is the velocity after the knot.
    pub fn velocity(&self, point: &Vector3<f64>, time: f64) -> Vector3<f64> {
        match self {
            Self::Translation { velocity } => *velocity,
            Self::Vibration { amplitude, frequency, .. } => amplitude * (TAU * frequency * self.angle(time).cos()),
            Self::Path(path) => path.velocity(time),
            Self::Turning(turning) => turning.spin.cross(&(point - turning.center)),
            Self::Servo(servo) => servo.direction * servo.state.speed,
        }
    }

    /// [m/s²] rate at which the [`velocity`](Self::velocity) at one place changes at `time` [s]. It is zero for all
    /// motions except a vibration; the jumps of the velocity at the knots of a path are left out.
    pub fn acceleration(&self, time: f64) -> Vector3<f64> {
        match self {
            Self::Translation { .. } | Self::Path(_) | Self::Turning(_) | Self::Servo(_) => Vector3::zeros(),
            Self::Vibration { amplitude, frequency, .. } => {
                amplitude * (-(TAU * frequency).powi(2) * self.angle(time).sin())
            }
        }
    }

    /// [rad/s] angular velocity of the shape; `None` for a translation.
    pub fn spin(&self) -> Option<Vector3<f64>> {
        match self {
            Self::Translation { .. } | Self::Vibration { .. } | Self::Path(_) | Self::Servo(_) => None,
            Self::Turning(turning) => Some(turning.spin),
        }
    }

    /// [m] position of `point` [m] at `time` [s] in the frame of the shape. In this frame the shape is always where its
    /// case puts it.
    pub(super) fn to_shape(&self, point: &Vector3<f64>, time: f64) -> Vector3<f64> {
        match self {
            Self::Turning(turning) => rotation(turning, -time) * (point - turning.center) + turning.center,
            _ => point - self.displacement(time),
        }
    }

    /// [m] position in the scene, at `time` [s], of a `point` [m] of the undisplaced shape: the inverse of
    /// [`to_shape`](Self::to_shape).
    pub(super) fn to_scene(&self, point: &Vector3<f64>, time: f64) -> Vector3<f64> {
        match self {
            Self::Turning(turning) => rotation(turning, time) * (point - turning.center) + turning.center,
            _ => point + self.displacement(time),
        }
    }

    /// Turns a vector of the undisplaced shape, such as a normal, into its direction in the scene at `time` [s].
    pub(super) fn direction(&self, vector: &Vector3<f64>, time: f64) -> Vector3<f64> {
        match self {
            Self::Turning(turning) => rotation(turning, time) * vector,
            Self::Translation { .. } | Self::Vibration { .. } | Self::Path(_) | Self::Servo(_) => *vector,
        }
    }

    /// Flight of a sphere's centre seen from the moving shape: the parabola with the position, velocity and
    /// acceleration at `time` [s]. In a frame that rotates at the angular velocity ω, the acceleration is g - 2 ω ×
    /// v + ω × (ω × r). Here g is gravity, v the velocity in the frame at rest, and r the position relative to the
    /// centre of rotation.
    pub(super) fn seen(&self, flight: &Flight, time: f64) -> Flight {
        let velocity = flight.velocity - self.velocity(&flight.position, time);
        let Self::Turning(turning @ Turning { center, spin }) = self else {
            let gravity = flight.gravity - self.acceleration(time);
            return Flight { position: self.to_shape(&flight.position, time), velocity, gravity };
        };
        let from_center = flight.position - center;
        let gravity = flight.gravity - spin.cross(&(flight.velocity * 2.0 - spin.cross(&from_center)));
        let back = rotation(turning, -time);
        Flight { position: back * from_center + center, velocity: back * velocity, gravity: back * gravity }
    }

    /// [m/s³] upper limit of the third derivative y''' of the position in the frame of the shape, for `time` [s] from
    /// the beginning of the flight. For a vibration it is |A| (2π f)³. In a rotating frame, with the symbols of
    /// [`seen`](Self::seen), y''' = -3 ω × g + 3 ω × (ω × v) - ω × (ω × (ω × r)).
    pub(super) fn jerk(&self, flight: &Flight, time: f64) -> f64 {
        match self {
            Self::Translation { .. } | Self::Path(_) | Self::Servo(_) => 0.0,
            Self::Vibration { amplitude, frequency, .. } => amplitude.norm() * (TAU * frequency).powi(3),
            Self::Turning(Turning { center, spin }) => {
                let (rate, gravity) = (spin.norm(), flight.gravity.norm());
                let speed = flight.velocity.norm() + gravity * time;
                let arm = (flight.position - center).norm() + speed * time;
                rate * (3.0 * gravity + rate * (3.0 * speed + rate * arm))
            }
        }
    }

    /// [m/s] largest speed of any point of the shape. `arm` [m] is the largest distance of a point from the axis of a
    /// rotation.
    pub(super) fn largest_speed(&self, arm: f64) -> f64 {
        match self {
            Self::Translation { velocity } => velocity.norm(),
            Self::Vibration { amplitude, frequency, .. } => TAU * frequency * amplitude.norm(),
            Self::Path(path) => path.largest_speed(),
            Self::Turning(turning) => turning.spin.norm() * arm,
            Self::Servo(servo) => servo.largest_speed,
        }
    }

    /// [m] largest distance between two positions of one point of the shape. `arm` [m] is the largest distance of a
    /// point from the axis of a rotation.
    pub(super) fn largest_excursion(&self, arm: f64) -> f64 {
        match self {
            Self::Translation { .. } | Self::Servo(_) => f64::INFINITY,
            Self::Vibration { amplitude, .. } => 2.0 * amplitude.norm(),
            Self::Path(path) => path.largest_excursion(),
            Self::Turning(_) => 2.0 * arm,
        }
    }

    /// [m] least and largest component of the displacement along a unit vector, from time 0 to `duration` [s]. For a
    /// vibration and a path, these are the values over all times. `None` for a rotation and for a servo wall, whose
    /// displacement is not known in advance.
    pub fn range_along(&self, direction: &Vector3<f64>, duration: f64) -> Option<[f64; 2]> {
        let two = |one: f64, other: f64| Some([one.min(other), one.max(other)]);
        match self {
            Self::Translation { velocity } => two(0.0, velocity.dot(direction) * duration),
            Self::Vibration { amplitude, .. } => two(amplitude.dot(direction), -amplitude.dot(direction)),
            Self::Path(path) => Some(path.range_along(direction)),
            Self::Turning(_) | Self::Servo(_) => None,
        }
    }

    /// [rad] phase 2π f t + φ of a vibration at the time t = `time` [s]; 0 for other motions. Whole periods are taken
    /// off f t before the multiplication by 2π.
    pub(super) fn angle(&self, time: f64) -> f64 {
        match self {
            Self::Vibration { frequency, phase, .. } => TAU * (frequency * time).fract() + phase,
            Self::Translation { .. } | Self::Path(_) | Self::Turning(_) | Self::Servo(_) => 0.0,
        }
    }
}

/// Rotation by which a turning shape has turned after `time` [s].
fn rotation(turning: &Turning, time: f64) -> Rotation3<f64> {
    let rate = turning.spin.norm();
    match Unit::try_new(turning.spin, 0.0) {
        Some(axis) => Rotation3::from_axis_angle(&axis, TAU * (rate * time / TAU).fract()),
        None => Rotation3::identity(),
    }
}
