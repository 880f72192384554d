//! Comparison of the averages of a steady run with a table of values, such as measurements. A variant is one of the
//! experiments of a case.

use super::averages::{number, scale};
use super::{Criteria, Finding, how_it_stopped, longer, stopped, unsteady, words};
use crate::experiment::{Reference, ReferencePoint, ReferenceTable};
use crate::outcome::Outcome;
use crate::output::{Basis, Verdict};
use crate::statistics::{Answer, Batches, Observable, Parity, SliceColumn, U, compare, slice_column};

/// Compares the averages of a variant (experiment of a case) with the table of values that the case gives as its
/// reference. `None` if the case gives no table.
pub fn judge(outcome: &Outcome, asked: Criteria) -> Option<Verdict> {
    let Some(Reference::Table(table)) = &outcome.experiment.against else { return None };
    let found = stopped(&[outcome], found(outcome, table, asked));
    let name = &outcome.experiment.name;
    Some(Verdict {
        variant: name.clone(),
        reference: table.name.clone(),
        answer: found.answer,
        basis: found.basis,
        sentence: format!("{} {}", words::pair(name, &table.name), found.sentence),
        reason: found.reason,
        margin: asked.margin,
        comparison: found.comparison,
        observed: Vec::new(),
        further: how_it_stopped(outcome).into_iter().collect(),
    })
}

fn found(outcome: &Outcome, table: &ReferenceTable, asked: Criteria) -> Finding {
    let pairs = if outcome.steadiness.steady { observables(outcome, table) } else { Vec::new() };
    if pairs.is_empty() {
        let why = match outcome.steadiness.steady {
            true => "the run has no average of a quantity of the table".into(),
            false => unsteady(&[outcome]),
        };
        return Finding {
            answer: Answer::Unresolved,
            basis: Basis::Nothing,
            sentence: format!("unresolved: {why}."),
            reason: "Averages of a steady run can be compared with a table.".into(),
            comparison: None,
        };
    }
    let (own, stated): (Vec<Observable>, Vec<Observable>) = pairs.into_iter().unzip();
    let comparison = compare(&own, &stated, asked.margin, asked.levels);
    Finding {
        answer: comparison.answer,
        basis: Basis::Averages,
        sentence: words::answer(&comparison, "m", |stretch| longer(outcome, stretch)),
        reason: "The run is steady while it is averaged: averages over time are compared with the values of the table, at their standard errors.".into(),
        comparison: Some(comparison),
    }
}

/// Pairs of observables, the first from the run and the second from the table. There is one pair for each profile, and
/// one for each average over the scene. A value of a profile in the table is compared with the slice of the box at its
/// height y.
fn observables(outcome: &Outcome, table: &ReferenceTable) -> Vec<(Observable, Observable)> {
    let mut pairs = Vec::new();
    let numbered: Vec<(usize, &ReferencePoint)> = table.points.iter().enumerate().collect();
    let mut names: Vec<&str> = Vec::new();
    for (_, point) in &numbered {
        if !names.contains(&point.quantity.as_str()) {
            names.push(&point.quantity);
        }
    }
    for name in names {
        let points: Vec<(usize, &ReferencePoint)> =
            numbered.iter().copied().filter(|(_, point)| point.quantity == name).collect();
        match slice_column(name) {
            Some(column) => pairs.extend(profile(outcome, column, points)),
            None => pairs.extend(points.into_iter().filter_map(|point| average(outcome, point))),
        }
    }
    pairs
}

/// Profile of the run and profile of the table as two observables. Differences of velocities are divided by a velocity
/// of the run, such as the mean slip, because velocities depend on the frame of reference. `None` if the divisor is not
/// known, for example without a measured velocity, or if it is not positive.
fn profile(
    outcome: &Outcome,
    column: SliceColumn,
    mut points: Vec<(usize, &ReferencePoint)>,
) -> Option<(Observable, Observable)> {
    let magnitudes = points.iter().map(|(_, point)| point.value.abs());
    let of_table = magnitudes.sum::<f64>() / points.len() as f64;
    let (scale, scale_is) =
        if column == U { scale(&U, outcome)? } else { (of_table, "the mean magnitude in the table") };
    if scale <= 0.0 {
        return None;
    }
    points.sort_by(|(_, one), (_, other)| one.y.unwrap_or_default().total_cmp(&other.y.unwrap_or_default()));
    let slices = &outcome.profiles.slices;
    let thickness = outcome.experiment.scene.domain.size.y / slices.len() as f64;
    let slice_of = |y: f64| ((y / thickness) as usize).min(slices.len() - 1);
    let of = |parts: Vec<Option<Batches>>| Observable {
        name: column.name.into(),
        unit: column.unit,
        places: points.iter().map(|(_, point)| point.y.unwrap_or_default()).collect(),
        parity: Parity::Neither,
        fixed_mean: false,
        scale,
        scale_is,
        parts,
    };
    let own = |(_, point): &(usize, &ReferencePoint)| {
        outcome.profiles.batches(slice_of(point.y.unwrap_or_default()), column).cloned()
    };
    Some((of(points.iter().map(own).collect()), of(points.iter().map(|point| stated(*point)).collect())))
}

/// Average over the whole scene, from the run and from the table. Differences are divided by the value of the table.
/// `None` if the run does not have this average.
fn average(outcome: &Outcome, (place, point): (usize, &ReferencePoint)) -> Option<(Observable, Observable)> {
    let averaged = &outcome.averaged;
    let (name, unit, own) = match point.quantity.as_str() {
        "granular_temperature" => ("granular temperature", "m²/s²", &averaged.temperature),
        "pair_impact_rate" => ("pair impacts per time", "1/s", &averaged.pair_rate),
        _ => ("wall impacts per time", "1/s", &averaged.wall_rate),
    };
    own.as_ref()?;
    let of = |part| number(name.into(), unit, (point.value.abs(), "the value of the table"), part);
    Some((of(own.clone()), of(stated((place, point)))))
}

/// Value of the table with its standard error, converted to the type in which averages of runs are tested. `place` is
/// the index of the point in the table; points with different indices get independent errors. `None` if the table gives
/// no standard error.
fn stated((place, point): (usize, &ReferencePoint)) -> Option<Batches> {
    point.standard_error.map(|error| Batches::of_stated(point.value, error, place))
}
