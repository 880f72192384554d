//! The particle store: the only thing in a simulation that changes.

use crate::domain::Domain;
use nalgebra::Vector3;
use rayon::prelude::*;

/// Length of a parallel chunk of particles or pairs; work much below it is not worth a second thread. Chunks do not
/// depend on the number of threads, so neither do results.
pub const CHUNK: usize = 8192;

/// Spheres as a struct of arrays. All arrays have the same length.
///
/// Engines may reorder the store for speed; `id` keeps the identity (0 .. N in the order of the initial state).
///
/// ```
/// use diptych::{Particles, Vector3};
///
/// let mut particles = Particles::default();
/// particles.push(Vector3::new(0.01, 0.02, 0.03), Vector3::x(), 2e-4, 3e-8, 0); // m, m/s, m, kg, species 0
/// assert_eq!((particles.len(), particles.id[0]), (1, 0));
/// assert_eq!(particles.kinetic_energy(), 1.5e-8); // J
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// [m] centres; along a periodic axis they may have left the box since the last [`wrap`](crate::domain::Domain::wrap).
    pub position: Vec<Vector3<f64>>,
    /// [m/s] velocities.
    pub velocity: Vec<Vector3<f64>>,
    /// [m] radii.
    pub radius: Vec<f64>,
    /// [kg] masses.
    pub mass: Vec<f64>,
    /// Index into [`Scene::species`](crate::scene::Scene::species).
    pub species: Vec<u16>,
    /// Identity of the particle, whatever its place in the store.
    pub id: Vec<u32>,
}

impl Particles {
    /// No particles, and room for some.
    pub fn with_capacity(count: usize) -> Self {
        Self {
            position: Vec::with_capacity(count),
            velocity: Vec::with_capacity(count),
            radius: Vec::with_capacity(count),
            mass: Vec::with_capacity(count),
            species: Vec::with_capacity(count),
            id: Vec::with_capacity(count),
        }
    }

    /// Takes all particles out and keeps the memory.
    pub fn clear(&mut self) {
        self.position.clear();
        self.velocity.clear();
        self.radius.clear();
        self.mass.clear();
        self.species.clear();
        self.id.clear();
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Appends a sphere; its id is its place. Lengths in m, velocity in m/s, mass in kg.
    pub fn push(&mut self, position: Vector3<f64>, velocity: Vector3<f64>, radius: f64, mass: f64, species: u16) {
        self.id.push(self.len() as u32);
        self.position.push(position);
        self.velocity.push(velocity);
        self.radius.push(radius);
        self.mass.push(mass);
        self.species.push(species);
    }

    /// Puts the particle that stands at `order[k]` at place `k`, for every `k`; `order` is a permutation of 0 .. N.
    pub fn reorder(&mut self, order: &[u32]) {
        fn gather<T: Copy>(values: &mut Vec<T>, order: &[u32]) {
            *values = order.iter().map(|&from| values[from as usize]).collect();
        }
        gather(&mut self.position, order);
        gather(&mut self.velocity, order);
        gather(&mut self.radius, order);
        gather(&mut self.mass, order);
        gather(&mut self.species, order);
        gather(&mut self.id, order);
    }

    /// Puts the particles in the order of their ids, the order of the initial state.
    pub fn sort_by_id(&mut self) {
        let mut order: Vec<u32> = (0..self.len() as u32).collect();
        order.sort_unstable_by_key(|&place| self.id[place as usize]);
        self.reorder(&order);
    }

    /// Brings all positions into the box along its periodic axes.
    pub fn wrap(&mut self, domain: &Domain) {
        self.position.par_chunks_mut(CHUNK).for_each(|chunk| {
            for x in chunk {
                *x = domain.wrap(x);
            }
        });
    }

    /// [kg m/s] total momentum.
    pub fn momentum(&self) -> Vector3<f64> {
        self.velocity.iter().zip(&self.mass).map(|(v, m)| v * *m).sum()
    }

    /// [J] total kinetic energy.
    pub fn kinetic_energy(&self) -> f64 {
        self.velocity.iter().zip(&self.mass).map(|(v, m)| 0.5 * m * v.norm_squared()).sum()
    }

    /// [m/s] mean of all velocities; 0 without particles. The same for any number of threads.
    pub fn mean_velocity(&self) -> Vector3<f64> {
        let sums: Vec<Vector3<f64>> = self.velocity.par_chunks(CHUNK).map(|chunk| chunk.iter().sum()).collect();
        sums.iter().sum::<Vector3<f64>>() / self.len().max(1) as f64
    }

    /// [m/s] the largest speed of any particle relative to `frame` [m/s]; infinite if one is not a number.
    pub fn largest_speed(&self, frame: Vector3<f64>) -> f64 {
        let largest = |chunk: &[Vector3<f64>]| {
            chunk.iter().fold(0.0f64, |most, v| {
                let square = (v - frame).norm_squared();
                if square > most {
                    square
                } else if square.is_nan() {
                    f64::INFINITY
                } else {
                    most
                }
            })
        };
        self.velocity.par_chunks(CHUNK).map(largest).reduce(|| 0.0, f64::max).sqrt()
    }
}
