//! The frame in which the calendar sees the particles: it moves with their mean velocity along the walls, and falls.

use crate::walls::Flight;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// x = x' + offset + u t + g t²/2, v = v' + u + g t, with t since the epoch: flights are straight in it.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct FallingFrame {
    /// [m] where its origin was at the epoch.
    pub offset: Vector3<f64>,
    /// [m/s] u, its velocity at the epoch.
    pub velocity: Vector3<f64>,
    /// [m/s²] g.
    pub gravity: Vector3<f64>,
}

impl FallingFrame {
    /// [m] where its origin is after `time` [s].
    fn origin(&self, time: f64) -> Vector3<f64> {
        self.offset + (self.velocity + self.gravity * (0.5 * time)) * time
    }

    /// [m/s] its velocity after `time` [s].
    pub fn velocity_at(&self, time: f64) -> Vector3<f64> {
        self.velocity + self.gravity * time
    }

    /// The flight, seen from the scene, of what is at `position` [m] with `velocity` [m/s] in this frame after `time` [s].
    pub fn flight(&self, position: &Vector3<f64>, velocity: &Vector3<f64>, time: f64) -> Flight {
        Flight {
            position: position + self.origin(time),
            velocity: velocity + self.velocity_at(time),
            gravity: self.gravity,
        }
    }

    /// The same frame with its time counted from `time` [s] on.
    pub fn from(&self, time: f64) -> Self {
        Self { offset: self.origin(time), velocity: self.velocity_at(time), gravity: self.gravity }
    }
}
