//! Format of a checkpoint file: an identifying first line, the version of the program, the data, and a checksum.

use crate::stored::{StoreError, Stored};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// First bytes of every checkpoint file, by which such a file is recognized.
const MAGIC: &[u8] = b"diptych checkpoint\n";

/// Version of the layout of the data. This number must be raised whenever a stored type changes, because the file does
/// not describe its types. It must also be raised if the arithmetic of a run changes, because a continued run must
/// give the results of an uninterrupted one.
const LAYOUT: u32 = 45;

/// Length of the checksum at the end of a file, in bytes.
const CHECKSUM: usize = size_of::<u32>();

/// Reason why a file of a checkpoint cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum Unreadable {
    /// The operating system cannot read the file.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// The first bytes are not those of a checkpoint.
    #[error("is no checkpoint")]
    Foreign,
    /// The file has been cut short or changed.
    #[error("is damaged: its checksum does not fit")]
    Damaged,
    /// The file was written by another version of the program, or on another system.
    #[error("was written by {theirs}, and this is {ours}")]
    OtherProgram {
        /// Version of the program that wrote the file.
        theirs: String,
        /// Version of the program that is running.
        ours: String,
    },
    /// The data are not of the expected type.
    #[error("does not hold what it should: {0}")]
    Unfit(#[from] StoreError),
}

/// Text in every checkpoint file that identifies the version of the program, the system, and the layout of the data.
fn program() -> String {
    let (version, system, machine) = (env!("CARGO_PKG_VERSION"), std::env::consts::OS, std::env::consts::ARCH);
    format!("diptych {version} on {system} {machine}, layout {LAYOUT}")
}

/// Makes the bytes of a checkpoint file that contains the data of `value`.
///
/// # Errors
/// Returns the errors of [`Stored::of`].
pub fn seal<T: Serialize>(value: &T) -> Result<Vec<u8>, StoreError> {
    let mut bytes = [MAGIC, program().as_bytes(), b"\n"].concat();
    bytes.extend_from_slice(Stored::of(value)?.as_bytes());
    let checksum = crc32fast::hash(&bytes);
    bytes.extend_from_slice(&checksum.to_le_bytes());
    Ok(bytes)
}

/// Reads the value stored in the bytes of a checkpoint file.
///
/// # Errors
/// Returns an [`Unreadable`] if the bytes are incomplete or changed, were written by another program, or contain a
/// value of another type.
pub fn open<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Unreadable> {
    if !bytes.starts_with(MAGIC) {
        // a file that contains only a part of the first line counts as damaged
        return Err(if MAGIC.starts_with(bytes) { Unreadable::Damaged } else { Unreadable::Foreign });
    }
    let Some((whole, checksum)) = bytes.split_last_chunk::<CHECKSUM>() else { return Err(Unreadable::Damaged) };
    if crc32fast::hash(whole) != u32::from_le_bytes(*checksum) {
        return Err(Unreadable::Damaged);
    }
    let rest = whole.get(MAGIC.len()..).unwrap_or_default();
    let Some(end) = rest.iter().position(|&byte| byte == b'\n') else { return Err(Unreadable::Damaged) };
    let (theirs, ours) = (String::from_utf8_lossy(&rest[..end]).into_owned(), program());
    if theirs != ours {
        return Err(Unreadable::OtherProgram { theirs, ours });
    }
    Ok(Stored::from(rest[end + 1..].to_vec()).read()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flipped_bit_and_every_truncation_is_noticed() {
        let value = (3_u64, "a name".to_owned(), vec![0.1_f64, f64::NEG_INFINITY]);
        let sealed = seal(&value).unwrap();
        assert_eq!(open::<(u64, String, Vec<f64>)>(&sealed).unwrap(), value);
        for place in 0..sealed.len() {
            assert!(open::<(u64, String, Vec<f64>)>(&sealed[..place]).is_err(), "cut at {place}");
            for bit in 0..8 {
                let mut flipped = sealed.clone();
                flipped[place] ^= 1 << bit;
                let why = open::<(u64, String, Vec<f64>)>(&flipped).unwrap_err();
                assert!(matches!(why, Unreadable::Damaged | Unreadable::Foreign), "{place}, {bit}: {why}");
            }
        }
    }

    #[test]
    fn other_programs_and_other_data_are_named() {
        let whole = seal(&1_u8).unwrap();
        let mut other = whole[..whole.len() - CHECKSUM].to_vec();
        let version = MAGIC.len() + "diptych ".len();
        other[version] = b'9';
        other.extend_from_slice(&crc32fast::hash(&other).to_le_bytes());
        let why = open::<u8>(&other).unwrap_err().to_string();
        assert!(why.contains("diptych 9.") && why.contains(env!("CARGO_PKG_VERSION")), "{why}");
        assert!(matches!(open::<u64>(&seal(&[9_u8; 3]).unwrap()), Err(Unreadable::Unfit(_))));
        assert!(matches!(open::<u8>(b"x,y,z\n"), Err(Unreadable::Foreign)));
    }
}
