//! Scenes that have no steady state, and quantities that can be predicted for them. In such scenes averages over time
//! have no meaning.

use super::gas::Gas;
use super::pull::is_pulled;
use super::rest::Rest;
use crate::experiment::{Amount, Experiment};
use crate::fluid::Profile;
use crate::walls::Wall;
use nalgebra::Vector3;
use serde::Serialize;

/// [-] fractions of the initial energy of agitation (random motion). For each fraction, the time at which it is lost
/// is predicted.
const SHARES: [f64; 3] = [0.5, 0.9, 0.99];

/// Predictions for a scene in which nothing keeps the particles moving. In such a scene a time average has no meaning,
/// because the quantities keep changing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Transient {
    /// Description of the course of the motion, in one sentence.
    pub course: String,
    /// Times at which certain fractions of the energy of agitation are lost; empty if they are not known.
    pub losses: Vec<Loss>,
    /// [s] upper limit of the time until all particles lie on the floor; `None` without a floor, or without energy
    /// losses on it.
    pub at_rest: Option<f64>,
    /// [-] relative standard deviation of the granular temperature at one instant, between runs with different random
    /// initial states.
    pub scatter: f64,
    /// Number of runs with different seeds whose mean has the desired error at every instant.
    pub replicas: u64,
}

/// Fraction of the energy of agitation, and the time at which it is lost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Loss {
    /// [-] fraction of the initial kinetic energy of agitation that is lost.
    pub share: f64,
    /// [s] time from the start until the fraction `share` is lost.
    pub time: f64,
}

/// Decay of the agitation of the particles: dT/dt = -2 a T - 2 b sqrt(T/T_0) T, with the rates a (field `drag`) and b
/// (field `impacts`), and the granular temperature T_0 at the start.
///
/// An impact of a pair removes (1-e²)/4 m u_n², with the restitution e and the normal speed u_n, where the mean of
/// u_n² over impacts is 4 T (weighted by flux). So N (3/2) m dT/dt = -(1-e²) m T Ṅ for N particles, with Ṅ the number
/// of impacts per time. An impact on a wall removes (1-e²)/2 m u_n², where the mean of u_n² is 2 T, so the loss per
/// impact is the same. Impact rates are proportional to sqrt(T): Haff 1983, J. Fluid Mech. 134, 401. Drag with the
/// response time τ removes the fraction 2/τ of T per time. Friction, which makes the decay faster, is neglected.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Decay {
    /// [1/s] relative rate 1/τ at which drag reduces the root of the granular temperature T, with the response time τ.
    drag: f64,
    /// [1/s] relative rate, at the start, at which impacts reduce the root of the granular temperature T.
    impacts: f64,
}

impl Decay {
    /// [s] time until the fraction `share` [-] of the energy of agitation is lost. With y = sqrt(T/T_0) the equation is
    /// y' = -a y - b y², where a is `drag` and b is `impacts`.
    fn time(&self, share: f64) -> f64 {
        let (a, b, left) = (self.drag, self.impacts, (1.0 - share).sqrt());
        if a == 0.0 {
            return (1.0 / left - 1.0) / b;
        }
        ((a + b * left) / (left * (a + b))).ln() / a
    }
}

/// True if the particles lose energy and nothing keeps them moving, so that averages over time have no meaning. This is
/// a first estimate, for which no collision rates are needed.
pub fn fades(experiment: &Experiment) -> bool {
    let scene = &experiment.scene;
    let drag = scene.fluid.as_ref().and_then(|fluid| fluid.drag.as_ref());
    let sheared = scene.fluid.as_ref().is_some_and(|fluid| !matches!(fluid.profile, Profile::Uniform(_)));
    let surfaces = scene.surfaces(experiment.most_that_touch(experiment.count()));
    let lossy = surfaces.iter().any(|surface| surface.restitution < 1.0 || surface.friction > 0.0);
    let driven = is_stirred(experiment) || drag.is_some() && sheared;
    !driven && (drag.is_some() || lossy)
}

/// True if something gives energy to the particles: walls whose shape or surface moves, the shear of the box, eddies of
/// the gas, a thermostat or thermal walls. Gravity that pulls the particles along walls counts too, and so do particles
/// that come in until the end of the run.
fn is_stirred(experiment: &Experiment) -> bool {
    let scene = &experiment.scene;
    let turbulent = scene.fluid.as_ref().is_some_and(|fluid| fluid.drag.is_some() && fluid.turbulence.is_some());
    let slides = |wall: &Wall| wall.turning.is_some() || wall.velocity != Vector3::zeros();
    turbulent
        || scene.changes()
        || scene.is_heated()
        || is_pulled(scene)
        || scene.inlets.iter().any(|inlet| inlet.end >= experiment.run.duration)
        || scene.walls.iter().any(|wall| slides(wall) && wall.surface.friction > 0.0)
}

/// Weighted mean of numbers, given as pairs [weight, number]; 0 if the list is empty.
fn mean(numbers: impl Iterator<Item = [f64; 2]>) -> f64 {
    let [weights, sum] =
        numbers.fold([0.0; 2], |[weights, sum], [weight, number]| [weights + weight, sum + weight * number]);
    if weights > 0.0 { sum / weights } else { 0.0 }
}

/// Makes predictions for a scene without a steady state. `None` if something keeps the particles moving, or if no
/// energy is lost. Without a floor, a fall of several species or sizes through a gas also keeps them moving. `at_start`
/// is the granular temperature T [m²/s²] at the start, and `of_the_rates` the T to which the collision rates in `gas`
/// belong. `target` [-] is the desired relative error.
pub fn transient(
    experiment: &Experiment,
    gas: &Gas,
    rest: Option<&Rest>,
    [at_start, of_the_rates]: [f64; 2],
    target: f64,
) -> Option<Transient> {
    let scene = &experiment.scene;
    let kinds = experiment.start.iter().filter(|population| population.amount.count() > 0).count();
    let falls = scene.gravity.norm() > 0.0;
    let drag = scene.fluid.as_ref().and_then(|fluid| fluid.drag.as_ref());
    // a gas with a velocity gradient keeps the particles moving, and so does a fall through a gas, if species or sizes
    // fall at different speeds
    let driven = is_stirred(experiment)
        || drag.is_some()
            && (!scene.fluid.as_ref().is_some_and(|fluid| matches!(fluid.profile, Profile::Uniform(_)))
                || falls && (kinds > 1 || scene.has_sizes()) && rest.is_none());
    let count = experiment.count() as f64;
    let loss = |e: f64| 1.0 - e * e;
    let counts = experiment.counts();
    let of_pairs = scene.meetings().map(|(one, other, meeting)| {
        let [one, other] = [one, other].map(usize::from);
        let reach = scene.species[one].diameter + scene.species[other].diameter;
        let twice = if one == other { 1.0 } else { 2.0 };
        [twice * counts[one] as f64 * counts[other] as f64 * reach * reach, loss(meeting.surface.restitution)]
    });
    let at_walls = scene.meetings_at_walls().map(|(one, _, meeting)| {
        let diameter = scene.species[usize::from(one)].diameter;
        [counts[usize::from(one)] as f64 * diameter * diameter, loss(meeting.surface.restitution)]
    });
    let rates = (mean(of_pairs) * gas.pair_rate + mean(at_walls) * gas.wall_rate) / count;
    let decay = Decay {
        drag: if drag.is_some() { response(experiment).map_or(0.0, |time| 1.0 / time) } else { 0.0 },
        // dT/dt = -(2/3) (1-e²) (rate/N) T, and the relative rate of y = sqrt(T/T_0) is half of the relative rate of T
        impacts: rates / 3.0 * (at_start / of_the_rates).sqrt(),
    };
    let lost = decay.drag > 0.0 || decay.impacts > 0.0;
    if driven || !lost {
        return None;
    }
    let at_rest = rest.map(|rest| rest.time).filter(|time| time.is_finite());
    let course = if let Some(rest) = rest.filter(|_| falls) {
        match rest.rises {
            true => "The particles rise, bounce and come to rest at the upper wall.",
            false => "The particles fall, bounce and come to rest on the floor.",
        }
    } else if drag.is_some() {
        "Drag and impacts take the agitation, and nothing brings it back."
    } else {
        "Impacts take the agitation, and nothing brings it back: a cooling gas."
    };
    // T is a sum of 3 N squares, so for Gaussian velocities its relative variance is 2/(3N); it is less if the run
    // starts with exactly the requested T
    let scatter = (2.0 / (3.0 * count)).sqrt();
    let losses = if falls && rest.is_some() {
        // no times are given, since falling particles gain energy
        Vec::new()
    } else {
        SHARES.map(|share| Loss { share, time: decay.time(share) }).into()
    };
    Some(Transient {
        course: course.to_owned(),
        losses,
        at_rest,
        scatter,
        replicas: (scatter / target).powi(2).ceil().max(1.0) as u64,
    })
}

/// [s] shortest response time of drag over all species, at the slip speed (relative to the gas) that corresponds to
/// the velocity fluctuations at the start. `None` without drag.
fn response(experiment: &Experiment) -> Option<f64> {
    let fluid = experiment.scene.fluid.as_ref()?;
    let law = fluid.drag.as_ref()?.law();
    let fraction = experiment.fraction_for_drag();
    let of = experiment.start.iter().map(|population| {
        let sphere = fluid.sphere(&experiment.scene.species[usize::from(population.species)]).among(fraction);
        law.response_time(&sphere, population.mean_fluctuation() * 3.0_f64.sqrt())
    });
    of.reduce(f64::min)
}

/// [m²/s²] variance of a velocity component at the start, averaged over all particles. Particles with listed velocities
/// count as 0.
pub fn variance_at_start(experiment: &Experiment) -> f64 {
    let random = |population: &&crate::experiment::Population| matches!(population.amount, Amount::Count(_));
    let of = experiment.start.iter().filter(random);
    let sum: f64 = of.map(|one| one.amount.count() as f64 * one.mean_fluctuation().powi(2)).sum();
    sum / experiment.count().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares the closed form of the decay with a numerical integration of its equation.
    #[test]
    fn the_closed_form_solves_its_equation() {
        for decay in
            [Decay { drag: 0.0, impacts: 3.0 }, Decay { drag: 2.0, impacts: 0.0 }, Decay { drag: 0.7, impacts: 5.0 }]
        {
            for share in SHARES {
                let (end, steps) = (decay.time(share), 100_000);
                let slope = |y: f64| -decay.drag * y - decay.impacts * y * y;
                let dt = end / f64::from(steps);
                let y = (0..steps).fold(1.0, |y, _| y + dt * slope(y + 0.5 * dt * slope(y)));
                // the step is that of the midpoint rule, with an error of second order in 1e-5
                assert!((1.0 - y * y - share).abs() < 1e-6, "{decay:?}: {share} lost, {}", 1.0 - y * y);
            }
        }
    }
}
