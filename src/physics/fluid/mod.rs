//! The gas around the particles.
//!
//! Without a [`Coupling`] in the scene the gas is frozen: the particles do not change the flow of the gas. The mean
//! velocity of the gas is streamwise (along z). In a channel the velocity depends only on the wall-normal distance y
//! (section 2.1 of the paper, see `docs/paper.md`), in a pipe on the distance from the axis.
//!
//! To add a profile, write one file with a function that returns a [`Profile`], and add a match arm in the code that
//! converts a case (input file) to a scene.

mod buoyancy;
mod fractions;
mod half_channel;
mod k_epsilon;
mod launder_sharma;
mod lift;
mod loaded_flow;
mod log_law;
mod pipe;
mod profile;
mod table;
mod turbulence;
mod wall_functions;

pub use buoyancy::Buoyancy;
pub use fractions::LocalFractions;
pub use k_epsilon::{ChannelFlow, GridNode, KBudget, Section, TurbulenceModel};
pub use lift::{Lift, LiftedSphere};
pub use loaded_flow::{Coupling, GasBalance, HeldFlow, LoadedFlow, Modulation, SliceSums};
pub use log_law::{LogConstants, LogLaw};
pub use pipe::Pipe;
pub use profile::{Channel, Profile, WallScale};
pub use table::VelocityTable;
pub use turbulence::{EddyLaw, EddySeen, Langevin, LocalTurbulence, Turbulence, TurbulenceStatistics};

use crate::drag::{Drag, Sphere};
use crate::scene::Species;
use serde::Serialize;

/// A gas: its properties, its velocity profile, and its drag law.
#[derive(Clone, Debug, Serialize)]
pub struct Fluid {
    /// [kg/m³] density ρ_f of the gas.
    pub density: f64,
    /// [m²/s] kinematic viscosity ν of the gas.
    pub kinematic_viscosity: f64,
    /// Streamwise gas velocity as a function of y, or of the distance from the axis of a pipe.
    pub profile: Profile,
    /// Drag law; `None` if the gas exerts no drag.
    pub drag: Option<Drag>,
    /// Buoyancy of the particles; `None` if the gas exerts no buoyancy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub buoyancy: Option<Buoyancy>,
    /// Turbulence that particles see; `None` if they see the mean velocity alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turbulence: Option<Turbulence>,
    /// Lift of the particles; `None` if the gas exerts no lift.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lift: Option<Lift>,
    /// Effect of the particles on the gas; `None` if the gas is frozen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupling: Option<Coupling>,
}

impl Fluid {
    /// Makes a frozen gas without buoyancy, turbulence and lift, from its density [kg/m³], kinematic viscosity [m²/s],
    /// velocity profile and drag law. If `drag` is `None`, the gas exerts no drag.
    pub fn new(density: f64, kinematic_viscosity: f64, profile: Profile, drag: Option<Drag>) -> Self {
        Self {
            density,
            kinematic_viscosity,
            profile,
            drag,
            buoyancy: None,
            turbulence: None,
            lift: None,
            coupling: None,
        }
    }

    /// Properties of a single sphere of the species `species` in this gas on which its drag depends.
    pub fn sphere(&self, species: &Species) -> Sphere {
        let inertia = species.inertial_density() * species.diameter.powi(2);
        Sphere {
            stokes_time: inertia / (18.0 * self.density * self.kinematic_viscosity),
            reynolds_per_speed: species.diameter / self.kinematic_viscosity,
            fraction: 0.0,
        }
    }
}
