//! Files of other programs: every oddity of such files, and every pair of oddities, is read or refused as listed.

pub mod parts;
mod starts;
mod triangles;

use diptych::case::Case;
use diptych::experiment::{Experiment, Model};

/// Expected result of reading a file.
pub enum Expected {
    /// The file is read, with this number of triangles or particles. The warnings contain these words; without words,
    /// there are no warnings.
    Read(usize, &'static [&'static str]),
    /// The file is refused with a message that contains these words.
    Refused(&'static [&'static str]),
}

/// Reads the case `text` with a file in its folder, which has the given name and bytes. Returns the experiment and its
/// warnings, or the message of the error.
pub fn read(name: &str, bytes: &[u8], text: &str, model: Model) -> Result<(Experiment, Vec<String>), String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(name), bytes).unwrap();
    let path = folder.path().join("case.toml");
    std::fs::write(&path, text.replace("FILE", name)).unwrap();
    let read = Case::read(&path, &[]).and_then(|case| case.experiment(Some(model), None));
    let told = |warnings: Vec<diptych::case::Diagnostic>| warnings.iter().map(ToString::to_string).collect();
    read.map(|(experiment, warnings)| (experiment, told(warnings))).map_err(|error| error.to_string())
}

/// Compares the result of reading a file with the expected result. The result is a number of triangles or particles
/// with warnings, or the message of an error.
pub fn judge(what: &str, found: &Result<(usize, Vec<String>), String>, expected: &Expected) {
    match (found, expected) {
        (Ok((count, told)), Expected::Read(wanted, parts)) => {
            assert_eq!(count, wanted, "{what}: {told:#?}");
            let told = told.join("\n");
            assert_eq!(told.is_empty(), parts.is_empty(), "{what}: {told}");
            for part in *parts {
                assert!(told.contains(part), "{what}: no {part:?} in\n{told}");
            }
        }
        (Err(message), Expected::Refused(parts)) => {
            for part in *parts {
                assert!(message.contains(part), "{what}: no {part:?} in\n{message}");
            }
            assert!(message.contains("\nhelp: "), "{what}: no remedy in\n{message}");
        }
        (Ok((count, told)), Expected::Refused(parts)) => {
            panic!("{what}: read as {count} where {parts:?} belongs; {told:?}")
        }
        (Err(message), Expected::Read(..)) => panic!("{what}: refused\n{message}"),
    }
}

/// Every oddity alone and every pair of oddities, with their names.
pub fn combinations<T: Clone>(plain: &T, oddities: &[(&'static str, fn(T) -> T)]) -> Vec<(String, T)> {
    let mut all = vec![("plain".to_owned(), plain.clone())];
    for (k, (name, change)) in oddities.iter().enumerate() {
        all.push(((*name).to_owned(), change(plain.clone())));
        for (other, also) in &oddities[k + 1..] {
            all.push((format!("{name}, {other}"), also(change(plain.clone()))));
        }
    }
    all
}
