//! `diptych completions` and `diptych man`: prints completions for a shell, and manual pages of the commands.

use crate::cli::{Cli, Completions, Man};
use crate::runs::{StudyError, answer};
use clap::CommandFactory;

/// Prints the script with which a shell completes the commands and options of diptych.
///
/// # Errors
/// Returns an error if standard output cannot be written.
pub fn completions(args: &Completions) -> Result<(), StudyError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "diptych", &mut script);
    answer(&String::from_utf8_lossy(&script))
}

/// Prints the manual page of diptych or of one of its commands.
///
/// # Errors
/// Returns an error if there is no such command, or if the page cannot be written.
pub fn man(args: &Man) -> Result<(), StudyError> {
    let mut whole = Cli::command();
    whole.build();
    let command = match &args.command {
        None => whole,
        Some(name) => whole
            .find_subcommand(name)
            .ok_or_else(|| StudyError::Input(format!("error: there is no command `{name}`\nhelp: see diptych --help")))?
            .clone(),
    };
    let mut page = Vec::new();
    let failed = |why| StudyError::Failed(format!("error: cannot make the page: {why}"));
    clap_mangen::Man::new(command)
        .source(concat!("diptych ", env!("CARGO_PKG_VERSION")))
        .render(&mut page)
        .map_err(failed)?;
    answer(&String::from_utf8_lossy(&page))
}
