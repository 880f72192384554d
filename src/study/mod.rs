//! What people do with the engines: run, compare, impact. Studies know engines only through the trait.

mod calibration;
pub mod chart;
mod check;
mod compare;
mod error;
mod execute;
mod fluid;
mod hand;
mod impact;
mod keys;
pub mod limits;
mod plan;
mod progress;
mod run;
mod session;
mod sweep;
mod terminal;
mod trust;
mod trust_sheet;
mod verify;

pub use chart::chart;
pub use check::{check, check_text};
pub use compare::compare;
pub use execute::execute;
pub use fluid::{ChannelSummary, FluidSummary, fluid, write_profile};
pub use hand::{cases, completions, init, man};
pub use impact::impact;
pub use keys::{keys, markdown};
pub use limits::limits;
pub use plan::{Planned, plan, plan_of};
pub use run::run;
pub use session::StudyError;
pub use sweep::sweep;
pub use terminal::tell;
pub use trust_sheet::trust_sheet;
pub use verify::verify;
