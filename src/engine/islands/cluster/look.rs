//! Search of the surroundings of islands for bystanders and for other islands to unite with.

use super::{Cluster, Clusters, Few, Member};
use crate::engine::islands::search::BoundingSphere;
use crate::work_sharing;

/// Islands whose surroundings a thread searches at once.
const BATCH: usize = 16;

/// Result of a search of the surroundings of an island.
enum Surroundings {
    /// Cold particles that the island might hit, by index.
    Bystanders(Few),
    /// Other islands that it might meet; all of them if there may be crowds, otherwise one.
    Islands(Vec<usize>),
    /// The island has grown too large.
    TooLarge,
}

impl Clusters<'_> {
    /// Searches the surroundings of islands until no two of them meet; each then knows its bystanders. Returns false if
    /// one grows too large. The searches run in rounds, in parallel, and change nothing during a round. Islands only
    /// grow, so the result does not depend on the order of the searches.
    pub(super) fn expand_all(&mut self, changed: Vec<usize>) -> bool {
        let mut waiting = changed;
        while !waiting.is_empty() {
            waiting.sort_unstable();
            waiting.dedup();
            self.settle_changed(&waiting);
            // crowds first: each takes in at once all that it meets; otherwise the islands around it would be united
            // with it one by one
            if self.crowds && !waiting.iter().all(|&which| !self.clusters[which].is_crowd() || self.expand_crowd(which))
            {
                return false;
            }
            waiting.retain(|&which| self.clusters[which].has_to_look());
            let this = &*self;
            let look = |&which: &usize| (which, this.clusters[which].version, this.look_around(which));
            let looks = waiting.chunks(BATCH);
            let seen = work_sharing::map(looks, |some| some.iter().map(look).collect::<Vec<_>>()).into_iter().flatten();
            let mut united = Vec::new();
            for (which, version, seen) in seen {
                // otherwise it has been united with another one in this round, which searches in the next
                if self.clusters[which].alive && self.clusters[which].version == version {
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

    /// Computes the reach of the members of islands where it is not known.
    fn settle_changed(&mut self, islands: &[usize]) {
        for &which in islands {
            let cluster = &self.clusters[which];
            if cluster.alive && cluster.settled != Some(cluster.version) {
                self.settle(which);
            }
        }
    }

    /// Takes into a crowd all particles beside it, finds its bystanders, and unites it with islands that it may meet.
    /// Returns false if it grows too large.
    fn expand_crowd(&mut self, which: usize) -> bool {
        let mut which = which;
        while self.clusters[which].has_to_look() {
            self.settle(which);
            self.take_in_beside(which);
            match self.look_around(which) {
                Surroundings::Bystanders(bystanders) => self.has_seen(which, bystanders),
                Surroundings::Islands(others) => which = self.unite_all(which, others),
                Surroundings::TooLarge => return false,
            }
        }
        true
    }

    /// Unites an island with some others.
    fn unite_all(&mut self, which: usize, others: Vec<usize>) -> usize {
        others.into_iter().fold(which, |which, other| self.unite(which, other))
    }

    /// Records that an island, in its present version, meets no other one.
    fn has_seen(&mut self, which: usize, bystanders: Few) {
        let cluster = &mut self.clusters[which];
        cluster.bystanders = bystanders;
        cluster.seen = Some(cluster.version);
    }

    /// Finds the particles and islands that an island might hit.
    fn look_around(&self, which: usize) -> Surroundings {
        let cluster = &self.clusters[which];
        if cluster.is_too_large(self.most) && !self.crowds {
            return Surroundings::TooLarge;
        }
        let mut bystanders = Few::new();
        let mut met: Vec<usize> = Vec::new();
        let search = &*self.search;
        let largest_reach = search.levels.largest_reach();
        for &member in &cluster.hot {
            let here = self.members[member as usize].ball;
            // beyond half a period, images other than the nearest may be met
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
            self.grid.for_each_near(&here.middle, here.reach + self.widest, |range, _| {
                self.sorted[range].iter().for_each(|&other| meet(&self.members[other as usize]));
            });
            self.members[self.sorted.len()..].iter().for_each(meet);
            if let Some(&met) = met.last().filter(|_| !self.crowds) {
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
        bystanders.sort_unstable_by_key(|&place| self.particles.id[place as usize]);
        bystanders.dedup();
        Surroundings::Bystanders(bystanders)
    }
}

impl Cluster {
    /// True if the island is a crowd, or has more than `most` members and a shorter part would have fewer. Contacts in
    /// progress are there in any part, so each of them allows for two members.
    fn is_too_large(&self, most: usize) -> bool {
        self.is_crowd() || self.hot.len() > most.max(2 * self.carried.len())
    }

    /// True if the island has changed since its surroundings were last searched.
    fn has_to_look(&self) -> bool {
        self.alive && self.seen != Some(self.version)
    }
}
