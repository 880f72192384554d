//! Recommendation of an engine, a stiffness and a time step for a case, with reasons.
//!
//! The recommendation depends on the scene, not on measured times, so it is the same on every machine. Local stepping
//! moves only particles in contact by time steps; uniform stepping moves all particles by time steps. The paper is that
//! of `docs/paper.md`.

use super::RunPrediction;
use super::contact::ContactKind;
use super::effects::FROZEN;
use super::gas::{FREEZING, stiffening_for};
use super::integrator::{Method, Scheme, realised_restitution};
use super::obstacles::{against_soft, named};
use super::shear::stiffening_in_shear;
use super::springs::fastest_spring;
use crate::contact_law::ContactLaw;
use crate::experiment::Experiment;
use serde::Serialize;

/// [-] ratio λ* of mean overlap to diameter up to which the flow in the paper (`docs/paper.md`) did not change (Eq.
/// 13). With the recommended stiffness, 99 % of the overlaps are below this value.
const DEEPEST: f64 = 0.05;

/// Numbers of steps per contact from which the recommendation chooses one. The paper's range is T_c/50 to T_c/15
/// (section 3.4).
const STEPS: [f64; 6] = [15.0, 20.0, 30.0, 50.0, 100.0, 200.0];

/// [-] mean fraction of the time that a particle is in contact, above which local stepping takes more computing time
/// than uniform stepping. Ratios of the computing time of local stepping to that of uniform stepping were measured with
/// `diptych plan cases/dense-gas.toml` at lower stiffnesses (medians of four runs on a busy machine). They were 0.9 at
/// the fraction of time 0.04, 1.0 at 0.06 and 1.6 at 0.12. With a volume fraction of 0.4 they were 0.7 at the fraction
/// of time 0.02, 0.8 at 0.04 and 5.7 at 0.12.
const CROWDED: f64 = 0.06;

/// [-] cost per particle of a search for particles that may touch in a window (time between two exchanges with the
/// gas), over the cost of one time step per particle. Local stepping (time steps only for particles in contact)
/// searches at least once per window. A search costs about as much as 60 pair checks, like building the neighbour list
/// (see `neighbours`).
const SEARCH: f64 = 60.0;

/// [-] largest fraction of particles that lie on others or on a wall at the start for which hybrid spheres are
/// recommended. In addition, the window (time between two exchanges with the gas) must have at least `LONG_WINDOW` time
/// steps. Otherwise hybrid spheres may cost more than uniform steps of all particles. The cost of hybrid spheres over
/// that of uniform steps was measured. In `cases/hybrid/rain-on-a-bed.toml` (fraction 0.024) it was 0.36 at 4300 steps
/// per window and 0.8 at 480. In gas-above-bed.toml (fraction 0.11) it was 1.2 at 200.
const FEW_LIE: f64 = 0.05;
const LONG_WINDOW: f64 = 300.0;

/// Number of time steps per contact at which local stepping (time steps only for particles in contact) and uniform
/// stepping (time steps for all particles) are compared; 20 is the default of a case.
const USUAL_STEPS: f64 = 20.0;

/// A kind of engine, together with its way of time stepping.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EngineChoice {
    /// Hard spheres, whose collisions are computed one by one as events.
    Hard,
    /// Soft spheres with local stepping: only particles in contact move in time steps.
    SoftLocal,
    /// Soft spheres with uniform stepping: every particle moves in every time step.
    SoftUniform,
    /// Hybrid spheres: instantaneous collisions if two bodies meet and no other body is near, soft contacts otherwise.
    Hybrid,
    /// Collisions by chance: pairs are chosen at random in cells.
    Dsmc,
}

impl EngineChoice {
    /// All kinds of engines, in the order of their declaration.
    pub const ALL: [Self; 5] = [Self::Hard, Self::SoftLocal, Self::SoftUniform, Self::Hybrid, Self::Dsmc];
}

impl std::fmt::Display for EngineChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Hard => "hard spheres, event-driven",
            Self::SoftLocal => "soft spheres, local stepping",
            Self::SoftUniform => "soft spheres, uniform stepping",
            Self::Hybrid => "hybrid spheres",
            Self::Dsmc => "collisions by chance (dsmc)",
        })
    }
}

/// Recommendation for a case: engine, contact law and time step, with reasons.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Recommendation {
    /// Recommended engine; `None` if no engine of this program is suitable for the case.
    pub engine: Option<EngineChoice>,
    /// Contact law for soft spheres, which are recommended or serve as a comparison with hard spheres. `None` if no
    /// stiffness can be recommended.
    pub law: Option<ContactLaw>,
    /// [-] recommended number of time steps per contact, N_c.
    pub steps_per_contact: f64,
    /// [s] recommended time step: shortest contact time over N_c; `None` without a contact law.
    pub time_step: Option<f64>,
    /// [s] window h: time between two exchanges of momentum with the gas.
    pub window: f64,
    /// True if the recommended model is adequate for the case, including the model of the gas.
    pub adequate: bool,
    /// Reasons for the recommended engine.
    pub reasons: Vec<String>,
    /// Engines that cannot be used for the case, with reasons.
    pub refused: Vec<String>,
    /// Assumptions of the predictions that are doubtful for this scene, one sentence each.
    pub doubts: Vec<String>,
}

impl Recommendation {
    /// Summary of the recommendation in one line.
    pub fn headline(&self) -> String {
        let engine = match self.engine {
            Some(engine) => engine.to_string(),
            None => return format!("No model here is adequate: {}.", self.refused.join("; ")),
        };
        if self.adequate {
            format!("Recommended: {engine}.")
        } else {
            format!(
                "Recommended for the collisions: {engine}. For the gas no model here is adequate: the particles carry more momentum than it has."
            )
        }
    }
}

/// Makes the recommendation for an experiment from its predictions `plan`. `contacts` contains all kinds of contact of
/// the scene, and `temperatures` the granular temperature T [m²/s²] of each species.
pub fn recommend(
    experiment: &Experiment,
    plan: &RunPrediction,
    contacts: &[ContactKind],
    temperatures: &[f64],
) -> Recommendation {
    let hard = against_hard(experiment, plan);
    let soft = against_soft(experiment);
    let mut reasons = Vec::new();
    let wanted = softest(experiment, plan, contacts, temperatures);
    let given = experiment.soft.law;
    let enough = |law: &ContactLaw, least: &ContactLaw| law.parameter().value >= least.parameter().value;
    let law = match (given, &wanted) {
        (Some(given), Some((least, _))) if enough(&given, least) => Some(given),
        (given, wanted) => wanted.as_ref().map(|(least, _)| rounded_up(least)).or(given),
    };
    let engine = match engine(plan, contacts, law, (&hard, &soft)) {
        Some((choice, why)) => {
            reasons.push(why);
            Some(choice)
        }
        None => None,
    };
    if let Some((least, why)) = &wanted {
        let needed = least.parameter();
        let needed = format!("{} {}", plain(needed.value, 3), needed.unit);
        reasons.push(match given.map(|given| (given.parameter(), enough(&given, least))) {
            Some((given, true)) => format!("The case's {given} is enough: {needed} would do ({why})."),
            Some((given, false)) => format!("The case's {given} is too low: at least {needed} ({why})."),
            None => format!("Soft spheres would need at least {needed} ({why})."),
        });
    }
    let scheme = match engine {
        Some(EngineChoice::SoftUniform) => Scheme { method: Method::VelocityVerlet, exact_instants: false },
        Some(EngineChoice::Hard | EngineChoice::SoftLocal | EngineChoice::Hybrid | EngineChoice::Dsmc) | None => {
            Scheme { method: Method::FourthOrder, exact_instants: true }
        }
    };
    let steps_per_contact = steps(plan, contacts, &law.unwrap_or(UNNAMED), scheme, &mut reasons);
    let steps_per_contact = for_springs(experiment, contacts, law, steps_per_contact, &mut reasons);
    let time_step = shortest(contacts, law).map(|time| time / steps_per_contact);
    let doubts = doubts(plan);
    let loading: f64 = plan.flow.iter().map(|flow| flow.mass_loading).sum();
    let coupled = experiment.scene.fluid.as_ref().is_some_and(|fluid| fluid.coupling.is_some());
    Recommendation {
        engine,
        law,
        steps_per_contact,
        time_step,
        window: plan.window,
        adequate: engine.is_some() && (loading <= FROZEN || coupled),
        reasons,
        refused: named(&hard, &soft),
        doubts,
    }
}

/// Chooses the engine, and returns it with the reason for the choice; `None` if no engine is suitable. `against`
/// contains the reasons against hard spheres, and then those against soft spheres.
fn engine(
    plan: &RunPrediction,
    contacts: &[ContactKind],
    law: Option<ContactLaw>,
    against: (&[String], &[String]),
) -> Option<(EngineChoice, String)> {
    // the particles form a dense bed long before the last bounce ends
    let bed = plan.particles + plan.coming.unwrap_or(0) > 1 && (plan.share_at_rest() > 0.0 || plan.lying > 0);
    let lasting = bed || plan.time_in_contact.is_some_and(|share| share > CROWDED);
    let steps_per_window = || shortest(contacts, law).map(|time| plan.window * USUAL_STEPS / time);
    let few_steps = || steps_per_window().is_some_and(|steps| steps < SEARCH);
    let few_lie = plan.share_at_rest() == 0.0 && plan.lying > 0 && plan.lying as f64 <= FEW_LIE * plan.particles as f64;
    match against {
        ([], _) => Some((EngineChoice::Hard, why_hard(plan))),
        (_, []) if few_lie && steps_per_window().is_some_and(|steps| steps >= LONG_WINDOW) => Some((
            EngineChoice::Hybrid,
            format!(
                "{} of the {} particles lie on others and are stepped; all others meet two at a time, for which an instant is enough.",
                plan.lying, plan.particles
            ),
        )),
        (_, []) if lasting => Some((
            EngineChoice::SoftUniform,
            "Contacts last: particles come to lie, or touch others for much of their time, so every particle is stepped."
                .into(),
        )),
        (_, []) if few_steps() => Some((
            EngineChoice::SoftUniform,
            "Several contacts at once need forces that act at the same time; a window has so few time steps that to search it for \
             those who may touch would cost more than to step every particle."
                .into(),
        )),
        (_, []) => Some((
            EngineChoice::SoftLocal,
            "Several contacts at once need forces that act at the same time; few particles touch, so only those are stepped."
                .into(),
        )),
        _ => None,
    }
}

/// [s] duration of the shortest contact under a law; `None` without contacts or without a law.
fn shortest(contacts: &[ContactKind], law: Option<ContactLaw>) -> Option<f64> {
    contacts.iter().filter_map(|contact| Some(contact.contact_time(&law?))).reduce(f64::min)
}

fn why_hard(plan: &RunPrediction) -> String {
    match (plan.time_in_contact, plan.gas.as_ref()) {
        (Some(share), Some(gas)) => format!(
            "Contacts are collisions of two: a particle is in contact for {} % of the time at this stiffness, and flies {} mm between collisions. \
             Hard spheres leave out only what does not show, and need neither stiffness nor time step.",
            plain(100.0 * share, 2),
            plain(1e3 * gas.mean_free_path, 3)
        ),
        _ if plan.coming.is_some() => "Particles come in, and do not come to rest within the run: each collision of two is an instant with a known outcome.".into(),
        _ => "A few bodies that meet two at a time and do not come to rest within the run: each collision is an instant with a known outcome.".into(),
    }
}

/// Reasons against hard spheres for the experiment. If the initial state gives no reason, but the short calibration
/// run has failed, the failure of that run is the reason.
fn against_hard(experiment: &Experiment, plan: &RunPrediction) -> Vec<String> {
    let mut list = plan.obstacles().against_hard(experiment);
    if list.is_empty()
        && let Some(calibration) = &plan.calibration
    {
        list.extend(calibration.failure.iter().cloned());
    }
    list
}

/// Linear contact law from which the recommended stiffness is computed if the case has no contact law. Its stiffness is
/// 1 N/m, so that a factor of stiffening is a stiffness in N/m.
const UNNAMED: ContactLaw = ContactLaw::linear(1.0);

/// Softest adequate contact law of the type in the case, and the requirement that determines its stiffness, in words.
/// `None` if no particle moves.
pub fn softest(
    experiment: &Experiment,
    plan: &RunPrediction,
    contacts: &[ContactKind],
    temperatures: &[f64],
) -> Option<(ContactLaw, String)> {
    let law = experiment.soft.law.unwrap_or(UNNAMED);
    let mut wants: Vec<(f64, String)> = Vec::new();
    for contact in contacts {
        wants.push((
            contact.stiffening_for(&law, DEEPEST),
            format!("99 % of the overlaps below {DEEPEST} d, {}", contact.name),
        ));
    }
    if let Some(gas) = &plan.gas {
        for ((species, ratio), temperature) in experiment.scene.alike().zip(temperatures) {
            let least = stiffening_for(&law.stiffened(ratio), species, *temperature, plan.target_error);
            wants.push((least, format!("cross-section within {} of that of hard spheres", percent(plan.target_error))));
        }
        if experiment.scene.domain.shear.is_some() {
            let longest = contacts.iter().map(|contact| contact.contact_time(&law)).fold(0.0, f64::max);
            let least = stiffening_in_shear(&law, gas.collision_rate * longest, plan.target_error);
            wants.push((least, format!("shear stress within {} of that of hard spheres", percent(plan.target_error))));
        }
    }
    if let Some(rest) = plan.rest.as_ref().filter(|rest| rest.time < plan.duration) {
        let overlaps = contacts.iter().map(|contact| contact.static_overlap(&law, rest.weight));
        wants.push((
            (overlaps.fold(0.0, f64::max) / plan.target_error).powf(law.exponent()),
            format!("the lowest contact at rest within {} of a diameter", percent(plan.target_error)),
        ));
    }
    let wants = wants.into_iter().filter(|(factor, _)| factor.is_finite() && *factor > 0.0);
    let (factor, why) = wants.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((law.stiffened(factor), why))
}

/// Smallest number of steps per contact N_c, out of [`STEPS`], with which errors of the time steps change the energy
/// of a particle by less than the desired relative error. The change is summed over the collisions of the particle
/// within half a response time of drag, or within the whole run if that is shorter. If all numbers are too small, the
/// largest is returned. The reason for the choice is added to `reasons`.
fn steps(
    plan: &RunPrediction,
    contacts: &[ContactKind],
    law: &ContactLaw,
    scheme: Scheme,
    reasons: &mut Vec<String>,
) -> f64 {
    let bounces = plan.rest.as_ref().filter(|_| plan.gas.is_none()).map_or(1.0, |rest| rest.bounces(plan.duration));
    let rate = plan.gas.as_ref().map_or(0.0, |gas| gas.collision_rate + gas.wall_rate / plan.particles.max(1) as f64);
    let memory = plan.flow.iter().map(|flow| 0.5 * flow.response_time).fold(plan.duration, f64::min);
    let remembered = (rate * memory).max(bounces).max(1.0);
    let error = |steps: f64| {
        let misses = contacts.iter().map(|contact| {
            let asked = contact.bodies.restitution;
            realised_restitution(scheme, law, (&contact.spring(law), contact.speeds.mean()), steps)
                .map_or(f64::INFINITY, |realised| (realised.mean_square - asked * asked).abs() / 3.0)
        });
        remembered * misses.fold(0.0, f64::max)
    };
    // if no number of steps is enough (for a restitution of 0), the largest is used, and no accuracy is stated
    let chosen = STEPS.into_iter().find(|&steps| error(steps) <= plan.target_error).unwrap_or(STEPS[STEPS.len() - 1]);
    if error(chosen).is_finite() {
        let over = match remembered.round() {
            1.0 => "one impact".to_owned(),
            many => format!("the {many} impacts whose effect a particle keeps"),
        };
        let change = plain(100.0 * error(chosen), 2);
        reasons.push(format!(
            "{chosen} steps per contact: the realised restitution then changes the kinetic energy by {change} % over {over}."
        ));
    }
    chosen
}

/// Smallest number of steps per contact N_c with which half a period of the fastest tangential, rolling or twisting
/// spring has `steps` time steps. The result is at least `steps`, and equal to `steps` without a law. If it is larger
/// than `steps`, the reason is added to `reasons`.
fn for_springs(
    experiment: &Experiment,
    contacts: &[ContactKind],
    law: Option<ContactLaw>,
    steps: f64,
    reasons: &mut Vec<String>,
) -> f64 {
    /// [-] fraction of a time step that counts as rounding when the number of steps is rounded up.
    const SMALL: f64 = 0.01;
    let (Some(law), Some(shortest)) = (law, shortest(contacts, law)) else { return steps };
    let Some((spring, contact)) = fastest_spring(experiment, &law, contacts) else { return steps };
    let share = spring.half_period() / shortest;
    let needed = (steps / share - SMALL).ceil();
    if needed <= steps {
        return steps;
    }
    reasons.push(format!(
        "{needed} steps per contact, as the {} spring ({}) limits the time step: half its period is {} of a contact and gets {steps} steps.",
        spring.name,
        contact.name,
        plain(share, 2)
    ));
    needed
}

/// Sentences about assumptions of the predictions that are doubtful for this scene; empty if there are none.
fn doubts(plan: &RunPrediction) -> Vec<String> {
    let mut list = Vec::new();
    for effect in plan.effects.iter().filter(|effect| !effect.modelled && !effect.negligible()) {
        list.push(match effect.number {
            Some(number) if number.is_infinite() => format!(
                "{} is not in the model and is not small here: without bound ({}).",
                effect.name, effect.measure
            ),
            Some(number) => format!(
                "{} is not in the model and is not small here: {} against {} ({}).",
                effect.name,
                plain(number, 2),
                plain(effect.threshold, 2),
                effect.measure
            ),
            None => format!("{} is not in the model, and nothing here says how large it is.", effect.name),
        });
    }
    if let Some(gas) = plan.gas.as_ref().filter(|gas| gas.volume_fraction > FREEZING) {
        list.push(format!(
            "at a volume fraction of {:.3} spheres order (freezing: {FREEZING}): kinetic theory does not hold.",
            gas.volume_fraction
        ));
    }
    if plan.calibration.as_ref().is_some_and(|run| !run.steady && plan.gas.is_some()) {
        let why = if plan.transient.is_some() { "nothing is steady here" } else { "the short run was not steady" };
        list.push(format!("{why}: rates, and the costs that follow from them, are means over the short run."));
    }
    list
}

/// Returns the law with its parameter rounded up to 1, 2 or 5 times a power of ten.
pub fn rounded_up(law: &ContactLaw) -> ContactLaw {
    let value = law.parameter().value;
    law.stiffened(round_up(value) / value)
}

/// Rounds a positive number up to 1, 2 or 5 times a power of ten.
pub fn round_up(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    let digits = [1.0, 2.0, 5.0, 10.0].into_iter().find(|digit| digit * power >= value * (1.0 - 1e-12));
    digits.unwrap_or(10.0) * power
}

/// Writes a number in decimal notation with `digits` significant digits, without an exponent.
pub(super) fn plain(value: f64, digits: usize) -> String {
    format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value).to_string()
}

fn percent(share: f64) -> String {
    format!("{} %", (1e6 * share).round() / 1e4)
}
