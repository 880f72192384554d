//! Diptych runs one particle scene with two interchangeable collision models and compares them.
//!
//! ```text
//!  cases/*.toml + models/**          --model, --set key=value
//!             |
//!         CaseFile (as typed)  --->  Experiment (checked, SI) = Scene + start + settings
//!             |
//!         Simulation: for each window h
//!             drag half-kick -> engine.advance(h) -> drag half-kick -> observers
//!                                   |
//!                        soft: time steps   |   hard: event calendar
//!             |
//!         Outcome -> outputs (csv, json, svg, html)  <-  studies: run, compare, plan, impact
//! ```
//!
//! Without the feature `program` (on by default) the crate has no command line, no studies and no output files. Without
//! the feature `case` it cannot read case files. The modules from `clock` to `outcome`, with all physics, need no
//! feature.
//!
//! All quantities are in SI units; x is spanwise, y wall-normal, z streamwise. Modules import only from modules above
//! them in the list below.
//!
//! Names that most programs need are re-exported at the root; `examples/` shows their use.

#![allow(rustdoc::broken_intra_doc_links, reason = "units stand in brackets")]

#[doc(inline)]
pub use diptych_physics::{
    clock, communicator, contact_law, domain, drag, encounter, engine, exact, experiment, fluid, kinetic_theory,
    neighbours, noise, observe, outcome, particles, placement, predict, record, restitution, rotation, scene, schedule,
    simulation, statistics, stored, walls, work_sharing,
};

#[cfg(feature = "case")]
#[doc(inline)]
pub use diptych_input::{case, legible, memory, triangles};

#[cfg(feature = "program")]
pub mod cli;
#[cfg(feature = "program")]
pub mod output;

#[cfg(feature = "program")]
pub mod checkpoint;

#[cfg(feature = "program")]
pub mod runs;

#[cfg(feature = "program")]
pub mod study;

#[cfg(feature = "lab")]
pub mod lab;

#[cfg(feature = "program")]
pub mod program;

// Names that most programs using the library need.
pub use nalgebra::Vector3;

pub use contact_law::{ContactLaw, Hertz, KuwabaraKono, LinearSpringDashpot};
pub use domain::Domain;
pub use drag::{Drag, DragLaw, SchillerNaumann, Stokes};
pub use engine::dsmc::Dsmc;
pub use engine::hard::{Hard, SteppedHard};
pub use engine::hybrid::Hybrid;
pub use engine::soft::Soft;
pub use engine::{Counters, Engine, Failure, Window};
pub use experiment::{Experiment, Model, Population, Spheres};
pub use fluid::{Fluid, Profile};
pub use outcome::Outcome;
pub use particles::Particles;
pub use placement::{initial_state, random_start};
pub use record::{Histogram, Impact, Impacts, Ledger, Record};
pub use restitution::RestitutionBySpeed;
pub use scene::{Elasticity, Scene, Species, Surface};
pub use simulation::{Simulation, Snapshot};
pub use stored::{StoreError, Stored};
pub use walls::{Geometry, Hollow, Mesh, Obstacle, Plane, Wall, WallGeometry};
