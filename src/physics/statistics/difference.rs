//! Tests of one observable of two runs. They show whether the runs differ, and give an upper bound of the difference.
//!
//! A profile has three tests. Student's t test of the mean over the profile finds a uniform difference. Hotelling's T²
//! test finds a difference in a few smooth shapes across the channel. A test of the slice with the largest deviation
//! finds a local difference, as at a wall. It is Student's t test with as many trials as there are slices. The smallest
//! of the three probabilities is multiplied by three, the number of tests. If the mean vanishes by definition or
//! symmetry, there are two tests. A single number has only Student's t test.
//!
//! Equivalence is tested at every position separately, so the bound is valid for a difference of any shape.

use super::batches::{Batches, Contrast, Correlation, Prior, measured};
use super::modes::{Parity, fold, shapes};
use nalgebra::DVector;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, FisherSnedecor, Normal, StudentsT};
use std::borrow::Cow;

/// [-] probability of a false answer "equivalent" if the true difference equals the margin, the largest accepted
/// difference. The value is usual for two one-sided tests.
pub const EQUIVALENCE_LEVEL: f64 = 0.05;
/// [-] accepted probability that runs of the recommended length fail to show that equal systems are equivalent.
const FAILED: f64 = 0.2;
/// [-] number z for which a normally distributed number lies below its mean plus z standard deviations with a
/// probability of 80 %.
const POWER: f64 = 0.8416;
/// [-] largest scatter, divided by the scale of the observable, that is attributed to rounding. A difference up to ten
/// times as large then counts as zero.
const ROUNDING: f64 = 1e-12;
/// [-] smallest number of degrees of freedom for each shape in Hotelling's test. With fewer, Hotelling's distribution
/// has such long tails that a further shape reduces the power of the test.
const FREEDOM_PER_SHAPE: f64 = 4.0;

/// Quantity that is compared between two runs: a number, a profile over slices, or a curve over time.
#[derive(Clone, Debug)]
pub struct Observable {
    /// Name of the observable. A profile has the name of its column in `profiles.csv`.
    pub name: Cow<'static, str>,
    /// Unit of the observable; empty if it has none.
    pub unit: &'static str,
    /// Positions: centres of the slices [m] for a profile, times [s] for a curve; empty for a single number.
    pub places: Vec<f64>,
    /// Symmetry of a profile under a reflection at the mid-plane of the channel; `Neither` for a curve over time.
    pub parity: Parity,
    /// True if the mean over the positions is fixed by definition, as for a density divided by its mean.
    pub fixed_mean: bool,
    /// Scale by which differences are divided, in the unit of the observable.
    pub scale: f64,
    /// Description of the scale, in words that follow "% of", such as "its mean".
    pub scale_is: &'static str,
    /// Average at each position, with the blocks of time from which its error is computed. Each entry contains one
    /// average; it is `None` if the average is unknown. A single number has one entry.
    pub parts: Vec<Option<Batches>>,
}

/// Difference between two runs, first minus second, in the unit of the observable, with its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Deviation {
    /// Position of the difference: centre of a slice [m] or time [s]. `None` for the mean over all positions, and for a
    /// single number.
    pub place: Option<f64>,
    /// Value in the first run minus value in the second run, in the unit of the observable.
    pub difference: f64,
    /// Standard error of the difference, in the unit of the observable; 0 if neither run scatters.
    pub error: f64,
    /// [-] degrees of freedom of the standard error.
    pub freedom: f64,
}

impl Deviation {
    /// [-] probability that equal systems show a difference of at least this size, of either sign, by Student's t test.
    pub fn chance(&self) -> f64 {
        if self.error > 0.0 {
            two_sided(self.difference / self.error, self.freedom)
        } else {
            f64::from(u8::from(self.difference == 0.0))
        }
    }

    /// Upper bound of the magnitude of the difference, by a one-sided test at the level `level` [-], in the unit of the
    /// observable.
    pub fn bound(&self, level: f64) -> f64 {
        self.difference.abs() + self.width(level)
    }

    /// Distance from the difference to its upper bound, by a one-sided test at the level `level` [-], in the unit of
    /// the observable.
    pub fn width(&self, level: f64) -> f64 {
        if self.error > 0.0 { student_bound(level, self.freedom) * self.error } else { 0.0 }
    }
}

/// Results of the tests of one observable of two runs. Differences and bounds are in the unit of the observable;
/// probabilities are numbers [-].
#[derive(Clone, Debug, Serialize)]
pub struct Tested {
    /// Name of the observable that was tested.
    pub name: Cow<'static, str>,
    /// Unit of the observable; empty if it has none.
    pub unit: &'static str,
    /// Scale by which differences are divided, in the unit of the observable.
    pub scale: f64,
    /// Description of the scale, in words that follow "% of", such as "its mean".
    pub scale_is: &'static str,
    /// Difference of the mean over all positions, or of the single number. `None` if the mean is fixed by definition or
    /// by symmetry.
    pub mean: Option<Deviation>,
    /// Difference at the position where it is most significant; `None` for a single number.
    pub largest: Option<Deviation>,
    /// [-] probability that equal systems show a difference of at least this size in the smooth shapes (polynomials
    /// across the profile).
    pub smooth_chance: f64,
    /// [-] probability that equal systems show a difference of at least this size at any one position; `None` for a
    /// single number.
    pub local_chance: Option<f64>,
    /// [-] probability that equal systems show a difference of at least this size in any of the tests of the
    /// observable.
    pub chance: f64,
    /// Upper bound of the magnitude of the difference at any position, in the unit of the observable. It comes from two
    /// one-sided tests at every position, at the level of 5 % or, with several interim tests, at a lower one.
    pub bound: f64,
    /// Upper bound of the magnitude of the difference, in the unit of the observable, if the difference is a sum of the
    /// smooth shapes (polynomials across the profile). Its level is that of `bound`.
    pub smooth_bound: f64,
    /// Differences at all positions; a single number has one position.
    #[serde(skip)]
    places: Vec<Deviation>,
    /// Standard error of the coefficient of the first smooth shape (polynomial across the profile), times the largest
    /// value of this shape, in the unit of the observable.
    #[serde(skip)]
    first_error: f64,
    /// [-] degrees of freedom of the standard error `first_error`.
    #[serde(skip)]
    first_freedom: f64,
    /// Number of smooth shapes (polynomials across the profile) that Hotelling's test combines.
    #[serde(skip)]
    shapes: usize,
}

impl Tested {
    /// Difference that a report names first: that of the mean or, if it is more significant, the largest one at a
    /// position. `None` if neither is known.
    pub fn headline(&self) -> Option<Deviation> {
        match (self.mean, self.largest) {
            (Some(mean), Some(largest)) if mean.chance() > largest.chance() => Some(largest),
            (mean, largest) => mean.or(largest),
        }
    }

    /// Smallest difference in the first smooth shape (polynomial across the profile) that a test at the level `level`
    /// [-] finds in 80 % of cases, in the unit of the observable. The first shape is uniform unless the mean difference
    /// vanishes by definition or symmetry.
    pub fn detectable(&self, level: f64) -> f64 {
        let level = level / self.tests();
        let bound = if self.mean.is_some() {
            student_bound(0.5 * level, self.first_freedom)
        } else {
            // a difference of s standard errors in one of K shapes gives a T² of about s² + K - 1
            let others = self.shapes.saturating_sub(1) as f64;
            (hotelling_bound(level, self.shapes, self.first_freedom) - others).max(0.0).sqrt()
        };
        self.first_error * (bound + POWER)
    }

    /// [-] number of tests of the observable, by which the smallest probability is multiplied: 1 for a single number, 3
    /// for a profile, 2 for a profile whose mean difference vanishes by definition or symmetry.
    fn tests(&self) -> f64 {
        match (self.mean, self.largest) {
            (_, None) => 1.0,
            (None, Some(_)) => 2.0,
            (Some(_), Some(_)) => 3.0,
        }
    }

    /// Interval that contains the differences at all positions, in the unit of the observable. Each of its ends comes
    /// from one-sided tests at the level `level` [-].
    pub fn interval(&self, level: f64) -> [f64; 2] {
        let ends = self.places.iter().map(|one| [one.difference - one.width(level), one.difference + one.width(level)]);
        ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or_default()
    }

    /// Number of positions at which the difference has a standard error above 0.
    pub fn scattering(&self) -> usize {
        self.places.iter().filter(|one| one.error > 0.0).count()
    }

    /// Smallest margin with which equal systems are shown to be equivalent in 80 % of cases, in the unit of the
    /// observable. The position with the largest error determines this margin. `places` is the number of positions of
    /// all observables that must be shown to be equivalent. `level` [-] is the level of each one-sided test.
    pub fn width_needed(&self, level: f64, places: usize) -> f64 {
        let surely =
            Normal::new(0.0, 1.0).map_or(0.0, |law| law.inverse_cdf(1.0 - 0.5 * FAILED / places.max(1) as f64));
        let width = |one: &Deviation| (student_bound(level, one.freedom) + surely) * one.error;
        self.places.iter().filter(|one| one.error > 0.0).map(width).fold(0.0, f64::max)
    }
}

/// Observable of two runs whose values at mirrored positions have been averaged (folding about the mid-plane), ready
/// for the tests.
pub struct Folded {
    name: Cow<'static, str>,
    unit: &'static str,
    scale: f64,
    scale_is: &'static str,
    /// Positions that remain after mirrored ones have been averaged: centres of slices [m] or times [s]; empty for a
    /// single number.
    places: Vec<f64>,
    batches: [Batches; 2],
    /// Value of each smooth shape (polynomial across the profile) at each of the remaining positions.
    shapes: Vec<Vec<f64>>,
    /// True if the first smooth shape is uniform, so that its coefficient is the mean difference.
    has_mean: bool,
}

impl Folded {
    /// Averages the values of an observable at positions that are mirror images about the mid-plane, in both runs.
    /// `None` if no position is known in both runs, or if the standard errors of a run are unknown.
    pub fn new(a: &Observable, b: &Observable) -> Option<Self> {
        let count = a.places.len().max(1);
        if [a, b].iter().any(|one| one.parts.len() != count) {
            return None;
        }
        let (places, rows) = fold(count, a.parity);
        // the average of two mirrored positions is known if both are known
        let known = |row: &[f64]| {
            row.iter().enumerate().all(|(k, weight)| *weight == 0.0 || a.parts[k].is_some() && b.parts[k].is_some())
        };
        let kept: Vec<usize> = (0..rows.len()).filter(|&k| known(&rows[k])).collect();
        let needed: Vec<usize> = (0..count).filter(|&k| kept.iter().any(|&row| rows[row][k] != 0.0)).collect();
        let rows: Vec<Vec<f64>> = kept.iter().map(|&row| needed.iter().map(|&k| rows[row][k]).collect()).collect();
        let joined = |one: &Observable| Batches::join(needed.iter().filter_map(|&k| one.parts[k].as_ref()));
        let batches = [joined(a)?.project(&rows), joined(b)?.project(&rows)];
        if batches.iter().any(|batches| !batches.tells_errors()) {
            return None;
        }
        let places: Vec<f64> = kept.iter().filter_map(|&row| a.places.get(places[row]).copied()).collect();
        let shapes = if a.places.is_empty() {
            vec![vec![1.0]]
        } else {
            shapes(&places_across(&a.places, &places), a.parity, usize::from(a.fixed_mean))
        };
        let has_mean = a.parity != Parity::Odd && !a.fixed_mean;
        let (name, unit, scale, scale_is) = (a.name.clone(), a.unit, a.scale, a.scale_is);
        Some(Self { name, unit, scale, scale_is, places, batches, shapes, has_mean })
    }

    /// Correlations [-] between neighbouring blocks of time of the coefficients of all smooth shapes (polynomials
    /// across the profile). Each correlation comes with its variance [-] due to chance.
    pub fn correlations(&self) -> Vec<(f64, f64)> {
        let [a, b] = self.projected(&self.shapes);
        measured(&a, &b)
    }

    /// Coefficients of the smooth shapes `shapes` (polynomials across the profile) in each of the two runs, averaged
    /// over the run and in each block of time.
    fn projected(&self, shapes: &[Vec<f64>]) -> [Batches; 2] {
        let count = self.batches[0].values.len() as f64;
        let weights: Vec<Vec<f64>> =
            shapes.iter().map(|shape| shape.iter().map(|value| value / count).collect()).collect();
        [0, 1].map(|k| self.batches[k].project(&weights))
    }

    /// Tests the observable. `prior` is the distribution of the correlations between blocks over all observables, and
    /// `level` [-] the level of each one-sided test of equivalence. `None` if a run has too few blocks.
    pub fn test(&self, prior: Prior, level: f64) -> Option<Tested> {
        let rounding = ROUNDING * self.scale.abs();
        let [a, b] = &self.batches;
        let local = Contrast::new(a, b, Correlation::Common)?;
        let smooth = Smooth::new(self, prior, rounding)?;
        let number = smooth.mean(rounding).filter(|_| self.places.len() < 2);
        let places = number.map_or_else(|| at_places(&local, &self.places, rounding), |mean| vec![mean]);
        let clearer = |a: &Deviation, b: &Deviation| b.chance().total_cmp(&a.chance());
        let largest = places.iter().copied().max_by(clearer).filter(|_| number.is_none());
        let smooth_chance = smooth.chance(rounding);
        let local_chance = largest.map(|one| (one.chance() * self.places.len() as f64).min(1.0));
        let mean = self.has_mean.then(|| smooth.mean(rounding)).flatten();
        let bound = places.iter().map(|one| one.bound(level)).fold(0.0, f64::max);
        let smooth_bound = if number.is_some() { bound } else { smooth.bound(level) };
        let (first_error, first_freedom) = smooth.first();
        let mut tested = Tested {
            name: self.name.clone(),
            unit: self.unit,
            scale: self.scale,
            scale_is: self.scale_is,
            mean,
            largest,
            smooth_chance,
            local_chance,
            chance: 1.0,
            bound,
            smooth_bound,
            places,
            first_error,
            first_freedom,
            shapes: smooth.scattering.len().max(1),
        };
        let chances = [mean.map(|mean| mean.chance()), Some(smooth_chance), local_chance];
        tested.chance = chances.into_iter().flatten().fold(1.0, |least, chance| least.min(chance * tested.tests()));
        Some(tested)
    }
}

/// Coordinates [-] of the positions `kept`, on a scale on which the positions `all` extend from -1 to 1.
fn places_across(all: &[f64], kept: &[f64]) -> Vec<f64> {
    let (Some(first), Some(last)) = (all.first(), all.last()) else { return vec![0.0] };
    let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
    kept.iter().map(|place| if half > 0.0 { (place - middle) / half } else { 0.0 }).collect()
}

/// Difference between the two runs at each of the `places`, which correspond to the components of `contrast`. Errors up
/// to `rounding` count as 0.
fn at_places(contrast: &Contrast, places: &[f64], rounding: f64) -> Vec<Deviation> {
    places.iter().enumerate().map(|(k, &place)| deviation(contrast, k, Some(place), rounding)).collect()
}

/// Difference in the component of `contrast` with index `component`, which belongs to the position `place`. If its
/// error is at most `rounding`, the error counts as 0. A difference of at most ten times `rounding` then counts as 0 as
/// well.
fn deviation(contrast: &Contrast, component: usize, place: Option<f64>, rounding: f64) -> Deviation {
    let (difference, error) = (contrast.difference[component], contrast.error(component));
    if error > rounding {
        return Deviation { place, difference, error, freedom: contrast.freedom_of(component) };
    }
    let difference = if difference.abs() <= 10.0 * rounding { 0.0 } else { difference };
    Deviation { place, difference, error: 0.0, freedom: 1.0 }
}

/// Difference between two runs, expressed by the coefficients of a few smooth shapes (polynomials across the profile),
/// with its covariance.
struct Smooth {
    /// Value of each smooth shape at each position.
    shapes: Vec<Vec<f64>>,
    contrast: Contrast,
    /// Indices of the shapes (polynomials across the profile) whose coefficients differ between blocks of time. The
    /// coefficients of the other shapes are known exactly.
    scattering: Vec<usize>,
}

impl Smooth {
    fn new(folded: &Folded, prior: Prior, rounding: f64) -> Option<Self> {
        let mut shapes = folded.shapes.clone();
        loop {
            let [a, b] = folded.projected(&shapes);
            let contrast = Contrast::new(&a, &b, Correlation::Each(prior))?;
            let scattering: Vec<usize> = (0..shapes.len()).filter(|&k| contrast.error(k) > rounding).collect();
            let freedom = scattering.iter().map(|&k| contrast.freedom_of(k)).fold(f64::INFINITY, f64::min);
            let most = (freedom / FREEDOM_PER_SHAPE).max(1.0);
            if shapes.len() as f64 <= most || scattering.is_empty() {
                return Some(Self { shapes, contrast, scattering });
            }
            shapes.truncate(most as usize);
        }
    }

    /// Difference of the mean over all positions. It is the coefficient of the first of the shapes (polynomials across
    /// the profile), which must be a constant. `None` without shapes.
    fn mean(&self, rounding: f64) -> Option<Deviation> {
        (!self.shapes.is_empty()).then(|| deviation(&self.contrast, 0, None, rounding))
    }

    /// [-] probability that equal systems show a difference of at least this size in the smooth shapes (polynomials
    /// across the profile), by Hotelling's distribution.
    fn chance(&self, rounding: f64) -> f64 {
        let exact = (0..self.shapes.len()).filter(|k| !self.scattering.contains(k));
        if exact.into_iter().any(|k| self.contrast.difference[k].abs() > 10.0 * rounding) {
            return 0.0;
        }
        let difference =
            DVector::from_iterator(self.scattering.len(), self.scattering.iter().map(|&k| self.contrast.difference[k]));
        let covariance = self.contrast.covariance().select_rows(&self.scattering).select_columns(&self.scattering);
        let Some(factored) = covariance.cholesky() else { return 1.0 };
        let solved = factored.solve(&difference);
        let square = difference.dot(&solved);
        let mut direction = DVector::zeros(self.shapes.len());
        self.scattering.iter().zip(solved.iter()).for_each(|(&k, value)| direction[k] = *value);
        if square > 0.0 { hotelling(square, self.scattering.len(), self.contrast.freedom(&direction)) } else { 1.0 }
    }

    /// Upper bound of the magnitude of the difference at the position where this bound is largest, in the unit of the
    /// observable. `level` [-] is the level of each one-sided test.
    fn bound(&self, level: f64) -> f64 {
        let places = self.shapes.first().map_or(0, Vec::len);
        let at = |place: usize| {
            let direction = DVector::from_iterator(self.shapes.len(), self.shapes.iter().map(|shape| shape[place]));
            let difference = direction.dot(&self.contrast.difference).abs();
            let error = self.contrast.error_along(&direction);
            difference + student_bound(level, self.contrast.freedom(&direction)) * error
        };
        (0..places).map(at).fold(0.0, f64::max)
    }

    /// Standard error of the coefficient of the first smooth shape (polynomial across the profile), times the largest
    /// value of this shape, in the unit of the observable. The second number is the degrees of freedom [-] of this
    /// error.
    fn first(&self) -> (f64, f64) {
        let Some(shape) = self.shapes.first() else { return (0.0, 1.0) };
        let largest = shape.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        (self.contrast.error(0) * largest, self.contrast.freedom_of(0))
    }
}

/// [-] probability that |t| exceeds `deviation`, by Student's distribution with `freedom` degrees of freedom. For
/// infinitely many degrees of freedom this is the normal distribution.
pub fn two_sided(deviation: f64, freedom: f64) -> f64 {
    if freedom.is_infinite() {
        return Normal::new(0.0, 1.0).map_or(1.0, |law| 2.0 * law.sf(deviation.abs()));
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(1.0, |law| (2.0 * law.sf(deviation.abs())).min(1.0))
}

/// [-] value that Student's t with `freedom` degrees of freedom exceeds with the probability `level` [-].
pub fn student_bound(level: f64, freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |law| law.inverse_cdf(1.0 - level))
}

/// [-] probability that Hotelling's T² (1931) of K = `shapes` components exceeds `square` if there is no difference.
/// The value T² (ν - K + 1)/(ν K) has Fisher's F distribution, where ν is the number `freedom` of degrees of freedom.
fn hotelling(square: f64, shapes: usize, freedom: f64) -> f64 {
    let count = shapes as f64;
    let rest = (freedom - count + 1.0).max(1.0);
    FisherSnedecor::new(count, rest).map_or(1.0, |law| law.sf(square * rest / (freedom * count)))
}

/// [-] value that Hotelling's T² of `shapes` components exceeds with the probability `level` [-] if there is no
/// difference. `freedom` is the number of degrees of freedom.
fn hotelling_bound(level: f64, shapes: usize, freedom: f64) -> f64 {
    let count = shapes as f64;
    let rest = (freedom - count + 1.0).max(1.0);
    let bound = FisherSnedecor::new(count, rest).map_or(f64::INFINITY, |law| law.inverse_cdf(1.0 - level));
    bound * freedom * count / rest
}
