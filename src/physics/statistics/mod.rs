//! Averages over many particles, and their statistical errors.
//!
//! Samples are taken at fixed times, and sums are stored for each slice of the box and each block of time. The scatter
//! between blocks gives every average a standard error. The start of averaging can be chosen after the run.

mod batches;
mod comparison;
mod difference;
mod errors;
mod modes;
mod profile_table;
mod profiles;
mod slice_columns;
mod spin_sums;
mod steady;
mod temperature;
mod work_precision;

pub use batches::{Batches, FEWEST_RUNS, MOST_STATED};
pub use comparison::{Answer, Comparison, ErrorLevels, Judged, LEVEL, compare, holm};
pub use difference::{Deviation, EQUIVALENCE_LEVEL, Observable, Tested, student_bound, two_sided};
pub use errors::{Estimate, FEWEST_BLOCKS, estimate};
pub use modes::Parity;
pub use profile_table::{ProfileTable, SliceRow};
pub use profiles::Accumulator;
pub use slice_columns::{
    MEAN_SPIN_X, NUMBER_DENSITY, ROTATIONAL_TEMPERATURE, SLICE_COLUMNS, SLICE_QUANTITIES, SliceColumn, U, UU, UV, VV,
    WW, second_moments, slice_column, slice_columns, spin_components,
};
pub use steady::{LARGEST_DRIFT, Steadiness, SteadySeries, judge};
pub use temperature::VelocitySpread;
pub use work_precision::{PowerLaw, pareto_front, power_law};
