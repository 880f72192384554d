//! `diptych run`: one case, one model.

use super::keeper::{Keeper, runs};
use super::occasion::Occasion;
use super::plan::{USUAL_TARGET, any_model, plan_of};
use super::session::{StudyError, failures, progress, read, simulate, start, trust, use_threads, warn};
use super::terminal::conclude;
use super::trust::notes;
use crate::case::describe;
use crate::cli::{ModelChoice, Run};
use crate::experiment::Experiment;
use crate::output::{StateFile, Study, write_part, write_study};

/// Runs a case with one model and writes its folder.
///
/// # Errors
/// Bad input before anything is computed; a failure of the engine after everything up to it has been written.
pub fn run(args: &Run) -> Result<(), StudyError> {
    run_on(args, &Occasion::First)
}

/// The same, begun or gone on with.
pub(super) fn run_on(args: &Run, occasion: &Occasion) -> Result<(), StudyError> {
    let case = read(&args.case, &args.input)?;
    let auto = args.model == Some(ModelChoice::Auto);
    let model = args.model.and_then(ModelChoice::model);
    let seed = args.effort.seed;
    let mut checked = if auto { any_model(&case, seed)? } else { case.experiment(model, seed)? };
    use_threads(&args.effort)?;
    let reason = if auto { Some(choose(&mut checked.0)?) } else { None };
    let start = start(&checked.0)?;
    let folder = occasion.folder(&args.output, &args.case, "run")?;
    warn(std::slice::from_ref(&checked), args.output.quiet);
    let progress = progress(std::slice::from_ref(&checked), args.output.quiet);
    let (experiment, _) = checked;
    let runs = runs(std::iter::once((&experiment, start.fingerprint())))?;
    let mut keeper = Keeper::new(args.keep.checkpoint_every, occasion, &folder, &case, runs)?;
    keeper.expect(args.verify);
    let mut state_file = args.save_state.then(|| StateFile::new(&folder));
    let (outcome, state) = simulate(&experiment, start, progress.watch(0), state_file.as_mut(), &mut keeper)?;
    drop(progress);
    state_file.map_or(Ok(()), StateFile::written)?;
    keeper.expect(false);
    let sheets = [trust(&outcome, &state, args.verify, args.output.quiet, &mut keeper)?];
    let outcomes = [outcome];
    let verdicts = [super::trust::verdict(&outcomes[0])];
    let study = Study {
        provenance: &occasion.provenance(&case, describe(&experiment)),
        outcomes: &outcomes,
        parameters: &[case.parameters(&experiment)],
        verdicts: &verdicts,
        differences: &[],
        notes: &reason.into_iter().chain(notes(&outcomes)).collect::<Vec<_>>(),
        trust: &sheets,
    };
    if keeper.is_stopped() {
        keeper.helped(write_part(&folder, &study))?;
        return Err(keeper.words(&experiment.name));
    }
    let report = keeper.helped(write_study(&folder, &study))?;
    keeper.done()?;
    if !args.output.quiet {
        conclude(&verdicts, "Report", &report);
    }
    failures(&outcomes)
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
