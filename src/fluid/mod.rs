//! What gas do the particles fly through?
//!
//! The gas is frozen: a mean streamwise velocity (along z) that depends on the wall-normal distance y only (the paper's section 2.1), or in a pipe
//! on the distance from its axis; not altered by the particles.
//!
//! To add a profile: one file that ends in a [`Profile`], and an arm where the case is resolved.

mod half_channel;
mod k_epsilon;
mod launder_sharma;
mod log_law;
mod pipe;
mod profile;
mod table;
mod wall_functions;

pub use k_epsilon::{ChannelFlow, GridNode, KBudget, Section, TurbulenceModel};
pub use log_law::{LogConstants, LogLaw};
pub use pipe::Pipe;
pub use profile::{Channel, Profile, WallScale};
pub use table::VelocityTable;

use crate::drag::{Drag, Sphere};
use crate::scene::Species;
use serde::Serialize;

/// A frozen gas: its properties, its velocity profile, and how it drags a sphere.
#[derive(Clone, Debug, Serialize)]
pub struct Fluid {
    /// [kg/m³] density ρ_f.
    pub density: f64,
    /// [m²/s] kinematic viscosity ν.
    pub kinematic_viscosity: f64,
    /// Streamwise gas velocity against y, or against the distance from the axis of a pipe.
    pub profile: Profile,
    /// Drag law; `None`: the gas is there but exerts no force.
    pub drag: Option<Drag>,
}

impl Fluid {
    /// What drag needs to know of a sphere of this kind in this gas.
    pub fn sphere(&self, species: &Species) -> Sphere {
        Sphere {
            stokes_time: species.density * species.diameter.powi(2) / (18.0 * self.density * self.kinematic_viscosity),
            reynolds_per_speed: species.diameter / self.kinematic_viscosity,
        }
    }
}
