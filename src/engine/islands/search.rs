//! Who is hot: one look at every pair near enough, once per window.

use crate::domain::Domain;
use crate::engine::motion::first_touch;
use crate::neighbours::cells::CellGrid;
use crate::particles::{CHUNK, Particles};
use crate::scene::Scene;
use crate::walls::Flight;
use nalgebra::Vector3;
use rayon::prelude::*;
use std::ops::Range;

/// Rows of cells per parallel task.
const ROWS: usize = 64;

/// A particle as the search sees it, in cell order.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// [m] centre.
    pub position: Vector3<f64>,
    /// [m] radius plus the longest way it can go in the window in free flight.
    pub reach: f64,
}

/// A touch on the straight flights of this window: two places, or one and a wall.
pub type Touch = (u32, Option<u32>);

/// What a search found.
pub struct Found {
    /// In cell order of the first particle.
    pub touches: Vec<Touch>,
    /// Pairs and walls looked at.
    pub checks: u64,
}

/// Particles in cells with their reach.
#[derive(Default)]
pub struct Search {
    pub grid: CellGrid,
    /// Places in cell order.
    pub order: Vec<u32>,
    pub spots: Vec<Spot>,
    /// [m] the largest reach.
    pub largest_reach: f64,
    /// Cluster of each hot particle by place, `NOBODY` for the others; all `NOBODY` between windows.
    pub label: Vec<u32>,
}

/// No cluster.
pub const NOBODY: u32 = u32::MAX;

/// Places in the order of cells that hold about one particle each.
pub fn cell_order(particles: &Particles, domain: &Domain) -> Vec<u32> {
    let spacing = (domain.volume() / particles.len().max(1) as f64).cbrt();
    CellGrid::new(&particles.position, domain, spacing).1
}

impl Search {
    /// Sorts the particles into cells for a window of `part` [s]. Positions are inside the box.
    pub fn build(&mut self, particles: &Particles, scene: &Scene, frame: Vector3<f64>, part: f64) {
        let largest_radius = particles.radius.iter().fold(0.0, |a: f64, &r| a.max(r));
        // rounding of the flights must not make the reach too short
        let reach = |i: usize| particles.radius[i] + (particles.velocity[i] - frame).norm() * part * (1.0 + 1e-12);
        let edge = 2.0 * (largest_radius + particles.largest_speed(frame) * part * (1.0 + 1e-12));
        let spacing = (scene.domain.volume() / particles.len().max(1) as f64).cbrt();
        let (grid, order) = CellGrid::new(&particles.position, &scene.domain, edge.max(0.8 * spacing));
        self.spots.resize(order.len(), Spot { position: Vector3::zeros(), reach: 0.0 });
        self.spots.par_chunks_mut(CHUNK).zip(order.par_chunks(CHUNK)).for_each(|(spots, order)| {
            for (spot, &place) in spots.iter_mut().zip(order) {
                let i = place as usize;
                *spot = Spot { position: particles.position[i], reach: reach(i) };
            }
        });
        self.largest_reach = 0.5 * edge;
        self.grid = grid;
        self.order = order;
        self.label.resize(particles.len(), NOBODY);
    }

    /// All touches on straight flights within `part` [s]; `fallen` [m/s] is what gravity has added to the velocities.
    pub fn hot(&self, particles: &Particles, scene: &Scene, fallen: Vector3<f64>, part: f64) -> Found {
        let rows: Vec<usize> = (0..self.grid.rows()).collect();
        let parts: Vec<(Vec<Touch>, u64)> = rows
            .par_chunks(ROWS)
            .map(|rows| {
                let mut touches = Vec::new();
                let mut checks = 0;
                let mut near = Vec::new();
                for &row in rows {
                    self.grid.for_each_in_row(row, |k, others, wraps| {
                        checks += others.len() as u64;
                        let kept = self.near(k, others, wraps, &scene.domain, &mut near);
                        for &l in &near[..kept] {
                            let (i, j) = (self.order[k], self.order[l as usize]);
                            if meets(particles, &scene.domain, i as usize, j as usize, part) {
                                touches.push((i, Some(j)));
                            }
                        }
                    });
                }
                (touches, checks)
            })
            .collect();
        let mut found = Found { touches: Vec::new(), checks: 0 };
        for (touches, checks) in parts {
            found.touches.extend(touches);
            found.checks += checks;
        }
        self.hot_at_walls(particles, scene, fallen, part, &mut found);
        found
    }

    /// Collects those of a range that are within reach of spot `k` at the front of `near`; returns how many.
    ///
    /// Every one is written and only those within reach are kept: about half the ranges hold one, and a branch that cannot
    /// be predicted costs more than a store.
    #[inline]
    fn near(&self, k: usize, others: Range<usize>, wraps: bool, domain: &Domain, near: &mut Vec<u32>) -> usize {
        if near.len() < others.len() {
            near.resize(2 * others.len(), 0);
        }
        let a = self.spots[k];
        let first = others.start as u32;
        let mut kept = 0;
        for (l, b) in (first..).zip(&self.spots[others]) {
            let apart = if wraps { domain.separation(&a.position, &b.position) } else { a.position - b.position };
            let reach = a.reach + b.reach;
            near[kept] = l;
            kept += usize::from(apart.norm_squared() < reach * reach);
        }
        kept
    }

    fn hot_at_walls(&self, particles: &Particles, scene: &Scene, fallen: Vector3<f64>, part: f64, found: &mut Found) {
        if scene.walls.is_empty() {
            return;
        }
        let parts: Vec<Vec<Touch>> = (0..particles.len().div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut touches = Vec::new();
                for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(particles.len()) {
                    if meets_wall(particles, scene, fallen, i, part) {
                        touches.push((i as u32, None));
                    }
                }
                touches
            })
            .collect();
        found.checks += (particles.len() * scene.walls.len()) as u64;
        found.touches.extend(parts.iter().flatten());
    }
}

/// Whether two straight flights touch within `part` [s].
fn meets(particles: &Particles, domain: &Domain, i: usize, j: usize, part: f64) -> bool {
    let (a, b) = (&particles.velocity[i], &particles.velocity[j]);
    let reach = particles.radius[i] + particles.radius[j];
    let apart = domain.separation(&particles.position[i], &particles.position[j]);
    first_touch(&apart, &(a - b), reach, a.norm() + b.norm()).is_some_and(|t| t < part)
}

/// Whether a flight touches any wall within `part` [s].
fn meets_wall(particles: &Particles, scene: &Scene, fallen: Vector3<f64>, i: usize, part: f64) -> bool {
    let (position, radius) = (particles.position[i], particles.radius[i]);
    let flight = Flight { position, velocity: particles.velocity[i] + fallen, gravity: scene.gravity };
    scene.walls.iter().any(|wall| {
        let nearest = wall.geometry.nearest(&position);
        // what nears the wall is the part of the motion along its normal; beside a body all of it may
        let speed =
            if wall.geometry.is_flat() { -flight.velocity.dot(&nearest.normal) } else { flight.velocity.norm() };
        let fall = scene.gravity.norm() * part;
        nearest.distance - radius <= (speed.max(0.0) + fall) * part
            && wall.geometry.law().touch_time(&flight, radius, part).is_some()
    })
}
