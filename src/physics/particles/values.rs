//! Values of the columns of a particle store: as bytes for messages between processes, and as numbers for saved states
//! of a run.

use nalgebra::Vector3;

/// A value that processes send to each other as a fixed number of bytes. For millions of particles, text or an
/// encoding of variable length would take longer than the transfer.
pub trait AsBytes: Sized {
    /// [bytes] size of one value in its packed form.
    const SIZE: usize;

    /// Appends the value to `bytes`.
    fn pack(&self, bytes: &mut Vec<u8>);

    /// Reads the value from `bytes`, whose length must be [`SIZE`](Self::SIZE).
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

/// A value of a column that consists of one number or, for a vector, of three.
pub trait AsNumbers {
    /// The numbers of the value, in the order of the names (such as "x", "y", "z") in the declaration of the column.
    fn numbers(&self) -> &[f64];

    /// Mutable access to the numbers of the value, in the order of [`numbers`](Self::numbers).
    fn numbers_mut(&mut self) -> &mut [f64];
}

impl AsNumbers for f64 {
    fn numbers(&self) -> &[f64] {
        std::slice::from_ref(self)
    }

    fn numbers_mut(&mut self) -> &mut [f64] {
        std::slice::from_mut(self)
    }
}

impl AsNumbers for Vector3<f64> {
    fn numbers(&self) -> &[f64] {
        self.as_slice()
    }

    fn numbers_mut(&mut self) -> &mut [f64] {
        self.as_mut_slice()
    }
}
