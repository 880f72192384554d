//! Error against cost.

use super::chart;
use crate::experiment::Model;
use crate::output::panel::Figure;
use crate::output::panel::{Look, Panel, Point, Series};
use crate::output::{ChartStudy, Cost};

/// [-] errors below this stand on the lower frame: it is as near to none as a picture needs to tell.
const LOWEST: f64 = 1e-9;

/// Two pictures per quantity: error against wall-clock time, and against operations.
pub fn work_precision(study: &ChartStudy) -> Vec<Figure> {
    let mut figures = Vec::new();
    for (index, quantity) in study.quantities.iter().enumerate() {
        for (cost, name, words) in
            [(Cost::Wall, "wall", "wall-clock time on one thread"), (Cost::Work, "operations", "operations")]
        {
            let floor = if quantity.floor > 0.0 {
                " Line marked chance: what chance alone makes of one run; points below it say no more than points on it."
            } else {
                ""
            };
            let caption = format!(
                "{}: error against {words}. Bars: one standard error. Pale and broad: what no other point beats; thin dashed: the \
                 same among soft methods.{floor} Points on the lower frame: errors of 1e-9 or less. Stars on \
                 the upper frame: failures, at the cost until then.",
                quantity.name
            );
            figures.push(Figure::new(format!("{}-{name}", quantity.key), caption, picture(study, index, cost)));
        }
    }
    figures
}

fn picture(study: &ChartStudy, index: usize, cost: Cost) -> String {
    let at = |place: usize| {
        let point = &study.points[place];
        let found = point.errors.get(index).copied().flatten()?;
        // without an error at all it stands on the lower frame, not off the chart
        let y = found.error.max(f64::MIN_POSITIVE);
        Some(Point { x: point.cost(cost), y, error: found.uncertainty })
    };
    let front = |models: &[Model]| -> Vec<Point> {
        let places = study.front(index, cost, models).into_iter();
        places.filter_map(at).map(|p| Point { error: None, ..p }).collect()
    };
    let mut series = vec![
        Series { label: "not beaten".into(), look: Look::Front, points: front(&[Model::Soft, Model::Hard]) },
        Series { label: "not beaten by soft".into(), look: Look::Reference, points: front(&[Model::Soft]) },
    ];
    for (place, method) in study.methods.iter().enumerate() {
        let of = |k: &usize| study.points[*k].method == place;
        let points: Vec<Point> = (0..study.points.len()).filter(of).filter_map(at).collect();
        series.push(Series { label: method.name.clone(), look: Look::Sweep(place), points });
    }
    for place in 0..study.methods.len() {
        let failed = study.points.iter().filter(|point| point.method == place && point.failure.is_some());
        let points = failed.map(|point| Point::at(point.cost(cost), 1.0)).collect();
        // one entry in the legend: the colour tells the method
        series.push(Series { label: "failed (colour: method)".into(), look: Look::Failed(place), points });
    }
    let floor = study.quantities[index].floor;
    chart::single(&Panel {
        x_label: match cost {
            Cost::Wall => "wall-clock time of one run, one thread  [s]".into(),
            Cost::Work => "pair checks + force evaluations + events of one run".into(),
        },
        y_label: study.quantities[index].axis.into(),
        series,
        marks: if floor > 0.0 { vec![(floor, "chance")] } else { Vec::new() },
        log_x: true,
        log_y: true,
        floor: Some(LOWEST),
        ..Panel::default()
    })
}
