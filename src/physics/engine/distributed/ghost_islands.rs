//! Messages by which processes compare their results for islands near the border of a block. An island is a group of
//! particles that may meet, and a block is the region of the box whose particles a process owns.

use crate::engine::islands::{BoundingSphere, Clusters, IslandFinder, Member, VelocityChange};
use nalgebra::Vector3;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use std::hash::Hasher;

/// Summary of the result of one process for one member of an island (group of particles that may meet). The process
/// sends it to other processes for comparison.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct HotParticleDigest {
    /// Id of the hot particle (member of an island).
    pub id: u32,
    /// Checksum of the ids of the members of the particle's island, and of the bounds on their motion.
    mark: u64,
    /// Ball that contains the particle after the first touch in its island, until the end of the part (piece of the
    /// time between two exchanges with the gas).
    ball: BoundingSphere,
    /// Velocity changes of the particle in the part (interval of time), in the order of time; `None` if the engine does
    /// not report them.
    turns: Option<Vec<VelocityChange>>,
}

/// Calls `tell` with the result for each chosen member of an island (group of particles that may meet), and with the
/// middle [m] of the member's flight. A member is chosen if `chosen` returns true for its index in the store, and
/// `near` returns true for the middle of its flight.
pub fn tell<'a>(
    islands: &impl IslandFinder<'a>,
    chosen: impl Fn(u32) -> bool,
    near: impl Fn(&Vector3<f64>) -> bool,
    mut tell: impl FnMut(HotParticleDigest, &Vector3<f64>),
) {
    for (which, cluster) in islands.list.iter().enumerate().filter(|(_, cluster)| cluster.alive) {
        let members = cluster.hot.iter().map(|&member| &islands.members[member as usize]);
        let mut known = None;
        for member in members.filter(|member| chosen(member.index) && near(&member.flight.middle)) {
            let id = islands.particles.id[member.index as usize];
            let mark = *known.get_or_insert_with(|| mark(islands, which));
            let turns = islands.velocity_changes(member).map(<[VelocityChange]>::to_vec);
            tell(HotParticleDigest { id, mark, ball: member.ball, turns }, &member.flight.middle);
        }
    }
}

/// True if other processes have the same results for the islands (groups of particles that may meet) of this process,
/// which contain a particle for whose index `chosen` returns true. The checksums of these islands must be equal, and no
/// particle in the messages may meet one of these islands without being a member. `told` contains the messages, each
/// with the index of its particle in this process.
pub fn agree_with<'a>(
    islands: &impl IslandFinder<'a>,
    chosen: impl Fn(u32) -> bool,
    told: &[(u32, HotParticleDigest)],
) -> bool {
    let own: Vec<bool> = (0..islands.list.len()).map(|which| islands.has(which, &chosen)).collect();
    let marks: FxHashMap<u32, u64> = told.iter().map(|(index, told)| (*index, told.mark)).collect();
    let mut known = islands.members.iter().filter(|member| own[member.cluster as usize] && !chosen(member.index));
    let alike = known.all(|member| marks.get(&member.index) == Some(&mark(islands, member.cluster as usize)));
    let widest = told.iter().map(|(_, told)| told.ball.reach).fold(islands.widest, f64::max);
    let late = late_near(islands, &own, told, widest);
    let domain = islands.domain;
    let meets = |index: u32, told: &HotParticleDigest| {
        let flight = islands.search.flights[index as usize];
        let meets = |member: &Member| {
            own[member.cluster as usize]
                && islands.may_meet(member, index, told.turns.as_deref())
                && (told.ball.meets(&member.flight, domain)
                    || told.ball.meets(&member.ball, domain)
                    || flight.meets(&member.ball, domain))
        };
        let mut met = late.iter().copied().any(meets);
        for ball in [told.ball, flight] {
            islands.for_each_beside(&ball, widest, &mut |member| met |= meets(member));
        }
        met
    };
    let is_known = |index: u32| {
        let label = islands.search.label[index as usize];
        label.is_some_and(|label| own[islands.members[label.member()].cluster as usize])
    };
    alike && told.iter().all(|(index, told)| is_known(*index) || !meets(*index, told))
}

/// Members of islands (groups of particles that may meet) that may meet a particle in the messages `told`, but are not
/// in the cells of the search, because they were added later. Only islands with a particle of this process are
/// searched; `own` is true for these islands. Members too deep inside the region that this process stores to meet such
/// a particle are left out. No member, and no ball in the messages, reaches farther than `widest` [m] from its middle.
fn late_near<'i, 'a: 'i>(
    islands: &'i impl IslandFinder<'a>,
    own: &[bool],
    told: &[(u32, HotParticleDigest)],
    widest: f64,
) -> Vec<&'i Member> {
    let depth = |middle: &Vector3<f64>| islands.search.region.depth(middle, islands.domain);
    let deeper = |deepest: f64, (index, told): &(u32, HotParticleDigest)| {
        deepest.max(depth(&told.ball.middle)).max(depth(&islands.search.flights[*index as usize].middle))
    };
    let deep = told.iter().fold(f64::NEG_INFINITY, deeper) + 2.0 * widest.max(islands.search.levels.largest_reach());
    let is_near = |one: &&Member| depth(&one.flight.middle).min(depth(&one.ball.middle)) <= deep;
    islands.late().iter().filter(|member| own[member.cluster as usize]).filter(is_near).collect()
}

/// Checksum of the ids of the particles in an island (group of particles that may meet) and of the bounds on their
/// motion. Two processes with equal checksums solve the same island.
fn mark(islands: &Clusters, which: usize) -> u64 {
    let cluster = &islands.list[which];
    let id = |index: u32| u64::from(islands.particles.id[index as usize]);
    let hot = cluster.hot.iter().map(|&member| id(islands.members[member as usize].index));
    let ([one, other], [fast, next]) = (cluster.energies, cluster.speeds);
    let bounds = [cluster.floor, cluster.first, cluster.stored, one, other, fast, next];
    let all = hot.chain([u64::MAX]).chain(cluster.bystanders.iter().map(|&index| id(index)));
    let mut mark = std::hash::DefaultHasher::new();
    all.chain(bounds.map(f64::to_bits)).chain([u64::from(cluster.lasts)]).for_each(|part| mark.write_u64(part));
    mark.finish()
}
