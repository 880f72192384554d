//! Computes the shift of each observable by each factor (change of the case), and judges all shifts together.

use super::plan::{Compared, PlannedFactor, SensitivityPlan};
use crate::outcome::Outcome;
use crate::output::Basis;
use crate::output::sensitivity::{Factor, Shift};
use crate::statistics::{Answer, LEVEL, holm};
use crate::study::judge::{ReplicaRuns, ShiftReference, Shifts, widened};

/// Factors (changes of the case) whose runs are complete, with their shifts and answers, and the names of all other
/// factors. Factors with a shift beyond the margin (largest accepted shift) come first, then unresolved ones; factors
/// whose run stopped come last. `outcomes` has one outcome for each replica (run with its own seed) of each run.
/// `pooled` has one outcome for each run, averaged over its replicas.
pub fn factors(
    plan: &SensitivityPlan,
    pooled: &[Option<Outcome>],
    outcomes: &[Vec<Option<Outcome>>],
    margin: f64,
) -> (Vec<Factor>, Vec<String>) {
    let others: Vec<Vec<Outcome>> =
        outcomes.iter().map(|runs| runs.iter().skip(1).flatten().cloned().collect()).collect();
    let names = |factors: &[PlannedFactor]| factors.iter().map(|factor| factor.name.clone()).collect::<Vec<_>>();
    let runs = |place: usize| Some(ReplicaRuns { outcome: pooled[place].as_ref()?, others: &others[place] });
    let Some(reference) = runs(plan.first()) else { return (Vec::new(), names(&plan.factors)) };
    let ground = ShiftReference::new(reference);
    let (mut found, mut waiting) = (Vec::new(), Vec::new());
    for planned in &plan.factors {
        match factor(plan, planned, &runs, &ground, margin) {
            Some(factor) => found.push(factor),
            None => waiting.push(planned.name.clone()),
        }
    }
    decide(&mut found, margin);
    // the order is: factors whose effect exceeds the margin, unresolved ones, factors below the margin; in each group
    // the largest shift comes first
    let size = |factor: &Factor| factor.headline().map_or(0.0, |shift| shift.share().abs());
    found.sort_by(|a, b| b.answer.cmp(&a.answer).then(size(b).total_cmp(&size(a))));
    // factors with runs that stopped come last, since they have no shifts
    found.sort_by_key(|factor| factor.stopped.is_some());
    (found, waiting)
}

/// Factor with its shifts, before its answer is known; `None` if one of its runs is not complete.
fn factor<'a>(
    plan: &SensitivityPlan,
    planned: &PlannedFactor,
    runs: &impl Fn(usize) -> Option<ReplicaRuns<'a>>,
    ground: &ShiftReference,
    margin: f64,
) -> Option<Factor> {
    let sides = planned.sides();
    let all: Vec<ReplicaRuns> = sides.iter().flatten().map(|place| runs(*place)).collect::<Option<_>>()?;
    let name = |place: &usize| plan.run(*place).name.clone();
    let stopped = all.iter().find_map(|run| {
        let why = run.outcome.failure.as_ref()?;
        Some(format!("\"{}\": {why}", run.outcome.experiment.name))
    });
    let shifts = if stopped.is_some() {
        Shifts { shifts: Vec::new(), basis: Basis::Nothing, doubt: None }
    } else {
        shifts(&planned.compared, runs, ground, margin)?
    };
    Some(Factor {
        name: planned.name.clone(),
        title: planned.title.clone(),
        change: planned.change.clone(),
        why: planned.why.clone(),
        basis: stopped.is_none().then_some(shifts.basis),
        shifts: shifts.shifts,
        runs: sides.map(|side| side.iter().map(name).collect()),
        remarks: shifts.doubt.into_iter().collect(),
        stopped,
        answer: Answer::Unresolved,
    })
}

fn shifts<'a>(
    compared: &Compared,
    runs: &impl Fn(usize) -> Option<ReplicaRuns<'a>>,
    ground: &ShiftReference,
    margin: f64,
) -> Option<Shifts> {
    match compared {
        Compared::Against(base, run) => Some(ground.shifts(&[(1.0, runs(*run)?)], &[(1.0, runs(*base)?)], margin)),
        Compared::Extrapolated(places) => {
            let line = LineFit::new(&places.iter().map(|place| place.1).collect::<Vec<_>>());
            let all: Vec<ReplicaRuns> = places.iter().map(|place| runs(place.0)).collect::<Option<_>>()?;
            let [of, against] = split(&line.to_zero, &all);
            let found = ground.shifts(&of, &against, margin);
            let [above, below] = split(&line.miss, &all);
            let misses = ground.misses(&above, &below, margin);
            Some(Shifts { shifts: widened(found.shifts, &misses, line.share), ..found })
        }
    }
}

/// Positive and negative part of a weighted sum of runs: the runs with positive weights, and those with negative
/// weights, each with the magnitude of its weight.
fn split<'a>(weights: &[f64], runs: &[ReplicaRuns<'a>]) -> [Vec<(f64, ReplicaRuns<'a>)>; 2] {
    let side = |sign: f64| -> Vec<(f64, ReplicaRuns<'a>)> {
        let all = weights.iter().zip(runs).map(|(weight, run)| (sign * weight, *run));
        all.filter(|(weight, _)| *weight > 0.0).collect()
    };
    [side(1.0), side(-1.0)]
}

/// Straight line through values at given positions, fitted by least squares with equal weights.
struct LineFit {
    /// Weights of the values. The weighted sum of the values is the value of the line at position 0 minus that at
    /// position 1.
    to_zero: Vec<f64>,
    /// Weights of three values. The weighted sum of the values is the deviation of the second value from the line
    /// through the first and the third.
    miss: Vec<f64>,
    /// [-] standard error of the slope for three values that have no error but their distance from the fitted line. It
    /// is divided by the deviation of the second value from the line through the first and the third.
    share: f64,
}

impl LineFit {
    fn new(places: &[f64]) -> Self {
        let count = places.len() as f64;
        let centre = places.iter().sum::<f64>() / count;
        let square = places.iter().map(|place| (place - centre).powi(2)).sum::<f64>();
        let to_zero = places.iter().map(|place| -(place - centre) / square).collect();
        let mut miss = vec![0.0; places.len()];
        if let [first, second, third] = places {
            let part = (second - first) / (third - first);
            miss = vec![-(1.0 - part), 1.0, -part];
        }
        // for three values, the sum of squared residuals of the fit is the square of the weighted sum of the values,
        // divided by the sum of the squared weights `miss`
        let norm = miss.iter().map(|weight| weight * weight).sum::<f64>();
        Self { to_zero, miss, share: (1.0 / (norm * square)).sqrt() }
    }
}

/// Sets the answers of all shifts and of all factors. Holm's procedure, applied to all shifts together, limits the
/// probability of a false difference.
fn decide(factors: &mut [Factor], margin: f64) {
    let chances: Vec<f64> = factors.iter().flat_map(|factor| &factor.shifts).filter_map(|shift| shift.chance).collect();
    let mut detected = holm(&chances, LEVEL).into_iter();
    for factor in factors {
        let doubted = !factor.remarks.is_empty();
        for shift in &mut factor.shifts {
            let detected = shift.chance.is_some() && detected.next().unwrap_or(false);
            shift.answer = answer(shift, detected && !doubted, doubted, margin);
        }
        factor.answer = factor.shifts.iter().map(|shift| shift.answer).max().unwrap_or(Answer::Unresolved);
    }
}

fn answer(shift: &Shift, detected: bool, doubted: bool, margin: f64) -> Answer {
    let within = shift.reached.is_some_and(|reached| reached < margin);
    match (within && !doubted, detected) {
        (true, _) => Answer::Equivalent,
        (false, true) => Answer::Different,
        (false, false) => Answer::Unresolved,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_followed_to_its_end_and_a_miss_is_seen() {
        let line = LineFit::new(&[1.0, 2.0, 4.0]);
        let dot = |weights: &[f64], values: [f64; 3]| weights.iter().zip(values).map(|(w, v)| w * v).sum::<f64>();
        // line 7 - 0.5 x: its value at 0 is 0.5 higher than at 1
        let on_it = [6.5, 6.0, 5.0];
        assert!((dot(&line.to_zero, on_it) - 0.5).abs() < 1e-12 && dot(&line.miss, on_it).abs() < 1e-12);
        // the slope of a bent line has the squared error of least squares, s²/Σ(x - <x>)², with s² the sum of squared
        // residuals
        let bent = [0.0, 1.0, 0.0];
        let miss = dot(&line.miss, bent);
        let slope = -dot(&line.to_zero, bent);
        let middle = 1.0 / 3.0;
        let residual: f64 =
            [1.0, 2.0, 4.0].iter().zip(bent).map(|(x, y)| (y - middle - slope * (x - 7.0 / 3.0)).powi(2)).sum();
        let square: f64 = [1.0, 2.0, 4.0].iter().map(|x: &f64| (x - 7.0 / 3.0).powi(2)).sum();
        assert!((miss - 1.0).abs() < 1e-12 && (line.share * miss - (residual / square).sqrt()).abs() < 1e-12);
    }
}
