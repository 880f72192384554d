//! Weight, buoyancy and added mass of the particles in the gas around them.

use super::{Scene, Species};
use crate::fluid::Buoyancy;
use nalgebra::Vector3;

/// Coefficient of the added mass of a sphere: the sphere accelerates gas of half its own volume (Maxey and Riley 1983).
pub const ADDED_MASS: f64 = 0.5;

impl Species {
    /// [kg] mass of one sphere without added mass; the mean mass if sizes differ.
    pub fn own_mass(&self) -> f64 {
        self.density * self.volume()
    }

    /// [-] fraction by which buoyancy and added mass reduce the acceleration of this species by gravity, in a gas with
    /// the density `gas` [kg/m³].
    fn carried_by(&self, gas: f64) -> f64 {
        (gas + self.added_density) / self.inertial_density()
    }
}

impl Scene {
    /// Gives all species the added mass of spheres in the gas of the scene. A scene without gas does not change.
    ///
    /// A sphere of mass m and volume V in a gas of density ρ_f then has the inertia of the mass m + ρ_f V/2. Masses,
    /// momenta and energies of the simulation include the gas that moves with the spheres. Call this method before
    /// [`add_buoyancy`](Self::add_buoyancy) and before particles are made.
    pub fn add_added_mass(&mut self) {
        let Some(fluid) = &self.fluid else { return };
        self.species.iter_mut().for_each(|species| species.added_density = ADDED_MASS * fluid.density);
    }

    /// Adds the buoyancy of the particles to a scene with gas and gravity; other scenes do not change. The
    /// acceleration of a species becomes g (1 - ρ_f/ρ_p), with the densities ρ_f of the gas and ρ_p of the particles.
    /// With the added mass ρ_a [kg/m³] it becomes g (ρ_p - ρ_f)/(ρ_p + ρ_a). A second call of this method changes
    /// nothing.
    ///
    /// Engines use one acceleration for all particles: [`gravity`](Self::gravity), which becomes that of the densest
    /// species. The simulation adds the accelerations of the other species, minus this one, in half-kicks (changes of
    /// the velocities for half a window, the time between two exchanges with the gas) before and after each window.
    /// The free flight of such a species is exact, and the error in its contacts is of second order in the window.
    pub fn add_buoyancy(&mut self) {
        let gravity = self.gravity;
        let Some(fluid) = self.fluid.as_mut().filter(|fluid| fluid.buoyancy.is_none()) else { return };
        let densest = self.species.iter().max_by(|one, other| one.density.total_cmp(&other.density));
        let Some(densest) = densest else { return };
        if gravity == Vector3::zeros() {
            return;
        }
        let density = fluid.density;
        let carried = |species: &Species| species.carried_by(density);
        let alike = self.species.iter().all(|species| species.density == densest.density);
        let species = if alike { &[] } else { self.species.as_slice() };
        let differences = species.iter().map(|species| gravity * (carried(densest) - carried(species))).collect();
        self.gravity = gravity * (1.0 - carried(densest));
        fluid.buoyancy = Some(Buoyancy { gravity, differences });
    }

    /// [m/s²] acceleration by gravity alone, without buoyancy.
    pub fn gravity_alone(&self) -> Vector3<f64> {
        let buoyancy = self.fluid.as_ref().and_then(|fluid| fluid.buoyancy.as_ref());
        buoyancy.map_or(self.gravity, |buoyancy| buoyancy.gravity)
    }

    /// [m/s²] acceleration of each species by weight and buoyancy, minus [`gravity`](Self::gravity). The list is empty
    /// if this difference is zero for all species.
    pub fn differences_in_gravity(&self) -> &[Vector3<f64>] {
        let buoyancy = self.fluid.as_ref().and_then(|fluid| fluid.buoyancy.as_ref());
        buoyancy.map_or(&[], |buoyancy| &buoyancy.differences)
    }

    /// True if forces outside the engine change the velocities of particles between two windows (times between two
    /// exchanges with the gas). These forces are drag, lift, a thermostat, the forces of an orbit, and the buoyancy of
    /// species of different densities.
    pub fn is_kicked(&self) -> bool {
        let dragged = self.fluid.as_ref().is_some_and(|fluid| fluid.drag.is_some() || fluid.lift.is_some());
        let driven = self.thermostat.is_some() || self.domain.orbit().is_some();
        dragged || driven || !self.differences_in_gravity().is_empty()
    }

    /// [m/s²] acceleration of the particles of a species by weight and buoyancy.
    pub fn gravity_of(&self, species: &Species) -> Vector3<f64> {
        match self.fluid.as_ref().filter(|fluid| fluid.buoyancy.is_some()) {
            Some(fluid) => self.gravity_alone() * (1.0 - species.carried_by(fluid.density)),
            None => self.gravity,
        }
    }
}
