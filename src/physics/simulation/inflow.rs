//! Particles that come in through inlets: random positions without overlap, by random sequential insertion. They come
//! in at the end of a window, the time between two exchanges with the gas. The ledger holds the sums of work, losses
//! and impulses since the start.
//!
//! The random size, velocity and spin of a particle are determined by the seed of the run and the id of the particle.
//! Its random position depends also on the number of windows completed so far. So these random values do not depend on
//! threads, on the order in which particles are stored, or on a stop and continuation of the run.

use super::Simulation;
use super::through_flow::ThroughFlow;
use crate::domain::Domain;
use crate::noise::{Noise, NoiseUse};
use crate::particles::Particles;
use crate::placement::{FreeRoom, MARGIN};
use crate::record::Ledger;
use crate::scene::{Inlet, Scene, Species, StartRegion};
use crate::walls::NearWalls;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Number of random positions tried for a particle at the end of a window (time between two exchanges with the gas).
/// Random sequential addition of spheres jams at a volume fraction of 0.382 (Talbot, Schaaf and Tarjus 1991). At half
/// of this fraction about 1 in 10 positions is free.
const TRIES: usize = 1000;

/// Free space of each inlet of `scene`, in which new particles can be placed. The walls of the scene must not have
/// periodic images yet.
pub(super) fn rooms(scene: &Scene) -> Vec<FreeRoom> {
    let room = |inlet: &Inlet| FreeRoom::within(scene, Some(&StartRegion::Body(inlet.region.clone())));
    scene.inlets.iter().map(room).collect()
}

/// Sphere that a new particle must not overlap.
struct SphereInTheWay {
    /// [m] position of the centre, inside the box along periodic axes.
    position: Vector3<f64>,
    /// [m] radius of the sphere.
    radius: f64,
}

impl SphereInTheWay {
    /// True if a sphere with the centre `position` [m] and the radius `radius` [m] would overlap or nearly touch this
    /// one.
    fn blocks(&self, position: &Vector3<f64>, radius: f64, domain: &Domain) -> bool {
        let reach = (self.radius + radius) * (1.0 + MARGIN);
        domain.separation(position, &self.position).norm_squared() <= reach * reach
    }
}

/// A particle that must come in at an inlet now, before it has a position.
struct NewParticle {
    /// [m] radius of the particle.
    radius: f64,
    /// [m/s] velocity of the particle.
    velocity: Vector3<f64>,
    /// [rad/s] spin of the particle, which is used only if spheres rotate.
    spin: Vector3<f64>,
}

impl NewParticle {
    /// Chooses radius, velocity and spin of the particle with the id `id` at random.
    fn drawn(inlet: &Inlet, species: &Species, seed: u64, id: u32) -> Self {
        let mut noise = Noise::new(seed, NoiseUse::Inlets, 0);
        let random = noise.of(id);
        let share = random.random::<f64>();
        let diameter = species.sizes.as_ref().map_or(species.diameter, |sizes| sizes.quantile(share));
        let mut normal = || Vector3::from_fn(|_, _| StandardNormal.sample(random));
        let velocity = inlet.velocity_mean + inlet.velocity_fluctuation.component_mul(&normal());
        let spin = inlet.spin_mean + normal() * inlet.spin_fluctuation;
        Self { radius: 0.5 * diameter, velocity, spin }
    }
}

impl Simulation {
    /// Particles that come in now, with their entries in the ledger (sums of energies and impulses). Particles that
    /// must come in but find no free position wait for a later window. `leaving` contains the index of each particle
    /// that leaves now, in ascending order, with the index of its outlet. The counts of particles in `flow` are
    /// updated.
    pub(super) fn incoming(&mut self, flow: &mut ThroughFlow, leaving: &[(u32, usize)]) -> (Particles, Vec<Ledger>) {
        let (mut fresh, mut entries) = (Particles::default(), Vec::new());
        for number in 0..self.scene.inlets.len() {
            let due = self.scene.inlets[number].due(self.time).saturating_sub(flow.inlets[number].count());
            let placed = if due > 0 { self.insert(number, due, (flow, leaving), &mut fresh) } else { 0 };
            for index in fresh.len() - placed..fresh.len() {
                entries.push(flow.inlets[number].add(&fresh, index, &self.scene));
            }
            flow.inlets[number].set_waiting(due - placed as u64);
        }
        (fresh, entries)
    }

    /// Appends up to `due` particles of the inlet with the index `number` to `fresh`, and returns their number. If one
    /// particle finds no free position, this particle and the remaining ones wait for a later window.
    fn insert(
        &mut self,
        number: usize,
        due: u64,
        (flow, leaving): (&mut ThroughFlow, &[(u32, usize)]),
        fresh: &mut Particles,
    ) -> usize {
        self.move_room(number);
        let (scene, inlet, room) = (&self.scene, &self.scene.inlets[number], &self.inlet_rooms[number]);
        let species = &scene.species[usize::from(inlet.species)];
        let mut obstacles = self.obstacles(inlet, leaving, fresh);
        let before = fresh.len();
        for _ in 0..due {
            let Some(id) = flow.next_id() else { break };
            let particle = NewParticle::drawn(inlet, species, self.seed, id);
            let radius = particle.radius;
            let mut noise = Noise::new(self.seed, NoiseUse::InletPositions, self.windows);
            let mut random = Xoshiro256PlusPlus::seed_from_u64(noise.of(id).random());
            let is_free = |position: &Vector3<f64>| {
                room.fits(position, radius * (1.0 + MARGIN))
                    && !obstacles.iter().any(|one| one.blocks(position, radius, &scene.domain))
            };
            let mut tried = (0..TRIES).map(|_| room.anywhere(radius * (1.0 + MARGIN), &mut random));
            let Some(position) = tried.find(is_free) else { break };
            flow.take_id();
            obstacles.push(SphereInTheWay { position, radius });
            let mut one = Particles::default();
            one.push(position, particle.velocity, radius, species.of_one_size(2.0 * radius).mass(), inlet.species);
            one.id[0] = id;
            scene.let_rotate(&mut one);
            one.spin.iter_mut().flatten().for_each(|spin| *spin = particle.spin);
            self.draw_eddies_of(&mut one);
            fresh.copy_from(&one, &[0]);
        }
        fresh.len() - before
    }

    /// Moves the walls in the free space of the inlet with the index `number` to their places at the present time.
    fn move_room(&mut self, number: usize) {
        let room = &mut self.inlet_rooms[number];
        if room.scene.has_moving_walls() {
            room.scene.move_to(self.time);
            room.near = NearWalls::of(&room.scene.walls);
        }
    }

    /// Spheres that reach into the region of an inlet: particles of the scene, except those that leave now, and the
    /// particles `fresh` that have just come in.
    fn obstacles(&self, inlet: &Inlet, leaving: &[(u32, usize)], fresh: &Particles) -> Vec<SphereInTheWay> {
        let domain = &self.scene.domain;
        let [low, high] = inlet.region.corners();
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let obstacle = |(position, radius): (&Vector3<f64>, &f64)| {
            let position = domain.wrap(position);
            let apart = domain.separation(&position, &middle);
            let reaches = (0..3).all(|axis| apart[axis].abs() <= half[axis] + radius);
            reaches.then_some(SphereInTheWay { position, radius: *radius })
        };
        let stays = |index: &u32| leaving.binary_search_by_key(index, |(index, _)| *index).is_err();
        let old = (0u32..).zip(self.particles.position.iter().zip(&self.particles.radius));
        let old = old.filter_map(|(index, sphere)| obstacle(sphere).filter(|_| stays(&index)));
        old.chain(fresh.position.iter().zip(&fresh.radius).filter_map(obstacle)).collect()
    }
}
