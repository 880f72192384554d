//! Results of a study of sensitivity: the shift of each observable by each factor.

use super::{Basis, Provenance};
use crate::statistics::Answer;
use serde::Serialize;

/// Shift of an observable by a factor.
#[derive(Clone, Debug, Serialize)]
pub struct Shift {
    /// Name of the observable.
    pub observable: String,
    /// Unit of the observable, empty for none.
    pub unit: &'static str,
    /// Scale of the shift, in the unit of the observable.
    pub scale: f64,
    /// Description of the scale, in words that follow "% of".
    #[serde(skip)]
    pub scale_is: &'static str,
    /// Value with the factor minus that without it, in the unit of the observable.
    pub difference: f64,
    /// One standard error of the difference, in the unit of the observable; 0 if nothing scatters, `None` if it is not
    /// known.
    pub error: Option<f64>,
    /// [-] degrees of freedom behind the error.
    pub freedom: Option<f64>,
    /// [s] time of the shift, for curves over time; `None` for a mean.
    pub time: Option<f64>,
    /// [-] probability of as large a shift in equal systems, for this observable alone.
    pub chance: Option<f64>,
    /// [-] smallest margin within which the observable is equivalent, over the scale; `None` without an error.
    pub reached: Option<f64>,
    /// [-] factor on the length of the run with which equal systems would be shown equivalent, in 80 % of cases.
    pub stretch: Option<f64>,
    /// The answer, judged for all factors and observables together.
    #[serde(rename = "verdict")]
    pub answer: Answer,
}

impl Shift {
    /// [-] shift over the scale.
    pub fn share(&self) -> f64 {
        self.difference / self.scale
    }

    /// [-] one standard error of the shift over the scale.
    pub fn share_error(&self) -> Option<f64> {
        self.error.map(|error| error / self.scale)
    }
}

/// A factor and its effects.
#[derive(Clone, Debug, Serialize)]
pub struct Factor {
    /// Name of the factor on the command line.
    pub name: String,
    /// Description of the factor, in a sentence.
    pub title: String,
    /// Old and new value.
    pub change: String,
    /// Reason for the size of the change.
    pub why: String,
    /// Kind of results that the shifts refer to; `None` if a run stopped early.
    pub basis: Option<Basis>,
    /// Shifts, in the order of all observables.
    pub shifts: Vec<Shift>,
    /// Names of the runs with the factor, and of the runs that they are compared with.
    pub runs: [Vec<String>; 2],
    /// Further remarks.
    pub remarks: Vec<String>,
    /// Reason why one of the runs stopped early, if one did.
    pub stopped: Option<String>,
    /// The answer: the worst of all observables.
    #[serde(rename = "verdict")]
    pub answer: Answer,
}

impl Factor {
    /// The shift to be named first: the largest of those that decide the answer.
    pub fn headline(&self) -> Option<&Shift> {
        let deciding = self.shifts.iter().filter(|shift| shift.answer == self.answer);
        deciding.max_by(|a, b| a.share().abs().total_cmp(&b.share().abs()))
    }
}

/// A factor that was left out of the study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OmittedFactor {
    /// Name of the factor on the command line.
    pub name: String,
    /// Reason for leaving it out.
    pub why: String,
}

/// A run of the study.
#[derive(Clone, Debug, Serialize)]
pub struct SensitivityRun {
    /// Name of the run.
    pub name: String,
    /// Changes of the case, as they would be typed; empty for none.
    pub set: String,
    /// Collision model of the run.
    pub model: crate::experiment::Model,
    /// Number of finished replicas, runs with different seeds.
    pub replicas: usize,
    /// True if the run is steady while it is averaged.
    pub steady: bool,
    /// [s] simulated time.
    pub simulated_seconds: f64,
    /// [s] wall time of all replicas together.
    pub wall_seconds: f64,
    /// Reason of an early stop, if there was one.
    pub failure: Option<String>,
}

/// All data of a study of sensitivity that outputs need.
pub struct SensitivityStudy<'a> {
    /// Origin of the results.
    pub provenance: &'a Provenance,
    /// [-] the margin, over the scale of each observable.
    pub margin: f64,
    /// The factors, the most important first.
    pub factors: &'a [Factor],
    /// Factors that were left out.
    pub left_out: &'a [OmittedFactor],
    /// Names of factors with unfinished runs.
    pub waiting: &'a [String],
    /// The finished runs; the first is the unchanged case.
    pub runs: &'a [SensitivityRun],
    /// The answer in sentences, the shortest first.
    pub sentences: &'a [String],
    /// Limits of the reliability of the numbers, a sentence each.
    pub notes: &'a [String],
}

impl SensitivityStudy<'_> {
    /// The observables of all factors, in their order.
    pub fn observables(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for shift in self.factors.iter().flat_map(|factor| &factor.shifts) {
            if !names.contains(&shift.observable.as_str()) {
                names.push(&shift.observable);
            }
        }
        names
    }
}
