//! Trust sheets: checks of the results as plain data, with one [`TrustSheet`] per variant. Tables and `summary.json`
//! are made from these data. A window is the time between two exchanges of momentum with the gas. A variant is one of
//! the experiments of a case.

use crate::statistics::Estimate;
use serde::Serialize;

/// Condition on the value of a check.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Expected {
    /// The value should equal this number.
    Equals(f64),
    /// The magnitude of the value should be at most this number.
    AtMost(f64),
    /// There is no condition: the value is only reported.
    Anything,
}

/// Judgement of a checked value by the condition of its check: good, suspect, only stated or unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// The value fulfils the condition.
    Good,
    /// The value violates the condition.
    Suspect,
    /// The value is only reported, because there is no condition.
    Stated,
    /// The value is missing; the remark contains the reason.
    Unknown,
}

/// Check of the results: one value with a condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrustCheck {
    /// Name of the checked value.
    pub name: &'static str,
    /// Unit of the value; empty if it has none.
    pub unit: &'static str,
    /// Value that is checked, with its standard error, written in JSON as `value` and `error`. `None` if it is unknown.
    #[serde(flatten, serialize_with = "value_and_error")]
    pub found: Option<Estimate>,
    /// Condition on the value, such as a limit.
    pub expected: Expected,
    /// Judgement of the found value by the condition `expected`.
    pub judgement: Judgement,
    /// Reason why the value was not found, or the source of the limit in `expected`.
    pub remark: String,
}

impl TrustCheck {
    /// [-] value minus expected value, divided by the standard error of the value; 0 if the two values differ only by
    /// rounding. `None` if no value is expected, or if the standard error is unknown or 0.
    pub fn in_errors(&self) -> Option<f64> {
        let (Expected::Equals(value), found) = (self.expected, self.found?) else { return None };
        let off = found.less(Estimate::exact(value));
        // a relative difference up to 1e-12 counts as rounding, even if the standard error is smaller
        if off.value.abs() <= 1e-12 * value.abs() { Some(0.0) } else { off.in_errors() }
    }
}

/// Writes an estimate as two numbers, the value and its error; both are null without an estimate.
fn value_and_error<S: serde::Serializer>(found: &Option<Estimate>, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct TrustNumbers {
        value: Option<f64>,
        error: Option<f64>,
    }
    let numbers = TrustNumbers { value: found.map(|found| found.value), error: found.and_then(|found| found.error) };
    numbers.serialize(serializer)
}

/// Quantity in two short runs. The first run has the time step and the window of the original run, the second run half
/// of both. A window is the time between two exchanges with the gas.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Halved {
    /// Name of the quantity that is compared between the two runs.
    pub name: &'static str,
    /// Unit of the quantity; empty if it has none.
    pub unit: &'static str,
    /// Value of the quantity in the short run with the original time step and window (time between two exchanges with
    /// the gas).
    pub as_run: Estimate,
    /// Value of the quantity in the short run with half the time step and half the window (time between two exchanges
    /// with the gas).
    pub halved: Estimate,
}

impl Halved {
    /// Value with half the time step and half the window (time between two exchanges with the gas), minus the value
    /// with the original ones. The standard error assumes that the two short runs are independent.
    pub fn change(&self) -> Estimate {
        self.halved.less(self.as_run)
    }

    /// [-] change of the quantity when time step and window (time between two exchanges with the gas) are halved,
    /// divided by the standard error of the change. It is 0 if the change is only rounding. `None` if the error is
    /// unknown or 0.
    pub fn in_errors(&self) -> Option<f64> {
        let change = self.change();
        // a quantity without unit is a fraction and has the scale 1; a change up to 1e-12 of the scale counts as
        // rounding
        let scale = if self.unit.is_empty() { 1.0 } else { self.as_run.value.abs() };
        if change.value.abs() <= 1e-12 * scale { Some(0.0) } else { change.in_errors() }
    }
}

/// Two short continuations of a run from its final state. The first has the settings of the run, the second half the
/// time step and half the window (time between two exchanges with the gas).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verification {
    /// [s] simulated time of each of the two continuations.
    pub stretch: f64,
    /// [-] wall-clock time of both continuations together, divided by the wall-clock time of the run.
    pub cost: f64,
    /// [s] window of the run (time between two exchanges with the gas). To verify the results, the run is continued
    /// twice from its final state: first with this window, then with half this window.
    pub window: f64,
    /// [s] time step of the run; `None` for event-driven collisions. To verify the results, the run is continued twice
    /// from its final state: first with this time step, then with half this time step.
    pub time_step: Option<f64>,
    /// Compared quantities that have values in both continuations.
    pub quantities: Vec<Halved>,
}

/// Result of a test in which a run is continued with half the time step and half the window (time between two exchanges
/// with the gas).
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HalvedStep {
    /// The run was continued twice: with its settings, and with half the time step and half the window (time between
    /// two exchanges with the gas).
    Verified(Verification),
    /// The run was not continued, for the reason given by the text.
    Unknown(String),
}

/// Trust sheet of one variant (experiment of a case): checks that show how far its results are reliable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrustSheet {
    /// Name of the variant (experiment of a case).
    pub variant: String,
    /// Checks of the results, each with its judgement.
    pub checks: Vec<TrustCheck>,
    /// Test of the effect of halving the time step and the window (time between two exchanges with the gas).
    pub halved_step: HalvedStep,
}
