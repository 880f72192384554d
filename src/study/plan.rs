//! `diptych plan CASE`: predictions for a case before it is run, with the recommended engine, stiffness, time step and
//! duration.

use super::calibration::{Physics, agitated, costs, is_gas, physics, start_variances, variance_of, with_choice};
use crate::case::{Case, Checked, Diagnostic, name_of};
use crate::cli::Plan as Arguments;
use crate::contact_law::ContactLaw;
use crate::experiment::{Experiment, Integrator, Model, Spheres, TimeStep};
use crate::output::numbers::significant;
use crate::output::{PlanDocument, plan_json, plan_text};
use crate::particles::Particles;
use crate::predict::contact::{ContactKind, ImpactSpeeds, StepScales, contacts, step_limits};
use crate::predict::effects::effects;
use crate::predict::flow::flows;
use crate::predict::gas::{AgitationSpread, Component, gas, largest_island, softest as softest_pair};
use crate::predict::integrator::{Method, Scheme};
use crate::predict::obstacles::{Obstacles, bodies};
use crate::predict::recommendation::{rounded_up, softest};
use crate::predict::shear::shear;
use crate::predict::springs::spring_limits;
use crate::predict::transient::{transient, variance_at_start};
use crate::predict::{
    Agitation, Averaging, EngineChoice, PredictedCost, Recommendation, RunPrediction, recommend, shortest_side,
};
use crate::record::Histogram;
use crate::runs::{StudyError, answer, answer_json, read, start, use_threads, warn};
use crate::schedule::Schedule;
use crate::simulation::soft_step;

/// [-] desired relative error of averages for which a plan is made, if the option `--target-error` is not given.
pub const USUAL_TARGET: f64 = 0.01;

/// Plan of a case, the settings that it recommends, and the case with these settings.
pub struct PlannedExperiment {
    /// Predictions for the run, and the measurements on which they depend.
    pub plan: RunPrediction,
    /// Settings that are recommended, such as engine, contact law and steps per contact.
    pub recommendation: Recommendation,
    /// Case with the recommended engine, stiffness and time steps. It is unchanged if no engine is adequate.
    pub experiment: Experiment,
}

/// Makes the plan of a case and prints it.
///
/// # Errors
/// Returns an error if the case has a mistake, if its scene is too crowded to start, or if the plan cannot be printed.
pub fn plan(args: &Arguments) -> Result<(), StudyError> {
    let case = read(&args.case, &args.input)?;
    let checked = any_model(&case, args.effort.seed)?;
    use_threads(args.effort.threads.map(usize::from))?;
    warn(std::slice::from_ref(&checked), args.json);
    let planned = plan_of(&checked.0, args.target_error, true)?;
    let document = document(&case, &planned, &checked.0, args.json)?;
    if args.json { answer_json(&document) } else { answer(&document) }
}

/// Experiment of the case with its own model. If this model cannot run the case, soft spheres are tried, then hard
/// spheres. Any model that can run is enough for a plan, since the plan itself recommends a model. A `seed` replaces
/// that of the case.
pub fn any_model(case: &Case, seed: Option<u64>) -> Result<Checked, Diagnostic> {
    case.experiment(None, seed).or_else(|why| {
        let other = |model| case.experiment(Some(model), seed).ok();
        other(Model::Soft).or_else(|| other(Model::Hard)).ok_or(why)
    })
}

fn document(
    case: &Case,
    planned: &PlannedExperiment,
    experiment: &Experiment,
    json: bool,
) -> Result<String, StudyError> {
    let document = PlanDocument {
        case: case.path.display().to_string(),
        title: case.title.clone(),
        model_of_the_case: name_of(experiment.model()).to_owned(),
        threads: rayon::current_num_threads(),
        plan: &planned.plan,
        recommendation: &planned.recommendation,
    };
    if json { Ok(plan_json(&document)?) } else { Ok(plan_text(&document)) }
}

/// Makes the plan of an experiment whose averages should have the relative error `target` [-]. If `timed` is true,
/// every model that can run the case is also run for some windows (times between two exchanges with the gas) to measure
/// its cost. The recommendation does not depend on this timing.
///
/// # Errors
/// Returns an error if the scene is too crowded to start.
pub fn plan_of(experiment: &Experiment, target: f64, timed: bool) -> Result<PlannedExperiment, StudyError> {
    let measured = physics(experiment);
    let temperatures =
        measured.as_ref().map_or_else(|| start_variances(experiment), |found| found.temperatures.clone());
    let moved = agitated(experiment, &temperatures);
    let particles = start(&moved)?;
    let mut plan = without_contacts(experiment, target, &particles, &temperatures, measured.as_ref());
    let kinds = kinds(experiment, &plan, &particles, &temperatures, measured.as_ref());
    let wanted = softest(experiment, &plan, &kinds, &temperatures).map(|(least, _)| rounded_up(&least));
    let law = experiment.soft.law.or(wanted);
    if let Some(law) = &law {
        with_contacts(&mut plan, experiment, &kinds, &temperatures, law);
    }
    plan.effects = effects(&experiment.scene, &plan);
    plan.transient = plan.gas.as_ref().and_then(|gas| {
        let variances = [variance_at_start(experiment), plan.agitation.variance];
        transient(experiment, gas, plan.rest.as_ref(), variances, target)
    });
    plan.averaging = averaging(experiment, &plan).filter(|_| plan.transient.is_none());
    if timed {
        plan.costs = costs(&moved, &particles, law);
        // the timing is valid for flying particles; in a bed at rest one island (group of particles that may meet)
        // contains all particles, and local steps cost more than uniform steps
        let local = |cost: &&mut PredictedCost| {
            matches!(cost.model, EngineChoice::SoftLocal | EngineChoice::Hybrid) && cost.failure.is_none()
        };
        if plan.particles + plan.coming.unwrap_or(0) > 1 && plan.share_at_rest() > 0.0 {
            plan.costs.iter_mut().filter(local).for_each(|cost| cost.wall_seconds = None);
        }
    }
    let recommendation = recommend(experiment, &plan, &kinds, &temperatures);
    let experiment = follow(experiment, &recommendation);
    Ok(PlannedExperiment { plan, recommendation, experiment })
}

/// Predictions that do not depend on the contact law, such as collision rates, mean free path and the time in which
/// particles come to rest. The fields of the result that depend on the contact law are left empty. `measured` contains
/// the measurements of a short run; `None` without such a run.
fn without_contacts(
    experiment: &Experiment,
    target: f64,
    particles: &Particles,
    temperatures: &[f64],
    measured: Option<&Physics>,
) -> RunPrediction {
    let scene = &experiment.scene;
    let counts = experiment.counts();
    let seen = Obstacles::of(experiment, particles);
    let kinds = scene.species.iter().zip(&counts).zip(temperatures);
    let components: Vec<Component> =
        kinds.flat_map(|((species, &count), &variance)| Component::of(species, count, variance)).collect();
    let spread = measured.map_or_else(AgitationSpread::even, |found| found.spread.clone());
    let gas = is_gas(experiment).then(|| gas(scene, &components, &spread));
    let schedule = Schedule::new(experiment);
    let coming = experiment.expected_count() - experiment.count() as f64;
    let (variance, source) = match measured {
        Some(found) => {
            let run = &found.calibration;
            let steady = if run.steady { "" } else { ", not yet steady" };
            (found.variance, format!("short run of {} particles for {:.4} s{steady}", run.particles, run.simulated))
        }
        None => (variance_of(particles), "the start".to_owned()),
    };
    RunPrediction {
        target_error: target,
        particles: particles.len(),
        coming: (!scene.inlets.is_empty()).then(|| (coming as usize).max(1)),
        duration: experiment.run.duration,
        window: schedule.window,
        agitation: Agitation { variance, source },
        contact_law: String::new(),
        integrator: String::new(),
        contacts: Vec::new(),
        step_limits: Vec::new(),
        largest_island: gas
            .as_ref()
            .and_then(|gas| largest_island(gas.collision_rate * schedule.window, particles.len())),
        gas,
        time_in_contact: None,
        softness: None,
        shear: None,
        rest: seen.rest,
        static_overlap: None,
        starts_overlapping: seen.overlapping,
        in_a_row: seen.in_a_row,
        lying: seen.lying,
        flow: flows(scene, &experiment.expected_numbers()),
        effects: Vec::new(),
        calibration: measured.map(|found| found.calibration.clone()),
        costs: Vec::new(),
        averaging: None,
        transient: None,
    }
}

/// Adds to a plan the predictions that depend on the contact law `law`: contacts, time steps and overlaps.
fn with_contacts(
    plan: &mut RunPrediction,
    experiment: &Experiment,
    kinds: &[ContactKind],
    temperatures: &[f64],
    law: &ContactLaw,
) {
    let scene = &experiment.scene;
    let mut soft = experiment.clone();
    soft.run.spheres = Spheres::Soft(*law);
    let scheme = Scheme::of(soft.soft.integrator, soft.soft.stepping);
    let time_step = soft_step(&soft, experiment.most_that_touch(plan.particles)).min(plan.window);
    let parameter = law.parameter();
    plan.contact_law = format!("{} {} {}", parameter.name, significant(parameter.value, 3), parameter.unit);
    plan.integrator = format!(
        "{}, {}",
        match scheme.method {
            Method::VelocityVerlet => "velocity Verlet",
            Method::Heun => "Heun's second-order Runge-Kutta",
            Method::FourthOrder => "fourth-order Runge-Kutta",
        },
        if scheme.exact_instants { "contacts from exact instants" } else { "contacts found on the grid of steps" }
    );
    plan.contacts = kinds.iter().map(|kind| kind.predict(law, time_step, scheme)).collect();
    let steps_per_contact = match experiment.soft.time_step {
        TimeStep::PerContact(steps) => steps,
        TimeStep::Fixed(step) => plan.contacts.iter().map(|row| row.contact_time).fold(f64::INFINITY, f64::min) / step,
    };
    let channel = scene.fluid.as_ref().and_then(|fluid| fluid.profile.channel_flow());
    let fluid_cell = channel.and_then(|flow| {
        flow.nodes.windows(2).map(|pair| (pair[1].y - pair[0].y).abs()).filter(|dy| *dy > 0.0).reduce(f64::min)
    });
    let fastest = experiment.start.iter().map(|p| p.velocity_mean.norm()).fold(0.0, f64::max);
    let motion = StepScales {
        steps_per_contact,
        speed: fastest + plan.agitation.variance.sqrt(),
        window: plan.window,
        fluid_cell,
    };
    let springs = spring_limits(experiment, law, kinds, steps_per_contact);
    plan.step_limits = step_limits(&plan.contacts, springs, &motion);
    let longest = |wall: bool| {
        plan.contacts.iter().filter(|row| row.contact.wall == wall).map(|row| row.contact_time).fold(0.0, f64::max)
    };
    if let Some(gas) = &plan.gas {
        let walls = gas.wall_rate / plan.particles.max(1) as f64;
        plan.time_in_contact = Some((gas.collision_rate * longest(false) + walls * longest(true)).min(1.0));
        let kinds = experiment.expected_counts().into_iter().zip(temperatures);
        let present: Vec<Option<f64>> = kinds.map(|(count, t)| (count > 0.0).then_some(*t)).collect();
        plan.softness = softest_pair(law, scene, &present).filter(|shrink| *shrink > 0.0);
    }
    plan.shear = plan.gas.as_ref().and_then(|gas| shear(scene, gas, law, [longest(false), plan.target_error]));
    if let Some(rest) = plan.rest.as_ref().filter(|rest| rest.time < plan.duration) {
        let overlaps = kinds.iter().map(|kind| kind.static_overlap(law, rest.weight));
        plan.static_overlap = overlaps.reduce(f64::max);
        plan.time_in_contact = Some(plan.time_in_contact.unwrap_or(0.0).max(1.0 - rest.time / plan.duration));
    }
}

/// Kinds of contact of the case, such as contacts between two species, with their impact speeds. If the particles form
/// a gas, the speeds follow from the temperatures or, with a single species, from a short run. Otherwise the speeds are
/// the largest ones that the velocities at the start and at inlets allow, and at least that of a fall to rest.
/// `measured` contains the measurements of a short run; `None` without such a run.
fn kinds(
    experiment: &Experiment,
    plan: &RunPrediction,
    particles: &Particles,
    temperatures: &[f64],
    measured: Option<&Physics>,
) -> Vec<ContactKind> {
    let counts = experiment.expected_numbers();
    let temperature = |species: usize| temperatures.get(species).copied().unwrap_or(0.0);
    if plan.gas.is_some() {
        let spread = measured.map_or_else(AgitationSpread::even, |found| found.spread.clone());
        // with several species, the measured speeds do not show which species collided
        let counted = measured.filter(|_| experiment.scene.species.len() == 1);
        let speeds = |variance, counted: Option<&Histogram>, parts: &[[f64; 2]]| match counted {
            Some(speeds) => ImpactSpeeds::Measured { variance, speeds: speeds.clone() },
            None => ImpactSpeeds::Gas { variance, parts: parts.to_vec() },
        };
        let pairs = counted.and_then(|found| found.pair_speeds.as_ref());
        let walls = counted.and_then(|found| found.wall_speeds.as_ref());
        let pair = |p, q| speeds(temperature(p) + temperature(q), pairs, &spread.pairs);
        let wall = |p| speeds(temperature(p), walls, &spread.walls);
        return contacts(&experiment.scene, &counts, pair, wall);
    }
    bodies(experiment, particles, plan.rest.as_ref().map_or(0.0, |rest| rest.speed))
}

/// [-] smallest averaging time that is recommended, divided by the mean time between two collisions of a particle.
/// Only for such long times do errors fall with the root of the averaging time.
const FREE_TIMES: f64 = 10.0;

/// Number of particles and averaging time with which averages get the desired error. Errors fall with the square root
/// of the product of the number of particles and the averaging time. `None` if the particles do not form a gas, or if
/// the short run was not steady or gave no error.
fn averaging(experiment: &Experiment, plan: &RunPrediction) -> Option<Averaging> {
    let (gas, run) = (plan.gas.as_ref()?, plan.calibration.as_ref().filter(|run| run.steady)?);
    let needed = run.particles as f64 * run.averaged * (run.temperature_error? / plan.target_error).powi(2);
    let domain = &experiment.scene.domain;
    let diameter = experiment.scene.largest_diameter();
    let side = shortest_side(diameter, gas.mean_free_path, domain.size.y);
    let size: [f64; 3] =
        std::array::from_fn(|axis| if domain.periodic[axis] { side.min(domain.size[axis]) } else { domain.size[axis] });
    let particles = (plan.particles as f64 * size.iter().product::<f64>() / domain.volume()).round().max(1.0);
    // samples (instants of measurement) that are less than a mean free time apart are not independent, so the
    // averaging time has a lower limit
    let shortest = FREE_TIMES / gas.collision_rate;
    Some(Averaging {
        size,
        particles: particles as usize,
        duration: (needed / particles).max(shortest),
        duration_as_given: (needed / plan.particles as f64).max(shortest),
    })
}

/// Copy of the case with the recommended settings. It is unchanged if no engine is adequate. A contact law of the case
/// that is stiff enough is not changed.
fn follow(experiment: &Experiment, recommendation: &Recommendation) -> Experiment {
    let Some(engine) = recommendation.engine else { return experiment.clone() };
    let Some(mut chosen) = with_choice(experiment, engine, recommendation.law) else { return experiment.clone() };
    if engine != EngineChoice::Hard {
        chosen.soft.time_step = TimeStep::PerContact(recommendation.steps_per_contact);
        chosen.soft.integrator = Integrator::VelocityVerlet;
    }
    chosen
}
