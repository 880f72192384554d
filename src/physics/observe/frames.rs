//! Records the particles at several instants, for animations.

use super::{Needs, Observer, plain_data};
use crate::experiment::Experiment;
use crate::particles::CHUNK;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::work_sharing;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Largest number of recorded particles. More particles could neither be distinguished in a picture nor be drawn fast
/// enough.
const MOST_PARTICLES: usize = 500;

/// Largest number of particles for which frames are always evenly spaced over the whole run. A viewer can follow so few
/// particles even if they fly far between two frames.
const FEW: usize = 50;

/// Smallest and largest number of frames (instants) that are recorded in a run.
const FRAMES: std::ops::RangeInclusive<usize> = 40..=241;

/// Largest product of recorded particles and frames, summed over all runs shown on a page. It limits the data of the
/// page to a few megabytes.
const BUDGET: usize = 90_000;

/// [-] desired mean distance that a particle flies between two frames, over its radius. The distance is that by
/// velocity fluctuations alone. It is short enough to show collisions.
const FLIGHT: f64 = 1.0;

/// [-] largest mean distance that a particle may fly between two frames if the frames cover the whole run, over the
/// desired distance `FLIGHT`. If it would fly further, the frames end before the run.
const WHOLE: f64 = 5.0;

/// State of the recorded particles at one instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// [s] simulated time of the frame.
    pub time: f64,
    /// [m] centres of the recorded particles, inside the box along periodic axes.
    pub position: Vec<Vector3<f32>>,
    /// [m/s] velocities of the recorded particles. With drag, a frame between two samples (instants of measurement) has
    /// the velocities with which the particles flew in the latest window. A window is the time between two exchanges of
    /// momentum with the gas.
    pub velocity: Vec<Vector3<f32>>,
    /// [m] largest overlap of each recorded particle; 0 for particles without contact.
    pub overlap: Vec<f32>,
    /// [rad/s] magnitude of the spin of each recorded particle; empty if spheres do not rotate.
    pub spin: Vec<f32>,
    /// Method that moved each particle in the latest window (time between two exchanges with the gas): 0 straight
    /// flight, 1 the solution of an island (a small group of particles that may meet), 2 the engine with all particles
    /// at once.
    pub solver: Vec<u8>,
}

/// Frames of up to 500 particles at up to 241 instants, from the start of the run. Frames spread over the whole run may
/// be too far apart in time to show collisions. In that case, the frames are closer in time and end before the run.
/// There are no frames of a scene with inlets or outlets.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Frames {
    /// [s] duration of the run.
    duration: f64,
    /// Largest number of recorded particles, and largest number of frames (instants at which they are recorded).
    most: (usize, usize),
    /// [s] time between the latest recorded frame and the next one.
    spacing: f64,
    /// Number of all particles of the scene, also of those that are not recorded.
    pub particles: usize,
    /// [m] radius of each recorded particle, in the order of ids.
    pub radius: Vec<f32>,
    /// Species of each recorded particle.
    pub species: Vec<u16>,
    /// Recorded states of the particles in the order of time.
    pub frames: Vec<Frame>,
}

impl Frames {
    /// Creates an observer of one run. `variants` is the number of runs that are shown together on a page, one for
    /// each variant of the case (each of its experiments).
    pub fn new(experiment: &Experiment, variants: usize) -> Self {
        let room = BUDGET / variants.max(1);
        let particles = MOST_PARTICLES.min(room / FRAMES.start()).min(experiment.count().max(1)).max(1);
        let frames = (room / particles).clamp(*FRAMES.start(), *FRAMES.end());
        Self { duration: experiment.run.duration, most: (particles, frames), ..Self::default() }
    }

    /// Makes a recording of particles of one species from their radii [m] and the frames.
    pub fn recorded(radius: Vec<f32>, frames: Vec<Frame>) -> Self {
        Self { particles: radius.len(), species: vec![0; radius.len()], radius, frames, ..Self::default() }
    }

    /// Difference n between the ids of two successive recorded particles: every n-th particle is recorded.
    fn every(&self) -> usize {
        self.particles.div_ceil(self.most.0.max(1)).max(1)
    }

    /// [s] time from this frame to the next one. Frames are evenly spaced over the whole run unless the particles would
    /// fly too far between two such frames.
    fn space(&self, simulation: &Simulation) -> f64 {
        let even = self.duration / self.most.1.saturating_sub(1).max(1) as f64;
        // the first two frames decide: frames that are spaced over the whole run keep their spacing
        let goes_on = self.frames.len() > 1 && self.spacing >= even;
        if simulation.count() <= FEW || goes_on {
            return even;
        }
        let near = FLIGHT * simulation.mean_radius() / simulation.fluctuation_speed();
        if even <= WHOLE * near { even } else { near.min(even) }
    }
}

impl Frames {
    /// True if a last frame at `time` [s], the end of the run, is missing and the number of frames allows it.
    fn lacks(&self, time: f64) -> bool {
        self.frames.len() < self.most.1 && self.frames.last().is_some_and(|frame| frame.time < time)
    }
}

impl Observer for Frames {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        (self.frames.len() < self.most.1).then_some(now + self.spacing)
    }

    // no drag is added to the velocities: between the previous frame and this one, particles flew with the velocities
    // of the latest window
    fn needs_velocities(&self) -> bool {
        false
    }

    fn needs(&self) -> Needs {
        Needs::Every(u32::try_from(self.every()).unwrap_or(1))
    }

    fn see(&mut self, simulation: &Simulation) {
        // with inlets or outlets nothing is recorded, because a page shows particles that stay during the whole run
        if simulation.scene().has_openings() {
            return;
        }
        let particles = &simulation.particles;
        self.particles = simulation.count();
        let every = u32::try_from(self.every()).unwrap_or(u32::MAX);
        let some = |(chunk, ids): (usize, &[u32])| {
            let followed = ids.iter().enumerate().filter(|(_, id)| id.is_multiple_of(every));
            followed.map(|(place, _)| (chunk * CHUNK + place) as u32).collect::<Vec<_>>()
        };
        let mut followed: Vec<u32> = work_sharing::map(particles.id.chunks(CHUNK).enumerate(), some).concat();
        followed.sort_unstable_by_key(|place| particles.id[*place as usize]);
        if self.frames.is_empty() {
            self.radius = followed.iter().map(|place| particles.radius[*place as usize] as f32).collect();
            self.species = followed.iter().map(|place| particles.species[*place as usize]).collect();
        }
        let overlaps = simulation.overlaps();
        let islands = simulation.in_islands();
        let mut solver = vec![if islands.is_some() { 0 } else { 2_u8 }; particles.len()];
        islands.into_iter().flatten().for_each(|place| solver[*place as usize] = 1);
        let domain = &simulation.scene().domain;
        let of = |place: &u32| *place as usize;
        self.frames.push(Frame {
            time: simulation.time,
            position: followed
                .iter()
                .map(|place| domain.wrap(&particles.position[of(place)]).map(|x| x as f32))
                .collect(),
            velocity: followed.iter().map(|place| particles.velocity[of(place)].map(|v| v as f32)).collect(),
            overlap: followed.iter().map(|place| overlaps[of(place)] as f32).collect(),
            spin: match &particles.spin {
                None => Vec::new(),
                Some(spins) => followed.iter().map(|place| spins[of(place)].norm() as f32).collect(),
            },
            solver: followed.iter().map(|place| solver[of(place)]).collect(),
        });
        self.spacing = self.space(simulation);
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
