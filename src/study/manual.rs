//! `diptych completions` and `diptych man`: prints completions for a shell, and manual pages.

use crate::cli::{Cli, Completions, Man};
use crate::runs::{StudyError, answer};
use clap::CommandFactory;

/// Prints the completions of a shell.
///
/// # Errors
/// Standard output cannot be written.
pub fn completions(args: &Completions) -> Result<(), StudyError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "diptych", &mut script);
    answer(&String::from_utf8_lossy(&script))
}

/// Prints a manual page.
///
/// # Errors
/// There is no such command, or the page cannot be written.
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
