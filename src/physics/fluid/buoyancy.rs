//! Buoyancy: force by the pressure of the gas on a sphere, opposite to gravity.

use nalgebra::Vector3;
use serde::Serialize;

/// Buoyancy in a scene with gravity g: the force -ρ_f V g on a sphere of volume V in a gas of density ρ_f
/// (Archimedes).
///
/// The stresses of the undisturbed gas act on a sphere with the force ρ_f V (DU/Dt - g) (Maxey and Riley 1983, Phys.
/// Fluids 26, 883). The acceleration DU/Dt of the gas, with the velocity U, is left out. In a gas that particles do
/// not change, the acceleration of the mean flow is zero, because the profile is steady, directed along z and constant
/// along z. [`Scene::add_buoyancy`](crate::Scene::add_buoyancy) creates this buoyancy for a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Buoyancy {
    /// [m/s²] acceleration g by gravity alone.
    pub gravity: Vector3<f64>,
    /// [m/s²] acceleration of each species by weight and buoyancy, minus that of the densest species. The list is empty
    /// if all species have one density.
    pub differences: Vec<Vector3<f64>>,
}
