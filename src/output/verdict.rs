//! Result of the comparison of a variant with its reference.

use crate::statistics::{Answer, Comparison};
use serde::Serialize;

/// Kind of data by which a variant is compared with its reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// Averages over the time in which both the variant and the reference are steady.
    Averages,
    /// Curves over time of the variant and the reference, from several replicas of each.
    Curves,
    /// Positions and velocities of each particle in both runs at equal times.
    Paths,
    /// No data could be compared.
    Nothing,
}

/// Comparison of a variant with its reference.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// Name of the variant that is compared.
    pub variant: String,
    /// Name of the reference with which the variant is compared.
    pub reference: String,
    /// Answer: equivalent, different or unresolved.
    #[serde(rename = "verdict")]
    pub answer: Answer,
    /// Kind of data by which the variant and the reference were compared.
    pub basis: Basis,
    /// Sentence that states the answer for the report.
    pub sentence: String,
    /// Reason why this kind of data was compared, in words.
    pub reason: String,
    /// [-] margin of equivalence: largest accepted difference, divided by the scale of the observable.
    pub margin: f64,
    /// Tests of the compared observables; `None` for a comparison of paths.
    pub comparison: Option<Comparison>,
    /// Further remarks about the variant and its reference, one sentence each.
    #[serde(skip)]
    pub further: Vec<String>,
}

/// Worst answer of several comparisons; "different" is worse than "unresolved". `None` without comparisons.
pub fn overall(verdicts: &[Verdict]) -> Option<Answer> {
    verdicts.iter().map(|verdict| verdict.answer).max()
}
