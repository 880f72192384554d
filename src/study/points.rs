//! Independent points of a study, of which several run at once, with a progress display. A point is one or several runs
//! with one set of values.

use crate::runs::{StudyError, tell};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use std::io::{IsTerminal, stderr};
use std::time::Instant;

/// Runs the function `one` on all points of a study, several at once, and returns the results in the order of the
/// points. The results do not depend on the number of threads. `name` is displayed with the progress; nothing is
/// displayed if `quiet` is true.
///
/// # Errors
/// Returns the error of one of the points that fail.
pub fn run_points<P: Sync, R: Send>(
    name: &str,
    quiet: bool,
    points: &[P],
    one: impl Fn(&P) -> Result<R, StudyError> + Sync,
) -> Result<Vec<R>, StudyError> {
    let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(points.len() as u64) };
    // the default progress bar is used if the template is not valid
    if let Ok(style) = ProgressStyle::with_template("{bar:16} {pos} of {len} points, {eta} left  {wide_msg}") {
        bar.set_style(style);
    }
    bar.set_message(name.to_owned());
    let began = Instant::now();
    let each = points.par_iter().with_max_len(1).map(|point| {
        let result = one(point);
        bar.inc(1);
        result
    });
    let results = each.collect();
    bar.finish_and_clear();
    if !quiet && !stderr().is_terminal() {
        tell(format_args!("{name}: {} points in {:.1} s", points.len(), began.elapsed().as_secs_f64()));
    }
    results
}
