//! Columns of a particle store, all declared in one list.
//!
//! The macro [`columns`] makes a struct of arrays, and all operations on it, from a list of columns. A column that
//! only some laws need is an `Option<Vec<T>>`. With `None` the column takes no memory, and operations skip it. If a
//! store without such a column copies particles from a store with the column, the column is added. The particles that
//! were in the store before then have zeros in the added column.
//!
//! Columns of quantities that change with time are marked `as moving`. Columns of quantities that forces change
//! directly (velocity and spin) are marked `as moving by kicks`. From these marks the macro makes `Motion`, the moving
//! state of one particle, and all code that reads, sets, sends, saves or checks the moving state. The moving columns
//! are listed nowhere else.

use super::CHUNK;
use super::values::AsBytes;
use crate::work_sharing;

/// Operations on one column (the values of one quantity for all particles) of a particle store.
pub trait Column {
    /// Type of the value of one particle.
    type Value: Copy + Default + AsBytes + Send + Sync;

    /// True if a store may lack the column.
    const IS_OPTIONAL: bool;

    /// Mutable chunk of a column: the values of consecutive particles. It is empty if the store lacks the column.
    type Chunk<'a>
    where
        Self: 'a;

    /// Values of all particles; `None` if the store lacks the column.
    fn values(&self) -> Option<&Vec<Self::Value>>;

    /// Values of all particles, mutable; `None` if the store lacks the column.
    fn values_mut(&mut self) -> Option<&mut Vec<Self::Value>>;

    /// All values of the column as one mutable chunk.
    fn whole(&mut self) -> Self::Chunk<'_>;

    /// Removes the first `count` values from the chunk `rest` and returns them. If `rest` has fewer values, returns
    /// them all.
    fn split<'a>(rest: &mut Self::Chunk<'a>, count: usize) -> Self::Chunk<'a>
    where
        Self: 'a;

    /// Sets the value at an index of a chunk; does nothing if the store lacks the column.
    fn put(chunk: &mut Self::Chunk<'_>, index: usize, value: Self::Value);

    /// Adds the column, with `count` zeros, if the store lacks it and `wanted` is true.
    fn adopt(&mut self, wanted: bool, count: usize);

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

    /// Appends the values at `indices` of the same column of another store, or zeros if that store lacks it. `count` is
    /// the number of particles in this store before the call.
    fn copy_from(&mut self, other: &Self, indices: &[u32], count: usize) {
        self.adopt(other.values().is_some(), count);
        let Some(own) = self.values_mut() else { return };
        match other.values() {
            Some(values) => own.extend(indices.iter().map(|&index| values[index as usize])),
            None => own.resize(own.len() + indices.len(), Self::Value::default()),
        }
    }

    /// Copies, for each pair of indices, the value at the first index to the second index.
    fn relocate(&mut self, moves: &[(u32, u32)]) {
        if let Some(values) = self.values_mut() {
            moves.iter().for_each(|&(from, to)| values[to as usize] = values[from as usize]);
        }
    }

    /// [bytes] size of `count` packed values, plus a byte that states whether the column exists.
    fn packed_size(&self, count: usize) -> usize {
        1 + self.values().map_or(0, |_| count * Self::Value::SIZE)
    }

    /// Appends to `bytes` a byte that states whether the column exists, and then the values at `indices`.
    fn pack(&self, indices: &[u32], bytes: &mut Vec<u8>) {
        bytes.push(u8::from(self.values().is_some()));
        if let Some(values) = self.values() {
            indices.iter().for_each(|&index| values[index as usize].pack(bytes));
        }
    }

    /// Appends `count` values that [`pack`](Self::pack) has written at the beginning of `bytes`; zeros if `pack` wrote
    /// none. Returns the remaining bytes, or `None` if `bytes` cannot be a result of `pack`. `before` is the number of
    /// particles in this store before the call.
    fn unpack<'a>(&mut self, bytes: &'a [u8], count: usize, before: usize) -> Option<&'a [u8]> {
        let (is_there, rest) = bytes.split_first()?;
        if *is_there > 1 || (*is_there == 0 && !Self::IS_OPTIONAL) {
            return None;
        }
        self.adopt(*is_there == 1, before);
        let Some(values) = self.values_mut() else { return Some(rest) };
        if *is_there == 0 {
            // columns that are not optional were read before, so `bytes` contained at least `count` values of them
            values.resize(values.len() + count, Self::Value::default());
            return Some(rest);
        }
        let (own, rest) = rest.split_at_checked(Self::Value::SIZE.checked_mul(count)?)?;
        values.extend(own.chunks_exact(Self::Value::SIZE).map(Self::Value::unpack));
        Some(rest)
    }

    /// Reads the value of the particle at `index` from the beginning of `bytes`, if the store has the column. Returns
    /// the remaining bytes, or `None` if there are too few bytes or no such particle.
    fn unpack_at<'a>(&mut self, index: usize, bytes: &'a [u8]) -> Option<&'a [u8]> {
        let Some(values) = self.values_mut() else { return Some(bytes) };
        let (own, rest) = bytes.split_at_checked(Self::Value::SIZE)?;
        *values.get_mut(index)? = Self::Value::unpack(own);
        Some(rest)
    }
}

/// Removes the first `count` values from the slice `rest` and returns them. If `rest` has fewer values, returns them
/// all.
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

/// Makes a particle store, and a type for the values of one particle that change with time (its moving state), from a
/// list of columns. `=> ["x", "y", "z"]` after a column means that saved states contain the column, as numbers with
/// these names. `as moving` means that the values change with time. `by kicks` means that forces change the values
/// directly.
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
            /// Sets the moving state (values that change with time) of the particle at an index of the chunk.
            #[inline(always)]
            pub fn set(&mut self, index: usize, motion: &$motion) {
                $($(
                    let _ = stringify!($moving);
                    <$kind as Column>::put(&mut self.$column, index, motion.$column);
                )?)+
            }
        }

        impl $store {
            /// Moving state (values that change with time) of all particles, in chunks of `size` particles. Several
            /// threads can change different chunks at the same time.
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

            /// Moving state (values that change with time) of a particle; 0 in columns that the store lacks.
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

            /// Sets the moving state (values that change with time) of the particle at an index.
            #[inline]
            pub fn set_motion(&mut self, index: usize, motion: &$motion) {
                $($(
                    let _ = stringify!($moving);
                    if let Some(values) = Column::values_mut(&mut self.$column) {
                        values[index] = motion.$column;
                    }
                )?)+
            }

            /// Calls `visit` with every number of the moving state of the particle at an index. An optional column is
            /// skipped where its value is zero. Spheres that can rotate but have no spin therefore have the same
            /// checksum as spheres that cannot rotate.
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

            /// Appends the moving state (values that change with time) of a particle to `bytes`.
            pub(crate) fn pack_motion(&self, index: usize, bytes: &mut Vec<u8>) {
                $($(
                    let _ = stringify!($moving);
                    if let Some(values) = Column::values(&self.$column) {
                        AsBytes::pack(&values[index], bytes);
                    }
                )?)+
            }

            /// Reads the moving state (values that change with time) of a particle from the beginning of `bytes`.
            /// Returns the remaining bytes, or `None` if there are too few. The bytes must come from a store with the
            /// same columns.
            pub(crate) fn unpack_motion<'a>(&mut self, index: usize, bytes: &'a [u8]) -> Option<&'a [u8]> {
                $($(
                    let _ = stringify!($moving);
                    let bytes = Column::unpack_at(&mut self.$column, index, bytes)?;
                )?)+
                Some(bytes)
            }

            /// Appends to `bytes` the quantities of one particle that forces change directly (velocity and spin).
            pub(crate) fn pack_kicked(&self, index: usize, bytes: &mut Vec<u8>) {
                $($($(
                    let _ = stringify!($kicks);
                    if let Some(values) = Column::values(&self.$column) {
                        AsBytes::pack(&values[index], bytes);
                    }
                )?)?)+
            }

            /// Sets velocity and spin of one particle from bytes that [`pack_kicked`](Self::pack_kicked) has written.
            /// Returns the remaining bytes, or `None` if there are too few.
            pub(crate) fn unpack_kicked<'a>(&mut self, index: usize, bytes: &'a [u8]) -> Option<&'a [u8]> {
                $($($(
                    let _ = stringify!($kicks);
                    let bytes = Column::unpack_at(&mut self.$column, index, bytes)?;
                )?)?)+
                Some(bytes)
            }

            /// Copies the columns that forces change directly (velocity and spin), of all particles, to `kept`. The
            /// other columns of `kept` do not change.
            pub(crate) fn keep_kicked(&self, kept: &mut Self) {
                $($($(
                    let _ = stringify!($kicks);
                    kept.$column.clone_from(&self.$column);
                )?)?)+
            }

            /// Restores the columns that [`keep_kicked`](Self::keep_kicked) has copied, by an exchange with `kept`.
            /// `kept` then contains the values of this store before the call.
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
            /// Removes all particles; the allocated memory remains for later use.
            pub fn clear(&mut self) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.clear();
                })+
            }

            /// Number of particles: the length of the first column in use.
            fn count(&self) -> usize {
                [$(Column::values(&self.$column).map(Vec::len)),+].into_iter().flatten().next().unwrap_or(0)
            }

            /// Removes all particles whose index is `count` or more.
            pub fn truncate(&mut self, count: usize) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.truncate(count);
                })+
            }

            /// True if every column in use has one value for each of `count` particles.
            pub(crate) fn is_whole(&self, count: usize) -> bool {
                $(Column::values(&self.$column).is_none_or(|values| values.len() == count))&&+
            }

            /// Appends one particle with zero in every column.
            fn grow(&mut self) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.push(Default::default());
                })+
            }

            /// Moves the particle at index `order[k]` to index `k`, for every `k`. `order` contains each index at most
            /// once. Particles whose index is missing from `order` are removed.
            pub fn reorder(&mut self, order: &[u32]) {
                $(Column::reorder(&mut self.$column, order);)+
            }

            /// Appends copies of the particles at the given indices of another store.
            pub fn copy_from(&mut self, other: &Self, indices: &[u32]) {
                let count = self.count();
                $(Column::copy_from(&mut self.$column, &other.$column, indices, count);)+
            }

            /// Reserves memory for exactly `count` more particles.
            pub(crate) fn reserve(&mut self, count: usize) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.reserve_exact(count);
                })+
            }

            /// Frees allocated memory that is not in use.
            pub(crate) fn shrink(&mut self) {
                $(if let Some(values) = Column::values_mut(&mut self.$column) {
                    values.shrink_to_fit();
                })+
            }

            /// Copies, for each pair of indices, the particle at the first index to the second index. The particle at
            /// the second index is overwritten.
            pub(crate) fn relocate(&mut self, moves: &[(u32, u32)]) {
                $(Column::relocate(&mut self.$column, moves);)+
            }

            /// Appends the particles at the given indices to `bytes`.
            pub(crate) fn pack(&self, indices: &[u32], bytes: &mut Vec<u8>) {
                // reserves exactly the bytes needed, because spare capacity would be large for millions of particles
                bytes.reserve_exact(size_of::<u64>() $(+ Column::packed_size(&self.$column, indices.len()))+);
                bytes.extend_from_slice(&(indices.len() as u64).to_le_bytes());
                $(Column::pack(&self.$column, indices, bytes);)+
            }

            /// Appends all particles from `bytes`, which [`pack`](Self::pack) has written. `None` if `bytes` cannot be
            /// a result of `pack`.
            pub(crate) fn unpack(&mut self, bytes: &[u8]) -> Option<()> {
                let (count, bytes) = bytes.split_first_chunk()?;
                let (count, before) = (u64::from_le_bytes(*count) as usize, self.count());
                $(let bytes = Column::unpack(&mut self.$column, bytes, count, before)?;)+
                bytes.is_empty().then_some(())
            }

            /// Names of the numbers that a saved state contains for each particle.
            pub fn state_names(&self) -> Vec<&'static str> {
                let mut names = Vec::new();
                $($(if Column::values(&self.$column).is_some() {
                    names.extend([$($name),+]);
                })?)+
                names
            }

            /// Numbers [SI] of the particle at `index` in a saved state, in the order of
            /// [`state_names`](Self::state_names).
            pub fn state_numbers(&self, index: usize) -> Vec<f64> {
                let mut numbers = Vec::new();
                $($(if let Some(values) = Column::values(&self.$column) {
                    let _: [&str; _] = [$($name),+];
                    numbers.extend_from_slice(values[index].clone().numbers_mut());
                })?)+
                numbers
            }

            /// Sets the numbers [SI] of the particle at `index`, in the order of
            /// [`state_names`](Self::state_names).
            pub fn set_state(&mut self, index: usize, numbers: &[f64]) {
                let mut numbers = numbers.iter();
                $($(if let Some(values) = Column::values_mut(&mut self.$column) {
                    let _: [&str; _] = [$($name),+];
                    for (own, number) in values[index].numbers_mut().iter_mut().zip(&mut numbers) {
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
