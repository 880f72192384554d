//! Packing of the particles of a process into bytes that can be stored, and distribution of stored parts to any number
//! of processes.

use super::{Domains, ids_of, pack, take_aboard};
use crate::domain::Domain;
use crate::engine::driver::{CrossRankContact, Work};
use crate::engine::islands::Solve;
use crate::particles::Particles;
use rustc_hash::FxHashMap;

/// Packs the particles of this process and their carried state, in which ids stand for the particles.
pub fn packed_part<S: Solve>(
    particles: &Particles,
    home: &[S::Carried],
    abroad: &[CrossRankContact<S::Carried>],
) -> Vec<u8> {
    let mut lasting = ids_of::<S>(particles, home.iter());
    lasting.extend(abroad.iter().map(|abroad| abroad.carried));
    pack(particles, &(0..particles.len() as u32).collect::<Vec<u32>>(), &lasting)
}

/// Turns carried state with ids into carried state with indices, at the process that has its particles.
pub fn settle<S: Solve>(lasting: Vec<S::Carried>, work: &mut Work<S::Carried>) {
    let places: FxHashMap<u32, u32> = work.particles.id.iter().copied().zip(0..).collect();
    for carried in lasting {
        let here: Vec<Option<u32>> = S::places(&carried).iter().flatten().map(|id| places.get(id).copied()).collect();
        match here.iter().flatten().next() {
            // the overlap of the two is known when a part has been done
            Some(&own) if here.iter().any(Option::is_none) => {
                work.abroad.push(CrossRankContact { carried, own, overlap: None })
            }
            Some(_) => work.lasting.push(S::moved(&carried, &|id| places.get(&id).copied().unwrap_or(id))),
            None => {}
        }
    }
}

impl Domains {
    /// Distributes a part that the lead process has: each process gets its particles and their carried state. The other
    /// processes pass no bytes.
    pub fn deal<S: Solve>(&self, bytes: &[u8], domain: &Domain) -> Vec<u8> {
        let mut outgoing = vec![Vec::new(); self.communicator.size()];
        let mut part = Particles::default();
        if let Some(lasting) = take_aboard::<S::Carried>(bytes, &mut part) {
            part.wrap(domain);
            let owners: Vec<usize> = part.position.iter().map(|x| self.blocks.owner(x)).collect();
            let owner_of: FxHashMap<u32, usize> = part.id.iter().copied().zip(owners.iter().copied()).collect();
            for (rank, bytes) in outgoing.iter_mut().enumerate() {
                let is_theirs = |place: &u32| owners[*place as usize] == rank;
                let places: Vec<u32> = (0..part.len() as u32).filter(is_theirs).collect();
                let touches = |carried: &&S::Carried| {
                    S::places(carried).iter().flatten().any(|id| owner_of.get(id) == Some(&rank))
                };
                *bytes = pack(&part, &places, &lasting.iter().filter(touches).copied().collect::<Vec<_>>());
            }
        }
        self.communicator.exchange(outgoing).into_iter().next().unwrap_or_default()
    }
}
