//! Settings of a command that does runs. They are made of its arguments in one place, and the arguments go no further.

use super::session::{self, StudyError, quoted};
use crate::case::Case;
use crate::checkpoint::StoredCommand;
use crate::cli::{CheckpointEvery, Effort, Output};
use crate::output::{Folder, Provenance};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Origin of a command.
pub enum Invocation {
    /// The user typed the command.
    First,
    /// The user typed the command again, and the runs that are over are kept.
    Again,
    /// `resume` goes on with the command.
    Resumed {
        /// Folder of the results of the command.
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
    pub invocation: Invocation,
    /// Path of the folder for the results.
    pub folder: PathBuf,
    /// True if the results of an earlier command in the folder may be replaced.
    pub overwrite: bool,
    /// True to print nothing while the command runs.
    pub quiet: bool,
    /// Number of threads of a process, if one is asked for.
    pub threads: Option<u16>,
    /// True to store the results of runs, which stay when the command is over, and not the ends of the runs.
    pub keeps_results: bool,
    /// True to do concurrent runs one after the other, each with all threads.
    pub in_turn: bool,
    /// Wall time between two checkpoints.
    pub checkpoint_every: CheckpointEvery,
}

impl CommandSettings {
    /// Settings of the command of that name on a case, with the usual time between checkpoints.
    pub fn new(invocation: Invocation, command: &str, case: &Path, output: &Output, effort: &Effort) -> Self {
        let folder = match &invocation {
            Invocation::First | Invocation::Again => session::place(output, case, command),
            Invocation::Resumed { folder, .. } => folder.clone(),
        };
        Self {
            invocation,
            folder,
            overwrite: output.overwrite,
            quiet: output.quiet,
            threads: effort.threads,
            keeps_results: false,
            in_turn: false,
            checkpoint_every: CheckpointEvery::usual(),
        }
    }

    /// Notes that a command that the user typed goes on with an earlier start.
    pub fn goes_on(&mut self) {
        if let Invocation::First = self.invocation {
            self.invocation = Invocation::Again;
        }
    }

    /// Command line with which the command began.
    pub fn arguments(&self) -> Vec<OsString> {
        match &self.invocation {
            Invocation::First | Invocation::Again => std::env::args_os().collect(),
            Invocation::Resumed { command, .. } => command.arguments.clone(),
        }
    }

    /// Opens the folder for the results.
    ///
    /// # Errors
    /// The folder is in use, cannot be written to, or, for a command that begins, holds results.
    pub fn open_folder(&self) -> Result<Folder, StudyError> {
        match &self.invocation {
            Invocation::First => session::make(self.folder.clone(), self.overwrite),
            Invocation::Again | Invocation::Resumed { .. } => {
                Folder::resume(&self.folder).map_err(|error| StudyError::Input(format!("error: {error}")))
            }
        }
    }

    /// Provenance of the results; `scene`: description of the scene.
    pub fn provenance(&self, case: &Case, scene: String) -> Provenance {
        Provenance { command: quoted(self.arguments()), ..session::provenance(case, scene) }
    }
}
