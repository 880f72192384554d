//! Motion shared by engines that move all particles at once.
//!
//! Within a window an engine works in the frame that falls freely with gravity from rest: there particles without
//! contact fly straight at constant velocity, gravity costs nothing per particle, and it is exact.

use crate::particles::{CHUNK, Particles};
use nalgebra::Vector3;
use rayon::prelude::*;

/// x += v dt + shift for every particle: `shift` [m] is the fall of the frame meanwhile.
pub fn drift(particles: &mut Particles, dt: f64, shift: Vector3<f64>) {
    let each = |positions: &mut [Vector3<f64>], velocities: &[Vector3<f64>]| {
        for (x, v) in positions.iter_mut().zip(velocities) {
            *x += v * dt + shift;
        }
    };
    if particles.len() <= 2 * CHUNK {
        each(&mut particles.position, &particles.velocity);
    } else {
        let velocities = particles.velocity.par_chunks(CHUNK);
        particles.position.par_chunks_mut(CHUNK).zip(velocities).for_each(|(x, v)| each(x, v));
    }
}

/// v += change for every particle [m/s]: leaves the falling frame.
pub fn accelerate(particles: &mut Particles, change: Vector3<f64>) {
    if change != Vector3::zeros() {
        particles.velocity.par_chunks_mut(CHUNK).for_each(|chunk| {
            for v in chunk {
                *v += change;
            }
        });
    }
}

/// [s] when two spheres in straight flight first touch: the smaller root of |r + u t| = reach, separation r [m], relative
/// velocity u [m/s]. Spheres that overlap (by rounding) and approach touch now, 0; those that separate do not touch
/// again. `speeds` [m/s] is the sum of both speeds: an approach slower than its rounding is none.
#[inline]
pub fn first_touch(apart: &Vector3<f64>, velocity: &Vector3<f64>, reach: f64, speeds: f64) -> Option<f64> {
    let closing = -apart.dot(velocity);
    if closing <= 0.0 {
        return None;
    }
    let gap_square = apart.norm_squared() - reach * reach;
    let discriminant = closing * closing - velocity.norm_squared() * gap_square;
    if discriminant < 0.0 || closing <= 4.0 * f64::EPSILON * apart.norm() * speeds {
        return None;
    }
    if gap_square <= 0.0 {
        return Some(0.0);
    }
    Some(gap_square / (closing + discriminant.sqrt()))
}
