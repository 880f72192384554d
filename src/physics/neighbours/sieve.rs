//! Selection of items without branches (conditional jumps of the program), for a test of every pair in a list.

/// Selects items in their order, without branches. Each item is stored, but the count increases only if the item is
/// selected. The next item overwrites an item that is not selected. This costs less than a branch that the processor
/// often predicts wrongly.
pub(super) struct Sieve<T> {
    held: [T; 64],
    count: usize,
}

impl<T: Copy> Sieve<T> {
    /// Makes an empty sieve (collection of selected items), whose unused entries contain `any`.
    pub(super) fn new(any: T) -> Self {
        Self { held: [any; 64], count: 0 }
    }

    /// Stores the item `item` in the sieve. If `wanted` is false, the next item overwrites it. A full sieve is emptied:
    /// its items are appended to `picked`.
    #[inline(always)]
    pub(super) fn offer(&mut self, item: T, wanted: bool, picked: &mut Vec<T>) {
        self.held[self.count] = item;
        self.count += usize::from(wanted);
        if self.count == self.held.len() {
            self.empty(picked);
        }
    }

    /// Appends the items selected so far to `picked`, and empties the sieve.
    pub(super) fn empty(&mut self, picked: &mut Vec<T>) {
        picked.extend_from_slice(&self.held[..self.count]);
        self.count = 0;
    }
}
