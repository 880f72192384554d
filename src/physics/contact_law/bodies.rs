//! Properties of two touching bodies on which a contact law depends, and constants of the law between two bodies.

use crate::particles::Particles;
use crate::restitution::RestitutionBySpeed;
use crate::scene::{Elasticity, Kind, Scene, Species, Surface};
use serde::{Deserialize, Serialize};

/// Properties of two touching bodies on which a contact law depends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bodies {
    /// [kg] effective mass M = 1/(1/m_p + 1/m_q); at a wall the mass of the particle.
    pub effective_mass: f64,
    /// [m] effective radius R = 1/(1/r_p + 1/r_q); at a wall the radius of the particle.
    pub effective_radius: f64,
    /// [-] normal restitution e of an isolated impact, which the law must reproduce.
    pub restitution: f64,
    /// Restitution as a function of the normal speed; `None` if the restitution is constant. The field `restitution` is
    /// the value of this function at one typical speed, for predictions.
    #[serde(skip)]
    pub by_speed: Option<RestitutionBySpeed>,
    /// Elasticity of each body; `None` for a body with the elasticity of the contact law.
    #[serde(skip)]
    pub elasticity: [Option<Elasticity>; 2],
    /// [-] ratio of the stiffness between these two bodies to the stiffness of the contact law. The contact properties
    /// of the pair of bodies ([`Meeting`](crate::scene::Meeting)) give it.
    #[serde(skip)]
    pub stiffness_ratio: f64,
}

impl Bodies {
    /// Returns the properties of the same two bodies, with the restitution of an impact at the normal speed `speed`
    /// [m/s].
    pub fn at_speed(&self, speed: f64) -> Self {
        Self { restitution: self.by_speed.map_or(self.restitution, |law| law.at(speed)), ..*self }
    }

    /// Returns the properties of the same two bodies, with restitution 1 at every speed.
    pub fn elastic(&self) -> Self {
        Self { restitution: 1.0, by_speed: None, ..*self }
    }

    /// Properties of two particles, which are given by their indices `i` and `j` in the store.
    pub fn pair(scene: &Scene, particles: &Particles, i: usize, j: usize) -> Self {
        let species = [i, j].map(|index| particles.species[index]);
        let meeting = scene.meeting(species[0], Kind::Species(species[1]));
        let effective_mass = 1.0 / (1.0 / particles.mass[i] + 1.0 / particles.mass[j]);
        Self {
            effective_mass,
            effective_radius: 1.0 / (1.0 / particles.radius[i] + 1.0 / particles.radius[j]),
            restitution: meeting.surface.restitution,
            by_speed: meeting.surface.by_speed,
            elasticity: species.map(|species| scene.species[usize::from(species)].elasticity),
            stiffness_ratio: meeting.stiffness_of(effective_mass),
        }
    }

    /// Properties of a particle, given by its index `i` in the store, and of a wall, given by its index in the scene.
    pub fn at_wall(scene: &Scene, particles: &Particles, i: usize, wall: usize) -> Self {
        let species = particles.species[i];
        let meeting = scene.meeting(species, Kind::Wall(wall as u32));
        Self {
            effective_mass: particles.mass[i],
            effective_radius: particles.radius[i],
            restitution: meeting.surface.restitution,
            by_speed: meeting.surface.by_speed,
            elasticity: [scene.species[usize::from(species)].elasticity, scene.walls[wall].elasticity],
            stiffness_ratio: meeting.stiffness_of(particles.mass[i]),
        }
    }

    /// Properties of two spheres of the species `one` and `other` with the surface properties `surface` (restitution
    /// and friction) of their contact. The stiffness is that of the contact law.
    pub fn of(one: &Species, other: &Species, surface: &Surface) -> Self {
        Self {
            effective_mass: 1.0 / (1.0 / one.mass() + 1.0 / other.mass()),
            effective_radius: 1.0 / (2.0 / one.diameter + 2.0 / other.diameter),
            restitution: surface.restitution,
            by_speed: surface.by_speed,
            elasticity: [one.elasticity, other.elasticity],
            stiffness_ratio: 1.0,
        }
    }

    /// Properties of two spheres of the species with the indices `one` and `other` in the scene, which may be equal.
    pub fn between(scene: &Scene, one: u16, other: u16) -> Self {
        let meeting = scene.meeting(one, Kind::Species(other));
        let (first, second) = (&scene.species[usize::from(one)], &scene.species[usize::from(other)]);
        let bodies =
            if one == other { Self::alike(first, &meeting.surface) } else { Self::of(first, second, &meeting.surface) };
        Self { stiffness_ratio: meeting.stiffness_of(bodies.effective_mass), ..bodies }
    }

    /// Properties of a sphere and a wall, given by the indices of the species and of the wall in the scene.
    pub fn beside(scene: &Scene, species: u16, wall: u32) -> Self {
        let meeting = scene.meeting(species, Kind::Wall(wall));
        let elasticity = scene.walls[wall as usize].elasticity;
        let bodies = Self::of_wall(&scene.species[usize::from(species)], &meeting.surface, elasticity);
        Self { stiffness_ratio: meeting.stiffness_of(bodies.effective_mass), ..bodies }
    }

    /// Properties of two spheres of one species with the surface properties `surface` of their contact. The stiffness
    /// is that of the contact law.
    pub fn alike(species: &Species, surface: &Surface) -> Self {
        Self {
            effective_mass: 0.5 * species.mass(),
            effective_radius: 0.25 * species.diameter,
            restitution: surface.restitution,
            by_speed: surface.by_speed,
            elasticity: [species.elasticity; 2],
            stiffness_ratio: 1.0,
        }
    }

    /// Properties of a sphere of a species, and of a wall with the given elasticity. `surface` holds the surface
    /// properties of their contact. With the elasticity `None` the wall has the elasticity of the contact law.
    pub fn of_wall(species: &Species, surface: &Surface, elasticity: Option<Elasticity>) -> Self {
        Self {
            effective_mass: species.mass(),
            effective_radius: 0.5 * species.diameter,
            restitution: surface.restitution,
            by_speed: surface.by_speed,
            elasticity: [species.elasticity, elasticity],
            stiffness_ratio: 1.0,
        }
    }
}

/// Constants of a contact law for the contact of two given bodies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spring {
    /// [kg] effective mass M of the two bodies.
    pub effective_mass: f64,
    /// [-] restitution e that an isolated impact of the two bodies has.
    pub restitution: f64,
    /// [N/m] stiffness of a linear spring; for Hertz's law, k_H [N/m^1.5] in the force k_H δ^(3/2) at the overlap δ.
    pub stiffness: f64,
    /// [N s/m] constant of a linear dashpot; for Hertz's law, c [N s/m^1.25] in the force c δ^(1/4) u_n; for Kuwabara
    /// and Kono's law, c [N s/m^1.5] in the force c δ^(1/2) u_n. Here δ is the overlap and u_n the normal velocity.
    pub dashpot: f64,
}
