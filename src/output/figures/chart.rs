//! Common style of all pictures. Only this file, `cells`, `map` and `rows` use the plotting library kuva.
//!
//! The colours are those of Okabe and Ito, which colour-blind readers can distinguish. Each colour has a separate dash
//! pattern and marker, so that pictures are readable in black and white.

use crate::output::numbers::{significant, superscript};
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};
use kuva::backend::svg::SvgBackend;
use kuva::plot::legend::{LegendEntry, LegendPosition, LegendShape};
use kuva::plot::scatter::MarkerShape;
use kuva::plot::{BandPlot, LinePlot, LineStyle, ScatterPlot};
use kuva::render::annotations::{ReferenceLine, TextAnnotation};
use kuva::render::figure::Figure;
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render::{Scene, render_multiple};
use kuva::render::theme::Theme;
use std::sync::Arc;

/// [px] width of every picture.
pub(super) const WIDTH: f64 = 640.0;
/// [px] height of a picture with one panel.
pub(super) const HEIGHT: f64 = 400.0;
/// [px] height of one panel if there are several.
const PANEL_HEIGHT: f64 = 250.0;
/// Number of decades (powers of ten) by which a logarithmic vertical axis extends below the largest value, unless the
/// panel gives another lower end. The labels of more decades would not fit.
const DECADES: i32 = 6;
/// Colour of curves that are drawn only as a reference.
pub(super) const GREY: &str = "#777777";

pub(super) const COLOURS: [&str; 7] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"];
const DASHES: [&str; 6] = ["", "8 3", "2 2.5", "9 3 2 3", "14 4", "5 2 1 2 1 2"];
pub(super) const MARKERS: [MarkerShape; 6] = [
    MarkerShape::Circle,
    MarkerShape::Square,
    MarkerShape::Triangle,
    MarkerShape::Diamond,
    MarkerShape::Cross,
    MarkerShape::TriangleDown,
];

impl SeriesStyle {
    fn colour(self) -> &'static str {
        match self {
            Self::Line(place) | Self::Steps(place) | Self::Points(place) | Self::Sweep(place) | Self::Failed(place) => {
                COLOURS[place % COLOURS.len()]
            }
            Self::Reference => GREY,
            Self::Winner => "#000000",
            Self::Exact | Self::Front => "#c4c4c4",
        }
    }

    fn dash(self) -> &'static str {
        match self {
            Self::Line(place) | Self::Steps(place) => DASHES[place % DASHES.len()],
            Self::Points(_) | Self::Sweep(_) | Self::Failed(_) | Self::Winner | Self::Front | Self::Exact => "",
            Self::Reference => "4 4",
        }
    }

    fn legend(self, label: &str) -> LegendEntry {
        let shape = match self {
            Self::Points(place) | Self::Sweep(place) => LegendShape::Marker(MARKERS[place % MARKERS.len()]),
            Self::Failed(_) => LegendShape::Marker(MarkerShape::Star),
            Self::Winner => LegendShape::Marker(MarkerShape::Diamond),
            Self::Front => LegendShape::Marker(MarkerShape::Circle),
            _ => LegendShape::Line,
        };
        let dasharray = Some(self.dash()).filter(|dash| !dash.is_empty()).map(String::from);
        LegendEntry { label: plain(label), color: self.colour().into(), shape, dasharray }
    }
}

/// SVG picture of one panel, with a legend below the panel if the legend has several entries.
pub(super) fn single(panel: &Panel) -> String {
    let legend = legend(std::slice::from_ref(panel));
    let (plots, layout) = draw(panel);
    let layout = if legend.len() > 1 { with_legend(layout, legend) } else { layout };
    svg(&render_multiple(plots, layout.with_width(WIDTH).with_height(HEIGHT)))
}

/// Returns the layout of a picture with a legend below the panel.
pub(super) fn with_legend(layout: Layout, legend: Vec<LegendEntry>) -> Layout {
    let layout = layout.with_legend_entries(legend).with_legend_box(false);
    layout.with_legend_position(LegendPosition::OutsideBottomColumns)
}

/// SVG picture of several panels in rows of two, with one legend below all panels if the legend has several entries.
pub(super) fn grid(panels: &[Panel]) -> String {
    if panels.is_empty() {
        return single(&Panel::default());
    }
    let legend = legend(panels);
    let rows = panels.len().div_ceil(2);
    let (plots, layouts): (Vec<_>, Vec<_>) =
        panels.iter().map(draw).map(|(plots, layout)| (plots, layout.with_ticks(4))).unzip();
    let figure = Figure::new(rows, 2)
        .with_plots(plots)
        .with_layouts(layouts)
        .with_spacing(8.0)
        .with_padding(4.0)
        .with_cell_size((WIDTH - 16.0) / 2.0, PANEL_HEIGHT);
    let figure =
        if legend.len() > 1 { figure.with_shared_legend_bottom().with_shared_legend_entries(legend) } else { figure };
    svg(&figure.render())
}

/// Legend entries of all panels, in order of first appearance.
fn legend(panels: &[Panel]) -> Vec<LegendEntry> {
    let mut seen: Vec<&str> = Vec::new();
    let mut entries = Vec::new();
    for series in panels.iter().flat_map(|panel| &panel.series) {
        if !seen.contains(&series.label.as_str()) && series.points.iter().any(|p| p.x.is_finite() && p.y.is_finite()) {
            seen.push(&series.label);
            entries.push(series.look.legend(&series.label));
        }
    }
    entries
}

pub(super) fn style(layout: Layout) -> Layout {
    let theme = Theme {
        grid_color: "#e6e6e6".into(),
        axis_color: "#333333".into(),
        legend_border: "#d0d0d0".into(),
        ..Theme::light()
    };
    layout
        .with_theme(theme)
        .with_font_family("Helvetica, Arial, sans-serif")
        .with_title_size(15)
        .with_label_size(15)
        .with_tick_size(13)
        .with_body_size(14)
}

fn draw(panel: &Panel) -> (Vec<Plot>, Layout) {
    let shown = |p: &&SeriesPoint| {
        p.x.is_finite() && p.y.is_finite() && (!panel.log_y || p.y > 0.0) && (!panel.log_x || p.x > 0.0)
    };
    let mut plots = Vec::new();
    let (mut x, mut y) = (AxisRange::EMPTY, AxisRange::EMPTY);
    for &(value, _) in &panel.marks {
        y.include(value);
    }
    let top = panel.series.iter().flat_map(|series| &series.points).filter(shown).fold(0.0, |top, p| p.y.max(top));
    let six = top * 10f64.powi(-DECADES);
    let floor = if panel.log_y { panel.floor.unwrap_or(six) } else { f64::NEG_INFINITY };
    let (failed, drawn): (Vec<&PanelSeries>, Vec<&PanelSeries>) =
        panel.series.iter().partition(|series| matches!(series.look, SeriesStyle::Failed(_)));
    for series in drawn {
        let points = series.points.iter().filter(shown).map(|p| SeriesPoint { y: p.y.max(floor), ..*p });
        let points: Vec<SeriesPoint> = points.collect();
        for point in &points {
            let error = if panel.log_y { None } else { point.error };
            x.include(point.x);
            y.include(point.y - error.unwrap_or(0.0));
            y.include(point.y + error.unwrap_or(0.0));
        }
        plots.extend(plot(series.look, &points, floor));
    }
    for point in failed.iter().flat_map(|series| &series.points).filter(shown) {
        x.include(point.x);
        // a point of a failed run is drawn on the upper frame, whatever its value
        if panel.log_y || y.is_empty() {
            y.include(point.y);
        }
    }
    let empty = x.is_empty();
    let x_ends = if panel.log_x { x.decades() } else { x.ends() };
    let y_ends = if panel.log_x && panel.log_y { y.decades() } else { y.padded(panel.log_y) };
    let (x, y) = if empty {
        ((0.0, 1.0), (0.0, 1.0))
    } else {
        (panel.x_range.unwrap_or(x_ends), panel.y_range.unwrap_or(y_ends))
    };
    for series in failed {
        let points: Vec<SeriesPoint> =
            series.points.iter().filter(shown).map(|p| SeriesPoint { y: y.1, ..*p }).collect();
        plots.extend(plot(series.look, &points, floor));
    }
    let mut layout = layout(panel, x, y, empty);
    if empty {
        // kuva draws axes only if there is a plot
        plots.push(Plot::Line(LinePlot::new().with_data([(0.0, 0.0)])));
    }
    for &(value, label) in &panel.marks {
        let line = ReferenceLine::horizontal(value).with_color(GREY).with_dasharray("5 4");
        layout = layout.with_reference_line(if label.is_empty() { line } else { line.with_label(label) });
    }
    (plots, layout)
}

/// Layout of a panel whose axes have the given ends. `empty` is true for a panel without points, which contains the
/// words "nothing recorded".
fn layout(panel: &Panel, x: (f64, f64), y: (f64, f64), empty: bool) -> Layout {
    let mut layout = style(Layout::new(x, y))
        .with_x_axis_min(x.0)
        .with_x_axis_max(x.1)
        .with_x_tick_format(if panel.log_x { powers() } else { ticks(x) })
        .with_y_tick_format(if panel.log_y { powers() } else { ticks(y) });
    if !panel.title.is_empty() {
        layout = layout.with_title(plain(&panel.title));
    }
    layout = layout.with_x_label(plain(&panel.x_label)).with_y_label(plain(&panel.y_label));
    if panel.log_y && !empty {
        layout = layout.with_log_y();
    }
    if panel.log_x && !empty {
        layout = layout.with_log_x();
    }
    if (panel.log_x || panel.y_range.is_some()) && !empty {
        layout = layout.with_y_axis_min(y.0).with_y_axis_max(y.1);
    }
    if empty {
        layout = layout.with_annotation(TextAnnotation::new("nothing recorded", 0.5, 0.5).with_color(GREY));
    }
    layout
}

/// Tick labels with as many decimal places as the ticks need. Ticks at distances of 0.0025 need four places; with two
/// places, every other label would be wrong.
pub(super) fn ticks((low, high): (f64, f64)) -> TickFormat {
    let span = high - low;
    TickFormat::Custom(Arc::new(move |value| {
        // the tick at zero may have a small value left by rounding in the sum of steps
        let value = if value.abs() < 1e-9 * span { 0.0 } else { value };
        let size = value.abs().max(1e-3 * span);
        if value != 0.0 && !(1e-4..1e6).contains(&size) {
            return significant(value, 3);
        }
        // ticks have at most three places beyond the first digit of the span; further digits are rounding errors
        let places = (3 - span.log10().floor() as i32).clamp(1, 9) as usize;
        let text = format!("{:.places$}", value.abs());
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if value < 0.0 { format!("−{text}") } else { text.to_owned() }
    }))
}

/// Tick labels of a logarithmic axis. Whole powers of ten below 0.01 or above 1000 are written as powers, such as 10⁻³;
/// all other numbers are written as usual.
pub(super) fn powers() -> TickFormat {
    TickFormat::Custom(Arc::new(|value| {
        let power = value.log10();
        if !power.is_finite() || (power - power.round()).abs() > 1e-6 || (-2.1..3.1).contains(&power) {
            significant(value, 1)
        } else {
            format!("10{}", superscript(power.round() as i32))
        }
    }))
}

/// Plots that draw one series: points, or a line with a band if errors are known. `floor` is the lower end of the
/// vertical axis, at which error bars end.
fn plot(look: SeriesStyle, points: &[SeriesPoint], floor: f64) -> Vec<Plot> {
    let data: Vec<(f64, f64)> = points.iter().map(|p| (p.x, p.y)).collect();
    let line = || {
        let style = if look.dash().is_empty() { LineStyle::Solid } else { LineStyle::Custom(look.dash().into()) };
        LinePlot::new().with_data(data.clone()).with_color(look.colour()).with_line_style(style)
    };
    match look {
        SeriesStyle::Line(place) => {
            let known: Vec<(&SeriesPoint, f64)> = points.iter().filter_map(|p| Some((p, p.error?))).collect();
            let lower = known.iter().map(|(p, error)| p.y - error);
            let upper = known.iter().map(|(p, error)| p.y + error);
            let band = BandPlot::new(known.iter().map(|(p, _)| p.x), lower, upper).with_color(look.colour());
            let mut plots = vec![Plot::Band(band.with_opacity(0.22)), Plot::Line(line().with_stroke_width(1.8))];
            if points.len() < 2 {
                plots.push(scatter(place, data));
            }
            plots
        }
        SeriesStyle::Steps(_) => vec![Plot::Line(line().with_stroke_width(1.6))],
        SeriesStyle::Points(place) => vec![scatter(place, data)],
        SeriesStyle::Sweep(place) => {
            let arms = points.iter().map(|p| {
                let error = p.error.unwrap_or(0.0);
                (error.min(p.y - floor).max(0.0), error)
            });
            let marks =
                ScatterPlot::new().with_data(data.clone()).with_y_err_asymmetric(arms).with_color(look.colour());
            let marks = marks.with_size(4.0).with_marker(MARKERS[place % MARKERS.len()]);
            vec![Plot::Line(line().with_stroke_width(1.0)), Plot::Scatter(marks)]
        }
        SeriesStyle::Failed(_) => {
            let stars = ScatterPlot::new().with_data(data).with_color(look.colour()).with_size(6.0);
            vec![Plot::Scatter(stars.with_marker(MarkerShape::Star))]
        }
        SeriesStyle::Winner => {
            let marks = ScatterPlot::new().with_data(data).with_color(look.colour()).with_size(8.0);
            vec![Plot::Scatter(marks.with_marker(MarkerShape::Diamond))]
        }
        SeriesStyle::Reference => vec![Plot::Line(line().with_stroke_width(1.4))],
        SeriesStyle::Front => {
            let halos = ScatterPlot::new().with_data(data.clone()).with_color(look.colour()).with_size(8.0);
            vec![Plot::Line(line().with_stroke_width(5.0)), Plot::Scatter(halos)]
        }
        SeriesStyle::Exact => vec![Plot::Line(line().with_stroke_width(5.0))],
    }
}

fn scatter(place: usize, data: Vec<(f64, f64)>) -> Plot {
    let plot = ScatterPlot::new().with_data(data).with_color(COLOURS[place % COLOURS.len()]).with_size(3.0);
    Plot::Scatter(plot.with_marker(MARKERS[place % MARKERS.len()]))
}

/// Range of an axis: its lower and its upper end.
#[derive(Clone, Copy)]
struct AxisRange(f64, f64);

impl AxisRange {
    const EMPTY: Self = Self(f64::INFINITY, f64::NEG_INFINITY);

    fn include(&mut self, value: f64) {
        *self = Self(self.0.min(value), self.1.max(value));
    }

    fn is_empty(self) -> bool {
        self.0 > self.1
    }

    /// Lower and upper end of the axis, which differ even if all values are equal.
    fn ends(self) -> (f64, f64) {
        let Self(low, high) = self;
        // a smaller difference is a rounding error, and would give ticks with equal labels
        if high - low > 1e-9 * low.abs().max(high.abs()) {
            return (low, high);
        }
        let half = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
        (low - half, high + half)
    }

    /// Smallest range between whole powers of ten that contains this range and spans at least one decade.
    fn decades(self) -> (f64, f64) {
        let (low, high) = (self.0.log10().floor(), self.1.log10().ceil());
        (10f64.powf(low), 10f64.powf(high.max(low + 1.0)))
    }

    fn padded(self, logarithmic: bool) -> (f64, f64) {
        if logarithmic {
            return if self.1 > self.0 { (self.0, self.1) } else { (0.5 * self.0, 2.0 * self.0) };
        }
        let (low, high) = self.ends();
        let pad = 0.04 * (high - low);
        // if no value is negative, the axis begins at 0 or above
        (if self.0 >= 0.0 && low - pad < 0.0 { 0.0 } else { low - pad }, high + pad)
    }
}

/// SVG text of a picture. Its view box allows a page to scale the picture to the width of a column.
pub(super) fn svg(scene: &Scene) -> String {
    let text = SvgBackend::new().render_scene(scene);
    let view = format!("<svg viewBox=\"0 0 {} {}\" ", scene.width, scene.height);
    text.replacen("<svg ", &view, 1)
}

/// Text in a form that kuva accepts: a dollar sign would begin a formula, and XML allows no control characters.
pub(super) fn plain(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).collect::<String>().replace('$', "\\$")
}
