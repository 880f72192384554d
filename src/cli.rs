//! The command line: types only.
//!
//! Doc comments are help texts. Groups of options that several commands share have none where a command takes them in: it would
//! become help text too.
#![expect(missing_docs, reason = "a doc comment on a group of options would become help text")]

use crate::case::quantity;
use crate::experiment::Model;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use std::time::Duration;

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
    /// Goes on with a run or a comparison that was stopped or killed, with the same results as if it had not been.
    Resume(Resume),
    /// Predicts contacts, steps, rates and costs of a case and recommends an engine; runs a few seconds of calibration only.
    Plan(Plan),
    /// Reads and checks a case and says what would run.
    Check(Check),
    /// Computes the gas velocity profile of a case.
    Fluid(FluidArguments),
    /// Shows one impact, of two spheres or of a sphere and a wall, under each model.
    Impact(ImpactArguments),
    /// Charts the error of every method against its cost, with the cheapest ones marked.
    Chart(Chart),
    /// Maps where each method fails, each point a run: stability, restitution, overlap, collapse, missed collisions.
    Limits(Limits),
    /// Runs the variants of a case at several values of its keys, and draws what was measured over them; started again, it goes on.
    Sweep(Sweep),
    /// Tells what matters most: how far contact model, stiffness, restitution, gas and others shift each result, in one chart.
    Sensitivity(Sensitivity),
    /// Serves a page on this machine, on which both models run side by side: scenes to play with, sliders, questions.
    #[cfg(feature = "lab")]
    Lab(Lab),
    /// Lists the cases that are built in, each with the question that it asks, and the sets of values for `use`.
    Cases,
    /// Writes a built-in case to a file, as a start for a case of your own.
    Init(Init),
    /// Explains the keys of a case: type, unit, default, range, example.
    Keys(Keys),
    /// Prints the completions of a shell, to be put where the shell looks for them.
    Completions(Completions),
    /// Prints the manual page of the program or of one command, for `man -l`.
    Man(Man),
}

/// What every command that reads a case takes.
#[derive(Clone, Debug, Args)]
pub struct Input {
    /// Overrides a key of the case, for example --set soft.steps_per_contact=50 or --set 'domain.size[0]=12 mm'; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Pushes placed particles that overlap apart before the start, and tells how far; the same as --set run.relax=true.
    #[arg(long)]
    pub relax: bool,
}

impl Input {
    /// All that is set in the case, by flags of their own too.
    pub fn sets(&self) -> Vec<String> {
        let relax = self.relax.then(|| "run.relax=true".to_owned());
        self.set.iter().cloned().chain(relax).collect()
    }

    /// The same with the simulated time, if it is given.
    pub fn with_duration(&self, duration: Option<&String>) -> Self {
        let mut input = self.clone();
        input.set.extend(duration.map(|duration| format!("run.duration={duration}")));
        input
    }

    /// The same with the time between two instants of the trajectories, if it is given.
    pub fn with_every(&self, every: Option<&String>) -> Self {
        let mut input = self.clone();
        input.set.extend(every.map(|every| format!("output.every={every}")));
        input
    }
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

/// What every command that can be gone on with takes.
#[derive(Clone, Debug, Args)]
pub struct Keep {
    /// Wall time between two checkpoints, from which `diptych resume` goes on, such as "90 s" or "1 h"; `never` writes none.
    #[arg(long, value_name = "TIME", default_value = "10 min", value_parser = wall_time)]
    pub checkpoint_every: CheckpointEvery,
}

/// How often checkpoints are written; `None`: never.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CheckpointEvery(pub Option<Duration>);

/// A wall time with its unit, or `never`.
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

/// How many runs there are of a variant.
#[derive(Clone, Copy, Debug, Args)]
pub struct Repeats {
    /// Runs each variant from so many seeds (that of the case and the next ones) and averages over them; `run` and `compare` time
    /// the first of each, which runs alone, and the others run beside each other.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    pub replicas: u16,
}

/// `diptych run`.
#[derive(Clone, Debug, Args)]
pub struct Run {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// Collision model, instead of the case's; auto: the one that `plan` recommends.
    #[arg(long)]
    pub model: Option<ModelChoice>,
    /// Writes the final positions and velocities too (state.csv).
    #[arg(long)]
    pub save_state: bool,
    /// Writes what makes and takes the second moments of the velocity too: production, transport, drag, impacts (budgets.csv,
    /// figures/budgets.svg); of a run that is resumed, since then.
    #[arg(long)]
    pub budgets: bool,
    /// Runs a fifteenth of the run on from its end, as set and at half the step and window, and reports what that changes;
    /// costs about a fifth of the run.
    #[arg(long)]
    pub verify: bool,
    /// Writes the particles every so often for ParaView, OVITO and ASE (trajectory/), such as --every "1 ms"; the same as
    /// --set output.every="1 ms". Windows end at these times too: where they would not have, the last digits of results change.
    #[arg(long, value_name = "TIME")]
    pub every: Option<String>,
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
const MODELS: [Model; 3] = [Model::Soft, Model::Hard, Model::Hybrid];

fn model_of(name: String) -> Result<Model, String> {
    MODELS.into_iter().find(|model| model.name() == name).ok_or(name)
}

/// A collision model, or whichever is recommended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ModelChoice {
    /// Time-stepped spring-dashpot contacts.
    Soft,
    /// Instantaneous collisions.
    Hard,
    /// Instantaneous collisions where two meet alone, spring-dashpot contacts elsewhere.
    Hybrid,
    /// What `plan` recommends for the case.
    Auto,
}

impl ModelChoice {
    /// The model itself; none where it is still to be chosen.
    pub fn model(self) -> Option<Model> {
        match self {
            Self::Soft => Some(Model::Soft),
            Self::Hard => Some(Model::Hard),
            Self::Hybrid => Some(Model::Hybrid),
            Self::Auto => None,
        }
    }
}

/// `diptych plan`.
#[derive(Clone, Debug, Args)]
pub struct Plan {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// Relative error that the recommendation is for, as 1% or 0.01 [-].
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

/// [-] a share between 0 and 1, as a number or in percent.
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

/// `diptych compare`.
#[derive(Clone, Debug, Args)]
pub struct Compare {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// Runs a fifteenth of the run on from its end, as set and at half the step and window, and reports what that changes;
    /// costs about a fifth of the run.
    #[arg(long)]
    pub verify: bool,
    /// Writes the particles every so often for ParaView, OVITO and ASE (trajectory/), such as --every "1 ms"; the same as
    /// --set output.every="1 ms". Windows end at these times too: where they would not have, the last digits of results change.
    #[arg(long, value_name = "TIME")]
    pub every: Option<String>,
    /// Differences smaller than this count as none, as 1% or 0.01 of the scale of each observable [-].
    #[arg(long, value_name = "SHARE", default_value = "1%", value_parser = relative_error)]
    pub margin: f64,
    /// Runs replicas of every variant in pieces of four, looks after each piece, and stops when every answer is "equivalent" or
    /// "different", or when --replicas of each (64 if it is not given) are used up. The chances of wrong answers hold for all looks together.
    #[arg(long)]
    pub until_decided: bool,
    /// Tells the answer by the exit code as well: 0 all equivalent, 3 some different, 4 some not resolved and none different.
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

/// `diptych resume`.
#[derive(Clone, Debug, Args)]
pub struct Resume {
    /// The folder of its results.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Threads to use; results are the same for any number [default: as it was started].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Shows no progress and no summary.
    #[arg(long)]
    pub quiet: bool,
}

/// `diptych check`.
#[derive(Clone, Debug, Args)]
pub struct Check {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// Prints what there is to say as JSON.
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub input: Input,
}

/// `diptych fluid`.
#[derive(Clone, Debug, Args)]
pub struct FluidArguments {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub output: Output,
}

/// `diptych impact`.
#[derive(Clone, Debug, Args)]
pub struct ImpactArguments {
    /// The case file, or the name of a built-in case: one or two spheres [default: impact].
    pub case: Option<PathBuf>,
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub output: Output,
}

/// `diptych chart`.
#[derive(Clone, Debug, Args)]
pub struct Chart {
    /// The case file, or the name of a built-in case: one impact, or many particles.
    pub case: PathBuf,
    /// Fewer values of each knob, and a tenth of the time for many particles.
    #[arg(long)]
    pub quick: bool,
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub output: Output,
}

/// `diptych limits`.
#[derive(Clone, Debug, Args)]
pub struct Limits {
    /// Coarser grids and shorter runs: some ten seconds on one core.
    #[arg(long)]
    pub quick: bool,
    /// One map only, by its name; may be repeated [default: all].
    #[arg(long, value_name = "MAP")]
    pub only: Vec<String>,
    /// Threads to use; results are the same for any number [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub output: Output,
}

/// `diptych sweep`.
#[derive(Clone, Debug, Args)]
pub struct Sweep {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// A key and its values, for example --sweep "soft.linear_spring_dashpot.stiffness=300 N/m,1 kN/m"; may be repeated: a grid
    /// [default: the case's [[sweep]] list].
    #[arg(long, value_name = "KEY=A,B,...")]
    pub sweep: Vec<String>,
    /// Only the variant of that name; may be repeated [default: all that `compare` would run].
    #[arg(long, value_name = "VARIANT")]
    pub only: Vec<String>,
    /// One run after the other, each with all threads, so that wall times can be compared [default: several at once, which share them].
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

/// `diptych sensitivity`.
#[derive(Clone, Debug, Args)]
pub struct Sensitivity {
    /// The case file, or the name of a built-in case.
    pub case: PathBuf,
    /// Only these factors, each with its size if it is not the usual one, as in --factors restitution=0.8,gas,box=0.25; there are
    /// model, stiffness, integrator, stepping, restitution, wall-restitution, friction, wall-friction, gas, drag, box and seed
    /// [default: all that the scene has].
    #[arg(long, value_name = "NAME[=SIZE],...", value_delimiter = ',')]
    pub factors: Vec<String>,
    /// A factor of your own: a key of the case at another value, such as --vary "particles[0].density=1100 kg/m^3"; may be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    pub vary: Vec<String>,
    /// The collision model of the case as it is, instead of the case's.
    #[arg(long, value_parser = PossibleValuesParser::new(MODELS.map(Model::name)).try_map(model_of))]
    pub model: Option<Model>,
    /// Simulated time of each run; the same as --set run.duration=TIME.
    #[arg(long, value_name = "TIME")]
    pub duration: Option<String>,
    /// Runs each of them from so many seeds (that of the case and the next ones) [default: 1, or 8 where averages over time mean
    /// nothing, as in a gas that cools].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub replicas: Option<u16>,
    /// Shifts smaller than this count as none, as 1% or 0.01 of the scale of each observable [-].
    #[arg(long, value_name = "SHARE", default_value = "1%", value_parser = relative_error)]
    pub margin: f64,
    /// Prints the factors, their sizes, the number of runs and about how long they take, and runs nothing else.
    #[arg(long)]
    pub plan: bool,
    /// Tells the answer by the exit code as well: 0 nothing is beyond the margin, 3 something is, 4 something is not resolved.
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

/// `diptych lab`.
#[cfg(feature = "lab")]
#[derive(Clone, Debug, Args)]
pub struct Lab {
    /// Port of this machine to serve the page at [default: any that is free].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub port: Option<u16>,
}

/// `diptych init`.
#[derive(Clone, Debug, Args)]
pub struct Init {
    /// Name of the built-in case, see `diptych cases`.
    pub name: String,
    /// File to write [default: the last part of NAME with .toml]; one that is there is never replaced.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// `diptych keys`.
#[derive(Clone, Debug, Args)]
pub struct Keys {
    /// Only this table and those within it, such as soft or walls.plane [default: all].
    pub table: Option<String>,
    /// Prints a JSON schema of a case for editors; with Even Better TOML: `#:schema diptych.schema.json` at the top of a case.
    #[arg(long, conflicts_with = "table")]
    pub schema: bool,
    /// Prints Markdown: the page docs/keys.md.
    #[arg(long, conflicts_with = "schema")]
    pub markdown: bool,
}

/// `diptych completions`.
#[derive(Clone, Debug, Args)]
pub struct Completions {
    /// The shell.
    pub shell: clap_complete::Shell,
}

/// `diptych man`.
#[derive(Clone, Debug, Args)]
pub struct Man {
    /// Only this command.
    pub command: Option<String>,
}
