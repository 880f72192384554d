//! Collisions by chance: in each cell, pairs of particles that are chosen at random collide.

use super::cells::Crowding;
use crate::encounter::{Couple, Encounter};
use crate::engine::hard::Collision;
use crate::particles::Particles;
use crate::record::Log;
use crate::scene::Scene;
use crate::walls::perpendicular;
use nalgebra::Vector3;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, Exp1, UnitDisc};
use std::f64::consts::PI;

/// Data of one cell, on which the collisions of its particles depend.
#[derive(Clone, Copy)]
pub struct CellState<'a> {
    /// All particles of the run.
    pub particles: &'a Particles,
    /// Scene of the run.
    pub scene: &'a Scene,
    /// Indices of the particles of this cell, as numbered in the particle store.
    pub members: &'a [u32],
    /// [m³] part of the cell's volume in which centres of the smallest particles can be.
    pub open: f64,
    /// Local volume fraction, from which the Enskog factor (collision rate over that of a dilute gas) follows; `None`
    /// if that factor is left out.
    pub crowding: Option<Crowding>,
    /// Radius [m] of all particles of the run if their radii are equal; `None` if the radii differ.
    pub radius: Option<f64>,
}

/// Results of the collisions in several cells, before they are written to the particle store.
#[derive(Default)]
pub struct CellCollisions {
    /// Index in the particle store, new velocity [m/s] and new spin [rad/s] of each particle that collided. If a
    /// particle is listed more than once, its last entry is valid.
    pub changed: Vec<(u32, Vector3<f64>, Vector3<f64>)>,
    /// Impacts and energies of the collisions, for the record of the run.
    pub log: Log,
    /// Number of pairs that were chosen at random as candidates for a collision; not all of them collide.
    pub drawn: u64,
    /// [1/s] sum of the expected collision rates of all particles in the cells, which is twice the expected number of
    /// collisions per time. If the radii differ, it is an upper limit, because each pair is given the cross-section of
    /// the largest particles in its cell.
    pub rate: f64,
    /// True if the velocity of a particle in the cells is not a finite number, so that the collisions are not valid.
    pub broken: bool,
}

/// Scratch memory of a thread, used for the collisions in one cell after another.
#[derive(Default)]
pub struct CellMemory {
    velocity: Vec<Vector3<f64>>,
    spin: Vec<Vector3<f64>>,
    /// Store with copies of the two particles of a collision.
    pair: Particles,
}

/// Makes the particles of a cell collide at random for a time of `duration` [s], and adds the results to `into`; the
/// positions do not change. `noise` supplies the random numbers that determine the pairs and their impact parameters.
pub fn collide(
    cell: &CellState,
    duration: f64,
    noise: &mut ChaCha8Rng,
    memory: &mut CellMemory,
    into: &mut CellCollisions,
) {
    let count = cell.members.len();
    if count < 2 {
        return;
    }
    let CellMemory { velocity, spin, pair } = memory;
    velocity.clear();
    velocity.extend(cell.members.iter().map(|&index| cell.particles.velocity[index as usize]));
    let rotating = cell.particles.spin.is_some();
    spin.clear();
    if rotating {
        spin.extend(cell.members.iter().map(|&index| cell.particles.spin_of(index as usize)));
    }
    let number = count as f64;
    let mean = velocity.iter().sum::<Vector3<f64>>() / number;
    let (squares, mut farthest) = velocity.iter().fold((0.0, 0.0_f64), |(sum, most), v| {
        let square = (v - mean).norm_squared();
        (sum + square, most.max(square))
    });
    // a maximum ignores values that are not numbers, so the sum is tested
    if !squares.is_finite() {
        into.broken = true;
        return;
    }
    let radius_of = |k: usize| cell.particles.radius[cell.members[k] as usize];
    let largest = cell.radius.unwrap_or_else(|| (0..count).map(radius_of).fold(0.0, f64::max));
    let section = |radii: [f64; 2]| {
        let reach = radii[0] + radii[1];
        PI * reach * reach * cell.crowding.map_or(1.0, |crowding| crowding.contact_value(radii))
    };
    let largest_section = section([largest; 2]);
    // number of pairs, times cross-section, divided by volume
    let pairs = 0.5 * number * (number - 1.0) * largest_section / cell.open;
    // Chapman & Cowling 1970, 5.21: the mean relative speed is 4 sqrt(T/π)
    into.rate += 2.0 * pairs * 4.0 * (squares / (3.0 * (number - 1.0)) / PI).sqrt();
    let mut time = 0.0;
    loop {
        // no relative speed exceeds twice the largest speed relative to the mean velocity
        let fastest = 2.0 * farthest.sqrt();
        time += noise.sample::<f64, _>(Exp1) / (pairs * fastest);
        // without relative motion the time is infinite or not a number
        if time.is_nan() || time >= duration {
            return;
        }
        into.drawn += 1;
        let (i, other) = (noise.random_range(0..count), noise.random_range(0..count - 1));
        let j = if other < i { other } else { other + 1 };
        let relative = velocity[i] - velocity[j];
        let speed = relative.norm();
        let own = if cell.radius.is_some() { largest_section } else { section([radius_of(i), radius_of(j)]) };
        if noise.random::<f64>() * largest_section * fastest >= own * speed {
            continue;
        }
        take_pair(cell, [i, j], (velocity, spin), pair);
        let collision = by_chance(pair, relative, speed, noise);
        collision.resolve(pair, cell.scene, 0.0, &mut into.log);
        for (k, &member) in [i, j].iter().enumerate() {
            velocity[member] = pair.velocity[k];
            if rotating {
                spin[member] = pair.spin_of(k);
            }
            farthest = farthest.max((velocity[member] - mean).norm_squared());
            into.changed.push((cell.members[member], pair.velocity[k], pair.spin_of(k)));
        }
    }
}

/// Copies two members of a cell, given by their numbers in the cell, into the store `pair`. Their velocities [m/s] and
/// spins [rad/s] are taken from `velocity` and `spin`, which earlier collisions of this step have changed.
fn take_pair(
    cell: &CellState,
    members: [usize; 2],
    (velocity, spin): (&[Vector3<f64>], &[Vector3<f64>]),
    pair: &mut Particles,
) {
    pair.clear();
    pair.copy_from(cell.particles, &members.map(|member| cell.members[member]));
    for (k, member) in members.into_iter().enumerate() {
        pair.velocity[k] = velocity[member];
        if let (Some(of_pair), Some(spin)) = (&mut pair.spin, spin.get(member)) {
            of_pair[k] = *spin;
        }
    }
}

/// Chooses at random the geometry of a collision of the two particles in the store `pair`. `relative` [m/s] is the
/// velocity of the first relative to the second, and `speed` [m/s] the magnitude of `relative`. The impact parameter is
/// uniform over the cross-section of the pair.
fn by_chance(pair: &Particles, relative: Vector3<f64>, speed: f64, noise: &mut ChaCha8Rng) -> Collision {
    let along = relative / speed;
    let (aside, across) = perpendicular(&along);
    let [a, b]: [f64; 2] = UnitDisc.sample(noise);
    // unit vector from the second particle to the first; the relative velocity points against it
    let normal = aside * a + across * b - along * (1.0 - a * a - b * b).sqrt();
    let met = Encounter { normal, gap: 0.0, velocity: relative, normal_velocity: relative.dot(&normal) };
    let couple = Couple::pair(0, 1);
    Collision { couple, met, elastic: false, kinds: couple.kinds(pair), wall: None, image: 0.0 }
}
