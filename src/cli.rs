//! Types of the command line, from which clap makes the parser.
//!
//! clap prints the doc comments of this file as help. A field that includes a shared group of options has no comment,
//! because clap would print that comment too.
#![expect(missing_docs, reason = "a doc comment on a group of options would become help text")]

mod comparisons;
mod factors;

pub use comparisons::{Compare, JudgeArguments, Validate};
pub use factors::{FactorRuns, NeededModels, Sensitivity};

use crate::case::quantity;
use crate::experiment::Model;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use std::time::Duration;

/// One particle scene, two collision models: soft spheres stepped in time and hard spheres driven by events.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
pub struct Cli {
    /// The command to run.
    #[command(subcommand)]
    pub command: Command,
}

/// Commands of the program.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Runs a case with one collision model.
    Run(Run),
    /// Runs the variants of a case one after the other and compares them. Without a [[compare]] list, the variants are
    /// soft and hard.
    Compare(Compare),
    /// Compares files of any program: series over time, output of LAMMPS, tables of values with standard errors, and
    /// folders of results.
    Judge(JudgeArguments),
    /// Continues a run, a comparison, a sweep or a study of sensitivity or of needs that was stopped or killed; the
    /// results do not depend on the interruption.
    Resume(Resume),
    /// Predicts contacts, time steps, rates and costs of a case and recommends an engine; runs only a few seconds of
    /// calibration.
    Plan(Plan),
    /// Reads and checks a case and reports what it would run.
    Check(Check),
    /// Computes the gas velocity profile of a case.
    Fluid(FluidArguments),
    /// Shows one impact, of two spheres or of a sphere and a wall, under each model.
    Impact(ImpactArguments),
    /// Charts the error of every method against its cost, and marks the cheapest methods.
    Chart(Chart),
    /// Draws maps that show where each method fails: stability, restitution, overlap, collapse, missed collisions. Each
    /// point of a map is a run.
    Limits(Limits),
    /// Compares the program with closed forms, with published numbers of other codes, and with experiments.
    Validate(Validate),
    /// Runs the variants of a case at several values of its keys, and plots the results over these values. An
    /// interrupted sweep is continued when it is started again.
    Sweep(Sweep),
    /// Shows in one chart how strongly each result shifts with the contact model, stiffness, restitution, gas and other
    /// inputs.
    Sensitivity(Sensitivity),
    /// Finds the cheapest set of models (contacts, rotation, turbulence, two-way coupling, lift, ...) that gives the
    /// results of the richest one.
    Needs(NeededModels),
    /// Serves a page on this machine, on which both models run side by side: scenes to try out, sliders, questions.
    #[cfg(feature = "lab")]
    Lab(Lab),
    /// Lists the built-in cases, each with its question, and the sets of values for `use`.
    Cases,
    /// Writes a built-in case to a file, as a starting point for a case of your own.
    Init(Init),
    /// Explains the keys of a case: type, unit, default, range, example.
    Keys(Keys),
    /// Prints the completion script of a shell, to be saved in the folder in which the shell looks for such scripts.
    Completions(Completions),
    /// Prints the manual page of the program or of one command, for `man -l`.
    Man(Man),
}

/// Options of every command that reads a case.
#[derive(Clone, Debug, Args)]
pub struct Input {
    /// Sets a key of the case to another value, for example --set soft.steps_per_contact=50 or --set
    /// 'domain.size[0]=12 mm'; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Pushes overlapping placed particles apart before the start, and reports how far they moved; the same as --set
    /// run.relax=true.
    #[arg(long)]
    pub relax: bool,
}

impl Input {
    /// Changes of keys of the case, each as `key=value`: those of `--set`, then those of flags such as `--relax`.
    pub fn sets(&self) -> Vec<String> {
        let relax = self.relax.then(|| "run.relax=true".to_owned());
        self.set.iter().cloned().chain(relax).collect()
    }

    /// Copies these options. If a `duration` is given, adds the change of the key `run.duration`.
    pub fn with_duration(&self, duration: Option<&String>) -> Self {
        let mut input = self.clone();
        input.set.extend(duration.map(|duration| format!("run.duration={duration}")));
        input
    }

    /// Copies these options. If a time `every` between two trajectory frames is given, adds the change of the key
    /// `output.every`.
    pub fn with_every(&self, every: Option<&String>) -> Self {
        let mut input = self.clone();
        input.set.extend(every.map(|every| format!("output.every={every}")));
        input
    }
}

/// Options of every command that writes a folder.
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

/// Options of every command that `diptych resume` can continue.
#[derive(Clone, Debug, Args)]
pub struct Keep {
    /// Wall time between two checkpoints, from which `diptych resume` continues, such as "90 s" or "1 h"; `never`
    /// writes none.
    #[arg(long, value_name = "TIME", default_value = "10 min", value_parser = wall_time, allow_hyphen_values = true)]
    pub checkpoint_every: CheckpointEvery,
}

/// Wall time between two checkpoints; `None` if no checkpoints are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CheckpointEvery(pub Option<Duration>);

impl CheckpointEvery {
    /// Default wall time between two checkpoints: 10 minutes.
    pub fn usual() -> Self {
        Self(Some(Duration::from_mins(10)))
    }
}

/// Parses a wall time with its unit, or the word `never`.
fn wall_time(text: &str) -> Result<CheckpointEvery, String> {
    if text.trim() == "never" {
        return Ok(CheckpointEvery(None));
    }
    let seconds = quantity::parse(text, [0, 0, 1]).map_err(|why| {
        let help = why.help.map_or(String::new(), |help| format!("; {help}"));
        format!("`{text}` {}{help}, or `never`", why.message)
    })?;
    let time = Duration::try_from_secs_f64(seconds).ok().filter(|time| !time.is_zero());
    time.map(|time| CheckpointEvery(Some(time))).ok_or_else(|| "a time above 0 belongs here, or `never`".to_owned())
}

/// Options of every command that simulates.
#[derive(Clone, Debug, Args)]
pub struct Effort {
    /// Threads to use; results are the same for any number [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Seed of the random numbers of the start and of the run, in place of the seed that the case gives.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

/// Number of runs (replicas) of each variant.
#[derive(Clone, Copy, Debug, Args)]
pub struct Repeats {
    /// Runs each variant with N seeds (that of the case and the next ones) and averages over them. `run` and `compare`
    /// time the first run of each variant, which is done alone; the other runs are done at the same time.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    pub replicas: u16,
}

/// Arguments of `diptych run`.
#[derive(Clone, Debug, Args)]
pub struct Run {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// Collision model, in place of the model that the case gives; auto: the model that `plan` recommends.
    #[arg(long)]
    pub model: Option<ModelChoice>,
    /// Also writes the final positions and velocities (state.csv).
    #[arg(long)]
    pub save_state: bool,
    /// Also writes the budget of the second moments of the velocity: production, transport, drag, impacts
    /// (budgets.csv, figures/budgets.svg). For a resumed run the budget begins at the resumption.
    #[arg(long)]
    pub budgets: bool,
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
    /// Shows the run on a page while it goes on, and prints the address of the page. Only browsers on this machine can
    /// open it. Results are those of a run without the page.
    #[cfg(feature = "lab")]
    #[arg(long)]
    pub live: bool,
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

/// All collision models.
const MODELS: [Model; 4] = [Model::Soft, Model::Hard, Model::Hybrid, Model::Dsmc];

fn model_of(name: String) -> Result<Model, String> {
    MODELS.into_iter().find(|model| model.name() == name).ok_or(name)
}

/// A collision model, or the recommended one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ModelChoice {
    /// Soft spheres: contacts of springs and dashpots, integrated in time steps.
    Soft,
    /// Hard spheres: instantaneous collisions.
    Hard,
    /// Instantaneous collisions where two bodies touch and no other is near, spring-dashpot contacts elsewhere.
    Hybrid,
    /// Instantaneous collisions of pairs that are drawn at random in cells.
    Dsmc,
    /// The model that `plan` recommends for the case.
    Auto,
}

impl ModelChoice {
    /// Collision model that was chosen; `None` for `auto`, for which `plan` chooses the model later.
    pub fn model(self) -> Option<Model> {
        match self {
            Self::Soft => Some(Model::Soft),
            Self::Hard => Some(Model::Hard),
            Self::Hybrid => Some(Model::Hybrid),
            Self::Dsmc => Some(Model::Dsmc),
            Self::Auto => None,
        }
    }
}

/// Arguments of `diptych plan`.
#[derive(Clone, Debug, Args)]
pub struct Plan {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// Largest relative error allowed for the recommended model, as 1% or 0.01 [-].
    #[arg(long, value_name = "ERROR", default_value = "1%", value_parser = relative_error)]
    pub target_error: f64,
    /// Prints the plan as JSON.
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub effort: Effort,
}

/// Parses a relative error [-] between 0 and 1, both excluded, from a number or a percentage.
fn relative_error(text: &str) -> Result<f64, String> {
    let (number, unit) = match text.trim().strip_suffix('%') {
        Some(number) => (number.trim(), 0.01),
        None => (text.trim(), 1.0),
    };
    match number.parse::<f64>() {
        Ok(value) if value > 0.0 && value * unit < 1.0 => Ok(value * unit),
        _ => Err("an error is a share between 0 and 1, such as 1% or 0.01".into()),
    }
}

/// Arguments of `diptych resume`.
#[derive(Clone, Debug, Args)]
pub struct Resume {
    /// The folder of results of the stopped command.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Threads to use; results are the same for any number [default: as at the first start].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Shows no progress and no summary.
    #[arg(long)]
    pub quiet: bool,
}

/// Arguments of `diptych check`.
#[derive(Clone, Debug, Args)]
pub struct Check {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// Prints the findings as JSON.
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub input: Input,
}

/// Arguments of `diptych fluid`.
#[derive(Clone, Debug, Args)]
pub struct FluidArguments {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// Also draws the gas profiles that a finished run of this case with two-way coupling ([fluid.coupling]) has
    /// written to the folder RUN.
    #[arg(long, value_name = "RUN")]
    pub after: Option<PathBuf>,
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub output: Output,
}

/// Arguments of `diptych impact`.
#[derive(Clone, Debug, Args)]
pub struct ImpactArguments {
    /// The case file, or the name of a built-in case: one or two spheres [default: impact].
    pub case: Option<PathBuf>,
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub output: Output,
}

/// Arguments of `diptych chart`.
#[derive(Clone, Debug, Args)]
pub struct Chart {
    /// The case file, or the name of a built-in case: one impact, or many particles.
    pub case: PathBuf,
    /// Uses fewer values of each parameter and, for scenes of many particles, a tenth of the simulated time.
    #[arg(long)]
    pub quick: bool,
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub output: Output,
}

/// Arguments of `diptych limits`.
#[derive(Clone, Debug, Args)]
pub struct Limits {
    /// Uses coarser grids and shorter runs: about a minute on one core.
    #[arg(long)]
    pub quick: bool,
    /// Draws one map only, by its name; may be repeated [default: all].
    #[arg(long, value_name = "MAP")]
    pub only: Vec<String>,
    /// Threads to use; results are the same for any number [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub output: Output,
}

/// Arguments of `diptych sweep`.
#[derive(Clone, Debug, Args)]
pub struct Sweep {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// A key and its values, for example --sweep "soft.linear_spring_dashpot.stiffness=300 N/m,1 kN/m"; if repeated,
    /// all combinations are run [default: the case's [[sweep]] list].
    #[arg(long, value_name = "KEY=A,B,...")]
    pub sweep: Vec<String>,
    /// Runs only the variant with this name; may be repeated [default: all that `compare` would run].
    #[arg(long, value_name = "VARIANT")]
    pub only: Vec<String>,
    /// Runs the simulations one after the other, each with all threads, so that wall times can be compared [default:
    /// several runs at once, which share the threads].
    #[arg(long)]
    pub in_turn: bool,
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub output: Output,
    #[command(flatten)]
    pub effort: Effort,
    #[command(flatten)]
    pub repeats: Repeats,
}

/// Arguments of `diptych lab`.
#[cfg(feature = "lab")]
#[derive(Clone, Debug, Args)]
pub struct Lab {
    /// Port of this machine for the page [default: any free port].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub port: Option<u16>,
    /// Writes a page with one scene to this file instead of serving the lab. The page contains recorded runs for the
    /// values of its sliders, and works without the program and without a network. An existing file is never replaced.
    #[arg(long, value_name = "FILE", conflicts_with = "port")]
    pub export: Option<PathBuf>,
    /// Scene of the exported page, such as impact, cradle, cooling or heap.
    #[arg(long, value_name = "NAME", requires = "export", default_value = "impact")]
    pub scene: String,
}

/// Arguments of `diptych init`.
#[derive(Clone, Debug, Args)]
pub struct Init {
    /// Name of the built-in case, see `diptych cases`.
    pub name: String,
    /// File to write [default: the last part of NAME with .toml]; an existing file is never replaced.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Arguments of `diptych keys`.
#[derive(Clone, Debug, Args)]
pub struct Keys {
    /// Explains only this table and the tables within it, such as soft or walls.plane [default: all].
    pub table: Option<String>,
    /// Prints a JSON schema, by which editors check a case. With the extension Even Better TOML, put the line
    /// `#:schema diptych.schema.json` at the top of a case.
    #[arg(long, conflicts_with = "table")]
    pub schema: bool,
    /// Prints Markdown: the page docs/keys.md.
    #[arg(long, conflicts_with = "schema")]
    pub markdown: bool,
}

/// Arguments of `diptych completions`.
#[derive(Clone, Debug, Args)]
pub struct Completions {
    /// Shell for which completions are printed.
    pub shell: clap_complete::Shell,
}

/// Arguments of `diptych man`.
#[derive(Clone, Debug, Args)]
pub struct Man {
    /// Command whose manual page is printed [default: the program itself].
    pub command: Option<String>,
}
