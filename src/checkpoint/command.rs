//! The command line and the identity of its runs: enough to start a command again, and to notice that its case has
//! changed.

use crate::experiment::Experiment;
use serde::{Deserialize, Serialize};
use std::ffi::OsString;

/// A command that writes checkpoints.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StoredCommand {
    /// The command line, the program first.
    pub arguments: Vec<OsString>,
    /// Folder in which the command was typed, for relative paths.
    pub folder: OsString,
    /// Checksum of the text of the case.
    pub case: u32,
    /// Runs of the command, in order.
    pub runs: Vec<RunIdentity>,
}

/// One run of a command, with checksums of its parts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunIdentity {
    /// Name of the variant, or the hash by which the run is known.
    pub name: String,
    /// Names of the parts of the experiment, with a checksum of each.
    parts: Vec<(String, u32)>,
}

impl RunIdentity {
    /// Identity of an experiment that starts from a state with this checksum.
    ///
    /// # Errors
    /// If the experiment cannot be written as JSON.
    pub fn new(experiment: &Experiment, start: u64) -> Result<Self, serde_json::Error> {
        let Experiment { name, against: _, scene, start: populations, soft, hard, hybrid, run, statistics } =
            experiment;
        let parts = [
            ("scene", serde_json::to_vec(scene)?),
            ("particles", serde_json::to_vec(&(populations, start))?),
            ("soft", serde_json::to_vec(soft)?),
            ("hard", serde_json::to_vec(hard)?),
            ("hybrid", serde_json::to_vec(hybrid)?),
            ("run", serde_json::to_vec(run)?),
            ("statistics", serde_json::to_vec(statistics)?),
        ];
        let parts = parts.into_iter().map(|(part, text)| (part.to_owned(), checksum(&text))).collect();
        Ok(Self { name: name.clone(), parts })
    }

    /// Identity of a run that is known by a hash of everything that it depends on.
    pub fn of_hash(hash: &str) -> Self {
        Self { name: hash.to_owned(), parts: Vec::new() }
    }

    /// Name of the first part that differs in another run.
    pub fn difference(&self, other: &Self) -> Option<&str> {
        let differs = |(own, other): &(&(String, u32), &(String, u32))| own != other;
        self.parts.iter().zip(&other.parts).find(differs).map(|(own, _)| own.0.as_str())
    }

    /// Name in the names of files: the hash of the run, or a checksum of its parts.
    pub fn file_name(&self) -> String {
        if self.parts.is_empty() { self.name.clone() } else { format!("{:08x}", self.checksum()) }
    }

    /// Checksum of all parts.
    pub fn checksum(&self) -> u32 {
        let mut all = crc32fast::Hasher::new();
        all.update(self.name.as_bytes());
        self.parts.iter().for_each(|(_, part)| all.update(&part.to_le_bytes()));
        all.finalize()
    }
}

/// Checksum of bytes (CRC-32).
pub fn checksum(bytes: &[u8]) -> u32 {
    crc32fast::hash(bytes)
}
