//! Shift of each observable by a change of the case: one number per observable, so that the effects of several changes
//! can be compared.
//!
//! In steady runs the shift is that of a mean over the channel, of the number density at the walls, of the temperature
//! or of a rate. In other runs with many particles it is that of a curve over time, at the most significant instant or
//! in the mean. With few bodies it is that of velocities and positions at one instant. Weighted sums of runs can be
//! compared as well, such as the slope of a line through several runs.

use super::paths::{self, Horizon};
use super::{ReplicaRuns, averages, curves};
use crate::outcome::Outcome;
use crate::output::Basis;
use crate::output::sensitivity::Shift;
use crate::statistics::{
    Answer, Batches, Deviation, EQUIVALENCE_LEVEL, ErrorLevels, Judged, Observable, Parity, Tested, compare,
    student_bound, two_sided,
};

/// Weighted sum of several runs. Each entry has the weight [-] of a run, and the outcomes of its replicas (runs with
/// different seeds). The observables of the runs are summed with these weights.
pub type Mix<'a> = [(f64, ReplicaRuns<'a>)];

/// Runs of the unchanged case. They determine the kind of comparison for all changes: paths, averages or curves.
pub struct ShiftReference<'a> {
    runs: ReplicaRuns<'a>,
    basis: Basis,
    /// Time up to which paths can be predicted; `None` if the runs do not have recorded paths.
    horizon: Option<Horizon>,
}

/// Function that selects one of the differences found for an observable as its shift, such as the mean difference. It
/// returns `None` if the observable has no such difference.
type ShiftColumn = fn(&Tested) -> Option<Deviation>;

/// Shifts (differences from the unchanged case) of several observables by one change of the case, and the kind of
/// comparison by which they were found.
pub struct Shifts {
    /// Shifts (differences from the unchanged case), one per observable.
    pub shifts: Vec<Shift>,
    /// Kind of comparison by which the shifts were found: paths, averages or curves.
    pub basis: Basis,
    /// Reason why the shifts allow no conclusion; `None` if there is no such reason.
    pub doubt: Option<String>,
}

impl<'a> ShiftReference<'a> {
    /// Makes a reference from the runs of the unchanged case. Chooses the kind of comparison (paths, averages or
    /// curves) that is valid for these runs.
    pub fn new(runs: ReplicaRuns<'a>) -> Self {
        let outcome = runs.outcome;
        let few = !outcome.paths.points.is_empty();
        let horizon = few.then(|| paths::horizon(outcome));
        let steady = outcome.steadiness.steady;
        let basis = match &horizon {
            Some(horizon) if !(steady && horizon.is_chaotic()) => Basis::Paths,
            _ if steady => Basis::Averages,
            _ => Basis::Curves,
        };
        Self { runs, basis, horizon }
    }

    /// Shifts of the observables: the weighted sum of runs `of` minus the weighted sum `against`. Weights are
    /// positive, and their totals are equal in both sums. The shift of a curve over time is its mean difference or its
    /// difference at one instant, whichever is more significant. `margin` [-] is the largest difference that counts as
    /// equivalent.
    pub fn shifts(&self, of: &Mix, against: &Mix, margin: f64) -> Shifts {
        self.found([of, against], margin, Tested::headline)
    }

    /// Differences of two weighted sums of runs that should be equal, such as the deviations of runs from a straight
    /// line. For a curve over time the mean difference is returned, since the largest difference over all instants is
    /// never zero. `margin` [-] is the largest difference that counts as equivalent.
    pub fn misses(&self, of: &Mix, against: &Mix, margin: f64) -> Vec<Shift> {
        self.found([of, against], margin, |tested| tested.mean).shifts
    }

    fn found(&self, [of, against]: [&Mix; 2], margin: f64, pick: ShiftColumn) -> Shifts {
        let all_steady = of.iter().chain(against).all(|(_, runs)| runs.outcome.steadiness.steady);
        let mut found = match (self.basis, &self.horizon) {
            (Basis::Paths, Some(horizon)) => self.paths(of, against, horizon),
            (Basis::Averages, _) if all_steady => self.averages([of, against], margin, pick),
            (Basis::Averages | Basis::Curves | Basis::Paths | Basis::Nothing, _) => {
                self.curves([of, against], margin, pick)
            }
        };
        if ends(of) == ends(against) {
            found.doubt = None;
            found.shifts.iter_mut().for_each(nothing);
        }
        found
    }

    fn averages(&self, [of, against]: [&Mix; 2], margin: f64, pick: ShiftColumn) -> Shifts {
        let each = |mix: &Mix| -> Vec<(f64, Vec<Observable>)> {
            let one = |(weight, runs): &(f64, ReplicaRuns)| {
                let [own, _] = averages::observables(runs.outcome, self.runs.outcome);
                (*weight, own.iter().filter_map(number).collect())
            };
            mix.iter().map(one).collect()
        };
        let frozen = of.iter().chain(against).find(|(_, runs)| {
            super::frozen([runs.outcome, runs.outcome]).is_some() && runs.others.len() + 1 < curves::FEWEST
        });
        let name = |(_, runs): &(f64, ReplicaRuns)| runs.outcome.experiment.name.clone();
        let doubt = frozen.map(|one| format!("particles of \"{}\" keep their places: see --replicas", name(one)));
        Shifts { shifts: judged([&sum(&each(of)), &sum(&each(against))], margin, pick), basis: Basis::Averages, doubt }
    }

    fn curves(&self, [of, against]: [&Mix; 2], margin: f64, pick: ShiftColumn) -> Shifts {
        let reference = all_of(&self.runs);
        let mixes = of.iter().chain(against).map(|(_, runs)| all_of(runs));
        let groups: Vec<Vec<&Outcome>> = mixes.chain([reference.clone()]).collect();
        let times = curves::common(&groups);
        let each = |mix: &Mix| -> Vec<(f64, Vec<Observable>)> {
            let one =
                |(weight, runs): &(f64, ReplicaRuns)| (*weight, curves::observables(&all_of(runs), &reference, &times));
            mix.iter().map(one).collect()
        };
        let shifts = judged([&sum(&each(of)), &sum(&each(against))], margin, pick);
        let doubt = shifts.iter().all(|shift| shift.error.is_none()).then(|| {
            "of so few runs of something that is not steady nothing is known of the error: see --replicas".to_owned()
        });
        Shifts { shifts, basis: Basis::Curves, doubt }
    }

    fn paths(&self, of: &Mix, against: &Mix, horizon: &Horizon) -> Shifts {
        let signed: Vec<(f64, &Outcome)> = of
            .iter()
            .map(|(weight, runs)| (*weight, runs.outcome))
            .chain(against.iter().map(|(weight, runs)| (-weight, runs.outcome)))
            .collect();
        match paths::apart(&signed, self.runs.outcome, horizon) {
            Ok(apart) => {
                let shift = |observable: &str, unit, scale, difference: f64| Shift {
                    observable: observable.to_owned(),
                    unit,
                    scale,
                    scale_is: if unit == "m/s" { "the largest speed" } else { "the largest speed times the time" },
                    difference,
                    error: Some(0.0),
                    freedom: None,
                    time: Some(apart.time),
                    chance: Some(f64::from(u8::from(difference == 0.0))),
                    reached: Some(difference / scale),
                    stretch: None,
                    answer: Answer::Unresolved,
                };
                let shifts = vec![
                    shift("velocity of one particle", "m/s", apart.speed, apart.velocity),
                    shift("place of one particle", "m", apart.speed * apart.time, apart.place),
                ];
                Shifts { shifts, basis: Basis::Paths, doubt: None }
            }
            Err(why) => Shifts { shifts: Vec::new(), basis: Basis::Paths, doubt: Some(why) },
        }
    }
}

/// Checksums of the final states of all runs in a weighted sum. Runs with equal checksums are taken to be equal bit for
/// bit.
fn ends(mix: &Mix) -> Vec<u64> {
    mix.iter().flat_map(|(_, runs)| all_of(runs)).map(|run| run.final_state_hash).collect()
}

/// Sets a shift (difference) and its error to exactly zero, for runs that are equal bit for bit.
fn nothing(shift: &mut Shift) {
    shift.difference = 0.0;
    shift.error = Some(0.0);
    shift.chance = Some(1.0);
    shift.reached = Some(0.0);
}

fn all_of<'a>(runs: &ReplicaRuns<'a>) -> Vec<&'a Outcome> {
    std::iter::once(runs.outcome).chain(runs.others).collect()
}

/// Observable with one number in place of a profile: the mean of the profile over the slices of the box across y. If
/// the profile changes sign at the mid-plane, the number is half the difference between the means of the two halves.
/// For the density it is the mean of the two slices at the walls, or the first slice of a profile that is not
/// symmetric. An observable that is a single number is returned unchanged. If no slice has a value, the returned
/// observable has none either. The result is never `None`.
fn number(profile: &Observable) -> Option<Observable> {
    let count = profile.places.len();
    if count == 0 {
        return Some(profile.clone());
    }
    let weight = |slice: usize| match (profile.fixed_mean, profile.parity) {
        (true, Parity::Even) if slice == 0 || slice + 1 == count => 0.5,
        (true, Parity::Odd | Parity::Neither) if slice == 0 => 1.0,
        (true, _) => 0.0,
        (false, Parity::Odd) if 2 * slice + 1 == count => 0.0,
        (false, Parity::Odd) if 2 * slice + 1 < count => 1.0,
        (false, Parity::Odd) => -1.0,
        (false, Parity::Even | Parity::Neither) => 1.0,
    };
    let known: Vec<(f64, &Batches)> = (0..count)
        .filter(|&slice| weight(slice) != 0.0)
        .filter_map(|slice| Some((weight(slice), profile.parts[slice].as_ref()?)))
        .collect();
    let whole: f64 = known.iter().map(|(weight, _)| weight.abs()).sum();
    let row = known.iter().map(|(weight, _)| weight / whole).collect();
    let one = Batches::join(known.into_iter().map(|(_, part)| part)).map(|joined| joined.project(&[row]));
    Some(Observable {
        name: if profile.fixed_mean { "number density at the wall".into() } else { profile.name.clone() },
        places: Vec::new(),
        parity: Parity::Even,
        fixed_mean: false,
        parts: vec![one],
        ..profile.clone()
    })
}

/// Sums the observables of several runs, each multiplied by the weight [-] of its run.
fn sum(each: &[(f64, Vec<Observable>)]) -> Vec<Observable> {
    let Some((weight, first)) = each.first() else { return Vec::new() };
    if each.len() == 1 && *weight == 1.0 {
        return first.clone();
    }
    let one = |(place, observable): (usize, &Observable)| {
        let part = |k: usize| {
            let parts: Option<Vec<(f64, &Batches)>> =
                each.iter().map(|(weight, all)| Some((*weight, all.get(place)?.parts.get(k)?.as_ref()?))).collect();
            Batches::sum(&parts?)
        };
        Observable { parts: (0..observable.parts.len()).map(part).collect(), ..observable.clone() }
    };
    first.iter().enumerate().map(one).collect()
}

/// Tests two lists of the same observables, and returns the shift of each. `pick` selects the shift among the
/// differences found for one observable.
fn judged([a, b]: [&[Observable]; 2], margin: f64, pick: ShiftColumn) -> Vec<Shift> {
    let comparison = compare(a, b, margin, ErrorLevels::default());
    let one = |(a, b): (&Observable, &Observable)| {
        let known = comparison.judged.iter().find(|judged| judged.tested.name == a.name);
        known.and_then(|judged| Some(shift(judged, pick(&judged.tested)?))).or_else(|| without_error(a, b))
    };
    a.iter().zip(b).filter_map(one).collect()
}

fn shift(judged: &Judged, found: Deviation) -> Shift {
    Shift {
        observable: judged.tested.name.to_string(),
        unit: judged.tested.unit,
        scale: judged.tested.scale,
        scale_is: judged.tested.scale_is,
        difference: found.difference,
        error: Some(found.error),
        freedom: Some(found.freedom),
        time: found.place,
        chance: Some(judged.tested.chance),
        reached: Some(judged.reached),
        stretch: Some(judged.stretch),
        answer: Answer::Unresolved,
    }
}

/// Shift of an observable without error bars: its largest difference over all positions or instants. `None` if no
/// difference is known.
fn without_error(a: &Observable, b: &Observable) -> Option<Shift> {
    let difference = |k: usize| {
        let [a, b] = [a, b].map(|one| one.parts.get(k)?.as_ref()?.values.first().copied());
        Some((k, a? - b?))
    };
    let all = (0..a.parts.len()).filter_map(difference);
    let (place, difference) = all.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    Some(Shift {
        observable: a.name.to_string(),
        unit: a.unit,
        scale: a.scale,
        scale_is: a.scale_is,
        difference,
        error: None,
        freedom: None,
        time: a.places.get(place).copied(),
        chance: None,
        reached: None,
        stretch: None,
        answer: Answer::Unresolved,
    })
}

/// Increases the errors of shifts (differences) that are found from a straight line through several runs, if the runs
/// do not lie on the line. For each observable, `misses` has the distance of one run from the line, with the error of
/// this distance. If the distance is larger than its error, the error of the shift is multiplied by their ratio. If
/// the error of the distance is 0, the distance times `share` [-] is added to the error of the shift.
pub fn widened(shifts: Vec<Shift>, misses: &[Shift], share: f64) -> Vec<Shift> {
    let one = |mut shift: Shift| {
        let miss = misses.iter().find(|miss| miss.observable == shift.observable);
        let Some((miss, error, missed)) = miss.and_then(|miss| Some((miss, shift.error?, miss.error?))) else {
            return shift;
        };
        let more = if missed > 0.0 {
            ((miss.difference / missed).abs() - 1.0).max(0.0) * error
        } else {
            share * miss.difference.abs()
        };
        // three runs and a line with two parameters leave one degree of freedom
        let freedom = shift.freedom.unwrap_or(1.0);
        if more > 0.0 {
            shift.error = Some(error + more);
            shift.freedom = Some(freedom);
            let width = student_bound(EQUIVALENCE_LEVEL, freedom) * more / shift.scale;
            shift.reached = shift.reached.map(|reached| reached + width);
            shift.chance = Some(two_sided(shift.difference / (error + more), freedom));
        }
        shift
    };
    shifts.into_iter().map(one).collect()
}
