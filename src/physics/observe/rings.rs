//! Averages over the particles in rings about the axis of a pipe with gas flow. A sample is an instant at which
//! measurements are taken.

use super::{Needs, Observer, plain_data};
use crate::experiment::Experiment;
use crate::fluid::{Pipe, Profile};
use crate::particles::Particles;
use crate::scene::Scene;
use crate::simulation::Simulation;
use crate::statistics::{Accumulator, ProfileTable};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Sums over the particles in rings of equal area about the axis of a pipe with gas flow. Without pipe flow nothing is
/// summed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Rings {
    profiles: Option<Accumulator>,
    count: usize,
}

/// Ring about the axis of a pipe, between two radii, with the gas velocity in it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ring {
    /// [m] inner radius of the ring.
    pub inner: f64,
    /// [m] outer radius of the ring.
    pub outer: f64,
    /// [m/s] mean velocity of the gas over the area of the ring.
    pub gas: f64,
}

/// Averages over the particles in rings about the axis of a pipe, from the axis to the wall.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RingAverages {
    /// Rings about the axis; none if the gas flow is not that of a pipe.
    pub rings: Vec<Ring>,
    /// Time averages in the order of the rings. The coordinate `y` of a ring is the radius [m] that divides its area
    /// into two equal parts. V is the mean velocity away from the axis, W that around the axis, and the moments use the
    /// same components. Densities are relative to the mean density in the pipe.
    #[serde(skip)]
    pub profiles: ProfileTable,
}

/// Pipe of the gas flow of a scene; `None` if the gas flow is not that of a pipe.
fn pipe(scene: &Scene) -> Option<&Pipe> {
    match &scene.fluid.as_ref()?.profile {
        Profile::Pipe(pipe) => Some(pipe),
        Profile::Uniform(_) | Profile::Tabulated(_) | Profile::Channel(_) | Profile::LogLaw(_) => None,
    }
}

impl Rings {
    /// Creates an observer for an experiment, before the start of its run. The case gives the number of rings as its
    /// number of slices.
    pub fn new(experiment: &Experiment) -> Self {
        let count = experiment.statistics.slices;
        // with the square of the radius as coordinate, rings of equal area are slices of equal height
        let profiles = pipe(&experiment.scene).map(|_| Accumulator::new(count, 1.0));
        Self { profiles, count }
    }

    /// Averages in rings about the axis of a pipe, from the time `from` [s] to the end of the run.
    pub fn averages(&self, scene: &Scene, from: f64) -> RingAverages {
        /// Number of circles about the axis in each ring on which the gas velocity is evaluated.
        const CIRCLES: usize = 16;
        let (Some(profiles), Some(pipe)) = (&self.profiles, pipe(scene)) else { return RingAverages::default() };
        let radius = |share: f64| pipe.radius() * (share / self.count as f64).sqrt();
        let [x, y] = pipe.center();
        let rings = (0..self.count).map(|ring| {
            let at = |circle: usize| radius(ring as f64 + (circle as f64 + 0.5) / CIRCLES as f64);
            let gas = (0..CIRCLES).map(|circle| pipe.velocity_at(x + at(circle), y)).sum::<f64>() / CIRCLES as f64;
            Ring { inner: radius(ring as f64), outer: radius(ring as f64 + 1.0), gas }
        });
        let mut table = profiles.table(from);
        for (ring, row) in table.slices.iter_mut().enumerate() {
            row.y = radius(ring as f64 + 0.5);
        }
        RingAverages { rings: rings.collect(), profiles: table }
    }
}

impl Observer for Rings {
    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        let (Some(profiles), Some(pipe)) = (&mut self.profiles, pipe(simulation.scene())) else { return };
        let [x, y] = pipe.center();
        let particles = &simulation.particles;
        let (mass, inertia) = (particles.mass.clone(), particles.inertia.clone());
        let spin = particles.spin.as_ref().map(|_| Vec::with_capacity(particles.len()));
        let mut turned = Particles { mass, spin, inertia, ..Particles::default() };
        for (index, place) in particles.position.iter().enumerate() {
            let (x, y) = (place.x - x, place.y - y);
            let r = x.hypot(y);
            // on the axis itself the outward direction is undefined
            let (cos, sin) = if r > 0.0 { (x / r, y / r) } else { (1.0, 0.0) };
            let cylindrical = |v: &Vector3<f64>| Vector3::new(v.y * cos - v.x * sin, v.x * cos + v.y * sin, v.z);
            turned.position.push(Vector3::new(0.0, (r / pipe.radius()).powi(2), 0.0));
            turned.velocity.push(cylindrical(&particles.velocity[index]));
            if let Some(spins) = &mut turned.spin {
                spins.push(cylindrical(&particles.spin_of(index)));
            }
        }
        profiles.sample(simulation.time, simulation.sample().with(&turned));
    }

    plain_data!();
}
