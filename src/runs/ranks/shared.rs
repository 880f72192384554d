//! Communication in a run that all processes share. Only the thread that has started MPI may call MPI. So a second
//! thread does the run, and sends requests for communication to the first thread, the thread of MPI.

use super::Ranks;
use super::link::Link;
use crate::communicator::Communicator;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Message between the thread of the run and the thread of MPI: a request for communication, or its answer.
enum Call {
    Exchange(Vec<Vec<u8>>),
    Broadcast(Vec<u8>),
    Sum(Vec<i64>),
    Largest(Vec<f64>),
}

/// Amount and duration of the communication of one process with the others during a shared run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Traffic {
    /// Number of messages that this process has sent to single other processes.
    pub messages: u64,
    /// [bytes] total size of the messages that this process has sent to single other processes.
    pub bytes: u64,
    /// Number of calls of communication in which all processes took part.
    pub calls: u64,
    /// Wall time spent on communication, including the time spent waiting for other processes.
    pub waited: Duration,
    /// Wall time of the shared run, from its beginning to its end.
    pub whole: Duration,
}

impl std::fmt::Display for Traffic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { messages, bytes, calls, waited, whole } = self;
        let share = 100.0 * waited.as_secs_f64() / whole.as_secs_f64().max(f64::MIN_POSITIVE);
        let size = *bytes as f64 * 1e-6;
        write!(
            f,
            "process 0 sent {messages} messages ({size:.1} MB) in {calls} calls; these, and waiting for the others, took {share:.0} % of \
             the time"
        )
    }
}

/// Connection of the thread of the run to the thread that may call MPI. Each communication becomes a request to the
/// thread of MPI.
struct LineEnd {
    rank: usize,
    size: usize,
    ends: Mutex<(Sender<Call>, Receiver<Call>)>,
}

impl LineEnd {
    /// Sends a request to the thread of MPI and returns the answer; `None` if that thread has closed the connection.
    fn ask(&self, call: Call) -> Option<Call> {
        let ends = self.ends.lock().unwrap_or_else(PoisonError::into_inner);
        ends.0.send(call).ok()?;
        ends.1.recv().ok()
    }
}

impl Communicator for LineEnd {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn exchange(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        match self.ask(Call::Exchange(outgoing)) {
            Some(Call::Exchange(incoming)) => incoming,
            _ => vec![Vec::new(); self.size],
        }
    }

    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8> {
        match self.ask(Call::Broadcast(bytes)) {
            Some(Call::Broadcast(bytes)) => bytes,
            _ => Vec::new(),
        }
    }

    fn sum(&self, numbers: &mut [i64]) {
        if let Some(Call::Sum(sums)) = self.ask(Call::Sum(numbers.to_vec())) {
            numbers.copy_from_slice(&sums);
        }
    }

    fn largest(&self, values: &mut [f64]) {
        if let Some(Call::Largest(largest)) = self.ask(Call::Largest(values.to_vec())) {
            values.copy_from_slice(&largest);
        }
    }
}

fn answer(link: &dyn Link, call: Call) -> Call {
    match call {
        Call::Exchange(outgoing) => Call::Exchange(link.exchange(outgoing)),
        Call::Broadcast(bytes) => Call::Broadcast(link.broadcast(bytes)),
        Call::Sum(mut numbers) => {
            link.sum(&mut numbers);
            Call::Sum(numbers)
        }
        Call::Largest(mut values) => {
            link.largest(&mut values);
            Call::Largest(values)
        }
    }
}

impl Ranks {
    /// Does `work` on a run that all processes share. In each process a second thread does this work, since only the
    /// first thread, which has started MPI, may call MPI. Returns the result of the work, and the amount of
    /// communication.
    pub fn together<T: Send>(&self, work: impl FnOnce(Arc<dyn Communicator>) -> T + Send) -> (T, Traffic) {
        let (asked, calls) = channel();
        let (answers, answered) = channel();
        let (began, mut traffic) = (Instant::now(), Traffic::default());
        let line = LineEnd { rank: self.link.rank(), size: self.count(), ends: Mutex::new((asked, answered)) };
        std::thread::scope(|scope| {
            let run = scope.spawn(move || work(Arc::new(line)));
            while let Ok(call) = calls.recv() {
                if let Call::Exchange(outgoing) = &call {
                    let lengths = outgoing.iter().map(Vec::len).filter(|length| *length > 0);
                    lengths.for_each(|length| {
                        traffic.messages += 1;
                        traffic.bytes += length as u64;
                    });
                }
                let asked = Instant::now();
                let answer = answer(&*self.link, call);
                traffic.calls += 1;
                traffic.waited += asked.elapsed();
                // this cannot fail, because the thread of the run waits for the answer
                let _ = answers.send(answer);
            }
            traffic.whole = began.elapsed();
            (run.join().unwrap_or_else(|why| std::panic::resume_unwind(why)), traffic)
        })
    }
}
