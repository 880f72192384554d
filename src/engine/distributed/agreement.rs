//! Agreement of all processes about a part of a window that they have tried.

use super::domains::{Domains, LocalParticles};
use super::ghost_islands::{HotParticleDigest, agree_with, tell};
use super::packing::{packed, unpacked};
use crate::engine::islands::{IslandFinder, Reach};

/// Safety factor of the distance from which particles are borrowed, over the distance needed in the part before. A
/// repeated part costs more than particles borrowed in vain.
const SPARE: f64 = 1.25;

/// Decision of all processes about a part that they have tried.
pub enum PartDecision {
    /// The part is done.
    Done,
    /// The part is to be repeated with particles from farther away.
    Again,
    /// Islands grow too large, or an engine failed.
    Failed,
}

/// Result of one process for a part.
struct LocalStatus {
    /// Largest reach [m] of flights and islands.
    reach: Reach,
    /// Least distance [m] from the islands of the own particles to the end of the region seen.
    room: f64,
    /// True if islands grow too large, or the engine failed.
    failed: bool,
    /// True if other processes have the same result.
    agrees: bool,
}

impl<C> Domains<C> {
    /// Joint decision of all processes about a part that they have tried; this one has `failed` if islands grow too
    /// large or the engine fails.
    pub fn decide<'a>(
        &mut self,
        islands: &impl IslandFinder<'a>,
        view: &LocalParticles<C>,
        failed: bool,
    ) -> PartDecision {
        let room = islands.least_room(|place| view.is_mine(place));
        let agrees = self.compare(islands, view, failed) && view.complete;
        let status = LocalStatus { reach: islands.reach(), room, failed, agrees };
        self.vote(&status, islands.half_period(), islands.domain().size.amax())
    }

    /// True if other processes have the same result for the islands of this process. All processes must call it; one
    /// that has `failed` sends nothing.
    fn compare<'a>(&self, islands: &impl IslandFinder<'a>, view: &LocalParticles<C>, failed: bool) -> bool {
        let mut told: Vec<Vec<HotParticleDigest>> = vec![Vec::new(); self.communicator.size()];
        if !failed {
            let space = (&self.block(islands.domain()), islands.domain());
            tell(
                islands,
                |place| view.is_mine(place),
                |middle| !self.blocks.is_deep(middle, space.0, self.lent()),
                |one, middle| self.for_each_borrower(middle, space, |rank| told[rank].push(one.clone())),
            );
        }
        let outgoing = told.iter().map(|told| if told.is_empty() { Vec::new() } else { packed(told) }).collect();
        let heard = self.communicator.exchange(outgoing);
        let heard = heard.iter().filter_map(|bytes| unpacked::<Vec<HotParticleDigest>>(bytes)).flatten();
        let heard: Vec<_> = heard.filter_map(|one| Some((*view.strangers.get(&one.id)?, one))).collect();
        !failed && agree_with(islands, |place| view.is_mine(place), &heard)
    }

    /// Joint decision of all processes about a part, in a box whose longest edge is `size` [m].
    fn vote(&mut self, opinion: &LocalStatus, half_period: f64, size: f64) -> PartDecision {
        let LocalStatus { reach, room, failed, agrees } = *opinion;
        let flag = |set: bool| if set { 1.0 } else { 0.0 };
        let mut votes = [reach.flight, reach.around, reach.ball, -room, flag(failed), flag(!agrees)];
        self.communicator.largest(&mut votes);
        let [flight, around, ball, nearest, failed, differs] = votes;
        let reach = Reach { flight, around, ball };
        if failed > 0.0 || !reach.fits(half_period) {
            return PartDecision::Failed;
        }
        let missing = reach.sight() + nearest;
        let needed = self.width + missing;
        if missing > 0.0 {
            self.width = SPARE * needed;
            return PartDecision::Again;
        }
        if differs > 0.0 {
            // every process has seen all particles, so results cannot differ; a shorter part is another try
            if self.width > size {
                return PartDecision::Failed;
            }
            self.width = SPARE * (self.width + reach.sight());
            return PartDecision::Again;
        }
        self.width = (SPARE * needed).clamp(0.9 * self.width, self.width.max(SPARE * needed));
        PartDecision::Done
    }
}
