//! Search in the old neighbour list of a particle whose list is made again.

/// Old neighbour list of a particle, with a hash table of its entries. Most old neighbours are also new neighbours.
/// With the table, the old neighbours that are not new neighbours are found in a time proportional to the length of the
/// list.
#[derive(Clone, Debug, Default)]
pub struct OldNeighbours {
    /// Indices of the old neighbours. Each one that is also a new neighbour is replaced by the index of the particle to
    /// which the list belongs.
    indices: Vec<u32>,
    /// Hash table with open addressing. Each used slot contains the place of an old neighbour in `indices`, plus one;
    /// unused slots contain 0. The size of the table is a power of two, and more than twice the number of old
    /// neighbours.
    slots: Vec<u32>,
}

/// Multiplier of the hash function: 2³² over the golden ratio (Knuth, The Art of Computer Programming 3, section 6.4).
const MULTIPLIER: u32 = 0x9E37_79B9;

impl OldNeighbours {
    /// Stores the indices in `list` as the old neighbours.
    #[inline]
    pub fn set(&mut self, list: &[u32]) {
        self.indices.clear();
        self.indices.extend_from_slice(list);
        self.slots.clear();
        self.slots.resize((2 * list.len() + 2).next_power_of_two(), 0);
        for (place, &index) in (1..).zip(list) {
            let slot = self.slots_of(index).find(|&slot| self.slots[slot] == 0);
            slot.into_iter().for_each(|slot| self.slots[slot] = place);
        }
    }

    /// Removes `index` from the old neighbours, and returns true if it was one of them. `own` is the index of the
    /// particle to which the list belongs.
    #[inline]
    pub fn remove(&mut self, index: u32, own: u32) -> bool {
        for slot in self.slots_of(index) {
            let Some(place) = (self.slots[slot] as usize).checked_sub(1) else { return false };
            if self.indices[place] == index {
                self.indices[place] = own;
                return true;
            }
        }
        false
    }

    /// Indices of the old neighbours that have not been removed. `own` is the index of the particle to which the list
    /// belongs.
    pub fn rest(&self, own: u32) -> impl Iterator<Item = u32> {
        self.indices.iter().copied().filter(move |index| *index != own)
    }

    /// Slots of the hash table in which `index` may be, in the order of the search.
    #[inline]
    fn slots_of(&self, index: u32) -> impl Iterator<Item = usize> + use<> {
        let size = self.slots.len();
        let first = (index.wrapping_mul(MULTIPLIER) >> 16) as usize;
        (0..size).map(move |step| (first + step) & (size - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_neighbours_are_removed_once_and_the_others_remain() {
        let mut old = OldNeighbours::default();
        for count in [0, 1, 7, 100, 5000] {
            let list: Vec<u32> = (0..count).map(|k| 65_536 * k % 99_991).collect();
            old.set(&list);
            assert!(!old.remove(99_999, 200_000));
            let (gone, rest) = list.split_at(list.len() / 3);
            for &index in gone {
                assert!(old.remove(index, 200_000), "{index} of {count}");
                assert!(!old.remove(index, 200_000), "{index} of {count} again");
            }
            assert_eq!(old.rest(200_000).collect::<Vec<u32>>(), rest);
        }
    }
}
