//! One sweep: runs all of its points, and holds what they come to.

use crate::engine::Failure;
use crate::experiment::Experiment;
use crate::output::limits::{self, Picture};
use crate::study::session::StudyError;
use crate::study::terminal::tell;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use std::io::{IsTerminal, stderr};
use std::time::Instant;

/// How points are run.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Coarser grids, shorter runs.
    pub quick: bool,
    /// No progress.
    pub quiet: bool,
}

/// What a sweep starts from.
pub struct Points<'a> {
    /// How points are run.
    pub grid: &'a Grid,
    /// Name of its first map, for the progress.
    pub name: &'static str,
    /// The experiment of its case file, of which every point changes something.
    pub base: Experiment,
}

/// One point of which every number is known.
pub struct KnownPoint {
    /// The numbers in the order of the columns, each in the unit of its column.
    pub values: Vec<f64>,
    /// Why it stopped, if it did: of several runs the first that did.
    pub failure: Option<Failure>,
}

/// What a sweep found for one map.
pub struct MapSweep {
    /// The points, in the order in which they are drawn.
    pub rows: Vec<limits::MapPoint>,
    /// What is to be learnt, from the numbers.
    pub lesson: String,
    /// How it is drawn.
    pub picture: Picture,
}

impl MapSweep {
    /// Of points of which every number is known.
    pub fn new(rows: Vec<KnownPoint>, lesson: String, picture: Picture) -> Self {
        let row = |row: KnownPoint| limits::MapPoint {
            values: row.values.into_iter().map(Some).collect(),
            failure: row.failure,
        };
        Self { rows: rows.into_iter().map(row).collect(), lesson, picture }
    }
}

impl Points<'_> {
    /// The first of these in the quick grid, the second in the full one.
    pub fn choose<T>(&self, quick: T, full: T) -> T {
        if self.grid.quick { quick } else { full }
    }

    /// The experiment of the case file with a change.
    pub fn with(&self, change: impl FnOnce(&mut Experiment)) -> Experiment {
        let mut experiment = self.base.clone();
        change(&mut experiment);
        experiment
    }

    /// Runs all points, several at once, and gives their results in the order of the points, whatever thread ran them.
    pub fn run<P: Sync, R: Send>(
        &self,
        points: &[P],
        one: impl Fn(&P) -> Result<R, StudyError> + Sync,
    ) -> Result<Vec<R>, StudyError> {
        let bar = if self.grid.quiet { ProgressBar::hidden() } else { ProgressBar::new(points.len() as u64) };
        // a template that does not parse would only lose its looks
        if let Ok(style) = ProgressStyle::with_template("{bar:16} {pos} of {len} points, {eta} left  {wide_msg}") {
            bar.set_style(style);
        }
        bar.set_message(self.name);
        let began = Instant::now();
        let each = points.par_iter().with_max_len(1).map(|point| {
            let result = one(point);
            bar.inc(1);
            result
        });
        let results = each.collect();
        bar.finish_and_clear();
        if !self.grid.quiet && !stderr().is_terminal() {
            tell(format_args!("{}: {} points in {:.1} s", self.name, points.len(), began.elapsed().as_secs_f64()));
        }
        results
    }
}
