//! Groups of hot particles that become islands, with bounds on the distance that each member may reach. Speeds are
//! relative to a frame that moves with the mean velocity of all particles along the walls. Particles are *hot* if they
//! touch something on their straight flight in this part, *cold* if they do not. A part is a piece of a window, the
//! time between two exchanges with the gas. Carried contacts (or recent collisions) continue from one part to the
//! next. A crowd is a large island that is moved by uniform steps.

mod bounded;
mod crowd_growth;
mod fill;
mod finder;
mod reach;
mod retries;
mod traced;
mod trajectories;

pub use bounded::BoundedIslands;
pub use fill::fill;
pub use finder::{IslandFinder, IslandLimits};
pub use reach::Reach;
use reach::{motion, two_largest};
pub use traced::TracedIslands;
pub use trajectories::{MemberTrajectories, VelocityChange};

use super::LARGEST_ISLAND;
use super::batch::IslandResult;
use super::search::{BoundingSphere, FirstTouch, Label, Search};
use crate::domain::Domain;
use crate::neighbours::along_walls;
use crate::particles::Particles;
use crate::scene::Scene;
use nalgebra::Vector3;
use smallvec::SmallVec;
use std::ops::Range;

/// Number of islands (groups of particles that may meet), or of members, that a thread treats as one piece of work;
/// fewer are not worth a second thread.
const BATCH: usize = 64;

/// A hot particle: a particle that may touch something in this part, and so is a member of an island (group of
/// particles that may meet). A part is a piece of the time between two exchanges with the gas.
pub struct Member {
    pub(in crate::engine) index: u32,
    pub(in crate::engine) cluster: u32,
    /// Ball that contains the particle in this part (interval of time) if the particle flies straight all the time.
    pub(in crate::engine) flight: BoundingSphere,
    /// Ball that contains the particle from the first touch in its island (group of particles that may meet) to the
    /// end of the part (interval of time). Before that touch the particle flies straight.
    pub(in crate::engine) ball: BoundingSphere,
    /// Radius [m] of a ball about the middle of the straight flight that contains both `flight` and `ball`.
    around: f64,
    /// Radius [m] of `ball` when the particles next to this member were last added to its crowd, an island moved by
    /// uniform steps; 0 if they have not been added.
    took_in: f64,
    /// Range of the velocity changes of this particle in the list of all changes; `None` if they are unknown. If they
    /// are known, `ball` contains the path after the first change.
    turns: Option<Range<usize>>,
}

/// Short list of indices. Up to four indices are stored in the list itself, so that most islands (groups of particles
/// that may meet) need no memory on the heap.
pub type Few = SmallVec<[u32; 4]>;

/// An island (group of particles that may meet) while it is being found: its members, and bounds on their speeds.
pub struct Cluster {
    /// Numbers of the members in the list `Clusters::members`. `update_reach` sorts them by the ids of the particles.
    pub(in crate::engine) hot: Few,
    /// Indices in the particle store of the bystanders, in the order of their ids. Bystanders are particles that fly
    /// straight unless a member hits them.
    pub(in crate::engine) bystanders: Few,
    /// Numbers of the carried contacts (or recent collisions) that belong to the island (group of particles that may
    /// meet). `update_reach` sorts them in ascending order.
    carried: Few,
    /// The two largest energies [J] of members, the largest first: kinetic energy of the motion relative to the mean
    /// velocity of all particles along the walls, and of rotation.
    pub(in crate::engine) energies: [f64; 2],
    /// The two largest speeds [m/s] of members relative to the mean velocity of all particles along the walls, the
    /// largest first. The speed of a rotating surface is added.
    pub(in crate::engine) speeds: [f64; 2],
    /// Sum of the energies [J] that the carried contacts of the island may give back to its particles.
    pub(in crate::engine) stored: f64,
    /// Largest energy [J] that a single carried contact of the island may give back.
    deepest: f64,
    /// Lower bound [m/s] of the speed limits of the members. It is 0 until a member exceeds its limit, and is then
    /// raised.
    pub(in crate::engine) floor: f64,
    /// Time [s] of the first touch in the island (group of particles that may meet) since the start of the part
    /// (interval of time). Until then all members fly straight.
    pub(in crate::engine) first: f64,
    /// True if the island (group of particles that may meet) is a crowd even if it is small: its particles are moved
    /// by uniform steps, since it contains many contacts or was too expensive.
    pub(in crate::engine) lasts: bool,
    pub(in crate::engine) alive: bool,
    /// Place of the island's result in the lists of results; `None` as long as there is no valid result.
    solved: Option<IslandResult>,
    /// Number of changes of the island so far. Data computed for an earlier version are outdated.
    version: u32,
    /// Version of the island (group of particles that may meet) for which the distances that its members may reach
    /// were last computed; `None` if they were never computed.
    settled: Option<u32>,
    /// Version of the island (group of particles that may meet) for which a search of its surroundings last found no
    /// other island that it may meet; `None` if there was no such search.
    seen: Option<u32>,
}

impl Cluster {
    fn is_crowd(&self) -> bool {
        self.lasts || self.hot.len() > LARGEST_ISLAND
    }
}

/// Places of the results of all islands (groups of particles that may meet) in the lists of results.
pub struct Landing {
    /// Place of the result of each solved island (group of particles that may meet), in the order of the islands.
    pub kept: Vec<IslandResult>,
    /// For each member, the number of its island (group of particles that may meet) in `kept`, and its number in that
    /// island; `None` if the island has no result.
    pub of_member: Vec<Option<(u32, u32)>>,
}

/// Data with which islands (groups of particles that may meet) are found in a part, a piece of the time between two
/// exchanges with the gas.
pub struct Space<'a> {
    /// Scene with walls, box and gravity at the start of the part (interval of time).
    pub scene: &'a Scene,
    /// [m/s] velocity of the moving frame in which speeds are measured.
    pub frame: Vector3<f64>,
    /// [s] length of the part (interval of time).
    pub part: f64,
    /// [kg] mass of the lightest particle of the run.
    pub lightest: f64,
}

/// All islands (groups of particles that may meet) in a part, a piece of the time between two exchanges with the gas.
pub struct Clusters<'a> {
    pub(in crate::engine) search: &'a mut Search,
    pub(in crate::engine) particles: &'a Particles,
    pub(in crate::engine) domain: &'a Domain,
    frame: Vector3<f64>,
    part: f64,
    /// Mass [kg] of the lightest particle of the run.
    lightest: f64,
    /// The islands (groups of particles that may meet) by their numbers. An island that has been united with another
    /// one stays in the list, but is not `alive`.
    pub(in crate::engine) list: Vec<Cluster>,
    /// Energy [J] that each carried contact may give back to its particles.
    energy: Vec<f64>,
    /// Amount [m/s] by which all speed limits are raised because of walls. It is the velocity that gravity adds
    /// towards walls during the part (interval of time), plus twice the speed of the fastest wall. An impact on a
    /// moving wall adds at most twice the speed of the wall.
    fall: f64,
    pub(in crate::engine) members: Vec<Member>,
    /// Largest distance [m] that any member may reach from the middle of its straight flight.
    pub(in crate::engine) widest: f64,
    half_period: f64,
}

impl<'a> Clusters<'a> {
    pub fn new(search: &'a mut Search, particles: &'a Particles, space: Space<'a>) -> Self {
        let Space { scene, frame, part, lightest } = space;
        let domain = &scene.domain;
        let fall = (scene.gravity - along_walls(scene, scene.gravity)).norm() * part + 2.0 * scene.wall_speed();
        let periods = (0..3).filter(|axis| domain.periodic[*axis]).map(|axis| 0.5 * domain.size[axis]);
        let half_period = periods.fold(f64::INFINITY, f64::min);
        Self {
            search,
            particles,
            domain,
            frame,
            part,
            lightest,
            list: Vec::new(),
            energy: Vec::new(),
            fall,
            members: Vec::new(),
            widest: 0.0,
            half_period,
        }
    }

    /// Velocity [m/s] of the frame in which the speed of a particle, given by index, is limited. In a sheared box it
    /// contains the mean flow at the position of the particle at the start of the part (interval of time).
    #[inline]
    fn frame_of(&self, index: usize) -> Vector3<f64> {
        self.frame + self.domain.mean_flow(&self.particles.position[index])
    }

    /// Makes islands (groups of particles that may meet) of all particles that touch on straight flights or have a
    /// carried contact. `carried` contains the two particles of each contact (the second is `None`, for instance, at a
    /// wall). `energy` contains the energy [J] that each contact may give back. If `many` is true, all contacts form
    /// one crowd, an island moved by uniform steps.
    fn begin(&mut self, touches: &[FirstTouch], carried: &[[Option<u32>; 2]], energy: Vec<f64>, many: bool) {
        self.energy = energy;
        let mut crowd: Option<usize> = None;
        for (k, indices) in carried.iter().enumerate() {
            let Some(i) = indices[0] else { continue };
            let mut which = self.join(i, indices[1], 0.0);
            if many {
                which = crowd.map_or(which, |crowd| self.unite(crowd, which));
                crowd = Some(which);
                self.list[which].lasts = true;
            }
            self.list[which].carried.push(k as u32);
        }
        self.members.reserve(2 * touches.len());
        self.list.reserve(touches.len());
        for touch in touches {
            self.join(touch.index, touch.other, touch.time);
        }
        self.settle_all();
    }

    /// Unites the islands (groups of particles that may meet) of two particles that touch at `time` [s] since the
    /// start of the part (interval of time). If `j` is `None`, particle `i` touches a wall. Returns the number of the
    /// united island. A new island is made if neither particle is in one. Energies and speeds of the particles are not
    /// read here, but later in parallel.
    fn join(&mut self, i: u32, j: Option<u32>, time: f64) -> usize {
        let known = self.found(i).or_else(|| self.found(j?));
        let mut which = known.unwrap_or_else(|| self.open());
        for index in [Some(i), j].into_iter().flatten() {
            match self.found(index) {
                Some(other) => which = self.unite(which, other),
                None => self.enlist(index, which),
            }
        }
        let cluster = &mut self.list[which];
        cluster.first = cluster.first.min(time);
        which
    }

    /// Number of the island (group of particles that may meet) of the particle at `index`. If the particle is in no
    /// island, a new island of this particle is made, with its energy and speed.
    fn cluster_of(&mut self, index: u32) -> usize {
        let is_new = self.search.label[index as usize].is_none();
        let which = self.named(index);
        if is_new {
            let (energy, speed) = motion(self.particles, self.frame_of(index as usize), index);
            let cluster = &mut self.list[which];
            (cluster.energies, cluster.speeds) = ([energy, 0.0], [speed, 0.0]);
        }
        which
    }

    /// Number of the island (group of particles that may meet) of the particle at `index`. If the particle is in no
    /// island, a new island of this particle is made; its energy and speed are not yet set.
    fn named(&mut self, index: u32) -> usize {
        self.found(index).unwrap_or_else(|| {
            let which = self.open();
            self.enlist(index, which);
            which
        })
    }

    /// Number of the island (group of particles that may meet) of the particle at `index`; `None` if the particle is
    /// in no island.
    fn found(&self, index: u32) -> Option<usize> {
        let label = self.search.label[index as usize]?;
        Some(self.members[label.member()].cluster as usize)
    }

    /// Makes the particle at `index`, which is in no island (group of particles that may meet) so far, a member of the
    /// island `which`.
    fn enlist(&mut self, index: u32, which: usize) {
        let (cluster, member) = (which as u32, self.members.len());
        self.search.label[index as usize] = Some(Label::of(member));
        self.list[which].hot.push(member as u32);
        let flight = BoundingSphere { middle: Vector3::zeros(), reach: 0.0 };
        self.members.push(Member { index, cluster, flight, ball: flight, around: 0.0, took_in: 0.0, turns: None });
    }

    /// Makes a new island (group of particles that may meet) without members, and returns its number.
    fn open(&mut self) -> usize {
        self.list.push(Cluster {
            hot: Few::new(),
            bystanders: Few::new(),
            carried: Few::new(),
            energies: [0.0; 2],
            speeds: [0.0; 2],
            stored: 0.0,
            deepest: 0.0,
            floor: 0.0,
            first: self.part,
            lasts: false,
            alive: true,
            solved: None,
            version: 0,
            settled: None,
            seen: None,
        });
        self.list.len() - 1
    }

    /// Unites the islands with the numbers `a` and `b` (groups of particles that may meet). The members and contacts
    /// of the island with fewer members move to the other island, whose number is returned.
    fn unite(&mut self, a: usize, b: usize) -> usize {
        if a == b {
            return a;
        }
        let (into, from) = if self.list[a].hot.len() >= self.list[b].hot.len() { (a, b) } else { (b, a) };
        let gone = &mut self.list[from];
        gone.alive = false;
        gone.solved = None;
        let (hot, carried) = (std::mem::take(&mut gone.hot), std::mem::take(&mut gone.carried));
        let (energies, speeds, floor) = (gone.energies, gone.speeds, gone.floor);
        let (first, lasts) = (gone.first, gone.lasts);
        for &member in &hot {
            self.members[member as usize].cluster = into as u32;
        }
        let kept = &mut self.list[into];
        kept.hot.extend(hot);
        kept.carried.extend(carried);
        kept.energies = two_largest(kept.energies, energies);
        kept.speeds = two_largest(kept.speeds, speeds);
        kept.floor = kept.floor.max(floor);
        kept.first = kept.first.min(first);
        kept.lasts |= lasts;
        kept.solved = None;
        kept.version += 1;
        into
    }

    /// Numbers of the islands (groups of particles that may meet) without a valid result that this process has to
    /// solve. A process solves an island only if it stores all particles around the island.
    pub fn unsolved(&self) -> Vec<usize> {
        let sees_all = self.search.region.is_all();
        let search_radius = if sees_all { 0.0 } else { self.reach().search_radius() };
        let unsolved = self.list.iter().enumerate().filter(|(_, c)| c.alive && c.solved.is_none());
        unsolved.map(|(which, _)| which).filter(|&which| sees_all || self.room(which) >= search_radius).collect()
    }

    /// Number of members of the island with the number `which` (group of particles that may meet).
    pub fn members(&self, which: usize) -> usize {
        self.list[which].hot.len()
    }

    /// Numbers of the carried contacts (or recent collisions) that belong to the island with the number `which` (group
    /// of particles that may meet).
    pub fn carried(&self, which: usize) -> &[u32] {
        &self.list[which].carried
    }

    /// Stores the place of the valid result of the island `which` (group of particles that may meet).
    pub fn keep(&mut self, which: usize, result: IslandResult) {
        self.list[which].solved = Some(result);
    }

    /// Removes the labels of members from all particles, and discards the results of the islands (groups of particles
    /// that may meet).
    pub fn release(self) {
        for member in &self.members {
            self.search.label[member.index as usize] = None;
        }
    }

    /// Returns where the results are stored: the place of the result of each solved island (group of particles that
    /// may meet), and for each member the number of its island and its number within the island. Particles keep their
    /// labels as members until the results are written into the particle store.
    pub fn land(self) -> Landing {
        let mut of_member = vec![None; self.members.len()];
        let mut kept = Vec::with_capacity(self.list.len());
        for cluster in &self.list {
            let Some(result) = cluster.solved else { continue };
            for (number, &member) in cluster.hot.iter().enumerate() {
                of_member[member as usize] = Some((kept.len() as u32, number as u32));
            }
            kept.push(result);
        }
        Landing { kept, of_member }
    }
}
