//! Frame of reference of the calendar (the event queue of all particles). The frame falls with gravity, so flights are
//! straight in it. When the calendar is built, the frame moves with the mean velocity of the particles along the walls.
//! If the particles fly together as a layer, the frame moves with their whole mean velocity. The epoch is the instant
//! from which times are counted.

use crate::walls::Flight;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Falling frame, in which flights are straight. Positions relative to the scene are x = x' + offset + u t + g t²/2,
/// and velocities are v = v' + u + g t. Here x' and v' are the values in the frame, and u is the velocity of the frame
/// at the epoch (zero of the event queue's time). Gravity is g, and t is the time since the epoch.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct FallingFrame {
    /// [m] position of the frame's origin at the epoch (zero of time), relative to the origin of the scene.
    pub offset: Vector3<f64>,
    /// [m/s] velocity u of the frame at the epoch (zero of time), relative to the scene.
    pub velocity: Vector3<f64>,
    /// [m/s²] gravity g, the acceleration of the frame.
    pub gravity: Vector3<f64>,
}

impl FallingFrame {
    /// Position [m] of the frame's origin, relative to the origin of the scene, at `time` [s] since the epoch (zero of
    /// the event queue's time).
    fn origin(&self, time: f64) -> Vector3<f64> {
        self.offset + (self.velocity + self.gravity * (0.5 * time)) * time
    }

    /// Velocity [m/s] of the frame relative to the scene at `time` [s] since the epoch (zero of the event queue's
    /// time).
    pub fn velocity_at(&self, time: f64) -> Vector3<f64> {
        self.velocity + self.gravity * time
    }

    /// Flight of a body relative to the scene, from `time` [s] since the epoch (zero of the event queue's time) on. At
    /// that time the body has `position` [m] and `velocity` [m/s] in this frame.
    pub fn flight(&self, position: &Vector3<f64>, velocity: &Vector3<f64>, time: f64) -> Flight {
        Flight {
            position: position + self.origin(time),
            velocity: velocity + self.velocity_at(time),
            gravity: self.gravity,
        }
    }

    /// Returns this frame with a new zero of time (epoch), which is `time` [s] after the old one.
    pub fn from(&self, time: f64) -> Self {
        Self { offset: self.origin(time), velocity: self.velocity_at(time), gravity: self.gravity }
    }
}
