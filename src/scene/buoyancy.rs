//! Weight of the particles in the gas around them.

use super::{Scene, Species};
use crate::fluid::Buoyancy;
use nalgebra::Vector3;

impl Scene {
    /// Adds the buoyancy of the particles to a scene with gas and gravity; other scenes do not change. The acceleration
    /// of a species of density ρ_p becomes g (1 - ρ_f/ρ_p), where ρ_f is the density of the gas. A second call changes
    /// nothing.
    ///
    /// Engines move all particles in one falling frame. So [`gravity`](Self::gravity) becomes the acceleration of the
    /// densest species, and the simulation adds the differences of the others in half-kicks before and after each
    /// window. A species whose particles fly freely then moves exactly, and contacts are of second order in the window.
    pub fn add_buoyancy(&mut self) {
        let gravity = self.gravity;
        let Some(fluid) = self.fluid.as_mut().filter(|fluid| fluid.buoyancy.is_none()) else { return };
        let Some(densest) = self.species.iter().map(|species| species.density).reduce(f64::max) else { return };
        if gravity == Vector3::zeros() {
            return;
        }
        let carried = |density: f64| fluid.density / density;
        let difference = |density: f64| gravity * (carried(densest) - carried(density));
        let alike = self.species.iter().all(|species| species.density == densest);
        let species = if alike { &[] } else { self.species.as_slice() };
        let differences = species.iter().map(|species| difference(species.density)).collect();
        self.gravity = gravity * (1.0 - carried(densest));
        fluid.buoyancy = Some(Buoyancy { gravity, differences });
    }

    /// [m/s²] acceleration by gravity alone, without buoyancy.
    pub fn gravity_alone(&self) -> Vector3<f64> {
        let buoyancy = self.fluid.as_ref().and_then(|fluid| fluid.buoyancy.as_ref());
        buoyancy.map_or(self.gravity, |buoyancy| buoyancy.gravity)
    }

    /// [m/s²] acceleration of each species by weight and buoyancy, minus [`gravity`](Self::gravity). The list is empty
    /// if all species have the acceleration `gravity`.
    pub fn differences_in_gravity(&self) -> &[Vector3<f64>] {
        let buoyancy = self.fluid.as_ref().and_then(|fluid| fluid.buoyancy.as_ref());
        buoyancy.map_or(&[], |buoyancy| &buoyancy.differences)
    }

    /// True if kicks change the velocities of particles between two windows: those of drag, or of buoyancy of species of
    /// different densities.
    pub fn is_kicked(&self) -> bool {
        let dragged = self.fluid.as_ref().is_some_and(|fluid| fluid.drag.is_some());
        dragged || !self.differences_in_gravity().is_empty()
    }

    /// [m/s²] acceleration of the particles of a species by weight and buoyancy.
    pub fn gravity_of(&self, species: &Species) -> Vector3<f64> {
        match self.fluid.as_ref().filter(|fluid| fluid.buoyancy.is_some()) {
            Some(fluid) => self.gravity_alone() * (1.0 - fluid.density / species.density),
            None => self.gravity,
        }
    }
}
