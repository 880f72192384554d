//! Initial positions of the particles.
//!
//! Random positions without overlap, equal for every model. The method is sequential insertion while that is quick.
//! At higher density random positions are pushed apart until nothing overlaps, and the densest starts use a
//! relaxation of all particles at once.

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
use crate::scene::StartRegion;
use crate::work_sharing;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use room::{FreeRoom, regions};

/// [-] volume fraction above which insertion gets slow: random sequential addition of spheres jams at 0.382 (Talbot,
/// Schaaf & Tarjus 1991).
const INSERTION_LIMIT: f64 = 0.2;

/// Number of rounds before a placement is given up.
const ROUNDS: usize = 5000;

/// Number of rounds in which spheres within much larger ones draw a new position, where all are pushed apart. Without
/// them crowds around the larger spheres remain, which take long to spread. After eight rounds fewer than one in 10⁴
/// is still within a larger sphere at a volume fraction of 0.3.
const ROUNDS_OF_INSERTION: usize = 8;

/// Pairs of a list that count as much effort as one particle of a round: about as many as a particle has in a dense
/// start.
const PER_PARTICLE: u64 = 32;

/// [-] fraction by which spheres are enlarged during placement, so that none start in touch; half of it remains as a
/// gap.
const MARGIN: f64 = 1e-3;

/// A start that could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{}: the particles fill {wanted:.3e} of the {room:.3e} m^3 that walls and bodies in the box leave them, and {}; ask for fewer particles, make that room larger (a larger box around a vessel is of no use), or give positions in a file",
    self.what(),
    self.bound()
)]
pub struct Crowded {
    /// [-] volume of the particles over that of their room.
    pub wanted: f64,
    /// [-] volume of the particles that overlap nothing over that of their room.
    pub reached: f64,
    /// [m³] free volume of the room.
    pub room: f64,
    /// True if the search was given up for its effort before all rounds were done.
    pub given_up: bool,
    /// [-] volume fraction that no arrangement of these spheres exceeds, if they are to fill more.
    pub most: Option<f64>,
}

impl Crowded {
    fn what(&self) -> String {
        match self.most {
            Some(_) => "there is no random start".into(),
            None => format!("no random start without overlap found after {ROUNDS} rounds"),
        }
    }

    fn bound(&self) -> String {
        match self.most {
            Some(most) => format!("no arrangement of such spheres more than {most:.3e}"),
            None => format!("those that overlap nothing {:.3e}", self.reached),
        }
    }

    /// Refuses particles that fill more of their room than any arrangement does, before any is sought.
    fn refuse_overfull(wanted: f64, room: &FreeRoom) -> Result<(), Self> {
        let most = room.most();
        if wanted <= most {
            return Ok(());
        }
        Err(Self { wanted, reached: 0.0, room: room.volume(), given_up: false, most: Some(most) })
    }
}

/// The initial state: equal for every model, made from the seed alone.
///
/// # Errors
/// If random positions without overlap are not found in a bounded number of rounds.
pub fn initial_state(experiment: &Experiment) -> Result<Particles, Crowded> {
    initial_state_within(experiment, u64::MAX)
}

/// The initial state, given up after a limited `effort`, for a caller that only tests whether a start is found soon.
/// A position tried for a sphere counts 1, a round over all particles their number.
///
/// # Errors
/// If random positions without overlap are not found with that effort.
pub fn initial_state_within(experiment: &Experiment, effort: u64) -> Result<Particles, Crowded> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(experiment.run.seed);
    let regions = regions(&experiment.start);
    let room_in =
        |region: &Option<StartRegion>| FreeRoom::within(&experiment.scene, region.as_ref()).with_effort(effort);
    let rooms: Vec<FreeRoom> = regions.iter().map(|(region, _)| room_in(region)).collect();
    let region_of = |population: usize| regions.iter().position(|(_, of)| of.contains(&population)).unwrap_or_default();
    let room_of: Vec<&FreeRoom> = (0..experiment.start.len()).map(|population| &rooms[region_of(population)]).collect();
    let mut particles = draw::draw(experiment, &room_of, &mut random, &|_| true);
    // particles of one region are moved while all others stay
    for ((_, populations), room) in regions.iter().zip(&rooms) {
        let mut is_free = Vec::with_capacity(particles.len());
        for (index, population) in experiment.start.iter().enumerate() {
            let free = populations.contains(&index) && matches!(population.amount, Amount::Count(_));
            is_free.extend(std::iter::repeat_n(free, population.amount.count()));
        }
        if is_free.iter().any(|free| *free) {
            let fraction = volume(experiment, |index| populations.contains(&index)) / room.volume();
            Crowded::refuse_overfull(fraction, room)?;
            work_sharing::keep_workers_spinning(|| separate(&mut particles, &is_free, fraction, room, &mut random))?;
        }
    }
    experiment.scene.let_rotate(&mut particles);
    Ok(particles)
}

/// [-] volume of all particles over the free volume of a room that has all of them.
fn filled(experiment: &Experiment, room: &FreeRoom) -> f64 {
    volume(experiment, |_| true) / room.volume()
}

/// [m³] volume of the particles of some populations, by index.
fn volume(experiment: &Experiment, is_meant: impl Fn(usize) -> bool) -> f64 {
    let species = &experiment.scene.species;
    let meant = experiment.start.iter().enumerate().filter(|(index, _)| is_meant(*index));
    let of = |population: &Population| {
        let one = &species[usize::from(population.species)];
        one.volume() * population.amount.count() as f64
    };
    meant.map(|(_, population)| of(population)).fold(0.0, |sum, volume| sum + volume)
}

/// Moves the free particles until nothing overlaps, and returns them in the order of ids. They fill `fraction` [-] of
/// the room.
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
    // at rest while the list is built: only positions matter here
    let velocity = std::mem::replace(&mut particles.velocity, vec![Vector3::zeros(); true_radius.len()]);
    let mut list = NeighbourList::default();
    let there =
        There { region: Region::from(&scene.domain), may_move: &|id| is_free[id as usize], is_counted: &|_| true };
    let mut bad = usize::MAX;
    let largest = particles.radius.iter().copied().fold(0.0, f64::max);
    let rounds = if fraction > relax::DENSE && !room.is_slab(largest) {
        bad = relax::relax(particles, is_free, room);
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
    // the list takes more memory than the particles, which can use it after this
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

/// Particles that a search for overlaps considers.
struct There<'a> {
    /// Region that holds the particles.
    region: Region,
    /// True for the ids of particles that may be moved.
    may_move: &'a dyn Fn(u32) -> bool,
    /// True for positions [m] that are counted here, and not by another process.
    is_counted: &'a dyn Fn(&Vector3<f64>) -> bool,
}

/// Pairs, by index, that overlap and of which at least one particle may move. Also the number of such overlaps, with
/// particles and with walls, that are deeper than allowed. Sorts the particles.
fn look_for_overlaps(
    particles: &mut Particles,
    list: &mut NeighbourList,
    there: &There,
    room: &FreeRoom,
) -> (Vec<(u32, u32)>, usize) {
    let (scene, mut slots) = (&room.scene, Vec::new());
    // nothing moves before the next search
    list.build_in(&there.region, particles, scene, 0.0);
    list.overlapping(particles, scene, &mut slots);
    let pairs = slots.iter().take_while(|slot| (**slot as usize) < list.pairs.len());
    // placed particles may nearly touch: they stay as they are
    let moves = |place: u32| (there.may_move)(particles.id[place as usize]);
    let counted = |place: usize| (there.is_counted)(&particles.position[place]);
    let overlaps: Vec<(u32, u32)> = pairs
        .map(|slot| (list.pairs[*slot as usize].i, list.pairs[*slot as usize].j))
        .filter(|&(i, j)| moves(i) || moves(j))
        .collect();
    // pushing apart approaches touch of the enlarged spheres without reaching it
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

/// True if one sphere is at most half as large as the other.
fn are_unequal(particles: &Particles, (i, j): (u32, u32)) -> bool {
    let (a, b) = (particles.radius[i as usize], particles.radius[j as usize]);
    a.min(b) <= 0.5 * a.max(b)
}

/// Draws a new position for one particle of each overlapping pair: the smaller of those that may move, or the later
/// of equal ones.
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

/// Ids and indices of particles that draw a new position, in the order of ids, so that the draw does not depend on
/// the order of the store.
fn displaced(particles: &Particles, overlaps: &[(u32, u32)], may_move: &dyn Fn(u32) -> bool) -> Vec<(u32, u32)> {
    let mut again: Vec<(u32, u32)> = overlaps
        .iter()
        .map(|&(i, j)| {
            // a much larger sphere finds no position among small ones that have theirs
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

/// Draws a new position for each particle that was pushed out of the walls around its region.
fn draw_strays_again(particles: &mut Particles, is_free: &[bool], room: &FreeRoom, random: &mut Xoshiro256PlusPlus) {
    let is_stray = |particles: &Particles, place: usize| {
        is_free[particles.id[place] as usize] && !room.holds(&particles.position[place])
    };
    let mut strays: Vec<usize> = (0..particles.len()).filter(|&place| is_stray(particles, place)).collect();
    strays.sort_unstable_by_key(|&place| particles.id[place]);
    for place in strays {
        particles.position[place] = room.somewhere(particles.radius[place], random);
    }
}

/// Moves overlapping particles apart along the line of centres, one pair after the other, each from its latest
/// position. If all moved at once, the sum of the pushes would throw a sphere among several others too far, and it
/// would never settle. Walls push back.
fn push_apart(particles: &mut Particles, overlaps: &[(u32, u32)], is_free: &[bool], room: &FreeRoom) {
    /// A little more than needed, or the last overlaps would shrink for ever.
    const OVERSHOOT: f64 = 1.05;
    let scene = &room.scene;
    let mut walls = Vec::new();
    for &(i, j) in overlaps {
        let (i, j) = (i as usize, j as usize);
        let apart = scene.domain.separation(&particles.position[i], &particles.position[j]);
        let distance = apart.norm();
        let overlap = particles.radius[i] + particles.radius[j] - distance;
        // weighted as if by mass, so that a large sphere stays among the small ones it parts
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
        // if its centre is free, one wall pushes it by at most a radius, and then another may be in the way
        room.near.list(&position, 3.0 * radius, &mut walls);
        for wall in &walls {
            // from the position after the last wall
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
