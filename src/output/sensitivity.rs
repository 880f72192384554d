//! Results of a sensitivity study as plain data: the shift of each observable by each factor. A factor is an input of
//! the case that the study changes.

use super::{Basis, Provenance};
use crate::statistics::Answer;
use serde::Serialize;

/// Shift of one observable: change of its value by one changed factor, such as a parameter of the case.
#[derive(Clone, Debug, Serialize)]
pub struct Shift {
    /// Name of the observable that is shifted.
    pub observable: String,
    /// Unit of the observable; empty if it has none.
    pub unit: &'static str,
    /// Scale (reference magnitude) of the observable, by which the shift is divided, in the unit of the observable.
    pub scale: f64,
    /// Description of the scale (the value by which the shift is divided), as the words after "% of".
    #[serde(skip)]
    pub scale_is: &'static str,
    /// Value of the observable with the changed factor, minus the value without the change, in the unit of the
    /// observable.
    pub difference: f64,
    /// One standard error of the difference, in the unit of the observable. It is 0 without randomness, and `None` if
    /// unknown.
    pub error: Option<f64>,
    /// [-] number of degrees of freedom from which `error` is estimated; `None` if the error is 0 or unknown.
    pub freedom: Option<f64>,
    /// [s] time at which the shift of a curve is measured; `None` for the shift of a mean.
    pub time: Option<f64>,
    /// [-] probability that two equal systems show a shift of at least this size by chance, for this observable alone.
    /// `None` if the error is unknown.
    pub chance: Option<f64>,
    /// [-] smallest margin (largest accepted difference) with which the answer would be "equivalent", divided by
    /// `scale`. `None` without a standard error.
    pub reached: Option<f64>,
    /// [-] necessary duration of the run, divided by its actual duration. With the necessary duration, two equal
    /// systems are found equivalent in 80 % of cases. `None` if the error is 0 or unknown.
    pub stretch: Option<f64>,
    /// Answer (equivalent, different or unresolved) for this observable, from a test of all factors and observables
    /// together.
    #[serde(rename = "verdict")]
    pub answer: Answer,
}

impl Shift {
    /// [-] shift of the observable by the changed factor, divided by the scale of the observable.
    pub fn share(&self) -> f64 {
        self.difference / self.scale
    }

    /// [-] one standard error of the shift, divided by the scale of the observable; `None` if it is unknown.
    pub fn share_error(&self) -> Option<f64> {
        self.error.map(|error| error / self.scale)
    }
}

/// Changed factor with its effects on the observables.
#[derive(Clone, Debug, Serialize)]
pub struct Factor {
    /// Name of the factor on the command line.
    pub name: String,
    /// Description of the factor (an input that the study changes) in a sentence, for the report.
    pub title: String,
    /// Old and new value of the changed factor, in words.
    pub change: String,
    /// Reason why the change of the factor has this size.
    pub why: String,
    /// Kind of results (averages, curves or paths) from which the shifts are computed; `None` if a run stopped early.
    pub basis: Option<Basis>,
    /// Shifts of all observables by this factor, in a fixed order.
    pub shifts: Vec<Shift>,
    /// Names of the runs with the changed factor, and names of the runs with which they are compared.
    pub runs: [Vec<String>; 2],
    /// Further remarks about the factor.
    pub remarks: Vec<String>,
    /// Reason why a run with this factor stopped early; `None` if all runs ended.
    pub stopped: Option<String>,
    /// Answer for the factor: the least favourable answer among all observables. From favourable to unfavourable, the
    /// answers are equivalent, unresolved, different.
    #[serde(rename = "verdict")]
    pub answer: Answer,
}

impl Factor {
    /// Shift that is largest relative to its scale, among the observables whose answer equals that of the factor.
    /// `None` if there are no shifts.
    pub fn headline(&self) -> Option<&Shift> {
        let deciding = self.shifts.iter().filter(|shift| shift.answer == self.answer);
        deciding.max_by(|a, b| a.share().abs().total_cmp(&b.share().abs()))
    }
}

/// Factor that the study left out, with the reason.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OmittedFactor {
    /// Name of the omitted factor on the command line.
    pub name: String,
    /// Reason why the factor was left out.
    pub why: String,
}

/// Run of a sensitivity study, with its settings and its computing time.
#[derive(Clone, Debug, Serialize)]
pub struct SensitivityRun {
    /// Name of the run, as in [`Factor::runs`].
    pub name: String,
    /// Changes to the case in the form of `--set` arguments; empty without changes.
    pub set: String,
    /// Collision model of the run.
    pub model: crate::experiment::Model,
    /// Number of finished replicas, which are runs with different seeds.
    pub replicas: usize,
    /// True if the run is steady during the averaging period.
    pub steady: bool,
    /// [s] simulated time of each replica (run with one seed).
    pub simulated_seconds: f64,
    /// [s] wall-clock time of all replicas (runs with different seeds) together.
    pub wall_seconds: f64,
    /// Reason why the run stopped early; `None` if it ended regularly.
    pub failure: Option<String>,
}

/// All results of a sensitivity study.
pub struct SensitivityStudy<'a> {
    /// Origin of the results: title, case and command.
    pub provenance: &'a Provenance,
    /// [-] margin of equivalence: largest accepted difference, divided by the scale (reference magnitude) of the
    /// observable.
    pub margin: f64,
    /// Factors in order of importance; the most important is first.
    pub factors: &'a [Factor],
    /// Factors that were left out.
    pub left_out: &'a [OmittedFactor],
    /// Names of factors whose runs are not finished.
    pub waiting: &'a [String],
    /// Finished runs of the study. The first one is that of the unchanged case.
    pub runs: &'a [SensitivityRun],
    /// Answers in sentences, beginning with the cheapest set of models that is accurate enough.
    pub sentences: &'a [String],
    /// Remarks on how far the numbers are reliable, one sentence each.
    pub notes: &'a [String],
}

impl SensitivityStudy<'_> {
    /// Names of the observables of all factors, in order of first appearance.
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
