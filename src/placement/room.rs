//! Where spheres of a random start may be.

use super::{MARGIN, ROUNDS};
use crate::experiment::Population;
use crate::scene::{Scene, StartRegion, Surface};
use crate::walls::{NearWalls, Nearest, Repeated, Wall, WallGeometry};
use nalgebra::Vector3;
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// Places at which the free volume is measured: its standard error is then below 1.1 % of the box that they lie in.
const PLACES: u32 = 8192;

/// [-] below it what of a gap or a normal is rounding.
const ROUNDING: f64 = 1e-9;

/// The room for one kind of particles, or for several with the same region.
pub struct FreeRoom {
    /// The scene of a simulation, bodies with their images; a region that is a body is one more wall.
    pub scene: Scene,
    /// The walls in a tree of boxes.
    pub near: NearWalls,
    /// [m] corners of the box that places are drawn from: the domain, or what flat walls, vessels and the region leave of it.
    corners: [Vector3<f64>; 2],
    /// Walls that the particles are to be inside of, by index; none: anywhere.
    inside: Vec<u32>,
    /// Effort that may still be spent on places that are tried, and rounds over all particles.
    effort: AtomicU64,
    /// [m³] the free volume, once it has been measured.
    volume: OnceLock<f64>,
}

impl FreeRoom {
    /// The room of all particles that have no region of their own.
    pub fn of(scene: &Scene) -> Self {
        Self::within(scene, None)
    }

    /// The room within a region.
    pub fn within(scene: &Scene, region: Option<&StartRegion>) -> Self {
        let mut walls = scene.walls.clone();
        let mut inside = Vec::new();
        match region {
            Some(StartRegion::Body(body)) => {
                let smooth = Surface { restitution: 1.0, friction: 0.0 };
                walls.push(Wall::new(WallGeometry::Hollow(body.clone()), smooth));
            }
            Some(StartRegion::InsideWalls(of)) => inside.clone_from(of),
            None => {}
        }
        let corners = corners(&walls, &inside, scene.domain.size);
        let scene = Scene { walls: Repeated::all(&walls, &scene.domain), ..scene.clone() };
        let near = NearWalls::of(&scene.walls);
        Self { scene, near, corners, inside, effort: AtomicU64::new(u64::MAX), volume: OnceLock::new() }
    }

    /// This room with a bound on the effort that is spent on it.
    pub fn with_effort(self, effort: u64) -> Self {
        Self { effort: AtomicU64::new(effort), ..self }
    }

    /// Takes off what something costs; whether anything is left.
    pub fn spend(&self, cost: u64) -> bool {
        let left = self.effort.load(Ordering::Relaxed).saturating_sub(cost);
        self.effort.store(left, Ordering::Relaxed);
        left > 0
    }

    /// [m] between a sphere that touches a wall or lies behind it and that wall, negative; of one that is free, not negative.
    pub fn gap(&self, place: &Vector3<f64>, radius: f64) -> f64 {
        let mut gap = f64::INFINITY;
        self.for_each_wall(place, radius, |nearest| {
            gap = gap.min(nearest.distance - self.reach(&nearest.normal, radius))
        });
        gap
    }

    /// Calls `visit` with the nearest points of the walls that a sphere may touch or lie behind, and of others.
    fn for_each_wall(&self, place: &Vector3<f64>, radius: f64, mut visit: impl FnMut(Nearest)) {
        self.near.for_each_nearest(&self.scene.walls, place, radius, |_, nearest| visit(nearest));
    }

    /// [m] the distance that a sphere keeps from a wall with that normal. Spheres are placed as if larger than they are; in a slab as thick as they are
    /// that leaves no room across it, and there they are as large as they are.
    pub fn reach(&self, normal: &Vector3<f64>, radius: f64) -> f64 {
        let across = (0..3).find(|&axis| normal[axis].abs() > 1.0 - ROUNDING);
        let is_thin = across.is_some_and(|axis| self.middle(axis, radius).is_some());
        if is_thin { radius / (1.0 + MARGIN) * (1.0 - ROUNDING) } else { radius }
    }

    /// [m] the middle of the room along an axis, if that is too thin there for spheres of `radius` [m] to be anywhere else.
    pub fn middle(&self, axis: usize, radius: f64) -> Option<f64> {
        let [low, high] = self.corners.map(|corner| corner[axis]);
        (!self.scene.domain.periodic[axis] && high - low < 2.0 * radius).then_some(0.5 * (low + high))
    }

    /// True if it is too thin along some axis for spheres of `radius` [m] to be anywhere but in the middle.
    pub fn is_slab(&self, radius: f64) -> bool {
        (0..3).any(|axis| self.middle(axis, radius).is_some())
    }

    /// True if the particles are to be inside some of the walls.
    pub fn is_inside_walls(&self) -> bool {
        !self.inside.is_empty()
    }

    /// True if a centre at `place` [m] is inside the walls that the particles are to be inside of.
    pub fn holds(&self, place: &Vector3<f64>) -> bool {
        let holds = |wall: &u32| self.scene.walls[*wall as usize].geometry.encloses(place);
        self.inside.is_empty() || self.inside.iter().any(holds)
    }

    /// A random place at which a sphere of `radius` [m] touches no wall; any, if none is found.
    pub fn somewhere(&self, radius: f64, random: &mut Xoshiro256PlusPlus) -> Vector3<f64> {
        let [low, high] = self.corners;
        let mut place = Vector3::zeros();
        for _ in 0..ROUNDS {
            place = Vector3::from_fn(|axis, _| {
                let is_whole = low[axis] == 0.0 && high[axis] == self.scene.domain.size[axis];
                let margin = if self.scene.domain.periodic[axis] && is_whole { 0.0 } else { radius };
                let drawn = margin + random.random::<f64>() * (high[axis] - low[axis] - 2.0 * margin);
                self.middle(axis, radius).unwrap_or(low[axis] + drawn)
            });
            if self.gap(&place, radius) > 0.0 && self.holds(&place) || !self.spend(1) {
                break;
            }
        }
        place
    }

    /// [m³] what walls leave free of the box that places are drawn from, measured at places that fill it evenly: the additive recurrence with the
    /// inverse powers of 1.2207..., the root of x⁴ = x + 1 (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
    pub fn volume(&self) -> f64 {
        *self.volume.get_or_init(|| self.measured_volume())
    }

    fn measured_volume(&self) -> f64 {
        const ROOT: f64 = 1.220_744_084_605_759_5;
        let [low, high] = self.corners;
        let box_volume = (high - low).iter().map(|edge| edge.max(0.0)).product::<f64>();
        let are_sides = |wall: &Wall| wall.geometry.plane().is_some_and(|plane| plane.normal.amax() > 1.0 - ROUNDING);
        if self.inside.is_empty() && self.scene.walls.iter().all(are_sides) {
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

/// Populations by their regions: the first with each, and which share it.
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

/// [m] corners of the box that flat walls across the axes, vessels and walls to be inside of leave of a domain with those edges [m].
fn corners(walls: &[Wall], inside: &[u32], size: Vector3<f64>) -> [Vector3<f64>; 2] {
    let [mut low, mut high] = [Vector3::zeros(), size];
    let mut narrow = |[from, to]: [Vector3<f64>; 2]| {
        // what differs by rounding from a side of the domain is that side
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
        wall.geometry.room_corners().into_iter().for_each(&mut narrow);
    }
    let bounds = inside.iter().filter_map(|wall| walls[*wall as usize].geometry.extent());
    let around = bounds.reduce(|[a, b], [c, d]| [a.inf(&c), b.sup(&d)]);
    around.into_iter().for_each(&mut narrow);
    [low, high]
}
