//! Processes that work on one command: this process alone, or those that `mpirun` has started (feature `mpi`). The
//! number of a process is called its rank in MPI.
//!
//! All processes read the same command line and case, and [check](Ranks::agree) that these agree. Process 0, the lead,
//! then does the command. The other processes are helpers. Every process makes the same list of runs by itself. The
//! lead sends indices of this list to the helpers, and the helpers send back the results of the runs. The result of a
//! run does not depend on the process that has done it.

mod link;
#[cfg(feature = "mpi")]
mod mpi;
mod shared;
#[cfg(test)]
mod tests;

use super::error::StudyError;
use super::run_list::POLL_INTERVAL;
use super::terminal::tell;
use crate::output::numbers::counted;
use link::{Link, LoneProcess};
use serde::{Deserialize, Serialize};
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;

/// Processes that work on one command, as seen from one of them. Process 0 is the lead, the others are helpers.
pub struct Ranks {
    link: Box<dyn Link>,
    /// True if the processes have already compared the checksums of their lists of runs.
    agreed: Cell<bool>,
    /// Numbers of the helper processes that are free to begin a run. A helper is listed once for each run that it can
    /// begin.
    free: RefCell<VecDeque<usize>>,
    /// Number of runs that the lead process has given to helper processes, and whose results have not arrived.
    away: Cell<usize>,
    /// Exit code that this helper process has received from the lead process; `None` before the command has ended.
    dismissed: Cell<Option<u8>>,
}

/// Message between the lead process and one of its helper processes.
#[derive(Serialize, Deserialize)]
pub enum Message {
    /// From the lead process to a helper process: do the run with this index in the list of runs.
    Do(usize),
    /// From the lead process to a helper process: take part in the run with this index in the list of runs. All
    /// processes share this run, and it begins now.
    Follow(usize),
    /// From the lead process to a helper process: stop the runs in progress at the ends of their windows (times between
    /// two exchanges with the gas).
    Stop,
    /// From the lead process to a helper process: the command has ended, with this exit code.
    End(u8),
    /// From a helper process to the lead process: the helper can do this number of runs at the same time.
    Free(usize),
    /// From a helper process to the lead process: the run with this index has reached this simulated time [s].
    At(usize, f64),
    /// From a helper process to the lead process: the run with this index is over. The bytes are its result, `None` if
    /// the run was stopped early; an error is the one with which the run failed.
    Done(usize, Result<Option<Vec<u8>>, StudyError>),
    /// From a helper process to the lead process: the helper can do no run, for this reason.
    Failed(String),
    /// From a helper process to the lead process: this is the last message of the helper.
    Gone,
}

/// Result of reading the command and the case in one process. The processes compare these results before they begin.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
enum Found {
    /// The process can begin. The number is a checksum of its work, for example of its list of runs.
    Work(u32),
    /// The process cannot begin, for the reason in the text. The second value is true if the input is wrong.
    Error(String, bool),
}

impl Ranks {
    /// Connects this process with the processes that were started together with it. Without other processes, this
    /// process works alone. If the program was built without MPI, it works alone too, and prints a warning if there are
    /// other processes.
    ///
    /// # Errors
    /// Returns an error if MPI cannot be started.
    pub fn join() -> Result<Self, StudyError> {
        if !link::is_one_of_several() {
            return Ok(Self::alone());
        }
        #[cfg(feature = "mpi")]
        return match mpi::Mpi::join() {
            Some(link) => Ok(Self::with(Box::new(link))),
            None => Err(StudyError::Failed("error: MPI cannot be started: it has been started already".into())),
        };
        #[cfg(not(feature = "mpi"))]
        {
            tell(
                "warning: this is one of several processes that were started together, but the program was built without MPI: each \
                 does all of the work (`cargo install --path . --features mpi` builds it with MPI)",
            );
            Ok(Self::alone())
        }
    }

    /// Creates the `Ranks` of a process that works alone, without a connection to others.
    pub fn alone() -> Self {
        Self::with(Box::new(LoneProcess))
    }

    fn with(link: Box<dyn Link>) -> Self {
        Self {
            link,
            agreed: Cell::new(false),
            free: RefCell::default(),
            away: Cell::new(0),
            dismissed: Cell::new(None),
        }
    }

    /// True if this process is the lead, process 0, which does the command and prints its messages.
    pub fn is_lead(&self) -> bool {
        self.link.rank() == 0
    }

    /// Number of processes that work on the command.
    pub fn count(&self) -> usize {
        self.link.size()
    }

    /// Number of threads of this process: the number `asked` that the user has given, else an equal share of the cores
    /// of this computer.
    pub fn threads(&self, asked: Option<u16>) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        asked.map_or_else(|| (cores() / self.link.on_this_machine()).max(1), usize::from)
    }

    /// Prints that several processes share the runs, if there is more than one process and `quiet` is false.
    pub fn announce(&self, threads: usize, quiet: bool) {
        if self.count() > 1 && !quiet {
            tell(format!("{} processes share the work, {} in this one", self.count(), counted(threads, "thread")));
        }
    }

    /// Does `work` in the lead process alone. All processes must call this function; the helpers get a default value.
    ///
    /// # Errors
    /// Returns the error of the work, or the error of a process that could not begin.
    pub fn by_lead<T: Default>(&self, work: impl FnOnce() -> Result<T, StudyError>) -> Result<T, StudyError> {
        self.agree(Ok(()), |()| 0)?;
        if self.is_lead() { work() } else { Ok(T::default()) }
    }

    /// Compares the work of this process with the work of all other processes before the work begins. `found` is the
    /// work of this process, such as its list of runs, or the reason why the process cannot begin. The function `mark`
    /// computes the checksum of the work. Every process must call this function or [`close`](Self::close).
    ///
    /// # Errors
    /// Returns the error of the first process that has one, in all processes. It also returns an error if the work of
    /// a process differs from that of the lead.
    pub fn agree<T>(&self, found: Result<T, StudyError>, mark: impl FnOnce(&T) -> u32) -> Result<T, StudyError> {
        self.agreed.set(true);
        if self.count() == 1 {
            return found;
        }
        let own = match &found {
            Ok(found) => Found::Work(mark(found)),
            Err(why) => Found::Error(why.to_string(), matches!(why, StudyError::Input(_))),
        };
        let all = self.link.gather(&packed(&own)?);
        let all: Vec<Found> = all.iter().map(|one| unpacked(one)).collect::<Result<_, _>>()?;
        disagreement(&all).map_or(found, Err)
    }

    /// Ends the common work of all processes; `result` is the result of this process. The lead prints the error, if
    /// there is one. All processes return the exit code that the function `code` computes from the result of the lead.
    /// Every process must call this function.
    pub fn close<T>(&self, result: Result<T, StudyError>, code: impl FnOnce(&Result<T, StudyError>) -> u8) -> u8 {
        let result = if self.agreed.get() { result } else { self.agree(result, |_| 0) };
        if !self.is_lead() {
            return self.wait_for_the_end(result.err());
        }
        let code = code(&result);
        let mut left = self.count() - 1;
        (1..=left).for_each(|helper| self.send(helper, &Message::End(code)));
        while left > 0 {
            match self.take() {
                Some((_, Message::Gone)) => left -= 1,
                Some(_) => {}
                None => std::thread::sleep(POLL_INTERVAL),
            }
        }
        if let Err(why) = &result {
            tell(why);
        }
        code
    }

    /// Waits in a helper process until the lead ends the command, and returns the exit code of the lead. `why` is an
    /// error of the helper, which is reported to the lead.
    fn wait_for_the_end(&self, why: Option<StudyError>) -> u8 {
        if let (Some(why), None) = (why, self.dismissed.get()) {
            self.report(&Message::Failed(why.to_string()));
        }
        let code = loop {
            if let Some(code) = self.dismissed.get() {
                break code;
            }
            match self.take() {
                Some((_, Message::End(code))) => self.dismissed(code),
                Some(_) => {}
                None => std::thread::sleep(POLL_INTERVAL),
            }
        };
        self.report(&Message::Gone);
        code
    }

    /// Stores the exit code with which the lead has ended the command. This method is called in a helper process.
    pub fn dismissed(&self, code: u8) {
        self.dismissed.set(Some(code));
    }

    /// Sends the run at `index` to a helper process that is free to begin a run. Returns false if no helper
    /// is free.
    pub fn hand_out(&self, index: usize) -> bool {
        let Some(helper) = self.free.borrow_mut().pop_front() else { return false };
        self.send(helper, &Message::Do(index));
        self.away.set(self.away.get() + 1);
        true
    }

    /// Number of runs that are in progress in helper processes.
    pub fn away(&self) -> usize {
        self.away.get()
    }

    /// Tells all helper processes that the run at `index` begins, which all processes share.
    pub fn call_together(&self, index: usize) {
        (1..self.count()).for_each(|helper| self.send(helper, &Message::Follow(index)));
    }

    /// Tells all helper processes to stop their runs in progress at the ends of their windows (times between two
    /// exchanges with the gas).
    pub fn stop_helpers(&self) {
        (1..self.count()).for_each(|helper| self.send(helper, &Message::Stop));
    }

    /// Next message that another process has sent to this one; `None` if no message has arrived. A message from a
    /// helper process also updates the list of free helpers and the number of runs that helpers are doing.
    pub fn heard(&self) -> Option<Message> {
        let (from, message) = self.take()?;
        match &message {
            Message::Free(count) => self.free.borrow_mut().extend(std::iter::repeat_n(from, *count)),
            Message::Done(..) => {
                self.away.set(self.away.get() - 1);
                self.free.borrow_mut().push_back(from);
            }
            _ => {}
        }
        Some(message)
    }

    /// Sends a message from this process to the lead process.
    pub fn report(&self, message: &Message) {
        self.send(0, message);
    }

    fn send(&self, to: usize, message: &Message) {
        // a `Message` can always be serialised, so no error is possible
        if let Ok(bytes) = packed(message) {
            self.link.send(to, &bytes);
        }
    }

    fn take(&self) -> Option<(usize, Message)> {
        loop {
            let (from, bytes) = self.link.take()?;
            // bytes that are no message come from a process that runs another program; `agree` has already detected
            // such a process
            if let Ok(message) = unpacked(&bytes) {
                return Some((from, message));
            }
        }
    }
}

fn packed<T: Serialize>(value: &T) -> Result<Vec<u8>, StudyError> {
    postcard::to_stdvec(value).map_err(unfit)
}

fn unpacked<T: for<'a> Deserialize<'a>>(bytes: &[u8]) -> Result<T, StudyError> {
    postcard::from_bytes(bytes).map_err(unfit)
}

fn unfit(why: postcard::Error) -> StudyError {
    StudyError::Failed(format!("error: a message between processes cannot be read: {why}"))
}

/// Error with the reason why the processes cannot begin together; `None` if they can. `all` has the result of each
/// process, in the order of the numbers of the processes.
fn disagreement(all: &[Found]) -> Option<StudyError> {
    let error = all.iter().enumerate().find_map(|(rank, found)| match found {
        Found::Error(why, input) => Some((rank, why, *input)),
        Found::Work(_) => None,
    });
    if let Some((rank, why, input)) = error {
        let alike = all.iter().all(|found| matches!(found, Found::Error(other, _) if other == why));
        let whose = if alike {
            String::new()
        } else {
            format!("\nhelp: process {rank} of {} has found this; all of them must see the same files", all.len())
        };
        let words = format!("{why}{whose}");
        return Some(if input { StudyError::Input(words) } else { StudyError::Failed(words) });
    }
    let (lead, helpers) = all.split_first()?;
    let other = helpers.iter().position(|found| found != lead)? + 1;
    Some(StudyError::Input(format!(
        "error: process {other} of {} has read another case or command than process 0\n\
         help: start all with the same command, where all see the same files and the same program",
        all.len()
    )))
}
