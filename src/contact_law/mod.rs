//! Contact laws: the force with which two soft spheres push each other apart.
//!
//! A contact law is one file here and one variant of [`ContactLaw`]. It gives the force, the stored energy, the
//! duration and depth of an impact, and the frequency at which the contact oscillates. No other module reads the
//! parameters of a law.
//!
//! Sign convention: the overlap δ [m] is positive while the bodies touch. Its rate is minus the normal velocity u_n
//! [m/s], which is negative while the bodies approach. A contact ends when δ = 0 (the paper's convention). So the
//! force pulls a little at the end, and the restitution is exactly the one asked for.

mod hertz;
mod linear_spring_dashpot;

pub use hertz::Hertz;
pub use linear_spring_dashpot::LinearSpringDashpot;

use crate::particles::Particles;
use crate::scene::{Elasticity, Kind, Scene, Species, Surface};
use serde::{Deserialize, Serialize, Serializer};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Properties of two touching bodies that a contact law needs.
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
    /// [-] stiffness over that of the law, from [`Meeting`](crate::scene::Meeting).
    #[serde(skip)]
    pub stiffness_ratio: f64,
}

impl Bodies {
    /// The particles at indices `i` and `j` of a store.
    pub fn pair(scene: &Scene, particles: &Particles, i: usize, j: usize) -> Self {
        let species = [i, j].map(|place| particles.species[place]);
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

    /// The particle at index `i` of a store and a wall.
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

    /// Two spheres of the species with these indices in a scene; both indices may be equal.
    pub fn between(scene: &Scene, one: u16, other: u16) -> Self {
        let meeting = scene.meeting(one, Kind::Species(other));
        let (first, second) = (&scene.species[usize::from(one)], &scene.species[usize::from(other)]);
        let bodies =
            if one == other { Self::alike(first, &meeting.surface) } else { Self::of(first, second, &meeting.surface) };
        Self { stiffness_ratio: meeting.stiffness_of(bodies.effective_mass), ..bodies }
    }

    /// A sphere of the species with this index in a scene, and a wall.
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

    /// A sphere of a species and a wall with the given surface; without an elasticity of its own the wall takes that
    /// of the law.
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

/// Constants of a law between two given bodies.
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

/// Functions that every contact law provides.
pub trait Law {
    /// Constants of the law between two bodies.
    fn between(&self, bodies: &Bodies) -> Spring;

    /// Constants between bodies of mass 1 kg, in units in which the elastic constant is 1. In these units all impacts
    /// with one restitution are alike.
    fn unit(&self, restitution: f64) -> Spring;

    /// [-] exponent n: the elastic force is proportional to the overlap to the power n.
    fn exponent(&self) -> f64;

    /// [N] elastic and viscous parts of the normal force at overlap δ [m] and normal velocity u_n [m/s]. A time step
    /// may reach a small negative overlap at the end of a contact: there the force continues smoothly, and pulls.
    fn force(&self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64);

    /// [J] energy stored at overlap δ [m].
    fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64;

    /// [s] duration of an impact at normal speed `speed` > 0 [m/s]; infinite if it does not end.
    fn contact_time(&self, spring: &Spring, speed: f64) -> f64;

    /// [m] largest overlap of an impact at normal speed `speed` [m/s].
    fn greatest_overlap(&self, spring: &Spring, speed: f64) -> f64;

    /// [1/s] highest angular frequency sqrt(f'(δ)/M) that an impact at normal speed `speed` [m/s] reaches. A time
    /// step must be stable at this frequency.
    fn frequency(&self, spring: &Spring, speed: f64) -> f64;

    /// [-] damping ratio of small oscillations about any overlap: the viscous constant over the critical one at that
    /// overlap.
    fn swing_damping(&self, restitution: f64) -> f64;

    /// [m] ∫ exp(-V(δ)/E) dδ over all overlaps, with V the stored energy: the length by which spheres act as if they
    /// were smaller, if their relative motion has the energy scale `energy` E [J] (Barker and Henderson 1967, J.
    /// Chem. Phys. 47, 4714).
    fn thermal_overlap(&self, spring: &Spring, energy: f64) -> f64;

    /// Overlap [m] and its rate [m/s] as functions of the time [s] since first touch, for an impact at normal speed
    /// `speed` [m/s]. Valid up to the end of the impact.
    fn course(&self, spring: &Spring, speed: f64) -> Box<dyn Fn(f64) -> (f64, f64)>;

    /// [m] overlap of a contact at rest that carries `force` [N].
    fn static_overlap(&self, spring: &Spring, force: f64) -> f64 {
        (force / spring.stiffness).powf(1.0 / self.exponent())
    }

    /// [-] factor by which the law must be stiffer for impacts of equal energy to go only 1/`ratio` as deep. The
    /// energy at overlap δ is k δ^(n+1)/(n+1).
    fn stiffening(&self, ratio: f64) -> f64 {
        ratio.powf(self.exponent() + 1.0)
    }

    /// This law with an elastic force `factor` [-] times as large at every overlap.
    fn stiffened(&self, factor: f64) -> ContactLaw;

    /// Name of the law for use in a sentence.
    fn name(&self) -> &'static str;

    /// Table of the law in the case, below `[soft]`: name, keys and values in SI units.
    fn table(&self) -> (&'static str, Vec<(&'static str, f64)>);

    /// The elastic parameter that a user chooses: its key in the case, its value in SI units and its unit.
    fn parameter(&self) -> Parameter;
}

/// The parameter that makes a law soft or stiff, for tables and messages.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Key in the case.
    pub key: &'static str,
    /// Name for use in a sentence.
    pub name: &'static str,
    /// Symbol of the parameter.
    pub symbol: &'static str,
    /// Value in SI units.
    pub value: f64,
    /// SI unit of the value.
    pub unit: &'static str,
}

impl std::fmt::Display for Parameter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // moduli have too many digits to be read in full
        if self.value < 1e6 {
            write!(f, "{} {} {}", self.name, self.value, self.unit)
        } else {
            write!(f, "{} {:e} {}", self.name, self.value, self.unit)
        }
    }
}

/// The contact law of a soft scene, for pairs and walls.
///
/// ```
/// use diptych::contact_law::{Bodies, ContactLaw};
/// use diptych::{Species, Surface};
///
/// let glass = Species { name: "glass".into(), diameter: 1e-3, density: 2500.0, elasticity: None, sizes: None };
/// let law = ContactLaw::linear(1000.0); // N/m
/// let spring = law.between(&Bodies::alike(&glass, &Surface { restitution: 1.0, friction: 0.0 }));
/// // without damping a contact of two spheres lasts π sqrt(M/k_n), M half the mass of one
/// let lasts = std::f64::consts::PI * (0.5 * glass.mass() / 1000.0).sqrt(); // s
/// assert!((law.contact_time(&spring, 0.1) / lasts - 1.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactLaw {
    /// A linear spring beside a linear dashpot.
    LinearSpringDashpot(LinearSpringDashpot),
    /// Hertz's law with a viscous part.
    Hertz(Hertz),
}

/// Evaluates an expression with the chosen law: the only code that lists all laws.
macro_rules! with_law {
    ($chosen:expr, $law:ident => $value:expr) => {
        match $chosen {
            ContactLaw::LinearSpringDashpot($law) => $value,
            ContactLaw::Hertz($law) => $value,
        }
    };
}

impl ContactLaw {
    /// A linear spring of stiffness k_n [N/m] beside a linear dashpot.
    pub const fn linear(stiffness: f64) -> Self {
        Self::LinearSpringDashpot(LinearSpringDashpot { stiffness })
    }

    /// [N] as [`Law::force`]. It is called in every time step, so it avoids dynamic dispatch.
    #[inline]
    pub fn force(&self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64) {
        with_law!(self, law => law.force(spring, overlap, normal_velocity))
    }

    /// [J] as [`Law::stored_energy`], without dynamic dispatch.
    #[inline]
    pub fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64 {
        with_law!(self, law => law.stored_energy(spring, overlap))
    }
}

impl Serialize for ContactLaw {
    /// Serializes the law as its table of the case.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (name, values) = self.table();
        BTreeMap::from([(name, values.into_iter().collect::<BTreeMap<_, _>>())]).serialize(serializer)
    }
}

impl std::fmt::Display for ContactLaw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, {}", self.name(), self.parameter())
    }
}

impl std::ops::Deref for ContactLaw {
    type Target = dyn Law;

    fn deref(&self) -> &(dyn Law + 'static) {
        with_law!(self, law => law)
    }
}

/// [-] damping ratio ζ = -ln e / sqrt(π² + ln² e) of a linear spring and dashpot with restitution e (the paper, below
/// Eq. 6); 1 for e = 0.
pub fn damping_ratio(restitution: f64) -> f64 {
    if restitution <= 0.0 {
        return 1.0;
    }
    let ln = restitution.ln();
    -ln / (PI * PI + ln * ln).sqrt()
}

/// [-] largest overlap of an impact on a linear spring and dashpot, in units of u/ω_0 (the paper's Eq. 10):
/// exp(-ζ arccos ζ / sqrt(1 - ζ²)).
pub fn reduced_overlap(restitution: f64) -> f64 {
    let ratio = damping_ratio(restitution);
    if ratio >= 1.0 {
        return (-1.0f64).exp(); // the limit ζ -> 1: critical damping
    }
    (-ratio * ratio.acos() / (1.0 - ratio * ratio).sqrt()).exp()
}

/// [N] magnitude of the Coulomb force against a slip of `slip` >= 0 [m/s] (the paper's rule, without rotation):
/// μ|f_n| with the `friction` μ [-], but never more than would stop the slip within `time_step` [s].
#[inline]
pub fn friction_force(friction: f64, normal_force: f64, slip: f64, effective_mass: f64, time_step: f64) -> f64 {
    (friction * normal_force.abs()).min(effective_mass * slip / time_step)
}
