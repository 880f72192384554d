//! A plan as a text to read or as JSON.

use super::OutputError;
use super::numbers::{UNKNOWN, count, counted, percent, quantity, significant, with_error};
use crate::predict::{Choice, Plan, Recommendation};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// A plan with what it is about.
#[derive(Clone, Debug, Serialize)]
pub struct PlanDocument<'a> {
    /// Path of the case.
    pub case: String,
    /// Its first line.
    pub title: String,
    /// The model that the case itself names.
    pub model_of_the_case: String,
    /// Threads used for the times.
    pub threads: usize,
    /// What was predicted and measured.
    pub plan: &'a Plan,
    /// What to do.
    pub recommendation: &'a Recommendation,
}

/// Unit of every number in the JSON, by key.
const UNITS: [(&str, &str); 55] = [
    ("averaged", "s"),
    ("collision_rate", "1/s"),
    ("contact_time", "s"),
    ("effective_radius", "m"),
    ("stiffness", "N/m"),
    ("contact_value", "1"),
    ("diameter", "m"),
    ("duration", "s"),
    ("duration_as_given", "s"),
    ("effective_mass", "kg"),
    ("gravity", "m/s^2"),
    ("height", "m"),
    ("impact_speed", "m/s"),
    ("kappa", "1"),
    ("largest_island", "1"),
    ("longest", "s"),
    ("mass_loading", "1"),
    ("mean_free_path", "m"),
    ("mean_overlap", "1"),
    ("memory", "byte"),
    ("number", "1"),
    ("overlap_99", "1"),
    ("pair_rate", "1/s"),
    ("particles", "1"),
    ("realised_mean_square", "1"),
    ("realised_restitution", "1"),
    ("response_time", "s"),
    ("restitution", "1"),
    ("simulated", "s"),
    ("size", "m"),
    ("slip_reynolds", "1"),
    ("softness", "1"),
    ("speed", "m/s"),
    ("static_overlap", "1"),
    ("steps", "1"),
    ("steps_per_contact", "1"),
    ("stokes_bulk", "1"),
    ("stokes_friction", "1"),
    ("stokes_time", "s"),
    ("target_error", "1"),
    ("temperature_error", "1"),
    ("terminal_slip", "m/s"),
    ("threads", "1"),
    ("threshold", "1"),
    ("time", "s"),
    ("time_in_contact", "1"),
    ("time_step", "s"),
    ("turbulent_variance", "m^2/s^2"),
    ("variance", "m^2/s^2"),
    ("volume_fraction", "1"),
    ("wall_rate", "1/s"),
    ("wall_seconds", "s"),
    ("weight", "N"),
    ("window", "s"),
    ("windows_timed", "1"),
];

/// The plan as JSON: numbers in SI units, the unit of each key under `units`.
///
/// # Errors
/// A value that JSON cannot hold.
pub fn plan_json(document: &PlanDocument) -> Result<String, OutputError> {
    #[derive(Serialize)]
    struct WithUnits<'a> {
        units: BTreeMap<&'a str, &'a str>,
        #[serde(flatten)]
        document: &'a PlanDocument<'a>,
    }
    let units = UNITS.into_iter().collect();
    let mut text = serde_json::to_string_pretty(&WithUnits { units, document })?;
    text.push('\n');
    Ok(text)
}

/// The plan as text: the answer first, then what it rests on.
pub fn plan_text(document: &PlanDocument) -> String {
    let (plan, advice) = (document.plan, document.recommendation);
    let mut text = format!("{}: {}\n\n", document.case, document.title);
    let _ = writeln!(text, "{}\n", advice.headline());
    advised(&mut text, advice);
    list(&mut text, "Why", &advice.reasons);
    list(&mut text, "Cannot do it", &advice.refused);
    list(&mut text, "Doubtful in this scene", &advice.doubts);
    motion(&mut text, plan);
    contacts(&mut text, plan);
    flow(&mut text, plan);
    effects(&mut text, plan);
    costs(&mut text, plan, document.threads);
    averaging(&mut text, plan);
    text
}

fn advised(text: &mut String, advice: &Recommendation) {
    let mut rows = vec![["window".to_owned(), quantity(advice.window, "s", 3)]];
    if let Some(parameter) = advice.law.map(|law| law.parameter()) {
        let use_of = if advice.engine == Some(Choice::Hard) { " (if soft spheres are used instead)" } else { "" };
        let value = format!("{} {}{use_of}", significant(parameter.value, 3), parameter.unit);
        rows.push([parameter.name.into(), value]);
        let step = advice.time_step.map_or(String::new(), |step| format!(", steps of {}", quantity(step, "s", 3)));
        rows.push(["steps per contact".into(), format!("{}{step}", advice.steps_per_contact)]);
    }
    table(text, &rows);
}

fn list(text: &mut String, title: &str, lines: &[String]) {
    if !lines.is_empty() {
        let _ = writeln!(text, "\n{title}");
        for line in lines {
            let _ = writeln!(text, "  - {line}");
        }
    }
}

fn motion(text: &mut String, plan: &Plan) {
    let _ = writeln!(text, "\nMotion");
    let mut rows = vec![[
        "agitation, T = <u''u''> per component".to_owned(),
        format!("{} m²/s², from {}", significant(plan.agitation.variance, 3), plan.agitation.source),
    ]];
    if let Some(gas) = &plan.gas {
        let theory = "kinetic theory (Enskog)";
        rows.push(["volume fraction".into(), significant(gas.volume_fraction, 3)]);
        rows.push(["collisions of a particle".into(), format!("{} /s, {theory}", significant(gas.collision_rate, 3))]);
        if let Some(run) = &plan.calibration {
            let [rate, error] = run.collision_rate;
            rows.push(["".into(), format!("{} /s, short run", with_error(rate, error))]);
        }
        rows.push(["mean free path".into(), quantity(gas.mean_free_path, "m", 3)]);
        if gas.wall_rate > 0.0 {
            let rate = gas.wall_rate / plan.particles.max(1) as f64;
            rows.push(["wall impacts of a particle".into(), format!("{} /s, {theory}", significant(rate, 3))]);
            if let Some(run) = &plan.calibration {
                let [rate, error] = run.wall_rate;
                rows.push(["".into(), format!("{} /s, short run", with_error(rate, error))]);
            }
        }
        let island = plan
            .largest_island
            .map_or("without bound: one calendar for all".into(), |size| format!("{size} particles"));
        rows.push(["largest island in a window".into(), island]);
    }
    if let Some(share) = plan.time_in_contact {
        rows.push(["time in contact".into(), format!("{} of a particle's time", percent(share, 1.0))]);
    }
    if let Some(shrink) = plan.softness {
        rows.push(["softness".into(), format!("spheres act smaller by {}", percent(shrink, 1.0))]);
    }
    if let Some(rest) = &plan.rest {
        rows.push(["fastest fall on the floor".into(), format!("{} m/s", significant(rest.speed, 3))]);
        let when = if rest.time.is_finite() {
            format!("after about {}", quantity(rest.time, "s", 3))
        } else {
            "never: nothing is lost".into()
        };
        rows.push(["bounces over".into(), when]);
    }
    if let Some(overlap) = plan.static_overlap {
        rows.push(["overlap under the weight at rest".into(), format!("{} d", significant(overlap, 3))]);
    }
    table(text, &rows);
}

fn contacts(text: &mut String, plan: &Plan) {
    if plan.contacts.is_empty() {
        return;
    }
    let _ = writeln!(text, "\nContacts at {}; {}", plan.contact_law, plan.integrator);
    let head = ["", "T_c", "N_c", "impact speed", "κ_n", "mean overlap", "99 % overlap", "e asked", "e realised"];
    let mut rows = vec![head.map(str::to_owned)];
    for row in &plan.contacts {
        rows.push([
            row.contact.name.clone(),
            quantity(row.contact_time, "s", 4),
            significant(row.steps, 3),
            format!("{} m/s", significant(row.impact_speed, 3)),
            significant(row.kappa, 3),
            // of a few bodies only the fastest impact is known
            if plan.gas.is_some() { format!("{} d", significant(row.mean_overlap, 3)) } else { UNKNOWN.into() },
            format!("{} d", significant(row.overlap_99, 3)),
            row.contact.bodies.restitution.to_string(),
            row.realised_restitution.map_or("does not end".into(), |e| format!("{e:.5}")),
        ]);
    }
    table(text, &rows);
    let _ = writeln!(text, "\nLimits on the soft time step; the first binds");
    let rows: Vec<_> =
        plan.step_limits.iter().map(|limit| [limit.name.clone(), quantity(limit.longest, "s", 3)]).collect();
    table(text, &rows);
}

fn flow(text: &mut String, plan: &Plan) {
    if plan.flow.is_empty() {
        return;
    }
    let _ = writeln!(text, "\nParticles in the gas");
    let head = [
        "",
        "Stokes time",
        "terminal slip",
        "τ at that slip",
        "St, bulk velocity",
        "St, friction velocity",
        "mass loading",
    ];
    let mut rows = vec![head.map(str::to_owned)];
    for row in &plan.flow {
        rows.push([
            row.species.clone(),
            quantity(row.stokes_time, "s", 3),
            format!("{} m/s", significant(row.terminal_slip, 3)),
            quantity(row.response_time, "s", 3),
            significant(row.stokes_bulk, 3),
            row.stokes_friction.map_or(String::new(), |number| significant(number, 3)),
            significant(row.mass_loading, 3),
        ]);
    }
    table(text, &rows);
}

fn effects(text: &mut String, plan: &Plan) {
    let _ = writeln!(text, "\nWhat can be left out");
    for effect in &plan.effects {
        let verdict = match (effect.negligible(), effect.modelled) {
            (true, _) => "negligible",
            (false, true) => "matters, is modelled",
            (false, false) => "matters, is not modelled",
        };
        let number = match effect.number {
            Some(number) if number.is_infinite() => "unbounded".into(),
            Some(number) => significant(number, 2),
            None => "unknown".into(),
        };
        let threshold = significant(effect.threshold, 2);
        let _ = writeln!(text, "  {}: {verdict}, {number} (threshold {threshold}: {})", effect.name, effect.source);
        let _ = writeln!(text, "      {}", effect.measure);
    }
}

fn costs(text: &mut String, plan: &Plan, threads: usize) {
    if plan.costs.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "\nCost of {} on this machine, {}, at the case's own settings (from a few windows; {} particles)",
        quantity(plan.duration, "s", 3),
        counted(threads, "thread"),
        count(plan.particles as u64)
    );
    let mut rows = vec![["", "wall time", "memory", "windows timed"].map(str::to_owned)];
    for cost in &plan.costs {
        rows.push([
            cost.model.to_string(),
            match (&cost.failure, cost.wall_seconds) {
                (Some(_), _) => "stops".into(),
                (None, Some(seconds)) => format!("{} s", significant(seconds, 2)),
                (None, None) => "unknown".into(),
            },
            cost.memory.map_or("unknown".into(), |bytes| quantity(bytes, "B", 2)),
            cost.windows_timed.to_string(),
        ]);
    }
    table(text, &rows);
    for why in plan.costs.iter().filter_map(|cost| cost.failure.as_ref()) {
        let _ = writeln!(text, "  {why}");
    }
}

fn averaging(text: &mut String, plan: &Plan) {
    let Some(need) = &plan.averaging else { return };
    let _ = writeln!(
        text,
        "\nFor a standard error of {} of the granular temperature in a slice",
        percent(plan.target_error, 1.0)
    );
    let size = need.size.map(|side| quantity(side, "m", 3)).join(" x ");
    table(
        text,
        &[
            ["in the box of the case".to_owned(), format!("average over {}", quantity(need.duration_as_given, "s", 2))],
            [
                "in the smallest box".to_owned(),
                format!(
                    "{size}, {} particles: average over {}",
                    count(need.particles as u64),
                    quantity(need.duration, "s", 2)
                ),
            ],
        ],
    );
}

/// Columns as wide as what they hold, two spaces apart.
fn table<const COLUMNS: usize>(text: &mut String, rows: &[[String; COLUMNS]]) {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; COLUMNS] = std::array::from_fn(width);
    for row in rows {
        let mut line = String::from("  ");
        for (cell, width) in row.iter().zip(widths) {
            let _ = write!(line, "{cell}{}  ", " ".repeat(width - cell.chars().count()));
        }
        let _ = writeln!(text, "{}", line.trim_end());
    }
}
