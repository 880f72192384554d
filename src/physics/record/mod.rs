//! Records of a run: impacts, losses of energy, and impulses on walls. The ledger contains the sums of work, losses and
//! impulses.
//!
//! All engines record the same quantities here; statistics and reports read the records.

mod histogram;
mod impacts;
mod kinds;
mod ledger;

pub use histogram::Histogram;
pub use impacts::{Impact, Impacts, InstantaneousContacts, LeftOut, SlipChange, Slips, Summary};
pub use kinds::{Between, ByKinds, MeetingTotals, Meetings};
pub use ledger::{AT_WALLS, BY_SHEAR, Books, ENTRIES, FrictionLosses, Ledger, OF_PAIRS, OF_SPRINGS, SOME};

use crate::work_sharing;
use serde::{Deserialize, Serialize};

/// Impacts, and amounts for the ledger (sums of work, losses and impulses), from a part of an engine's work. They are
/// not yet added to a [`Record`]. With separate logs an engine can discard a part of its work, and several threads can
/// write.
#[derive(Clone, Debug, Default)]
pub struct Log {
    /// Finished impacts, each with the kinds of its two bodies.
    pub impacts: Vec<(Between, Impact)>,
    /// Amounts to add to the ledger of the record, which contains the sums of work, losses and impulses.
    pub ledger: Ledger,
    /// Amounts for the ledger in addition to `ledger`: one [`Ledger::to_array`] for each island (a group of particles
    /// that may meet).
    pub islands: Vec<[f64; ENTRIES]>,
}

/// Number of impacts that one thread counts at a time. For fewer impacts, two threads would be slower than one, because
/// their counts must be merged.
const TOGETHER: usize = 4096;

impl Record {
    /// Adds the entries of a log to the record, and empties the log.
    pub fn absorb(&mut self, log: &mut Log) {
        self.count(&mut log.impacts);
        log.islands.push(std::mem::take(&mut log.ledger).to_array());
        self.ledger.add(&log.islands);
        log.islands.clear();
    }

    /// Counts finished impacts, in any order, and empties `impacts`.
    pub fn count(&mut self, impacts: &mut Vec<(Between, Impact)>) {
        if impacts.len() <= TOGETHER {
            self.count_some(impacts);
        } else {
            let counted = |some: &mut [(Between, Impact)]| {
                let mut record = Self::default();
                record.count_some(some);
                record
            };
            work_sharing::map(impacts.chunks_mut(TOGETHER), counted).iter().for_each(|counted| self.merge(counted));
        }
        impacts.clear();
    }

    fn count_some(&mut self, impacts: &mut [(Between, Impact)]) {
        impacts.sort_unstable_by_key(|(between, _)| *between);
        for alike in impacts.chunk_by(|(one, _), (other, _)| one == other) {
            let between = alike[0].0;
            let all = || alike.iter().map(|(_, impact)| impact);
            if between.is_wall() {
                self.walls.add_all(all())
            } else {
                self.pairs.add_all(all())
            }
            self.kinds.add_all(between, all());
        }
    }

    /// Adds another record, of other impacts of the same run. The order of the records does not matter.
    pub fn merge(&mut self, other: &Self) {
        self.pairs.merge(&other.pairs);
        self.walls.merge(&other.walls);
        self.kinds.merge(&other.kinds);
        self.ledger.merge(&other.ledger);
    }
}

/// All records that an engine makes during a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Sums and histograms over the impacts between particles.
    pub pairs: Impacts,
    /// Sums and histograms over the impacts of particles on walls.
    pub walls: Impacts,
    /// Sums over all impacts, separate for each pair of kinds (each a species of particles or a wall).
    pub kinds: Meetings,
    /// Energies and momenta that particles gained or lost since the start, as exact sums.
    pub ledger: Books,
}

#[cfg(test)]
mod tests;
