//! Content of a trust sheet: plain data, one [`TrustSheet`] per variant. Tables and `summary.json` show it.

use crate::statistics::Estimate;
use serde::Serialize;

/// Expectation of a number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Expected {
    /// The number should equal this value.
    Equals(f64),
    /// The magnitude of the number should be at most this value.
    AtMost(f64),
    /// No expectation: the number is only stated.
    Anything,
}

/// Judgement of a number against its expectation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// The number is as expected.
    Good,
    /// The number is not as expected.
    Suspect,
    /// There is no expectation.
    Stated,
    /// The number is missing; the remark gives the reason.
    Unknown,
}

/// One number of a trust sheet with its expectation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrustCheck {
    /// Name of the number.
    pub name: &'static str,
    /// Unit of the number, empty for none.
    pub unit: &'static str,
    /// The number and its standard error; written as `value` and `error`.
    #[serde(flatten, serialize_with = "value_and_error")]
    pub found: Option<Estimate>,
    /// Expectation of the number.
    pub expected: Expected,
    /// Judgement of the number.
    pub judgement: Judgement,
    /// Reason for a missing number, or the source of the limit.
    pub remark: String,
}

impl TrustCheck {
    /// [-] number minus expected value, in standard errors; `None` without an error or an expected value.
    pub fn in_errors(&self) -> Option<f64> {
        let (Expected::Equals(value), found) = (self.expected, self.found?) else { return None };
        let off = found.less(Estimate::exact(value));
        // a relative difference of 1e-12 is rounding, whatever the scatter
        if off.value.abs() <= 1e-12 * value.abs() { Some(0.0) } else { off.in_errors() }
    }
}

/// An estimate as two numbers, both null if there is none.
fn value_and_error<S: serde::Serializer>(found: &Option<Estimate>, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct TrustNumbers {
        value: Option<f64>,
        error: Option<f64>,
    }
    let numbers = TrustNumbers { value: found.map(|found| found.value), error: found.and_then(|found| found.error) };
    numbers.serialize(serializer)
}

/// One quantity at the step and window of the run, and at half of both.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Halved {
    /// Name of the quantity.
    pub name: &'static str,
    /// Unit of the quantity, empty for none.
    pub unit: &'static str,
    /// Value with the settings of the variant.
    pub as_run: Estimate,
    /// Value at half the step and half the window.
    pub halved: Estimate,
}

impl Halved {
    /// Value at the halved settings minus that at the original ones. Its standard error treats both stretches as
    /// independent.
    pub fn change(&self) -> Estimate {
        self.halved.less(self.as_run)
    }

    /// [-] change in units of its standard error; `None` without an error.
    pub fn in_errors(&self) -> Option<f64> {
        let change = self.change();
        // a quantity without unit is a share, with scale 1; a change below 1e-12 of the scale is rounding
        let scale = if self.unit.is_empty() { 1.0 } else { self.as_run.value.abs() };
        if change.value.abs() <= 1e-12 * scale { Some(0.0) } else { change.in_errors() }
    }
}

/// A short stretch from the final state, run twice: with the settings of the variant, and at half the step and half the
/// window.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verification {
    /// [s] simulated time of each of the two stretches.
    pub stretch: f64,
    /// [-] wall-clock time of both over that of the run.
    pub cost: f64,
    /// [s] window of the run; the second stretch has half of it.
    pub window: f64,
    /// [s] step of the run, `None` for events; the second stretch has half of it.
    pub time_step: Option<f64>,
    /// The compared quantities; those that a stretch could not give are left out.
    pub quantities: Vec<Halved>,
}

/// Result of the test with a halved step.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HalvedStep {
    /// The run was repeated with half the time step.
    Verified(Verification),
    /// The run was not repeated, for this reason.
    Unknown(String),
}

/// The reliability of the numbers of one variant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrustSheet {
    /// Name of the variant.
    pub variant: String,
    /// The numbers.
    pub checks: Vec<TrustCheck>,
    /// Effect of halving the step.
    pub halved_step: HalvedStep,
}
