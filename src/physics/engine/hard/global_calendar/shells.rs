//! Neighbour lists that are updated separately for each particle.
//!
//! Each particle has a shell, a ball about its position when its list was last updated. The particle may move by a
//! margin, the radius of this ball, before it leaves its shell. Its neighbours are the particles that it may touch
//! while both stay in their shells; the shells then *overlap*. A particle that leaves its shell gets a new one, while
//! the other shells stay.

use super::cells::{ROUNDING, ShellGrid, rounded, widened};
use super::division::Division;
use super::neighbour_lists::{NeighbourLists, lists_of, lists_of_mut};
use super::next_events::{FlightState, NextEvents, ParticleRange};
use super::search::FoundNeighbours;
use super::territories::Territories;
use crate::domain::Domain;
use crate::particles::CHUNK;
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Shell of a particle (a ball in which its neighbour list is valid), and the location of its neighbour list.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Shell {
    /// Centre [m] of the shell, inside the box. It is stored in single precision, as in the grid of cells.
    centre: [f32; 3],
    /// Location of the particle's neighbour list in `NeighbourLists::near`: the neighbours are `near[first .. first +
    /// count]`. `room` is the size number of the memory block that starts at `first`.
    pub(super) first: u32,
    pub(super) count: u32,
    pub(super) room: u8,
    /// True if the particle may touch a wall before it leaves this shell (ball in which its neighbour list is valid).
    pub at_wall: bool,
    /// True if a particle of another part may be a neighbour of this particle. A part is the group of particles whose
    /// events one thread processes.
    pub at_border: bool,
    /// True if the prediction of touches must look for the nearest periodic image of each neighbour (its copy, shifted
    /// by an edge of the box). False if every neighbour itself is nearest. This is stored because it follows from the
    /// positions of the flights, which may be outside the box, and not from the centre of the shell, which is inside.
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

/// Grid of cells with the shells (balls in which neighbour lists are valid) of all particles in a range of radii. The
/// largest radius of the range is at most twice the smallest. A single grid for all sizes would have very many small
/// particles in each cell.
#[derive(Clone, Debug)]
pub struct ShellLevel {
    pub cells: ShellGrid,
    /// [m] smallest radius of the particles in this grid.
    pub smallest: f64,
    /// [m] largest radius of the particles in this grid.
    pub largest: f64,
}

/// The shells of all particles: balls in which neighbour lists are valid.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Shells {
    /// [m] margin: distance that a particle may move from the centre of its shell (ball in which its neighbour list is
    /// valid) before it needs a new list.
    pub margin: f64,
    /// All different combinations of radius and mass, in ascending order; `FlightState::kind` is an index of this list.
    pub kinds: Vec<RadiusClass>,
    /// Grids of cells with the centres of shells (balls in which neighbour lists are valid), one for each range of
    /// radii, in ascending order.
    #[serde(skip)]
    pub levels: Vec<ShellLevel>,
    /// Largest radius [m] of any particle.
    #[serde(skip)]
    largest: f64,
    /// Smallest radius [m] of any particle.
    #[serde(skip)]
    smallest: f64,
    /// Division of the particles into parts with consecutive indices, one part for each thread.
    #[serde(skip)]
    pub parts: Division,
    /// For each thread, the cells in which it may give particles new shells (balls in which neighbour lists are valid)
    /// while the other threads process events. Empty if there are several grids, for particles of very different radii.
    #[serde(skip)]
    pub territories: Territories,
}

impl Shell {
    /// Makes a shell (ball in which a neighbour list is valid) about the point `centre` [m] inside the box, with the
    /// present location of the neighbour list. `at_wall` is true if the particle may touch a wall within the shell.
    pub fn about(&self, centre: [f32; 3], at_wall: bool) -> Self {
        Self { centre, at_wall, ..*self }
    }

    /// Centre [m] of the shell (ball in which the neighbour list is valid) in single precision, as it is stored.
    #[inline]
    pub fn rounded_centre(&self) -> [f32; 3] {
        self.centre
    }

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
    /// Makes the shells (balls in which neighbour lists are valid) and the neighbour lists of all particles, whose
    /// positions [m] must be inside the box. `at_wall` is true, by index, for the particles that may touch a wall
    /// within their shell. Returns the lists of each part (particles of one thread), and the number of distances
    /// between shells that were computed.
    pub fn build(
        &mut self,
        next_events: &mut [NextEvents],
        bodies: &[FlightState],
        domain: &Domain,
        at_wall: &[bool],
    ) -> (Vec<NeighbourLists>, u64) {
        for ((entry, body), &at_wall) in next_events.iter_mut().zip(bodies).zip(at_wall) {
            entry.shell = Shell { centre: rounded(&body.position), at_wall, ..Shell::default() };
        }
        self.fill_cells(next_events, bodies, domain);
        let (mut lists, mut checks) = (vec![NeighbourLists::default(); self.parts.count()], 0);
        let chunks = bodies.len().div_ceil(CHUNK);
        // a few chunks of particles at a time, so that most lists are stored only once in memory
        let batch = rayon::current_num_threads();
        for first in (0..chunks).step_by(batch) {
            let last = chunks.min(first + batch);
            let (this, all) = (&*self, ParticleRange { first: 0, bodies, next_events });
            let search = |chunk: usize| {
                let indices = chunk * CHUNK..((chunk + 1) * CHUNK).min(bodies.len());
                this.neighbours_of_each(indices.map(|index| index as u32), all, (domain, 0.0))
            };
            let found: Vec<FoundNeighbours> = (first..last).into_par_iter().map(search).collect();
            for (chunk, found) in (first..last).zip(found) {
                checks += found.checks;
                self.store(&found, chunk * CHUNK, &mut lists, next_events);
            }
        }
        (lists, checks)
    }

    /// Stores the neighbour lists `found` of consecutive particles, the first of which has the index `first`, behind
    /// the present lists of their parts (particles of one thread). The location of each list is written to the entry of
    /// its particle in `next_events`.
    fn store(
        &self,
        found: &FoundNeighbours,
        first: usize,
        lists: &mut [NeighbourLists],
        next_events: &mut [NextEvents],
    ) {
        let all = next_events.len();
        let (mut start, end, mut each) = (first, first + found.counts.len(), found.each());
        while start < end {
            let part = self.parts.of(start as u32);
            let [first_of_part, end_of_part] = [part.start as usize, (part.end as usize).min(all)];
            let (last, own) = (end.min(end_of_part), lists_of_mut(lists, &self.parts, start as u32));
            let counts = found.counts[start - first..last - first].iter().copied();
            own.reserve(counts, last - first_of_part, end_of_part - first_of_part);
            for (index, (list, across)) in (start..last).zip(&mut each) {
                let shell = &mut next_events[index].shell;
                own.append(index as u32, list, shell);
                shell.across = across;
            }
            start = last;
        }
    }

    /// Makes the grids of cells, and sorts the centres of all shells (balls in which neighbour lists are valid) into
    /// the cells. Snapshots of a run do not contain the grids, so the grids are also made when a run is resumed.
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

    /// Number of the grid (in `levels`) to which a particle belongs by its radius; grid 0 is for the smallest radii.
    #[inline]
    pub fn level(&self, body: &FlightState) -> usize {
        let radius = self.radius(body);
        self.levels.iter().take_while(|level| level.largest < radius).count()
    }

    /// Divides the cells among the parts (particles of one thread). Each thread may give particles new shells (balls in
    /// which neighbour lists are valid) in the cells of its part.
    pub fn divide_cells(&mut self, next_events: &[NextEvents]) {
        // with several grids, a cell of one grid may be in the territories of two parts
        self.territories = match self.levels.as_slice() {
            [level] => Territories::of(&level.cells, &self.parts, next_events),
            _ => Territories::default(),
        };
    }

    /// True if a thread may move the shell of particle `index` from the point `old` [m] to the point `new` [m], while
    /// other threads process the events of their particles. A shell is the ball in which a neighbour list is valid.
    pub fn may_move(&self, index: u32, [old, new]: [&[f32; 3]; 2]) -> bool {
        matches!(self.levels.as_slice(), [level] if self.territories.allow(index, &self.parts, &level.cells, [old, new]))
    }

    /// Notes that the shell (ball in which the neighbour list is valid) of particle `index` has been moved to the point
    /// `centre` [m]. If the cell at this point does not belong to the particle's part (particles of one thread), no
    /// thread may make new shells there until the cells are divided anew.
    pub fn note_move(&mut self, index: u32, centre: &[f32; 3]) {
        if let [level] = self.levels.as_slice() {
            self.territories.enter(index, &self.parts, &level.cells, centre);
        }
    }

    /// True if a particle may have neighbours across a sheared side of the box, because its shell is near that side. A
    /// shell is the ball in which a neighbour list is valid.
    pub fn is_at_sheared_side(&self, shell: &Shell, domain: &Domain) -> bool {
        if domain.shear.is_none() {
            return false;
        }
        let (y, reach) = (f64::from(shell.centre[1]), self.search_radius(domain));
        !(reach..domain.size.y - reach).contains(&y)
    }

    /// [m] largest distance between the centres of the shells of two neighbours (balls in which their neighbour lists
    /// are valid), for any radii of the particles. It allows for rounding errors.
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

    /// Returns copies of all neighbour lists, for the given division of the particles among threads, and a copy of
    /// `next_events` with the new locations of the lists. In the copy all lists are sorted and follow one another
    /// without gaps. Stored data then do not depend on the order in which lists were built.
    pub fn copy_lists(
        &self,
        lists: &[NeighbourLists],
        division: &Division,
        next_events: &[NextEvents],
    ) -> (Vec<NeighbourLists>, Vec<NextEvents>) {
        let (mut copies, mut next_events) = (vec![NeighbourLists::default(); division.count()], next_events.to_vec());
        let mut sorted = Vec::new();
        for (index, NextEvents { shell, .. }) in (0..).zip(&mut next_events) {
            sorted.clear();
            sorted.extend_from_slice(lists_of(lists, &self.parts, index).neighbours(shell));
            sorted.sort_unstable();
            lists_of_mut(&mut copies, division, index).append(index, &sorted, shell);
        }
        (copies, next_events)
    }
}
