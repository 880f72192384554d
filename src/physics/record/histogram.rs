//! A histogram whose range grows with the largest value.

use crate::exact::{ExactSum, add_rows};
use serde::{Deserialize, Serialize};

/// Number of bins. If a value lies beyond the last bin, the range doubles and neighbouring bins are merged in pairs.
const BINS: usize = 512;

/// Histogram of a non-negative quantity, with bins of equal width that begin at 0. The width is the smallest power of
/// two for which the bins contain the largest value, so the result does not depend on the order of the values. The
/// width doubles when a value lies beyond the last bin. Numbers are in the unit of the quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Histogram {
    /// Width of a bin, in the unit of the values; 0 before the first positive value.
    pub width: f64,
    /// Number of values in each bin.
    pub counts: Vec<u64>,
    /// Number of values that were counted, over all bins.
    pub total: u64,
    /// Largest value that was counted, in the unit of the values; 0 before the first value.
    pub maximum: f64,
    /// Exact sum of all values that were counted.
    sum: Box<ExactSum>,
    /// Exact sum of the squares of all values that were counted.
    sum_of_squares: Box<ExactSum>,
}

impl Default for Histogram {
    fn default() -> Self {
        Self {
            width: 0.0,
            counts: vec![0; BINS],
            total: 0,
            maximum: 0.0,
            sum: Box::default(),
            sum_of_squares: Box::default(),
        }
    }
}

impl Histogram {
    /// Counts one value. A negative value counts as 0; a value that is not finite is ignored.
    pub fn add(&mut self, value: f64) {
        if self.place(value) {
            self.sum.add(value);
            self.sum_of_squares.add(value * value);
        }
    }

    /// Counts several values, with the result of [`add`](Self::add) for each value.
    pub fn add_all(&mut self, mut values: impl Iterator<Item = f64>) {
        /// Number of values that are collected before one call adds all of them to the exact sums.
        const ROWS: usize = 32;
        let mut rows = [[0.0; 2]; ROWS];
        loop {
            let mut count = 0;
            for value in values.by_ref() {
                if self.place(value) {
                    rows[count] = [value, value * value];
                    count += 1;
                }
                if count == ROWS {
                    break;
                }
            }
            add_rows([&mut self.sum, &mut self.sum_of_squares], &rows[..count]);
            if count < ROWS {
                return;
            }
        }
    }

    /// Counts a value in its bin. Returns true for a positive finite value, which must also be added to the sums.
    fn place(&mut self, value: f64) -> bool {
        if !value.is_finite() {
            return false;
        }
        self.total += 1;
        if value <= 0.0 {
            self.counts[0] += 1;
            return false;
        }
        if value > self.maximum {
            self.maximum = value;
            if self.width == 0.0 {
                // the largest power of two that is not above value / BINS, and at least the smallest normal number
                let below = f64::from_bits((value / BINS as f64).to_bits() & f64::INFINITY.to_bits());
                self.width = below.max(f64::MIN_POSITIVE);
            }
            while value >= self.width * BINS as f64 {
                self.widen();
            }
        }
        self.counts[((value / self.width) as usize).min(BINS - 1)] += 1;
        true
    }

    /// Adds the counts and sums of another histogram of the same quantity.
    pub fn merge(&mut self, other: &Self) {
        let mut other = other.clone();
        if self.width == 0.0 || other.width == 0.0 {
            // values of 0 are in the first bin, whatever the width
            self.width = self.width.max(other.width);
            other.width = self.width;
        }
        while self.width < other.width {
            self.widen();
        }
        while other.width < self.width {
            other.widen();
        }
        self.counts.iter_mut().zip(&other.counts).for_each(|(count, other)| *count += other);
        self.total += other.total;
        self.maximum = self.maximum.max(other.maximum);
        self.sum.merge(&other.sum);
        self.sum_of_squares.merge(&other.sum_of_squares);
    }

    /// Sum of all values, rounded to double precision.
    pub fn sum(&self) -> f64 {
        self.sum.value()
    }

    /// Sum of the squares of all values, rounded to double precision.
    pub fn sum_of_squares(&self) -> f64 {
        self.sum_of_squares.value()
    }

    /// Doubles the range: makes the bins twice as wide and merges neighbouring bins in pairs.
    fn widen(&mut self) {
        for k in 0..BINS / 2 {
            self.counts[k] = self.counts[2 * k] + self.counts[2 * k + 1];
        }
        self.counts[BINS / 2..].fill(0);
        self.width *= 2.0;
    }

    /// Histogram of the values that were added after `before` was copied from this histogram. Its maximum is too large
    /// by up to the width of a bin, unless the largest of all values is among these values.
    pub fn since(&self, before: &Self) -> Self {
        let mut past = before.clone();
        while past.width > 0.0 && past.width < self.width {
            past.widen();
        }
        let counts: Vec<u64> = self.counts.iter().zip(&past.counts).map(|(all, past)| all - past).collect();
        let last = counts.iter().rposition(|&count| count > 0);
        Self {
            width: self.width,
            total: self.total - before.total,
            maximum: last.map_or(0.0, |last| self.maximum.min((last + 1) as f64 * self.width)),
            counts,
            sum: Box::new(self.sum.less(&before.sum)),
            sum_of_squares: Box::new(self.sum_of_squares.less(&before.sum_of_squares)),
        }
    }

    /// Mean of the values; `None` without values.
    pub fn mean(&self) -> Option<f64> {
        (self.total > 0).then(|| self.sum() / self.total as f64)
    }

    /// Largest value; `None` without values.
    pub fn largest(&self) -> Option<f64> {
        (self.total > 0).then_some(self.maximum)
    }

    /// Standard error of the mean for independent values: their standard deviation divided by the square root of their
    /// number. `None` for fewer than two values.
    pub fn standard_error(&self) -> Option<f64> {
        if self.total < 2 {
            return None;
        }
        let mean = self.mean()?;
        let variance = self.sum_of_squares() / self.total as f64 - mean * mean;
        Some((variance.max(0.0) / (self.total - 1) as f64).sqrt())
    }

    /// Value below which the fraction `q` [-] of the values lies, interpolated linearly within a bin; `None` without
    /// values.
    pub fn quantile(&self, q: f64) -> Option<f64> {
        if self.total == 0 {
            return None;
        }
        let wanted = q.clamp(0.0, 1.0) * self.total as f64;
        let mut below = 0.0;
        for (k, &count) in self.counts.iter().enumerate() {
            if count > 0 && below + count as f64 >= wanted {
                let inside = (wanted - below) / count as f64;
                return Some(((k as f64 + inside) * self.width).min(self.maximum));
            }
            below += count as f64;
        }
        Some(self.maximum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_and_moments_are_those_of_the_values() {
        let mut histogram = Histogram::default();
        // the smallest value is added first, so the range must double several times
        for k in 1..=100_000 {
            histogram.add(f64::from(k) * 1e-3);
        }
        assert_eq!(histogram.total, 100_000);
        assert_eq!(histogram.counts.iter().sum::<u64>(), 100_000);
        assert!((histogram.mean().unwrap() - 50.0005).abs() < 1e-9);
        assert_eq!(histogram.maximum, 100.0);
        // a uniform distribution from 0 to 100 has the standard deviation 100/sqrt(12)
        assert!((histogram.standard_error().unwrap() / (100.0 / 12f64.sqrt() / 100_000f64.sqrt()) - 1.0).abs() < 1e-4);
        for q in [0.01, 0.5, 0.9, 0.99] {
            assert!((histogram.quantile(q).unwrap() - 100.0 * q).abs() < 0.01 * histogram.width + 1e-3, "{q}");
        }
        assert_eq!(histogram.quantile(1.0), Some(100.0));
        assert_eq!(histogram.quantile(7.0), Some(100.0));
    }

    #[test]
    fn doubling_keeps_every_value_in_its_place() {
        let mut histogram = Histogram::default();
        let values: Vec<f64> = (0..400).map(|k| 1.1_f64.powi(k % 100)).collect();
        values.iter().for_each(|&v| histogram.add(v));
        assert_eq!(histogram.width.log2().fract(), 0.0);
        for (k, &count) in histogram.counts.iter().enumerate() {
            let (low, high) = (k as f64 * histogram.width, (k + 1) as f64 * histogram.width);
            assert_eq!(count, values.iter().filter(|&&v| low <= v && v < high).count() as u64, "bin {k}");
        }
        // the range is at most twice the largest value
        assert!(histogram.maximum >= 0.5 * histogram.width * BINS as f64);
    }

    #[test]
    fn what_came_later_is_what_a_histogram_of_its_own_would_hold() {
        let early: Vec<f64> = (0..300).map(|k| 0.01 * f64::from(k)).collect();
        // the range doubles between the two halves, and the largest value is added early or late
        for factor in [0.5, 7.0] {
            let late: Vec<f64> = early.iter().map(|v| factor * v + 0.003).collect();
            let (mut all, mut alone) = (Histogram::default(), Histogram::default());
            early.iter().for_each(|&v| all.add(v));
            let before = all.clone();
            late.iter().for_each(|&v| all.add(v));
            late.iter().for_each(|&v| alone.add(v));
            let since = all.since(&before);
            while alone.width < since.width {
                alone.widen();
            }
            assert_eq!((since.total, &since.counts), (alone.total, &alone.counts));
            let [since_mean, alone_mean] = [&since, &alone].map(|histogram| histogram.mean().unwrap());
            assert!((since_mean - alone_mean).abs() < 1e-12 * alone_mean);
            assert!((since.sum_of_squares() / alone.sum_of_squares() - 1.0).abs() < 1e-12);
            let beyond = since.maximum - alone.maximum;
            assert!((0.0..=since.width).contains(&beyond), "{beyond}");
            assert_eq!(all.since(&all).total, 0);
            assert_eq!(all.since(&Histogram::default()), all);
        }
    }

    #[test]
    fn weird_values_do_no_harm() {
        let mut histogram = Histogram::default();
        assert_eq!((histogram.mean(), histogram.quantile(0.5), histogram.largest()), (None, None, None));
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            histogram.add(value);
        }
        assert_eq!(histogram, Histogram::default());
        for value in [0.0, -0.0, -3.0] {
            histogram.add(value);
        }
        assert_eq!((histogram.total, histogram.counts[0], histogram.maximum), (3, 3, 0.0));
        assert_eq!((histogram.mean(), histogram.quantile(0.9)), (Some(0.0), Some(0.0)));
        for value in [5e-324, 1e-310, 1.0, 1e300, f64::MAX] {
            histogram.add(value);
        }
        assert_eq!((histogram.total, histogram.counts.iter().sum::<u64>()), (8, 8));
        assert_eq!(histogram.quantile(1.0), Some(f64::MAX));
        assert!(histogram.width.is_finite());
        assert!(histogram.quantile(f64::NAN).unwrap().is_finite());
    }

    #[test]
    fn equal_values_give_that_value_as_every_upper_quantile() {
        let mut histogram = Histogram::default();
        (0..1000).for_each(|_| histogram.add(0.3));
        assert!((histogram.quantile(0.5).unwrap() - 0.3).abs() <= histogram.width);
        assert!(histogram.quantile(0.99).unwrap() <= 0.3);
    }
}
