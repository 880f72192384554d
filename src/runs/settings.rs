//! Settings of a command that does runs. The settings are made from the arguments of the command in one place; the code
//! of runs depends on the settings only.

use super::error::StudyError;
use crate::case::Case;
use crate::checkpoint::StoredCommand;
use crate::cli::{CheckpointEvery, Effort, Input, Output};
use crate::output::{Folder, Provenance};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Origin of a command: typed by the user, or continued by `resume`.
pub enum CommandOrigin {
    /// The user typed the command.
    Typed,
    /// The user typed the command again for existing results. Completed runs are not repeated.
    TypedAgain,
    /// The command `resume` continues the earlier command.
    Resumed {
        /// Folder with the results of the command.
        folder: PathBuf,
        /// Command line as it was typed when the command began.
        command: StoredCommand,
        /// True if the command prints nothing while it runs.
        quiet: bool,
    },
}

/// Settings of a command that does runs.
pub struct CommandSettings {
    /// Origin of the command.
    pub origin: CommandOrigin,
    /// Path of the folder for the results.
    pub folder: PathBuf,
    /// True if the results of an earlier command in the folder may be replaced.
    pub overwrite: bool,
    /// True if nothing is to be printed while the command runs.
    pub quiet: bool,
    /// Number of threads of a process; `None` if the user gave none.
    pub threads: Option<u16>,
    /// True if the result of each run is stored in place of its final state. Stored results remain after the command is
    /// over.
    pub keeps_results: bool,
    /// True if the runs are done one after the other, each with all threads.
    pub in_turn: bool,
    /// Wall time between two checkpoints.
    pub checkpoint_every: CheckpointEvery,
}

impl CommandSettings {
    /// Settings of the command with the name `command` on a case, with the default time between checkpoints.
    pub fn new(origin: CommandOrigin, command: &str, case: &Path, output: &Output, effort: &Effort) -> Self {
        let folder = match &origin {
            CommandOrigin::Typed | CommandOrigin::TypedAgain => place(output, case, command),
            CommandOrigin::Resumed { folder, .. } => folder.clone(),
        };
        Self {
            origin,
            folder,
            overwrite: output.overwrite,
            quiet: output.quiet,
            threads: effort.threads,
            keeps_results: false,
            in_turn: false,
            checkpoint_every: CheckpointEvery::usual(),
        }
    }

    /// Marks a command that the user typed again for existing results as one that continues the earlier command.
    pub fn goes_on(&mut self) {
        if let CommandOrigin::Typed = self.origin {
            self.origin = CommandOrigin::TypedAgain;
        }
    }

    /// Command line with which the command began.
    pub fn arguments(&self) -> Vec<OsString> {
        match &self.origin {
            CommandOrigin::Typed | CommandOrigin::TypedAgain => std::env::args_os().collect(),
            CommandOrigin::Resumed { command, .. } => command.arguments.clone(),
        }
    }

    /// Opens the folder for the results.
    ///
    /// # Errors
    /// The folder is in use, cannot be written to, or contains results although the command begins.
    pub fn open_folder(&self) -> Result<Folder, StudyError> {
        match &self.origin {
            CommandOrigin::Typed => make(self.folder.clone(), self.overwrite),
            CommandOrigin::TypedAgain | CommandOrigin::Resumed { .. } => {
                Folder::resume(&self.folder).map_err(|error| StudyError::Input(format!("error: {error}")))
            }
        }
    }

    /// Provenance of the results: command, case and program. `scene` is a description of the scene.
    pub fn provenance(&self, case: &Case, scene: String) -> Provenance {
        Provenance { command: quoted(self.arguments()), ..provenance(case, scene) }
    }
}

/// Reads the case of a command.
pub fn read(path: &Path, input: &Input) -> Result<Case, StudyError> {
    Ok(Case::read(path, &input.sets())?)
}

/// Makes the folder of a command. A folder that cannot be written to is reported as wrong input, since nothing has been
/// computed yet.
pub fn folder(output: &Output, case: &Path, command: &str) -> Result<Folder, StudyError> {
    make(place(output, case, command), output.overwrite)
}

/// Path of the folder for the results of a command: the one that the user gave, or `out/<case>-<command>`.
fn place(output: &Output, case: &Path, command: &str) -> PathBuf {
    output.out.clone().unwrap_or_else(|| {
        let stem = case.file_stem().map_or("case".into(), |stem| stem.to_string_lossy());
        PathBuf::from(format!("out/{stem}-{command}"))
    })
}

/// Creates a folder for results; an error counts as bad input. Without `overwrite` it must not contain results.
fn make(path: PathBuf, overwrite: bool) -> Result<Folder, StudyError> {
    Folder::create(path, overwrite).map_err(|error| StudyError::Input(format!("error: {error}")))
}

/// Provenance of the results: command, case and program. `scene` is a description of the scene.
pub fn provenance(case: &Case, scene: String) -> Provenance {
    Provenance {
        title: case.title.clone(),
        case_path: case.path.display().to_string(),
        case_text: case.text.to_string(),
        command: command_line(),
        scene,
    }
}

/// Command line as the user typed it.
pub fn command_line() -> String {
    quoted(std::env::args_os())
}

/// A command line as text, quoted where a shell requires it.
pub fn quoted(arguments: impl IntoIterator<Item = OsString>) -> String {
    let quoted = arguments.into_iter().enumerate().map(|(k, argument)| {
        // the program is written by its name, without its path
        let argument = if k == 0 { "diptych".into() } else { argument.to_string_lossy().into_owned() };
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_=./,:+".contains(c);
        if !argument.is_empty() && argument.chars().all(plain) {
            argument
        } else {
            format!("'{}'", argument.replace('\'', "'\\''"))
        }
    });
    quoted.collect::<Vec<_>>().join(" ")
}
