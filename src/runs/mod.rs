//! Runs of the commands: this module makes outcomes (the results of runs) from settings and a list of runs.
//!
//! `Executor` does the runs, one at a time or concurrently, by threads of this process and by other processes. A stored
//! run continues from its stored state. The commands make the list of runs, and write documents about the outcomes.

mod checkpointer;
mod error;
mod execute;
mod executor;
mod progress;
mod ranks;
mod resumable;
mod run_list;
mod settings;
mod signals;
mod standard_observers;
mod terminal;
mod threads;

pub(crate) use checkpointer::{Checkpointer, unusable};
pub use error::StudyError;
pub(crate) use error::{failures, failures_of};
pub use execute::execute;
pub(crate) use execute::execute_with_checkpoints;
pub(crate) use executor::{Executor, RunResult};
pub(crate) use progress::{INTERVAL, Progress, span};
pub use ranks::Ranks;
pub(crate) use resumable::{ResumableRun, mark, mark_of_experiments, refuse_too_large, start};
pub use settings::{CommandOrigin, quoted};
pub(crate) use settings::{CommandSettings, command_line, folder, provenance, read};
pub use signals::Signals;
#[cfg(feature = "lab")]
pub(crate) use standard_observers::StandardObservers;
pub use terminal::{answer, tell};
pub(crate) use terminal::{answer_json, conclude, warn};
pub(crate) use threads::{share_threads, use_threads};
