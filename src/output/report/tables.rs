//! The tables of a run or comparison.

use super::{note, table};
use crate::experiment::{HardStepping, Model};
use crate::outcome::Outcome;
use crate::output::figures::ROUNDING;
use crate::output::numbers::{Prefix, UNKNOWN, count, percent, quantity, significant, with_error};
use crate::output::summary::{particle_windows_per_second, relative_residual};
use crate::output::{Difference, cost as cost_of};
use crate::record::Impacts;
use crate::statistics::Estimate;
use maud::{Markup, html};

/// What is beyond this many standard errors is marked.
const SUSPECT: f64 = 3.0;

/// [-] share of the energy that went through the ledger; more than this unexplained is marked. The integrator's own
/// error at 20 steps per contact stays well below.
const SUSPECT_RESIDUAL: f64 = 1e-3;

type Row = (bool, Vec<String>);

/// One row per variant, its name first.
fn rows(outcomes: &[Outcome], cells: impl Fn(&Outcome) -> (bool, Vec<String>)) -> Vec<Row> {
    outcomes
        .iter()
        .map(|outcome| {
            let (marked, rest) = cells(outcome);
            (marked, std::iter::once(outcome.experiment.name.clone()).chain(rest).collect())
        })
        .collect()
}

/// What each variant did and what it cost.
pub(super) fn cost(outcomes: &[Outcome]) -> Markup {
    let cheapest = outcomes.iter().map(cost_of).filter(|cost| *cost > 0.0).fold(f64::INFINITY, f64::min);
    let cells = |o: &Outcome| {
        let model = match (o.experiment.model(), o.experiment.hard.stepping) {
            (Model::Soft, _) => "soft",
            (Model::Hard, HardStepping::Events) => "hard, events",
            (Model::Hard, HardStepping::Steps { .. }) => "hard, steps",
        };
        let step = o.time_step.map_or(UNKNOWN.into(), |step| quantity(step, "s", 3));
        let work = [o.counters.steps, o.counters.events].map(|n| if n > 0 { count(n) } else { UNKNOWN.into() });
        let [steps, events] = work;
        let cells = vec![
            model.into(),
            step,
            quantity(o.window, "s", 3),
            quantity(o.simulated_seconds, "s", 3),
            significant(cost_of(o), 3),
            significant(cost_of(o) / cheapest, 3),
            steps,
            events,
            count(o.counters.pair_checks),
        ];
        (o.failure.is_some(), cells)
    };
    let head = [
        "variant",
        "model",
        "time step",
        "window",
        "simulated",
        "wall s per simulated s",
        "over cheapest",
        "steps",
        "events",
        "pair checks",
    ];
    let particles: Vec<usize> = outcomes.iter().map(|outcome| outcome.particles).collect();
    let particles = super::distinct(particles.iter().map(|&n| count(n as u64)));
    html! {
        (table(&head, &rows(outcomes, cells)))
        (note(&format!("Particles: {particles}. Wall-clock times are of one run each and hold for this machine and these threads only; \
            the counts hold everywhere.")))
        (integrators(outcomes))
        (timing(outcomes))
        (islands(outcomes))
    }
}

/// With which integrators contacts were stepped; nothing where there were none.
fn integrators(outcomes: &[Outcome]) -> Markup {
    let stepped = outcomes.iter().filter_map(|outcome| {
        let integrators = outcome.integrators();
        let name = &outcome.experiment.name;
        (!integrators.is_empty()).then(|| format!("“{name}”: {}", integrators.join(", ")))
    });
    let stepped: Vec<String> = stepped.collect();
    if stepped.is_empty() {
        return html! {};
    }
    note(&format!("Integrators of the contacts that ran. {}.", stepped.join("; ")))
}

/// What islands came to; nothing where there were none.
fn islands(outcomes: &[Outcome]) -> Markup {
    if outcomes.iter().all(|o| o.counters.islands == 0) {
        return html! {};
    }
    let cells = |o: &Outcome| {
        let c = &o.counters;
        let cells = if c.islands == 0 {
            vec![UNKNOWN.into(); 5]
        } else {
            vec![
                count(c.neighbour_builds),
                count(c.islands),
                significant(c.island_members as f64 / c.islands as f64, 3),
                count(c.largest_island),
                percent(c.islands_redone as f64, c.islands as f64),
            ]
        };
        (false, cells)
    };
    let head = ["variant", "searches", "islands", "members, mean", "members, most", "done again"];
    html! {
    (table(&head, &rows(outcomes, cells)))
    (note("Island: particles that may touch one another within a part of a window, solved on their own.")) }
}

/// Where the time went.
fn timing(outcomes: &[Outcome]) -> Markup {
    let cells = |o: &Outcome| {
        let t = &o.timing;
        let islands = t.engine - t.neighbours - t.flight;
        let parts = [t.neighbours, islands, t.flight, t.drag, t.statistics].map(|part| percent(part, t.wall_seconds));
        let time = quantity(t.wall_seconds, "s", 3);
        let speed = significant(particle_windows_per_second(o), 3);
        (false, [time].into_iter().chain(parts).chain([t.threads.to_string(), speed]).collect())
    };
    let head = [
        "variant",
        "wall time",
        "neighbours",
        "islands, contacts",
        "flight",
        "drag",
        "statistics",
        "threads",
        "particle-windows per s",
    ];
    table(&head, &rows(outcomes, cells))
}

/// Variants against the reference.
pub(super) fn differences(differences: &[Difference]) -> Markup {
    let row = |d: &Difference| {
        let unit = if d.unit.is_empty() { "–" } else { &d.unit };
        let y = if d.y.is_finite() { quantity(d.y, "m", 3) } else { UNKNOWN.into() };
        let single = d.slices <= 1;
        let rms = if single { UNKNOWN.into() } else { significant(d.rms_in_errors, 2) };
        let beyond = if single {
            UNKNOWN.into()
        } else {
            format!("{} of {} ({})", d.beyond_three, d.slices, significant(d.expected_beyond_three, 2))
        };
        let cells = vec![
            symbol(&d.quantity),
            unit.to_owned(),
            format!("{} − {}", d.variant, d.reference),
            with_error(d.largest.value, d.largest.error),
            y,
            significant(d.in_errors(), 2),
            rms,
            beyond,
        ];
        (d.in_errors().abs() > SUSPECT, cells)
    };
    let head = [
        "quantity",
        "unit",
        "difference",
        "largest ± 1 SE",
        "at y",
        "largest in SE",
        "rms in SE",
        "beyond 3 SE (by chance)",
    ];
    html! {
        (table(&head, &differences.iter().map(row).collect::<Vec<_>>()))
        (note("SE: standard error from the scatter between blocks of time. For a profile, the slice that differs most. If only \
            chance differs, the rms is near 1; among 40 slices a largest value of 2 to 3 is then ordinary. Rows beyond 3 are marked."))
    }
}

/// A quantity as the pictures write it.
fn symbol(quantity: &str) -> String {
    match quantity {
        "number_density_ratio" => "n/⟨n⟩".into(),
        "uu" | "vv" | "ww" | "uv" | "uw" | "vw" => {
            let factors: String = quantity.chars().flat_map(|c| [c, '″']).collect();
            format!("⟨{factors}⟩")
        }
        other => other.into(),
    }
}

/// What happened when spheres met each other and walls.
pub(super) fn impacts(outcomes: &[Outcome]) -> Markup {
    let pairs = |o: &Outcome| {
        let requested = significant(o.experiment.scene.contact.restitution, 4);
        (false, impact_cells(&o.pairs, o.pair_rate, requested))
    };
    let walls = |o: &Outcome| {
        let each = o.experiment.scene.walls.iter().map(|wall| significant(wall.surface.restitution, 4));
        (false, impact_cells(&o.walls, o.wall_rate, super::distinct(each)))
    };
    let walled = outcomes.iter().any(|outcome| !outcome.experiment.scene.walls.is_empty());
    let head = [
        "variant",
        "impacts",
        "impacts per s",
        "mean normal speed [m/s]",
        "e requested",
        "e realised",
        "mean duration",
        "mean δ/d",
        "99 % δ/d",
        "largest δ/d",
    ];
    html! {
        p { strong { "Between particles" } }
        (table(&head, &rows(outcomes, pairs)))
        @if walled {
            p { strong { "At walls" } }
            (table(&head, &rows(outcomes, walls)))
        }
        (note("e realised: root of the normal energy after over before, summed over impacts. δ: largest overlap of an impact, d: diameter, of unequal spheres the smaller one; collisions of hard \
            spheres have no duration, and no overlap at exact instants. "))
    }
}

fn impact_cells(impacts: &Impacts, rate: Estimate, requested: String) -> Vec<String> {
    let s = impacts.summary();
    let known = |text: String| if s.count > 0 { text } else { UNKNOWN.into() };
    // Collisions at the exact instant have neither; those found at the ends of steps have an overlap.
    let lasting = |text: String| if s.mean_duration > 0.0 { text } else { UNKNOWN.into() };
    // at the exact instant they have none but that of rounding
    let deep = |value: f64| if s.largest_overlap > ROUNDING { significant(value, 3) } else { UNKNOWN.into() };
    vec![
        count(s.count),
        with_error(rate.value, rate.error),
        known(significant(s.mean_normal_speed, 3)),
        requested,
        known(significant(s.mean_restitution, 5)),
        lasting(quantity(s.mean_duration, "s", 3)),
        deep(s.mean_maximum_overlap),
        deep(s.p99_maximum_overlap),
        deep(s.largest_overlap),
    ]
}

/// Where the energy went.
pub(super) fn energy(outcomes: &[Outcome]) -> Markup {
    let largest = outcomes
        .iter()
        .flat_map(|o| [o.energy_at_start, o.energy_at_end, o.record.ledger.drag_work, o.record.ledger.gravity_work])
        .filter(|energy| energy.is_finite())
        .fold(0.0, |a: f64, b| a.max(b.abs()));
    let prefix = Prefix::of(largest);
    let joule = |energy: f64| significant(energy * prefix.factor, 4);
    let through = |o: &Outcome| o.record.ledger.through(o.energy_at_start);
    // Variants stand side by side: a ledger reads downwards.
    let plain = |name: &str, of: fn(&Outcome) -> f64| -> Row {
        (false, std::iter::once(name.into()).chain(outcomes.iter().map(|o| joule(of(o)))).collect())
    };
    let work = |name: &str, of: fn(&Outcome) -> f64| -> Row {
        let cell = |o: &Outcome| format!("{} ({})", joule(of(o)), percent(of(o), through(o)));
        (false, std::iter::once(name.into()).chain(outcomes.iter().map(cell)).collect())
    };
    // impulses lose what rounding takes: no digit of it means anything
    let loss = |name: &str, of: fn(&Outcome) -> f64| -> Row {
        let cell = |o: &Outcome| {
            let share = of(o) / through(o);
            if share.abs() < 1e-12 {
                "0".into()
            } else {
                format!("{} ({})", joule(-of(o)), percent(-of(o), through(o)))
            }
        };
        (false, std::iter::once(name.into()).chain(outcomes.iter().map(cell)).collect())
    };
    let kept = |o: &Outcome| o.record.ledger.contact_time_kept;
    let suspect = outcomes.iter().any(|o| relative_residual(o).abs() > SUSPECT_RESIDUAL);
    let table_rows = [
        plain("at the start", |o| o.energy_at_start),
        work("drag", |o| o.record.ledger.drag_work),
        work("gravity", |o| o.record.ledger.gravity_work),
        loss("restitution between particles", |o| o.record.ledger.pair_restitution_loss),
        loss("friction between particles", |o| o.record.ledger.pair_friction_loss),
        loss("restitution at walls", |o| o.record.ledger.wall_restitution_loss),
        loss("friction at walls", |o| o.record.ledger.wall_friction_loss),
        plain("at the end", |o| o.energy_at_end),
        (suspect, work("unexplained", |o| o.record.ledger.residual(o.energy_at_start, o.energy_at_end)).1),
    ];
    let unit = format!("energy [{}J]", prefix.symbol);
    let head: Vec<&str> =
        std::iter::once(unit.as_str()).chain(outcomes.iter().map(|o| o.experiment.name.as_str())).collect();
    html! {
        (table(&head, &table_rows))
        @for o in outcomes.iter().filter(|o| kept(o) > 0.0) {
            (note(&format!("“{}”: restitution would have taken another {} {}J ({}) from collisions that came within the contact \
                time of another and were elastic for it.", o.experiment.name, joule(kept(o)), prefix.symbol, percent(kept(o), through(o)))))
        }
        (note("Kinetic and elastic energy; in brackets the share of what went through the ledger (start + |drag| + |gravity|). \
            Unexplained: rounding for hard spheres, also the integrator’s own gain or loss for soft ones; marked above 0.1 %."))
    }
}

/// Whether the forces along the stream add up to nothing.
pub(super) fn momentum(outcomes: &[Outcome]) -> Markup {
    let forces = |o: &Outcome| [o.balance.drag.value, o.balance.weight, o.balance.wall.value, o.balance.residual.value];
    let largest = outcomes.iter().flat_map(forces).filter(|f| f.is_finite()).fold(0.0, |a: f64, b| a.max(b.abs()));
    let prefix = Prefix::of(largest);
    let newton = |e: Estimate| with_error(e.value * prefix.factor, e.error * prefix.factor);
    let cells = |o: &Outcome| {
        let b = &o.balance;
        let errors = if b.residual.error > 0.0 { b.residual.value / b.residual.error } else { f64::NAN };
        let weight = significant(b.weight * prefix.factor, 4);
        let cells = vec![newton(b.drag), weight, newton(b.wall), newton(b.residual), significant(errors, 2)];
        (errors.abs() > SUSPECT, cells)
    };
    html! {
        (table(&["variant", "drag", "weight", "walls", "sum", "sum in SE"], &rows(outcomes, cells)))
        (note(&format!("Mean forces on all particles along the stream in {}N over the averaging period. In a steady flow they add up \
            to zero within the error.", prefix.symbol)))
    }
}

/// When averaging began and whether the flow was steady.
pub(super) fn averaging(outcomes: &[Outcome]) -> Markup {
    let cells = |o: &Outcome| {
        let s = &o.steadiness;
        let steady = if s.steady { "yes" } else { "no" };
        let times = [o.profiles.from, o.profiles.until].map(|time| quantity(time, "s", 3));
        let samples: u64 = o.profiles.slices.iter().map(|slice| slice.samples).sum();
        let rest = [
            o.profiles.blocks.to_string(),
            count(samples),
            steady.into(),
            s.drift.map_or(UNKNOWN.into(), |drift| significant(drift, 2)),
        ];
        (!s.steady, times.into_iter().chain(rest).collect())
    };
    html! {
        (table(&["variant", "from", "until", "blocks", "particle samples", "steady", "drift in SE"], &rows(outcomes, cells)))
        (note("Drift: second minus first half of the averaged time, the largest of the observed series. Averages of a flow that is \
            not steady describe this run, not the flow."))
    }
}

/// The final states: equal hashes mean equal bits.
pub(super) fn hashes(outcomes: &[Outcome]) -> Markup {
    let cells =
        |o: &Outcome| (false, vec![format!("{:016x}", o.initial_state_hash), format!("{:016x}", o.final_state_hash)]);
    table(&["variant", "hash of the initial state", "hash of the final state"], &rows(outcomes, cells))
}
