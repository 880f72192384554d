//! Who is near whom, kept up to date particle by particle.
//!
//! Each particle has a shell: a ball about the place where it was last looked at. It may move within it by a margin; those
//! are its neighbours whose shells overlap its own. Whoever leaves its shell gets a new one, and nobody else is touched.

use super::card::{Body, Card};
use crate::domain::Domain;
use crate::particles::CHUNK;
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Neighbours more than are found at first for which there is room.
const SPARE: u32 = 3;

/// Where a particle was looked at, and whom it had near.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Shell {
    /// [m] its centre, inside the box.
    pub centre: Vector3<f64>,
    /// Its neighbours are `near[first .. first + count]`; there is room for `room`.
    first: u32,
    count: u32,
    room: u32,
    /// Whether walls are near.
    pub at_wall: bool,
}

/// The shells of all particles.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Shells {
    /// [m] how far a particle may go from the centre of its shell.
    pub margin: f64,
    /// [m] all radii there are.
    pub radii: Vec<f64>,
    /// The neighbours of all.
    near: Vec<u32>,
    /// Shells made so far.
    pub renewed: u64,
    /// Distances computed.
    pub checks: u64,
    #[serde(skip)]
    cells: Cells,
    /// [m] the largest radius.
    #[serde(skip)]
    largest: f64,
    #[serde(skip)]
    found: Vec<u32>,
}

/// Cells over the domain with the shells' centres in them; they change hands one by one.
#[derive(Clone, Debug, Default)]
struct Cells {
    count: [usize; 3],
    periodic: [bool; 3],
    /// [1/m] cells per length.
    per_length: Vector3<f64>,
    /// [m] edges of the box, infinite where it is not periodic, and half of them.
    period: [f32; 3],
    half: [f32; 3],
    /// [m] what distances may be off by single precision.
    rounding: f32,
    members: Vec<Vec<Spot>>,
}

/// The centre of a shell [m], rounded, and whose it is.
#[derive(Clone, Copy, Debug)]
struct Spot {
    centre: [f32; 3],
    place: u32,
}

impl Spot {
    fn new(centre: &Vector3<f64>, place: u32) -> Self {
        Self { centre: [centre.x as f32, centre.y as f32, centre.z as f32], place }
    }
}

impl Cells {
    fn new(domain: &Domain, edge: f64, particles: usize) -> Self {
        // not many more cells than particles, however empty the box
        let most = (particles as f64).cbrt().ceil() + 3.0;
        let longest = (domain.volume().cbrt() / most).max(edge);
        let count = std::array::from_fn(|axis| {
            let fitting = (domain.size[axis] / longest).clamp(1.0, 4096.0) as usize;
            // with two periodic cells each would be the other's neighbour twice
            if domain.periodic[axis] && fitting < 3 { 1 } else { fitting }
        });
        Self {
            count,
            periodic: domain.periodic,
            per_length: Vector3::from_fn(|axis, _| count[axis] as f64 / domain.size[axis]),
            period: std::array::from_fn(|axis| domain.size[axis] as f32),
            half: std::array::from_fn(|axis| {
                if domain.periodic[axis] { 0.5 * domain.size[axis] as f32 } else { f32::INFINITY }
            }),
            // coordinates are rounded to 6e-8 of the box, and periods are
            rounding: 1e-6 * domain.size.max() as f32,
            members: vec![Vec::new(); count[0] * count[1] * count[2]],
        }
    }

    /// Outside an open side the nearest cell takes a position: clamping never parts neighbours.
    fn coordinates(&self, x: &Vector3<f64>) -> [usize; 3] {
        std::array::from_fn(|axis| ((x[axis] * self.per_length[axis]) as usize).min(self.count[axis] - 1))
    }

    fn of(&self, x: &Vector3<f64>) -> usize {
        let c = self.coordinates(x);
        c[0] + self.count[0] * (c[1] + self.count[1] * c[2])
    }

    /// Up to three coordinates along an axis: a cell and those beside it.
    fn beside(&self, axis: usize, at: usize) -> ([usize; 3], usize) {
        let n = self.count[axis];
        if n == 1 {
            return ([0; 3], 1);
        }
        let mut list = ([at; 3], 1);
        let mut put = |c: usize| {
            list.0[list.1] = c;
            list.1 += 1;
        };
        match at {
            0 if self.periodic[axis] => put(n - 1),
            0 => {}
            _ => put(at - 1),
        }
        match at + 1 {
            next if next < n => put(next),
            _ if self.periodic[axis] => put(0),
            _ => {}
        }
        list
    }

    /// Calls `visit` with all places whose centres may be within `reach` [m] of `centre`, at most an edge; returns how many were
    /// looked at.
    #[inline]
    fn for_each_near(&self, centre: &Vector3<f64>, reach: f64, mut visit: impl FnMut(u32)) -> u64 {
        let at = self.coordinates(centre);
        let [(xs, nx), (ys, ny), (zs, nz)] = std::array::from_fn(|axis| self.beside(axis, at[axis]));
        let here = Spot::new(centre, 0).centre;
        let reach = reach as f32 + self.rounding;
        let square = reach * reach;
        let mut checks = 0;
        for &z in &zs[..nz] {
            for &y in &ys[..ny] {
                for &x in &xs[..nx] {
                    let members = &self.members[x + self.count[0] * (y + self.count[1] * z)];
                    checks += members.len() as u64;
                    for spot in members {
                        let apart = |axis: usize| {
                            let d = (spot.centre[axis] - here[axis]).abs();
                            if d > self.half[axis] { self.period[axis] - d } else { d }
                        };
                        let [dx, dy, dz] = [apart(0), apart(1), apart(2)];
                        if dx * dx + dy * dy + dz * dz <= square {
                            visit(spot.place);
                        }
                    }
                }
            }
        }
        checks
    }
}

impl Shell {
    /// How many neighbours it has.
    #[inline]
    pub fn count(&self) -> u32 {
        self.count
    }
}

impl Shells {
    /// Shells about all bodies where they are, inside the box.
    pub fn build(&mut self, cards: &mut [Card], bodies: &[Body], domain: &Domain, at_wall: &[bool]) {
        for ((card, body), &at_wall) in cards.iter_mut().zip(bodies).zip(at_wall) {
            card.shell = Shell { centre: body.position, at_wall, ..Shell::default() };
        }
        self.fill_cells(cards, domain);
        let (this, all) = (&*self, &*cards);
        let look = |chunk: usize| {
            let places = chunk * CHUNK..((chunk + 1) * CHUNK).min(bodies.len());
            let (mut lists, mut counts, mut checks) = (Vec::new(), Vec::new(), 0);
            for i in places {
                let before = lists.len();
                checks += this.look_around(i as u32, all, bodies, domain, |j| lists.push(j));
                counts.push((lists.len() - before) as u32);
            }
            (lists, counts, checks)
        };
        let parts: Vec<(Vec<u32>, Vec<u32>, u64)> =
            (0..bodies.len().div_ceil(CHUNK)).into_par_iter().map(look).collect();
        self.near.clear();
        let mut cards = cards.iter_mut();
        for (lists, counts, checks) in parts {
            self.checks += checks;
            let mut lists = lists.as_slice();
            for (count, card) in counts.into_iter().zip(&mut cards) {
                let (own, rest) = lists.split_at(count as usize);
                lists = rest;
                let (first, room) = (self.near.len() as u32, count + SPARE);
                self.near.extend_from_slice(own);
                self.near.resize((first + room) as usize, 0);
                (card.shell.first, card.shell.count, card.shell.room) = (first, count, room);
            }
        }
        self.renewed += bodies.len() as u64;
    }

    /// Puts the centres in cells: what is not stored of the shells.
    pub fn fill_cells(&mut self, cards: &[Card], domain: &Domain) {
        self.largest = self.radii.iter().fold(0.0, |most: f64, radius| most.max(*radius));
        self.cells = Cells::new(domain, 2.0 * (self.largest + self.margin), cards.len());
        for (place, card) in cards.iter().enumerate() {
            let cell = self.cells.of(&card.shell.centre);
            self.cells.members[cell].push(Spot::new(&card.shell.centre, place as u32));
        }
    }

    /// [m] the radius of a body.
    #[inline]
    pub fn radius(&self, body: &Body) -> f64 {
        self.radii[body.kind as usize]
    }

    /// Whom a shell has near.
    #[inline]
    pub fn neighbours(&self, shell: &Shell) -> &[u32] {
        &self.near[shell.first as usize..(shell.first + shell.count) as usize]
    }

    /// Calls `found` with all whose shells overlap that of `i`, and some that nearly do; returns how many were looked at.
    fn look_around(&self, i: u32, cards: &[Card], bodies: &[Body], domain: &Domain, mut found: impl FnMut(u32)) -> u64 {
        let (centre, radius) = (cards[i as usize].shell.centre, self.radius(&bodies[i as usize]));
        let farthest = radius + self.largest + 2.0 * self.margin;
        let alike = self.radii.len() == 1;
        self.cells.for_each_near(&centre, farthest, |j| {
            let near = || {
                let reach = radius + self.radius(&bodies[j as usize]) + 2.0 * self.margin;
                domain.separation(&centre, &cards[j as usize].shell.centre).norm_squared() < reach * reach
            };
            if j != i && (alike || near()) {
                found(j);
            }
        })
    }

    /// Gives particle `i` a new shell about where it is, inside the box.
    pub fn renew(&mut self, i: u32, cards: &mut [Card], bodies: &[Body], domain: &Domain, at_wall: bool) {
        let shell = cards[i as usize].shell;
        let centre = bodies[i as usize].position;
        let (from, to) = (self.cells.of(&shell.centre), self.cells.of(&centre));
        cards[i as usize].shell = Shell { centre, at_wall, ..shell };
        self.cells.members[from].retain(|spot| spot.place != i);
        self.cells.members[to].push(Spot::new(&centre, i));
        let mut found = std::mem::take(&mut self.found);
        found.clear();
        self.checks += self.look_around(i, cards, bodies, domain, |j| found.push(j));
        // most stay: only who comes and who goes is told
        for k in shell.first..shell.first + shell.count {
            let j = self.near[k as usize];
            if !found.contains(&j) {
                self.remove(&mut cards[j as usize].shell, i);
            }
        }
        let old = shell.first as usize..(shell.first + shell.count) as usize;
        for &j in &found {
            if !self.near[old.clone()].contains(&j) {
                self.add(&mut cards[j as usize].shell, i);
            }
        }
        let count = found.len() as u32;
        let shell = &mut cards[i as usize].shell;
        if count > shell.room {
            (shell.first, shell.room) = (self.near.len() as u32, 2 * count);
            self.near.resize((shell.first + shell.room) as usize, 0);
        }
        shell.count = count;
        self.near[shell.first as usize..(shell.first + count) as usize].copy_from_slice(&found);
        self.found = found;
        self.renewed += 1;
    }

    fn remove(&mut self, shell: &mut Shell, i: u32) {
        let list = &mut self.near[shell.first as usize..(shell.first + shell.count) as usize];
        if let Some(k) = list.iter().position(|&other| other == i) {
            list.swap(k, shell.count as usize - 1);
            shell.count -= 1;
        }
    }

    fn add(&mut self, shell: &mut Shell, i: u32) {
        if shell.count == shell.room {
            // to the end, where there is room for twice as many
            let old = shell.first as usize..(shell.first + shell.count) as usize;
            shell.first = self.near.len() as u32;
            shell.room = 2 * shell.room + SPARE;
            self.near.extend_from_within(old);
            self.near.resize((shell.first + shell.room) as usize, 0);
        }
        self.near[(shell.first + shell.count) as usize] = i;
        shell.count += 1;
    }

    /// The same with all lists in ascending order and without gaps between them, and the cards that go with them: what is stored must
    /// not depend on how it came about.
    pub fn tidy(&self, cards: &[Card]) -> (Self, Vec<Card>) {
        let (mut near, mut cards) = (Vec::new(), cards.to_vec());
        for Card { shell, .. } in &mut cards {
            let first = near.len();
            near.extend_from_slice(self.neighbours(shell));
            near[first..].sort_unstable();
            (shell.first, shell.room) = (first as u32, shell.count);
        }
        let radii = self.radii.clone();
        let Self { margin, renewed, checks, .. } = *self;
        (Self { margin, radii, near, renewed, checks, ..Self::default() }, cards)
    }
}
