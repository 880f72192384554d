//! Groups of hot particles that become islands, with bounds on the distance that each member may reach. A window is the
//! time between two exchanges of momentum with the gas. *Hot* particles touch something on their straight flight in
//! this part of a window; *cold* particles do not.

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

/// Number of islands, or of members, in a piece of parallel work; fewer are not worth a second thread.
const BATCH: usize = 64;

/// A hot particle, which is a member of an island.
pub struct Member {
    pub(in crate::engine) place: u32,
    pub(in crate::engine) cluster: u32,
    /// The ball that contains the straight flight of the particle.
    pub(in crate::engine) flight: BoundingSphere,
    /// The ball that contains the particle from the first touch in its island to the end of the part of the time
    /// window. Before that touch the particle flies straight.
    pub(in crate::engine) ball: BoundingSphere,
    /// Radius [m] of a ball about the middle of the straight flight that contains both `flight` and `ball`.
    around: f64,
    /// Radius [m] that the ball had when particles next to this member were last added to the crowd (large island moved
    /// by uniform steps); 0 if this has not been done.
    took_in: f64,
    /// Range of the velocity changes of this particle in the list of all changes. It is `None` before the island is
    /// solved, and for engines that do not report velocity changes. If it is known, `ball` contains the trajectory
    /// after the first change.
    turns: Option<Range<usize>>,
}

/// A list that rarely has more than four entries. The first four are stored in place, so most islands need no memory on
/// the heap.
pub type Few = SmallVec<[u32; 4]>;

/// An island (group of particles that may meet) while it is being found: its members, and bounds on their speeds.
pub struct Cluster {
    /// Numbers of the hot members; after `settle` they are in the order of the particles' ids.
    pub(in crate::engine) hot: Few,
    /// Indices in the particle store of the cold particles that the members might hit, in the order of their ids.
    pub(in crate::engine) bystanders: Few,
    /// Numbers of the items of state carried from earlier parts of a time window, such as contacts, that belong to the
    /// island. After `settle` they are in ascending order.
    carried: Few,
    /// The two largest kinetic energies [J] of the members, relative to the moving frame of the search.
    pub(in crate::engine) energies: [f64; 2],
    /// The two largest speeds [m/s] of the members, relative to the moving frame of the search.
    pub(in crate::engine) speeds: [f64; 2],
    /// Energy [J] of all carried state of the island, such as that stored in its contacts.
    pub(in crate::engine) stored: f64,
    /// Largest energy [J] of one item of carried state (such as contacts) of the island.
    deepest: f64,
    /// Lower limit [m/s] of the speed limits of the members. It rises when a member has exceeded its limit.
    pub(in crate::engine) floor: f64,
    /// Time [s] of the first touch in the island: until then all members fly straight.
    pub(in crate::engine) first: f64,
    /// True if the island is a crowd, always moved by uniform steps, even if it is small. An example is an island with
    /// many contacts.
    pub(in crate::engine) lasts: bool,
    pub(in crate::engine) alive: bool,
    /// Location of the island's result; `None` before the island is solved.
    solved: Option<IslandResult>,
    /// Number of changes of the island so far. The result of a search of the surroundings is valid for one version
    /// only.
    version: u32,
    /// Version of the island for which the reach of the members was last computed.
    settled: Option<u32>,
    /// Version of the island for which the surroundings were last searched. No new search is needed until the island
    /// changes.
    seen: Option<u32>,
}

impl Cluster {
    fn is_crowd(&self) -> bool {
        self.lasts || self.hot.len() > LARGEST_ISLAND
    }
}

/// Locations of the results of all islands, by island and by member.
pub struct Landing {
    /// Location of the result of each solved island.
    pub kept: Vec<IslandResult>,
    /// For each member, the number of its island in `kept`, and the number of the member in that island; `None` if its
    /// island has no result.
    pub of_member: Vec<Option<(u32, u32)>>,
}

/// Settings with which islands are made in a part of a time window.
pub struct Space<'a> {
    /// Scene with walls, domain and gravity.
    pub scene: &'a Scene,
    /// Velocity [m/s] of the frame in which speeds are measured.
    pub frame: Vector3<f64>,
    /// Length [s] of this part of the time window.
    pub part: f64,
    /// Mass [kg] of the lightest particle of the run.
    pub lightest: f64,
}

/// All islands of a part of a time window.
pub struct Clusters<'a> {
    pub(in crate::engine) search: &'a mut Search,
    pub(in crate::engine) particles: &'a Particles,
    pub(in crate::engine) domain: &'a Domain,
    frame: Vector3<f64>,
    part: f64,
    /// Mass [kg] of the lightest particle of the run.
    lightest: f64,
    /// The islands; an island that was united with another one is not `alive`.
    pub(in crate::engine) list: Vec<Cluster>,
    /// Energy [J] of each item of carried state, such as that stored in a contact.
    energy: Vec<f64>,
    /// Speed [m/s] that gravity adds towards walls during the part of the time window, in the falling frame. Added is
    /// twice the speed of walls that move, which an impact gives to a particle at most.
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

    /// Velocity [m/s] of the frame of a particle, given by index: that of the search, and in a sheared box the mean flow
    /// where the particle is when the part begins.
    #[inline]
    fn frame_of(&self, place: usize) -> Vector3<f64> {
        self.frame + self.domain.mean_flow(&self.particles.position[place])
    }

    /// Makes islands from all touches and from the carried state (such as contacts), whose energies [J] are given. If
    /// `many` is true, all carried state belongs to one crowd (large island moved by uniform steps).
    fn begin(&mut self, touches: &[FirstTouch], carried: &[[Option<u32>; 2]], energy: Vec<f64>, many: bool) {
        self.energy = energy;
        let mut crowd: Option<usize> = None;
        for (k, places) in carried.iter().enumerate() {
            let Some(i) = places[0] else { continue };
            let mut which = self.join(i, places[1], 0.0);
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
            self.join(touch.place, touch.other, touch.time);
        }
        self.settle_all();
    }

    /// Unites the island of particle `i` with that of its partner `j`, and returns its number; their first touch is at
    /// `time` [s]. A new island is made if neither particle is in one. The speeds of the particles are not read here.
    fn join(&mut self, i: u32, j: Option<u32>, time: f64) -> usize {
        let known = self.found(i).or_else(|| self.found(j?));
        let mut which = known.unwrap_or_else(|| self.open());
        for place in [Some(i), j].into_iter().flatten() {
            match self.found(place) {
                Some(other) => which = self.unite(which, other),
                None => self.enlist(place, which),
            }
        }
        let cluster = &mut self.list[which];
        cluster.first = cluster.first.min(time);
        which
    }

    /// Returns the number of a particle's island. If the particle is in none, a new island with the energy and speed of
    /// the particle is made.
    fn cluster_of(&mut self, place: u32) -> usize {
        let is_new = self.search.label[place as usize].is_none();
        let which = self.named(place);
        if is_new {
            let (energy, speed) = motion(self.particles, self.frame_of(place as usize), place);
            let cluster = &mut self.list[which];
            (cluster.energies, cluster.speeds) = ([energy, 0.0], [speed, 0.0]);
        }
        which
    }

    /// Returns the number of a particle's island; a new one is made if needed. Energy and speed of the particle are not
    /// read here, since those of all particles are computed in parallel later.
    fn named(&mut self, place: u32) -> usize {
        self.found(place).unwrap_or_else(|| {
            let which = self.open();
            self.enlist(place, which);
            which
        })
    }

    /// Number of a particle's island; `None` if the particle is in none.
    fn found(&self, place: u32) -> Option<usize> {
        let label = self.search.label[place as usize]?;
        Some(self.members[label.member()].cluster as usize)
    }

    /// Makes a particle, which is in no island so far, a member of the island `which`.
    fn enlist(&mut self, place: u32, which: usize) {
        let (cluster, member) = (which as u32, self.members.len());
        self.search.label[place as usize] = Some(Label::of(member));
        self.list[which].hot.push(member as u32);
        let flight = BoundingSphere { middle: Vector3::zeros(), reach: 0.0 };
        self.members.push(Member { place, cluster, flight, ball: flight, around: 0.0, took_in: 0.0, turns: None });
    }

    /// Makes an island without members, and returns its number.
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

    /// Unites two islands: the members of the smaller one join the larger. Returns the number of the larger.
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

    /// Numbers of the islands that this process still has to solve. A process solves an island only if it stores all
    /// particles around the island.
    pub fn unsolved(&self) -> Vec<usize> {
        let sees_all = self.search.region.is_all();
        let sight = if sees_all { 0.0 } else { self.reach().sight() };
        let unsolved = self.list.iter().enumerate().filter(|(_, c)| c.alive && c.solved.is_none());
        unsolved.map(|(which, _)| which).filter(|&which| sees_all || self.room(which) >= sight).collect()
    }

    /// Number of members of an island.
    pub fn members(&self, which: usize) -> usize {
        self.list[which].hot.len()
    }

    /// Numbers of the items of carried state (such as contacts) that belong to an island.
    pub fn carried(&self, which: usize) -> &[u32] {
        &self.list[which].carried
    }

    /// Stores the location of the result of an island.
    pub fn keep(&mut self, which: usize, result: IslandResult) {
        self.list[which].solved = Some(result);
    }

    /// Removes the labels of all members from the particles, if the results of the islands are not used.
    pub fn release(self) {
        for member in &self.members {
            self.search.label[member.place as usize] = None;
        }
    }

    /// Returns the locations of the results of all islands, in the order of the islands and by member. The labels of
    /// members are kept until the results are written into the particle store.
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
