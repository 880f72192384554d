//! Hot particles gathered into islands, with bounds on how far each may get.

mod bed;
mod course;
mod fill;
mod look;
mod reach;
mod retries;
mod sight;

use course::DeflectedFlights;
pub use course::{PiecewiseTrajectory, VelocityChange};
use reach::{motion, two_largest};
pub use sight::HotParticleDigest;

use super::LARGEST_ISLAND;
use super::batch::IslandResult;
use super::search::{BoundingSphere, FirstTouch, Label, Search};
use crate::domain::Domain;
use crate::neighbours::along_walls;
use crate::neighbours::cells::CellGrid;
use crate::particles::Particles;
use crate::scene::Scene;
use nalgebra::Vector3;
use smallvec::SmallVec;
use std::ops::Range;

/// Contacts in progress from which all of them are one crowd: each of them takes a step of an island four times the force of a uniform step,
/// and with so many something always touches.
const MANY_CONTACTS: usize = 16;

/// Islands, or members, that a thread takes at once: below that a second thread is not worth it.
const BATCH: usize = 64;

/// A hot particle.
struct Member {
    place: u32,
    cluster: u32,
    /// Its straight flight.
    flight: BoundingSphere,
    /// The ball that holds it from the first touch of its island on; until then it is on its straight flight.
    ball: BoundingSphere,
    /// [m] reach about the middle of the flight that holds both.
    around: f64,
    /// [m] the reach of its ball when it last took in what lies beside it; 0: it never did.
    took_in: f64,
    /// Where its flight turns, of all turns, once its island is solved by an engine that says so; its ball then holds its way from the first turn on.
    turns: Option<Range<usize>>,
}

/// Numbers of which there are rarely more than four: so many are kept in place, and most islands ask for no memory of their own.
type Few = SmallVec<[u32; 4]>;

/// One island in the making.
struct Cluster {
    /// Hot members, once settled in the order of their ids.
    hot: Few,
    /// Cold particles that they might hit, by place, in the order of their ids.
    bystanders: Few,
    /// What is carried into it, once settled in the order in which it lasts.
    carried: Few,
    /// [J] the two largest kinetic energies of its hot particles, relative to the frame.
    energies: [f64; 2],
    /// [m/s] their two largest speeds, relative to the frame.
    speeds: [f64; 2],
    /// [J] energy of what is carried.
    stored: f64,
    /// [J] the largest energy of one thing carried.
    deepest: f64,
    /// [m/s] at least this is allowed for, whatever the energy.
    floor: f64,
    /// [s] its first touch: until then all of it fly straight.
    first: f64,
    /// Whether it is a crowd however small it is: many contacts last in it.
    lasts: bool,
    alive: bool,
    /// Where its result is.
    solved: Option<IslandResult>,
    /// Counts its changes: what an earlier version saw around it is out of date.
    version: u32,
    /// The version of which it is known how far its members reach.
    settled: Option<u32>,
    /// The version that has seen all around it: nothing is to be found there until it changes.
    seen: Option<u32>,
}

impl Cluster {
    fn is_crowd(&self) -> bool {
        self.lasts || self.hot.len() > LARGEST_ISLAND
    }
}

/// Where the results of islands are.
pub struct Landing {
    /// Of each island.
    pub kept: Vec<IslandResult>,
    /// Of each member the number of its island among these, and its own among the members.
    pub of_member: Vec<Option<(u32, u32)>>,
}

/// Where islands are made, and of what size.
pub struct Space<'a> {
    /// Walls, domain and gravity.
    pub scene: &'a Scene,
    /// [m/s] velocity of the frame that speeds are taken in.
    pub frame: Vector3<f64>,
    /// [s] length of the part.
    pub part: f64,
    /// Whether islands may be crowds.
    pub crowds: bool,
    /// Whether the engine says where flights turn.
    pub traces: bool,
    /// [kg] the mass of the lightest particle.
    pub lightest: f64,
    /// Members beyond which an island that is no crowd is too large.
    pub most: usize,
}

/// All islands of a window.
pub struct Clusters<'a> {
    search: &'a mut Search,
    particles: &'a Particles,
    domain: &'a Domain,
    frame: Vector3<f64>,
    part: f64,
    /// Whether islands may be crowds.
    crowds: bool,
    /// Whether the engine says where flights turn: who meets whom is then asked of islands that are solved.
    traces: bool,
    /// [kg] the mass of the lightest particle.
    lightest: f64,
    /// Members beyond which an island that is no crowd is too large.
    most: usize,
    clusters: Vec<Cluster>,
    /// Where flights of members turn; of each member in the order of time.
    turns: Vec<VelocityChange>,
    /// The balls of the members of an engine that says where flights turn, in cells; and those of islands that were solved anew since.
    turned: [DeflectedFlights; 2],
    /// [J] energy of each thing carried.
    energy: Vec<f64>,
    /// [m/s] what gravity adds towards walls: in the falling frame they come nearer.
    fall: f64,
    members: Vec<Member>,
    /// The members in cells, as they were last sorted: those that became hot since stand behind them in `members`.
    grid: CellGrid,
    sorted: Vec<u32>,
    /// [m] the largest reach of a member.
    widest: f64,
    half_period: f64,
}

impl<'a> Clusters<'a> {
    pub fn new(search: &'a mut Search, particles: &'a Particles, space: Space<'a>) -> Self {
        let Space { scene, frame, part, crowds, traces, lightest, most } = space;
        let domain = &scene.domain;
        let fall = (scene.gravity - along_walls(scene, scene.gravity)).norm() * part;
        let periods = (0..3).filter(|axis| domain.periodic[*axis]).map(|axis| 0.5 * domain.size[axis]);
        let half_period = periods.fold(f64::INFINITY, f64::min);
        Self {
            search,
            particles,
            domain,
            frame,
            part,
            crowds,
            traces,
            lightest,
            most,
            clusters: Vec::new(),
            turns: Vec::new(),
            turned: Default::default(),
            energy: Vec::new(),
            fall,
            members: Vec::new(),
            grid: CellGrid::default(),
            sorted: Vec::new(),
            widest: 0.0,
            half_period,
        }
    }

    /// Makes islands of all touches and of what is carried; false if one grows too large.
    pub fn gather(&mut self, touches: &[FirstTouch], carried: &[[Option<u32>; 2]], energy: Vec<f64>) -> bool {
        self.energy = energy;
        // many contacts that last are one crowd from the start, whether they touch one another or not: as islands of their own they would
        // meet one by one, and be stepped at several times the cost
        let many = self.crowds && carried.len() > MANY_CONTACTS;
        let mut crowd: Option<usize> = None;
        for (k, places) in carried.iter().enumerate() {
            let Some(i) = places[0] else { continue };
            let mut which = self.join(i, places[1], 0.0);
            if many {
                which = crowd.map_or(which, |crowd| self.unite(crowd, which));
                crowd = Some(which);
                self.clusters[which].lasts = true;
            }
            self.clusters[which].carried.push(k as u32);
        }
        self.members.reserve(2 * touches.len());
        self.clusters.reserve(touches.len());
        for touch in touches {
            self.join(touch.place, touch.other, touch.time);
        }
        self.settle_all();
        if self.traces {
            return true;
        }
        self.sort();
        self.expand_all((0..self.clusters.len()).collect())
    }

    /// Sorts the members into cells.
    fn sort(&mut self) {
        let spacing = (self.search.region.volume() / self.members.len().max(1) as f64).cbrt();
        // a bed fills a part of the domain only: cells of a third of the spacing are at most 27 for each member
        let edge = self.widest.max(if self.crowds { spacing / 3.0 } else { spacing });
        self.grid.sort(&self.members, |member| member.flight.middle, &self.search.region, edge, &mut self.sorted);
    }

    /// The cluster of a particle that touches at `time` [s], made if there is none, united with that of the other. How fast they are is not yet known.
    fn join(&mut self, i: u32, j: Option<u32>, time: f64) -> usize {
        let known = self.found(i).or_else(|| self.found(j?));
        let mut which = known.unwrap_or_else(|| self.open());
        for place in [Some(i), j].into_iter().flatten() {
            match self.found(place) {
                Some(other) => which = self.unite(which, other),
                None => self.enlist(place, which),
            }
        }
        let cluster = &mut self.clusters[which];
        cluster.first = cluster.first.min(time);
        which
    }

    /// The cluster of a particle, made if there is none.
    fn cluster_of(&mut self, place: u32) -> usize {
        let is_new = self.search.label[place as usize].is_none();
        let which = self.named(place);
        if is_new {
            let (energy, speed) = motion(self.particles, self.frame, place);
            let cluster = &mut self.clusters[which];
            (cluster.energies, cluster.speeds) = ([energy, 0.0], [speed, 0.0]);
        }
        which
    }

    /// The same, but nothing is fetched of the particle: what is known of all is worked out in parallel later.
    fn named(&mut self, place: u32) -> usize {
        self.found(place).unwrap_or_else(|| {
            let which = self.open();
            self.enlist(place, which);
            which
        })
    }

    /// The cluster of a particle, if it has one.
    fn found(&self, place: u32) -> Option<usize> {
        let label = self.search.label[place as usize]?;
        Some(self.members[label.member()].cluster as usize)
    }

    /// A particle without a cluster becomes a member of one.
    fn enlist(&mut self, place: u32, which: usize) {
        let (cluster, member) = (which as u32, self.members.len());
        self.search.label[place as usize] = Some(Label::of(member));
        self.clusters[which].hot.push(member as u32);
        let flight = BoundingSphere { middle: Vector3::zeros(), reach: 0.0 };
        self.members.push(Member { place, cluster, flight, ball: flight, around: 0.0, took_in: 0.0, turns: None });
    }

    /// A cluster without members.
    fn open(&mut self) -> usize {
        self.clusters.push(Cluster {
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
        self.clusters.len() - 1
    }

    /// The smaller goes into the larger.
    fn unite(&mut self, a: usize, b: usize) -> usize {
        if a == b {
            return a;
        }
        let (into, from) = if self.clusters[a].hot.len() >= self.clusters[b].hot.len() { (a, b) } else { (b, a) };
        let gone = &mut self.clusters[from];
        gone.alive = false;
        gone.solved = None;
        let (hot, carried) = (std::mem::take(&mut gone.hot), std::mem::take(&mut gone.carried));
        let (energies, speeds, floor) = (gone.energies, gone.speeds, gone.floor);
        let (first, lasts) = (gone.first, gone.lasts);
        for &member in &hot {
            self.members[member as usize].cluster = into as u32;
        }
        let kept = &mut self.clusters[into];
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

    /// Islands that are still to be solved: those of which all is seen that they may have to do with.
    pub fn unsolved(&self) -> Vec<usize> {
        let sees_all = self.search.region.is_all();
        let sight = if sees_all { 0.0 } else { self.reach().sight() };
        let unsolved = self.clusters.iter().enumerate().filter(|(_, c)| c.alive && c.solved.is_none());
        unsolved.map(|(which, _)| which).filter(|&which| sees_all || self.room(which) >= sight).collect()
    }

    /// How many members an island has.
    pub fn members(&self, which: usize) -> usize {
        self.clusters[which].hot.len()
    }

    /// What is carried into an island.
    pub fn carried(&self, which: usize) -> &[u32] {
        &self.clusters[which].carried
    }

    /// Notes where its result is.
    pub fn keep(&mut self, which: usize, result: IslandResult) {
        self.clusters[which].solved = Some(result);
    }

    /// Forgets the labels: nothing has come of it.
    pub fn release(self) {
        for member in &self.members {
            self.search.label[member.place as usize] = None;
        }
    }

    /// Says where the results are, in order, and of each member which one of its island's is its own; the labels are left to whoever puts them into the store.
    pub fn land(self) -> Landing {
        let mut of_member = vec![None; self.members.len()];
        let mut kept = Vec::with_capacity(self.clusters.len());
        for cluster in &self.clusters {
            let Some(result) = cluster.solved else { continue };
            for (number, &member) in cluster.hot.iter().enumerate() {
                of_member[member as usize] = Some((kept.len() as u32, number as u32));
            }
            kept.push(result);
        }
        Landing { kept, of_member }
    }
}
