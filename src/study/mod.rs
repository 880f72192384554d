//! What people do with the engines: run, compare, impact. Studies know engines only through the trait.

mod execute;
mod outcome;

pub use execute::{Progress, execute};
pub use outcome::{Balance, Outcome, Timing};
