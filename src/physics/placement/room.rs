//! Free space in which the spheres of a random start are placed.

use super::{MARGIN, ROUNDS};
use crate::experiment::Population;
use crate::scene::{Scene, StartRegion, Surface};
use crate::walls::{NearWalls, Nearest, Repeated, Wall, WallGeometry};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// Number of points with which the free volume is measured. The standard error is below 1.1 % of the volume of the box
/// that contains the points.
const PLACES: u32 = 8192;

/// [-] largest relative difference of lengths, or difference of the components of unit normals, that counts as
/// rounding.
const ROUNDING: f64 = 1e-9;

/// Free space in which the particles of one population (group of particles with common settings), or of several
/// populations with one region, are placed.
pub struct FreeRoom {
    /// Scene of the simulation, with periodic images of bodies. If the region is a body, the scene contains it as a
    /// hollow wall.
    pub scene: Scene,
    /// Data structure that finds the walls near a point.
    pub near: NearWalls,
    /// [m] corners of the box in which random positions are chosen. It is the part of the domain between flat walls,
    /// within vessels and within the region.
    corners: [Vector3<f64>; 2],
    /// Indices of the walls inside which the particles start; empty if the region is a body, or if there is no region.
    inside: Vec<u32>,
    /// Remaining effort of the search for positions: the number of positions that may still be tried. A round over all
    /// particles also costs effort.
    effort: AtomicU64,
    /// [m³] free volume; empty until this volume is measured.
    volume: OnceLock<f64>,
}

impl FreeRoom {
    /// Makes the free space of the whole scene, for populations without a region.
    pub fn of(scene: &Scene) -> Self {
        Self::within(scene, None)
    }

    /// Makes the free space within a region of the scene. `None` means the whole scene.
    pub fn within(scene: &Scene, region: Option<&StartRegion>) -> Self {
        let mut walls = scene.walls.clone();
        let mut inside = Vec::new();
        match region {
            Some(StartRegion::Body(body)) => {
                let smooth = Surface::new(1.0, 0.0);
                walls.push(Wall::new(WallGeometry::Hollow(body.clone()), smooth));
            }
            Some(StartRegion::InsideWalls(of)) => inside.clone_from(of),
            None => {}
        }
        let corners = corners(&walls, &inside, scene.domain.size);
        // gravity is left out, because neighbour lists would allow for a fall in each step of a relaxation
        let gravity = Vector3::zeros();
        let (walls, domain) = (Repeated::all(&walls, &scene.domain), scene.domain.at_rest());
        let scene = Scene { walls, domain, gravity, ..scene.clone() };
        let near = NearWalls::of(&scene.walls);
        Self { scene, near, corners, inside, effort: AtomicU64::new(u64::MAX), volume: OnceLock::new() }
    }

    /// [-] largest volume fraction that spheres can fill, increased by the error of a measured volume. In a box,
    /// spheres of one size fill at most π/√18 (Hales 2005, Ann. Math. 162, 1065). In other spaces the limit is 1,
    /// because a single sphere can fill a spherical vessel.
    pub fn most(&self) -> f64 {
        /// [-] factor for the error of a measured volume, which covers several standard errors.
        const MEASURED: f64 = 1.05;
        let is_box = self.is_box();
        let one_size = !self.scene.has_sizes() && self.scene.smallest_diameter() == self.scene.largest_diameter();
        let densest = if is_box && one_size { std::f64::consts::PI / 18f64.sqrt() } else { 1.0 };
        if is_box { densest } else { MEASURED * densest }
    }

    /// True if the space is a box, whose volume is exact, because it is not measured with points.
    fn is_box(&self) -> bool {
        let are_sides = |wall: &Wall| wall.geometry.plane().is_some_and(|plane| plane.normal.amax() > 1.0 - ROUNDING);
        self.inside.is_empty() && self.scene.walls.iter().all(are_sides)
    }

    /// Returns this space with a limit on the effort of the search for positions: the number of positions that may be
    /// tried.
    pub fn with_effort(self, effort: u64) -> Self {
        Self { effort: AtomicU64::new(effort), ..self }
    }

    /// Subtracts the cost of an operation from the remaining effort. Returns true if effort is left.
    pub fn spend(&self, cost: u64) -> bool {
        let left = self.effort.load(Ordering::Relaxed).saturating_sub(cost);
        self.effort.store(left, Ordering::Relaxed);
        left > 0
    }

    /// [m] smallest gap between any wall and a sphere with the centre `place` [m]. It is negative if the sphere
    /// overlaps a wall or has its centre behind a wall.
    pub fn gap(&self, place: &Vector3<f64>, radius: f64) -> f64 {
        let mut gap = f64::INFINITY;
        self.for_each_wall(place, radius, |nearest| {
            gap = gap.min(nearest.distance - self.reach(&nearest.normal, radius))
        });
        gap
    }

    /// Calls `visit` with the nearest point of every wall that a sphere overlaps or has passed through. `visit` may
    /// also be called for other walls near the sphere. `place` [m] is the centre.
    fn for_each_wall(&self, place: &Vector3<f64>, radius: f64, mut visit: impl FnMut(Nearest)) {
        self.near.for_each_nearest(&self.scene.walls, place, radius, |_, nearest| visit(nearest));
    }

    /// [m] required distance of a sphere's centre from a wall with this normal: the radius, enlarged as during the
    /// placement. Between two walls one diameter apart an enlarged sphere would not fit, so the true radius is used
    /// there.
    pub fn reach(&self, normal: &Vector3<f64>, radius: f64) -> f64 {
        let across = (0..3).find(|&axis| normal[axis].abs() > 1.0 - ROUNDING);
        let is_thin = across.is_some_and(|axis| self.middle(axis, radius).is_some());
        if is_thin { radius / (1.0 + MARGIN) * (1.0 - ROUNDING) } else { radius }
    }

    /// [m] coordinate of the middle of the space along an axis, if the space is narrower than a sphere of `radius` [m].
    /// `radius` is the enlarged radius of the placement; the true sphere may still fit in the middle. `None` if the
    /// space is wide enough or the axis is periodic.
    pub fn middle(&self, axis: usize, radius: f64) -> Option<f64> {
        let [low, high] = self.corners.map(|corner| corner[axis]);
        (!self.scene.domain.periodic[axis] && high - low < 2.0 * radius).then_some(0.5 * (low + high))
    }

    /// True if the space is so thin along some axis that spheres of `radius` [m] fit only in the middle between two
    /// sides.
    pub fn is_slab(&self, radius: f64) -> bool {
        (0..3).any(|axis| self.middle(axis, radius).is_some())
    }

    /// True if the particles start inside some of the walls, which the start region names.
    pub fn is_inside_walls(&self) -> bool {
        !self.inside.is_empty()
    }

    /// True if the position `place` [m] of a centre is inside one of the walls that enclose the start region. Without
    /// such walls the result is true everywhere.
    pub fn holds(&self, place: &Vector3<f64>) -> bool {
        let holds = |wall: &u32| self.scene.walls[*wall as usize].geometry.law().encloses(place);
        self.inside.is_empty() || self.inside.iter().any(holds)
    }

    /// Returns a random position in the region at which a sphere of `radius` [m] touches no wall. If no such position
    /// is found within `ROUNDS` trials and the allowed effort, the last position tried is returned.
    pub fn somewhere(&self, radius: f64, random: &mut Xoshiro256PlusPlus) -> Vector3<f64> {
        let mut place = Vector3::zeros();
        for _ in 0..ROUNDS {
            place = self.anywhere(radius, random);
            if self.fits(&place, radius) || !self.spend(1) {
                break;
            }
        }
        place
    }

    /// Returns a random position for a sphere of `radius` [m] in the box of the free space, which may touch a wall.
    pub fn anywhere(&self, radius: f64, random: &mut Xoshiro256PlusPlus) -> Vector3<f64> {
        let [low, high] = self.corners;
        Vector3::from_fn(|axis, _| {
            let is_whole = low[axis] == 0.0 && high[axis] == self.scene.domain.size[axis];
            let margin = if self.scene.domain.periodic[axis] && is_whole { 0.0 } else { radius };
            let drawn = margin + random.random::<f64>() * (high[axis] - low[axis] - 2.0 * margin);
            self.middle(axis, radius).unwrap_or(low[axis] + drawn)
        })
    }

    /// True if a random search finds a position for a single sphere of `radius` [m].
    pub fn has_place_for(&self, radius: f64) -> bool {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
        (0..ROUNDS).any(|_| self.fits(&self.anywhere(radius, &mut random), radius))
    }

    /// True if a sphere of `radius` [m] at `place` [m] touches no wall and is in the region.
    pub fn fits(&self, place: &Vector3<f64>, radius: f64) -> bool {
        self.gap(place, radius) > 0.0 && self.holds(place)
    }

    /// [m³] volume that walls leave free in the box in which random positions are chosen, within the region. Without a
    /// region the volume is exact if all walls are planes perpendicular to the axes. Otherwise the volume is measured
    /// with points that fill the box evenly. Coordinate k (1 to 3) of point n, counted from the lowest corner and
    /// divided by the edge, is the fractional part of 1/2 + n/ρ^k. Here ρ = 1.2207... is the root of ρ⁴ = ρ + 1
    /// (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
    pub fn volume(&self) -> f64 {
        *self.volume.get_or_init(|| self.measured_volume())
    }

    fn measured_volume(&self) -> f64 {
        const ROOT: f64 = 1.220_744_084_605_759_5;
        let [low, high] = self.corners;
        let box_volume = (high - low).iter().map(|edge| edge.max(0.0)).product::<f64>();
        if self.is_box() {
            return box_volume;
        }
        let is_free = |number: &u32| {
            let share = |axis: i32| (0.5 + f64::from(*number) * ROOT.powi(-axis - 1)).fract();
            let place = Vector3::from_fn(|axis, _| low[axis] + share(axis as i32) * (high[axis] - low[axis]));
            self.gap(&place, 0.0) >= 0.0 && self.holds(&place)
        };
        let free = (1..=PLACES).filter(is_free).count();
        box_volume * free as f64 / f64::from(PLACES)
    }
}

/// Returns each different start region once, with the indices of the populations that start in it. `None` stands for
/// populations without a start region.
pub fn regions(populations: &[Population]) -> Vec<(Option<StartRegion>, Vec<usize>)> {
    let mut regions: Vec<(Option<StartRegion>, Vec<usize>)> = Vec::new();
    for (index, population) in populations.iter().enumerate() {
        match regions.iter_mut().find(|(region, _)| *region == population.region) {
            Some((_, of)) => of.push(index),
            None => regions.push((population.region.clone(), vec![index])),
        }
    }
    regions
}

/// [m] lowest and highest corner of the part of a domain in which random positions are chosen. The domain has the edges
/// `size` [m]. The part lies between flat walls perpendicular to the axes, within vessels, and within the walls around
/// the region.
fn corners(walls: &[Wall], inside: &[u32], size: Vector3<f64>) -> [Vector3<f64>; 2] {
    let [mut low, mut high] = [Vector3::zeros(), size];
    let mut narrow = |[from, to]: [Vector3<f64>; 2]| {
        // limits that differ from a side of the domain only by rounding are ignored
        for axis in 0..3 {
            if from[axis] > low[axis] + ROUNDING * size[axis] {
                low[axis] = from[axis];
            }
            if to[axis] < high[axis] - ROUNDING * size[axis] {
                high[axis] = to[axis];
            }
        }
    };
    for wall in walls {
        wall.geometry.law().room_corners().into_iter().for_each(&mut narrow);
    }
    let bounds = inside.iter().filter_map(|wall| walls[*wall as usize].geometry.law().extent());
    let around = bounds.reduce(|[a, b], [c, d]| [a.inf(&c), b.sup(&d)]);
    around.into_iter().for_each(&mut narrow);
    [low, high]
}
