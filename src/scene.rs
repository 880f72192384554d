//! The scene: input data of a simulation that all engines read and none of them changes.

mod buoyancy;
mod sizes;
mod start_region;

pub use buoyancy::ADDED_MASS;
pub use sizes::{Fraction, SizeDistribution};
pub use start_region::StartRegion;

use crate::domain::Domain;
use crate::fluid::Fluid;
use crate::particles::Particles;
use crate::rotation::{ImpactKind, ResistanceFriction, Rotation, SOLID_SPHERE, tangential_mass};
use crate::walls::Wall;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Properties of an impact between two surfaces, for soft and hard engines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Surface {
    /// [-] normal restitution e, 0 ..= 1: ratio of normal speeds after and before an isolated impact.
    pub restitution: f64,
    /// [-] Coulomb friction μ, >= 0.
    pub friction: f64,
}

/// Properties of the contact between two kinds of bodies, which are two species or a species and a wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Meeting {
    /// Restitution and friction, for soft and hard engines.
    pub surface: Surface,
    /// [-] stiffness of soft contacts of the pair over that of the contact law.
    pub stiffness_ratio: f64,
    /// [kg] effective mass at which `stiffness_ratio` holds, if the stiffness of a contact is proportional to the
    /// effective mass of the two bodies. All contacts of the pair then last equally long. `None`: the stiffness does
    /// not depend on the masses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_mass: Option<f64>,
    /// Rolling and twisting friction, where they differ from those of the contact law.
    #[serde(skip_serializing_if = "ResistanceFriction::is_of_law")]
    pub resistance: ResistanceFriction,
}

impl Meeting {
    /// [-] stiffness, over that of the contact law, of two bodies with an effective mass [kg].
    #[inline]
    pub fn stiffness_of(&self, effective_mass: f64) -> f64 {
        match self.at_mass {
            None => self.stiffness_ratio,
            Some(mass) => self.stiffness_ratio * (effective_mass / mass),
        }
    }
}

impl From<Surface> for Meeting {
    /// Contact properties with the given surface and the stiffness of the contact law.
    fn from(surface: Surface) -> Self {
        Self { surface, stiffness_ratio: 1.0, at_mass: None, resistance: ResistanceFriction::default() }
    }
}

/// Kind of a collision partner: a species or a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Particles of a species, by its index in [`Scene::species`].
    Species(u16),
    /// A wall, by its index in [`Scene::walls`].
    Wall(u32),
}

/// Pairs of kinds with contact properties of their own. All other pairs use [`Scene::contact`] or the surface of the
/// wall.
///
/// ```
/// use diptych::scene::{Kind, Pairs};
/// use diptych::Surface;
///
/// let mut pairs = Pairs::default();
/// pairs.set(1, Kind::Species(0), Surface { restitution: 0.8, friction: 0.2 }.into());
/// // the order of the two kinds does not matter
/// assert_eq!(pairs.find(0, Kind::Species(1)).map(|meeting| meeting.surface.restitution), Some(0.8));
/// assert!(pairs.find(0, Kind::Wall(1)).is_none());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Pairs(Vec<(u16, Kind, Meeting)>);

/// Pair of kinds in sorted order. Of two species, the one with the lower index comes first.
#[inline]
pub(crate) fn in_order(species: u16, other: Kind) -> (u16, Kind) {
    match other {
        Kind::Species(other) if other < species => (other, Kind::Species(species)),
        Kind::Species(_) | Kind::Wall(_) => (species, other),
    }
}

impl Pairs {
    /// Sets the contact properties of a pair of a species and another kind.
    pub fn set(&mut self, species: u16, other: Kind, meeting: Meeting) {
        let key = in_order(species, other);
        match self.0.binary_search_by_key(&key, |(species, other, _)| (*species, *other)) {
            Ok(place) => self.0[place].2 = meeting,
            Err(place) => self.0.insert(place, (key.0, key.1, meeting)),
        }
    }

    /// Contact properties of a pair of a species and another kind, if they were set for this pair.
    #[inline]
    pub fn find(&self, species: u16, other: Kind) -> Option<&Meeting> {
        if self.0.is_empty() {
            return None;
        }
        let key = in_order(species, other);
        self.0.binary_search_by_key(&key, |(species, other, _)| (*species, *other)).ok().map(|place| &self.0[place].2)
    }

    /// All pairs: a species, the other kind and their contact properties, in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = &(u16, Kind, Meeting)> {
        self.0.iter()
    }

    /// True if no pair has properties of its own.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Mutable surfaces of all pairs.
    pub fn surfaces_mut(&mut self) -> impl Iterator<Item = &mut Surface> {
        self.0.iter_mut().map(|(_, _, meeting)| &mut meeting.surface)
    }
}

/// Elastic constants of a solid. They are used only by contact laws that derive their stiffness from materials.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Elasticity {
    /// [Pa] Young's modulus E.
    pub youngs_modulus: f64,
    /// [-] Poisson's ratio ν, -1 < ν <= 0.5.
    pub poissons_ratio: f64,
}

/// One kind of particle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Species {
    /// Name as written in the case.
    pub name: String,
    /// [m] diameter d. For spheres of different sizes it is the diameter of the mean volume, the cube root of the
    /// mean of d³.
    pub diameter: f64,
    /// [kg/m³] density ρ_p.
    pub density: f64,
    /// [kg/m³] added mass over the volume of a sphere: gas that accelerates together with the sphere. 0 without added
    /// mass.
    #[serde(skip_serializing_if = "is_zero")]
    pub added_density: f64,
    /// Elasticity of the species; `None`: the elasticity of the contact law.
    pub elasticity: Option<Elasticity>,
    /// Distribution of the diameters; `None`: all particles have the diameter `diameter`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sizes: Option<SizeDistribution>,
    /// [-] moment of inertia about the centre over m r², where m is the mass without added mass: 2/5 of a solid sphere,
    /// 2/3 of a thin shell.
    #[serde(skip_serializing_if = "is_solid")]
    pub inertia_factor: f64,
}

/// True if the inertia factor is that of a solid sphere, which is left out of the stored scene.
fn is_solid(factor: &f64) -> bool {
    *factor == SOLID_SPHERE
}

/// True if the density is 0 (no added mass), which is left out of the stored scene.
fn is_zero(density: &f64) -> bool {
    *density == 0.0
}

impl Species {
    /// A species of solid spheres of one size: diameter [m] and density [kg/m³].
    pub fn new(name: impl Into<String>, diameter: f64, density: f64) -> Self {
        let (name, elasticity, sizes) = (name.into(), None, None);
        Self { name, diameter, density, added_density: 0.0, elasticity, sizes, inertia_factor: SOLID_SPHERE }
    }

    /// [m³] volume of one sphere, π d³/6. If sizes differ, it is the mean volume.
    pub fn volume(&self) -> f64 {
        std::f64::consts::PI / 6.0 * self.diameter.powi(3)
    }

    /// [kg/m³] mass that a force accelerates, over the volume of a sphere: density plus added mass per volume.
    pub fn inertial_density(&self) -> f64 {
        self.density + self.added_density
    }

    /// [kg] mass of one sphere with its added mass. If sizes differ, it is the mean mass.
    pub fn mass(&self) -> f64 {
        self.inertial_density() * self.volume()
    }

    /// [-] moment of inertia about the centre over m r², where m is the mass with added mass. The moment of inertia
    /// itself has no part of added mass, because a sphere that only rotates does not accelerate the gas around it.
    pub fn factor_with_added_mass(&self) -> f64 {
        self.inertia_factor * (self.density / self.inertial_density())
    }

    /// [m] smallest possible diameter.
    pub fn smallest(&self) -> f64 {
        self.sizes.as_ref().map_or(self.diameter, SizeDistribution::smallest)
    }

    /// [m] largest possible diameter.
    pub fn largest(&self) -> f64 {
        self.sizes.as_ref().map_or(self.diameter, SizeDistribution::largest)
    }

    /// A copy of the species in which all particles have one diameter [m].
    pub fn of_one_size(&self, diameter: f64) -> Self {
        Self { diameter, sizes: None, ..self.clone() }
    }
}

/// Domain, walls, gravity, gas and surfaces: read-only while a simulation runs.
///
/// ```
/// use diptych::{Domain, Plane, Scene, Species, Surface, Vector3, Wall, WallGeometry};
///
/// let surface = Surface { restitution: 0.9, friction: 0.1 };
/// let floor = Plane { point: Vector3::zeros(), normal: Vector3::y() };
/// let scene = Scene {
///     domain: Domain::new(Vector3::repeat(0.01), [true, false, true]), // m
///     gravity: Vector3::new(0.0, -9.81, 0.0),                          // m/s^2
///     fluid: None,
///     walls: vec![Wall::new(WallGeometry::Plane(floor), surface)],
///     contact: surface,
///     pairs: Default::default(),
///     rotation: None,
///     species: vec![Species::new("glass", 1e-3, 2500.0)],
/// };
/// assert!((scene.species[0].mass() - 1.309e-6).abs() < 1e-9); // kg
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct Scene {
    /// Box and periodicity.
    pub domain: Domain,
    /// [m/s²] acceleration of the particles by gravity. With [buoyancy](Self::add_buoyancy), it is the acceleration of
    /// the densest species by weight and buoyancy.
    pub gravity: Vector3<f64>,
    /// The gas with its velocity profile and drag law; `None`: no gas and no drag.
    pub fluid: Option<Fluid>,
    /// Walls, each with its own surface.
    pub walls: Vec<Wall>,
    /// Surface of two particles, for all pairs of species that are not in `pairs`.
    pub contact: Surface,
    /// Pairs of species, and of species and walls, with contact properties of their own.
    #[serde(skip_serializing_if = "Pairs::is_empty")]
    pub pairs: Pairs,
    /// Kinds of particles. `Particles::species` contains indices of this list.
    pub species: Vec<Species>,
    /// Tangential law of spheres that rotate. `None`: no sphere rotates, and friction depends on the current slip
    /// alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Rotation>,
}

impl Scene {
    /// [m³] volume available to particles: that of the domain, or of the smallest vessel if that is smaller.
    pub fn room(&self) -> f64 {
        let vessels = self.walls.iter().filter_map(|wall| wall.geometry.law().vessel_volume(&self.domain.size));
        vessels.fold(self.domain.volume(), f64::min)
    }

    /// Gives the particles spin and inertia, if spheres of the scene rotate.
    pub fn let_rotate(&self, particles: &mut Particles) {
        if self.rotation.is_some() {
            particles.let_rotate(&self.species.iter().map(Species::factor_with_added_mass).collect::<Vec<_>>());
        }
    }

    /// Kinds of impacts that can happen, without duplicates; spheres of spread sizes count as mean spheres.
    /// `shear_ratio` returns, for two bodies with the given elasticities, Mindlin's tangential stiffness over Hertz's
    /// elastic constant [-].
    pub fn impact_kinds(&self, shear_ratio: impl Fn([Option<Elasticity>; 2]) -> f64) -> Vec<ImpactKind> {
        let species = |species: u16| &self.species[usize::from(species)];
        let body = |of: u16| {
            let species = species(of);
            let (mass, radius) = (species.mass(), 0.5 * species.diameter);
            (mass, radius, species.factor_with_added_mass() * mass * radius * radius)
        };
        let ratio = |bodies: &[(f64, f64, f64)]| {
            tangential_mass(bodies.iter().copied()) * bodies.iter().map(|(mass, ..)| 1.0 / mass).sum::<f64>()
        };
        let pairs = self.meetings().map(|(one, other, meeting)| {
            let shear_ratio = shear_ratio([species(one).elasticity, species(other).elasticity]);
            let mass_ratio = ratio(&[body(one), body(other)]);
            ImpactKind { restitution: meeting.surface.restitution, mass_ratio, shear_ratio }
        });
        let walls = self.meetings_at_walls().map(|(one, wall, meeting)| {
            let shear_ratio = shear_ratio([species(one).elasticity, self.walls[wall as usize].elasticity]);
            ImpactKind { restitution: meeting.surface.restitution, mass_ratio: ratio(&[body(one)]), shear_ratio }
        });
        let mut kinds: Vec<ImpactKind> = Vec::new();
        for kind in pairs.chain(walls) {
            if !kinds.iter().any(|other| other.is_like(&kind)) {
                kinds.push(kind);
            }
        }
        kinds
    }

    /// Contact properties of a species with another kind.
    #[inline]
    pub fn meeting(&self, species: u16, other: Kind) -> Meeting {
        match self.pairs.find(species, other) {
            Some(meeting) => *meeting,
            None => Meeting { resistance: self.resistance(species, other), ..(*self.usual(other)).into() },
        }
    }

    /// Rolling and twisting friction of a species with another kind.
    #[inline]
    pub fn resistance(&self, species: u16, other: Kind) -> ResistanceFriction {
        match (self.pairs.find(species, other), other) {
            (Some(meeting), _) => meeting.resistance,
            (None, Kind::Wall(wall)) => self.walls[wall as usize].resistance,
            (None, Kind::Species(_)) => ResistanceFriction::default(),
        }
    }

    /// Restitution and friction of a species with another kind.
    #[inline]
    pub fn surface(&self, species: u16, other: Kind) -> &Surface {
        self.pairs.find(species, other).map_or_else(|| self.usual(other), |meeting| &meeting.surface)
    }

    /// Surface in contacts with a kind, for all pairs that are not in `pairs`.
    #[inline]
    fn usual(&self, other: Kind) -> &Surface {
        match other {
            Kind::Species(_) => &self.contact,
            Kind::Wall(wall) => &self.walls[wall as usize].surface,
        }
    }

    /// All pairs of species with their contact properties. The index of the first species is at most that of the
    /// second.
    pub fn meetings(&self) -> impl Iterator<Item = (u16, u16, Meeting)> {
        let count = self.species.len() as u16;
        let each = move |one| (one..count).map(move |other| (one, other, self.meeting(one, Kind::Species(other))));
        (0..count).flat_map(each)
    }

    /// All pairs of a species and a wall, with their contact properties.
    pub fn meetings_at_walls(&self) -> impl Iterator<Item = (u16, u32, Meeting)> {
        let (count, walls) = (self.species.len() as u16, self.walls.len() as u32);
        let each = move |one| (0..walls).map(move |wall| (one, wall, self.meeting(one, Kind::Wall(wall))));
        (0..count).flat_map(each)
    }

    /// All species, each with the stiffness of contacts between two of its particles over that of the contact law [-].
    pub fn alike(&self) -> impl Iterator<Item = (&Species, f64)> {
        (0..).zip(&self.species).map(|(index, species)| {
            (species, self.meeting(index, Kind::Species(index)).stiffness_of(0.5 * species.mass()))
        })
    }

    /// [m] smallest diameter that any particle can have; infinite without species.
    pub fn smallest_diameter(&self) -> f64 {
        self.species.iter().map(Species::smallest).fold(f64::INFINITY, f64::min)
    }

    /// [m] largest diameter that any particle can have; 0 without species.
    pub fn largest_diameter(&self) -> f64 {
        self.species.iter().map(Species::largest).fold(0.0, f64::max)
    }

    /// Two copies of the scene: with all particles at their smallest diameter, and with all at their largest. There is
    /// only one copy if every species has one size.
    pub fn at_extremes(&self) -> Vec<Self> {
        if !self.has_sizes() {
            return vec![self.clone()];
        }
        let with = |size: fn(&Species) -> f64| Self {
            species: self.species.iter().map(|species| species.of_one_size(size(species))).collect(),
            ..self.clone()
        };
        vec![with(Species::smallest), with(Species::largest)]
    }

    /// True if any species has a distribution of diameters.
    pub fn has_sizes(&self) -> bool {
        self.species.iter().any(|species| species.sizes.is_some())
    }

    /// [m/s] speed below which a particle counts as at rest: a hundredth of sqrt(g d), with gravity g and the smallest
    /// diameter d. A particle with this speed rises by d/20,000. 0 without gravity.
    pub fn rest_speed(&self) -> f64 {
        0.01 * (self.gravity.norm() * self.smallest_diameter()).sqrt()
    }

    /// [-] restitution between particles; `None` if it differs between pairs of species.
    pub fn restitution_of_pairs(&self) -> Option<f64> {
        if self.pairs.is_empty() {
            return Some(self.contact.restitution);
        }
        same(self.meetings().map(|(_, _, meeting)| meeting.surface.restitution))
    }

    /// [-] restitution at walls; `None` without walls, or if it differs between walls or species.
    pub fn restitution_at_walls(&self) -> Option<f64> {
        if self.pairs.is_empty() {
            return same(self.walls.iter().map(|wall| wall.surface.restitution));
        }
        same(self.meetings_at_walls().map(|(_, _, meeting)| meeting.surface.restitution))
    }

    /// Surfaces of all contacts between particles and at walls. For `particles` < 2 there are only those at walls. If
    /// no pair has properties of its own, the list has one surface per wall and [`contact`](Self::contact).
    pub fn surfaces(&self, particles: usize) -> Vec<Surface> {
        if self.pairs.is_empty() {
            let walls = self.walls.iter().map(|wall| wall.surface);
            return walls.chain((particles > 1).then_some(self.contact)).collect();
        }
        let walls = self.meetings_at_walls().map(|(_, _, meeting)| meeting.surface);
        let pairs = self.meetings().map(|(_, _, meeting)| meeting.surface).filter(|_| particles > 1);
        walls.chain(pairs).collect()
    }
}

/// The common value of all numbers; `None` without numbers or if they differ.
fn same(mut numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let first = numbers.next()?;
    numbers.all(|number| number == first).then_some(first)
}
