//! Numerical integration of the slip speed under drag, for laws without a closed-form solution.
//!
//! Let w be the slip speed [m/s], w_0 its initial value, τ the response time [s], and L = ln(w/w_0). The equation dw/dt
//! = -w/τ(w) becomes dL/dt = -1/τ(w_0 e^L). Its right-hand side is smooth and does not grow as the slip speed decays,
//! so an explicit method with adaptive steps suffices. The method is Gragg's modified midpoint rule, extrapolated to
//! step zero as by Bulirsch and Stoer (Hairer, Nørsett and Wanner 1993, Solving Ordinary Differential Equations I,
//! section II.9).

/// Number of results of the midpoint rule, with 2, 4, ..., 12 substeps, from which a step is extrapolated to substep
/// zero. Extrapolation from six results is of twelfth order in the step.
const SEQUENCES: usize = 6;
/// [-] allowed error of L = ln(w/w_0) in one step, relative to |L| at the end of the step. It is a tenth of the
/// documented accuracy of 1e-12, because the errors of several steps add up.
const TOLERANCE: f64 = 1e-13;
/// [-] shortest step, divided by the time integrated so far. Rounding would make the end of a shorter step equal to
/// its start. Where the response time τ jumps, steps become this short. The error of ln(w), with the slip speed w, is
/// then about the jump of 1/τ times the step.
const SHORTEST: f64 = 8.0 * f64::EPSILON;

/// [-] solution L = ln(w/w_0) of dL/dt = `rate`(L) after `duration` [s], with the slip speed w, L = 0 at the start and
/// the rate in 1/s. The relative error is 1e-12. The result is not-a-number if `rate` returns not-a-number.
pub(super) fn integrate(rate: &dyn Fn(f64) -> f64, duration: f64) -> f64 {
    let (mut time, mut log) = (0.0, 0.0);
    let mut step = duration.min(1.0 / rate(0.0).abs());
    while time < duration {
        let last = step >= duration - time;
        if last {
            step = duration - time;
        }
        let (change, error) = extrapolate(rate, log, step);
        if !error.is_finite() {
            return f64::NAN;
        }
        let allowed = TOLERANCE * (log + change).abs();
        if error <= allowed || step <= SHORTEST * time {
            log += change;
            time = if last { duration } else { time + step };
        }
        // the error of a step is proportional to the step to the power 2 SEQUENCES - 1; the factor 0.9 makes a
        // repetition of the next step unlikely
        let factor = 0.9 * (allowed / error).powf(1.0 / (2 * SEQUENCES - 1) as f64);
        // without an error (or for 0/0, if L does not change) the step grows by the largest factor, 4
        step *= if factor.is_nan() { 4.0 } else { factor.clamp(0.1, 4.0) };
    }
    log
}

/// [-] change of L = ln(w/w_0) in one step of length `step` [s] from the value `start`, and the estimated error of the
/// change. The change is extrapolated from results of the midpoint rule with 2, 4, ..., 12 substeps. The error is the
/// difference between the extrapolations with and without the last result. A comparison of two extrapolations that
/// both use the last result would not be safe, because the two may agree by chance where the law jumps.
fn extrapolate(rate: &dyn Fn(f64) -> f64, start: f64, step: f64) -> (f64, f64) {
    let first = rate(start);
    // one row of the scheme of Aitken and Neville, which extrapolates in the square of the substep
    let mut row = [0.0; SEQUENCES];
    let (mut best, mut before) = (0.0, 0.0);
    for k in 0..SEQUENCES {
        let mut value = midpoint(rate, (start, first), step, 2 * (k + 1));
        for (column, entry) in row.iter_mut().take(k).enumerate() {
            let ratio = (k + 1) as f64 / (k - column) as f64;
            let better = value + (value - *entry) / (ratio * ratio - 1.0);
            *entry = std::mem::replace(&mut value, better);
        }
        row[k] = value;
        (best, before) = (value, best);
    }
    (best, (best - before).abs())
}

/// [-] change of L = ln(w/w_0) over `step` [s], by `substeps` steps of the midpoint rule. `start` is L at the start,
/// and `first` is dL/dt [1/s] there. As in Gragg's method, the result is smoothed over the last substeps.
fn midpoint(rate: &dyn Fn(f64) -> f64, (start, first): (f64, f64), step: f64, substeps: usize) -> f64 {
    let h = step / substeps as f64;
    // all values are relative to the start, so that a short step keeps its digits
    let (mut before, mut now) = (0.0, h * first);
    for _ in 1..substeps {
        let next = before + 2.0 * h * rate(start + now);
        (before, now) = (now, next);
    }
    0.5 * (before + now + h * rate(start + now))
}
