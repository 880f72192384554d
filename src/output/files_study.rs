//! Results of a comparison of files that any program may have written, as plain data for the outputs.

use super::csv::{CsvTable, number};
use super::{Basis, OutputError, Provenance, Verdict};
use crate::statistics::{Estimate, Steadiness};
use serde::Serialize;

/// Summary of one side (A or B) of a compared quantity.
#[derive(Clone, Debug, Serialize)]
pub struct SideSummary {
    /// Name of the column that contains the quantity or, in a table of single values, label of the value.
    pub column: String,
    /// Number of files (replicas: runs with different seeds) of this side (A or B) of the comparison.
    pub files: usize,
    /// Number of samples (values at single instants) in all files of this side (A or B) of the comparison.
    pub samples: usize,
    /// Average of the quantity from the start of averaging to the end; `None` if it cannot be computed.
    pub mean: Option<Estimate>,
    /// [s] instant at which averaging starts. It is in the unit of the times in the files if the settings do not name
    /// this unit. `None` for a single value, which has no times.
    pub from: Option<f64>,
    /// [s] integral correlation time of the quantity. It is in the unit of the times in the files if the settings do
    /// not name this unit. `None` if it cannot be computed.
    pub correlation_time: Option<f64>,
    /// Result of the test for a steady state; `None` for a single value, which has no times.
    pub steadiness: Option<Steadiness>,
}

/// Quantity that is compared between the two sides A and B.
#[derive(Clone, Debug, Serialize)]
pub struct FilesQuantity {
    /// Name of the quantity in sentences.
    pub name: String,
    /// SI unit of the quantity; empty if the settings give none.
    pub unit: String,
    /// [-] margin of equivalence: largest accepted difference, divided by the scale (reference magnitude) of the
    /// quantity.
    pub margin: f64,
    /// Kind of data by which the two sides are compared, such as averages or curves.
    pub basis: Basis,
    /// Summaries of the two compared sides, A and B; B is the reference.
    pub sides: [SideSummary; 2],
}

/// All results of a comparison of files.
#[derive(Clone, Copy, Debug)]
pub struct FilesStudy<'a> {
    /// Origin of the results: title, settings and command.
    pub provenance: &'a Provenance,
    /// Names of the sides A and B.
    pub names: &'a [String; 2],
    /// Paths of the files of the sides A and B.
    pub paths: &'a [String; 2],
    /// Quantities in the order of the settings.
    pub quantities: &'a [FilesQuantity],
    /// Answers in sentences. The page begins with these sentences.
    pub verdicts: &'a [String],
    /// Results of the statistical tests. One entry contains all quantities with the same margin (largest accepted
    /// difference) and the same kind of data, such as averages or curves.
    pub comparisons: &'a [Verdict],
    /// Remarks on how far the numbers are reliable, one sentence each.
    pub notes: &'a [String],
}

/// Contents of `judge.csv`: two rows for each quantity, one for each side (A or B). Means and errors are in the unit of
/// the quantity. Times are in s, or in the unit of the times in the files if the settings do not name this unit.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub(super) fn table(quantities: &[FilesQuantity]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head("quantity,unit,side,column,files,samples,mean,mean_se,averaged_from,correlation_time,drift,steady")?;
    for quantity in quantities {
        for (side, letter) in quantity.sides.iter().zip(["A", "B"]) {
            let steadiness = side.steadiness;
            let names = [quantity.name.as_str(), &quantity.unit, letter, &side.column].map(str::to_owned);
            let counts = [side.files, side.samples].map(|count| count.to_string());
            let numbers = [
                side.mean.map(|mean| mean.value),
                side.mean.and_then(|mean| mean.error),
                side.from,
                side.correlation_time,
                steadiness.and_then(|steadiness| steadiness.drift),
            ];
            let steady = steadiness.map_or(String::new(), |steadiness| steadiness.steady.to_string());
            table.row(names.into_iter().chain(counts).chain(numbers.map(number)).chain([steady]))?;
        }
    }
    table.bytes()
}
