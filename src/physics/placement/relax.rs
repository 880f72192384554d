//! Dense starts: overlapping spheres repel each other like soft spheres until no overlap is left.

use super::{FreeRoom, MARGIN, PER_PARTICLE, ROUNDS};
use crate::encounter::FrameTime;
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use crate::scene::Scene;
use crate::work_sharing;
use nalgebra::Vector3;

/// [-] volume fraction above which relaxation needs fewer rounds (passes over all overlaps) than pushing pairs apart in
/// turn. Relaxation reaches volume fractions up to 0.62 (`tests/stress.rs`). Random packings jam at 0.64.
pub const DENSE: f64 = 0.55;

/// [-] longest time step in units of sqrt(mass/stiffness), where mass and stiffness are 1. With 1 in place of 0.5, a
/// volume fraction of 0.62 needs four times as many steps.
const LONGEST: f64 = 0.5;

/// [-] fraction by which the radii of particles with given positions are enlarged while they are pushed apart. It is
/// small, so that particles are moved hardly farther than needed.
const PLACED_MARGIN: f64 = 1e-4;

/// Largest displacement of any particle from its given position, and the id of this particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// [m] distance of the particle's new position from its given position.
    pub farthest: f64,
    /// Id of the particle with the largest displacement.
    pub id: u32,
}

/// Pushes overlapping particles apart, and away from walls, until nothing overlaps. The velocities do not change. The
/// id of each particle must be its index; this order is kept.
///
/// # Errors
/// The number of remaining overlaps, if no arrangement without overlap was found.
pub fn push_placed_apart(particles: &mut Particles, scene: &Scene) -> Result<Moved, usize> {
    let room = FreeRoom::of(scene);
    let given = particles.clone();
    particles.radius.iter_mut().for_each(|radius| *radius *= 1.0 + PLACED_MARGIN);
    particles.velocity.fill(Vector3::zeros());
    let left =
        work_sharing::keep_workers_spinning(|| push_apart(particles, &vec![true; given.len()], &room, PLACED_MARGIN));
    particles.sort_by_id();
    (particles.radius, particles.velocity) = (given.radius, given.velocity);
    if left > 0 {
        return Err(left);
    }
    let way = |k: usize| scene.domain.separation(&particles.position[k], &given.position[k]).norm();
    let mut moved = Moved { farthest: 0.0, id: 0 };
    for k in 0..particles.len() {
        if way(k) > moved.farthest {
            moved = Moved { farthest: way(k), id: k as u32 };
        }
    }
    Ok(moved)
}

/// Moves the free particles (those for whose id `is_free` is true) until nothing overlaps. Their velocities must be
/// zero. Returns the number of remaining overlaps deeper than half of the enlargement of the radii by [`MARGIN`].
///
/// The method is FIRE (Bitzek et al. 2006, Phys. Rev. Lett. 97, 170201, with its constants). It solves Newton's
/// equations for spheres with the same mass and repelling springs of the same stiffness, and turns the velocities
/// towards the forces. When the forces do negative work, all velocities are set to zero.
pub fn relax(particles: &mut Particles, is_free: &[bool], room: &FreeRoom) -> usize {
    push_apart(particles, is_free, room, MARGIN)
}

/// Moves the free particles (those for whose id `is_free` is true) until no overlap is too deep, and returns the number
/// of overlaps that are still too deep. The caller has already enlarged the radii by the fraction `margin` [-]. An
/// overlap is too deep if it exceeds half of this enlargement.
fn push_apart(particles: &mut Particles, is_free: &[bool], room: &FreeRoom, margin: f64) -> usize {
    let scene = &room.scene;
    let (mut list, mut slots) = (NeighbourList::default(), Vec::new());
    let mut force = vec![Vector3::zeros(); particles.len()];
    let (mut dt, mut turn, mut downhill) = (0.1 * LONGEST, 0.1, 0);
    let mut deep = usize::MAX;
    for _ in 0..ROUNDS {
        if !list.allows(0.0) {
            list.build(particles, scene, dt);
        }
        list.overlapping(particles, scene, &mut slots);
        deep = overlaps(&list, &slots, (particles, scene), (is_free, margin), &mut force);
        if deep == 0 || !room.spend(particles.len() as u64 + list.slots() as u64 / PER_PARTICLE) {
            break;
        }
        for (force, id) in force.iter_mut().zip(&particles.id) {
            if !is_free[*id as usize] {
                *force = Vector3::zeros();
            }
        }
        let velocity = &mut particles.velocity;
        let sum = |a: &[Vector3<f64>], b: &[Vector3<f64>]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
        if sum(&force, velocity) > 0.0 {
            let along = turn * (sum(velocity, velocity) / sum(&force, &force)).sqrt();
            velocity.iter_mut().zip(&force).for_each(|(v, f)| *v = *v * (1.0 - turn) + f * along);
            downhill += 1;
            if downhill > 5 {
                (dt, turn) = ((1.1 * dt).min(LONGEST), 0.99 * turn);
            }
        } else {
            velocity.fill(Vector3::zeros());
            (dt, turn, downhill) = (0.5 * dt, 0.1, 0);
        }
        velocity.iter_mut().zip(&force).for_each(|(v, f)| *v += f * dt);
        let frame = list.frame();
        list.travel(particles.largest_speed(frame) * dt);
        for (x, v) in particles.position.iter_mut().zip(&particles.velocity) {
            *x += v * dt;
        }
    }
    particles.wrap(&scene.domain);
    deep
}

/// Sums the repulsive forces on each particle into `force`. The force of an overlap is the overlap [m] times the unit
/// normal; overlaps without a free particle are left out. Returns the number of overlaps that are deeper than half of
/// `margin` [-] times the sum of the enlarged radii (at a wall, times the one radius).
fn overlaps(
    list: &NeighbourList,
    slots: &[u32],
    (particles, scene): (&Particles, &Scene),
    (is_free, margin): (&[bool], f64),
    force: &mut [Vector3<f64>],
) -> usize {
    force.fill(Vector3::zeros());
    let mut deep = 0;
    for &slot in slots {
        let couple = list.couple(slot as usize);
        let met = couple.meet(particles, scene, FrameTime::default());
        // pairs of fixed particles may nearly touch, but are not moved
        if !couple.indices().into_iter().flatten().any(|index| is_free[particles.id[index as usize] as usize]) {
            continue;
        }
        let reach: f64 = couple.indices().into_iter().flatten().map(|index| particles.radius[index as usize]).sum();
        deep += usize::from(met.overlap() > 0.5 * margin * reach);
        force[couple.i as usize] += met.normal * met.overlap();
        if let Some(j) = couple.j() {
            force[j as usize] -= met.normal * met.overlap();
        }
    }
    deep
}
