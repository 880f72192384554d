//! What people do with the engines: run, compare, impact. Studies know engines only through the trait.

mod outcome;

pub use outcome::{Balance, Outcome, Timing};
