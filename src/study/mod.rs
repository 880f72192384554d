//! What people do with the engines: run, compare, impact. Studies know engines only through the trait.

mod check;
mod outcome;

pub use check::check;
pub use outcome::{Balance, Outcome, Timing};
