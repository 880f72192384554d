//! The path of every particle, where there are few.

use super::series::interval;
use super::{Needs, Observer, plain_data};
use crate::schedule::{MOST_FOLLOWED, Schedule};
use crate::simulation::Simulation;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Instants at which they are noted, whatever the length of the run.
const INSTANTS: u64 = 1000;

/// A particle at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathSample {
    /// [s] simulated time.
    pub time: f64,
    /// Identity.
    pub id: u32,
    /// [m] centre, inside the box along periodic axes.
    pub position: Vector3<f64>,
    /// [m/s] velocity.
    pub velocity: Vector3<f64>,
    /// [m] its largest overlap now; 0 if it touches nothing.
    pub overlap: f64,
}

/// Paths of all particles of a scene of up to 50, at the same times in every variant of it; empty for others.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Paths {
    /// [s] between instants.
    interval: f64,
    /// By time, then by id.
    pub points: Vec<PathSample>,
}

impl Paths {
    /// For a run with that schedule.
    pub fn new(schedule: &Schedule) -> Self {
        Self { interval: interval(schedule, INSTANTS, INSTANTS), points: Vec::new() }
    }
}

impl Paths {
    /// Whether paths end before a time [s].
    fn lacks(&self, time: f64) -> bool {
        self.points.last().is_some_and(|point| point.time < time)
    }
}

impl Observer for Paths {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        // without points there were too many particles
        (!self.points.is_empty()).then_some(now + self.interval)
    }

    fn see(&mut self, simulation: &Simulation) {
        let (particles, time) = (&simulation.particles, simulation.time);
        if particles.len() > MOST_FOLLOWED {
            return;
        }
        let overlaps = simulation.overlaps();
        let first = self.points.len();
        self.points.extend((0..particles.len()).map(|place| PathSample {
            time,
            id: particles.id[place],
            position: simulation.scene().domain.wrap(&particles.position[place]),
            velocity: particles.velocity[place],
            overlap: overlaps[place],
        }));
        self.points[first..].sort_unstable_by_key(|point| point.id);
    }

    fn sight_of_end(&self, now: f64) -> Needs {
        if self.lacks(now) { self.sight() } else { Needs::Nothing }
    }

    fn end(&mut self, simulation: &Simulation) {
        if self.lacks(simulation.time) {
            self.see(simulation);
        }
    }

    plain_data!();
}
