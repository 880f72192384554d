//! Frame of reference of the calendar: it moves with the mean velocity of the particles along the walls, and falls.

use crate::walls::Flight;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Falling frame: x = x' + offset + u t + g t²/2, v = v' + u + g t, with t since the epoch. Flights are straight in it.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct FallingFrame {
    /// Position of the origin [m] at the epoch.
    pub offset: Vector3<f64>,
    /// Velocity u [m/s] of the frame at the epoch.
    pub velocity: Vector3<f64>,
    /// Gravity g [m/s²].
    pub gravity: Vector3<f64>,
}

impl FallingFrame {
    /// Position of the origin [m] after `time` [s].
    fn origin(&self, time: f64) -> Vector3<f64> {
        self.offset + (self.velocity + self.gravity * (0.5 * time)) * time
    }

    /// Velocity of the frame [m/s] after `time` [s].
    pub fn velocity_at(&self, time: f64) -> Vector3<f64> {
        self.velocity + self.gravity * time
    }

    /// Flight, seen from the scene, of a body at `position` [m] with `velocity` [m/s] in this frame after `time` [s].
    pub fn flight(&self, position: &Vector3<f64>, velocity: &Vector3<f64>, time: f64) -> Flight {
        Flight {
            position: position + self.origin(time),
            velocity: velocity + self.velocity_at(time),
            gravity: self.gravity,
        }
    }

    /// This frame with times counted from `time` [s] on.
    pub fn from(&self, time: f64) -> Self {
        Self { offset: self.origin(time), velocity: self.velocity_at(time), gravity: self.gravity }
    }
}
