//! Grids of points for maps, and pictures of the results at these points.

use crate::output::limits::{Cell, Class, Picture, RegimeMap, Shade};
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};

/// Axis of a map: its label, the values of the points in ascending order, and true for a logarithmic axis.
pub struct MapAxis<'a>(pub &'a str, pub &'a [f64], pub bool);

/// Lower and upper end of the coloured cell around each of the ascending `values` of an axis. The ends lie halfway to
/// the neighbouring values. If `log` is true, they lie halfway between the logarithms.
fn edges(values: &[f64], log: bool) -> Vec<(f64, f64)> {
    let from = |at: f64| if log { at.exp() } else { at };
    let at: Vec<f64> = values.iter().map(|value| if log { value.ln() } else { *value }).collect();
    let half = |k: usize, l: usize| 0.5 * (at[l] - at[k]);
    let last = at.len() - 1;
    let end = |k: usize| {
        let below = if k > 0 { half(k - 1, k) } else { half(0, 1.min(last)) };
        let above = if k < last { half(k, k + 1) } else { below };
        // the cell of a value that is not negative does not extend below zero
        let low = from(at[k] - below);
        (if values[k] >= 0.0 { low.max(0.0) } else { low }, from(at[k] + above))
    };
    (0..at.len()).map(end).collect()
}

/// Picture of a map: a coloured cell around each point of a grid, and theoretical lines. Points are numbered row by
/// row, so that `x` changes fastest. `class` returns the index in `classes` of the point with a given number.
pub fn plane(
    x: &MapAxis,
    y: &MapAxis,
    classes: &[(&str, Shade)],
    class: impl Fn(usize) -> usize,
    lines: Vec<(&str, Vec<(f64, f64)>)>,
) -> Picture {
    let (across, up) = (edges(x.1, x.2), edges(y.1, y.2));
    let cells = points(&across, &up).into_iter().enumerate().map(|(k, (x, y))| Cell { x, y, class: class(k) });
    let classes = classes.iter().map(|&(label, shade)| Class { label: label.into(), shade });
    Picture::Cells(RegimeMap {
        x_label: x.0.into(),
        y_label: y.0.into(),
        log: [x.2, y.2],
        classes: classes.collect(),
        cells: cells.collect(),
        lines: lines.into_iter().map(|(label, points)| (label.into(), points)).collect(),
    })
}

/// Picture of curves. `labels` contains the label of the horizontal axis, then that of the vertical axis. `log_x` and
/// `log_y` are true for logarithmic axes, false for linear ones.
pub fn curves(labels: [&str; 2], [log_x, log_y]: [bool; 2], series: Vec<PanelSeries>) -> Picture {
    let [x_label, y_label] = labels.map(String::from);
    Picture::Curves(Panel { x_label, y_label, series, log_x, log_y, ..Panel::default() })
}

/// Curve of a picture through `points`, each given as abscissa and ordinate.
pub fn curve(label: impl Into<String>, look: SeriesStyle, points: impl Iterator<Item = [f64; 2]>) -> PanelSeries {
    PanelSeries::new(label, look, points.map(|[x, y]| SeriesPoint::at(x, y)))
}

/// Measured points of a picture, each given as abscissa, ordinate, and standard error of the ordinate. `place` is the
/// number of the marker and of the colour.
pub fn measured(label: impl Into<String>, place: usize, points: impl Iterator<Item = [f64; 3]>) -> PanelSeries {
    PanelSeries::new(
        label,
        SeriesStyle::Points(place),
        points.map(|[x, y, error]| SeriesPoint { x, y, error: Some(error) }),
    )
}

/// All pairs of a value of `x` and a value of `y`, with `x` changing fastest.
pub fn points<T: Copy>(x: &[T], y: &[T]) -> Vec<(T, T)> {
    y.iter().flat_map(|&y| x.iter().map(move |&x| (x, y))).collect()
}

/// List of `count` equally spaced values from `first` to `last`, rounded to nine decimals; `count` is at least 2.
pub fn even(first: f64, last: f64, count: usize) -> Vec<f64> {
    let step = (last - first) / (count - 1) as f64;
    // rounded to nine decimals; tables would otherwise show rounding errors, such as 0.30000000000000004
    (0..count).map(|k| ((first + step * k as f64) * 1e9).round() / 1e9).collect()
}

/// List of `count` values from `first` to `last` with a constant ratio of neighbours; `count` is at least 2.
pub fn ratios(first: f64, last: f64, count: usize) -> Vec<f64> {
    let ratio = (last / first).powf(1.0 / (count - 1) as f64);
    (0..count).map(|k| first * ratio.powi(k as i32)).collect()
}
