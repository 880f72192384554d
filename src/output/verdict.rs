//! Result of the comparison of a variant with its reference. A variant is one of the experiments of a case. The table
//! `[observe]` of a case requests further measurements.

use crate::statistics::{Answer, Comparison, Estimate};
use serde::Serialize;

/// Kind of data by which a variant (experiment of a case) is compared with its reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// Averages over the time in which both compared runs are steady.
    Averages,
    /// Curves over time, each the mean of several replicas (runs with different seeds).
    Curves,
    /// Positions and velocities of each particle, in both compared runs at equal times.
    Paths,
    /// No data could be compared.
    Nothing,
}

/// Comparison of a variant (experiment of a case) with its reference.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// Name of the variant (experiment of a case) that is compared.
    pub variant: String,
    /// Name of the reference (another experiment of the case, or a table of values) with which the variant is compared.
    pub reference: String,
    /// Answer of the comparison: equivalent, different or unresolved.
    #[serde(rename = "verdict")]
    pub answer: Answer,
    /// Kind of data that was compared, such as averages.
    pub basis: Basis,
    /// Sentence that states the answer for the report.
    pub sentence: String,
    /// Reason why data of the kind `basis` were compared, in words.
    pub reason: String,
    /// [-] margin of equivalence: largest accepted difference, divided by the scale (reference magnitude) of the
    /// observable.
    pub margin: f64,
    /// Statistical tests of the compared observables; `None` for a comparison of paths.
    pub comparison: Option<Comparison>,
    /// Differences in further numbers, which both runs measure because the case has a table `[observe]`. They have no
    /// effect on `answer`. Empty unless averages were compared.
    #[serde(rename = "observe")]
    pub observed: Vec<ObservedDifference>,
    /// Further remarks on the comparison, one sentence each.
    #[serde(skip)]
    pub further: Vec<String>,
}

/// Difference between a variant (experiment of a case) and its reference in a number that both measure because the case
/// has a table `[observe]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObservedDifference {
    /// Name of the measurement in the table `[observe]` of the case.
    pub measurement: &'static str,
    /// Name of the number in `observables.csv`.
    pub quantity: String,
    /// Name of the measured number in tables and sentences.
    #[serde(skip)]
    pub symbol: String,
    /// SI unit of the number; empty for a pure number.
    pub unit: &'static str,
    /// Value of the variant (experiment of a case) minus value of its reference, in the unit of the number, with its
    /// standard error. The error is unknown if the runs are too short.
    pub difference: Estimate,
    /// [%] difference in per cent of the magnitude of the reference. `None` if the reference is zero within its error.
    pub percent: Option<Estimate>,
    /// [-] probability that two equal systems show a difference of at least this size by chance, for this number alone.
    /// `None` without a standard error.
    pub chance: Option<f64>,
    /// [-] smallest margin (largest accepted difference) with which the answer would be "equivalent", divided by the
    /// magnitude of the reference. `None` if the reference is zero within its error, or without a standard error.
    pub reached: Option<f64>,
    /// Answer for this number; `None` if the number was not judged, for the reason in `remark`.
    pub answer: Option<Answer>,
    /// Remark on the answer, such as the reason why there is no answer; empty without a remark.
    pub remark: &'static str,
}

impl ObservedDifference {
    /// Answer as a word; "no answer" if the number was not judged.
    pub fn word(&self) -> &'static str {
        self.answer.map_or("no answer", Answer::word)
    }
}

/// Least favourable answer of several comparisons: "different", else "unresolved", else "equivalent". `None` without
/// comparisons.
pub fn overall(verdicts: &[Verdict]) -> Option<Answer> {
    verdicts.iter().map(|verdict| verdict.answer).max()
}
