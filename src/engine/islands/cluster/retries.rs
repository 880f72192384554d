//! Changes to unfinished islands before they are solved again.

use super::{Cluster, Clusters};
use crate::engine::islands::batch::Retry;
use crate::engine::islands::search::Label;
use crate::work_sharing;

/// Factor from the observed speed to the next speed limit, after a limit was passed: few repetitions find a sufficient
/// limit.
const RAISE: f64 = 1.5;

/// Islands whose bystanders a thread checks at once.
const BATCH: usize = 512;

impl Clusters<'_> {
    /// Applies the changes of all islands of a round, before the surroundings of any are searched again. So the order
    /// of the changes does not matter. Returns false if an island grows too large.
    pub fn apply_retries(&mut self, retries: Vec<(usize, Retry)>) -> bool {
        let mut known = self.members.len();
        // an island may be united with another one before its turn comes, but its members stay
        let taught: Vec<(u32, Retry)> =
            retries.into_iter().map(|(which, lesson)| (self.clusters[which].hot[0], lesson)).collect();
        for (member, lesson) in &taught {
            self.apply_retry(*member, lesson);
        }
        if self.traces {
            return true;
        }
        let mut changed: Vec<u32> = taught.into_iter().map(|(member, _)| member).collect();
        while !changed.is_empty() {
            changed.extend(self.unite_with_bystanders(known));
            known = self.members.len();
            let of = |member: u32| self.members[member as usize].cluster as usize;
            if !self.expand_all(changed.drain(..).map(of).collect()) {
                return false;
            }
            changed.extend((known..self.members.len()).map(|member| member as u32));
        }
        true
    }

    /// Changes one island: a bystander becomes a member, a speed limit rises, or the island becomes a crowd.
    fn apply_retry(&mut self, member: u32, lesson: &Retry) {
        let mut which = self.members[member as usize].cluster as usize;
        match lesson {
            Retry::Crowd => self.clusters[which].lasts = true,
            Retry::Stops(stops) => {
                for stop in stops {
                    if stop.bystander {
                        let with = self.cluster_of(stop.place);
                        which = self.unite(which, with);
                    } else {
                        let floor = &mut self.clusters[which].floor;
                        *floor = floor.max(RAISE * stop.speed);
                    }
                }
            }
        }
        self.clusters[which].solved = None;
        self.clusters[which].version += 1;
    }

    /// Unites islands with those of their bystanders that are hot now: members from number `known` on. Returns a member
    /// of each island that has changed.
    fn unite_with_bystanders(&mut self, known: usize) -> Vec<u32> {
        let mut changed = Vec::new();
        if self.members.len() == known {
            return changed;
        }
        let this = &*self;
        let late =
            |place: &u32| this.search.label[*place as usize].map(Label::member).filter(|&member| member >= known);
        let of_one = |(which, cluster): (usize, &Cluster)| {
            let late: Vec<usize> = cluster.bystanders.iter().filter_map(late).collect();
            (cluster.alive && !late.is_empty()).then_some((which, late))
        };
        let of_some = |first: usize| {
            let clusters = this.clusters.iter().enumerate().skip(first).take(BATCH);
            clusters.filter_map(of_one).collect::<Vec<_>>()
        };
        let found = work_sharing::map((0..self.clusters.len()).step_by(BATCH), of_some);
        for (which, late) in found.into_iter().flatten() {
            if !self.clusters[which].alive {
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
