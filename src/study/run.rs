//! `diptych run`: one case, one model.

use super::keeper::{Keeper, runs};
use super::occasion::Occasion;
use super::plan::{USUAL_TARGET, any_model, plan_of};
use super::replicas::{others, pool, progress, run_others};
use super::session::{Into, StudyError, failures, file_names, read, simulate, start, trust, use_threads, warn};
use super::terminal::conclude;
use super::trust::notes;
use crate::case::describe;
use crate::cli::{ModelChoice, Run};
use crate::experiment::Experiment;
use crate::observe::{Frames, MOMENTS, Observer, SecondMoments, Terms};
use crate::outcome::Outcome;
use crate::output::numbers::with_error;
use crate::output::{FIGURES, Folder, StateFile, Study, csv, figures, write_part, write_study};
use crate::schedule::Schedule;
use crate::statistics::Estimate;

/// Runs a case with one model and writes its folder.
///
/// # Errors
/// Bad input before anything is computed; a failure of the engine after everything up to it has been written.
pub fn run(args: &Run) -> Result<(), StudyError> {
    run_on(args, &Occasion::First)
}

/// The same, begun or gone on with.
pub(super) fn run_on(args: &Run, occasion: &Occasion) -> Result<(), StudyError> {
    let case = read(&args.case, &args.input.with_every(args.every.as_ref()))?;
    let auto = args.model == Some(ModelChoice::Auto);
    let model = args.model.and_then(ModelChoice::model);
    let seed = args.effort.seed;
    let mut checked = if auto { any_model(&case, seed)? } else { case.experiment(model, seed)? };
    use_threads(&args.effort)?;
    let reason = if auto { Some(choose(&mut checked.0)?) } else { None };
    refuse_budgets(args, &Schedule::new(&checked.0))?;
    let (start, trajectories) = (start(&checked.0)?, case.trajectories()?);
    let replicas = others(&checked.0, args.repeats.replicas)?;
    let folder = occasion.folder(&args.output, &args.case, "run")?;
    warn(std::slice::from_ref(&checked), args.output.quiet);
    let (experiment, _) = checked;
    let progress = progress(std::iter::once((&experiment, replicas.as_slice())), args.output.quiet);
    let runs = runs(std::iter::once((&experiment, start.fingerprint())))?;
    let mut keeper = Keeper::new(args.keep.checkpoint_every, occasion, &folder, &case, runs)?;
    keeper.expect(args.verify || !replicas.is_empty());
    let mut state_file = args.save_state.then(|| StateFile::new(&folder, &case.text));
    let schedule = Schedule::new(&experiment);
    let mut moments = args.budgets.then(|| SecondMoments::new(experiment.statistics.slices, &schedule));
    let file = state_file.as_mut().map(|file| file as &mut dyn Observer);
    let mut frames = Frames::new(&experiment, 1);
    let asked = file.into_iter().chain(moments.as_mut().map(|moments| moments as &mut dyn Observer));
    let observers = asked.chain([&mut frames as &mut dyn Observer]).collect();
    let names = file_names(std::iter::once(experiment.name.as_str()));
    let into = Into { folder: &folder, name: &names[0], trajectories, others: observers };
    let (outcome, state) = simulate(&experiment, start, progress.watch(0), into, &mut keeper)?;
    state_file.map_or(Ok(()), StateFile::written)?;
    keeper.expect(false);
    let sheets = [trust(&outcome, &state, args.verify, args.output.quiet, &mut keeper)?];
    let replicas = run_others(replicas, (&progress, 1), args.output.quiet, &mut keeper)?;
    drop(progress);
    let outcomes = [pool(outcome, &replicas)];
    let verdicts = [super::trust::verdict(&outcomes[0])];
    let study = Study {
        provenance: &occasion.provenance(&case, describe(&experiment)),
        outcomes: &outcomes,
        parameters: &[case.parameters(&experiment)],
        verdicts: &verdicts,
        comparisons: &[],
        overrides: &[],
        notes: &reason.into_iter().chain(notes(&outcomes)).collect::<Vec<_>>(),
        trust: &sheets,
        frames: &[frames],
    };
    if keeper.is_stopped() {
        keeper.helped(write_part(&folder, &study))?;
        return Err(keeper.words(&experiment.name));
    }
    let report = keeper.helped(write_study(&folder, &study))?;
    // the folder of pictures is made anew with the report
    let balance = moments.map_or(Ok(Vec::new()), |moments| budgets(&moments, &outcomes[0], &folder))?;
    keeper.done()?;
    if !args.output.quiet {
        let said: Vec<String> = verdicts.iter().cloned().chain(balance).collect();
        conclude(&said, "Report", &report);
    }
    failures(&outcomes)
}

/// Budgets are sums over windows of one length.
fn refuse_budgets(args: &Run, schedule: &Schedule) -> Result<(), StudyError> {
    if !args.budgets || schedule.longest() == schedule.window {
        return Ok(());
    }
    let why = "--budgets needs windows of one length, and those of this run grow while drag slows the particles down";
    Err(StudyError::Input(format!("error: {why}\nhelp: --set run.window=\"{:?} s\"", schedule.window)))
}

/// Writes the budgets of the second moments and says how well they close.
fn budgets(moments: &SecondMoments, outcome: &Outcome, folder: &Folder) -> Result<Vec<String>, StudyError> {
    let Some(budgets) = moments.budgets(outcome.steadiness.from) else {
        return Ok(vec!["No budgets: a slice saw no particle, or nothing was averaged.".into()]);
    };
    folder.write("budgets.csv", &csv::budgets(&budgets)?)?;
    let figure = figures::budgets(&budgets, outcome.experiment.scene.domain.size.y);
    folder.write(&format!("{FIGURES}/{}.svg", figure.name), figure.svg.as_bytes())?;
    let term = |term: &Estimate| with_error(*term);
    let sentence = |(&(name, ..), terms): (&(&str, usize, usize), &Terms<Estimate>)| {
        format!(
            "{name} per second, mean over all particles [m²/s³]: production {}, impacts {}, drag {}; rest {}.",
            term(&terms.production),
            term(&terms.impacts),
            term(&terms.drag),
            term(&terms.rest)
        )
    };
    let walls = format!(
        "Of these, friction at walls gives {} to uu + ww, and their restitution {} to vv. Averaged from {:.4} s on.",
        term(&budgets.wall_friction),
        term(&budgets.wall_restitution),
        budgets.from
    );
    Ok(MOMENTS.iter().zip(&budgets.whole).map(sentence).chain([walls]).collect())
}

/// Gives the experiment the engine that its plan recommends; returns the line that says so.
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
