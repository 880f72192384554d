//! Diptych runs one particle scene with interchangeable collision models (soft spheres with springs, hard spheres with
//! instantaneous collisions, hybrids of both, and randomly drawn collisions) and compares the results.
//!
//! ```text
//!  cases/*.toml + models/**          --model, --set key=value
//!             |
//!         CaseFile (as typed)  --->  Experiment (checked, SI) = Scene + start + settings
//!             |
//!         Simulation: for each window h
//!             drag half-kick -> engine.advance(h) -> drag half-kick -> observers
//!                                   |
//!                        soft: time steps   |   hard: event queue
//!             |
//!         Outcome -> outputs (csv, json, svg, html)  <-  studies: run, compare, plan, impact
//! ```
//!
//! A window h is the time between two exchanges of momentum with the gas. A half-kick changes the velocities as the
//! drag of the gas does during h/2. Observers are the measurements during a run.
//!
//! Without the feature `program` (on by default) the crate has no command line, no studies and no output files. Without
//! the feature `case` it cannot read case files. The crate `diptych_physics` contains all physics (the modules from
//! `clock` to `outcome`) and needs no feature.
//!
//! All quantities are in SI units; x is spanwise, y wall-normal, z streamwise. In the list of modules in this file,
//! each module imports only from the modules above it.
//!
//! The crate re-exports all modules of the physics and of the reader of cases. The root of the crate also has the names
//! of the types that a typical program uses. The programs in `examples/` use these names.

#![allow(rustdoc::broken_intra_doc_links, reason = "units stand in brackets")]

#[doc(inline)]
pub use diptych_physics::*;

#[cfg(feature = "case")]
#[doc(inline)]
pub use diptych_input::*;

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
