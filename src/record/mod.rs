//! What happened while an engine moved the particles: impacts, dissipation, impulses on walls.
//!
//! Both engines write here in the same terms; statistics and reports read it.

mod histogram;
mod impacts;
mod ledger;

pub use histogram::Histogram;
pub use impacts::{Impact, Impacts, Summary};
pub use ledger::Ledger;

use serde::{Deserialize, Serialize};

/// What a stretch of engine work adds to a [`Record`]. Kept apart while it may still be discarded, or while several
/// threads write.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Log {
    /// Impacts that have ended, in order, and whether each was on a wall.
    pub impacts: Vec<(bool, Impact)>,
    /// What to add to the ledger.
    pub ledger: Ledger,
}

impl Record {
    /// Takes over what a log holds and empties it.
    pub fn absorb(&mut self, log: &mut Log) {
        for (wall, impact) in log.impacts.drain(..) {
            if wall { self.walls.add(&impact) } else { self.pairs.add(&impact) }
        }
        self.ledger += std::mem::take(&mut log.ledger);
    }
}

/// Everything an engine tells.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Record {
    /// Impacts between particles.
    pub pairs: Impacts,
    /// Impacts of particles on walls.
    pub walls: Impacts,
    /// Energy and momentum, added up exactly.
    pub ledger: Ledger,
}
