//! Lengths of windows on an orbit, whose forces act in kicks between two windows. A window is the time between two
//! exchanges with the gas.

use super::SPLITTING;
use crate::experiment::Experiment;

/// [s] longest window in a box on an orbit; infinite without an orbit. In a window (time between two exchanges with the
/// gas) of length h, a kick turns velocities by the angle ω h. The rate ω is 2 Ω with the angular velocity Ω of the
/// orbit, or the angular frequency of vertical oscillations, whichever is larger. Splitting these turns from the motion
/// changes the frequencies of free motion by at most the share (ω h)²/24. The window is so short that this share is at
/// most [`SPLITTING`].
pub fn longest(experiment: &Experiment) -> f64 {
    let orbit = experiment.scene.domain.orbit();
    orbit.map_or(f64::INFINITY, |orbit| (24.0 * SPLITTING).sqrt() / orbit.fastest())
}
