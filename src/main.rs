//! Parses the command line, calls the study, maps errors to exit codes.

use clap::Parser;
use diptych::cli::{Cli, Command};
use diptych::statistics::Answer;
use diptych::study::{self, StudyError};
use std::process::ExitCode;

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Run(args) => study::run(&args),
        Command::Compare(args) => match study::compare(&args) {
            Ok(answer) if args.exit_code => return ExitCode::from(answer.map_or(0, exit_code)),
            other => other.map(|_| ()),
        },
        Command::Sensitivity(args) => match study::sensitivity(&args) {
            Ok(answer) if args.exit_code => return ExitCode::from(answer.map_or(0, exit_code)),
            other => other.map(|_| ()),
        },
        Command::Resume(args) => study::resume(&args),
        Command::Plan(args) => study::plan(&args),
        Command::Check(args) => study::check(&args),
        Command::Fluid(args) => study::fluid(&args),
        Command::Impact(args) => study::impact(&args),
        Command::Chart(args) => study::chart(&args),
        Command::Limits(args) => study::limits(&args),
        Command::Sweep(args) => study::sweep(&args),
        #[cfg(feature = "lab")]
        Command::Lab(args) => diptych::lab::lab(&args),
        Command::Cases => study::cases(),
        Command::Init(args) => study::init(&args),
        Command::Keys(args) => study::keys(&args),
        Command::Completions(args) => study::completions(&args),
        Command::Man(args) => study::man(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            study::tell(&error);
            match error {
                StudyError::Input(_) => ExitCode::from(2),
                StudyError::Failed(_) => ExitCode::from(1),
                // as shells report a program that Ctrl-C has ended: 128 and the number of the signal
                StudyError::Stopped(_) => ExitCode::from(130),
            }
        }
    }
}

/// What `--exit-code` answers; 1 and 2 stand for failures and bad input.
fn exit_code(answer: Answer) -> u8 {
    match answer {
        Answer::Equivalent => 0,
        Answer::Different => 3,
        Answer::Unresolved => 4,
    }
}
