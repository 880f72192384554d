//! The data that last between two windows, taken out of a simulation and put into another.

use super::totals::SimulationTotals;
use super::{Simulation, SimulationTimes};
use crate::communicator::Communicator;
use crate::experiment::Experiment;
use crate::particles::Particles;
use crate::predict::energy::Bound;
use crate::record::Record;
use crate::stored::{StoreError, Stored};
use serde::{Deserialize, Serialize};

/// All data that last between two windows, as one value. A simulation of the same experiment continues from it with
/// bits identical to those of the first. `docs/design/runs.md` lists the contents.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Snapshot {
    /// The particles, in the order of the store; empty where the state is in parts.
    pub particles: Particles,
    /// Number of parts of the state, which are stored beside the snapshot; 0 if the snapshot holds all.
    pub parts: usize,
    /// Collisions and other records since the start.
    pub record: Record,
    /// [s] simulated time.
    pub time: f64,
    /// Number of windows done.
    pub windows: u64,
    /// Time spent so far.
    pub spent: SimulationTimes,
    /// Sums over all particles.
    totals: SimulationTotals,
    /// True if the drag of the last window has been applied completely.
    half_kicked: bool,
    /// Limit of the energy growth by the scheme itself, which depends on the start (soft).
    bound: Option<Bound>,
    /// [J] elastic energy of the start, as long as the engine has not processed it (soft).
    unseen: Option<f64>,
    /// State of the engine.
    engine: Stored,
}

impl Snapshot {
    /// Checks that the particles can be those of an experiment.
    ///
    /// # Errors
    /// If they cannot.
    pub fn fits(&self, experiment: &Experiment) -> Result<(), StoreError> {
        let (particles, kinds) = (&self.particles, experiment.scene.species.len());
        let known = particles.species.iter().all(|kind| usize::from(*kind) < kinds);
        if known && particles.is_whole(particles.len()) { Ok(()) } else { Err(StoreError::misfit()) }
    }
}

impl Simulation {
    /// A snapshot with which a simulation of the same experiment can continue. If processes share the run and each
    /// has a part, the parts are not in it: call [`give_parts`](Self::give_parts) before.
    ///
    /// # Errors
    /// If an engine of the calling program cannot store its state.
    pub fn snapshot(&self) -> Result<Snapshot, StoreError> {
        let parts = self.parts().map_or(0, Communicator::size);
        Ok(Snapshot {
            particles: if parts == 0 { self.particles.clone() } else { Particles::default() },
            parts,
            record: self.record.clone(),
            time: self.time,
            windows: self.windows,
            spent: self.spent,
            totals: self.totals,
            half_kicked: self.half_kicked,
            bound: self.bound.clone(),
            unseen: self.unseen,
            engine: self.engine.stored()?,
        })
    }

    /// A simulation of an experiment that continues from a snapshot.
    ///
    /// # Errors
    /// If the snapshot is of another engine, or its particles cannot be those of the experiment.
    pub fn restore(experiment: &Experiment, snapshot: Snapshot) -> Result<Self, StoreError> {
        snapshot.fits(experiment)?;
        Self::new(experiment, snapshot.particles.clone()).resume(snapshot)
    }

    /// Continues from a snapshot with an engine of the calling program. This simulation keeps its scene and settings,
    /// and takes the particles and records from the snapshot.
    ///
    /// # Errors
    /// If the snapshot is of another engine.
    pub fn resume(mut self, snapshot: Snapshot) -> Result<Self, StoreError> {
        let Snapshot { particles, record, time, windows, spent, totals, .. } = snapshot;
        let Snapshot { half_kicked, bound, unseen, engine, .. } = snapshot;
        self.engine.restore(&engine)?;
        let by_walls = record.ledger.by_walls();
        let run = Self { particles, record, time, windows, spent, totals, by_walls, ..self };
        Ok(Self { half_kicked, bound, unseen, ..run })
    }
}
