//! All particles of a run in the order of their ids, in slices that fit in memory, from all processes that hold them.

use super::{CHUNK, Particles};
use crate::communicator::Communicator;

/// Number of particles of a slice put together from several processes: few enough for the memory of one, and many
/// enough for few messages.
const SLICE: usize = 1 << 17;

/// Calls `visit` with slices of the particles of all processes, one after the other in the order of ids. Only the
/// lead process calls `visit`. All processes must call this function, each with its part, and ids are 0 .. N. Without
/// a communicator `particles` are all there are.
pub fn for_each_slice(
    particles: &Particles,
    communicator: Option<&dyn Communicator>,
    visit: &mut dyn FnMut(&Particles),
) {
    let mut order: Vec<u32> = (0..particles.len() as u32).collect();
    order.sort_unstable_by_key(|&place| particles.id[place as usize]);
    let mut slice = Particles::default();
    let Some(communicator) = communicator else {
        for places in order.chunks(CHUNK) {
            slice.clear();
            slice.copy_from(particles, places);
            visit(&slice);
        }
        return;
    };
    let mut count = [order.len() as i64];
    communicator.sum(&mut count);
    let mut rest = order.as_slice();
    for last in (0..count[0] as usize).step_by(SLICE).map(|first| first + SLICE) {
        let own;
        (own, rest) = rest.split_at(rest.partition_point(|&place| (particles.id[place as usize] as usize) < last));
        let mut bytes = Vec::new();
        particles.pack(own, &mut bytes);
        slice.clear();
        for bytes in communicator.collect(bytes) {
            // what a process has packed can be read
            let _ = slice.unpack(&bytes);
        }
        if communicator.is_lead() {
            slice.sort_by_id();
            visit(&slice);
        }
    }
}

/// Checksum of the particles of all processes, as [`Particles::fingerprint`]. All processes must call it and get the
/// result.
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
