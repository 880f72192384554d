//! Runs of a sweep, several at once or one after the other.

use crate::engine::Failure;
use crate::experiment::Experiment;
use crate::output::sweep::{OBSERVABLES, SweepRun};
use crate::placement::initial_state;
use crate::study::execute::execute_unless;
use crate::study::progress::{Progress, Watch};
use crate::study::session::StudyError;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

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
    /// Threads in all; none: one per core.
    pub threads: Option<usize>,
    /// One run after the other, with all threads; otherwise several at once, with one thread each.
    pub in_turn: bool,
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
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = effort.threads.unwrap_or_else(cores);
    let (workers, each) = if effort.in_turn { (1, threads) } else { (threads.min(jobs.len()), 1) };
    let build = |_| ThreadPoolBuilder::new().num_threads(each).build();
    let pools: Vec<ThreadPool> = (0..workers).map(build).collect::<Result<_, _>>().map_err(|why| {
        StudyError::Input(format!("error: cannot start {threads} threads: {why}\nhelp: lower --threads"))
    })?;
    let progress = Progress::new(jobs.iter().map(|job| &job.experiment), effort.quiet);
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for pool in &pools {
            let (sender, next, progress) = (sender.clone(), &next, &progress);
            scope.spawn(move || {
                while let Some((place, job)) = take(jobs, next).filter(|_| !stop()) {
                    let Some(run) = pool.install(|| run(job, progress.watch(place), stop)) else { break };
                    // nobody listens any more: what is left would be lost
                    if sender.send((place, run)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        receiver.into_iter().try_for_each(|(place, run)| finished(&jobs[place], run))
    })
}

/// The next job that nobody has taken.
fn take<'a>(jobs: &'a [Job], next: &AtomicUsize) -> Option<(usize, &'a Job)> {
    let place = next.fetch_add(1, Ordering::Relaxed);
    jobs.get(place).map(|job| (place, job))
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
