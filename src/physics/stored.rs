//! Data of an engine or an observer as bytes, which a checkpoint stores together with the state of the particles.
//!
//! The bytes can be read only as the type that was stored. The format is that of the library `postcard`: numbers keep
//! all of their bits, and the bytes contain no names or types. Code that writes the bytes to a file adds a version and
//! a checksum.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// The stored data of one engine or observer (measurement during a run), as bytes.
///
/// ```
/// # extern crate diptych_physics as diptych;
/// use diptych::Stored;
///
/// let stored = Stored::of(&(7_u32, 0.1_f64))?;
/// assert_eq!(stored.read::<(u32, f64)>()?, (7, 0.1));
/// assert!(stored.read::<(f64, f64, f64)>().is_err());
/// # Ok::<(), diptych::StoreError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stored(Vec<u8>);

/// Error: data cannot be stored, or bytes do not belong to the requested type.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("stored data do not fit: {0}")]
pub struct StoreError(#[from] postcard::Error);

impl StoreError {
    /// Error for bytes that can be read but do not belong to the requested type.
    pub(crate) fn misfit() -> Self {
        Self(postcard::Error::DeserializeBadEncoding)
    }
}

impl From<Vec<u8>> for Stored {
    fn from(bytes: Vec<u8>) -> Self {
        Self(bytes)
    }
}

impl Stored {
    /// The stored data as bytes, without the type of the value.
    pub fn as_bytes(&self) -> &[u8] {
        &self.0
    }

    /// Stores a value as bytes.
    ///
    /// # Errors
    /// If the value contains a sequence whose length is not known in advance. No type that derives `Serialize` without
    /// further attributes contains one.
    pub fn of<T: Serialize + ?Sized>(value: &T) -> Result<Self, StoreError> {
        Ok(Self(postcard::to_stdvec(value)?))
    }

    /// Reads the stored value; its type `T` must be the type that was stored.
    ///
    /// # Errors
    /// If the bytes cannot be a value of type `T`, or if bytes are left after the value.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, StoreError> {
        let (value, rest) = postcard::take_from_bytes(&self.0)?;
        if rest.is_empty() { Ok(value) } else { Err(StoreError::misfit()) }
    }
}
