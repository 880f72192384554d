//! Distributions over impacts (the paper's Fig. 6).

use super::chart::{self, Look, Panel, Point, Series};
use crate::outcome::Outcome;
use crate::output::csv::{Bin, bins};
use crate::record::{Histogram, Impacts};

/// Bins that a picture of this width can show.
const SHOWN: usize = 48;

/// [-] overlaps over the diameter below this are rounding: what events leave.
pub(super) const ROUNDING: f64 = 1e-9;

/// Probability density of the normal speed of approach: pairs and walls.
pub fn impact_speed(outcomes: &[Outcome]) -> String {
    pairs_and_walls(outcomes, "normal speed  [m/s]", "PDF  [s/m]", false, 0.0, |impacts| &impacts.normal_speed)
}

/// Probability density of the largest overlap over the diameter, logarithmic, since rare deep overlaps are the
/// question: pairs and walls.
pub fn overlap(outcomes: &[Outcome]) -> String {
    pairs_and_walls(outcomes, "δ max / d  [–]", "PDF  [–]", true, ROUNDING, |impacts| &impacts.maximum_overlap)
}

/// `least`: variants whose values are all smaller are left out.
fn pairs_and_walls(
    outcomes: &[Outcome],
    x_label: &str,
    y_label: &str,
    log_y: bool,
    least: f64,
    pick: fn(&Impacts) -> &Histogram,
) -> String {
    let panel = |title: &str, of: fn(&Outcome) -> &Impacts| Panel {
        title: title.into(),
        x_label: x_label.into(),
        y_label: y_label.into(),
        series: outcomes
            .iter()
            .enumerate()
            .filter(|(_, o)| pick(of(o)).maximum >= least)
            .map(|(place, o)| series(place, o, pick(of(o)), log_y))
            .collect(),
        log_y,
        ..Panel::default()
    };
    chart::grid(&[panel("between particles", |o| &o.record.pairs), panel("at walls", |o| &o.record.walls)])
}

/// A staircase through the densities. On a linear axis it ends on zero; on a logarithmic one an empty bin stands at half
/// a count, below all that can be counted.
fn series(place: usize, outcome: &Outcome, histogram: &Histogram, log_y: bool) -> Series {
    let all = bins(histogram);
    let mut points: Vec<Point> = Vec::new();
    let merged = all.len().div_ceil(SHOWN).max(1);
    for group in all.chunks(merged) {
        let Some(first) = group.first() else { continue };
        // The last group may be short of bins: those beyond are empty.
        let density = group.iter().map(|bin: &Bin| bin.density).sum::<f64>() / merged as f64;
        let one_count = 1.0 / (histogram.total as f64 * histogram.width * merged as f64);
        let y = if log_y { density.max(0.5 * one_count) } else { density };
        let upper = first.lower + merged as f64 * histogram.width;
        points.extend([first.lower, upper].map(|x| Point { x, y, error: f64::NAN }));
    }
    if let (Some(last), false) = (points.last().copied(), log_y) {
        points.push(Point { y: 0.0, ..last });
    }
    Series { label: outcome.experiment.name.clone(), look: Look::Steps(place), points }
}
