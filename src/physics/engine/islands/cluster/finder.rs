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

/// Limits of the number of particles in an island (group of particles that may meet).
#[derive(Clone, Copy)]
pub struct IslandLimits {
    /// True if islands may be crowds, which are large islands moved by uniform steps.
    pub crowds: bool,
    /// Largest number of members of an island that is not moved by uniform steps.
    pub most: usize,
}

/// Method that finds the particles that may meet within a part, a piece of the time between two exchanges with the
/// gas. It groups them into islands (groups of particles that may meet), which an engine solves one by one.
pub trait IslandFinder<'a>: DerefMut<Target = Clusters<'a>> + Sync + Sized {
    /// Measured costs of islands (groups of particles that may meet) that are found by this method.
    const COSTS: PartCosts;

    /// True if, after an island was too large and a part (piece of a window) had to be shortened, all later parts of
    /// the window are at most as long as the shortened one.
    const KEEPS_SHORTER: bool;

    /// Makes a finder without islands (groups of particles that may meet) from the data `clusters` of a part, a piece
    /// of the time between two exchanges with the gas.
    fn new(clusters: Clusters<'a>, limits: IslandLimits) -> Self;

    /// Ends the search for islands (groups of particles that may meet), and returns the islands that were found.
    fn into_clusters(self) -> Clusters<'a>;

    /// Makes islands (groups of particles that may meet) of all particles that touch on straight flights or have a
    /// carried contact. `carried` contains the two particles of each contact (the second is `None`, for instance, at a
    /// wall). `energy` contains the energy [J] that each contact may give back. Returns false if an island is too
    /// large.
    fn gather(&mut self, touches: &[FirstTouch], carried: &[[Option<u32>; 2]], energy: Vec<f64>) -> bool;

    /// Appends to `pairs` each pair of one member of an island (group of particles that may meet) with a particle that
    /// it may touch. Only particles after the member in the list of the island count. `member` contains the index of
    /// the member in this list, and its data. `island` contains the list (store indices of all particles of the island,
    /// members first) and the number of members.
    fn list_pairs(&self, member: (usize, &Member), island: (&[u32], usize), pairs: &mut Vec<Pair>);

    /// Makes an empty store for the trajectories of `members` particles. Its memory is reserved in advance, unless the
    /// method uses no trajectories.
    fn trajectories(_members: usize) -> MemberTrajectories {
        MemberTrajectories::default()
    }

    /// Moves the trajectories of a solved island (group of particles that may meet) to the end of `_trajectories`;
    /// does nothing if the method uses no trajectories.
    fn trace<C>(&self, _island: &mut Island<C>, _trajectories: &mut MemberTrajectories) {}

    /// Stores the trajectories of the members of the solved island `_which` (group of particles that may meet). They
    /// are at the places `_ways` in `_trajectories`. Does nothing if the method uses no trajectories.
    fn follow(&mut self, _which: usize, _ways: Range<usize>, _trajectories: &MemberTrajectories) {}

    /// Changes the islands (groups of particles that may meet) in `retries`, and unites islands that may meet; all
    /// these islands must be solved again. Returns the number of solved islands whose results became invalid because
    /// they met other islands or particles; `None` if an island is too large. `mine` returns true for the index of a
    /// particle that belongs to this process. An island is counted only if its leader (the member with the smallest
    /// id) belongs to this process.
    fn next_round(&mut self, retries: Vec<(usize, Retry)>, mine: impl Fn(u32) -> bool) -> Option<u64>;

    /// Velocity changes of a member in this part (interval of time), in the order of time; `None` if its trajectory is
    /// unknown.
    fn velocity_changes(&self, _member: &Member) -> Option<&[VelocityChange]> {
        None
    }

    /// True if a member may touch a particle of another island (group of particles that may meet). `_place` is the
    /// index of that particle in the store, and `_turns` are its velocity changes (`None` if unknown). A method
    /// without trajectories always returns true.
    fn may_meet(&self, _member: &Member, _place: u32, _turns: Option<&[VelocityChange]>) -> bool {
        true
    }

    /// Members that were added after the members were last sorted into cells.
    /// [`for_each_beside`](Self::for_each_beside) does not find these members.
    fn late(&self) -> &[Member] {
        &[]
    }

    /// Calls `visit` with all members in cells that may come into the ball `ball`, and with a few members that do not.
    /// `widest` [m] is the largest distance of any member from the middle of its straight flight.
    fn for_each_beside(&self, ball: &BoundingSphere, widest: f64, visit: &mut dyn FnMut(&Member));
}
