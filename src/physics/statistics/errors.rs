//! Standard errors of averages of correlated samples.
//!
//! Samples are merged into blocks of time, and the scatter of the block means gives the error (blocking). In a run
//! that is short in units of its relaxation time, the block means are still correlated. The error by plain blocking is
//! then too small (by half, for a run of 10 relaxation times). The functions in this file measure the correlation
//! between neighbouring blocks, correct it for its known bias in short series, and enlarge the error accordingly. The
//! error by plain blocking remains a lower limit.

use serde::{Deserialize, Serialize};

/// Smallest number of blocks (or samples) from which a standard error is computed. With fewer blocks, their correlation
/// cannot be measured.
pub const FEWEST_BLOCKS: usize = 8;
/// Smallest number of blocks into which a long series is merged; the number of blocks is always less than twice this
/// number. More blocks would resolve fast noise, but miss slow fluctuations. Fewer blocks would be too few data for an
/// estimate.
const BLOCKS: usize = 20;
/// [-] upper limit of the correlation between neighbouring blocks; a higher measured value is replaced by this limit. A
/// series with a higher correlation is a single slow fluctuation.
pub(super) const LARGEST_CORRELATION: f64 = 0.9;

/// Value of a quantity and its standard error, both in the unit of the quantity.
///
/// Functions return `None` instead of an estimate if there is no sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Estimated value of the quantity.
    pub value: f64,
    /// Standard error of the value; `None` if it is unknown, for example with fewer than 8 blocks.
    pub error: Option<f64>,
}

impl Estimate {
    /// Creates an estimate from a value and its standard error.
    pub fn new(value: f64, error: f64) -> Self {
        Self { value, error: Some(error) }
    }

    /// Creates an estimate from a value whose standard error is unknown.
    pub fn without_error(value: f64) -> Self {
        Self { value, error: None }
    }

    /// Creates an estimate from a value that is known exactly: its standard error is 0.
    pub fn exact(value: f64) -> Self {
        Self { value, error: Some(0.0) }
    }

    /// Mean of independent estimates of one number, with its standard error. The error is unknown if one of the
    /// estimates has none. `None` without estimates, or if one of them is `None`.
    pub fn mean_of(estimates: impl Iterator<Item = Option<Self>>) -> Option<Self> {
        let all: Vec<Self> = estimates.collect::<Option<_>>()?;
        let count = all.len() as f64;
        let errors: Option<Vec<f64>> = all.iter().map(|one| one.error).collect();
        let square = errors.map(|errors| errors.iter().map(|error| error * error).sum::<f64>());
        let value = all.iter().map(|one| one.value).sum::<f64>() / count;
        (!all.is_empty()).then(|| Self { value, error: square.map(|sum| sum.sqrt() / count) })
    }

    /// Estimate multiplied by a factor that is known exactly.
    pub fn times(self, factor: f64) -> Self {
        Self { value: self.value * factor, error: self.error.map(|error| error * factor) }
    }

    /// Estimate divided by a divisor that is known exactly.
    pub fn over(self, divisor: f64) -> Self {
        Self { value: self.value / divisor, error: self.error.map(|error| error / divisor) }
    }

    /// This estimate minus another estimate. The two estimates must be independent.
    pub fn less(self, other: Self) -> Self {
        let error = self.error.zip(other.error).map(|(one, other)| one.hypot(other));
        Self { value: self.value - other.value, error }
    }

    /// True if the value is at most two standard errors from 0, so that differences should not be divided by it. False
    /// if the error is unknown.
    pub fn is_zero_within_error(self) -> bool {
        self.error.is_some_and(|error| self.value.abs() <= 2.0 * error)
    }

    /// [-] value divided by its standard error; `None` if the error is unknown or 0.
    pub fn in_errors(self) -> Option<f64> {
        self.error.filter(|error| *error > 0.0).map(|error| self.value / error)
    }
}

/// Mean of equally spaced samples in the order of time. Its standard error takes the correlation of the samples into
/// account.
///
/// `None` without a sample, or if the mean is not finite. With fewer than 8 samples the standard error is unknown.
pub fn estimate(samples: &[f64]) -> Option<Estimate> {
    let value = mean(samples);
    value.is_finite().then(|| Estimate { value, error: standard_error(samples, Removed::Mean) })
}

/// Number of pieces that are merged into each block, if a series of `count` equal pieces is divided into 20 to 39
/// blocks. Callers leave out pieces that do not fill a block, at the beginning of the series.
pub(super) fn block_size(count: usize) -> usize {
    (count / BLOCKS).max(1)
}

/// Arithmetic mean of the values; NaN without values.
pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Fit that has been subtracted from a series before its scatter is measured.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Removed {
    /// The mean of the series has been subtracted.
    Mean,
    /// A parabola fitted to the series has been subtracted, so that a drift does not count as noise in the test for
    /// drift.
    Parabola,
}

/// Standard error of the mean of a series in the order of time. A long series is first merged into blocks. With
/// [`Removed::Parabola`] the values must be the residuals of a fitted parabola. `None` for fewer than 8 values, or if a
/// value is not finite.
pub(super) fn standard_error(values: &[f64], removed: Removed) -> Option<f64> {
    if values.len() < FEWEST_BLOCKS || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let size = block_size(values.len());
    let mut blocks: Vec<f64> = values[values.len() % size..].chunks_exact(size).map(mean).collect();
    let mut variance = corrected_variance(&blocks, removed);
    while blocks.len() >= 2 * FEWEST_BLOCKS {
        blocks = blocks[blocks.len() % 2..].chunks_exact(2).map(mean).collect();
        variance = variance.max(plain_variance(&blocks));
    }
    Some(variance.sqrt())
}

/// Variance of the mean of all blocks, on the assumption that blocks are uncorrelated. `blocks` are the means of
/// successive pieces of a series.
fn plain_variance(blocks: &[f64]) -> f64 {
    let (count, centre) = (blocks.len() as f64, mean(blocks));
    blocks.iter().map(|b| (b - centre).powi(2)).sum::<f64>() / (count - 1.0) / count
}

/// Variance of the mean of all blocks, on the assumption that their correlation decays exponentially. `blocks` are the
/// means of successive pieces of a series, and `removed` is the fit that has been subtracted from it.
fn corrected_variance(blocks: &[f64], removed: Removed) -> f64 {
    let (count, centre) = (blocks.len() as f64, mean(blocks));
    let scatter: f64 = blocks.iter().map(|b| (b - centre).powi(2)).sum();
    if scatter == 0.0 {
        return 0.0;
    }
    let neighbours: f64 = blocks.windows(2).map(|pair| (pair[0] - centre) * (pair[1] - centre)).sum();
    // in a short series with the correlation rho the measured correlation is too low by about (1 + 4 rho)/count,
    // because the mean is computed from the same series (Marriott and Pope 1954). With three fitted coefficients the
    // bias is three times as large
    let bias = if removed == Removed::Parabola { 3.0 } else { 1.0 };
    let correlation =
        ((count * neighbours / scatter + bias) / (count - 4.0 * bias).max(1.0)).clamp(0.0, LARGEST_CORRELATION);
    let factor = inflation(correlation, blocks.len());
    // the mean follows slow fluctuations, so the scatter about the mean is smaller than the true variance of a block
    let seen = (1.0 - factor / count).max(0.05) * count;
    scatter / seen * factor / count
}

/// [-] variance of the mean of `count` blocks divided by that of independent blocks. `correlation` [-] is that of
/// neighbouring blocks. The signal is assumed to be exponentially correlated.
pub(super) fn inflation(correlation: f64, count: usize) -> f64 {
    let decay = decay(correlation);
    let (mut factor, mut power) = (1.0, correlation);
    for lag in 1..count {
        factor += 2.0 * (1.0 - lag as f64 / count as f64) * power;
        power *= decay;
    }
    factor
}

/// [-] ratio by which the correlation of block means decreases from one lag to the next, beyond the first lag. The
/// signal is assumed to be exponentially correlated; `correlation` [-] is that of neighbouring blocks. The ratio is
/// smaller than `correlation`, since neighbouring blocks also share fluctuations across their border.
fn decay(correlation: f64) -> f64 {
    // with blocks of b relaxation times the correlation is (1 - exp(-b))^2 / 2(b - 1 + exp(-b)), which falls with b
    let (mut short, mut long) = (1e-3_f64, 1e3_f64);
    for _ in 0..50 {
        let b = (short * long).sqrt();
        let left = -(-b).exp_m1();
        if left * left > 2.0 * correlation * (b - left) {
            short = b;
        } else {
            long = b;
        }
    }
    (-short).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::two_sided;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Exponentially correlated noise of unit variance with the relaxation time `relaxation` [samples], plus white
    /// noise with the standard deviation `white` [-].
    fn noise(count: usize, relaxation: f64, white: f64, random: &mut Xoshiro256PlusPlus) -> Vec<f64> {
        let mut normal = || -> f64 { StandardNormal.sample(random) };
        let rho = if relaxation > 0.0 { (-1.0 / relaxation).exp() } else { 0.0 };
        let mut slow = normal();
        (0..count)
            .map(|_| {
                let value = slow + white * normal();
                slow = rho * slow + (1.0 - rho * rho).sqrt() * normal();
                value
            })
            .collect()
    }

    fn exact(count: usize, relaxation: f64, white: f64) -> f64 {
        let rho: f64 = if relaxation > 0.0 { (-1.0 / relaxation).exp() } else { 0.0 };
        let n = count as f64;
        let sum: f64 = (1..count).map(|k| 2.0 * (1.0 - k as f64 / n) * rho.powi(k as i32)).sum();
        ((1.0 + white * white + sum) / n).sqrt()
    }

    /// Ratio of the estimated to the exact standard error, averaged over `size` series. The second number is the share
    /// of the series whose mean deviates by more than 3 standard errors.
    fn trial(count: usize, relaxation: f64, white: f64, size: usize) -> (f64, f64) {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
        let exact = exact(count, relaxation, white);
        let (mut ratio, mut beyond) = (0.0, 0.0);
        for _ in 0..size {
            let found = estimate(&noise(count, relaxation, white, &mut random)).unwrap();
            let error = found.error.unwrap();
            ratio += error / exact;
            beyond += f64::from(found.value.abs() > 3.0 * error);
        }
        (ratio / size as f64, beyond / size as f64)
    }

    #[test]
    fn errors_of_correlated_series_are_right_and_not_low() {
        // run of 480 samples; relaxation times of 0, 1 %, 3 % and 7 % of the run, with and without additional white
        // noise
        for (relaxation, white) in
            [(0.0, 0.0), (4.8, 0.0), (4.8, 3.0), (16.0, 0.0), (16.0, 3.0), (32.0, 0.0), (32.0, 3.0)]
        {
            let (ratio, beyond) = trial(480, relaxation, white, 2000);
            println!(
                "relaxation {relaxation}, white {white}: error {ratio:.3} of exact, {:.2} % beyond 3",
                100.0 * beyond
            );
            // the run contains only 15 slow fluctuations, so the estimated error may exceed the exact error
            let high = if relaxation > 30.0 { 1.30 } else { 1.15 };
            assert!((0.97..=high).contains(&ratio), "relaxation {relaxation}, white {white}: {ratio}");
            let expected = two_sided(3.0, 8.0);
            assert!(beyond < 2.0 * expected, "relaxation {relaxation}: {beyond} beyond 3 errors, t gives {expected}");
        }
    }

    #[test]
    fn short_series_say_that_nothing_is_known() {
        assert_eq!(estimate(&[]), None);
        assert_eq!(estimate(&[3.0]), Some(Estimate::without_error(3.0)));
        assert_eq!(estimate(&[3.0; 7]), Some(Estimate::without_error(3.0)));
        assert_eq!(estimate(&[3.0; 8]), Some(Estimate::exact(3.0)));
        let mut broken = [1.0; 30];
        broken[4] = f64::NAN;
        assert_eq!(estimate(&broken), None);
    }
}
