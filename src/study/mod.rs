//! What people do with the engines: run, compare, impact. Studies know engines only through the trait.

mod fluid;
mod outcome;

pub use fluid::{ChannelSummary, FluidSummary, fluid_study};
pub use outcome::{Balance, Outcome, Timing};
