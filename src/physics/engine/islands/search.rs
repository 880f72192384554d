//! Search for hot particles: those that touch something in a part (a piece of the time between two exchanges with the
//! gas) if all particles fly straight. Every pair that is near enough is checked once. The frame of the search moves
//! with the mean velocity of all particles along the walls. The members of islands (groups of particles that may meet)
//! are the hot particles.

use crate::domain::Domain;
use crate::encounter::{AtWall, Couple, FrameTime, may_meet};
use crate::neighbours::cells::CellGrid;
use crate::neighbours::levels::{SizeLevels, SortedSizes};
use crate::neighbours::packed::PackedBalls;
use crate::neighbours::region::Region;
use crate::particles::{CHUNK, Particles};
use crate::scene::Scene;
use crate::walls::{Geometry, NearWalls, Plane, Wall};
use crate::work_sharing;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::num::NonZeroU32;

/// Number of rows of cells that a thread searches as one piece of work.
const ROWS: usize = 16;

/// Number of near pairs that are collected before the data of their particles are read from the particle store.
const BATCH: usize = 64;

/// Ball that contains a particle throughout a flight or another interval of its motion, relative to the moving frame
/// of the search. In a sheared box, the mean flow at the particle's position at the start of the interval is added to
/// the velocity of the frame.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct BoundingSphere {
    /// [m] centre of the ball, inside the box along periodic axes. For a straight flight it is the middle of the
    /// flight.
    pub middle: Vector3<f64>,
    /// [m] radius of the ball. For a straight flight it is the radius of the particle plus half the length of the
    /// flight.
    pub reach: f64,
}

impl BoundingSphere {
    /// Ball that contains particle `i` during a straight flight of `part` [s], relative to a frame with the velocity
    /// `frame` [m/s].
    #[inline(always)]
    pub fn of(particles: &Particles, i: usize, domain: &Domain, frame: Vector3<f64>, part: f64) -> Self {
        let (position, radius) = (particles.position[i], particles.radius[i]);
        let half = (particles.velocity[i] - (frame + domain.mean_flow(&position))) * (0.5 * part);
        // the ball is enlarged, so that rounding does not make it too small
        let length = half.norm() * (1.0 + 1e-12);
        let ball = Self { middle: domain.wrap(&(position + half)), reach: radius + length };
        ball.strained(domain, part, radius + 2.0 * length)
    }

    /// Enlarges the ball in a sheared box, where the frames of two particles move relative to each other. `way` [m] is
    /// the largest distance of any point of the particle, during `part` [s], from the initial position of its centre.
    /// If two particles touch, their distance along y at the start was at most the sum of `way` of both. Their frames
    /// are then displaced relative to each other by at most the shear rate times `part` times this sum.
    #[inline]
    pub fn strained(self, domain: &Domain, part: f64, way: f64) -> Self {
        match domain.shear {
            None => self,
            Some(_) => Self { reach: self.reach + domain.strain_rate() * part * way * (1.0 + 1e-9), ..self },
        }
    }

    /// True if this ball and the ball `other` overlap, periodic images included.
    #[inline]
    pub fn meets(&self, other: &Self, domain: &Domain) -> bool {
        let reach = self.reach + other.reach;
        domain.separation(&self.middle, &other.middle).norm_squared() < reach * reach
    }
}

/// Touch of two bodies that fly straight, in a part (a piece of the time between two exchanges with the gas).
#[derive(Clone, Copy, Debug)]
pub struct FirstTouch {
    pub index: u32,
    /// Index of the other particle; `None` for a wall.
    pub other: Option<u32>,
    /// [s] time of the touch since the start of the part (interval of time).
    pub time: f64,
}

/// Touches that a search has found, and the number of pairs that the search has checked.
pub struct SearchResult {
    /// Touches of pairs in the order of the cells of their first particles, then touches of walls.
    pub touches: Vec<FirstTouch>,
    /// Number of pairs of particles, plus number of pairs of a particle and a wall, that were checked.
    pub checks: u64,
}

/// Straight flights of all particles in a part (a piece of the time between two exchanges with the gas), sorted into
/// cells.
#[derive(Default)]
pub struct Search {
    pub levels: SizeLevels,
    /// Region of space that contains the middles of all flights: the box, or a part of it if several processes share
    /// the run.
    pub region: Region,
    /// Ball that contains the straight flight of each particle, by particle index.
    pub flights: Vec<BoundingSphere>,
    packed: PackedBalls,
    /// Mark of each hot particle (member of an island), by particle index: the number of the particle among all
    /// members. `None` for other particles, and for all particles while no islands are solved.
    pub label: Vec<Option<Label>>,
    /// Structure for finding the walls near a point, made when the flights were last computed.
    pub near_walls: NearWalls,
    /// Indices of the particles whose flights come near a wall, in one list for each chunk of consecutive particles.
    /// If some wall is not flat, all particles are listed.
    beside_walls: Vec<Vec<u32>>,
}

/// Label of a hot particle (member of an island): its number among the members of all islands (groups of particles
/// that may meet). An `Option<Label>` takes four bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Label(NonZeroU32);

impl Label {
    /// Label of the island member that has the number `member`.
    pub fn of(member: usize) -> Self {
        Self(NonZeroU32::MIN.saturating_add(member as u32))
    }

    /// Number of the island member that has this label.
    pub fn member(self) -> usize {
        self.0.get() as usize - 1
    }
}

/// Indices of the particles in a region, cell by cell, for cells that contain about one particle each.
pub fn cell_order(particles: &Particles, region: &Region) -> Vec<u32> {
    let spacing = (region.volume() / particles.len().max(1) as f64).cbrt();
    CellGrid::new(&particles.position, region, spacing).1
}

/// Appends to `touches` the touches of the given pairs within `part` [s], if all particles fly straight, and empties
/// the list of pairs. All particles are read from the store before any pair is checked in detail, so that the processor
/// need not wait for memory at every pair.
fn touches_of(
    pairs: &mut Vec<(u32, u32)>,
    (particles, scene): (&Particles, &Scene),
    part: f64,
    touches: &mut Vec<FirstTouch>,
) {
    let mut may = 0;
    for k in 0..pairs.len() {
        let (i, j) = pairs[k];
        pairs[may] = (i, j);
        may += usize::from(may_meet(particles, scene, [i as usize, j as usize]));
    }
    for &(i, j) in &pairs[..may] {
        let time = Couple::pair(i, j).touch_time(particles, scene, FrameTime::default(), part);
        let time = time.filter(|time| *time < part);
        touches.extend(time.map(|time| FirstTouch { index: i, other: Some(j), time }));
    }
    pairs.clear();
}

impl Search {
    /// Computes the straight flights of all particles during the interval `span`, relative to a frame with the velocity
    /// `frame` [m/s]. Sorts the flights into cells by their middles, which must be in `region`. Positions must be
    /// inside the box.
    pub fn build(
        &mut self,
        particles: &Particles,
        scene: &Scene,
        region: Region,
        frame: Vector3<f64>,
        span: &SearchInterval,
    ) {
        let (domain, part) = (&scene.domain, span.part);
        self.region = region;
        self.near_walls = NearWalls::of(&scene.walls);
        self.label.resize(particles.len(), None);
        self.flights.resize(particles.len(), BoundingSphere { middle: Vector3::zeros(), reach: 0.0 });
        // flat walls are checked here, while the flights are in the cache
        let planes: Option<Vec<&Plane>> = scene.walls.iter().map(|wall| wall.geometry.plane()).collect();
        let is_beside = |flight: &BoundingSphere| {
            let near = |plane: &&Plane| plane.nearest(&flight.middle).distance <= flight.reach + span.falls;
            planes.as_ref().is_none_or(|planes| planes.iter().any(near))
        };
        self.beside_walls = work_sharing::map(self.flights.chunks_mut(CHUNK).enumerate(), |(chunk, flights)| {
            let mut beside = Vec::new();
            for (index, flight) in (chunk * CHUNK..).zip(flights) {
                *flight = BoundingSphere::of(particles, index, domain, frame, part);
                if is_beside(flight) {
                    beside.push(index as u32);
                }
            }
            beside
        });
        let sizes = SortedSizes::new(&particles.radius, 0.0);
        self.levels.sort(
            &self.flights,
            &sizes,
            |flight| flight.middle,
            |index| self.flights[index].reach,
            &self.region,
        );
        let flights = &self.flights;
        self.packed.fill(&self.levels.order(), |index| (flights[index].middle, flights[index].reach), &self.region);
    }

    /// Calls `visit` with the index of every particle that comes into a ball on its straight flight, periodic images
    /// included.
    #[inline(always)]
    pub fn for_each_beside(&self, ball: &BoundingSphere, domain: &Domain, mut visit: impl FnMut(u32)) {
        domain.for_each_image(&ball.middle, ball.reach + self.levels.largest_reach(), |middle| {
            self.packed.for_each_beside((middle, ball.reach), &self.levels, &self.region, |indices| {
                indices
                    .iter()
                    .filter(|&&index| ball.meets(&self.flights[index as usize], domain))
                    .for_each(|&index| visit(index));
            });
        });
    }

    /// Finds all touches of particles with one another and with walls during the interval `span`, if all particles fly
    /// straight.
    pub fn hot(&self, particles: &Particles, scene: &Scene, span: &SearchInterval) -> SearchResult {
        let part = span.part;
        let rows = self.levels.rows();
        let parts: Vec<(Vec<FirstTouch>, u64)> = work_sharing::map(rows.chunks(ROWS), |rows| {
            let mut touches = Vec::new();
            let mut checks = 0;
            let mut waiting = Vec::with_capacity(2 * BATCH);
            for &row in rows {
                let smaller = |i: usize| (self.flights[i].middle, self.flights[i].reach);
                checks += self.packed.for_each_near::<false>(&self.levels, row, smaller, |i, others| {
                    waiting.extend(others.iter().map(|&j| (i, j)));
                    if waiting.len() >= BATCH {
                        touches_of(&mut waiting, (particles, scene), part, &mut touches);
                    }
                });
            }
            touches_of(&mut waiting, (particles, scene), part, &mut touches);
            (touches, checks)
        });
        let mut found = SearchResult { touches: Vec::new(), checks: 0 };
        for (touches, checks) in parts {
            found.touches.extend(touches);
            found.checks += checks;
        }
        self.hot_across(particles, scene, span, &mut found);
        self.hot_at_walls(particles, scene, span, &mut found);
        found
    }

    /// Finds the touches across the sheared sides of the box: the flights near the lower side are shifted above the
    /// upper side, and compared with the flights below the upper side.
    fn hot_across(&self, particles: &Particles, scene: &Scene, span: &SearchInterval, found: &mut SearchResult) {
        if scene.domain.shear.is_none() {
            return;
        }
        let (mut waiting, largest) = (Vec::new(), self.levels.largest_reach());
        for (i, flight) in (0..).zip(&self.flights) {
            let search_radius = flight.reach + largest;
            if flight.middle.y >= search_radius {
                continue;
            }
            scene.domain.for_each_across(&flight.middle, search_radius, |image| {
                self.packed.for_each_beside((image, flight.reach), &self.levels, &self.region, |others| {
                    waiting.extend(others.iter().map(|&j| (i, j)));
                });
            });
        }
        found.checks += waiting.len() as u64;
        touches_of(&mut waiting, (particles, scene), span.part, &mut found.touches);
    }

    fn hot_at_walls(&self, particles: &Particles, scene: &Scene, span: &SearchInterval, found: &mut SearchResult) {
        let touch = |&index: &u32| {
            let time = self.touch_of_wall(particles, scene, span, index as usize)?;
            Some(FirstTouch { index, other: None, time })
        };
        let look = |beside: &Vec<u32>| beside.iter().filter_map(touch).collect();
        let parts: Vec<Vec<FirstTouch>> = work_sharing::map(self.beside_walls.iter(), look);
        found.checks += (particles.len() * self.near_walls.asked()) as u64;
        found.touches.extend(parts.iter().flatten());
    }

    /// Time [s] from the start of the interval `span` to the first touch of particle `i` with a wall, if the particle
    /// flies straight; `None` if it touches no wall.
    fn touch_of_wall(&self, particles: &Particles, scene: &Scene, span: &SearchInterval, i: usize) -> Option<f64> {
        let SearchInterval { elapsed, part, falls } = *span;
        let spot = &self.flights[i];
        // walls need the middle of the flight without wrapping into the box; it is computed only if it is needed,
        // since flat walls do not need it
        let way = || particles.position[i] + particles.velocity[i] * (0.5 * part);
        let look = |(wall, shape): (usize, &Wall)| {
            // the frame moves along planes, so the ball of the flight has the right distance from planes. For other
            // shapes the path relative to the frame at rest is used, or relative to the shape if the shape moves.
            let reach = spot.reach + falls;
            let geometry = &shape.geometry;
            let is_near = match &shape.moving {
                _ if geometry.is_flat() => geometry.is_within(&spot.middle, reach),
                None => geometry.is_within(&way(), reach),
                Some(moving) => {
                    let flight = FrameTime::fallen(elapsed).flight(particles, scene, i);
                    moving.may_reach(&flight, particles.radius[i], part)
                }
            };
            if !is_near {
                return None;
            }
            let touch = |which| {
                let at = AtWall { wall: wall as u32, which };
                Couple::at_wall(i as u32, at).touch_time(particles, scene, FrameTime::fallen(elapsed), part)
            };
            (0..geometry.contacts()).filter_map(touch).reduce(f64::min)
        };
        if self.near_walls.are_few() {
            return scene.walls.iter().enumerate().filter_map(look).reduce(f64::min);
        }
        let mut first: Option<f64> = None;
        self.near_walls.for_each(&way(), spot.reach + falls, |wall| {
            let time = look((wall as usize, &scene.walls[wall as usize]));
            first = first.into_iter().chain(time).reduce(f64::min);
        });
        first
    }
}

/// Interval of time in which particles are assumed to fly straight, while touches are searched.
pub struct SearchInterval {
    /// Time [s] from the last exchange with the gas to the start of the interval.
    elapsed: f64,
    /// [s] length of the interval.
    part: f64,
    /// Upper limit [m] of the distance by which gravity moves particles away from their straight flights in the
    /// interval, plus the distance by which walls move.
    falls: f64,
}

impl SearchInterval {
    /// Makes an interval of `part` [s] that begins `elapsed` [s] after the last exchange with the gas.
    pub fn new(scene: &Scene, elapsed: f64, part: f64) -> Self {
        let falls = part * ((scene.gravity * elapsed).norm() + scene.gravity.norm() * part + scene.wall_speed());
        Self { elapsed, part, falls }
    }
}
