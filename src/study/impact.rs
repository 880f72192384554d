//! `diptych impact`: computes one impact of two spheres, or of a sphere and a wall, with each collision model. A
//! variant is one of the experiments of a case.

use super::oblique::oblique;
use crate::case::describe_variants;
use crate::cli::ImpactArguments;
use crate::clock::Clock;
use crate::contact_law::Bodies;
use crate::engine::Partner;
use crate::experiment::{Experiment, Model};
use crate::observe;
use crate::output::numbers::significant;
use crate::output::{Analytic, Bounce, BounceValues, ImpactStudy, ObliqueStudy, PathPoint, write_impact};
use crate::particles::Particles;
use crate::record::Impacts;
use crate::runs::{StudyError, conclude, failures_of, folder, provenance, read, start, warn};
use crate::scene::{Kind, Scene, Surface};
use crate::schedule::Schedule;
use crate::simulation::{Simulation, soft_step};
use std::path::Path;

/// Name of the built-in case that runs if the command names no case.
const DEFAULT_CASE: &str = "impact";

/// Largest number of points of a path (gap and normal velocity over time). A point takes 24 bytes, so some hundred
/// megabytes are needed to store, write and draw the path.
const MOST_POINTS: f64 = 1e7;

/// Number of intervals between the stored points of a path. The path of soft spheres has a point after each time step
/// instead.
const POINTS: f64 = 400.0;

/// The two bodies of the case that collide, with the surface properties of their contact.
#[derive(Clone, Copy)]
pub(super) struct ImpactPair {
    pub partner: Partner,
    pub bodies: Bodies,
    pub surface: Surface,
    diameter: f64,
}

/// Simulates the impact with each variant (experiment) of the case and writes the results to one folder.
///
/// # Errors
/// Returns an error for bad input, before anything is computed, or for failures of engines, after everything has been
/// written.
pub fn impact(args: &ImpactArguments) -> Result<(), StudyError> {
    let path = args.case.clone().unwrap_or_else(|| DEFAULT_CASE.into());
    let case = read(&path, &args.input)?;
    let variants = case.variants(None)?;
    let mut runs = Vec::new();
    for (experiment, _) in &variants {
        let particles = start(experiment)?;
        let meeting = meeting(&experiment.scene, &particles, &path)?;
        check_path(experiment, particles.len(), &path)?;
        check_chance(experiment, &meeting, &path)?;
        runs.push((experiment, particles, meeting));
    }
    let folder = folder(&args.output, &path, "impact")?;
    warn(&variants, args.output.quiet);
    let bounces: Vec<Bounce> = runs
        .iter()
        .map(|(experiment, particles, meeting)| {
            let mut bounce = bounce(experiment, particles.clone(), meeting);
            bounce.parameters = case.parameters(experiment);
            bounce
        })
        .collect();
    let (first, particles, meeting) = &runs[0];
    let scene = describe_variants(variants.iter().map(|(experiment, _)| experiment));
    let approach = -point(&first.scene, particles, meeting, 0.0).normal_velocity;
    let mut verdicts: Vec<String> = bounces.iter().map(|bounce| sentence(bounce, &meeting.surface)).collect();
    let all: Vec<_> = runs.iter().map(|(experiment, particles, _)| (*experiment, particles)).collect();
    let oblique = oblique(&all, meeting, approach);
    verdicts.extend(oblique.iter().flat_map(differences));
    let study = ImpactStudy {
        provenance: &provenance(&case, scene),
        bounces: &bounces,
        requested_restitution: meeting.surface.restitution,
        oblique: oblique.as_ref(),
        diameter: meeting.diameter,
        impact_speed: approach,
        verdicts: &verdicts,
        notes: &notes(&meeting.surface),
    };
    let report = write_impact(&folder, &study)?;
    if !args.output.quiet {
        conclude(&verdicts, "Report", &report);
    }
    failures_of(bounces.iter().map(|bounce| (bounce.name.as_str(), bounce.failure.as_ref())))
}

/// Notes for the reader on effects that are missing in the pictures or in the closed form. The properties of the
/// contact are in `surface`.
fn notes(surface: &Surface) -> Vec<String> {
    let mut notes = vec![
        "The closed form of a soft contact (the paper's Eq. 6) leaves out gravity and any other contact while it lasts."
            .to_owned(),
    ];
    if surface.friction > 0.0 {
        notes.push("Friction acts along the surface; the pictures show the normal motion.".into());
    }
    notes
}

/// Sentences on the oblique impacts, one for each variant (experiment of a case) after the first. A sentence gives the
/// largest difference of the tangential impulses of this variant and the first one.
fn differences(study: &ObliqueStudy) -> Vec<String> {
    let first = &study.curves[0].name;
    let sentence = |k: usize| {
        let (share, slip) = study.difference(k)?;
        let name = &study.curves[k].name;
        Some(format!(
            "Oblique impacts: the tangential impulse of \"{name}\" differs from that of \"{first}\" by up to {} % of the largest friction impulse, at s/(μ u_n) = {}.",
            significant(100.0 * share, 2),
            significant(slip, 3)
        ))
    };
    (1..study.curves.len()).filter_map(sentence).collect()
}

fn sentence(bounce: &Bounce, surface: &Surface) -> String {
    if let Some(why) = &bounce.failure {
        return format!("\"{}\" stopped: {why}.", bounce.name);
    }
    let BounceValues { restitution: Some(restitution), contact_time: Some(time), maximum_overlap: Some(overlap) } =
        bounce.values
    else {
        return format!("\"{}\": no impact ended within the duration.", bounce.name);
    };
    let asked = match surface.by_speed {
        None => surface.restitution.to_string(),
        Some(_) => format!("{:.6}", surface.restitution),
    };
    let rebound = format!("\"{}\": restitution {restitution:.6} where {asked} was asked for", bounce.name);
    if bounce.time_step.is_some() && time > 0.0 {
        format!("{rebound}; contact time {time:.4e} s, largest overlap {overlap:.4e} m, {} steps.", bounce.work)
    } else {
        format!("{rebound}, at one instant.")
    }
}

/// Refuses an impact without duration, and a soft impact with so many time steps that its path would fill the memory.
/// The path has one point per step.
fn check_path(experiment: &Experiment, particles: usize, case: &Path) -> Result<(), StudyError> {
    if experiment.run.duration == 0.0 {
        return Err(StudyError::Input(format!(
            "error: {}: the impact \"{}\" lasts for 0 s\nhelp: give a `run.duration` of a few contact times",
            case.display(),
            experiment.name
        )));
    }
    let steps = experiment.run.duration / soft_step(experiment, particles);
    if experiment.model() != Model::Soft || steps <= MOST_POINTS {
        return Ok(());
    }
    Err(StudyError::Input(format!(
        "error: {}: the impact \"{}\" would have {steps:.3e} time steps, each a point of its path; allowed: up to {MOST_POINTS:e}\nhelp: lower `soft.steps_per_contact`, or shorten `run.duration` to a few contact times",
        case.display(),
        experiment.name
    )))
}

/// Refuses an impact of two spheres with the DSMC model. In this model pairs collide at random, so the impact has no
/// certain time and place.
fn check_chance(experiment: &Experiment, meeting: &ImpactPair, case: &Path) -> Result<(), StudyError> {
    if experiment.model() != Model::Dsmc || matches!(meeting.partner, Partner::Wall(_)) {
        return Ok(());
    }
    Err(StudyError::Input(format!(
        "error: {}: in \"{}\" the two spheres collide by chance (model dsmc), so that their impact has no certain time and place\nhelp: use the soft, the hard or the hybrid model, or one sphere and a wall",
        case.display(),
        experiment.name
    )))
}

/// The two bodies of the scene: two spheres, or one sphere and the nearest wall. If the restitution depends on the
/// speed, it is taken at the present speed of approach.
pub(super) fn meeting(scene: &Scene, particles: &Particles, case: &Path) -> Result<ImpactPair, StudyError> {
    let mut found = two_bodies(scene, particles, case)?;
    let approach = -point(scene, particles, &found, 0.0).normal_velocity;
    found.surface.represent(approach);
    found.bodies = found.bodies.at_speed(approach);
    Ok(found)
}

fn two_bodies(scene: &Scene, particles: &Particles, case: &Path) -> Result<ImpactPair, StudyError> {
    let wrong = |what: String| {
        Err(StudyError::Input(format!(
            "error: {}: {what}\nhelp: `impact` shows two spheres, or one sphere and a wall; `cases/impact.toml` is an example",
            case.display()
        )))
    };
    match particles.len() {
        2 => Ok(ImpactPair {
            partner: Partner::Particle(1),
            bodies: Bodies::pair(scene, particles, 0, 1),
            surface: *scene.surface(particles.species[0], Kind::Species(particles.species[1])),
            diameter: 2.0 * particles.radius[0].min(particles.radius[1]),
        }),
        1 => {
            let distance = |k: &usize| scene.walls[*k].geometry.law().nearest(&particles.position[0]).distance;
            let nearest = (0..scene.walls.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let Some(wall) = nearest else { return wrong("one sphere and no wall to meet".into()) };
            Ok(ImpactPair {
                partner: Partner::Wall(wall as u32),
                bodies: Bodies::at_wall(scene, particles, 0, wall),
                surface: *scene.surface(particles.species[0], Kind::Wall(wall as u32)),
                diameter: 2.0 * particles.radius[0],
            })
        }
        count => wrong(format!("{count} spheres")),
    }
}

/// Gap [m] between the two bodies and their normal relative velocity [m/s], at the simulated time `time` [s], to which
/// `scene` and `particles` belong. The gap is negative while the bodies overlap, and the velocity is positive while
/// they separate.
pub(super) fn point(scene: &Scene, particles: &Particles, meeting: &ImpactPair, time: f64) -> PathPoint {
    let place = |id: u32| particles.id.iter().position(|&other| other == id).unwrap_or_default();
    let i = place(0);
    let (gap, normal_velocity) = match meeting.partner {
        Partner::Particle(id) => {
            let j = place(id);
            let velocity = particles.velocity[i] - particles.velocity[j];
            let (apart, velocity) =
                scene.domain.relative(&particles.position[i], &particles.position[j], velocity, 0.0);
            let distance = apart.norm();
            (distance - particles.radius[i] - particles.radius[j], velocity.dot(&apart) / distance)
        }
        Partner::Wall(wall) => {
            let wall = &scene.walls[wall as usize];
            let nearest = wall.geometry.law().nearest(&particles.position[i]);
            let surface = particles.position[i] - nearest.normal * nearest.distance;
            let velocity = particles.velocity[i] - wall.surface_velocity(&surface, 0.0);
            (nearest.distance - particles.radius[i], velocity.dot(&nearest.normal))
        }
    };
    PathPoint { time, gap, normal_velocity }
}

/// Simulates the impact with one variant (experiment of a case). Gap and normal velocity are stored after every window
/// (piece of the run). A window is one time step for soft spheres, else a 400th of the run.
fn bounce(experiment: &Experiment, particles: Particles, meeting: &ImpactPair) -> Bounce {
    let scene = &experiment.scene;
    let duration = experiment.run.duration;
    let step = match experiment.model() {
        Model::Soft => soft_step(experiment, particles.len()),
        Model::Hard | Model::Hybrid | Model::Dsmc => duration / POINTS,
    };
    let windows = (duration / step - 1e-9).ceil().max(1.0);
    let window = duration / windows;
    let schedule = Schedule::even(window, 1, windows as u64);
    let first = point(scene, &particles, meeting, 0.0);
    let mut path = Vec::new();
    let mut noted = |now: &Simulation| path.push(point(now.scene(), &now.particles, meeting, now.time));
    let mut simulation = Simulation::new(experiment, particles).with_clock(Clock::wall());
    let failure = observe::run(&mut simulation, &schedule, &mut [&mut noted]).err();
    let wall_seconds = simulation.spent.whole.as_secs_f64();
    let record = &simulation.record;
    let impacts: &Impacts = if matches!(meeting.partner, Partner::Wall(_)) { &record.walls } else { &record.pairs };
    let summary = impacts.summary();
    let counters = simulation.counters();
    Bounce {
        name: experiment.name.clone(),
        model: experiment.model(),
        values: BounceValues {
            restitution: summary.mean_restitution,
            contact_time: summary.mean_duration,
            maximum_overlap: summary.largest_overlap.map(|overlap| overlap * meeting.diameter),
        },
        analytic: closed_form(experiment, meeting, first),
        time_step: (counters.steps > 0).then(|| match experiment.model() {
            Model::Soft => window,
            // hybrid spheres take steps only during a contact of three or more bodies
            Model::Hybrid => soft_step(experiment, simulation.particles.len()),
            Model::Hard | Model::Dsmc => duration / counters.steps as f64,
        }),
        work: if counters.steps > 0 { counters.steps } else { counters.events },
        wall_seconds,
        parameters: serde_json::Value::Null,
        path,
        failure,
    }
}

/// Closed form of the impact: straight flight until the bodies touch, the contact, then straight flight. A soft contact
/// follows the contact law (Eq. 6 of the paper of docs/paper.md); a hard one takes an instant. `None` if gravity curves
/// the flight towards a wall, if the wall moves, if the bodies do not meet or already overlap at the start, or if the
/// contact has no end.
fn closed_form(experiment: &Experiment, meeting: &ImpactPair, first: PathPoint) -> Option<Analytic> {
    let approach = -first.normal_velocity;
    let scene = &experiment.scene;
    let bent = match meeting.partner {
        Partner::Wall(wall) => scene.gravity.norm() > 0.0 || scene.walls[wall as usize].moving.is_some(),
        Partner::Particle(_) => false,
    };
    if bent || approach <= 0.0 || first.gap < 0.0 {
        return None;
    }
    let e = meeting.surface.restitution;
    let touch = first.gap / approach;
    let (mut contact_time, mut maximum_overlap) = (0.0, 0.0);
    let mut contact: Box<dyn Fn(f64) -> (f64, f64)> = Box::new(|_| (0.0, 0.0));
    if let Some(law) = experiment.law() {
        let spring = law.between(&meeting.bodies);
        contact_time = law.contact_time(&spring, approach);
        // a restitution e = 0 means critical damping, with which a contact has no end
        if !contact_time.is_finite() {
            return None;
        }
        maximum_overlap = law.greatest_overlap(&spring, approach);
        let course = law.course(&spring, approach);
        contact = Box::new(move |time| {
            let (overlap, growth) = course(time);
            (-overlap, -growth)
        });
    }
    let end = touch + contact_time;
    let duration = experiment.run.duration;
    let at = |time: f64| {
        let (gap, normal_velocity) = if time < touch {
            (first.gap - approach * time, -approach)
        } else if time < end {
            contact(time - touch)
        } else {
            (e * approach * (time - end), e * approach)
        };
        PathPoint { time, gap, normal_velocity }
    };
    let mut times: Vec<f64> = (0..=POINTS as usize).map(|k| duration * k as f64 / POINTS).collect();
    // the path has corners at the beginning and the end of the contact, which the picture must show
    times.extend([touch * (1.0 - f64::EPSILON), end].iter().filter(|t| **t < duration));
    // points within the contact, which may be much shorter than the run
    let during = (1..POINTS as usize).map(|k| touch + contact_time * k as f64 / POINTS);
    times.extend(during.filter(|t| contact_time > 0.0 && *t < duration));
    times.sort_by(f64::total_cmp);
    let values =
        BounceValues { restitution: Some(e), contact_time: Some(contact_time), maximum_overlap: Some(maximum_overlap) };
    Some(Analytic { path: times.into_iter().map(at).collect(), values })
}
