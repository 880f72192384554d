//! What can be said before anything is run?
//!
//! Closed forms and quadratures of a scene's numbers: no running, no output. Each prediction names its source and what it
//! leaves out.

pub mod energy;
pub mod integrator;
