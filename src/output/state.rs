//! File `state.csv` with the final state of a run.

use super::csv;
use super::{Folder, OutputError};
use crate::case::saved;
use crate::observe::{Needs, Observer};
use crate::schedule::Schedule;
use crate::simulation::Simulation;

/// Observer that writes `state.csv` when the run is over or has failed.
pub struct StateFile<'a> {
    folder: &'a Folder,
    /// Checksum of the text of the case file. By this checksum, a reader of `state.csv` can tell to which case the
    /// state belongs.
    case: u64,
    written: Result<(), OutputError>,
}

impl<'a> StateFile<'a> {
    /// Creates the observer, which writes into `folder`. `case` is the text of the case file of the run.
    pub fn new(folder: &'a Folder, case: &str) -> Self {
        Self { folder, case: saved::fingerprint(case), written: Ok(()) }
    }

    /// Returns an error if the file could not be written. The caller calls this method after the run.
    ///
    /// # Errors
    /// The file could not be written.
    pub fn written(self) -> Result<(), OutputError> {
        self.written
    }

    fn write(&self, simulation: &Simulation) -> Result<(), OutputError> {
        let about = [
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("case", format!("{:016x}", self.case)),
            ("time_s", format!("{:?}", simulation.time)),
            ("units", "m, m/s".to_owned()),
        ];
        self.folder.write("state.csv", &csv::state(&simulation.particles, simulation.scene(), &about)?)?;
        Ok(())
    }
}

impl Observer for StateFile<'_> {
    fn next(&self, _now: f64, _schedule: &Schedule) -> Option<f64> {
        None
    }

    fn see(&mut self, _simulation: &Simulation) {}

    fn needs_at_end(&self, _now: f64) -> Needs {
        Needs::Every(1)
    }

    fn end(&mut self, simulation: &Simulation) {
        self.written = self.write(simulation);
    }
}
