//! Upper limit of the speed of particles that drag slows down. As this limit decreases during a run, windows (times
//! between two exchanges with the gas) may become longer.

use super::{DragScales, motion};
use crate::drag::Drag;
use crate::experiment::{Experiment, Population};
use crate::fluid::Profile;
use crate::predict::flow::terminal_slip;
use crate::scene::Scene;
use crate::walls::Wall;

/// Upper limit of the speed of particles of one species in still gas, computed from drag and gravity alone. The limit
/// decides when windows (times between two exchanges with the gas) may become longer.
///
/// Drag decreases the root mean square speed R at least as fast as the speed of one sphere that starts with the speed
/// R. The reason is as follows. The power of drag at the speed w is m w²/τ(w), with the mass m and the response time τ.
/// It is a convex function of w² if 1/τ is a sum of growing powers of w. The laws of Stokes and of Schiller and Naumann
/// have this form, except for a small jump at a Reynolds number of 1000. So the mean of this power is at least its
/// value at R (Jensen's inequality). Collisions of spheres that do not rotate and walls at rest add no energy
/// ([`is_fed`]). Gravity g adds at most the speed of a fall from rest. Let S be the sum of two speeds: that of this
/// fall, and one that begins at the initial R and decreases by drag alone. Drag grows at least in proportion to w, so
/// dS/dt >= g - S/τ(S), while dR/dt <= g - R/τ(R). Therefore S is an upper limit of R.
pub(super) struct Slowing<'a> {
    experiment: &'a Experiment,
    /// [m/s] root mean square speed R of the particles at the start; if there are several populations, the largest R.
    speed: f64,
}

impl<'a> Slowing<'a> {
    /// Makes the upper limit of the speeds for an experiment. `None` if there is no such limit, because drag is
    /// absent, the gas moves, the calling program defines the drag law, or the scene [adds energy](is_fed). Also
    /// `None` if several species, several sizes or a start without speed make the limit useless.
    pub(super) fn of(experiment: &'a Experiment) -> Option<Self> {
        if is_fed(&experiment.scene) {
            return None;
        }
        let fluid =
            experiment.scene.fluid.as_ref().filter(|fluid| fluid.drag.is_some() && fluid.turbulence.is_none())?;
        // the power of a law of the calling program may not be convex
        let is_known = !matches!(fluid.drag, Some(Drag::Other(_)));
        let still = matches!(fluid.profile, Profile::Uniform(0.0)) && is_known;
        let of_one_kind =
            !experiment.scene.has_sizes() && experiment.start.windows(2).all(|two| two[0].species == two[1].species);
        let speeds = experiment.start.iter().map(|population| {
            let (velocity, fluctuation) = motion(population);
            (velocity.norm_squared() + 3.0 * fluctuation * fluctuation).sqrt()
        });
        let speed = speeds.fold(0.0, f64::max);
        (still && of_one_kind && speed > 0.0).then_some(Self { experiment, speed })
    }

    /// [s] longest window (time between two exchanges with the gas) allowed at the time `time` [s] of the run. It grows
    /// with time, because the upper limit of the speeds decreases.
    pub(super) fn longest_window(&self, time: f64) -> f64 {
        let Self { experiment, speed } = self;
        let scene = &experiment.scene;
        let longest = |population: &Population| {
            let fluid = scene.fluid.as_ref()?;
            let (drag, species) = (fluid.drag.as_ref()?, &scene.species[usize::from(population.species)]);
            let gravity = scene.gravity_of(species).norm();
            // the drag of a sphere alone is the weakest that a law for suspensions has anywhere in the box
            let sphere = fluid.sphere(species);
            let fall = terminal_slip(drag, &sphere, gravity).min(gravity * experiment.run.duration);
            let fastest = speed * drag.law().decay(&sphere, *speed, time) + fall;
            Some(DragScales::at(experiment, species, [fastest, fastest / 3.0_f64.sqrt()])?.longest_window())
        };
        experiment.start.iter().filter_map(longest).fold(f64::INFINITY, f64::min)
    }
}

/// True if particles may gain kinetic energy of translation, besides that from gravity and from the gas: from a wall
/// that moves or is thermal, from a thermostat, from the shear of the box, from spins, or by particles that come in.
fn is_fed(scene: &Scene) -> bool {
    let feeds = |wall: &Wall| wall.surface_moves() || wall.thermal.is_some();
    let by_all = scene.thermostat.is_some() || scene.domain.shear.is_some() || scene.rotation.is_some();
    by_all || !scene.inlets.is_empty() || scene.walls.iter().any(feeds)
}
