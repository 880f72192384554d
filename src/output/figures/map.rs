//! Map of a measured field on a grid that is one cell thick, such as the heights of a free surface seen from above.

use super::chart::{HEIGHT, WIDTH, style, svg, ticks};
use crate::observe::ObservedGrid;
use crate::output::numbers::Prefix;
use kuva::plot::Heatmap;
use kuva::plot::colormap::ColorMap;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;

/// Largest number of drawn cells along an edge. In a grid with more cells, neighbouring cells are averaged, so that the
/// file stays small.
const MOST_CELLS: usize = 64;

/// [px] height (`MARGIN`) and width (`SIDES`) that labels and the scale of the colours take in a picture.
const MARGIN: f64 = 70.0;
const SIDES: f64 = 190.0;

/// SVG picture of the first field of a grid, and a text with the meaning and the unit of its colours. `None` unless
/// exactly two edges of the grid have more than one cell, and the first field is a length.
pub(super) fn map(grid: &ObservedGrid) -> Option<(String, String)> {
    let level: Vec<usize> = (0..3).filter(|axis| grid.cells[*axis] > 1).collect();
    let [across, along] = level[..] else { return None };
    let (name, _, values) =
        grid.fields.first().filter(|(name, components, _)| *components == 1 && name.ends_with("_m"))?;
    let [columns, rows] = [across, along].map(|axis| grid.cells[axis]);
    let merged = columns.max(rows).div_ceil(MOST_CELLS);
    let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let unit = Prefix::of(values.iter().fold(0.0_f64, |largest, value| largest.max(value - lowest)));
    let data = (0..rows.div_ceil(merged)).rev().map(|row| {
        let cell = |column: usize| {
            let own = (row * merged..rows.min((row + 1) * merged)).flat_map(|row| {
                let first = row * columns;
                &values[first + column * merged..first + columns.min((column + 1) * merged)]
            });
            let (sum, count) = own.fold((0.0, 0.0), |(sum, count), value| (sum + value - lowest, count + 1.0));
            sum / count * unit.factor
        };
        (0..columns.div_ceil(merged)).map(cell).collect::<Vec<f64>>()
    });
    let edges = [across, along].map(|axis| grid.spacing[axis] * grid.cells[axis] as f64);
    let length = Prefix::of(edges[0].max(edges[1]));
    let [x, y] = edges.map(|edge| (0.0, edge * length.factor));
    let quantity = name.trim_end_matches("_m");
    let meaning = format!("{quantity} above its lowest value [{}m]", unit.symbol);
    let axis = |axis: usize| format!("{}  [{}m]", ["x", "y", "z"][axis], length.symbol);
    let heat = Heatmap::new().with_data(data).with_x_range(x.0, x.1).with_y_range(y.0, y.1).with_cell_size(1.0);
    let heat = heat.with_color_map(ColorMap::Cividis);
    let height = (MARGIN + (WIDTH - SIDES) * edges[1] / edges[0]).clamp(0.5 * HEIGHT, 2.0 * HEIGHT);
    let plots = vec![Plot::Heatmap(heat)];
    // only a layout made from the plots has the scale of the colours
    let layout = style(Layout::auto_from_plots(&plots))
        .with_x_axis_min(x.0)
        .with_x_axis_max(x.1)
        .with_y_axis_min(y.0)
        .with_y_axis_max(y.1)
        .with_show_grid(false)
        .with_x_tick_format(ticks(x))
        .with_y_tick_format(ticks(y))
        .with_x_label(axis(across))
        .with_y_label(axis(along));
    Some((svg(&render_multiple(plots, layout.with_width(WIDTH).with_height(height))), meaning))
}
