//! `diptych check CASE`: what would run, and what to expect of it, without running it.

use super::session::{StudyError, read};
use super::terminal::answer;
use crate::case::{Case, Checked, Diagnostic, describe};
use crate::cli::Check;
use crate::experiment::{Experiment, TimeStep};
use crate::output::numbers::counted;
use crate::predict::contact::ContactTimes;
use crate::schedule::Schedule;
use std::fmt::Write;

/// Checks a case and prints what would run.
///
/// # Errors
/// What is wrong with the case.
pub fn check(args: &Check) -> Result<(), StudyError> {
    let case = read(&args.case, &args.input)?;
    answer(&check_text(&case)?)
}

/// The scene in words, and each variant with its contact times and time step. A case that one model cannot run is as
/// good as `run` finds it: that model is then said not to run, and why.
///
/// # Errors
/// What is wrong with the case: nothing can run it, or a variant that it names itself cannot.
pub fn check_text(case: &Case) -> Result<String, Diagnostic> {
    let (run, variants) = (case.experiment(None, None), case.variants(None));
    let (variants, refused) = match variants {
        Ok(variants) => (variants, None),
        // soft and hard, which the case does not ask for: one of them may be all it is made for
        Err(why) if run.is_ok() && !case.names_variants() => (Vec::new(), Some(why)),
        Err(why) => return Err(run.err().filter(|_| !case.names_variants()).unwrap_or(why)),
    };
    let mut text = String::new();
    let _ = writeln!(text, "{}: {}", case.path.display(), case.title);
    // a case that `run` cannot start but `compare` can has no model of its own: nothing to say about it
    let run = run.ok();
    if let Some((experiment, _)) = run.as_ref().or(variants.first()) {
        let _ = writeln!(text, "\n{}", describe(experiment).trim_end());
    }
    if let Some((experiment, _)) = &run {
        let _ = writeln!(text, "\n`run` would run the {} model.", crate::case::name_of(experiment.model()));
        text.push_str(&timing(experiment));
    }
    let _ = match &refused {
        Some(why) => writeln!(text, "\n`compare` cannot run soft and hard:\n{why}"),
        None => writeln!(text, "\n`compare` would run {}:", counted(variants.len(), "variant")),
    };
    for (experiment, _) in &variants {
        let _ = writeln!(text, "  \"{}\", {}", experiment.name, crate::case::name_of(experiment.model()));
        text.push_str(&timing(experiment));
    }
    let mut told: Vec<&Diagnostic> = Vec::new();
    for warning in run.iter().chain(&variants).flat_map(|(_, warnings): &Checked| warnings) {
        if !told.contains(&warning) {
            let _ = writeln!(text, "\n{warning}");
            told.push(warning);
        }
    }
    if told.is_empty() {
        text.push_str("\nNo warnings.\n");
    }
    Ok(text)
}

/// Contact times and time step of the soft model; window and length of both.
fn timing(experiment: &Experiment) -> String {
    let mut text = String::new();
    if let Some(law) = experiment.law() {
        let particles = experiment.count();
        let times = ContactTimes::of(experiment, &law, particles);
        let step = match experiment.soft.time_step {
            TimeStep::Fixed(step) => Some(step),
            TimeStep::PerContact(steps) => times.governing().map(|time| time / steps),
        };
        if let Some(step) = step {
            let _ = writeln!(
                text,
                "    {}, time step {step:.4e} s, {:.3e} steps in all",
                law.parameter(),
                (experiment.run.duration / step).ceil()
            );
            for (name, time) in [("pair", times.pair), ("wall", times.wall)] {
                if let Some(time) = time {
                    let _ = writeln!(text, "    {name} contact {time:.4e} s, N_c = {:.2}", time / step);
                }
            }
        }
    }
    let schedule = Schedule::new(experiment);
    if schedule.samples > 0 {
        // more than a u64 holds, if the case allows it
        let windows = experiment.run.duration / schedule.window;
        let windows = if windows < 1e6 { format!("{windows:.0}") } else { format!("{windows:.3e}") };
        let samples = counted(schedule.samples as usize, "sample");
        let _ = writeln!(text, "    {windows} windows of {:.4e} s, {samples}", schedule.window);
    }
    text
}
