//! State of a simulation between two windows (times between two exchanges with the gas), as a value from which another
//! simulation can continue.

use super::totals::SimulationTotals;
use super::{Simulation, SimulationTimes, ThroughFlow};
use crate::communicator::Communicator;
use crate::experiment::Experiment;
use crate::fluid::LoadedFlow;
use crate::particles::Particles;
use crate::predict::energy::Bound;
use crate::record::Record;
use crate::stored::{StoreError, Stored};
use crate::walls::ServoState;
use serde::{Deserialize, Serialize};

/// All data that a simulation needs to continue after a window (time between two exchanges with the gas). A simulation
/// of the same experiment continues from a snapshot with identical bits. `docs/design/runs.md` lists the contents.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Snapshot {
    /// The particles, in the order in which the simulation stores them; empty if the state is divided into parts.
    pub particles: Particles,
    /// Number of parts of the state, which are stored separately from the snapshot; 0 if the snapshot contains the
    /// whole state.
    pub parts: usize,
    /// Collisions and other records since the start.
    pub record: Record,
    /// [s] simulated time of the snapshot.
    pub time: f64,
    /// Number of windows (times between two exchanges with the gas) completed since the start of the run.
    pub windows: u64,
    /// Wall-clock times spent so far in the engine, in changes of velocity between windows, and in observers.
    pub spent: SimulationTimes,
    /// Number, mean radius, mass and momentum of the particles of all processes.
    totals: SimulationTotals,
    /// True if the change of velocity by drag after the latest window has been applied completely, so that velocities
    /// and positions belong to one time. False if velocities still lack the change by drag in half a window.
    half_kicked: bool,
    /// Limit of the growth of the energy by errors of the time steps of soft spheres. It depends on the initial state.
    /// `None` if there is no such limit, for example because the model has no soft contacts.
    bound: Option<Bound>,
    /// [J] elastic energy of the overlaps at the start; `None` after the first window (time between two exchanges with
    /// the gas).
    unseen: Option<f64>,
    /// Gas flow that the particles change; `None` if the particles do not change the gas.
    loaded_flow: Option<Box<LoadedFlow>>,
    /// Particles that have come in and left; `None` in a scene without inlets and outlets.
    through_flow: Option<Box<ThroughFlow>>,
    /// States of the servo walls (which move to keep the pressure on them), in the order of the walls.
    servo: Vec<ServoState>,
    /// State of the engine, as bytes.
    engine: Stored,
}

impl Snapshot {
    /// Checks that all data of the particles are complete, and that the experiment has their species.
    ///
    /// # Errors
    /// A quantity is not stored for every particle, or the experiment lacks a species of the particles.
    pub fn fits(&self, experiment: &Experiment) -> Result<(), StoreError> {
        let (particles, kinds) = (&self.particles, experiment.scene.species.len());
        let known = particles.species.iter().all(|kind| usize::from(*kind) < kinds);
        if known && particles.is_whole(particles.len()) { Ok(()) } else { Err(StoreError::misfit()) }
    }
}

impl Simulation {
    /// Creates a snapshot from which a simulation of the same experiment can continue. If each process has a part of
    /// the particles, the snapshot does not contain the particles. In this case call [`give_parts`](Self::give_parts)
    /// first.
    ///
    /// # Errors
    /// An engine of the calling program cannot store its state.
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
            loaded_flow: self.loaded_flow.clone(),
            through_flow: self.through_flow.clone(),
            servo: self.servo_states(),
            engine: self.engine.stored()?,
        })
    }

    /// Creates a simulation of an experiment that continues from a snapshot.
    ///
    /// # Errors
    /// The snapshot was taken with another engine, or its particles do not fit the experiment.
    pub fn restore(experiment: &Experiment, snapshot: Snapshot) -> Result<Self, StoreError> {
        snapshot.fits(experiment)?;
        Self::new(experiment, snapshot.particles.clone()).resume(snapshot)
    }

    /// Continues from a snapshot with the engine of this simulation, which the calling program may have supplied. The
    /// settings and the shapes of the scene do not change. The particles, the records, the gas flow and the places of
    /// moving walls become those of the snapshot.
    ///
    /// # Errors
    /// The snapshot was taken with another engine.
    pub fn resume(mut self, snapshot: Snapshot) -> Result<Self, StoreError> {
        let Snapshot { particles, record, time, windows, spent, totals, .. } = snapshot;
        let Snapshot { half_kicked, bound, unseen, loaded_flow, through_flow, servo, engine, .. } = snapshot;
        self.engine.restore(&engine)?;
        self.take_gas(loaded_flow);
        let by_walls = record.ledger.by_walls();
        let mut run = Self { particles, record, time, windows, spent, totals, by_walls, ..self };
        run.set_servo_states(&servo);
        run.scene.move_to(time);
        let bound = bound.map(|bound| bound.completed(run.bound.take()));
        Ok(Self { half_kicked, bound, unseen, through_flow, ..run })
    }
}
