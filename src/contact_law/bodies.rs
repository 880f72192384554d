//! Two touching bodies as a contact law sees them, and the constants that it makes of them.

use crate::particles::Particles;
use crate::scene::{Elasticity, Kind, Scene, Species, Surface};
use serde::{Deserialize, Serialize};

/// Two touching bodies as a contact law needs them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bodies {
    /// [kg] effective mass M = 1/(1/m_p + 1/m_q); at a wall the particle's own mass.
    pub effective_mass: f64,
    /// [m] effective radius R = 1/(1/r_p + 1/r_q); at a wall the particle's own radius.
    pub effective_radius: f64,
    /// [-] normal restitution e that an isolated impact is to have.
    pub restitution: f64,
    /// Elasticity of each body, where it has one of its own.
    #[serde(skip)]
    pub elasticity: [Option<Elasticity>; 2],
    /// [-] stiffness over that which the law says, from [`Meeting`](crate::scene::Meeting).
    #[serde(skip)]
    pub stiffness_ratio: f64,
}

impl Bodies {
    /// Two particles, by their indices `i` and `j` in a store.
    pub fn pair(scene: &Scene, particles: &Particles, i: usize, j: usize) -> Self {
        let species = [i, j].map(|index| particles.species[index]);
        let meeting = scene.meeting(species[0], Kind::Species(species[1]));
        let effective_mass = 1.0 / (1.0 / particles.mass[i] + 1.0 / particles.mass[j]);
        Self {
            effective_mass,
            effective_radius: 1.0 / (1.0 / particles.radius[i] + 1.0 / particles.radius[j]),
            restitution: meeting.surface.restitution,
            elasticity: species.map(|species| scene.species[usize::from(species)].elasticity),
            stiffness_ratio: meeting.stiffness_of(effective_mass),
        }
    }

    /// A particle, by its index `i` in a store, and a wall.
    pub fn at_wall(scene: &Scene, particles: &Particles, i: usize, wall: usize) -> Self {
        let species = particles.species[i];
        let meeting = scene.meeting(species, Kind::Wall(wall as u32));
        Self {
            effective_mass: particles.mass[i],
            effective_radius: particles.radius[i],
            restitution: meeting.surface.restitution,
            elasticity: [scene.species[usize::from(species)].elasticity, scene.walls[wall].elasticity],
            stiffness_ratio: meeting.stiffness_of(particles.mass[i]),
        }
    }

    /// Two spheres of two species.
    pub fn of(one: &Species, other: &Species, surface: &Surface) -> Self {
        Self {
            effective_mass: 1.0 / (1.0 / one.mass() + 1.0 / other.mass()),
            effective_radius: 1.0 / (2.0 / one.diameter + 2.0 / other.diameter),
            restitution: surface.restitution,
            elasticity: [one.elasticity, other.elasticity],
            stiffness_ratio: 1.0,
        }
    }

    /// Two spheres of species with these indices in a scene, which may be one species.
    pub fn between(scene: &Scene, one: u16, other: u16) -> Self {
        let meeting = scene.meeting(one, Kind::Species(other));
        let (first, second) = (&scene.species[usize::from(one)], &scene.species[usize::from(other)]);
        let bodies =
            if one == other { Self::alike(first, &meeting.surface) } else { Self::of(first, second, &meeting.surface) };
        Self { stiffness_ratio: meeting.stiffness_of(bodies.effective_mass), ..bodies }
    }

    /// A sphere of the species with that index in a scene, and a wall.
    pub fn beside(scene: &Scene, species: u16, wall: u32) -> Self {
        let meeting = scene.meeting(species, Kind::Wall(wall));
        let elasticity = scene.walls[wall as usize].elasticity;
        let bodies = Self::of_wall(&scene.species[usize::from(species)], &meeting.surface, elasticity);
        Self { stiffness_ratio: meeting.stiffness_of(bodies.effective_mass), ..bodies }
    }

    /// Two spheres of one species.
    pub fn alike(species: &Species, surface: &Surface) -> Self {
        Self {
            effective_mass: 0.5 * species.mass(),
            effective_radius: 0.25 * species.diameter,
            restitution: surface.restitution,
            elasticity: [species.elasticity; 2],
            stiffness_ratio: 1.0,
        }
    }

    /// A sphere of a species and a wall with that surface. A wall without an elasticity of its own has that of the law.
    pub fn of_wall(species: &Species, surface: &Surface, elasticity: Option<Elasticity>) -> Self {
        Self {
            effective_mass: species.mass(),
            effective_radius: 0.5 * species.diameter,
            restitution: surface.restitution,
            elasticity: [species.elasticity, elasticity],
            stiffness_ratio: 1.0,
        }
    }
}

/// The constants of a law between two given bodies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spring {
    /// [kg] effective mass M.
    pub effective_mass: f64,
    /// [-] restitution e asked for.
    pub restitution: f64,
    /// [N/m] elastic constant of a linear spring; [N/m^1.5] of Hertz's law.
    pub stiffness: f64,
    /// [N s/m] viscous constant of a linear dashpot; [N s/m^1.25] of Hertz's law.
    pub dashpot: f64,
}
