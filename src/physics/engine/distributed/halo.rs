//! Own and borrowed particles of a process while several processes share uniform time steps. A borrowed particle, or
//! ghost, is a copy of a particle that another process owns. A window is the time between two exchanges with the gas.
//! The neighbour list holds the pairs that may touch soon. The lead process is process 0.

use super::CrossRankContact;
use super::domains::Domains;
use crate::encounter::FrameTime;
use crate::engine::driver::Work;
use crate::engine::islands::Solve;
use crate::engine::soft::{Contact, ContactTorque, ForceBuffer, ForceIncrement, SoftIslands};
use crate::engine::{Failure, Overlap};
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use nalgebra::Vector3;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::{Deserialize, Serialize};

/// Solver of islands (groups of particles that may meet) of soft spheres; this module uses its functions that read and
/// change the indices of the particles of a contact.
type Solving = SoftIslands;

/// Own particles of a process and its ghosts (copies of particles of other processes), while processes share uniform
/// time steps.
#[derive(Default)]
pub struct Halo {
    /// For each particle, in the order of the neighbour list, true if this process owns it.
    pub mine: Vec<bool>,
    /// Indices of the particles that this process owns, in the order of the neighbour list.
    pub own: Vec<u32>,
    /// For each process, the indices of the own particles of which that process has copies, in the order of ids.
    pub lent: Vec<Vec<u32>>,
    /// For each process, the indices of the particles that this process has copied from it, in the order of ids.
    pub borrowed: Vec<Vec<u32>>,
    /// [m] positions of the particles at the time when the neighbour list was built.
    pub built_at: Vec<Vector3<f64>>,
    /// Own particles and copies of particles of other processes, at the end of the last window (time between two
    /// exchanges with the gas).
    pub seen: Particles,
    /// Scratch memory: for each particle, true if a force acted on it. Between uses all entries are false.
    pushed: Vec<bool>,
}

/// Ids of the particles of which processes have exchanged copies. Ids replace indices while the order of the particles
/// changes.
pub struct Names {
    lent: Vec<Vec<u32>>,
    borrowed: Vec<Vec<u32>>,
    /// Id of each particle, by its index before the neighbour list was built.
    id: Vec<u32>,
}

/// Data that a process sends to the lead process (process 0), for a neighbour list of all particles and a list of all
/// forces that are not yet applied.
#[derive(Serialize, Deserialize)]
struct ListSummary {
    id: Vec<u32>,
    built_at: Vec<Vector3<f64>>,
    /// Ids of particles, each with a force [N] and a torque that have been computed but not yet applied. The torque is
    /// `None` if spheres do not rotate.
    due: Vec<(u32, Vector3<f64>, Option<ContactTorque>)>,
}

impl Halo {
    /// Makes the data of a process that owns all `count` particles of its store and has no copies.
    pub fn of_all(count: usize) -> Self {
        Self { mine: vec![true; count], own: (0..count as u32).collect(), ..Self::default() }
    }

    /// Sends particles that have left the block (region of the box) to the processes that own their new blocks, and
    /// copies all particles of other processes within `width` [m] of the block. Afterwards the store contains own
    /// particles and copies, and `work.lasting` the contacts of own particles. The function `follow` fills the lists
    /// `own`, `lent` and `borrowed` later.
    pub fn borrow(domains: &mut Domains<Contact>, work: &mut Work<Contact>, width: f64) -> (Self, Names) {
        let (mine, indices) = domains.borrow::<SoftIslands>(work, width);
        let id = &work.particles.id;
        let ids = |indices: &Vec<u32>| {
            let mut ids: Vec<u32> = indices.iter().map(|&index| id[index as usize]).collect();
            ids.sort_unstable();
            ids
        };
        let lent: Vec<Vec<u32>> = indices.iter().map(ids).collect();
        let outgoing = lent.iter().map(|ids| ids.iter().flat_map(|id| id.to_le_bytes()).collect()).collect();
        let number = |bytes: &[u8; 4]| u32::from_le_bytes(*bytes);
        let borrowed = domains.communicator().exchange(outgoing);
        let borrowed: Vec<Vec<u32>> =
            borrowed.iter().map(|bytes| bytes.as_chunks::<4>().0.iter().map(number).collect()).collect();
        // removes particles that have left the block and are not borrowed again
        let wanted: FxHashSet<u32> = borrowed.iter().flatten().copied().collect();
        let stays: Vec<bool> = id.iter().zip(&mine).map(|(id, mine)| *mine || wanted.contains(id)).collect();
        let kept: Vec<u32> = (0..id.len() as u32).filter(|&index| stays[index as usize]).collect();
        let mut index_of = vec![0; id.len()];
        kept.iter().zip(0..).for_each(|(&from, index)| index_of[from as usize] = index);
        let is_kept = |index: &u32| stays[*index as usize];
        let is_mine = |index: &u32| mine[*index as usize];
        work.lasting.retain(|contact| {
            let indices = Solving::indices(contact);
            indices.iter().flatten().all(is_kept) && indices.iter().flatten().any(is_mine)
        });
        for contact in work.lasting.iter_mut() {
            *contact = Solving::moved(contact, &|index| index_of[index as usize]);
        }
        work.particles.reorder(&kept);
        let mine = kept.iter().map(is_mine).collect();
        (Self { mine, ..Self::default() }, Names { lent, borrowed, id: work.particles.id.clone() })
    }

    /// Adopts the order of particles in a new neighbour list: the particle that was at index `p` is now at
    /// `index_of[p]`. Fills the lists of indices with the new indices of the particles whose ids are in `names`.
    pub fn follow(&mut self, index_of: &[u32], names: Names) {
        let mut mine = vec![false; index_of.len()];
        self.mine.iter().zip(index_of).for_each(|(is_mine, &index)| mine[index as usize] = *is_mine);
        self.own = (0u32..).zip(&mine).filter(|(_, mine)| **mine).map(|(index, _)| index).collect();
        self.mine = mine;
        let index: FxHashMap<u32, u32> = names.id.iter().copied().zip(index_of.iter().copied()).collect();
        let indices = |ids: Vec<u32>| ids.iter().filter_map(|id| index.get(id).copied()).collect();
        self.lent = names.lent.into_iter().map(indices).collect();
        self.borrowed = names.borrowed.into_iter().map(indices).collect();
    }

    /// Marks the particles on which the forces in `pushes` act. [`pack`](Self::pack) reads the marks.
    pub fn mark(&mut self, pushes: &[ForceBuffer]) {
        self.pushed.resize(self.mine.len(), false);
        self.set_pushed(pushes, true);
    }

    /// Removes the marks of the particles on which the forces in `pushes` act.
    pub fn unmark(&mut self, pushes: &[ForceBuffer]) {
        self.set_pushed(pushes, false);
    }

    fn set_pushed(&mut self, pushes: &[ForceBuffer], set: bool) {
        for push in pushes.iter().flat_map(|pushes| &pushes.list) {
            self.pushed[push.i as usize] = set;
            if let Some(j) = push.j {
                self.pushed[j.get() as usize] = set;
            }
        }
    }

    /// Packs new velocities into bytes for another process, which has copies of the particles of this process with the
    /// indices `lent`. Only particles on which forces acted are included. Each velocity is preceded by the place of
    /// its particle in `lent`.
    pub fn pack(&self, lent: &[u32], particles: &Particles) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (k, &index) in (0u32..).zip(lent) {
            if self.pushed[index as usize] {
                bytes.extend(k.to_le_bytes());
                particles.pack_kicked(index as usize, &mut bytes);
            }
        }
        bytes
    }

    /// Returns own particles and copies at the start of a window, the time between two exchanges with the gas. Drag,
    /// for instance, may have changed the velocities of own particles; the new velocities are sent to the processes
    /// that have copies of these particles.
    pub fn synchronised_view(&mut self, own: &Particles, domains: &Domains<Contact>) -> Particles {
        let mut seen = std::mem::take(&mut self.seen);
        for (k, &index) in self.own.iter().enumerate() {
            seen.set_motion(index as usize, &own.motion(k));
        }
        // kicks by drag also change the gas fluctuations (`eddies`) at the particles; the fluctuations at borrowed
        // particles are not used
        if let (Some(eddies), Some(of_own)) = (&mut seen.eddies, &own.eddies) {
            self.own.iter().zip(of_own).for_each(|(&index, own)| eddies[index as usize] = *own);
        }
        let pack = |indices: &Vec<u32>| {
            let mut bytes = Vec::new();
            indices.iter().for_each(|&index| seen.pack_motion(index as usize, &mut bytes));
            bytes
        };
        let outgoing = self.lent.iter().map(pack).collect();
        let incoming = domains.communicator().exchange(outgoing);
        for (indices, bytes) in self.borrowed.iter().zip(&incoming) {
            let mut rest = bytes.as_slice();
            for &index in indices {
                // unpacking succeeds, since all processes have the same columns
                rest = seen.unpack_motion(index as usize, rest).unwrap_or_default();
            }
        }
        seen
    }

    /// Writes the own particles and the contacts among them into `work` at the end of a window. `seen` contains own
    /// particles and copies. Returns the contacts between an own particle and a particle of another process.
    pub fn leave(
        &self,
        seen: &Particles,
        contacts: &[Contact],
        solver: &SoftIslands,
        work: &mut Work<Contact>,
    ) -> Vec<CrossRankContact<Contact>> {
        work.particles.clear();
        work.particles.copy_from(seen, &self.own);
        let mut index_of = vec![None; self.mine.len()];
        self.own.iter().zip(0u32..).for_each(|(&from, index)| index_of[from as usize] = Some(index));
        work.lasting.clear();
        let mut abroad = Vec::new();
        for contact in contacts {
            let of = Solving::indices(contact);
            let mut here = of.iter().flatten().filter_map(|&index| index_of[index as usize]);
            match here.next() {
                Some(own) if of.iter().flatten().any(|&index| index_of[index as usize].is_none()) => {
                    let carried = Solving::moved(contact, &|index| seen.id[index as usize]);
                    let overlap = solver.touching(contact).map(|couple| Overlap {
                        depth: couple.meet(seen, work.scene, FrameTime::default()).overlap(),
                        diameter: couple.diameter(seen),
                    });
                    abroad.push(CrossRankContact { carried, own, overlap });
                }
                Some(_) => {
                    let index = |index: u32| index_of[index as usize].unwrap_or(index);
                    work.lasting.push(Solving::moved(contact, &index));
                }
                None => {}
            }
        }
        abroad
    }

    /// Packs data for the lead process (process 0): ids of the own particles, their positions at the time when the
    /// neighbour list was built, and the forces that are not yet applied.
    pub fn packed(&self, pushes: &[ForceBuffer]) -> Vec<u8> {
        let mut due = Vec::new();
        let id = |index: u32| self.seen.id[index as usize];
        for (ForceIncrement { i, j, force }, torque) in pushes.iter().flat_map(ForceBuffer::iter) {
            due.push((id(i), force, torque));
            due.extend(j.map(|j| (id(j.get()), -force, torque.map(ContactTorque::reversed))));
        }
        let told = ListSummary {
            id: self.own.iter().map(|&index| id(index)).collect(),
            built_at: self.own.iter().map(|&index| self.built_at[index as usize]).collect(),
            due,
        };
        postcard::to_stdvec(&told).unwrap_or_default()
    }
}

/// Makes, in the lead process (process 0), the neighbour list of all particles and the list of forces that are not yet
/// applied, from the data `parts` of all processes. The settings of the list are those of `own`, the list of the lead
/// process. Sorts the particles and contacts of `work` in the order of the new neighbour list.
pub fn list_of_all(parts: &[Vec<u8>], own: &NeighbourList, work: &mut Work<Contact>) -> (NeighbourList, ForceBuffer) {
    let index: FxHashMap<u32, u32> = work.particles.id.iter().copied().zip(0..).collect();
    let mut then = work.particles.clone();
    let mut due = Vec::new();
    for told in parts.iter().filter_map(|bytes| postcard::from_bytes::<ListSummary>(bytes).ok()) {
        for (id, position) in told.id.iter().zip(told.built_at) {
            if let Some(&index) = index.get(id) {
                then.position[index as usize] = position;
            }
        }
        due.extend(told.due);
    }
    let mut list = own.without_pairs();
    let order = list.build_again(&mut then, work.scene);
    let mut index_of = vec![0u32; order.len()];
    order.iter().zip(0..).for_each(|(&from, index)| index_of[from as usize] = index);
    work.particles.reorder(&order);
    for contact in work.lasting.iter_mut() {
        *contact = Solving::moved(contact, &|index| index_of[index as usize]);
        contact.slot = list.slot(&contact.touch.couple).map_or(contact.slot, |slot| slot as u32);
    }
    work.lasting.sort_unstable_by_key(|contact| contact.slot);
    let now = |id: u32| index.get(&id).map_or(0, |&index| index_of[index as usize]);
    let mut pending = ForceBuffer::default();
    for (id, force, torque) in due {
        let push = ForceIncrement { i: now(id), j: None, force };
        match torque {
            Some(torque) => pending.add_rotating(push, torque),
            None => pending.add(push),
        }
    }
    (list, pending)
}

/// Converts a failure, or `None`, to bytes for sending to other processes.
pub fn to_bytes(failure: &Option<Failure>) -> Vec<u8> {
    postcard::to_stdvec(failure).unwrap_or_default()
}

/// Adopts the velocities after a kick (change of velocities by forces), which another process has sent for particles
/// copied from it. `borrowed` contains the indices of these copies in this process.
pub fn take_kicks(mut bytes: &[u8], borrowed: &[u32], particles: &mut Particles) {
    while let Some((number, rest)) = bytes.split_first_chunk() {
        let index = borrowed.get(u32::from_le_bytes(*number) as usize);
        // unpacking succeeds, since all processes store the same quantities of particles
        let read = index.and_then(|&index| particles.unpack_kicked(index as usize, rest));
        let Some(rest) = read else { return };
        bytes = rest;
    }
}
