//! The scene: walls, gravity, gas and materials, which engines read and do not change.

mod buoyancy;
mod instants;
mod openings;
mod sizes;
mod start_region;
mod surface;
mod thermostat;

pub use buoyancy::ADDED_MASS;
pub use instants::SceneInTime;
pub use openings::{Inlet, Outlet, OutletShape};
pub use sizes::{Fraction, SizeDistribution};
pub use start_region::StartRegion;
pub use surface::Surface;
pub use thermostat::Thermostat;

use crate::domain::Domain;
use crate::fluid::Fluid;
use crate::particles::Particles;
use crate::rotation::{ImpactKind, ResistanceFriction, Rotation, SOLID_SPHERE, tangential_mass};
use crate::walls::Wall;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Contact properties of a pair of bodies: two particles of the same or of different species, or a particle and a wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Meeting {
    /// Restitution and friction of the two bodies, which all engines use.
    pub surface: Surface,
    /// [-] stiffness of soft contacts of the pair, divided by the stiffness of the contact law.
    pub stiffness_ratio: f64,
    /// [kg] effective mass for which `stiffness_ratio` is valid. The stiffness of a contact is then proportional to the
    /// effective mass of its two bodies, so that all contacts of the pair have one duration. `None` if the stiffness
    /// does not depend on the masses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_mass: Option<f64>,
    /// Coefficients of rolling and twisting friction of this pair. A coefficient that is missing is taken from the
    /// rolling or twisting law.
    #[serde(skip_serializing_if = "ResistanceFriction::is_of_law")]
    pub resistance: ResistanceFriction,
}

impl Meeting {
    /// [-] stiffness of a contact of two bodies with an effective mass [kg], over that of the contact law.
    #[inline]
    pub fn stiffness_of(&self, effective_mass: f64) -> f64 {
        match self.at_mass {
            None => self.stiffness_ratio,
            Some(mass) => self.stiffness_ratio * (effective_mass / mass),
        }
    }
}

impl From<Surface> for Meeting {
    /// Makes the contact properties of a pair with the surface `surface`. The stiffness of the pair is that of the
    /// contact law. Its rolling and twisting friction are those of the rolling and twisting laws.
    fn from(surface: Surface) -> Self {
        Self { surface, stiffness_ratio: 1.0, at_mass: None, resistance: ResistanceFriction::default() }
    }
}

/// Type of a body in a contact: a species of particles, or a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Particles of a species, by its index in [`Scene::species`].
    Species(u16),
    /// A wall, by its index in [`Scene::walls`].
    Wall(u32),
}

/// Contact properties of particular pairs of bodies. All other pairs have those of [`Scene::contact`] or of their wall.
///
/// ```
/// # extern crate diptych_physics as diptych;
/// use diptych::scene::{Kind, Pairs, Surface};
///
/// let mut pairs = Pairs::default();
/// pairs.set(1, Kind::Species(0), Surface::new(0.8, 0.2).into());
/// // the order of the two does not matter
/// assert_eq!(pairs.find(0, Kind::Species(1)).map(|meeting| meeting.surface.restitution), Some(0.8));
/// assert!(pairs.find(0, Kind::Wall(1)).is_none());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Pairs(Vec<(u16, Kind, Meeting)>);

/// Puts a species and the other body of a pair, `other`, into the order in which pairs are stored. Of two species, the
/// one with the smaller index comes first; a species comes before a wall.
#[inline]
pub(crate) fn in_order(species: u16, other: Kind) -> (u16, Kind) {
    match other {
        Kind::Species(other) if other < species => (other, Kind::Species(species)),
        Kind::Species(_) | Kind::Wall(_) => (species, other),
    }
}

impl Pairs {
    /// Sets the contact properties of a species and another species or a wall.
    pub fn set(&mut self, species: u16, other: Kind, meeting: Meeting) {
        let key = in_order(species, other);
        match self.0.binary_search_by_key(&key, |(species, other, _)| (*species, *other)) {
            Ok(place) => self.0[place].2 = meeting,
            Err(place) => self.0.insert(place, (key.0, key.1, meeting)),
        }
    }

    /// Contact properties of a species and another species or a wall; `None` if no properties were set for this pair.
    #[inline]
    pub fn find(&self, species: u16, other: Kind) -> Option<&Meeting> {
        if self.0.is_empty() {
            return None;
        }
        let key = in_order(species, other);
        self.0.binary_search_by_key(&key, |(species, other, _)| (*species, *other)).ok().map(|place| &self.0[place].2)
    }

    /// All pairs in ascending order: a species, another species or a wall, and their contact properties.
    pub fn iter(&self) -> impl Iterator<Item = &(u16, Kind, Meeting)> {
        self.0.iter()
    }

    /// True if contact properties were set for no pair.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Mutable references to the surfaces (restitution and friction) of all pairs.
    pub fn surfaces_mut(&mut self) -> impl Iterator<Item = &mut Surface> {
        self.0.iter_mut().map(|(_, _, meeting)| &mut meeting.surface)
    }
}

/// Elastic constants of a solid. Only contact laws whose stiffness follows from the material use them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Elasticity {
    /// [Pa] Young's modulus E.
    pub youngs_modulus: f64,
    /// [-] Poisson's ratio ν, -1 < ν <= 0.5.
    pub poissons_ratio: f64,
}

/// Kind of particles: spheres of one material, of one size or with a distribution of sizes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Species {
    /// Name of the species, as written in the case.
    pub name: String,
    /// [m] diameter d. For spheres of different sizes it is the diameter of the mean volume, the cube root of the
    /// mean of d³.
    pub diameter: f64,
    /// [kg/m³] density ρ_p of the particles.
    pub density: f64,
    /// [kg/m³] added mass (inertia of the gas that a sphere accelerates) over the volume of the sphere. 0 without added
    /// mass.
    #[serde(skip_serializing_if = "is_zero")]
    pub added_density: f64,
    /// Elasticity of the species; `None` means the elasticity of the contact law.
    pub elasticity: Option<Elasticity>,
    /// Distribution of the diameters; `None` if all particles have the same diameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sizes: Option<SizeDistribution>,
    /// [-] moment of inertia about the centre over m r², where m is the mass without added mass: 2/5 for a solid
    /// sphere, 2/3 for a thin shell.
    #[serde(skip_serializing_if = "is_solid")]
    pub inertia_factor: f64,
}

/// True for the inertia factor of a solid sphere, which is the default and is not serialized.
fn is_solid(factor: &f64) -> bool {
    *factor == SOLID_SPHERE
}

/// True if a species has no added mass, which is the default and is not serialized.
fn is_zero(density: &f64) -> bool {
    *density == 0.0
}

impl Species {
    /// Makes a species of solid spheres of one size, from the diameter [m] and the density [kg/m³].
    pub fn new(name: impl Into<String>, diameter: f64, density: f64) -> Self {
        let (name, elasticity, sizes) = (name.into(), None, None);
        Self { name, diameter, density, added_density: 0.0, elasticity, sizes, inertia_factor: SOLID_SPHERE }
    }

    /// [m³] volume of one sphere, π d³/6; the mean volume if sizes differ.
    pub fn volume(&self) -> f64 {
        std::f64::consts::PI / 6.0 * self.diameter.powi(3)
    }

    /// [kg/m³] inertial mass of a sphere (its mass plus the added mass), divided by its volume.
    pub fn inertial_density(&self) -> f64 {
        self.density + self.added_density
    }

    /// [kg] mass of one sphere with its added mass; the mean mass if sizes differ.
    pub fn mass(&self) -> f64 {
        self.inertial_density() * self.volume()
    }

    /// [-] moment of inertia about the centre over m r², where m includes the added mass. A rotating sphere accelerates
    /// no gas, so the moment of inertia is that of the sphere alone.
    pub fn factor_with_added_mass(&self) -> f64 {
        self.inertia_factor * (self.density / self.inertial_density())
    }

    /// [m] smallest possible diameter of a sphere of this species.
    pub fn smallest(&self) -> f64 {
        self.sizes.as_ref().map_or(self.diameter, SizeDistribution::smallest)
    }

    /// [m] largest possible diameter of a sphere of this species.
    pub fn largest(&self) -> f64 {
        self.sizes.as_ref().map_or(self.diameter, SizeDistribution::largest)
    }

    /// Returns a copy of the species in which all particles have one diameter [m].
    pub fn of_one_size(&self, diameter: f64) -> Self {
        Self { diameter, sizes: None, ..self.clone() }
    }
}

/// Domain, walls, gravity, gas and surfaces. Engines do not change them. The simulation changes walls that move, the
/// images of a sheared box, and a gas on which particles act.
///
/// ```
/// # extern crate diptych_physics as diptych;
/// use diptych::{Domain, Plane, Scene, Species, Surface, Vector3, Wall, WallGeometry};
///
/// let surface = Surface::new(0.9, 0.1);
/// let floor = Plane { point: Vector3::zeros(), normal: Vector3::y() };
/// let domain = Domain::new(Vector3::repeat(0.01), [true, false, true]); // m
/// let scene = Scene {
///     gravity: Vector3::new(0.0, -9.81, 0.0), // m/s^2
///     walls: vec![Wall::new(WallGeometry::Plane(floor), surface)],
///     ..Scene::new(domain, surface, vec![Species::new("glass", 1e-3, 2500.0)])
/// };
/// assert!((scene.species[0].mass() - 1.309e-6).abs() < 1e-9); // kg
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct Scene {
    /// Box with its edge lengths, periodic axes and shear.
    pub domain: Domain,
    /// [m/s²] acceleration of the particles by gravity. With [buoyancy](Self::add_buoyancy), it is the acceleration of
    /// the densest species by weight and buoyancy.
    pub gravity: Vector3<f64>,
    /// The gas with its velocity profile and drag law; `None` if the scene has no gas.
    pub fluid: Option<Fluid>,
    /// Walls, each with its own surface.
    pub walls: Vec<Wall>,
    /// Restitution and friction of contacts between particles, for pairs of species that are not in `pairs`.
    pub contact: Surface,
    /// Particular contact properties of pairs of species, and of pairs of a species and a wall.
    #[serde(skip_serializing_if = "Pairs::is_empty")]
    pub pairs: Pairs,
    /// Species of the particles; `Particles::species` contains indices into this list.
    pub species: Vec<Species>,
    /// Laws of friction of rotating spheres; `None` if spheres do not rotate and friction has no tangential spring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Rotation>,
    /// Heating of the particles from outside; `None` if the particles are not heated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thermostat: Option<Thermostat>,
    /// Places where particles leave the scene.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outlets: Vec<Outlet>,
    /// Places where particles come into the scene.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inlets: Vec<Inlet>,
}

impl Scene {
    /// Makes a scene without walls, gravity, gas, rotation and heat. Further parts are set in its fields.
    pub fn new(domain: Domain, contact: Surface, species: Vec<Species>) -> Self {
        Self {
            domain,
            gravity: Vector3::zeros(),
            fluid: None,
            walls: Vec::new(),
            contact,
            pairs: Pairs::default(),
            species,
            rotation: None,
            thermostat: None,
            outlets: Vec::new(),
            inlets: Vec::new(),
        }
    }

    /// [m³] volume available to particles: the volume of the domain, or of the smallest vessel (hollow wall) in it.
    pub fn room(&self) -> f64 {
        let vessels = self.walls.iter().filter_map(|wall| wall.geometry.law().vessel_volume(&self.domain.size));
        vessels.fold(self.domain.volume(), f64::min)
    }

    /// Adds spins and moments of inertia to the particles, if spheres of the scene rotate.
    pub fn let_rotate(&self, particles: &mut Particles) {
        if self.rotation.is_some() {
            particles.let_rotate(&self.species.iter().map(Species::factor_with_added_mass).collect::<Vec<_>>());
        }
    }

    /// Sets the seed of the random numbers that rough and thermal walls use in rebounds.
    pub fn seed_walls(&mut self, seed: u64) {
        for wall in &mut self.walls {
            wall.roughness.iter_mut().for_each(|roughness| roughness.seed = seed);
            wall.thermal.iter_mut().for_each(|thermal| thermal.seed = seed);
        }
    }

    /// True if the box is periodic in all directions, without walls, gas or shear.
    pub fn is_homogeneous(&self) -> bool {
        self.domain.periodic == [true; 3]
            && self.walls.is_empty()
            && self.fluid.is_none()
            && self.domain.shear.is_none()
    }

    /// True if a thermostat or thermal walls give energy to the particles.
    pub fn is_heated(&self) -> bool {
        self.thermostat.is_some() || self.has_thermal_walls()
    }

    /// True if the restitution of any impact depends on its speed.
    pub fn depends_on_speed(&self) -> bool {
        let walls = self.walls.iter().map(|wall| &wall.surface);
        let pairs = self.pairs.iter().map(|(_, _, meeting)| &meeting.surface);
        walls.chain(pairs).chain([&self.contact]).any(|surface| surface.by_speed.is_some())
    }

    /// Chooses the restitution that predictions use, for every surface whose restitution depends on the speed: its
    /// restitution at the normal speed `speed` [m/s].
    pub fn represent(&mut self, speed: f64) {
        let walls = self.walls.iter_mut().map(|wall| &mut wall.surface);
        let surfaces = walls.chain([&mut self.contact]).chain(self.pairs.surfaces_mut());
        surfaces.for_each(|surface| surface.represent(speed));
    }

    /// All kinds of impacts in the scene, each listed once. Two kinds differ in restitution, mass ratio (tangential
    /// over normal effective mass) or shear ratio. If sizes differ, the spheres are taken to have the mean volume.
    /// `shear_ratio` returns Mindlin's stiffness over Hertz's elastic constant [-] for the elasticities of two bodies.
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

    /// Contact properties of a particle of the species with the index `species` and another particle or a wall.
    #[inline]
    pub fn meeting(&self, species: u16, other: Kind) -> Meeting {
        match self.pairs.find(species, other) {
            Some(meeting) => *meeting,
            None => Meeting { resistance: self.resistance(species, other), ..(*self.usual(other)).into() },
        }
    }

    /// Coefficients of rolling and twisting friction between a particle of the species with the index `species` and the
    /// body `other`, a particle or a wall.
    #[inline]
    pub fn resistance(&self, species: u16, other: Kind) -> ResistanceFriction {
        match (self.pairs.find(species, other), other) {
            (Some(meeting), _) => meeting.resistance,
            (None, Kind::Wall(wall)) => self.walls[wall as usize].resistance,
            (None, Kind::Species(_)) => ResistanceFriction::default(),
        }
    }

    /// Restitution and friction between a particle of the species with the index `species` and the body `other`, a
    /// particle or a wall.
    #[inline]
    pub fn surface(&self, species: u16, other: Kind) -> &Surface {
        self.pairs.find(species, other).map_or_else(|| self.usual(other), |meeting| &meeting.surface)
    }

    /// Restitution and friction of contacts with `other`, for pairs of bodies that are not in [`Scene::pairs`].
    #[inline]
    fn usual(&self, other: Kind) -> &Surface {
        match other {
            Kind::Species(_) => &self.contact,
            Kind::Wall(wall) => &self.walls[wall as usize].surface,
        }
    }

    /// All pairs of species, also each species with itself, and their contact properties. The smaller index is first.
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

    /// All species, each with a stiffness ratio [-]: stiffness of contacts between two of its particles over that of
    /// the contact law.
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

    /// Two copies of the scene: all particles have their smallest diameter in one copy, and their largest in the other.
    /// If every species has one size, the result is one copy.
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

    /// True if the particles of any species differ in diameter.
    pub fn has_sizes(&self) -> bool {
        self.species.iter().any(|species| species.sizes.is_some())
    }

    /// [m/s] speed below which particles under gravity g count as at rest. It is a hundredth of sqrt(g d) with the
    /// smallest diameter d, so that they rise by less than d/20,000; 0 without gravity.
    pub fn rest_speed(&self) -> f64 {
        if self.species.is_empty() { 0.0 } else { 0.01 * (self.gravity.norm() * self.smallest_diameter()).sqrt() }
    }

    /// [-] restitution between particles; `None` unless it is the same for all pairs of species, at all speeds.
    pub fn restitution_of_pairs(&self) -> Option<f64> {
        if self.pairs.is_empty() {
            return constant([self.contact]);
        }
        constant(self.meetings().map(|(_, _, meeting)| meeting.surface))
    }

    /// [-] restitution at walls. `None` if there are no walls, or if the restitution differs between species or walls
    /// or depends on the speed.
    pub fn restitution_at_walls(&self) -> Option<f64> {
        if self.pairs.is_empty() {
            return constant(self.walls.iter().map(|wall| wall.surface));
        }
        constant(self.meetings_at_walls().map(|(_, _, meeting)| meeting.surface))
    }

    /// Surfaces of all contacts that can occur: at the walls and, if the number `particles` is above 1, between
    /// particles. Pairs with contact properties of their own are included.
    pub fn surfaces(&self, particles: usize) -> Vec<Surface> {
        let is_paired = particles > 1;
        if self.pairs.is_empty() {
            return self.walls.iter().map(|wall| wall.surface).chain(is_paired.then_some(self.contact)).collect();
        }
        let walls = self.meetings_at_walls().map(|(_, _, meeting)| meeting.surface);
        let pairs = self.meetings().map(|(_, _, meeting)| meeting.surface).filter(|_| is_paired);
        walls.chain(pairs).collect()
    }
}

/// Common constant restitution [-] of all surfaces. `None` if the restitutions differ, if one of them depends on speed,
/// or without surfaces.
fn constant(surfaces: impl IntoIterator<Item = Surface>) -> Option<f64> {
    let own = |surface: Surface| surface.by_speed.is_none().then_some(surface.restitution);
    let mut all = surfaces.into_iter().map(own);
    let first = all.next()??;
    all.all(|restitution| restitution == Some(first)).then_some(first)
}
