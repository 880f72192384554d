//! One island (a group of particles that may meet) as a small scene, which an engine can solve separately. *Hot*
//! particles are its members; *bystanders* are particles that the members might hit. A window is the time between two
//! exchanges of momentum with the gas.

use super::cluster::VelocityChange;
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use crate::record::{Ledger, Log};
use nalgebra::Vector3;

/// Largest number of particles among which a linear search for one of them is faster than a binary search.
const FEW: usize = 32;

/// An island as a small separate scene for an engine. Local indices count the hot particles (members of islands) first,
/// then the bystanders (particles that members might hit).
pub struct Island<C> {
    /// Copies of the particles, in the frame at rest; positions are those of the particle store.
    pub particles: Particles,
    /// Index in the particle store of each particle.
    pub places: Vec<u32>,
    /// Number of hot particles, which are the members of the island.
    pub hot: usize,
    /// True if the island is a crowd, a large island that is moved by uniform steps.
    pub crowd: bool,
    /// Local indices of all particles, sorted by the index in the particle store; empty for a small island, which needs
    /// no sorted list.
    by_place: Vec<u32>,
    /// Pairs of particles, and particles with walls, that may touch.
    pub list: NeighbourList,
    /// State carried over from the previous part of a time window, such as contacts; it contains local indices of
    /// particles. The engine replaces it by the state to be carried to the next part.
    pub carried: Vec<C>,
    /// Log of the impacts in the island.
    pub log: Log,
    /// Velocity changes in the order of time, each with the local index of the particle; empty if the engine does not
    /// report them.
    pub turns: Vec<(u32, VelocityChange)>,
    /// Number of impulses (hard spheres) or contact steps (soft spheres).
    pub events: u64,
    /// Number of impulses of the hybrid engine, which counts its contact steps in `events`.
    pub impulses: u64,
    /// Number of uniform steps, if the island is a crowd.
    pub crowd_steps: u64,
    /// Number of contact forces computed in uniform steps.
    pub crowd_forces: u64,
    /// Number of gaps or times of touch computed.
    pub pair_checks: u64,
    /// Number of contact forces computed.
    pub force_evaluations: u64,
    /// Number of particles moved by stages of contact steps, plus the number of gaps checked after steps. It measures
    /// the work.
    pub updates: u64,
    /// Local indices of the particles that left their bounds, without the one that the solver returns.
    pub also: Vec<usize>,
    /// Largest speed [m/s] so far, relative to the frame of the speed limits. It is set by solvers that cannot stop
    /// when a limit is exceeded; otherwise it is 0.
    pub fastest: f64,
    /// Speed limit [m/s] of each hot particle (member of an island), relative to the moving frame `frame`.
    pub(super) limits: Vec<f64>,
    /// Velocity [m/s] of the moving frame of the speed limits, relative to the frame at rest.
    frame: Vector3<f64>,
    /// [m/s] mean flow of a sheared box where each particle was at the beginning of the part, which is added to the
    /// velocity of the frame; empty without shear.
    pub(super) flow: Vec<Vector3<f64>>,
}

/// Speed limits of the hot particles (members) of an island.
pub struct Bounds<'a> {
    /// Speed limit [m/s] of each hot particle (member of an island), relative to the moving frame.
    limits: &'a [f64],
    /// Velocity [m/s] of the moving frame of the speed limits, relative to the frame at rest.
    frame: Vector3<f64>,
    /// [m/s] mean flow that is added to the velocity of the frame, by particle; empty without shear.
    flow: &'a [Vector3<f64>],
}

impl Bounds<'_> {
    /// True if the particle at a local index may have the velocity [m/s], as in [`Island::allows`].
    pub fn allows(&self, place: usize, velocity: &Vector3<f64>) -> bool {
        let frame = frame_of(place, self.frame, self.flow);
        self.limits.get(place).is_some_and(|limit| (velocity - frame).norm() <= *limit)
    }
}

/// [m/s] velocity of the frame of the particle at a local index: the common `frame` and the mean `flow` of a sheared box.
#[inline]
fn frame_of(place: usize, frame: Vector3<f64>, flow: &[Vector3<f64>]) -> Vector3<f64> {
    match flow.get(place) {
        None => frame,
        Some(flow) => frame + flow,
    }
}

impl<C> Island<C> {
    /// Makes an island without particles.
    pub fn empty() -> Self {
        Self {
            particles: Particles::default(),
            places: Vec::new(),
            hot: 0,
            crowd: false,
            by_place: Vec::new(),
            list: NeighbourList::default(),
            carried: Vec::new(),
            log: Log::default(),
            turns: Vec::new(),
            events: 0,
            impulses: 0,
            crowd_steps: 0,
            crowd_forces: 0,
            pair_checks: 0,
            force_evaluations: 0,
            updates: 0,
            also: Vec::new(),
            fastest: 0.0,
            limits: Vec::new(),
            frame: Vector3::zeros(),
            flow: Vec::new(),
        }
    }

    /// Replaces the content of the island by copies of hot particles (members of islands), each with its speed limit
    /// [m/s], and of bystanders (particles that members might hit). Particles are given by index in the particle store.
    /// `fallen` [m/s] is the velocity that gravity has added to the velocities of the store since the time window
    /// began.
    pub(super) fn begin(
        &mut self,
        store: &Particles,
        hot: impl Iterator<Item = (u32, f64)>,
        bystanders: &[u32],
        frame: Vector3<f64>,
        fallen: Vector3<f64>,
    ) {
        self.places.clear();
        self.limits.clear();
        self.flow.clear();
        for (place, limit) in hot {
            self.places.push(place);
            self.limits.push(limit);
        }
        self.hot = self.places.len();
        self.places.extend_from_slice(bystanders);
        self.by_place.clear();
        if self.places.len() > FEW {
            self.by_place.extend(0..self.places.len() as u32);
            self.by_place.sort_unstable_by_key(|&local| self.places[local as usize]);
        }
        self.particles.clear();
        self.particles.copy_from(store, &self.places);
        for velocity in &mut self.particles.velocity {
            *velocity += fallen;
        }
        self.frame = frame + fallen;
        self.list.pairs.clear();
        self.list.walls.clear();
        self.carried.clear();
        self.log.impacts.clear();
        self.turns.clear();
        self.log.ledger = Ledger::default();
        (self.events, self.impulses) = (0, 0);
        (self.crowd_steps, self.crowd_forces) = (0, 0);
        (self.pair_checks, self.force_evaluations, self.updates) = (0, 0, 0);
        (self.also, self.fastest) = (Vec::new(), 0.0);
    }

    /// Local index of the particle with the index `place` in the particle store; `None` if the particle is not in the
    /// island.
    pub(super) fn local(&self, place: u32) -> Option<u32> {
        if self.by_place.is_empty() {
            return self.places.iter().position(|&other| other == place).map(|local| local as u32);
        }
        let found = self.by_place.binary_search_by_key(&place, |&local| self.places[local as usize]);
        found.ok().map(|k| self.by_place[k])
    }

    /// True if the velocity [m/s] of the particle at local index `place` does not exceed its speed limit. The velocity
    /// is relative to a frame that falls with gravity, and that is at rest at the start of the part. The result is
    /// false for a bystander (particle that members might hit), because a bystander must not be touched.
    pub fn allows(&self, place: usize, velocity: &Vector3<f64>) -> bool {
        Bounds { limits: &self.limits, frame: self.frame, flow: &self.flow }.allows(place, velocity)
    }

    /// Borrows three fields of the island at the same time: particles, log and speed limits.
    pub fn open(&mut self) -> (&mut Particles, &mut Log, Bounds<'_>) {
        (&mut self.particles, &mut self.log, Bounds { limits: &self.limits, frame: self.frame, flow: &self.flow })
    }

    /// Records a velocity change of the particle at local index `place`, at `time` [s] since the start of the part.
    /// `origin` [m] is the position on the line of the new flight, extended backwards to the start of the part.
    /// `velocity` [m/s] is the new velocity, relative to a frame that falls with gravity and is at rest at the start of
    /// the part.
    pub fn turn(&mut self, place: u32, time: f64, origin: Vector3<f64>, velocity: Vector3<f64>) {
        self.turns.push((place, VelocityChange { time, origin, velocity: velocity - self.frame_of(place as usize) }));
    }

    /// Speed [m/s] of the particle at local index `place`, relative to the moving frame of the speed limits.
    pub fn speed(&self, place: usize) -> f64 {
        (self.particles.velocity[place] - self.frame_of(place)).norm().max(self.fastest)
    }

    /// Velocity [m/s] of the frame of the speed limit of the particle at local index `place`.
    fn frame_of(&self, place: usize) -> Vector3<f64> {
        frame_of(place, self.frame, &self.flow)
    }

    /// Magnitude [m/s] of the difference between the velocity `frame` [m/s] and that of the frame of the speed limits.
    /// Speeds relative to the two frames differ by at most this magnitude.
    pub fn apart_from(&self, frame: &Vector3<f64>) -> f64 {
        (frame - self.frame).norm()
    }

    /// Smallest speed limit [m/s] of the hot particles (members of islands), relative to the moving frame.
    pub fn least_limit(&self) -> f64 {
        self.limits.iter().copied().fold(f64::INFINITY, f64::min)
    }
}
