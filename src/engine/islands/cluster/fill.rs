//! An island handed to an engine: its particles, and the pairs that may touch.

use super::Clusters;
use crate::encounter::AtWall;
use crate::engine::islands::island::Island;
use crate::engine::islands::search::BoundingSphere;
use crate::neighbours::{NearWall, Pair};
use crate::scene::Scene;
use nalgebra::Vector3;

impl Clusters<'_> {
    /// Fills the small scene of an island, except for the carried state. `fallen` [m/s] is the velocity that gravity
    /// has added to those of the store.
    pub fn fill<C>(&self, island: &mut Island<C>, which: usize, scene: &Scene, fallen: Vector3<f64>) {
        let cluster = &self.clusters[which];
        let members = || cluster.hot.iter().map(|&member| &self.members[member as usize]);
        let hot = members().map(|member| (member.place, self.limit(cluster, member.place)));
        island.begin(self.particles, hot, &cluster.bystanders, self.frame, fallen);
        island.crowd = cluster.is_crowd();
        if island.crowd {
            return;
        }
        let Island { particles, places, list, limits, hot, .. } = island;
        let falls = (scene.gravity.norm() * self.part + fallen.norm()) * self.part;
        for (a, member) in members().enumerate() {
            let pair = |b: usize| Pair { i: a as u32, j: b as u32 };
            if self.traces {
                list.pairs.extend((a + 1..places.len()).map(pair));
            } else {
                // a touch at the very start of the ball must not be lost by rounding
                let here = BoundingSphere { reach: member.ball.reach * (1.0 + 1e-9), ..member.ball };
                let others =
                    (a + 1..places.len()).filter(|&b| here.meets(&self.ball_of(places[b], b < *hot), self.domain));
                list.pairs.extend(others.map(pair));
            }
            let reach = particles.radius[a] + limits[a] * self.part + falls;
            let (particle, first) = (a as u32, list.walls.len());
            self.search.near_walls.for_each(&particles.position[a], reach, |wall| {
                let shape = &scene.walls[wall as usize].geometry;
                if shape.is_within(&particles.position[a], reach) {
                    let contacts = 0..shape.contacts();
                    list.walls.extend(contacts.map(|which| NearWall { particle, at: AtWall { wall, which } }));
                }
            });
            if !self.search.near_walls.are_few() {
                // in the order of the case, each wall once
                list.walls[first..].sort_unstable_by_key(|near| (near.at.wall, near.at.which));
                list.walls.dedup();
            }
        }
    }

    /// Ball that holds a particle of an island, given by index: of a member from the first touch on, of a bystander
    /// throughout its straight flight.
    fn ball_of(&self, place: u32, is_member: bool) -> BoundingSphere {
        match self.search.label[place as usize] {
            Some(label) if is_member => self.members[label.member()].ball,
            _ => self.search.flights[place as usize],
        }
    }
}
