//! Runs beside each other, each on threads of its own.

use super::session::StudyError;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

/// How runs share the machine.
#[derive(Clone, Copy)]
pub struct Share {
    /// Threads in all; none: one per core.
    pub threads: Option<usize>,
    /// One run after the other, with all threads; otherwise several at once, with one thread each.
    pub in_turn: bool,
}

/// Does jobs `0..count`, each with `run` in a pool of threads that is its own meanwhile, and hands each result to `finished`, in
/// the order in which they end. `None` of a run means that no other one is to be begun.
///
/// # Errors
/// The first error of `finished`; no thread can be started.
pub fn beside<R: Send>(
    count: usize,
    share: Share,
    run: impl Fn(usize) -> Option<R> + Sync,
    mut finished: impl FnMut(usize, R) -> Result<(), StudyError>,
) -> Result<(), StudyError> {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = share.threads.unwrap_or_else(cores);
    let (workers, each) = if share.in_turn { (1, threads) } else { (threads.min(count), 1) };
    let build = |_| ThreadPoolBuilder::new().num_threads(each).build();
    let pools: Vec<ThreadPool> = (0..workers).map(build).collect::<Result<_, _>>().map_err(|why| {
        StudyError::Input(format!("error: cannot start {threads} threads: {why}\nhelp: lower --threads"))
    })?;
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for pool in &pools {
            let (sender, next, run) = (sender.clone(), &next, &run);
            scope.spawn(move || {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    if place >= count {
                        break;
                    }
                    let Some(result) = pool.install(|| run(place)) else { break };
                    // nobody listens any more: what is left would be lost
                    if sender.send((place, result)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        receiver.into_iter().try_for_each(|(place, result)| finished(place, result))
    })
}
