//! Averages over time in slices, with their standard errors, and several runs of one variant taken together.

use super::batches::Batches;
use super::errors::Estimate;
use super::profiles::SUMS;
use serde::Serialize;

/// Time averages in one slice.
///
/// A slice that no particle visited has number density 0 and no velocity moments; they are written as empty cells.
/// Without any sample at all there is no number density either.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SliceRow {
    /// [m] centre of the slice.
    pub y: f64,
    /// [-] number density over the mean of the whole domain, by particle centres. The slices at walls are not corrected
    /// for the strip of one radius that no centre can enter (20.3 % of a 1 mm slice for spheres of 406 um).
    pub number_density_ratio: Option<Estimate>,
    /// [m/s] U, V, W.
    pub mean: [Option<Estimate>; 3],
    /// [m²/s²] <u''u''>, <v''v''>, <w''w''>, <u''v''>, <u''w''>, <v''w''>; about the mean over slice and time.
    pub second: [Option<Estimate>; 6],
    /// [m³/s³] uuu, uuv, uuw, uvv, uvw, uww, vvv, vvw, vww, www.
    pub third: [Option<Estimate>; 10],
    /// Number of particles counted, over all samples.
    pub samples: u64,
}

/// All slices, from y = 0 to the top of the domain.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ProfileTable {
    /// One row per slice.
    pub slices: Vec<SliceRow>,
    /// Number of blocks of time for each standard error; fewer than 8 give none.
    pub blocks: usize,
    /// [s] time of the first sample averaged: the first block that starts at the requested start of averaging or later.
    pub from: f64,
    /// [s] time of the last sample averaged.
    pub until: f64,
    /// Blocks of time of each estimate in each slice, in the order of the row. From 0 stands the number density ratio,
    /// from 1 the means, from 4 the second, from 10 the third moments. `None` if there is no value or no error.
    #[serde(skip)]
    pub batches: Vec<Vec<Option<Batches>>>,
}

impl ProfileTable {
    /// The blocks of one estimate of a slice; the index `which` is as in [`Self::batches`].
    pub fn batches(&self, slice: usize, which: usize) -> Option<&Batches> {
        self.batches.get(slice)?.get(which)?.as_ref()
    }

    /// Averages of several runs of one variant as one: means over the runs, with errors from the blocks of all of them.
    /// A value that is missing in one run is unknown. `by_runs`: as for [`Batches::pool`].
    pub fn pool(runs: &[&Self], by_runs: bool) -> Self {
        let Some(first) = runs.first() else { return Self::default() };
        let batches = |slice: usize| -> Vec<Option<Batches>> {
            let one = |which: usize| {
                let known: Option<Vec<&Batches>> = runs.iter().map(|run| run.batches(slice, which)).collect();
                Batches::pool(&known?, by_runs)
            };
            (0..SUMS).map(one).collect()
        };
        let batches: Vec<Vec<Option<Batches>>> = (0..first.slices.len()).map(batches).collect();
        let row = |(slice, row): (usize, &SliceRow)| {
            let estimate = |which: usize| batches[slice][which].as_ref().and_then(|batches| batches.estimate());
            let samples = runs.iter().filter_map(|run| run.slices.get(slice)).map(|row| row.samples).sum();
            SliceRow { samples, ..SliceRow::new(row.y, estimate) }
        };
        let slices = first.slices.iter().enumerate().map(row).collect();
        let blocks = runs.iter().map(|run| run.blocks).sum();
        Self { slices, blocks, from: first.from, until: first.until, batches }
    }
}

impl SliceRow {
    /// A row from its estimates in their order; without the number of samples.
    pub(super) fn new(y: f64, estimate: impl Fn(usize) -> Option<Estimate>) -> Self {
        Self {
            y,
            number_density_ratio: estimate(0),
            mean: std::array::from_fn(|i| estimate(1 + i)),
            second: std::array::from_fn(|k| estimate(4 + k)),
            third: std::array::from_fn(|k| estimate(10 + k)),
            samples: 0,
        }
    }
}
