//! A turbulent flow along z through a round pipe.

use super::k_epsilon::ChannelFlow;
use super::table::VelocityTable;
use serde::Serialize;

/// A pipe flow: the velocity depends on the distance from the axis.
#[derive(Clone, Debug, Serialize)]
pub struct Pipe {
    /// [m] x and y of the axis.
    center: [f64; 2],
    /// Velocity as a function of the distance from the wall.
    half: VelocityTable,
    flow: ChannelFlow,
}

impl Pipe {
    /// A solved flow about the axis through x and y of `center` [m].
    ///
    /// # Errors
    ///
    /// None for a solved flow; those of [`VelocityTable::new`] if its profile was altered.
    pub fn new(center: [f64; 2], flow: ChannelFlow) -> Result<Self, String> {
        Ok(Self { center, half: flow.half_table()?, flow })
    }

    /// [m] x and y of the axis.
    pub fn center(&self) -> [f64; 2] {
        self.center
    }

    /// [m] radius.
    pub fn radius(&self) -> f64 {
        0.5 * self.flow.height
    }

    /// [m/s] velocity at x and y [m]; 0 at the wall and outside.
    #[inline]
    pub fn velocity_at(&self, x: f64, y: f64) -> f64 {
        let (x, y) = (x - self.center[0], y - self.center[1]);
        self.half.value(self.radius() - (x * x + y * y).sqrt())
    }

    /// [m/s] velocity at `y` [m] in the plane x = const through the axis.
    #[inline]
    pub fn velocity(&self, y: f64) -> f64 {
        self.half.value(self.radius() - (y - self.center[1]).abs())
    }

    /// [m] y of the lowest and of the highest point of the wall.
    pub fn between(&self) -> [f64; 2] {
        [self.center[1] - self.radius(), self.center[1] + self.radius()]
    }

    /// [m/s] greatest velocity.
    pub fn maximum(&self) -> f64 {
        self.half.maximum()
    }

    /// The solved flow.
    pub fn flow(&self) -> &ChannelFlow {
        &self.flow
    }
}
