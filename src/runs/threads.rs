//! Threads of a process, and their distribution among concurrent runs.

use super::error::StudyError;
use super::ranks::Ranks;
use crate::cli::Effort;

/// Sets the number of threads of this process: the number that the user has given, else an equal share of the cores for
/// each process on this computer.
pub fn share_threads(effort: &Effort, ranks: &Ranks) -> Result<(), StudyError> {
    if ranks.count() == 1 {
        return use_threads(effort.threads.map(usize::from));
    }
    // the calling thread is reserved for MPI
    let threads = ranks.threads(effort.threads);
    start_threads(threads, rayon::ThreadPoolBuilder::new().num_threads(threads))
}

/// Sets the number of threads of this process, if the user has given it. With one thread, the calling thread does the
/// work itself. Otherwise it would wait for another thread in each window (time between two exchanges with the gas).
/// For a small scene on a busy machine, this waiting would take longer than the work.
pub fn use_threads(threads: Option<usize>) -> Result<(), StudyError> {
    let Some(threads) = threads else { return Ok(()) };
    let mut pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    if threads == 1 {
        pool = pool.use_current_thread();
    }
    start_threads(threads, pool)
}

fn start_threads(threads: usize, pool: rayon::ThreadPoolBuilder) -> Result<(), StudyError> {
    pool.build_global().map_err(|why| {
        StudyError::Input(format!("error: cannot start {threads} threads: {why}\nhelp: lower --threads"))
    })
}

/// Distribution of the threads of a process among runs that are done at the same time.
#[derive(Clone, Copy)]
pub struct ThreadBudget {
    /// Number of threads of the process.
    pub threads: usize,
    /// True if runs are done one after the other, each with all threads. Otherwise several runs are done concurrently,
    /// with equal shares of the threads.
    pub in_turn: bool,
}

impl ThreadBudget {
    /// Number of runs that are done at the same time if there are `count` runs, and number of threads of each of them.
    pub fn of(self, count: usize) -> (usize, usize) {
        let at_once = if self.in_turn { 1 } else { self.threads.min(count).max(1) };
        (at_once, (self.threads / at_once).max(1))
    }
}
