//! Two ways to find the particles that may meet within a part of a window: by bounds on where hot particles may get
//! ([`BoundedIslands`](super::BoundedIslands)), or by the trajectories of islands that are solved
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
    /// True if islands may be crowds.
    pub crowds: bool,
    /// Number of members beyond which an island that is no crowd is too large.
    pub most: usize,
}

/// Way to find the particles that may meet within a part of a window.
pub trait IslandFinder<'a>: DerefMut<Target = Clusters<'a>> + Sync + Sized {
    /// Costs of islands that are found in this way.
    const COSTS: PartCosts;

    /// True if a part that had to be shortened limits the further parts of the window.
    const KEEPS_SHORTER: bool;

    /// A finder without islands so far.
    fn new(clusters: Clusters<'a>, limits: IslandLimits) -> Self;

    /// The islands that were found.
    fn into_clusters(self) -> Clusters<'a>;

    /// Makes islands of all touches and of the carried state, whose energies [J] are given. Returns false if one grows
    /// too large.
    fn gather(&mut self, touches: &[FirstTouch], carried: &[[Option<u32>; 2]], energy: Vec<f64>) -> bool;

    /// Lists the pairs that may touch of a member, given with its local index, and the particles after it. All are given
    /// by index in the store, with the number of hot ones.
    fn list_pairs(&self, member: (usize, &Member), island: (&[u32], usize), pairs: &mut Vec<Pair>);

    /// Room for the trajectories of `members` particles.
    fn trajectories(_members: usize) -> MemberTrajectories {
        MemberTrajectories::default()
    }

    /// Takes the trajectories out of an island that has been solved.
    fn trace<C>(&self, _island: &mut Island<C>, _trajectories: &mut MemberTrajectories) {}

    /// Stores the trajectories of the members of an island, given by their range in a list.
    fn follow(&mut self, _which: usize, _ways: Range<usize>, _trajectories: &MemberTrajectories) {}

    /// Changes the islands that are to be solved again after a round, and unites those that may meet. Returns the number
    /// of islands solved in vain, among those whose leading particle is chosen by `mine`. Returns `None` if an island
    /// grows too large.
    fn next_round(&mut self, retries: Vec<(usize, Retry)>, mine: impl Fn(u32) -> bool) -> Option<u64>;

    /// Velocity changes of a member, if they are known.
    fn velocity_changes(&self, _member: &Member) -> Option<&[VelocityChange]> {
        None
    }

    /// True if a member may touch a particle of another island that has these velocity changes, given by index in the
    /// store.
    fn may_meet(&self, _member: &Member, _place: u32, _turns: Option<&[VelocityChange]>) -> bool {
        true
    }

    /// Members that are in no cells; [`for_each_beside`](Self::for_each_beside) leaves them out.
    fn late(&self) -> &[Member] {
        &[]
    }

    /// Calls `visit` with members near a ball: all that may reach it, and a few more. No member reaches farther than
    /// `widest` [m].
    fn for_each_beside(&self, ball: &BoundingSphere, widest: f64, visit: &mut dyn FnMut(&Member));
}
