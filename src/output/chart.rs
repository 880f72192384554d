//! Results of the work-precision chart (error of each method plotted against its computing cost) as plain data for the
//! outputs.

use super::Provenance;
use super::numbers::with_error;
use crate::engine::{Counters, Failure};
use crate::experiment::Model;
use crate::statistics::{Estimate, PowerLaw};
use serde::Serialize;

/// Quantity whose error is drawn against the computing cost in a work-precision chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartQuantity {
    /// Short name for files and tables, such as `restitution_mean`.
    pub key: &'static str,
    /// Name of the quantity in words.
    pub name: &'static str,
    /// Definition of the error as a formula for the label of an axis, such as `|e − e₀|/e₀`.
    pub axis: &'static str,
    /// Reference value of the quantity for all errors, with its standard error, in `unit`.
    pub reference: Estimate,
    /// Unit of the value and the reference; empty if the quantity has no unit.
    pub unit: &'static str,
    /// [-] statistical floor: error that chance alone gives a single run, even if its method is exact. It is estimated
    /// from the scatter between the reference runs, and is 0 if nothing is random.
    pub floor: f64,
}

/// Value and error of one quantity at one point of the work-precision chart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PointError {
    /// Value of the quantity that the method gives, in the unit of the quantity.
    pub value: f64,
    /// [-] error of the value, as defined by [`ChartQuantity::axis`].
    pub error: f64,
    /// [-] standard error of `error`; `None` if unknown.
    pub uncertainty: Option<f64>,
    /// Smallest and largest value among the runs with the same method and the same value of its parameter, in the unit
    /// of the quantity; `None` for a single run.
    pub range: Option<(f64, f64)>,
}

/// Wall-clock times [s] of equal runs on one thread: median, shortest and longest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CostSpread {
    /// [s] median of the wall-clock times of single runs.
    pub median: f64,
    /// [s] shortest of the wall-clock times of single runs.
    pub lowest: f64,
    /// [s] longest of the wall-clock times of single runs.
    pub highest: f64,
}

/// Reason why a point of the work-precision chart has no result.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum ChartFailure {
    /// The engine stopped with a failure.
    #[error("{0}")]
    Engine(Failure),
    /// The impact had not ended when the simulated time of the case was over.
    #[error("the impact had not ended when the time of the case was over")]
    Unfinished,
}

impl ChartFailure {
    /// Kind of the failure as one word, as it is written in JSON.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Engine(failure) => failure.kind(),
            Self::Unfinished => "unfinished",
        }
    }
}

/// Point of the work-precision chart: one method with one value of the parameter that is swept (varied).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartPoint {
    /// Index in [`ChartStudy::methods`] of the method of this point of the chart.
    pub method: usize,
    /// Value of the parameter of the method that is swept (varied) for the chart, in the unit of this parameter.
    pub knob: f64,
    /// Number of runs from which the values and errors of this point of the chart are computed.
    pub samples: usize,
    /// Wall-clock time of one run of this point of the chart on one thread.
    pub wall: CostSpread,
    /// Counts of operations, such as time steps, summed over all runs of this point of the chart. They are the same on
    /// every machine.
    pub counters: Counters,
    /// [-] number of operations of one run: sum of pair checks, force evaluations and events.
    pub work: f64,
    /// Errors of this point of the chart, in the order of [`ChartStudy::quantities`]; `None` for a quantity that was
    /// not measured at the point.
    pub errors: Vec<Option<PointError>>,
    /// Reason why this point of the chart has no errors; `None` for a point with errors.
    pub failure: Option<ChartFailure>,
}

/// Method of computing collisions, with the parameter that is swept (varied) for the chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartMethod {
    /// Name of the method, such as that of an engine with its kind of time steps.
    pub name: String,
    /// Collision model of the method.
    pub model: Model,
    /// Symbol of the parameter of the method that is swept (varied), such as that of the time step.
    pub knob: &'static str,
    /// Unit of the swept (varied) parameter; empty if this parameter has no unit.
    pub unit: &'static str,
}

/// Power law fitted to the errors of a method as a function of the parameter that is swept (varied).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartSlope {
    /// Index in [`ChartStudy::methods`] of the method to which the power law belongs.
    pub method: usize,
    /// Index in [`ChartStudy::quantities`] of the quantity whose error follows the power law.
    pub quantity: usize,
    /// Fitted exponent of the power law, with its error.
    #[serde(flatten)]
    pub law: PowerLaw,
    /// Smallest and largest value of the swept (varied) parameter in the fitted range, in the unit of this parameter.
    pub range: (f64, f64),
}

impl ChartSlope {
    /// Text of the fitted exponent with its error, with two decimal places at most. The error follows from the scatter
    /// of the points about a straight line in logarithmic axes. The error does not cover a curvature of the true line,
    /// so more decimal places would have no meaning.
    pub fn exponent(&self) -> String {
        let law = &self.law;
        if law.error < 0.01 {
            format!("{:.2} ± less than 0.01", law.exponent).replace('-', "−")
        } else {
            with_error(Estimate::new(law.exponent, law.error))
        }
    }
}

/// All results of a work-precision chart.
#[derive(Clone, Copy, Debug)]
pub struct ChartStudy<'a> {
    /// Origin of the results: title, case and command.
    pub provenance: &'a Provenance,
    /// Description, in words, of the reference values and of their accuracy.
    pub reference: &'a str,
    /// Description, in words, of the runs of each point of the chart.
    pub setting: &'a str,
    /// Methods that are compared in the chart.
    pub methods: &'a [ChartMethod],
    /// Quantities whose errors are drawn in the chart.
    pub quantities: &'a [ChartQuantity],
    /// Points of the chart: one for each method and each value of its parameter that is swept (varied).
    pub points: &'a [ChartPoint],
    /// Power laws fitted to the errors of the methods.
    pub slopes: &'a [ChartSlope],
    /// Conclusions drawn from the chart, one sentence each.
    pub verdicts: &'a [String],
    /// Remarks on how far the numbers of the chart are reliable, one sentence each.
    pub notes: &'a [String],
}

/// Measure of the cost of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CostMeasure {
    /// Wall-clock time on one thread.
    Wall,
    /// Number of operations: pair checks, force evaluations and events.
    Work,
}

impl ChartPoint {
    /// Cost of one run of this point of the chart: wall-clock time [s] or number of operations [-].
    pub fn cost(&self, cost: CostMeasure) -> f64 {
        match cost {
            CostMeasure::Wall => self.wall.median,
            CostMeasure::Work => self.work,
        }
    }

    /// [-] error of the quantity with the index `quantity` at this point of the chart; `None` if unknown.
    pub fn error(&self, quantity: usize) -> Option<f64> {
        self.errors.get(quantity).copied().flatten().map(|found| found.error)
    }
}

/// Cheapest point among the points of the models in `models` whose error is at most `target` [-]. The error is that of
/// the quantity with the index `quantity`, plus two standard errors of this error. The two standard errors exclude
/// points whose error is small only by chance. `None` if there is no such point.
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
    /// Indices of the points on the Pareto front of the models in `models` for the quantity with the index `quantity`,
    /// in order of cost. A point is on this front if no other point of these models has both a smaller cost and a
    /// smaller error. Errors below the statistical floor (error by chance alone) are replaced by the floor.
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
