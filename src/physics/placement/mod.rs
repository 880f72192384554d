//! Initial state of the particles: random positions without overlap, which are the same for every model.
//!
//! Three methods remove overlaps. Each method works in rounds; a round treats each overlap once. At low density,
//! overlapping particles get new random positions (sequential insertion). At higher density, overlapping pairs are
//! pushed apart. At the highest densities, all particles are moved at once like soft spheres (relaxation).

mod draw;
mod parts;
mod relax;
mod room;

pub use parts::{Start, comes_in_parts};
pub use relax::{Moved, push_placed_apart};

use crate::experiment::{Amount, Experiment, Population};
use crate::neighbours::NeighbourList;
use crate::neighbours::region::Region;
use crate::particles::Particles;
use crate::scene::{Scene, StartRegion};
use crate::work_sharing;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
pub use room::FreeRoom;
use room::regions;

/// [-] volume fraction up to which insertion is used; above it, insertion is slow. Random sequential addition of
/// spheres jams at 0.382 (Talbot, Schaaf & Tarjus 1991).
const INSERTION_LIMIT: f64 = 0.2;

/// Number of rounds after which a placement is given up. A round treats each overlap once.
const ROUNDS: usize = 5000;

/// Number of rounds (passes over all overlaps) in which spheres that overlap much larger spheres get new random
/// positions, before pairs are pushed apart. Without these new positions, dense groups around the larger spheres would
/// spread slowly. After eight rounds, at a volume fraction of 0.3, fewer than one in 10⁴ spheres still overlap a
/// larger sphere.
const ROUNDS_OF_INSERTION: usize = 8;

/// Number of overlapping or nearly overlapping pairs that cost as much effort as one particle, in a round (pass over
/// all overlaps). A dense start has about this number of such pairs per particle.
const PER_PARTICLE: u64 = 32;

/// [-] fraction by which the radii of spheres are enlarged during placement, so that no spheres touch at the start. The
/// gaps are at least half of the enlargement.
pub const MARGIN: f64 = 1e-3;

/// Error: no start without overlap was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{}: the particles fill {wanted:.3e} of the {room:.3e} m^3 that walls and bodies in the box leave them, and {}; ask for fewer particles, make that room larger (a larger box around a vessel is of no use), or give positions in a file",
    self.what(),
    self.bound()
)]
pub struct Crowded {
    /// [-] volume of the particles over the free volume in which they start.
    pub wanted: f64,
    /// [-] volume of the particles without overlap when the search for positions ended, over the free volume in which
    /// the particles start.
    pub reached: f64,
    /// [m³] free volume of the space in which the particles start: volume that walls and bodies leave.
    pub room: f64,
    /// True if the search for positions ended early because the allowed effort was spent.
    pub given_up: bool,
    /// [-] largest volume fraction of any arrangement of these spheres, if the particles would exceed it; otherwise
    /// `None`.
    pub most: Option<f64>,
}

impl Crowded {
    fn what(&self) -> String {
        match self.most {
            Some(_) => "there is no random start".into(),
            None if self.given_up => "no random start without overlap found with limited effort".into(),
            None => format!("no random start without overlap found after {ROUNDS} rounds"),
        }
    }

    fn bound(&self) -> String {
        match self.most {
            Some(most) => format!("no arrangement of such spheres more than {most:.3e}"),
            None => format!("those that overlap nothing {:.3e}", self.reached),
        }
    }

    /// Returns an error if the particles fill more of the free volume than any arrangement of spheres can. This
    /// function is called before random positions are tried.
    fn refuse_overfull(wanted: f64, room: &FreeRoom) -> Result<(), Self> {
        let most = room.most();
        if wanted <= most {
            return Ok(());
        }
        Err(Self { wanted, reached: 0.0, room: room.volume(), given_up: false, most: Some(most) })
    }
}

/// Makes the initial state of the particles. It depends only on the experiment and its seed, and is the same for every
/// model.
///
/// # Errors
/// If random positions without overlap are not found in a bounded number of rounds (passes over all overlaps).
pub fn initial_state(experiment: &Experiment) -> Result<Particles, Crowded> {
    initial_state_within(experiment, u64::MAX)
}

/// Makes the initial state within a limited `effort`, for callers that only test whether a start can be found quickly.
/// Each position tried for a sphere costs 1. Each round (pass over all overlaps) costs the number of particles, plus a
/// fraction of the number of neighbouring pairs.
///
/// # Errors
/// If random positions without overlap are not found within the given effort.
pub fn initial_state_within(experiment: &Experiment, effort: u64) -> Result<Particles, Crowded> {
    StartPlan::of(experiment).make(effort)
}

/// Makes the initial state of `populations` in a scene. It equals the [`initial_state`] of an experiment with this
/// scene, these populations and this seed.
///
/// # Errors
/// If random positions without overlap are not found in a bounded number of rounds (passes over all overlaps).
pub fn random_start(scene: &Scene, populations: &[Population], seed: u64) -> Result<Particles, Crowded> {
    StartPlan { scene, populations, seed }.make(u64::MAX)
}

/// Data on which a random initial state depends: the scene, the populations (groups of particles with common settings)
/// and the seed.
#[derive(Clone, Copy)]
struct StartPlan<'a> {
    scene: &'a Scene,
    populations: &'a [Population],
    seed: u64,
}

impl<'a> StartPlan<'a> {
    fn of(experiment: &'a Experiment) -> Self {
        Self { scene: &experiment.scene, populations: &experiment.start, seed: experiment.run.seed }
    }

    /// Makes the initial state within a limited `effort`, whose unit is one tried position ([`initial_state_within`]).
    fn make(self, effort: u64) -> Result<Particles, Crowded> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let regions = regions(self.populations);
        let room_in = |region: &Option<StartRegion>| FreeRoom::within(self.scene, region.as_ref()).with_effort(effort);
        let rooms: Vec<FreeRoom> = regions.iter().map(|(region, _)| room_in(region)).collect();
        let region_of =
            |population: usize| regions.iter().position(|(_, of)| of.contains(&population)).unwrap_or_default();
        let room_of: Vec<&FreeRoom> =
            (0..self.populations.len()).map(|population| &rooms[region_of(population)]).collect();
        let mut particles = draw::draw(self, &room_of, &mut random, &|_| true);
        // moves the particles of one region, while those of other regions stay fixed
        for ((_, populations), room) in regions.iter().zip(&rooms) {
            let mut is_free = Vec::with_capacity(particles.len());
            for (index, population) in self.populations.iter().enumerate() {
                let free = populations.contains(&index) && matches!(population.amount, Amount::Count(_));
                is_free.extend(std::iter::repeat_n(free, population.amount.count()));
            }
            if is_free.iter().any(|free| *free) {
                let fraction = self.volume(|index| populations.contains(&index)) / room.volume();
                Crowded::refuse_overfull(fraction, room)?;
                work_sharing::keep_workers_spinning(|| {
                    separate(&mut particles, &is_free, fraction, room, &mut random)
                })?;
            }
        }
        self.add_mean_flow(&mut particles);
        self.scene.let_rotate(&mut particles);
        Ok(particles)
    }

    /// Adds the mean flow of a sheared box to the velocities of the particles at random positions, which are in the
    /// order of their ids.
    fn add_mean_flow(self, particles: &mut Particles) {
        let mut first = 0;
        for population in self.populations {
            let end = first + population.amount.count();
            if matches!(population.amount, Amount::Count(_)) {
                let motions = particles.position[first..end].iter().zip(&mut particles.velocity[first..end]);
                motions.for_each(|(x, v)| *v += self.scene.domain.mean_flow(x));
            }
            first = end;
        }
    }

    /// [-] volume of all particles over the free volume of `room`, which must contain all particles.
    fn filled(self, room: &FreeRoom) -> f64 {
        self.volume(|_| true) / room.volume()
    }

    /// [m³] volume of the particles of those populations for whose index `is_meant` is true.
    fn volume(self, is_meant: impl Fn(usize) -> bool) -> f64 {
        let species = &self.scene.species;
        let meant = self.populations.iter().enumerate().filter(|(index, _)| is_meant(*index));
        let of = |population: &Population| {
            let one = &species[usize::from(population.species)];
            one.volume() * population.amount.count() as f64
        };
        meant.map(|(_, population)| of(population)).fold(0.0, |sum, volume| sum + volume)
    }
}

/// Moves the free particles (those for whose id `is_free` is true) until nothing overlaps, and then sorts all particles
/// by id. `fraction` [-] is the share of the free volume of `room` that the particles fill.
fn separate(
    particles: &mut Particles,
    is_free: &[bool],
    fraction: f64,
    room: &FreeRoom,
    random: &mut Xoshiro256PlusPlus,
) -> Result<(), Crowded> {
    let scene = &room.scene;
    let true_radius = particles.radius.clone();
    for r in &mut particles.radius {
        *r *= 1.0 + MARGIN;
    }
    // the velocities are set to zero, because neighbour lists would otherwise allow for motion
    let velocity = std::mem::replace(&mut particles.velocity, vec![Vector3::zeros(); true_radius.len()]);
    let mut list = NeighbourList::default();
    let there =
        There { region: Region::from(&scene.domain), may_move: &|id| is_free[id as usize], is_counted: &|_| true };
    let mut bad = usize::MAX;
    let largest = particles.radius.iter().copied().fold(0.0, f64::max);
    let rounds = if fraction > relax::DENSE && !room.is_slab(largest) {
        bad = relax::relax(particles, is_free, room) + strays(particles, is_free, room).len();
        0
    } else {
        ROUNDS
    };
    for round in 0..rounds {
        let overlaps;
        (overlaps, bad) = look_for_overlaps(particles, &mut list, &there, room);
        if bad == 0 || !room.spend(particles.len() as u64 + list.slots() as u64 / PER_PARTICLE) {
            break;
        }
        if fraction <= INSERTION_LIMIT {
            insert_again(particles, &overlaps, is_free, room, random);
        } else {
            if round < ROUNDS_OF_INSERTION {
                let unequal: Vec<(u32, u32)> =
                    overlaps.iter().copied().filter(|pair| are_unequal(particles, *pair)).collect();
                insert_again(particles, &unequal, is_free, room, random);
            }
            push_apart(particles, &overlaps, is_free, room);
        }
        if room.is_inside_walls() {
            draw_strays_again(particles, is_free, room, random);
        }
    }
    // frees the list, which takes more memory than the particles, before the particles are sorted
    drop(list);
    particles.sort_by_id();
    particles.radius = true_radius;
    particles.velocity = velocity;
    if bad == 0 {
        Ok(())
    } else {
        let reached = fraction * (1.0 - bad as f64 / particles.len() as f64).max(0.0);
        Err(Crowded { wanted: fraction, reached, room: room.volume(), given_up: !room.spend(0), most: None })
    }
}

/// Scope of a search for overlaps: the region, the particles that may be moved, and the positions at which overlaps are
/// counted.
struct There<'a> {
    /// Region of the domain that contains all particles of the search.
    region: Region,
    /// Function that returns true for the ids of particles that may be moved.
    may_move: &'a dyn Fn(u32) -> bool,
    /// Function that returns true for the positions [m] at which this process counts overlaps. Other processes count
    /// the overlaps elsewhere.
    is_counted: &'a dyn Fn(&Vector3<f64>) -> bool,
}

/// Finds overlapping pairs in which at least one particle may move, and sorts the particles. Returns the indices of
/// both particles of each pair. Also returns the number of overlaps, with particles and walls, that are deeper than
/// half the enlargement of the radii by [`MARGIN`]. Free particles outside the walls of their region count too.
fn look_for_overlaps(
    particles: &mut Particles,
    list: &mut NeighbourList,
    there: &There,
    room: &FreeRoom,
) -> (Vec<(u32, u32)>, usize) {
    let (scene, mut slots) = (&room.scene, Vec::new());
    // the skin is 0, because no particle moves before the next search
    list.build_in(&there.region, particles, scene, 0.0);
    list.overlapping(particles, scene, &mut slots);
    let pairs = slots.iter().take_while(|slot| (**slot as usize) < list.pairs.len());
    // pairs of particles with given positions may nearly touch, but are not moved
    let moves = |place: u32| (there.may_move)(particles.id[place as usize]);
    let counted = |place: usize| (there.is_counted)(&particles.position[place]);
    let overlaps: Vec<(u32, u32)> = pairs
        .map(|slot| (list.pairs[*slot as usize].i, list.pairs[*slot as usize].j))
        .filter(|&(i, j)| moves(i) || moves(j))
        .collect();
    // enlarged spheres separate ever more slowly, so a gap of half the enlargement is sufficient
    let deep = |&&(i, j): &&(u32, u32)| {
        let (i, j) = (i as usize, j as usize);
        let reach = (particles.radius[i] + particles.radius[j]) * (1.0 - 0.5 * MARGIN);
        let first = if particles.id[i] < particles.id[j] { i } else { j };
        counted(first)
            && scene.domain.separation(&particles.position[i], &particles.position[j]).norm_squared() < reach * reach
    };
    let sunk = |place: &usize| {
        let radius = particles.radius[*place];
        moves(*place as u32)
            && counted(*place)
            && (room.gap(&particles.position[*place], radius) < -0.5 * MARGIN * radius
                || !room.holds(&particles.position[*place]))
    };
    let bad = overlaps.iter().filter(deep).count() + (0..particles.len()).filter(sunk).count();
    (overlaps, bad)
}

/// True if one sphere has at most half the radius of the other.
fn are_unequal(particles: &Particles, (i, j): (u32, u32)) -> bool {
    let (a, b) = (particles.radius[i as usize], particles.radius[j as usize]);
    a.min(b) <= 0.5 * a.max(b)
}

/// Puts one particle of each overlapping pair at a new random position: the particle that may move, or the smaller of
/// the two if both may move. If the radii are equal, the particle with the higher id is moved. `is_free` is true for
/// the ids of particles that may move.
fn insert_again(
    particles: &mut Particles,
    overlaps: &[(u32, u32)],
    is_free: &[bool],
    room: &FreeRoom,
    random: &mut Xoshiro256PlusPlus,
) {
    for (id, place) in displaced(particles, overlaps, &|id| is_free[id as usize]) {
        if is_free[id as usize] {
            particles.position[place as usize] = room.somewhere(particles.radius[place as usize], random);
        }
    }
}

/// Ids and indices of the particles that get new random positions, one of each overlapping pair. They are sorted by id,
/// so that the new positions do not depend on the order of the store. `may_move` returns true for the id of a particle
/// that may be moved.
fn displaced(particles: &Particles, overlaps: &[(u32, u32)], may_move: &dyn Fn(u32) -> bool) -> Vec<(u32, u32)> {
    let mut again: Vec<(u32, u32)> = overlaps
        .iter()
        .map(|&(i, j)| {
            // the smaller sphere is moved, because a much larger one would find no free position among small ones
            let smallness = |place: u32| -particles.radius[place as usize];
            let rank =
                |place: u32| (may_move(particles.id[place as usize]), smallness(place), particles.id[place as usize]);
            let place = if rank(i) > rank(j) { i } else { j };
            (particles.id[place as usize], place)
        })
        .collect();
    again.sort_unstable();
    again.dedup();
    again
}

/// Puts each free particle (`is_free` is true for its id) that was pushed out of the walls of its region at a new
/// random position inside them.
fn draw_strays_again(particles: &mut Particles, is_free: &[bool], room: &FreeRoom, random: &mut Xoshiro256PlusPlus) {
    let mut strays = strays(particles, is_free, room);
    strays.sort_unstable_by_key(|&index| particles.id[index]);
    for index in strays {
        particles.position[index] = room.somewhere(particles.radius[index], random);
    }
}

/// Indices of the free particles (`is_free` is true for the id) outside the walls of their region. The list is empty if
/// the region has no walls.
fn strays(particles: &Particles, is_free: &[bool], room: &FreeRoom) -> Vec<usize> {
    let is_stray = |index: &usize| is_free[particles.id[*index] as usize] && !room.holds(&particles.position[*index]);
    (0..particles.len()).filter(is_stray).collect()
}

/// Moves overlapping particles apart along the line of their centres. The pairs are treated in turn, each at the latest
/// positions. If all pairs were moved at once, spheres with several neighbours would be pushed too far and would not
/// settle. Particles that overlap a wall are moved along its normal. Particles for whose ids `is_free` is false stay in
/// place.
fn push_apart(particles: &mut Particles, overlaps: &[(u32, u32)], is_free: &[bool], room: &FreeRoom) {
    /// [-] displacement over overlap in each round (pass over all overlaps). With a ratio of 1, the remaining overlaps
    /// would shrink but never end.
    const OVERSHOOT: f64 = 1.05;
    let scene = &room.scene;
    let mut walls = Vec::new();
    for &(i, j) in overlaps {
        let (i, j) = (i as usize, j as usize);
        let apart = scene.domain.separation(&particles.position[i], &particles.position[j]);
        let distance = apart.norm();
        let overlap = particles.radius[i] + particles.radius[j] - distance;
        // displacements are inversely proportional to the masses, so that small spheres hardly move a large one
        let smaller = particles.radius[i].min(particles.radius[j]);
        let lightness = |place: usize| (smaller / particles.radius[place]).powi(3);
        let free = |place: usize| if is_free[particles.id[place] as usize] { lightness(place) } else { 0.0 };
        let (free_i, free_j) = (free(i), free(j));
        if overlap <= 0.0 || free_i + free_j == 0.0 {
            continue;
        }
        let normal = if distance > 0.0 { apart / distance } else { Vector3::x() };
        let push = normal * (OVERSHOOT * overlap / (free_i + free_j));
        particles.position[i] += push * free_i;
        particles.position[j] -= push * free_j;
    }
    for place in 0..particles.len() {
        if scene.walls.is_empty() || !is_free[particles.id[place] as usize] {
            continue;
        }
        let radius = particles.radius[place];
        let mut position = particles.position[place];
        // a wall moves a free sphere by at most a radius, and the sphere may then overlap another wall
        room.near.list(&position, 3.0 * radius, &mut walls);
        for wall in &walls {
            // the position includes the displacements by the previous walls
            let shape = scene.walls[*wall as usize].geometry.law();
            if shape.is_clear(&position, radius) {
                continue;
            }
            let nearest = shape.nearest(&position);
            let reach = room.reach(&nearest.normal, radius);
            if nearest.distance < reach {
                position += nearest.normal * (reach - nearest.distance);
            }
        }
        particles.position[place] = position;
    }
}
