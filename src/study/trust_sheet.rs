//! Trust sheet of a variant (one of the experiments of a case): numbers that show how reliable its results are, each
//! with its expected value or its limit. The paper is that of docs/paper.md.

use super::trust::{MISS, meets_several, softness};
use crate::engine::Failure;
use crate::experiment::{HardStepping, Model};
use crate::outcome::Outcome;
use crate::output::numbers::{percent, with_error};
use crate::output::{Expected, HalvedStep, Judgement, TrustCheck, TrustSheet};
use crate::statistics::Estimate;

/// Number of standard errors up to which a difference from the expected value is attributed to chance.
const SUSPECT: f64 = 3.0;
/// [-] largest share of the energy that the energy balance of a run may leave unexplained. The error of the integrator
/// at 20 steps per contact is much smaller.
const RESIDUAL: f64 = 1e-3;
/// [-] limit of the mean overlap of the impacts, divided by the diameter of the smaller particle. It is λ in Eq. 11 of
/// the paper, which uses the mean impact speed.
const MEAN_OVERLAP: f64 = 0.01;
/// [-] limit of the largest overlap, divided by the diameter of the smaller particle. It is the weaker of the two
/// limits that the paper gives below its Eq. 10.
const LARGEST_OVERLAP: f64 = 0.1;
/// [-] limit of the softness, above which the sheet marks it. Soft spheres act like hard spheres whose diameter is
/// smaller by this share. At the limit, impacts in a dilute gas make the agitation (random velocities) of the three
/// directions equal 0.8 % more slowly than impacts of hard spheres. This is π/2 times the softness
/// (docs/theory/softness.md).
const SOFTNESS: f64 = 0.005;

/// Makes the trust sheet (checks of reliability) of the outcome of one variant (experiment of a case). `halved_step`
/// is the comparison with a run whose time step is half as long.
pub fn trust_sheet(outcome: &Outcome, halved_step: HalvedStep) -> TrustSheet {
    let mut checks = vec![completed(outcome), escapes(outcome)];
    checks.extend(restitutions(outcome));
    checks.extend(overlaps(outcome));
    checks.push(energy(outcome));
    checks.push(momentum(outcome));
    checks.push(steady(outcome));
    checks.push(soft_diameter(outcome));
    checks.push(threads(outcome));
    TrustSheet { variant: outcome.experiment.name.clone(), checks, halved_step }
}

fn certain(value: f64) -> Estimate {
    Estimate::without_error(value)
}

/// Makes one check of the trust sheet. With the expectation `Equals`, a result is suspect if its difference from the
/// expected value exceeds `allowed`. If the result has a standard error, the difference must also exceed 3 standard
/// errors. With `AtMost`, a result is suspect if its magnitude exceeds the limit; with `Anything` it is not judged.
fn check(name: &'static str, unit: &'static str, found: Estimate, expected: Expected, allowed: f64) -> TrustCheck {
    let mut check =
        TrustCheck { name, unit, found: Some(found), expected, judgement: Judgement::Stated, remark: String::new() };
    let good = match expected {
        Expected::Anything => return check,
        Expected::Equals(value) => {
            let by_chance = check.in_errors().is_some_and(|errors| errors.abs() <= SUSPECT);
            (found.value - value).abs() <= allowed || by_chance
        }
        Expected::AtMost(limit) => found.value.abs() <= limit,
    };
    check.judgement = if good { Judgement::Good } else { Judgement::Suspect };
    check
}

fn remarked(check: TrustCheck, remark: impl Into<String>) -> TrustCheck {
    TrustCheck { remark: remark.into(), ..check }
}

fn unknown(name: &'static str, unit: &'static str, why: &str) -> TrustCheck {
    let (expected, judgement) = (Expected::Anything, Judgement::Unknown);
    TrustCheck { name, unit, found: None, expected, judgement, remark: why.into() }
}

fn completed(outcome: &Outcome) -> TrustCheck {
    let duration = outcome.experiment.run.duration;
    let found =
        check("simulated time", "s", certain(outcome.simulated_seconds), Expected::Equals(duration), 1e-9 * duration);
    match &outcome.failure {
        Some(why) => remarked(found, format!("stopped early: {why}")),
        None => remarked(found, "the run reached its end"),
    }
}

fn escapes(outcome: &Outcome) -> TrustCheck {
    let escaped = matches!(outcome.failure, Some(Failure::Escaped { .. }));
    let found = check("escapes", "", certain(if escaped { 1.0 } else { 0.0 }), Expected::Equals(0.0), 0.0);
    remarked(found, "particles outside the box at a sample; the first one stops the run")
}

fn restitutions(outcome: &Outcome) -> [TrustCheck; 2] {
    let scene = &outcome.experiment.scene;
    let of = |name, count: u64, found: Option<Estimate>, asked: Option<f64>, missing: &str| {
        let Some(found) = found else {
            return unknown(name, "", if count == 0 { missing } else { "no interval between samples saw an impact" });
        };
        let several = meets_several(outcome);
        let expected = asked.filter(|_| !several).map_or(Expected::Anything, Expected::Equals);
        let remark = match (asked, found.error) {
            (None, _) => "the case asks for several restitutions, or one by speed: the mean over all of these impacts",
            _ if several => "spheres touch several others at once and share their energy: not that of one impact",
            (Some(_), None) => "too few intervals between samples saw an impact: no standard error",
            (Some(_), Some(_)) => "suspect beyond 0.005 and 3 SE",
        };
        remarked(check(name, "", found, expected, MISS), remark)
    };
    let no_wall_impact = if scene.walls.is_empty() { "there are no walls" } else { "no impact on a wall ended" };
    [
        of(
            "restitution, pairs",
            outcome.record.pairs.count,
            outcome.pair_restitution,
            scene.restitution_of_pairs(),
            "no impact between particles ended",
        ),
        of(
            "restitution, walls",
            outcome.record.walls.count,
            outcome.wall_restitution,
            scene.restitution_at_walls().filter(|_| !scene.has_thermal_walls()),
            no_wall_impact,
        ),
    ]
}

fn overlaps(outcome: &Outcome) -> Vec<TrustCheck> {
    const NAMES: [[&str; 3]; 2] = [
        ["mean overlap δ/d, pairs", "99 % of overlaps δ/d, pairs", "largest overlap δ/d, pairs"],
        ["mean overlap δ/d, walls", "99 % of overlaps δ/d, walls", "largest overlap δ/d, walls"],
    ];
    let experiment = &outcome.experiment;
    let instant = match experiment.model() {
        Model::Hard => experiment.hard.stepping == HardStepping::Events,
        Model::Dsmc => true,
        Model::Soft | Model::Hybrid => false,
    };
    let source = if experiment.model().has_contacts() {
        ["Eq. 11 of the paper, at the mean impact speed", "", "the paper, below its Eq. 10"]
    } else {
        ["how late collisions are seen; limits as for soft contacts", "", "how late collisions are seen"]
    };
    let kinds = [
        (&outcome.pairs, &outcome.record.pairs, true),
        (&outcome.walls, &outcome.record.walls, !experiment.scene.walls.is_empty()),
    ];
    let mut checks = Vec::new();
    for (names, (impacts, ever, present)) in NAMES.iter().zip(kinds) {
        if !present {
            continue;
        }
        let summary = impacts.summary();
        let (Some(mean), Some(deep), Some(largest)) =
            (summary.mean_maximum_overlap, summary.p99_maximum_overlap, ever.maximum_overlap.largest())
        else {
            checks.push(unknown(names[0], "", "no impact ended"));
            continue;
        };
        if instant {
            checks.push(unknown(names[0], "", "collisions at exact instants have no overlap"));
            continue;
        }
        let mean = Estimate { value: mean, error: impacts.maximum_overlap.standard_error() };
        checks.push(remarked(check(names[0], "", mean, Expected::AtMost(MEAN_OVERLAP), 0.0), source[0]));
        checks.push(remarked(check(names[1], "", certain(deep), Expected::Anything, 0.0), source[1]));
        let largest = check(names[2], "", certain(largest), Expected::AtMost(LARGEST_OVERLAP), 0.0);
        checks.push(remarked(largest, source[2]));
    }
    checks
}

fn energy(outcome: &Outcome) -> TrustCheck {
    const NAME: &str = "energy unexplained, of what went through";
    let through = outcome.record.ledger.through(outcome.energy_at_start);
    if through <= 0.0 {
        return unknown(NAME, "", "nothing moves: no energy went through the ledger");
    }
    remarked(
        check(NAME, "", outcome.energy_residual.over(through), Expected::AtMost(RESIDUAL), 0.0),
        "through: start + |drag| + |gravity| + |moving walls| + |shear| + |thermostat| + |inflow less outflow|; rounding for hard spheres, the integrator's gain or loss for soft ones",
    )
}

fn momentum(outcome: &Outcome) -> TrustCheck {
    const NAME: &str = "streamwise forces, sum";
    let balance = &outcome.balance;
    if balance.is_idle() {
        return unknown(NAME, "N", "no drag, weight, wall friction, inflow or outflow acts along the stream");
    }
    let Some(residual) = balance.residual.filter(|residual| residual.error.is_some()) else {
        return unknown(NAME, "N", "too few samples in the averaging period for a standard error");
    };
    let found = check(NAME, "N", residual, Expected::Equals(0.0), 0.0);
    match balance.flow.filter(|_| outcome.experiment.scene.has_openings()) {
        Some(flow) => {
            let flow = with_error(flow);
            remarked(found, format!("drag + weight + walls + inflow less outflow ({flow} N): zero in a steady flow"))
        }
        None => remarked(found, "drag + weight + walls: zero in a steady flow"),
    }
}

fn steady(outcome: &Outcome) -> TrustCheck {
    const NAME: &str = "drift while averaging, in SE";
    let steadiness = &outcome.steadiness;
    let Some(drift) = steadiness.drift else {
        return unknown(NAME, "", "too few samples to judge whether the averaged part is steady");
    };
    let found = check(NAME, "", certain(drift), Expected::AtMost(SUSPECT), 0.0);
    if steadiness.steady {
        return remarked(found, "steady");
    }
    let why = if found.judgement == Judgement::Good {
        "not steady: no steady start was found in the first half of the run"
    } else {
        "not steady: averages describe this run, not the flow"
    };
    remarked(TrustCheck { judgement: Judgement::Suspect, ..found }, why)
}

fn soft_diameter(outcome: &Outcome) -> TrustCheck {
    const NAME: &str = "softness: spheres act as if smaller by";
    let pairs = &outcome.record.pairs;
    match outcome.experiment.model() {
        Model::Hard => return unknown(NAME, "", "hard spheres are not soft"),
        Model::Dsmc => return unknown(NAME, "", "spheres that collide by chance are not soft"),
        Model::Hybrid if pairs.instants.count > 0 => {
            let share = percent(pairs.instants.count as f64, pairs.count as f64);
            let why = format!("{share} of the impacts between particles are instants: see what they leave out");
            return unknown(NAME, "", &why);
        }
        Model::Soft | Model::Hybrid if pairs.count == 0 => {
            return unknown(NAME, "", "no impact between particles ended");
        }
        Model::Soft | Model::Hybrid => {}
    }
    match softness(outcome) {
        Some(shrink) => remarked(
            check(NAME, "", certain(shrink), Expected::AtMost(SOFTNESS), 0.0),
            "sqrt(π m T/(2 k_n))/d; at 0.005 impacts make the agitation of the directions equal 0.8 % more slowly",
        ),
        None => unknown(NAME, "", "few spheres, or none sampled: the agitation of a gas is not known"),
    }
}

fn threads(outcome: &Outcome) -> TrustCheck {
    let found = check("threads", "", certain(outcome.timing.threads as f64), Expected::Anything, 0.0);
    remarked(found, "results are the same for any number")
}
