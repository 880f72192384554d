//! What the chart of work against precision hands to the outputs: plain data.

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
    /// What it is, in words.
    pub name: &'static str,
    /// What its error is, for an axis: `|e − e₀|/e₀`.
    pub axis: &'static str,
    /// The value that all are measured against, and its own standard error; in `unit`.
    pub reference: Estimate,
    /// Unit of value and reference, empty for none.
    pub unit: &'static str,
    /// [-] statistical floor: the error that one run shows by chance alone, from the scatter of the reference's runs; 0 where
    /// there is no chance.
    pub floor: f64,
}

/// The error of one point in one quantity, as charted [-].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PointError {
    /// The value found, in the quantity's unit.
    pub value: f64,
    /// [-] its error.
    pub error: f64,
    /// [-] standard error of that error; `None` if it is not known.
    pub uncertainty: Option<f64>,
    /// Smallest and largest value among the samples, in the quantity's unit; `None` for a single run.
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

/// Why a point has no result.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum ChartFailure {
    /// The engine stopped.
    #[error("{0}")]
    Engine(Failure),
    /// The impact had not ended when the time of the case was over.
    #[error("the impact had not ended when the time of the case was over")]
    Unfinished,
}

impl ChartFailure {
    /// The type of the failure as one word, as it stands in JSON.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Engine(failure) => failure.kind(),
            Self::Unfinished => "unfinished",
        }
    }
}

/// One method at one setting of its knob.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartPoint {
    /// Index into [`ChartStudy::methods`].
    pub method: usize,
    /// Value of the knob, in the unit of the knob.
    pub knob: f64,
    /// Runs behind it.
    pub samples: usize,
    /// Wall-clock time of one run.
    pub wall: CostSpread,
    /// Work of all its runs together, the same on every machine.
    pub counters: Counters,
    /// [-] pair checks, force evaluations and events of one run.
    pub work: f64,
    /// One per quantity in the order of [`ChartStudy::quantities`]; `None` where the point does not know it.
    pub errors: Vec<Option<PointError>>,
    /// Why there are none.
    pub failure: Option<ChartFailure>,
}

/// A method and the knob it is swept over.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartMethod {
    /// Name.
    pub name: String,
    /// Collision model.
    pub model: Model,
    /// Symbol of the knob.
    pub knob: &'static str,
    /// Its unit, empty for none.
    pub unit: &'static str,
}

/// How the error of a method falls with its knob.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartSlope {
    /// Index into [`ChartStudy::methods`].
    pub method: usize,
    /// Index into [`ChartStudy::quantities`].
    pub quantity: usize,
    /// The fit.
    #[serde(flatten)]
    pub law: PowerLaw,
    /// Knob at both ends of what was fitted.
    pub range: (f64, f64),
}

impl ChartSlope {
    /// The exponent with its error, to two places at most: the scatter about a line says nothing of what bends it.
    pub fn exponent(&self) -> String {
        let law = &self.law;
        if law.error < 0.01 {
            format!("{:.2} ± less than 0.01", law.exponent).replace('-', "−")
        } else {
            with_error(Estimate::new(law.exponent, law.error))
        }
    }
}

/// Everything outputs need to know of a chart.
#[derive(Clone, Copy, Debug)]
pub struct ChartStudy<'a> {
    /// Where it comes from.
    pub provenance: &'a Provenance,
    /// What the errors are measured against, and how well that is known.
    pub reference: &'a str,
    /// What was run for each point.
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
    /// What limits how far the numbers can be trusted.
    pub notes: &'a [String],
}

/// What a cost is counted in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CostMeasure {
    /// Wall-clock time on one thread.
    Wall,
    /// Pair checks, force evaluations and events.
    Work,
}

impl ChartPoint {
    /// The cost: [s] or a count.
    pub fn cost(&self, cost: CostMeasure) -> f64 {
        match cost {
            CostMeasure::Wall => self.wall.median,
            CostMeasure::Work => self.work,
        }
    }

    /// [-] the error in a quantity; `None` where not known.
    pub fn error(&self, quantity: usize) -> Option<f64> {
        self.errors.get(quantity).copied().flatten().map(|found| found.error)
    }
}

/// The cheapest of some models whose error in a quantity is within `target` [-] for certain: it counts with twice its uncertainty, so that luck
/// does not win.
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
    /// Indices of the points of some models that no other of these beats in a quantity, in the order of cost. Errors below the statistical floor
    /// count as the floor: chance is no precision.
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
