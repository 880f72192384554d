//! Settings of a command that does runs. They are made from the arguments of the command in one place; the code that
//! does runs depends on nothing else of the command.

use super::error::StudyError;
use crate::case::Case;
use crate::checkpoint::StoredCommand;
use crate::cli::{CheckpointEvery, Effort, Input, Output};
use crate::output::{Folder, Provenance};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Origin of a command: typed by the user, or continued by the command `resume`.
pub enum CommandOrigin {
    /// The user typed the command, and it begins.
    Typed,
    /// The user typed the command again for a folder with results. Completed runs are not repeated.
    TypedAgain,
    /// The command `resume` continues a command that was stopped.
    Resumed {
        /// Folder with the results of the stopped command.
        folder: PathBuf,
        /// Stored data of the stopped command: its command line as the user typed it, and the identities of its runs.
        command: StoredCommand,
        /// True if the continued command prints nothing.
        quiet: bool,
    },
}

/// Settings of a command that does runs: folder of results, threads, and times of checkpoints.
pub struct CommandSettings {
    /// Origin of the command: typed or resumed.
    pub origin: CommandOrigin,
    /// Path of the folder to which results are written.
    pub folder: PathBuf,
    /// True if the results of an earlier command in the folder may be replaced.
    pub overwrite: bool,
    /// True if the command prints nothing while it runs.
    pub quiet: bool,
    /// Number of threads of each process; `None` if the user has not given it.
    pub threads: Option<u16>,
    /// True if the result of each run is stored instead of its final state. Stored results remain when the command has
    /// ended.
    pub keeps_results: bool,
    /// True if the runs are done one after the other, each with all threads.
    pub in_turn: bool,
    /// Wall time between two checkpoints, or never.
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

    /// Changes the origin of a command from `Typed` to `TypedAgain`: the command continues the runs of an earlier
    /// command with the same folder.
    pub fn goes_on(&mut self) {
        if let CommandOrigin::Typed = self.origin {
            self.origin = CommandOrigin::TypedAgain;
        }
    }

    /// Command line with which the command began. A resumed command has the command line of the command that was
    /// stopped.
    pub fn arguments(&self) -> Vec<OsString> {
        match &self.origin {
            CommandOrigin::Typed | CommandOrigin::TypedAgain => std::env::args_os().collect(),
            CommandOrigin::Resumed { command, .. } => command.arguments.clone(),
        }
    }

    /// Opens the folder to which results are written.
    ///
    /// # Errors
    /// Returns an error if the folder is in use or cannot be written to. A command that begins also gets an error if
    /// the folder contains results that it may not replace.
    pub fn open_folder(&self) -> Result<Folder, StudyError> {
        match &self.origin {
            CommandOrigin::Typed => make(self.folder.clone(), self.overwrite),
            CommandOrigin::TypedAgain | CommandOrigin::Resumed { .. } => {
                Folder::resume(&self.folder).map_err(|error| StudyError::Input(format!("error: {error}")))
            }
        }
    }

    /// Origin of the results for the report: title, path and text of the case, command line, and the description
    /// `scene` of the scene.
    pub fn provenance(&self, case: &Case, scene: String) -> Provenance {
        Provenance { command: quoted(self.arguments()), ..provenance(case, scene) }
    }
}

/// Reads the case of a command, with the changes that the user has typed.
pub fn read(path: &Path, input: &Input) -> Result<Case, StudyError> {
    Ok(Case::read(path, &input.sets())?)
}

/// Makes the folder for the results of a command. An error counts as wrong input, since nothing has been computed.
pub fn folder(output: &Output, case: &Path, command: &str) -> Result<Folder, StudyError> {
    make(place(output, case, command), output.overwrite)
}

/// Path of the folder for the results of a command: the path that the user has given, else `out/<case>-<command>`.
fn place(output: &Output, case: &Path, command: &str) -> PathBuf {
    output.out.clone().unwrap_or_else(|| {
        let stem = case.file_stem().map_or("case".into(), |stem| stem.to_string_lossy());
        PathBuf::from(format!("out/{stem}-{command}"))
    })
}

/// Creates a folder for results. An error counts as wrong input. If `overwrite` is false, the folder must not contain
/// results.
fn make(path: PathBuf, overwrite: bool) -> Result<Folder, StudyError> {
    Folder::create(path, overwrite).map_err(|error| StudyError::Input(format!("error: {error}")))
}

/// Origin of the results for the report: title, path and text of the case, command line, and the description `scene` of
/// the scene.
pub fn provenance(case: &Case, scene: String) -> Provenance {
    Provenance {
        title: case.title.clone(),
        case_path: case.path.display().to_string(),
        case_text: case.text.to_string(),
        command: command_line(),
        scene,
    }
}

/// Command line of this process as the user typed it, with quotes where a shell needs them.
pub fn command_line() -> String {
    quoted(std::env::args_os())
}

/// Command line as text, with quotes where a shell needs them.
pub fn quoted(arguments: impl IntoIterator<Item = OsString>) -> String {
    let quoted = arguments.into_iter().enumerate().map(|(k, argument)| {
        // the program has its name only, without its path
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
