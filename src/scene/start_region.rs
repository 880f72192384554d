//! The part of a scene that a random start fills.

use crate::walls::Hollow;
use serde::Serialize;

/// A part of the domain that the particles of a random start are in.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StartRegion {
    /// Wholly inside a body.
    Body(Hollow),
    /// Their centres inside one of these walls of the scene, by index.
    InsideWalls(Vec<u32>),
}
