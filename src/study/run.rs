//! `diptych run`: runs one case with one model.

use super::plan::{USUAL_TARGET, any_model, plan_of};
use super::replicas::pool;
use super::trust::{notes, verdict};
use super::variants::{VariantFindings, VariantResults, Variants};
use crate::case::describe;
use crate::cli::{ModelChoice, Run};
use crate::experiment::Experiment;
use crate::observe::{Observer, SecondMoments};
use crate::output::{StateFile, budget_sentences};
use crate::runs::{CommandOrigin, CommandSettings, Ranks, StudyError, read, share_threads};
use crate::schedule::Schedule;

/// Function that makes an additional observer (measurement during a run) for the run of an experiment.
pub type MakeObserver<'a> = &'a mut dyn FnMut(&Experiment) -> Result<Box<dyn Observer>, StudyError>;

/// Begins or resumes the run of a case with one model, and writes the results to one folder. `make` makes an additional
/// observer (measurement during the run), which must not store data. With several processes, only the first process
/// calls `make`.
///
/// # Errors
/// Returns an error for bad input, before anything is computed, or for a failure of the engine, after all results up to
/// this failure have been written. Other errors are those of `make`.
pub fn run(args: &Run, origin: CommandOrigin, ranks: &Ranks, make: Option<MakeObserver>) -> Result<(), StudyError> {
    let settings = CommandSettings {
        checkpoint_every: args.keep.checkpoint_every,
        ..CommandSettings::new(origin, "run", &args.case, &args.output, &args.effort)
    };
    let (variants, reason) = ranks.agree(variant(args, ranks), |(variants, _)| variants.mark())?;
    let experiment = &variants.checked[0].0;
    let Some(mut results) = VariantResults::begin(&variants, &settings, describe(experiment), ranks)? else {
        return Ok(());
    };
    let folder = results.folder();
    let mut state_file = args.save_state.then(|| StateFile::new(&folder, &variants.case.text));
    let mut moments =
        args.budgets.then(|| SecondMoments::new(experiment.statistics.slices, &Schedule::new(experiment)));
    let file = state_file.as_mut().map(|file| file as &mut dyn Observer);
    let mut watching = make.map(|make| make(experiment)).transpose()?;
    let asked = file.into_iter().chain(moments.as_mut().map(|moments| moments as &mut dyn Observer));
    let asked = asked.chain(watching.as_mut().map(|watching| &mut **watching as &mut dyn Observer));
    let end = results.run_first(asked.collect())?;
    state_file.map_or(Ok(()), StateFile::written)?;
    results.check(end)?;
    let is_whole = results.run_replicas(0, 1..usize::from(variants.replicas))?;
    let mut runs = results.runs.swap_remove(0);
    let outcomes = vec![pool(runs.remove(0), runs).0];
    let budgets = moments.filter(|_| is_whole).map(|moments| moments.budgets(outcomes[0].steadiness.from));
    let mut sentences = vec![verdict(&outcomes[0])];
    match &budgets {
        Some(Some(budgets)) => sentences.extend(budget_sentences(budgets)),
        Some(None) => sentences.push("No budgets: a slice saw no particle, or nothing was averaged.".into()),
        None => {}
    }
    let findings = VariantFindings {
        verdicts: sentences[..1].to_vec(),
        notes: reason.into_iter().chain(notes(&outcomes)).collect(),
        outcomes,
        budgets: budgets.flatten(),
        ..VariantFindings::default()
    };
    let report = results.write(&findings, is_whole)?;
    if !is_whole {
        return Err(results.stopped(0));
    }
    results.finish(&findings, &sentences, &report)
}

/// Experiment of the case that the command runs, as a list with one variant. The text is the reason for its model;
/// `None` unless the program chooses the model (`--model auto`).
fn variant(args: &Run, ranks: &Ranks) -> Result<(Variants, Option<String>), StudyError> {
    let case = read(&args.case, &args.input.with_every(args.every.as_ref()))?;
    let auto = args.model == Some(ModelChoice::Auto);
    let model = args.model.and_then(ModelChoice::model);
    let seed = args.effort.seed;
    let mut checked = if auto { any_model(&case, seed)? } else { case.experiment(model, seed)? };
    share_threads(&args.effort, ranks)?;
    let reason = if auto { Some(choose(&mut checked.0)?) } else { None };
    refuse_budgets(args, &checked.0)?;
    let trajectories = case.trajectories()?;
    let replicas = args.repeats.replicas;
    let variants = Variants { case, checked: vec![checked], replicas, trajectories, verify: args.verify };
    variants.refuse_idle(ranks)?;
    Ok((variants, reason))
}

/// Refuses the option `--budgets` (budgets of the second moments of velocity) where budgets would be wrong. A budget
/// follows each particle from window to window (time between two exchanges with the gas), and all windows must have
/// one length. It takes gravity and the drag of the mean gas flow as known, and attributes the rest of each change of
/// velocity to impacts.
fn refuse_budgets(args: &Run, experiment: &Experiment) -> Result<(), StudyError> {
    if !args.budgets {
        return Ok(());
    }
    let (scene, schedule) = (&experiment.scene, Schedule::new(experiment));
    let fluid = scene.fluid.as_ref();
    let without = |table: &str| format!("leave --budgets out, or {table}");
    let wrong = [
        (scene.has_openings(), "particles that stay, and here they come and go", without("[[inlets]] and [[outlets]]")),
        (scene.domain.shear.is_some(), "a box that is not sheared", without("[domain.shear]")),
        (scene.thermostat.is_some(), "particles that are not heated", without("[thermostat]")),
        (
            fluid.is_some_and(|fluid| fluid.turbulence.is_some()),
            "particles that see the mean gas flow alone",
            without("[fluid.turbulence]"),
        ),
        (fluid.is_some_and(|fluid| fluid.lift.is_some()), "particles without lift", without("[fluid.lift]")),
        (
            schedule.is_cut(),
            "windows of one length, and --every ends some of them between",
            format!("write every {:?} s or a multiple of it", schedule.longest()),
        ),
        (
            schedule.longest() != schedule.window,
            "windows of one length, and those of this run grow while drag slows the particles down",
            format!("--set run.window=\"{:?} s\"", schedule.window),
        ),
    ];
    match wrong.into_iter().find(|(is_wrong, ..)| *is_wrong) {
        Some((_, why, help)) => Err(StudyError::Input(format!("error: --budgets needs {why}\nhelp: {help}"))),
        None => Ok(()),
    }
}

/// Changes the experiment to the engine that its plan recommends. Returns the reason for this engine as a line for the
/// user, or an error if no engine is adequate.
fn choose(experiment: &mut Experiment) -> Result<String, StudyError> {
    let planned = plan_of(experiment, USUAL_TARGET, false)?;
    let recommendation = &planned.recommendation;
    let headline = recommendation.headline();
    let Some(engine) = recommendation.engine else {
        return Err(StudyError::Input(format!(
            "error: {headline}\nhelp: `plan` says more; --model hard or soft runs it nevertheless"
        )));
    };
    let reason = recommendation.reasons.first().map_or("", String::as_str);
    experiment.clone_from(&planned.experiment);
    experiment.name = crate::case::name_of(experiment.model()).to_owned();
    Ok(format!("--model auto took {engine}. {headline} {reason}"))
}
