//! Document of a comparison of files that any program may have written.

use super::verdict::{legend, of_pair};
use crate::output::document::{Block, Document, TextRow};
use crate::output::numbers::{UNKNOWN, significant, with_error};
use crate::output::{FilesQuantity, FilesStudy, Folder, OutputError, SideSummary, figures, files_study};
use serde_json::json;
use std::path::PathBuf;

/// Writes all results of a comparison of files, and returns the path of the report.
///
/// # Errors
/// An [`OutputError`]. Files written before the error remain, but there is no `summary.json`.
pub fn write_files_study(folder: &Folder, study: &FilesStudy) -> Result<PathBuf, OutputError> {
    let figures = figures::files_study(study.comparisons);
    let mut body = vec![
        Block::Figures(0..figures.len()),
        Block::heading("Data of both sides"),
        Block::entries([("A", study.paths[0].clone()), ("B, the reference", study.paths[1].clone())]),
        Block::table(
            "quantity | unit | side | column | files | samples | mean ± 1 SE | averaged from | correlation time | drift [SE] | steady",
            study.quantities.iter().flat_map(rows),
        ),
        Block::note(
            "SE: standard error, with the correlation of samples. Correlation time: half the time between independent samples, \
             in seconds if the settings give a unit of time, else in the unit of the column of times. Drift: difference of the two halves of what is averaged.",
        ),
        Block::heading("Differences"),
    ];
    study.comparisons.iter().for_each(|verdict| body.extend(of_pair(verdict)));
    body.push(legend());
    let document = Document {
        provenance: study.provenance,
        failures: Vec::new(),
        verdicts: study.verdicts,
        answers: usize::MAX,
        front: Vec::new(),
        notes: study.notes,
        body,
        tail: Vec::new(),
        tables: vec![("judge.csv".into(), files_study::table(study.quantities)?)],
        figures,
    };
    let numbers = json!({ "sides": study.names, "files": study.paths, "quantities": study.quantities, "comparisons": study.comparisons });
    document.write(folder, numbers)
}

/// Two rows of a table for one quantity: one for side A and one for side B of the comparison.
fn rows(quantity: &FilesQuantity) -> Vec<TextRow> {
    quantity.sides.iter().zip(["A", "B"]).map(|(side, letter)| (false, row(quantity, side, letter))).collect()
}

fn row(quantity: &FilesQuantity, side: &SideSummary, letter: &str) -> Vec<String> {
    let steady = side.steadiness;
    vec![
        quantity.name.clone(),
        if quantity.unit.is_empty() { UNKNOWN.into() } else { quantity.unit.clone() },
        letter.into(),
        side.column.clone(),
        side.files.to_string(),
        side.samples.to_string(),
        with_error(side.mean),
        significant(side.from, 3),
        significant(side.correlation_time, 2),
        significant(steady.and_then(|steady| steady.drift), 2),
        steady.map_or(UNKNOWN.into(), |steady| if steady.steady { "yes" } else { "no" }.into()),
    ]
}
