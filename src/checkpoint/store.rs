//! Reads and writes the files of a checkpoint, from which a stopped command is continued.

use super::command::{RunIdentity, StoredCommand};
use super::envelope::{Unreadable, open, seal};
use crate::engine::Failure;
use crate::observe::Pause;
use crate::output::{ASIDE, CHECKPOINT, COMMAND, OutputError, put};
use crate::stored::StoreError;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Names of the files of the two generations, which are the two newest stored states of a run. If several runs are done
/// at the same time, `-` and a checksum of the run follow each name.
const GENERATIONS: [&str; 2] = ["a", "b"];

/// Prefix of the names of files that contain finished runs.
const DONE: &str = "done-";

/// Data of one run in a checkpoint: its state, and its outcome if the run is over.
#[derive(Serialize, Deserialize)]
pub struct StoredRun {
    /// State of the run, from which the run continues.
    pub pause: Pause,
    /// End of the run: `None` if the run is not over, `Some(None)` if it is complete, else the failure that stopped it.
    pub over: Option<Option<Failure>>,
}

/// Reads and writes the files of a checkpoint, which are in a subfolder of a folder of results.
pub struct Store {
    place: PathBuf,
    /// Names of the two files to which the states of a run are written in turn. So the two newest states are always
    /// kept.
    generations: [String; 2],
    /// Number of the next generation (stored state of the run). Generations with even numbers are written to the first
    /// file, those with odd numbers to the second.
    next: u64,
}

/// Result of the search for a stored state of the present run: the newest state, and the files that cannot be used.
pub struct Newest {
    /// Identity of the run and its newest usable state; `None` if no file can be used.
    pub found: Option<(RunIdentity, StoredRun)>,
    /// Checkpoint files that cannot be used, each with the reason.
    pub refused: Vec<(PathBuf, Unreadable)>,
}

impl Store {
    /// Creates the store for the checkpoint in the given folder of results.
    pub fn of(folder: &Path) -> Self {
        Self { place: folder.join(CHECKPOINT), generations: GENERATIONS.map(String::from), next: 0 }
    }

    /// Creates the store for one of several runs that are done at the same time. Its states have separate files in the
    /// same subfolder.
    pub fn for_run(&self, run: &RunIdentity) -> Self {
        let generations = GENERATIONS.map(|name| format!("{name}-{}", run.file_name()));
        Self { place: self.place.clone(), generations, next: 0 }
    }

    /// Stores a command at its start, and removes the checkpoint of an earlier command.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn begin(&self, command: &StoredCommand) -> Result<(), OutputError> {
        self.remove()?;
        self.replace_command(command)
    }

    /// Stores a command that continues the runs of an earlier command, in place of the earlier one.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn replace_command(&self, command: &StoredCommand) -> Result<(), OutputError> {
        COMMAND.iter().try_for_each(|name| self.write(name, command))
    }

    /// Reads the command to be continued. It is stored in two equal files; the first one that can be used is read.
    ///
    /// # Errors
    /// Returns the reason for the first file if no file can be used.
    pub fn command(&self) -> Result<StoredCommand, Unreadable> {
        let [first, copy] = COMMAND;
        match self.read(first) {
            // both files were written by the same program, so the second file cannot be used either
            Err(why @ Unreadable::OtherProgram { .. }) => Err(why),
            Err(why) => self.read(copy).map_err(|_| why),
            whole => whole,
        }
    }

    /// Stores the data `part` of the process with the number `number`, if several processes share a run. `over` is true
    /// if the run has ended, false if it will be continued. The remaining state is stored after this call, by
    /// [`keep`](Self::keep) or, if the run is over, by [`finish`](Self::finish).
    ///
    /// # Errors
    /// Returns an error if a file cannot be written; the state then cannot be stored.
    pub fn keep_part(&self, run: &RunIdentity, over: bool, number: usize, part: &[u8]) -> Result<(), OutputError> {
        let of = if over { done(run) } else { self.generations[(self.next % 2) as usize].clone() };
        let age = if over { 0 } else { self.next };
        self.write(&part_of(&of, number), &(age, run, part))
    }

    /// Reads the data of the process with the number `number` from the newest state of a run or, if `over` is true,
    /// from its final state. This call must follow a call of [`newest`](Self::newest) or [`finished`](Self::finished),
    /// which checks that all files of the state can be used.
    ///
    /// # Errors
    /// Returns an error if the file cannot be used.
    pub fn part(&self, run: &RunIdentity, over: bool, number: usize) -> Result<Vec<u8>, Unreadable> {
        if over {
            return self.read_part(&done(run), (0, run), number);
        }
        let age = self.next.saturating_sub(1);
        self.read_part(&self.generations[(age % 2) as usize], (age, run), number)
    }

    fn read_part(&self, of: &str, (age, run): (u64, &RunIdentity), number: usize) -> Result<Vec<u8>, Unreadable> {
        let (found, whose, part) = self.read::<(u64, RunIdentity, Vec<u8>)>(&part_of(of, number))?;
        // the data belong to another stored state if the program was stopped before all processes had written their
        // files
        if (found, &whose) == (age, run) { Ok(part) } else { Err(Unreadable::Damaged) }
    }

    /// Checks that the files with the data of the single processes, which belong to a stored state, can be read. `of`
    /// is the name of the file with the other data of this state. `whose` contains the generation number of the state,
    /// and its run. If a file cannot be read, its path and the reason are returned as the error.
    fn has_parts(&self, of: &str, whose: (u64, &RunIdentity), kept: &StoredRun) -> Result<(), (PathBuf, Unreadable)> {
        (0..kept.pause.snapshot.parts).try_for_each(|number| {
            let read = self.read_part(of, whose, number).map(drop);
            read.map_err(|why| (self.place.join(part_of(of, number)), why))
        })
    }

    /// Stores the next state of the present run in place of the older of the two stored states.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written; both stored states are then unchanged.
    pub fn keep(&mut self, run: &RunIdentity, kept: &StoredRun) -> Result<(), OutputError> {
        self.write(&self.generations[(self.next % 2) as usize], &(self.next, run, kept))?;
        self.next += 1;
        Ok(())
    }

    /// Reads the newest state of the present run. The next state that is stored will replace the other file.
    pub fn newest(&mut self) -> Newest {
        let (mut states, mut refused) = (Vec::new(), Vec::new());
        for name in &self.generations {
            match self.read::<(u64, RunIdentity, StoredRun)>(name) {
                Ok((age, run, kept)) => match self.has_parts(name, (age, &run), &kept) {
                    Ok(()) => states.push((age, run, kept)),
                    Err(part) => refused.push(part),
                },
                // until a second state is stored, only one of the two files exists
                Err(Unreadable::Io(why)) if why.kind() == ErrorKind::NotFound => {}
                Err(why) => refused.push((self.place.join(name), why)),
            }
        }
        let newest = states.into_iter().max_by_key(|(generation, ..)| *generation);
        self.next = newest.as_ref().map_or(0, |(generation, ..)| generation + 1);
        Newest { found: newest.map(|(_, run, kept)| (run, kept)), refused }
    }

    /// Stores the final state of a run with the data of its observers (measurements during the run), or the result
    /// that was computed from them. If several runs are done at the same time, the separate files with states of this
    /// run are then removed.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn finish<T: Serialize>(&self, run: &RunIdentity, end: &T) -> Result<(), OutputError> {
        self.write(&done(run), &(run, end))?;
        // if several runs are done at the same time, each has separate files for its states: after the end of the run
        // these files are no longer needed, and no other run would replace them
        for name in self.generations.iter().filter(|name| !GENERATIONS.contains(&name.as_str())) {
            let _ = std::fs::remove_file(self.place.join(name));
        }
        Ok(())
    }

    /// Reads the final state of a run with the data of its observers (measurements during the run). `None` if no such
    /// data are stored, or if the file belongs to another run.
    ///
    /// # Errors
    /// Returns the path of the file and the reason if the file cannot be used.
    pub fn finished(&self, run: &RunIdentity) -> Result<Option<StoredRun>, (PathBuf, Unreadable)> {
        let name = done(run);
        match self.read::<(RunIdentity, StoredRun)>(&name) {
            Ok((of, kept)) if of == *run => self.has_parts(&name, (0, run), &kept).map(|()| Some(kept)),
            Ok(_) => Ok(None),
            Err(Unreadable::Io(why)) if why.kind() == ErrorKind::NotFound => Ok(None),
            Err(why) => Err((self.place.join(name), why)),
        }
    }

    /// Reads the result of a run, which a sweep stores in place of the final state. `None` if there is no such result,
    /// or if it cannot be read or belongs to another run.
    pub fn result(&self, run: &RunIdentity) -> Option<Vec<u8>> {
        let (of, result) = self.read::<(RunIdentity, Vec<u8>)>(&done(run)).ok()?;
        (of == *run).then_some(result)
    }

    /// Removes the files of the checkpoint, and also the subfolder if it contains no other files.
    ///
    /// # Errors
    /// Returns an error if a file cannot be removed.
    pub fn remove(&self) -> Result<(), OutputError> {
        let entries = match std::fs::read_dir(&self.place) {
            Ok(entries) => entries,
            Err(why) if why.kind() == ErrorKind::NotFound => return Ok(()),
            Err(why) => return Err(OutputError::io("read", &self.place, why)),
        };
        // the file of the command is removed first: if the program is killed after that, no command remains that could
        // be continued
        for path in COMMAND.map(|name| self.place.join(name)) {
            match std::fs::remove_file(&path) {
                Err(why) if why.kind() != ErrorKind::NotFound => {
                    return Err(OutputError::io("remove the old", &path, why));
                }
                Ok(()) | Err(_) => {}
            }
        }
        for entry in entries.flatten() {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            let generation = name.split('-').next().is_some_and(|first| GENERATIONS.contains(&first));
            let state = generation || name.starts_with(DONE);
            // an incomplete file, left by a program that was killed while writing, is removed too
            if state || name.starts_with(ASIDE) {
                std::fs::remove_file(entry.path())
                    .map_err(|why| OutputError::io("remove the old", &entry.path(), why))?;
            }
        }
        // removing the folder fails, as intended, if it contains other files
        let _ = std::fs::remove_dir(&self.place);
        Ok(())
    }

    fn write<T: Serialize>(&self, name: &str, value: &T) -> Result<(), OutputError> {
        let path = self.place.join(name);
        let unfit = |why: StoreError| OutputError::io("write", &path, std::io::Error::other(why));
        put(&path, &seal(value).map_err(unfit)?)
    }

    fn read<T: DeserializeOwned>(&self, name: &str) -> Result<T, Unreadable> {
        open(&std::fs::read(self.place.join(name))?)
    }
}

/// Name of the file with the data of the process `number`; the file `name` contains the other data of this state.
fn part_of(name: &str, number: usize) -> String {
    format!("{name}-part-{number}")
}

/// Name of the file that contains the final state of a run, or its result.
fn done(run: &RunIdentity) -> String {
    format!("{DONE}{}", run.file_name())
}
