//! The command line: types only.

use crate::experiment::Model;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// One particle scene, two collision models: soft spheres stepped in time and hard spheres driven by events.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Runs a case with one collision model.
    Run(Run),
    /// Runs the variants of a case one after the other and compares them; without a [[compare]] list: soft and hard.
    Compare(Compare),
    /// Reads and checks a case and says what would run.
    Check(Check),
    /// Computes the gas velocity profile of a case.
    Fluid(Fluid),
    /// Shows one impact, of two spheres or of a sphere and a wall, under each model.
    Impact(Impact),
    /// Maps where each method fails, each point a run: stability, restitution, overlap, collapse, missed collisions.
    Limits(Limits),
}

/// What every command that reads a case takes.
#[derive(Clone, Debug, Args)]
pub struct Input {
    /// Overrides a key of the case, for example --set soft.steps_per_contact=50 or --set 'domain.size[0]=12 mm'; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// What every command that writes a folder takes.
#[derive(Clone, Debug, Args)]
pub struct Output {
    /// Folder for the results [default: out/CASE-COMMAND].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replaces results that are already in the folder.
    #[arg(long)]
    pub overwrite: bool,
    /// Shows no progress and no summary.
    #[arg(long)]
    pub quiet: bool,
}

/// What every command that simulates takes.
#[derive(Clone, Debug, Args)]
pub struct Effort {
    /// Threads to use; results are the same for any number [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Seed of the initial state, instead of the case's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

/// `diptych run`.
#[derive(Clone, Debug, Args)]
pub struct Run {
    /// The case file.
    pub case: PathBuf,
    /// Collision model, instead of the case's.
    #[arg(long)]
    pub model: Option<Model>,
    /// Writes the final positions and velocities too (state.csv).
    #[arg(long)]
    pub save_state: bool,
    #[command(flatten)]
    #[expect(missing_docs, reason = "a doc comment here would become help text")]
    pub input: Input,
    #[command(flatten)]
    #[expect(missing_docs, reason = "a doc comment here would become help text")]
    pub output: Output,
    #[command(flatten)]
    #[expect(missing_docs, reason = "a doc comment here would become help text")]
    pub effort: Effort,
}

/// `diptych compare`.
#[derive(Clone, Debug, Args)]
pub struct Compare {
    /// The case file.
    pub case: PathBuf,
    #[command(flatten)]
    #[expect(missing_docs, reason = "a doc comment here would become help text")]
    pub input: Input,
    #[command(flatten)]
    #[expect(missing_docs, reason = "a doc comment here would become help text")]
    pub output: Output,
    #[command(flatten)]
    #[expect(missing_docs, reason = "a doc comment here would become help text")]
    pub effort: Effort,
}

/// `diptych check`.
#[derive(Clone, Debug, Args)]
pub struct Check {
    /// The case file.
    pub case: PathBuf,
    #[command(flatten)]
    #[expect(missing_docs, reason = "a doc comment here would become help text")]
    pub input: Input,
}

/// `diptych fluid`.
#[derive(Clone, Debug, Args)]
pub struct Fluid {
    /// The case file.
    pub case: PathBuf,
    #[command(flatten)]
    #[expect(missing_docs, reason = "a doc comment here would become help text")]
    pub input: Input,
    #[command(flatten)]
    #[expect(missing_docs, reason = "a doc comment here would become help text")]
    pub output: Output,
}

/// `diptych impact`.
#[derive(Clone, Debug, Args)]
pub struct Impact {
    /// The case file: one or two spheres [default: cases/impact.toml, built in].
    pub case: Option<PathBuf>,
    #[command(flatten)]
    #[expect(missing_docs, reason = "a doc comment here would become help text")]
    pub input: Input,
    #[command(flatten)]
    #[expect(missing_docs, reason = "a doc comment here would become help text")]
    pub output: Output,
}

/// `diptych limits`.
#[derive(Clone, Debug, Args)]
pub struct Limits {
    /// Coarser grids and shorter runs: two minutes on two cores.
    #[arg(long)]
    pub quick: bool,
    /// One map only, by its name; may be repeated [default: all].
    #[arg(long, value_name = "MAP")]
    pub only: Vec<String>,
    /// Threads to use; results are the same for any number [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    #[expect(missing_docs, reason = "a doc comment here would become help text")]
    pub output: Output,
}
