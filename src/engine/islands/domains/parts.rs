//! What a process has, as bytes that can be stored, and what is stored so, dealt out anew to however many processes.

use super::{Domains, ids_of, pack, take_aboard};
use crate::domain::Domain;
use crate::engine::driver::{CrossRankContact, Work};
use crate::engine::islands::Solve;
use crate::particles::Particles;
use rustc_hash::FxHashMap;

/// The particles of this process and what lasts of them, its places being ids.
pub fn packed_part<S: Solve>(
    particles: &Particles,
    home: &[S::Carried],
    abroad: &[CrossRankContact<S::Carried>],
) -> Vec<u8> {
    let mut lasting = ids_of::<S>(particles, home.iter());
    lasting.extend(abroad.iter().map(|abroad| abroad.carried));
    pack(particles, &(0..particles.len() as u32).collect::<Vec<u32>>(), &lasting)
}

/// Puts what lasts, its places being ids, where its particles are.
pub fn settle<S: Solve>(lasting: Vec<S::Carried>, work: &mut Work<S::Carried>) {
    let places: FxHashMap<u32, u32> = work.particles.id.iter().copied().zip(0..).collect();
    for carried in lasting {
        let here: Vec<Option<u32>> = S::places(&carried).iter().flatten().map(|id| places.get(id).copied()).collect();
        match here.iter().flatten().next() {
            // how far two overlap is known when a part has been done
            Some(&own) if here.iter().any(Option::is_none) => {
                work.abroad.push(CrossRankContact { carried, own, overlap: None })
            }
            Some(_) => work.lasting.push(S::moved(&carried, &|id| places.get(&id).copied().unwrap_or(id))),
            None => {}
        }
    }
}

impl Domains {
    /// Gives each process what is its of a part that the lead has; the others have none to give.
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
