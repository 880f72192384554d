//! `diptych cases` and `diptych init`: list of the built-in cases, and a copy of one of them as a new case.

use crate::case::{Case, built_in, nearest};
use crate::cli::Init;
use crate::runs::{StudyError, answer, tell};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// [characters] width of the column with the names of the cases in the printed list. The title of the case follows each
/// name.
const NAMES: usize = 30;

/// Prints the list of the built-in cases, with title and question of each, and the list of the built-in sets of values.
///
/// # Errors
/// Returns an error if the list cannot be written.
pub fn cases() -> Result<(), StudyError> {
    let mut text = String::from("Built-in cases, for any command that takes a case, and for `diptych init NAME`:\n\n");
    for case in built_in::cases() {
        let read = Case::built_in(&case, &[])?;
        let question = question(&read.heading).unwrap_or_else(|| read.title.clone());
        let _ = writeln!(text, "{:NAMES$} {}", case.name, read.title);
        if question != read.title {
            let _ = writeln!(text, "{:NAMES$}   {question}", "");
        }
    }
    text.push_str("\nBuilt-in sets of values, for `use = \"NAME\"` in a table of a case:\n\n");
    built_in::sets().iter().for_each(|set| text += &format!("{}\n", set.name));
    answer(&text)
}

/// Question that a case answers: the text after "Question:" in the comment at the top of the file of the case. The text
/// ends before "Source:" on a new line or at the end of the paragraph. `None` if the comment has no "Question:".
fn question(heading: &str) -> Option<String> {
    let after = heading.split_once("Question:")?.1;
    let end = after.find("\n\n").into_iter().chain(after.find("\nSource:")).min().unwrap_or(after.len());
    Some(after[..end].split_whitespace().collect::<Vec<_>>().join(" "))
}

/// Copies a built-in case to a new file, and the files that the case names to the folder of this new file. Prints the
/// paths of the written files.
///
/// # Errors
/// Returns an error if no built-in case has the name, if the new file exists already, or if a file cannot be written.
/// A file that the case names is left as it is if it exists already with equal contents.
pub fn init(args: &Init) -> Result<(), StudyError> {
    let bad = |message: String| StudyError::Input(format!("error: {message}"));
    let Some(case) = built_in::case(&args.name) else {
        let names: Vec<String> = built_in::cases().into_iter().map(|case| case.name).collect();
        let help = nearest(&args.name, &names).map(|name| format!("did you mean `{name}`? ")).unwrap_or_default();
        return Err(bad(format!("no built-in case is called `{}`\nhelp: {help}`diptych cases` lists them", args.name)));
    };
    let stem = Path::new(&case.name).file_name().unwrap_or_default();
    let path = args.out.clone().unwrap_or_else(|| PathBuf::from(stem).with_extension("toml"));
    let write = |path: &Path, bytes: &[u8], other: &str| {
        write_new(path, bytes).map_err(|why| {
            let help = if path.exists() { format!("\nhelp: name {other} with --out") } else { String::new() };
            bad(format!("cannot write {}: {why}{help}", path.display()))
        })
    };
    write(&path, case.text.as_bytes(), "another file")?;
    for (name, bytes) in built_in::files_of(&case) {
        let beside = path.with_file_name(&name);
        // an existing file with equal contents, written for another case, is not written again
        if std::fs::read(&beside).is_ok_and(|there| there == bytes) {
            continue;
        }
        write(&beside, bytes, "a file in another folder")?;
        tell(format_args!("{} written, which the case names", beside.display()));
    }
    let name = path.display();
    tell(format_args!("{name} written. Next: diptych check {name}, diptych plan {name}, diptych compare {name}"));
    Ok(())
}

/// Writes a new file, either completely or not at all. Returns an error if the file exists already.
fn write_new(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    // temporary files can be read by their owner only; the new file gets ordinary permissions
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    let mut aside = builder.prefix(".diptych-").tempfile_in(folder)?;
    aside.write_all(bytes)?;
    aside.persist_noclobber(path).map(drop).map_err(|refused| refused.error)
}
