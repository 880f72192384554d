//! Order of particles along Morton's curve, which visits all small cubes of the box one after the other. With this
//! order, particles that are neighbours in space are near each other in memory.

use crate::domain::Domain;
use crate::particles::Particles;
use nalgebra::Vector3;
use rayon::prelude::*;

/// Number of bits of a cube's number along each axis; with ten bits there are about a thousand cubes along the longest
/// edge of the box.
const BITS: u32 = 10;

/// Indices of the particles in the order in which Morton's curve meets their positions. All positions must be inside
/// the box.
pub fn order(particles: &Particles, domain: &Domain) -> Vec<u32> {
    let cells = f64::from(1u32 << BITS);
    // cells are cubes, because flat cells would cut a long box into slices
    let scale = cells / domain.size.max();
    let key = |x: &Vector3<f64>| {
        (0..3).fold(0u32, |key, axis| key | spread((x[axis] * scale).clamp(0.0, cells - 1.0) as u32) << axis)
    };
    let mut order: Vec<(u32, u32, u32)> = (particles.position.iter().zip(&particles.id))
        .enumerate()
        .map(|(index, (x, &id))| (key(x), id, index as u32))
        .collect();
    order.par_sort_unstable();
    order.into_iter().map(|(.., index)| index).collect()
}

/// Inserts two zero bits after each of the lowest ten bits of a number. Three such numbers, one per axis, are then
/// combined to the position along Morton's curve.
fn spread(bits: u32) -> u32 {
    let bits = (bits | bits << 16) & 0x0300_00ff;
    let bits = (bits | bits << 8) & 0x0300_f00f;
    let bits = (bits | bits << 4) & 0x030c_30c3;
    (bits | bits << 2) & 0x0924_9249
}
