//! What do we report of many particles, and how sure are we?
//!
//! Samples are taken at fixed times; sums are kept per slice and per block of time, so that every figure gets a
//! standard error from the scatter between blocks, and the start of averaging can be decided after the run.

mod comparison;
mod errors;
mod profiles;
mod steady;
mod temperature;
mod work_precision;

pub use comparison::{Comparison, Difference, QuantityComparison, Verdict, compare};
pub use errors::{Estimate, FEWEST_BLOCKS, degrees_of_freedom, estimate, two_sided_tail};
pub use profiles::{Accumulator, ProfileTable, SliceRow};
pub use steady::{Steadiness, judge};
pub use temperature::Spread;
pub use work_precision::{PowerLaw, pareto_front, power_law};
