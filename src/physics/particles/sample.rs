//! Sums over all particles of a run, which are stored in one process or divided between several.

use super::Particles;
use crate::communicator::Communicator;
use crate::exact::{self, ExactSum};
use nalgebra::Vector3;

/// All particles of a run at one instant. If several processes share a run, each stores a part of the particles. All
/// processes must call the methods in the same order, and each receives the sum over all particles. Sums are exact, so
/// they do not depend on how the particles are divided.
#[derive(Clone, Copy)]
pub struct Sample<'a> {
    /// Particles that this process stores.
    pub particles: &'a Particles,
    /// Connection to the processes that store the other particles; `None` if this process stores all particles.
    communicator: Option<&'a dyn Communicator>,
}

impl<'a> From<&'a Particles> for Sample<'a> {
    /// Makes a sample for one process that stores all particles.
    fn from(particles: &'a Particles) -> Self {
        Self::part(particles, None)
    }
}

impl<'a> Sample<'a> {
    /// Makes a sample (particles over which sums are taken) of the particles of this process. If `communicator` is
    /// given, sums include the particles of the other processes.
    pub fn part(particles: &'a Particles, communicator: Option<&'a dyn Communicator>) -> Self {
        Self { particles, communicator }
    }

    /// True if the particles of the run are divided between several processes.
    pub fn is_part(&self) -> bool {
        self.communicator.is_some()
    }

    /// Returns a sample (particles over which sums are taken) of other particles. Each process passes the particles
    /// that it has computed from its own particles of this sample, such as copies with other velocities.
    pub fn with<'b>(&self, particles: &'b Particles) -> Sample<'b>
    where
        'a: 'b,
    {
        Sample { particles, communicator: self.communicator }
    }

    /// Replaces each sum over the particles of this process by the total over all processes.
    pub fn total(&self, sums: &mut [&mut ExactSum]) {
        if let Some(communicator) = self.communicator {
            communicator.total(sums);
        }
    }

    /// Sums of K values over all particles in all processes. `of` returns the values of the particle at an index in
    /// this process.
    pub fn sums<const K: usize>(&self, of: impl Fn(usize) -> [f64; K] + Sync) -> [f64; K] {
        let mut sums = exact::sums(self.particles.position.len(), of);
        self.total(&mut sums.each_mut());
        exact::values(&sums)
    }

    /// Sums of K values over all particles in all processes, for each of `groups` groups. For the particle at an index
    /// in this process, `of` returns the number of its group and its values.
    pub fn sums_in_groups<const K: usize>(
        &self,
        groups: usize,
        of: impl Fn(usize) -> (usize, [f64; K]) + Sync,
    ) -> Vec<[f64; K]> {
        let mut sums = exact::sums_in_groups(groups, self.particles.position.len(), of);
        if self.communicator.is_some() {
            self.total(&mut sums.each_mut());
        }
        sums.values()
    }

    /// Number of particles in all processes.
    pub fn count(&self) -> usize {
        let [count] = self.added([self.particles.position.len() as f64]);
        count as usize
    }

    /// [m/s] mean of all velocities over all processes; 0 without particles.
    pub fn mean_velocity(&self) -> Vector3<f64> {
        let mut sums = self.particles.velocity_sums();
        self.total(&mut sums.each_mut());
        Vector3::from(exact::values(&sums)) / self.count().max(1) as f64
    }

    /// [m/s] root mean square of the velocities relative to their mean, over the particles in all processes; 0 without
    /// particles.
    pub fn fluctuation_speed(&self) -> f64 {
        let mut sum = self.particles.square_speeds(self.mean_velocity());
        self.total(&mut [&mut sum]);
        (sum.value() / self.count().max(1) as f64).sqrt()
    }

    /// Returns, for each of the K values, the largest of the values that the processes pass.
    pub fn largest<const K: usize>(&self, mut values: [f64; K]) -> [f64; K] {
        if let Some(communicator) = self.communicator {
            communicator.largest(&mut values);
        }
        values
    }

    /// Returns, for each of the K counts, the sum of the counts that the processes pass. The counts must be whole
    /// numbers.
    pub fn added<const K: usize>(&self, counts: [f64; K]) -> [f64; K] {
        let Some(communicator) = self.communicator else { return counts };
        let mut whole = counts.map(|count| count as i64);
        communicator.sum(&mut whole);
        whole.map(|count| count as f64)
    }

    /// [kg] total mass of the particles in all processes.
    pub fn total_mass(&self) -> f64 {
        let [mass] = self.sums(|index| [self.particles.mass[index]]);
        mass
    }

    /// [kg m/s] total momentum of the particles in all processes.
    pub fn momentum(&self) -> Vector3<f64> {
        let [x, y, z] = self.sums(|index| (self.particles.velocity[index] * self.particles.mass[index]).into());
        Vector3::new(x, y, z)
    }

    /// [-] means of r, r² and r³ over all particles, where r is the radius in units of `unit` [m]; 0 without particles.
    pub fn mean_radii(&self, unit: f64) -> [f64; 3] {
        let mut sums = self.particles.radius_sums(unit);
        self.total(&mut sums.each_mut());
        exact::values(&sums).map(|sum| sum / self.count().max(1) as f64)
    }

    /// [J] total rotational energy of the particles in all processes; 0 if spheres do not rotate. Either all processes
    /// store spins, or no process does.
    pub fn rotational_energy(&self) -> f64 {
        if self.particles.spin.is_none() {
            return 0.0;
        }
        let mut sum = self.particles.rotational_energies();
        self.total(&mut [&mut sum]);
        sum.value()
    }

    /// [J] total translational kinetic energy of the particles in all processes.
    pub fn kinetic_energy(&self) -> f64 {
        let mut sum = self.particles.kinetic_energies();
        self.total(&mut [&mut sum]);
        sum.value()
    }
}
