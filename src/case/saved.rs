//! The lines above the table of a state that a run has saved.
//!
//! The first line gives the number of particles and a checksum of all the rest. So a table that was cut short or
//! changed is not taken for the state of a run. The other lines describe the run.

use crate::domain::Domain;

/// Beginning of the first line; to readers of CSV it is a comment.
const BEGIN: &str = "# diptych state: ";

/// The table `text` of `particles` particles, below a line with the number of particles and the checksum.
pub fn sign(text: &str, particles: usize) -> String {
    format!("{BEGIN}{particles} particles, checksum {:016x}\n{text}", checksum(text))
}

/// True if `text` is a saved state; a table without the first line was made by the user.
///
/// # Errors
/// In words: the line is there, but the text below does not match its checksum or number of particles.
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

/// The lines `# key: value` above the table of a saved state. Files of older versions and tables made by the user have
/// none.
pub fn head(text: &str) -> impl Iterator<Item = (&str, &str)> {
    let lines = text.lines().skip(1).map_while(|line| line.strip_prefix("# "));
    lines.filter_map(|line| line.split_once(": ")).map(|(key, value)| (key, value.trim_end()))
}

/// Lines about the box of a saved state: edges [m] and periodic axes, as text.
pub fn box_lines(domain: &Domain) -> [(&'static str, String); 2] {
    let axes = ["x", "y", "z"].into_iter().zip(domain.periodic).filter(|(_, periodic)| *periodic).map(|(axis, _)| axis);
    let edges: Vec<String> = domain.size.iter().map(|edge| format!("{edge:?}")).collect();
    [("box_m", edges.join(" ")), ("periodic", axes.collect::<Vec<_>>().join(" "))]
}

/// A checksum of a text, to tell one case from another.
pub fn fingerprint(text: &str) -> u64 {
    checksum(text)
}

/// FNV-1a over all bytes except carriage returns, which a change of line ends adds, and blank space at the end.
pub(super) fn checksum(text: &str) -> u64 {
    let bytes = text.trim_end().bytes().filter(|byte| *byte != b'\r');
    // offset basis and prime: Fowler, Noll & Vo
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}
