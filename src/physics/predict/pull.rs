//! Gravity that pulls particles along walls without end, so that it keeps them moving.

use crate::rotation::Rotation;
use crate::scene::{Kind, Scene, Species};
use crate::walls::{Plane, Wall};
use nalgebra::Vector3;

/// [-] components of gravity below this fraction of its magnitude count as rounding.
const ROUNDING: f64 = 1e-9;

/// True if gravity keeps the particles of some species moving for ever: gravity pulls them along walls, and these
/// walls resist the motion.
///
/// Only the components of gravity along periodic axes count, or along all axes if the scene has outlets. On a floor,
/// the pull must be larger than the force that friction can hold: μ times the pressure for spheres that slide, and
/// rolling friction for spheres that roll. Without a floor, as in a vertical channel, friction or the shape of a wall
/// holds the particles back. Whether a layer of many particles holds itself on a shallow slope is not considered.
pub(super) fn is_pulled(scene: &Scene) -> bool {
    (0u16..).zip(&scene.species).any(|(index, species)| pulls(scene, index, species))
}

/// True if gravity keeps the particles of one species moving. The species is given by its index and its properties.
fn pulls(scene: &Scene, index: u16, species: &Species) -> bool {
    let weight = scene.gravity_of(species);
    let is_free = |axis: usize| scene.domain.periodic[axis] || !scene.outlets.is_empty();
    let free = Vector3::from_fn(|axis, _| if is_free(axis) { weight[axis] } else { 0.0 });
    let least = ROUNDING * weight.norm();
    let pressed = |plane: &Plane| -weight.dot(&plane.normal);
    let planes = (0u32..).zip(&scene.walls).filter_map(|(wall, shape)| Some((wall, shape.geometry.plane()?)));
    let floors = planes.filter(|(_, plane)| pressed(plane) > least);
    match floors.max_by(|a, b| pressed(a.1).total_cmp(&pressed(b.1))) {
        Some((floor, plane)) => {
            let along = (free - plane.normal * free.dot(&plane.normal)).norm();
            along > least && along > hold(scene, index, floor) * pressed(plane)
        }
        None => free.norm() > least && (0u32..).zip(&scene.walls).any(|(k, wall)| resists(scene, index, (k, wall))),
    }
}

/// [-] largest force along a floor that holds a sphere at rest, over the force with which it presses on the floor. The
/// species and the wall are given by their indices.
fn hold(scene: &Scene, species: u16, floor: u32) -> f64 {
    let meeting = scene.meeting(species, Kind::Wall(floor));
    let of_law = |rotation: &Rotation| rotation.rolling.and_then(|law| law.friction());
    let rolling = scene.rotation.as_ref().map(|rotation| {
        // a wall or a pair can have its own coefficient of rolling friction in place of that of the law
        of_law(rotation).map_or(0.0, |friction| meeting.resistance.rolling.unwrap_or(friction))
    });
    rolling.map_or(meeting.surface.friction, |rolling| rolling.min(meeting.surface.friction))
}

/// True if a wall can hold back particles that move past it: by friction, roughness or its shape.
fn resists(scene: &Scene, species: u16, (index, wall): (u32, &Wall)) -> bool {
    let friction = scene.surface(species, Kind::Wall(index)).friction;
    friction > 0.0 || wall.roughness.is_some() || !wall.geometry.is_flat()
}
