//! Checkpoints: files from which a command goes on that was stopped, or that was killed.
//!
//! While `run` and `compare` are at work their folder of results has a subfolder [`checkpoint`](crate::output::CHECKPOINT) with
//!
//! * `command`: what was typed and what it ran on, from which `diptych resume` starts it again ([`StoredCommand`]);
//! * `a` and `b`: the last two states of the run under way, two generations. The older file is replaced by the next
//!   state, written aside and renamed, so that at every instant there is a whole one; runs that go on beside each other have
//!   `a-…` and `b-…` each;
//! * `a-part-0`, …: what each of the processes that share the run has, where it is cut into domains; `a` then has all else, and
//!   is written last;
//! * `done-…`: the end of each run of the command that is over, which is then not run again.
//!
//! Each file says which program wrote it and ends with a checksum (`envelope`). The subfolder goes when all results are written.

mod command;
mod envelope;
mod store;

pub use command::{RunIdentity, StoredCommand, checksum};
pub use envelope::{Unreadable, open, seal};
pub use store::{Newest, Store, StoredRun};
