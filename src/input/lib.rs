//! Reads case files (TOML with units) and files of triangles for Diptych.
//!
//! The crate `diptych` re-exports everything here, and programs use that crate. This file lists the modules. Each
//! imports only from modules earlier in the list, and from the crate `diptych_physics`.

#![allow(rustdoc::broken_intra_doc_links, reason = "units stand in brackets")]

pub mod legible;
pub mod memory;
pub mod triangles;

pub mod case;

use diptych_physics::{
    contact_law, domain, drag, engine, experiment, fluid, particles, placement, predict, restitution, rotation, scene,
    schedule, simulation, statistics, walls,
};
