//! Results of the chart of work against precision, as plain data for the outputs.

use super::Provenance;
use super::numbers::with_error;
use crate::engine::{Counters, Failure};
use crate::experiment::Model;
use crate::statistics::{Estimate, PowerLaw};
use serde::Serialize;

/// A quantity whose error is charted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartQuantity {
    /// Short name for files and tables, `restitution_mean`.
    pub key: &'static str,
    /// Name of the quantity, in words.
    pub name: &'static str,
    /// Definition of the error, for an axis: `|e − e₀|/e₀`.
    pub axis: &'static str,
    /// Reference value for all errors, and its own standard error; in `unit`.
    pub reference: Estimate,
    /// Unit of value and reference, empty for none.
    pub unit: &'static str,
    /// [-] statistical floor: the error that one run shows by chance alone, from the scatter of the runs of the
    /// reference; 0 without chance.
    pub floor: f64,
}

/// The error of one point in one quantity, as charted [-].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PointError {
    /// Value found, in the unit of the quantity.
    pub value: f64,
    /// [-] error of the value.
    pub error: f64,
    /// [-] standard error of `error`; `None` if it is not known.
    pub uncertainty: Option<f64>,
    /// Smallest and largest value among the samples, in the unit of the quantity; `None` for a single run.
    pub range: Option<(f64, f64)>,
}

/// Wall-clock time on one thread [s].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CostSpread {
    /// [s] median.
    pub median: f64,
    /// [s] shortest.
    pub lowest: f64,
    /// [s] longest.
    pub highest: f64,
}

/// Reason why a point has no result.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum ChartFailure {
    /// The engine stopped.
    #[error("{0}")]
    Engine(Failure),
    /// The impact had not ended at the end of the simulated time.
    #[error("the impact had not ended when the time of the case was over")]
    Unfinished,
}

impl ChartFailure {
    /// The type of the failure as one word, as in JSON.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Engine(failure) => failure.kind(),
            Self::Unfinished => "unfinished",
        }
    }
}

/// One method at one value of its parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartPoint {
    /// Index into [`ChartStudy::methods`].
    pub method: usize,
    /// Value of the swept parameter, in the unit of that parameter.
    pub knob: f64,
    /// Number of runs.
    pub samples: usize,
    /// Wall-clock time of one run.
    pub wall: CostSpread,
    /// Work of all runs together, equal on every machine.
    pub counters: Counters,
    /// [-] pair checks, force evaluations and events of one run.
    pub work: f64,
    /// One error per quantity in the order of [`ChartStudy::quantities`]; `None` if the point does not have the
    /// quantity.
    pub errors: Vec<Option<PointError>>,
    /// Reason why there are no errors.
    pub failure: Option<ChartFailure>,
}

/// A method and the parameter that is swept.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartMethod {
    /// Name.
    pub name: String,
    /// Collision model.
    pub model: Model,
    /// Symbol of the swept parameter.
    pub knob: &'static str,
    /// Unit of the parameter, empty for none.
    pub unit: &'static str,
}

/// Fitted decrease of the error of a method with its swept parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartSlope {
    /// Index into [`ChartStudy::methods`].
    pub method: usize,
    /// Index into [`ChartStudy::quantities`].
    pub quantity: usize,
    /// The fit.
    #[serde(flatten)]
    pub law: PowerLaw,
    /// Values of the parameter at both ends of the fitted range.
    pub range: (f64, f64),
}

impl ChartSlope {
    /// The exponent with its error, to two decimal places at most: the scatter about a line does not measure a
    /// curvature.
    pub fn exponent(&self) -> String {
        let law = &self.law;
        if law.error < 0.01 {
            format!("{:.2} ± less than 0.01", law.exponent).replace('-', "−")
        } else {
            with_error(Estimate::new(law.exponent, law.error))
        }
    }
}

/// All data of a chart that outputs need.
#[derive(Clone, Copy, Debug)]
pub struct ChartStudy<'a> {
    /// Origin of the results.
    pub provenance: &'a Provenance,
    /// Description of the reference of the errors, and of its accuracy.
    pub reference: &'a str,
    /// Description of the runs of each point.
    pub setting: &'a str,
    /// The methods.
    pub methods: &'a [ChartMethod],
    /// The quantities.
    pub quantities: &'a [ChartQuantity],
    /// All points.
    pub points: &'a [ChartPoint],
    /// Fitted slopes.
    pub slopes: &'a [ChartSlope],
    /// The conclusion, a sentence each.
    pub verdicts: &'a [String],
    /// Limits of the reliability of the numbers.
    pub notes: &'a [String],
}

/// Measure of the cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CostMeasure {
    /// Wall-clock time on one thread.
    Wall,
    /// Pair checks, force evaluations and events.
    Work,
}

impl ChartPoint {
    /// Cost: [s] or a count.
    pub fn cost(&self, cost: CostMeasure) -> f64 {
        match cost {
            CostMeasure::Wall => self.wall.median,
            CostMeasure::Work => self.work,
        }
    }

    /// [-] error in a quantity; `None` if it is not known.
    pub fn error(&self, quantity: usize) -> Option<f64> {
        self.errors.get(quantity).copied().flatten().map(|found| found.error)
    }
}

/// The cheapest point of some models whose error in a quantity is certainly within `target` [-]. Twice its uncertainty
/// is added to the error, so that a lucky value does not win.
pub fn cheapest<'a>(
    (methods, points): (&[ChartMethod], &'a [ChartPoint]),
    quantity: usize,
    target: f64,
    cost: CostMeasure,
    models: &[Model],
) -> Option<&'a ChartPoint> {
    let good = |point: &&ChartPoint| {
        let found = point.errors.get(quantity).copied().flatten();
        let bound = found.and_then(|found| Some(found.error + 2.0 * found.uncertainty?));
        models.contains(&methods[point.method].model) && bound.is_some_and(|bound| bound <= target)
    };
    points.iter().filter(good).min_by(|a, b| a.cost(cost).total_cmp(&b.cost(cost)))
}

impl ChartStudy<'_> {
    /// Indices of the points on the Pareto front of some models in a quantity, in the order of cost: no other of their
    /// points beats them. Errors below the statistical floor count as the floor, because a small error by chance is not
    /// precision.
    pub fn front(&self, quantity: usize, cost: CostMeasure, models: &[Model]) -> Vec<usize> {
        let floor = self.quantities.get(quantity).map_or(0.0, |quantity| quantity.floor);
        let asked = |point: &ChartPoint| models.contains(&self.methods[point.method].model);
        let known = |(place, point): (usize, &ChartPoint)| {
            let error = point.error(quantity).filter(|_| asked(point))?;
            Some((place, (point.cost(cost), error.max(floor))))
        };
        let (places, points): (Vec<usize>, Vec<(f64, f64)>) = self.points.iter().enumerate().filter_map(known).unzip();
        crate::statistics::pareto_front(&points).into_iter().map(|k| places[k]).collect()
    }
}
