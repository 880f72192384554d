//! Figures of the measurements that a case requests. A variant is one of the experiments of a case. Variants that are
//! drawn in the same panel form a group.

use super::file_name;
use super::map::map;
use super::profiles::draw;
use crate::observe::{Observation, ObservedCurve, ObservedQuantity};
use crate::outcome::Outcome;
use crate::output::groups::{PanelGroup, distinct, groups};
use crate::output::numbers::Prefix;
use crate::output::panel::{Figure, Panel, PanelSeries, SeriesPoint, SeriesStyle};

/// Name of the figures of a measurement: the name of the measurement in the case, with hyphens instead of underscores.
pub fn of_measurement(name: &str) -> String {
    name.replace('_', "-")
}

/// Figures of all measurements, one for each measurement and group of variants (experiments of a case), with a panel
/// per curve.
pub fn measurements(outcomes: &[Outcome]) -> Vec<Figure> {
    groups(outcomes).iter().flat_map(of_group).collect()
}

fn of_group(group: &PanelGroup) -> Vec<Figure> {
    let mut names: Vec<&Observation> = Vec::new();
    for observed in group.members.iter().flat_map(|(_, outcome)| &outcome.observations) {
        if !names.iter().any(|known| known.name == observed.name) && !observed.curves.is_empty() {
            names.push(observed);
        }
    }
    let figure = |first: &&Observation| {
        let panels: Vec<Panel> = first.curves.iter().map(|curve| panel(group, first, curve)).collect();
        let name = of_measurement(first.name);
        let caption = format!("{}. Band: one standard error.", first.title);
        let (name, caption) = match group.title.as_str() {
            "" => (name, caption),
            title => (format!("{name}-{}", file_name(title)), format!("{title}. {caption}")),
        };
        Figure::new(name, caption, draw(&panels))
    };
    names.iter().map(figure).chain(group.members.iter().flat_map(|(name, outcome)| maps(name, outcome))).collect()
}

/// Maps of the fields that an experiment measures on grids that are one cell thick.
fn maps(variant: &str, outcome: &Outcome) -> Vec<Figure> {
    let figure = |observed: &Observation| {
        let name = format!("{}-map-{}", of_measurement(observed.name), file_name(&outcome.experiment.name));
        let (picture, meaning) = map(observed.grid.as_ref()?)?;
        let title = observed.title;
        let caption = format!("{title} of “{variant}” at the sample with the largest contrast. Colours: {meaning}.");
        Some(Figure::new(name, caption, picture))
    };
    outcome.observations.iter().filter_map(figure).collect()
}

/// Panel of a curve of a measurement, with one line for each variant (experiment of a case) that has this curve.
fn panel(group: &PanelGroup, first: &Observation, curve: &ObservedCurve) -> Panel {
    let lines: Vec<(usize, &str, &Observation, &ObservedCurve)> = (0..)
        .zip(&group.members)
        .filter_map(|(place, (name, outcome))| {
            let observed = outcome.observations.iter().find(|observed| observed.name == first.name)?;
            let own = observed.curves.iter().find(|own| own.quantity.column == curve.quantity.column)?;
            Some((place, name.as_str(), observed, own))
        })
        .collect();
    let furthest = lines.iter().flat_map(|(_, _, observed, _)| &observed.places).copied().fold(0.0, f64::max);
    let values = lines.iter().flat_map(|(.., curve)| curve.values.iter().flatten());
    let largest = values.map(|value| value.value.abs()).fold(0.0, f64::max);
    let ([x, y], [x_label, y_label]) = scales([(&first.axis, furthest), (&curve.quantity, largest)]);
    let theories = lines.iter().map(|(_, name, observed, curve)| {
        (*name, curve.theory.as_ref().map(|(source, values)| (*source, (&observed.places, values))))
    });
    let exact = distinct(theories).into_iter().map(|((source, (places, theory)), whose)| {
        let points = places.iter().zip(theory).map(|(place, value)| SeriesPoint::at(place * x, value * y));
        PanelSeries::new(format!("{source}{whose}"), SeriesStyle::Exact, points)
    });
    let measured = lines.iter().map(|(style, name, observed, curve)| {
        let points = observed.places.iter().zip(&curve.values).filter_map(|(place, value)| {
            let value = value.as_ref()?.times(y);
            Some(SeriesPoint { x: place * x, y: value.value, error: value.error })
        });
        PanelSeries::new(*name, SeriesStyle::Line(*style), points)
    });
    Panel { x_label, y_label, series: exact.chain(measured).collect(), log_y: curve.is_logarithmic, ..Panel::default() }
}

/// Factors by which two quantities are multiplied for their axes, and the labels of the axes. The SI prefixes follow
/// from the given largest values. Pure numbers and units with a power have no prefix.
fn scales(of: [(&ObservedQuantity, f64); 2]) -> ([f64; 2], [String; 2]) {
    let scale = |(quantity, largest): (&ObservedQuantity, f64)| {
        let (symbol, unit) = (&quantity.symbol, quantity.unit);
        match unit {
            "" => (1.0, format!("{symbol}  [–]")),
            "m" | "s" | "Pa" | "J" | "N" => {
                let prefix = Prefix::of(largest);
                (prefix.factor, format!("{symbol}  [{}{unit}]", prefix.symbol))
            }
            _ => (1.0, format!("{symbol}  [{unit}]")),
        }
    };
    let [(x, x_label), (y, y_label)] = of.map(scale);
    ([x, y], [x_label, y_label])
}
