//! Messages to other processes about islands near the border of a domain.

use crate::engine::islands::{BoundingSphere, Clusters, Member, ParticleTrajectory, VelocityChange};
use nalgebra::Vector3;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use std::hash::Hasher;

/// Message of a process to others about one of its hot particles.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct HotParticleDigest {
    /// Id of the particle.
    pub id: u32,
    /// Checksum of the island of the particle.
    mark: u64,
    /// The ball that holds the particle.
    ball: BoundingSphere,
    /// Velocity changes of the particle, if they are known.
    turns: Option<Vec<VelocityChange>>,
}

impl Clusters<'_> {
    /// Calls `tell` with the result for each chosen particle and the middle of its flight, if that is `near` another
    /// process.
    pub fn tell(
        &self,
        chosen: impl Fn(u32) -> bool,
        near: impl Fn(&Vector3<f64>) -> bool,
        mut tell: impl FnMut(HotParticleDigest, &Vector3<f64>),
    ) {
        for (which, cluster) in self.clusters.iter().enumerate().filter(|(_, cluster)| cluster.alive) {
            let members = cluster.hot.iter().map(|&member| &self.members[member as usize]);
            let mut mark = None;
            for member in members.filter(|member| chosen(member.place) && near(&member.flight.middle)) {
                let (id, mark) =
                    (self.particles.id[member.place as usize], *mark.get_or_insert_with(|| self.mark(which)));
                let turns = self.course(member).turns.map(<[VelocityChange]>::to_vec);
                tell(HotParticleDigest { id, mark, ball: member.ball, turns }, &member.flight.middle);
            }
        }
    }

    /// True if the messages of other processes, by particle index, agree with the results here for the islands of the
    /// chosen particles. The islands must have equal members, and no other particle of those messages may meet them.
    pub fn agree_with(&self, chosen: impl Fn(u32) -> bool, told: Vec<(u32, HotParticleDigest)>) -> bool {
        let own: Vec<bool> = (0..self.clusters.len()).map(|which| self.has(which, &chosen)).collect();
        let marks: FxHashMap<u32, u64> = told.iter().map(|(place, told)| (*place, told.mark)).collect();
        let widest = told.iter().map(|(_, told)| told.ball.reach).fold(self.widest, f64::max);
        let mut known = self.members.iter().filter(|member| own[member.cluster as usize] && !chosen(member.place));
        let alike = known.all(|member| marks.get(&member.place) == Some(&self.mark(member.cluster as usize)));
        // late members are in no cells; most are too deep inside to meet a particle of another process
        let depth = |middle: &Vector3<f64>| self.search.region.depth(middle, self.domain);
        let deeper = |deepest: f64, (place, told): &(u32, HotParticleDigest)| {
            deepest.max(depth(&told.ball.middle)).max(depth(&self.search.flights[*place as usize].middle))
        };
        let deep = told.iter().fold(f64::NEG_INFINITY, deeper) + 2.0 * widest.max(self.search.levels.largest_reach());
        let late = if self.traces { &[] } else { &self.members[self.sorted.len()..] };
        let late = late.iter().filter(|member| own[member.cluster as usize]);
        let late: Vec<&Member> =
            late.filter(|one| depth(&one.flight.middle).min(depth(&one.ball.middle)) <= deep).collect();
        let meets = |place: u32, told: &HotParticleDigest| {
            let flight = self.search.flights[place as usize];
            let other = ParticleTrajectory { place, turns: told.turns.as_deref() };
            let meets = |member: &Member| {
                own[member.cluster as usize]
                    && self.may_touch(&self.course(member), &other)
                    && (told.ball.meets(&member.flight, self.domain)
                        || told.ball.meets(&member.ball, self.domain)
                        || flight.meets(&member.ball, self.domain))
            };
            if self.traces {
                let mut met = false;
                for spot in [told.ball, flight] {
                    self.for_each_turned_beside(&spot, |member| met |= meets(member));
                }
                self.search.for_each_beside(&told.ball, self.domain, |place| {
                    let label = self.search.label[place as usize];
                    met |= label.is_some_and(|label| meets(&self.members[label.member()]));
                });
                return met;
            }
            let mut met = late.iter().copied().any(meets);
            for spot in [told.ball, flight] {
                self.grid.for_each_near(&spot.middle, spot.reach + widest, |range, _| {
                    met |= self.sorted[range].iter().any(|&member| meets(&self.members[member as usize]));
                });
            }
            met
        };
        let is_known = |place: u32| {
            self.search.label[place as usize].is_some_and(|label| own[self.members[label.member()].cluster as usize])
        };
        alike && told.iter().all(|(place, told)| is_known(*place) || !meets(*place, told))
    }

    /// Checksum of all data that the result of an island depends on, except the state of its particles.
    fn mark(&self, which: usize) -> u64 {
        let cluster = &self.clusters[which];
        let id = |place: u32| u64::from(self.particles.id[place as usize]);
        let hot = cluster.hot.iter().map(|&member| id(self.members[member as usize].place));
        let ([one, other], [fast, next]) = (cluster.energies, cluster.speeds);
        let bounds = [cluster.floor, cluster.first, cluster.stored, one, other, fast, next];
        let all = hot.chain([u64::MAX]).chain(cluster.bystanders.iter().map(|&place| id(place)));
        let mut mark = std::hash::DefaultHasher::new();
        all.chain(bounds.map(f64::to_bits)).chain([u64::from(cluster.lasts)]).for_each(|part| mark.write_u64(part));
        mark.finish()
    }
}
