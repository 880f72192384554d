//! Document of a plan (predictions before a run), as text or as JSON.

use crate::output::OutputError;
use crate::output::document::{Block, TextRow, known, text};
use crate::output::numbers::{count, counted, percent, quantity, significant, with_error};
use crate::predict::{EngineChoice, Recommendation, RunPrediction};
use crate::statistics::Estimate;
use serde::Serialize;
use std::collections::BTreeMap;

/// Predictions and recommendation of a plan, with data of the case.
#[derive(Clone, Debug, Serialize)]
pub struct PlanDocument<'a> {
    /// Path of the case file.
    pub case: String,
    /// Title of the case: first paragraph of the comment at the beginning of the case file.
    pub title: String,
    /// Collision model that the case file sets.
    pub model_of_the_case: String,
    /// Number of threads for which computing times are predicted.
    pub threads: usize,
    /// Predictions for the run, and measurements in a short run.
    pub plan: &'a RunPrediction,
    /// Recommended engine, contact law and time step.
    pub recommendation: &'a Recommendation,
}

/// Units of all numbers in the JSON. Each entry is a unit, followed by the keys of the numbers in this unit.
const UNITS: [(&str, &str); 11] = [
    (
        "s",
        "at_rest averaged contact_time duration duration_as_given fall longest response_time simulated stokes_time time \
         time_step wall_seconds window",
    ),
    ("1/s", "collision_rate pair_rate shear_rate wall_rate"),
    ("m", "effective_radius diameter height mean_free_path size"),
    ("N/m", "stiffness"),
    (
        "1",
        "coming contact_over_shear contact_value dissipation_over_shear kappa largest_island largest_stress_change lying \
         mass_loading mean_overlap number overlap_99 particles realised_mean_square realised_restitution replicas \
         restitution scatter share slip_reynolds softness static_overlap steps steps_per_contact stokes_bulk stokes_friction target_error temperature_error threads threshold \
         time_in_contact volume_fraction windows_timed",
    ),
    ("kg", "effective_mass"),
    ("m/s^2", "gravity"),
    ("m/s", "impact_speed speed terminal_slip"),
    ("byte", "memory"),
    ("m^2/s^2", "turbulent_variance variance"),
    ("N", "weight"),
];

/// Plan (predictions before a run) as JSON. Numbers are in SI, and the entry `units` contains the unit of each key.
///
/// # Errors
/// Returns an error if a value cannot be written as JSON.
pub fn plan_json(document: &PlanDocument) -> Result<String, OutputError> {
    #[derive(Serialize)]
    struct WithUnits<'a> {
        units: BTreeMap<&'a str, &'a str>,
        #[serde(flatten)]
        document: &'a PlanDocument<'a>,
    }
    let units = UNITS.iter().flat_map(|(unit, keys)| keys.split_whitespace().map(|key| (key, *unit))).collect();
    let mut text = serde_json::to_string_pretty(&WithUnits { units, document })?;
    text.push('\n');
    Ok(text)
}

/// Plan (predictions before a run) as text: first the recommendation, then the data from which the recommendation
/// follows.
pub fn plan_text(document: &PlanDocument) -> String {
    let (plan, advice) = (document.plan, document.recommendation);
    let mut blocks = vec![
        Block::Paragraph(format!("{}: {}", document.case, document.title)),
        Block::Paragraph(advice.headline()),
        advised(advice),
    ];
    // the recommendation does not consider failures in the short runs whose computing time is measured, so a note names
    // such a failure if all short runs failed
    let stopped: Vec<&String> = plan.costs.iter().filter_map(|cost| cost.failure.as_ref()).collect();
    if let Some(why) = stopped.first().filter(|_| stopped.len() == plan.costs.len()) {
        blocks.push(Block::note(format!("No model comes to the end of the windows that were timed below: {why}.")));
    }
    for (title, lines) in
        [("Why", &advice.reasons), ("Cannot do it", &advice.refused), ("Doubtful in this scene", &advice.doubts)]
    {
        if !lines.is_empty() {
            blocks.extend([Block::heading(title), Block::List(lines.clone())]);
        }
    }
    blocks.extend([Block::heading("Motion"), motion(plan)]);
    blocks.extend(contacts(plan));
    blocks.extend(flow(plan));
    blocks.extend(effects(plan));
    blocks.extend(costs(plan, document.threads));
    blocks.extend(averaging(plan));
    blocks.extend(transient(plan));
    text(&blocks)
}

/// Largest number of rows in a table of the plan, so that the table fits on a screen.
const MOST_ROWS: usize = 12;

/// Note on the number of rows that a table leaves out because it shows at most [`MOST_ROWS`] rows. `rows` is the number
/// of all rows. `None` if no row is left out.
fn left_out(rows: usize) -> Option<Block> {
    let more = rows.checked_sub(MOST_ROWS).filter(|more| *more > 0)?;
    Some(Block::Note(format!("and {} more, all with --json", counted(more, "row"))))
}

/// List of terms with their values, which grows by one entry at a time.
#[derive(Default)]
struct Entries(Vec<(String, String)>);

impl Entries {
    fn add(&mut self, term: impl Into<String>, text: impl Into<String>) {
        self.0.push((term.into(), text.into()));
    }
}

fn advised(advice: &Recommendation) -> Block {
    let mut entries = Entries::default();
    entries.add("window", quantity(advice.window, "s", 3));
    if let Some(parameter) = advice.law.map(|law| law.parameter()) {
        let use_of = if advice.engine == Some(EngineChoice::Hard) { " (if soft spheres are used instead)" } else { "" };
        entries.add(parameter.name, format!("{} {}{use_of}", significant(parameter.value, 3), parameter.unit));
        let step = advice.time_step.map_or(String::new(), |step| format!(", steps of {}", quantity(step, "s", 3)));
        entries.add("steps per contact", format!("{}{step}", advice.steps_per_contact));
    }
    Block::Entries(entries.0)
}

fn motion(plan: &RunPrediction) -> Block {
    let mut entries = Entries::default();
    if let Some(coming) = plan.coming {
        entries.add("particles from inlets", format!("up to about {} at once", count(coming as u64)));
    }
    entries.add(
        "agitation, T = <u''u''> per component",
        format!("{} m²/s², from {}", significant(plan.agitation.variance, 3), plan.agitation.source),
    );
    if let Some(gas) = &plan.gas {
        let theory = "kinetic theory (Enskog)";
        entries.add("volume fraction", significant(gas.volume_fraction, 3));
        entries.add("collisions of a particle", format!("{} /s, {theory}", significant(gas.collision_rate, 3)));
        let short_run = |[value, error]: [Option<f64>; 2]| {
            format!("{} /s, short run", with_error(value.map(|value| Estimate { value, error })))
        };
        if let Some(run) = &plan.calibration {
            entries.add("", short_run(run.collision_rate));
        }
        entries.add("mean free path", quantity(gas.mean_free_path, "m", 3));
        if gas.wall_rate > 0.0 {
            let rate = gas.wall_rate / plan.particles.max(1) as f64;
            entries.add("wall impacts of a particle", format!("{} /s, {theory}", significant(rate, 3)));
            if let Some(run) = &plan.calibration {
                entries.add("", short_run(run.wall_rate));
            }
        }
        let island =
            plan.largest_island.map_or("without bound: one calendar for all".into(), |size| counted(size, "particle"));
        entries.add("largest island in a window", island);
    }
    if let Some(share) = plan.time_in_contact {
        entries.add("time in contact", format!("{} of a particle's time", percent(share, 1.0)));
    }
    if let Some(shrink) = plan.softness {
        entries.add("softness", format!("spheres act smaller by {}", percent(shrink, 1.0)));
    }
    if let Some(shear) = &plan.shear {
        entries.add("contact time times shear rate", significant(shear.contact_over_shear, 3));
        entries.add("dissipation rate over shear rate", significant(shear.dissipation_over_shear, 3));
        let (error, from) = (percent(plan.target_error, 1.0), &shear.hard_from);
        let change = match shear.largest_stress_change {
            Some(change) => format!("up to {} off that of hard spheres", percent(change, 1.0)),
            None => "unlike that of hard spheres".to_owned(),
        };
        entries.add("shear stress", format!("{change}; within {error} of it from {from} on"));
    }
    if let Some(rest) = &plan.rest {
        let name = if rest.rises { "fastest rise to the upper wall" } else { "fastest fall on the floor" };
        entries.add(name, format!("{} m/s", significant(rest.speed, 3)));
        let ends = rest.time.is_finite();
        let after = format!("after about {}", quantity(rest.time, "s", 3));
        entries.add("bounces over", if ends { after } else { "never: nothing is lost".into() });
    }
    if let Some(overlap) = plan.static_overlap {
        entries.add("overlap under the weight at rest", format!("{} d", significant(overlap, 3)));
    }
    Block::Entries(entries.0)
}

fn contacts(plan: &RunPrediction) -> Vec<Block> {
    if plan.contacts.is_empty() {
        return Vec::new();
    }
    // if all contacts have the same stiffness, it is in the heading only, otherwise each row has its own
    let own = plan.contacts.iter().any(|row| row.contact.bodies.stiffness_ratio != 1.0);
    let rows = plan.contacts.iter().take(MOST_ROWS).map(|row| -> TextRow {
        let stiffness = own.then(|| format!("{} N/m", significant(row.stiffness, 4)));
        let mut cells: Vec<String> = std::iter::once(row.contact.name.clone()).chain(stiffness).collect();
        cells.extend([
            quantity(row.contact_time, "s", 4),
            significant(row.steps, 3),
            format!("{} m/s", significant(row.impact_speed, 3)),
            significant(row.kappa, 3),
            // a scene of a few bodies has no mean overlap: only the fastest impact is predicted
            known(plan.gas.is_some(), format!("{} d", significant(row.mean_overlap, 3))),
            format!("{} d", significant(row.overlap_99, 3)),
            match row.contact.bodies.by_speed {
                None => row.contact.bodies.restitution.to_string(),
                Some(_) => format!("{} at this mean speed", significant(row.contact.bodies.restitution, 4)),
            },
            row.realised_restitution.map_or("does not end".into(), |e| format!("{e:.5}")),
        ]);
        (false, cells)
    });
    let limits =
        plan.step_limits.iter().take(MOST_ROWS).map(|limit| (limit.name.clone(), quantity(limit.longest, "s", 3)));
    let mut blocks = vec![
        Block::Heading(format!("Contacts at {}; {}", plan.contact_law, plan.integrator)),
        Block::table(
            &format!(
                "{} | T_c | N_c | impact speed | κ_n | mean overlap | 99 % overlap | e asked | e realised",
                if own { " | k_n" } else { "" }
            ),
            rows,
        ),
    ];
    blocks.extend(left_out(plan.contacts.len()));
    blocks.extend([Block::heading("Limits on the soft time step; the first binds"), Block::Entries(limits.collect())]);
    blocks.extend(left_out(plan.step_limits.len()));
    blocks
}

fn flow(plan: &RunPrediction) -> Vec<Block> {
    if plan.flow.is_empty() {
        return Vec::new();
    }
    let rows = plan.flow.iter().take(MOST_ROWS).map(|row| -> TextRow {
        let cells = vec![
            row.species.clone(),
            quantity(row.stokes_time, "s", 3),
            format!("{} m/s", significant(row.terminal_slip, 3)),
            quantity(row.response_time, "s", 3),
            significant(row.stokes_bulk, 3),
            row.stokes_friction.map_or(String::new(), |number| significant(number, 3)),
            significant(row.mass_loading, 3),
        ];
        (false, cells)
    });
    let head =
        " | Stokes time | terminal slip | τ at that slip | St, bulk velocity | St, friction velocity | mass loading";
    [Block::heading("Particles in the gas"), Block::table(head, rows)]
        .into_iter()
        .chain(left_out(plan.flow.len()))
        .collect()
}

fn effects(plan: &RunPrediction) -> Vec<Block> {
    let of_one = plan.effects.iter().flat_map(|effect| {
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
        let line = format!("{}: {verdict}, {number} (threshold {threshold}: {})", effect.name, effect.source);
        [Block::Note(line), Block::Note(format!("    {}", effect.measure))]
    });
    std::iter::once(Block::heading("What can be left out")).chain(of_one).collect()
}

fn costs(plan: &RunPrediction, threads: usize) -> Vec<Block> {
    if plan.costs.is_empty() {
        return Vec::new();
    }
    let title = format!(
        "Cost of {} on this machine, {}, at the case's own settings (from a few windows; {} particles{})",
        quantity(plan.duration, "s", 3),
        counted(threads, "thread"),
        count(plan.particles as u64),
        if plan.coming.is_some() { " at the start" } else { "" }
    );
    let rows = plan.costs.iter().map(|cost| -> TextRow {
        let time = match (&cost.failure, cost.wall_seconds) {
            (Some(_), _) => "stops".into(),
            (None, Some(seconds)) => format!("{} s", significant(seconds, 2)),
            (None, None) => "unknown".into(),
        };
        let memory = cost.memory.map_or("unknown".into(), |bytes| quantity(bytes, "B", 2));
        (false, vec![cost.model.to_string(), time, memory, cost.windows_timed.to_string()])
    });
    let table = Block::table(" | wall time | memory | windows timed", rows);
    let causes = plan.costs.iter().filter_map(|cost| cost.failure.as_ref()).map(Block::note);
    let bed = plan.costs.iter().any(|cost| cost.failure.is_none() && cost.wall_seconds.is_none()).then(|| {
        let share = percent(plan.share_at_rest(), 1.0);
        let words = "The windows timed are of the start, when particles fly; in a bed islands hold all particles, and local stepping costs";
        Block::Note(format!("Particles lie for {share} of the run. {words} more than uniform stepping."))
    });
    [Block::Heading(title), table].into_iter().chain(causes).chain(bed).collect()
}

fn averaging(plan: &RunPrediction) -> Vec<Block> {
    let Some(need) = &plan.averaging else { return Vec::new() };
    let error = percent(plan.target_error, 1.0);
    let size = need.size.map(|side| quantity(side, "m", 3)).join(" x ");
    let particles = count(need.particles as u64);
    vec![
        Block::Heading(format!("For a standard error of {error} of the granular temperature in a slice")),
        Block::entries([
            ("in the box of the case", format!("average over {}", quantity(need.duration_as_given, "s", 2))),
            (
                "in the smallest box",
                format!("{size}, {particles} particles: average over {}", quantity(need.duration, "s", 2)),
            ),
        ]),
    ]
}

/// Part of the document with predictions for a scene that never becomes steady. The list is empty for other scenes.
fn transient(plan: &RunPrediction) -> Vec<Block> {
    let Some(found) = &plan.transient else { return Vec::new() };
    let mut entries = Entries::default();
    for loss in &found.losses {
        entries.add(format!("{} of that energy lost", percent(loss.share, 1.0)), after(loss.time));
    }
    if let Some(time) = found.at_rest {
        entries.add("at rest", format!("{} at the latest", after(time)));
    }
    let error = percent(plan.target_error, 1.0);
    let scatter = percent(found.scatter, 1.0);
    let runs = counted(found.replicas as usize, "run");
    entries.add(
        format!("for curves within {error}"),
        format!("the mean of {runs} of different seeds; at one instant one run is off by {scatter}, at most"),
    );
    let course = format!("{} An average over time says little; the curve over time does.", found.course);
    vec![Block::heading("Nothing is steady here"), Block::Note(course), Block::Entries(entries.0)]
}

/// Time [s] after the start, in words; "never" if it is infinite.
fn after(time: f64) -> String {
    if time.is_finite() { format!("after about {}", quantity(time, "s", 2)) } else { "never".into() }
}
