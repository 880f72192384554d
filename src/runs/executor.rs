//! Executor of the runs of a command. Runs are done one at a time or concurrently, by the threads of this process and
//! by other processes. A stored run continues from its stored state, and a run that has ended is not repeated. The lead
//! process distributes the runs among the other processes, the helpers. An observer is a measurement during a run.

use super::checkpointer::Checkpointer;
use super::error::StudyError;
use super::execute::{SharedRun, execute_with_checkpoints, follow};
use super::progress::Progress;
use super::ranks::Ranks;
use super::resumable::{ResumableRun, mark};
use super::run_list::{RunList, distribute, help};
use super::settings::CommandSettings;
use super::terminal::{conclude, tell, warn};
use super::threads::ThreadBudget;
use crate::case::{Case, Checked};
use crate::engine::Failure;
use crate::observe::Observer;
use crate::outcome::Outcome;
use crate::output::{Folder, OutputError, Trajectory};
use crate::particles::Particles;
use std::fmt::Display;
use std::marker::PhantomData;
use std::path::Path;
use std::rc::Rc;

/// Result that a command computes from a run, such as an outcome or a row of a table.
pub trait RunResult: Send + Sized {
    /// Computes the result of a run that has ended, or of a run that could not begin.
    ///
    /// # Errors
    /// Returns an error if the run could not begin, and the command does not accept this as a result.
    fn of(run: &ResumableRun, outcome: Result<Outcome, StudyError>) -> Result<Self, StudyError>;

    /// Result as bytes, which are sent to the lead process. `None` if the final state of the run and the data of its
    /// observers (measurements) are sent instead.
    fn to_bytes(&self) -> Option<Vec<u8>>;

    /// Result from the bytes that another process has sent. `None` if the bytes are the final state of the run and the
    /// data of its observers (measurements).
    fn from_bytes(bytes: &[u8]) -> Option<Self>;

    /// True if the run has been simulated to its end.
    fn is_complete(&self) -> bool;
}

impl RunResult for Outcome {
    fn of(_: &ResumableRun, outcome: Result<Outcome, StudyError>) -> Result<Self, StudyError> {
        outcome
    }

    fn to_bytes(&self) -> Option<Vec<u8>> {
        None
    }

    fn from_bytes(_: &[u8]) -> Option<Self> {
        None
    }

    fn is_complete(&self) -> bool {
        self.failure.is_none()
    }
}

/// Executor of the runs of a command. It exists in the lead process.
pub struct Executor<'a> {
    /// Folder to which the results of the command are written.
    pub folder: Rc<Folder>,
    /// Checkpointer that stores the states of the runs.
    pub checkpointer: Checkpointer,
    /// Runs of the command, in the order of their indices.
    pub runs: Vec<ResumableRun>,
    progress: Progress,
    threads: ThreadBudget,
    ranks: &'a Ranks,
    /// True if the command prints nothing.
    pub quiet: bool,
}

impl<'a> Executor<'a> {
    /// Opens the folder for the results of `runs` and finds their stored states. All processes must pass the same list
    /// of runs. In a helper process, the call does runs for the lead process until the command ends, and then returns
    /// `None`. `R` is the type of the results of runs that are done [concurrently](Self::concurrently).
    ///
    /// # Errors
    /// Returns an error if the list of runs could not be made or differs between processes, or if the system refuses
    /// the folder or a thread.
    pub fn begin<R: RunResult>(
        settings: &CommandSettings,
        case: &Case,
        checked: &[Checked],
        runs: Result<Vec<ResumableRun>, StudyError>,
        ranks: &'a Ranks,
    ) -> Result<Option<Self>, StudyError> {
        let runs = ranks.agree(runs, |runs| mark(runs))?;
        let threads = ThreadBudget { threads: ranks.threads(settings.threads), in_turn: settings.in_turn };
        let shown = |quiet| Progress::new(runs.iter().map(|run| &run.experiment), quiet);
        if !ranks.is_lead() {
            let (checkpointer, folder) = (Checkpointer::of_helper(settings)?, Folder::of_another(&settings.folder));
            let list = ResumableRuns::<R> {
                runs: &runs,
                folder: &folder,
                checkpointer: &checkpointer,
                progress: &shown(true),
                result: PhantomData,
            };
            return help(&list, threads, ranks, checkpointer.signals()).map(|()| None);
        }
        let folder = settings.open_folder()?;
        ranks.announce(threads.threads, settings.quiet);
        warn(checked, settings.quiet);
        let checkpointer = Checkpointer::new(settings, &folder, case, &runs)?;
        let progress = shown(settings.quiet);
        let folder = Rc::new(folder);
        Ok(Some(Self { folder, checkpointer, runs, progress, threads, ranks, quiet: settings.quiet }))
    }

    /// Prints a line for the user, unless the command prints nothing.
    pub fn say(&self, line: impl Display) {
        if !self.quiet {
            tell(line);
        }
    }

    /// Adds a run that depends on the results of earlier runs, and returns the index of the new run. The run must be
    /// done [alone](Self::alone), since it is missing in the lists of the helper processes.
    pub fn add(&mut self, run: ResumableRun) -> usize {
        self.progress.add(&run.experiment);
        self.runs.push(run);
        self.runs.len() - 1
    }

    /// Does or resumes the run at `index`, with the observers (measurements) `others` in addition to the standard
    /// ones. If a trajectory is requested and cannot be written, the run fails. Returns the outcome and the final
    /// state of the particles in the order of ids. With several processes, the final state is returned only if
    /// `gives_end` is true.
    ///
    /// # Errors
    /// Returns an error if the run cannot begin, if its state cannot be stored, or if the stored state belongs to
    /// another run.
    pub fn alone(
        &mut self,
        index: usize,
        mut others: Vec<&mut dyn Observer>,
        gives_end: bool,
    ) -> Result<(Outcome, Particles), StudyError> {
        let Self { folder, checkpointer, runs, progress, ranks, quiet, .. } = self;
        let (run, mut watch) = (&runs[index], progress.watch(index));
        // several processes share the run if there are no runs that they could do concurrently
        let is_shared = ranks.count() > 1 && runs.iter().all(|run| run.is_lone);
        let shared = is_shared.then_some(SharedRun { index, ranks, quiet: *quiet, gives_end });
        std::thread::scope(|scope| {
            let mut trajectory = run.trajectory(scope, folder);
            // in the other processes of a shared run the trajectory is the first additional observer, so the trajectory
            // must be the first one in this process as well
            let first = trajectory.as_mut().map(|trajectory| trajectory as &mut dyn Observer);
            let mut observers: Vec<&mut dyn Observer> = first.into_iter().collect();
            observers.push(&mut watch);
            observers.extend(others.iter_mut().map(|other| &mut **other as &mut dyn Observer));
            let (mut outcome, end) = execute_with_checkpoints(run, &mut observers, checkpointer, shared)?;
            let written = trajectory.map_or(Ok(()), Trajectory::written);
            // without the folder there is no stored state from which the run can be resumed
            let is_gone = matches!(written, Err(OutputError::Gone { .. }));
            if let Err(why) = written {
                let time = outcome.simulated_seconds;
                outcome.failure.get_or_insert(Failure::Unwritten { time, why: why.to_string() });
            }
            if let (Some(failure @ Failure::Unwritten { .. }), false) = (&outcome.failure, is_gone) {
                checkpointer.stop_unwritten(failure);
            }
            Ok((outcome, end))
        })
    }

    /// Stored result of the run at `index`; `None` if the command is neither resumed nor typed again, or if no result
    /// of this run was stored before.
    pub fn stored<R: RunResult>(&self, index: usize) -> Option<R> {
        R::from_bytes(&self.checkpointer.result(&self.runs[index].identity)?)
    }

    /// Does the runs at `indices` concurrently, in all processes. Each process does at most as many runs at a time as
    /// it has threads. The results do not depend on the numbers of processes and threads. The function `finished` gets
    /// the index and the result of each run, in the order in which runs end. If the user stops the command, the states
    /// of incomplete runs are stored, and `finished` is not called for them.
    ///
    /// # Errors
    /// Returns the first error of `finished`. Other errors are that a run cannot begin, that its stored state belongs
    /// to another run, that a result cannot be stored, or that no thread can be started.
    pub fn concurrently<R: RunResult>(
        &self,
        indices: &[usize],
        mut finished: impl FnMut(usize, R) -> Result<(), StudyError>,
    ) -> Result<(), StudyError> {
        let Self { folder, checkpointer, runs, progress, .. } = self;
        let list = ResumableRuns::<R> { runs, folder, checkpointer, progress, result: PhantomData };
        distribute(&list, indices, self.threads, self.ranks, |index, result: Result<R, StudyError>| {
            let result = result?;
            if let Some(bytes) = result.to_bytes() {
                checkpointer.store_result(&runs[index].identity, &bytes)?;
            }
            finished(index, result)
        })
    }

    /// Ends the command after all results have been written: prints the final sentences, and removes the stored states.
    ///
    /// # Errors
    /// Returns an error if a stored state cannot be removed.
    pub fn finish(self, sentences: &[String], report: &Path) -> Result<(), StudyError> {
        self.conclude(sentences, report);
        Ok(self.checkpointer.done()?)
    }

    /// Prints the final sentences and the path of the report, unless the command prints nothing.
    pub fn conclude(&self, sentences: &[String], report: &Path) {
        if !self.quiet {
            conclude(sentences, "Report", report);
        }
    }
}

/// List of the runs of a command, in the form in which several processes share it.
struct ResumableRuns<'a, R> {
    runs: &'a [ResumableRun],
    folder: &'a Folder,
    checkpointer: &'a Checkpointer,
    progress: &'a Progress,
    result: PhantomData<fn() -> R>,
}

impl<R: RunResult> ResumableRuns<'_, R> {
    /// Does the run at `index`, using the checkpointer `own`. `None` if the run was stopped before it had
    /// ended.
    fn run_with(&self, index: usize, own: &mut Checkpointer) -> Result<Option<R>, StudyError> {
        if own.is_stopping() {
            return Ok(None);
        }
        let run = &self.runs[index];
        let over = execute_with_checkpoints(run, &mut [&mut self.progress.watch(index)], own, None);
        if own.is_stopped() { Ok(None) } else { R::of(run, over.map(|(outcome, _)| outcome)).map(Some) }
    }
}

impl<R: RunResult> RunList for ResumableRuns<'_, R> {
    type Answer = R;

    fn count(&self) -> usize {
        self.runs.iter().filter(|run| !run.is_lone).count()
    }

    fn run(&self, index: usize) -> Result<Option<R>, StudyError> {
        self.run_with(index, &mut self.checkpointer.for_run(&self.runs[index].identity))
    }

    fn run_for_another(&self, index: usize) -> Result<Option<Vec<u8>>, StudyError> {
        let mut own = self.checkpointer.for_run(&self.runs[index].identity);
        let result = self.run_with(index, &mut own)?;
        Ok(result.map(|result| result.to_bytes().unwrap_or_else(|| own.into_end())))
    }

    fn follow(&self, index: usize, ranks: &Ranks) {
        let run = &self.runs[index];
        std::thread::scope(|scope| {
            let mut trajectory = run.trajectory(scope, self.folder);
            let trajectory = trajectory.as_mut().map(|trajectory| trajectory as &mut dyn Observer);
            follow(run, &mut trajectory.into_iter().collect::<Vec<_>>(), ranks);
        });
    }

    fn answer_of_another(&self, index: usize, bytes: &[u8]) -> Result<R, StudyError> {
        if let Some(result) = R::from_bytes(bytes) {
            self.progress.ended_elsewhere(index, result.is_complete());
            return Ok(result);
        }
        // the run is not simulated again: the outcome is computed from the received final data, as for a run that had
        // ended before the command was resumed
        let run = &self.runs[index];
        let mut own = self.checkpointer.for_run(&run.identity);
        own.receive(&run.identity, bytes)?;
        let over = execute_with_checkpoints(run, &mut [&mut self.progress.watch(index)], &mut own, None);
        R::of(run, over.map(|(outcome, _)| outcome))
    }

    fn is_elsewhere(&self, index: usize, time: f64) {
        self.progress.is_elsewhere(index, time);
    }

    fn under_way(&self) -> Vec<(usize, f64)> {
        self.progress.under_way()
    }
}
