//! Output of results as tables, pictures, pages and summaries.
//!
//! For each study, a file in `documents` turns the results into one `document` of sentences, tables, pictures and
//! numbers. Each format has one writer: [`csv`] for tables, [`figures`] for SVG pictures, `html` for the page, text for
//! a terminal, and JSON for the summary. The writers compute no physics. [`Folder`] writes each file completely or not
//! at all. Files use SI units; pictures and pages use SI prefixes.
//!
//! The functions `write_…` write a whole folder, with `summary.json` last. This file exists only if all files of the
//! report are complete. [`write_part`] writes the folder without the summary, after each variant of a comparison. A
//! variant is one of the experiments of a case.

mod chart;
pub mod csv;
mod document;
mod documents;
pub mod figures;
mod files;
mod files_study;
mod groups;
mod html;
mod impact;

pub mod limits;
pub mod numbers;
mod over_time;
pub mod panel;
mod player;
pub mod sensitivity;
mod state;
pub mod sweep;
mod trajectory;
mod trust;
mod validation;
mod verdict;

pub use chart::{
    ChartFailure, ChartMethod, ChartPoint, ChartQuantity, ChartSlope, ChartStudy, CostMeasure, CostSpread, PointError,
    cheapest,
};
pub use documents::{
    PlanDocument, budget_sentences, chart_answers, limits_answers, plan_json, plan_text, sweep_verdicts,
    validation_answers, write_chart, write_files_study, write_impact, write_limits, write_part, write_sensitivity,
    write_sensitivity_part, write_study, write_sweep, write_validation,
};
pub use files::{ASIDE, CHECKPOINT, COMMAND, FIGURES, Folder, SUMMARY, put};
pub use files_study::{FilesQuantity, FilesStudy, SideSummary};
pub use groups::references;

pub use impact::{Analytic, Bounce, BounceValues, ImpactStudy, ObliqueCurve, ObliqueStudy, PathPoint};
#[cfg(feature = "lab")]
pub(crate) use player::outlines;
pub use state::StateFile;
pub use trajectory::{TRAJECTORY, Trajectory};
pub use trust::{Expected, Halved, HalvedStep, Judgement, TrustCheck, TrustSheet, Verification};
pub use validation::{NotValidated, ValidationNumber, ValidationRow, ValidationRule, ValidationStudy, ValidationTier};
pub use verdict::{Basis, ObservedDifference, Verdict, overall};

use crate::observe::{Budgets, Frames};
use crate::outcome::Outcome;
use std::path::{Path, PathBuf};

/// Reason why results could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The folder contains results of another run.
    #[error("{} holds results already; name another folder with --out, or pass --overwrite to replace them", path.display())]
    Occupied {
        /// Path of the folder with the results.
        path: PathBuf,
    },
    /// The folder contains a run that was stopped before its end.
    #[error(
        "{} holds a run that was stopped before its end; go on with it by `diptych resume {}`, or name another folder with --out, or pass --overwrite to begin anew",
        path.display(), path.display()
    )]
    Unfinished {
        /// Path of the folder with the stopped run.
        path: PathBuf,
    },
    /// Another command is writing into the folder.
    #[error("another run is writing into {} at this moment; wait for its end, or name another folder with --out", path.display())]
    InUse {
        /// Path of the folder that is in use.
        path: PathBuf,
    },
    /// The operating system refused to write or read.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// Attempted action, as the words before the path in the error message.
        action: &'static str,
        /// Path of the file or folder that could not be written or read.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Other programs removed frames of a trajectory (files with the particles at one instant) from the folder during
    /// the run.
    #[error("{gone} of {frames} frames of the trajectory were removed during the run, the first is {}; its index lists the others", path.display())]
    Gone {
        /// Path of the first removed frame (file with the particles at one instant).
        path: PathBuf,
        /// Number of removed frames (files with the particles at one instant).
        gone: usize,
        /// Number of frames (files with the particles at one instant) that the run had written.
        frames: usize,
    },
    /// One of the processes that share the run could not write its file.
    #[error("process {process}: {why}")]
    OfProcess {
        /// Rank (number) of the process that could not write.
        process: usize,
        /// Error message of the process.
        why: String,
    },
    /// A table of results could not be encoded as CSV.
    #[error("cannot encode a table: {0}")]
    Csv(#[from] ::csv::Error),
    /// The summary could not be encoded as JSON.
    #[error("cannot encode the summary: {0}")]
    Json(#[from] serde_json::Error),
}

impl OutputError {
    pub(crate) fn io(action: &'static str, path: &Path, source: std::io::Error) -> Self {
        Self::Io { action, path: path.to_owned(), source }
    }
}

/// Data needed to reproduce the results of a command.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// Title of the case, in one line.
    pub title: String,
    /// Path of the case file.
    pub case_path: String,
    /// Text of the case file as it was read.
    pub case_text: String,
    /// Command line that computed the results.
    pub command: String,
    /// Description of the scene, in words.
    pub scene: String,
}

/// All results of a run or a comparison.
#[derive(Clone, Copy, Debug)]
pub struct Study<'a> {
    /// Origin of the results: title, case file and command line.
    pub provenance: &'a Provenance,
    /// Results of the runs: one [`Outcome`] per variant (experiment of a case).
    pub outcomes: &'a [Outcome],
    /// All parameters of each variant (experiment of a case) in SI, in the order of the variants.
    pub parameters: &'a [serde_json::Value],
    /// Answers in sentences: first those of the comparisons between variants (experiments of a case), then further
    /// findings. The page begins with the first of these sentences.
    pub verdicts: &'a [String],
    /// Comparisons of variants (experiments of a case), each with its reference variant; empty for a single run.
    pub comparisons: &'a [Verdict],
    /// Settings that distinguish each variant (experiment of a case) from the others, as typed in the case. An empty
    /// text means no settings.
    pub overrides: &'a [String],
    /// Remarks on how far the numbers are reliable, one sentence each.
    pub notes: &'a [String],
    /// Checks of the results: one sheet (list of checks) per variant (experiment of a case), in the order of the
    /// variants.
    pub trust: &'a [TrustSheet],
    /// Recorded motion of the particles for animations, in the order of the variants (experiments of a case). Empty
    /// without animations.
    pub frames: &'a [Frames],
    /// Budgets of a single run: rates at which single processes, such as drag, change the second moments of velocity
    /// (means of products of two fluctuations). `None` unless the user asks for budgets.
    pub budgets: Option<&'a Budgets>,
}

/// [s] wall time of a run below which costs are not compared. Work that is done once, such as the start of threads,
/// takes milliseconds and would distort the ratio of two short times.
pub const TELLING: f64 = 0.1;

/// [s/s] wall-clock time per simulated time of a run whose cost is compared with that of others. `None` if the run
/// stopped early, since its cost is not that of the whole case, and if it took less than [`TELLING`].
pub fn ranked_cost(outcome: &Outcome) -> Option<f64> {
    let is_ranked = outcome.failure.is_none() && outcome.timing.wall_seconds >= TELLING;
    cost(outcome).filter(|_| is_ranked)
}

/// [s/s] wall-clock time per simulated time; `None` if nothing was simulated.
pub fn cost(outcome: &Outcome) -> Option<f64> {
    (outcome.simulated_seconds > 0.0).then(|| outcome.timing.wall_seconds / outcome.simulated_seconds)
}
