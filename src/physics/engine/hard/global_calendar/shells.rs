//! Neighbour lists that are updated separately for each particle.
//!
//! Each particle has a shell, a ball about its position when its list was last updated. The particle may move by a
//! margin, the radius of this ball, before it leaves its shell. Its neighbours are the particles that it may touch
//! while both stay in their shells; the shells then *overlap*. A particle that leaves its shell gets a new one, while
//! the other shells stay.

use super::cells::{ROUNDING, ShellGrid, rounded, widened};
use super::division::Division;
use super::list_pool::{ListPool, room_for, size};
use super::next_events::{FlightState, NextEvents};
use super::search::{Lists, has_images};
use crate::domain::Domain;
use crate::particles::CHUNK;
use nalgebra::Vector3;
use prefetch_index::prefetch_index;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Shell of a particle (a ball in which its neighbour list is valid), and the location of its neighbour list.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Shell {
    /// Centre [m] of the shell, inside the box; in single precision, as in the grid of cells.
    centre: [f32; 3],
    /// Location of the list in `Shells::near`: the neighbours are `near[first .. first + count]`. `room` is the size
    /// number of the memory block that starts at `first`.
    first: u32,
    count: u32,
    room: u8,
    /// True if the particle may touch a wall before it leaves the shell.
    pub at_wall: bool,
    /// True if the particle may have neighbours in another part of the particles, whose events another thread
    /// processes.
    pub at_border: bool,
    /// True if a periodic image of a neighbour may be nearer than the neighbour itself. Flights may lead out of the
    /// box, so this does not follow from the centre of the shell.
    pub across: bool,
}

/// Class of particles: a combination of radius and mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RadiusClass {
    /// [m] radius of each particle of the class.
    pub radius: f64,
    /// [kg] mass of each particle of the class.
    pub mass: f64,
}

/// Grid with the shells of all particles in a range of radii, in which the largest radius is at most twice the
/// smallest. A single grid for all sizes would have very many small particles in each cell.
#[derive(Clone, Debug)]
pub struct ShellLevel {
    pub cells: ShellGrid,
    /// [m] smallest radius of the particles in this grid.
    pub smallest: f64,
    /// [m] largest radius of the particles in this grid.
    pub largest: f64,
}

/// The shells of all particles (balls in which neighbour lists are valid), with the lists.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Shells {
    /// [m] margin: distance that a particle may move from the centre of its shell (ball in which its neighbour list is
    /// valid) before it needs a new list.
    pub margin: f64,
    /// All different combinations of radius and mass, in ascending order; `FlightState::kind` is an index of this list.
    pub kinds: Vec<RadiusClass>,
    /// Memory of all neighbour lists. Unused entries of a list contain the index of the particle to which the list
    /// belongs.
    near: Vec<u32>,
    /// Number of shells (balls in which neighbour lists are valid) made since the start of the run.
    pub renewed: u64,
    /// Number of distances between shells computed since the start of the run.
    pub checks: u64,
    /// Grids with the centres of shells, one for each range of radii, in ascending order.
    #[serde(skip)]
    pub levels: Vec<ShellLevel>,
    /// Largest radius [m] of any particle.
    #[serde(skip)]
    largest: f64,
    /// Smallest radius [m] of any particle.
    #[serde(skip)]
    smallest: f64,
    #[serde(skip)]
    found: Vec<u32>,
    /// Mark of each particle, by which an update of a neighbour list distinguishes old from new neighbours. It is twice
    /// the number (modulo 2³¹) of the last update in which the particle was an old neighbour. One is added if the
    /// particle stays a neighbour in that update.
    #[serde(skip)]
    marks: Vec<u32>,
    /// Free memory blocks between the neighbour lists, which other lists may use.
    #[serde(skip)]
    free: ListPool,
    /// Division of the particles into parts with consecutive indices, one part for each thread.
    #[serde(skip)]
    pub parts: Division,
}

/// Inverse of the fraction of memory that is reserved for growth of the neighbour lists: a fifth is added. After a
/// random start the lists become longer by a fifth or less in dense scenes. Without reserved memory all lists might
/// have to be copied. Reserved memory that is never written takes no space.
const SPARE: usize = 5;

/// Inverse of the fraction by which the memory of all neighbour lists grows when it is full: it grows by 1/16.
const MORE: usize = 16;

/// Number of indices in a cache line of 64 bytes.
const PER_LINE: usize = 16;

impl Shell {
    /// Centre [m] of the shell, the ball in which the neighbour list of a particle is valid.
    #[inline]
    pub fn centre(&self) -> Vector3<f64> {
        widened(&self.centre)
    }

    #[inline]
    pub fn count(&self) -> u32 {
        self.count
    }
}

impl Shells {
    /// Makes the shells and the neighbour lists of all particles, whose positions [m] must be inside the box. `at_wall`
    /// is true, by index, for the particles that may touch a wall within their shell.
    pub fn build(&mut self, next_events: &mut [NextEvents], bodies: &[FlightState], domain: &Domain, at_wall: &[bool]) {
        for ((entry, body), &at_wall) in next_events.iter_mut().zip(bodies).zip(at_wall) {
            entry.shell = Shell { centre: rounded(&body.position), at_wall, ..Shell::default() };
        }
        self.fill_cells(next_events, bodies, domain);
        self.near.clear();
        self.free.clear();
        let chunks = bodies.len().div_ceil(CHUNK);
        // a few chunks of particles at a time, so that most lists are stored only once in memory
        let batch = rayon::current_num_threads();
        for first in (0..chunks).step_by(batch) {
            let last = chunks.min(first + batch);
            let (this, all) = (&*self, &*next_events);
            let look = |chunk: usize| {
                let indices = chunk * CHUNK..((chunk + 1) * CHUNK).min(bodies.len());
                this.look_around_each(indices.map(|index| index as u32), all, bodies, (domain, 0.0))
            };
            let parts: Vec<Lists> = (first..last).into_par_iter().map(look).collect();
            self.reserve(&parts, (last * CHUNK).min(bodies.len()), bodies.len());
            for (chunk, lists) in (first..last).zip(parts) {
                self.hand_out(lists, chunk * CHUNK, next_events);
            }
        }
        self.renewed += bodies.len() as u64;
    }

    /// Updates `Shell::across` of each particle: true if a periodic image of a neighbour may be nearer than the
    /// neighbour itself. This is needed after flights have been shifted by whole periods. `now` [s] is the present
    /// time.
    pub fn find_images(&self, next_events: &mut [NextEvents], bodies: &[FlightState], domain: &Domain, now: f64) {
        for (index, NextEvents { shell, .. }) in (0..).zip(next_events) {
            shell.across = has_images(index, self.neighbours(shell), bodies, (domain, now));
        }
    }

    /// Frees the memory of all lists and cells, before these are made again.
    pub fn forget(&mut self) {
        (self.near, self.levels) = (Vec::new(), Vec::new());
        self.free.clear();
    }

    /// Reserves memory for the neighbour lists in `parts`. With these, the first `known` particles have lists. If
    /// memory must grow, it is made large enough for all `count` particles, by extrapolation.
    fn reserve(&mut self, parts: &[Lists], known: usize, count: usize) {
        let room: usize =
            parts.iter().flat_map(|lists| &lists.counts).map(|&count| size(room_for(count)) as usize).sum();
        let all = self.near.len() + room;
        if all > self.near.capacity() {
            let foreseen = (all as f64 * (count as f64 / known as f64)).ceil() as usize;
            self.near.reserve_exact(foreseen + foreseen / SPARE - self.near.len());
        }
    }

    /// Copies the neighbour lists of consecutive particles to the end of `near`, the memory of all lists. The first
    /// particle has the index `first`. The place of each list is written to the entry of its particle in `next_events`.
    fn hand_out(&mut self, lists: Lists, first: usize, next_events: &mut [NextEvents]) {
        self.checks += lists.checks;
        for ((index, entry), (own, across)) in (first as u32..).zip(&mut next_events[first..]).zip(lists.each()) {
            let count = own.len() as u32;
            let (first, room) = (self.near.len() as u32, room_for(count));
            self.near.extend_from_slice(own);
            self.near.resize((first + size(room)) as usize, index);
            (entry.shell.first, entry.shell.count, entry.shell.room) = (first, count, room);
            entry.shell.across = across;
        }
    }

    /// Makes the grids of cells and sorts the centres of all shells into them. Snapshots of a run do not contain the
    /// grids, so the grids are also made when a run is resumed.
    pub fn fill_cells(&mut self, next_events: &[NextEvents], bodies: &[FlightState], domain: &Domain) {
        self.largest = self.kinds.iter().fold(0.0, |most: f64, kind| most.max(kind.radius));
        self.smallest = self.kinds.iter().fold(f64::INFINITY, |least: f64, kind| least.min(kind.radius));
        let mut ranges: Vec<[f64; 2]> = Vec::new();
        // kinds are in ascending order of radius
        for RadiusClass { radius, .. } in &self.kinds {
            match ranges.last_mut() {
                Some([smallest, largest]) if *radius <= 2.0 * *smallest => *largest = *radius,
                _ => ranges.push([*radius; 2]),
            }
        }
        let level = |[smallest, largest]: [f64; 2]| {
            let cells = ShellGrid::new(domain, 2.0 * (largest + self.margin), next_events.len());
            ShellLevel { cells, smallest, largest }
        };
        self.levels = ranges.into_iter().map(level).collect();
        for (index, (entry, body)) in next_events.iter().zip(bodies).enumerate() {
            let level = self.level(body);
            self.levels[level].cells.put(index as u32, entry.shell.centre);
        }
    }

    /// Number of the grid of shells to which a particle belongs by its radius; grid 0 is for the smallest radii.
    #[inline]
    fn level(&self, body: &FlightState) -> usize {
        let radius = self.radius(body);
        self.levels.iter().take_while(|level| level.largest < radius).count()
    }

    /// True if a shell is so near to a sheared side of the box that its particle may have neighbours across that side.
    pub fn is_at_sheared_side(&self, shell: &Shell, domain: &Domain) -> bool {
        if domain.shear.is_none() {
            return false;
        }
        let (y, reach) = (f64::from(shell.centre[1]), self.search_radius(domain));
        !(reach..domain.size.y - reach).contains(&y)
    }

    /// [m] distance between the centres of two shells beyond which they are never neighbours, whatever the radii of
    /// their particles; rounding is allowed for.
    pub fn search_radius(&self, domain: &Domain) -> f64 {
        2.0 * (self.largest + self.margin) + 2.0 * ROUNDING * domain.size.max()
    }

    /// Largest radius [m] of any particle.
    #[inline]
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// True if all particles of the run have equal radii.
    #[inline]
    pub fn alike(&self) -> bool {
        self.smallest == self.largest
    }

    /// Radius [m] of the particle with the flight `body`, from the list of all combinations of radius and mass.
    #[inline]
    pub fn radius(&self, body: &FlightState) -> f64 {
        self.kinds[body.kind as usize].radius
    }

    /// Mass [kg] of the particle with the flight `body`, from the list of all combinations of radius and mass.
    #[inline]
    pub fn mass(&self, body: &FlightState) -> f64 {
        self.kinds[body.kind as usize].mass
    }

    /// Indices of the neighbours of the particle to which `shell` belongs.
    #[inline]
    pub fn neighbours(&self, shell: &Shell) -> &[u32] {
        &self.near[shell.first as usize..(shell.first + shell.count) as usize]
    }

    /// Indices of the neighbours of the particle to which `shell` belongs, in groups of four. If the last group is not
    /// full, the index of the particle itself fills it.
    #[inline]
    pub fn in_fours(&self, shell: &Shell) -> &[[u32; 4]] {
        let end = shell.first + shell.count.next_multiple_of(4);
        self.near[shell.first as usize..end as usize].as_chunks().0
    }

    /// Prefetches the neighbour list of `shell` into the processor's cache.
    #[inline]
    pub fn fetch_list(&self, shell: &Shell) {
        let (first, last) = (shell.first as usize, (shell.first + shell.count.saturating_sub(1)) as usize);
        (first..last).step_by(PER_LINE).chain([last]).for_each(|at| prefetch_index(&self.near, at));
    }

    /// Makes a new shell about the point `centre` [m] for particle `i`. The point must be inside the box. Updates the
    /// neighbour lists of `i`, of its old neighbours and of its new ones. `at_wall` is true if the particle may touch a
    /// wall within its new shell.
    pub fn update_neighbour_list(
        &mut self,
        i: u32,
        (centre, at_wall): (&Vector3<f64>, bool),
        next_events: &mut [NextEvents],
        bodies: &[FlightState],
        (domain, now): (&Domain, f64),
    ) {
        self.recentre(i, (centre, at_wall), next_events, bodies);
        let mut found = std::mem::take(&mut self.found);
        found.clear();
        self.checks += self.look_around(i, next_events, bodies, domain, &mut found);
        let across = has_images(i, &found, bodies, (domain, now));
        self.relink(i, (&found, across), next_events, bodies, (domain, now));
        self.found = found;
    }

    /// Moves the shell of particle `i` to the point `centre` [m] inside the box; its neighbour list must be made again.
    /// `at_wall` is true if the particle may touch a wall within the shell.
    pub fn recentre(
        &mut self,
        i: u32,
        (centre, at_wall): (&Vector3<f64>, bool),
        next_events: &mut [NextEvents],
        bodies: &[FlightState],
    ) {
        let level = self.level(&bodies[i as usize]);
        let shell = &mut next_events[i as usize].shell;
        let centre = rounded(centre);
        self.levels[level].cells.change(i, shell.centre, centre);
        *shell = Shell { centre, at_wall, ..*shell };
    }

    /// Makes the particles in `found` the neighbours of particle `i`, and updates the lists of its old and of its new
    /// neighbours. `across` is true if a periodic image of one particle in `found` may be nearer than that particle
    /// itself.
    pub fn relink(
        &mut self,
        i: u32,
        (found, across): (&[u32], bool),
        next_events: &mut [NextEvents],
        bodies: &[FlightState],
        (domain, now): (&Domain, f64),
    ) {
        let shell = next_events[i as usize].shell;
        // most neighbours stay neighbours, so only the lists of new and of lost neighbours are changed
        self.marks.resize(next_events.len(), 0);
        let was_near = 2 * ((self.renewed + 1) as u32 & (u32::MAX >> 1));
        if was_near == 0 {
            self.marks.fill(1);
        }
        for k in shell.first..shell.first + shell.count {
            self.marks[self.near[k as usize] as usize] = was_near;
        }
        let own = self.parts.of(i);
        let mut at_border = false;
        for &j in found {
            let is_foreign = !own.contains(&j);
            at_border |= is_foreign;
            if self.marks[j as usize] == was_near {
                self.marks[j as usize] = was_near + 1;
            } else {
                let other = &mut next_events[j as usize].shell;
                self.add(other, j, i);
                other.at_border |= is_foreign;
                other.across |= across && has_images(i, &[j], bodies, (domain, now));
            }
        }
        for k in shell.first..shell.first + shell.count {
            let j = self.near[k as usize];
            if self.marks[j as usize] == was_near {
                self.remove(&mut next_events[j as usize].shell, j, i);
            }
        }
        let count = found.len() as u32;
        let shell = &mut next_events[i as usize].shell;
        // moves also to a smaller memory block (room): otherwise every room would stay as large as its longest list so
        // far, and small rooms would remain unused
        let wanted = room_for(count);
        if wanted != shell.room {
            *shell = self.moved(shell, wanted);
        }
        (shell.count, shell.at_border, shell.across) = (count, at_border, across);
        let room = size(shell.room) as usize;
        let (own, free) = self.near[shell.first as usize..][..room].split_at_mut(found.len());
        own.copy_from_slice(found);
        free.fill(i);
        self.renewed += 1;
    }

    /// Returns the shell with another memory block for its list: a free one with the size number `room`, or a new one
    /// at the end of the memory. The old block becomes free; the new one still has arbitrary content.
    fn moved(&mut self, shell: &Shell, room: u8) -> Shell {
        self.free.give(shell.room, shell.first);
        let first = self.free.take(room).unwrap_or_else(|| {
            let (first, more) = (self.near.len(), size(room) as usize);
            if self.near.capacity() < first + more {
                // reserves less than the default growth, which would double the capacity
                self.near.reserve_exact(more.max(first / MORE));
            }
            self.near.resize(first + more, 0);
            first as u32
        });
        Shell { first, room, ..*shell }
    }

    /// Removes particle `j` from the neighbour list of particle `i`; `shell` is the shell of `i`.
    fn remove(&mut self, shell: &mut Shell, i: u32, j: u32) {
        let list = &mut self.near[shell.first as usize..(shell.first + shell.count) as usize];
        if let Some(k) = list.iter().position(|&other| other == j) {
            let last = list.len() - 1;
            list.swap(k, last);
            list[last] = i;
            shell.count -= 1;
        }
    }

    /// Adds particle `j` to the neighbour list of particle `i`; `shell` is the shell of `i`.
    fn add(&mut self, shell: &mut Shell, i: u32, j: u32) {
        if shell.count == size(shell.room) {
            let old = shell.first as usize..(shell.first + shell.count) as usize;
            *shell = self.moved(shell, shell.room + 1);
            let first = shell.first as usize;
            self.near.copy_within(old, first);
            self.near[first + shell.count as usize..first + size(shell.room) as usize].fill(i);
        }
        self.near[(shell.first + shell.count) as usize] = j;
        shell.count += 1;
    }

    /// Returns a copy of the shells, and of `next_events` with the new locations of the lists. In the copy all lists
    /// are sorted and follow one another without gaps. Stored data then do not depend on the order in which lists were
    /// built.
    pub fn tidy(&self, next_events: &[NextEvents]) -> (Self, Vec<NextEvents>) {
        let (mut near, mut next_events) = (Vec::new(), next_events.to_vec());
        for (index, NextEvents { shell, .. }) in (0..).zip(&mut next_events) {
            let first = near.len();
            near.extend_from_slice(self.neighbours(shell));
            near[first..].sort_unstable();
            (shell.first, shell.room) = (first as u32, room_for(shell.count));
            near.resize(first + size(shell.room) as usize, index);
        }
        let kinds = self.kinds.clone();
        let Self { margin, renewed, checks, .. } = *self;
        (Self { margin, kinds, near, renewed, checks, ..Self::default() }, next_events)
    }
}
