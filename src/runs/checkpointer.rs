//! Checkpoints of a command. The states of its runs are stored at intervals, when a run has ended, and when the user
//! stops the command. In this file the end of a run means its final state and the data of its observers. Observers are
//! the measurements during a run. A variant is one of the experiments of a case.

use super::error::StudyError;
use super::resumable::ResumableRun;
use super::settings::{CommandOrigin, CommandSettings};
use super::signals::Signals;
use super::terminal::tell;
use crate::case::Case;
use crate::checkpoint::{RunIdentity, Store, StoredCommand, StoredRun, Unreadable, checksum, open, seal};
use crate::cli::CheckpointEvery;
use crate::engine::Failure;
use crate::output::{Folder, OutputError, numbers};
use crate::stored::StoreError;
use std::path::Path;
use std::time::{Duration, Instant};

/// Stores the states of the runs of a command at intervals, and tells a run when it must pause or stop.
pub struct Checkpointer {
    signals: Signals,
    /// Store for the files of checkpoints; `None` if the command writes no checkpoints.
    store: Option<Store>,
    every: Option<Duration>,
    /// Instant of the latest checkpoint or, before the first one, of the start of the command.
    last: Instant,
    /// Run that was in progress when the command was stopped earlier, with its stored state. `None` if there is no such
    /// state, or if the run has already continued from it.
    under_way: Option<(RunIdentity, StoredRun)>,
    /// [s] simulated time of the latest stored state of the run in progress; `None` if no state is stored.
    stored: Option<f64>,
    /// True if the command has more work after the run in progress: other runs or a report.
    more: bool,
    /// True if a run was stopped before its end, by the user or because its results cannot be written.
    stopped: bool,
    /// Reason why the results of the run in progress cannot be written; `None` if they can be written.
    unwritten: Option<String>,
    quiet: bool,
    resumed: bool,
    /// Text for messages: the command line that continues this command after it has stopped.
    remedy: String,
    /// Place to which the final state of a run and the data of its observers (measurements during the run) go.
    ends: Ends,
}

/// Place to which the end of a run goes. The end is the final state with the data of the observers (measurements
/// during the run).
#[derive(Clone, Default)]
enum Ends {
    /// The end of the run goes to a file. The file is written if the command has more work after the run, or if an
    /// earlier state of the run was stored.
    #[default]
    Stored,
    /// The end of the run goes to memory, because another process needs it as these bytes. There are no bytes until
    /// the run has ended.
    Caught(Vec<u8>),
    /// The end of the run is already in memory: another process has done the run, and has sent the end as these bytes.
    Received(Vec<u8>),
    /// The end of the run is not stored. The result that is computed from the run is stored instead.
    Replaced,
}

impl Checkpointer {
    /// Creates the checkpointer of a command that writes into `folder`. A command that begins stores its arguments,
    /// and thereby replaces the checkpoint of an earlier command. A command that is resumed, or typed again for a
    /// folder with results, reads the stored state.
    ///
    /// # Errors
    /// Returns an error if the case of a resumed command, or a file that the case uses, has changed. Other errors are
    /// that the system refuses access to the folder, or refuses to install the signal handlers.
    pub fn new(
        settings: &CommandSettings,
        folder: &Folder,
        case: &Case,
        runs: &[ResumableRun],
    ) -> Result<Self, StudyError> {
        // all replicas (runs with different seeds) of a variant have one name, so only the identity of the first
        // replica is compared. If results are stored, a run is found by its name alone, and no identity is compared
        let mut first: Vec<RunIdentity> = Vec::new();
        for run in runs.iter().filter(|_| !settings.keeps_results).map(|run| &run.identity) {
            if first.iter().all(|known| known.name != run.name) {
                first.push(run.clone());
            }
        }
        let command = StoredCommand {
            arguments: settings.arguments(),
            folder: std::env::current_dir().unwrap_or_default().into_os_string(),
            case: checksum(case.text.as_bytes()),
            runs: first,
        };
        let CheckpointEvery(every) = settings.checkpoint_every;
        let mut checkpointer = Self {
            remedy: format!("`diptych resume {}`", folder.path().display()),
            ends: if settings.keeps_results { Ends::Replaced } else { Ends::Stored },
            ..Self::with(Signals::listen()?, every.map(|_| Store::of(folder.path())), every)
        };
        match &settings.origin {
            CommandOrigin::Typed => checkpointer.begin(&command, folder.path())?,
            CommandOrigin::TypedAgain => {
                checkpointer.store.as_ref().map_or(Ok(()), |store| store.replace_command(&command))?;
                checkpointer.find_stored();
            }
            CommandOrigin::Resumed { command: earlier, quiet, .. } => {
                checkpointer.quiet = *quiet;
                refuse_changes(earlier, &command, case)?;
                checkpointer.find_stored();
            }
        }
        Ok(checkpointer)
    }

    /// Creates the checkpointer of a helper, a process that does runs for the lead process of the command. It stores
    /// states in the folder of the lead process, and sends final states and the data of observers (measurements) to
    /// the lead process.
    ///
    /// # Errors
    /// Returns an error if the system refuses to install the signal handlers.
    pub fn of_helper(settings: &CommandSettings) -> Result<Self, StudyError> {
        let CheckpointEvery(every) = settings.checkpoint_every;
        Ok(Self {
            more: true,
            quiet: true,
            resumed: !matches!(settings.origin, CommandOrigin::Typed),
            ends: if settings.keeps_results { Ends::Replaced } else { Ends::Caught(Vec::new()) },
            ..Self::with(Signals::listen()?, every.map(|_| Store::of(&settings.folder)), every)
        })
    }

    fn with(signals: Signals, store: Option<Store>, every: Option<Duration>) -> Self {
        Self {
            signals,
            store,
            every,
            last: Instant::now(),
            under_way: None,
            stored: None,
            more: false,
            stopped: false,
            unwritten: None,
            quiet: false,
            resumed: false,
            remedy: String::new(),
            ends: Ends::Stored,
        }
    }

    /// Signals by which the user stops the command.
    pub fn signals(&self) -> &Signals {
        &self.signals
    }

    /// Creates a checkpointer with separate files for one of several concurrent runs. If the command is resumed or
    /// typed again, the stored state of this run is read. No progress messages are printed.
    pub fn for_run(&self, run: &RunIdentity) -> Self {
        let store = self.store.as_ref().map(|store| store.for_run(run));
        let mut one = Self {
            // the command continues after the end of this run
            more: true,
            quiet: true,
            remedy: self.remedy.clone(),
            ends: self.ends.clone(),
            ..Self::with(self.signals.clone(), store, self.every)
        };
        if self.resumed {
            one.find_stored();
        }
        one
    }

    /// True if the user has asked the command to stop. No new run may then begin.
    pub fn is_stopping(&self) -> bool {
        self.signals.say_stop()
    }

    /// Records that concurrent runs were stopped before they had ended. A resumed command continues all of them.
    pub fn stop(&mut self) {
        self.stopped = true;
        self.stored = None;
    }

    /// Stores the command line, so that the command can be resumed even if it is killed before the first checkpoint. If
    /// the command writes no checkpoints, files of an earlier command are removed.
    fn begin(&mut self, command: &StoredCommand, folder: &Path) -> Result<(), OutputError> {
        match &self.store {
            Some(store) => store.begin(command),
            // files of an earlier command in this folder must not be taken for files of the present command
            None => Store::of(folder).remove(),
        }
    }

    /// Reads the newest stored state of the run that was in progress when the command stopped. A warning is printed for
    /// a state that cannot be used.
    fn find_stored(&mut self) {
        self.resumed = true;
        let Some(store) = &mut self.store else { return };
        let newest = store.newest();
        for (path, why) in &newest.refused {
            let instead = match &newest.found {
                Some((_, kept)) => format!("the other one is used, t = {} s", time(kept)),
                None => "there is no other one: the run under way begins anew".to_owned(),
            };
            tell(format!("warning: the checkpoint {} {why}; {instead}", path.display()));
        }
        self.under_way = newest.found;
    }

    /// Stored state from which a run continues: its end, or a state before its end. `None` if the run must begin at
    /// its start. Prints a line that says that the run is over, or from which simulated time it continues. A warning
    /// is printed for a file that cannot be used.
    pub fn earlier(&mut self, run: &RunIdentity) -> Option<StoredRun> {
        self.stored = None;
        if let Ends::Received(bytes) = &self.ends {
            return open::<(RunIdentity, StoredRun)>(bytes).ok().filter(|(of, _)| of == run).map(|(_, kept)| kept);
        }
        let store = self.store.as_ref().filter(|_| self.resumed)?;
        match store.finished(run) {
            Ok(Some(kept)) => {
                self.say(format!("\"{}\" is over already", run.name));
                if let Ends::Caught(bytes) = &mut self.ends {
                    // serialising cannot fail here, because the stored data were serialised before
                    *bytes = seal(&(run, &kept)).unwrap_or_default();
                }
                return Some(kept);
            }
            Ok(None) => {}
            Err((path, why)) => {
                tell(format!("warning: the checkpoint {} {why}; \"{}\" is run again", path.display(), run.name));
            }
        }
        let (_, kept) = self.under_way.take_if(|(under_way, _)| under_way == run)?;
        self.stored = Some(kept.pause.snapshot.time);
        self.say(format!("\"{}\" goes on from t = {} s", run.name, time(&kept)));
        Some(kept)
    }

    fn say(&self, line: String) {
        if !self.quiet {
            tell(line);
        }
    }

    /// Records whether the command has more work after the next run, such as other runs or a report. If `more` is
    /// false, the command ends after this run.
    pub fn set_more(&mut self, more: bool) {
        self.more = more;
    }

    /// True if the run in progress must pause at the end of its present window (time between two exchanges with the
    /// gas). A run pauses if it is time for a checkpoint, or if the user stops the command.
    pub fn is_due(&self) -> bool {
        self.signals.say_stop() || self.every.is_some_and(|every| self.last.elapsed() >= every)
    }

    /// Stores one part of the state of a run that several processes share; `number` is the index of the part. If
    /// `over` is true, the state is the end of the run. The data that all parts have in common are stored later, by
    /// [`keep`](Self::keep) or [`finish`](Self::finish).
    ///
    /// # Errors
    /// Returns an error if the part cannot be written.
    pub fn keep_part(&self, run: &RunIdentity, over: bool, number: usize, part: &[u8]) -> Result<(), OutputError> {
        self.store.as_ref().map_or(Ok(()), |store| store.keep_part(run, over, number, part))
    }

    /// Stored part with the index `number` of the state of a run, as bytes; empty if there is no usable file. If `over`
    /// is true, the state is the end of the run.
    pub fn part(&self, run: &RunIdentity, over: bool, number: usize) -> Vec<u8> {
        self.store.as_ref().and_then(|store| store.part(run, over, number).ok()).unwrap_or_default()
    }

    /// Stores the state of a run that has not ended. If several processes share the run, the parts of its state have
    /// been stored before; `parts` is the error if this failed. Returns true if the command must stop. If storing
    /// fails, a warning is printed, the run continues, and the state that was stored before remains.
    pub fn keep(&mut self, run: &RunIdentity, kept: &StoredRun, parts: Result<(), OutputError>) -> bool {
        if let Some(store) = &mut self.store {
            match parts.and_then(|()| store.keep(run, kept)) {
                Ok(()) => self.stored = Some(kept.pause.snapshot.time),
                Err(why) => self.complain(&why),
            }
        }
        self.last = Instant::now();
        self.stopped = self.signals.say_stop();
        self.stopped
    }

    fn complain(&self, why: &OutputError) {
        let stored = match self.stored {
            Some(time) => format!("the state at t = {} s is still stored", numbers::significant(time, 6)),
            None => "nothing of this run is stored yet".to_owned(),
        };
        tell(format!("warning: no checkpoint at this time: {why}; {stored}"));
    }

    /// True if the final state of a run and the data of its observers (measurements) must be stored or sent to another
    /// process. This is so if another process needs these data, if the command has more work after the run, or if an
    /// earlier state of the run was stored. It is never so if only results are stored.
    pub fn wants_the_end(&self) -> bool {
        match self.ends {
            Ends::Caught(_) => true,
            Ends::Replaced => false,
            Ends::Stored | Ends::Received(_) => self.store.is_some() && (self.more || self.stored.is_some()),
        }
    }

    /// Stores the final state of a run and the data of its observers (measurements). If several processes share the
    /// run, the parts of the final state have been stored before; `parts` is the error if this failed. After an error,
    /// a warning is printed. If another process needs these data, they are put into memory as bytes instead.
    ///
    /// # Errors
    /// Returns an error if the data cannot be serialised for another process.
    pub fn finish(
        &mut self,
        run: &RunIdentity,
        kept: &StoredRun,
        parts: Result<(), OutputError>,
    ) -> Result<(), StoreError> {
        if let Ends::Caught(bytes) = &mut self.ends {
            *bytes = seal(&(run, kept))?;
            return Ok(());
        }
        if let Some(Err(why)) = self.store.as_ref().map(|store| parts.and_then(|()| store.finish(run, kept))) {
            self.complain(&why);
        }
        Ok(())
    }

    /// Final state of the run and data of its observers (measurements) as bytes, to be sent to another process. Empty
    /// if there are no such bytes.
    pub fn into_end(self) -> Vec<u8> {
        match self.ends {
            Ends::Caught(bytes) | Ends::Received(bytes) => bytes,
            Ends::Stored | Ends::Replaced => Vec::new(),
        }
    }

    /// Receives the final state of the run and the data of its observers (measurements) from another process, and
    /// stores them.
    ///
    /// # Errors
    /// Returns an error if the bytes are damaged, do not belong to this run, or cannot be stored.
    pub fn receive(&mut self, run: &RunIdentity, bytes: &[u8]) -> Result<(), StudyError> {
        match open::<(RunIdentity, StoredRun)>(bytes) {
            Ok((of, kept)) if of == *run => {
                if self.wants_the_end()
                    && let Err(why) = self.finish(run, &kept, Ok(()))
                {
                    return Err(StudyError::Failed(format!("error: cannot store \"{}\": {why}", run.name)));
                }
                self.ends = Ends::Received(bytes.to_vec());
                Ok(())
            }
            Ok((of, _)) => {
                Err(StudyError::Failed(format!("error: another process did \"{}\" for \"{}\"", of.name, run.name)))
            }
            Err(why) => Err(StudyError::Failed(format!("error: what another process sent of \"{}\" {why}", run.name))),
        }
    }

    /// Stored result of a run that has ended, as bytes. `None` if there is no such result, or if the command is neither
    /// resumed nor typed again.
    pub fn result(&self, run: &RunIdentity) -> Option<Vec<u8>> {
        self.store.as_ref().filter(|_| self.resumed)?.result(run)
    }

    /// Stores the result of a run, such as a row of a table, in place of the states of the run.
    ///
    /// # Errors
    /// Returns an error if the result cannot be written.
    pub fn store_result(&self, run: &RunIdentity, result: &[u8]) -> Result<(), OutputError> {
        self.store.as_ref().map_or(Ok(()), |store| store.for_run(run).finish(run, &result))
    }

    /// Records that the command stops because its results cannot be written. When writing is possible again, the user
    /// can resume the command from the stored state.
    pub fn stop_unwritten(&mut self, why: &Failure) {
        self.stopped = true;
        self.unwritten = Some(why.to_string());
    }

    /// True if a run was stopped before its end, by the user or because its results cannot be written.
    pub fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// Error with which a stopped command ends, after the report on its completed part has been written. `name` is the
    /// name of the stopped run.
    pub fn stop_error(&self, name: &str) -> StudyError {
        if let Some(why) = &self.unwritten {
            let help = match (&self.store, self.stored) {
                (None, _) => String::new(),
                (Some(_), None) => format!("\nhelp: once it can be written, {} does what is left", self.remedy),
                (Some(_), Some(time)) => format!(
                    "\nhelp: once it can be written, {} goes on from t = {} s",
                    self.remedy,
                    numbers::significant(time, 6)
                ),
            };
            return StudyError::Failed(format!("error: \"{name}\" stopped: {why}{help}"));
        }
        StudyError::Stopped(match (&self.store, self.stored) {
            (None, _) => format!("\"{name}\" was stopped; nothing is stored (--checkpoint-every never)"),
            (Some(_), None) => format!("\"{name}\" was stopped; {} does what is left", self.remedy),
            (Some(_), Some(time)) => {
                format!("\"{name}\" was stopped; {} goes on from t = {} s", self.remedy, numbers::significant(time, 6))
            }
        })
    }

    /// Passes on the result of writing a report. To an error it adds the command by which the user can write the
    /// report later.
    ///
    /// # Errors
    /// Returns the given error, with the command that the user can type later.
    pub fn with_remedy<T>(&self, written: Result<T, OutputError>) -> Result<T, StudyError> {
        written.map_err(|why| match &self.store {
            Some(_) => {
                StudyError::Failed(format!("error: {why}\nhelp: once it can be written, {} does it", self.remedy))
            }
            None => why.into(),
        })
    }

    /// Removes the stored states. They are not needed when all results have been written.
    ///
    /// # Errors
    /// Returns an error if a file cannot be removed.
    pub fn done(self) -> Result<(), OutputError> {
        self.store.as_ref().map_or(Ok(()), Store::remove)
    }
}

/// Simulated time [s] of a stored state as text, with six significant digits or fewer.
fn time(kept: &StoredRun) -> String {
    numbers::significant(kept.pause.snapshot.time, 6)
}

/// Returns an error if the case or the variants (experiments) of a command have changed since the command began.
fn refuse_changes(earlier: &StoredCommand, now: &StoredCommand, case: &Case) -> Result<(), StudyError> {
    let path = case.path.display();
    let refuse = |what: String| {
        let help = "put it back as it was, or begin the command anew into another folder";
        Err(StudyError::Input(format!("error: {what} since the run began\nhelp: {help}")))
    };
    if earlier.case != now.case {
        return refuse(format!("the case {path} has been changed"));
    }
    for run in &now.runs {
        let name = &run.name;
        match earlier.runs.iter().find(|earlier| earlier.name == *name) {
            None => return refuse(format!("\"{name}\" has become a variant of {path}")),
            Some(earlier) => {
                if let Some(part) = earlier.difference(run) {
                    return refuse(format!(
                        "\"{name}\" ({part}) has been changed by a file that the case {path} uses: it is another"
                    ));
                }
            }
        }
    }
    Ok(())
}

/// Error for a checkpoint file that cannot be used, if there is no other usable file.
pub fn unusable(path: &Path, why: &Unreadable) -> StudyError {
    StudyError::Input(format!("error: the checkpoint {} {why}", path.display()))
}
