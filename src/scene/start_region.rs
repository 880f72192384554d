//! The part of a scene that a random start fills.

use crate::walls::Hollow;
use serde::Serialize;

/// A part of the domain in which a random start puts the particles.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StartRegion {
    /// The particles are wholly inside a body.
    Body(Hollow),
    /// The centre of each particle is inside one of the walls with these indices in the scene.
    InsideWalls(Vec<u32>),
}
