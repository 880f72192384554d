//! Turbulent gas flow along z through a round pipe.

use super::k_epsilon::ChannelFlow;
use super::table::VelocityTable;
use nalgebra::Vector3;
use serde::Serialize;

/// A pipe flow along z, whose velocity depends on the distance from the axis.
#[derive(Clone, Debug, Serialize)]
pub struct Pipe {
    /// [m] coordinates x and y of the axis.
    center: [f64; 2],
    /// Velocity [m/s] as a function of the distance from the wall.
    half: VelocityTable,
    flow: ChannelFlow,
}

impl Pipe {
    /// Makes a pipe flow from a solved flow. The axis is parallel to z, through the coordinates x and y in `center`
    /// [m].
    ///
    /// # Errors
    ///
    /// A solved flow gives no error. If its profile was altered, the errors are those of [`VelocityTable::new`].
    pub fn new(center: [f64; 2], flow: ChannelFlow) -> Result<Self, String> {
        Ok(Self { center, half: flow.half_table()?, flow })
    }

    /// [m] coordinates x and y of the axis.
    pub fn center(&self) -> [f64; 2] {
        self.center
    }

    /// [m] radius of the pipe.
    pub fn radius(&self) -> f64 {
        0.5 * self.flow.height
    }

    /// [m/s] gas velocity at the coordinates x and y [m]; 0 at the wall and outside the pipe.
    #[inline]
    pub fn velocity_at(&self, x: f64, y: f64) -> f64 {
        let (x, y) = (x - self.center[0], y - self.center[1]);
        self.half.value(self.radius() - (x * x + y * y).sqrt())
    }

    /// [m] distance from the wall at the coordinates x and y [m], and the gradient [-] of this distance, which points
    /// to the axis. On the axis the gradient is set to zero.
    #[inline]
    pub fn depth(&self, x: f64, y: f64) -> (f64, Vector3<f64>) {
        let from_axis = Vector3::new(x - self.center[0], y - self.center[1], 0.0);
        let distance = from_axis.norm();
        let inwards = if distance > 0.0 { -from_axis / distance } else { Vector3::zeros() };
        (self.radius() - distance, inwards)
    }

    /// [1/s] derivative of the gas velocity with respect to the distance from the wall, at the distance `depth` [m].
    pub fn slope(&self, depth: f64) -> f64 {
        self.half.slope(depth)
    }

    /// [m/s] gas velocity at the coordinate `y` [m], on the line along y that crosses the axis.
    #[inline]
    pub fn velocity(&self, y: f64) -> f64 {
        self.half.value(self.radius() - (y - self.center[1]).abs())
    }

    /// [m] coordinates y of the lowest and of the highest point of the wall.
    pub fn between(&self) -> [f64; 2] {
        [self.center[1] - self.radius(), self.center[1] + self.radius()]
    }

    /// [m/s] largest gas velocity of the profile, on the axis of the pipe.
    pub fn maximum(&self) -> f64 {
        self.half.maximum()
    }

    /// Solved flow from which this pipe flow was made.
    pub fn flow(&self) -> &ChannelFlow {
        &self.flow
    }
}
