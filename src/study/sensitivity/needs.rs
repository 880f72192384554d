//! Conclusion of `diptych needs`: the cheapest set of models that gives the results of the richest case (the case with
//! all models). The margin is the largest shift that is accepted as equivalent.

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
/// which has all models. There is no such run if fewer than two models are chosen, or if the case refuses to leave out
/// all of them together. If the user stops the command, the state of the run is stored.
///
/// # Errors
/// Returns an error if the run cannot begin or cannot be stored.
pub fn confirm(executor: &mut Executor, table: &mut SensitivityTable) -> Result<(), StudyError> {
    let (factors, _) = weigh::factors(&table.plan, &table.pooled(), &table.outcomes, table.margin);
    let chosen = superfluous(&table.plan.factors, &factors, &table.runs(), table.margin);
    let by: Vec<Simplification> = chosen.iter().filter_map(|factor| factor.simpler.clone()).collect();
    let titles: Vec<String> = chosen.iter().map(|factor| factor.title.clone()).collect();
    if by.len() < 2 {
        return Ok(());
    }
    let known = table.plan.runs.len();
    let all = by.iter().collect::<Vec<_>>();
    // a case may refuse to leave out these models together; there is then a conclusion for each model alone, but none
    // for all together
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

/// Factors (changes of the case) whose models can be left out together, beginning with the factor that saves the most
/// wall time. The shifts of each factor are below the margin (largest accepted shift). For every observable, the
/// magnitudes of the shifts by these factors add up to at most the margin.
fn superfluous<'a>(
    planned: &'a [PlannedFactor],
    factors: &[Factor],
    runs: &[SensitivityRun],
    margin: f64,
) -> Vec<&'a PlannedFactor> {
    let mut candidates: Vec<(&PlannedFactor, &Factor)> = planned
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
        // a run has one collision model, so at most one of the chosen factors may replace the collision model
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

/// [-] wall time of the run of a factor (change of the case) divided by that of the run with all models; 1 if the time
/// is not known.
fn cost(runs: &[SensitivityRun], factor: &Factor) -> f64 {
    let time = |name: &str| runs.iter().find(|run| run.name == name).map(|run| run.wall_seconds);
    let own = factor.runs[0].first().and_then(|name| time(name));
    own.zip(runs.first()).map_or(1.0, |(own, richest)| own / richest.wall_seconds)
}

/// Sentences on the cheapest set of models, the needed models, the models without a decision, the assumptions and the
/// effect of chance. Further sentences name each factor (change of the case) whose run stopped.
pub fn sentences(plan: &SensitivityPlan, factors: &[Factor], runs: &[SensitivityRun], margin: f64) -> Vec<String> {
    of_models((&plan.factors, &plan.assumed), factors, runs, margin)
}

/// Makes the sentences of [`sentences`] from the planned factors and the assumptions of a plan.
fn of_models(
    (planned, assumed): (&[PlannedFactor], &[String]),
    factors: &[Factor],
    runs: &[SensitivityRun],
    margin: f64,
) -> Vec<String> {
    let within = margin_in_words(margin);
    let is_model =
        |factor: &&Factor| planned.iter().any(|planned| planned.name == factor.name && planned.simpler.is_some());
    let models = |answer: Answer| -> Vec<&Factor> {
        let of = factors.iter().filter(|factor| factor.stopped.is_none() && factor.answer == answer);
        of.filter(is_model).collect()
    };
    let chosen = superfluous(planned, factors, runs, margin);
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
    if !assumed.is_empty() {
        sentences.push(format!("Assumed, since the case does not say: {}.", assumed.join("; ")));
    }
    sentences.extend(factors.iter().find(|factor| factor.name == "seed").and_then(chance));
    // the first sentence says why the cheapest set stopped
    sentences.extend(factors.iter().filter(|factor| factor.name != CHEAPEST).filter_map(|factor| {
        let title = capital(&factor.title);
        let effect = if is_model(&factor) { "cannot be left out" } else { "stopped" };
        Some(format!("{title} {effect}: {}.", factor.stopped.as_ref()?))
    }));
    sentences
}

/// Sentence on the models that the scene does not need, and on the wall time of a run without them. `cost` [-] is this
/// wall time divided by that of the run with all models, and `within` is the margin (largest accepted shift) as text.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Model;
    use crate::output::sensitivity::Shift;

    const MARGIN: f64 = 0.01;

    /// A planned factor that leaves a model out, and that changes the collision model if `changes_model` is true.
    fn planned(name: &str, changes_model: bool) -> PlannedFactor {
        let model = changes_model.then_some(Model::Hard);
        let simpler = Some(Simplification { model, ..Simplification::default() });
        let (name, title) = (name.to_owned(), format!("the {name}"));
        PlannedFactor { name, title, simpler, ..PlannedFactor::against(0, 1, "without", "a test") }
    }

    /// A factor (change of the case) whose only observable shifts by `share` [-], divided by the scale of the
    /// observable.
    fn factor(name: &str, share: f64, answer: Answer) -> Factor {
        let shift = Shift {
            observable: "T".to_owned(),
            unit: "m²/s²",
            scale: 2.0,
            scale_is: "its mean",
            difference: 2.0 * share,
            error: Some(0.001),
            freedom: Some(10.0),
            time: None,
            chance: None,
            reached: None,
            stretch: None,
            answer,
        };
        Factor {
            name: name.to_owned(),
            title: format!("the {name}"),
            change: "without".to_owned(),
            why: String::new(),
            basis: None,
            shifts: vec![shift],
            runs: [vec![format!("without {name}")], vec!["richest".to_owned()]],
            remarks: Vec::new(),
            stopped: None,
            answer,
        }
    }

    fn ran(name: &str, wall_seconds: f64) -> SensitivityRun {
        SensitivityRun {
            name: name.to_owned(),
            set: String::new(),
            model: Model::Hard,
            replicas: 1,
            steady: true,
            simulated_seconds: 1.0,
            wall_seconds,
            failure: None,
        }
    }

    fn names(chosen: &[&PlannedFactor]) -> Vec<String> {
        chosen.iter().map(|planned| planned.name.clone()).collect()
    }

    #[test]
    fn the_models_that_cost_most_are_left_out_while_the_sum_of_shifts_is_within_the_margin() {
        let plan = [planned("lift", false), planned("drag", false), planned("spin", false)];
        let runs = [ran("richest", 10.0), ran("without lift", 9.0), ran("without drag", 2.0), ran("without spin", 5.0)];
        let small = |name: &str, share: f64| factor(name, share, Answer::Equivalent);
        let all = [small("lift", 0.003), small("drag", -0.003), small("spin", 0.003)];
        assert_eq!(names(&superfluous(&plan, &all, &runs, MARGIN)), ["drag", "spin", "lift"]);
        // the shifts of 0.6 % and 0.5 % add up to more than 1 %, whatever their signs; of these two models, only the
        // one that saves more time is left out
        let all = [small("lift", 0.005), small("drag", -0.006), small("spin", 0.003)];
        assert_eq!(names(&superfluous(&plan, &all, &runs, MARGIN)), ["drag", "spin"]);
        let open = [factor("lift", 0.001, Answer::Unresolved), factor("drag", 0.5, Answer::Different)];
        assert!(superfluous(&plan, &open, &runs, MARGIN).is_empty());
        let stopped = Factor { stopped: Some("it fell".to_owned()), ..small("drag", 0.0) };
        assert!(superfluous(&plan, &[stopped], &runs, MARGIN).is_empty());
    }

    #[test]
    fn a_scene_keeps_one_collision_model() {
        let plan = [planned("contacts", true), planned("positions", true), planned("lift", false)];
        let runs = [ran("richest", 10.0), ran("without contacts", 3.0), ran("without positions", 1.0)];
        let all = ["contacts", "positions", "lift"].map(|name| factor(name, 0.0, Answer::Equivalent));
        assert_eq!(names(&superfluous(&plan, &all, &runs, MARGIN)), ["positions", "lift"]);
    }

    #[test]
    fn the_first_sentence_follows_from_the_run_of_the_cheapest_set() {
        let plan = [planned("lift", false), planned("drag", false), planned("spin", false)];
        let runs = [ran("richest", 10.0), ran("without cheapest", 2.5)];
        let say = |cheapest: Factor| {
            let spin = Factor { stopped: Some("a ball slid".to_owned()), ..factor("spin", 0.0, Answer::Different) };
            let small = ["lift", "drag"].map(|name| factor(name, 0.001, Answer::Equivalent));
            let all: Vec<Factor> = small.into_iter().chain([spin, cheapest]).collect();
            of_models((&plan, &["air".to_owned()]), &all, &runs, MARGIN)
        };
        let cheapest = |share: f64, answer: Answer| factor(CHEAPEST, share, answer);
        let said = say(cheapest(0.002, Answer::Equivalent));
        assert!(said[0].contains("can do without the lift, the drag; it takes 0.25 of the wall time"), "{said:?}");
        assert!(said.iter().any(|text| text == "Assumed, since the case does not say: air."), "{said:?}");
        assert!(said.iter().any(|text| text == "The spin cannot be left out: a ball slid."), "{said:?}");
        assert!(!said.iter().any(|text| text.starts_with("Needed")), "{said:?}");
        let said = say(cheapest(0.005, Answer::Unresolved));
        assert!(said[0].contains("whether they can all be left out together is unresolved"), "{said:?}");
        let said = say(cheapest(0.05, Answer::Different));
        assert!(said[0].contains("but not all together"), "{said:?}");
        let said = say(Factor { stopped: Some("it fell".to_owned()), ..cheapest(0.0, Answer::Equivalent) });
        assert!(said[0].contains("Together they stop: it fell"), "{said:?}");
        assert_eq!(said.iter().filter(|text| text.contains("it fell")).count(), 1, "{said:?}");
    }

    #[test]
    fn only_a_model_is_called_one_that_cannot_be_left_out() {
        let stopped =
            |name: &str| Factor { stopped: Some("it fell".to_owned()), ..factor(name, 0.0, Answer::Different) };
        let (plan, runs) = ([planned("lift", false)], [ran("richest", 10.0)]);
        let said = of_models((&plan, &[]), &[stopped("lift"), stopped("seed")], &runs, MARGIN);
        assert!(said.contains(&"The lift cannot be left out: it fell.".to_owned()), "{said:?}");
        assert!(said.contains(&"The seed stopped: it fell.".to_owned()), "{said:?}");
    }
}
