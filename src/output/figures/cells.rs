//! Maps of coloured cells with theoretical lines. The colours are those of Okabe and Ito, which colour-blind readers
//! can distinguish, and shades of blue. Cells of runs that failed or gave wrong results also have crosses, so that a
//! map is readable without colours.

use super::chart::{HEIGHT, WIDTH, plain, powers, style, svg, ticks, with_legend};
use crate::output::limits::{RegimeMap, Shade};
use kuva::plot::legend::{LegendEntry, LegendShape};
use kuva::plot::scatter::MarkerShape;
use kuva::plot::{BandPlot, LinePlot, LineStyle, ScatterPlot};
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;

/// Dash patterns of the theoretical lines, in the order of the lines.
const DASHES: [&str; 3] = ["", "8 4", "2 3"];

fn colour(shade: Shade) -> &'static str {
    match shade {
        Shade::Level(0) => "#e6f0f7",
        Shade::Level(1) => "#a9cde3",
        Shade::Level(2) => "#56a4cf",
        Shade::Level(_) => "#0072B2",
        Shade::Fails => "#E69F00",
        Shade::Silent => "#555555",
    }
}

/// SVG picture of a map of coloured cells, with the lines that theory predicts and a legend.
pub fn cells(map: &RegimeMap) -> String {
    let mut plots = Vec::new();
    let mut legend = Vec::new();
    let ends = |of: fn(&crate::output::limits::Cell) -> (f64, f64)| {
        let all = map.cells.iter().map(of);
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (a, b)| (low.min(a), high.max(b)))
    };
    let (x, y) = (ends(|cell| cell.x), ends(|cell| cell.y));
    for (index, class) in map.classes.iter().enumerate() {
        let of_class: Vec<_> = map.cells.iter().filter(|cell| cell.class == index).collect();
        if of_class.is_empty() {
            continue;
        }
        for cell in &of_class {
            let band = BandPlot::new([cell.x.0, cell.x.1], [cell.y.0; 2], [cell.y.1; 2]);
            plots.push(Plot::Band(band.with_color(colour(class.shade)).with_opacity(1.0)));
        }
        if matches!(class.shade, Shade::Fails | Shade::Silent) {
            let middle = |(a, b): (f64, f64), log: bool| if log { (a * b).sqrt() } else { 0.5 * (a + b) };
            let places = of_class.iter().map(|cell| (middle(cell.x, map.log[0]), middle(cell.y, map.log[1])));
            let crosses = ScatterPlot::new().with_data(places.collect::<Vec<_>>()).with_color("#ffffff");
            plots.push(Plot::Scatter(crosses.with_size(2.5).with_marker(MarkerShape::Cross)));
        }
        legend.push(LegendEntry {
            label: plain(&class.label),
            color: colour(class.shade).into(),
            shape: LegendShape::Rect,
            dasharray: None,
        });
    }
    for (index, (label, points)) in map.lines.iter().enumerate() {
        let inside = |p: &&(f64, f64)| p.0 >= x.0 && p.0 <= x.1 && p.1 >= y.0 && p.1 <= y.1;
        let dash = DASHES[index % DASHES.len()];
        let style = if dash.is_empty() { LineStyle::Solid } else { LineStyle::Custom(dash.into()) };
        let line = LinePlot::new().with_data(points.iter().filter(inside).copied().collect::<Vec<_>>());
        plots.push(Plot::Line(line.with_color("#000000").with_line_style(style).with_stroke_width(2.4)));
        let dasharray = Some(dash).filter(|dash| !dash.is_empty()).map(String::from);
        legend.push(LegendEntry { label: plain(label), color: "#000000".into(), shape: LegendShape::Line, dasharray });
    }
    let mut layout = style(Layout::new(x, y))
        .with_x_axis_min(x.0)
        .with_x_axis_max(x.1)
        .with_y_axis_min(y.0)
        .with_y_axis_max(y.1)
        .with_show_grid(false)
        .with_x_tick_format(if map.log[0] { powers() } else { ticks(x) })
        .with_y_tick_format(if map.log[1] { powers() } else { ticks(y) })
        .with_x_label(plain(&map.x_label))
        .with_y_label(plain(&map.y_label));
    if map.log[0] {
        layout = layout.with_log_x();
    }
    if map.log[1] {
        layout = layout.with_log_y();
    }
    svg(&render_multiple(plots, with_legend(layout, legend).with_width(WIDTH).with_height(HEIGHT)))
}
