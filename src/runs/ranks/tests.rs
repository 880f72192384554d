//! Tests of several processes, which the threads of one test simulate.

use super::link::Link;
use super::*;
use crate::runs::run_list::{RunList, distribute, help};
use crate::runs::signals::Signals;
use crate::runs::threads::ThreadBudget;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Barrier, Mutex};
use std::thread::scope;
use std::time::Duration;

/// Number of the sender of a message, and the bytes of the message.
type Letter = (usize, Vec<u8>);

/// Connection of one of several threads that simulate processes.
struct Thread {
    rank: usize,
    others: Vec<Sender<Letter>>,
    inbox: Receiver<Letter>,
    shared: Arc<(Barrier, Mutex<Vec<Vec<u8>>>)>,
}

impl Link for Thread {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.others.len()
    }

    fn on_this_machine(&self) -> usize {
        self.size()
    }

    fn send(&self, to: usize, bytes: &[u8]) {
        let _ = self.others[to].send((self.rank, bytes.to_vec()));
    }

    fn take(&self) -> Option<Letter> {
        self.inbox.try_recv().ok()
    }

    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>> {
        let (barrier, all) = &*self.shared;
        all.lock().unwrap()[self.rank] = own.to_vec();
        barrier.wait();
        let all = all.lock().unwrap().clone();
        barrier.wait();
        all
    }

    fn exchange(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        let all = self.gather(&postcard::to_stdvec(&outgoing).unwrap());
        let of = |bytes: &Vec<u8>| postcard::from_bytes::<Vec<Vec<u8>>>(bytes).unwrap().swap_remove(self.rank);
        all.iter().map(of).collect()
    }

    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8> {
        self.gather(&bytes).swap_remove(0)
    }

    fn sum(&self, numbers: &mut [i64]) {
        let all = self.gather(&postcard::to_stdvec(&numbers.to_vec()).unwrap());
        let all: Vec<Vec<i64>> = all.iter().map(|bytes| postcard::from_bytes(bytes).unwrap()).collect();
        numbers.iter_mut().enumerate().for_each(|(k, number)| *number = all.iter().map(|one| one[k]).sum());
    }

    fn largest(&self, values: &mut [f64]) {
        let all = self.gather(&postcard::to_stdvec(&values.to_vec()).unwrap());
        let all: Vec<Vec<f64>> = all.iter().map(|bytes| postcard::from_bytes(bytes).unwrap()).collect();
        let most = |k: usize| all.iter().map(|one| one[k]).fold(f64::NEG_INFINITY, f64::max);
        values.iter_mut().enumerate().for_each(|(k, value)| *value = most(k));
    }
}

/// Does `work` in each of `count` simulated processes, and returns their exit codes.
fn processes(count: usize, work: impl Fn(&Ranks) -> Result<u8, StudyError> + Sync) -> Vec<u8> {
    let (others, inboxes): (Vec<_>, Vec<_>) = (0..count).map(|_| channel()).unzip();
    let shared = Arc::new((Barrier::new(count), Mutex::new(vec![Vec::new(); count])));
    let code = |result: &Result<u8, StudyError>| match result {
        Ok(code) => *code,
        Err(StudyError::Input(_)) => 2,
        Err(_) => 1,
    };
    scope(|scope| {
        let each = inboxes.into_iter().enumerate().map(|(rank, inbox)| {
            let (others, shared, work) = (others.clone(), Arc::clone(&shared), &work);
            scope.spawn(move || {
                let ranks = Ranks::with(Box::new(Thread { rank, others, inbox, shared }));
                let result = work(&ranks);
                ranks.close(result, code)
            })
        });
        let all: Vec<_> = each.collect();
        all.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

/// List of test runs; the result of each run is the square of its index in the list.
struct Squares {
    /// Number of results that came from other processes.
    by_others: AtomicUsize,
    /// `Some` if each run that is done for another process must fail; `None` if these runs succeed.
    unknown: Option<usize>,
    /// Index of the run that is stopped before its end; `None` if all runs end.
    stopped_at: Option<usize>,
    /// Index of the run that panics; `None` if no run does.
    panics_at: Option<usize>,
    /// Number of runs that this process has begun, for itself or for another process.
    left: AtomicUsize,
}

impl Squares {
    fn new() -> Self {
        Self {
            by_others: AtomicUsize::new(0),
            unknown: None,
            stopped_at: None,
            panics_at: None,
            left: AtomicUsize::new(0),
        }
    }
}

const COUNT: usize = 60;

impl RunList for Squares {
    type Answer = usize;

    fn count(&self) -> usize {
        COUNT
    }

    fn run(&self, index: usize) -> Result<Option<usize>, StudyError> {
        std::thread::sleep(Duration::from_millis(2));
        assert_ne!(self.panics_at, Some(index), "the panic of this test");
        self.left.fetch_add(1, Ordering::Relaxed);
        Ok((self.stopped_at != Some(index)).then_some(index * index))
    }

    fn run_for_another(&self, index: usize) -> Result<Option<Vec<u8>>, StudyError> {
        if self.unknown.is_some() {
            return Err(StudyError::Failed("error: it broke".into()));
        }
        Ok(self.run(index)?.map(|square| square.to_le_bytes().to_vec()))
    }

    fn answer_of_another(&self, _index: usize, bytes: &[u8]) -> Result<usize, StudyError> {
        self.by_others.fetch_add(1, Ordering::Relaxed);
        Ok(usize::from_le_bytes(bytes.try_into().unwrap()))
    }

    fn is_elsewhere(&self, _index: usize, time: f64) {
        assert_eq!(time, 0.0);
    }

    fn under_way(&self) -> Vec<(usize, f64)> {
        Vec::new()
    }
}

const SHARE: ThreadBudget = ThreadBudget { threads: 2, in_turn: false };

#[test]
fn every_run_is_done_once_and_by_all() {
    let found = Mutex::new((Vec::new(), 0));
    let codes = processes(3, |ranks| {
        let squares = Squares::new();
        ranks.agree(Ok(()), |()| 7)?;
        if !ranks.is_lead() {
            return help(&squares, SHARE, ranks, &Signals::listen()?).map(|()| 9);
        }
        let mut all = vec![0; COUNT];
        // the runs are done in two calls, one after the other, as in `compare`
        let indices: Vec<usize> = (0..COUNT).collect();
        for part in [&indices[..20], &indices[20..]] {
            distribute(&squares, part, SHARE, ranks, |index, square| {
                all[index] += square?;
                Ok(())
            })?;
        }
        *found.lock().unwrap() = (all, squares.by_others.load(Ordering::Relaxed));
        Ok(3)
    });
    // all processes end with the exit code of the lead
    assert_eq!(codes, [3, 3, 3]);
    let (all, by_others) = found.into_inner().unwrap();
    assert!(all.iter().enumerate().all(|(index, square)| *square == index * index), "{all:?}");
    assert!(by_others > COUNT / 4 && by_others < COUNT, "{by_others} by others");
}

#[test]
fn a_helper_that_fails_ends_all_and_one_that_is_stopped_stops_all() {
    let one = |unknown, stopped_at| {
        processes(2, |ranks| {
            let squares = Squares { unknown, stopped_at, ..Squares::new() };
            ranks.agree(Ok(()), |()| 7)?;
            if !ranks.is_lead() {
                return help(&squares, SHARE, ranks, &Signals::listen()?).map(|()| 9);
            }
            let (indices, mut over): (Vec<usize>, _) = ((0..COUNT).collect(), 0);
            distribute(&squares, &indices, SHARE, ranks, |_, square| {
                over += 1;
                square.map(drop)
            })?;
            // each of four threads may be doing a run, and may receive a further run before the message to stop arrives
            Ok(if over < COUNT / 2 { 130 } else { 3 })
        })
    };
    assert_eq!(one(Some(3), None), [1, 1]);
    assert_eq!(one(None, Some(5)), [130, 130]);
}

/// A run panics while another thread waits for further runs. The list must end with the panic, and not wait.
#[test]
fn a_run_that_panics_ends_the_list() {
    let (said, heard) = channel();
    std::thread::spawn(move || {
        let squares = Squares { panics_at: Some(0), ..Squares::new() };
        let all = || distribute(&squares, &[0, 1, 2], SHARE, &Ranks::alone(), |_, square| square.map(drop));
        let _ = said.send(catch_unwind(AssertUnwindSafe(all)).is_err());
    });
    assert_eq!(heard.recv_timeout(Duration::from_secs(20)), Ok(true));
}

#[test]
fn processes_that_found_something_else_do_not_begin() {
    let other = Mutex::new(Vec::new());
    let both = |work: &(dyn Fn(usize) -> Result<u32, StudyError> + Sync)| {
        processes(3, |ranks| {
            let own = work(ranks.link.rank());
            let agreed = ranks.agree(own, |mark| *mark);
            if let (Err(why), true) = (&agreed, ranks.is_lead()) {
                other.lock().unwrap().push(why.to_string());
            }
            agreed.map(|_| 0)
        })
    };
    assert_eq!(both(&|_| Ok(1)), [0, 0, 0]);
    assert_eq!(both(&|rank| Ok(u32::from(rank == 2))), [2, 2, 2]);
    let missing = |rank| if rank == 1 { Err(StudyError::Input("error: no file".into())) } else { Ok(1) };
    assert_eq!(both(&missing), [2, 2, 2]);
    assert_eq!(both(&|_| Err(StudyError::Failed("error: all".into()))), [1, 1, 1]);
    let told = other.into_inner().unwrap();
    assert!(told[0].contains("process 2 of 3 has read another case"), "{told:?}");
    assert!(told[1].starts_with("error: no file\n") && told[1].contains("process 1 of 3"), "{told:?}");
    assert_eq!(told[2], "error: all");
}
