//! Frame of reference of the calendar (the event queue of all particles). The frame falls with gravity. At the epoch,
//! the instant from which times are counted, it moves with the mean velocity of the particles along the walls.

use crate::walls::Flight;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Falling frame, in which flights are straight. Positions are x = x' + offset + u t + g t²/2, and velocities are v =
/// v' + u + g t. Primes denote values in the frame, and t is the time since the epoch (zero of the calendar's time).
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct FallingFrame {
    /// Position of the frame's origin [m] at the epoch (zero of the calendar's time).
    pub offset: Vector3<f64>,
    /// Velocity u [m/s] of the frame at the epoch (zero of the calendar's time).
    pub velocity: Vector3<f64>,
    /// Gravity g [m/s²], with which the frame falls.
    pub gravity: Vector3<f64>,
}

impl FallingFrame {
    /// Position of the frame's origin [m] at `time` [s] since the epoch (zero of the calendar's time).
    fn origin(&self, time: f64) -> Vector3<f64> {
        self.offset + (self.velocity + self.gravity * (0.5 * time)) * time
    }

    /// Velocity of the frame [m/s] at `time` [s] since the epoch (zero of the calendar's time).
    pub fn velocity_at(&self, time: f64) -> Vector3<f64> {
        self.velocity + self.gravity * time
    }

    /// Flight, relative to the scene, of a body with `position` [m] and `velocity` [m/s] in this frame at `time` [s]
    /// since the epoch (zero of the calendar's time).
    pub fn flight(&self, position: &Vector3<f64>, velocity: &Vector3<f64>, time: f64) -> Flight {
        Flight {
            position: position + self.origin(time),
            velocity: velocity + self.velocity_at(time),
            gravity: self.gravity,
        }
    }

    /// This frame described from a new epoch, which is `time` [s] after the old one.
    pub fn from(&self, time: f64) -> Self {
        Self { offset: self.origin(time), velocity: self.velocity_at(time), gravity: self.gravity }
    }
}
