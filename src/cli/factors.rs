//! Arguments of the commands that change a case by one factor at a time.

use super::{Effort, Input, Keep, MODELS, Output, model_of, relative_error};
use crate::experiment::Model;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use std::path::PathBuf;

/// Arguments of `diptych sensitivity`.
#[derive(Clone, Debug, Args)]
pub struct Sensitivity {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// Tests only these factors, each with its size if it is not the usual one, as in --factors
    /// restitution=0.8,gas,box=0.25; there are model, stiffness, integrator, stepping, restitution, wall-restitution,
    /// friction, wall-friction, rotation, tangential-restitution, tangential-stiffness, rolling, gas, drag, box and
    /// seed [default: all that the scene has].
    #[arg(long, value_name = "NAME[=SIZE],...", value_delimiter = ',')]
    pub factors: Vec<String>,
    /// A factor of your own: a key of the case at another value, such as --vary "particles[0].density=1100 kg/m^3";
    /// may be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    pub vary: Vec<String>,
    #[command(flatten)]
    pub runs: FactorRuns,
}

/// Arguments of `diptych needs`.
#[derive(Clone, Debug, Args)]
pub struct NeededModels {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    #[command(flatten)]
    pub runs: FactorRuns,
}

impl NeededModels {
    /// Arguments of the sensitivity study from which `needs` computes its answer.
    pub fn as_sensitivity(&self) -> Sensitivity {
        let Self { case, runs } = self.clone();
        Sensitivity { case, factors: Vec::new(), vary: Vec::new(), runs }
    }
}

/// Options of the commands that change a case by one factor at a time: `sensitivity` and `needs`.
#[derive(Clone, Debug, Args)]
pub struct FactorRuns {
    /// Collision model of the unchanged case, with which all changed cases are compared [default: that of the case;
    /// for `needs` soft, if the case gives a contact law].
    #[arg(long, value_parser = PossibleValuesParser::new(MODELS.map(Model::name)).try_map(model_of))]
    pub model: Option<Model>,
    /// Simulated time of each run; the same as --set run.duration=TIME.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub duration: Option<String>,
    /// Runs each variant with N seeds (that of the case and the next ones) [default: 1, or 8 for scenes without a
    /// steady state, such as a cooling gas].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub replicas: Option<u16>,
    /// Shifts smaller than this margin count as zero; given as 1% or 0.01 of the scale of each observable, the value
    /// by which its shifts are divided [-].
    #[arg(long, value_name = "SHARE", default_value = "1%", value_parser = relative_error)]
    pub margin: f64,
    /// Prints the factors, their sizes, the number of runs and their approximate time, without doing the runs.
    #[arg(long)]
    pub plan: bool,
    /// Also gives the answer by the exit code: 0 if no shift is beyond the margin, 3 if some shift is, 4 if some shift
    /// is unresolved and none is beyond.
    #[arg(long)]
    pub exit_code: bool,
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub output: Output,
    #[command(flatten)]
    pub effort: Effort,
    #[command(flatten)]
    pub keep: Keep,
}
