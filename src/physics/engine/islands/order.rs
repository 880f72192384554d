//! Sorting of the particles in the store, and of the contacts carried from one part of a window (the time between two
//! exchanges with the gas) to the next. A part is a piece of a window.

use super::{Solve, search};
use crate::encounter::Other;
use crate::engine::distributed::Processes;
use crate::engine::driver::Work;

/// Sorts the carried contacts (or recent collisions) by the ids of their particles and by walls, and removes
/// duplicates. Their order then does not depend on the order of the particles in the store.
pub fn in_order<S: Solve>(solver: &S, work: &mut Work<S::Carried>) {
    let id = &work.particles.id;
    work.lasting.sort_by_cached_key(|carried| {
        let wall = match solver.touching(carried).map(|couple| couple.other) {
            Some(Other::Wall(at)) => Some((at.wall, at.which)),
            _ => None,
        };
        (S::indices(carried).map(|index| index.map(|index| id[index as usize])), wall)
    });
    // several processes may have sent one contact (or collision) of two ghost particles (copies of particles of other
    // processes)
    work.lasting.dedup_by_key(|carried| (S::indices(carried), solver.touching(carried)));
}

/// Sorts the particles in the store by cells, so that particles near in space are near in memory. Indices in carried
/// contacts are adapted.
pub fn sort<S: Solve>(work: &mut Work<S::Carried>, processes: &mut Processes<S::Carried>) {
    let domain = &work.scene.domain;
    work.wrap();
    let order = search::cell_order(work.particles, &processes.region(domain));
    let mut index_of = vec![0u32; order.len()];
    for (index, &from) in order.iter().enumerate() {
        index_of[from as usize] = index as u32;
    }
    work.particles.reorder(&order);
    for carried in work.lasting.iter_mut() {
        *carried = S::moved(carried, &|index| index_of[index as usize]);
    }
    processes.reorder(&index_of);
}
