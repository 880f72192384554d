//! Velocity profiles of the gas.

use super::k_epsilon::{ChannelFlow, TurbulenceModel};
use super::log_law::LogLaw;
use super::pipe::Pipe;
use super::table::VelocityTable;
use nalgebra::Vector3;
use serde::Serialize;
use std::sync::Arc;

/// Profile of the streamwise gas velocity: u_z(y) in a channel, for y from 0 to its height, or u_z in a pipe.
///
/// A clone shares its tables with the original. The computing time of an evaluation does not depend on the position or
/// the number of points.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Profile {
    /// A velocity [m/s] that is the same at all positions.
    Uniform(f64),
    /// A monotone cubic through given points (y, u).
    Tabulated(Arc<VelocityTable>),
    /// A channel flow computed by a k-epsilon model.
    Channel(Arc<Channel>),
    /// A channel flow by the logarithmic law of the wall.
    LogLaw(LogLaw),
    /// A turbulent pipe flow along z, computed by a k-epsilon model.
    Pipe(Arc<Pipe>),
}

/// Velocity and length in which flows along smooth walls are measured (wall units).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WallScale {
    /// [m/s] friction velocity u_τ = sqrt(τ_w/ρ) of the flow, with the shear stress τ_w at the wall and the density ρ
    /// of the gas.
    pub friction_velocity: f64,
    /// [m] viscous length ν/u_τ.
    pub length: f64,
}

/// A channel flow; the profile in its lower half is mirrored at the centre plane.
#[derive(Clone, Debug, Serialize)]
pub struct Channel {
    half: VelocityTable,
    flow: ChannelFlow,
}

impl Profile {
    /// Makes a profile as a monotone cubic through points (y [m], u [m/s]) in ascending order of y. Outside the points
    /// it is constant.
    ///
    /// # Errors
    ///
    /// Fewer than two points, a value that is not finite, or y that does not strictly increase.
    pub fn table(points: &[(f64, f64)]) -> Result<Self, String> {
        Ok(Self::Tabulated(Arc::new(VelocityTable::new(points)?)))
    }

    /// Makes the fully developed channel flow with the bulk velocity `bulk_velocity` [m/s] between walls at y = 0 and y
    /// = `height` [m], by a k-epsilon model.
    ///
    /// The profile is exactly symmetric. It is zero at both walls and outside the channel. Its mean equals
    /// `bulk_velocity` with a relative error of 1e-10, because the solver adjusts u_τ. With wall functions the profile
    /// contains the law of the wall below the first node.
    ///
    /// # Errors
    ///
    /// Those of [`ChannelFlow::solve`].
    pub fn k_epsilon_channel(
        bulk_velocity: f64,
        height: f64,
        kinematic_viscosity: f64,
        model: TurbulenceModel,
    ) -> Result<Self, String> {
        let flow = ChannelFlow::solve(bulk_velocity, height, kinematic_viscosity, model)?;
        Ok(Self::Channel(Arc::new(Channel { half: flow.half_table()?, flow })))
    }

    /// Makes the fully developed turbulent flow along z, with the bulk velocity `bulk_velocity` [m/s], through a pipe
    /// of `diameter` [m]. The model is that of Launder and Sharma. The axis goes through the coordinates x and y in
    /// `center` [m].
    ///
    /// # Errors
    ///
    /// Those of [`ChannelFlow::solve_pipe`].
    pub fn k_epsilon_pipe(
        bulk_velocity: f64,
        diameter: f64,
        center: [f64; 2],
        kinematic_viscosity: f64,
    ) -> Result<Self, String> {
        let flow = ChannelFlow::solve_pipe(bulk_velocity, diameter, kinematic_viscosity, None)?;
        Ok(Self::Pipe(Arc::new(Pipe::new(center, flow)?)))
    }

    /// Returns this channel or pipe profile with another solution `flow` of its equations. Other profiles do not
    /// change.
    ///
    /// # Errors
    ///
    /// Those of [`VelocityTable::new`]: a velocity that is not finite.
    pub fn with_flow(&self, flow: ChannelFlow) -> Result<Self, String> {
        Ok(match self {
            Self::Channel(_) => Self::Channel(Arc::new(Channel { half: flow.half_table()?, flow })),
            Self::Pipe(pipe) => Self::Pipe(Arc::new(Pipe::new(pipe.center(), flow)?)),
            Self::Uniform(_) | Self::Tabulated(_) | Self::LogLaw(_) => self.clone(),
        })
    }

    /// [m/s] streamwise gas velocity at a position [m].
    #[inline]
    pub fn velocity_at(&self, place: &Vector3<f64>) -> f64 {
        match self {
            Self::Pipe(pipe) => pipe.velocity_at(place.x, place.y),
            Self::Uniform(_) | Self::Tabulated(_) | Self::Channel(_) | Self::LogLaw(_) => self.velocity(place.y),
        }
    }

    /// [m] coordinate on which all quantities of the gas depend, at a position [m], and its gradient [-]. In a pipe, or
    /// a channel of the k-epsilon model, it is the distance from the nearer wall; otherwise it is y.
    #[inline]
    pub fn depth(&self, place: &Vector3<f64>) -> (f64, Vector3<f64>) {
        match self {
            Self::Pipe(pipe) => pipe.depth(place.x, place.y),
            Self::Channel(channel) if place.y > 0.5 * channel.flow.height => {
                (channel.flow.height - place.y, -Vector3::y())
            }
            Self::Uniform(_) | Self::Tabulated(_) | Self::Channel(_) | Self::LogLaw(_) => (place.y, Vector3::y()),
        }
    }

    /// [1/s] vorticity of the gas at a position [m]: the curl of the mean velocity, which is along z.
    pub fn vorticity_at(&self, place: &Vector3<f64>) -> Vector3<f64> {
        let (depth, direction) = self.depth(place);
        let slope = match self {
            Self::Uniform(_) => 0.0,
            Self::Tabulated(table) => table.slope(depth),
            Self::Channel(channel) => channel.half.slope(depth),
            Self::LogLaw(law) => law.slope(depth),
            Self::Pipe(pipe) => pipe.slope(depth),
        };
        (direction * slope).cross(&Vector3::z())
    }

    /// [m] coordinates y of the lower and the upper wall of the gas flow, in a box of `height` [m].
    pub fn between(&self, height: f64) -> [f64; 2] {
        match self {
            Self::Pipe(pipe) => pipe.between(),
            Self::Uniform(_) | Self::Tabulated(_) | Self::Channel(_) | Self::LogLaw(_) => [0.0, height],
        }
    }

    /// [m/s] streamwise gas velocity at the distance `y` [m] from the wall y = 0. Outside the profile it is the value
    /// at the nearer end. For a pipe it is the velocity at the coordinate `y`, on the line along y that crosses the
    /// axis.
    #[inline]
    pub fn velocity(&self, y: f64) -> f64 {
        match self {
            Self::Pipe(pipe) => pipe.velocity(y),
            Self::Uniform(velocity) => *velocity,
            Self::Tabulated(table) => table.value(y),
            Self::Channel(channel) => channel.half.value(y.min(channel.flow.height - y)),
            Self::LogLaw(law) => law.velocity(y),
        }
    }

    /// [m/s] largest streamwise gas velocity of the profile.
    pub fn maximum(&self) -> f64 {
        match self {
            Self::Uniform(velocity) => *velocity,
            Self::Tabulated(table) => table.maximum(),
            Self::Channel(channel) => channel.half.maximum(),
            Self::LogLaw(law) => law.velocity(0.5 * law.height),
            Self::Pipe(pipe) => pipe.maximum(),
        }
    }

    /// Points (y [m], u [m/s]) of the profile at `count` equally spaced y from 0 to `height` [m], both included.
    pub fn sample(&self, height: f64, count: usize) -> Vec<(f64, f64)> {
        let step = height / count.saturating_sub(1).max(1) as f64;
        (0..count).map(|i| i as f64 * step).map(|y| (y, self.velocity(y))).collect()
    }

    /// Solution of the k-epsilon model from which a channel or pipe profile was made; `None` for other profiles.
    pub fn channel_flow(&self) -> Option<&ChannelFlow> {
        match self {
            Self::Uniform(_) | Self::Tabulated(_) | Self::LogLaw(_) => None,
            Self::Channel(channel) => Some(&channel.flow),
            Self::Pipe(pipe) => Some(pipe.flow()),
        }
    }

    /// [m/s] bulk velocity of a channel or pipe flow; `None` for other profiles.
    pub fn bulk_velocity(&self) -> Option<f64> {
        match self {
            Self::Uniform(_) | Self::Tabulated(_) => None,
            Self::Channel(channel) => Some(channel.flow.bulk_velocity),
            Self::LogLaw(law) => Some(law.bulk_velocity),
            Self::Pipe(pipe) => Some(pipe.flow().bulk_velocity),
        }
    }

    /// Friction velocity and viscous length of the flow; `None` for a uniform or a tabulated profile.
    pub fn wall_scale(&self) -> Option<WallScale> {
        let (friction_velocity, viscosity) = match self {
            Self::Uniform(_) | Self::Tabulated(_) => return None,
            Self::Channel(channel) => (channel.flow.friction_velocity, channel.flow.kinematic_viscosity),
            Self::LogLaw(law) => (law.friction_velocity, law.kinematic_viscosity),
            Self::Pipe(pipe) => (pipe.flow().friction_velocity, pipe.flow().kinematic_viscosity),
        };
        Some(WallScale { friction_velocity, length: viscosity / friction_velocity })
    }
}
