//! Neighbour lists of the particles of one part, in one array. A part is a set of particles with consecutive indices,
//! whose events one thread processes. A *room* is a memory block of one list.

use super::division::Division;

use super::list_pool::{ListPool, room_for, size};
use super::old_neighbours::OldNeighbours;
use super::shells::Shell;
use prefetch_index::prefetch_index;
use serde::{Deserialize, Serialize};

/// Neighbour lists of the particles of one part, whose events one thread processes. A neighbour may belong to another
/// part. The lists of two parts share no cache line, nor a pair of lines that processors fetch together.
#[repr(align(128))]
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct NeighbourLists {
    /// Memory of all lists. Unused entries of a list contain the index of the particle to which the list belongs.
    near: Vec<u32>,
    /// Free rooms (memory blocks) between the lists, which other lists may use.
    #[serde(skip)]
    free: ListPool,
    /// Memory for the new list of a particle whose list is made again.
    #[serde(skip)]
    pub found: Vec<u32>,
    /// Memory for the old list of a particle whose list is made again.
    #[serde(skip)]
    pub old: OldNeighbours,
}

/// Inverse of the fraction of memory that is reserved for growth of the neighbour lists. With the value 5, a fifth is
/// added. After a random start the lists become longer by a fifth or less in dense scenes. Without reserved memory all
/// lists might have to be copied. Reserved memory that is never written takes no space.
const SPARE: usize = 5;

/// Inverse of the fraction by which the memory of all neighbour lists grows when it is full: it grows by 1/16.
const MORE: usize = 16;

/// Number of indices in a cache line of 64 bytes.
const PER_LINE: usize = 16;

/// Neighbour lists of the part (particles of one thread) to which the particle at `index` belongs. `lists` has one item
/// for each part, or only the item of this part.
#[inline(always)]
pub fn lists_of<'a>(lists: &'a [NeighbourLists], division: &Division, index: u32) -> &'a NeighbourLists {
    &lists[if lists.len() == 1 { 0 } else { division.number(index) }]
}

/// Neighbour lists, for changes, of the part (particles of one thread) to which the particle at `index` belongs.
/// `lists` has one item for each part, or only the item of this part.
#[inline(always)]
pub fn lists_of_mut<'a>(lists: &'a mut [NeighbourLists], division: &Division, index: u32) -> &'a mut NeighbourLists {
    let part = if lists.len() == 1 { 0 } else { division.number(index) };
    &mut lists[part]
}

impl NeighbourLists {
    /// Indices of the neighbours of a particle. `shell` is the ball in which its neighbour list is valid, with the
    /// location of the list.
    #[inline]
    pub fn neighbours(&self, shell: &Shell) -> &[u32] {
        &self.near[shell.first as usize..(shell.first + shell.count) as usize]
    }

    /// Indices of the neighbours of a particle, in groups of four. `shell` contains the location of its list. If the
    /// last group is not full, the index of the particle itself fills it.
    #[inline]
    pub fn in_fours(&self, shell: &Shell) -> &[[u32; 4]] {
        let end = shell.first + shell.count.next_multiple_of(4);
        self.near[shell.first as usize..end as usize].as_chunks().0
    }

    /// Prefetches the neighbour list at the location in `shell` into the processor's cache.
    #[inline]
    pub fn fetch_list(&self, shell: &Shell) {
        let (first, last) = (shell.first as usize, (shell.first + shell.count.saturating_sub(1)) as usize);
        (first..last).step_by(PER_LINE).chain([last]).for_each(|at| prefetch_index(&self.near, at));
    }

    /// Reserves memory for further lists, with the numbers of neighbours `counts`. With these lists, `known` of the
    /// `count` particles of the part have lists. If the memory must grow, it is made large enough for the lists of all
    /// `count` particles, by extrapolation.
    pub fn reserve(&mut self, counts: impl Iterator<Item = u32>, known: usize, count: usize) {
        let room: usize = counts.map(|count| size(room_for(count)) as usize).sum();
        let all = self.near.len() + room;
        if all > self.near.capacity() {
            let foreseen = (all as f64 * (count as f64 / known as f64)).ceil() as usize;
            self.near.reserve_exact(foreseen + foreseen / SPARE - self.near.len());
        }
    }

    /// Stores the list `own` of the particle at `index` behind all other lists, and writes the location of the list to
    /// `shell`.
    pub fn append(&mut self, index: u32, own: &[u32], shell: &mut Shell) {
        let (first, count) = (self.near.len() as u32, own.len() as u32);
        (shell.first, shell.count, shell.room) = (first, count, room_for(count));
        self.near.extend_from_slice(own);
        self.near.resize((first + size(shell.room)) as usize, index);
    }

    /// Replaces the list of the particle at `index` by `own`; `shell` contains the location of the list. If a smaller
    /// room (memory block) is sufficient, the list moves there. Otherwise every room would stay as large as its longest
    /// list so far, and small rooms would remain unused.
    pub fn replace(&mut self, index: u32, own: &[u32], shell: &mut Shell) {
        let count = own.len() as u32;
        let wanted = room_for(count);
        if wanted != shell.room {
            self.relocate(shell, wanted);
        }
        shell.count = count;
        let room = size(shell.room) as usize;
        let (list, free) = self.near[shell.first as usize..][..room].split_at_mut(own.len());
        list.copy_from_slice(own);
        free.fill(index);
    }

    /// Gives the list whose location is in `shell` another memory block: a free one with the size number `room`, or a
    /// new one at the end of the memory. The old block becomes free; the new block still has arbitrary content.
    fn relocate(&mut self, shell: &mut Shell, room: u8) {
        self.free.give(shell.room, shell.first);
        let first = self.free.take(room).unwrap_or_else(|| {
            let (first, more) = (self.near.len(), size(room) as usize);
            if self.near.capacity() < first + more {
                // reserves less than the default growth, which would double the capacity
                self.near.reserve_exact(more.max(first / MORE));
            }
            self.near.resize(first + more, 0);
            first as u32
        });
        (shell.first, shell.room) = (first, room);
    }

    /// Removes particle `j` from the neighbour list of particle `i`; `shell` contains the location of the list.
    pub fn remove(&mut self, shell: &mut Shell, i: u32, j: u32) {
        let list = &mut self.near[shell.first as usize..(shell.first + shell.count) as usize];
        if let Some(k) = list.iter().position(|&other| other == j) {
            let last = list.len() - 1;
            list.swap(k, last);
            list[last] = i;
            shell.count -= 1;
        }
    }

    /// Adds particle `j` to the neighbour list of particle `i`; `shell` contains the location of the list.
    pub fn add(&mut self, shell: &mut Shell, i: u32, j: u32) {
        if shell.count == size(shell.room) {
            let old = shell.first as usize..(shell.first + shell.count) as usize;
            self.relocate(shell, shell.room + 1);
            let first = shell.first as usize;
            self.near.copy_within(old, first);
            self.near[first + shell.count as usize..first + size(shell.room) as usize].fill(i);
        }
        self.near[(shell.first + shell.count) as usize] = j;
        shell.count += 1;
    }
}
