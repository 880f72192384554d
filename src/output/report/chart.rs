//! The page of a chart of work against precision.

use super::{dictionary, note, page, pictures, table};
use crate::experiment::Model;
use crate::output::figures::Figure;
use crate::output::numbers::{UNKNOWN, count, quantity, significant, with_error};
use crate::output::{ChartPoint, ChartStudy, Cost};
use maud::{Markup, html};

/// The page of a chart.
pub fn chart(study: &ChartStudy, figures: &[Figure]) -> String {
    let setting = [("each point", study.setting.to_owned()), ("reference", study.reference.to_owned())];
    let body = html! {
        (dictionary(&setting))
        h2 { "Pictures" }
        (pictures(figures))
        h2 { "References and floors" }
        (references(study))
        @if !study.slopes.is_empty() {
            h2 { "How errors fall" }
            (slopes(study))
        }
        h2 { "All points" }
        (points(study))
        @if study.points.iter().any(|point| point.failure.is_some()) {
            h2 { "Failures" }
            (failures(study))
        }
    };
    page(study.provenance, study.verdicts, study.notes, &body, &html! {})
}

fn references(study: &ChartStudy) -> Markup {
    let row = |of: &crate::output::ChartQuantity| {
        let floor = if of.floor > 0.0 { significant(of.floor, 2) } else { "none".into() };
        let reference = if of.reference.error > 0.0 {
            with_error(of.reference.value, of.reference.error)
        } else {
            format!("{}, exact", significant(of.reference.value, 6))
        };
        (
            false,
            vec![
                of.name.to_owned(),
                format!("{reference} {}", of.unit).trim_end().to_owned(),
                of.axis.to_owned(),
                floor,
            ],
        )
    };
    html! {
        (table(&["quantity", "reference ± 1 SE", "error", "statistical floor"], &study.quantities.iter().map(row).collect::<Vec<_>>()))
        (note("Statistical floor: standard deviation of one run beside the reference, from the scatter between the reference’s own runs. \
            References of profiles: the root mean square over slices."))
    }
}

fn slopes(study: &ChartStudy) -> Markup {
    let row = |slope: &crate::output::ChartSlope| {
        let method = &study.methods[slope.method];
        let unit = if method.unit.is_empty() { String::new() } else { format!(" {}", method.unit) };
        let cells = vec![
            study.quantities[slope.quantity].name.to_owned(),
            method.name.clone(),
            format!("{}^p", method.knob),
            slope.exponent(),
            slope.law.points.to_string(),
            format!("{} … {}{unit}", significant(slope.range.0, 3), significant(slope.range.1, 3)),
        ];
        (false, cells)
    };
    html! {
        (table(&["quantity", "method", "error as", "p ± 1 SE", "points", "knob"], &study.slopes.iter().map(row).collect::<Vec<_>>()))
        (note("Least squares on logarithms over the finest three to five points, whichever lie closest to a line, after the last change of sign; \
            points count whose errors are beyond 3 SE of chance and above 1e-12 of rounding. The error of p is the scatter about the line."))
    }
}

fn knob(study: &ChartStudy, point: &ChartPoint) -> String {
    let method = &study.methods[point.method];
    let value = if method.unit == "s" { quantity(point.knob, "s", 3) } else { significant(point.knob, 4) };
    let unit = if method.unit == "s" { "" } else { method.unit };
    format!("{}, {} = {value} {unit}", method.name, method.knob).trim_end().to_owned()
}

fn points(study: &ChartStudy) -> Markup {
    let fronts: Vec<_> =
        (0..study.quantities.len()).map(|index| study.front(index, Cost::Work, &[Model::Soft, Model::Hard])).collect();
    let row = |(place, point): (usize, &ChartPoint)| {
        let c = &point.counters;
        let each = |total: u64| {
            let mean = total as f64 / point.samples.max(1) as f64;
            if total == 0 { UNKNOWN.into() } else { count(mean.round() as u64) }
        };
        let wall = quantity(point.wall.median, "s", 2);
        let mut cells = vec![
            knob(study, point),
            wall,
            each(c.steps),
            each(c.pair_checks),
            each(c.force_evaluations),
            each(c.events),
        ];
        for (index, front) in fronts.iter().enumerate() {
            let cell = match (&point.failure, point.errors.get(index).copied().flatten()) {
                (Some(_), _) => "failed".into(),
                (None, Some(found)) => {
                    let mark = if front.contains(&place) { " •" } else { "" };
                    format!("{}{mark}", with_error(found.error, found.uncertainty))
                }
                (None, None) => UNKNOWN.into(),
            };
            cells.push(cell);
        }
        (point.failure.is_some(), cells)
    };
    let rows: Vec<_> = study.points.iter().enumerate().map(row).collect();
    let head = ["method", "wall time", "steps", "pair checks", "force evaluations", "events"];
    let head: Vec<&str> = head.into_iter().chain(study.quantities.iter().map(|quantity| quantity.name)).collect();
    html! {
        (table(&head, &rows))
        (note("Times and counts of one run, errors as shares ± 1 SE. •: no other point has the same or a smaller error for the same or \
            fewer operations."))
    }
}

fn failures(study: &ChartStudy) -> Markup {
    let row = |point: &ChartPoint| {
        let why = point.failure.as_ref()?;
        Some((false, vec![knob(study, point), why.kind(), why.to_string()]))
    };
    table(&["method", "kind", "cause"], &study.points.iter().filter_map(row).collect::<Vec<_>>())
}
