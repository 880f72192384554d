//! What people do with the engines: run, compare, impact. Studies know engines only through the trait.

mod execute;
mod fluid;
mod progress;

pub use execute::{Progress, execute};
pub use fluid::{ChannelSummary, FluidSummary, fluid_study};
