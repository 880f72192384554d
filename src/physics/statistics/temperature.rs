//! Variance of the velocities at one instant, and the granular temperature.

use crate::particles::Sample;
use nalgebra::Vector3;

/// Number of particles in one slice, and sums of their velocities and squared velocities. Velocities are relative to a
/// common reference, so that variances are not small differences of large numbers.
#[derive(Clone, Copy, Debug, Default)]
struct VelocitySums {
    count: f64,
    sum: Vector3<f64>,
    squares: Vector3<f64>,
}

impl VelocitySums {
    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.sum += other.sum;
        self.squares += other.squares;
    }
}

impl From<[f64; 8]> for VelocitySums {
    fn from([count, x, y, z, xx, yy, zz, _]: [f64; 8]) -> Self {
        Self { count, sum: Vector3::new(x, y, z), squares: Vector3::new(xx, yy, zz) }
    }
}

/// Sums of velocities at one instant in equal slices along y. A particle whose centre is outside the box counts in the
/// nearest slice.
#[derive(Clone, Debug)]
pub struct VelocitySpread {
    reference: Vector3<f64>,
    slices: Vec<VelocitySums>,
}

impl VelocitySpread {
    /// Sums of velocities in `slices` slices of a box with the height `height` [m] along y. The result depends neither
    /// on the number of threads nor on the order of the particles.
    pub fn of<'a>(sample: impl Into<Sample<'a>>, slices: usize, height: f64) -> Self {
        let sample = sample.into();
        Self::about(sample.mean_velocity(), sample, slices, height)
    }

    /// Sums of velocities in `slices` slices of a box with the height `height` [m] along y. Velocities are relative to
    /// the velocity `reference` [m/s], which should be near the mean.
    pub fn about<'a>(reference: Vector3<f64>, sample: impl Into<Sample<'a>>, slices: usize, height: f64) -> Self {
        let sample = sample.into();
        let particles = sample.particles;
        let slices = slices.max(1);
        let (per_length, last) = (slices as f64 / height, (slices - 1) as f64);
        let sums = sample.sums_in_groups(slices, |place| {
            let v = particles.velocity[place] - reference;
            let slice = (particles.position[place].y * per_length).clamp(0.0, last) as usize;
            (slice, [1.0, v.x, v.y, v.z, v.x * v.x, v.y * v.y, v.z * v.z, 0.0])
        });
        Self { reference, slices: sums.into_iter().map(VelocitySums::from).collect() }
    }

    fn total(&self) -> VelocitySums {
        let mut total = VelocitySums::default();
        self.slices.iter().for_each(|slice| total.add(slice));
        total
    }

    /// Number of all particles, as a floating-point number.
    pub fn count(&self) -> f64 {
        self.total().count
    }

    /// [m/s] mean velocity of all particles; 0 without particles.
    pub fn mean(&self) -> Vector3<f64> {
        let VelocitySums { count, sum, .. } = self.total();
        if count > 0.0 { self.reference + sum / count } else { Vector3::zeros() }
    }

    /// [m²/s²] mean square of the velocities of all particles relative to their mean, summed over x, y and z; 0 without
    /// particles.
    pub fn variance(&self) -> f64 {
        let VelocitySums { count, sum, squares } = self.total();
        if count > 0.0 { (squares.sum() - sum.norm_squared() / count) / count } else { 0.0 }
    }

    /// [m²/s²] parts of the granular temperature along x, y and z: T_i = Σ (v_i - U_i)²/(N - S). U is the mean velocity
    /// in the slice of the particle, N the number of particles, and S the number of slices with particles. Each mean
    /// removes one degree of freedom. `None` if every slice contains at most one particle.
    pub fn components(&self) -> Option<Vector3<f64>> {
        let visited = self.slices.iter().filter(|slice| slice.count > 0.0);
        let (freedom, squares) = visited.fold((0.0, Vector3::zeros()), |(freedom, total), slice| {
            let about_mean = slice.squares - slice.sum.component_mul(&slice.sum) / slice.count;
            (freedom + slice.count - 1.0, total + about_mean)
        });
        (freedom > 0.0).then(|| squares / freedom)
    }

    /// Averages of each slice along y: number of particles, mean velocity [m/s], and parts of the granular temperature
    /// along x, y and z [m²/s²], relative to this mean. The mean is `None` without a particle, the temperature with
    /// fewer than two.
    pub fn of_slices(&self) -> impl Iterator<Item = (f64, Option<Vector3<f64>>, Option<Vector3<f64>>)> + '_ {
        self.slices.iter().map(|slice| {
            let mean = (slice.count > 0.0).then(|| self.reference + slice.sum / slice.count);
            let alone = Self { reference: self.reference, slices: vec![*slice] };
            (slice.count, mean, alone.components())
        })
    }

    /// [m²/s²] granular temperature T, the mean of [`components`](Self::components) over the three directions. `None`
    /// if every slice contains at most one particle.
    pub fn temperature(&self) -> Option<f64> {
        self.components().map(|components| components.sum() / 3.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::Particles;

    #[test]
    fn a_shear_is_no_temperature_and_few_particles_do_not_bias_it() {
        let temperature =
            |particles: &Particles, slices| VelocitySpread::of(particles, slices, 1.0).temperature().unwrap();
        let mut particles = Particles::default();
        let mut push = |y: f64, v: [f64; 3]| particles.push(Vector3::new(0.0, y, 0.0), v.into(), 0.1, 1.0, 0);
        // two slices that move relative to each other at 10 m/s, each with two particles at ±1 m/s along x: the
        // variance along x is 2 about the mean of the two particles
        for (y, w) in [(0.2, 100.0), (0.8, 110.0)] {
            push(y, [1.0, 0.0, w]);
            push(y, [-1.0, 0.0, w]);
        }
        assert!((temperature(&particles, 2) - 2.0 / 3.0).abs() < 1e-12);
        let one = VelocitySpread::of(&particles, 1, 1.0);
        assert!((one.temperature().unwrap() - (4.0 + 100.0) / 9.0).abs() < 1e-12);
        assert!((one.components().unwrap() - Vector3::new(4.0, 0.0, 100.0) / 3.0).norm() < 1e-12);
        let each: Vec<_> = VelocitySpread::of(&particles, 2, 1.0).of_slices().collect();
        assert_eq!(each[1], (2.0, Some(Vector3::new(0.0, 0.0, 110.0)), Some(Vector3::new(2.0, 0.0, 0.0))));
        // variance about the mean of all particles, for any number of slices: squares of ±1 and ±5
        let two = VelocitySpread::of(&particles, 2, 1.0);
        assert!((two.variance() - 26.0).abs() < 1e-12 && (two.mean() - Vector3::new(0.0, 0.0, 105.0)).norm() < 1e-12);
        // a particle outside the box counts in the nearest slice
        particles.position[3].y = 1.2;
        assert!((temperature(&particles, 2) - 2.0 / 3.0).abs() < 1e-12);
        assert!(temperature(&particles, 1) > 1.0);
        particles.position[0].y = -0.1;
        // a single particle in its slice has no temperature
        assert!(VelocitySpread::of(&particles, 1000, 1.0).temperature().is_none());
        let nobody = VelocitySpread::of(&Particles::default(), 4, 1.0);
        assert!(nobody.temperature().is_none() && nobody.mean().norm() + nobody.variance() == 0.0);
    }
}
