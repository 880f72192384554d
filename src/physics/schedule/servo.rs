//! Lengths of windows in scenes with servo walls. Servo walls move to keep the pressure on them, and the speed of such
//! a wall changes at the ends of windows. A window is the time between two exchanges with the gas.

use crate::experiment::Experiment;
use crate::predict::contact::ContactTimes;
use crate::scene::Species;
use std::f64::consts::PI;

/// [-] smallest number of windows during a contact of soft spheres with a servo wall, a wall that moves to keep the
/// pressure on it.
const WINDOWS_PER_CONTACT: f64 = 10.0;

/// [-] largest share of the difference between the target pressure and the measured pressure that a servo wall corrects
/// within one window. From a share of 2 on, the corrections would grow without limit.
const LARGEST_CORRECTION: f64 = 1.0 / 3.0;

/// [Pa s/m] acoustic impedance sqrt(K m)/d² of the smallest particles, with their mass m and diameter d. K is the
/// stiffness that gives the contact time t_c at a wall: K = m (π/t_c)². A servo wall with this damping reflects the
/// smallest part of a wave that travels along a row of particles. Infinite if no contact is possible.
pub fn impedance(experiment: &Experiment) -> f64 {
    let over_square = |species: &Species| {
        let diameter = species.smallest();
        species.of_one_size(diameter).mass() / diameter.powi(2)
    };
    let least = experiment.scene.species.iter().map(over_square).fold(f64::INFINITY, f64::min);
    contact_time(experiment).map_or(f64::INFINITY, |time| PI * least / time)
}

/// [s] shortest contact time of a particle at any wall; `None` without soft contacts.
fn contact_time(experiment: &Experiment) -> Option<f64> {
    ContactTimes::of(experiment, &experiment.law()?, experiment.most_that_touch(experiment.count())).wall
}

/// [s] longest window with servo walls, which move to keep the pressure on them; infinite without such walls. The
/// window is so short that a contact lasts at least ten windows. In a window of length h, the wall corrects the share h
/// K/(c d²) of the difference between the target pressure and the measured one. Here the particles that cover the wall
/// have the stiffness K and the diameter d, and c is the damping of the wall. The share is at most a third.
pub fn longest_for_servo(experiment: &Experiment) -> f64 {
    let impedance = impedance(experiment);
    let Some(time) = contact_time(experiment) else { return f64::INFINITY };
    let servos = experiment.scene.walls.iter().filter_map(|wall| wall.servo());
    let longest = servos.map(|servo| {
        let damping = servo.damping.unwrap_or(impedance);
        (time / WINDOWS_PER_CONTACT).min(LARGEST_CORRECTION * damping / impedance * time / PI)
    });
    longest.fold(f64::INFINITY, f64::min)
}
