//! Columns of a store, declared once.
//!
//! The macro [`columns`] makes a struct of arrays, and everything that has to be done with each of its columns, from one list.
//! A column that only some laws need is an `Option<Vec<T>>`: where it is `None` it takes no memory and every operation
//! leaves it out.

use super::CHUNK;
use crate::work_sharing;
use nalgebra::Vector3;

/// What is done with each column of a store.
pub trait Column {
    /// One value of it.
    type Value: Copy + Default + AsBytes + Send + Sync;

    /// The values, if there is such a column.
    fn values(&self) -> Option<&Vec<Self::Value>>;

    /// The values, if there is such a column.
    fn values_mut(&mut self) -> Option<&mut Vec<Self::Value>>;

    /// Puts the value that stands at `order[k]` at place `k`, for every `k`.
    fn reorder(&mut self, order: &[u32]) {
        if let Some(values) = self.values_mut() {
            let mut anew = vec![Self::Value::default(); order.len()];
            work_sharing::for_each(anew.chunks_mut(CHUNK).zip(order.chunks(CHUNK)), |(anew, order)| {
                anew.iter_mut().zip(order).for_each(|(value, &from)| *value = values[from as usize]);
            });
            *values = anew;
        }
    }

    /// Appends the values of a column like it that stand at those places.
    fn copy_from(&mut self, other: &Self, places: &[u32]) {
        if let (Some(own), Some(values)) = (self.values_mut(), other.values()) {
            own.extend(places.iter().map(|&place| values[place as usize]));
        }
    }

    /// Moves each value that stands at the first place of a pair to the second.
    fn relocate(&mut self, moves: &[(u32, u32)]) {
        if let Some(values) = self.values_mut() {
            moves.iter().for_each(|&(from, to)| values[to as usize] = values[from as usize]);
        }
    }

    /// [bytes] that so many values take, behind their number.
    fn packed_size(&self, count: usize) -> usize {
        self.values().map_or(0, |_| size_of::<u64>() + count * Self::Value::SIZE)
    }

    /// Appends the values at those places to bytes, behind their number.
    fn pack(&self, places: &[u32], bytes: &mut Vec<u8>) {
        if let Some(values) = self.values() {
            bytes.extend_from_slice(&(places.len() as u64).to_le_bytes());
            places.iter().for_each(|&place| values[place as usize].pack(bytes));
        }
    }

    /// Appends the values from the beginning of bytes that a column like it has packed, and returns the rest; `None` if they are too few.
    fn unpack<'a>(&mut self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        let Some(values) = self.values_mut() else { return Some(bytes) };
        let (count, rest) = bytes.split_first_chunk()?;
        let (own, rest) = rest.split_at_checked(Self::Value::SIZE.checked_mul(u64::from_le_bytes(*count) as usize)?)?;
        values.extend(own.chunks_exact(Self::Value::SIZE).map(Self::Value::unpack));
        Some(rest)
    }
}

/// A value that goes from process to process as it stands in memory: of a million particles text or numbers of variable length would take
/// longer than the way.
pub trait AsBytes: Sized {
    /// [bytes] that it takes.
    const SIZE: usize;

    /// Appends it to bytes.
    fn pack(&self, bytes: &mut Vec<u8>);

    /// Reads it from so many bytes as it takes.
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

/// A value that is written as one or several numbers.
pub trait AsNumbers {
    /// They, in the order of the names that the column is declared with.
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

/// Makes a store from a list of its columns; `=> ["x", "y", "z"]` behind one says that it belongs to a saved state, as numbers
/// of these names.
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
            /// Takes all particles out and keeps the memory.
            pub fn clear(&mut self) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.clear();
                })+
            }

            /// Takes out all particles from the place `count` on.
            pub fn truncate(&mut self, count: usize) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.truncate(count);
                })+
            }

            /// Whether every column that is kept has one value for each of `count` particles.
            pub(crate) fn is_whole(&self, count: usize) -> bool {
                $(Column::values(&self.$column).is_none_or(|values| values.len() == count))&&+
            }

            /// Appends one whose values are all 0.
            fn grow(&mut self) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.push(Default::default());
                })+
            }

            /// Puts the particle that stands at `order[k]` at place `k`, for every `k`; `order` is a permutation of 0 .. N, or a part of
            /// one: the others are taken out.
            pub fn reorder(&mut self, order: &[u32]) {
                $(Column::reorder(&mut self.$column, order);)+
            }

            /// Appends copies of the particles that stand at those places of another store with the same columns.
            pub fn copy_from(&mut self, other: &Self, places: &[u32]) {
                $(Column::copy_from(&mut self.$column, &other.$column, places);)+
            }

            /// Takes room for `count` particles more, and not for others.
            pub(crate) fn reserve(&mut self, count: usize) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.reserve_exact(count);
                })+
            }

            /// Gives back the room that it does not need.
            pub(crate) fn shrink(&mut self) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.shrink_to_fit();
                })+
            }

            /// Moves each particle that stands at the first place of a pair to the second, whose own is overwritten.
            pub(crate) fn relocate(&mut self, moves: &[(u32, u32)]) {
                $(Column::relocate(&mut self.$column, moves);)+
            }

            /// Appends the particles at those places to bytes.
            pub(crate) fn pack(&self, places: &[u32], bytes: &mut Vec<u8>) {
                // no more room than it takes: of millions that matters
                bytes.reserve_exact(0 $(+ Column::packed_size(&self.$column, places.len()))+);
                $(Column::pack(&self.$column, places, bytes);)+
            }

            /// Appends all particles of bytes that a store with the same columns has packed; `None` if these are not of one.
            pub(crate) fn unpack(&mut self, bytes: &[u8]) -> Option<()> {
                $(let bytes = Column::unpack(&mut self.$column, bytes)?;)+
                bytes.is_empty().then_some(())
            }

            /// Names of the numbers of a particle that a saved state holds.
            pub fn state_names(&self) -> Vec<&'static str> {
                let mut names = Vec::new();
                $($(if Column::values(&self.$column).is_some() {
                    names.extend([$($name),+]);
                })?)+
                names
            }

            /// The numbers of these names [SI] of the particle at `place`.
            pub fn state_numbers(&self, place: usize) -> Vec<f64> {
                let mut numbers = Vec::new();
                $($(if let Some(values) = Column::values(&self.$column) {
                    let _: [&str; _] = [$($name),+];
                    numbers.extend_from_slice(values[place].clone().numbers_mut());
                })?)+
                numbers
            }

            /// Gives the particle at `place` the numbers [SI] of these names.
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
        /// A store with a column that not all need.
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
