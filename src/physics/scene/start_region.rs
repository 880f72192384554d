//! The part of a scene that a random start fills.

use crate::walls::Hollow;
use serde::Serialize;

/// A part of the domain in which a random start puts the particles.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StartRegion {
    /// The interior of a hollow body, which contains each particle wholly.
    Body(Hollow),
    /// The interior of the walls with these indices in the scene. The centre of each particle is inside one of these
    /// walls.
    InsideWalls(Vec<u32>),
}
