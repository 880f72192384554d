//! Concurrent runs whose states are stored while they are under way: replicas, and the runs of a study of sensitivity.

use super::checkpointer::{Checkpointer, runs};
use super::error::StudyError;
use super::execute::{execute_kept, follow};
use super::progress::Progress;
use super::ranks::Ranks;
use super::run_list::{RunList, ThreadBudget, help};
use super::session::{file_names, refuse_too_large};
use crate::checkpoint::{RunIdentity, checksum};
use crate::communicator::Communicator;
use crate::experiment::{Experiment, Trajectories};
use crate::observe::Observer;
use crate::outcome::Outcome;
use crate::output::{Folder, Trajectory};
use crate::placement::{Crowded, Start};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// A run that can be resumed.
pub struct ResumableRun {
    /// Experiment that is run.
    pub experiment: Experiment,
    /// Initial state.
    pub start: Start,
    /// Identity of the run.
    pub run: RunIdentity,
}

impl ResumableRun {
    /// Run of that experiment from that start.
    ///
    /// # Errors
    /// The experiment cannot be written as JSON.
    pub fn new(experiment: Experiment, start: Start) -> Result<Self, StudyError> {
        let run = runs(std::iter::once((&experiment, start.fingerprint)))?.swap_remove(0);
        Ok(Self { experiment, start, run })
    }
}

/// Initial states of runs, one of each experiment. Where all processes share the runs, each process makes its part of a
/// start; they must have agreed on the experiments before.
///
/// # Errors
/// A scene too crowded to start.
pub fn starts(experiments: &[&Experiment], replicas: u16, ranks: &Ranks) -> Result<Vec<Start>, StudyError> {
    if ranks.count() == 1 {
        experiments.iter().try_for_each(|experiment| refuse_too_large(experiment))?;
    }
    let made: Result<Vec<Start>, Crowded> = if ranks.count() == 1 || replicas > 1 {
        experiments.iter().map(|experiment| Start::whole(experiment)).collect()
    } else {
        let parts = |communicator: Arc<dyn Communicator>| {
            experiments.iter().map(|experiment| Start::part(experiment, &*communicator)).collect()
        };
        ranks.together(parts).0
    };
    made.map_err(|crowded| StudyError::Input(format!("error: {crowded}")))
}

/// A checksum of experiments in their order, independent of their starts.
pub fn mark_of<'a>(experiments: impl Iterator<Item = &'a Experiment>) -> u32 {
    runs(experiments.map(|experiment| (experiment, 0))).map_or(0, |runs| mark(runs.iter()))
}

/// A checksum of runs in their order.
pub fn mark<'a>(runs: impl Iterator<Item = &'a RunIdentity>) -> u32 {
    let all: Vec<u8> = runs.flat_map(|run| run.checksum().to_le_bytes()).collect();
    checksum(&all)
}

/// Trajectories of runs that all processes share. Each process writes the pieces of its own particles.
pub struct Pieces {
    /// The folder of results, which process 0 has made.
    pub folder: Folder,
    /// Output that the case asks for.
    pub asked: Trajectories,
    /// Names of the files, one for each run.
    pub names: Vec<String>,
}

/// Does the work that the lead process asks for, until the command is over. That is the share of this process in the
/// `shared` runs of all processes, and whole `runs`. The `trajectories` of shared runs are written into that folder.
///
/// # Errors
/// No thread can be started.
pub fn help_with(
    (shared, runs): (Vec<ResumableRun>, Vec<&ResumableRun>),
    trajectories: Option<(PathBuf, Trajectories)>,
    keeper: &Checkpointer,
    share: ThreadBudget,
    ranks: &Ranks,
) -> Result<(), StudyError> {
    let progress = Progress::new(runs.iter().map(|one| &one.experiment), true);
    let watched = (0..runs.len()).collect();
    let pieces = trajectories.map(|(place, asked)| Pieces {
        folder: Folder::of_another(place),
        asked,
        names: file_names(shared.iter().map(|one| one.experiment.name.as_str())),
    });
    let shared = Mutex::new(shared.into_iter().map(Some).collect());
    help(&ResumableRuns { shared, pieces, runs, watched, keeper, progress: &progress }, share, ranks, keeper.signals())
}

/// A list of runs that can be resumed.
pub struct ResumableRuns<'a> {
    /// Runs that all processes share. Each is taken out when it begins, which frees the memory of its start.
    pub shared: Mutex<Vec<Option<ResumableRun>>>,
    /// Output that this process writes for the shared runs.
    pub pieces: Option<Pieces>,
    /// Runs that are done by one process each.
    pub runs: Vec<&'a ResumableRun>,
    /// Index of each run in the progress.
    pub watched: Vec<usize>,
    /// Checkpointer that stores the runs; in a resumed command it has their stored states.
    pub keeper: &'a Checkpointer,
    /// Display of the progress.
    pub progress: &'a Progress,
}

impl ResumableRuns<'_> {
    /// Does one run with that checkpointer; `None` if it was stopped.
    fn run_with(&self, place: usize, own: &mut Checkpointer) -> Result<Option<Outcome>, StudyError> {
        if own.is_stopping() {
            return Ok(None);
        }
        let ResumableRun { experiment, start, .. } = self.runs[place];
        let mut watch = self.progress.watch(self.watched[place]);
        let (outcome, _) = execute_kept(experiment, start.clone(), &mut [&mut watch], own)?;
        Ok((!own.is_stopped()).then_some(outcome))
    }
}

impl RunList for ResumableRuns<'_> {
    type Answer = Result<Outcome, StudyError>;

    fn count(&self) -> usize {
        self.runs.len()
    }

    fn run(&self, place: usize) -> Option<Self::Answer> {
        self.run_with(place, &mut self.keeper.beside(&self.runs[place].run)).transpose()
    }

    fn run_for_another(&self, place: usize) -> Result<Option<Vec<u8>>, StudyError> {
        let mut own = self.keeper.beside(&self.runs[place].run);
        Ok(self.run_with(place, &mut own)?.map(|_| own.into_end()))
    }

    fn follow(&self, place: usize, ranks: &Ranks) {
        let run = self.shared.lock().ok().and_then(|mut shared| shared.get_mut(place)?.take());
        let Some(ResumableRun { experiment, start, .. }) = run else { return };
        std::thread::scope(|scope| {
            let pieces = self.pieces.as_ref();
            let mut trajectory =
                pieces.map(|pieces| Trajectory::new(scope, &pieces.folder, &pieces.names[place], pieces.asked));
            let trajectory = trajectory.as_mut().map(|trajectory| trajectory as &mut dyn Observer);
            follow(&experiment, start, &mut trajectory.into_iter().collect::<Vec<_>>(), ranks);
        });
    }

    fn answer_of_another(&self, place: usize, bytes: &[u8]) -> Result<Self::Answer, StudyError> {
        // the outcome follows from the stored end, as for a run that was over when a command is resumed
        let ResumableRun { experiment, start, run } = self.runs[place];
        let mut own = self.keeper.beside(run);
        own.receive(run, bytes)?;
        let mut watch = self.progress.watch(self.watched[place]);
        Ok(execute_kept(experiment, start.clone(), &mut [&mut watch], &mut own).map(|(outcome, _)| outcome))
    }

    fn is_elsewhere(&self, place: usize, time: f64) {
        self.progress.is_elsewhere(self.watched[place], time);
    }

    fn under_way(&self) -> Vec<(usize, f64)> {
        let place = |watched: usize| self.watched.iter().position(|one| *one == watched);
        self.progress.under_way().into_iter().filter_map(|(watched, time)| Some((place(watched)?, time))).collect()
    }
}
