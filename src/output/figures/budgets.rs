//! Figure of the budgets of the second moments of velocity (means of products of two fluctuations) across the channel.
//! The terms of a budget are the rates at which processes, such as drag or impacts, change the moment.

use super::chart;
use crate::observe::{Budgets, MOMENTS, Terms};
use crate::output::numbers::Prefix;
use crate::output::panel::{Figure, Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::statistics::Estimate;

/// Name of a term of the budget, and the function that selects this term from all terms.
type Named = (&'static str, fn(&Terms<Estimate>) -> Estimate);

/// Terms of a budget (processes that change a second moment of velocity), in the order of the legend.
const TERMS: [Named; 5] = [
    ("production", |terms| terms.production),
    ("impacts", |terms| terms.impacts),
    ("drag", |terms| terms.drag),
    ("transport", |terms| terms.transport),
    ("rest", |terms| terms.rest),
];

/// Figure of the budgets of the second moments of a run between walls at y = 0 and y = `height` [m], with one panel per
/// moment.
pub fn budgets(budgets: &Budgets, height: f64) -> Figure {
    let prefix = Prefix::of(height);
    let panel = |(k, (name, ..)): (usize, (&str, usize, usize))| {
        let series = TERMS.iter().enumerate().map(|(look, (label, pick))| {
            let point = |(y, terms): &(f64, [Terms<Estimate>; 4])| {
                let Estimate { value, error } = pick(&terms[k]);
                SeriesPoint { x: y * prefix.factor, y: value, error }
            };
            PanelSeries::new(*label, SeriesStyle::Line(look), budgets.slices.iter().map(point))
        });
        let symbol: String = name.chars().flat_map(|c| [c, '″']).collect();
        Panel {
            title: format!("⟨{symbol}⟩"),
            x_label: format!("y  [{}m]", prefix.symbol),
            y_label: "m²/s³".into(),
            series: series.collect(),
            x_range: Some((0.0, height * prefix.factor)),
            ..Panel::default()
        }
    };
    let panels: Vec<Panel> = MOMENTS.into_iter().enumerate().map(panel).collect();
    Figure::new(
        "budgets",
        "Rates at which production, impacts, drag and transport change the second moments of the velocity; the rest is their sum.",
        chart::grid(&panels),
    )
}
