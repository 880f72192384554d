//! Checkpoints: files from which a stopped or killed command can be continued.
//!
//! During `run`, `compare`, `sensitivity`, `needs` and `sweep`, the folder of results has a subfolder
//! [`checkpoint`](crate::output::CHECKPOINT) with these files:
//!
//! * `command`: the command line and the identities of its runs, from which `diptych resume` starts the command again
//!   ([`StoredCommand`]);
//! * `a` and `b`: the two newest stored states of the present run, called generations. A new state is written under
//!   another name. It then replaces the older file by renaming, so that at every instant one file is complete. If
//!   several runs are done at the same time, each has separate files `a-…` and `b-…`;
//! * `a-part-0`, …: the data of each process, if several processes share the run. The file `a` then contains all
//!   other data and is written last;
//! * `done-…`: the final state of each finished run and the data of its observers (measurements during the run), so
//!   that this run is not repeated. For a sweep this file contains the measured values of the run.
//!
//! Each file contains the version of the program that wrote it, and ends with a checksum (`envelope`). The subfolder is
//! removed when all results are written. The subfolder of a sweep remains, so that a later sweep with further values
//! repeats no run.

mod command;
mod envelope;
mod store;

pub use command::{RunIdentity, StoredCommand, checksum};
pub use envelope::{Unreadable, open, seal};
pub use store::{Newest, Store, StoredRun};
