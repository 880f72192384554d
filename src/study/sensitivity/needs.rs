//! Conclusion of `diptych needs`: the cheapest set of models that gives the results of the richest case (the case with
//! all models).

use super::plan::{PlannedFactor, SensitivityPlan, Simplification};
use super::table::SensitivityTable;
use super::words::{capital, chance, in_size, open};
use super::{runs, weigh};
use crate::output::numbers::significant;
use crate::output::sensitivity::{Factor, SensitivityRun};
use crate::runs::{Executor, StudyError};
use crate::statistics::Answer;
use crate::study::judge::margin_in_words;
use std::collections::BTreeMap;

/// Name of the factor (change of the case) that leaves out all superfluous models together.
const CHEAPEST: &str = "cheapest";

/// Chooses the models that can be left out together, and compares a run without them with the run of the richest case,
/// which has all models. If the user stops the command, the run is stored and stays incomplete.
///
/// # Errors
/// Returns an error if the run cannot begin or cannot be stored.
pub fn confirm(executor: &mut Executor, table: &mut SensitivityTable) -> Result<(), StudyError> {
    let (factors, _) = weigh::factors(&table.plan, &table.pooled(), &table.outcomes, table.margin);
    let chosen = superfluous(&table.plan, &factors, &table.runs(), table.margin);
    let by: Vec<Simplification> = chosen.iter().filter_map(|factor| factor.simpler.clone()).collect();
    let titles: Vec<String> = chosen.iter().map(|factor| factor.title.clone()).collect();
    if by.len() < 2 {
        return Ok(());
    }
    let known = table.plan.runs.len();
    let all = by.iter().collect::<Vec<_>>();
    // a case may refuse to leave out these models together; the conclusion is then that for each model alone
    let Ok(run) = table.plan.simplified(CHEAPEST, &all) else { return Ok(()) };
    let change = format!("without {}", titles.join(", "));
    let why = "each of them alone is below the margin, and so is the sum of their shifts";
    let factor = PlannedFactor::against(table.plan.first(), run, change, why);
    let title = "the cheapest set".to_owned();
    table.plan.factors.push(PlannedFactor { name: CHEAPEST.to_owned(), title, ..factor });
    if run < known {
        return Ok(());
    }
    let mut outcomes = vec![None; usize::from(table.plan.replicas)];
    for (replica, resumable) in runs(&table.plan, known)?.into_iter().enumerate() {
        let index = executor.add(resumable);
        executor.checkpointer.set_more(true);
        let (outcome, _) = executor.alone(index, Vec::new(), false)?;
        if executor.checkpointer.is_stopped() {
            break;
        }
        outcomes[replica] = Some(outcome);
    }
    table.outcomes.push(outcomes);
    Ok(())
}

/// Factors whose models can be left out together, beginning with the one that saves the most time. The shifts of each
/// factor are below the margin. For every observable, the sum of the magnitudes of their shifts is at most the margin.
fn superfluous<'a>(
    plan: &'a SensitivityPlan,
    factors: &[Factor],
    runs: &[SensitivityRun],
    margin: f64,
) -> Vec<&'a PlannedFactor> {
    let mut candidates: Vec<(&PlannedFactor, &Factor)> = plan
        .factors
        .iter()
        .filter(|planned| planned.simpler.is_some())
        .filter_map(|planned| Some((planned, factors.iter().find(|factor| factor.name == planned.name)?)))
        .filter(|(_, factor)| factor.stopped.is_none() && factor.answer == Answer::Equivalent)
        .collect();
    candidates.sort_by(|a, b| cost(runs, a.1).total_cmp(&cost(runs, b.1)));
    let mut sums: BTreeMap<&str, f64> = BTreeMap::new();
    let mut chosen: Vec<&PlannedFactor> = Vec::new();
    for (planned, factor) in candidates {
        let model = |planned: &PlannedFactor| planned.simpler.as_ref().is_some_and(|simpler| simpler.model.is_some());
        let with = |shift: &crate::output::sensitivity::Shift| {
            sums.get(shift.observable.as_str()).unwrap_or(&0.0) + shift.share().abs()
        };
        // a run has one collision model, so only one factor can replace it
        let fits = !(model(planned) && chosen.iter().any(|one| model(one)));
        if fits && factor.shifts.iter().all(|shift| with(shift) <= margin) {
            for shift in &factor.shifts {
                *sums.entry(&shift.observable).or_default() += shift.share().abs();
            }
            chosen.push(planned);
        }
    }
    chosen
}

/// [-] wall time of the run of a factor divided by that of the run with all models; 1 if the time is not known.
fn cost(runs: &[SensitivityRun], factor: &Factor) -> f64 {
    let time = |name: &str| runs.iter().find(|run| run.name == name).map(|run| run.wall_seconds);
    let own = factor.runs[0].first().and_then(|name| time(name));
    own.zip(runs.first()).map_or(1.0, |(own, richest)| own / richest.wall_seconds)
}

/// Sentences on the cheapest set of models, the models that are needed, those not decided, the assumptions, the effect
/// of chance, and the failures.
pub fn sentences(plan: &SensitivityPlan, factors: &[Factor], runs: &[SensitivityRun], margin: f64) -> Vec<String> {
    let within = margin_in_words(margin);
    let is_model =
        |factor: &&Factor| plan.factors.iter().any(|planned| planned.name == factor.name && planned.simpler.is_some());
    let models = |answer: Answer| -> Vec<&Factor> {
        let of = factors.iter().filter(|factor| factor.stopped.is_none() && factor.answer == answer);
        of.filter(is_model).collect()
    };
    let chosen = superfluous(plan, factors, runs, margin);
    let cheapest = match factors.iter().find(|factor| factor.name == CHEAPEST) {
        Some(all) => Some(all),
        None => chosen.first().and_then(|one| factors.iter().find(|factor| factor.name == one.name)),
    };
    let mut sentences = vec![match cheapest {
        None => format!("No model is shown to be superfluous at a margin of {within}."),
        Some(cheapest) => conclusion(cheapest, &chosen, cost(runs, cheapest), &within),
    }];
    let needed = models(Answer::Different);
    if !needed.is_empty() {
        let list = needed.iter().map(|factor| format!("{}{}", factor.title, in_size(factor))).collect::<Vec<_>>();
        sentences.push(format!("Needed, since without it something shifts beyond the margin: {}.", list.join(", ")));
    }
    let undecided = models(Answer::Unresolved);
    sentences.extend(open(&undecided, &within));
    if !plan.assumed.is_empty() {
        sentences.push(format!("Assumed, since the case does not say: {}.", plan.assumed.join("; ")));
    }
    sentences.extend(factors.iter().find(|factor| factor.name == "seed").and_then(chance));
    let stopped = factors.iter().filter_map(|factor| {
        Some(format!("{} cannot be left out: {}.", capital(&factor.title), factor.stopped.as_ref()?))
    });
    sentences.extend(stopped);
    sentences
}

/// Sentence on the models that the scene does not need, and on the wall time without them. `cost` [-] is this time
/// divided by that with all models, and `within` is the margin as text.
fn conclusion(cheapest: &Factor, chosen: &[&PlannedFactor], cost: f64, within: &str) -> String {
    let without = chosen.iter().map(|planned| planned.title.as_str()).collect::<Vec<_>>().join(", ");
    let time = significant(Some(cost), 2);
    match (cheapest.stopped.as_ref(), cheapest.answer) {
        (None, Answer::Equivalent) => {
            format!(
                "Within {within} of the richest set of models, this scene can do without {without}; it takes {time} of the wall time."
            )
        }
        (None, Answer::Unresolved) => format!(
            "Each alone is within {within} of the richest set of models: {without}; whether they can all be left out together is unresolved."
        ),
        (None, Answer::Different) => {
            format!("Each alone can be left out within {within}, but not all together{}: {without}.", in_size(cheapest))
        }
        (Some(why), _) => format!("Each alone can be left out within {within}: {without}. Together they stop: {why}."),
    }
}
