//! Studies, which are the tasks that users do with the engines: run, compare, impact. Studies use engines only through
//! the trait `Engine`.

mod built_in;
mod calibration;
pub mod chart;
mod check;
mod compare;
mod fluid;
mod impact;
mod judge;
mod judge_files;
mod keys;
pub mod limits;
mod manual;
mod oblique;
mod plan;
mod replicas;
mod resume;
mod run;
mod sensitivity;
mod sweep;
mod trust;
mod trust_sheet;
mod variants;
mod verify;

pub use crate::runs::{Ranks, Signals, StudyError, answer, execute, quoted, tell};
pub use built_in::{cases, init};
pub use chart::chart;
pub use check::{check, check_text};
pub use compare::compare;
pub use fluid::{ChannelSummary, FluidSummary, fluid, write_profile};
pub use impact::impact;
pub use judge::{Criteria, judge, judge_at};
pub use judge_files::judge_files;
pub use keys::{keys, markdown};
pub use limits::limits;
pub use manual::{completions, man};
pub use plan::{PlannedExperiment, plan, plan_of};
pub use replicas::pool;
pub use resume::resume;
pub use run::run;
pub use sensitivity::sensitivity;
pub use sweep::sweep;
pub use trust_sheet::trust_sheet;
pub use verify::verify;
