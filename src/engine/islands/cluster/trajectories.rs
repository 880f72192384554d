//! Trajectories of particles that fly straight between velocity changes, in a part of a window (the time between two
//! exchanges of momentum with the gas).

use crate::engine::islands::search::BoundingSphere;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A change of a particle's velocity, which ends one straight flight and begins another.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct VelocityChange {
    /// Time of the change [s] since the start of the part of the time window.
    pub time: f64,
    /// Position [m] on the straight line of the new flight, extended backwards to the start of the part of the time
    /// window.
    pub origin: Vector3<f64>,
    /// New velocity [m/s], relative to the moving frame in which speeds are measured.
    pub velocity: Vector3<f64>,
}

/// Trajectory of a particle through a part of a time window.
#[derive(Clone, Copy)]
pub struct ParticleTrajectory<'a> {
    /// Index of the particle in the particle store.
    pub place: u32,
    /// Velocity changes in the order of time. With `None` the changes are unknown, and the particle may be anywhere in
    /// the ball of its island member.
    pub turns: Option<&'a [VelocityChange]>,
}

/// Trajectory of a member of a solved island, and bounds on its extent.
#[derive(Clone)]
pub struct PiecewiseTrajectory {
    /// Range of the velocity changes in the list that is stored with the trajectory, in the order of time.
    pub turns: Range<usize>,
    /// The ball that contains the trajectory after the first velocity change.
    pub ball: BoundingSphere,
    /// Distance [m] from the middle of the straight flight within which the whole trajectory lies.
    pub around: f64,
}

/// A straight piece of a trajectory between two successive velocity changes.
pub struct Segment {
    /// Times [s] of the beginning and the end of the piece, since the start of the part of the time window.
    pub span: [f64; 2],
    /// Position [m] on the straight line of this piece, extended backwards to the start of the part of the time window.
    pub origin: Vector3<f64>,
    /// Velocity [m/s] on this piece, relative to the moving frame of the search.
    pub velocity: Vector3<f64>,
}

/// Trajectories of the members of several islands, with their velocity changes.
#[derive(Default)]
pub struct MemberTrajectories {
    /// Trajectory of each member.
    pub ways: Vec<PiecewiseTrajectory>,
    /// Velocity changes of these trajectories.
    pub turns: Vec<VelocityChange>,
}
