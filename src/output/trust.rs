//! What a trust sheet holds: plain data, one [`TrustSheet`] per variant. Tables and `summary.json` show it.

use crate::statistics::Estimate;
use serde::Serialize;

/// What a number should be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Expected {
    /// The number should equal this value.
    Equals(f64),
    /// This value at most, in magnitude.
    AtMost(f64),
    /// Nothing is expected: it is there to be read.
    Anything,
}

/// Whether a number is what it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// The number is what it should be.
    Good,
    /// The number is not what it should be.
    Suspect,
    /// Nothing is expected of it.
    Stated,
    /// There is no such number; the remark says why.
    Unknown,
}

/// One number of a trust sheet beside what it should be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrustCheck {
    /// What it is.
    pub name: &'static str,
    /// Its unit, empty for none.
    pub unit: &'static str,
    /// The number and its standard error; written as `value` and `error`.
    #[serde(flatten, serialize_with = "value_and_error")]
    pub found: Option<Estimate>,
    /// What it should be.
    pub expected: Expected,
    /// Whether the number is what it should be.
    pub judgement: Judgement,
    /// Why the number is missing, or what the limit rests on.
    pub remark: String,
}

impl TrustCheck {
    /// [-] found less expected, in standard errors; `None` without an error or a value to expect.
    pub fn in_errors(&self) -> Option<f64> {
        let (Expected::Equals(value), found) = (self.expected, self.found?) else { return None };
        let off = found.less(Estimate::exact(value));
        // a relative difference of 1e-12 is rounding, whatever the scatter
        if off.value.abs() <= 1e-12 * value.abs() { Some(0.0) } else { off.in_errors() }
    }
}

/// An estimate as two numbers, both null where there is none.
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
    /// What it is.
    pub name: &'static str,
    /// Its unit, empty for none.
    pub unit: &'static str,
    /// As the variant is set.
    pub as_run: Estimate,
    /// At half the step and half the window.
    pub halved: Estimate,
}

impl Halved {
    /// Halved less as run, and the standard error of that, as if both stretches were independent.
    pub fn change(&self) -> Estimate {
        self.halved.less(self.as_run)
    }

    /// [-] the change in its standard errors; `None` without an error.
    pub fn in_errors(&self) -> Option<f64> {
        let change = self.change();
        // what has no unit is a share of one; less than that is rounding
        let scale = if self.unit.is_empty() { 1.0 } else { self.as_run.value.abs() };
        if change.value.abs() <= 1e-12 * scale { Some(0.0) } else { change.in_errors() }
    }
}

/// A short stretch from the final state, run twice: as the variant is set, and at half the step and half the window.
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
    /// The quantities compared; those that neither stretch could give are left out.
    pub quantities: Vec<Halved>,
}

/// Whether the halved step was looked at.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HalvedStep {
    /// The run was repeated with half the time step.
    Verified(Verification),
    /// The run was not repeated, for this reason.
    Unknown(String),
}

/// How far the numbers of one variant can be trusted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrustSheet {
    /// Name of the variant.
    pub variant: String,
    /// The numbers.
    pub checks: Vec<TrustCheck>,
    /// What halving the step changes.
    pub halved_step: HalvedStep,
}
