//! Figures of the work-precision chart: the error of each method as a function of its computing cost.

use super::chart;
use crate::experiment::Model;
use crate::output::panel::Figure;
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::output::{ChartStudy, CostMeasure, cheapest};

/// [-] smallest error on the vertical axis. Smaller errors are drawn on the lower frame of the picture.
const LOWEST: f64 = 1e-9;

/// [-] largest error with which a method may be marked as the cheapest, as a number and as text.
pub const WITHIN: (f64, &str) = (0.01, "1 %");

/// Figures of the error of each quantity. The first figures show the error as a function of the number of operations,
/// the other figures as a function of wall-clock time.
pub fn work_precision(study: &ChartStudy) -> Vec<Figure> {
    let all = |cost: CostMeasure, name: &'static str, words: &'static str| {
        study.quantities.iter().enumerate().map(move |(index, quantity)| {
            let caption = format!("{}: error against {words}.", quantity.name);
            Figure::new(format!("{}-{name}", quantity.key), caption, picture(study, index, cost))
        })
    };
    let by_work = all(CostMeasure::Work, "operations", "operations");
    by_work.chain(all(CostMeasure::Wall, "wall", "wall-clock time on one thread")).collect()
}

fn picture(study: &ChartStudy, index: usize, cost: CostMeasure) -> String {
    let at = |place: usize| {
        let point = &study.points[place];
        let found = point.errors.get(index).copied().flatten()?;
        // an error of 0 becomes the smallest positive number, so that the point is drawn on the lower frame
        let y = found.error.max(f64::MIN_POSITIVE);
        Some(SeriesPoint { x: point.cost(cost), y, error: found.uncertainty })
    };
    let front = |models: &[Model]| -> Vec<SeriesPoint> {
        let places = study.front(index, cost, models).into_iter();
        places.filter_map(at).map(|p| SeriesPoint { error: None, ..p }).collect()
    };
    let mut series = vec![
        PanelSeries {
            label: "not beaten".into(),
            look: SeriesStyle::Front,
            points: front(&[Model::Soft, Model::Hard]),
        },
        PanelSeries { label: "not beaten by soft".into(), look: SeriesStyle::Reference, points: front(&[Model::Soft]) },
    ];
    for (place, method) in study.methods.iter().enumerate() {
        let of = |k: &usize| study.points[*k].method == place;
        let points: Vec<SeriesPoint> = (0..study.points.len()).filter(of).filter_map(at).collect();
        series.push(PanelSeries { label: method.name.clone(), look: SeriesStyle::Sweep(place), points });
    }
    for place in 0..study.methods.len() {
        let failed = study.points.iter().filter(|point| point.method == place && point.failure.is_some());
        let points = failed.map(|point| SeriesPoint::at(point.cost(cost), 1.0)).collect();
        // all failures have one entry in the legend, in the colours of their methods
        series.push(PanelSeries { label: "failed (colour: method)".into(), look: SeriesStyle::Failed(place), points });
    }
    let both = [Model::Soft, Model::Hard];
    let winner = cheapest((study.methods, study.points), index, WITHIN.0, cost, &both);
    let winner = winner.and_then(|winner| study.points.iter().position(|point| std::ptr::eq(point, winner)));
    let points = winner.and_then(at).map(|point| SeriesPoint { error: None, ..point });
    series.push(PanelSeries::new(format!("cheapest within {}", WITHIN.1), SeriesStyle::Winner, points));
    let floor = study.quantities[index].floor;
    chart::single(&Panel {
        x_label: match cost {
            CostMeasure::Wall => "wall-clock time of one run, one thread  [s]".into(),
            CostMeasure::Work => "operations of one run".into(),
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
