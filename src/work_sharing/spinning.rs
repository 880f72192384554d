//! Keeps the other threads of a run awake between the pieces of work that they share.
//!
//! rayon soon puts a thread to sleep that has nothing to do, and to wake it takes long on a virtual machine. Two
//! threads were 1.4 times as fast as one in a dense gas, and 1.66 times when the others kept looking for work instead
//! (docs/design/islands.md). Results do not depend on it.

use super::IdleThread;
use rayon::{Scope, Yield};
use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    /// True if this thread leads such work or looks for pieces of it.
    static TAKES_PART: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work` on a thread of the pool while its other threads look for pieces of it. A pool has one such work at a
/// time. Otherwise a thread that looks for pieces of one work could delay another, in the middle of which it is.
pub fn keep_workers_spinning<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let over = AtomicBool::new(false);
    rayon::scope(|scope| {
        let _part = SpinningGuard::taken();
        keep_awake(scope, &over);
        // also if the work panics: the scope waits for the threads that look for more of it
        let _over = Over(&over);
        work()
    })
}

/// Signals the end of the work to the threads that look for it.
struct Over<'a>(&'a AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Marks the thread as taking part, as long as this value lives.
struct SpinningGuard;

impl SpinningGuard {
    /// Returns `None` if the thread takes part already.
    fn taken() -> Option<Self> {
        (!TAKES_PART.replace(true)).then_some(Self)
    }
}

impl Drop for SpinningGuard {
    fn drop(&mut self) {
        TAKES_PART.set(false);
    }
}

fn keep_awake<'scope>(scope: &Scope<'scope>, over: &'scope AtomicBool) {
    for _ in 1..rayon::current_num_threads() {
        scope.spawn(move |_| {
            // A thread that takes part may come here while it waits for a piece of work. It must not wait for all of
            // the work.
            if let Some(_part) = SpinningGuard::taken() {
                look_for_work(over);
            }
        });
    }
}

/// Does available work until all is over.
fn look_for_work(over: &AtomicBool) {
    let mut idle = IdleThread::default();
    while !over.load(Ordering::Relaxed) {
        match rayon::yield_now() {
            Some(Yield::Executed) => idle = IdleThread::default(),
            _ => idle.look_again(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::RESTS;
    use super::*;
    use rayon::prelude::*;
    use std::sync::atomic::AtomicUsize;
    use std::time::Duration;

    /// Largest number of pieces of work done at once, on four threads.
    fn at_once(pause: Duration) -> usize {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        let (here, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        pool.install(|| {
            keep_workers_spinning(|| {
                std::thread::sleep(pause);
                (0..64).into_par_iter().with_max_len(1).for_each(|_| {
                    most.fetch_max(here.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                    std::thread::sleep(Duration::from_millis(1));
                    here.fetch_sub(1, Ordering::SeqCst);
                });
            });
        });
        most.into_inner()
    }

    #[test]
    fn all_threads_take_part_at_once_or_after_a_long_rest() {
        assert_eq!(at_once(Duration::ZERO), 4);
        assert_eq!(at_once(100 * RESTS), 4);
    }

    #[test]
    fn work_that_panics_ends_the_search_for_more() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let panics = || pool.install(|| keep_workers_spinning(|| -> usize { panic!("on purpose") }));
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(panics)).is_err());
        assert_eq!(pool.install(|| keep_workers_spinning(|| (0..100usize).into_par_iter().sum::<usize>())), 4950);
    }
}
