//! Tasks of every command around its work: reading the case, preparing the folder, reporting.

pub use super::error::StudyError;
use super::ranks::Ranks;
use super::terminal::tell;
use crate::case::{Case, Checked, Diagnostic};
use crate::cli::{Effort, Input, Output};
use crate::engine::Failure;
use crate::experiment::Experiment;
use crate::memory;
use crate::outcome::Outcome;
use crate::output::{Folder, Provenance, figures};
use crate::particles::Particles;
use crate::placement::initial_state;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Reads the case of a command.
pub fn read(path: &Path, input: &Input) -> Result<Case, StudyError> {
    Ok(Case::read(path, &input.sets())?)
}

/// Folder of results of a command: the one asked for, or `out/<case>-<command>`.
pub fn place(output: &Output, case: &Path, command: &str) -> PathBuf {
    output.out.clone().unwrap_or_else(|| {
        let stem = case.file_stem().map_or("case".into(), |stem| stem.to_string_lossy());
        PathBuf::from(format!("out/{stem}-{command}"))
    })
}

/// Makes the folder of a command at its [`place`]. A folder that cannot be written to is bad input: nothing has been computed yet.
pub fn folder(output: &Output, case: &Path, command: &str) -> Result<Folder, StudyError> {
    make(place(output, case, command), output.overwrite)
}

/// Makes a folder for results.
pub fn make(path: PathBuf, overwrite: bool) -> Result<Folder, StudyError> {
    Folder::create(path, overwrite).map_err(|error| StudyError::Input(format!("error: {error}")))
}

/// Prints the warnings of all variants, each once.
pub fn warn(variants: &[Checked], quiet: bool) {
    let mut told: Vec<&Diagnostic> = Vec::new();
    for warning in variants.iter().flat_map(|(_, warnings)| warnings) {
        if !quiet && !told.contains(&warning) {
            tell(warning);
            told.push(warning);
        }
    }
}

/// Sets the number of threads for a process that may be one of several on this machine.
pub fn share_threads(effort: &Effort, ranks: &Ranks) -> Result<(), StudyError> {
    if ranks.count() == 1 {
        return use_threads(effort.threads.map(usize::from));
    }
    // the calling thread belongs to MPI
    let threads = ranks.threads(effort.threads);
    start_threads(threads, rayon::ThreadPoolBuilder::new().num_threads(threads))
}

/// Sets the number of threads for the whole process, if it is given. A single thread is the calling thread itself. If
/// it waited for another thread to do the work of each window, small scenes on a busy machine would mostly wait.
pub fn use_threads(threads: Option<usize>) -> Result<(), StudyError> {
    let Some(threads) = threads else { return Ok(()) };
    let mut pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    if threads == 1 {
        pool = pool.use_current_thread();
    }
    start_threads(threads, pool)
}

fn start_threads(threads: usize, pool: rayon::ThreadPoolBuilder) -> Result<(), StudyError> {
    pool.build_global().map_err(|why| {
        StudyError::Input(format!("error: cannot start {threads} threads: {why}\nhelp: lower --threads"))
    })
}

/// Provenance of the results; `scene`: description of the scene.
pub fn provenance(case: &Case, scene: String) -> Provenance {
    Provenance {
        title: case.title.clone(),
        case_path: case.path.display().to_string(),
        case_text: case.text.to_string(),
        command: command_line(),
        scene,
    }
}

/// The command as it was typed.
pub fn command_line() -> String {
    quoted(std::env::args_os())
}

/// A command line, quoted where a shell needs it.
pub fn quoted(arguments: impl IntoIterator<Item = OsString>) -> String {
    let quoted = arguments.into_iter().enumerate().map(|(k, argument)| {
        // the program by its name, without the path it was started from
        let argument = if k == 0 { "diptych".into() } else { argument.to_string_lossy().into_owned() };
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_=./,:+".contains(c);
        if !argument.is_empty() && argument.chars().all(plain) {
            argument
        } else {
            format!("'{}'", argument.replace('\'', "'\\''"))
        }
    });
    quoted.collect::<Vec<_>>().join(" ")
}

/// The initial state of one variant; a scene too crowded to start is bad input.
pub fn start(experiment: &Experiment) -> Result<Particles, StudyError> {
    refuse_too_large(experiment)?;
    initial_state(experiment).map_err(|crowded| StudyError::Input(format!("error: {crowded}")))
}

/// Refuses a run for which there is not enough memory, before any of it is taken.
///
/// # Errors
/// [`StudyError::Input`], with the memory that the run takes and the memory that there is.
pub fn refuse_too_large(experiment: &Experiment) -> Result<(), StudyError> {
    match memory::refusal(experiment) {
        None => Ok(()),
        Some((why, help)) => Err(StudyError::Input(format!("error: {why}\nhelp: {help}"))),
    }
}

/// Names of files for variants. They are the names of the variants, in letters that any system accepts, and all
/// different.
pub fn file_names<'a>(variants: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for variant in variants {
        let name = figures::file_name(variant);
        let taken = name.is_empty() || names.contains(&name);
        names.push(if taken { format!("{name}variant-{}", names.len()) } else { name });
    }
    names
}

/// Error of a command if some of its variants failed.
pub fn failures_of<'a>(variants: impl Iterator<Item = (&'a str, Option<&'a Failure>)>) -> Result<(), StudyError> {
    let failed: Vec<String> =
        variants.filter_map(|(name, why)| Some(format!("error: \"{name}\" stopped: {}", why?))).collect();
    if failed.is_empty() { Ok(()) } else { Err(StudyError::Failed(failed.join("\n"))) }
}

/// Error of a command if some of its outcomes failed.
pub fn failures(outcomes: &[Outcome]) -> Result<(), StudyError> {
    failures_of(outcomes.iter().map(|o| (o.experiment.name.as_str(), o.failure.as_ref())))
}
