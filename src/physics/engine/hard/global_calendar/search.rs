//! Search for the neighbours of particles. A shell is a ball around a particle, in which its neighbour list is valid.
//! Two particles are neighbours if they may touch while both stay in their shells: the shells then overlap. The margin
//! is the distance that a particle may move from the centre of its shell.

use super::next_events::ParticleRange;
use super::shells::{ShellLevel, Shells};
use super::sliding::SLIDE;
use crate::domain::Domain;

/// Neighbour lists of several particles, before they are stored with the lists of other particles.
#[derive(Default)]
pub struct FoundNeighbours {
    /// Indices of the neighbours of all these particles, one list after the other.
    pub near: Vec<u32>,
    /// Number of neighbours in the list of each particle.
    pub counts: Vec<u32>,
    /// For each particle, true if the prediction of touches must look for the nearest periodic image of each neighbour
    /// (its copy, shifted by an edge of the box).
    across: Vec<bool>,
    /// Number of distances between shells (balls in which neighbour lists are valid) that were computed for these
    /// lists.
    pub checks: u64,
}

impl FoundNeighbours {
    /// The neighbour lists one after the other, in the order in which they were made. The second member of each item is
    /// true if the prediction of touches must look for the nearest periodic image of each neighbour (its copy, shifted
    /// by an edge of the box).
    pub fn each(&self) -> impl Iterator<Item = (&[u32], bool)> {
        let mut near = self.near.as_slice();
        self.counts.iter().zip(&self.across).map(move |(count, across)| {
            let (own, rest) = near.split_at(*count as usize);
            near = rest;
            (own, *across)
        })
    }
}

/// True if a particle in `others` may have a periodic image that is nearer to particle `i` than the stored position of
/// this other particle. False is returned only if all particles in `others` are less than half the shortest periodic
/// edge of the box apart from `i`. The time `now` [s] counts from the epoch (zero of the event queue's time).
pub fn has_images(i: u32, others: &[u32], particles: ParticleRange, (domain, now): (&Domain, f64)) -> bool {
    let here = particles.body(i).position_at(now);
    others.iter().any(|&j| !domain.is_direct(&(here - particles.body(j).position_at(now))))
}

impl Shells {
    /// Finds the neighbours of the particles with the given indices, at the present time `now` [s] since the epoch
    /// (zero of the event queue's time).
    pub fn neighbours_of_each(
        &self,
        indices: impl Iterator<Item = u32>,
        particles: ParticleRange,
        (domain, now): (&Domain, f64),
    ) -> FoundNeighbours {
        let mut all = FoundNeighbours::default();
        for index in indices {
            let before = all.near.len();
            all.checks += self.find_neighbours(index, particles, domain, &mut all.near);
            all.counts.push((all.near.len() - before) as u32);
            all.across.push(has_images(index, &all.near[before..], particles, (domain, now)));
        }
        all
    }

    /// Appends to `found` the indices of the neighbours of particle `i`. These are all particles whose shells overlap
    /// the shell of `i`, and some particles whose shells nearly overlap it. A shell is the ball in which a neighbour
    /// list is valid. Returns the number of shells tested.
    pub fn find_neighbours(&self, i: u32, particles: ParticleRange, domain: &Domain, found: &mut Vec<u32>) -> u64 {
        let (centre, radius) = (particles.shell(i).centre(), self.radius(particles.body(i)));
        let near = |j: u32| {
            let reach = radius + self.radius(particles.body(j)) + 2.0 * self.margin;
            domain.separation(&centre, &particles.shell(j).centre()).norm_squared() < reach * reach
        };
        let mut checks = 0;
        for ShellLevel { cells, smallest, largest } in &self.levels {
            let (before, farthest) = (found.len(), radius + largest + 2.0 * self.margin);
            checks += if radius <= *largest {
                cells.near(&centre, farthest, found)
            } else {
                cells.near_by_far(&centre, farthest, found)
            };
            let mut end = before;
            for k in before..found.len() {
                let j = found[k];
                found[end] = j;
                end += usize::from(j != i && (smallest == largest || near(j)));
            }
            found.truncate(end);
        }
        checks + self.find_across(i, particles, domain, found)
    }

    /// Appends to `found` the particles whose shells (balls in which neighbour lists are valid) may overlap an image of
    /// the shell of particle `i` across a sheared side. `domain` gives the mean places of the images, which slide along
    /// that side by up to [`SLIDE`] times the margin (radius of a shell) in both directions. Returns the number of
    /// shells tested.
    fn find_across(&self, i: u32, particles: ParticleRange, domain: &Domain, found: &mut Vec<u32>) -> u64 {
        let (centre, radius) = (particles.shell(i).centre(), self.radius(particles.body(i)));
        let mut checks = 0;
        domain.for_each_across(&centre, self.search_radius(domain), |image| {
            for ShellLevel { cells, largest, .. } in &self.levels {
                let before = found.len();
                checks += cells.near_by_far(&image, radius + largest + (2.0 + SLIDE) * self.margin, found);
                let mut end = before;
                for k in before..found.len() {
                    let j = found[k];
                    found[end] = j;
                    let reach = radius + self.radius(particles.body(j)) + 2.0 * self.margin;
                    let apart = domain.separation(&centre, &particles.shell(j).centre());
                    end += usize::from(apart.y.abs() < reach && apart.norm() < reach + SLIDE * self.margin);
                }
                found.truncate(end);
            }
        });
        checks
    }
}
