//! Hot particles gathered into islands, with bounds on how far each may get.

mod bed;
mod fill;
mod lessons;
mod sight;

pub use sight::Told;

use super::LARGEST_ISLAND;
use super::batch::Kept;
use super::search::{FirstTouch, Label, Search, Spot};
use crate::domain::Domain;
use crate::neighbours::along_walls;
use crate::neighbours::cells::CellGrid;
use crate::particles::Particles;
use crate::scene::Scene;
use nalgebra::Vector3;
use rayon::prelude::*;

/// Contacts in progress from which all of them are one crowd: each of them takes a step of an island four times the force of a uniform step,
/// and with so many something always touches.
const MANY_CONTACTS: usize = 16;

/// Islands, or members, that a thread takes at once: below that a second thread is not worth it.
const TOGETHER: usize = 64;

/// Speeds may pass the bound of energy conservation by this factor before an island is done again: contacts of finite
/// steps may gain a little.
const MARGIN: f64 = 1.05;

/// A hot particle.
struct Member {
    place: u32,
    cluster: u32,
    /// Its straight flight.
    flight: Spot,
    /// The ball that holds it from the first touch of its island on; until then it is on its straight flight.
    ball: Spot,
    /// [m] reach about the middle of the flight that holds both.
    around: f64,
    /// [m] the reach of its ball when it last took in what lies beside it; 0: it never did.
    took_in: f64,
}

/// One island in the making.
struct Cluster {
    /// Hot members, once settled in the order of their ids.
    hot: Vec<u32>,
    /// Cold particles that they might hit, by place, in the order of their ids.
    bystanders: Vec<u32>,
    /// What is carried into it, once settled in the order in which it lasts.
    carried: Vec<u32>,
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
    solved: Option<Kept>,
    /// Counts its changes: what an earlier version saw around it is out of date.
    version: u32,
    /// The version that has seen all around it: nothing is to be found there until it changes.
    seen: Option<u32>,
}

/// The two largest of two pairs.
fn two_largest(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let mut all = [a[0], a[1], b[0], b[1]];
    all.sort_unstable_by(|a, b| b.total_cmp(a));
    [all[0], all[1]]
}

impl Cluster {
    fn is_crowd(&self) -> bool {
        self.lasts || self.hot.len() > LARGEST_ISLAND
    }
}

/// What an island sees around it.
enum Surroundings {
    /// Cold particles it might hit, by place.
    Bystanders(Vec<u32>),
    /// Other islands that it might meet; where there may be crowds all of them, else one.
    Islands(Vec<usize>),
    /// It has grown too large to be one.
    TooLarge,
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
    /// [kg] the mass of the lightest particle.
    pub lightest: f64,
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
    /// [kg] the mass of the lightest particle.
    lightest: f64,
    clusters: Vec<Cluster>,
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
        let Space { scene, frame, part, crowds, lightest } = space;
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
            lightest,
            clusters: Vec::new(),
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
        for touch in touches {
            self.join(touch.place, touch.other, touch.time);
        }
        self.settle_all();
        self.sort();
        // most islands meet nobody: looking around changes nothing and is done in parallel; a crowd takes in what lies beside it first
        let this = &*self;
        let look = |which: usize| {
            let cluster = &this.clusters[which];
            (cluster.version, (!cluster.is_crowd()).then(|| this.look_around(which)))
        };
        let seen: Vec<(u32, Option<Surroundings>)> =
            (0..self.clusters.len()).into_par_iter().with_min_len(TOGETHER).map(look).collect();
        // crowds first: each takes in all that it meets at once, where the others would come to it one by one
        let mut order: Vec<(usize, (u32, Option<Surroundings>))> = seen.into_iter().enumerate().collect();
        order.sort_by_key(|(_, (_, seen))| seen.is_some());
        for (which, (version, seen)) in order {
            match seen {
                Some(Surroundings::Bystanders(bystanders)) if self.clusters[which].version == version => {
                    self.has_seen(which, bystanders);
                }
                _ => {
                    if !self.expand(which) {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Sorts the members into cells.
    fn sort(&mut self) {
        let spacing = (self.search.region.volume() / self.members.len().max(1) as f64).cbrt();
        // a bed fills a part of the domain only: cells of a third of the spacing are at most 27 for each member
        let edge = self.widest.max(if self.crowds { spacing / 3.0 } else { spacing });
        self.grid.sort(&self.members, |member| member.flight.middle, &self.search.region, edge, &mut self.sorted);
    }

    /// Notes that an island, as it is now, meets no other one.
    fn has_seen(&mut self, which: usize, bystanders: Vec<u32>) {
        let cluster = &mut self.clusters[which];
        cluster.bystanders = bystanders;
        cluster.seen = Some(cluster.version);
    }

    /// The cluster of a particle that touches at `time` [s], made if there is none, united with that of the other.
    fn join(&mut self, i: u32, j: Option<u32>, time: f64) -> usize {
        let mut which = self.cluster_of(i);
        if let Some(j) = j {
            let other = self.cluster_of(j);
            which = self.unite(which, other);
        }
        let cluster = &mut self.clusters[which];
        cluster.first = cluster.first.min(time);
        which
    }

    fn cluster_of(&mut self, place: u32) -> usize {
        if let Some(label) = self.search.label[place as usize] {
            return self.members[label.member()].cluster as usize;
        }
        let (which, member) = (self.clusters.len(), self.members.len() as u32);
        self.search.label[place as usize] = Some(Label::of(self.members.len()));
        let flight = self.search.flights[place as usize];
        let speed = (self.particles.velocity[place as usize] - self.frame).norm();
        self.members.push(Member { place, cluster: which as u32, flight, ball: flight, around: 0.0, took_in: 0.0 });
        self.clusters.push(Cluster {
            hot: vec![member],
            bystanders: Vec::new(),
            carried: Vec::new(),
            energies: [self.kinetic_energy(place), 0.0],
            speeds: [speed, 0.0],
            stored: 0.0,
            deepest: 0.0,
            floor: 0.0,
            first: self.part,
            lasts: false,
            alive: true,
            solved: None,
            version: 0,
            seen: None,
        });
        which
    }

    fn kinetic_energy(&self, place: u32) -> f64 {
        let i = place as usize;
        0.5 * self.particles.mass[i] * (self.particles.velocity[i] - self.frame).norm_squared()
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

    /// [m/s] how fast a hot particle may get: as fast as the two most energetic of its island could make it, or the two fastest, whichever
    /// is less. Both are bounds for two; among more they are rarely passed, and then the island is done again with a higher one.
    ///
    /// The two most energetic may give one particle all their energy. The two fastest, of speeds s₁ ≥ s₂, have a centre of mass that is not
    /// faster than s₁, and move at most at s₁ + s₂ relative to it: neither leaves at more than 2 s₁ + s₂. Energy E that a contact
    /// gives back adds at most √(2E/m) to that. It is the lesser bound for light particles among heavy ones.
    ///
    /// The contacts of a crowd hold far more energy together than any of its particles ever gets: there the two deepest count, and
    /// all are allowed the same.
    fn limit(&self, cluster: &Cluster, place: u32) -> f64 {
        let crowd = cluster.is_crowd();
        let stored = if crowd { 2.0 * cluster.deepest } else { cluster.stored };
        let mass = if crowd { self.lightest } else { self.particles.mass[place as usize] };
        let of_energy = (2.0 * (cluster.energies[0] + cluster.energies[1] + stored) / mass).sqrt();
        let of_momentum = 2.0 * cluster.speeds[0] + cluster.speeds[1] + (2.0 * stored / mass).sqrt();
        (of_energy.min(of_momentum) * MARGIN).max(cluster.floor) + self.fall
    }

    /// Works out how far the members of all islands reach. Each island looks at its own members only, and each member at its island, so the
    /// threads share them.
    fn settle_all(&mut self) {
        let mut clusters = std::mem::take(&mut self.clusters);
        clusters.par_iter_mut().with_min_len(TOGETHER).for_each(|cluster| self.put_in_order(cluster));
        self.clusters = clusters;
        let mut members = std::mem::take(&mut self.members);
        let reaches = members.par_iter_mut().with_min_len(TOGETHER).map(|member| self.reach_out(member));
        self.widest = reaches.reduce(|| self.widest, f64::max);
        self.members = members;
    }

    /// Works out how far the members of an island reach.
    fn settle(&mut self, which: usize) {
        let mut clusters = std::mem::take(&mut self.clusters);
        self.put_in_order(&mut clusters[which]);
        self.clusters = clusters;
        for number in 0..self.clusters[which].hot.len() {
            self.settle_member(self.clusters[which].hot[number]);
        }
    }

    /// Works out how far a member of an island reaches.
    fn settle_member(&mut self, member: u32) {
        let mut members = std::mem::take(&mut self.members);
        self.widest = self.widest.max(self.reach_out(&mut members[member as usize]));
        self.members = members;
    }

    /// Puts what an island holds in an order that does not depend on that of the store, or on who was united first, and sums up the energy of
    /// what is carried.
    fn put_in_order(&self, cluster: &mut Cluster) {
        cluster.hot.sort_unstable_by_key(|&member| self.particles.id[self.members[member as usize].place as usize]);
        cluster.carried.sort_unstable();
        let energies = || cluster.carried.iter().map(|&k| self.energy[k as usize]);
        (cluster.stored, cluster.deepest) = (energies().sum(), energies().fold(0.0, f64::max));
    }

    /// Works out the ball of a member of an island, and returns how far it reaches about the middle of its flight [m].
    fn reach_out(&self, member: &mut Member) -> f64 {
        let (cluster, i) = (&self.clusters[member.cluster as usize], member.place as usize);
        let first = cluster.first;
        let velocity = self.particles.velocity[i] - self.frame;
        let reach = self.particles.radius[i] + self.limit(cluster, member.place) * (self.part - first);
        member.ball = Spot { middle: self.domain.wrap(&(self.particles.position[i] + velocity * first)), reach };
        let aside = velocity.norm() * (first - 0.5 * self.part).abs() * (1.0 + 1e-12);
        member.around = member.flight.reach.max(reach + aside);
        member.around
    }

    /// Finds the bystanders of an island and unites it with islands that it may meet; false if it grows too large.
    fn expand(&mut self, which: usize) -> bool {
        let mut which = which;
        while self.clusters[which].alive && self.clusters[which].seen != Some(self.clusters[which].version) {
            self.settle(which);
            if self.crowds && self.clusters[which].is_crowd() {
                self.take_in_beside(which);
            }
            match self.look_around(which) {
                Surroundings::Bystanders(bystanders) => {
                    self.has_seen(which, bystanders);
                }
                Surroundings::Islands(others) => {
                    which = others.into_iter().fold(which, |which, other| self.unite(which, other));
                }
                Surroundings::TooLarge => return false,
            }
        }
        true
    }

    /// Finds the particles that are near enough to be hit by an island.
    fn look_around(&self, which: usize) -> Surroundings {
        let cluster = &self.clusters[which];
        if cluster.is_crowd() && !self.crowds {
            return Surroundings::TooLarge;
        }
        let mut bystanders = Vec::new();
        let mut met: Vec<usize> = Vec::new();
        let search = &*self.search;
        let largest_reach = search.levels.largest_reach();
        for &member in &cluster.hot {
            let here = self.members[member as usize].ball;
            // beyond half a period the nearest image is not the only one to meet
            if here.reach + self.widest.max(largest_reach) > self.half_period {
                return Surroundings::TooLarge;
            }
            let mut meet = |member: &Member| {
                if member.cluster != which as u32
                    && here.meets(&Spot { reach: member.around, ..member.flight }, self.domain)
                    && (here.meets(&member.flight, self.domain) || here.meets(&member.ball, self.domain))
                {
                    met.push(member.cluster as usize);
                }
            };
            self.grid.for_each_near(&here.middle, here.reach + self.widest, |range| {
                self.sorted[range].iter().for_each(|&other| meet(&self.members[other as usize]));
            });
            self.members[self.sorted.len()..].iter().for_each(meet);
            if let Some(&met) = met.last().filter(|_| !self.crowds) {
                return Surroundings::Islands(vec![met]);
            }
            search.for_each_beside(&here, self.domain, |other| {
                if search.label[other as usize].is_none() {
                    bystanders.push(other);
                }
            });
        }
        if !met.is_empty() {
            met.sort_unstable();
            met.dedup();
            return Surroundings::Islands(met);
        }
        bystanders.sort_unstable_by_key(|&place| self.particles.id[place as usize]);
        bystanders.dedup();
        Surroundings::Bystanders(bystanders)
    }

    /// Islands that are still to be solved: those of which all is seen that they may have to do with.
    pub fn unsolved(&self) -> Vec<usize> {
        let sight = self.reach().sight();
        let unsolved = self.clusters.iter().enumerate().filter(|(_, c)| c.alive && c.solved.is_none());
        unsolved.map(|(which, _)| which).filter(|&which| self.room(which) >= sight).collect()
    }

    /// What is carried into an island.
    pub fn carried(&self, which: usize) -> &[u32] {
        &self.clusters[which].carried
    }

    /// Notes where its result is.
    pub fn keep(&mut self, which: usize, result: Kept) {
        self.clusters[which].solved = Some(result);
    }

    /// Forgets the labels and says where the results are, in order.
    pub fn release(self) -> Vec<Kept> {
        for member in &self.members {
            self.search.label[member.place as usize] = None;
        }
        self.clusters.iter().filter_map(|cluster| cluster.solved).collect()
    }
}
