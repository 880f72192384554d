//! The chart of work against precision: its data and its document.

use super::document::{Block, Document, Row, columns, known};
use super::numbers::{UNKNOWN, count, quantity, significant, with_error};
use super::{Folder, OutputError, Provenance, csv, document, figures};
use crate::engine::{Counters, Failure};
use crate::experiment::Model;
use crate::statistics::{Estimate, PowerLaw};
use serde::Serialize;
use serde_json::json;
use std::path::PathBuf;

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
    /// [-] standard error of that error.
    pub uncertainty: f64,
    /// Smallest value among the samples, in the quantity's unit; NaN for a single run.
    pub lowest: f64,
    /// Largest.
    pub highest: f64,
}

/// Wall-clock time on one thread [s].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
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
    pub fn kind(&self) -> String {
        let of = |value: serde_json::Value| match value {
            serde_json::Value::Object(map) => map.into_iter().next().map(|(key, _)| key),
            serde_json::Value::String(name) => Some(name),
            _ => None,
        };
        let value = match self {
            Self::Engine(failure) => serde_json::to_value(failure),
            Self::Unfinished => serde_json::to_value(self),
        };
        value.ok().and_then(of).unwrap_or_else(|| "failure".into())
    }
}

/// One method at one setting of its knob.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartPoint {
    /// Index into [`ChartStudy::methods`].
    pub method: usize,
    /// Value of the knob, in the knob's unit.
    pub knob: f64,
    /// Runs behind it.
    pub samples: usize,
    /// Wall-clock time of one run.
    pub wall: Spread,
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
            with_error(law.exponent, law.error)
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
pub enum Cost {
    /// Wall-clock time on one thread.
    Wall,
    /// Pair checks, force evaluations and events.
    Work,
}

impl ChartPoint {
    /// The cost: [s] or a count.
    pub fn cost(&self, cost: Cost) -> f64 {
        match cost {
            Cost::Wall => self.wall.median,
            Cost::Work => self.work,
        }
    }

    /// [-] the error in a quantity; NaN where not known.
    pub fn error(&self, quantity: usize) -> f64 {
        self.errors.get(quantity).copied().flatten().map_or(f64::NAN, |found| found.error)
    }
}

impl ChartStudy<'_> {
    /// Indices of the points of some models that no other of these beats in a quantity, in the order of cost. Errors below the statistical floor
    /// count as the floor: chance is no precision.
    pub fn front(&self, quantity: usize, cost: Cost, models: &[Model]) -> Vec<usize> {
        let floor = self.quantities.get(quantity).map_or(0.0, |quantity| quantity.floor);
        // f64::max would take the floor for an error that is not known
        let known = |point: &ChartPoint| {
            let asked = models.contains(&self.methods[point.method].model);
            if asked && !point.error(quantity).is_nan() { point.error(quantity).max(floor) } else { f64::NAN }
        };
        let points: Vec<(f64, f64)> = self.points.iter().map(|point| (point.cost(cost), known(point))).collect();
        crate::statistics::pareto_front(&points)
    }
}

/// Writes everything a chart leaves behind; a method that fails is a result of a chart. Returns the path of the report.
///
/// # Errors
/// An [`OutputError`]; the files written before it stay, without a `summary.json`.
pub fn write_chart(folder: &Folder, study: &ChartStudy) -> Result<PathBuf, OutputError> {
    let figures = figures::work_precision(study);
    let mut body = vec![
        Block::entries([("each point", study.setting.to_owned()), ("reference", study.reference.to_owned())]),
        Block::heading("Pictures"),
        Block::Figures(0..figures.len()),
        Block::heading("References and floors"),
        Block::table(
            "quantity | reference ± 1 SE | error | statistical floor",
            study.quantities.iter().map(|quantity| (false, reference(quantity))),
        ),
        Block::note(
            "Statistical floor: standard deviation of one run beside the reference, from the scatter between the reference’s own runs. \
             References of profiles: the root mean square over slices.",
        ),
    ];
    if !study.slopes.is_empty() {
        body.extend([
            Block::heading("How errors fall"),
            Block::table(
                "quantity | method | error as | p ± 1 SE | points | knob",
                study.slopes.iter().map(|slope| (false, study.slope(slope))),
            ),
            Block::note(
                "Least squares on logarithms over the finest three to five points, whichever lie closest to a line, after the last change of sign; \
                 points count whose errors are beyond 3 SE of chance and above 1e-12 of rounding. The error of p is the scatter about the line.",
            ),
        ]);
    }
    body.extend([
        Block::heading("All points"),
        study.table(),
        Block::note(
            "Times and counts of one run, errors as shares ± 1 SE. •: no other point has the same or a smaller error for the same or \
             fewer operations.",
        ),
    ]);
    let failed = |point: &ChartPoint| {
        let why = point.failure.as_ref()?;
        Some((false, vec![study.knob(point), why.kind(), why.to_string()]))
    };
    if study.points.iter().any(|point| point.failure.is_some()) {
        body.push(Block::heading("Failures"));
        body.push(Block::table("method | kind | cause", study.points.iter().filter_map(failed)));
    }
    let document = Document {
        provenance: study.provenance,
        failures: Vec::new(),
        verdicts: study.verdicts,
        notes: study.notes,
        body,
        tail: Vec::new(),
        tables: vec![("chart.csv".into(), csv::chart(study)?)],
        figures,
    };
    let numbers = json!({
        "reference": study.reference,
        "setting": study.setting,
        "methods": study.methods,
        "quantities": study.quantities,
        "points": study.points,
        "slopes": study.slopes,
    });
    document.write(folder, numbers)
}

fn reference(of: &ChartQuantity) -> Vec<String> {
    let floor = if of.floor > 0.0 { significant(of.floor, 2) } else { "none".into() };
    let reference = if of.reference.error > 0.0 {
        with_error(of.reference.value, of.reference.error)
    } else {
        format!("{}, exact", significant(of.reference.value, 6))
    };
    vec![of.name.to_owned(), format!("{reference} {}", of.unit).trim_end().to_owned(), of.axis.to_owned(), floor]
}

impl ChartStudy<'_> {
    fn slope(&self, slope: &ChartSlope) -> Vec<String> {
        let method = &self.methods[slope.method];
        let range = format!("{} … {} {}", significant(slope.range.0, 3), significant(slope.range.1, 3), method.unit);
        vec![
            self.quantities[slope.quantity].name.to_owned(),
            method.name.clone(),
            format!("{}^p", method.knob),
            slope.exponent(),
            slope.law.points.to_string(),
            range.trim_end().to_owned(),
        ]
    }

    /// Method and setting of a point.
    fn knob(&self, point: &ChartPoint) -> String {
        let method = &self.methods[point.method];
        let value = if method.unit == "s" { quantity(point.knob, "s", 3) } else { significant(point.knob, 4) };
        let unit = if method.unit == "s" { "" } else { method.unit };
        format!("{}, {} = {value} {unit}", method.name, method.knob).trim_end().to_owned()
    }

    /// All points, with their errors in every quantity.
    fn table(&self) -> Block {
        let both = [Model::Soft, Model::Hard];
        let fronts: Vec<_> = (0..self.quantities.len()).map(|index| self.front(index, Cost::Work, &both)).collect();
        let row = |(place, point): (usize, &ChartPoint)| -> Row {
            let c = &point.counters;
            let each = |total: u64| {
                let mean = total as f64 / point.samples.max(1) as f64;
                known(total > 0, count(mean.round() as u64))
            };
            let error = |(index, front): (usize, &Vec<usize>)| match (&point.failure, point.errors.get(index)) {
                (Some(_), _) => "failed".into(),
                (None, Some(Some(found))) => {
                    let mark = if front.contains(&place) { " •" } else { "" };
                    format!("{}{mark}", with_error(found.error, found.uncertainty))
                }
                (None, _) => UNKNOWN.into(),
            };
            let counts = [c.steps, c.pair_checks, c.force_evaluations, c.events].map(each);
            let head = [self.knob(point), quantity(point.wall.median, "s", 2)].into_iter().chain(counts);
            (point.failure.is_some(), head.chain(fronts.iter().enumerate().map(error)).collect())
        };
        let head = columns("method | wall time | steps | pair checks | force evaluations | events").into_iter();
        Block::Table(document::Table {
            head: head.chain(self.quantities.iter().map(|quantity| quantity.name.to_owned())).collect(),
            rows: self.points.iter().enumerate().map(row).collect(),
            remarks: false,
        })
    }
}
