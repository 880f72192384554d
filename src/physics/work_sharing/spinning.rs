//! Keeps the threads of a run awake between the pieces of work that they share.
//!
//! The library rayon soon puts an idle thread to sleep, and waking it takes long on a virtual machine. In a dense gas,
//! two threads were 1.4 times as fast as one, and 1.66 times as fast if idle threads searched for work instead of
//! sleeping (docs/design/islands.md). Results do not depend on the search.

use super::IdleThread;
use rayon::{Scope, Yield};
use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    /// True if this thread runs the work given to [`keep_workers_spinning`], or searches for pieces of this work.
    static TAKES_PART: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work` on a thread of the pool, while the other threads search for pieces of this work. A call of this function
/// within such a piece does not start another search, because a searching thread could delay the piece.
pub fn keep_workers_spinning<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let over = AtomicBool::new(false);
    rayon::scope(|scope| {
        let _part = SpinningGuard::taken();
        keep_awake(scope, &over);
        // the flag is also set after a panic, because the scope waits for the searching threads
        let _over = Over(&over);
        work()
    })
}

/// Guard that sets a flag when it is dropped. The flag ends the search of the other threads for pieces of work.
struct Over<'a>(&'a AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Guard that marks the current thread as taking part in the work of [`keep_workers_spinning`]. The mark is removed
/// when the guard is dropped.
struct SpinningGuard;

impl SpinningGuard {
    /// Marks the current thread as taking part in the work. Returns `None` if the thread was marked before.
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
            // a marked thread may get this task while it waits for a piece; it must not wait here until all work is
            // over
            if let Some(_part) = SpinningGuard::taken() {
                look_for_work(over);
            }
        });
    }
}

/// Makes this thread do pieces of work of the pool until the flag `over` is set.
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

    /// Largest number of pieces of work that were done at the same time by four threads, after a pause without work.
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
