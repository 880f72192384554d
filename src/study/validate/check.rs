//! One row (test) of the validation suite before it runs, and functions by which such tests run their scenes.

use crate::case::{Case, built_in};
use crate::engine::Failure;
use crate::experiment::{Experiment, Model};
use crate::output::panel::Panel;
use crate::output::{ValidationNumber, ValidationRule, ValidationTier};
use crate::runs::{StudyError, start};
use crate::simulation::Simulation;
use crate::statistics::{Answer, Estimate};
use rayon::prelude::*;

/// Row of the validation suite: the description of a comparison, and the function that runs its scene.
pub struct ValidationCheck {
    /// Name of the row (comparison of the suite) on the command line (`--only`) and in the report.
    pub name: &'static str,
    /// Kind of the reference, such as a closed form or an experiment.
    pub tier: ValidationTier,
    /// Name of the built-in case that contains the scene. The comparison may change some keys of this case.
    pub case: &'static str,
    /// Description of the scene, for the report.
    pub scene: &'static str,
    /// Source of the reference value, with the place in the source.
    pub source: &'static str,
    /// Text on effects that the comparison does not test, for the report.
    pub not_shown: &'static str,
    /// True if the comparison takes minutes. The option `--quick` leaves out such comparisons.
    pub takes_minutes: bool,
    /// Function that runs the scene, and returns the results with their references.
    pub measure: fn(&CheckScene) -> Result<CheckResult, StudyError>,
}

/// Results of a row of the validation suite, with a picture if there is one.
pub struct CheckResult {
    /// Numbers of the comparison with their references, before they are judged.
    pub numbers: Vec<ValidationNumber>,
    /// Picture with its caption; `None` if the comparison has no picture.
    pub picture: Option<(&'static str, Panel)>,
}

impl From<Vec<ValidationNumber>> for CheckResult {
    fn from(numbers: Vec<ValidationNumber>) -> Self {
        Self { numbers, picture: None }
    }
}

/// Built-in case of a row (comparison of the suite), from which the experiments of the row are made.
pub struct CheckScene {
    case: Case,
    /// True for fewer and shorter runs (option `--quick`).
    pub quick: bool,
}

impl CheckScene {
    /// Scene of the built-in case with the name `case`. If `quick` is true, its runs are fewer and shorter.
    ///
    /// # Errors
    /// Returns an error if there is no such case, or if it cannot be read. Both would be faults of the program.
    pub fn new(case: &str, quick: bool) -> Result<Self, StudyError> {
        let missing = || StudyError::Failed(format!("error: no built-in case is called `{case}`"));
        let case = Case::built_in(&built_in::case(case).ok_or_else(missing)?, &[])?;
        Ok(Self { case, quick })
    }

    /// Returns `quick` with the option `--quick`, else `full`.
    pub fn choose<T>(&self, quick: T, full: T) -> T {
        if self.quick { quick } else { full }
    }

    /// Experiment of the scene with the collision model `model`, the seed `seed`, and changes of keys in the form
    /// `key=value`.
    ///
    /// # Errors
    /// Returns an error if the case refuses a change, which would be a fault of the program.
    pub fn experiment(&self, model: Model, seed: Option<u64>, sets: &[String]) -> Result<Experiment, StudyError> {
        Ok(self.case.changed(sets, Some(model), seed)?.0)
    }

    /// Simulation of the scene, with the particles at their start. Without a `seed` the case determines the seed.
    ///
    /// # Errors
    /// Returns the errors of [`experiment`](Self::experiment), and an error if the particles do not fit into the box.
    pub fn simulation(&self, model: Model, seed: Option<u64>, sets: &[String]) -> Result<Simulation, StudyError> {
        let experiment = self.experiment(model, seed, sets)?;
        Ok(Simulation::new(&experiment, start(&experiment)?))
    }

    /// Results of the function `one`, which does one run, for the seeds 1 to `count`. They are in the order of the
    /// seeds.
    ///
    /// # Errors
    /// Returns the error of one of the runs that fail.
    pub fn replicas<T: Send>(
        &self,
        count: u64,
        one: impl Fn(u64) -> Result<T, StudyError> + Sync,
    ) -> Result<Vec<T>, StudyError> {
        let seeds: Vec<u64> = (1..=count).collect();
        seeds.into_par_iter().with_max_len(1).map(&one).collect()
    }
}

/// Runs a simulation up to the simulated time `time` [s] in `windows` equal windows (pieces of the run). Afterwards the
/// particles are in the order of their ids.
///
/// # Errors
/// Returns an error if the engine stops.
pub fn run_to(simulation: &mut Simulation, time: f64, windows: u64) -> Result<(), StudyError> {
    let window = (time - simulation.time) / windows as f64;
    simulation.run(windows, window).map_err(stopped)?;
    simulation.particles.sort_by_id();
    Ok(())
}

/// Error of a row (comparison of the suite) for the failure of an engine.
pub fn stopped(why: Failure) -> StudyError {
    StudyError::Failed(why.to_string())
}

/// Makes a number of a validation row that has no scatter, with an exact reference. The tolerance is in the unit of the
/// number.
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

/// Makes a number of a validation row that has no scatter, with a reference that is a measurement or was read off a
/// picture. `reading` is the standard error of the reference. This error and the margin (largest accepted difference)
/// are in the unit of the number.
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

/// Makes a number of a validation row from several independent runs, with its standard error. The margin (largest
/// accepted difference) is in the unit of the number.
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
