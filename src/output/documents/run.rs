//! Document of a run or a comparison. A variant is one of the experiments of a case.

use super::{budgets, energy, gas_flow, hybrid, kinds, measurements, openings, overview, stress, trust, verdict, work};
use crate::outcome::Outcome;
use crate::output::document::{Block, Document, TextRow, known, status};
use crate::output::figures::ROUNDING;
use crate::output::html::TRUST;
use crate::output::numbers::{Prefix, count, percent, quantity, significant, with_error};
use crate::output::panel::Figure;
use crate::output::player::Player;
use crate::output::{Folder, OutputError, Study, cost, csv, figures, over_time, overall};
use crate::record::Impacts;
use crate::scene::Surface;
use crate::statistics::{Answer, Estimate};
use serde_json::{Value, json};
use std::path::PathBuf;

/// Largest number of answers of comparisons (equivalent, different or unresolved) that are shown at the top of a page.
const ANSWERS: usize = 3;

/// Number of standard errors. A deviation from an expected value that is larger is highlighted.
const SUSPECT: f64 = 3.0;

/// Writes all results of a run or a comparison, and returns the path of the report.
///
/// # Errors
/// An [`OutputError`]. Files written before the error remain, but there is no `summary.json`.
pub fn write_study(folder: &Folder, study: &Study) -> Result<PathBuf, OutputError> {
    let variants = study.outcomes.iter().enumerate().map(|(place, outcome)| {
        let mut summary = variant(outcome, study.parameters.get(place));
        summary["set"] = study.overrides.get(place).filter(|set| !set.is_empty()).cloned().into();
        let judged = study.comparisons.iter().find(|one| one.variant == outcome.experiment.name);
        summary["verdict"] = judged.map(|verdict| verdict.answer.word()).into();
        summary
    });
    let numbers = json!({
        "seed": study.outcomes.first().map(|outcome| outcome.experiment.run.seed),
        "variants": variants.collect::<Vec<_>>(),
        "verdict": overall(study.comparisons).map(Answer::word),
        "comparisons": study.comparisons,
        "trust": study.trust,
    });
    document(study)?.write(folder, numbers)
}

/// Writes the present results of an unfinished comparison: all files except `summary.json`. Returns the path of the
/// report.
///
/// # Errors
/// Errors of [`write_study`].
pub fn write_part(folder: &Folder, study: &Study) -> Result<PathBuf, OutputError> {
    document(study)?.write_part(folder)
}

fn document<'a>(study: &Study<'a>) -> Result<Document<'a>, OutputError> {
    let outcomes = study.outcomes;
    let mut tables = vec![
        ("series.csv".to_owned(), over_time::series(outcomes)?),
        ("profiles.csv".to_owned(), csv::profiles(outcomes)?),
        ("impacts.csv".to_owned(), csv::impacts(outcomes)?),
        ("stress.csv".to_owned(), stress::csv(outcomes)?),
    ];
    tables.extend(kinds::tables(outcomes)?);
    if outcomes.iter().any(|outcome| !outcome.rings.rings.is_empty()) {
        tables.push(("rings.csv".to_owned(), csv::rings(outcomes)?));
    }
    if outcomes.iter().any(|outcome| outcome.experiment.model().has_contacts()) {
        tables.push(("overlaps.csv".to_owned(), csv::overlaps(outcomes)?));
    }
    tables.extend(measurements::tables(outcomes)?);
    tables.extend(verdict::observed_csv(study)?.map(|table| ("observed-differences.csv".to_owned(), table)));
    tables.extend(gas_flow::csv(outcomes)?.map(|table| ("gas.csv".to_owned(), table)));
    tables.extend(openings::csv(outcomes)?.map(|table| ("flow.csv".to_owned(), table)));
    tables.extend(over_time::paths(outcomes)?.map(|table| ("paths.csv".to_owned(), table)));
    if let Some(budgets) = study.budgets {
        tables.push(("budgets.csv".to_owned(), csv::budgets(budgets)?));
    }
    let reproduction = [
        ("seed", distinct(outcomes.iter().map(|o| o.experiment.run.seed.to_string()))),
        ("threads", distinct(outcomes.iter().map(|o| o.timing.threads.to_string()))),
        ("initial state", distinct(outcomes.iter().map(|o| format!("{:016x}", o.initial_state_hash)))),
    ];
    let mut figures = figures::over_time(outcomes);
    let over_time = figures.len();
    figures.extend(figures::glance(study));
    figures.extend(figures::study(outcomes));
    figures.extend(figures::measurements(outcomes));
    let of_budgets = |budgets| figures::budgets(budgets, outcomes[0].experiment.scene.domain.size.y);
    figures.extend(study.budgets.map(of_budgets));
    let document = Document {
        provenance: study.provenance,
        failures: outcomes.iter().filter_map(|o| Some((o.experiment.name.as_str(), o.failure.as_ref()?))).collect(),
        verdicts: study.verdicts,
        answers: study.comparisons.len().clamp(1, ANSWERS),
        front: overview::blocks(study, &figures),
        notes: study.notes,
        body: body(study, over_time, &figures),
        tail: vec![Block::entries(reproduction), hashes(outcomes)],
        tables,
        figures,
    };
    Ok(document.with_distinct_names())
}

/// Main part of the page of a run or a comparison. The first `over_time` figures show curves over time.
fn body(study: &Study, over_time: usize, figures: &[Figure]) -> Vec<Block> {
    let outcomes = study.outcomes;
    // curves over time come first for unsteady runs, whose averages mix different states, and for runs of a few bodies,
    // whose averages have little meaning
    let follows = |outcome: &Outcome| !outcome.steadiness.steady || !outcome.paths.points.is_empty();
    let transient = over_time > 0 && outcomes.iter().all(follows);
    let player = Player::of(outcomes, study.frames);
    let mut body: Vec<Block> = player.map(|player| Block::Player(Box::new(player))).into_iter().collect();
    if transient {
        body.extend([Block::Section("over-time", "Over time".into()), Block::Figures(0..over_time)]);
    }
    if !study.comparisons.is_empty() {
        body.push(Block::heading("Differences"));
        body.extend(verdict::blocks(study));
        body.extend(pictures(figures, &["differences"]));
    }
    if over_time > 0 && !transient {
        body.extend([Block::heading("Over time"), Block::Figures(0..over_time)]);
    }
    body.push(Block::heading("Profiles"));
    if !outcomes.iter().any(|outcome| outcome.steadiness.steady) {
        body.push(Block::note("No variant is steady: these averages are of what changes meanwhile."));
    }
    body.extend(pictures(figures, &["number-density", "streamwise-velocity", "second-moments", "spins"]));
    body.extend(averaging(outcomes));
    body.extend(openings::blocks(outcomes));
    body.push(Block::heading("Impacts and overlaps"));
    body.extend(impacts(outcomes));
    body.extend(pictures(figures, &["overlap", "first-overlap", "mean-overlap", "impact-speed"]));
    body.extend(kinds::blocks(outcomes));
    body.extend(hybrid::blocks(outcomes));
    body.extend(stress::blocks(outcomes));
    body.extend(measurements::blocks(outcomes, |name| pictures(figures, &[name])));
    body.extend(budgets::blocks(study.budgets, || pictures(figures, &["budgets"])));
    body.extend(gas_flow::blocks(outcomes));
    body.extend(pictures(figures, &["gas"]));
    body.push(Block::heading("Energy ledger"));
    body.extend(energy::blocks(outcomes));
    if !outcomes.iter().all(|outcome| outcome.balance.is_idle()) {
        body.push(Block::Subheading("Streamwise momentum".into()));
        body.extend(momentum(outcomes));
    }
    body.push(Block::heading(TRUST));
    body.extend(trust::blocks(study.trust));
    body.push(Block::heading("Cost and counts"));
    body.extend(work::costs(outcomes));
    body.extend(work::timing(outcomes));
    body.extend(work::islands(outcomes));
    body
}

/// Parts of the page with the figures whose names are in `names`, or begin with such a name and a hyphen. Consecutive
/// figures are placed next to each other. The figure of the differences in per cent is left out, because it is at the
/// top of the page.
fn pictures(figures: &[Figure], names: &[&str]) -> Vec<Block> {
    let is = |figure: &Figure, name: &str| {
        figure.name.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
    };
    let asked = |figure: &Figure| figure.name != figures::IN_PER_CENT && names.iter().any(|name| is(figure, name));
    let mut ranges: Vec<std::ops::Range<usize>> = Vec::new();
    for place in (0..figures.len()).filter(|place| asked(&figures[*place])) {
        match ranges.last_mut() {
            Some(last) if last.end == place => last.end += 1,
            _ => ranges.push(place..place + 1),
        }
    }
    ranges.into_iter().map(Block::Figures).collect()
}

/// Joins the distinct texts in order of first appearance, separated by commas.
pub fn distinct(texts: impl Iterator<Item = String>) -> String {
    let mut seen: Vec<String> = Vec::new();
    for text in texts {
        if !seen.contains(&text) {
            seen.push(text);
        }
    }
    seen.join(", ")
}

/// Table with one row per variant (experiment of a case). The first cell of a row is the name of the variant; `cells`
/// returns the other cells.
pub(super) fn table(head: &str, outcomes: &[Outcome], cells: impl Fn(&Outcome) -> TextRow) -> Block {
    let row = |outcome: &Outcome| {
        let (marked, rest) = cells(outcome);
        (marked, std::iter::once(outcome.experiment.name.clone()).chain(rest).collect())
    };
    Block::table(head, outcomes.iter().map(row))
}

/// Parts of the page about impacts between particles and on walls.
fn impacts(outcomes: &[Outcome]) -> Vec<Block> {
    let rotates = outcomes.iter().any(|outcome| outcome.experiment.scene.rotation.is_some());
    let of_slip = if rotates { " | β realised | sliding" } else { "" };
    let head = &format!(
        "variant | impacts | impacts per s | mean normal speed [m/s] | e requested | e realised{of_slip} | mean duration | mean δ/d | 99 % δ/d | largest δ/d"
    );
    let pairs = |o: &Outcome| {
        let speed = o.pairs.summary().mean_normal_speed;
        let asked = o.experiment.scene.meetings().map(|(_, _, meeting)| requested(&meeting.surface, speed));
        (false, impact_cells(&o.pairs, o.pair_rate, distinct(asked), rotates))
    };
    let walls = |o: &Outcome| {
        let meetings = o.experiment.scene.meetings_at_walls();
        let speed = o.walls.summary().mean_normal_speed;
        let each = meetings.map(|(_, _, meeting)| requested(&meeting.surface, speed));
        (false, impact_cells(&o.walls, o.wall_rate, distinct(each), rotates))
    };
    let mut blocks = vec![Block::Label("Between particles".into()), table(head, outcomes, pairs)];
    if outcomes.iter().any(|outcome| !outcome.experiment.scene.walls.is_empty()) {
        blocks.extend([Block::Label("At walls".into()), table(head, outcomes, walls)]);
    }
    if rotates {
        blocks.push(Block::note(
            "β realised: tangential restitution, -Σ s·s'/Σ s² with the slip s of the surfaces at first touch and s' at the end: -1 without friction, 1 if every slip is reversed. Sliding: share of the impacts \
             whose tangential impulse is at Coulomb's limit, so that the surfaces slide all the time. ",
        ));
    }
    blocks.push(Block::note(
        "e realised: root of the normal energy after over before, summed over impacts. δ: largest overlap of an impact, d: diameter, of unequal spheres the smaller one; collisions of hard \
         spheres have no duration, and no overlap at exact instants. ",
    ));
    blocks
}

/// Restitution that a case gives, as text. A restitution that depends on the speed is evaluated at `speed` [m/s], the
/// mean normal speed of impact. If this speed is unknown (`None`), the text is "by speed".
fn requested(surface: &Surface, speed: Option<f64>) -> String {
    match (surface.by_speed, speed) {
        (None, _) => significant(surface.restitution, 4),
        (Some(law), Some(speed)) => format!("{} at {} m/s", significant(law.at(speed), 4), significant(speed, 3)),
        (Some(_), None) => "by speed".to_owned(),
    }
}

fn impact_cells(impacts: &Impacts, rate: Option<Estimate>, requested: String, rotates: bool) -> Vec<String> {
    let s = impacts.summary();
    // overlaps of collisions at exact instants are rounding errors
    let deep = |value: Option<f64>| known(s.largest_overlap > Some(ROUNDING), significant(value, 3));
    let mut cells = vec![
        count(s.count),
        with_error(rate),
        significant(s.mean_normal_speed, 3),
        requested,
        significant(s.mean_restitution, 5),
    ];
    if rotates {
        let sliding = percent(impacts.slips.sliding as f64, impacts.slips.count as f64);
        cells.extend([significant(s.tangential_restitution, 4), known(impacts.slips.count > 0, sliding)]);
    }
    cells.extend([
        // collisions at exact instants have no duration
        known(s.mean_duration > Some(0.0), quantity(s.mean_duration, "s", 3)),
        deep(s.mean_maximum_overlap),
        deep(s.p99_maximum_overlap),
        deep(s.largest_overlap),
    ]);
    cells
}

/// Parts of the page about the balance of streamwise forces.
fn momentum(outcomes: &[Outcome]) -> Vec<Block> {
    let forces = |o: &Outcome| {
        let averaged = [o.balance.drag, o.balance.wall, o.balance.flow, o.balance.residual].into_iter().flatten();
        averaged.map(|force| force.value).chain([o.balance.weight])
    };
    let largest = outcomes.iter().flat_map(forces).filter(|f| f.is_finite()).fold(0.0, |a: f64, b| a.max(b.abs()));
    let prefix = Prefix::of(largest);
    let flows = outcomes.iter().any(|o| o.experiment.scene.has_openings());
    let newton = |force: Option<Estimate>| with_error(force.map(|force| force.times(prefix.factor)));
    let cells = |o: &Outcome| {
        let b = &o.balance;
        let errors = b.residual.and_then(Estimate::in_errors);
        let weight = significant(b.weight * prefix.factor, 4);
        let forces = [newton(b.drag), weight, newton(b.wall)].into_iter().chain(flows.then(|| newton(b.flow)));
        let cells = forces.chain([newton(b.residual), significant(errors, 2)]).collect();
        (errors.is_some_and(|errors| errors.abs() > SUSPECT), cells)
    };
    let note = format!(
        "Mean forces on all particles along the stream in {}N over the averaging period. In a steady flow they add up \
         to zero within the error.",
        prefix.symbol
    );
    let head = if flows {
        "variant | drag | weight | walls | inflow less outflow | sum | sum in SE"
    } else {
        "variant | drag | weight | walls | sum | sum in SE"
    };
    vec![table(head, outcomes, cells), Block::Note(note)]
}

/// Mean forces on all particles along the stream for `summary.json`. Only scenes with inlets or outlets have an entry
/// for the momentum that passes through them per time.
fn momentum_json(outcome: &Outcome) -> Value {
    let balance = &outcome.balance;
    let mut forces = json!({
        "drag": measured(balance.drag),
        "weight": balance.weight,
        "wall": measured(balance.wall),
        "residual": measured(balance.residual),
    });
    if outcome.experiment.scene.has_openings() {
        forces["flow"] = measured(balance.flow);
    }
    forces
}

/// Parts of the page about the averaging period and the test for a steady state.
fn averaging(outcomes: &[Outcome]) -> Vec<Block> {
    let cells = |o: &Outcome| {
        let s = &o.steadiness;
        let steady = if s.steady { "yes" } else { "no" };
        let times = [o.profiles.from, o.profiles.until].map(|time| quantity(time, "s", 3));
        let samples: u64 = o.profiles.slices.iter().map(|slice| slice.samples).sum();
        let rest = [o.profiles.blocks.to_string(), count(samples), steady.into(), significant(s.drift, 2)];
        (!s.steady, times.into_iter().chain(rest).collect())
    };
    vec![
        table("variant | from | until | blocks | particle samples | steady | drift in SE", outcomes, cells),
        Block::note(
            "Drift: second minus first half of the averaged time, the largest of the observed series. Averages of a flow that is \
             not steady describe this run, not the flow.",
        ),
    ]
}

/// Table of the hashes of the initial and the final state of each variant (experiment of a case). Equal hashes mean
/// that all bits of the states are equal.
fn hashes(outcomes: &[Outcome]) -> Block {
    let cells =
        |o: &Outcome| (false, vec![format!("{:016x}", o.initial_state_hash), format!("{:016x}", o.final_state_hash)]);
    table("variant | hash of the initial state | hash of the final state", outcomes, cells)
}

pub(super) fn measured(found: Option<Estimate>) -> Value {
    json!({ "value": found.map(|found| found.value), "standard_error": found.and_then(|found| found.error) })
}

/// Results of an experiment for `summary.json`, in SI units; `null` means an unknown value. `parameters` contains all
/// settings of the experiment; `None` if they are not known.
fn variant(outcome: &Outcome, parameters: Option<&Value>) -> Value {
    let (experiment, record) = (&outcome.experiment, &outcome.record);
    let (pairs, walls) = (outcome.pairs.summary(), outcome.walls.summary());
    json!({
        "name": experiment.name,
        "model": experiment.model(),
        "status": status(outcome.failure.is_some()),
        "failure": outcome.failure,
        "failure_message": outcome.failure.as_ref().map(ToString::to_string),
        "particles": outcome.particles,
        "pair_impacts": record.pairs.count,
        "wall_impacts": record.walls.count,
        "windows": outcome.windows,
        "window": outcome.window,
        "time_step": outcome.time_step,
        "sample_interval": outcome.sample_interval,
        "counters": outcome.counters,
        "integrators": outcome.integrators(),
        "wall_seconds": outcome.timing.wall_seconds,
        "simulated_seconds": outcome.simulated_seconds,
        "wall_seconds_per_simulated_second": cost(outcome),
        "particle_windows_per_second": work::particle_windows_per_second(outcome),
        "timing": outcome.timing,
        "energy": energy::json(outcome),
        "granular_temperature": measured(outcome.temperature),
        "stress": stress::json(outcome),
        "observe": measurements::json(outcome),
        "gas": gas_flow::json(outcome),
        "flows": openings::json(outcome),
        "restitution": {
            "requested_pairs": experiment.scene.restitution_of_pairs(),
            "requested_walls": experiment.scene.walls.iter().map(|wall| wall.surface.restitution).collect::<Vec<_>>(),
            "pairs": pairs.mean_restitution,
            "pairs_standard_error": outcome.pair_restitution.and_then(|found| found.error),
            "walls": walls.mean_restitution,
            "walls_standard_error": outcome.wall_restitution.and_then(|found| found.error),
        },
        "impacts": { "pairs": pairs, "walls": walls },
        "instants": hybrid::json(outcome),
        "impacts_per_second": { "pairs": measured(outcome.pair_rate), "walls": measured(outcome.wall_rate) },
        "kinds": outcome.kinds,
        "momentum_balance": momentum_json(outcome),
        "averaging": {
            "from": outcome.profiles.from,
            "until": outcome.profiles.until,
            "blocks": outcome.profiles.blocks,
            "steadiness": outcome.steadiness,
            "replicas": outcome.averaged.replicas,
        },
        // hashes are written as text, because JSON readers keep only 53 bits of a number
        "initial_state_hash": format!("{:016x}", outcome.initial_state_hash),
        "final_state_hash": format!("{:016x}", outcome.final_state_hash),
        "parameters": parameters,
    })
}
