//! Result of the comparison of a variant with its reference.

use crate::statistics::{Answer, Comparison};
use serde::Serialize;

/// Kind of the compared data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// Averages over the time in which both are steady.
    Averages,
    /// Curves over time, of replicas.
    Curves,
    /// Positions and velocities of each particle at the same times.
    Paths,
    /// Nothing could be compared.
    Nothing,
}

/// A variant against its reference.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// The variant.
    pub variant: String,
    /// Name of the reference.
    pub reference: String,
    /// The answer.
    #[serde(rename = "verdict")]
    pub answer: Answer,
    /// Kind of the compared data.
    pub basis: Basis,
    /// The answer in words.
    pub sentence: String,
    /// Reason for this kind of comparison, in words.
    pub reason: String,
    /// [-] the margin asked for, over the scale of each observable.
    pub margin: f64,
    /// The observables that were compared; none for paths.
    pub comparison: Option<Comparison>,
    /// Further remarks about the two, a sentence each.
    #[serde(skip)]
    pub further: Vec<String>,
}

/// The answer for several comparisons together: the worst, "different" before "unresolved"; `None` without comparisons.
pub fn overall(verdicts: &[Verdict]) -> Option<Answer> {
    verdicts.iter().map(|verdict| verdict.answer).max()
}
