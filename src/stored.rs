//! Data of an engine or an observer as bytes, so that they can be kept beside the state of the particles.
//!
//! Only the type that wrote the bytes can read them. The format is that of `postcard`: numbers keep all of their
//! bits, and the bytes do not describe their own meaning. Code that writes them to a file adds a version and a
//! checksum.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// The data of one engine or observer.
///
/// ```
/// use diptych::Stored;
///
/// let stored = Stored::of(&(7_u32, 0.1_f64))?;
/// assert_eq!(stored.read::<(u32, f64)>()?, (7, 0.1));
/// assert!(stored.read::<(f64, f64, f64)>().is_err());
/// # Ok::<(), diptych::StoreError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stored(Vec<u8>);

/// Data that cannot be stored, or bytes that are not those of the data asked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("stored data do not fit: {0}")]
pub struct StoreError(#[from] postcard::Error);

impl StoreError {
    /// The error for data that can be read but belong to something else.
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
    /// The bytes.
    pub fn as_bytes(&self) -> &[u8] {
        &self.0
    }

    /// Stores a value.
    ///
    /// # Errors
    /// If the type has a part whose length or shape is not known beforehand; no type that derives `Serialize` plainly
    /// has such a part.
    pub fn of<T: Serialize + ?Sized>(value: &T) -> Result<Self, StoreError> {
        Ok(Self(postcard::to_stdvec(value)?))
    }

    /// The value, of the type that was stored.
    ///
    /// # Errors
    /// If the bytes cannot be those of such a value, or are more than it needs.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, StoreError> {
        let (value, rest) = postcard::take_from_bytes(&self.0)?;
        if rest.is_empty() { Ok(value) } else { Err(StoreError::misfit()) }
    }
}
