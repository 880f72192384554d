//! Columns of a particle store, declared once.
//!
//! The macro [`columns`] makes from one list a struct of arrays and every operation on all of its columns. A column
//! that only some laws need is an `Option<Vec<T>>`: if it is `None`, it takes no memory and every operation skips it.

use super::CHUNK;
use crate::work_sharing;
use nalgebra::Vector3;

/// Operations on one column of a store.
pub trait Column {
    /// Type of one value.
    type Value: Copy + Default + AsBytes + Send + Sync;

    /// The values, if there is such a column.
    fn values(&self) -> Option<&Vec<Self::Value>>;

    /// The values for changes, if there is such a column.
    fn values_mut(&mut self) -> Option<&mut Vec<Self::Value>>;

    /// Moves the value at index `order[k]` to index `k`, for every `k`.
    fn reorder(&mut self, order: &[u32]) {
        if let Some(values) = self.values_mut() {
            let mut anew = vec![Self::Value::default(); order.len()];
            work_sharing::for_each(anew.chunks_mut(CHUNK).zip(order.chunks(CHUNK)), |(anew, order)| {
                anew.iter_mut().zip(order).for_each(|(value, &from)| *value = values[from as usize]);
            });
            *values = anew;
        }
    }

    /// Appends the values at the given indices of another column.
    fn copy_from(&mut self, other: &Self, places: &[u32]) {
        if let (Some(own), Some(values)) = (self.values_mut(), other.values()) {
            own.extend(places.iter().map(|&place| values[place as usize]));
        }
    }

    /// Moves each value from the first index of a pair to the second.
    fn relocate(&mut self, moves: &[(u32, u32)]) {
        if let Some(values) = self.values_mut() {
            moves.iter().for_each(|&(from, to)| values[to as usize] = values[from as usize]);
        }
    }

    /// [bytes] size of `count` packed values, including their number.
    fn packed_size(&self, count: usize) -> usize {
        self.values().map_or(0, |_| size_of::<u64>() + count * Self::Value::SIZE)
    }

    /// Appends the number of indices and the values at these indices to `bytes`.
    fn pack(&self, places: &[u32], bytes: &mut Vec<u8>) {
        if let Some(values) = self.values() {
            bytes.extend_from_slice(&(places.len() as u64).to_le_bytes());
            places.iter().for_each(|&place| values[place as usize].pack(bytes));
        }
    }

    /// Appends the values that a similar column packed at the beginning of `bytes`, and returns the remaining bytes;
    /// `None` if there are too few bytes.
    fn unpack<'a>(&mut self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        let Some(values) = self.values_mut() else { return Some(bytes) };
        let (count, rest) = bytes.split_first_chunk()?;
        let (own, rest) = rest.split_at_checked(Self::Value::SIZE.checked_mul(u64::from_le_bytes(*count) as usize)?)?;
        values.extend(own.chunks_exact(Self::Value::SIZE).map(Self::Value::unpack));
        Some(rest)
    }
}

/// A value that is sent between processes as it stands in memory. For a million particles, text or numbers of
/// variable length would take longer to encode than to send.
pub trait AsBytes: Sized {
    /// [bytes] size of one value.
    const SIZE: usize;

    /// Appends the value to `bytes`.
    fn pack(&self, bytes: &mut Vec<u8>);

    /// Reads the value from `bytes`, which has exactly its size.
    fn unpack(bytes: &[u8]) -> Self;
}

macro_rules! packed_number {
    ($($number:ty),+) => {
        $(impl AsBytes for $number {
            const SIZE: usize = size_of::<$number>();

            fn pack(&self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }

            fn unpack(bytes: &[u8]) -> Self {
                bytes.try_into().map_or_else(|_| Self::default(), Self::from_le_bytes)
            }
        })+
    };
}

packed_number!(f64, u16, u32);

impl AsBytes for Vector3<f64> {
    const SIZE: usize = 24;

    fn pack(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|number| number.pack(bytes));
    }

    fn unpack(bytes: &[u8]) -> Self {
        Self::from_iterator(bytes.chunks_exact(8).map(f64::unpack))
    }
}

impl<T: Copy + Default + AsBytes + Send + Sync> Column for Vec<T> {
    type Value = T;

    fn values(&self) -> Option<&Vec<T>> {
        Some(self)
    }

    fn values_mut(&mut self) -> Option<&mut Vec<T>> {
        Some(self)
    }
}

impl<T: Copy + Default + AsBytes + Send + Sync> Column for Option<Vec<T>> {
    type Value = T;

    fn values(&self) -> Option<&Vec<T>> {
        self.as_ref()
    }

    fn values_mut(&mut self) -> Option<&mut Vec<T>> {
        self.as_mut()
    }
}

/// A value that consists of one or several numbers.
pub trait AsNumbers {
    /// The numbers, in the order of the names with which the column is declared.
    fn numbers_mut(&mut self) -> &mut [f64];
}

impl AsNumbers for f64 {
    fn numbers_mut(&mut self) -> &mut [f64] {
        std::slice::from_mut(self)
    }
}

impl AsNumbers for Vector3<f64> {
    fn numbers_mut(&mut self) -> &mut [f64] {
        self.as_mut_slice()
    }
}

/// Makes a store from a list of its columns. `=> ["x", "y", "z"]` after a column includes it in saved states, as
/// numbers with these names.
macro_rules! columns {
    (
        $(#[$of_store:meta])*
        pub struct $store:ident {
            $($(#[$of_column:meta])* pub $column:ident: $kind:ty $(=> [$($name:literal),+])?,)+
        }
    ) => {
        $(#[$of_store])*
        pub struct $store {
            $($(#[$of_column])* pub $column: $kind,)+
        }

        impl $store {
            /// Removes all particles and keeps the memory.
            pub fn clear(&mut self) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.clear();
                })+
            }

            /// Removes all particles from index `count` on.
            pub fn truncate(&mut self, count: usize) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.truncate(count);
                })+
            }

            /// True if every column in use has one value for each of `count` particles.
            pub(crate) fn is_whole(&self, count: usize) -> bool {
                $(Column::values(&self.$column).is_none_or(|values| values.len() == count))&&+
            }

            /// Appends one particle with all values 0.
            fn grow(&mut self) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.push(Default::default());
                })+
            }

            /// Moves the particle at index `order[k]` to index `k`, for every `k`. `order` is a permutation of 0 .. N
            /// or a part of one; particles that it lacks are removed.
            pub fn reorder(&mut self, order: &[u32]) {
                $(Column::reorder(&mut self.$column, order);)+
            }

            /// Appends copies of the particles at the given indices of another store with equal columns.
            pub fn copy_from(&mut self, other: &Self, places: &[u32]) {
                $(Column::copy_from(&mut self.$column, &other.$column, places);)+
            }

            /// Reserves memory for exactly `count` more particles.
            pub(crate) fn reserve(&mut self, count: usize) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.reserve_exact(count);
                })+
            }

            /// Frees the memory that the store does not need.
            pub(crate) fn shrink(&mut self) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.shrink_to_fit();
                })+
            }

            /// Moves each particle from the first index of a pair to the second, and overwrites the particle there.
            pub(crate) fn relocate(&mut self, moves: &[(u32, u32)]) {
                $(Column::relocate(&mut self.$column, moves);)+
            }

            /// Appends the particles at the given indices to `bytes`.
            pub(crate) fn pack(&self, places: &[u32], bytes: &mut Vec<u8>) {
                // exactly the memory that it takes: for millions of particles that matters
                bytes.reserve_exact(0 $(+ Column::packed_size(&self.$column, places.len()))+);
                $(Column::pack(&self.$column, places, bytes);)+
            }

            /// Appends all particles from the bytes that a store with equal columns packed; `None` if the bytes do
            /// not fit.
            pub(crate) fn unpack(&mut self, bytes: &[u8]) -> Option<()> {
                $(let bytes = Column::unpack(&mut self.$column, bytes)?;)+
                bytes.is_empty().then_some(())
            }

            /// Names of the numbers per particle in a saved state.
            pub fn state_names(&self) -> Vec<&'static str> {
                let mut names = Vec::new();
                $($(if Column::values(&self.$column).is_some() {
                    names.extend([$($name),+]);
                })?)+
                names
            }

            /// Numbers [SI] of the particle at index `place`, in the order of [`state_names`](Self::state_names).
            pub fn state_numbers(&self, place: usize) -> Vec<f64> {
                let mut numbers = Vec::new();
                $($(if let Some(values) = Column::values(&self.$column) {
                    let _: [&str; _] = [$($name),+];
                    numbers.extend_from_slice(values[place].clone().numbers_mut());
                })?)+
                numbers
            }

            /// Sets the numbers [SI] of the particle at index `place`, in the order of
            /// [`state_names`](Self::state_names).
            pub fn set_state(&mut self, place: usize, numbers: &[f64]) {
                let mut numbers = numbers.iter();
                $($(if let Some(values) = Column::values_mut(&mut self.$column) {
                    let _: [&str; _] = [$($name),+];
                    for (own, number) in values[place].numbers_mut().iter_mut().zip(&mut numbers) {
                        *own = *number;
                    }
                })?)+
            }
        }
    };
}

pub(super) use columns;

#[cfg(test)]
mod tests {
    use super::*;

    columns! {
        /// A store with an optional column.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct Rods {
            pub position: Vec<Vector3<f64>> => ["x", "y", "z"],
            pub length: Vec<f64>,
            pub spin: Option<Vec<Vector3<f64>>> => ["wx", "wy", "wz"],
        }
    }

    fn three(spinning: bool) -> Rods {
        let mut rods = Rods { spin: spinning.then(Vec::new), ..Rods::default() };
        for k in 0..3 {
            rods.grow();
            rods.length[k] = k as f64;
            let numbers = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|n| n + 10.0 * k as f64);
            rods.set_state(k, &numbers);
        }
        rods
    }

    #[test]
    fn every_operation_reaches_every_column() {
        let mut rods = three(true);
        assert_eq!(rods.state_names(), ["x", "y", "z", "wx", "wy", "wz"]);
        rods.reorder(&[2, 0, 1]);
        assert_eq!(rods.length, [2.0, 0.0, 1.0]);
        assert_eq!(rods.state_numbers(0), [21.0, 22.0, 23.0, 24.0, 25.0, 26.0]);
        let mut copy = Rods { spin: Some(Vec::new()), ..Rods::default() };
        copy.copy_from(&rods, &[1, 1]);
        assert_eq!(copy.state_numbers(1), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!((copy.length.len(), copy.spin.as_ref().map(Vec::len)), (2, Some(2)));
        assert!(copy.is_whole(2) && !copy.is_whole(3));
        let mut sent = Rods { spin: Some(Vec::new()), ..Rods::default() };
        let packed = |rods: &Rods, places: &[u32]| {
            let mut bytes = Vec::new();
            rods.pack(places, &mut bytes);
            bytes
        };
        let bytes = packed(&copy, &[0, 1]);
        assert_eq!((sent.unpack(&bytes), &sent), (Some(()), &copy));
        assert_eq!(sent.clone().unpack(&bytes[1..]), None);
        assert_eq!(sent.clone().unpack(&bytes[..bytes.len() - 1]), None);
        assert_eq!((sent.unpack(&packed(&rods, &[2])), sent.length.as_slice()), (Some(()), &[0.0, 0.0, 1.0][..]));
        assert_eq!(sent.state_numbers(2), rods.state_numbers(2));
        sent.relocate(&[(2, 0)]);
        assert_eq!((sent.length.as_slice(), sent.state_numbers(0)), (&[1.0, 0.0, 1.0][..], rods.state_numbers(2)));
        let room = |rods: &Rods| {
            let spin = rods.spin.as_ref().map_or(0, Vec::capacity);
            [rods.position.capacity(), rods.length.capacity(), spin]
        };
        sent.reserve(100);
        assert!(room(&sent).iter().all(|room| *room >= 103) && sent.is_whole(3));
        sent.shrink();
        assert!(room(&sent).iter().all(|room| *room < 103) && sent.length == [1.0, 0.0, 1.0]);
        let mut first = copy.clone();
        first.truncate(1);
        assert!(first.is_whole(1));
        copy.spin = Some(Vec::new());
        assert!(!copy.is_whole(2), "a column too short");
        copy.clear();
        assert_eq!((copy.position.len(), copy.length.len(), copy.spin), (0, 0, Some(Vec::new())));
    }

    #[test]
    fn a_column_that_is_not_needed_is_not_there() {
        let mut rods = three(false);
        assert_eq!(rods.state_names(), ["x", "y", "z"]);
        rods.reorder(&[1, 2, 0]);
        assert_eq!(rods.state_numbers(2), [1.0, 2.0, 3.0]);
        let mut copy = Rods::default();
        copy.copy_from(&rods, &[0, 2]);
        rods.clear();
        assert_eq!((rods.spin, copy.spin, copy.length), (None, None, vec![1.0, 0.0]));
    }
}
