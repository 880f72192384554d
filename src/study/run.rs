//! `diptych run`: one case, one model.

use super::session::{StudyError, failures, folder, provenance, read, simulate, start, trust, use_threads, warn};
use super::trust::notes;
use crate::case::describe;
use crate::cli::Run;
use crate::output::{Study, write_study};

/// Runs a case with one model and writes its folder.
///
/// # Errors
/// Bad input before anything is computed; a failure of the engine after everything up to it has been written.
pub fn run(args: &Run) -> Result<(), StudyError> {
    let case = read(&args.case, &args.input)?;
    let checked = case.experiment(args.model, args.effort.seed)?;
    use_threads(&args.effort)?;
    let start = start(&checked.0)?;
    let folder = folder(&args.output, &args.case, "run")?;
    warn(std::slice::from_ref(&checked), args.output.quiet);
    let (experiment, _) = checked;
    let (outcome, state) = simulate(&experiment, start, args.output.quiet);
    let sheets = [trust(&outcome, &state, args.verify, args.output.quiet)];
    let outcomes = [outcome];
    let verdicts = [super::trust::verdict(&outcomes[0])];
    let study = Study {
        provenance: &provenance(&case, describe(&experiment)),
        outcomes: &outcomes,
        parameters: &[case.parameters(&experiment)],
        verdicts: &verdicts,
        differences: &[],
        notes: &notes(&outcomes),
        trust: &sheets,
    };
    let report = write_study(&folder, &study, args.save_state.then_some(&state))?;
    if !args.output.quiet {
        println!("{}", verdicts[0]);
        println!("Report: {}", report.display());
    }
    failures(&outcomes)
}
