//! Many bins of particle indices, most of which contain few indices; the event queue uses one bin for each interval of
//! time. A bin is a chain of leaves (blocks of six indices). The leaves of all bins are stored in one list; free leaves
//! are used again.

use super::append;
use prefetch_index::prefetch_index;
use std::iter::successors;
use std::num::NonZeroU32;

/// Link to a leaf (block of six indices): its number in the list of leaves, plus one; `None` at the end of a chain.
type BinLink = Option<NonZeroU32>;

/// A block of up to six particle indices of one bin (interval of time), in half a cache line.
#[derive(Clone, Copy, Debug)]
struct Leaf {
    indices: [u32; 6],
    count: u32,
    /// Link to the next leaf (block of six indices) of the bin; for an unused leaf, link to the next unused leaf.
    next: BinLink,
}

/// Bins that contain particle indices; the event queue has one bin per interval of time.
#[derive(Clone, Debug, Default)]
pub struct Bins {
    /// Link to the first leaf (block of six indices) of each bin; all other leaves of the bin are full.
    first: Vec<BinLink>,
    leaves: Vec<Leaf>,
    free: BinLink,
}

impl Bins {
    /// Makes `count` empty bins in place of the present ones.
    pub fn reset(&mut self, count: usize) {
        self.first.clear();
        self.first.resize(count, None);
        self.leaves.clear();
        self.free = None;
    }

    pub fn count(&self) -> usize {
        self.first.len()
    }

    /// Adds the particle at `index` to the bin number `bin`.
    #[inline]
    pub fn put(&mut self, bin: usize, index: u32) {
        let link = self.first[bin];
        if let Some(leaf) = link.map(|one| &mut self.leaves[one.get() as usize - 1])
            && let Some(room) = leaf.indices.get_mut(leaf.count as usize)
        {
            *room = index;
            leaf.count += 1;
            return;
        }
        let leaf = Leaf { indices: [index; 6], count: 1, next: link };
        self.first[bin] = Some(self.keep(leaf));
    }

    /// Stores a leaf (block of six indices) at a free place of the list of leaves, or at its end. Returns the link to
    /// the leaf.
    fn keep(&mut self, leaf: Leaf) -> NonZeroU32 {
        match self.free {
            Some(one) => {
                let room = &mut self.leaves[one.get() as usize - 1];
                self.free = room.next;
                *room = leaf;
                one
            }
            None => {
                append(&mut self.leaves, leaf);
                NonZeroU32::MIN.saturating_add(self.leaves.len() as u32 - 1)
            }
        }
    }

    /// Particle indices in the bin number `bin`; they stay in the bin.
    pub fn indices(&self, bin: usize) -> impl Iterator<Item = u32> {
        let leaf = |link: BinLink| link.map(|one| &self.leaves[one.get() as usize - 1]);
        let leaves = successors(leaf(self.first[bin]), move |last| leaf(last.next));
        leaves.flat_map(|leaf| leaf.indices.iter().take(leaf.count as usize).copied())
    }

    /// Prefetches the first leaf (block of six indices) of a bin into the processor's cache.
    pub fn fetch(&self, bin: usize) {
        if let Some(one) = self.first[bin] {
            prefetch_index(&self.leaves, one.get() as usize - 1);
        }
    }

    /// Removes all indices from a bin, and calls `each` with every index.
    pub fn empty(&mut self, bin: usize, mut each: impl FnMut(u32)) {
        let mut link = self.first[bin].take();
        while let Some(one) = link {
            let leaf = &mut self.leaves[one.get() as usize - 1];
            leaf.indices.iter().take(leaf.count as usize).for_each(|index| each(*index));
            link = std::mem::replace(&mut leaf.next, self.free);
            self.free = Some(one);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bin_gives_what_was_put_into_it_and_its_leaves_are_used_again() {
        let mut bins = Bins::default();
        bins.reset(8);
        for round in 0..50u32 {
            for index in 0..100 {
                bins.put((index * index % 8) as usize, index + round);
            }
            for bin in 0..8 {
                let seen: Vec<u32> = bins.indices(bin).collect();
                let mut found = Vec::new();
                bins.empty(bin, |index| found.push(index));
                assert_eq!(seen, found);
                found.sort_unstable();
                let put = (0..100u32).filter(|index| (index * index % 8) as usize == bin).map(|index| index + round);
                assert_eq!(found, put.collect::<Vec<_>>());
            }
        }
        assert!(bins.leaves.len() <= 100 / 6 + 8, "{} leaves", bins.leaves.len());
    }
}
