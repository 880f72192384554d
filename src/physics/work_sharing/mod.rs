//! Work sharing among the threads of a run: each thread takes one piece of work after another until no piece is left.
//!
//! A run alternates between dozens of shared loops, each of some tenths of a millisecond. A thread that starts a loop
//! of this module works on pieces too, and then waits for the other threads without sleeping. Loops of the library
//! rayon put a waiting thread to sleep, and waking it takes long on a virtual machine (docs/design/islands.md). The
//! result of a piece does not depend on the thread, so results are equal for any number of threads.

mod spinning;

pub use spinning::keep_workers_spinning;

use rayon::Yield;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Number of searches for work after which an idle thread rests. So many searches take about 2 ms if no other program
/// uses the processor. This time is longer than the pause between two shared loops of an engine, but short compared
/// with the times in which one thread works alone. The searches are counted, because engines do not read the time.
const LOOKS: u32 = 5000;

/// Pause of an idle thread before each further search for work, once [`LOOKS`] searches have found none.
const RESTS: Duration = Duration::from_micros(200);

/// Calls `work` on every piece, on several threads of the pool, and returns when all pieces are done.
pub fn for_each<T: Send>(
    pieces: impl DoubleEndedIterator<Item = T> + ExactSizeIterator + Send,
    work: impl Fn(T) + Sync,
) {
    for_each_with(pieces, || (), |(), piece| work(piece));
}

/// Calls `work` on every piece, on several threads of the pool. Each thread has its own scratch memory, which `own`
/// makes.
pub fn for_each_with<T: Send, M>(
    pieces: impl DoubleEndedIterator<Item = T> + ExactSizeIterator + Send,
    own: impl Fn() -> M + Sync,
    work: impl Fn(&mut M, T) + Sync,
) {
    let helpers = rayon::current_num_threads().min(pieces.len()).saturating_sub(1);
    let pieces = Mutex::new(pieces);
    // rayon passes on a panic in a piece; the remaining pieces are then not needed
    let next = |back: bool| {
        let mut pieces = pieces.lock().unwrap_or_else(PoisonError::into_inner);
        if back { pieces.next_back() } else { pieces.next() }
    };
    on_threads(helpers, &|back| {
        let mut memory = own();
        while let Some(piece) = next(back) {
            work(&mut memory, piece);
        }
    });
}

/// Calls `do_pieces` on this thread and on `helpers` other threads. The argument of `do_pieces` is true on the other
/// threads, which take pieces from the end of the list. So a thread is likely to get again the pieces of the previous
/// loop, which are still in the cache of its processor.
///
/// The function takes a trait object, because compiling the calls of rayon anew for each loop would take long. For the
/// same reason a loop without helpers also calls this function: the body of the loop is then compiled only once.
fn on_threads(helpers: usize, do_pieces: &(dyn Fn(bool) + Sync)) {
    if helpers == 0 {
        return do_pieces(false);
    }
    let busy = AtomicUsize::new(helpers);
    rayon::scope(|scope| {
        for _ in 0..helpers {
            scope.spawn(|_| {
                let _done = CompletionSignal(&busy);
                do_pieces(true);
            });
        }
        do_pieces(false);
        wait_for(&busy);
    });
}

/// Returns the results of `work` for all pieces, in the order of the pieces.
pub fn map<T: Send, R: Send>(
    pieces: impl DoubleEndedIterator<Item = T> + ExactSizeIterator + Send,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    map_with(pieces, || (), |(), piece| work(piece))
}

/// Returns the results of `work` for all pieces, in the order of the pieces. Each thread has its own scratch memory,
/// which `own` makes.
pub fn map_with<T: Send, R: Send, M>(
    pieces: impl DoubleEndedIterator<Item = T> + ExactSizeIterator + Send,
    own: impl Fn() -> M + Sync,
    work: impl Fn(&mut M, T) -> R + Sync,
) -> Vec<R> {
    let mut results: Vec<Option<R>> = Vec::new();
    results.resize_with(pieces.len(), || None);
    for_each_with(pieces.zip(results.iter_mut()), own, |memory, (piece, result)| *result = Some(work(memory, piece)));
    results.into_iter().flatten().collect()
}

/// Guard of a thread that works on a shared loop. When it is dropped, also after a panic, the number of busy threads
/// decreases by one.
struct CompletionSignal<'a>(&'a AtomicUsize);

impl Drop for CompletionSignal<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Release);
    }
}

/// Waits until `busy`, the number of other threads that still work on the shared loop, is zero. Meanwhile this thread
/// does other available work of the pool.
fn wait_for(busy: &AtomicUsize) {
    let mut idle = IdleThread::default();
    while busy.load(Ordering::Acquire) > 0 {
        match rayon::yield_now() {
            Some(Yield::Executed) => idle = IdleThread::default(),
            _ => idle.look_again(),
        }
    }
}

/// Counter of the searches of a thread that has no work.
#[derive(Default)]
struct IdleThread {
    /// Number of searches since the thread last had work.
    looks: u32,
}

impl IdleThread {
    /// Waits before this thread searches for work again, so that other programs can use the processor. After [`LOOKS`]
    /// searches without work, the pause is [`RESTS`].
    fn look_again(&mut self) {
        self.looks = self.looks.saturating_add(1);
        if self.looks < LOOKS { std::thread::yield_now() } else { std::thread::sleep(RESTS) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
    }

    #[test]
    fn every_piece_is_done_once_and_what_comes_of_it_stands_at_its_place() {
        for threads in [1, 2, 5] {
            for count in [0, 1, 2, 3, 100] {
                assert_eq!(on(threads, || map(0..count, |k| 3 * k)), (0..count).map(|k| 3 * k).collect::<Vec<_>>());
                let mut numbers: Vec<usize> = (0..count).collect();
                on(threads, || for_each(numbers.chunks_mut(7), |some| some.iter_mut().for_each(|number| *number += 1)));
                assert!(numbers.iter().enumerate().all(|(k, number)| *number == k + 1), "{threads} {count}");
            }
        }
    }

    #[test]
    fn all_threads_take_part_and_none_has_the_memory_of_another() {
        let barrier = std::sync::Barrier::new(3);
        let made = AtomicUsize::new(0);
        let own = || made.fetch_add(1, Ordering::Relaxed);
        // each piece waits until the two other pieces have begun, so a single thread would never end
        let who = on(3, || map_with(0..3, own, |own, _| (barrier.wait(), *own).1));
        assert_eq!(made.into_inner(), 3);
        assert_eq!(who.iter().collect::<std::collections::BTreeSet<_>>().len(), 3, "{who:?}");
    }

    #[test]
    fn pieces_may_share_work_of_their_own() {
        let sum = |k: usize| map(0..50, |j| k * j).into_iter().sum::<usize>();
        assert_eq!(on(3, || keep_workers_spinning(|| map(0..40, sum))), (0..40).map(|k| k * 1225).collect::<Vec<_>>());
    }

    #[test]
    fn a_piece_that_panics_is_told_and_leaves_nobody_waiting() {
        // the panic occurs first in the thread that begins at the front, then in the other thread
        for wrong in [0, 1] {
            let barrier = std::sync::Barrier::new(2);
            let piece = |k: usize| assert!((barrier.wait(), k).1 != wrong, "on purpose");
            assert!(
                std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| on(2, || for_each(0..2, piece)))).is_err()
            );
        }
    }
}
