//! Figures of profiles across the channel (Fig. 5 and 7 of the paper, docs/paper.md), and of differences of profiles in
//! standard errors. A variant is one of the experiments of a case. Variants that are drawn in the same panel form a
//! group.

use super::chart;
use crate::fluid::Profile;
use crate::observe::GasFlow;
use crate::outcome::Outcome;
use crate::output::groups::{PanelGroup, TOLD_APART, groups, references};
use crate::output::numbers::Prefix;
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::statistics::{
    self, Estimate, MEAN_SPIN_X, NUMBER_DENSITY, ROTATIONAL_TEMPERATURE, SliceColumn, SliceRow, U, UU, UV, VV, WW,
};
use crate::walls::WallGeometry;

/// Number of points of the drawn profile of the gas velocity.
const FLUID_POINTS: usize = 201;

/// Picture of the number density divided by its mean, with a panel per group of variants (experiments of a case). The
/// density is that in the volume that centres of particles can reach.
pub fn number_density(outcomes: &[Outcome]) -> String {
    let height = Height::of(outcomes);
    let panel = |group: &PanelGroup| {
        let series = room(group, &height);
        Panel { title: group.title.clone(), ..height.panel(&format!("{}  [–]", NUMBER_DENSITY.symbol), series) }
    };
    draw(&groups(outcomes).iter().map(panel).collect::<Vec<_>>())
}

/// Picture of the mean streamwise velocity of the particles, with a panel per group of variants (experiments of a
/// case).
pub fn streamwise_velocity(outcomes: &[Outcome]) -> String {
    let height = Height::of(outcomes);
    let panel = |group: &PanelGroup| {
        let series = lines(group, &height, U);
        Panel { title: group.title.clone(), ..height.panel("U  [m/s]", series) }
    };
    draw(&groups(outcomes).iter().map(panel).collect::<Vec<_>>())
}

/// Picture of the mean streamwise velocities of the particles and of the gas; `None` without a gas. A separate picture
/// has the particles alone, because the wider range of the gas velocity hides differences between the experiments.
pub fn beside_the_gas(outcomes: &[Outcome]) -> Option<String> {
    let height = Height::of(outcomes);
    let groups = groups(outcomes);
    groups.iter().find_map(|group| gas(group, &height))?;
    let panel = |group: &PanelGroup| {
        let mut series = lines(group, &height, U);
        series.extend(gas(group, &height));
        Panel { title: group.title.clone(), ..height.panel("U  [m/s]", series) }
    };
    Some(draw(&groups.iter().map(panel).collect::<Vec<_>>()))
}

/// [-] fraction of the slice with the index `k` that centres of spheres can reach. The box is divided into `slices`
/// equal slices along y, and centres stay at least a radius away from walls. `None` if this fraction is zero. For
/// several species or sizes of spheres the result is 1.
fn open_part(outcome: &Outcome, k: usize, slices: usize) -> Option<f64> {
    let scene = &outcome.experiment.scene;
    let ([species], false) = (scene.species.as_slice(), scene.has_sizes()) else { return Some(1.0) };
    let (top, radius) = (scene.domain.size.y, 0.5 * species.diameter);
    let is_wall = |y: f64, facing: f64| {
        scene.walls.iter().any(|wall| match &wall.geometry {
            // the plane is a side of the box, except for rounding
            WallGeometry::Plane(plane) => plane.normal.y == facing && (plane.point.y - y).abs() <= 1e-9 * top,
            _ => false,
        })
    };
    let low = if is_wall(0.0, 1.0) { radius } else { 0.0 };
    let high = if is_wall(top, -1.0) { top - radius } else { top };
    let width = top / slices as f64;
    let open = ((k + 1) as f64 * width).min(high) - (k as f64 * width).max(low);
    (open > 0.0).then(|| (open / width).min(1.0))
}

/// Curves of the number density, divided by its mean, across the channel. The density is that in the volume that
/// centres of particles can reach.
fn room(group: &PanelGroup, height: &Height) -> Vec<PanelSeries> {
    let series = |(place, (name, outcome)): (usize, &(String, &Outcome))| {
        let rows = &outcome.profiles.slices;
        let point = |(k, row): (usize, &SliceRow)| {
            let Estimate { value, error } = row.of(NUMBER_DENSITY)?.times(1.0 / open_part(outcome, k, rows.len())?);
            Some(SeriesPoint { x: row.y * height.prefix.factor, y: value, error })
        };
        PanelSeries::new(name.clone(), SeriesStyle::Line(place), rows.iter().enumerate().filter_map(point))
    };
    group.members.iter().enumerate().map(series).collect()
}

/// Picture of one panel, or of several panels in rows of two.
pub(super) fn draw(panels: &[Panel]) -> String {
    match panels {
        [panel] => chart::single(panel),
        panels => chart::grid(panels),
    }
}

fn gas(group: &PanelGroup, height: &Height) -> Option<PanelSeries> {
    let (outcome, fluid) =
        group.members.iter().find_map(|(_, outcome)| Some((outcome, outcome.experiment.scene.fluid.as_ref()?)))?;
    // in a pipe, the slices contain particles in the whole cross-section, but the gas is drawn in the plane through the
    // axis
    let label = if matches!(fluid.profile, Profile::Pipe(_)) { "gas, in the plane through the axis" } else { "gas" };
    let points = match &outcome.gas {
        Some(gas) => loaded_points(gas, &fluid.profile, height),
        None => gas_points(&fluid.profile, height),
    };
    Some(PanelSeries { label: label.into(), look: SeriesStyle::Reference, points })
}

/// Points of the time-averaged velocity of a gas on which the particles act, at the grid points of both halves of the
/// channel. The grid is computed for one half only.
fn loaded_points(gas: &GasFlow, profile: &Profile, height: &Height) -> Vec<SeriesPoint> {
    let [low, high] = profile.between(height.length);
    let lower = gas.mean.iter().map(|node| (low + node.y, node.u));
    let upper = gas.mean.iter().rev().map(|node| (high - node.y, node.u));
    lower.chain(upper).map(|(y, u)| SeriesPoint::at(y * height.prefix.factor, u)).collect()
}

fn gas_points(profile: &Profile, height: &Height) -> Vec<SeriesPoint> {
    let point = |k| {
        let y = height.length * k as f64 / (FLUID_POINTS - 1) as f64;
        SeriesPoint::at(y * height.prefix.factor, profile.velocity(y))
    };
    (0..FLUID_POINTS).map(point).collect()
}

/// Panel of the gas velocity between walls at y = 0 and y = `length` [m].
pub(super) fn gas_velocity(profile: &Profile, length: f64) -> Panel {
    let height = Height { length, prefix: Prefix::of(length) };
    let line = PanelSeries { label: "gas".into(), look: SeriesStyle::Line(0), points: gas_points(profile, &height) };
    height.panel("U  [m/s]", vec![line])
}

/// Pictures of the six second moments of velocity (means of products of two fluctuations), with a panel per moment.
/// Each entry of the list belongs to a group of variants (experiments of a case): the title of the group, and its
/// picture.
pub fn second_moments(outcomes: &[Outcome]) -> Vec<(String, String)> {
    panels(&groups(outcomes), &Height::of(outcomes), statistics::second_moments())
}

/// Pictures of the mean spins and of the parts of the rotational temperature along x, y and z, with a panel per
/// quantity. Each entry of the list belongs to a group of variants (experiments of a case) with rotating spheres: the
/// title of the group, and its picture.
pub fn spins(outcomes: &[Outcome]) -> Vec<(String, String)> {
    let mut groups = groups(outcomes);
    groups.retain(|group| group.members.iter().any(|(_, outcome)| outcome.experiment.scene.rotation.is_some()));
    panels(&groups, &Height::of(outcomes), &statistics::spin_components().collect::<Vec<_>>())
}

/// Title and picture of each group of variants (experiments of a case). Each picture has a panel for each quantity in
/// `columns`.
fn panels(groups: &[PanelGroup], height: &Height, columns: &[SliceColumn]) -> Vec<(String, String)> {
    let picture = |group: &PanelGroup| {
        let panel = |column: &SliceColumn| {
            height.panel(&format!("{}  [{}]", column.symbol, column.unit), lines(group, height, *column))
        };
        (group.title.clone(), chart::grid(&columns.iter().map(panel).collect::<Vec<_>>()))
    };
    groups.iter().map(picture).collect()
}

/// Picture of the difference between each variant (experiment of a case) and its reference, in standard errors of the
/// difference, with a panel for each quantity. The averages in each slice (layer of the box normal to y) are compared.
/// A variant is left out if its number of slices differs from that of its reference.
pub fn differences(outcomes: &[Outcome]) -> String {
    let height = Height::of(outcomes);
    let rotating = outcomes.iter().all(|outcome| outcome.experiment.scene.rotation.is_some());
    let of_spins = rotating.then_some([MEAN_SPIN_X, ROTATIONAL_TEMPERATURE]);
    let panels: Vec<Panel> = [NUMBER_DENSITY, U, UU, VV, WW, UV]
        .into_iter()
        .chain(of_spins.into_iter().flatten())
        .map(|column| {
            let mut panel = height.panel("Δ / SE  [–]", scores(outcomes, &height, column));
            panel.title = column.symbol.into();
            panel.marks = vec![(-3.0, ""), (0.0, ""), (3.0, "")];
            panel
        })
        .collect();
    chart::grid(&panels)
}

fn lines(group: &PanelGroup, height: &Height, column: SliceColumn) -> Vec<PanelSeries> {
    let series = |(place, (name, outcome)): (usize, &(String, &Outcome))| {
        let point = |row: &SliceRow| {
            let Estimate { value, error } = row.of(column)?;
            Some(SeriesPoint { x: row.y * height.prefix.factor, y: value, error })
        };
        let points = outcome.profiles.slices.iter().filter_map(point).collect();
        PanelSeries { label: name.clone(), look: SeriesStyle::Line(place), points }
    };
    group.members.iter().enumerate().map(series).collect()
}

fn scores(outcomes: &[Outcome], height: &Height, column: SliceColumn) -> Vec<PanelSeries> {
    // without standard errors, the difference cannot be given in standard errors
    let score = |(row, base): (&SliceRow, &SliceRow)| {
        let score = row.of(column)?.less(base.of(column)?).in_errors()?;
        Some(SeriesPoint::at(row.y * height.prefix.factor, score))
    };
    let pairs = references(outcomes).into_iter().enumerate().filter(|(place, reference)| {
        let slices = |k: usize| outcomes[k].profiles.slices.len();
        place != reference && slices(*place) == slices(*reference)
    });
    // a variant has the same style in all pictures; if there are more variants than styles, only the drawn variants are
    // counted to choose a style, so that fewer styles are used twice
    let kept = outcomes.len() <= TOLD_APART;
    pairs
        .enumerate()
        .map(|(order, (place, reference))| {
            let look = if kept { place } else { order };
            let (outcome, against) = (&outcomes[place], &outcomes[reference]);
            PanelSeries {
                label: format!("{} − {}", outcome.experiment.name, against.experiment.name),
                look: SeriesStyle::Points(look),
                points: outcome.profiles.slices.iter().zip(&against.profiles.slices).filter_map(score).collect(),
            }
        })
        .collect()
}

/// Axis y, normal to the walls, that all profiles share.
struct Height {
    /// [m] height of the domain along y, which is the length of the axis.
    length: f64,
    prefix: Prefix,
}

impl Height {
    fn of(outcomes: &[Outcome]) -> Self {
        let length = outcomes.iter().map(|outcome| outcome.experiment.scene.domain.size.y).fold(0.0, f64::max);
        Self { length, prefix: Prefix::of(length) }
    }

    fn panel(&self, y_label: &str, series: Vec<PanelSeries>) -> Panel {
        let end = self.length * self.prefix.factor;
        Panel {
            x_label: format!("y  [{}m]", self.prefix.symbol),
            y_label: y_label.into(),
            series,
            x_range: (end > 0.0 && end.is_finite()).then_some((0.0, end)),
            ..Panel::default()
        }
    }
}
