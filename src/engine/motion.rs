//! Motion shared by engines that move all particles at once.
//!
//! Within a window an engine works in the frame that falls freely with gravity from rest. In this frame particles
//! without contact fly straight at constant velocity. Gravity costs nothing per particle there, and it is exact.

use crate::particles::{CHUNK, Particles};
use crate::work_sharing;

use nalgebra::Vector3;

/// Particles that a thread moves at a time: a quarter of a chunk, because with few chunks a thread would wait for the
/// last.
const PART: usize = CHUNK / 4;

/// x += v dt + shift for every particle; `shift` [m] is the fall of the frame in this time.
pub fn drift(particles: &mut Particles, dt: f64, shift: Vector3<f64>) {
    let each = |positions: &mut [Vector3<f64>], velocities: &[Vector3<f64>]| {
        for (x, v) in positions.iter_mut().zip(velocities) {
            *x += v * dt + shift;
        }
    };
    if particles.len() <= 2 * CHUNK {
        each(&mut particles.position, &particles.velocity);
    } else {
        let parts = particles.position.chunks_mut(PART).zip(particles.velocity.chunks(PART));
        work_sharing::for_each(parts, |(x, v)| each(x, v));
    }
}

/// v += change [m/s] for every particle: leaves the falling frame.
pub fn accelerate(particles: &mut Particles, change: Vector3<f64>) {
    if change != Vector3::zeros() {
        work_sharing::for_each(particles.velocity.chunks_mut(CHUNK), |part| part.iter_mut().for_each(|v| *v += change));
    }
}
