//! Particle store: positions, velocities and other data of all particles. The engines change these data during a run.

mod columns;
mod sample;
mod slices;
mod values;

pub use sample::Sample;
pub use slices::{fingerprint_of, for_each_slice};

use crate::domain::Domain;
use crate::exact::{self, ExactSum};
use crate::work_sharing;
use columns::{Column, columns};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use values::{AsBytes, AsNumbers};

/// Number of particles or pairs in a piece of parallel work. For smaller numbers a second thread saves no computing
/// time. The pieces do not depend on the number of threads, so neither do the results.
pub const CHUNK: usize = 8192;

columns! {
    /// Moving state of one particle: position, velocity and spin, which steps, collisions and other events change.
    pub struct Motion;

    /// Mutable access to the moving state of consecutive particles of a store: one slice per quantity, such as position
    /// and velocity.
    pub struct MotionChunk;

    /// Particle store: spheres as a struct of arrays. All arrays have the same length, with one entry per sphere.
    /// Engines may reorder the store for speed. The `id` of a particle stays: ids are 0 to N - 1 for the N particles of
    /// the initial state, in its order. Particles that come in through inlets get larger ids.
    ///
    /// ```
    /// # extern crate diptych_physics as diptych;
    /// use diptych::{Particles, Vector3};
    ///
    /// let mut particles = Particles::default();
    /// particles.push(Vector3::new(0.01, 0.02, 0.03), Vector3::x(), 2e-4, 3e-8, 0); // m, m/s, m, kg, species 0
    /// assert_eq!((particles.len(), particles.id[0]), (1, 0));
    /// assert_eq!(particles.kinetic_energy(), 1.5e-8); // J
    /// ```
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    pub struct Particles {
        /// [m] positions of the centres. Along periodic axes, centres may have left the box since the most recent call
        /// of [`wrap`](crate::domain::Domain::wrap).
        pub position: Vec<Vector3<f64>> => ["x", "y", "z"] as moving,
        /// [m/s] velocities of the centres.
        pub velocity: Vec<Vector3<f64>> => ["vx", "vy", "vz"] as moving by kicks,
        /// [m] radii of the spheres.
        pub radius: Vec<f64>,
        /// [rad/s] spins; `None` if spheres do not rotate.
        pub spin: Option<Vec<Vector3<f64>>> => ["wx", "wy", "wz"] as moving by kicks,
        /// [kg m²] moments of inertia about the centre; `None` if spheres do not rotate.
        pub inertia: Option<Vec<f64>>,
        /// [kg] masses of the spheres.
        pub mass: Vec<f64>,
        /// Index of each particle's species in [`Scene::species`](crate::scene::Scene::species).
        pub species: Vec<u16>,
        /// [-] fluctuations of the gas velocity at the particles, over the standard deviation of this velocity at the
        /// place of each particle. For the discrete random walk ([`EddyLaw::Eddy`](crate::fluid::EddyLaw::Eddy)), the
        /// fluctuations themselves [m/s]. `None` if particles see the mean velocity alone. Kicks of drag and
        /// reflections at walls change the fluctuations.
        pub eddies: Option<Vec<Vector3<f64>>>,
        /// Id of each particle, which stays with the particle when the store is reordered.
        pub id: Vec<u32>,
    }
}

/// Changes of momentum and energy of the particles that leave a sheared box through a side and come back at the other
/// side with the velocity of their image there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SideCrossings {
    /// [kg m/s] momentum along z that the particles gained, because each got the velocity of its image at the other
    /// side.
    pub impulse: f64,
    /// [J] change of the kinetic energy of the particles that crossed a side.
    pub work: f64,
}

impl SideCrossings {
    /// Changes of momentum and energy by the crossing of one particle of `mass` [kg]. Its velocity along z is `before`
    /// [m/s] and changes by `change` [m/s].
    pub fn of(mass: f64, before: f64, change: f64) -> Self {
        Self { impulse: mass * change, work: mass * change * (before + 0.5 * change) }
    }
}

impl std::ops::Neg for SideCrossings {
    type Output = Self;

    fn neg(self) -> Self {
        Self { impulse: -self.impulse, work: -self.work }
    }
}

impl Particles {
    /// Number of particles in the store.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// True if the store contains no particle.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Appends a sphere with a position [m], a velocity [m/s], a radius [m] and a mass [kg]. `species` is an index in
    /// the scene. The id of the sphere is its index.
    pub fn push(&mut self, position: Vector3<f64>, velocity: Vector3<f64>, radius: f64, mass: f64, species: u16) {
        let index = self.len();
        self.grow();
        self.position[index] = position;
        self.velocity[index] = velocity;
        self.radius[index] = radius;
        self.mass[index] = mass;
        self.species[index] = species;
        self.id[index] = index as u32;
    }

    /// Appends all particles of another store, with their new indices as ids.
    pub fn append(&mut self, other: &Self) {
        let (first, count) = (self.len() as u32, other.len() as u32);
        self.copy_from(other, &(0..count).collect::<Vec<u32>>());
        self.id.truncate(first as usize);
        self.id.extend(first..first + count);
    }

    /// Sorts the particles by id, which is the order of the initial state.
    pub fn sort_by_id(&mut self) {
        let mut order: Vec<u32> = (0..self.len() as u32).collect();
        order.sort_unstable_by_key(|&index| self.id[index as usize]);
        self.reorder(&order);
    }

    /// Checksum of the state: FNV-1a over the bits of all positions, velocities and spins, in the order of ids.
    pub fn fingerprint(&self) -> u64 {
        fingerprint_of(self, None)
    }

    /// Replaces every position outside a periodic side by the periodic image inside the box. Particles outside a
    /// sheared side also get the velocity of that image. Returns the sum of the changes of momentum and energy at
    /// sheared sides.
    pub fn wrap(&mut self, domain: &Domain) -> SideCrossings {
        if domain.shear.is_some() {
            return self.cross(domain);
        }
        work_sharing::for_each(self.position.chunks_mut(CHUNK), |chunk| {
            for x in chunk {
                *x = domain.wrap(x);
            }
        });
        SideCrossings::default()
    }

    /// Wraps all particles into a sheared box, and returns the sum of the changes of momentum and energy at the sheared
    /// sides.
    fn cross(&mut self, domain: &Domain) -> SideCrossings {
        let (mut impulse, mut work) = (ExactSum::default(), ExactSum::default());
        let motions = self.position.iter_mut().zip(&mut self.velocity);
        for ((x, v), &mass) in motions.zip(&self.mass) {
            let before = v.z;
            let change = domain.wrap_motion(x, v);
            if change != 0.0 {
                let crossing = SideCrossings::of(mass, before, change);
                impulse.add(crossing.impulse);
                work.add(crossing.work);
            }
        }
        SideCrossings { impulse: impulse.value(), work: work.value() }
    }

    /// Particles with velocities relative to the mean flow of a sheared box. Without shear the result is the particles
    /// themselves, not a copy.
    pub fn relative_to_flow(&self, domain: &Domain) -> Cow<'_, Self> {
        if domain.shear.is_none() {
            return Cow::Borrowed(self);
        }
        let relative = |(x, v): (&Vector3<f64>, &Vector3<f64>)| v - domain.mean_flow(x);
        let velocity = self.position.iter().zip(&self.velocity).map(relative).collect();
        Cow::Owned(Self { velocity, ..self.clone() })
    }

    /// [kg m/s] total momentum of all particles.
    pub fn momentum(&self) -> Vector3<f64> {
        let sums = exact::sums(self.len(), |k| {
            let p = self.velocity[k] * self.mass[k];
            [p.x, p.y, p.z, 0.0]
        });
        let [x, y, z, _] = exact::values(&sums);
        Vector3::new(x, y, z)
    }

    /// [J] total translational kinetic energy of all particles.
    pub fn kinetic_energy(&self) -> f64 {
        self.kinetic_energies().value()
    }

    /// [J] exact sum, independent of the order of its terms, of the translational kinetic energies of all particles.
    pub fn kinetic_energies(&self) -> ExactSum {
        let [sum] = exact::sums(self.len(), |k| [0.5 * self.mass[k] * self.velocity[k].norm_squared()]);
        sum
    }

    /// Adds spins and moments of inertia to a store without them. The spins are 0, and the moments are I = q m r² [kg
    /// m²]. `factors` contains the inertia factor q [-] of each species, in the order of
    /// [`Scene::species`](crate::scene::Scene::species).
    pub fn let_rotate(&mut self, factors: &[f64]) {
        let count = self.len();
        self.spin.get_or_insert_with(|| vec![Vector3::zeros(); count]);
        let of = |k: usize| factors[usize::from(self.species[k])] * self.mass[k] * self.radius[k] * self.radius[k];
        if self.inertia.is_none() {
            self.inertia = Some((0..count).map(of).collect());
        }
    }

    /// [rad/s] spins of all particles; empty if spheres do not rotate.
    #[inline(always)]
    pub fn spins(&self) -> &[Vector3<f64>] {
        self.spin.as_deref().unwrap_or_default()
    }

    /// [rad/s] spin of the particle at an index; 0 if spheres do not rotate.
    #[inline(always)]
    pub fn spin_of(&self, index: usize) -> Vector3<f64> {
        self.spin.as_ref().map_or_else(Vector3::zeros, |spins| spins[index])
    }

    /// [J] exact sum of the rotational energies I ω²/2 of all particles; 0 if spheres do not rotate.
    pub fn rotational_energies(&self) -> ExactSum {
        let (Some(spins), Some(inertia)) = (&self.spin, &self.inertia) else { return ExactSum::default() };
        let [sum] = exact::sums(self.len(), |k| [0.5 * inertia[k] * spins[k].norm_squared()]);
        sum
    }

    /// [J] total rotational energy of all particles; 0 if spheres do not rotate.
    pub fn rotational_energy(&self) -> f64 {
        self.rotational_energies().value()
    }

    /// [rad/s] spins of all particles; an empty list if spheres do not rotate.
    pub fn total_mass(&self) -> f64 {
        exact::sum(&self.mass, |mass| *mass).value()
    }

    /// [m/s] mean of all velocities; 0 without particles.
    pub fn mean_velocity(&self) -> Vector3<f64> {
        Vector3::from(exact::values(&self.velocity_sums())) / self.len().max(1) as f64
    }

    /// [m/s] exact sums of the velocity components of all particles along x, y and z.
    pub fn velocity_sums(&self) -> [ExactSum; 3] {
        let four = exact::side_by_side(
            &self.velocity,
            #[inline(always)]
            |[a, b, c, d]: &[Vector3<f64>; 4]| [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z],
        );
        let mut sums = exact::none::<3>();
        four.iter().enumerate().for_each(|(k, sum)| sums[k % 3].merge(sum));
        sums
    }

    /// [m²/s²] mean square of the velocities relative to the velocity `frame` [m/s]; 0 without particles.
    pub fn mean_square_speed(&self, frame: Vector3<f64>) -> f64 {
        self.square_speeds(frame).value() / self.len().max(1) as f64
    }

    /// [m²/s²] exact sum of the squares of the velocities relative to the velocity `frame` [m/s].
    pub fn square_speeds(&self, frame: Vector3<f64>) -> ExactSum {
        exact::sum(&self.velocity, |v| (v - frame).norm_squared())
    }

    /// [m²/s²] exact sum of the squares of the velocities relative to the velocity `frame` [m/s], and the largest speed
    /// [m/s] relative to `frame`. The largest speed is infinite if a velocity is not a number.
    pub fn square_speeds_and_largest(&self, frame: Vector3<f64>) -> (ExactSum, f64) {
        let (squares, largest) = exact::sum_and_largest(&self.velocity, |v| (v - frame).norm_squared());
        (squares, largest.sqrt())
    }

    /// [-] means of r, r² and r³ over all particles, where r is the radius in units of `unit` [m]; 0 without particles.
    pub fn mean_radii(&self, unit: f64) -> [f64; 3] {
        exact::values(&self.radius_sums(unit)).map(|sum| sum / self.len().max(1) as f64)
    }

    /// [-] exact sums of r, r² and r³ over all particles, where r is the radius in units of `unit` [m].
    pub fn radius_sums(&self, unit: f64) -> [ExactSum; 3] {
        let per_unit = 1.0 / unit;
        let four = exact::side_by_side(
            &self.radius,
            #[inline(always)]
            |radii: &[f64; 4]| {
                let [a, b, c, d] = radii.map(|radius| radius * per_unit);
                let ([aa, bb, cc, dd], third) = ([a * a, b * b, c * c, d * d], |square: f64, root: f64| square * root);
                [a, b, c, d, aa, bb, cc, dd, third(aa, a), third(bb, b), third(cc, c), third(dd, d)]
            },
        );
        let mut sums = exact::none::<3>();
        four.iter().enumerate().for_each(|(k, sum)| sums[k / 4].merge(sum));
        sums
    }

    /// [m/s] largest speed of any particle after the mean flow of a sheared box and the velocity `frame` [m/s] are
    /// subtracted from its velocity. It is infinite if a velocity is not a number.
    pub fn largest_speed_in(&self, frame: Vector3<f64>, domain: &Domain) -> f64 {
        if domain.shear.is_none() {
            return self.largest_speed(frame);
        }
        let relative = |(x, v): (&Vector3<f64>, &Vector3<f64>)| (v - domain.mean_flow(x) - frame).norm_squared();
        let squares = self.position.iter().zip(&self.velocity).map(relative);
        // an infinite speed stands for one that is not a number
        squares.fold(0.0f64, |most, square| if square.is_nan() { f64::INFINITY } else { most.max(square) }).sqrt()
    }

    /// [m/s] largest speed of any particle relative to the velocity `frame` [m/s]; infinite if a velocity is not a
    /// number.
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
        work_sharing::map(self.velocity.chunks(CHUNK), largest).into_iter().fold(0.0, f64::max).sqrt()
    }
}
