//! Parts of a report about the instantaneous impacts in hybrid runs: their share of all impacts, and the neglected
//! contact times and overlaps. The other impacts of a hybrid run are soft contacts. A variant is one of the experiments
//! of a case.

use super::run::table;
use crate::experiment::Model;
use crate::outcome::Outcome;
use crate::output::document::{Block, known};
use crate::output::numbers::{count, percent, quantity, significant};
use crate::record::Impacts;
use serde_json::{Value, json};

/// Parts of the report about instantaneous impacts: their share, the neglected durations and overlaps, and the realised
/// restitution of instantaneous impacts and of soft contacts. The list is empty if no run is hybrid.
pub(super) fn blocks(outcomes: &[Outcome]) -> Vec<Block> {
    if outcomes.iter().all(|outcome| outcome.experiment.model() != Model::Hybrid) {
        return Vec::new();
    }
    let mut blocks = vec![Block::heading("Instants and contacts")];
    for (label, walls) in [("Between particles", false), ("At walls", true)] {
        let head = "variant | instants | contacts that ended | share of instants | e realised, instants | e realised, contacts | \
                    contact time left out, mean | overlap left out δ/d, mean | largest";
        blocks.push(Block::Label(label.into()));
        blocks.push(table(head, outcomes, |outcome| {
            let hybrid = outcome.experiment.model() == Model::Hybrid;
            let impacts = if walls { &outcome.record.walls } else { &outcome.record.pairs };
            (false, cells(impacts).map(|cell| known(hybrid, cell)).into())
        }));
    }
    let hybrids = outcomes.iter().filter(|outcome| outcome.experiment.model() == Model::Hybrid);
    blocks.extend(hybrids.map(|outcome| {
        Block::Note(format!(
            "“{}”: instants left out {} of a particle’s time in contact, which is the relative error to expect of rates; \
             steps of a crowd or of all particles: {}.",
            outcome.experiment.name,
            percent(time_left_out(outcome), 1.0),
            count(outcome.counters.uniform_steps)
        ))
    }));
    blocks.push(Block::note(
        "A touch is an instant if no other particle can come before an isolated contact would be over; what that contact would have been \
         is what it left out. Counted over the whole run; contacts in progress at its end are not in the table.",
    ));
    blocks
}

fn cells(impacts: &Impacts) -> [String; 8] {
    let instants = &impacts.instants;
    let n = instants.count as f64;
    let some = |value: f64| (n > 0.0).then_some(value);
    [
        count(instants.count),
        count(impacts.count - instants.count),
        percent(n, impacts.count as f64),
        significant(instants.restitution(), 5),
        significant(contacts_restitution(impacts), 5),
        quantity(some(instants.duration() / n), "s", 3),
        significant(some(instants.overlap() / n), 3),
        significant(some(instants.largest_overlap), 3),
    ]
}

/// [-] realised restitution of the impacts that were computed as soft contacts; `None` if there were none.
fn contacts_restitution(impacts: &Impacts) -> Option<f64> {
    let before = impacts.normal_speed.sum_of_squares() - impacts.instants.approach_squares();
    let after = impacts.rebound_squares() - impacts.instants.rebound_squares();
    (impacts.count > impacts.instants.count).then(|| (after / before).sqrt())
}

/// [-] share of time for which a particle, on average, would have been in contact if each instantaneous impact had
/// lasted for a contact time. These contact times are summed over all particles. The sum is divided by the simulated
/// time times the mean number of particles. The share is 0 without particles.
fn time_left_out(outcome: &Outcome) -> f64 {
    let record = &outcome.record;
    let time = 2.0 * record.pairs.instants.duration() + record.walls.instants.duration();
    let total = outcome.mean_count() * outcome.simulated_seconds;
    if total > 0.0 { time / total } else { 0.0 }
}

/// Numbers about the instantaneous impacts of a hybrid run for `summary.json`; `null` for runs with other collision
/// models.
pub(super) fn json(outcome: &Outcome) -> Value {
    if outcome.experiment.model() != Model::Hybrid {
        return Value::Null;
    }
    let of = |impacts: &Impacts| {
        let instants = &impacts.instants;
        let mean = |sum: f64| (instants.count > 0).then(|| sum / instants.count as f64);
        json!({
            "instants": instants.count,
            "contacts": impacts.count - instants.count,
            "restitution_of_instants": instants.restitution(),
            "restitution_of_contacts": contacts_restitution(impacts),
            "mean_duration_left_out": mean(instants.duration()),
            "mean_overlap_left_out": mean(instants.overlap()),
            "largest_overlap_left_out": (instants.count > 0).then_some(instants.largest_overlap),
        })
    };
    json!({
        "pairs": of(&outcome.record.pairs),
        "walls": of(&outcome.record.walls),
        "share_of_time_left_out": time_left_out(outcome),
    })
}
