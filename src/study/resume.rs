//! `diptych resume`: continues a run, a comparison, a sweep or a study of sensitivity or of needs that was stopped or
//! killed.

use super::compare::compare;
use super::run::{MakeObserver, run};
use super::sensitivity::{Question, sensitivity};
use super::sweep::sweep;
use crate::checkpoint::{Store, Unreadable};
use crate::cli::{Cli, Command, Effort, Output, Resume, Run};
use crate::output::{CHECKPOINT, COMMAND, SUMMARY};
use crate::runs::{CommandOrigin, Ranks, StudyError, unusable};
use crate::simulation::Simulation;
use clap::Parser;
use std::io::ErrorKind;
use std::path::Path;

/// Continues the command whose results are in the folder that `args` names.
///
/// # Errors
/// Returns an error if the folder has nothing that could be resumed, if another version of the program wrote it, or if
/// its case has changed. Other errors are those of the resumed command.
pub fn resume(args: &Resume, ranks: &Ranks) -> Result<(), StudyError> {
    let shown = args.folder.display();
    let input = |message: String| StudyError::Input(format!("error: {message}"));
    let folder = std::path::absolute(&args.folder).map_err(|why| input(format!("no folder {shown}: {why}")))?;
    let command = Store::of(&folder).command().map_err(|why| refusal(&folder, why))?;
    let cli = Cli::try_parse_from(&command.arguments)
        .map_err(|why| input(format!("{shown} cannot be gone on with: {why}")))?;
    // paths in the command line are relative to the folder in which the command was typed
    std::env::set_current_dir(&command.folder).map_err(|why| {
        input(format!(
            "{} was started in {}, which cannot be entered: {why}",
            shown,
            Path::new(&command.folder).display()
        ))
    })?;
    let origin = CommandOrigin::Resumed { folder, command, quiet: args.quiet };
    // only the commands that are continued below store their state
    if let Command::Run(mut typed) = cli.command {
        adopt(args, &mut typed.output, &mut typed.effort);
        // the observer (function called during the run) that showed the run on a page has stored no data, so an
        // observer that does nothing takes its place
        let idle: MakeObserver = &mut |_| Ok(Box::new(|_: &Simulation| ()));
        run(&typed, origin, ranks, is_watched(&typed).then_some(idle))
    } else if let Command::Compare(mut typed) = cli.command {
        adopt(args, &mut typed.output, &mut typed.effort);
        compare(&typed, origin, ranks).map(|_| ())
    } else if let Command::Sensitivity(mut typed) = cli.command {
        adopt(args, &mut typed.runs.output, &mut typed.runs.effort);
        sensitivity(&typed, Question::Sensitivity, origin, ranks).map(|_| ())
    } else if let Command::Needs(mut typed) = cli.command {
        adopt(args, &mut typed.runs.output, &mut typed.runs.effort);
        sensitivity(&typed.as_sensitivity(), Question::Needs, origin, ranks).map(|_| ())
    } else if let Command::Sweep(mut typed) = cli.command {
        adopt(args, &mut typed.output, &mut typed.effort);
        sweep(&typed, origin, ranks)
    } else {
        Err(input(format!("{shown} holds no run, comparison, sweep or study of sensitivity or of needs")))
    }
}

/// True if the command showed its run on a page in the browser.
#[cfg(feature = "lab")]
fn is_watched(run: &Run) -> bool {
    run.live
}

/// False, because a program without the feature `lab` shows no run in the browser.
#[cfg(not(feature = "lab"))]
fn is_watched(_: &Run) -> bool {
    false
}

/// Replaces options of the resumed command by the options typed for `resume`: the number of threads, and the choice to
/// print nothing.
fn adopt(args: &Resume, output: &mut Output, effort: &mut Effort) {
    output.quiet |= args.quiet;
    effort.threads = args.threads.or(effort.threads);
}

/// Error with the reason why the command whose results are in `folder` cannot be resumed.
fn refusal(folder: &Path, why: Unreadable) -> StudyError {
    let path = folder.join(CHECKPOINT).join(COMMAND[0]);
    match why {
        Unreadable::Io(why) if why.kind() == ErrorKind::NotFound => {
            let told = if folder.join(SUMMARY).exists() {
                format!("the results in {} are complete: there is nothing to go on with", folder.display())
            } else {
                format!("{} holds no run to go on with: there is no {}", folder.display(), path.display())
            };
            StudyError::Input(format!("error: {told}"))
        }
        why => unusable(&path, &why),
    }
}
