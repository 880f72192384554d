//! Document of the work-precision chart, which shows the error of each method as a function of its computing cost.

use crate::experiment::Model;
use crate::output::document::{Block, Document, Table, TextRow, columns, known, text};
use crate::output::numbers::{UNKNOWN, count, percent, quantity, significant, with_error};
use crate::output::{
    ChartPoint, ChartQuantity, ChartSlope, ChartStudy, CostMeasure, Folder, OutputError, cheapest, csv, figures,
};
use crate::statistics::Estimate;
use serde_json::json;
use std::path::PathBuf;

/// Writes all results of a work-precision chart, including the points of failed runs. Returns the path of the report.
///
/// # Errors
/// An [`OutputError`]. Files written before the error remain, but there is no `summary.json`.
pub fn write_chart(folder: &Folder, study: &ChartStudy) -> Result<PathBuf, OutputError> {
    let figures = figures::work_precision(study);
    let document = Document {
        provenance: study.provenance,
        failures: Vec::new(),
        verdicts: study.verdicts,
        // no answer is at the top of the page, because the body has a separate answer for each quantity
        answers: 0,
        front: Vec::new(),
        notes: study.notes,
        body: body(study, figures.len()),
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

/// Answers of a work-precision chart as a table for a terminal. For each quantity, the table has the cheapest soft and
/// the cheapest hard method with an error of at most 1 %, and those with an error of at most 0.1 %. The error includes
/// two of its standard errors. For each method, the table has the number of operations of one run.
pub fn chart_answers(study: &ChartStudy) -> String {
    let rows = study.quantities.iter().enumerate().flat_map(|(index, quantity)| {
        [(0.01, "1 %"), (0.001, "0.1 %")].map(|(target, words)| -> TextRow {
            let of = |model: Model| match cheapest(
                (study.methods, study.points),
                index,
                target,
                CostMeasure::Work,
                &[model],
            ) {
                _ if quantity.floor > target => format!("chance moves one run by {}", percent(quantity.floor, 1.0)),
                Some(point) => format!("{}: {}", study.knob(point), count(point.work.round() as u64)),
                None => "none for certain".into(),
            };
            (false, vec![quantity.name.to_owned(), words.to_owned(), of(Model::Soft), of(Model::Hard)])
        })
    });
    text(&[Block::table(
        "quantity | within | cheapest soft method: operations | cheapest hard method: operations",
        rows,
    )])
}

/// Explanation of the lines and marks in the diagrams, for the page.
const READING: &str = "Operations: pair checks, force evaluations and events of one run together; they are the same on every machine. Bars: one standard error. \
     Pale and broad: what no other point beats; thin dashed: the same among soft methods. Diamond: the cheapest within 1 % for certain. Line marked chance: what chance alone \
     makes of one run, where there is chance; points below it say no more than points on it. Points on the lower frame: errors of 1e-9 or less. Stars on the upper frame: \
     failures, at the cost until then.";

/// Main part of the page: for each quantity a diagram and the cheapest methods, then the data.
fn body(study: &ChartStudy, figures: usize) -> Vec<Block> {
    let mut body = vec![
        Block::entries([("each point", study.setting.to_owned()), ("reference", study.reference.to_owned())]),
        Block::note(READING),
    ];
    for (index, quantity) in study.quantities.iter().enumerate() {
        body.extend([
            Block::Section(quantity.key, quantity.name.to_owned()),
            Block::Verdict(study.aloud(index)),
            Block::Figures(index..index + 1),
        ]);
    }
    body.extend([
        Block::heading("Against wall-clock time"),
        Block::Figures(study.quantities.len()..figures),
        Block::heading("References and floors"),
        Block::table(
            "quantity | reference ± 1 SE | error | statistical floor",
            study.quantities.iter().map(|quantity| (false, reference(quantity))),
        ),
        Block::note(
            "Statistical floor: standard deviation of one run beside the reference, from the scatter between the reference’s own runs. \
             References of profiles: the root mean square over slices.",
        ),
    ]);
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
        Some((false, vec![study.knob(point), why.kind().into(), why.to_string()]))
    };
    if study.points.iter().any(|point| point.failure.is_some()) {
        body.push(Block::heading("Failures"));
        body.push(Block::table("method | kind | cause", study.points.iter().filter_map(failed)));
    }
    body
}

fn reference(of: &ChartQuantity) -> Vec<String> {
    let floor = if of.floor > 0.0 { significant(of.floor, 2) } else { "none".into() };
    let reference = if of.reference.error > Some(0.0) {
        with_error(of.reference)
    } else {
        format!("{}, exact", significant(of.reference.value, 6))
    };
    vec![of.name.to_owned(), format!("{reference} {}", of.unit).trim_end().to_owned(), of.axis.to_owned(), floor]
}

impl ChartStudy<'_> {
    /// Sentence that names the cheapest soft and the cheapest hard method whose error in the quantity with the index
    /// `index` is at most 1 %.
    fn aloud(&self, index: usize) -> String {
        let (target, words) = figures::WITHIN;
        let floor = self.quantities[index].floor;
        if floor > target {
            return format!("No method wins within {words}: chance alone moves one run by {}.", percent(floor, 1.0));
        }
        let of = |models: &[Model]| cheapest((self.methods, self.points), index, target, CostMeasure::Work, models);
        let (soft, hard) = (of(&[Model::Soft]), of(&[Model::Hard]));
        let times = |more: &ChartPoint, less: &ChartPoint| significant(more.work / less.work, 2);
        match (soft, hard) {
            (None, None) => format!("Nothing stays within {words} for certain."),
            (Some(soft), None) => format!(
                "Within {words} soft spheres win, by {}; no hard method gets there for certain.",
                self.knob(soft)
            ),
            (None, Some(hard)) => format!(
                "Within {words} hard spheres win, by {}; no soft method gets there for certain.",
                self.knob(hard)
            ),
            (Some(soft), Some(hard)) if hard.work <= soft.work => format!(
                "Within {words} hard spheres win: the best soft method, {}, takes {} times as many operations.",
                self.knob(soft),
                times(soft, hard)
            ),
            (Some(soft), Some(hard)) => format!(
                "Within {words} soft spheres win, by {}: hard spheres take {} times as many operations.",
                self.knob(soft),
                times(hard, soft)
            ),
        }
    }

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

    /// Name of the method of a point, followed by the value of the parameter of this method that is swept (varied).
    fn knob(&self, point: &ChartPoint) -> String {
        let method = &self.methods[point.method];
        let value = if method.unit == "s" { quantity(point.knob, "s", 3) } else { significant(point.knob, 4) };
        let unit = if method.unit == "s" { "" } else { method.unit };
        format!("{}, {} = {value} {unit}", method.name, method.knob).trim_end().to_owned()
    }

    /// Table of all points of the chart, with their errors in every quantity.
    fn table(&self) -> Block {
        let both = [Model::Soft, Model::Hard];
        let fronts: Vec<_> =
            (0..self.quantities.len()).map(|index| self.front(index, CostMeasure::Work, &both)).collect();
        let row = |(place, point): (usize, &ChartPoint)| -> TextRow {
            let c = &point.counters;
            let each = |total: u64| {
                let mean = total as f64 / point.samples.max(1) as f64;
                known(total > 0, count(mean.round() as u64))
            };
            let error = |(index, front): (usize, &Vec<usize>)| match (&point.failure, point.errors.get(index)) {
                (Some(_), _) => "failed".into(),
                (None, Some(Some(found))) => {
                    let mark = if front.contains(&place) { " •" } else { "" };
                    format!("{}{mark}", with_error(Estimate { value: found.error, error: found.uncertainty }))
                }
                (None, _) => UNKNOWN.into(),
            };
            let counts = [c.steps, c.pair_checks, c.force_evaluations, c.events].map(each);
            let head = [self.knob(point), quantity(point.wall.median, "s", 2)].into_iter().chain(counts);
            (point.failure.is_some(), head.chain(fronts.iter().enumerate().map(error)).collect())
        };
        let head = columns("method | wall time | steps | pair checks | force evaluations | events").into_iter();
        Block::Table(Table {
            head: head.chain(self.quantities.iter().map(|quantity| quantity.name.to_owned())).collect(),
            rows: self.points.iter().enumerate().map(row).collect(),
            remarks: false,
        })
    }
}
