//! Checkpoints: files from which a stopped or killed command continues.
//!
//! While `run`, `compare`, `sensitivity` and `sweep` work, their folder of results has a subfolder [`checkpoint`](crate::output::CHECKPOINT)
//! with
//!
//! * `command`: the command line and the identity of its runs, from which `diptych resume` starts it again
//!   ([`StoredCommand`]);
//! * `a` and `b`: the last two states of the present run, two generations. The next state replaces the older file. It
//!   is written under another name and then renamed, so that at every instant one file is complete. Runs side by side
//!   have `a-…` and `b-…` each;
//! * `a-part-0`, …: the data of each process that shares the run, if the run is cut into domains. `a` then holds all
//!   other data, and is written last;
//! * `done-…`: the end of each finished run of the command, which is then not run again; of a sweep the measured values
//!   of each finished run.
//!
//! Each file names the program that wrote it and ends with a checksum (`envelope`). The subfolder is removed when all
//! results are written; that of a sweep stays, so that further values need no run twice.

mod command;
mod envelope;
mod store;

pub use command::{RunIdentity, StoredCommand, checksum};
pub use envelope::{Unreadable, open, seal};
pub use store::{Newest, Store, StoredRun};
