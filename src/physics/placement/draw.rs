//! Random positions, sizes and velocities of particles, before overlaps are removed.

use super::{FreeRoom, MARGIN, StartPlan};
use crate::experiment::{Amount, Population};
use crate::particles::Particles;
use crate::scene::Species;
use nalgebra::Vector3;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Number that is combined with the seed of a run by XOR, so that spins have random numbers of their own. Its value is
/// arbitrary.
const SPINS: u64 = 0x5350_494e_5350_494e;

/// Makes the particles of all populations (groups of particles with common settings). Random positions are in the free
/// space of the population. The ids are 0 to N - 1 over all populations. Returns all particles with given positions,
/// and the particles at random positions [m] for which `is_kept` is true. If some positions are given, `is_kept` must
/// be true everywhere.
pub fn draw(
    plan: StartPlan,
    rooms: &[&FreeRoom],
    random: &mut Xoshiro256PlusPlus,
    is_kept: &dyn Fn(&Vector3<f64>) -> bool,
) -> Particles {
    let (mut particles, mut id) = (Particles::default(), 0);
    let rotates = plan.scene.rotation.is_some();
    particles.spin = rotates.then(Vec::new);
    // spins have their own random numbers, so that positions and velocities are the same with and without rotation
    let mut of_spins = Xoshiro256PlusPlus::seed_from_u64(plan.seed ^ SPINS);
    for (population, room) in plan.populations.iter().zip(rooms) {
        let species = &room.scene.species[population.species as usize];
        match &population.amount {
            Amount::Placed(placed) => {
                particles.append(placed);
                id += placed.len() as u32;
            }
            Amount::Count(count) => {
                let mut diameters = Diameters::new(species, *count, random);
                let Population { velocity_mean, velocity_fluctuation, spin_mean, spin_fluctuation, .. } = population;
                let mut velocities = Normals::new((*velocity_mean, *velocity_fluctuation), *count, random);
                let spread = (*spin_mean, Vector3::repeat(*spin_fluctuation));
                let mut spins = rotates.then(|| Normals::new(spread, *count, &mut of_spins));
                // reserves exactly the memory needed, because a growing vector may take twice as much
                particles.reserve(*count);
                for _ in 0..*count {
                    let (diameter, velocity) = (diameters.next(), velocities.next());
                    let spin = spins.as_mut().map(Normals::next);
                    let (radius, mass) = (0.5 * diameter, species.of_one_size(diameter).mass());
                    // the radius is enlarged, as in the whole placement
                    let position = room.somewhere(radius * (1.0 + MARGIN), random);
                    if is_kept(&position) {
                        particles.push(position, velocity, radius, mass, population.species);
                        if let Some(own) = particles.id.last_mut() {
                            *own = id;
                        }
                        let own = particles.spin.as_mut().and_then(|spins| spins.last_mut());
                        if let (Some(own), Some(spin)) = (own, spin) {
                            *own = spin;
                        }
                    }
                    id += 1;
                }
            }
        }
    }
    particles
}

/// Diameters of the spheres of a population. Each new sphere takes the next diameter.
enum Diameters {
    /// [m] common diameter of all spheres.
    Same(f64),
    /// [m] diameters that are not yet used; the next sphere takes the final element of the list.
    Spread(Vec<f64>),
}

impl Diameters {
    /// Diameters of `count` spheres of a species, in random order. A distribution of sizes is cut into `count` parts of
    /// equal probability, and one diameter is chosen at random in each part. Even a few spheres then represent the
    /// distribution.
    fn new(species: &Species, count: usize, random: &mut Xoshiro256PlusPlus) -> Self {
        let Some(sizes) = &species.sizes else { return Self::Same(species.diameter) };
        let mut draw = |part: usize| sizes.quantile((part as f64 + random.random::<f64>()) / count as f64);
        let mut diameters: Vec<f64> = (0..count).map(&mut draw).collect();
        diameters.shuffle(random);
        diameters.reverse();
        Self::Spread(diameters)
    }

    fn next(&mut self) -> f64 {
        match self {
            Self::Same(diameter) => *diameter,
            Self::Spread(diameters) => diameters.pop().unwrap_or_default(),
        }
    }
}

/// Gaussian velocities or spins, shifted and scaled so that every component has exactly the required mean and standard
/// deviation. The standard deviation is the root of the mean square about the mean, with the number of spheres as
/// divisor. A single sphere has no standard deviation: its random number is multiplied by the required deviation, and
/// the mean is added.
///
/// The same random numbers are generated three times: for their mean, for their deviation, and for use. To store them
/// would take more memory than the particles, if only a part of the particles is kept.
struct Normals {
    /// Random generator in the state before the next value.
    random: Xoshiro256PlusPlus,
    /// [-] mean of all random numbers, for each component of the vectors; 0 for a single sphere.
    drawn: Vector3<f64>,
    /// Required mean of the velocities [m/s] or spins [rad/s].
    mean: Vector3<f64>,
    /// Factor by which the difference between a random number and `drawn` is multiplied, in m/s or rad/s.
    factor: Vector3<f64>,
}

impl Normals {
    /// Prepares `count` velocities or spins, from random numbers of `random`. Each component has the given mean and
    /// standard deviation.
    fn new((mean, deviation): (Vector3<f64>, Vector3<f64>), count: usize, random: &mut Xoshiro256PlusPlus) -> Self {
        let before = random.clone();
        let (mut drawn, mut stretch) = (Vector3::zeros(), Vector3::repeat(1.0));
        let sum: Vector3<f64> = (0..count).map(|_| normal(random)).sum();
        if count > 1 {
            drawn = sum / count as f64;
            let mut again = before.clone();
            let square = |_| {
                let v = normal(&mut again) - drawn;
                v.component_mul(&v)
            };
            let squares = (0..count).map(square).sum::<Vector3<f64>>() / count as f64;
            // equal random numbers, which do not occur in practice, have no deviation; a division by zero must be
            // excluded
            stretch = squares.map(|square| if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 });
        }
        Self { random: before, drawn, mean, factor: deviation.component_mul(&stretch) }
    }

    fn next(&mut self) -> Vector3<f64> {
        self.mean + (normal(&mut self.random) - self.drawn).component_mul(&self.factor)
    }
}

/// Three independent Gaussian numbers of mean 0 and variance 1.
fn normal(random: &mut Xoshiro256PlusPlus) -> Vector3<f64> {
    Vector3::from_fn(|_, _| StandardNormal.sample(random))
}
