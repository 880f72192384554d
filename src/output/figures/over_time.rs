//! Figures of curves over time: averages over all particles, and the path of each particle if the particles are few.
//! Theoretical curves are added where a theory is valid. A variant is one of the experiments of a case.

use super::{chart, file_name};
use crate::experiment::Model;
use crate::observe::Row;
use crate::outcome::Outcome;
use crate::output::groups::{PanelGroup, distinct, groups};
use crate::output::numbers::Prefix;
use crate::output::panel::{Figure, Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::predict::closed_form::{Bouncing, Chain, Cooling, settling_velocity};
use nalgebra::Vector3;

/// Number of equal parts of a run in which impact rates are averaged. With fewer parts a curve would have few points,
/// and with more parts there would be few impacts in each part.
const PARTS: usize = 50;

/// Number of intervals from which a theoretical curve is drawn.
const POINTS: usize = 600;

/// [-] largest ratio of the highest to the lowest granular temperature in a panel with a linear axis. Above this ratio,
/// the axis of the temperature is logarithmic.
const DECAY: f64 = 20.0;

/// [-] largest mean velocity, divided by the settling velocity, from which on a line at the settling velocity is
/// drawn. At lower mean velocities this line would lie far outside the curves.
const NEAR: f64 = 0.1;

/// [-] ratio of the mean velocity to the velocity fluctuations. Below this ratio, the mean velocity counts as a
/// rounding error.
const ROUNDING: f64 = 1e-9;

/// Figures of curves over time of a run or a comparison. Variants (experiments of a case) that are drawn in the same
/// panels form a group, and each group has separate figures.
pub fn over_time(outcomes: &[Outcome]) -> Vec<Figure> {
    let mut figures = Vec::new();
    for group in groups(outcomes) {
        let time = TimeAxis::of(&group);
        figures.extend(picture(&group, "over-time", SERIES, series(&group, &time)));
        figures.extend(picture(&group, "paths", PATHS, paths(&group, &time)));
    }
    figures
}

const SERIES: &str = "All particles together over time. Grey: theory where there is one, of hard spheres: a gas left alone cools and \
    collides as Haff (1983) and Enskog's rate say; a sphere in a gas settles where drag carries its weight.";

const PATHS: &str = "Every particle over time, along the axis on which most happens. Grey: theory where there is one, of hard \
    spheres: flights between bounces, or velocities that equal elastic spheres in a row exchange.";

fn picture(group: &PanelGroup, name: &str, caption: &str, panels: Vec<Panel>) -> Option<Figure> {
    if panels.is_empty() {
        return None;
    }
    let svg = chart::grid(&panels);
    Some(if group.title.is_empty() {
        Figure::new(name, caption, svg)
    } else {
        Figure::new(format!("{name}-{}", file_name(&group.title)), format!("{}. {caption}", group.title), svg)
    })
}

/// Time axis that all panels of a group of variants (experiments of a case) share.
struct TimeAxis {
    /// [s] simulated time of the longest run, which is the length of the axis.
    length: f64,
    prefix: Prefix,
}

impl TimeAxis {
    fn of(group: &PanelGroup) -> Self {
        let length = group.members.iter().map(|(_, outcome)| outcome.simulated_seconds).fold(0.0, f64::max);
        Self { length, prefix: Prefix::of(length) }
    }

    /// Makes a panel with this time axis and the given series. Series without points are left out. `None` if only
    /// theoretical series remain.
    fn panel(&self, y_label: String, series: Vec<PanelSeries>) -> Option<Panel> {
        let series: Vec<PanelSeries> = series.into_iter().filter(|series| !series.points.is_empty()).collect();
        let drawn = series.iter().any(|series| !matches!(series.look, SeriesStyle::Exact | SeriesStyle::Reference));
        let x_label = format!("t  [{}s]", self.prefix.symbol);
        drawn.then(|| Panel { x_label, y_label, series, ..Panel::default() })
    }

    fn point(&self, time: f64, value: f64) -> SeriesPoint {
        SeriesPoint::at(time * self.prefix.factor, value)
    }

    /// Theoretical curve over the whole time axis. `of` returns the value of the curve at a time [s]. Times without a
    /// value are left out.
    fn theory(&self, label: &str, of: impl Fn(f64) -> Option<f64>) -> PanelSeries {
        let times = (0..=POINTS).map(|k| self.length * k as f64 / POINTS as f64);
        let points = times.filter_map(|time| Some(self.point(time, of(time)?)));
        PanelSeries::new(label, SeriesStyle::Exact, points)
    }
}

/// Curves of a quantity over time, one per variant (experiment of a case). `of` returns the quantity in a row of the
/// time series, or `None` if the quantity is unknown.
fn lines(group: &PanelGroup, time: &TimeAxis, of: impl Fn(&Row) -> Option<f64>) -> Vec<PanelSeries> {
    let line = |(place, (name, outcome)): (usize, &(String, &Outcome))| {
        let points = outcome.series.rows.iter().filter_map(|row| Some(time.point(row.time, of(row)?)));
        PanelSeries::new(name.clone(), SeriesStyle::Line(place), points)
    };
    group.members.iter().enumerate().map(line).collect()
}

/// Curves of the rate of impacts [1/s] over time, averaged over parts of the run. `count` returns the number of impacts
/// from the start of the run to the time of a row.
fn rates(group: &PanelGroup, time: &TimeAxis, count: impl Fn(&Row) -> u64) -> Vec<PanelSeries> {
    let line = |(place, (name, outcome)): (usize, &(String, &Outcome))| {
        let rows: Vec<&Row> = outcome.series.rows.iter().collect();
        let step = rows.len().div_ceil(PARTS).max(1);
        let ends: Vec<&Row> = rows
            .iter()
            .copied()
            .step_by(step)
            .chain((rows.len() % step != 1).then(|| rows.last()).flatten().copied())
            .collect();
        let part = |pair: &[&Row]| {
            let length = pair[1].time - pair[0].time;
            let rate = (count(pair[1]) - count(pair[0])) as f64 / length;
            (length > 0.0).then(|| time.point(0.5 * (pair[0].time + pair[1].time), rate))
        };
        PanelSeries::new(
            name.clone(),
            SeriesStyle::Line(place),
            ends.windows(2).filter_map(part).collect::<Vec<SeriesPoint>>(),
        )
    };
    group.members.iter().enumerate().map(line).collect()
}

/// Largest magnitude of the vertical coordinate among the points of all series.
fn largest(series: &[PanelSeries]) -> f64 {
    series.iter().flat_map(|series| &series.points).map(|point| point.y.abs()).fold(0.0, f64::max)
}

/// Panel of a quantity whose unit `unit` gets an SI prefix, such as milli. `None` if the quantity is always 0, or if
/// only theoretical series have points.
fn prefixed(time: &TimeAxis, name: &str, unit: &str, mut series: Vec<PanelSeries>) -> Option<Panel> {
    let prefix = Prefix::of(largest(&series));
    series.iter_mut().flat_map(|series| &mut series.points).for_each(|point| point.y *= prefix.factor);
    (largest(&series) > 0.0).then(|| time.panel(format!("{name}  [{}{unit}]", prefix.symbol), series))?
}

fn plain(time: &TimeAxis, label: &str, series: Vec<PanelSeries>) -> Option<Panel> {
    (largest(&series) > 0.0).then(|| time.panel(label.into(), series))?
}

/// Curves of the granular temperature [m²/s²] over time. The list is empty if the temperature is unknown at any instant
/// in any of the runs, as in runs with very few particles.
fn temperature(group: &PanelGroup, time: &TimeAxis) -> Vec<PanelSeries> {
    let known = |outcome: &Outcome| outcome.series.rows.iter().all(|row| row.temperature.is_some());
    let all = group.members.iter().all(|(_, outcome)| known(outcome));
    if all { lines(group, time, Row::granular_temperature) } else { Vec::new() }
}

/// Curves of the mean velocity [m/s] along the axis with the index `axis`. The list is empty if the mean velocities are
/// zero except for rounding errors.
fn velocity(group: &PanelGroup, time: &TimeAxis, axis: usize) -> Vec<PanelSeries> {
    let lines = lines(group, time, |row| Some(row.velocity[axis]));
    let rows = group.members.iter().flat_map(|(_, outcome)| &outcome.series.rows);
    let agitation = rows.filter_map(Row::granular_temperature).fold(0.0, f64::max).sqrt();
    if largest(&lines) > ROUNDING * agitation { lines } else { Vec::new() }
}

/// Panels with averages over all particles, such as the energy, as functions of time.
fn series(group: &PanelGroup, time: &TimeAxis) -> Vec<Panel> {
    let Some((_, first)) = group.members.first() else { return Vec::new() };
    let axis = axis(first);
    let letter = ["x", "y", "z"][axis];
    let cooling = theories(group, |outcome| {
        let start = outcome.series.rows.first().and_then(Row::granular_temperature)?;
        Cooling::of(&outcome.experiment, outcome.particles, start)
    });
    let with = |mut series: Vec<PanelSeries>, theory: Vec<PanelSeries>| {
        series.splice(0..0, theory);
        series
    };
    let cools = |of: fn(&Cooling, f64) -> f64| -> Vec<PanelSeries> {
        cooling.iter().map(|(gas, label)| time.theory(label, |t| Some(of(gas, t)))).collect()
    };
    let (haff, enskog) = (cools(Cooling::temperature), cools(Cooling::pair_rate));
    let temperature = temperature(group, time);
    let least = temperature.iter().flat_map(|series| &series.points).map(|point| point.y).fold(f64::INFINITY, f64::min);
    let decays = least > 0.0 && largest(&temperature) > DECAY * least;
    let velocity = velocity(group, time, axis);
    let most = largest(&velocity);
    let settles = theories(group, |outcome| {
        let settled = settling_velocity(&outcome.experiment.scene)?[axis];
        (most > NEAR * settled.abs()).then_some(settled)
    });
    let settles = settles.iter().map(|(settled, label)| time.theory(label, |_| Some(*settled))).collect();
    let panels = [
        plain(time, "T  [m²/s²]", with(temperature, haff)).map(|panel| Panel { log_y: decays, ..panel }),
        plain(time, "T_r  [m²/s²]", lines(group, time, |row| row.rotational_temperature())),
        plain(time, &format!("mean velocity, {letter}  [m/s]"), with(velocity, settles)),
        prefixed(time, "energy", "J", lines(group, time, |row| Some(row.energy()))),
        plain(time, "pair impacts  [1/s]", with(rates(group, time, |row| row.pair_impacts), enskog)),
        plain(time, "wall impacts  [1/s]", rates(group, time, |row| row.wall_impacts)),
        plain(time, "contacts per particle  [–]", lines(group, time, |row| Some(row.coordination))),
        plain(time, "largest overlap / d  [–]", lines(group, time, |row| Some(row.largest_overlap))),
        prefixed(time, &format!("centre of mass, {letter}"), "m", lines(group, time, |row| row.centre[axis])),
    ];
    panels.into_iter().flatten().collect()
}

/// Index of the axis along which most of the motion occurs. With gravity, it is the axis along which gravity has its
/// largest component. Without gravity, it is the axis of the largest velocity in the recorded paths. If nothing moves,
/// it is the streamwise axis z.
fn axis(outcome: &Outcome) -> usize {
    let gravity = outcome.experiment.scene.gravity_alone();
    let speeds =
        outcome.paths.points.iter().fold(Vector3::zeros(), |most: Vector3<f64>, point| most.sup(&point.velocity.abs()));
    match (gravity.norm() > 0.0, speeds.norm() > 0.0) {
        (true, _) => gravity.iamax(),
        (false, true) => speeds.iamax(),
        (false, false) => 2,
    }
}

/// Distinct theories of the variants (experiments of a case) of a group, each with the label of its curves. The label
/// names the variants with this theory, unless all have it. `of` returns the theory of a variant, or `None` if there is
/// no theory for it.
fn theories<T: PartialEq>(group: &PanelGroup, of: impl Fn(&Outcome) -> Option<T>) -> Vec<(T, String)> {
    let each = group.members.iter().map(|(name, outcome)| (name.as_str(), of(outcome)));
    distinct(each).into_iter().map(|(theory, whose)| (theory, format!("theory{whose}"))).collect()
}

/// Theory of the motion of single particles.
#[derive(PartialEq)]
enum PathTheory {
    /// Theory of one sphere that bounces.
    Bouncing(Bouncing),
    /// Theory of equal spheres in a row.
    Chain(Chain),
}

impl PathTheory {
    /// Position [m] and velocity [m/s] of the particle with the id `id` at `time` [s]; `None` if the theory does not
    /// give them.
    fn at(&self, id: usize, time: f64) -> Option<[Vector3<f64>; 2]> {
        match self {
            Self::Bouncing(bouncing) => bouncing.at(time),
            Self::Chain(chain) => chain.at(id, time),
        }
    }
}

/// Theory of a single bouncing sphere or of a row of equal spheres; `None` for other scenes.
fn theory(outcome: &Outcome) -> Option<PathTheory> {
    let points = &outcome.paths.points;
    let start: Vec<_> = points.iter().take(outcome.particles).map(|point| [point.position, point.velocity]).collect();
    if let [start] = start[..] {
        return Bouncing::of(&outcome.experiment, start).map(PathTheory::Bouncing);
    }
    // in the DSMC model, pairs collide by chance and otherwise fly through each other, so that the order in a row is
    // not kept
    let chain = Chain::of(&outcome.experiment.scene, &start).filter(|_| outcome.experiment.model() != Model::Dsmc);
    chain.map(PathTheory::Chain)
}

/// Panels of the position and the velocity of every particle along one axis.
fn paths(group: &PanelGroup, time: &TimeAxis) -> Vec<Panel> {
    let Some((_, first)) = group.members.first().filter(|(_, first)| !first.paths.points.is_empty()) else {
        return Vec::new();
    };
    let axis = axis(first);
    let letter = ["x", "y", "z"][axis];
    let theories = theories(group, theory);
    let all = |which: usize| {
        let of = |point: &crate::observe::PathSample| [point.position, point.velocity][which][axis];
        let mut series = Vec::new();
        for (theory, label) in &theories {
            let path = |id| time.theory(label, |t| Some(theory.at(id, t)?[which][axis]));
            series.extend((0..first.particles).map(path));
        }
        for (place, (name, outcome)) in group.members.iter().enumerate() {
            for id in 0..outcome.particles {
                let own = outcome.paths.points.iter().filter(|point| point.id as usize == id);
                let points = own.map(|point| time.point(point.time, of(point)));
                series.push(PanelSeries::new(name.clone(), SeriesStyle::Line(place), points));
            }
        }
        series
    };
    let panels = [prefixed(time, letter, "m", all(0)), plain(time, &format!("v_{letter}  [m/s]"), all(1))];
    panels.into_iter().flatten().collect()
}
