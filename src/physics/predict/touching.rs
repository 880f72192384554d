//! Tests of the initial state: particles that overlap, lie on something, or nearly touch more than one neighbour.

use super::rest::ALL_PAIRS;
use crate::encounter::{FrameTime, Other};
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use crate::scene::Scene;

/// [-] gap between two neighbours at the start, over the overlap of an impact, below which the contacts of a sphere
/// with both neighbours overlap in time. The number follows from solutions of the three-sphere equations. Three spheres
/// in a row with gaps of twice u sqrt(m/k) (speed u, mass m, stiffness k) agree with a sequence of two impacts to 1e-6.
/// With half of these gaps they differ by more than 1e-2.
const SEPARATE: f64 = 2.0;

/// True if spheres overlap each other or a wall by more than the rounding of positions.
pub fn overlapping(scene: &Scene, particles: &Particles) -> bool {
    /// [-] largest overlap that counts as rounding of typed positions, divided by the diameter.
    const ROUNDING: f64 = 1e-9;
    let mut list = NeighbourList::default();
    let mut sorted = particles.clone();
    list.build(&mut sorted, scene, 0.0);
    let mut slots = Vec::new();
    list.overlapping(&sorted, scene, &mut slots);
    slots.iter().any(|&slot| {
        let couple = list.couple(slot as usize);
        couple.meet(&sorted, scene, FrameTime::default()).overlap() > ROUNDING * couple.diameter(&sorted)
    })
}

/// Number of particles that lie on a wall or on another particle. The gap below such a particle is less than a
/// thousandth of its diameter. Neither of the two bodies may be faster than after a fall through this gap. `given`
/// contains, for each id, true if the case gives the position. Particles at random positions are not counted, because
/// they may be this close by chance.
pub fn lying(scene: &Scene, particles: &Particles, given: &[bool]) -> usize {
    /// [-] largest gap below a particle that counts as lying, over its diameter. Overlaps of glass beads of 1 mm at 10
    /// kN/m are 1e-6 of a diameter under their weight, and 1e-3 under a thousand layers.
    const NEAR: f64 = 1e-3;
    let mut list = NeighbourList::default();
    let mut sorted = particles.clone();
    list.build(&mut sorted, scene, 0.0);
    let near = |i: usize| 2.0 * NEAR * sorted.radius[i];
    let given = |i: usize| given.get(sorted.id[i] as usize).is_some_and(|given| *given);
    let slow = |i: usize| given(i) && sorted.velocity[i].norm_squared() <= 2.0 * scene.gravity.norm() * near(i);
    let mut lies = vec![false; sorted.len()];
    for couple in (0..list.slots()).map(|slot| list.couple(slot)) {
        let met = couple.meet(&sorted, scene, FrameTime::default());
        let i = Some(couple.i as usize);
        let other = match couple.other {
            Other::Particle(j) => Some(j as usize),
            Other::Wall(_) => None,
        };
        let all_slow = i.into_iter().chain(other).all(slow);
        let close = i.into_iter().chain(other).any(|i| met.overlap() > -near(i));
        let held = -scene.gravity.dot(&met.normal);
        if all_slow && close && held != 0.0 {
            // the upper particle of a pair lies on the lower one
            let upper = if held > 0.0 { i } else { other };
            upper.into_iter().for_each(|i| lies[i] = true);
        }
    }
    lies.into_iter().filter(|lies| *lies).count()
}

/// True if some particle at the start has two neighbours (or a neighbour and a wall) so close that an impact has
/// contacts with both at the same time. `overlap` [m] is the overlap of such an impact. Hard spheres would transmit
/// the impulse in several successive collisions instead. The test is for starts with given positions, since particles
/// at random positions are farther apart. More than 2000 particles are not tested, and the result is then false.
pub fn in_a_row(scene: &Scene, particles: &Particles, overlap: f64) -> bool {
    let count = particles.len();
    if count > ALL_PAIRS {
        return false;
    }
    let near = SEPARATE * overlap.max(1e-9 * particles.radius.iter().fold(0.0, |a: f64, &r| a.max(r)));
    (0..count).any(|i| {
        let (x, r) = (&particles.position[i], particles.radius[i]);
        let beside = (0..count).filter(|&j| {
            let apart = scene.domain.separation(x, &particles.position[j]).norm();
            j != i && apart - r - particles.radius[j] < near
        });
        let walls = scene.walls.iter().filter(|wall| wall.geometry.nearest(x).distance - r < near);
        beside.count() + walls.count() > 1
    })
}
