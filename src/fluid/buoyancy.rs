//! Buoyancy: the pressure of the gas around a sphere, which carries a part of its weight.

use nalgebra::Vector3;
use serde::Serialize;

/// Buoyancy of the particles in a scene with gravity g: the force -ρ_f V g on a sphere of volume V (Archimedes).
///
/// It is the force ρ_f V (DU/Dt - g) by which the stresses of the undisturbed gas act on a sphere (Maxey and Riley 1983,
/// Phys. Fluids 26, 883). The acceleration DU/Dt of the gas is zero, because each profile is steady, along z, and
/// constant along z. [`Scene::add_buoyancy`](crate::Scene::add_buoyancy) makes this value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Buoyancy {
    /// [m/s²] acceleration by gravity alone, g.
    pub gravity: Vector3<f64>,
    /// [m/s²] acceleration of each species by weight and buoyancy, minus that of the densest species. The list is empty
    /// if all species have equal densities.
    pub differences: Vec<Vector3<f64>>,
}
