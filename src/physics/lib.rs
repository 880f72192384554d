//! The physics of Diptych: scenes, engines, their simulation, statistics and predictions. There are engines for soft,
//! hard and hybrid spheres, and for collisions by chance (DSMC).
//!
//! The crate `diptych` re-exports everything here, and programs use that crate. All quantities are in SI units; x is
//! spanwise, y wall-normal, z streamwise. Modules import only from modules above them in the list below.

#![allow(rustdoc::broken_intra_doc_links, reason = "units stand in brackets")]

pub mod clock;
pub mod noise;
pub mod stored;
pub mod work_sharing;

pub mod domain;
pub mod exact;

pub mod communicator;
pub mod kinetic_theory;
pub mod rotation;

pub mod particles;
pub mod restitution;

pub mod scene;

pub mod contact_law;

pub mod experiment;

pub mod drag;
pub mod fluid;
pub mod walls;

pub mod encounter;
pub mod neighbours;
pub mod placement;
pub mod record;

pub mod engine;
pub mod predict;

pub mod schedule;
pub mod simulation;
pub mod statistics;

pub mod observe;

pub mod outcome;

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
