//! Common interface of the two ways to find the particles that may meet within a part of a window. One uses bounds on
//! where hot particles may get ([`BoundedIslands`](super::BoundedIslands)). The other uses the trajectories of solved
//! islands ([`TracedIslands`](super::TracedIslands)).

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
    /// True if islands may be crowds, which are moved by uniform steps.
    pub crowds: bool,
    /// Largest number of members of an island that is no crowd.
    pub most: usize,
}

/// Way to find the particles that may meet within a part of a window.
pub trait IslandFinder<'a>: DerefMut<Target = Clusters<'a>> + Sync + Sized {
    /// Costs of islands that are found in this way.
    const COSTS: PartCosts;

    /// True if, after one part had to be shortened, later parts of the window are no longer than it.
    const KEEPS_SHORTER: bool;

    /// Makes a finder without islands.
    fn new(clusters: Clusters<'a>, limits: IslandLimits) -> Self;

    /// Returns the islands that were found.
    fn into_clusters(self) -> Clusters<'a>;

    /// Makes islands from all touches and from the carried state, whose energies [J] are given. Returns false if an
    /// island is too large.
    fn gather(&mut self, touches: &[FirstTouch], carried: &[[Option<u32>; 2]], energy: Vec<f64>) -> bool;

    /// Appends the pairs of one member with later particles of its island that may touch. `member` contains its local
    /// index. `island` contains the indices in the store of all particles, and the number of hot ones.
    fn list_pairs(&self, member: (usize, &Member), island: (&[u32], usize), pairs: &mut Vec<Pair>);

    /// Reserves memory for the trajectories of `members` particles.
    fn trajectories(_members: usize) -> MemberTrajectories {
        MemberTrajectories::default()
    }

    /// Moves the trajectories of a solved island to `_trajectories`.
    fn trace<C>(&self, _island: &mut Island<C>, _trajectories: &mut MemberTrajectories) {}

    /// Stores the trajectories of the members of an island, which are a range of a list.
    fn follow(&mut self, _which: usize, _ways: Range<usize>, _trajectories: &MemberTrajectories) {}

    /// Applies the changes to islands that must be solved again, and unites islands that may meet. Returns the number
    /// of islands that were solved in vain, counting those whose leading particle satisfies `mine`. Returns `None` if
    /// an island is too large.
    fn next_round(&mut self, retries: Vec<(usize, Retry)>, mine: impl Fn(u32) -> bool) -> Option<u64>;

    /// Velocity changes of a member; `None` if they are not known.
    fn velocity_changes(&self, _member: &Member) -> Option<&[VelocityChange]> {
        None
    }

    /// True if a member may touch a particle of another island. The particle is given by its index in the store and its
    /// velocity changes.
    fn may_meet(&self, _member: &Member, _place: u32, _turns: Option<&[VelocityChange]>) -> bool {
        true
    }

    /// Members that are not in cells; [`for_each_beside`](Self::for_each_beside) skips them.
    fn late(&self) -> &[Member] {
        &[]
    }

    /// Calls `visit` with all members that may reach a ball, and with a few others. No member reaches farther than
    /// `widest` [m] from the middle of its flight.
    fn for_each_beside(&self, ball: &BoundingSphere, widest: f64, visit: &mut dyn FnMut(&Member));
}
