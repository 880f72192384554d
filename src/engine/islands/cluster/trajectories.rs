//! MemberTrajectories of particles that fly straight between velocity changes.

use crate::engine::islands::search::BoundingSphere;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A velocity change that ends a straight piece of flight.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct VelocityChange {
    /// Time of the change [s] since the start of the part.
    pub time: f64,
    /// Position [m] at the start of the part, extrapolated back along the new flight.
    pub origin: Vector3<f64>,
    /// New velocity [m/s], relative to the frame of the search.
    pub velocity: Vector3<f64>,
}

/// Trajectory of a particle through the part.
#[derive(Clone, Copy)]
pub struct ParticleTrajectory<'a> {
    /// Index of the particle in the store.
    pub place: u32,
    /// Velocity changes in the order of time; `None` if they are unknown and the particle may be anywhere in its ball.
    pub turns: Option<&'a [VelocityChange]>,
}

/// Trajectory of a hot particle as it was solved.
#[derive(Clone)]
pub struct PiecewiseTrajectory {
    /// Range of the velocity changes, in the list that came with the trajectory, in the order of time.
    pub turns: Range<usize>,
    /// The ball that holds the trajectory from the first velocity change on.
    pub ball: BoundingSphere,
    /// Reach [m] about the middle of the straight flight that holds the whole trajectory.
    pub around: f64,
}

/// A straight piece of a trajectory.
pub struct Segment {
    /// Beginning and end [s].
    pub span: [f64; 2],
    /// Position [m] at the start of the part, extrapolated along this piece.
    pub origin: Vector3<f64>,
    /// Velocity [m/s] relative to the frame of the search.
    pub velocity: Vector3<f64>,
}

/// MemberTrajectories of hot particles, with their velocity changes.
#[derive(Default)]
pub struct MemberTrajectories {
    /// The trajectories.
    pub ways: Vec<PiecewiseTrajectory>,
    /// Velocity changes of those trajectories.
    pub turns: Vec<VelocityChange>,
}
