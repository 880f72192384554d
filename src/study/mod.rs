//! What people do with the engines: run, compare, impact. Studies know engines only through the trait.

mod check;
mod compare;
mod execute;
mod fluid;
mod impact;
pub mod limits;
mod progress;
mod run;
mod session;
mod trust;

pub use check::{check, check_text};
pub use compare::compare;
pub use execute::{Progress, execute};
pub use fluid::{ChannelSummary, FluidSummary, fluid, write_profile};
pub use impact::impact;
pub use limits::limits;
pub use run::run;
pub use session::StudyError;
