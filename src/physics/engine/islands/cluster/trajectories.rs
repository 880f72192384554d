//! Trajectories of particles that fly straight between velocity changes, in a part (a piece of the time between two
//! exchanges with the gas).

use crate::engine::islands::search::BoundingSphere;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A change of a particle's velocity, which ends one straight flight and begins another.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct VelocityChange {
    /// [s] time of the change since the start of the part, a piece of the time between two exchanges with the gas.
    pub time: f64,
    /// [m] position that the particle would have had at the start of the part (interval of time) if it had always moved
    /// on the line of the new flight.
    pub origin: Vector3<f64>,
    /// [m/s] new velocity, relative to the moving frame in which the speed of this particle is limited; in a sheared
    /// box that frame contains the mean flow.
    pub velocity: Vector3<f64>,
}

/// Trajectory of a particle through a part, a piece of the time between two exchanges with the gas.
#[derive(Clone, Copy)]
pub struct ParticleTrajectory<'a> {
    /// Index of the particle in the particle store.
    pub index: u32,
    /// Velocity changes in the order of time; an empty list means a straight flight. With `None` the changes are
    /// unknown, and the particle may be anywhere in the ball that was estimated for it.
    pub turns: Option<&'a [VelocityChange]>,
}

/// Trajectory of a member of a solved island (group of particles that may meet), with balls that contain the
/// trajectory.
#[derive(Clone)]
pub struct PiecewiseTrajectory {
    /// Range of the particle's velocity changes in `MemberTrajectories::turns`, in the order of time.
    pub turns: Range<usize>,
    /// Ball that contains the path after the first velocity change; without a change, the straight flight.
    pub ball: BoundingSphere,
    /// [m] radius of a ball about the middle of the straight flight that contains the whole trajectory.
    pub around: f64,
}

/// A straight piece of a trajectory between two successive velocity changes.
pub struct Segment {
    /// [s] times of the beginning and the end of the piece since the start of the part (interval of time).
    pub span: [f64; 2],
    /// [m] position that the particle would have had at the start of the part (interval of time) if it had always moved
    /// on the line of this piece.
    pub origin: Vector3<f64>,
    /// [m/s] velocity on this piece, relative to the moving frame of the search, which is common to all particles.
    pub velocity: Vector3<f64>,
}

/// Trajectories of the members of several islands (groups of particles that may meet) that one thread has solved.
#[derive(Default)]
pub struct MemberTrajectories {
    /// Trajectory of each member, for one island (group of particles that may meet) after another.
    pub ways: Vec<PiecewiseTrajectory>,
    /// Velocity changes of all trajectories in `ways`. Those of one member follow one another.
    pub turns: Vec<VelocityChange>,
}
