//! How long are the windows, and when are samples taken?
//!
//! The choice depends on the scene alone, not on the model: both engines see the same drag splitting and are sampled at
//! the same times.

use crate::experiment::{Amount, Experiment, Population};
use crate::fluid::Profile;
use crate::predict::contact::AGITATION;
use crate::predict::flow::terminal_slip;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// [-] what splitting drag from motion may change in the mean velocity and in the agitation, relative to them. Standard
/// errors of long runs are ten times as large.
pub const SPLITTING: f64 = 1e-4;

/// [-] the same in how a single particle follows the gas, where no noise hides it.
pub const SPLITTING_ALONE: f64 = 1e-5;

/// Windows in a run without drag, one sample each.
const PIECES: f64 = 200.0;

/// Samples per response time of drag: well below the time in which velocities change.
const SAMPLES_PER_RESPONSE: f64 = 20.0;

/// Equal windows, grouped between samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// [s] window h.
    pub window: f64,
    /// Windows between two samples.
    pub windows_per_sample: u64,
    /// Samples after the one at the start.
    pub samples: u64,
}

impl Schedule {
    /// The schedule of an experiment: no window is longer than the one it gives or, without one, than the splitting of drag
    /// allows; all are equal and a whole number of them makes the duration.
    pub fn new(experiment: &Experiment) -> Self {
        let duration = experiment.run.duration;
        if duration <= 0.0 {
            return Self { window: 0.0, windows_per_sample: 0, samples: 0 };
        }
        let drag = experiment.start.iter().filter_map(|population| Drag::of(experiment, population));
        let drag: Vec<Drag> = drag.collect();
        let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
        let (allowed, often) = if drag.is_empty() {
            (duration / PIECES, duration / PIECES)
        } else {
            let response = least(&mut drag.iter().map(|drag| drag.response));
            (least(&mut drag.iter().map(Drag::longest_window)), response / SAMPLES_PER_RESPONSE)
        };
        let longest = experiment.run.window.unwrap_or(allowed).min(duration);
        let interval = experiment.statistics.sample_interval.unwrap_or(often).clamp(longest, duration);
        // rounding of the quotients must not add a window
        let samples = (duration / interval - 1e-9).ceil().max(1.0);
        let windows_per_sample = (duration / samples / longest - 1e-9).ceil().max(1.0);
        Self {
            window: duration / (samples * windows_per_sample),
            windows_per_sample: windows_per_sample as u64,
            samples: samples as u64,
        }
    }

    /// [s] time between two samples.
    pub fn interval(&self) -> f64 {
        self.windows_per_sample as f64 * self.window
    }

    /// Windows of the whole run.
    pub fn windows(&self) -> u64 {
        self.samples * self.windows_per_sample
    }

    /// Windows from the start until `time` [s] is reached.
    pub fn windows_to(&self, time: f64) -> u64 {
        /// [-] part of a window that counts as rounding: the product of 1e9 windows and their length is off by 1e-7 of one.
        const ROUNDING: f64 = 1e-6;
        (time / self.window - ROUNDING).ceil() as u64
    }
}

/// What the splitting error of drag depends on.
///
/// Kicks at the ends of a window stand for drag along it. Four things change meanwhile, and the error of each is of second
/// order in the window h (Strang 1968, SIAM J. Numer. Anal. 5, 506; the factors are those of the trapezoidal rule):
/// * the slip, by drag itself: (h/τ)²/24 of a velocity, with the response time τ of the start and the relaxation time τ_l of the
///   slip to come, whichever is shorter;
/// * the speed of a fall from rest, which gravity and drag make together: h² (1/τ_l - 1/τ_0)/(12 t) of what is reached after
///   the time t, with the relaxation times τ_l there and τ_0 at rest;
/// * the velocity, by collisions at a rate ν: their instants within the window are at random, which agitates by
///   ν τ (h/τ)²/24 of the agitation;
/// * the gas, on the way across its profile: σ² h² u'/(6 L_y) of the mean velocity, with u' the gradient at the walls.
///
/// For the fall the rate of change of the speed is g - D(w), and its error h² g ((D'² - D D'')/24 + g D''/12) at most, from the
/// double commutators of Strang's splitting. Where drag carries the weight, the speed is then off by less than (h D')²/24 of
/// itself; before, the last term rules, and its integral over the fall, D = 0 and w = g t, is the second error.
#[derive(Clone, Copy, Debug)]
struct Drag {
    /// [s] response time τ at the greater of the slip of the start and the slip that gravity brings.
    response: f64,
    /// [s] relaxation time τ_l at the slip that gravity brings.
    relaxation: f64,
    /// [s²] t/(1/τ_l - 1/τ_0) of the fall; infinite without one, or where drag is linear.
    fall: f64,
    /// [1/s] collisions a particle suffers per time, ν.
    rate: f64,
    /// [1/s²] σ² u'/(L_y U): agitation times gradient over the height and the velocity of the gas.
    crossing: f64,
}

impl Drag {
    fn of(experiment: &Experiment, population: &Population) -> Option<Self> {
        let scene = &experiment.scene;
        let fluid = scene.fluid.as_ref()?;
        let drag = fluid.drag.as_ref()?;
        let (law, species) = (drag.law(), &scene.species[population.species as usize]);
        let sphere = fluid.sphere(species);
        let height = scene.domain.size.y;
        let gas = fluid.profile.velocity(0.5 * height);
        let (velocity, fluctuation) = motion(population);
        // of the mean, or of a particle where those of a kind fly in all directions
        let slip = (velocity - Vector3::new(0.0, 0.0, gas)).norm().max(3.0_f64.sqrt() * fluctuation);
        let gravity = scene.gravity.norm();
        let falling = terminal_slip(drag, fluid, species, gravity).min(gravity * experiment.run.duration);
        let relaxation = law.relaxation_time(&sphere, falling);
        let steeper = 1.0 / relaxation - 1.0 / law.relaxation_time(&sphere, 0.0);
        let fall = if falling > 0.0 && steeper > 0.0 { falling / gravity / steeper } else { f64::INFINITY };
        let count: usize = experiment.count();
        let density = count as f64 / scene.domain.volume();
        // what a calm start is taken to become; falling bodies as much of their speed
        let kept_up = if count < 2 { 0.0 } else { AGITATION * gas.abs().max(falling) };
        let agitation = fluctuation.max(kept_up);
        // Chapman & Cowling 1970, 5.21: 4 n d² sqrt(π T), T the variance of a component
        let rate = 4.0 * density * species.diameter.powi(2) * PI.sqrt() * agitation;
        let gradient = wall_gradient(&fluid.profile, 0.5 * species.diameter, height);
        let crossing = agitation * agitation * gradient / (height * gas.abs());
        Some(Self { response: law.response_time(&sphere, slip.max(falling)), relaxation, fall, rate, crossing })
    }

    /// [s] the longest window with all four errors within bounds.
    fn longest_window(&self) -> f64 {
        let alone = (24.0 * SPLITTING_ALONE).sqrt() * self.response.min(self.relaxation);
        let fall = (12.0 * SPLITTING_ALONE * self.fall).sqrt();
        let agitation = (24.0 * SPLITTING / (1.0 + self.rate * self.response)).sqrt() * self.response;
        let crossing = (6.0 * SPLITTING / self.crossing).sqrt();
        // 0/0 of a gas at rest is no bound
        [fall, agitation, crossing].into_iter().fold(alone, f64::min)
    }
}

/// [m/s] mean velocity and rms fluctuation of a component.
fn motion(population: &Population) -> (Vector3<f64>, f64) {
    let Amount::Placed(placed) = &population.amount else {
        return (population.velocity_mean, population.mean_fluctuation());
    };
    let count = placed.len().max(1) as f64;
    let mean = placed.velocity.iter().sum::<Vector3<f64>>() / count;
    let square = placed.velocity.iter().map(|v| (v - mean).norm_squared()).sum::<f64>() / count;
    (mean, (square / 3.0).sqrt())
}

/// [1/s] how steep the gas profile is where a sphere of that radius [m] touches the lower or the upper side of the box.
fn wall_gradient(profile: &Profile, radius: f64, height: f64) -> f64 {
    let steep = |near: f64, far: f64| (profile.velocity(far) - profile.velocity(near)).abs() / radius;
    steep(radius, 2.0 * radius).max(steep(height - radius, height - 2.0 * radius))
}
