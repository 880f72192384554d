//! What lasts between two windows, taken out of a simulation and put into another.

use super::totals::SimulationTotals;
use super::{Simulation, SimulationTimes};
use crate::communicator::Communicator;
use crate::experiment::Experiment;
use crate::particles::Particles;
use crate::predict::energy::Bound;
use crate::record::Record;
use crate::stored::{StoreError, Stored};
use serde::{Deserialize, Serialize};

/// Everything that lasts between two windows, as one value: a simulation of the same experiment goes on from it with the same
/// bits as the one that it was taken of. `docs/architecture.md` says what belongs to it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Snapshot {
    /// The particles, in the order of the store; none where the state is in parts.
    pub particles: Particles,
    /// In how many parts the state is, which are stored beside it; 0 if it is here.
    pub parts: usize,
    /// What has happened since the start.
    pub record: Record,
    /// [s] simulated time.
    pub time: f64,
    /// Windows done.
    pub windows: u64,
    /// Time spent so far.
    pub spent: SimulationTimes,
    /// All particles in a few numbers.
    totals: SimulationTotals,
    /// As in the simulation.
    half_kicked: bool,
    /// How far the energy may grow by itself, which depends on the start (soft).
    bound: Option<Bound>,
    /// [J] elastic energy of the start, for as long as the engine has not seen it (soft).
    unseen: Option<f64>,
    /// What the engine carries on.
    engine: Stored,
}

impl Snapshot {
    /// Whether its particles can be those of an experiment.
    ///
    /// # Errors
    /// They cannot.
    pub fn fits(&self, experiment: &Experiment) -> Result<(), StoreError> {
        let (particles, kinds) = (&self.particles, experiment.scene.species.len());
        let known = particles.species.iter().all(|kind| usize::from(*kind) < kinds);
        if known && particles.is_whole(particles.len()) { Ok(()) } else { Err(StoreError::misfit()) }
    }
}

impl Simulation {
    /// What a simulation of the same experiment needs to go on from here. Where processes share the run and each has a part, the parts are not in it:
    /// [`give_parts`](Self::give_parts) comes before.
    ///
    /// # Errors
    /// An engine of the caller's cannot store what it carries on.
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

    /// A simulation of that experiment that goes on from a snapshot.
    ///
    /// # Errors
    /// The snapshot is of another engine, or its particles cannot be those of the experiment.
    pub fn restore(experiment: &Experiment, snapshot: Snapshot) -> Result<Self, StoreError> {
        snapshot.fits(experiment)?;
        Self::new(experiment, snapshot.particles.clone()).resume(snapshot)
    }

    /// The same for an engine of the caller's: this simulation has its scene and its settings, and takes over all that has
    /// happened.
    ///
    /// # Errors
    /// The snapshot is of another engine.
    pub fn resume(mut self, snapshot: Snapshot) -> Result<Self, StoreError> {
        let Snapshot { particles, record, time, windows, spent, totals, .. } = snapshot;
        let Snapshot { half_kicked, bound, unseen, engine, .. } = snapshot;
        self.engine.restore(&engine)?;
        let by_walls = record.ledger.by_walls();
        let run = Self { particles, record, time, windows, spent, totals, by_walls, ..self };
        Ok(Self { half_kicked, bound, unseen, ..run })
    }
}
