//! Test whether a run is statistically steady, and search for the start of its steady part.

use super::errors::{FEWEST_BLOCKS, Removed, mean, standard_error};
use serde::Serialize;

/// Number of successive samples (instants of measurement) that are averaged before the start of the steady part is
/// searched. This reduces the influence of chance.
const BATCH: usize = 5;
/// [-] largest difference, in standard errors, that does not count as drift. About a dozen quantities are tested, and
/// their errors have about ten degrees of freedom. The number was found from 400 steady channels and gases:
/// docs/theory/statistics.md, "Steady or not".
pub const LARGEST_DRIFT: f64 = 4.0;
/// [-] drift, in standard errors, that confirms an initial relaxation of more than half of the run. The search for the
/// start of averaging ends at half of the run. Chance seldom gives this latest start, and even more seldom together
/// with such a drift.
const SUSPECT: f64 = 2.0;
/// [-] smallest relative decrease of the variance of the mean for which samples (instants of measurement) at the start
/// are dropped. Noise gives a decrease of a few per cent.
const WORTH: f64 = 0.1;

/// Result of the test for a steady state, for several observables together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Steadiness {
    /// [s] simulated time at which the steady part of the run begins; 0 without measurements.
    pub from: f64,
    /// True if no tested quantity drifts by more than 4 standard errors during the averaging period, and if no initial
    /// relaxation of more than half of the run was found. With too few samples (instants of measurement) for a test,
    /// the result is false and `drift` is `None`.
    pub steady: bool,
    /// [-] largest drift of all tested quantities: difference between the means of the second and the first half of
    /// the averaging period, in standard errors. `None` if unknown, infinite for a drift without any noise.
    pub drift: Option<f64>,
}

/// Values of one observable at equal intervals of time, with the sizes of the changes that count as steady.
#[derive(Clone, Copy, Debug)]
pub struct SteadySeries<'a> {
    /// Values at all samples (instants of measurement), in the unit of the observable.
    pub values: &'a [f64],
    /// Scale of the changes, in the unit of the observable. Regular changes below a thousandth of this scale do not
    /// count as drift. If the scale is 0, every change counts.
    pub scale: f64,
    /// Largest difference between the means of the two halves of the averaging period that does not count as drift, in
    /// the unit of the observable. If it is 0, every difference counts.
    pub step: f64,
}

impl SteadySeries<'_> {
    /// First `count` values of the series. If they differ by no more than the rounding errors of a long run, all are
    /// set to 0. An example is a conserved mean velocity. Its rounding errors add up like a random walk, which would
    /// count as a drift.
    fn without_rounding(&self, count: usize) -> Vec<f64> {
        /// [-] largest range of the values, divided by the scale, that is attributed to rounding. It is a hundred times
        /// the error of 10^4 roundings of numbers of that size.
        const ROUNDING: f64 = 1e-12;
        let values = &self.values[..count];
        let (least, most) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        let all_finite = values.iter().all(|v| v.is_finite());
        if all_finite && most - least <= ROUNDING * self.scale { vec![0.0; count] } else { values.to_vec() }
    }

    /// Drift of the `values` of this observable, in standard errors [-], by [`drift_of_any_shape`]. It is 0 if the
    /// means of the two halves differ by at most `step`, and `None` for too few values.
    fn drift(&self, values: &[f64]) -> Option<f64> {
        let drift = drift_of_any_shape(values, 1e-3 * self.scale)?;
        let half = values.len() / 2;
        let apart = (mean(&values[values.len() - half..]) - mean(&values[..half])).abs();
        Some(if apart <= self.step { 0.0 } else { drift })
    }
}

/// Tests whether several observables are steady. They are sampled at common, equally spaced `times` [s]. `from` [s] is
/// the start of averaging. If it is `None`, the marginal standard error rule finds the start, and drops at most half of
/// the run.
pub fn judge(times: &[f64], series: &[SteadySeries], from: Option<f64>) -> Steadiness {
    let count = series.iter().map(|s| s.values.len()).fold(times.len(), usize::min);
    let times = &times[..count];
    let series: Vec<(Vec<f64>, &SteadySeries)> = series.iter().map(|one| (one.without_rounding(count), one)).collect();
    let (start, forced) = match from {
        Some(from) => (times.partition_point(|&t| t < from - 1e-9 * from.abs()), false),
        None => {
            let found = series.iter().map(|(values, one)| start(values, one));
            found.fold((0, false), |worst, one| (worst.0.max(one.0), worst.1 || one.1))
        }
    };
    // if one series cannot be judged, there is no result for the series together
    let drifts: Option<Vec<f64>> = series.iter().map(|(values, one)| one.drift(&values[start..])).collect();
    let drift = drifts.and_then(|drifts| drifts.into_iter().reduce(f64::max));
    Steadiness {
        from: from.or_else(|| times.get(start).copied()).unwrap_or(0.0),
        steady: drift.is_some_and(|drift| drift <= LARGEST_DRIFT) && !forced,
        drift,
    }
}

/// Number of samples (instants of measurement) to drop at the start of the series. The second value is true if the
/// initial relaxation lasts longer than half of the run. This holds if the number is at its limit and the values drift
/// even without the first half of these samples.
fn start(values: &[f64], series: &SteadySeries) -> (usize, bool) {
    let (start, at_limit) = truncation(values);
    let drifts = || series.drift(&values[start / 2..]).is_some_and(|drift| drift > SUSPECT);
    (start, at_limit && drifts())
}

/// Number of samples (instants of measurement) to drop at the start. The second value is true if the number is at its
/// limit, half of the run. The number minimizes the squared standard error of the mean of the remaining samples, as if
/// they were independent (MSER-5; White 1997). No sample is dropped if the square would decrease by less than a tenth.
fn truncation(values: &[f64]) -> (usize, bool) {
    let batches: Vec<f64> = values.chunks_exact(BATCH).map(mean).collect();
    let count = batches.len();
    if count < 4 || batches.iter().any(|b| !b.is_finite()) {
        return (0, false);
    }
    // the sums begin at the end of the series and are relative to the overall mean, to avoid cancellation
    let centre = mean(&batches);
    let (mut sum, mut squares) = (0.0, 0.0);
    let (mut best, mut whole) = ((f64::INFINITY, 0), f64::INFINITY);
    for first in (0..count).rev() {
        let value = batches[first] - centre;
        sum += value;
        squares += value * value;
        let left = (count - first) as f64;
        let marginal = (squares - sum * sum / left).max(0.0) / (left * left);
        if first <= count / 2 && marginal <= best.0 {
            best = (marginal, first);
        }
        whole = marginal;
    }
    if best.0 > (1.0 - WORTH) * whole {
        return (0, false);
    }
    // noise shifts the minimum a little, so a number in the last tenth below the limit also counts as at the limit
    (best.1 * BATCH, 10 * best.1 >= 9 * (count / 2))
}

/// Drift of the values or drift of their ranks, in standard errors [-], whichever is larger; `None` for too few values.
/// A decay that no parabola fits, such as that of a cooling gas, would be taken for noise, but its ranks decrease along
/// a straight line. Ranks of a steady series are also steady. Ranks do not depend on the size of changes, so values
/// within one `step` count as equal. Energy that is lost by rounding or by an integrator then does not count as decay.
fn drift_of_any_shape(values: &[f64], step: f64) -> Option<f64> {
    Some(drift(values)?.max(drift(&ranks(values, step))?))
}

/// Rank of each value: the number of smaller values plus half the number of equal values, the value itself included.
/// Values are first rounded to whole multiples of `step`.
fn ranks(values: &[f64], step: f64) -> Vec<f64> {
    let rounded = |value: &f64| if step > 0.0 { (value / step).round() } else { *value };
    let values: Vec<f64> = values.iter().map(rounded).collect();
    let mut sorted = values.clone();
    sorted.sort_by(f64::total_cmp);
    let rank = |value: &f64| {
        let (below, up_to) = (sorted.partition_point(|one| one < value), sorted.partition_point(|one| one <= value));
        0.5 * (below + up_to) as f64
    };
    values.iter().map(rank).collect()
}

/// [-] magnitude of the difference between the means of the first and the second half of the values, in standard
/// errors. The standard error comes from the scatter about a fitted parabola, because a drift would increase the
/// scatter about the mean. `None` for fewer than 16 values, or if a value is not finite.
fn drift(values: &[f64]) -> Option<f64> {
    let count = values.len();
    if count < 2 * FEWEST_BLOCKS || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let half = count / 2;
    let difference = (mean(&values[count - half..]) - mean(&values[..half])).abs();
    let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if difference <= 1e-12 * largest {
        return Some(0.0);
    }
    // the polynomials are orthogonal about the middle; the even polynomial does not contribute to the difference of the
    // halves
    let middle = 0.5 * (count - 1) as f64;
    let x: Vec<f64> = (0..count).map(|k| (k as f64 - middle) / count as f64).collect();
    let spread = x.iter().map(|x| x * x).sum::<f64>() / count as f64;
    let mut residuals = values.to_vec();
    take_off(&mut residuals, &vec![1.0; count]);
    take_off(&mut residuals, &x);
    take_off(&mut residuals, &x.iter().map(|x| x * x - spread).collect::<Vec<f64>>());
    // each half has half the samples, and the variances of the two halves add up, so the error is twice that of the
    // mean of all samples
    let error = 2.0 * standard_error(&residuals, Removed::Parabola)?;
    Some(if error <= 1e-12 * largest { f64::INFINITY } else { difference / error })
}

/// Subtracts a multiple of `shape` from `values`: the multiple that fits the values best by least squares.
fn take_off(values: &mut [f64], shape: &[f64]) {
    let overlap: f64 = values.iter().zip(shape).map(|(v, s)| v * s).sum();
    let factor = overlap / shape.iter().map(|s| s * s).sum::<f64>();
    values.iter_mut().zip(shape).for_each(|(v, s)| *v -= factor * s);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Creates a series of the values, in which every change counts.
    fn exact(values: &[f64]) -> SteadySeries<'_> {
        SteadySeries { values, scale: 0.0, step: 0.0 }
    }

    /// Times and values of a relaxation from 1 + `jump` to 1 with the time constant `tau` [s], over 5 s. Noise with a
    /// relaxation time of 0.1 s is added.
    fn series(jump: f64, tau: f64, random: &mut Xoshiro256PlusPlus) -> (Vec<f64>, Vec<f64>) {
        let times: Vec<f64> = (0..500).map(|k| 0.01 * f64::from(k)).collect();
        let rho = (-0.1_f64).exp();
        let mut slow: f64 = StandardNormal.sample(random);
        let values = times
            .iter()
            .map(|t| {
                let kick: f64 = StandardNormal.sample(random);
                slow = rho * slow + (1.0 - rho * rho).sqrt() * kick;
                1.0 + jump * (-t / tau).exp() + 0.1 * slow
            })
            .collect();
        (times, values)
    }

    /// Share of 400 made-up runs, with the `jump` and the time constant `tau` [s] of the function `series`, that are
    /// found to be steady. The second number is the mean start of averaging [s]; `from` is the given start.
    fn share(jump: f64, tau: f64, from: Option<f64>) -> (f64, f64) {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
        let (mut steady, mut start) = (0.0, 0.0);
        for _ in 0..400 {
            let (times, values) = series(jump, tau, &mut random);
            let found = judge(&times, &[exact(&values)], from);
            steady += f64::from(u8::from(found.steady)) / 400.0;
            start += found.from / 400.0;
        }
        println!("jump {jump}, tau {tau}, {from:?}: steady {steady:.3}, from {start:.2} s");
        (steady, start)
    }

    #[test]
    fn rounding_that_walks_is_no_drift() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
        let times: Vec<f64> = (0..1000).map(f64::from).collect();
        let mut value = 0.0;
        let mut step = |_: &f64| {
            let by: f64 = StandardNormal.sample(&mut random);
            value += 1e-16 * (by + 0.2);
            value
        };
        let values: Vec<f64> = times.iter().map(&mut step).collect();
        let judged = |scale: f64| judge(&times, &[SteadySeries { values: &values, scale, step: 0.0 }], None);
        assert!(judged(1.0).steady && judged(1.0).from == 0.0);
        // the same series drifts if the scale of the observable has the size of its changes
        assert!(!judged(1e-13).steady);
    }

    #[test]
    fn a_transient_is_dropped_and_the_rest_is_steady() {
        let (steady, start) = share(2.0, 0.2, None);
        // the transient falls below the noise at 0.2 ln 20 = 0.6 s
        assert!(steady > 0.85 && (0.4..1.5).contains(&start), "{steady} {start}");
        let (steady, start) = share(0.0, 1.0, None);
        assert!(steady > 0.85 && start < 0.7, "{steady} {start}");
    }

    #[test]
    fn false_alarms_are_rare_where_the_start_is_given() {
        let (steady, start) = share(0.0, 1.0, Some(1.0));
        assert!(steady > 0.95 && (start - 1.0).abs() < 1e-9, "{steady}");
    }

    #[test]
    fn runs_that_still_drift_are_found() {
        // from 2.4 s on the remaining drift is about 4 standard errors, and from 1 s on about 6
        assert!(share(2.0, 3.0, None).0 < 0.12);
        assert!(share(2.0, 3.0, Some(1.0)).0 < 0.12);
        let times: Vec<f64> = (0..100).map(f64::from).collect();
        let ramp = judge(&times, &[exact(&times)], Some(0.0));
        assert!(!ramp.steady && ramp.drift.is_some_and(|drift| drift > 1e6), "{ramp:?}");
        // one series that drifts among steady ones determines the result
        let mut random = Xoshiro256PlusPlus::seed_from_u64(6);
        let (times, good) = series(0.0, 1.0, &mut random);
        let (_, bad) = series(5.0, 5.0, &mut random);
        assert!(judge(&times, &[exact(&good)], Some(0.0)).steady);
        assert!(!judge(&times, &[exact(&good), exact(&bad)], Some(0.0)).steady);
    }

    #[test]
    fn a_gas_that_cools_is_not_steady() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
        for scatter in [0.0, 0.05, 0.2] {
            // Haff (1983): the temperature decreases as (1 + t/tau)^-2; the run lasts 10 tau, 40 tau or 100 tau
            for spans in [10.0, 40.0, 100.0] {
                let times: Vec<f64> = (0..200).map(f64::from).collect();
                let one = |t: &f64| {
                    let noise: f64 = StandardNormal.sample(&mut random);
                    (1.0 + spans * t / 200.0).powi(-2) * (1.0 + scatter * noise)
                };
                let values: Vec<f64> = times.iter().map(one).collect();
                let found = judge(&times, &[exact(&values)], Some(0.0));
                assert!(!found.steady && found.drift.is_some_and(|drift| drift > 3.0), "{scatter} {spans} {found:?}");
            }
        }
    }

    #[test]
    fn what_falls_by_less_than_matters_is_steady() {
        // energy loss by the error of an integrator, with dips during contacts
        let times: Vec<f64> = (0..200).map(f64::from).collect();
        let dip = |t: &f64| if t % 7.0 < 0.5 { 3e-4 } else { 0.0 };
        let falling = |by: f64| times.iter().map(|t| 1.0 - by * t / 200.0 - dip(t)).collect::<Vec<f64>>();
        let scaled =
            |values: &[f64]| judge(&times, &[SteadySeries { values, scale: 1.0, step: 0.0 }], Some(0.0)).steady;
        assert!(scaled(&falling(2e-5)) && !scaled(&falling(2e-2)));
    }

    #[test]
    fn short_and_broken_series_are_not_called_steady() {
        for count in 0..16 {
            let times: Vec<f64> = (0..count).map(f64::from).collect();
            for from in [None, Some(0.0), Some(1e9)] {
                let found = judge(&times, &[exact(&times)], from);
                assert!(!found.steady && found.drift.is_none());
            }
        }
        assert!(!judge(&[], &[], None).steady);
        let times: Vec<f64> = (0..100).map(f64::from).collect();
        assert!(!judge(&times, &[exact(&[f64::NAN; 100])], None).steady);
        assert!(!judge(&times, &[exact(&[1.0; 3])], None).steady);
        assert!(judge(&times, &[exact(&[1.0; 100])], None).steady);
    }
}
