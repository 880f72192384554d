//! Reasons why a model cannot be used for a case, as far as the scene and the initial state show them. The commands
//! `plan` and `check` use them.

use super::contact::{ContactKind, ImpactSpeeds, contacts};
use super::flow::{flows, lift};
use super::rest::{Rest, rest};
use super::touching::{in_a_row, lying, overlapping};
use crate::experiment::{Amount, Experiment};
use crate::particles::Particles;
use crate::scene::Inlet;
use nalgebra::Vector3;

/// Properties of the start of a run that may exclude an engine.
#[derive(Clone, Debug)]
pub struct Obstacles {
    /// Floor on which particles gather under gravity; `None` if there is no such floor.
    pub rest: Option<Rest>,
    /// True if particles overlap each other or a wall at the start.
    pub overlapping: bool,
    /// True if the start has rows of particles whose gaps are less than twice the overlap of an impact.
    pub in_a_row: bool,
    /// Number of particles that lie on a wall or on other particles at the start.
    pub lying: usize,
}

impl Obstacles {
    /// Finds the properties of the initial state `start` that may exclude hard spheres. Neighbours in a row count as
    /// touching if their gap is less than twice the overlap of an impact under the contact law of the case.
    pub fn of(experiment: &Experiment, start: &Particles) -> Self {
        let scene = &experiment.scene;
        let given = experiment.start.iter().flat_map(|population| match &population.amount {
            Amount::Placed(placed) => vec![true; placed.len()],
            Amount::Count(count) => vec![false; *count],
        });
        let given: Vec<bool> = given.collect();
        let placed = given.iter().all(|given| *given);
        let lift = lift(scene, &flows(scene, &experiment.expected_numbers()));
        let rest = rest(experiment, start, lift);
        let fall = rest.as_ref().map_or(0.0, |rest| rest.speed);
        let deepest = experiment.soft.law.filter(|_| placed).map_or(0.0, |law| {
            let deep = |kind: &ContactKind| kind.largest_overlap(&law, kind.speeds.quantile(0.99));
            bodies(experiment, start, fall).iter().map(deep).fold(0.0, f64::max)
        });
        Self {
            rest,
            overlapping: overlapping(scene, start),
            in_a_row: placed && in_a_row(scene, start, deepest),
            // particles that the gas lifts do not lie on the floor
            lying: if given.contains(&true) && lift.is_none_or(|lift| lift <= 0.0) {
                lying(scene, start, &given)
            } else {
                0
            },
        }
    }

    /// Reasons why hard spheres cannot be used for the experiment; empty if there are none.
    pub fn against_hard(&self, experiment: &Experiment) -> Vec<String> {
        let duration = experiment.run.duration;
        let mut list = Vec::new();
        // with a contact time, collisions in quick succession are elastic, so a bed hovers above the floor
        let rests = |rest: &&Rest| rest.time < duration && experiment.hard.contact_time.is_none();
        if let Some(rest) = self.rest.as_ref().filter(rests) {
            let time = rest.time;
            let when = match (time > 0.0, rest.slides) {
                (true, false) => {
                    format!("come to rest after about {time:.3e} s of {duration} s: ever shorter bounces without end")
                }
                (true, true) => format!(
                    "stay on the floor after about {time:.3e} s of {duration} s, and slide or roll along it: ever shorter bounces without end"
                ),
                (false, false) => "lie at rest from the start".to_owned(),
                (false, true) => "lie on the floor from the start, and slide or roll along it".to_owned(),
            };
            list.push(format!("particles {when}, and instants cannot carry weight"));
        } else if self.lying > 0 && experiment.hard.contact_time.is_none() {
            list.push(format!(
                "{} of the particles lie on something at the start, and instants cannot carry weight",
                self.lying
            ));
        }
        if experiment.scene.has_servo_walls() {
            list.push("a servo wall measures the force of contacts that last".into());
        }
        if self.overlapping {
            list.push("the start has spheres that overlap, which hard ones cannot".into());
        }
        if self.in_a_row {
            list.push(
                "neighbours that touch at the start, or nearly: a blow reaches several at once, hard spheres pass it on one by one"
                    .into(),
            );
        }
        list
    }
}

/// Reasons why soft spheres of any stiffness cannot be used for the experiment; empty if there are none.
pub fn against_soft(experiment: &Experiment) -> Vec<String> {
    let scene = &experiment.scene;
    let mut list = Vec::new();
    if scene.surfaces(experiment.most_that_touch(experiment.count())).iter().any(|surface| !surface.always_rebounds()) {
        list.push("a restitution of 0 needs critical damping, with which a contact never ends".into());
    }
    if scene.has_thermal_walls() {
        list.push("a thermal wall gives a new velocity in an instant, which a lasting contact does not have".into());
    }
    list
}

/// Adds to each reason the name of the model that it excludes, and returns the lines of text. `hard` and `soft`
/// contain the reasons against hard spheres and soft spheres.
pub fn named(hard: &[String], soft: &[String]) -> Vec<String> {
    let of = |name: &str, list: &[String]| list.iter().map(|why| format!("{name}: {why}")).collect::<Vec<_>>();
    [of("hard spheres", hard), of("soft spheres", soft)].concat()
}

/// Kinds of contact of a few bodies, each with the normal speed of its fastest impact. This speed is the largest one
/// that the velocities at the start and at inlets allow, but at least `fall` [m/s].
pub fn bodies(experiment: &Experiment, start: &Particles, fall: f64) -> Vec<ContactKind> {
    let (apart, fastest) = speeds(start, &experiment.scene.inlets);
    let pair = |_: usize, _: usize| ImpactSpeeds::Bodies { speed: apart.max(fall) };
    let counts = experiment.expected_numbers();
    contacts(&experiment.scene, &counts, pair, |_| ImpactSpeeds::Bodies { speed: fastest.max(fall) })
}

/// [m/s] upper limit of the relative speed of any two particles, followed by the largest speed of any particle.
/// Velocity components of particles from an inlet are taken to deviate from their means by at most three standard
/// deviations.
fn speeds(particles: &Particles, inlets: &[Inlet]) -> (f64, f64) {
    /// Largest number of particles for which the relative velocities of all pairs are computed.
    const ALL_PAIRS: usize = 2000;
    let velocities = &particles.velocity;
    let largest = |frame: Vector3<f64>| velocities.iter().map(|v| (v - frame).norm()).fold(0.0, f64::max);
    let apart = if velocities.len() <= ALL_PAIRS {
        velocities.iter().map(|one| largest(*one)).fold(0.0, f64::max)
    } else {
        2.0 * largest(velocities.iter().sum::<Vector3<f64>>() / velocities.len() as f64)
    };
    let spread = |inlet: &Inlet| 3.0 * inlet.velocity_fluctuation.norm();
    let (mut apart, mut fastest) = (apart, largest(Vector3::zeros()));
    for (k, inlet) in inlets.iter().enumerate() {
        let others =
            inlets[..=k].iter().map(|other| (inlet.velocity_mean - other.velocity_mean).norm() + spread(other));
        let others = others.chain((!velocities.is_empty()).then(|| largest(inlet.velocity_mean)));
        apart = others.map(|other| other + spread(inlet)).fold(apart, f64::max);
        fastest = fastest.max(inlet.velocity_mean.norm() + spread(inlet));
    }
    (apart, fastest)
}
