//! Memory blocks ("rooms") for neighbour lists, of different sizes in one long array. Free blocks are used again.
//!
//! A particle's neighbour list grows and shrinks by one entry at a time. If the sizes of rooms were powers of two, a
//! quarter of the memory would be unused on average. Sizes are multiples of four entries, so one or two entries are
//! unused. Above 64 entries the steps from one size to the next grow, to at most an eighth of the size, so that there
//! are few different sizes.

/// Number of entries by which the sizes of the smallest rooms (memory blocks of neighbour lists) differ. The value
/// equals the number of neighbours that are tested at the same time.
const STEP: u32 = 4;

/// Size of the smallest room (memory block of a neighbour list), counted in steps of four entries. This room fills half
/// a cache line.
const LEAST: u32 = 2;

/// Number of sizes of rooms (memory blocks of neighbour lists) from one power of two to the next.
const PER_OCTAVE: u32 = 8;

/// Number of entries of a room (memory block of a neighbour list) with the size number `room`. Below twice
/// [`PER_OCTAVE`] the size number counts steps of four entries. For larger size numbers, there are eight sizes from one
/// power of two to the next.
#[inline]
pub fn size(room: u8) -> u32 {
    let room = u32::from(room);
    if room < 2 * PER_OCTAVE {
        STEP * room
    } else {
        (STEP * (PER_OCTAVE + room % PER_OCTAVE)) << (room / PER_OCTAVE - 1)
    }
}

/// Size number of the smallest room (memory block of a neighbour list) that has space for `count` entries.
#[inline]
pub fn room_for(count: u32) -> u8 {
    let steps = count.div_ceil(STEP).max(LEAST);
    if steps < 2 * PER_OCTAVE {
        return steps as u8;
    }
    let doublings = (steps / PER_OCTAVE).ilog2();
    // rounding up to the next octave gives the first size of that octave
    (PER_OCTAVE * doublings + steps.div_ceil(1 << doublings)) as u8
}

/// Free rooms (memory blocks of neighbour lists). A list that grows or shrinks moves to a room of another size, and its
/// old room becomes free.
#[derive(Clone, Debug, Default)]
pub struct ListPool {
    /// For each size number of rooms (memory blocks), the indices in the array of all neighbour lists at which free
    /// rooms of that size begin.
    free: Vec<Vec<u32>>,
}

impl ListPool {
    /// Adds a free room (memory block) with the size number `room`, which begins at the index `first` of the array of
    /// all lists.
    pub fn give(&mut self, room: u8, first: u32) {
        self.free.resize(self.free.len().max(usize::from(room) + 1), Vec::new());
        self.free[usize::from(room)].push(first);
    }

    /// Removes a free room (memory block) with the size number `room` from the pool. Returns the index, in the array of
    /// all lists, at which the room begins; `None` if no room of this size is free.
    pub fn take(&mut self, room: u8) -> Option<u32> {
        self.free.get_mut(usize::from(room))?.pop()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_count_has_the_smallest_room_that_holds_it() {
        for count in 0..100_000 {
            let room = room_for(count);
            assert!(size(room) >= count && size(room).is_multiple_of(4), "{count}: room {room} of {}", size(room));
            assert!(room == 2 || size(room - 1) < count, "{count}: room {room} of {}", size(room));
        }
        let largest = room_for(u32::MAX / 2);
        assert!(size(largest) > u32::MAX / 2 - 4);
    }

    #[test]
    fn a_room_that_was_given_back_is_taken_once() {
        let mut rooms = ListPool::default();
        assert_eq!(rooms.take(3), None);
        rooms.give(3, 40);
        rooms.give(5, 60);
        assert_eq!([rooms.take(3), rooms.take(3), rooms.take(4), rooms.take(5)], [Some(40), None, None, Some(60)]);
    }
}
