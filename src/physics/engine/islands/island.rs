//! One island (a group of particles that may meet) as a small scene, which an engine can solve separately. Its
//! members touch something within the part (*hot* particles); for each of them a bound on its speed is estimated.
//! *Bystanders* are particles that fly straight unless a member hits them. A part is a piece of a window, the time
//! between two exchanges with the gas.

use super::cluster::VelocityChange;
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use crate::record::{Ledger, Log};
use nalgebra::Vector3;

/// Largest number of particles in an island (group of particles that may meet) for which a linear search for one
/// particle is faster than a binary search.
const FEW: usize = 32;

/// An island (group of particles that may meet) as a small separate scene for an engine. Local indices number the
/// particles: first the members (hot particles), then the bystanders, which fly straight unless a member hits them.
pub struct Island<C> {
    /// Copies of the particles, with velocities relative to the frame at rest. The engine moves them from the start of
    /// a part (interval of time) to its end.
    pub particles: Particles,
    /// Index in the particle store of each particle, by local index.
    pub indices: Vec<u32>,
    /// Number of members of the island; they come before the bystanders in `particles`.
    pub hot: usize,
    /// True if the island is a crowd, a large island that is moved by uniform steps.
    pub crowd: bool,
    /// Local indices of all particles, sorted by the index in the particle store, for a binary search. Empty for a
    /// small island (group of particles that may meet), in which a linear search is faster.
    by_index: Vec<u32>,
    /// Pairs of particles, and particles with walls, that may touch in this part (interval of time).
    pub list: NeighbourList,
    /// Contacts in progress (soft spheres) or recent collisions (hard spheres), with local indices of particles.
    /// Before the island (group of particles that may meet) is solved, the list is that at the start of the part
    /// (interval of time); afterwards it is that at the end.
    pub carried: Vec<C>,
    /// Log of the impacts and energies in the island (group of particles that may meet).
    pub log: Log,
    /// Velocity changes in the order of time, each with the local index of its particle; empty if the engine does not
    /// report them.
    pub turns: Vec<(u32, VelocityChange)>,
    /// Number of collisions (hard spheres), or of time steps of contacts (soft and hybrid spheres).
    pub events: u64,
    /// Number of collisions of hybrid spheres; 0 in other engines, which do not use it.
    pub impulses: u64,
    /// Number of uniform steps, if the island is a crowd (moved by uniform steps); otherwise 0.
    pub crowd_steps: u64,
    /// Number of contact forces computed in uniform steps, if the island is a crowd.
    pub crowd_forces: u64,
    /// Number of gaps and times of touch that were computed for the island (group of particles that may meet).
    pub pair_checks: u64,
    /// Number of contact forces that were computed in the island, those of uniform steps included.
    pub force_evaluations: u64,
    /// Measure of the work: one for each particle moved in each stage of the time integrator, plus one for each gap
    /// checked after a step. In a crowd (island moved by uniform steps) both count one half.
    pub updates: u64,
    /// Local indices of further particles that exceeded their speed limit, or that were hit although they are
    /// bystanders. The particle that the solver returns is not repeated here.
    pub also: Vec<usize>,
    /// [m/s] largest speed of any particle so far, relative to the moving frame. A solver sets this speed if it notices
    /// only at the end that the speed limit (estimated upper bound) was exceeded; otherwise the value is 0.
    pub fastest: f64,
    /// Speed limit [m/s] of each member, relative to the moving frame `frame`: an estimated upper bound. A faster
    /// member may leave the ball in which other particles were searched, so the island is then solved again.
    pub(super) limits: Vec<f64>,
    /// Velocity [m/s] of the moving frame in which speeds are compared with the limits, relative to the frame at rest.
    frame: Vector3<f64>,
    /// [m/s] mean flow of a sheared box at the place of each particle at the start of the part (interval of time). The
    /// mean flow is added to the velocity of the frame of the speed limits. The list is empty without shear.
    pub(super) flow: Vec<Vector3<f64>>,
}

impl<C> Island<C> {
    /// Makes an island (group of particles that may meet) without particles.
    pub fn empty() -> Self {
        Self {
            particles: Particles::default(),
            indices: Vec::new(),
            hot: 0,
            crowd: false,
            by_index: Vec::new(),
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

    /// Fills the island with copies of members, given by index in the store and speed limit [m/s], and of bystanders,
    /// which fly straight unless a member hits them. The speed limits are relative to a frame with the velocity `frame`
    /// [m/s]. `fallen` [m/s] is the velocity that gravity has added since the last exchange with the gas, and that the
    /// store does not contain.
    pub(super) fn begin(
        &mut self,
        store: &Particles,
        hot: impl Iterator<Item = (u32, f64)>,
        bystanders: &[u32],
        frame: Vector3<f64>,
        fallen: Vector3<f64>,
    ) {
        self.indices.clear();
        self.limits.clear();
        self.flow.clear();
        for (index, limit) in hot {
            self.indices.push(index);
            self.limits.push(limit);
        }
        self.hot = self.indices.len();
        self.indices.extend_from_slice(bystanders);
        self.by_index.clear();
        if self.indices.len() > FEW {
            self.by_index.extend(0..self.indices.len() as u32);
            self.by_index.sort_unstable_by_key(|&local| self.indices[local as usize]);
        }
        self.particles.clear();
        self.particles.copy_from(store, &self.indices);
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

    /// Local index of the particle at `index` in the particle store; `None` if the particle is not in the island
    /// (group of particles that may meet).
    pub(super) fn local(&self, index: u32) -> Option<u32> {
        if self.by_index.is_empty() {
            return self.indices.iter().position(|&other| other == index).map(|local| local as u32);
        }
        let found = self.by_index.binary_search_by_key(&index, |&local| self.indices[local as usize]);
        found.ok().map(|k| self.by_index[k])
    }

    /// True if the particle at the local `index` is a member with a speed up to its limit, the upper bound that was
    /// estimated for it. `velocity` [m/s] is given in the frame that falls with gravity from rest at the start of the
    /// part (interval of time). The speed is relative to the moving frame of the limits. The result for a bystander,
    /// which must not be touched, is always false.
    pub fn allows(&self, index: usize, velocity: &Vector3<f64>) -> bool {
        let speed = || (velocity - self.frame_of(index)).norm();
        self.limits.get(index).is_some_and(|limit| speed() <= *limit)
    }

    /// Records a velocity change of the particle at the local `index`, at `time` [s] since the start of the part
    /// (interval of time). `origin` [m] is the position that the particle would have had at the start of the part on
    /// the line of its new flight. `velocity` [m/s] is its new velocity in the frame that falls with gravity from rest
    /// at the start of the part.
    pub fn turn(&mut self, index: u32, time: f64, origin: Vector3<f64>, velocity: Vector3<f64>) {
        self.turns.push((index, VelocityChange { time, origin, velocity: velocity - self.frame_of(index as usize) }));
    }

    /// Speed [m/s] of the particle at the local `index`, relative to the moving frame of the speed limits (estimated
    /// upper bounds). If the speed `fastest` that a solver has noted is larger, it is returned instead.
    pub fn speed(&self, index: usize) -> f64 {
        (self.particles.velocity[index] - self.frame_of(index)).norm().max(self.fastest)
    }

    /// Velocity [m/s] of the moving frame in which the speed of the particle at the local `index` is compared with its
    /// limit. The limit is an estimated upper bound: no speed is reduced, but the island is solved again if a speed is
    /// larger. The velocity is the field `frame`, plus the mean flow at the particle in a sheared box.
    fn frame_of(&self, index: usize) -> Vector3<f64> {
        match self.flow.get(index) {
            None => self.frame,
            Some(flow) => self.frame + flow,
        }
    }

    /// Largest possible difference [m/s] between the speeds of one particle in two frames. One frame has the velocity
    /// `frame` [m/s], the other is the moving frame of this island without the mean flow of a sheared box.
    pub fn apart_from(&self, frame: &Vector3<f64>) -> f64 {
        (frame - self.frame).norm()
    }

    /// Smallest speed limit (estimated upper bound) [m/s] of any member, relative to the moving frame; infinite without
    /// members.
    pub fn least_limit(&self) -> f64 {
        self.limits.iter().copied().fold(f64::INFINITY, f64::min)
    }
}
