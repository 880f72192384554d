//! Arguments of the commands that compare two sides: runs of a case, files, or runs and published numbers.

use super::{Effort, Input, Keep, Output, Repeats, relative_error};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `diptych compare`.
#[derive(Clone, Debug, Args)]
pub struct Compare {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// Continues the run twice by a fifteenth of its length: once with the same settings, once with half the time step
    /// and half the window (time between two exchanges with the gas). Reports the difference; costs about a fifth of
    /// the run.
    #[arg(long)]
    pub verify: bool,
    /// Writes the particles at regular intervals for ParaView, OVITO and ASE (trajectory/), such as --every "1 ms";
    /// the same as --set output.every="1 ms". Windows (times between two exchanges with the gas) also end at these
    /// times, which may change the last digits of results.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub every: Option<String>,
    /// Differences smaller than this margin count as zero; given as 1% or 0.01 of the scale of each observable, the
    /// value by which its differences are divided [-].
    #[arg(long, value_name = "SHARE", default_value = "1%", value_parser = relative_error)]
    pub margin: f64,
    /// Runs replicas (runs with other seeds) of every variant in batches of four and tests the answers after each
    /// batch. Stops when every answer is "equivalent" or "different", or when each variant has as many runs as
    /// --replicas allows (64 if it is not given). The probabilities of wrong answers apply to all tests together.
    #[arg(long)]
    pub until_decided: bool,
    /// Also gives the answer by the exit code: 0 if all are equivalent, 3 if some are different, 4 if some are
    /// unresolved and none is different.
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
    #[command(flatten)]
    pub repeats: Repeats,
}

/// Arguments of `diptych judge`.
#[derive(Clone, Debug, Args)]
pub struct JudgeArguments {
    /// First side: a CSV file, a log or a `fix ave/time` file of LAMMPS, or a folder of results (FOLDER:VARIANT for one
    /// of several variants); replicas are separated by commas [default: the files that --settings names].
    pub a: Option<String>,
    /// Second side, the reference: files as for the first side, or a CSV table with the columns value and
    /// standard_error.
    pub b: Option<String>,
    /// File that names columns, units, start of averaging, curves and margins (judge.toml) [default: columns of equal
    /// names are compared].
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
    /// Differences smaller than this margin count as zero; given as 1% or 0.01 of the scale of each quantity, the
    /// value by which its differences are divided [-] [default: that of --settings, or 1%].
    #[arg(long, value_name = "SHARE", value_parser = relative_error)]
    pub margin: Option<f64>,
    /// Also gives the answer by the exit code: 0 if all quantities are equivalent, 3 if some are different, 4 if some
    /// are unresolved and none is different.
    #[arg(long)]
    pub exit_code: bool,
    #[command(flatten)]
    pub output: Output,
}

/// Arguments of `diptych validate`.
#[derive(Clone, Debug, Args)]
pub struct Validate {
    /// Uses fewer and shorter runs, and leaves out rows that take minutes: under two minutes on two cores.
    #[arg(long)]
    pub quick: bool,
    /// Runs one row only, by its name; may be repeated [default: all].
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Also gives the answer by the exit code: 0 if all rows agree or are equivalent, 3 if some are different, 4 if
    /// some are unresolved and none is different.
    #[arg(long)]
    pub exit_code: bool,
    /// Threads to use; results are the same for any number [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub output: Output,
}
