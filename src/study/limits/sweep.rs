//! One sweep (set of points from which maps are made): runs all of its points, and stores their results.

use crate::engine::Failure;
use crate::experiment::Experiment;
use crate::output::limits::{self, Picture};
use crate::runs::StudyError;
use crate::study::points::run_points;

/// Options for running the points of a sweep (set of points from which maps are made).
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// True if each map has fewer points and shorter runs.
    pub quick: bool,
    /// True if no progress is displayed.
    pub quiet: bool,
}

/// Options and base experiment of a sweep (set of points from which maps are made). The experiments of all points are
/// changed copies of the base experiment.
pub struct Points<'a> {
    /// Options for running the points.
    pub grid: &'a Grid,
    /// Name of the first map of the sweep, which is displayed with the progress.
    pub name: &'static str,
    /// Experiment of the case file of the sweep, of which each point changes a copy.
    pub base: Experiment,
}

/// Point of a map whose numbers are all known.
pub struct KnownPoint {
    /// Numbers of the point in the order of the columns of the map's table, each in the unit of its column.
    pub values: Vec<f64>,
    /// Failure of the first run of this point of the map that stopped early; `None` if no run stopped.
    pub failure: Option<Failure>,
}

/// Results of a sweep (set of points) for one of its maps.
pub struct MapSweep {
    /// Points of the map, in the order in which they are drawn.
    pub rows: Vec<limits::MapPoint>,
    /// Conclusion from the numbers of the map, as sentences.
    pub lesson: String,
    /// Picture of the map.
    pub picture: Picture,
}

impl MapSweep {
    /// Makes the results of a map from points without missing numbers.
    pub fn new(rows: Vec<KnownPoint>, lesson: String, picture: Picture) -> Self {
        let row = |row: KnownPoint| limits::MapPoint {
            values: row.values.into_iter().map(Some).collect(),
            failure: row.failure,
        };
        Self { rows: rows.into_iter().map(row).collect(), lesson, picture }
    }
}

impl Points<'_> {
    /// Returns `quick` if the user asked for fewer points and shorter runs, else `full`.
    pub fn choose<T>(&self, quick: T, full: T) -> T {
        if self.grid.quick { quick } else { full }
    }

    /// Copy of the experiment of the case file, changed by the function `change`.
    pub fn with(&self, change: impl FnOnce(&mut Experiment)) -> Experiment {
        let mut experiment = self.base.clone();
        change(&mut experiment);
        experiment
    }

    /// Runs all points of the sweep, several at once, and returns their results in the order of the points. The results
    /// do not depend on the number of threads.
    pub fn run<P: Sync, R: Send>(
        &self,
        points: &[P],
        one: impl Fn(&P) -> Result<R, StudyError> + Sync,
    ) -> Result<Vec<R>, StudyError> {
        run_points(self.name, self.grid.quiet, points, one)
    }
}
