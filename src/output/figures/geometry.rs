//! Figure of the box with its axes in an oblique view, which corresponds to Fig. 1 of the paper (docs/paper.md).

use super::chart;
use crate::output::numbers::Prefix;
use crate::output::panel::{Figure, Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::scene::Scene;

/// [-] factor by which a spanwise length is multiplied to give its horizontal and its vertical part in the picture. The
/// spanwise axis is drawn at 45 degrees and at half length (cabinet projection).
const OBLIQUE: f64 = 0.5 * std::f64::consts::FRAC_1_SQRT_2;
/// [-] length of an arrow, divided by the shortest edge of the box.
const ARROW: f64 = 0.3;
/// Number of intervals of the drawn curve of the gas velocity.
const POINTS: usize = 80;

/// Figure of the box, with its two ends along y, the profile of the gas velocity and the direction of gravity. The axis
/// y points to the right, z upwards, and x into the page.
pub fn geometry(scene: &Scene) -> Figure {
    let size = scene.domain.size;
    let prefix = Prefix::of(size.max());
    let at =
        |x: f64, y: f64, z: f64| SeriesPoint::at((y + OBLIQUE * x) * prefix.factor, (z + OBLIQUE * x) * prefix.factor);
    let length = |edge: f64| format!("{} {}m", edge * prefix.factor, prefix.symbol);
    let wall =
        |y: f64| [(0.0, 0.0), (size.x, 0.0), (size.x, size.z), (0.0, size.z), (0.0, 0.0)].map(|(x, z)| at(x, y, z));
    let kind = |axis: usize| if scene.domain.periodic[axis] { "periodic" } else { "between walls" };
    // series with the same name have one common line in the legend
    let end = |y: f64| PanelSeries::new("ends of the box along y", SeriesStyle::Line(0), wall(y));
    let mut series = vec![end(0.0), end(size.y)];
    for (x, z) in [(0.0, 0.0), (size.x, 0.0), (size.x, size.z), (0.0, size.z)] {
        series.push(PanelSeries::new("edges", SeriesStyle::Reference, [at(x, 0.0, z), at(x, size.y, z)]));
    }
    let arrow = ARROW * size.min();
    // the arrows are beside the box, so that nothing covers them
    let from = size.y + 1.5 * arrow;
    let axis = |label: String, look: usize, end: SeriesPoint| {
        PanelSeries::new(label, SeriesStyle::Line(look), [at(0.0, from, 0.0), end])
    };
    series.push(axis(format!("x spanwise, {}, {}", length(size.x), kind(0)), 2, at(2.0 * arrow, from, 0.0)));
    series.push(axis(format!("y wall-normal, {}, {}", length(size.y), kind(1)), 5, at(0.0, from + arrow, 0.0)));
    series.push(axis(format!("z streamwise, {}, {}", length(size.z), kind(2)), 3, at(0.0, from, arrow)));
    if let Some(fluid) = scene.fluid.as_ref().filter(|fluid| fluid.profile.maximum() > 0.0) {
        let scale = 0.5 * size.z / fluid.profile.maximum();
        let curve = fluid.profile.sample(size.y, POINTS + 1).into_iter();
        let points = curve.map(|(y, u)| at(0.0, y, 0.25 * size.z + scale * u));
        series.push(PanelSeries::new("gas velocity, along z", SeriesStyle::Line(1), points));
    }
    if scene.gravity_alone().z != 0.0 {
        let (y, from) = (0.5 * size.y, 0.2 * size.z);
        let end = at(0.0, y, from + arrow * 0.5 * scene.gravity_alone().z.signum());
        series.push(PanelSeries::new("gravity", SeriesStyle::Line(4), [at(0.0, y, from), end]));
    }
    let label = |axes: &str| format!("{axes}  [{}m]", prefix.symbol);
    let panel =
        Panel { x_label: label("y, and x at 45°"), y_label: label("z, and x at 45°"), series, ..Panel::default() };
    Figure::new("geometry", "The box: y to the right, z up, x into the page at half its length.", chart::single(&panel))
}
