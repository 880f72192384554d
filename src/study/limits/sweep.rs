//! One sweep of a map: runs all of its points, and stores their results.

use crate::engine::Failure;
use crate::experiment::Experiment;
use crate::output::limits::{self, Picture};
use crate::runs::StudyError;
use crate::study::points::run_points;

/// Options for running the points of a sweep.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// True for coarser grids and shorter runs.
    pub quick: bool,
    /// True to hide the progress.
    pub quiet: bool,
}

/// Options and base experiment of a sweep, from which its points are made.
pub struct Points<'a> {
    /// Options for running the points.
    pub grid: &'a Grid,
    /// Name of the first map of the sweep, for the progress display.
    pub name: &'static str,
    /// Experiment of the case file of the sweep. Each point changes a part of a copy.
    pub base: Experiment,
}

/// Point of a map all of whose numbers are known.
pub struct KnownPoint {
    /// Numbers in the order of the columns, each in the unit of its column.
    pub values: Vec<f64>,
    /// Failure of the first run of the point that stopped; `None` if none did.
    pub failure: Option<Failure>,
}

/// Results of a sweep for one map.
pub struct MapSweep {
    /// The points of the map, in the order in which they are drawn.
    pub rows: Vec<limits::MapPoint>,
    /// Conclusion from the numbers, in words.
    pub lesson: String,
    /// Picture of the map.
    pub picture: Picture,
}

impl MapSweep {
    /// Makes a map from points without missing numbers.
    pub fn new(rows: Vec<KnownPoint>, lesson: String, picture: Picture) -> Self {
        let row = |row: KnownPoint| limits::MapPoint {
            values: row.values.into_iter().map(Some).collect(),
            failure: row.failure,
        };
        Self { rows: rows.into_iter().map(row).collect(), lesson, picture }
    }
}

impl Points<'_> {
    /// Returns `quick` for the coarse grid, `full` for the full one.
    pub fn choose<T>(&self, quick: T, full: T) -> T {
        if self.grid.quick { quick } else { full }
    }

    /// Copy of the experiment of the case file, after the change `change`.
    pub fn with(&self, change: impl FnOnce(&mut Experiment)) -> Experiment {
        let mut experiment = self.base.clone();
        change(&mut experiment);
        experiment
    }

    /// Runs all points, several at once, and returns their results in the order of the points. The results do not
    /// depend on the threads.
    pub fn run<P: Sync, R: Send>(
        &self,
        points: &[P],
        one: impl Fn(&P) -> Result<R, StudyError> + Sync,
    ) -> Result<Vec<R>, StudyError> {
        run_points(self.name, self.grid.quiet, points, one)
    }
}
