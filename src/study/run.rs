//! `diptych run`: one case, one model.

use super::checkpointer::Checkpointer;
use super::invocation::Invocation;
use super::kept_runs::{ResumableRun, help_with, mark, mark_of, starts};
use super::plan::{USUAL_TARGET, any_model, plan_of};
use super::ranks::Ranks;
use super::replicas::{ReplicaContext, others, pool, progress, refuse_idle, run_others, shared};
use super::run_list::ThreadBudget;
use super::session::{Into, StudyError, failures, file_names, read, share_threads, simulate, trust, warn};
use super::terminal::conclude;
use super::trust::notes;
use crate::case::{Case, Checked, describe};
use crate::checkpoint;
use crate::cli::{ModelChoice, Run};
use crate::experiment::{Experiment, Trajectories};
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
pub fn run(args: &Run, ranks: &Ranks) -> Result<(), StudyError> {
    run_on(args, &Invocation::First, ranks)
}

/// Begins or resumes a run.
pub(super) fn run_on(args: &Run, occasion: &Invocation, ranks: &Ranks) -> Result<(), StudyError> {
    let prepared = ranks.agree(prepare(args, ranks), |prepared| mark(prepared.runs()))?;
    let share = ThreadBudget { threads: ranks.threads(args.effort.threads), in_turn: false };
    if !ranks.is_lead() {
        let place = occasion.place(&args.output, &args.case, "run");
        let keeper = Checkpointer::of_helper(args.keep.checkpoint_every, occasion, &place)?;
        let PreparedRun { first, others, trajectories, .. } = prepared;
        let lists = (vec![first], others.iter().flatten().collect());
        return help_with(lists, trajectories.map(|asked| (place, asked)), &keeper, share, ranks);
    }
    let PreparedRun { case, checked, reason, first: ResumableRun { start, run, .. }, others, trajectories } = prepared;
    let folder = occasion.folder(&args.output, &args.case, "run")?;
    ranks.announce(share.threads, args.output.quiet);
    warn(std::slice::from_ref(&checked), args.output.quiet);
    let (experiment, _) = checked;
    let progress = progress(std::iter::once((&experiment, others[0].as_slice())), args.output.quiet);
    let runs = vec![run];
    let mut keeper = Checkpointer::new(args.keep.checkpoint_every, occasion, &folder, &case, runs)?;
    keeper.expects(args.verify || !others[0].is_empty());
    let mut state_file = args.save_state.then(|| StateFile::new(&folder, &case.text));
    let schedule = Schedule::new(&experiment);
    let mut moments = args.budgets.then(|| SecondMoments::new(experiment.statistics.slices, &schedule));
    let file = state_file.as_mut().map(|file| file as &mut dyn Observer);
    let mut frames = Frames::new(&experiment, 1);
    let asked = file.into_iter().chain(moments.as_mut().map(|moments| moments as &mut dyn Observer));
    let observers = asked.chain([&mut frames as &mut dyn Observer]).collect();
    let names = file_names(std::iter::once(experiment.name.as_str()));
    let ground = ReplicaContext { others: &others, progress: &progress, share, ranks, quiet: args.output.quiet };
    let shared = shared(0, &ground, args.verify);
    let into = Into { folder: &folder, name: &names[0], trajectories, others: observers, shared };
    let (outcome, state) = simulate(&experiment, start, progress.watch(0), into, &mut keeper)?;
    state_file.map_or(Ok(()), StateFile::written)?;
    keeper.expects(false);
    let sheets = [trust(&outcome, &state, args.verify, args.output.quiet, &mut keeper)?];
    let replicas = run_others(0, 0..others[0].len(), &ground, &mut keeper)?;
    drop(progress);
    let outcomes = [pool(outcome, replicas).0];
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

/// A run, prepared.
struct PreparedRun {
    case: Case,
    checked: Checked,
    /// Reason for the model, if the program chose it.
    reason: Option<String>,
    first: ResumableRun,
    /// The replicas of the one variant.
    others: [Vec<ResumableRun>; 1],
    trajectories: Option<Trajectories>,
}

impl PreparedRun {
    fn runs(&self) -> impl Iterator<Item = &checkpoint::RunIdentity> {
        std::iter::once(&self.first).chain(self.others.iter().flatten()).map(|one| &one.run)
    }
}

fn prepare(args: &Run, ranks: &Ranks) -> Result<PreparedRun, StudyError> {
    let asked = ranks.agree(ask(args, ranks), |asked| mark_of(std::iter::once(&asked.checked.0)))?;
    let RunRequest { case, checked, reason, trajectories } = asked;
    let start = starts(&[&checked.0], args.repeats.replicas, ranks)?.swap_remove(0);
    let first = ResumableRun::new(checked.0.clone(), start)?;
    let others = [others(&checked.0, args.repeats.replicas)?];
    Ok(PreparedRun { case, checked, reason, first, others, trajectories })
}

/// Run as asked for on the command line.
struct RunRequest {
    case: Case,
    checked: Checked,
    reason: Option<String>,
    trajectories: Option<Trajectories>,
}

fn ask(args: &Run, ranks: &Ranks) -> Result<RunRequest, StudyError> {
    let case = read(&args.case, &args.input.with_every(args.every.as_ref()))?;
    let auto = args.model == Some(ModelChoice::Auto);
    let model = args.model.and_then(ModelChoice::model);
    let seed = args.effort.seed;
    let mut checked = if auto { any_model(&case, seed)? } else { case.experiment(model, seed)? };
    share_threads(&args.effort, ranks)?;
    let reason = if auto { Some(choose(&mut checked.0)?) } else { None };
    refuse_budgets(args, &Schedule::new(&checked.0))?;
    refuse_idle(&checked.0, args.repeats.replicas, ranks)?;
    let trajectories = case.trajectories()?;
    Ok(RunRequest { case, checked, reason, trajectories })
}

/// Refuses budgets where windows differ in length: budgets are sums over windows of one length.
fn refuse_budgets(args: &Run, schedule: &Schedule) -> Result<(), StudyError> {
    if args.budgets && schedule.is_cut() {
        let why = "--budgets needs windows of one length, and --every ends some of them between";
        let help = format!("write every {:?} s or a multiple of it", schedule.longest());
        return Err(StudyError::Input(format!("error: {why}\nhelp: {help}")));
    }
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
