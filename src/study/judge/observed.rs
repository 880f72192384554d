//! Comparison of the numbers that two steady runs measure because their case has a table `[observe]`. They are
//! compared by the same rule as the averages that every case has. A variant is one of the experiments of a case.
//!
//! These numbers are tested together, with a separate error level (probability of a false difference) of 1 %, and are
//! no part of the answer for the variants. So a further measurement changes neither this answer nor its probability of
//! error.

use super::words::pair;
use super::{Criteria, averages};
use crate::observe::{Observation, ObservedNumber};
use crate::outcome::Outcome;
use crate::output::ObservedDifference;
use crate::output::numbers::with_error;
use crate::statistics::{Answer, Batches, Estimate, Judged, Observable, compare};

/// Largest number of quantities with the same answer that a sentence names. The table of the report contains all
/// quantities.
const NAMED: usize = 4;

/// Remark on a reference value that is zero within its error, so that differences cannot be divided by it.
const ZERO: &str = "no relative difference: the value is zero within its error";
/// Remark on numbers whose standard error was not computed from averages over intervals of time. The number of
/// independent values is then not known.
const NORMAL: &str = "tested by the normal distribution: the number of independent values is not known";
/// Remark on numbers that are constant in time, such as the wavelength of a pattern that stays. Another run may have
/// another pattern.
const STILL: &str = "no scatter within the runs: --replicas 8 gives errors";
/// Remark on numbers without a standard error.
const SHORT: &str = "no standard error: too few samples";

/// Differences of the numbers that two steady runs measure, in the order of the first run, which is that of the
/// compared variant (experiment of a case). If a run stopped early, the answer "equivalent" becomes "unresolved".
pub(super) fn judge(both: [&Outcome; 2], asked: Criteria) -> Vec<ObservedDifference> {
    let until = both[0].profiles.until.min(both[1].profiles.until);
    let mut found = observed_differences(both.map(|one| one.observations.as_slice()), until, asked);
    // a part of a run cannot show equivalence
    if both.iter().any(|one| one.failure.is_some()) {
        for one in found.iter_mut().filter(|one| one.answer == Some(Answer::Equivalent)) {
            one.answer = Some(Answer::Unresolved);
        }
    }
    found
}

/// Differences of the numbers that two runs share, first run minus second run, with answers by the margin (largest
/// accepted difference) and the error levels of `asked`. Measurements after `until` [s] are left out. A difference is
/// divided by the magnitude of the number in the second run. If this magnitude is zero within its error, only a
/// difference can be shown, and no equivalence.
pub fn observed_differences(runs: [&[Observation]; 2], until: f64, asked: Criteria) -> Vec<ObservedDifference> {
    let shared = shared(runs);
    let (mut own, mut other) = (Vec::new(), Vec::new());
    for (place, one) in shared.iter().enumerate() {
        let [a, b] = [0, 1].map(|k| batches(one.numbers[k], 2 * place + k, until));
        let scale = one.scale();
        let of = |part| averages::number(one.name().into(), one.numbers[0].quantity.unit, (scale, "its value"), part);
        own.push(of(a));
        other.push(of(b));
    }
    let comparison = compare(&own, &other, asked.margin, asked.levels);
    let row = |(one, (a, b)): (&SharedNumber, (&Observable, &Observable))| {
        let judged = comparison.judged.iter().find(|judged| judged.tested.name == a.name);
        one.difference(judged, [a, b])
    };
    shared.iter().zip(own.iter().zip(&other)).map(row).collect()
}

/// Number that two runs measure. Its value is known in both runs.
struct SharedNumber<'a> {
    measurement: &'static str,
    numbers: [&'a ObservedNumber; 2],
    /// Values of the number in the two runs, each with its standard error, in the unit of the number.
    values: [Estimate; 2],
}

impl SharedNumber<'_> {
    /// Name of the number, made of its measurement and its column. No other number of a run has this name.
    fn name(&self) -> String {
        format!("{}, {}", self.measurement, self.numbers[0].quantity.column)
    }

    /// Magnitude of the number in the second run, by which differences are divided, in the unit of the number. It is 0
    /// if the number is zero within its error.
    fn scale(&self) -> f64 {
        if self.values[1].is_zero_within_error() { 0.0 } else { self.values[1].value.abs() }
    }

    /// True if at least one of the two numbers has no averages over intervals of time, unless its standard error is 0.
    /// The number of independent values is then not known, so the standard error is taken as exact.
    fn is_stated(&self) -> bool {
        let each = self.numbers.iter().zip(&self.values);
        each.into_iter().any(|(number, value)| number.batches.is_none() && value.error != Some(0.0))
    }

    /// True if the error of at least one of the two numbers is computed from the scatter in time, and not from the
    /// scatter between replicas (runs with different seeds).
    fn is_of_one_run(&self) -> bool {
        self.numbers.iter().filter_map(|number| number.batches.as_ref()).any(|batches| batches.per_run > 1)
    }

    fn difference(&self, judged: Option<&Judged>, tested: [&Observable; 2]) -> ObservedDifference {
        let scale = self.scale();
        let values = tested.map(|one| one.parts[0].as_ref().and_then(|part| part.values.first().copied()));
        let [a, b] = [0, 1].map(|k| values[k].unwrap_or(self.values[k].value));
        let found = judged.and_then(|one| one.tested.mean);
        let difference =
            Estimate { value: found.map_or(a - b, |one| one.difference), error: found.map(|one| one.error) };
        let still = found.is_some_and(|one| one.error == 0.0) && self.is_of_one_run();
        let answer = judged.map(|one| one.answer).filter(|_| !still);
        let answer = answer.filter(|answer| scale > 0.0 || *answer != Answer::Unresolved);
        let remark = match judged {
            None => SHORT,
            Some(_) if still => STILL,
            Some(_) if scale == 0.0 => ZERO,
            Some(_) if self.is_stated() => NORMAL,
            Some(_) => "",
        };
        let quantity = &self.numbers[0].quantity;
        ObservedDifference {
            measurement: self.measurement,
            quantity: quantity.column.clone(),
            symbol: quantity.symbol.clone(),
            unit: quantity.unit,
            difference,
            percent: (scale > 0.0).then(|| difference.times(100.0 / scale)),
            chance: judged.map(|one| one.tested.chance),
            reached: judged.map(|one| one.reached).filter(|_| scale > 0.0),
            answer,
            remark,
        }
    }
}

/// Numbers that both runs measure and whose values are known in both.
fn shared(runs: [&[Observation]; 2]) -> Vec<SharedNumber<'_>> {
    let mut shared = Vec::new();
    for own in runs[0] {
        let Some(other) = runs[1].iter().find(|other| other.name == own.name) else { continue };
        for number in &own.numbers {
            let same = other.numbers.iter().find(|one| one.quantity.column == number.quantity.column);
            let Some(same) = same else { continue };
            if let (Some(a), Some(b)) = (number.value, same.value) {
                shared.push(SharedNumber { measurement: own.name, numbers: [number, same], values: [a, b] });
            }
        }
    }
    shared
}

/// Averages of a number over intervals (blocks) of time up to `until` [s]. The standard error of a number without
/// blocks is taken as exact; numbers with different values of `place` get independent errors. `None` without a
/// standard error, or if the first block ends after `until`.
fn batches(number: &ObservedNumber, place: usize, until: f64) -> Option<Batches> {
    let stated = || number.value.and_then(|found| Some(Batches::of_stated(found.value, found.error?, place)));
    let blocks = |batches: &Batches| Some(batches.until(until)).filter(|kept| kept.per_run > 0);
    number.batches.as_ref().map_or_else(stated, blocks)
}

/// Sentence on the differences of measured numbers of two variants (experiments of a case) with the given `names`;
/// `None` if there are no such numbers.
pub(super) fn sentence(names: [&String; 2], found: &[ObservedDifference]) -> Option<String> {
    let group = |wanted: Option<Answer>, words: &str| {
        let all: Vec<&ObservedDifference> = found.iter().filter(|one| one.answer == wanted).collect();
        let each = all.iter().take(NAMED).map(|one| match (wanted, one.percent) {
            (Some(Answer::Different), Some(percent)) => format!("{} by {} %", one.symbol, with_error(percent)),
            _ => one.symbol.clone(),
        });
        let more = all.len().saturating_sub(NAMED);
        let more = (more > 0).then(|| format!("{more} more"));
        (!all.is_empty()).then(|| format!("{words} in {}", each.chain(more).collect::<Vec<_>>().join(" · ")))
    };
    let groups = [
        group(Some(Answer::Different), "different"),
        group(Some(Answer::Unresolved), "unresolved"),
        group(Some(Answer::Equivalent), "equivalent"),
        group(None, "without an answer"),
    ];
    let groups: Vec<String> = groups.into_iter().flatten().collect();
    let head = pair(names[0], names[1]);
    (!groups.is_empty())
        .then(|| format!("{head} what is measured under [observe], judged by itself, is {}.", groups.join("; ")))
}
