//! Header lines of a saved state (`state.csv`), by which a changed file is recognized.
//!
//! The first line contains the number of particles and a checksum of the rest. So a table that was cut short or changed
//! is not accepted as a saved state. The other lines describe the run.

use crate::domain::Domain;

/// Beginning of the first line of a saved state. It begins with `#`, so that readers of CSV take it as a comment.
const BEGIN: &str = "# diptych state: ";

/// Adds the first line, with the number of particles and the checksum, to the table `text`.
pub fn sign(text: &str, particles: usize) -> String {
    format!("{BEGIN}{particles} particles, checksum {:016x}\n{text}", checksum(text))
}

/// Returns true if `text` is an unchanged saved state, false if it does not begin with the first line of a saved state.
///
/// # Errors
/// A message in words: the text does not match the checksum or the number of particles in its first line.
pub fn verify(text: &str) -> Result<bool, String> {
    let Some(signed) = text.strip_prefix(BEGIN) else { return Ok(false) };
    let (line, table) = signed.split_once('\n').unwrap_or((signed, ""));
    let Some((particles, sum)) = line.trim_end().split_once(" particles, checksum ") else {
        return Err("the line of a saved state is damaged: it has no number of particles and checksum".into());
    };
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).flexible(true).from_reader(table.as_bytes());
    let found = reader.records().count();
    if particles.parse() != Ok(found) {
        return Err(format!("the saved state holds {found} particles where its first line says {particles}"));
    }
    if u64::from_str_radix(sum, 16) != Ok(checksum(table)) {
        return Err("the saved state is not as it was written: its checksum does not fit".into());
    }
    Ok(true)
}

/// Pairs of key and value in the lines `# key: value` above the table of a saved state. Files of older versions and
/// tables made by the user have no such lines.
pub fn head(text: &str) -> impl Iterator<Item = (&str, &str)> {
    let lines = text.lines().skip(1).map_while(|line| line.strip_prefix("# "));
    lines.filter_map(|line| line.split_once(": ")).map(|(key, value)| (key, value.trim_end()))
}

/// Lines about the box in the head of a saved state, as pairs of key and value: edges [m] and periodic axes. For a
/// sheared box also the displacement [m] along z of the periodic image one box height above.
pub fn box_lines(domain: &Domain) -> Vec<(&'static str, String)> {
    let axes = ["x", "y", "z"].into_iter().zip(domain.periodic).filter(|(_, periodic)| *periodic).map(|(axis, _)| axis);
    let edges: Vec<String> = domain.size.iter().map(|edge| format!("{edge:?}")).collect();
    let lines = [("box_m", edges.join(" ")), ("periodic", axes.collect::<Vec<_>>().join(" "))].into_iter();
    lines.chain(domain.offset().map(|offset| ("image_offset_m", format!("{offset:?}")))).collect()
}

/// Checksum of a text, such as that of a case: different texts have different checksums, except by a rare chance.
pub fn fingerprint(text: &str) -> u64 {
    checksum(text)
}

/// FNV-1a hash of all bytes except blank space at the end and carriage returns. Changed line ends therefore do not
/// matter.
pub(super) fn checksum(text: &str) -> u64 {
    let bytes = text.trim_end().bytes().filter(|byte| *byte != b'\r');
    // offset basis and prime of the FNV-1a hash (Fowler, Noll & Vo)
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}
