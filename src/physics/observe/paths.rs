//! Paths of all particles, for scenes with few particles that all stay.

use super::series::interval;
use super::{Needs, Observer, plain_data};
use crate::schedule::{MOST_FOLLOWED, Schedule};
use crate::simulation::Simulation;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Number of instants at which positions and velocities are recorded, for runs of any duration.
const INSTANTS: u64 = 1000;

/// State of one particle at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathSample {
    /// [s] simulated time of this state.
    pub time: f64,
    /// Id of the particle, which it keeps during the whole run.
    pub id: u32,
    /// [m] centre of the particle, inside the box along periodic axes.
    pub position: Vector3<f64>,
    /// [m/s] velocity of the particle.
    pub velocity: Vector3<f64>,
    /// [rad/s] spin of the particle; `None` if spheres do not rotate.
    pub spin: Option<Vector3<f64>>,
    /// [m] largest overlap of the particle with another body at this time; 0 without contact.
    pub overlap: f64,
}

/// Paths of all particles of a scene with up to 50 particles; empty for larger scenes, and with inlets or outlets. The
/// instants are equal in all variants of a case (models or settings that are compared).
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Paths {
    /// [s] time between two instants at which the particles are recorded.
    interval: f64,
    /// Recorded states of all particles, sorted by time, then by id.
    pub points: Vec<PathSample>,
}

impl Paths {
    /// Creates the observer before the start of a run. The instants of recording are chosen from those of `schedule`.
    pub fn new(schedule: &Schedule) -> Self {
        Self { interval: interval(schedule, INSTANTS, INSTANTS), points: Vec::new() }
    }
}

impl Paths {
    /// True if the recorded paths end before `time` [s].
    fn lacks(&self, time: f64) -> bool {
        self.points.last().is_some_and(|point| point.time < time)
    }
}

impl Observer for Paths {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        // without recorded points, the scene has too many particles, or inlets or outlets; the observer is not called
        // again
        (!self.points.is_empty()).then_some(now + self.interval)
    }

    fn see(&mut self, simulation: &Simulation) {
        let (particles, time) = (&simulation.particles, simulation.time);
        if particles.len() > MOST_FOLLOWED || simulation.scene().has_openings() {
            return;
        }
        let overlaps = simulation.overlaps();
        let first = self.points.len();
        self.points.extend((0..particles.len()).map(|place| PathSample {
            time,
            id: particles.id[place],
            position: simulation.scene().domain.wrap(&particles.position[place]),
            velocity: particles.velocity[place],
            spin: particles.spin.as_ref().map(|spins| spins[place]),
            overlap: overlaps[place],
        }));
        self.points[first..].sort_unstable_by_key(|point| point.id);
    }

    fn needs_at_end(&self, now: f64) -> Needs {
        if self.lacks(now) { self.needs() } else { Needs::Nothing }
    }

    fn end(&mut self, simulation: &Simulation) {
        if self.lacks(simulation.time) {
            self.see(simulation);
        }
    }

    plain_data!();
}
