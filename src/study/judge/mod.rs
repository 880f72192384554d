//! Comparison of every variant with its reference. The answer is "equivalent", "different" or "unresolved".
//!
//! Few bodies are compared by their paths, as long as paths can be predicted. After that time, and for many bodies, two
//! steady runs are compared by their averages over time. Runs that are not steady are compared by curves over time,
//! whose errors are computed from replicas (runs with different seeds). A variant is one of the experiments of a case.
//! The scale of an observable is the value by which its differences are divided.

mod averages;
mod curves;
mod observed;
mod paths;
mod shifts;
mod table;
mod words;

pub use observed::observed_differences;
pub use shifts::{ShiftReference, Shifts, widened};
pub use words::{answer as answer_in_words, in_prose, margin as margin_in_words, not_steady, pair};

use super::trust::softness;
use crate::experiment::Amount;
use crate::outcome::Outcome;
use crate::output::numbers::{counted, quantity, significant};
use crate::output::{Basis, TELLING, Verdict, cost, references};
use crate::schedule::Schedule;
use crate::statistics::{Answer, Comparison, ErrorLevels, compare};
use crate::study::replicas::FROZEN;
use words::percent;

/// [-] largest accepted ratio of the times between samples (instants of measurement) in a recommended longer run and
/// in the present run. With a larger ratio, errors of averages would not decrease as expected. The recommendation then
/// also names a time between samples.
const CLOSE: f64 = 1.1;

/// [-] volume fraction up to which soft and hard spheres have nearly equal collision rates. The relative difference of
/// the rates is about 5 % of the softness (relative amount by which soft spheres act as smaller ones;
/// docs/theory/softness.md).
const DILUTE: f64 = 0.03;

/// Compares every variant (experiment of a case) with its reference, which is another variant or a table of values.
/// `outcomes` has one outcome for each variant, averaged over all its replicas (runs with different seeds). `others`
/// has, for each variant, the separate outcomes of all replicas except the first. `margin` [-] is the largest
/// difference that counts as equivalent, divided by the scale of each observable.
pub fn judge(outcomes: &[Outcome], others: &[Vec<Outcome>], margin: f64) -> Vec<Verdict> {
    judge_at(outcomes, others, Criteria { margin, levels: ErrorLevels::default() })
}

/// Compares every variant (experiment of a case) with its reference, with the margin (largest accepted difference) and
/// the accepted probabilities of wrong answers in `asked`. The probabilities must be smaller if a comparison is tested
/// several times while its runs are done.
pub fn judge_at(outcomes: &[Outcome], others: &[Vec<Outcome>], asked: Criteria) -> Vec<Verdict> {
    let replicas = |place: usize| others.get(place).map_or(&[][..], Vec::as_slice);
    let pairs = references(outcomes).into_iter().enumerate().filter(|(place, other)| place != other);
    let judged = pairs.map(|(place, reference)| {
        let runs = [place, reference].map(|one| ReplicaRuns { outcome: &outcomes[one], others: replicas(one) });
        one(&runs, asked)
    });
    judged.chain(outcomes.iter().filter_map(|outcome| table::judge(outcome, asked))).collect()
}

/// Margin of equivalence and error levels of a comparison of two variants (experiments of a case).
#[derive(Clone, Copy, Debug)]
pub struct Criteria {
    /// [-] largest difference that counts as equivalent, divided by the scale of the observable, such as its mean.
    pub margin: f64,
    /// Accepted probabilities of wrong answers.
    pub levels: ErrorLevels,
}

/// Outcomes of all replicas (runs with different seeds) of a variant (experiment of a case).
#[derive(Clone, Copy)]
pub struct ReplicaRuns<'a> {
    /// Outcome of the first replica (run with one of the seeds). If there are several replicas, the averages in this
    /// outcome are over all replicas.
    pub outcome: &'a Outcome,
    /// Outcomes of all replicas (runs with different seeds) except the first replica.
    pub others: &'a [Outcome],
}

/// Answer of a comparison of two variants (experiments of a case) with the reason for it. The sentence begins after
/// the names of the variants.
struct Finding {
    answer: Answer,
    basis: Basis,
    sentence: String,
    reason: String,
    comparison: Option<Comparison>,
}

fn one(runs: &[ReplicaRuns; 2], asked: Criteria) -> Verdict {
    let [variant, reference] = [runs[0].outcome, runs[1].outcome];
    let found = stopped(&[variant, reference], found(runs, asked));
    let names = [&variant.experiment.name, &reference.experiment.name];
    let observed = match found.basis {
        Basis::Averages => observed::judge([variant, reference], asked),
        Basis::Curves | Basis::Paths | Basis::Nothing => Vec::new(),
    };
    let mut further = Vec::new();
    further.extend(observed::sentence(names, &observed));
    further.extend([variant, reference].into_iter().filter_map(how_it_stopped));
    further.extend(soft_rate(variant, reference));
    further.extend(costs(variant, reference));
    Verdict {
        variant: names[0].clone(),
        reference: names[1].clone(),
        answer: found.answer,
        basis: found.basis,
        sentence: format!("{} {}", pair(names[0], names[1]), found.sentence),
        reason: found.reason,
        margin: asked.margin,
        comparison: found.comparison,
        observed,
        further,
    }
}

/// Compares the first of two variants (experiments of a case) with the second one. The comparison is by paths, curves
/// or averages, depending on the numbers of particles and replicas and on the steadiness of the runs. Runs with the
/// same final state are equivalent.
fn found(runs: &[ReplicaRuns; 2], asked: Criteria) -> Finding {
    let both = [runs[0].outcome, runs[1].outcome];
    let [variant, reference] = both;
    let has_errors = runs.iter().all(|one| one.others.len() + 1 >= curves::FEWEST);
    let few = both.iter().all(|one| !one.paths.points.is_empty()) && !has_errors;
    let both_steady = both.iter().all(|one| one.steadiness.steady);
    if variant.final_state_hash == reference.final_state_hash {
        identical()
    } else if few && !(both_steady && paths::is_chaotic(reference)) {
        paths::judge(variant, reference, asked.margin)
    } else if !both_steady {
        curves::judge(runs, asked)
    } else if let Some(kept) = frozen(both).filter(|_| !has_errors) {
        one_of_many(both, kept)
    } else {
        steady(variant, reference, asked)
    }
}

/// Corrects the finding if one of the `runs` stopped early: the answer "equivalent" becomes "unresolved", since a part
/// of a run cannot show equivalence. Other answers are unchanged.
fn stopped(runs: &[&Outcome], found: Finding) -> Finding {
    let Some(stopped) = runs.iter().find(|one| one.failure.is_some()) else { return found };
    if found.answer != Answer::Equivalent {
        return found;
    }
    let name = &stopped.experiment.name;
    let sentence = format!("unresolved: \"{name}\" stopped before its end; what there is of it is {}", found.sentence);
    Finding { answer: Answer::Unresolved, sentence, ..found }
}

/// Message about a run that stopped early, or about a replica (run with another seed) that stopped and is left out of
/// the averages. `None` if nothing stopped.
fn how_it_stopped(run: &Outcome) -> Option<String> {
    let (name, why) = (&run.experiment.name, run.failure.as_ref()?);
    let time = quantity(run.simulated_seconds, "s", 4);
    Some(if run.simulated_seconds < run.experiment.run.duration * (1.0 - 1e-9) {
        format!("\"{name}\" stopped after {time}: the two are compared up to there, and its cost is not.")
    } else {
        format!("A replica of \"{name}\" stopped and is left out: {why}.")
    })
}

/// [-] share of the particles that are in the same layer (slice of the height y) at the start and at the end of
/// averaging, the larger value of the two runs. `None` if it is at most [`FROZEN`]. With a larger share, averages of
/// one run are not valid for other runs.
fn frozen(both: [&Outcome; 2]) -> Option<f64> {
    both.iter().filter_map(|one| one.places_kept).reduce(f64::max).filter(|kept| *kept > FROZEN)
}

/// Finding "unresolved" for two variants (experiments of a case) with one run each, in which particles do not mix.
/// Another run would settle to another state. `kept` [-] is the share of particles that stay in their layer (slice of
/// the height y).
fn one_of_many(both: [&Outcome; 2], kept: f64) -> Finding {
    let placed = both[1].experiment.start.iter().all(|one| matches!(one.amount, Amount::Placed(_)));
    let advice = if placed {
        "particles that start at random places could be told apart by --replicas 8"
    } else {
        "--replicas 8 gives errors"
    };
    Finding {
        answer: Answer::Unresolved,
        basis: Basis::Nothing,
        sentence: format!(
            "unresolved: {} of the particles are in the same layer at the end as at the start of averaging, so that one run says nothing of others ({advice}).",
            percent(kept)
        ),
        reason: "What does not mix is told from other runs by the scatter between replicas alone.".into(),
        comparison: None,
    }
}

fn identical() -> Finding {
    Finding {
        answer: Answer::Equivalent,
        basis: Basis::Paths,
        sentence: "equivalent: both end in the same state, bit for bit.".into(),
        reason: "The final states are the same.".into(),
        comparison: None,
    }
}

/// Compares two steady runs by their averages over time.
fn steady(variant: &Outcome, reference: &Outcome, asked: Criteria) -> Finding {
    let [a, b] = averages::observables(variant, reference);
    let comparison = compare(&a, &b, asked.margin, asked.levels);
    let shorter = if variant.simulated_seconds < reference.simulated_seconds { variant } else { reference };
    let replicas = |one: &Outcome| one.averaged.replicas.map_or(1, |replicas| replicas.count);
    let runs = replicas(variant).min(replicas(reference));
    // if all particles start at given positions, all replicas (runs with different seeds) are equal
    let placed = shorter.experiment.start.iter().all(|one| matches!(one.amount, Amount::Placed(_)));
    let frozen = frozen([variant, reference]).is_some();
    let needed = |stretch: f64| {
        let longer = longer(shorter, stretch);
        let more = format!("{} replicas as long as these", significant((stretch * runs as f64).ceil(), 2));
        match (placed, frozen) {
            (true, _) => longer,
            (false, true) => more,
            (false, false) => format!("{longer}, or {more},"),
        }
    };
    Finding {
        answer: comparison.answer,
        basis: Basis::Averages,
        sentence: words::answer(&comparison, "m", needed),
        reason: if frozen {
            "Both are steady but do not mix: averages over time are compared, with errors from the scatter between replicas.".into()
        } else {
            "Both are steady while they are averaged: averages over time are compared.".into()
        },
        comparison: Some(comparison),
    }
}

/// Description, for a sentence, of a run whose averaging period is `stretch` [-] times that of `run`. By default, the
/// longer run may have a longer time between samples (instants of measurement) than `run`. If the ratio of these times
/// exceeds [`CLOSE`], the text also recommends the time between samples of `run`.
fn longer(run: &Outcome, stretch: f64) -> String {
    let from = run.profiles.from;
    let mut experiment = run.experiment.clone();
    experiment.run.duration = from + stretch * (run.simulated_seconds - from);
    let longer = format!("{} simulated of each", quantity(experiment.run.duration, "s", 2));
    if Schedule::new(&experiment).interval() <= CLOSE * run.sample_interval {
        return longer;
    }
    format!("{longer} (statistics.sample_interval = \"{}\")", quantity(run.sample_interval, "s", 2))
}

/// Names of the runs in `runs` that are not steady, each with the reason, for a sentence. Such runs have no meaningful
/// averages over time.
fn unsteady(runs: &[&Outcome]) -> String {
    let why = runs.iter().filter_map(|one| {
        let predicate = words::not_steady(&one.steadiness)?;
        Some(format!("\"{}\" {predicate}", one.experiment.name))
    });
    why.collect::<Vec<_>>().join(", ")
}

/// Remark that soft spheres in a dilute gas collide as often as hard ones, although they behave like smaller spheres
/// in other ways. `None` in a dense gas, or unless a soft variant (experiment of a case) is compared with a hard
/// reference.
fn soft_rate(variant: &Outcome, reference: &Outcome) -> Option<String> {
    // the measured volume fraction is used, since particles may come and go
    let slices = &variant.stress.volume_fraction;
    let filled: f64 = slices.iter().flatten().map(|fraction| fraction.value).sum();
    let dilute = slices.iter().all(Option::is_some) && filled < DILUTE * slices.len() as f64;
    let shrink = softness(variant).filter(|_| dilute && reference.experiment.law().is_none())?;
    Some(format!(
        "At this stiffness and agitation the spheres of \"{}\" press and crowd as if smaller by {}, but touch at their full diameter: in a dilute gas as often as hard ones.",
        variant.experiment.name,
        percent(shrink)
    ))
}

/// Sentence on the wall time of a variant (experiment of a case) divided by that of its reference, or on wall times
/// that are too short for such a ratio. `None` if either run stopped early, since its wall time is not that of the
/// whole case.
fn costs(variant: &Outcome, reference: &Outcome) -> Option<String> {
    if [variant, reference].iter().any(|one| one.failure.is_some()) {
        return None;
    }
    let names = (&variant.experiment.name, &reference.experiment.name);
    if variant.timing.wall_seconds.min(reference.timing.wall_seconds) < TELLING {
        let head = pair(names.0, names.1);
        return Some(format!("{head} too short a run to compare costs; `diptych chart` measures them."));
    }
    let ratio = cost(variant)? / cost(reference)?;
    Some(format!(
        "\"{}\" took {} times the wall time of \"{}\" (one run each, one after the other, {}).",
        names.0,
        significant(ratio, 2),
        names.1,
        counted(variant.timing.threads, "thread")
    ))
}
