//! Every variant against its reference: equivalent, different, or not resolved.
//!
//! Few bodies are compared by the path of each, as long as paths can be foretold. Beyond that, and with many, two steady runs are
//! compared by their averages; what is not steady has no averages and is compared by curves over time, whose errors come from
//! replicas.

mod averages;
mod curves;
mod paths;
mod shifts;
mod words;

pub use shifts::{Ground, Shifts, widened};
pub use words::{in_prose, margin as margin_in_words, not_steady};

use super::trust::softness;
use crate::experiment::Amount;
use crate::outcome::Outcome;
use crate::output::numbers::{counted, quantity, significant};
use crate::output::{Basis, Verdict, cost, references};
use crate::statistics::{Answer, Comparison, compare};
use words::{pair, percent};

/// [s] wall time below which a ratio of two says little of the methods: what is done once, such as the first search of
/// neighbours and the start of threads, takes milliseconds.
const TELLING: f64 = 0.1;

/// [-] share of the box up to which soft spheres meet as often as hard ones but for a share of 5 % of their softness or so
/// (docs/theory.md, "Softness").
const DILUTE: f64 = 0.03;

/// Judges every variant that has a reference other than itself. `others`: the replicas of each variant but the first, whose
/// averages the outcome holds already. `margin` [-]: over the scale of each observable.
pub fn judge(outcomes: &[Outcome], others: &[Vec<Outcome>], margin: f64) -> Vec<Verdict> {
    let replicas = |place: usize| others.get(place).map_or(&[][..], Vec::as_slice);
    let pairs = references(outcomes).into_iter().enumerate().filter(|(place, other)| place != other);
    let judged = pairs.map(|(place, reference)| {
        let runs = [place, reference].map(|one| Runs { outcome: &outcomes[one], others: replicas(one) });
        one(&runs, margin)
    });
    judged.collect()
}

/// A variant with its replicas.
#[derive(Clone, Copy)]
pub struct Runs<'a> {
    /// The averages over all of them, else the first.
    pub outcome: &'a Outcome,
    /// All but the first.
    pub others: &'a [Outcome],
}

/// What an answer consists of before it gets the names of the variants.
struct Found {
    answer: Answer,
    basis: Basis,
    sentence: String,
    reason: String,
    comparison: Option<Comparison>,
}

fn one(runs: &[Runs; 2], margin: f64) -> Verdict {
    let [variant, reference] = [runs[0].outcome, runs[1].outcome];
    let few = [variant, reference].iter().all(|one| !one.paths.points.is_empty());
    let both_steady = variant.steadiness.steady && reference.steadiness.steady;
    let found = if variant.final_state_hash == reference.final_state_hash {
        identical()
    } else if few && !(both_steady && paths::is_chaotic(reference)) {
        paths::judge(variant, reference, margin)
    } else if both_steady {
        steady(variant, reference, margin)
    } else {
        curves::judge(runs, margin)
    };
    let names = [&variant.experiment.name, &reference.experiment.name];
    let mut further = Vec::new();
    for stopped in [variant, reference].into_iter().filter(|one| one.failure.is_some()) {
        further.push(format!(
            "\"{}\" stopped after {}: the two are compared up to there, and its cost is not.",
            stopped.experiment.name,
            quantity(stopped.simulated_seconds, "s", 4)
        ));
    }
    further.extend(soft_rate(variant, reference));
    further.extend(costs(variant, reference));
    Verdict {
        variant: names[0].clone(),
        reference: names[1].clone(),
        answer: found.answer,
        basis: found.basis,
        sentence: format!("{} {}", pair(names[0], names[1]), found.sentence),
        reason: found.reason,
        margin,
        comparison: found.comparison,
        further,
    }
}

fn identical() -> Found {
    Found {
        answer: Answer::Equivalent,
        basis: Basis::Paths,
        sentence: "equivalent: both end in the same state, bit for bit.".into(),
        reason: "The final states are the same.".into(),
        comparison: None,
    }
}

/// Two steady runs, by their averages.
fn steady(variant: &Outcome, reference: &Outcome, margin: f64) -> Found {
    let [a, b] = averages::observables(variant, reference);
    let comparison = compare(&a, &b, margin);
    let shorter = if variant.simulated_seconds < reference.simulated_seconds { variant } else { reference };
    let replicas = |one: &Outcome| one.averaged.replicas.map_or(1, |replicas| replicas.count);
    let runs = replicas(variant).min(replicas(reference));
    let needed = |stretch: f64| {
        let from = shorter.profiles.from;
        let time = from + stretch * (shorter.simulated_seconds - from);
        let count = (stretch * runs as f64).ceil();
        let longer = format!("{} of each", quantity(time, "s", 2));
        // from given places all replicas would be the same run
        if shorter.experiment.start.iter().all(|one| matches!(one.amount, Amount::Placed(_))) {
            return longer;
        }
        format!("{longer}, or {} replicas as long as these,", significant(count, 2))
    };
    Found {
        answer: comparison.answer,
        basis: Basis::Averages,
        sentence: words::answer(&comparison, "m", needed),
        reason: "Both are steady while they are averaged: averages over time are compared.".into(),
        comparison: Some(comparison),
    }
}

/// Why something is not judged by averages over time: who is not steady.
fn unsteady(runs: [&Outcome; 2]) -> String {
    let why = runs.into_iter().filter_map(|one| {
        let predicate = words::not_steady(&one.steadiness)?;
        Some(format!("\"{}\" {predicate}", one.experiment.name))
    });
    why.collect::<Vec<_>>().join(", ")
}

/// What finite stiffness explains of a difference in the rate of impacts, in a dilute gas.
fn soft_rate(variant: &Outcome, reference: &Outcome) -> Option<String> {
    let scene = &variant.experiment.scene;
    let volume = |(count, species): (usize, &crate::scene::Species)| count as f64 * species.volume();
    let filled = variant.experiment.counts().into_iter().zip(&scene.species).map(volume).sum::<f64>();
    let dilute = filled < DILUTE * scene.domain.volume();
    let shrink = softness(variant).filter(|_| dilute && reference.experiment.law().is_none())?;
    Some(format!(
        "At this stiffness and agitation the spheres of \"{}\" press and crowd as if smaller by {}, but touch at their full diameter: in a dilute gas as often as hard ones.",
        variant.experiment.name,
        percent(shrink)
    ))
}

/// What a variant costs over its reference; nothing of one that stopped, whose cost is not that of the case.
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
