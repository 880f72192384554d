//! The command-line program: parses the command line, runs the command, and turns its result into an exit code.

use crate::cli::{Cli, Command};
use crate::legible;
use crate::statistics::Answer;
use crate::study::CommandOrigin::Typed;
use crate::study::{self, Question, Ranks, StudyError};
use clap::Parser;
use clap::error::ErrorKind;
use std::ffi::OsString;

/// Text printed when the program is started without a command.
const FIRST_STEPS: &str = "\
Diptych runs one particle scene with soft and with hard spheres, and tells whether the choice matters.

  diptych cases               lists the built-in scenes, each with its question
  diptych plan quick          predicts steps, rates and costs of one, and recommends a model
  diptych compare quick       runs soft and hard spheres and compares them, in half a minute
  diptych init beads-in-air   writes a scene to a file, as a start for one of your own
  diptych check FILE          reads a scene and tells what it would run
  diptych lab                 shows both models side by side in a browser

`diptych help` lists all commands, `diptych COMMAND --help` the options of one.";

/// Runs the program with the arguments of a command line, the first of which is the name of the program. Returns the
/// exit code.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let ranks = match Ranks::join() {
        Ok(ranks) => ranks,
        Err(why) => {
            study::tell(&why);
            return exit_code(&Err(why));
        }
    };
    match Cli::try_parse_from(arguments) {
        Ok(cli) => ranks.close(command(cli.command, &ranks), exit_code),
        Err(why) if why.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = ranks.agree(Err::<(), _>(StudyError::Input(why.to_string())), |()| 0);
            if ranks.is_lead() {
                study::tell(FIRST_STEPS);
            }
            why.exit_code() as u8
        }
        // clap returns requests for help or for the version as errors too
        Err(why) => {
            let _ = ranks.agree(Err::<(), _>(StudyError::Input(why.to_string())), |()| 0);
            let said = if ranks.is_lead() { say(&why) } else { Ok(()) };
            if said.is_ok() { why.exit_code() as u8 } else { 1 }
        }
    }
}

/// Prints the message of the command-line parser: in colours if it contains no control characters. Control characters
/// would act on the terminal. A message with such characters is printed without colours, and the characters appear in
/// the form `\u{1b}`.
fn say(why: &clap::Error) -> std::io::Result<()> {
    let plain = why.render().to_string();
    let shown = legible::lines(&plain);
    if shown == plain {
        return why.print();
    }
    study::tell(shown);
    Ok(())
}

/// Runs a command and returns its exit code if it succeeds. With `--exit-code` the code of a comparison, a validation
/// or a study of factors (`sensitivity`, `needs`) depends on its answer (see [`verdict`]). Otherwise the code is 0.
fn command(command: Command, ranks: &Ranks) -> Result<u8, StudyError> {
    let done = match command {
        #[cfg(feature = "lab")]
        Command::Run(args) if args.live => crate::lab::run_live(&args, ranks),
        Command::Run(args) => study::run(&args, Typed, ranks, None),
        Command::Compare(args) => return Ok(verdict(args.exit_code, study::compare(&args, Typed, ranks)?)),
        Command::Sensitivity(args) => {
            return Ok(verdict(args.runs.exit_code, study::sensitivity(&args, Question::Sensitivity, Typed, ranks)?));
        }
        Command::Needs(args) => {
            return Ok(verdict(
                args.runs.exit_code,
                study::sensitivity(&args.as_sensitivity(), Question::Needs, Typed, ranks)?,
            ));
        }
        Command::Judge(args) => return Ok(verdict(args.exit_code, ranks.by_lead(|| study::judge_files(&args))?)),
        Command::Validate(args) => return Ok(verdict(args.exit_code, ranks.by_lead(|| study::validate(&args))?)),
        Command::Sweep(args) => study::sweep(&args, Typed, ranks),
        Command::Resume(args) => study::resume(&args, ranks),
        Command::Plan(args) => ranks.by_lead(|| study::plan(&args)),
        Command::Check(args) => ranks.by_lead(|| study::check(&args)),
        Command::Fluid(args) => ranks.by_lead(|| study::fluid(&args)),
        Command::Impact(args) => ranks.by_lead(|| study::impact(&args)),
        Command::Chart(args) => ranks.by_lead(|| study::chart(&args)),
        Command::Limits(args) => ranks.by_lead(|| study::limits(&args)),
        #[cfg(feature = "lab")]
        Command::Lab(args) => ranks.by_lead(|| crate::lab::lab(&args)),
        Command::Cases => ranks.by_lead(study::cases),
        Command::Init(args) => ranks.by_lead(|| study::init(&args)),
        Command::Keys(args) => ranks.by_lead(|| study::keys(&args)),
        Command::Completions(args) => ranks.by_lead(|| study::completions(&args)),
        Command::Man(args) => ranks.by_lead(|| study::man(&args)),
    };
    done.map(|()| 0)
}

/// Exit code for the result of a command: 1 for a failed run, 2 for bad input, 130 after Ctrl-C, else the code that the
/// successful command has returned.
fn exit_code(result: &Result<u8, StudyError>) -> u8 {
    match result {
        Ok(code) => *code,
        Err(StudyError::Failed(_)) => 1,
        Err(StudyError::Input(_)) => 2,
        // shells use 128 plus the number of the signal, which is 2 for Ctrl-C
        Err(StudyError::Stopped(_)) => 130,
    }
}

/// Exit code for the answer of a comparison: 0 for equivalent, 3 for different, 4 for unresolved. The code is 0 if
/// `answer` is `None` (no comparison), or if `asked` is false because `--exit-code` was not given. Codes 1 and 2 stand
/// for failures and bad input.
fn verdict(asked: bool, answer: Option<Answer>) -> u8 {
    match answer.filter(|_| asked) {
        None | Some(Answer::Equivalent) => 0,
        Some(Answer::Different) => 3,
        Some(Answer::Unresolved) => 4,
    }
}
