//! Particles at some instants, for pictures that move.

use super::{Needs, Observer, plain_data};
use crate::experiment::Experiment;
use crate::particles::CHUNK;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::work_sharing;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Particles that are followed; more cannot be told apart, nor drawn as fast as they move.
const MOST_PARTICLES: usize = 500;

/// Particles up to which each can be followed by eye, however far it goes between two frames.
const FEW: usize = 50;

/// Frames of a run.
const FRAMES: std::ops::RangeInclusive<usize> = 40..=241;

/// Particles times frames of all variants together: a few megabytes on a page.
const BUDGET: usize = 90_000;

/// [radii] that a particle flies between two frames, on average and relative to the others: its collisions can be seen.
const FLIGHT: f64 = 1.0;

/// [-] times as far may they fly where the whole run can be shown so.
const WHOLE: f64 = 5.0;

/// The particles that are followed, at one instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// [s] simulated time.
    pub time: f64,
    /// [m] centres, inside the box along periodic axes.
    pub position: Vec<Vector3<f32>>,
    /// [m/s] velocities; where drag acts and it is no sample, those of the window that ends here.
    pub velocity: Vec<Vector3<f32>>,
    /// [m] largest overlap of each; 0 of those that touch nothing.
    pub overlap: Vec<f32>,
    /// Who moved each: 0 nobody (it flew straight), 1 an island, 2 the engine, all at once.
    pub solver: Vec<u8>,
}

/// Up to 500 particles at up to 241 instants, from the start on. Where a run is too long for that, frames follow one another as closely as lets
/// collisions be seen, and end before the run does.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Frames {
    /// [s] length of the run.
    duration: f64,
    /// Particles to be followed, and frames to be kept.
    most: (usize, usize),
    /// [s] to the next frame.
    spacing: f64,
    /// Particles of the scene.
    pub particles: usize,
    /// [m] radius of each that is followed, in the order of ids.
    pub radius: Vec<f32>,
    /// Species of each that is followed.
    pub species: Vec<u16>,
    /// In the order of time.
    pub frames: Vec<Frame>,
}

impl Frames {
    /// For one of `variants` that are shown together.
    pub fn new(experiment: &Experiment, variants: usize) -> Self {
        let room = BUDGET / variants.max(1);
        let particles = MOST_PARTICLES.min(room / FRAMES.start()).min(experiment.count().max(1)).max(1);
        let frames = (room / particles).clamp(*FRAMES.start(), *FRAMES.end());
        Self { duration: experiment.run.duration, most: (particles, frames), ..Self::default() }
    }

    /// Frames of particles of these radii [m], of one species, that come from elsewhere.
    pub fn recorded(radius: Vec<f32>, frames: Vec<Frame>) -> Self {
        Self { particles: radius.len(), species: vec![0; radius.len()], radius, frames, ..Self::default() }
    }

    /// Every so manieth particle is followed.
    fn every(&self) -> usize {
        self.particles.div_ceil(self.most.0.max(1)).max(1)
    }

    /// [s] to the next frame: even over the run if the particles stay near enough meanwhile.
    fn space(&self, simulation: &Simulation) -> f64 {
        let even = self.duration / self.most.1.saturating_sub(1).max(1) as f64;
        // decided at the start: who sees the whole run goes on to see it
        let goes_on = self.frames.len() > 1 && self.spacing >= even;
        if simulation.count() <= FEW || goes_on {
            return even;
        }
        let near = FLIGHT * simulation.mean_radius() / simulation.agitation();
        if even <= WHOLE * near { even } else { near.min(even) }
    }
}

impl Frames {
    /// Whether there is room for the last state of a run that has been shown as a whole, or has stopped meanwhile, at a time [s].
    fn lacks(&self, time: f64) -> bool {
        self.frames.len() < self.most.1 && self.frames.last().is_some_and(|frame| frame.time < time)
    }
}

impl Observer for Frames {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        (self.frames.len() < self.most.1).then_some(now + self.spacing)
    }

    // with the velocities that they had in the last window, particles flew from the last frame to this
    fn needs_velocities(&self) -> bool {
        false
    }

    fn sight(&self) -> Needs {
        Needs::Every(u32::try_from(self.every()).unwrap_or(1))
    }

    fn see(&mut self, simulation: &Simulation) {
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
            solver: followed.iter().map(|place| solver[of(place)]).collect(),
        });
        self.spacing = self.space(simulation);
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
