//! Profiles across the channel (the paper's Fig. 5 and 7), and their differences in standard errors.

use super::chart::{self, Look, Panel, Point, Series};
use crate::outcome::Outcome;
use crate::output::numbers::Prefix;
use crate::output::reference;
use crate::statistics::{Estimate, SliceRow};

/// Points of the gas profile.
const FLUID_POINTS: usize = 201;

/// Names of the second moments, in the order of [`SliceRow::second`].
const SECOND: [&str; 6] = ["⟨u″u″⟩", "⟨v″v″⟩", "⟨w″w″⟩", "⟨u″v″⟩", "⟨u″w″⟩", "⟨v″w″⟩"];

/// One estimate of a slice.
type Pick = fn(&SliceRow) -> Estimate;

/// Number density over its mean.
pub fn number_density(outcomes: &[Outcome]) -> String {
    let height = Height::of(outcomes);
    let series = lines(outcomes, &height, |row| row.number_density_ratio);
    chart::single(&height.panel("n / ⟨n⟩  [–]", series))
}

/// Mean streamwise velocity, with that of the gas if there is one.
pub fn streamwise_velocity(outcomes: &[Outcome]) -> String {
    let height = Height::of(outcomes);
    let mut series = lines(outcomes, &height, |row| row.mean[0]);
    if let Some(fluid) = outcomes.iter().find_map(|outcome| outcome.experiment.scene.fluid.as_ref()) {
        let point = |k| {
            let y = height.length * k as f64 / (FLUID_POINTS - 1) as f64;
            Point { x: y * height.prefix.factor, y: fluid.profile.velocity(y), error: f64::NAN }
        };
        let points = (0..FLUID_POINTS).map(point).collect();
        series.push(Series { label: "gas".into(), look: Look::Reference, points });
    }
    chart::single(&height.panel("U  [m/s]", series))
}

/// The six second moments, a panel each.
pub fn second_moments(outcomes: &[Outcome]) -> String {
    let height = Height::of(outcomes);
    let panel =
        |k: usize| height.panel(&format!("{}  [m²/s²]", SECOND[k]), lines(outcomes, &height, |row| row.second[k]));
    chart::grid(&(0..SECOND.len()).map(panel).collect::<Vec<_>>())
}

/// Differences from the reference variant in standard errors of the difference, a panel per quantity. Slices are
/// compared place by place; variants with another number of slices are left out.
pub fn differences(outcomes: &[Outcome]) -> String {
    let height = Height::of(outcomes);
    let quantities: [(&str, Pick); 6] = [
        ("n / ⟨n⟩", |row| row.number_density_ratio),
        ("U", |row| row.mean[0]),
        (SECOND[0], |row| row.second[0]),
        (SECOND[1], |row| row.second[1]),
        (SECOND[2], |row| row.second[2]),
        (SECOND[3], |row| row.second[3]),
    ];
    let panels: Vec<Panel> = quantities
        .iter()
        .map(|&(name, pick)| {
            let mut panel = height.panel("Δ / SE  [–]", scores(outcomes, &height, pick));
            panel.title = name.into();
            panel.marks = vec![(-3.0, ""), (0.0, ""), (3.0, "")];
            panel
        })
        .collect();
    chart::grid(&panels)
}

fn lines(outcomes: &[Outcome], height: &Height, pick: impl Fn(&SliceRow) -> Estimate) -> Vec<Series> {
    let series = |(place, outcome): (usize, &Outcome)| {
        let point = |row: &SliceRow| {
            let Estimate { value, error } = pick(row);
            Point { x: row.y * height.prefix.factor, y: value, error }
        };
        let points = outcome.profiles.slices.iter().map(point).collect();
        Series { label: outcome.experiment.name.clone(), look: Look::Line(place), points }
    };
    outcomes.iter().enumerate().map(series).collect()
}

fn scores(outcomes: &[Outcome], height: &Height, pick: Pick) -> Vec<Series> {
    let place_of_reference = reference(outcomes);
    let Some(against) = outcomes.get(place_of_reference) else {
        return Vec::new();
    };
    let score = |(row, base): (&SliceRow, &SliceRow)| {
        let (a, b) = (pick(row), pick(base));
        // No scatter, no score: 0/0 and infinities are left out of the picture.
        Point { x: row.y * height.prefix.factor, y: (a.value - b.value) / a.error.hypot(b.error), error: f64::NAN }
    };
    outcomes
        .iter()
        .enumerate()
        .filter(|(place, outcome)| {
            *place != place_of_reference && outcome.profiles.slices.len() == against.profiles.slices.len()
        })
        .map(|(place, outcome)| Series {
            label: format!("{} − {}", outcome.experiment.name, against.experiment.name),
            look: Look::Points(place),
            points: outcome.profiles.slices.iter().zip(&against.profiles.slices).map(score).collect(),
        })
        .collect()
}

/// The wall-normal axis of all profiles.
struct Height {
    /// [m] height of the domain.
    length: f64,
    prefix: Prefix,
}

impl Height {
    fn of(outcomes: &[Outcome]) -> Self {
        let length = outcomes.iter().map(|outcome| outcome.experiment.scene.domain.size.y).fold(0.0, f64::max);
        Self { length, prefix: Prefix::of(length) }
    }

    fn panel(&self, y_label: &str, series: Vec<Series>) -> Panel {
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
