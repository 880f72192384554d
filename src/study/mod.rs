//! Studies, the tasks that users do with the engines: run, compare, impact. Studies know engines only through the
//! trait.

mod calibration;
pub mod chart;
mod check;
mod checkpointer;
mod compare;
mod error;
mod execute;
mod fluid;
mod impact;
mod invocation;
mod judge;
mod kept_runs;
mod keys;
pub mod limits;
mod plan;
mod progress;
mod ranks;
mod replicas;
mod resume;
mod run;
mod run_list;
mod scaffold;
mod sensitivity;
mod session;
mod signals;
mod sweep;
mod terminal;
mod trust;
mod trust_sheet;
mod verify;

pub use chart::chart;
pub use check::{check, check_text};
pub use compare::compare;
#[cfg(feature = "lab")]
pub(crate) use execute::StandardObservers;
pub use execute::execute;
pub use fluid::{ChannelSummary, FluidSummary, fluid, write_profile};
pub use impact::impact;
pub use judge::{Criteria, judge, judge_at};
pub use keys::{keys, markdown};
pub use limits::limits;
pub use plan::{PlannedExperiment, plan, plan_of};
pub use ranks::Ranks;
pub use replicas::pool;
pub use resume::resume;
pub use run::run;
pub use scaffold::{cases, completions, init, man};
pub use sensitivity::sensitivity;
pub use session::{StudyError, quoted};
pub use signals::Signals;
pub use sweep::sweep;
pub use terminal::{answer, tell};
pub use trust_sheet::trust_sheet;
pub use verify::verify;
