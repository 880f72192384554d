//! Runs of a sweep, several at once or one after the other.

use crate::engine::Failure;
use crate::experiment::Experiment;
use crate::output::sweep::{OBSERVABLES, SweepRun};
use crate::placement::initial_state;
use crate::study::beside::{Share, beside};
use crate::study::execute::execute_unless;
use crate::study::progress::{Progress, Watch};
use crate::study::session::StudyError;

/// A run that is missing.
pub struct Job {
    /// By which its result is known.
    pub identity: String,
    /// What messages call it.
    pub name: String,
    /// What is run.
    pub experiment: Experiment,
}

/// How the runs of a sweep share the machine.
pub struct Effort {
    /// Threads, and how many runs at once.
    pub share: Share,
    /// No progress.
    pub quiet: bool,
}

/// Runs all jobs and hands each result to `finished`, in the order in which they end. When `stop` says so, the runs under way are left
/// at the ends of their windows without a result, and no other one is begun.
///
/// # Errors
/// The first error of `finished`; no thread can be started.
pub fn run_all(
    jobs: &[Job],
    effort: &Effort,
    stop: &(dyn Fn() -> bool + Sync),
    mut finished: impl FnMut(&Job, SweepRun) -> Result<(), StudyError>,
) -> Result<(), StudyError> {
    let progress = Progress::new(jobs.iter().map(|job| &job.experiment), effort.quiet);
    let one = |place: usize| if stop() { None } else { run(&jobs[place], progress.watch(place), stop) };
    beside(jobs.len(), effort.share, one, |place, run| finished(&jobs[place], run))
}

/// Runs one job in the pool it is in; nothing if it is stopped.
fn run(job: &Job, mut watch: Watch, stop: &(dyn Fn() -> bool + Sync)) -> Option<SweepRun> {
    let mut result = SweepRun {
        identity: job.identity.clone(),
        measured: Default::default(),
        failure: None,
        wall_seconds: 0.0,
        threads: rayon::current_num_threads(),
    };
    let start = match initial_state(&job.experiment) {
        Ok(start) => start,
        Err(crowded) => {
            result.failure = Some(crowded.to_string());
            return Some(result);
        }
    };
    let (outcome, _) = execute_unless(&job.experiment, start, &mut [&mut watch], stop);
    if matches!(outcome.failure, Some(Failure::Stopped { .. })) {
        return None;
    }
    result.wall_seconds = outcome.timing.wall_seconds;
    result.failure = outcome.failure.as_ref().map(ToString::to_string);
    if result.failure.is_none() {
        let measured = OBSERVABLES.iter().filter_map(|one| Some((one.key.to_owned(), (one.of)(&outcome)?)));
        result.measured = measured.collect();
    }
    Some(result)
}
