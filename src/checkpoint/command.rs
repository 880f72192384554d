//! Stored form of a command: its command line and the identities of its runs. With these data a command can be started
//! again, and a change of its case is detected.

use crate::experiment::Experiment;
use serde::{Deserialize, Serialize};
use std::ffi::OsString;

/// Command with the identities of its runs, as it is stored in a checkpoint. From these data `diptych resume` starts
/// the command again.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StoredCommand {
    /// Words of the command line; the first is the program.
    pub arguments: Vec<OsString>,
    /// Folder in which the command was started, from which relative paths are resolved.
    pub folder: OsString,
    /// Checksum of the text of the case, by which a changed case is detected.
    pub case: u32,
    /// Identities of the runs of the command, in the order of its list of runs. Replicas (runs of one experiment with
    /// different seeds) have one name, and only the identity of the first replica is stored. The list is empty for a
    /// sweep.
    pub runs: Vec<RunIdentity>,
}

/// Identity of one run of a command, by which its stored state is recognized. It consists of a name, and of a checksum
/// of each part of its experiment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunIdentity {
    /// Name of the variant or, in an identity made by [`of_hash`](Self::of_hash), a hash of all data that determine the
    /// run.
    pub name: String,
    /// Name of each part of the experiment, such as `scene`, with the checksum of this part. The list is empty in an
    /// identity made by [`of_hash`](Self::of_hash).
    parts: Vec<(String, u32)>,
}

impl RunIdentity {
    /// Creates the identity of the run of an experiment; `start` is a checksum of the initial state of the particles.
    ///
    /// # Errors
    /// Returns an error if the experiment cannot be written as JSON.
    pub fn new(experiment: &Experiment, start: u64) -> Result<Self, serde_json::Error> {
        let Experiment {
            name,
            against: _,
            scene,
            start: populations,
            soft,
            hard,
            hybrid,
            dsmc,
            run,
            statistics,
            observe,
        } = experiment;
        let parts = [
            ("scene", serde_json::to_vec(scene)?),
            ("particles", serde_json::to_vec(&(populations, start))?),
            ("soft", serde_json::to_vec(soft)?),
            ("hard", serde_json::to_vec(hard)?),
            ("hybrid", serde_json::to_vec(hybrid)?),
            ("dsmc", serde_json::to_vec(dsmc)?),
            ("run", serde_json::to_vec(run)?),
            ("statistics", serde_json::to_vec(statistics)?),
            ("observe", serde_json::to_vec(observe)?),
        ];
        let parts = parts.into_iter().map(|(part, text)| (part.to_owned(), checksum(&text))).collect();
        Ok(Self { name: name.clone(), parts })
    }

    /// Creates an identity that consists only of a hash of all data that determine a run.
    pub fn of_hash(hash: &str) -> Self {
        Self { name: hash.to_owned(), parts: Vec::new() }
    }

    /// Name of the first part of the experiment, such as `scene`, in which this run differs from another; `None` if all
    /// parts are equal, or if one of the two identities has no parts.
    pub fn difference(&self, other: &Self) -> Option<&str> {
        let differs = |(own, other): &(&(String, u32), &(String, u32))| own != other;
        self.parts.iter().zip(&other.parts).find(differs).map(|(own, _)| own.0.as_str())
    }

    /// Text that identifies the run in the names of files. It is the hash if the identity was made by
    /// [`of_hash`](Self::of_hash), otherwise the checksum of the name and of all parts of the experiment.
    pub fn file_name(&self) -> String {
        if self.parts.is_empty() { self.name.clone() } else { format!("{:08x}", self.checksum()) }
    }

    /// Checksum of the name of the run and of all parts of its experiment.
    pub fn checksum(&self) -> u32 {
        let mut all = crc32fast::Hasher::new();
        all.update(self.name.as_bytes());
        self.parts.iter().for_each(|(_, part)| all.update(&part.to_le_bytes()));
        all.finalize()
    }
}

/// CRC-32 checksum of a sequence of bytes.
pub fn checksum(bytes: &[u8]) -> u32 {
    crc32fast::hash(bytes)
}
