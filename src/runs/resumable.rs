//! Run that can be resumed: its experiment, its initial state, and the identity by which its stored state is found.

use super::error::StudyError;
use crate::checkpoint::{RunIdentity, checksum};
use crate::experiment::{Experiment, Trajectories};
use crate::memory;
use crate::output::{Folder, Trajectory};
use crate::particles::Particles;
use crate::placement::{Start, initial_state};
use std::sync::{Mutex, PoisonError};
use std::thread::Scope;

/// Run of a command that can be resumed after the command was stopped.
pub struct ResumableRun {
    /// Experiment that is run.
    pub experiment: Experiment,
    /// Name of the run and checksums of its data, by which its stored state is found.
    pub identity: RunIdentity,
    /// True if no other run is done at the same time, so that the wall time of this run is meaningful. If this is true
    /// for all runs of a command, all processes share each run.
    pub is_lone: bool,
    /// Trajectory of the run: name of its files, and settings. `None` if no trajectory is written. Only a run that is
    /// done alone has a trajectory.
    pub trajectory: Option<(String, Trajectories)>,
    /// Initial state. `None` if the state is made only when the run begins, or if the run has begun and has taken the
    /// state.
    start: Mutex<Option<Start>>,
}

impl ResumableRun {
    /// Creates the run of an experiment from the initial state `start`.
    ///
    /// # Errors
    /// Returns an error if the experiment cannot be written as JSON.
    pub fn new(experiment: Experiment, start: Start) -> Result<Self, StudyError> {
        let identity = identity(&experiment, start.fingerprint)?;
        Ok(Self { experiment, identity, is_lone: false, trajectory: None, start: Mutex::new(Some(start)) })
    }

    /// Creates a run that is identified by `hash`, a hash of all data on which the run depends. Its initial state is
    /// made when the run begins.
    pub fn known_by(hash: &str, experiment: Experiment) -> Self {
        let identity = RunIdentity::of_hash(hash);
        Self { experiment, identity, is_lone: false, trajectory: None, start: Mutex::default() }
    }

    /// Observer that writes the trajectory of the run into `folder`, with contacts if the case requests the contact
    /// network; `None` if no trajectory is written. The writing thread belongs to `scope`.
    pub fn trajectory<'scope, 'env>(
        &self,
        scope: &'scope Scope<'scope, 'env>,
        folder: &'env Folder,
    ) -> Option<Trajectory<'scope>> {
        let (name, asked) = self.trajectory.as_ref()?;
        let law = self.experiment.law().filter(|_| self.experiment.observe.contact_network);
        Some(Trajectory::new(scope, folder, name, *asked).with_contacts(law))
    }

    /// Marks the run as one during which no other run is done. `trajectory` has the name of the files and the settings
    /// of the trajectory; `None` if no trajectory is written.
    pub fn lone(self, trajectory: Option<(String, Trajectories)>) -> Self {
        Self { is_lone: true, trajectory, ..self }
    }

    /// Initial state of the run. The state is moved out of this `ResumableRun`, so that its memory is free when the run
    /// has ended; a second call makes it again.
    ///
    /// # Errors
    /// Returns an error if the scene is too crowded to start or too large for the memory.
    pub fn start(&self) -> Result<Start, StudyError> {
        let made = self.start.lock().unwrap_or_else(PoisonError::into_inner).take();
        made.map_or_else(|| start(&self.experiment).map(Start::from), Ok)
    }
}

fn identity(experiment: &Experiment, start: u64) -> Result<RunIdentity, StudyError> {
    RunIdentity::new(experiment, start)
        .map_err(|why| StudyError::Failed(format!("error: cannot store the command: {why}")))
}

/// Checksum of a list of runs. It depends on their order.
pub fn mark(runs: &[ResumableRun]) -> u32 {
    mark_of(runs.iter().map(|run| run.identity.checksum()))
}

/// Checksum of a list of experiments. It depends on their order, but not on their initial states.
pub fn mark_of_experiments<'a>(experiments: impl Iterator<Item = &'a Experiment>) -> u32 {
    mark_of(experiments.map(|experiment| identity(experiment, 0).map_or(0, |identity| identity.checksum())))
}

fn mark_of(checksums: impl Iterator<Item = u32>) -> u32 {
    checksum(&checksums.flat_map(u32::to_le_bytes).collect::<Vec<u8>>())
}

/// Makes the initial state of an experiment. Returns an error (wrong input) if the scene is too crowded to start or too
/// large for the memory.
pub fn start(experiment: &Experiment) -> Result<Particles, StudyError> {
    refuse_too_large(experiment)?;
    initial_state(experiment).map_err(|crowded| StudyError::Input(format!("error: {crowded}")))
}

/// Returns an error if there is not enough memory for a run, before any memory is taken.
///
/// # Errors
/// The error is [`StudyError::Input`], with the memory that the run needs and the memory that is free.
pub fn refuse_too_large(experiment: &Experiment) -> Result<(), StudyError> {
    match memory::refusal(experiment) {
        None => Ok(()),
        Some((why, help)) => Err(StudyError::Input(format!("error: {why}\nhelp: {help}"))),
    }
}
