//! Records of a run: impacts, dissipation, impulses on walls.
//!
//! Both engines write here in common terms; statistics and reports read it.

mod histogram;
mod impacts;
mod kinds;
mod ledger;

pub use histogram::Histogram;
pub use impacts::{Impact, Impacts, InstantaneousContacts, LeftOut, Summary};
pub use kinds::{Between, ByKinds, MeetingTotals, Meetings};
pub use ledger::{AT_WALLS, Books, ENTRIES, Ledger, OF_PAIRS, SOME};

use crate::work_sharing;
use serde::{Deserialize, Serialize};

/// Entries of a part of the engine's work for a [`Record`]. They are kept apart while they may still be discarded, or
/// while several threads write.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Log {
    /// Impacts that have ended, with the kinds that met.
    pub impacts: Vec<(Between, Impact)>,
    /// Amounts to add to the ledger.
    pub ledger: Ledger,
    /// Further amounts for the ledger: [`Ledger::to_array`] of each island.
    pub islands: Vec<[f64; ENTRIES]>,
}

/// Impacts that a thread counts at once: counting much fewer takes less time than merging the counts of two threads.
const TOGETHER: usize = 4096;

impl Record {
    /// Adds the entries of a log, and empties it.
    pub fn absorb(&mut self, log: &mut Log) {
        self.count(&mut log.impacts);
        log.islands.push(std::mem::take(&mut log.ledger).to_array());
        self.ledger.add(&log.islands);
        log.islands.clear();
    }

    /// Counts impacts that have ended, in any order, and empties the list.
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

    /// Adds another record, of other impacts of the same run: the order does not matter.
    pub fn merge(&mut self, other: &Self) {
        self.pairs.merge(&other.pairs);
        self.walls.merge(&other.walls);
        self.kinds.merge(&other.kinds);
        self.ledger.merge(&other.ledger);
    }
}

/// All records of an engine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Impacts between particles.
    pub pairs: Impacts,
    /// Impacts of particles on walls.
    pub walls: Impacts,
    /// All impacts by the kinds that met.
    pub kinds: Meetings,
    /// Energy and momentum, added up exactly.
    pub ledger: Books,
}

#[cfg(test)]
mod tests;
