//! Comparison of two variants with many particles whose runs are not steady: curves over time are compared, with errors
//! from replicas (runs with different seeds). A variant is one of the experiments of a case.

use super::words::{self, in_prose, percent};
use super::{Criteria, Finding, ReplicaRuns, unsteady};
use crate::observe::{CurveScale, KindCurve, Row, SERIES_COLUMNS, SeriesColumn};
use crate::outcome::Outcome;
use crate::output::Basis;
use crate::output::numbers::{quantity, significant};
use crate::statistics::{Answer, Batches, LEVEL, Observable, Parity, compare, two_sided};
use std::borrow::Cow;

/// Largest number of instants at which two curves are compared. So many instants show the shape of a curve. More
/// instants would make the test at each of them less sensitive.
const INSTANTS: usize = 20;

/// Smallest number of replicas (runs with different seeds) of each variant (experiment of a case) from which a curve
/// gets standard errors.
pub const FEWEST: usize = 3;

/// Number of replicas (runs with different seeds) that is recommended if each variant (experiment of a case) has one
/// run. Student's t then has 14 degrees of freedom.
const ADVISED: usize = 8;

/// Number of particles that are assumed to move together as a group when single runs are compared. For particles that
/// move independently, the number would be 1. This larger number allows for more chance, so that the answer
/// "different" is not given too soon.
const CLUMP: f64 = 100.0;

/// Columns of the time series that are compared as curves over time. These are all columns that have a rule (`scale`)
/// for the value by which differences are divided.
fn curves() -> impl Iterator<Item = &'static SeriesColumn> {
    SERIES_COLUMNS.iter().filter(|column| column.scale.is_some())
}

/// [m/s] agitation at one instant: root of the granular temperature of all particles; `None` if it is not known.
fn agitation(row: &Row) -> Option<f64> {
    row.granular_temperature().map(|temperature| temperature.max(0.0).sqrt())
}

/// Compares the curves over time of two variants (experiments of a case) that are not steady, at instants at which all
/// their runs were measured. `runs` has the replicas (runs with different seeds) of the variant, then those of its
/// reference.
pub fn judge(runs: &[ReplicaRuns; 2], asked: Criteria) -> Finding {
    let all: [Vec<&Outcome>; 2] = [0, 1].map(|k| std::iter::once(runs[k].outcome).chain(runs[k].others).collect());
    let why = unsteady(&[runs[0].outcome, runs[1].outcome]);
    let times = common(&all);
    if times.is_empty() {
        return nothing(&why);
    }
    if all.iter().any(|runs| runs.len() < FEWEST) {
        return single(runs[0].outcome, runs[1].outcome, &times, &why);
    }
    let observables = [0, 1].map(|k| observables(&all[k], &all[1], &times));
    let comparison = compare(&observables[0], &observables[1], asked.margin, asked.levels);
    let count = all[0].len().min(all[1].len()) as f64;
    let needed = |stretch: f64| format!("{} replicas", significant((stretch * count).ceil(), 2));
    Finding {
        answer: comparison.answer,
        basis: Basis::Curves,
        sentence: words::answer(&comparison, "s", needed),
        reason: format!(
            "{why}: curves over time are compared, with errors from {} and {} replicas.",
            all[0].len(),
            all[1].len()
        ),
        comparison: Some(comparison),
    }
}

fn nothing(why: &str) -> Finding {
    Finding {
        answer: Answer::Unresolved,
        basis: Basis::Nothing,
        sentence: format!(
            "unresolved: {why}, and the runs have no instant in common at which something could be compared."
        ),
        reason: "Nothing could be compared.".into(),
        comparison: None,
    }
}

/// Row of the time series of a run at the simulated time `time` [s]; `None` if nothing was measured at this time.
fn row_at(run: &Outcome, time: f64) -> Option<&Row> {
    let rows = &run.series.rows;
    let place = rows.partition_point(|row| row.time < time * (1.0 - 1e-9));
    rows.get(place).filter(|row| (row.time - time).abs() <= 1e-9 * time)
}

/// [s] instants after the start at which curves are compared: at most 20 instants at which all runs were measured.
pub fn common(all: &[Vec<&Outcome>]) -> Vec<f64> {
    let Some(first) = all.iter().flatten().next() else { return Vec::new() };
    let runs: Vec<&&Outcome> = all.iter().flatten().collect();
    let times = first.series.rows.iter().map(|row| row.time).filter(|time| *time > 0.0);
    let times: Vec<f64> = times.filter(|&time| runs.iter().all(|run| row_at(run, time).is_some())).collect();
    let count = times.len().min(INSTANTS);
    (1..=count).map(|k| times[k * times.len() / count - 1]).collect()
}

/// Curves over time of all `runs` of a variant (experiment of a case), for all particles and for each species. Curves
/// that the `references` lack are left out. `times` [s] are the instants of the curves.
pub fn observables(runs: &[&Outcome], references: &[&Outcome], times: &[f64]) -> Vec<Observable> {
    let kinds = references.first().map_or(&[][..], |reference| &reference.kinds.curves);
    let of_kinds = kinds.iter().filter_map(|curve| of_kind(curve, runs, references, times));
    curves().filter_map(|curve| observable(curve, runs, references, times)).chain(of_kinds).collect()
}

/// One curve over time of all `runs` of a variant (experiment of a case), at the instants `times` [s]. `None` if the
/// `references` do not have this curve, or if the curve is zero in all `references`.
fn observable(curve: &SeriesColumn, runs: &[&Outcome], references: &[&Outcome], times: &[f64]) -> Option<Observable> {
    let scale = scale(curve, references, times)?;
    let value = |run: &Outcome, time| (curve.of)(row_at(run, time)?);
    let of = Of { name: curve.name.into(), unit: curve.unit, scale, is_sum: curve.is_sum };
    Some(of.observable(value, runs, references, times))
}

fn of_kind(curve: &KindCurve, runs: &[&Outcome], references: &[&Outcome], times: &[f64]) -> Option<Observable> {
    let value = |run: &Outcome, time: f64| run.kinds.curves.iter().find(|own| own.name == curve.name)?.at(time);
    let all = references.iter().flat_map(|run| times.iter().filter_map(|&time| value(run, time)));
    let scale = all.fold(0.0_f64, |most, value| most.max(value.abs()));
    let of = Of { name: curve.name.clone().into(), unit: curve.unit, scale, is_sum: curve.sum };
    (scale > 0.0).then(|| of.observable(value, runs, references, times))
}

/// Name and unit of a curve over time, and the scale by which differences of the curve are divided. If the values are
/// sums over particles (`is_sum`), they are scaled to the number of particles of the reference.
struct Of {
    name: Cow<'static, str>,
    unit: &'static str,
    scale: f64,
    is_sum: bool,
}

impl Of {
    fn observable(
        self,
        value: impl Fn(&Outcome, f64) -> Option<f64>,
        runs: &[&Outcome],
        references: &[&Outcome],
        times: &[f64],
    ) -> Observable {
        let number = references.first().map_or(0, |reference| reference.particles) as f64;
        let share = |run: &Outcome| if self.is_sum { number / run.particles.max(1) as f64 } else { 1.0 };
        let part = |&time: &f64| {
            let values: Option<Vec<f64>> = runs.iter().map(|run| Some(share(run) * value(run, time)?)).collect();
            Some(Batches::of_runs(vec![values?]))
        };
        Observable {
            parts: times.iter().map(part).collect(),
            name: self.name,
            unit: self.unit,
            places: times.to_vec(),
            parity: Parity::Neither,
            fixed_mean: false,
            scale: self.scale,
            scale_is: "its largest value",
        }
    }
}

/// Scale of a curve, in the unit of the curve; differences are divided by it. It is the largest magnitude in the
/// reference. For a velocity it is the largest change or, if larger, the largest agitation. `None` if the scale is 0.
fn scale(curve: &SeriesColumn, references: &[&Outcome], times: &[f64]) -> Option<f64> {
    let rows = || references.iter().flat_map(|run| times.iter().filter_map(|&time| row_at(run, time)));
    let largest = |of: fn(&Row) -> Option<f64>, start: f64| {
        rows().filter_map(of).fold(0.0_f64, |most, value| most.max((value - start).abs()))
    };
    // a velocity depends on the frame of reference, but its change does not
    let first = references.first().and_then(|run| (curve.of)(run.series.rows.first()?));
    let by_change = curve.scale == Some(CurveScale::LargestChange);
    let start = first.filter(|_| by_change).unwrap_or(0.0);
    let scale = largest(curve.of, start).max(if by_change { largest(agitation, 0.0) } else { 0.0 });
    (scale > 0.0).then_some(scale)
}

/// Compares two variants (experiments of a case) with one run each. A single run has no error bar, but a difference
/// may exceed the largest one that is possible by chance. If N groups of particles move independently, temperature and
/// energy scatter by sqrt(2/(3N)) of their values. A group is assumed to have [`CLUMP`] particles.
fn single(variant: &Outcome, reference: &Outcome, times: &[f64], why: &str) -> Finding {
    let clumps = variant.particles.min(reference.particles) as f64 / CLUMP;
    let scatter = (2.0 / (3.0 * clumps)).sqrt();
    let mut clearest: Option<(f64, f64, &SeriesColumn, f64)> = None;
    let mut widest: Option<(f64, f64, &SeriesColumn)> = None;
    for curve in curves().filter(|curve| ["granular temperature", "energy"].contains(&curve.name)) {
        let Some(scale) = scale(curve, &[reference], times) else { continue };
        for &time in times {
            let values = [variant, reference].map(|run| row_at(run, time).and_then(curve.of));
            let [Some(a), Some(b)] = values else { continue };
            let share = (a - b) / scale;
            let chance = two_sided((a - b) / (scatter * a.hypot(b)), f64::INFINITY) * 2.0 * times.len() as f64;
            if clearest.is_none_or(|(least, ..)| chance < least) {
                clearest = Some((chance, share, curve, time));
            }
            if widest.is_none_or(|(most, ..)| share.abs() > f64::abs(most)) {
                widest = Some((share, time, curve));
            }
        }
    }
    let advice = format!("--replicas {ADVISED} gives errors");
    let named = |share: f64, curve: &SeriesColumn, time: f64| {
        format!("{} in {} at t = {}", percent(share), in_prose(curve.name), quantity(time, "s", 3))
    };
    let (answer, sentence) = match (clearest, widest) {
        (Some((chance, ..)), Some((share, time, curve))) if chance <= LEVEL => (
            Answer::Different,
            format!(
                "different by {} of its largest value: more than chance could do even if {CLUMP} particles at a time moved as one ({advice}).",
                named(share, curve, time)
            ),
        ),
        (_, Some((share, time, curve))) => (
            Answer::Unresolved,
            format!(
                "unresolved: {why}, and of one run each nothing is known of the error of a curve over time; they are apart by {} at most, in per cent of the largest value ({advice}).",
                named(share, curve, time)
            ),
        ),
        _ => return nothing(why),
    };
    let reason = format!("{why}: curves over time are compared.");
    Finding { answer, basis: Basis::Curves, sentence, reason, comparison: None }
}
