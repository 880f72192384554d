//! The page of an impact study.

use super::{dictionary, failed, note, page, pictures, table};
use crate::experiment::Model;
use crate::output::figures::Figure;
use crate::output::numbers::{UNKNOWN, count, quantity, significant};
use crate::output::{Bounce, BounceValues, ImpactStudy};
use maud::{Markup, html};

/// The page of an impact study.
pub fn impact(study: &ImpactStudy, figures: &[Figure]) -> String {
    let bounces = study.bounces;
    let failures: Vec<_> = bounces.iter().filter_map(|b| Some((b.name.as_str(), b.failure.as_ref()?))).collect();
    let setting = [
        ("normal speed of approach", format!("{} m/s", significant(study.impact_speed, 4))),
        ("diameter", quantity(study.diameter, "m", 4)),
        ("restitution requested", significant(study.requested_restitution, 4)),
    ];
    let body = html! {
        (failed(&failures))
        (dictionary(&setting))
        h2 { "Pictures" }
        (pictures(figures))
        h2 { "As computed, and in closed form" }
        (values(study))
        h2 { "Work" }
        (work(bounces))
    };
    page(study.provenance, study.verdicts, study.notes, &body, &html! {})
}

fn values(study: &ImpactStudy) -> Markup {
    let cells = |name: String, model: &str, values: &BounceValues, exact: Option<&BounceValues>| {
        let error = exact.map_or(f64::NAN, |exact| values.restitution - exact.restitution);
        let lasting = |text: String| if values.contact_time > 0.0 { text } else { UNKNOWN.into() };
        vec![
            name,
            model.into(),
            significant(values.restitution, 6),
            significant(values.restitution - study.requested_restitution, 2),
            significant(error, 2),
            lasting(quantity(values.contact_time, "s", 4)),
            lasting(quantity(values.maximum_overlap, "m", 4)),
            lasting(significant(values.maximum_overlap / study.diameter, 3)),
        ]
    };
    let mut rows = Vec::new();
    for bounce in study.bounces {
        let model = match bounce.model {
            Model::Soft => "soft",
            Model::Hard => "hard",
        };
        let exact = bounce.analytic.as_ref().map(|analytic| &analytic.values);
        rows.push((bounce.failure.is_some(), cells(bounce.name.clone(), model, &bounce.values, exact)));
        if let Some(exact) = exact {
            rows.push((false, cells("↳ closed form".into(), "", exact, None)));
        }
    }
    let head = [
        "variant",
        "model",
        "restitution e",
        "e − requested",
        "e − closed form",
        "contact time",
        "largest overlap δ",
        "δ/d",
    ];
    html! {
        (table(&head, &rows))
        (note("A collision of hard spheres is instantaneous: it has neither contact time nor overlap."))
    }
}

/// Counts only: the wall time of one impact is that of setting it up and of noting its path.
fn work(bounces: &[Bounce]) -> Markup {
    let row = |b: &Bounce| {
        let step = if b.time_step > 0.0 { quantity(b.time_step, "s", 3) } else { UNKNOWN.into() };
        (b.failure.is_some(), vec![b.name.clone(), step, count(b.work)])
    };
    let rows: Vec<_> = bounces.iter().map(row).collect();
    html! {
        (table(&["variant", "time step", "steps or events"], &rows))
        (note("What methods cost cannot be told from one impact; `diptych chart` measures it over many."))
    }
}
