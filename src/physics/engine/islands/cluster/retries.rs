//! Changes to unfinished islands (groups of particles that may meet) before they are solved again.

use super::Clusters;
use crate::engine::islands::batch::Retry;

/// [-] the lower bound of the speed limits of an island (group of particles that may meet) is raised to this factor
/// times the speed of a particle that exceeded its limit. With this factor, islands rarely have to be solved again.
const RAISE: f64 = 1.5;

impl Clusters<'_> {
    /// Changes the islands (groups of particles that may meet) that must be solved again, given by their numbers. The
    /// surroundings of islands are searched again only afterwards, so the order of the changes does not matter.
    /// Returns the number of one member of each changed island.
    pub(super) fn apply_retries(&mut self, retries: Vec<(usize, Retry)>) -> Vec<u32> {
        // members identify the islands, since an island may be united with another one before its change is applied
        let retries: Vec<(u32, Retry)> =
            retries.into_iter().map(|(which, retry)| (self.list[which].hot[0], retry)).collect();
        for (member, retry) in &retries {
            self.apply_retry(*member, retry);
        }
        retries.into_iter().map(|(member, _)| member).collect()
    }

    /// Changes the island (group of particles that may meet) of the member with the number `member` before the island
    /// is solved again. A bystander that was hit becomes a member, a speed limit rises, or the island becomes a crowd,
    /// which is moved by uniform steps.
    fn apply_retry(&mut self, member: u32, retry: &Retry) {
        let mut which = self.members[member as usize].cluster as usize;
        match retry {
            Retry::Crowd => self.list[which].lasts = true,
            Retry::Stops(stops) => {
                for stop in stops {
                    if stop.bystander {
                        let with = self.cluster_of(stop.index);
                        which = self.unite(which, with);
                    } else {
                        let floor = &mut self.list[which].floor;
                        *floor = floor.max(RAISE * stop.speed);
                    }
                }
            }
        }
        self.list[which].solved = None;
        self.list[which].version += 1;
    }
}
