//! All particles of a run in the order of their ids, collected from all processes, in slices (particles with successive
//! ids) that fit in memory.

use super::{CHUNK, Particles};
use crate::communicator::Communicator;

/// Number of particles with successive ids in a slice. Several processes collect the particles slice by slice. A slice
/// is small enough for the memory of one process, and large enough that few messages are sent.
const SLICE: usize = 1 << 17;

/// Calls `visit` with slices of the particles of all processes, in the order of ids. Only the lead process (number 0)
/// calls `visit`. All processes must call this function, each with its own particles. With a communicator, the ids of
/// all particles together must be all numbers below the total number of particles. Without a communicator `particles`
/// contains all particles.
pub fn for_each_slice(
    particles: &Particles,
    communicator: Option<&dyn Communicator>,
    visit: &mut dyn FnMut(&Particles),
) {
    let mut order: Vec<u32> = (0..particles.len() as u32).collect();
    order.sort_unstable_by_key(|&index| particles.id[index as usize]);
    let mut slice = Particles::default();
    let Some(communicator) = communicator else {
        for indices in order.chunks(CHUNK) {
            slice.clear();
            slice.copy_from(particles, indices);
            visit(&slice);
        }
        return;
    };
    let mut count = [order.len() as i64];
    communicator.sum(&mut count);
    let mut rest = order.as_slice();
    for last in (0..count[0] as usize).step_by(SLICE).map(|first| first + SLICE) {
        let own;
        (own, rest) = rest.split_at(rest.partition_point(|&index| (particles.id[index as usize] as usize) < last));
        let mut bytes = Vec::new();
        particles.pack(own, &mut bytes);
        slice.clear();
        for bytes in communicator.collect(bytes) {
            // unpacking cannot fail, since `pack` wrote these bytes
            let _ = slice.unpack(&bytes);
        }
        if communicator.is_lead() {
            slice.sort_by_id();
            visit(&slice);
        }
    }
}

/// Checksum of the particles of all processes, equal to [`Particles::fingerprint`] of a store with all particles. All
/// processes must call this function, and each receives the result. Without a communicator, `particles` contains all
/// particles.
pub fn fingerprint_of(particles: &Particles, communicator: Option<&dyn Communicator>) -> u64 {
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325; // offset basis, Fowler, Noll & Vo
    for_each_slice(particles, communicator, &mut |slice| {
        for index in 0..slice.len() {
            slice.for_each_moving_number(index, &mut |value| {
                for byte in value.to_bits().to_le_bytes() {
                    hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3); // prime, Fowler, Noll & Vo
                }
            });
        }
    });
    let Some(communicator) = communicator else { return hash };
    let told = communicator.broadcast(hash.to_le_bytes().to_vec());
    told.try_into().map_or(hash, u64::from_le_bytes)
}
