//! The granular temperature of one instant.

use crate::particles::Particles;
use nalgebra::Vector3;

/// [m²/s²] granular temperature T = Σ |v - U|²/(3 (N - S)): U is the mean velocity of the particles in the same of `slices`
/// equal slices of `height` [m] along y, S the number of slices with a particle in them, one mean taken from each.
///
/// A centre beyond the domain counts in the nearest slice. `None` where every slice holds at most one particle.
pub fn granular_temperature(particles: &Particles, slices: usize, height: f64) -> Option<f64> {
    let slices = slices.max(1);
    let mut sums = vec![(0.0, Vector3::zeros(), 0.0); slices];
    // velocities are taken off a common one first, so that squares do not cancel
    let reference = particles.velocity.first().copied().unwrap_or_default();
    for (x, v) in particles.position.iter().zip(&particles.velocity) {
        let place = (x.y / height * slices as f64).clamp(0.0, (slices - 1) as f64) as usize;
        let v = v - reference;
        let (count, sum, squares) = &mut sums[place];
        *count += 1.0;
        *sum += v;
        *squares += v.norm_squared();
    }
    let visited = sums.iter().filter(|(count, ..)| *count > 0.0);
    let (freedom, squares) = visited.fold((0.0, 0.0), |(freedom, total), (count, sum, squares)| {
        (freedom + count - 1.0, total + squares - sum.norm_squared() / count)
    });
    (freedom > 0.0).then(|| squares / (3.0 * freedom))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shear_is_no_temperature_and_few_particles_do_not_bias_it() {
        let temperature = |particles: &Particles, slices| granular_temperature(particles, slices, 1.0).unwrap();
        let mut particles = Particles::default();
        let mut push = |y: f64, v: [f64; 3]| particles.push(Vector3::new(0.0, y, 0.0), v.into(), 0.1, 1.0, 0);
        // two slices that move apart at 10 m/s, in each two particles at ±1 m/s along x: variance of x 2 about the mean of two
        for (y, w) in [(0.2, 100.0), (0.8, 110.0)] {
            push(y, [1.0, 0.0, w]);
            push(y, [-1.0, 0.0, w]);
        }
        assert!((temperature(&particles, 2) - 2.0 / 3.0).abs() < 1e-12);
        assert!((temperature(&particles, 1) - (4.0 + 100.0) / 9.0).abs() < 1e-12);
        // one beyond the box belongs to the nearest slice
        particles.position[3].y = 1.2;
        assert!((temperature(&particles, 2) - 2.0 / 3.0).abs() < 1e-12);
        assert!(temperature(&particles, 1) > 1.0);
        particles.position[0].y = -0.1;
        // one alone in its slice tells nothing
        assert!(granular_temperature(&particles, 1000, 1.0).is_none());
        assert!(granular_temperature(&Particles::default(), 4, 1.0).is_none());
    }
}
