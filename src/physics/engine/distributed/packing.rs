//! Packing the particles of a process into bytes that can be stored, and distributing stored parts to any number of
//! processes. The lead process is process 0.

use super::CrossRankContact;
use super::domains::Domains;
use crate::domain::Domain;
use crate::engine::driver::Work;
use crate::engine::islands::Solve;
use crate::particles::Particles;
use rustc_hash::FxHashMap;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// [bytes] size of the number at the start of a message, which tells how many bytes of particle data follow.
const LENGTH: usize = 8;

/// Packs all particles of this process and their carried items (contacts in progress, or recent collisions) into
/// bytes. `home` contains the items of own particles only, `abroad` those that also involve a particle of another
/// process. In the bytes, ids of particles replace indices.
pub fn packed_part<S: Solve>(
    particles: &Particles,
    home: &[S::Carried],
    abroad: &[CrossRankContact<S::Carried>],
) -> Vec<u8> {
    let mut lasting = ids_of::<S>(particles, home.iter());
    lasting.extend(abroad.iter().map(|abroad| abroad.carried));
    pack(particles, &(0..particles.len() as u32).collect::<Vec<u32>>(), &lasting)
}

/// Adds to `work` the received contacts (or recent collisions) whose particles are all stored in this process, and
/// replaces ids by indices. Contacts between a particle of this process and one of another process are not added but
/// returned. Contacts without a particle of this process are left out.
pub fn add_received_contacts<S: Solve>(
    lasting: Vec<S::Carried>,
    work: &mut Work<S::Carried>,
) -> Vec<CrossRankContact<S::Carried>> {
    let mut abroad = Vec::new();
    let indices: FxHashMap<u32, u32> = work.particles.id.iter().copied().zip(0..).collect();
    for carried in lasting {
        let here: Vec<Option<u32>> = S::indices(&carried).iter().flatten().map(|id| indices.get(id).copied()).collect();
        match here.iter().flatten().next() {
            // for a contact between particles of two processes, the overlap is computed at the end of the next
            // interval of motion
            Some(&own) if here.iter().any(Option::is_none) => {
                abroad.push(CrossRankContact { carried, own, overlap: None })
            }
            Some(_) => work.lasting.push(S::moved(&carried, &|id| indices.get(&id).copied().unwrap_or(id))),
            None => {}
        }
    }
    abroad
}

impl<C: Copy + Serialize + DeserializeOwned> Domains<C> {
    /// Distributes one part of a stored run (a share of its particles) to the processes that own the blocks (regions of
    /// the box). The lead process (process 0) has read the part as `bytes`; the other processes pass empty `bytes`.
    /// Returns, in each process, bytes with the particles of this process and their contacts. All processes must call
    /// this function.
    pub fn deal<S: Solve<Carried = C>>(&self, bytes: &[u8], domain: &Domain) -> Vec<u8> {
        let mut outgoing = vec![Vec::new(); self.communicator.size()];
        let mut part = Particles::default();
        if let Some(lasting) = take_aboard::<C>(bytes, &mut part) {
            part.wrap(domain);
            let owners: Vec<usize> = part.position.iter().map(|x| self.blocks.owner(x)).collect();
            let owner_of: FxHashMap<u32, usize> = part.id.iter().copied().zip(owners.iter().copied()).collect();
            for (rank, bytes) in outgoing.iter_mut().enumerate() {
                let is_theirs = |index: &u32| owners[*index as usize] == rank;
                let indices: Vec<u32> = (0..part.len() as u32).filter(is_theirs).collect();
                let touches = |carried: &&S::Carried| {
                    S::indices(carried).iter().flatten().any(|id| owner_of.get(id) == Some(&rank))
                };
                *bytes = pack(&part, &indices, &lasting.iter().filter(touches).copied().collect::<Vec<_>>());
            }
        }
        self.communicator.exchange(outgoing).into_iter().next().unwrap_or_default()
    }
}

/// Packs the particles at `indices`, and the contacts `lasting`, into bytes for sending. The bytes contain
/// the length of the particles' data, these data, then the contacts.
pub fn pack<C: Serialize>(particles: &Particles, indices: &[u32], lasting: &[C]) -> Vec<u8> {
    let mut bytes = vec![0; LENGTH];
    particles.pack(indices, &mut bytes);
    let length = (bytes.len() - LENGTH) as u64;
    bytes[..LENGTH].copy_from_slice(&length.to_le_bytes());
    let lasting = packed(&lasting);
    bytes.reserve_exact(lasting.len());
    bytes.extend(lasting);
    bytes
}

/// Appends packed particles to `particles`, and returns the contacts that were packed with them. `None` if the bytes
/// are too short or the contacts cannot be read. If the particles cannot be read, no particle is appended.
pub fn take_aboard<C: DeserializeOwned>(bytes: &[u8], particles: &mut Particles) -> Option<Vec<C>> {
    let (length, rest) = bytes.split_first_chunk::<LENGTH>()?;
    let (of_particles, rest) = rest.split_at_checked(u64::from_le_bytes(*length) as usize)?;
    let (lasting, count) = (unpacked(rest)?, particles.len());
    if particles.unpack(of_particles).is_none() {
        particles.truncate(count);
    }
    Some(lasting)
}

/// Copies contacts in progress (or recent collisions), with ids of particles instead of indices.
pub fn ids_of<'a, S: Solve>(particles: &Particles, lasting: impl Iterator<Item = &'a S::Carried>) -> Vec<S::Carried>
where
    S::Carried: 'a,
{
    lasting.map(|carried| S::moved(carried, &|index| particles.id[index as usize])).collect()
}

/// Converts a value to bytes, for sending to other processes.
pub fn packed<T: Serialize>(value: &T) -> Vec<u8> {
    postcard::to_stdvec(value).unwrap_or_default()
}

/// Reads a value that [`packed`] has converted to bytes; `None` if the bytes are not such a value.
pub fn unpacked<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}
