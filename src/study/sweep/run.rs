//! Runs of a sweep, several concurrently or one after the other.

use crate::engine::Failure;
use crate::experiment::Experiment;
use crate::output::sweep::{OBSERVABLES, SweepRun};
use crate::statistics::Estimate;
use crate::study::execute::execute_unless;
use crate::study::progress::{Progress, Watch};
use crate::study::ranks::Ranks;
use crate::study::replicas::FROZEN;
use crate::study::run_list::{RunList, ThreadBudget, beside, help};
use crate::study::session::{StudyError, start};
use crate::study::signals::Signals;

/// A run of the sweep.
pub struct SweepJob {
    /// Hash by which the result of the run is known.
    pub identity: String,
    /// Name of the run in messages.
    pub name: String,
    /// Experiment that is run.
    pub experiment: Experiment,
}

/// Resources that the runs of a sweep share.
pub struct SweepResources<'a> {
    /// Number of threads, and of concurrent runs.
    pub share: ThreadBudget,
    /// The processes.
    pub ranks: &'a Ranks,
    /// True to show no progress.
    pub quiet: bool,
}

/// Runs the missing jobs, given by their indices among all. Each result is handed to `finished`, in the order in which
/// runs end. When `signals` say so, the present runs are left at the ends of their windows without a result, and no
/// other run begins.
///
/// # Errors
/// The first error of `finished`; no thread can be started.
pub fn run_all(
    (jobs, missing): (&[SweepJob], &[usize]),
    effort: &SweepResources,
    signals: &Signals,
    mut finished: impl FnMut(&SweepJob, SweepRun) -> Result<(), StudyError>,
) -> Result<(), StudyError> {
    let runs = SweepRuns::new(jobs, signals, effort.quiet);
    beside(&runs, missing, (effort.share, effort.ranks), |place, run| finished(&jobs[place], run))
}

/// Does the work that the lead process of a sweep asks for, until the sweep is over.
///
/// # Errors
/// No thread can be started.
pub fn help_with(jobs: &[SweepJob], share: ThreadBudget, ranks: &Ranks) -> Result<(), StudyError> {
    let signals = Signals::listen()?;
    help(&SweepRuns::new(jobs, &signals, true), share, ranks, &signals)
}

/// Jobs of a sweep that are watched and may be stopped.
struct SweepRuns<'a> {
    jobs: &'a [SweepJob],
    signals: &'a Signals,
    progress: Progress,
}

impl<'a> SweepRuns<'a> {
    fn new(jobs: &'a [SweepJob], signals: &'a Signals, quiet: bool) -> Self {
        Self { jobs, signals, progress: Progress::new(jobs.iter().map(|job| &job.experiment), quiet) }
    }
}

impl RunList for SweepRuns<'_> {
    type Answer = SweepRun;

    fn count(&self) -> usize {
        self.jobs.len()
    }

    fn run(&self, place: usize) -> Option<SweepRun> {
        let stop = || self.signals.say_stop();
        if stop() { None } else { run(&self.jobs[place], self.progress.watch(place), &stop) }
    }

    fn run_for_another(&self, place: usize) -> Result<Option<Vec<u8>>, StudyError> {
        let written = self.run(place).map(|run| serde_json::to_vec(&run)).transpose();
        written.map_err(|why| StudyError::Failed(format!("error: cannot send a result: {why}")))
    }

    fn answer_of_another(&self, place: usize, bytes: &[u8]) -> Result<SweepRun, StudyError> {
        self.progress.ended_elsewhere(place);
        serde_json::from_slice(bytes)
            .map_err(|why| StudyError::Failed(format!("error: cannot read the result of another process: {why}")))
    }

    fn is_elsewhere(&self, place: usize, time: f64) {
        self.progress.is_elsewhere(place, time);
    }

    fn under_way(&self) -> Vec<(usize, f64)> {
        self.progress.under_way()
    }
}

/// Runs one job in the present thread pool; `None` if it is stopped.
fn run(job: &SweepJob, mut watch: Watch, stop: &(dyn Fn() -> bool + Sync)) -> Option<SweepRun> {
    let mut result = SweepRun {
        identity: job.identity.clone(),
        measured: Default::default(),
        failure: None,
        wall_seconds: 0.0,
        threads: rayon::current_num_threads(),
    };
    let start = match start(&job.experiment) {
        Ok(start) => start,
        Err(why) => {
            result.failure = Some(why.to_string().trim_start_matches("error: ").to_owned());
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
        // the scatter within one run tells of other runs only if the run is steady and mixes
        let tells = outcome.steadiness.steady && outcome.places_kept.is_none_or(|kept| kept <= FROZEN);
        let measured = OBSERVABLES.iter().filter_map(|one| {
            let found = (one.of)(&outcome)?;
            let found = if one.is_average && !tells { Estimate::without_error(found.value) } else { found };
            Some((one.key.to_owned(), found))
        });
        result.measured = measured.collect();
    }
    Some(result)
}
