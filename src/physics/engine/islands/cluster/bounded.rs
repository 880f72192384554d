//! Islands (groups of particles that may meet) that are found by upper limits on the flights of their members. Before
//! an island is solved, its surroundings are searched. The search finds *bystanders* (cold particles that the island
//! might hit), and other islands with which the island must unite. *Hot* particles touch something on their straight
//! flight, *cold* ones do not. A part is a piece of a window, the time between two exchanges with the gas.

use super::{Cluster, Clusters, Few, IslandFinder, IslandLimits, Member};
use crate::engine::islands::batch::Retry;
use crate::engine::islands::choice::{BOUNDED, PartCosts};
use crate::engine::islands::search::{BoundingSphere, FirstTouch, Label};
use crate::neighbours::Pair;
use crate::neighbours::cells::CellGrid;
use crate::work_sharing;
use std::ops::{Deref, DerefMut};

/// Number of contacts in progress above which all of them form one crowd (an island moved by uniform steps), in
/// engines that take crowds. A contact costs four times as much in the step of a separate island (group of particles
/// that may meet) as in a uniform step. With so many contacts, some particles touch at any time, so an island of them
/// would need steps all the time.
const MANY_CONTACTS: usize = 16;

/// Number of islands (groups of particles that may meet) whose surroundings a thread searches in one piece of work.
const BATCH: usize = 16;

/// Number of islands (groups of particles that may meet) whose bystanders (particles that fly straight unless a member
/// hits them) a thread checks in one piece of work.
const MANY: usize = 512;

/// Result of searching the surroundings of an island (group of particles that may meet) for particles that it may
/// meet.
enum Surroundings {
    /// The island (group of particles that may meet) meets no other island. The list contains the indices of its
    /// bystanders, particles that fly straight unless a member hits them.
    Bystanders(Few),
    /// Numbers of other islands (groups of particles that may meet) that this island may meet. The list contains all
    /// of them if the engine takes crowds (large islands moved by uniform steps), otherwise only one.
    Islands(Vec<usize>),
    /// The island has too many members, or reaches too far, for a part (interval of time) of the present length.
    TooLarge,
}

/// Islands (groups of particles that may meet) that are found by upper limits on the distances that their members may
/// fly. All particles that an island may meet are found before the island is solved.
pub struct BoundedIslands<'a> {
    clusters: Clusters<'a>,
    limits: IslandLimits,
    /// Cells into which the members were last sorted by the middles of their flights. Members that were added later are
    /// not in the cells.
    grid: CellGrid,
    pub(super) sorted: Vec<u32>,
}

impl<'a> Deref for BoundedIslands<'a> {
    type Target = Clusters<'a>;

    fn deref(&self) -> &Clusters<'a> {
        &self.clusters
    }
}

impl<'a> DerefMut for BoundedIslands<'a> {
    fn deref_mut(&mut self) -> &mut Clusters<'a> {
        &mut self.clusters
    }
}

impl<'a> IslandFinder<'a> for BoundedIslands<'a> {
    const COSTS: PartCosts = BOUNDED;
    const KEEPS_SHORTER: bool = true;

    fn new(clusters: Clusters<'a>, limits: IslandLimits) -> Self {
        Self { clusters, limits, grid: CellGrid::default(), sorted: Vec::new() }
    }

    fn into_clusters(self) -> Clusters<'a> {
        self.clusters
    }

    fn gather(&mut self, touches: &[FirstTouch], carried: &[[Option<u32>; 2]], energy: Vec<f64>) -> bool {
        // many contacts in progress form one crowd from the start, even if they do not touch one another: as separate
        // islands they would unite one by one, at several times the cost of uniform steps
        let many = self.limits.crowds && carried.len() > MANY_CONTACTS;
        self.begin(touches, carried, energy, many);
        self.sort();
        self.expand_all((0..self.list.len()).collect())
    }

    /// Appends the pairs of a member with later particles of its island (group of particles that may meet), if the
    /// balls of both particles overlap. The ball of a member contains its path after the first touch; that of a
    /// bystander contains its straight flight.
    fn list_pairs(&self, (a, member): (usize, &Member), (indices, hot): (&[u32], usize), pairs: &mut Vec<Pair>) {
        // the ball is enlarged to allow for rounding, so that a touch at the very beginning is not lost
        let here = BoundingSphere { reach: member.ball.reach * (1.0 + 1e-9), ..member.ball };
        let others = (a + 1..indices.len()).filter(|&b| here.meets(&self.ball_of(indices[b], b < hot), self.domain));
        pairs.extend(others.map(|b| Pair { i: a as u32, j: b as u32 }));
    }

    fn next_round(&mut self, retries: Vec<(usize, Retry)>, _mine: impl Fn(u32) -> bool) -> Option<u64> {
        let mut known = self.members.len();
        let mut changed = self.apply_retries(retries);
        while !changed.is_empty() {
            changed.extend(self.unite_with_bystanders(known));
            known = self.members.len();
            let of = |member: u32| self.members[member as usize].cluster as usize;
            let islands = changed.drain(..).map(of).collect();
            if !self.expand_all(islands) {
                return None;
            }
            changed.extend((known..self.members.len()).map(|member| member as u32));
        }
        Some(0)
    }

    fn late(&self) -> &[Member] {
        &self.members[self.sorted.len()..]
    }

    fn for_each_beside(&self, ball: &BoundingSphere, widest: f64, visit: &mut dyn FnMut(&Member)) {
        self.domain.for_each_image(&ball.middle, ball.reach + widest, |middle| {
            self.grid.for_each_near(&middle, ball.reach + widest, |range, _| {
                self.sorted[range].iter().for_each(|&member| visit(&self.members[member as usize]));
            });
        });
    }
}

impl BoundedIslands<'_> {
    /// Sorts the members of all islands (groups of particles that may meet) into cells by the middles of their
    /// straight flights.
    pub(super) fn sort(&mut self) {
        let Clusters { search, members, widest, .. } = &self.clusters;
        let spacing = (search.region.volume() / members.len().max(1) as f64).cbrt();
        // contacts fill only a part of the domain: with cells of a third of the mean spacing there are at most 27 cells
        // per member
        let edge = widest.max(if self.limits.crowds { spacing / 3.0 } else { spacing });
        self.grid.sort(members, |member| member.flight.middle, &search.region, edge, &mut self.sorted);
    }

    /// Ball that contains a particle of an island (group of particles that may meet), given by its index in the store.
    /// For a member (`is_member` is true) it contains the path after the first touch in the island. For a bystander it
    /// contains the whole straight flight.
    fn ball_of(&self, index: u32, is_member: bool) -> BoundingSphere {
        match self.search.label[index as usize] {
            Some(label) if is_member => self.members[label.member()].ball,
            _ => self.search.flights[index as usize],
        }
    }

    /// Searches the surroundings of the islands `changed` (groups of particles that may meet), and unites islands
    /// until no two of them may meet. Then the bystanders (particles that fly straight unless a member hits them) of
    /// each island are known. Returns false if an island is too large.
    ///
    /// In each round, the searches of all changed islands run in parallel; islands change only between rounds. Islands
    /// only grow, so the result does not depend on the order of the searches.
    fn expand_all(&mut self, changed: Vec<usize>) -> bool {
        let mut waiting = changed;
        while !waiting.is_empty() {
            waiting.sort_unstable();
            waiting.dedup();
            self.settle_changed(&waiting);
            // crowds first: a crowd adds all islands that it meets at the same time; otherwise these islands would be
            // united with it one by one
            if self.limits.crowds
                && !waiting.iter().all(|&which| !self.list[which].is_crowd() || self.expand_crowd(which))
            {
                return false;
            }
            waiting.retain(|&which| self.list[which].has_to_look());
            let this = &*self;
            let look = |&which: &usize| (which, this.list[which].version, this.look_around(which));
            let looks = waiting.chunks(BATCH);
            let seen = work_sharing::map(looks, |some| some.iter().map(look).collect::<Vec<_>>()).into_iter().flatten();
            let mut united = Vec::new();
            for (which, version, seen) in seen {
                // if an island was united with another one in this round, its surroundings are searched in the next
                // round
                if self.list[which].alive && self.list[which].version == version {
                    match seen {
                        Surroundings::Bystanders(bystanders) => self.has_seen(which, bystanders),
                        Surroundings::Islands(others) => united.push(self.unite_all(which, others)),
                        Surroundings::TooLarge => return false,
                    }
                }
            }
            waiting = united;
        }
        true
    }

    /// For those of the given islands (groups of particles that may meet) that have changed since the last
    /// computation, computes the distances that their members may reach.
    fn settle_changed(&mut self, islands: &[usize]) {
        for &which in islands {
            let cluster = &self.list[which];
            if cluster.alive && cluster.settled != Some(cluster.version) {
                self.update_reach(which);
            }
        }
    }

    /// Completes a crowd, an island moved by uniform steps: adds the particles next to it as members, unites islands
    /// that it may meet with it, and finds its bystanders (particles that fly straight unless a member hits them).
    /// Returns false if the crowd is too large.
    fn expand_crowd(&mut self, which: usize) -> bool {
        let mut which = which;
        while self.list[which].has_to_look() {
            self.update_reach(which);
            self.take_in_beside(which);
            match self.look_around(which) {
                Surroundings::Bystanders(bystanders) => self.has_seen(which, bystanders),
                Surroundings::Islands(others) => which = self.unite_all(which, others),
                Surroundings::TooLarge => return false,
            }
        }
        true
    }

    /// Unites the island with the number `which` (group of particles that may meet) with the islands `others`, and
    /// returns the number of the united island.
    fn unite_all(&mut self, which: usize, others: Vec<usize>) -> usize {
        others.into_iter().fold(which, |which, other| self.unite(which, other))
    }

    /// Stores the bystanders (particles that fly straight unless a member hits them) of an island (group of particles
    /// that may meet). The function is called after a search has shown that the island meets no other one.
    fn has_seen(&mut self, which: usize, bystanders: Few) {
        let cluster = &mut self.list[which];
        cluster.bystanders = bystanders;
        cluster.seen = Some(cluster.version);
    }

    /// Searches the surroundings of the island with the number `which` (group of particles that may meet) for
    /// particles and islands that its members might hit.
    fn look_around(&self, which: usize) -> Surroundings {
        let cluster = &self.list[which];
        if cluster.is_too_large(self.limits.most) && !self.limits.crowds {
            return Surroundings::TooLarge;
        }
        let mut bystanders = Few::new();
        let mut met: Vec<usize> = Vec::new();
        let search = &*self.search;
        let largest_reach = search.levels.largest_reach();
        for &member in &cluster.hot {
            let here = self.members[member as usize].ball;
            // beyond half a period, an image other than the nearest could be hit
            if here.reach + self.widest.max(largest_reach) > self.half_period {
                return Surroundings::TooLarge;
            }
            let mut meet = |member: &Member| {
                if member.cluster != which as u32
                    && here.meets(&BoundingSphere { reach: member.around, ..member.flight }, self.domain)
                    && (here.meets(&member.flight, self.domain) || here.meets(&member.ball, self.domain))
                {
                    met.push(member.cluster as usize);
                }
            };
            self.domain.for_each_image(&here.middle, here.reach + self.widest, |middle| {
                self.grid.for_each_near(&middle, here.reach + self.widest, |range, _| {
                    self.sorted[range].iter().for_each(|&other| meet(&self.members[other as usize]));
                });
            });
            self.members[self.sorted.len()..].iter().for_each(meet);
            if let Some(&met) = met.last().filter(|_| !self.limits.crowds) {
                return Surroundings::Islands(vec![met]);
            }
            search.for_each_beside(&here, self.domain, |other| {
                if search.label[other as usize].is_none() {
                    bystanders.push(other);
                }
            });
        }
        if !met.is_empty() {
            met.sort_unstable();
            met.dedup();
            return Surroundings::Islands(met);
        }
        bystanders.sort_unstable_by_key(|&index| self.particles.id[index as usize]);
        bystanders.dedup();
        Surroundings::Bystanders(bystanders)
    }

    /// Unites islands (groups of particles that may meet) with those in which their bystanders have become members. A
    /// bystander is a particle that was expected to fly straight. `known` is the number of members before the last
    /// changes. Returns the number of one member of each united island.
    fn unite_with_bystanders(&mut self, known: usize) -> Vec<u32> {
        let mut changed = Vec::new();
        if self.members.len() == known {
            return changed;
        }
        let this = &*self;
        let late =
            |index: &u32| this.search.label[*index as usize].map(Label::member).filter(|&member| member >= known);
        let of_one = |(which, cluster): (usize, &Cluster)| {
            let late: Vec<usize> = cluster.bystanders.iter().filter_map(late).collect();
            (cluster.alive && !late.is_empty()).then_some((which, late))
        };
        let of_some = |first: usize| {
            let clusters = this.list.iter().enumerate().skip(first).take(MANY);
            clusters.filter_map(of_one).collect::<Vec<_>>()
        };
        let found = work_sharing::map((0..self.list.len()).step_by(MANY), of_some);
        for (which, late) in found.into_iter().flatten() {
            if !self.list[which].alive {
                continue;
            }
            let mut united = which;
            for member in late {
                let other = self.members[member].cluster as usize;
                if other != united {
                    united = self.unite(united, other);
                    changed.push(member as u32);
                }
            }
        }
        changed
    }
}

impl Cluster {
    /// True if the island is a crowd (an island moved by uniform steps), or if it has more than `most` members, and
    /// more than two for each of its contacts in progress. Islands with many contacts are allowed, because a shorter
    /// interval of time would not reduce the number of contacts.
    fn is_too_large(&self, most: usize) -> bool {
        self.is_crowd() || self.hot.len() > most.max(2 * self.carried.len())
    }

    /// True if the island (group of particles that may meet) has changed since its surroundings were last searched.
    fn has_to_look(&self) -> bool {
        self.alive && self.seen != Some(self.version)
    }
}
