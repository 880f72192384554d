//! Pictures of one impact over time (Fig. 4 of the paper, docs/paper.md), and of the slip after oblique impacts. A
//! variant is one of the experiments of a case.

use super::chart;
use crate::output::numbers::Prefix;
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::output::{Bounce, ObliqueStudy, PathPoint};

/// Picture of the overlap (the negative gap) over time for each variant (experiment of a case), with the closed-form
/// solution if there is one.
pub fn overlap_in_time(bounces: &[Bounce]) -> String {
    let deepest = points(bounces).map(|point| -point.gap).filter(|overlap| overlap.is_finite()).fold(0.0, f64::max);
    let overlap = if deepest > 0.0 { Prefix::of(deepest) } else { Prefix::of(widest(bounces)) };
    // the motion before and after the contact is cut off where the gap exceeds half the largest overlap, because
    // nothing of interest happens there
    let floor = if deepest > 0.0 { -0.5 * deepest } else { f64::NEG_INFINITY };
    let time = Prefix::of(span(bounces, floor));
    let series = series(bounces, |path| {
        cut(path, floor).map(|(t, overlap_now)| (t * time.factor, overlap_now * overlap.factor)).collect()
    });
    chart::single(&Panel {
        x_label: format!("t  [{}s]", time.symbol),
        y_label: format!("overlap δ  [{}m]", overlap.symbol),
        series,
        marks: vec![(0.0, "")],
        ..Panel::default()
    })
}

/// Picture of the normal velocity over time for each variant (experiment of a case), with the closed-form solution if
/// there is one.
pub fn normal_velocity(bounces: &[Bounce]) -> String {
    let deepest = points(bounces).map(|point| -point.gap).filter(|overlap| overlap.is_finite()).fold(0.0, f64::max);
    let floor = if deepest > 0.0 { -0.5 * deepest } else { f64::NEG_INFINITY };
    let time = Prefix::of(span(bounces, floor));
    let (from, until) = near(bounces, floor);
    let series =
        series(bounces, |path| path.iter().map(|point| (point.time * time.factor, point.normal_velocity)).collect());
    let ends = (from * time.factor, until * time.factor);
    chart::single(&Panel {
        x_label: format!("t  [{}s]", time.symbol),
        y_label: "normal velocity  [m/s]".into(),
        series: series.into_iter().map(|one| within(one, ends)).collect(),
        marks: vec![(0.0, "")],
        x_range: (ends.0 < ends.1).then_some(ends),
        ..Panel::default()
    })
}

/// Picture of the reduced slip s/(μ u_n) after an impact as a function of the reduced slip before it, with a curve for
/// each variant (experiment of a case). Here s is the slip, μ the coefficient of friction and u_n the normal speed. The
/// picture also has measured points, and the theory of partial slip, in which only the edge of the contact circle
/// slips.
pub fn slip_after(study: &ObliqueStudy) -> String {
    let of = |points: &[(f64, f64)]| points.iter().map(|(x, y)| SeriesPoint::at(*x, *y)).collect::<Vec<_>>();
    let mut series: Vec<PanelSeries> = Vec::new();
    for (place, curve) in study.curves.iter().enumerate() {
        series.push(PanelSeries::new(&curve.name, SeriesStyle::Line(place), of(&curve.points)));
    }
    let [(measured, points), (partial_slip, curve)] = study.references();
    if !points.is_empty() {
        series.push(PanelSeries::new(measured, SeriesStyle::Points(study.curves.len()), of(points)));
    }
    if !curve.is_empty() {
        series.push(PanelSeries::new(partial_slip, SeriesStyle::Line(study.curves.len() + 1), of(curve)));
    }
    chart::single(&Panel {
        x_label: "slip before, s/(μ u_n)".into(),
        y_label: "slip after, s'/(μ u_n)".into(),
        series,
        marks: vec![(0.0, "")],
        ..Panel::default()
    })
}

fn points(bounces: &[Bounce]) -> impl Iterator<Item = &PathPoint> {
    bounces.iter().flat_map(|bounce| &bounce.path)
}

/// [m] largest magnitude of the gap in all impacts.
fn widest(bounces: &[Bounce]) -> f64 {
    points(bounces).map(|point| point.gap.abs()).filter(|gap| gap.is_finite()).fold(0.0, f64::max)
}

/// First and last time [s] at which the overlap is at least `floor` [m] in any of the impacts; (∞, -∞) if there is no
/// such time. A negative overlap is a gap.
fn near(bounces: &[Bounce], floor: f64) -> (f64, f64) {
    let times = bounces.iter().flat_map(|bounce| cut(&bounce.path, floor)).map(|(t, _)| t).filter(|t| t.is_finite());
    times.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)))
}

/// [s] largest magnitude of the times at which the overlap is at least `floor` [m] in any of the impacts. It is
/// infinite if there is no such time.
fn span(bounces: &[Bounce], floor: f64) -> f64 {
    let (from, until) = near(bounces, floor);
    from.abs().max(until.abs()).max(0.0)
}

/// Times [s] and overlaps [m] at the points of a path where the overlap is at least `floor` [m]. The times at which the
/// overlap equals `floor` are added by linear interpolation.
fn cut(path: &[PathPoint], floor: f64) -> impl Iterator<Item = (f64, f64)> {
    let inside = path.iter().filter(move |point| -point.gap >= floor).map(|point| (point.time, -point.gap));
    let crossings = path.windows(2).filter_map(move |pair| {
        let (a, b) = (-pair[0].gap, -pair[1].gap);
        ((a < floor) != (b < floor)).then(|| {
            let share = (floor - a) / (b - a);
            (pair[0].time + share * (pair[1].time - pair[0].time), floor)
        })
    });
    let mut kept: Vec<(f64, f64)> = inside.chain(crossings).collect();
    kept.sort_by(|a, b| a.0.total_cmp(&b.0));
    kept.into_iter()
}

/// Part of a series between the horizontal positions `from` and `until`. Its end points are found by linear
/// interpolation.
fn within(series: PanelSeries, (from, until): (f64, f64)) -> PanelSeries {
    let mut points: Vec<SeriesPoint> = Vec::new();
    for pair in series.points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        if b.x < from || a.x > until {
            continue;
        }
        let at = |x: f64| {
            let share = if b.x > a.x { (x - a.x) / (b.x - a.x) } else { 0.0 };
            SeriesPoint::at(x, a.y + share * (b.y - a.y))
        };
        let ends = if b.x > a.x { [at(a.x.max(from)), at(b.x.min(until))] } else { [a, b] };
        points.extend(ends);
    }
    PanelSeries { points, ..series }
}

/// Series of all closed-form solutions under one name, followed by the series of the computed impacts. Later series are
/// drawn on top. `map` converts a path to points.
fn series(bounces: &[Bounce], map: impl Fn(&[PathPoint]) -> Vec<(f64, f64)>) -> Vec<PanelSeries> {
    let one = |label: &str, look, path: &[PathPoint]| {
        PanelSeries::new(label, look, map(path).into_iter().map(|(x, y)| SeriesPoint::at(x, y)))
    };
    let computed = bounces.iter().enumerate().map(|(place, b)| one(&b.name, SeriesStyle::Line(place), &b.path));
    let exact =
        bounces.iter().filter_map(|b| b.analytic.as_ref()).map(|a| one("analytic", SeriesStyle::Exact, &a.path));
    exact.chain(computed).collect()
}
