//! Figures of the distributions of impacts (Fig. 6 of the paper), and of mean overlaps against the overlap number κ_n
//! (Eq. 13 of the paper). The paper is that of docs/paper.md. In a Maxwellian gas, κ_n is the time average of the
//! overlap, divided by the diameter. A variant is one of the experiments of a case. Variants that are drawn in the same
//! panel form a group.

use super::chart;
use crate::experiment::SoftStepping;
use crate::outcome::Outcome;
use crate::output::csv::{HistogramRow, bins};
use crate::output::groups::groups;
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::predict::overlaps::Overlaps;
use crate::record::{Histogram, Impacts};
use std::f64::consts::PI;

/// Largest number of bins of a histogram that a picture shows. Bins of finer histograms are merged.
const SHOWN: usize = 48;

/// Number of intervals from which a curve of kinetic theory is drawn: one for every four pixels of a panel.
const CURVE_POINTS: usize = 60;

/// Name in the legend of curves from kinetic theory.
const THEORY: &str = "Maxwellian gas";

/// [-] overlap, divided by the diameter, below which an overlap counts as a rounding error. Event-driven collisions
/// have such overlaps.
pub(in crate::output) const ROUNDING: f64 = 1e-9;

/// Kind of curve by which the distribution of a quantity is drawn.
#[derive(Clone, Copy, PartialEq)]
enum Shape {
    Density,
    /// Probability density on a logarithmic axis, on which rare values are visible too.
    LogDensity,
    /// Cumulative distribution: the fraction of smaller values.
    Share,
}

/// Quantity of an impact, such as its normal speed, with the style in which its distribution is drawn.
#[derive(Clone, Copy)]
struct ImpactQuantity {
    x_label: &'static str,
    /// [-] factor by which the quantity is multiplied for the axis, such as 100 for per cent.
    scale: f64,
    y_label: &'static str,
    shape: Shape,
    /// Threshold in the unit of the quantity. A variant (experiment of a case) whose values are all smaller is left out
    /// of the picture.
    least: f64,
    pick: fn(&Impacts) -> &Histogram,
    /// Prediction of kinetic theory as a function of the quantity; `None` if there is no theory.
    theory: Option<fn(&Overlaps, f64) -> f64>,
    /// True if the prediction is valid only for uniform stepping, in which each time step moves all particles.
    in_step: bool,
}

/// Picture of the probability density of the normal speed of approach, between particles and at walls.
pub fn impact_speed(outcomes: &[Outcome]) -> String {
    let view = ImpactQuantity {
        x_label: "normal speed  [m/s]",
        scale: 1.0,
        y_label: "PDF  [s/m]",
        shape: Shape::Density,
        least: 0.0,
        pick: |impacts| &impacts.normal_speed,
        theory: None,
        in_step: false,
    };
    views(outcomes, &[view])
}

/// Picture of the largest overlap of an impact, divided by the diameter, between particles and at walls. One panel
/// shows the probability density on a logarithmic axis, because deep overlaps are rare. The other panel shows the
/// cumulative distribution.
pub fn overlap(outcomes: &[Outcome]) -> String {
    let density = ImpactQuantity {
        x_label: "δ max / d  [–]",
        scale: 1.0,
        y_label: "PDF  [–]",
        shape: Shape::LogDensity,
        least: ROUNDING,
        pick: |impacts| &impacts.maximum_overlap,
        theory: Some(Overlaps::maximum_density),
        in_step: false,
    };
    let share =
        ImpactQuantity { y_label: "CDF  [–]", shape: Shape::Share, theory: Some(Overlaps::maximum_share), ..density };
    views(outcomes, &[density, share])
}

/// Picture of the overlap, divided by the diameter, at which an impact is first detected, between particles and at
/// walls. The panels show the probability density and the cumulative distribution.
pub fn first_overlap(outcomes: &[Outcome]) -> String {
    let density = ImpactQuantity {
        x_label: "δ first / d  [%]",
        y_label: "PDF  [1/%]",
        scale: 100.0,
        shape: Shape::Density,
        least: ROUNDING,
        pick: |impacts| &impacts.first_overlap,
        theory: Some(Overlaps::first_density),
        in_step: true,
    };
    let share =
        ImpactQuantity { y_label: "CDF  [–]", shape: Shape::Share, theory: Some(Overlaps::first_share), ..density };
    views(outcomes, &[density, share])
}

/// Picture of the mean overlaps of all experiments with soft spheres, divided by κ_n and the diameter, as a function
/// of the overlap number κ_n. By kinetic theory κ_n is the time average of the overlap over the diameter. Lines show
/// this theory. One panel is for pairs of particles, one for walls. A panel with fewer than two experiments is left
/// out; `None` if no panel remains.
pub fn mean_overlap(outcomes: &[Outcome]) -> Option<String> {
    let panel = |title: &str, wall: bool| {
        let known: Vec<(f64, &Impacts)> = outcomes
            .iter()
            .filter_map(|o| Some((o.kinetic_theory(wall)?.kappa, if wall { &o.walls } else { &o.pairs })))
            .filter(|(_, impacts)| impacts.count > 0)
            .collect();
        let series = |label: &str, place, of: fn(&Impacts) -> Option<f64>| {
            let point = |(kappa, impacts): &(f64, &Impacts)| Some(SeriesPoint::at(100.0 * kappa, of(impacts)? / kappa));
            PanelSeries::new(label, SeriesStyle::Points(place), known.iter().filter_map(point))
        };
        let series = vec![
            series("mean of the largest", 0, |impacts| impacts.summary().mean_maximum_overlap),
            series("mean over contact time", 1, |impacts| impacts.summary().time_mean_overlap),
        ];
        let points = || series.iter().flat_map(|series| &series.points);
        let low = points().fold(f64::INFINITY, |low, point| low.min(point.x));
        let (high, top) = points().fold((0.0, 2.0), |(x, y): (f64, f64), point| (x.max(point.x), y.max(point.y)));
        // the axis extends beyond the points by a factor of 1.5 on both sides, so that no point is on the frame
        let ranges = (Some((low / 1.5, 1.5 * high)), Some((0.0, top)));
        let panel = Panel {
            title: title.into(),
            x_label: "κ_n  [%]".into(),
            y_label: "overlap / (κ_n d)  [–]".into(),
            series,
            marks: vec![(0.5 * PI, "π/2"), (1.0, "1")],
            x_range: ranges.0,
            y_range: ranges.1,
            log_x: true,
            ..Panel::default()
        };
        (known.len(), panel)
    };
    let panels = [panel("between particles", false), panel("at walls", true)];
    let panels: Vec<Panel> = panels.into_iter().filter(|(known, _)| *known > 1).map(|(_, panel)| panel).collect();
    (!panels.is_empty()).then(|| chart::grid(&panels))
}

/// Picture with two panels for each group of variants (experiments of a case) and each quantity in `views`: one for
/// impacts between particles, and one for impacts at walls.
fn views(outcomes: &[Outcome], views: &[ImpactQuantity]) -> String {
    let mut panels = Vec::new();
    for group in groups(outcomes) {
        for view in views {
            for (kind, wall) in [("between particles", false), ("at walls", true)] {
                let title = if group.title.is_empty() { kind.into() } else { format!("{}, {kind}", group.title) };
                panels.push(view.panel(title, &group.members, wall));
            }
        }
    }
    // panels without impacts are left out, unless no panel would remain
    if panels.iter().any(|panel| !panel.series.is_empty()) {
        panels.retain(|panel| !panel.series.is_empty());
    }
    chart::grid(&panels)
}

impl ImpactQuantity {
    fn panel(&self, title: String, members: &[(String, &Outcome)], wall: bool) -> Panel {
        let log_y = self.shape == Shape::LogDensity;
        let mut panel =
            Panel { title, x_label: self.x_label.into(), y_label: self.y_label.into(), log_y, ..Panel::default() };
        panel.y_range = (self.shape == Shape::Share).then_some((0.0, 1.0));
        for (place, (name, outcome)) in members.iter().enumerate() {
            let histogram = (self.pick)(if wall { &outcome.walls } else { &outcome.pairs });
            if histogram.maximum < self.least || histogram.total == 0 {
                continue;
            }
            panel.series.extend(self.curve(outcome, histogram, wall));
            let (look, points) = match self.shape {
                Shape::Share => (SeriesStyle::Line(place), shares(histogram)),
                Shape::Density | Shape::LogDensity => (SeriesStyle::Steps(place), self.steps(histogram)),
            };
            panel.series.push(PanelSeries { label: name.clone(), look, points });
        }
        let density = if self.shape == Shape::Share { 1.0 } else { self.scale };
        for point in panel.series.iter_mut().flat_map(|series| &mut series.points) {
            *point = SeriesPoint::at(point.x * self.scale, point.y / density);
        }
        panel
    }

    /// Probability density of a histogram as a step curve. On a linear axis the curve ends at zero. On a logarithmic
    /// axis, an empty bin is drawn at the density of half a count, lower than any filled bin.
    fn steps(&self, histogram: &Histogram) -> Vec<SeriesPoint> {
        let all = bins(histogram);
        let mut points: Vec<SeriesPoint> = Vec::new();
        let merged = all.len().div_ceil(SHOWN).max(1);
        for group in all.chunks(merged) {
            let (Some(first), Some(sum)) =
                (group.first(), group.iter().map(|bin: &HistogramRow| bin.density).sum::<Option<f64>>())
            else {
                continue;
            };
            // if the last group of merged bins is smaller than the other groups of bins, its missing bins count as
            // empty
            let density = sum / merged as f64;
            let y = if self.shape == Shape::LogDensity { density.max(half_count(histogram, merged)) } else { density };
            let upper = first.lower + merged as f64 * histogram.width;
            points.extend([first.lower, upper].map(|x| SeriesPoint::at(x, y)));
        }
        if let (Some(last), Shape::Density) = (points.last().copied(), self.shape) {
            points.push(SeriesPoint { y: 0.0, ..last });
        }
        points
    }

    /// Curve that kinetic theory predicts, over the range of the histogram; `None` if the theory is not valid for the
    /// run. `wall` is true for impacts on walls, false for impacts between particles.
    fn curve(&self, outcome: &Outcome, histogram: &Histogram, wall: bool) -> Option<PanelSeries> {
        let (theory, overlaps) = (self.theory?, outcome.kinetic_theory(wall)?);
        let uniform = outcome.experiment.soft.stepping == SoftStepping::Uniform;
        if self.in_step && !uniform {
            return None;
        }
        let merged = bins(histogram).len().div_ceil(SHOWN).max(1);
        let floor = if self.shape == Shape::LogDensity { half_count(histogram, merged) } else { f64::NEG_INFINITY };
        let point = |k: usize| {
            let x = histogram.maximum * k as f64 / CURVE_POINTS as f64;
            SeriesPoint::at(x, theory(&overlaps, x))
        };
        let points = (0..=CURVE_POINTS).map(point).filter(|point| point.y >= floor).collect();
        Some(PanelSeries { label: THEORY.into(), look: SeriesStyle::Reference, points })
    }
}

/// Cumulative distribution of a histogram: fraction of the values below the upper end of each group of bins. The bins
/// are merged into at most `SHOWN` groups.
fn shares(histogram: &Histogram) -> Vec<SeriesPoint> {
    let all = bins(histogram);
    let mut below = 0;
    let end = |group: &[HistogramRow]| {
        below += group.iter().map(|bin| bin.count).sum::<u64>();
        Some(SeriesPoint::at(group.last()?.upper, below as f64 / histogram.total as f64))
    };
    let zero = SeriesPoint::at(0.0, 0.0);
    std::iter::once(zero).chain(all.chunks(all.len().div_ceil(SHOWN).max(1)).filter_map(end)).collect()
}

/// Probability density in a bin that is made of `merged` bins of the histogram and contains half a count. At this
/// density empty bins are drawn on a logarithmic axis.
fn half_count(histogram: &Histogram, merged: usize) -> f64 {
    0.5 / (histogram.total as f64 * histogram.width * merged as f64)
}
