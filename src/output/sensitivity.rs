//! What a study of sensitivity comes to: how far each factor shifts each observable.

use super::{Basis, Provenance};
use crate::statistics::Answer;
use serde::Serialize;

/// How far a factor shifts an observable.
#[derive(Clone, Debug, Serialize)]
pub struct Shift {
    /// Its name.
    pub observable: String,
    /// Its unit, empty for none.
    pub unit: &'static str,
    /// What the shift is set against, in the unit of the observable.
    pub scale: f64,
    /// Description of the scale, in words that follow "% of".
    #[serde(skip)]
    pub scale_is: &'static str,
    /// With the factor minus without it, in the unit of the observable.
    pub difference: f64,
    /// One standard error, in the unit of the observable; 0 where nothing scatters, `None` where it is not known.
    pub error: Option<f64>,
    /// [-] degrees of freedom behind the error.
    pub freedom: Option<f64>,
    /// [s] the instant, of curves over time; `None` for a mean.
    pub time: Option<f64>,
    /// [-] chance of as large a shift in equal systems, for this observable alone.
    pub chance: Option<f64>,
    /// [-] the smallest margin within which it is equivalent, over the scale; `None` without an error.
    pub reached: Option<f64>,
    /// [-] how many times as long a run would show systems that are equal to be equivalent, in 80 % of cases.
    pub stretch: Option<f64>,
    /// The answer, all factors and observables being judged together.
    #[serde(rename = "verdict")]
    pub answer: Answer,
}

impl Shift {
    /// [-] over the scale.
    pub fn share(&self) -> f64 {
        self.difference / self.scale
    }

    /// [-] one standard error over the scale.
    pub fn share_error(&self) -> Option<f64> {
        self.error.map(|error| error / self.scale)
    }
}

/// A factor and what it does.
#[derive(Clone, Debug, Serialize)]
pub struct Factor {
    /// Its name on the command line.
    pub name: String,
    /// What it is, in a sentence.
    pub title: String,
    /// From what to what.
    pub change: String,
    /// Why by so much.
    pub why: String,
    /// What the shifts rest on; `None` of one that stopped early.
    pub basis: Option<Basis>,
    /// Its shifts, in the order of all observables.
    pub shifts: Vec<Shift>,
    /// Names of its runs, and of those that they are compared with.
    pub runs: [Vec<String>; 2],
    /// What else there is to say of it.
    pub remarks: Vec<String>,
    /// Why one of its runs stopped early, if one did.
    pub stopped: Option<String>,
    /// The answer: the worst of its observables.
    #[serde(rename = "verdict")]
    pub answer: Answer,
}

impl Factor {
    /// The shift that is named first: the largest of those that decide the answer.
    pub fn headline(&self) -> Option<&Shift> {
        let deciding = self.shifts.iter().filter(|shift| shift.answer == self.answer);
        deciding.max_by(|a, b| a.share().abs().total_cmp(&b.share().abs()))
    }
}

/// A factor that was not looked at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OmittedFactor {
    /// Its name on the command line.
    pub name: String,
    /// Why.
    pub why: String,
}

/// A run of the study.
#[derive(Clone, Debug, Serialize)]
pub struct SensitivityRun {
    /// Its name.
    pub name: String,
    /// What it changes in the case, as it would be typed; empty for nothing.
    pub set: String,
    /// Its collision model.
    pub model: crate::experiment::Model,
    /// Runs of it from different seeds that are over.
    pub replicas: usize,
    /// Whether it is steady while it is averaged.
    pub steady: bool,
    /// [s] simulated time.
    pub simulated_seconds: f64,
    /// [s] wall time of all replicas together.
    pub wall_seconds: f64,
    /// Why it stopped early, if it did.
    pub failure: Option<String>,
}

/// Everything outputs need to know of a study of sensitivity.
pub struct SensitivityStudy<'a> {
    /// Where it comes from.
    pub provenance: &'a Provenance,
    /// [-] the margin, over the scale of each observable.
    pub margin: f64,
    /// The factors, those that matter most first.
    pub factors: &'a [Factor],
    /// Those that were not looked at.
    pub left_out: &'a [OmittedFactor],
    /// Names of factors whose runs are not over yet.
    pub waiting: &'a [String],
    /// The runs that are over; the first is the case as it is.
    pub runs: &'a [SensitivityRun],
    /// The answer in sentences, the shortest first.
    pub sentences: &'a [String],
    /// What limits how far the numbers can be trusted, a sentence each.
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
