//! Columns of a particle store, declared once.
//!
//! The macro [`columns`] makes a struct of arrays, and everything that has to be done with each of its columns, from
//! one list. A column that only some laws need is an `Option<Vec<T>>`: where it is `None` it takes no memory and every
//! operation leaves it out. A store that has no such column takes it over from one that it copies from, with zeros for
//! the particles it has already.
//!
//! What moves is marked `as moving`, and `as moving by kicks` where forces change it at once. From these marks follow
//! `Motion`, the moving state of one particle, and all that takes, puts, sends, keeps or checks it. Nothing else lists
//! what moves.

use super::CHUNK;
use super::values::AsBytes;
use crate::work_sharing;

/// Operations on one column of a store.
pub trait Column {
    /// Type of one value.
    type Value: Copy + Default + AsBytes + Send + Sync;

    /// True if stores may lack the column.
    const IS_OPTIONAL: bool;

    /// Values that follow one another, to be changed; nothing of a column that is not there.
    type Chunk<'a>
    where
        Self: 'a;

    /// The values, if there is such a column.
    fn values(&self) -> Option<&Vec<Self::Value>>;

    /// The values for changes, if there is such a column.
    fn values_mut(&mut self) -> Option<&mut Vec<Self::Value>>;

    /// All values, to be changed.
    fn whole(&mut self) -> Self::Chunk<'_>;

    /// Takes the first `count` values, or all there are, out of a chunk.
    fn split<'a>(rest: &mut Self::Chunk<'a>, count: usize) -> Self::Chunk<'a>
    where
        Self: 'a;

    /// Changes the value at an index of a chunk.
    fn put(chunk: &mut Self::Chunk<'_>, index: usize, value: Self::Value);

    /// Makes the column, with `count` values of 0, if it is missing and `wanted`.
    fn adopt(&mut self, wanted: bool, count: usize);

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

    /// Appends the values of a column like it that stand at those places; `count` are in the store already.
    fn copy_from(&mut self, other: &Self, places: &[u32], count: usize) {
        self.adopt(other.values().is_some(), count);
        let Some(own) = self.values_mut() else { return };
        match other.values() {
            Some(values) => own.extend(places.iter().map(|&place| values[place as usize])),
            None => own.resize(own.len() + places.len(), Self::Value::default()),
        }
    }

    /// Moves each value from the first index of a pair to the second.
    fn relocate(&mut self, moves: &[(u32, u32)]) {
        if let Some(values) = self.values_mut() {
            moves.iter().for_each(|&(from, to)| values[to as usize] = values[from as usize]);
        }
    }

    /// [bytes] that so many values take, behind a byte that says whether there are any.
    fn packed_size(&self, count: usize) -> usize {
        1 + self.values().map_or(0, |_| count * Self::Value::SIZE)
    }

    /// Appends the values at those places to bytes, behind a byte that says whether there are any.
    fn pack(&self, places: &[u32], bytes: &mut Vec<u8>) {
        bytes.push(u8::from(self.values().is_some()));
        if let Some(values) = self.values() {
            places.iter().for_each(|&place| values[place as usize].pack(bytes));
        }
    }

    /// Appends `count` values from the beginning of bytes that a column like it has packed, and returns the rest;
    /// `None` if they are too few. `before` are in the store already.
    fn unpack<'a>(&mut self, bytes: &'a [u8], count: usize, before: usize) -> Option<&'a [u8]> {
        let (is_there, rest) = bytes.split_first()?;
        if *is_there > 1 || (*is_there == 0 && !Self::IS_OPTIONAL) {
            return None;
        }
        self.adopt(*is_there == 1, before);
        let Some(values) = self.values_mut() else { return Some(rest) };
        if *is_there == 0 {
            // a column that is always there has shown that there are bytes for so many
            values.resize(values.len() + count, Self::Value::default());
            return Some(rest);
        }
        let (own, rest) = rest.split_at_checked(Self::Value::SIZE.checked_mul(count)?)?;
        values.extend(own.chunks_exact(Self::Value::SIZE).map(Self::Value::unpack));
        Some(rest)
    }

    /// Reads the value at a place from the beginning of bytes and returns the rest; `None` if they are too few.
    fn unpack_at<'a>(&mut self, place: usize, bytes: &'a [u8]) -> Option<&'a [u8]> {
        let Some(values) = self.values_mut() else { return Some(bytes) };
        let (own, rest) = bytes.split_at_checked(Self::Value::SIZE)?;
        *values.get_mut(place)? = Self::Value::unpack(own);
        Some(rest)
    }
}

/// Takes the first `count` values, or all there are, out of a slice.
fn split_slice<'a, T>(rest: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let all = std::mem::take(rest);
    let (first, others) = all.split_at_mut(count.min(all.len()));
    *rest = others;
    first
}

impl<T: Copy + Default + AsBytes + Send + Sync> Column for Vec<T> {
    const IS_OPTIONAL: bool = false;
    type Value = T;
    type Chunk<'a>
        = &'a mut [T]
    where
        T: 'a;

    fn whole(&mut self) -> &mut [T] {
        self
    }

    fn split<'a>(rest: &mut &'a mut [T], count: usize) -> &'a mut [T]
    where
        T: 'a,
    {
        split_slice(rest, count)
    }

    #[inline(always)]
    fn put(chunk: &mut &mut [T], index: usize, value: T) {
        chunk[index] = value;
    }

    fn values(&self) -> Option<&Vec<T>> {
        Some(self)
    }

    fn values_mut(&mut self) -> Option<&mut Vec<T>> {
        Some(self)
    }

    fn adopt(&mut self, _wanted: bool, _count: usize) {}
}

impl<T: Copy + Default + AsBytes + Send + Sync> Column for Option<Vec<T>> {
    const IS_OPTIONAL: bool = true;
    type Value = T;
    type Chunk<'a>
        = Option<&'a mut [T]>
    where
        T: 'a;

    fn whole(&mut self) -> Option<&mut [T]> {
        self.as_deref_mut()
    }

    fn split<'a>(rest: &mut Option<&'a mut [T]>, count: usize) -> Option<&'a mut [T]>
    where
        T: 'a,
    {
        rest.as_mut().map(|rest| split_slice(rest, count))
    }

    #[inline(always)]
    fn put(chunk: &mut Option<&mut [T]>, index: usize, value: T) {
        if let Some(values) = chunk {
            values[index] = value;
        }
    }

    fn values(&self) -> Option<&Vec<T>> {
        self.as_ref()
    }

    fn values_mut(&mut self) -> Option<&mut Vec<T>> {
        self.as_mut()
    }

    fn adopt(&mut self, wanted: bool, count: usize) {
        if self.is_none() && wanted {
            *self = Some(vec![T::default(); count]);
        }
    }
}

/// Makes a store, and the moving state of one of its particles, from a list of columns. `=> ["x", "y", "z"]` behind a
/// column says that it belongs to a saved state, as numbers of these names; `as moving` that it moves, `by kicks` that
/// forces change it at once.
macro_rules! columns {
    (
        $(#[$of_motion:meta])*
        pub struct $motion:ident;

        $(#[$of_chunk:meta])*
        pub struct $chunk:ident;

        $(#[$of_store:meta])*
        pub struct $store:ident {
            $(
                $(#[$of_column:meta])*
                pub $column:ident: $kind:ty $(=> [$($name:literal),+])? $(as $moving:ident $(by $kicks:ident)?)?,
            )+
        }
    ) => {
        $(#[$of_motion])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $motion {
            $($(
                #[doc = concat!("The ", stringify!($moving), " column `", stringify!($column), "` of a particle, in its unit.")]
                pub $column: <$kind as Column>::Value,
            )?)+
        }

        $(#[$of_chunk])*
        pub struct $chunk<'a> {
            $($(
                #[doc = concat!("The ", stringify!($moving), " column `", stringify!($column), "` of these particles, in its unit.")]
                pub $column: <$kind as Column>::Chunk<'a>,
            )?)+
        }

        impl $chunk<'_> {
            /// Gives the particle at an index of the chunk a moving state.
            #[inline(always)]
            pub fn set(&mut self, index: usize, motion: &$motion) {
                $($(
                    let _ = stringify!($moving);
                    <$kind as Column>::put(&mut self.$column, index, motion.$column);
                )?)+
            }
        }

        impl $store {
            /// Moving state of all particles, in chunks of that many which can be changed beside one another.
            pub fn motion_chunks(&mut self, size: usize) -> Vec<$chunk<'_>> {
                let chunks = self.count().div_ceil(size);
                let mut rest = $chunk {
                    $($($column: {
                        let _ = stringify!($moving);
                        Column::whole(&mut self.$column)
                    },)?)+
                };
                let next = |_| $chunk {
                    $($($column: {
                        let _ = stringify!($moving);
                        <$kind as Column>::split(&mut rest.$column, size)
                    },)?)+
                };
                (0..chunks).map(next).collect()
            }

            /// Moving state of the particle at an index; 0 in columns that the store has not.
            #[inline]
            pub fn motion(&self, index: usize) -> $motion {
                $motion {
                    $($(
                        $column: {
                            let _ = stringify!($moving);
                            Column::values(&self.$column).map_or_else(Default::default, |values| values[index])
                        },
                    )?)+
                }
            }

            /// Gives the particle at an index a moving state.
            #[inline]
            pub fn set_motion(&mut self, index: usize, motion: &$motion) {
                $($(
                    let _ = stringify!($moving);
                    if let Some(values) = Column::values_mut(&mut self.$column) {
                        values[index] = motion.$column;
                    }
                )?)+
            }

            /// Calls `visit` with every number of the moving state of the particle at an index. A zero of a column that
            /// stores may lack counts as none: a state of spheres that could rotate and do not is the state of spheres
            /// that cannot.
            pub(crate) fn for_each_moving_number(&self, index: usize, visit: &mut impl FnMut(f64)) {
                $($(
                    let _ = stringify!($moving);
                    if let Some(values) = Column::values(&self.$column) {
                        let numbers = values[index].numbers();
                        if !(<$kind as Column>::IS_OPTIONAL && numbers.iter().all(|number| *number == 0.0)) {
                            numbers.iter().for_each(|number| visit(*number));
                        }
                    }
                )?)+
            }

            /// Appends the moving state of the particle at an index to bytes.
            pub(crate) fn pack_motion(&self, index: usize, bytes: &mut Vec<u8>) {
                $($(
                    let _ = stringify!($moving);
                    if let Some(values) = Column::values(&self.$column) {
                        AsBytes::pack(&values[index], bytes);
                    }
                )?)+
            }

            /// Reads the moving state of the particle at an index from the beginning of bytes that a store with the
            /// same columns has packed, and returns the rest; `None` if they are too few.
            pub(crate) fn unpack_motion<'a>(&mut self, index: usize, bytes: &'a [u8]) -> Option<&'a [u8]> {
                $($(
                    let _ = stringify!($moving);
                    let bytes = Column::unpack_at(&mut self.$column, index, bytes)?;
                )?)+
                Some(bytes)
            }

            /// Appends what forces change at once of the particle at an index to bytes.
            pub(crate) fn pack_kicked(&self, index: usize, bytes: &mut Vec<u8>) {
                $($($(
                    let _ = stringify!($kicks);
                    if let Some(values) = Column::values(&self.$column) {
                        AsBytes::pack(&values[index], bytes);
                    }
                )?)?)+
            }

            /// Reads what [`pack_kicked`](Self::pack_kicked) wrote; `None` if the bytes are too few.
            pub(crate) fn unpack_kicked<'a>(&mut self, index: usize, bytes: &'a [u8]) -> Option<&'a [u8]> {
                $($($(
                    let _ = stringify!($kicks);
                    let bytes = Column::unpack_at(&mut self.$column, index, bytes)?;
                )?)?)+
                Some(bytes)
            }

            /// Keeps what forces change at once, of all particles, in a store that holds nothing else.
            pub(crate) fn keep_kicked(&self, kept: &mut Self) {
                $($($(
                    let _ = stringify!($kicks);
                    kept.$column.clone_from(&self.$column);
                )?)?)+
            }

            /// Takes back what forces have changed since [`keep_kicked`](Self::keep_kicked); `kept` then holds what
            /// they had made of it.
            pub(crate) fn take_back(&mut self, kept: &mut Self) {
                $($($(
                    let _ = stringify!($kicks);
                    std::mem::swap(&mut self.$column, &mut kept.$column);
                )?)?)+
            }
        }

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

            /// Number of particles, by the first column.
            fn count(&self) -> usize {
                [$(Column::values(&self.$column).map(Vec::len)),+].into_iter().flatten().next().unwrap_or(0)
            }

            /// Takes out all particles from the place `count` on.
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
                let count = self.count();
                $(Column::copy_from(&mut self.$column, &other.$column, places, count);)+
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
                // no more room than it takes: of millions that matters
                bytes.reserve_exact(size_of::<u64>() $(+ Column::packed_size(&self.$column, places.len()))+);
                bytes.extend_from_slice(&(places.len() as u64).to_le_bytes());
                $(Column::pack(&self.$column, places, bytes);)+
            }

            /// Appends all particles of bytes that such a store has packed; `None` if these are not of one.
            pub(crate) fn unpack(&mut self, bytes: &[u8]) -> Option<()> {
                let (count, bytes) = bytes.split_first_chunk()?;
                let (count, before) = (u64::from_le_bytes(*count) as usize, self.count());
                $(let bytes = Column::unpack(&mut self.$column, bytes, count, before)?;)+
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
mod tests;
