//! Averages over time in the slices of the box, with standard errors, and their averages over several replicas (runs
//! with different seeds). A sample is an instant at which measurements are taken.

use super::batches::Batches;
use super::errors::Estimate;
use super::slice_columns::{SLICE_COLUMNS, SLICE_QUANTITIES, SliceColumn};
use serde::Serialize;

/// Averages over time in one slice of the box.
///
/// A slice without particles has number density 0 and no velocity moments, which are written as empty cells. Without
/// any measurement its number density is also unknown.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SliceRow {
    /// [m] height y of the middle of the slice.
    pub y: f64,
    /// Averages in the order of [`SLICE_COLUMNS`], in their SI units; `None` if unknown. The number density is that of
    /// particle centres, divided by its mean in the whole box. In a slice at a wall no centre is within one radius of
    /// the wall. The density is not corrected for this: for spheres of 0.406 mm, it is 20.3 % of a slice 1 mm thick.
    /// Moments are relative to the mean over the slice and the averaging period.
    pub estimates: [Option<Estimate>; SLICE_QUANTITIES],
    /// Number of particles counted in the slice, summed over all instants of measurement.
    pub samples: u64,
}

/// Averages over time in all slices, from y = 0 to the top of the box.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ProfileTable {
    /// Averages, one row per slice.
    pub slices: Vec<SliceRow>,
    /// Number of blocks of time from which each standard error is computed; with fewer than 8 blocks there are no
    /// errors.
    pub blocks: usize,
    /// [s] time of the first sample (instant of measurement) in the averages: the start of a whole block of time, at
    /// or after the requested start of averaging.
    pub from: f64,
    /// [s] time of the last sample (instant of measurement) in the averages.
    pub until: f64,
    /// Values of each average in blocks of time, by index of the slice, then of the column. `None` if the average or
    /// its error is unknown.
    #[serde(skip)]
    pub batches: Vec<Vec<Option<Batches>>>,
}

impl ProfileTable {
    /// Average of one quantity in one slice, with its values in successive blocks of time. `None` if the average or its
    /// error is unknown.
    pub fn batches(&self, slice: usize, column: SliceColumn) -> Option<&Batches> {
        self.batches.get(slice)?.get(column.index)?.as_ref()
    }

    /// Averages over several replicas (runs with different seeds). A value is unknown if it is unknown in one of the
    /// runs. The standard errors come from the blocks of all runs. If `by_runs` is true, or if an error is unknown in
    /// one of the runs, they come from the scatter between the runs (see [`Batches::pool`]).
    pub fn pool(runs: &[&Self], by_runs: bool) -> Self {
        let Some(first) = runs.first() else { return Self::default() };
        let batches = |slice: usize| -> Vec<Option<Batches>> {
            let one = |column: SliceColumn| {
                let known: Option<Vec<&Batches>> = runs.iter().map(|run| run.batches(slice, column)).collect();
                if let Some(known) = known {
                    return Batches::pool(&known, by_runs);
                }
                let value = |run: &&Self| Some(run.slices.get(slice)?.of(column)?.value);
                let values: Option<Vec<f64>> = runs.iter().map(value).collect();
                Some(Batches::of_runs(vec![values?]))
            };
            SLICE_COLUMNS.into_iter().map(one).collect()
        };
        let batches: Vec<Vec<Option<Batches>>> = (0..first.slices.len()).map(batches).collect();
        let row = |(slice, row): (usize, &SliceRow)| {
            let estimate = |index: usize| batches[slice][index].as_ref().and_then(|batches| batches.estimate());
            let samples = runs.iter().filter_map(|run| run.slices.get(slice)).map(|row| row.samples).sum();
            SliceRow { y: row.y, estimates: std::array::from_fn(estimate), samples }
        };
        let slices = first.slices.iter().enumerate().map(row).collect();
        let blocks = runs.iter().map(|run| run.blocks).sum();
        Self { slices, blocks, from: first.from, until: first.until, batches }
    }
}

impl SliceRow {
    /// Average of one quantity in this slice, in the SI unit of the quantity; `None` if it is unknown.
    pub fn of(&self, column: SliceColumn) -> Option<Estimate> {
        self.estimates[column.index]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs that are too short for errors of their own have a common mean, with an error from their scatter.
    #[test]
    fn short_runs_have_a_mean_and_an_error_together() {
        let run = |value: f64| {
            let mut estimates = [None; SLICE_QUANTITIES];
            estimates[0] = Some(Estimate::without_error(value));
            ProfileTable { slices: vec![SliceRow { y: 0.5, estimates, samples: 1 }], ..ProfileTable::default() }
        };
        let runs = [run(1.0), run(2.0), run(3.0)];
        let pooled = ProfileTable::pool(&runs.iter().collect::<Vec<_>>(), false);
        let [Some(first), None] = [pooled.slices[0].estimates[0], pooled.slices[0].estimates[1]] else { panic!() };
        assert!((first.value - 2.0).abs() < 1e-15 && (first.error.unwrap() - 3.0_f64.sqrt().recip()).abs() < 1e-12);
        let two = ProfileTable::pool(&[&runs[0], &runs[1]], false).slices[0].estimates[0].unwrap();
        assert_eq!((two.value, two.error), (1.5, None));
    }
}
