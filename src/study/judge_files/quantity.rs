//! Averages and curves of one quantity on both sides of a comparison of files, with errors, steadiness and correlation
//! times. Replicas are runs with different seeds.

use super::pairs::ComparedColumns;
use super::settings::JudgedAs;
use super::side::{JudgeSide, SeriesFiles, SideData, TimedTable};
use crate::case::{Diagnostic, Sources};
use crate::output::{Basis, FilesQuantity, SideSummary};
use crate::statistics::{
    Batches, Estimate, FEWEST_RUNS, Observable, Parity, Steadiness, SteadySeries, judge as judge_steadiness,
};
use crate::study::judge::not_steady;

/// Largest number of instants at which the curves of two sides are compared.
const INSTANTS: usize = 20;

/// [-] largest relative difference of two times that count as one instant. Files give times with about six digits.
const SAME_TIME: f64 = 1e-6;

/// One quantity on both sides, as averages or curves that can be tested, with a summary for the report.
pub struct MeasuredQuantity {
    /// Names, units, means and steadiness of both sides for the report.
    pub summary: FilesQuantity,
    /// Averages or curves of both sides with their errors; `None` if nothing can be compared.
    pub observables: Option<[Observable; 2]>,
    /// Reason why nothing can be compared, or why curves are compared instead of averages. Empty without such a
    /// reason.
    pub remark: String,
}

/// Values of a quantity in the file of one replica (run with its own seed) at all its times, in the unit of the
/// comparison.
struct ReplicaValues<'a> {
    file: &'a TimedTable,
    values: Vec<f64>,
}

/// Data of one side of the comparison for one quantity: a series over time for each replica (run with its own seed), or
/// a single value with its error.
enum MeasuredSide<'a> {
    Series(&'a SeriesFiles, Vec<ReplicaValues<'a>>),
    Point(Estimate),
}

/// Reads a quantity on both sides and prepares the comparison of its averages or curves.
///
/// # Errors
/// Returns an error if a cell contains no number, or if the times are not equally spaced, unless the settings ask for
/// curves.
pub fn measure(
    columns: &ComparedColumns,
    sides: &[JudgeSide; 2],
    sources: &Sources,
) -> Result<MeasuredQuantity, Diagnostic> {
    let measured = [0, 1].map(|k| side(columns, k, &sides[k], sources));
    let [a, b] = measured;
    let both = [a?, b?];
    let curves_only = columns.compare == Some(JudgedAs::Curve);
    let averages = [average(columns, 0, &both[0], sources), average(columns, 1, &both[1], sources)];
    // series that are not equally spaced in time have no averages, but may have curves
    let averages = match averages {
        [Ok(a), Ok(b)] => Some([a, b]),
        [Err(_), _] | [_, Err(_)] if curves_only => None,
        [Err(why), _] | [_, Err(why)] => return Err(why),
    };
    let unsteady: Vec<String> = averages
        .iter()
        .flatten()
        .zip(sides)
        .filter_map(|(one, side)| {
            let predicate = not_steady(one.summary.steadiness.as_ref()?)?;
            Some(format!("\"{}\" {predicate}", side.name))
        })
        .collect();
    let mut found = MeasuredQuantity {
        summary: FilesQuantity {
            name: columns.name.clone(),
            unit: columns.unit.clone(),
            margin: columns.margin,
            basis: Basis::Nothing,
            sides: [0, 1].map(|k| match &averages {
                Some(averages) => averages[k].summary.clone(),
                None => bare(columns, k, &both[k]),
            }),
        },
        observables: None,
        remark: unsteady.join(", "),
    };
    match averages {
        Some(averages) if unsteady.is_empty() && !curves_only => {
            found.summary.basis = Basis::Averages;
            found.observables = Some(numbers(columns, &averages));
        }
        _ if columns.compare == Some(JudgedAs::Average) => {}
        _ => match curves(columns, &both) {
            Ok(observables) => {
                found.summary.basis = Basis::Curves;
                found.observables = Some(observables);
            }
            Err(why) => {
                found.remark =
                    [found.remark, why].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ")
            }
        },
    }
    Ok(found)
}

fn side<'a>(
    columns: &ComparedColumns,
    k: usize,
    side: &'a JudgeSide,
    sources: &Sources,
) -> Result<MeasuredSide<'a>, Diagnostic> {
    let (name, factor) = (&columns.columns[k], columns.factors[k]);
    match &side.data {
        SideData::Points(points) => {
            let point = points.iter().find(|point| point.label == *name);
            let estimate = point
                .map_or(Estimate::without_error(f64::NAN), |point| Estimate { value: point.value, error: point.error });
            Ok(MeasuredSide::Point(estimate.times(factor)))
        }
        SideData::Series(series) => {
            let one = |file: &'a TimedTable| {
                let values = file.values(file.table.column(name).unwrap_or_default(), sources)?;
                Ok(ReplicaValues { file, values: values.into_iter().map(|value| value * factor).collect() })
            };
            Ok(MeasuredSide::Series(series, series.replicas.iter().map(one).collect::<Result<_, _>>()?))
        }
    }
}

/// Average of a quantity on one side of the comparison (A or B) over the time in which it is steady, with the averages
/// over equal intervals (blocks) of this time.
struct SideAverage {
    summary: SideSummary,
    batches: Option<Batches>,
}

/// Summary of one side of a quantity before averages are computed. `k` is 0 for side A and 1 for side B.
fn bare(columns: &ComparedColumns, k: usize, side: &MeasuredSide) -> SideSummary {
    let (files, samples) = match side {
        MeasuredSide::Point(_) => (1, 1),
        MeasuredSide::Series(_, replicas) => (replicas.len(), replicas.iter().map(|one| one.values.len()).sum()),
    };
    SideSummary {
        column: columns.columns[k].clone(),
        files,
        samples,
        mean: None,
        from: None,
        correlation_time: None,
        steadiness: None,
    }
}

fn average(
    columns: &ComparedColumns,
    k: usize,
    side: &MeasuredSide,
    sources: &Sources,
) -> Result<SideAverage, Diagnostic> {
    let bare = bare(columns, k, side);
    let (series, replicas) = match side {
        MeasuredSide::Point(point) => {
            let batches = point.error.map(|error| Batches::of_stated(point.value, error, 0));
            return Ok(SideAverage { summary: SideSummary { mean: Some(*point), ..bare }, batches });
        }
        MeasuredSide::Series(series, replicas) => (series, replicas),
    };
    let mut spaced: Vec<(f64, &[f64], &[f64])> = Vec::new();
    for one in replicas {
        let (interval, rows) = one.file.spacing(series.from, sources)?;
        spaced.push((interval, &one.file.times[rows.clone()], &one.values[rows]));
    }
    let steadiness = steadiness(&spaced, series.from, columns.scale);
    let blocks: Option<Vec<Batches>> = spaced
        .iter()
        .map(|(interval, times, values)| {
            let first = times.partition_point(|time| *time < steadiness.from - 0.5 * interval);
            Batches::of_series(&values[first..], *interval, times.get(first).copied()?)
        })
        .collect();
    let blocks = blocks.unwrap_or_default();
    let correlated: Vec<f64> = spaced
        .iter()
        .zip(&blocks)
        .filter_map(|((interval, times, values), blocks)| {
            correlation_time(
                *interval,
                &values[times.partition_point(|time| *time < steadiness.from - 0.5 * interval)..],
                blocks,
            )
        })
        .collect();
    let batches = Batches::pool(&blocks.iter().collect::<Vec<_>>(), false).map(|mut batches| {
        if !series.unit_known {
            // in unknown units, the lengths of the averaged intervals (blocks) cannot be compared with those of the
            // other side
            batches.length = f64::NAN;
        }
        batches
    });
    let summary = SideSummary {
        mean: batches.as_ref().and_then(Batches::estimate),
        from: Some(steadiness.from),
        correlation_time: (!correlated.is_empty()).then(|| correlated.iter().sum::<f64>() / correlated.len() as f64),
        steadiness: Some(steadiness),
        ..bare
    };
    Ok(SideAverage { summary, batches })
}

/// Steadiness of all replicas (runs with different seeds) of a side together. Each entry of `spaced` belongs to one
/// replica: the time between two values, the times, and the values. Averaging begins at `from` or, if it is `None`, at
/// the time from which every replica is steady. Differences are divided by `scale` or, if it is `None`, by the mean of
/// the replica. The side is steady if more than half of its replicas are steady, since one steady run in twenty appears
/// unsteady by chance.
fn steadiness(spaced: &[(f64, &[f64], &[f64])], from: Option<f64>, scale: Option<f64>) -> Steadiness {
    let each: Vec<Steadiness> = spaced
        .iter()
        .map(|(_, times, values)| {
            let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
            let series = SteadySeries { values, scale: scale.unwrap_or(mean.abs()), step: 0.0 };
            judge_steadiness(times, &[series], from)
        })
        .collect();
    let steady = each.iter().filter(|one| one.steady).count();
    let drifts: Option<Vec<f64>> = each.iter().map(|one| one.drift).collect();
    Steadiness {
        from: each.iter().map(|one| one.from).fold(f64::NEG_INFINITY, f64::max),
        steady: 2 * steady > each.len(),
        drift: drifts.and_then(|drifts| drifts.into_iter().reduce(f64::max)),
    }
}

/// Integral correlation time τ of a series, in the unit of `interval`, the time between two values. The mean over a
/// long time L has the variance of one value times 2 τ/L. `None` if the values are all equal, or if their mean has no
/// standard error.
fn correlation_time(interval: f64, values: &[f64], blocks: &Batches) -> Option<f64> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let error = blocks.estimate()?.error?;
    (variance > 0.0).then(|| 0.5 * interval * count * error * error / variance)
}

/// Averages of both sides as observables that can be tested. Differences are divided by the given scale or, without
/// one, by the magnitude of the average of side B.
fn numbers(columns: &ComparedColumns, averages: &[SideAverage; 2]) -> [Observable; 2] {
    let value = averages[1].summary.mean.map_or(0.0, |mean| mean.value.abs());
    let (scale, scale_is) = columns.scale.map_or((value, "its value"), |scale| (scale, "the scale given"));
    [0, 1].map(|k| Observable {
        name: columns.name.clone().into(),
        unit: "",
        places: Vec::new(),
        parity: Parity::Even,
        fixed_mean: false,
        scale,
        scale_is,
        parts: vec![averages[k].batches.clone()],
    })
}

/// Curves over time of both sides as observables that can be tested, or the reason why they cannot be compared.
fn curves(columns: &ComparedColumns, both: &[MeasuredSide; 2]) -> Result<[Observable; 2], String> {
    let [MeasuredSide::Series(first, a), MeasuredSide::Series(second, b)] = both else {
        return Err("a table of points can be compared with a steady side only".into());
    };
    if a.len() < FEWEST_RUNS || b.len() < FEWEST_RUNS {
        return Err(format!("curves over time have errors from {FEWEST_RUNS} files (replicas) of each side on"));
    }
    if !first.unit_known || !second.unit_known {
        return Err("curves over time need `time_unit` for a column that counts steps".into());
    }
    let all: Vec<&ReplicaValues> = a.iter().chain(b).collect();
    let times: Vec<f64> = a[0].file.times.iter().copied().filter(|time| *time > 0.0).collect();
    let times: Vec<f64> = times.into_iter().filter(|time| all.iter().all(|one| one.at(*time).is_some())).collect();
    let count = times.len().min(INSTANTS);
    let times: Vec<f64> = (1..=count).map(|k| times[k * times.len() / count - 1]).collect();
    if times.is_empty() {
        return Err("the files have no instant in common after the start".into());
    }
    let largest = times
        .iter()
        .flat_map(|time| b.iter().filter_map(|one| one.at(*time)))
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    let (scale, scale_is) = columns.scale.map_or((largest, "its largest value"), |scale| (scale, "the scale given"));
    let of = |replicas: &[ReplicaValues]| Observable {
        name: columns.name.clone().into(),
        unit: "",
        places: times.clone(),
        parity: Parity::Neither,
        fixed_mean: false,
        scale,
        scale_is,
        parts: times
            .iter()
            .map(|time| {
                let values: Option<Vec<f64>> = replicas.iter().map(|one| one.at(*time)).collect();
                Some(Batches::of_runs(vec![values?]))
            })
            .collect(),
    };
    Ok([of(a), of(b)])
}

impl ReplicaValues<'_> {
    /// Value of the replica at `time`, in the unit of the comparison. `time` has the unit of the times of the file.
    /// `None` if no row of the file has this time.
    fn at(&self, time: f64) -> Option<f64> {
        let times = &self.file.times;
        let place = times.partition_point(|other| *other < time - SAME_TIME * time.abs());
        times.get(place).filter(|other| (**other - time).abs() <= SAME_TIME * time.abs()).map(|_| self.values[place])
    }
}
