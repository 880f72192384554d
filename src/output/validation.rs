//! Results of the validation suite as plain data for the outputs, with one [`ValidationRow`] per comparison. A margin
//! is the largest difference that is accepted as equivalent.

use super::csv::{CsvTable, number};
use super::numbers::{significant, with_error};
use super::panel::Panel;
use super::{OutputError, Provenance};
use crate::statistics::{Answer, Estimate};
use serde::Serialize;

/// Kind of the reference with which a row of the validation suite is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ValidationTier {
    /// Exact formulas and converged solutions of the equations that the program solves.
    ClosedForms,
    /// Published numbers of other codes and of theories.
    OtherCodes,
    /// Published measurements of experiments.
    Experiments,
}

impl ValidationTier {
    /// All kinds of references, in the order of the report.
    pub const ALL: [Self; 3] = [Self::ClosedForms, Self::OtherCodes, Self::Experiments];

    /// Name of this kind of reference in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::ClosedForms => "closed form",
            Self::OtherCodes => "other codes and theories",
            Self::Experiments => "experiment",
        }
    }
}

/// Rule by which the deviation of a number from its reference is judged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ValidationRule {
    /// The result is not random. The number agrees with its reference if the deviation is at most the tolerance;
    /// otherwise it is different.
    Tolerance,
    /// The result is random and has a standard error. A difference is found by Student's t test, and equivalence within
    /// the margin (largest accepted difference) by two one-sided tests.
    Margin,
}

/// Number in a row (comparison) of the validation suite, with its reference value.
#[derive(Clone, Debug, Serialize)]
pub struct ValidationNumber {
    /// Name of the number within its row, the comparison to which it belongs.
    pub name: String,
    /// Unit of the number; empty if it has none.
    pub unit: &'static str,
    /// Reference value with its standard error (0 for an exact value), in the unit of the number.
    pub reference: Estimate,
    /// Value computed by this program, with its standard error (0 if the result is not random), in the unit of the
    /// number.
    pub ours: Estimate,
    /// [-] number of degrees of freedom of the standard error of `ours`, for Student's t test.
    pub freedom: f64,
    /// Tolerance or margin: largest accepted magnitude of the difference, in the unit of the number.
    pub allowed: f64,
    /// Rule by which the difference from the reference is judged.
    pub rule: ValidationRule,
    /// Answer for this number: equivalent, different or unresolved.
    pub answer: Answer,
}

impl ValidationNumber {
    /// Value computed by this program minus the reference value, with the standard error, in the unit of the number.
    pub fn difference(&self) -> Estimate {
        self.ours.less(self.reference)
    }

    /// [-] magnitude of the difference from the reference, divided by the largest accepted difference (tolerance or
    /// margin).
    pub fn share(&self) -> f64 {
        self.difference().value.abs() / self.allowed
    }

    /// Answer for this number in words, with the difference on which the answer is based.
    pub fn verdict(&self) -> String {
        let allowed = with_unit(significant(self.allowed, 2), self.unit);
        let difference = with_unit(with_error(self.difference()), self.unit);
        match (self.answer, self.rule) {
            (Answer::Equivalent, ValidationRule::Tolerance) => format!("agrees within {allowed}"),
            (Answer::Equivalent, ValidationRule::Margin) => format!("equivalent within {allowed}"),
            (Answer::Different, _) => format!("different by {difference}"),
            (Answer::Unresolved, _) => format!("unresolved: {difference}, margin {allowed}"),
        }
    }
}

/// Text of a number followed by its unit, if the unit is not empty.
fn with_unit(number: String, unit: &str) -> String {
    if unit.is_empty() { number } else { format!("{number} {unit}") }
}

/// Row of the validation suite: one comparison, with its numbers.
#[derive(Clone, Debug)]
pub struct ValidationRow {
    /// Name of the row (comparison of the suite), as in the option `--only`.
    pub name: &'static str,
    /// Kind of the reference: exact formula, other code or experiment.
    pub tier: ValidationTier,
    /// Description, in words, of the scene that the comparison computes.
    pub scene: &'static str,
    /// Source of the reference, with the page, figure or table.
    pub source: &'static str,
    /// Sentence that states which question the comparison does not answer.
    pub not_shown: &'static str,
    /// Name of the built-in case that the comparison runs, with some changes.
    pub case: &'static str,
    /// Numbers of the comparison with their references. The list is empty if a run stopped.
    pub numbers: Vec<ValidationNumber>,
    /// Picture of the comparison, as its caption and its panel (axes with curves or points); `None` if there is none.
    pub picture: Option<(&'static str, Panel)>,
    /// Reason why a run of the comparison stopped early; `None` if all runs ended.
    pub failure: Option<String>,
    /// [s] wall-clock time of all runs of the comparison.
    pub wall_seconds: f64,
}

impl ValidationRow {
    /// Answer of the row (comparison): the least favourable answer of its numbers (different, else unresolved, else
    /// equivalent). It is `Unresolved` if a run stopped, or if there are no numbers.
    pub fn answer(&self) -> Answer {
        let worst = self.numbers.iter().map(|number| number.answer).max();
        worst.filter(|_| self.failure.is_none()).unwrap_or(Answer::Unresolved)
    }

    /// Number of the row (comparison) that deviates most. It is chosen among the numbers with the least favourable
    /// answer (different, else unresolved, else equivalent). Among these it has the largest difference, divided by its
    /// tolerance or margin (largest accepted difference). `None` if the row has no numbers.
    pub fn worst(&self) -> Option<&ValidationNumber> {
        let worst = self.answer();
        let among = self.numbers.iter().filter(|number| number.answer == worst);
        among.max_by(|a, b| a.share().total_cmp(&b.share()))
    }

    /// Answer of the row (comparison) in one word: "agrees" if all numbers are within tolerances, "stopped" if a run
    /// stopped, otherwise the word for [`answer`](Self::answer).
    pub fn word(&self) -> &'static str {
        let exact = self.numbers.iter().all(|number| number.rule == ValidationRule::Tolerance);
        match self.answer() {
            _ if self.failure.is_some() => "stopped",
            Answer::Equivalent if exact => "agrees",
            answer => answer.word(),
        }
    }
}

/// Comparison that the validation suite does not make, with the reason.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct NotValidated {
    /// Name of the comparison that is not made.
    pub name: &'static str,
    /// Reference that exists for this comparison, with its source.
    pub reference: &'static str,
    /// Reason why the comparison is not made, such as a missing part of the program or unpublished data.
    pub needs: &'static str,
}

/// All results of the validation suite.
#[derive(Clone, Copy, Debug)]
pub struct ValidationStudy<'a> {
    /// Origin of the results: title and command.
    pub provenance: &'a Provenance,
    /// Rows (comparisons) of the suite in the order of the report.
    pub rows: &'a [ValidationRow],
    /// Names of the rows (comparisons) that were left out because of the option `--quick`.
    pub left_out: &'a [&'static str],
    /// Comparisons that the suite does not make.
    pub not_validated: &'a [NotValidated],
    /// True if the suite made shorter runs because of the option `--quick`.
    pub quick: bool,
}

impl ValidationStudy<'_> {
    /// Command that repeats the runs of one row (comparison) of the suite.
    pub fn command(&self, row: &ValidationRow) -> String {
        format!("diptych validate --only {}{}", row.name, if self.quick { " --quick" } else { "" })
    }

    /// Least favourable answer (different, else unresolved, else equivalent) of all rows (comparisons) of the suite;
    /// `None` without rows.
    pub fn answer(&self) -> Option<Answer> {
        self.rows.iter().map(ValidationRow::answer).max()
    }
}

/// Contents of `validation.csv`: one row per number. The column `allowed` contains the tolerance or the margin (largest
/// accepted difference), in the unit of the number.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub(super) fn table(rows: &[ValidationRow]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head("row,tier,number,unit,reference,reference_se,ours,ours_se,difference,allowed,rule,verdict")?;
    for row in rows {
        for one in &row.numbers {
            let names = [row.name.to_owned(), row.tier.name().to_owned(), one.name.clone(), one.unit.to_owned()];
            let values = [
                Some(one.reference.value),
                one.reference.error,
                Some(one.ours.value),
                one.ours.error,
                Some(one.difference().value),
                Some(one.allowed),
            ];
            let rule = match one.rule {
                ValidationRule::Tolerance => "tolerance",
                ValidationRule::Margin => "margin",
            };
            let ends = [rule.to_owned(), one.answer.word().to_owned()];
            table.row(names.into_iter().chain(values.map(number)).chain(ends))?;
        }
    }
    table.bytes()
}
