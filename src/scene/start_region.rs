//! The part of a scene that a random start fills.

use crate::walls::Hollow;
use serde::Serialize;

/// A part of the domain in which a random start puts the particles.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StartRegion {
    /// The particles are wholly inside a body.
    Body(Hollow),
    /// The centres of the particles are inside one of these walls of the scene, by index.
    InsideWalls(Vec<u32>),
}
