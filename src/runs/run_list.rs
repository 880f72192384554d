//! Concurrent runs, each on its own threads, in this process or in other processes. The lead process distributes the
//! runs; the other processes, which do runs for it, are the helpers.

use super::error::StudyError;
use super::ranks::{Message, Ranks};
use super::signals::Signals;
use super::threads::ThreadBudget;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::scope;
use std::time::{Duration, Instant};

/// Wall time between two checks for messages from other processes. The waiting functions of MPI would occupy a core.
pub const POLL_INTERVAL: Duration = Duration::from_millis(1);

/// Wall time between two messages of a helper process about the progress of its runs.
const REPORT_INTERVAL: Duration = Duration::from_secs(1);

/// List of runs that may be done in any order, and by any process that has the same list.
pub trait RunList: Sync {
    /// Result of one run of the list.
    type Answer: Send;

    /// Number of runs of the list that may be done concurrently.
    fn count(&self) -> usize;

    /// Does the run at `index` in the thread pool from which this method is called. `None` if the run was
    /// stopped before it had ended; no other run may begin in this case.
    ///
    /// # Errors
    /// Returns an error if the run cannot be done.
    fn run(&self, index: usize) -> Result<Option<Self::Answer>, StudyError>;

    /// Does the run at `index`, and returns its result as bytes for another process. `None` if the run was
    /// stopped before it had ended.
    ///
    /// # Errors
    /// Returns an error if the run cannot be done, or if its result cannot be serialised.
    fn run_for_another(&self, index: usize) -> Result<Option<Vec<u8>>, StudyError>;

    /// Takes part in the run at `index`, which all processes share.
    fn follow(&self, _index: usize, _ranks: &Ranks) {}

    /// Result of the run at `index`, made from the bytes that another process has sent.
    ///
    /// # Errors
    /// Returns an error if the bytes do not belong to this run.
    fn answer_of_another(&self, index: usize, bytes: &[u8]) -> Result<Self::Answer, StudyError>;

    /// Records that another process does the run at `index`, and has reached the simulated time `time` [s]
    /// in it.
    fn is_elsewhere(&self, index: usize, time: f64);

    /// Indices of the runs in progress in this process, each with the simulated time [s] that the run has reached.
    fn under_way(&self) -> Vec<(usize, f64)>;
}

/// Does the runs at `indices`, in this process and in helper processes. The function `finished` gets the index and the
/// result of each run, in the order in which runs end. After a run was stopped before its end, no further run begins,
/// and stopped runs give no result.
///
/// # Errors
/// Returns the first error of `finished`, the error of a helper that can do no run, or an error if no thread can be
/// started.
pub fn distribute<R: RunList>(
    runs: &R,
    indices: &[usize],
    share: ThreadBudget,
    ranks: &Ranks,
    mut finished: impl FnMut(usize, Result<R::Answer, StudyError>) -> Result<(), StudyError>,
) -> Result<(), StudyError> {
    let pools = pools(share, indices.len())?;
    scope(|scope| {
        let (orders, answers) = crew(scope, &pools, |index| runs.run(index));
        let (mut left, mut here, mut stopped) = (indices, 0, false);
        loop {
            while let Some((next, rest)) = left.split_first().filter(|_| !stopped && here < pools.len()) {
                // sending cannot fail, because the worker threads receive indices until this end of the channel is
                // dropped
                let _ = orders.send(*next);
                (left, here) = (rest, here + 1);
            }
            while let Some((next, rest)) = left.split_first().filter(|(next, _)| !stopped && ranks.hand_out(**next)) {
                runs.is_elsewhere(*next, 0.0);
                left = rest;
            }
            if here + ranks.away() == 0 {
                return Ok(());
            }
            let (index, answer) = match wait(&answers, ranks) {
                Some(Heard::Here(index, answer)) => {
                    here -= 1;
                    (index, answer)
                }
                Some(Heard::There(Message::Done(index, answer))) => {
                    let made = |bytes: Vec<u8>| runs.answer_of_another(index, &bytes);
                    (index, answer.and_then(|bytes| bytes.map(made).transpose()))
                }
                Some(Heard::There(Message::At(index, time))) => {
                    runs.is_elsewhere(index, time);
                    continue;
                }
                Some(Heard::There(Message::Failed(why))) => return Err(StudyError::Failed(why)),
                Some(Heard::There(_) | Heard::Nothing) => continue,
                None => return Err(StudyError::Failed("error: a run ended without a result".into())),
            };
            match answer.transpose() {
                Some(answer) => finished(index, answer)?,
                None if stopped => {}
                None => {
                    stopped = true;
                    ranks.stop_helpers();
                }
            }
        }
    })
}

/// Does runs in a helper process until the command has ended. The lead process sends the indices of the runs. `signals`
/// stops the runs in progress when the lead requests a stop or ends the command.
///
/// # Errors
/// Returns an error if no thread can be started.
pub fn help<R: RunList>(runs: &R, share: ThreadBudget, ranks: &Ranks, signals: &Signals) -> Result<(), StudyError> {
    let pools = pools(share, runs.count())?;
    scope(|scope| {
        let (orders, answers) = crew(scope, &pools, |index| runs.run_for_another(index));
        ranks.report(&Message::Free(pools.len()));
        let mut told = Instant::now();
        loop {
            match wait(&answers, ranks) {
                Some(Heard::Here(index, answer)) => ranks.report(&Message::Done(index, answer)),
                Some(Heard::There(Message::Do(index))) => drop(orders.send(index)),
                Some(Heard::There(Message::Follow(index))) => runs.follow(index, ranks),
                Some(Heard::There(Message::Stop)) => signals.raise(),
                Some(Heard::There(Message::End(code))) => {
                    ranks.dismissed(code);
                    return signals.raise();
                }
                Some(Heard::There(_) | Heard::Nothing) => {}
                None => return,
            }
            if told.elapsed() >= REPORT_INTERVAL {
                runs.under_way().into_iter().for_each(|(index, time)| ranks.report(&Message::At(index, time)));
                told = Instant::now();
            }
        }
    });
    Ok(())
}

/// Thread pools of this process, one for each run that it does at the same time. `count` is the number of all runs.
fn pools(share: ThreadBudget, count: usize) -> Result<Vec<ThreadPool>, StudyError> {
    let (at_once, threads) = share.of(count);
    let build = |_| ThreadPoolBuilder::new().num_threads(threads).build();
    (0..at_once).map(build).collect::<Result<_, _>>().map_err(|why| {
        StudyError::Input(format!("error: cannot start {} threads: {why}\nhelp: lower --threads", share.threads))
    })
}

/// Starts a worker thread for each pool. The threads do the runs whose indices are sent through the returned sender,
/// and end when the sender is dropped. The returned receiver gets the index and the result of each run, or `None` if a
/// run has panicked.
fn crew<'scope, 'env, A: Send + 'scope>(
    scope: &'scope std::thread::Scope<'scope, 'env>,
    pools: &'env [ThreadPool],
    run: impl Fn(usize) -> A + Sync + Send + Clone + 'scope,
) -> (Sender<usize>, Receiver<Option<(usize, A)>>) {
    let (orders, indices) = channel();
    let (answered, answers) = channel();
    let indices = std::sync::Arc::new(Mutex::new(indices));
    for pool in pools {
        let (indices, answered, run) = (indices.clone(), answered.clone(), run.clone());
        scope.spawn(move || {
            loop {
                let index = indices.lock().unwrap_or_else(PoisonError::into_inner).recv();
                let Ok(index) = index else { break };
                // the other threads wait for further runs, so the receiver would not notice that this thread has ended
                let answer = catch_unwind(AssertUnwindSafe(|| pool.install(|| run(index)))).unwrap_or_else(|panic| {
                    let _ = answered.send(None);
                    resume_unwind(panic)
                });
                // sending fails if the receiver is gone; the results of further runs would then be lost
                if answered.send(Some((index, answer))).is_err() {
                    break;
                }
            }
        });
    }
    (orders, answers)
}

/// Event for which a process waits, such as the end of a run.
enum Heard<A> {
    /// A run has ended in this process. The values are its index and its result.
    Here(usize, A),
    /// A message of another process has arrived.
    There(Message),
    /// Nothing has happened during the longest waiting time, `REPORT_INTERVAL`.
    Nothing,
}

/// Waits for the end of a run in this process, or for a message from another process. With several processes, the
/// function waits at most [`REPORT_INTERVAL`]. `None` if a run has panicked.
fn wait<A>(answers: &Receiver<Option<(usize, A)>>, ranks: &Ranks) -> Option<Heard<A>> {
    if ranks.count() == 1 {
        return answers.recv().ok().flatten().map(|(index, answer)| Heard::Here(index, answer));
    }
    let began = Instant::now();
    while began.elapsed() < REPORT_INTERVAL {
        if let Some(message) = ranks.heard() {
            return Some(Heard::There(message));
        }
        match answers.recv_timeout(POLL_INTERVAL) {
            Ok(ended) => return ended.map(|(index, answer)| Heard::Here(index, answer)),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return None,
        }
    }
    Some(Heard::Nothing)
}
