//! One row of the validation suite before it runs, and the functions with which rows run their scenes.

use crate::case::{Case, built_in};
use crate::engine::Failure;
use crate::experiment::{Experiment, Model};
use crate::output::panel::Panel;
use crate::output::{ValidationNumber, ValidationRule, ValidationTier};
use crate::runs::{StudyError, start};
use crate::simulation::Simulation;
use crate::statistics::{Answer, Estimate};
use rayon::prelude::*;

/// Row of the validation suite: its description, and the function that runs its scene.
pub struct ValidationCheck {
    /// Name of the row on the command line (`--only`).
    pub name: &'static str,
    /// Kind of the reference.
    pub tier: ValidationTier,
    /// Name of the built-in case with the scene. The row changes some keys of this case.
    pub case: &'static str,
    /// Description of the scene, for the report.
    pub scene: &'static str,
    /// Source of the reference, with the place in it.
    pub source: &'static str,
    /// Sentence on what the row does not show.
    pub not_shown: &'static str,
    /// True if the row takes minutes, so that `--quick` leaves it out.
    pub takes_minutes: bool,
    /// Function that runs the scene and returns the numbers with their references.
    pub measure: fn(&CheckScene) -> Result<CheckResult, StudyError>,
}

/// Numbers of a row, with a picture if there is one.
pub struct CheckResult {
    /// Numbers with their references, not yet judged.
    pub numbers: Vec<ValidationNumber>,
    /// Picture with its caption.
    pub picture: Option<(&'static str, Panel)>,
}

impl From<Vec<ValidationNumber>> for CheckResult {
    fn from(numbers: Vec<ValidationNumber>) -> Self {
        Self { numbers, picture: None }
    }
}

/// Built-in case of a row, from which the runs of the row are made.
pub struct CheckScene {
    case: Case,
    /// True for `--quick`: fewer and shorter runs.
    pub quick: bool,
}

impl CheckScene {
    /// Scene of a built-in case.
    ///
    /// # Errors
    /// There is no such case, or it cannot be read, which would be an error in the program.
    pub fn new(case: &str, quick: bool) -> Result<Self, StudyError> {
        let missing = || StudyError::Failed(format!("error: no built-in case is called `{case}`"));
        let case = Case::built_in(&built_in::case(case).ok_or_else(missing)?, &[])?;
        Ok(Self { case, quick })
    }

    /// Returns `quick` for `--quick`, else `full`.
    pub fn choose<T>(&self, quick: T, full: T) -> T {
        if self.quick { quick } else { full }
    }

    /// Experiment of the scene with a model, a seed and changes of the form `key=value`.
    ///
    /// # Errors
    /// The case refuses a change, which would be an error in the program.
    pub fn experiment(&self, model: Model, seed: Option<u64>, sets: &[String]) -> Result<Experiment, StudyError> {
        Ok(self.case.changed(sets, Some(model), seed)?.0)
    }

    /// Simulation of the scene at its start.
    ///
    /// # Errors
    /// The errors of [`experiment`](Self::experiment), or particles that do not fit.
    pub fn simulation(&self, model: Model, seed: Option<u64>, sets: &[String]) -> Result<Simulation, StudyError> {
        let experiment = self.experiment(model, seed, sets)?;
        Ok(Simulation::new(&experiment, start(&experiment)?))
    }

    /// Results of `one` run for each of `count` seeds, in the order of the seeds.
    ///
    /// # Errors
    /// The first error of a run.
    pub fn replicas<T: Send>(
        &self,
        count: u64,
        one: impl Fn(u64) -> Result<T, StudyError> + Sync,
    ) -> Result<Vec<T>, StudyError> {
        let seeds: Vec<u64> = (1..=count).collect();
        seeds.into_par_iter().with_max_len(1).map(&one).collect()
    }
}

/// Runs a simulation up to `time` [s] in `windows` windows. Afterwards the particles are in the order of their ids.
///
/// # Errors
/// The engine stopped.
pub fn run_to(simulation: &mut Simulation, time: f64, windows: u64) -> Result<(), StudyError> {
    let window = (time - simulation.time) / windows as f64;
    simulation.run(windows, window).map_err(stopped)?;
    simulation.particles.sort_by_id();
    Ok(())
}

/// Converts the failure of an engine to the error of a row.
pub fn stopped(why: Failure) -> StudyError {
    StudyError::Failed(why.to_string())
}

/// Makes a number of a row from an exact reference and a result without scatter. The tolerance is in their unit.
pub fn exact(
    name: impl Into<String>,
    unit: &'static str,
    reference: f64,
    ours: f64,
    tolerance: f64,
) -> ValidationNumber {
    ValidationNumber {
        name: name.into(),
        unit,
        reference: Estimate::exact(reference),
        ours: Estimate::exact(ours),
        freedom: f64::INFINITY,
        allowed: tolerance,
        rule: ValidationRule::Tolerance,
        answer: Answer::Unresolved,
    }
}

/// Makes a number of a row from a result without scatter and a reference with the error `reading` of a measurement or
/// of a digitised picture. The error and the margin are in the unit of the number.
pub fn read_off(
    name: impl Into<String>,
    unit: &'static str,
    (reference, reading): (f64, f64),
    ours: f64,
    margin: f64,
) -> ValidationNumber {
    ValidationNumber {
        reference: Estimate::new(reference, reading),
        rule: ValidationRule::Margin,
        ..exact(name, unit, reference, ours, margin)
    }
}

/// Makes a number of a row from the results of several independent runs. The margin is in the unit of the number.
pub fn averaged(
    name: impl Into<String>,
    unit: &'static str,
    reference: Estimate,
    runs: impl IntoIterator<Item = f64>,
    margin: f64,
) -> ValidationNumber {
    let runs: Vec<f64> = runs.into_iter().collect();
    let count = runs.len() as f64;
    let mean = runs.iter().sum::<f64>() / count;
    let variance = runs.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    ValidationNumber {
        reference,
        ours: Estimate::new(mean, (variance / count).sqrt()),
        freedom: count - 1.0,
        rule: ValidationRule::Margin,
        ..exact(name, unit, reference.value, mean, margin)
    }
}
