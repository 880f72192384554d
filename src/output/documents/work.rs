//! Parts of a report about the cost of runs, in wall-clock time and in numbers of operations. A variant is one of the
//! experiments of a case.

use super::run::{distinct, table};
use crate::experiment::{HardStepping, Model};
use crate::outcome::Outcome;
use crate::output::document::{Block, known};
use crate::output::numbers::{count, percent, quantity, significant};
use crate::output::{cost, ranked_cost};

/// Table of the numbers of operations and the wall-clock time of each variant (experiment of a case).
pub fn costs(outcomes: &[Outcome]) -> Vec<Block> {
    let cheapest = outcomes.iter().filter_map(ranked_cost).reduce(f64::min);
    let cells = |o: &Outcome| {
        let model = match (o.experiment.model(), o.experiment.hard.stepping) {
            (Model::Soft, _) => "soft",
            (Model::Hybrid, _) => "hybrid",
            (Model::Dsmc, _) => "dsmc",
            (Model::Hard, HardStepping::Events) => "hard, events",
            (Model::Hard, HardStepping::Steps { .. }) => "hard, steps",
        };
        let [steps, events] = [o.counters.steps, o.counters.events].map(|n| known(n > 0, count(n)));
        let cells = vec![
            model.into(),
            quantity(o.time_step, "s", 3),
            quantity(o.window, "s", 3),
            quantity(o.simulated_seconds, "s", 3),
            significant(cost(o), 3),
            significant(ranked_cost(o).zip(cheapest).map(|(cost, cheapest)| cost / cheapest), 3),
            steps,
            events,
            count(o.counters.pair_checks),
        ];
        (o.failure.is_some(), cells)
    };
    let head = "variant | model | time step | window | simulated | wall s per simulated s | over cheapest | steps | events | pair checks";
    let particles = distinct(outcomes.iter().map(|outcome| count(outcome.particles as u64)));
    // names of the integrators used by runs with contacts
    let stepped = outcomes.iter().filter_map(|outcome| {
        let integrators = outcome.integrators();
        let name = &outcome.experiment.name;
        (!integrators.is_empty()).then(|| format!("“{name}”: {}", integrators.join(", ")))
    });
    let stepped = stepped.collect::<Vec<_>>().join("; ");
    let integrators = Block::Note(format!("Integrators of the contacts that ran. {stepped}."));
    let note = format!(
        "Particles: {particles}. Wall-clock times are of one run each and hold for this machine and these threads only; \
         the counts hold everywhere."
    );
    let blocks = [table(head, outcomes, cells), Block::Note(note)].into_iter();
    blocks.chain((!stepped.is_empty()).then_some(integrators)).collect()
}

/// Statistics of the islands, which are groups of particles that may touch within a part of a window (time between two
/// exchanges with the gas). The list is empty if no run had islands.
pub fn islands(outcomes: &[Outcome]) -> Vec<Block> {
    if outcomes.iter().all(|o| o.counters.islands == 0) {
        return Vec::new();
    }
    let cells = |o: &Outcome| {
        let c = &o.counters;
        let cells = [
            count(c.neighbour_builds),
            count(c.islands),
            significant(c.island_members as f64 / c.islands as f64, 3),
            count(c.largest_island),
            percent(c.islands_redone as f64, c.islands as f64),
        ];
        (false, cells.map(|cell| known(c.islands > 0, cell)).into())
    };
    vec![
        table("variant | searches | islands | members, mean | members, most | done again", outcomes, cells),
        Block::note("Island: particles that may touch one another within a part of a window, solved on their own."),
    ]
}

/// Table with the share that each part of the computation, such as drag or sampling, has in the wall-clock time of a
/// run.
pub fn timing(outcomes: &[Outcome]) -> Vec<Block> {
    let cells = |o: &Outcome| {
        let t = &o.timing;
        let islands = t.engine - t.neighbours - t.flight;
        let parts = [t.neighbours, islands, t.flight, t.drag, t.statistics].map(|part| percent(part, t.wall_seconds));
        let time = quantity(t.wall_seconds, "s", 3);
        let speed = significant(particle_windows_per_second(o), 3);
        (false, [time].into_iter().chain(parts).chain([t.threads.to_string(), speed]).collect())
    };
    let head = "variant | wall time | neighbours | islands, contacts | flight | drag | statistics | threads | particle-windows per s";
    let is_serial = |o: &&Outcome| o.counters.events > 0 && o.counters.islands == 0 && o.counters.steps == 0;
    let serial: Vec<_> = outcomes.iter().filter(is_serial).map(|o| format!("“{}”", o.experiment.name)).collect();
    let note = format!(
        "Serial: {}. One calendar took one event after the other; of more threads it gains only where its lists are made.",
        serial.join(", ")
    );
    [table(head, outcomes, cells)].into_iter().chain((!serial.is_empty()).then_some(Block::Note(note))).collect()
}

/// [1/s] number of particles times number of windows (times between two exchanges with the gas), per wall-clock second.
/// `None` if no wall-clock time was measured.
pub fn particle_windows_per_second(outcome: &Outcome) -> Option<f64> {
    let seconds = outcome.timing.wall_seconds;
    (seconds > 0.0).then(|| outcome.particles as f64 * outcome.windows as f64 / seconds)
}
