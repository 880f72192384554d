//! `diptych check CASE`: lists the runs that a case defines, with predictions, and runs nothing. A window is the time
//! between two exchanges with the gas. A variant is one of the experiments of a case.

use crate::case::{Case, Checked, Diagnostic, describe, name_of};
use crate::cli::Check;
use crate::contact_law::ContactLaw;
use crate::experiment::{Experiment, HardStepping, Model, TimeStep};
use crate::memory;
use crate::output::numbers::counted;
use crate::placement::initial_state_within;
use crate::predict::Obstacles;
use crate::predict::contact::{ContactTimes, at_fastest_impacts};
use crate::runs::{StudyError, answer, answer_json};
use crate::schedule::Schedule;
use serde::Serialize;
use std::collections::HashSet;
use std::fmt::Write;

/// Largest number of particles that `check` tries to place, in order to find scenes that are too crowded. More
/// particles would take seconds; the command `plan` places them.
const MOST: usize = 1_000_000;

/// Largest effort for placing the particles, about 5 s of wall time. The effort is the number of tried positions. Each
/// round over all particles adds the number of particles to it.
const EFFORT: u64 = 5_000_000;

/// Number of rounds over all particles that are always allowed while particles are placed, however many particles
/// there are. Ten rounds are enough in scenes where random insertion is quick.
const ROUNDS: u64 = 20;

/// Largest number of kinds of contact in the printed list. A kind is, for example, the contact of two species. The list
/// contains the kinds with the shortest contacts, on which the time step depends.
const LISTED: usize = 20;

/// Checks a case and prints the runs that it defines.
///
/// # Errors
/// Returns the mistake in the case as an error. With JSON output, the mistake is also printed.
pub fn check(args: &Check) -> Result<(), StudyError> {
    let found = Case::read(&args.case, &args.input.set).and_then(|case| CheckReport::of(&case));
    if !args.json {
        return answer(&found?.text());
    }
    let told = match &found {
        Ok(found) => serde_json::to_string_pretty(found),
        Err(error) => {
            let case = args.case.display().to_string();
            serde_json::to_string_pretty(&serde_json::json!({ "case": case, "error": error }))
        }
    };
    answer_json(&(told.map_err(|why| StudyError::Failed(format!("error: {why}")))? + "\n"))?;
    found?;
    Ok(())
}

/// Text that `check` prints for a case.
///
/// # Errors
/// Returns the mistake in the case: no model can run the case, or one of the variants (experiments) that the case
/// names cannot run.
pub fn check_text(case: &Case) -> Result<String, Diagnostic> {
    Ok(CheckReport::of(case)?.text())
}

#[derive(Serialize)]
struct CheckReport {
    case: String,
    title: String,
    /// Sentences that describe the scene and the run, one per entry.
    scene: Vec<String>,
    /// Variant that the command `run` would run; `None` if the case itself gives no model.
    run: Option<CheckedVariant>,
    /// Variants that the command `compare` would run.
    variants: Vec<CheckedVariant>,
    /// Reason why `compare` cannot run the case with soft and hard spheres; `None` if it can.
    compare_refused: Option<String>,
    /// Keys to which the command `sweep` gives several values, with these values.
    sweep: Vec<Varied>,
    /// Warnings about the case for the reader, without duplicates.
    warnings: Vec<Diagnostic>,
}

/// Key to which the command `sweep` gives several values.
#[derive(Serialize)]
struct Varied {
    key: String,
    /// Values of the key, as typed in the case.
    values: Vec<String>,
}

/// One variant (experiment) of the case, with its time step, contact times and windows (times between two exchanges
/// with the gas).
#[derive(Serialize)]
struct CheckedVariant {
    name: String,
    model: Model,
    /// Name, value and unit of the elastic parameter of the contact law; `None` for models without lasting contacts,
    /// such as hard spheres.
    contact_law: Option<String>,
    /// [s] time step of soft contacts. `None` if there is no contact law. `None` also if the case gives the number of
    /// steps per contact, but nothing can touch.
    time_step: Option<f64>,
    /// [-] number of time steps of soft spheres in the whole run; `None` if there is no time step.
    steps: Option<f64>,
    /// [s] duration of the shortest contact of two particles; `None` if there is no such contact.
    pair_contact: Option<f64>,
    /// [s] duration of the shortest contact of a particle with a wall; `None` if there is no such contact.
    wall_contact: Option<f64>,
    /// Kinds of contact, such as contacts between two species, with their names and durations [s]. At most 20 are
    /// listed, the shortest ones. Empty if there is at most one kind between particles and at most one at walls.
    contacts: Vec<(String, f64)>,
    /// Number of kinds of contact that are not in `contacts`, because their contacts last longer.
    contacts_left_out: usize,
    /// [s] length of a window, the time between two exchanges of momentum with the gas. If windows grow during the run,
    /// this is the shortest one.
    window: f64,
    /// [s] length of the longest window, the time between two exchanges of momentum with the gas.
    longest: f64,
    /// [-] number of windows (times between two exchanges of momentum with the gas) of the whole run. It is a float,
    /// because a case may have more windows than a 64-bit integer can count.
    windows: f64,
    samples: u64,
}

impl CheckReport {
    /// Examines a case: its scene, its variants (experiments), the time steps of the variants, and obstacles to their
    /// runs. If `run` accepts a case that `compare` cannot run, the report gives the reason.
    fn of(case: &Case) -> Result<Self, Diagnostic> {
        let sweep = varied(case)?;
        let (run, variants) = (case.experiment(None, None), case.variants(None));
        let (variants, refused) = match variants {
            Ok(variants) => (variants, None),
            // the case lists no variants, so it may be made for only one of the models
            Err(why) if run.is_ok() && !case.names_variants() => (Vec::new(), Some(why)),
            Err(why) => return Err(run.err().filter(|_| !case.names_variants()).unwrap_or(why)),
        };
        // `compare` may run a case that `run` cannot: a case without a model of its own; there is then no variant for
        // `run`
        let run = run.ok();
        let first = run.as_ref().or(variants.first()).map(|(experiment, _)| describe(experiment));
        let mut warnings: Vec<Diagnostic> = Vec::new();
        let mut looked_at = HashSet::new();
        for (experiment, told) in run.iter().chain(&variants) {
            // a variant whose description equals that of an examined variant is not examined again
            let stops = if looked_at.insert(describe(experiment)) { stops(experiment)? } else { Vec::new() };
            for warning in told.iter().cloned().chain(stops) {
                if !warnings.contains(&warning) {
                    warnings.push(warning);
                }
            }
        }
        Ok(Self {
            case: case.path.display().to_string(),
            title: case.title.clone(),
            scene: first.iter().flat_map(|words| words.lines()).map(str::to_owned).collect(),
            run: run.as_ref().map(CheckedVariant::of),
            variants: variants.iter().map(CheckedVariant::of).collect(),
            compare_refused: refused.map(|why| why.to_string()),
            sweep,
            warnings,
        })
    }

    fn text(&self) -> String {
        let mut text = format!("{}: {}\n", self.case, self.title);
        if !self.scene.is_empty() {
            let _ = writeln!(text, "\n{}", self.scene.join("\n"));
        }
        if let Some(run) = &self.run {
            let _ = writeln!(text, "\n`run` would run the {} model.\n{}", name_of(run.model), run.text().trim_end());
        }
        let _ = match &self.compare_refused {
            Some(why) => writeln!(text, "\n`compare` cannot run soft and hard:\n{why}"),
            None => writeln!(text, "\n`compare` would run {}:", counted(self.variants.len(), "variant")),
        };
        for variant in &self.variants {
            let _ = write!(text, "  \"{}\", {}\n{}", variant.name, name_of(variant.model), variant.text());
        }
        if !self.sweep.is_empty() {
            let points: usize = self.sweep.iter().map(|varied| varied.values.len()).product();
            let _ = writeln!(text, "\n`sweep` would run these at {}:", counted(points, "point"));
        }
        for Varied { key, values } in &self.sweep {
            let _ = writeln!(text, "  {key} = {}", values.join(", "));
        }
        self.warnings.iter().for_each(|warning| text += &format!("\n{warning}\n"));
        if self.warnings.is_empty() {
            text.push_str("\nNo warnings.\n");
        }
        text
    }
}

/// Keys to which the case gives several values for a sweep. Every value of a key is checked together with the first
/// values of the other keys. A value with which the case cannot run is an error.
fn varied(case: &Case) -> Result<Vec<Varied>, Diagnostic> {
    let axes = case.own_axes()?;
    for (k, axis) in axes.iter().enumerate() {
        for value in 0..axis.typed.len() {
            let mut at = vec![0; axes.len()];
            at[k] = value;
            case.point(&axes, &at, None)?;
        }
    }
    Ok(axes.into_iter().map(|axis| Varied { key: axis.key, values: axis.typed }).collect())
}

impl CheckedVariant {
    fn of((experiment, _): &Checked) -> Self {
        let law = experiment.law();
        let times =
            law.as_ref().map(|law| ContactTimes::of(experiment, law, experiment.most_that_touch(experiment.count())));
        let shortest = times.as_ref().and_then(ContactTimes::governing);
        let step = match experiment.soft.time_step {
            TimeStep::Fixed(step) => law.map(|_| step),
            TimeStep::PerContact(steps) => shortest.map(|time| time / steps),
        };
        let schedule = Schedule::new(experiment);
        let (contacts, contacts_left_out) = law.map_or((Vec::new(), 0), |law| contacts(experiment, &law));
        Self {
            name: experiment.name.clone(),
            model: experiment.model(),
            contact_law: law.map(|law| law.parameter().to_string()),
            time_step: step,
            steps: step.map(|step| (experiment.run.duration / step).ceil()),
            pair_contact: times.as_ref().and_then(|times| times.pair),
            wall_contact: times.as_ref().and_then(|times| times.wall),
            contacts,
            contacts_left_out,
            window: schedule.window,
            longest: schedule.longest(),
            windows: match schedule.longest() > schedule.window {
                true => schedule.windows() as f64,
                false => experiment.run.duration / schedule.window,
            },
            samples: schedule.samples,
        }
    }

    /// Text of one variant (experiment of a case) for the terminal: contact law, time step, contact times, and the
    /// number and lengths of its windows (times between two exchanges with the gas).
    fn text(&self) -> String {
        let mut text = String::new();
        if let (Some(law), Some(step), Some(steps)) = (&self.contact_law, self.time_step, self.steps) {
            let _ = writeln!(text, "    {law}, time step {step:.4e} s, {steps:.3e} steps in all");
            let shortest = [("pair contact", self.pair_contact), ("wall contact", self.wall_contact)];
            let shortest = shortest.into_iter().filter_map(|(name, time)| Some((name, time?)));
            let each = self.contacts.iter().map(|(name, time)| (name.as_str(), *time));
            let listed: Vec<(&str, f64)> = if self.contacts.is_empty() { shortest.collect() } else { each.collect() };
            if self.contacts_left_out > 0 {
                let _ = writeln!(text, "    of many kinds of contact the {LISTED} shortest:");
            }
            for (name, time) in listed {
                let _ = writeln!(text, "    {name} {time:.4e} s, N_c = {:.2}", time / step);
            }
        }
        if self.samples > 0 {
            let windows = self.windows;
            let windows = if windows < 1e6 { format!("{windows:.0}") } else { format!("{windows:.3e}") };
            let samples = counted(self.samples as usize, "sample");
            let grow = if self.longest > self.window { format!(" to {:.4e} s", self.longest) } else { String::new() };
            let _ = writeln!(text, "    {windows} windows of {:.4e} s{grow}, {samples}", self.window);
        }
        text
    }
}

/// Kinds of contact, such as contacts between two species, each with the duration [s] of a contact at the fastest
/// impacts. Empty if there is at most one kind between particles and at most one at walls. The number is that of kinds
/// that the list leaves out, because it has at most [`LISTED`] entries.
fn contacts(experiment: &Experiment, law: &ContactLaw) -> (Vec<(String, f64)>, usize) {
    let kinds = at_fastest_impacts(experiment);
    let several = |wall: bool| kinds.iter().filter(|kind| kind.wall == wall).count() > 1;
    if !several(false) && !several(true) {
        return (Vec::new(), 0);
    }
    let mut times: Vec<(String, f64)> =
        kinds.iter().map(|kind| (format!("{}:", kind.name), kind.contact_time(law))).collect();
    let left_out = times.len().saturating_sub(LISTED);
    if left_out > 0 {
        times.sort_by(|one, other| one.1.total_cmp(&other.1));
        times.truncate(LISTED);
    }
    (times, left_out)
}

/// Reasons that would prevent a run, found without running the case. If the memory is too small, the list contains
/// only this reason. With more than [`MOST`] particles nothing else is checked. If no random start is found with
/// limited effort, the list contains only a warning about the start. For event-driven hard spheres the list contains
/// the obstacles that the command `plan` finds. For all other models it is empty; limits of soft spheres are checked
/// when a case is read.
///
/// # Errors
/// Returns an error if the scene is so crowded that the command `run` refuses it.
fn stops(experiment: &Experiment) -> Result<Vec<Diagnostic>, Diagnostic> {
    let by_events = experiment.model() == Model::Hard && experiment.hard.stepping == HardStepping::Events;
    if let Some((why, help)) = memory::refusal(experiment) {
        return Ok(vec![Diagnostic::at(None, why).help(help).into_warning()]);
    }
    if experiment.count() > MOST {
        return Ok(Vec::new());
    }
    let start = match initial_state_within(experiment, EFFORT.max(ROUNDS * experiment.count() as u64)) {
        Ok(start) => start,
        Err(crowded) if !crowded.given_up => return Err(Diagnostic::at(None, crowded.to_string())),
        Err(_) => return Ok(vec![not_yet_placed()]),
    };
    if !by_events {
        return Ok(Vec::new());
    }
    let found = Obstacles::of(experiment, &start).against_hard(experiment).into_iter();
    let warning = |why: String| {
        let message = format!("the hard model is not expected to come to the end of this run: {why}");
        Diagnostic::at(None, message).help("`diptych plan` says what can run it").into_warning()
    };
    Ok(found.map(warning).collect())
}

/// Warning that `check` found no random start of the particles within its limited effort.
fn not_yet_placed() -> Diagnostic {
    let message = "no random start was found with the effort that `check` makes: a run tries longer, and refuses a scene that is too crowded";
    let help = "see whether the walls leave room for all particles; fewer of them start sooner";
    Diagnostic::at(None, message).into_warning().help(help)
}
