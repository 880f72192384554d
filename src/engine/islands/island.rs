//! One island as an engine gets it.

use super::cluster::VelocityChange;
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use crate::record::{Ledger, Log};
use nalgebra::Vector3;

/// Particles up to which one of them is found fastest by looking at all.
const FEW: usize = 32;

/// A small scene of its own, handed to an engine. Places are local: the hot particles first, then the bystanders.
pub struct Island<C> {
    /// Copies of the particles, in the frame at rest, positions as in the store.
    pub particles: Particles,
    /// Place in the store of each.
    pub places: Vec<u32>,
    /// How many are hot.
    pub hot: usize,
    /// Whether it is a crowd, for uniform steps.
    pub crowd: bool,
    /// Local places in the order of the places in the store, of an island that is large enough for it.
    by_place: Vec<u32>,
    /// Pairs and walls that may touch.
    pub list: NeighbourList,
    /// What the engine carries from the window before; what it leaves here is carried to the next. By local place.
    pub carried: Vec<C>,
    /// What happened.
    pub log: Log,
    /// Where flights turn, of an engine that says so: local place of the particle and what comes then, in the order of time.
    pub turns: Vec<(u32, VelocityChange)>,
    /// Impulses or contact steps.
    pub events: u64,
    /// Impulses of an engine that also has contacts.
    pub impulses: u64,
    /// Steps of all of a crowd.
    pub crowd_steps: u64,
    /// Contact forces computed in those.
    pub crowd_forces: u64,
    /// Gaps or touch times computed.
    pub pair_checks: u64,
    /// Contact forces computed.
    pub force_evaluations: u64,
    /// Particles moved by stages of steps, and gaps looked at after steps.
    pub updates: u64,
    /// Further particles that got out of bounds, besides the one that the solver names; by local place.
    pub also: Vec<usize>,
    /// [m/s] the largest speed on the way, relative to the frame of the search, of a solver that cannot stop at it; 0 of others.
    pub fastest: f64,
    /// [m/s] speed limit of each hot particle, relative to `frame`.
    pub(super) limits: Vec<f64>,
    /// [m/s] velocity of the moving frame, seen from the frame at rest.
    frame: Vector3<f64>,
}

/// How fast the hot particles of an island may be.
pub struct Bounds<'a> {
    /// [m/s] of each, relative to the frame.
    limits: &'a [f64],
    /// [m/s] velocity of the moving frame, seen from the frame at rest.
    frame: Vector3<f64>,
}

impl Bounds<'_> {
    /// As [`Island::allows`].
    pub fn allows(&self, place: usize, velocity: &Vector3<f64>) -> bool {
        self.limits.get(place).is_some_and(|limit| (velocity - self.frame).norm() <= *limit)
    }
}

impl<C> Island<C> {
    /// An island without particles.
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
        }
    }

    /// Begins anew with copies of the hot particles, each with its speed limit [m/s], and of the bystanders, by place in the store;
    /// `fallen` [m/s] is what gravity has added to the velocities there.
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

    /// The local place of the particle at a place in the store, if it is here.
    pub(super) fn local(&self, place: u32) -> Option<u32> {
        if self.by_place.is_empty() {
            return self.places.iter().position(|&other| other == place).map(|local| local as u32);
        }
        let found = self.by_place.binary_search_by_key(&place, |&local| self.places[local as usize]);
        found.ok().map(|k| self.by_place[k])
    }

    /// Whether the particle at local `place` may have that velocity [m/s, falling frame of this window]. A bystander may
    /// not be touched at all.
    pub fn allows(&self, place: usize, velocity: &Vector3<f64>) -> bool {
        Bounds { limits: &self.limits, frame: self.frame }.allows(place, velocity)
    }

    /// What an engine moves, where it writes down what happens, and how fast who may be.
    pub fn open(&mut self) -> (&mut Particles, &mut Log, Bounds<'_>) {
        (&mut self.particles, &mut self.log, Bounds { limits: &self.limits, frame: self.frame })
    }

    /// Notes that the flight of the particle at local `place` turns at `time` [s since the start of the part], with the origin that the flight from then on would
    /// have had at the start [m] and its velocity [m/s, falling frame of this window].
    pub fn turn(&mut self, place: u32, time: f64, origin: Vector3<f64>, velocity: Vector3<f64>) {
        self.turns.push((place, VelocityChange { time, origin, velocity: velocity - self.frame }));
    }

    /// [m/s] of the particle at local `place`, relative to the frame of the search.
    pub fn speed(&self, place: usize) -> f64 {
        (self.particles.velocity[place] - self.frame).norm().max(self.fastest)
    }

    /// [m/s] how much faster than that, seen from `frame` [m/s, falling frame of this window], a particle may be seen from the
    /// frame of the search.
    pub fn apart_from(&self, frame: &Vector3<f64>) -> f64 {
        (frame - self.frame).norm()
    }

    /// [m/s] the speed that every hot particle is allowed relative to the frame of the search.
    pub fn least_limit(&self) -> f64 {
        self.limits.iter().copied().fold(f64::INFINITY, f64::min)
    }
}
