//! Document of a run or a comparison.

use super::{gas_flow, hybrid, kinds, measurements, overview, stress, trust, verdict, work};
use crate::outcome::Outcome;
use crate::output::document::{Block, Document, Table, TextRow, known, status};
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

/// Largest number of answers at the top of a page. More answers would make the top too long.
const ANSWERS: usize = 3;

/// Number of standard errors beyond which a deviation is highlighted.
const SUSPECT: f64 = 3.0;

/// [-] magnitude of the unexplained energy, over the energy that passes through the balance, above which it is
/// highlighted. The error of the integrator at 20 steps per contact is much smaller.
const SUSPECT_RESIDUAL: f64 = 1e-3;

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
    tables.extend(gas_flow::csv(outcomes)?.map(|table| ("gas.csv".to_owned(), table)));
    tables.extend(over_time::paths(outcomes)?.map(|table| ("paths.csv".to_owned(), table)));
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
    Ok(Document {
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
    })
}

/// Main part of the page. The first `over_time` figures show curves over time.
fn body(study: &Study, over_time: usize, figures: &[Figure]) -> Vec<Block> {
    let outcomes = study.outcomes;
    // curves over time come first for unsteady runs, whose averages mix different states, and for a few bodies, whose
    // averages have little meaning
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
    body.push(Block::heading("Impacts and overlaps"));
    body.extend(impacts(outcomes));
    body.extend(pictures(figures, &["overlap", "first-overlap", "mean-overlap", "impact-speed"]));
    body.extend(kinds::blocks(outcomes));
    body.extend(hybrid::blocks(outcomes));
    body.extend(stress::blocks(outcomes));
    body.extend(measurements::blocks(outcomes, |name| pictures(figures, &[name])));
    body.extend(gas_flow::blocks(outcomes));
    body.extend(pictures(figures, &["gas"]));
    body.push(Block::heading("Energy ledger"));
    body.extend(energy(outcomes));
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

/// Figures whose names are given, or begin with a given name and a hyphen. Consecutive figures are placed next to each
/// other.
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

/// Distinct texts in order of first appearance, separated by commas.
pub fn distinct(texts: impl Iterator<Item = String>) -> String {
    let mut seen: Vec<String> = Vec::new();
    for text in texts {
        if !seen.contains(&text) {
            seen.push(text);
        }
    }
    seen.join(", ")
}

/// Table with one row per variant. The first cell of a row is the name of the variant.
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

/// Restitution that a case gives; where it depends on the speed, that at the mean normal speed of impact [m/s].
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

/// Notes on the energy that collisions within the contact time of another one have kept.
fn notes_on_contact_time(outcomes: &[Outcome], prefix: &Prefix) -> Vec<Block> {
    let note = |o: &Outcome| {
        let kept = o.record.ledger.contact_time_kept;
        let all = o.record.ledger.through(o.energy_at_start);
        Block::Note(format!(
            "“{}”: restitution would have taken another {} {}J ({}) from collisions that came within the contact \
             time of another and were elastic for it.",
            o.experiment.name,
            significant(kept * prefix.factor, 4),
            prefix.symbol,
            percent(kept, all)
        ))
    };
    outcomes.iter().filter(|o| o.record.ledger.contact_time_kept > 0.0).map(note).collect()
}

/// Parts of the page about the energy balance.
fn energy(outcomes: &[Outcome]) -> Vec<Block> {
    let largest = outcomes
        .iter()
        .flat_map(|o| [o.energy_at_start, o.energy_at_end, o.record.ledger.drag_work, o.record.ledger.gravity_work])
        .filter(|energy| energy.is_finite())
        .fold(0.0, |a: f64, b| a.max(b.abs()));
    let prefix = Prefix::of(largest);
    let joule = |energy: f64| significant(energy * prefix.factor, 4);
    let through = |o: &Outcome| o.record.ledger.through(o.energy_at_start);
    // each variant has a column, with the terms of its balance one below the other
    let row = |name: &str, cell: &dyn Fn(&Outcome) -> String| -> TextRow {
        (false, std::iter::once(name.into()).chain(outcomes.iter().map(cell)).collect())
    };
    let plain = |name: &str, of: fn(&Outcome) -> f64| row(name, &|o| joule(of(o)));
    let work = |name: &str, of: fn(&Outcome) -> f64| {
        row(name, &|o| format!("{} ({})", joule(of(o)), percent(of(o), through(o))))
    };
    // a loss that is only the rounding error of impulses has no meaningful digit
    let loss = |name: &str, of: fn(&Outcome) -> f64| {
        row(name, &|o| {
            let rounding = (of(o) / through(o)).abs() < 1e-12;
            if rounding { "0".into() } else { format!("{} ({})", joule(-of(o)), percent(-of(o), through(o))) }
        })
    };
    let suspect = outcomes.iter().filter_map(relative_residual).any(|residual| residual.abs() > SUSPECT_RESIDUAL);
    let mut rows = vec![
        plain("at the start", |o| o.energy_at_start),
        work("drag", |o| o.record.ledger.drag_work),
        work("gravity", |o| o.record.ledger.gravity_work),
    ];
    let any = |of: fn(&Outcome) -> bool| outcomes.iter().any(of);
    rows.extend(any(|o| o.record.ledger.wall_work != 0.0).then(|| work("moving walls", |o| o.record.ledger.wall_work)));
    rows.extend(
        any(|o| o.experiment.scene.domain.shear.is_some()).then(|| work("shear", |o| o.record.ledger.shear_work)),
    );
    let heated = any(|o| o.experiment.scene.is_heated());
    rows.extend(heated.then(|| work("thermostat and thermal walls", |o| o.record.ledger.thermostat_work)));
    rows.extend([
        loss("restitution between particles", |o| o.record.ledger.pair_restitution_loss),
        loss("friction between particles", |o| o.record.ledger.pair_friction_loss),
        loss("restitution at walls", |o| o.record.ledger.wall_restitution_loss),
        loss("friction at walls", |o| o.record.ledger.wall_friction_loss),
    ]);
    if any(|o| o.experiment.scene.rotation.is_some()) {
        type Part = (&'static str, fn(&Outcome) -> f64);
        let parts: [Part; 6] = [
            ("… of this friction: sliding", |o| o.record.ledger.sliding_loss()),
            ("… tangential restitution (dashpot)", |o| o.record.ledger.friction.tangential_restitution),
            ("… springs at separation", |o| o.record.ledger.friction.separation),
            ("… rescaled springs", |o| o.record.ledger.friction.rescaling),
            ("… rolling resistance", |o| o.record.ledger.friction.rolling),
            ("… twisting resistance", |o| o.record.ledger.friction.twisting),
        ];
        let of_scene = parts.iter().filter(|(_, of)| outcomes.iter().any(|o| of(o) != 0.0));
        rows.extend(of_scene.map(|(name, of)| loss(name, *of)));
    }
    rows.extend([
        plain("at the end", |o| o.energy_at_end),
        (suspect, work("unexplained", |o| o.record.ledger.residual(o.energy_at_start, o.energy_at_end)).1),
    ]);
    let head = std::iter::once(format!("energy [{}J]", prefix.symbol));
    let head = head.chain(outcomes.iter().map(|o| o.experiment.name.clone())).collect();
    let mut blocks = vec![Block::Table(Table { head, rows, remarks: false })];
    blocks.extend(notes_on_contact_time(outcomes, &prefix));
    blocks.push(Block::note(
        "Kinetic and elastic energy; in brackets the share of what went through the ledger (start + |drag| + |gravity| + |moving walls| + |shear| + |thermostat|). \
         Unexplained: rounding for hard spheres, also the integrator’s own gain or loss for soft ones; marked above 0.1 %.",
    ));
    blocks
}

/// Parts of the page about the balance of streamwise forces.
fn momentum(outcomes: &[Outcome]) -> Vec<Block> {
    let forces = |o: &Outcome| {
        let averaged = [o.balance.drag, o.balance.wall, o.balance.residual].into_iter().flatten();
        averaged.map(|force| force.value).chain([o.balance.weight])
    };
    let largest = outcomes.iter().flat_map(forces).filter(|f| f.is_finite()).fold(0.0, |a: f64, b| a.max(b.abs()));
    let prefix = Prefix::of(largest);
    let newton = |force: Option<Estimate>| with_error(force.map(|force| force.times(prefix.factor)));
    let cells = |o: &Outcome| {
        let b = &o.balance;
        let errors = b.residual.and_then(Estimate::in_errors);
        let weight = significant(b.weight * prefix.factor, 4);
        let cells = vec![newton(b.drag), weight, newton(b.wall), newton(b.residual), significant(errors, 2)];
        (errors.is_some_and(|errors| errors.abs() > SUSPECT), cells)
    };
    let note = format!(
        "Mean forces on all particles along the stream in {}N over the averaging period. In a steady flow they add up \
         to zero within the error.",
        prefix.symbol
    );
    vec![table("variant | drag | weight | walls | sum | sum in SE", outcomes, cells), Block::Note(note)]
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

/// Table of hashes of the initial and final states. Equal hashes mean that all bits of the states are equal.
fn hashes(outcomes: &[Outcome]) -> Block {
    let cells =
        |o: &Outcome| (false, vec![format!("{:016x}", o.initial_state_hash), format!("{:016x}", o.final_state_hash)]);
    table("variant | hash of the initial state | hash of the final state", outcomes, cells)
}

/// [-] unexplained energy, over the sum of the magnitudes of the initial energy and of all work (drag, gravity, moving
/// walls, shear, thermostat). `None` if this sum is 0.
fn relative_residual(outcome: &Outcome) -> Option<f64> {
    let ledger = &outcome.record.ledger;
    let through = ledger.through(outcome.energy_at_start);
    let residual = ledger.residual(outcome.energy_at_start, outcome.energy_at_end);
    (through > 0.0).then(|| residual / through)
}

pub(super) fn measured(found: Option<Estimate>) -> Value {
    json!({ "value": found.map(|found| found.value), "standard_error": found.and_then(|found| found.error) })
}

/// Energies of a variant for `summary.json`: start, end, and all terms of the energy balance.
fn energies(outcome: &Outcome) -> Value {
    let ledger = &outcome.record.ledger;
    let mut energies = json!({ "at_start": outcome.energy_at_start, "at_end": outcome.energy_at_end });
    if let (Value::Object(energies), Value::Object(ledger)) = (&mut energies, json!(**ledger)) {
        energies.extend(ledger);
    }
    if let Value::Object(energies) = &mut energies
        && outcome.experiment.scene.rotation.is_none()
    {
        energies.remove("friction");
    } else {
        energies["friction"]["sliding"] = ledger.sliding_loss().into();
    }
    if let Value::Object(energies) = &mut energies
        && outcome.experiment.scene.domain.shear.is_none()
    {
        energies.retain(|key, _| !key.starts_with("shear_"));
    }
    if let Value::Object(energies) = &mut energies
        && !outcome.experiment.scene.is_heated()
    {
        energies.retain(|key, _| !key.starts_with("thermostat_"));
    }
    energies["dissipated"] = ledger.dissipated().into();
    energies["residual"] = ledger.residual(outcome.energy_at_start, outcome.energy_at_end).into();
    energies["residual_relative"] = relative_residual(outcome).into();
    energies
}

/// Data of a variant for `summary.json`, in SI units; `null` means an unknown value.
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
        "energy": energies(outcome),
        "granular_temperature": measured(outcome.temperature),
        "stress": stress::json(outcome),
        "observe": measurements::json(outcome),
        "gas": gas_flow::json(outcome),
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
        "momentum_balance": {
            "drag": measured(outcome.balance.drag),
            "weight": outcome.balance.weight,
            "wall": measured(outcome.balance.wall),
            "residual": measured(outcome.balance.residual),
        },
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
