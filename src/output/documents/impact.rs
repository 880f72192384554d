//! Document of an impact study, which computes one impact with several variants. A variant is one of the experiments of
//! a case.

use crate::output::document::{Block, Document, TextRow, known, status};
use crate::output::numbers::{count, quantity, significant};
use crate::output::player::Player;
use crate::output::{Bounce, BounceValues, Folder, ImpactStudy, OutputError, csv, figures};
use serde_json::{Value, json};
use std::path::PathBuf;

/// Writes all results of an impact study, and returns the path of the report.
///
/// # Errors
/// An [`OutputError`]. Files written before the error remain, but there is no `summary.json`.
pub fn write_impact(folder: &Folder, study: &ImpactStudy) -> Result<PathBuf, OutputError> {
    let bounces = study.bounces;
    let figures = figures::impact(bounces, study.oblique);
    let mut body = vec![
        Block::entries([
            ("normal speed of approach", format!("{} m/s", significant(study.impact_speed, 4))),
            ("diameter", quantity(study.diameter, "m", 4)),
            ("restitution requested", significant(study.requested_restitution, 4)),
        ]),
        Block::Section("pictures", "Pictures".into()),
        Block::Figures(0..figures.len()),
        Block::heading("As computed, and in closed form"),
        values(study),
        Block::note("A collision of hard spheres is instantaneous: it has neither contact time nor overlap."),
        softness(study),
        Block::heading("Work"),
        Block::table("variant | time step | steps or events", bounces.iter().map(work)),
        Block::note("What methods cost cannot be told from one impact; `diptych chart` measures it over many."),
    ];
    let mut tables = vec![("impact.csv".into(), csv::bounces(bounces)?)];
    if let Some(oblique) = study.oblique {
        tables.push(("oblique.csv".into(), csv::oblique(oblique)?));
        body.push(Block::note("Oblique impacts are run without gas, gravity and spin, at the normal speed of the case. Measured points: aluminium oxide on glass, friction 0.092; in these units they do not depend on friction and speed."));
    }
    if let Some(player) = Player::of_impact(study) {
        body.insert(1, Block::Player(Box::new(player)));
    }
    let document = Document {
        provenance: study.provenance,
        failures: bounces.iter().filter_map(|b| Some((b.name.as_str(), b.failure.as_ref()?))).collect(),
        verdicts: study.verdicts,
        answers: usize::MAX,
        front: Vec::new(),
        notes: study.notes,
        body,
        tail: Vec::new(),
        tables,
        figures,
    };
    let numbers = json!({
        "requested_restitution": study.requested_restitution,
        "diameter": study.diameter,
        "impact_speed": study.impact_speed,
        "oblique": study.oblique.map(|oblique| {
            let of = |k: usize| oblique.difference(k).map(|(share, slip)| json!({ "variant": oblique.curves[k].name, "share_of_friction_impulse": share, "reduced_slip": slip }));
            (1..oblique.curves.len()).filter_map(of).collect::<Vec<_>>()
        }),
        "variants": bounces.iter().map(numbers).collect::<Vec<_>>(),
    });
    document.write(folder, numbers)
}

/// Table of restitution, contact time and largest overlap of each variant (experiment of a case). If there is a
/// closed-form solution, a further row contains the values of this solution.
fn values(study: &ImpactStudy) -> Block {
    let cells = |name: &str, model: &str, values: &BounceValues, exact: Option<&BounceValues>| {
        let off = |asked: Option<f64>| Some(values.restitution? - asked?);
        let lasting = |text: String| known(values.contact_time > Some(0.0), text);
        vec![
            name.into(),
            model.into(),
            significant(values.restitution, 6),
            significant(off(Some(study.requested_restitution)), 2),
            significant(off(exact.and_then(|exact| exact.restitution)), 2),
            lasting(quantity(values.contact_time, "s", 4)),
            lasting(quantity(values.maximum_overlap, "m", 4)),
            lasting(significant(values.maximum_overlap.map(|overlap| overlap / study.diameter), 3)),
        ]
    };
    let rows = study.bounces.iter().flat_map(|bounce| {
        let model = bounce.model.name();
        let exact = bounce.analytic.as_ref().map(|analytic| &analytic.values);
        let computed = (bounce.failure.is_some(), cells(&bounce.name, model, &bounce.values, exact));
        [Some(computed), exact.map(|exact| (false, cells("↳ closed form", "", exact, None)))].into_iter().flatten()
    });
    Block::table(
        "variant | model | restitution e | e − requested | e − closed form | contact time | largest overlap δ | δ/d",
        rows,
    )
}

/// Sentence stating that a softer spring takes fewer time steps but overlaps more deeply. The sentence names the
/// variant (experiment of a case) with the deepest overlap, and is empty if there is no overlap.
fn softness(study: &ImpactStudy) -> Block {
    let share =
        |bounce: &Bounce| Some(bounce.values.maximum_overlap.filter(|overlap| *overlap > 0.0)? / study.diameter);
    let deepest = study.bounces.iter().filter_map(|bounce| Some((share(bounce)?, bounce)));
    let words = deepest.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(share, bounce)| {
        format!(
            "A softer spring takes fewer steps, and a single impact has the restitution all the same. Its price is a deeper and longer contact: in a crowd the spheres act as if smaller, and more \
             often touch several others at once. \"{}\" overlaps by {} % of the diameter here; the sheet “How far to trust this” of a run marks mean overlaps above 1 %.",
            bounce.name,
            significant(100.0 * share, 2),
        )
    });
    Block::note(words.unwrap_or_default())
}

/// Row of a table with the time step, and with the number of time steps or events of an experiment. Wall-clock time is
/// left out, because it is mostly spent on preparing the impact and storing its path.
fn work(bounce: &Bounce) -> TextRow {
    let step = quantity(bounce.time_step, "s", 3);
    (bounce.failure.is_some(), vec![bounce.name.clone(), step, count(bounce.work)])
}

/// Results of one experiment of an impact study for `summary.json`.
fn numbers(bounce: &Bounce) -> Value {
    json!({
        "name": bounce.name,
        "model": bounce.model,
        "status": status(bounce.failure.is_some()),
        "failure": bounce.failure,
        "failure_message": bounce.failure.as_ref().map(ToString::to_string),
        "restitution": bounce.values.restitution,
        "contact_time": bounce.values.contact_time,
        "maximum_overlap": bounce.values.maximum_overlap,
        "analytic": bounce.analytic.as_ref().map(|analytic| analytic.values),
        "time_step": bounce.time_step,
        "steps_or_events": bounce.work,
        "wall_seconds": bounce.wall_seconds,
        "parameters": bounce.parameters,
    })
}
