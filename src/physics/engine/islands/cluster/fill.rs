//! Copying of an island (a group of particles that may meet) into a small scene with its particles, and with the pairs
//! and walls that may touch.

use super::IslandFinder;
use crate::encounter::AtWall;
use crate::engine::islands::island::Island;
use crate::neighbours::NearWall;
use crate::scene::Scene;
use nalgebra::Vector3;

/// Copies the island with the number `which` (group of particles that may meet) into the small scene `island`, but not
/// its contacts in progress. `fallen` [m/s] is the velocity that gravity has added since the last exchange with the
/// gas; the particle store does not contain it.
pub fn fill<'a, C>(
    islands: &impl IslandFinder<'a>,
    which: usize,
    island: &mut Island<C>,
    scene: &Scene,
    fallen: Vector3<f64>,
) {
    let cluster = &islands.list[which];
    let members = || cluster.hot.iter().map(|&member| &islands.members[member as usize]);
    let hot = members().map(|member| (member.index, islands.limit(cluster, member.index)));
    island.begin(islands.particles, hot, &cluster.bystanders, islands.frame, fallen);
    if scene.domain.shear.is_some() {
        island.flow.extend(island.particles.position.iter().map(|position| scene.domain.mean_flow(position)));
    }
    island.crowd = cluster.is_crowd();
    if island.crowd {
        return;
    }
    let Island { particles, indices, list, limits, hot, .. } = island;
    // a particle comes nearer to walls also by gravity and by the motion of the walls
    let falls = (scene.gravity.norm() * islands.part + fallen.norm() + scene.wall_speed()) * islands.part;
    for (a, member) in members().enumerate() {
        islands.list_pairs((a, member), (indices, *hot), &mut list.pairs);
        let reach = particles.radius[a] + limits[a] * islands.part + falls;
        let (particle, first) = (a as u32, list.walls.len());
        islands.search.near_walls.for_each(&particles.position[a], reach, |wall| {
            let shape = &scene.walls[wall as usize].geometry;
            if shape.is_within(&particles.position[a], reach) {
                let contacts = 0..shape.contacts();
                list.walls.extend(contacts.map(|which| NearWall { particle, at: AtWall { wall, which } }));
            }
        });
        if !islands.search.near_walls.are_few() {
            // if there are many walls, the search may find one twice, in any order; they are sorted in the order of
            // the case, and each is kept once
            list.walls[first..].sort_unstable_by_key(|near| (near.at.wall, near.at.which));
            list.walls.dedup();
        }
    }
}
