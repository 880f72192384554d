//! Figures of a sweep: each observable as a function of the first varied key. A point of the sweep is one value for
//! each varied key. A variant is one of the experiments of a case.

use super::chart;
use super::limits::x_range;
use crate::case::SweepAxis;
use crate::output::panel::{Figure, Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::output::sweep::{OBSERVABLES, SweepObservable, SweepRow, SweepStudy};

/// Figures of all observables that are known at one or more points of the sweep. The first varied key is on the
/// horizontal axis. There is a curve for each variant (experiment of a case) and each combination of values of the
/// other keys.
pub fn sweep(study: &SweepStudy) -> Vec<Figure> {
    let Some(axis) = study.axes.first() else { return Vec::new() };
    let known = |observable: &&SweepObservable| study.rows.iter().any(|row| row.measured(observable.key).is_some());
    let picture = |observable: &SweepObservable| {
        let caption = format!(
            "{} over `{}`. Bars and bands: one standard error, where it is known. A line with a band is one run that the key does not \
             change. Stars on the upper frame: runs that stopped early.{}",
            observable.name,
            axis.key,
            places(axis)
        );
        let name = format!("sweep-{}", super::file_name(observable.name));
        let panel = panel(study, axis, observable);
        Figure::new(name, caption, chart::single(&Panel { x_range: x_range(&panel), ..panel }))
    };
    OBSERVABLES.iter().filter(known).map(picture).collect()
}

/// Legend for a key whose values are words: the number at which each value is drawn on the horizontal axis. Empty for a
/// key whose values are numbers.
fn places(axis: &SweepAxis) -> String {
    if axis.numbers.is_some() {
        return String::new();
    }
    let places = axis.typed.iter().enumerate().map(|(place, typed)| format!("{}: {typed}", place + 1));
    format!(" Places: {}.", places.collect::<Vec<_>>().join(", "))
}

fn panel(study: &SweepStudy, axis: &SweepAxis, observable: &SweepObservable) -> Panel {
    let x = |row: &SweepRow| match &axis.numbers {
        Some(numbers) => numbers[row.at[0]],
        None => row.at[0] as f64 + 1.0,
    };
    // one curve for each variant and each combination of values of the other keys
    let mut curves: Vec<(usize, &[usize], Vec<&SweepRow>)> = Vec::new();
    for row in study.rows {
        match curves.iter_mut().find(|(variant, others, _)| (*variant, *others) == (row.variant, &row.at[1..])) {
            Some((.., rows)) => rows.push(row),
            None => curves.push((row.variant, &row.at[1..], vec![row])),
        }
    }
    let mut series = Vec::new();
    for (place, (variant, others, mut rows)) in curves.into_iter().enumerate() {
        rows.sort_by(|a, b| x(a).total_cmp(&x(b)));
        let points = rows.iter().filter_map(|row| {
            let found = row.measured(observable.key)?;
            Some(SeriesPoint { x: x(row), y: found.value, error: found.error })
        });
        let same = rows.len() > 1 && rows.iter().all(|row| row.identities == rows[0].identities);
        let look = if same { SeriesStyle::Line(place) } else { SeriesStyle::Sweep(place) };
        let mut label = study.variants[variant].clone();
        if !others.is_empty() {
            label += &format!(", {}", crate::output::sweep::point(&study.axes[1..], others));
        }
        series.push(PanelSeries::new(label, look, points));
        let stopped = rows.iter().filter(|row| row.failure().is_some()).map(|row| SeriesPoint::at(x(row), 1.0));
        series.push(PanelSeries::new("stopped early", SeriesStyle::Failed(place), stopped));
    }
    series.retain(|series| !series.points.is_empty());
    let unit = axis.unit.as_ref().map_or(String::new(), |unit| format!("  [{unit}]"));
    Panel {
        x_label: format!("{}{unit}", axis.name()),
        y_label: observable.axis.into(),
        series,
        log_x: axis.numbers.as_deref().is_some_and(is_wide),
        ..Panel::default()
    }
}

/// True if all values are positive and the largest is at least ten times the smallest, so that the axis is logarithmic.
fn is_wide(numbers: &[f64]) -> bool {
    let (low, high) =
        numbers.iter().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), &x| (low.min(x), high.max(x)));
    low > 0.0 && high >= 10.0 * low
}
