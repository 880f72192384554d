//! Slice averages (the paper's section 2.2) with standard errors.
//!
//! Components as in the paper: U, u streamwise (z); V, v wall-normal (y); W, w spanwise (x).

use crate::particles::Particles;

/// A value and its standard error, in the unit of the value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// One standard error; NaN when there are too few blocks to tell.
    pub error: f64,
}

/// Time averages in one slice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SliceRow {
    /// [m] centre of the slice.
    pub y: f64,
    /// [-] number density over the mean of the whole domain.
    pub number_density_ratio: Estimate,
    /// [m/s] U, V, W.
    pub mean: [Estimate; 3],
    /// [m²/s²] <u''u''>, <v''v''>, <w''w''>, <u''v''>, <u''w''>, <v''w''>.
    pub second: [Estimate; 6],
    /// [m³/s³] uuu, uuv, uuw, uvv, uvw, uww, vvv, vvw, vww, www.
    pub third: [Estimate; 10],
    /// Particles counted.
    pub samples: u64,
}

/// All slices, from y = 0 to the top of the domain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProfileTable {
    /// One row per slice.
    pub slices: Vec<SliceRow>,
    /// Blocks of time behind each standard error.
    pub blocks: usize,
    /// [s] averaging starts here.
    pub from: f64,
    /// [s] averaging ends here.
    pub until: f64,
}

/// Sums per slice and block.
#[derive(Clone, Debug)]
pub struct Accumulator {}

impl Accumulator {
    /// For `slices` slices of a domain of `height` [m] along y.
    pub fn new(slices: usize, height: f64) -> Self {
        let _ = (slices, height);
        Self {}
    }

    /// Takes one sample of all particles at simulated `time` [s].
    pub fn sample(&mut self, time: f64, particles: &Particles) {
        let _ = (time, particles);
    }

    /// Averages over the samples at `from` [s] and later.
    pub fn table(&self, from: f64) -> ProfileTable {
        let _ = from;
        ProfileTable::default()
    }
}
