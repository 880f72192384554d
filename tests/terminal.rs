//! Messages on the terminal may be lost, but not results.

use crate::support::{BASE, diptych, words};
use std::io::Read;
use std::path::Path;
use std::process::{Child, Stdio};

/// Every command that writes a folder, with the smallest accepted input.
const WRITING: [&[&str]; 6] = [
    &["run", BASE],
    &["compare", BASE],
    &["fluid", BASE],
    &["impact"],
    &["chart", "cases/impact.toml", "--quick"],
    &["limits", "--quick", "--only", "softness"],
];

/// Runs each writing command with the output streams set by `spawn`. The command must succeed and write all files.
fn all_write(what: &str, spawn: impl Fn(&mut std::process::Command) -> Child) {
    let place = tempfile::tempdir().unwrap();
    for arguments in WRITING {
        let folder = place.path().join(arguments[0]);
        let mut child = spawn(diptych(arguments).arg("--out").arg(&folder));
        let mut told = String::new();
        if let Some(mut stderr) = child.stderr.take() {
            stderr.read_to_string(&mut told).unwrap();
        }
        let status = child.wait().unwrap();
        assert_eq!(status.code(), Some(0), "{arguments:?} with {what}: {told}");
        assert!(folder.join("summary.json").exists(), "{arguments:?} with {what} wrote nothing");
    }
}

#[test]
fn nobody_reads_what_is_said() {
    all_write("a standard error that nobody reads", |command| {
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stderr.take());
        child
    });
    all_write("a standard output that nobody reads", |command| {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        drop(child.stdout.take());
        child
    });
}

/// Device for which every write fails.
#[cfg(target_os = "linux")]
fn full() -> Stdio {
    std::fs::File::options().write(true).open(Path::new("/dev/full")).unwrap().into()
}

#[cfg(target_os = "linux")]
#[test]
fn there_is_no_room_for_what_is_said() {
    all_write("both outputs full", |command| command.stdout(full()).stderr(full()).spawn().unwrap());
    // a closed pipe gives no message; a full disk gives a message
    let place = tempfile::tempdir().unwrap();
    let output = diptych(&["impact", "--out"]).arg(place.path()).stdout(full()).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(words(&output.stderr).matches("cannot write to standard output").count(), 1);
    // bad input has its own exit code, even if the reason cannot be printed
    let status = diptych(&["check", "no/such/case.toml"]).stderr(full()).status().unwrap();
    assert_eq!(status.code(), Some(2));
}

/// The commands `check` and `plan` write no folder, and only print. A closed pipe is no error; a full disk is.
#[test]
fn a_text_that_cannot_be_printed_is_lost_only_if_nobody_wants_it() {
    for arguments in [&["check", BASE][..], &["plan", "cases/impact.toml"]] {
        let mut child = diptych(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert!(output.stderr.is_empty(), "{arguments:?}: {}", words(&output.stderr));
        #[cfg(target_os = "linux")]
        {
            let output = diptych(arguments).stdout(full()).output().unwrap();
            assert_eq!(output.status.code(), Some(1), "{arguments:?}");
            assert!(words(&output.stderr).starts_with("error: cannot write to standard output"), "{arguments:?}");
        }
    }
}
