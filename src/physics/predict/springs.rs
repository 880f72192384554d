//! Frequencies and damping of the tangential, rolling and twisting springs in contacts of rotating spheres.

use super::contact::{ContactKind, StepLimit, fastest_impact};
use crate::contact_law::{Bodies, ContactLaw, Spring};
use crate::experiment::Experiment;
use crate::rotation::{RollingBodies, SpringDashpotSlider};
use crate::scene::Species;
use std::f64::consts::PI;

/// Tangential, rolling or twisting spring between two bodies, at the largest overlap of the fastest impacts.
#[derive(Clone, Copy, Debug)]
pub struct SideSpring {
    /// Name of the spring in a sentence, such as "tangential".
    pub name: &'static str,
    /// [1/s] undamped angular frequency of the spring.
    pub frequency: f64,
    /// [-] damping ratio of the spring: damping over critical damping.
    pub damping_ratio: f64,
}

impl SideSpring {
    /// [s] half the period of the damped spring; during this time the spring is stretched and returns. For an
    /// overdamped spring, half the period without damping is returned.
    pub fn half_period(&self) -> f64 {
        let swing = (1.0 - self.damping_ratio * self.damping_ratio).max(0.0).sqrt();
        PI / (self.frequency * if swing > 0.0 { swing } else { 1.0 })
    }
}

/// Tangential, rolling and twisting springs of a contact between two bodies, each at the largest overlap of the fastest
/// impacts. Springs without stiffness are left out. The list is empty if spheres do not rotate.
pub fn side_springs(experiment: &Experiment, law: &ContactLaw, bodies: &Bodies) -> Vec<SideSpring> {
    let scene = &experiment.scene;
    let inertia = scene.species.iter().map(Species::factor_with_added_mass).reduce(f64::min);
    let (Some(rotation), Some(inertia)) = (&scene.rotation, inertia) else { return Vec::new() };
    let Bodies { effective_mass, effective_radius, .. } = *bodies;
    let spring = law.between(bodies);
    let normal = law.normal_spring(bodies, &spring);
    let elastic = Spring { restitution: 1.0, dashpot: 0.0, ..spring };
    let deepest = law.greatest_overlap(&elastic, fastest_impact(experiment));
    let tangential = rotation.tangential.between(|| normal, effective_mass * inertia / (1.0 + inertia));
    // a torque turns two equal spheres, or one at a wall, like a single sphere of the effective mass and radius
    let moment = inertia * effective_mass * effective_radius * effective_radius;
    let rolls = RollingBodies::of(std::iter::once((effective_mass, effective_radius, moment)));
    let rolling = rotation.rolling.map(|rolling| rolling.between(&normal, &rolls).spring);
    let twisting = rotation.twisting.map(|twisting| twisting.between(&tangential, 1.0, deepest, &rolls).spring);
    let named = [("tangential", Some(tangential)), ("rolling", rolling), ("twisting", twisting)];
    let springs = named.into_iter().filter_map(|(name, spring)| Some((name, spring?)));
    let of = |(name, spring): (&'static str, SpringDashpotSlider)| {
        let at = spring.at(deepest);
        let frequency = (at.stiffness / at.mass).sqrt();
        SideSpring { name, frequency, damping_ratio: 0.5 * at.dashpot / (at.mass * frequency) }
    };
    springs.filter(|(_, spring)| spring.stiffness > 0.0).map(of).collect()
}

/// Limits on the time step due to tangential, rolling and twisting springs. At the longest allowed step, half a period
/// of the spring contains `steps` time steps. `steps` is the number of steps per contact N_c of the case.
pub fn spring_limits(
    experiment: &Experiment,
    law: &ContactLaw,
    contacts: &[ContactKind],
    steps: f64,
) -> Vec<StepLimit> {
    let of = |contact: &ContactKind| {
        let limit = |spring: SideSpring| StepLimit {
            name: format!("{} spring, half its period/N_c: {}", spring.name, contact.name),
            longest: spring.half_period() / steps,
        };
        side_springs(experiment, law, &contact.bodies).into_iter().map(limit).collect::<Vec<_>>()
    };
    contacts.iter().flat_map(of).collect()
}

/// Tangential, rolling or twisting spring with the shortest half period, and the contact to which it belongs. `None`
/// without such springs.
pub fn fastest_spring<'a>(
    experiment: &Experiment,
    law: &ContactLaw,
    contacts: &'a [ContactKind],
) -> Option<(SideSpring, &'a ContactKind)> {
    let of = |contact: &'a ContactKind| {
        side_springs(experiment, law, &contact.bodies).into_iter().map(move |spring| (spring, contact))
    };
    contacts.iter().flat_map(of).min_by(|a, b| a.0.half_period().total_cmp(&b.0.half_period()))
}
