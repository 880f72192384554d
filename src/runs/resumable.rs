//! Run that can be resumed: its experiment, its initial state, and the identity by which its stored state is found.

use super::error::StudyError;
use crate::checkpoint::{RunIdentity, checksum};
use crate::experiment::{Experiment, Trajectories};
use crate::memory;
use crate::particles::Particles;
use crate::placement::{Start, initial_state};
use std::sync::{Mutex, PoisonError};

/// Run that can be resumed.
pub struct ResumableRun {
    /// Experiment that is run.
    pub experiment: Experiment,
    /// Identity of the run.
    pub identity: RunIdentity,
    /// True if no other run goes on at the same time, so that its time is its own. All processes share such a run if
    /// the command has no others.
    pub is_lone: bool,
    /// Trajectory that is written, with the name of its files; only a lone run has one.
    pub trajectory: Option<(String, Trajectories)>,
    /// Initial state, until the run begins.
    start: Mutex<Option<Start>>,
}

impl ResumableRun {
    /// Run of that experiment from that start.
    ///
    /// # Errors
    /// The experiment cannot be written as JSON.
    pub fn new(experiment: Experiment, start: Start) -> Result<Self, StudyError> {
        let identity = identity(&experiment, start.fingerprint)?;
        Ok(Self { experiment, identity, is_lone: false, trajectory: None, start: Mutex::new(Some(start)) })
    }

    /// Run that is known by a hash of everything that it depends on. Its initial state is made when it begins.
    pub fn known_by(hash: &str, experiment: Experiment) -> Self {
        let identity = RunIdentity::of_hash(hash);
        Self { experiment, identity, is_lone: false, trajectory: None, start: Mutex::default() }
    }

    /// This run as one that goes on alone, and whose trajectory is written if there is one.
    pub fn lone(self, trajectory: Option<(String, Trajectories)>) -> Self {
        Self { is_lone: true, trajectory, ..self }
    }

    /// Initial state, which is taken out, so that its memory is free once the run is over.
    ///
    /// # Errors
    /// A scene too crowded to start.
    pub fn start(&self) -> Result<Start, StudyError> {
        let made = self.start.lock().unwrap_or_else(PoisonError::into_inner).take();
        made.map_or_else(|| start(&self.experiment).map(Start::from), Ok)
    }
}

fn identity(experiment: &Experiment, start: u64) -> Result<RunIdentity, StudyError> {
    RunIdentity::new(experiment, start)
        .map_err(|why| StudyError::Failed(format!("error: cannot store the command: {why}")))
}

/// A checksum of runs in their order.
pub fn mark(runs: &[ResumableRun]) -> u32 {
    mark_of(runs.iter().map(|run| run.identity.checksum()))
}

/// A checksum of experiments in their order, independent of their starts.
pub fn mark_of_experiments<'a>(experiments: impl Iterator<Item = &'a Experiment>) -> u32 {
    mark_of(experiments.map(|experiment| identity(experiment, 0).map_or(0, |identity| identity.checksum())))
}

fn mark_of(checksums: impl Iterator<Item = u32>) -> u32 {
    checksum(&checksums.flat_map(u32::to_le_bytes).collect::<Vec<u8>>())
}

/// The initial state of one variant; a scene too crowded to start is bad input.
pub fn start(experiment: &Experiment) -> Result<Particles, StudyError> {
    refuse_too_large(experiment)?;
    initial_state(experiment).map_err(|crowded| StudyError::Input(format!("error: {crowded}")))
}

/// Refuses a run for which there is not enough memory, before any of it is taken.
///
/// # Errors
/// [`StudyError::Input`], with the memory that the run takes and the memory that there is.
pub fn refuse_too_large(experiment: &Experiment) -> Result<(), StudyError> {
    match memory::refusal(experiment) {
        None => Ok(()),
        Some((why, help)) => Err(StudyError::Input(format!("error: {why}\nhelp: {help}"))),
    }
}
