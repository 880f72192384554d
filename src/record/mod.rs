//! What happened while an engine moved the particles: impacts, dissipation, impulses on walls.
//!
//! Both engines write here in the same terms; statistics and reports read it.

mod histogram;
mod impacts;
mod ledger;

pub use histogram::Histogram;
pub use impacts::{Impact, Impacts, Summary};
pub use ledger::Ledger;

/// Everything an engine tells.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Impacts between particles.
    pub pairs: Impacts,
    /// Impacts of particles on walls.
    pub walls: Impacts,
    /// Energy and momentum, added up exactly.
    pub ledger: Ledger,
}
