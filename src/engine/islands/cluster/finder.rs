//! Common interface of the two ways to find the particles that may meet within a part of a window (the time between two
//! exchanges with the gas). One way uses bounds on the positions that hot particles may reach
//! ([`BoundedIslands`](super::BoundedIslands)). The other uses the trajectories of solved islands
//! ([`TracedIslands`](super::TracedIslands)).

use super::trajectories::{MemberTrajectories, VelocityChange};
use super::{Clusters, Member};
use crate::engine::islands::batch::Retry;
use crate::engine::islands::choice::PartCosts;
use crate::engine::islands::island::Island;
use crate::engine::islands::search::{BoundingSphere, FirstTouch};
use crate::neighbours::Pair;
use std::ops::{DerefMut, Range};

/// Limits of the size of islands.
#[derive(Clone, Copy)]
pub struct IslandLimits {
    /// True if islands may be crowds, which are large islands moved by uniform steps.
    pub crowds: bool,
    /// Largest number of members of an island that is not a crowd (large island moved by uniform steps).
    pub most: usize,
}

/// Way to find the particles that may meet within a part of a time window.
pub trait IslandFinder<'a>: DerefMut<Target = Clusters<'a>> + Sync + Sized {
    /// Costs of islands that are found in this way.
    const COSTS: PartCosts;

    /// True if, after a part had to be shortened, all later parts of the time window are at most as long.
    const KEEPS_SHORTER: bool;

    /// Makes a finder without islands.
    fn new(clusters: Clusters<'a>, limits: IslandLimits) -> Self;

    /// Returns the islands found so far.
    fn into_clusters(self) -> Clusters<'a>;

    /// Makes islands from all touches and from the carried state (such as contacts), whose energies [J] are given.
    /// Returns false if an island is too large.
    fn gather(&mut self, touches: &[FirstTouch], carried: &[[Option<u32>; 2]], energy: Vec<f64>) -> bool;

    /// Appends the pairs of one member and those later particles of its island that it may touch. `member` is the
    /// member with its local index. `island` contains the indices in the particle store of all particles of the island,
    /// and the number of hot ones.
    fn list_pairs(&self, member: (usize, &Member), island: (&[u32], usize), pairs: &mut Vec<Pair>);

    /// Reserves memory for the trajectories of `members` particles.
    fn trajectories(_members: usize) -> MemberTrajectories {
        MemberTrajectories::default()
    }

    /// Moves the trajectories of a solved island to `_trajectories`; does nothing if trajectories are not used.
    fn trace<C>(&self, _island: &mut Island<C>, _trajectories: &mut MemberTrajectories) {}

    /// Stores the trajectories of the members of the island `_which`, which are the range `_ways` of those in
    /// `_trajectories`. Does nothing if trajectories are not used.
    fn follow(&mut self, _which: usize, _ways: Range<usize>, _trajectories: &MemberTrajectories) {}

    /// Changes the islands that must be solved again, and unites islands that may meet. Returns the number of solved
    /// islands whose results became invalid because these islands met others. An island is counted if its leader
    /// (member with the smallest id) satisfies `mine`. Returns `None` if an island is too large.
    fn next_round(&mut self, retries: Vec<(usize, Retry)>, mine: impl Fn(u32) -> bool) -> Option<u64>;

    /// Velocity changes of a member; `None` if no trajectory is stored for it.
    fn velocity_changes(&self, _member: &Member) -> Option<&[VelocityChange]> {
        None
    }

    /// True if a member may touch a particle of another island. `_place` is the index of that particle in the particle
    /// store, and `_turns` are its velocity changes.
    fn may_meet(&self, _member: &Member, _place: u32, _turns: Option<&[VelocityChange]>) -> bool {
        true
    }

    /// Members that are not yet sorted into cells, and that [`for_each_beside`](Self::for_each_beside) skips.
    fn late(&self) -> &[Member] {
        &[]
    }

    /// Calls `visit` with all members that may reach a ball, and with a few others. No member reaches farther than
    /// `widest` [m] from the middle of its flight.
    fn for_each_beside(&self, ball: &BoundingSphere, widest: f64, visit: &mut dyn FnMut(&Member));
}
