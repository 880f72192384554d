//! What happened while an engine moved the particles: impacts, dissipation, impulses on walls.
//!
//! Both engines write here in the same terms; statistics and reports read it.

mod histogram;
mod impacts;
mod kinds;
mod ledger;

pub use histogram::Histogram;
pub use impacts::{Impact, Impacts, Instants, LeftOut, Summary};
pub use kinds::{Between, ByKinds, Totals};
pub use ledger::Ledger;

use serde::{Deserialize, Serialize};

/// What a stretch of engine work adds to a [`Record`]. Kept apart while it may still be discarded, or while several
/// threads write.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Log {
    /// Impacts that have ended, in order, and who met.
    pub impacts: Vec<(Between, Impact)>,
    /// What to add to the ledger.
    pub ledger: Ledger,
}

impl Record {
    /// Takes over what a log holds and empties it.
    pub fn absorb(&mut self, log: &mut Log) {
        self.count(&mut log.impacts);
        self.ledger += std::mem::take(&mut log.ledger);
    }

    /// Counts impacts that have ended, in their order, and leaves none.
    pub fn count(&mut self, impacts: &mut Vec<(Between, Impact)>) {
        for (between, impact) in impacts.drain(..) {
            if between.is_wall() {
                self.walls.add(&impact)
            } else {
                self.pairs.add(&impact)
            }
            self.kinds.add(between, &impact);
        }
    }
}

/// Everything an engine tells.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Record {
    /// Impacts between particles.
    pub pairs: Impacts,
    /// Impacts of particles on walls.
    pub walls: Impacts,
    /// All impacts by the kinds that met.
    pub kinds: ByKinds,
    /// Energy and momentum, added up exactly.
    pub ledger: Ledger,
}
