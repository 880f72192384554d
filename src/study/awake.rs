//! Keeps the threads of a run awake between the pieces of work that they share.
//!
//! A window is made of dozens of pieces of work that threads share, each of some tenths of a millisecond, with what one thread does alone between them. rayon soon puts a thread to
//! sleep that has found nothing to do, and to wake it takes long where the machine is a virtual one: two threads were 1.4 times as fast as one in a dense gas, and are 1.66 times as
//! fast now that the others keep looking for work instead (docs/architecture.md, "Islands"). Results do not depend on it.

use rayon::{Scope, Yield};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// For so long a thread keeps looking: more than there is between two pieces of work in any engine that shares its work, and little where one thread works alone for long.
const LOOKS: Duration = Duration::from_millis(2);

/// After that it looks again after so long, each time.
const RESTS: Duration = Duration::from_micros(200);

/// Runs `work` on a thread of the pool while its other threads look for pieces of it. A pool has one such work at a time: a thread that looks for the pieces of one
/// would keep another, which it is in the middle of, waiting.
pub fn awake<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let over = AtomicBool::new(false);
    rayon::scope(|scope| {
        keep_awake(scope, &over);
        // also if the work panics: the scope waits for those who look for more of it
        let _over = Over(&over);
        work()
    })
}

/// Tells those who look for work that it is over.
struct Over<'a>(&'a AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

fn keep_awake<'scope>(scope: &Scope<'scope>, over: &'scope AtomicBool) {
    let own = rayon::current_thread_index();
    for _ in 1..rayon::current_num_threads() {
        scope.spawn(move |_| {
            // the thread that works may come by here while it waits for a piece of work
            if rayon::current_thread_index() != own {
                look_for_work(over);
            }
        });
    }
}

/// Does what there is to do, until it is over.
fn look_for_work(over: &AtomicBool) {
    let mut last = Instant::now();
    while !over.load(Ordering::Relaxed) {
        match rayon::yield_now() {
            Some(Yield::Executed) => last = Instant::now(),
            // whoever else wants the processor gets it
            _ if last.elapsed() < LOOKS => std::thread::yield_now(),
            _ => std::thread::sleep(RESTS),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;
    use std::sync::atomic::AtomicUsize;

    /// Pieces of work, of which so many are done at once, on four threads.
    fn at_once(pause: Duration) -> usize {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        let (here, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        pool.install(|| {
            awake(|| {
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
        assert_eq!(at_once(10 * LOOKS), 4);
    }

    #[test]
    fn work_that_panics_ends_the_search_for_more() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let panics = || pool.install(|| awake(|| -> usize { panic!("on purpose") }));
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(panics)).is_err());
        assert_eq!(pool.install(|| awake(|| (0..100usize).into_par_iter().sum::<usize>())), 4950);
    }
}
