//! Pictures with rows of points on a logarithmic horizontal axis. Each row has a name and points of several kinds.

use super::chart::{COLOURS, GREY, MARKERS, WIDTH, plain, powers, style, svg, with_legend};
use kuva::plot::ScatterPlot;
use kuva::plot::legend::{LegendEntry, LegendShape};
use kuva::render::annotations::{ReferenceLine, ShadedRegion};
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use std::sync::Arc;

/// [px] height of a row of the picture without its points.
const ROW: f64 = 18.0;
/// [px] additional height of a row for each kind of points.
const DOT: f64 = 7.0;
/// [px] height of the axis, its label and the legend together.
const REST: f64 = 130.0;
/// Number of decades (powers of ten) by which the axis extends to the left of the vertical line at the value `mark`.
const DECADES: f64 = 2.0;

/// Point in a row of a picture with rows of points.
pub struct Dot {
    /// Index of the kind of points to which this point belongs.
    pub series: usize,
    /// [units of the axis] value of the point.
    pub value: f64,
    /// [units of the axis] standard error of the value; `None` if no error is drawn.
    pub error: Option<f64>,
    /// True if the answer for this value is certain (equivalent or different). Points with an uncertain answer have
    /// pale colours.
    pub sure: bool,
}

/// Data of a picture with rows of points on a logarithmic axis.
pub struct RowsFigure {
    /// Label of the horizontal axis.
    pub x_label: String,
    /// Names of the kinds of points.
    pub series: Vec<String>,
    /// Names of the rows with their points; the first row is at the top.
    pub rows: Vec<(String, Vec<Dot>)>,
    /// [units of the axis] value at which a vertical line is drawn, such as the largest accepted difference.
    pub mark: f64,
}

/// SVG picture of rows of points.
pub fn rows(picture: &RowsFigure) -> String {
    let floor = picture.mark * 10f64.powf(-DECADES);
    let ends = picture.rows.iter().flat_map(|row| &row.1).map(|dot| dot.value + dot.error.unwrap_or(0.0));
    let top = ends.filter(|end| end.is_finite()).fold(10.0 * picture.mark, f64::max);
    let top = 10f64.powf((1.05 * top).log10().ceil());
    let count = picture.rows.len() as f64;
    let mut plots = Vec::new();
    for (series, _) in picture.series.iter().enumerate() {
        for sure in [true, false] {
            plots.extend(points(picture, series, sure, floor));
        }
    }
    let names: Vec<String> = picture.rows.iter().map(|row| plain(&row.0)).collect();
    let mut layout = style(Layout::new((floor, top), (0.5, count + 0.5)))
        .with_x_axis_min(floor)
        .with_x_axis_max(top)
        .with_y_axis_min(0.5)
        .with_y_axis_max(count + 0.5)
        .with_y_tick_step(1.0)
        .with_log_x()
        .with_x_tick_format(powers())
        .with_y_tick_format(TickFormat::Custom(Arc::new(move |value| {
            let place = count + 1.0 - value;
            let whole = (place - place.round()).abs() < 1e-6 && place >= 0.5 && place < count + 0.5;
            if whole { names.get(place.round() as usize - 1).cloned().unwrap_or_default() } else { String::new() }
        })))
        .with_x_label(plain(&picture.x_label))
        .with_reference_line(ReferenceLine::vertical(picture.mark).with_color(GREY).with_dasharray("5 4"));
    for row in (0..picture.rows.len()).step_by(2) {
        let middle = count - row as f64;
        layout = layout.with_shaded_region(
            ShadedRegion::horizontal(middle - 0.5, middle + 0.5).with_color("#f1f1f1").with_opacity(1.0),
        );
    }
    let legend = picture.series.iter().enumerate().map(|(series, name)| LegendEntry {
        label: plain(name),
        color: COLOURS[series % COLOURS.len()].into(),
        shape: LegendShape::Marker(MARKERS[series % MARKERS.len()]),
        dasharray: None,
    });
    let layout = with_legend(layout, legend.collect());
    let height = REST + count * (ROW + DOT * picture.series.len() as f64);
    svg(&render_multiple(plots, layout.with_width(WIDTH).with_height(height)))
}

/// Plot of the points of one kind, given by the index `series` in the list of kinds. If `sure` is true, the plot
/// contains the points with a certain answer, otherwise those with an uncertain answer. Points below `floor` are drawn
/// at `floor`. `None` without points.
fn points(picture: &RowsFigure, series: usize, sure: bool, floor: f64) -> Option<Plot> {
    let kinds = picture.series.len() as f64;
    let (mut data, mut arms) = (Vec::new(), Vec::new());
    for (row, (_, dots)) in picture.rows.iter().enumerate() {
        for dot in dots.iter().filter(|dot| dot.series == series && dot.sure == sure && dot.value.is_finite()) {
            // each kind has its own height within the row; the first kind is at the top
            let place = (picture.rows.len() - row) as f64 + 0.7 * (0.5 - (series as f64 + 0.5) / kinds);
            let x = dot.value.max(floor);
            let error = dot.error.unwrap_or(0.0);
            data.push((x, place));
            arms.push((error.min(x - floor).max(0.0), (dot.value + error - x).max(0.0)));
        }
    }
    let plot = ScatterPlot::new().with_data(data.clone()).with_x_err_asymmetric(arms).with_size(4.0);
    let colour = COLOURS[series % COLOURS.len()];
    let plot = plot.with_color(if sure { colour.to_owned() } else { pale(colour) });
    (!data.is_empty()).then(|| Plot::Scatter(plot.with_marker(MARKERS[series % MARKERS.len()])))
}

/// Paler form of the colour `#rrggbb`: one part of the colour and two parts of white.
fn pale(colour: &str) -> String {
    let part =
        |k: usize| colour.get(2 * k + 1..2 * k + 3).and_then(|hex| u8::from_str_radix(hex, 16).ok()).unwrap_or(0);
    let mixed = |k: usize| (f64::from(part(k)) + 2.0 * 255.0) / 3.0;
    format!("#{:02x}{:02x}{:02x}", mixed(0) as u8, mixed(1) as u8, mixed(2) as u8)
}
