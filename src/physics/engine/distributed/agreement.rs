//! Joint decision of all processes after they have tried to compute a part, a piece of a window (the time between two
//! exchanges of momentum with the gas). The trial is valid only if islands (groups of particles that may meet) that
//! several processes solved have the same members and results. To borrow a particle means to store a copy (ghost) of a
//! particle of another process.

use super::domains::{Domains, LocalParticles};
use super::ghost_islands::{HotParticleDigest, agree_with, tell};
use super::packing::{packed, unpacked};
use crate::engine::islands::{IslandFinder, Reach};

/// [-] factor by which the needed distance is increased, for the next part (piece of a window) or for the repetition of
/// a part. Within this distance from its block (region of the box), a process copies particles of other processes. The
/// factor exceeds 1, because copying a few particles too many costs less than repeating a part.
const SPARE: f64 = 1.25;

/// Joint decision of all processes, after each has tried to solve its islands (groups of particles that may meet) in a
/// part, a piece of the time between two exchanges with the gas.
pub enum PartDecision {
    /// The results of all processes for this piece of the window are valid.
    Done,
    /// This piece of the window must be computed again, with particles copied from other processes farther away.
    Again,
    /// The islands (groups of particles that may meet) of this piece of the window are given up. The reason is an
    /// island that is too large or reaches beyond half a period of the box, or a failure of the engine. Another reason
    /// is that the results differ although each process stores all particles. The caller then tries a shorter piece.
    Failed,
}

/// Result of one process for a part (piece of the time between two exchanges with the gas), on which the joint decision
/// is based.
struct LocalStatus {
    /// Largest distances [m] that particles reach in flights and in islands (groups of particles that may meet).
    reach: Reach,
    /// Smallest distance [m] from the islands (groups of particles that may meet) of own particles to the border of the
    /// region whose particles this process stores. It is negative if an island reaches beyond this border.
    room: f64,
    /// True if an island (group of particles that may meet) is too large, or the engine failed.
    failed: bool,
    /// True if other processes have obtained equal results for the islands (groups of particles that may meet) with
    /// particles of this process, and this process stores all particles in contact with its own.
    agrees: bool,
}

impl<C> Domains<C> {
    /// Returns the joint decision of all processes about a part, a piece of a window that they have tried to compute.
    /// The part is accepted, repeated with particles from farther away, or given up. `failed` is true if, in this
    /// process, an island (group of particles that may meet) is too large or the engine failed. All processes must call
    /// this function.
    pub fn decide<'a>(
        &mut self,
        islands: &impl IslandFinder<'a>,
        view: &LocalParticles<C>,
        failed: bool,
    ) -> PartDecision {
        let room = islands.least_room(|index| view.is_mine(index));
        let agrees = self.compare(islands, view, failed) && view.complete;
        let status = LocalStatus { reach: islands.reach(), room, failed, agrees };
        self.vote(&status, islands.half_period(), islands.domain().size.amax())
    }

    /// True if other processes have obtained equal results for the islands (groups of particles that may meet) with
    /// particles of this process. All processes must call this function at the same time. A process for which `failed`
    /// is true sends no results, and the function returns false there.
    fn compare<'a>(&self, islands: &impl IslandFinder<'a>, view: &LocalParticles<C>, failed: bool) -> bool {
        let mut told: Vec<Vec<HotParticleDigest>> = vec![Vec::new(); self.communicator.size()];
        if !failed {
            let space = (&self.block(islands.domain()), islands.domain());
            tell(
                islands,
                |index| view.is_mine(index),
                |middle| !self.blocks.is_deep(middle, space.0, self.lent()),
                |one, middle| self.for_each_borrower(middle, space, |rank| told[rank].push(one.clone())),
            );
        }
        let outgoing = told.iter().map(|told| if told.is_empty() { Vec::new() } else { packed(told) }).collect();
        let heard = self.communicator.exchange(outgoing);
        let heard = heard.iter().filter_map(|bytes| unpacked::<Vec<HotParticleDigest>>(bytes)).flatten();
        let heard: Vec<_> = heard.filter_map(|one| Some((*view.strangers.get(&one.id)?, one))).collect();
        !failed && agree_with(islands, |index| view.is_mine(index), &heard)
    }

    /// Derives the joint decision of all processes about a part (piece of a window) from the result `opinion` of this
    /// process and the results of the other processes. Adapts the distance from which this process copies particles of
    /// other processes. `half_period` [m] is half the shortest period of the box, and `size` [m] its longest edge.
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
        let missing = reach.search_radius() + nearest;
        let needed = self.width + missing;
        if missing > 0.0 {
            self.width = SPARE * needed;
            return PartDecision::Again;
        }
        if differs > 0.0 {
            // every process has stored all particles, so missing particles cannot cause the differences; a shorter part
            // is tried next
            if self.width > size {
                return PartDecision::Failed;
            }
            self.width = SPARE * (self.width + reach.search_radius());
            return PartDecision::Again;
        }
        self.width = (SPARE * needed).clamp(0.9 * self.width, self.width.max(SPARE * needed));
        PartDecision::Done
    }
}
