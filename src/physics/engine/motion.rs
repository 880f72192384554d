//! Straight motion of all particles at once, used by several engines.
//!
//! Within a window (time between two exchanges with the gas) an engine uses the frame that falls freely with gravity
//! from rest. In this frame, particles without contact fly straight at constant velocity. Gravity then needs no
//! computation per step, and it is exact.

use crate::particles::{CHUNK, Particles};
use crate::work_sharing;

use nalgebra::Vector3;

/// Number of particles that a thread moves as one piece of work. With larger pieces, the other threads would wait
/// longer for the last one.
const PART: usize = CHUNK / 4;

/// Moves every particle: position x += v dt + shift. The velocities v belong to a frame that falls with gravity, and
/// `shift` [m] is the distance by which this frame falls in the time `dt` [s].
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

/// Changes every velocity: v += `change` [m/s]. The engines use the function to return from the falling frame to the
/// frame at rest.
pub fn accelerate(particles: &mut Particles, change: Vector3<f64>) {
    if change != Vector3::zeros() {
        work_sharing::for_each(particles.velocity.chunks_mut(CHUNK), |part| part.iter_mut().for_each(|v| *v += change));
    }
}
