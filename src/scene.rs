//! The scene: everything both engines read and neither changes.

use crate::domain::Domain;
use crate::fluid::Fluid;
use crate::walls::Wall;
use nalgebra::Vector3;
use serde::Serialize;

/// How two surfaces answer an impact: one source for both engines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Surface {
    /// [-] normal restitution e, 0 ..= 1: ratio of normal speeds after and before an isolated impact.
    pub restitution: f64,
    /// [-] Coulomb friction μ, >= 0.
    pub friction: f64,
}

/// How a solid answers pressure; only contact laws that derive their stiffness from materials read it.
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
    /// [m] diameter d.
    pub diameter: f64,
    /// [kg/m³] density ρ_p.
    pub density: f64,
    /// Its own elasticity; `None`: that of the contact law.
    pub elasticity: Option<Elasticity>,
}

impl Species {
    /// [m³] volume of one sphere, π d³/6.
    pub fn volume(&self) -> f64 {
        std::f64::consts::PI / 6.0 * self.diameter.powi(3)
    }

    /// [kg] mass of one sphere.
    pub fn mass(&self) -> f64 {
        self.density * self.volume()
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
///     species: vec![Species { name: "glass".into(), diameter: 1e-3, density: 2500.0, elasticity: None }],
/// };
/// assert!((scene.species[0].mass() - 1.309e-6).abs() < 1e-9); // kg
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct Scene {
    /// Box and periodicity.
    pub domain: Domain,
    /// [m/s²] gravity.
    pub gravity: Vector3<f64>,
    /// The gas with its velocity profile and drag law; `None`: no gas, no drag code runs.
    pub fluid: Option<Fluid>,
    /// Walls, each with its own surface.
    pub walls: Vec<Wall>,
    /// Particle against particle.
    pub contact: Surface,
    /// Kinds of particles; `Particles::species` points here.
    pub species: Vec<Species>,
}
