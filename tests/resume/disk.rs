//! Runs on a disk that cannot be written, or is full.

use super::*;

/// The command shell limits the size of files (`ulimit -f`), which has the effect of a full disk. The limit is in
/// blocks of 512 or 1024 bytes.
#[cfg(unix)]
#[test]
fn a_disk_that_refuses_leaves_what_is_there() {
    let more = ["--model=soft", "--set=run.duration=3 s"];
    let (expected, _) = undisturbed("run", BASE, &more);
    let place = tempfile::tempdir().unwrap();
    let folder = killed_after_two(&more, place.path());
    let states = || by_age(&folder).map(|path| std::fs::read(path).unwrap());
    let before = states();
    let limited = Command::new("sh")
        .args(["-c", "ulimit -f 8; exec \"$0\" resume \"$1\"", env!("CARGO_BIN_EXE_diptych")])
        .arg(&folder)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let told = words(&limited.stderr);
    assert_eq!(code(&limited), Some(1), "{told}");
    assert!(told.contains("no checkpoint at this time: cannot write") && told.contains("is still stored"), "{told}");
    // the report does not fit on the disk, either
    assert!(told.contains("error: cannot write") && told.contains("help: once it can be written"), "{told}");
    assert!(states() == before, "an earlier state has been touched");
    let output = resume(&folder);
    assert_eq!(code(&output), Some(0), "{}", words(&output.stderr));
    same("after the disk", &results(&folder), &expected);
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "needs a name space with a disk of its own: unshare must be allowed; cargo test --test it resume::disk::a_disk_of_200 -- --ignored"]
fn a_disk_of_200_kb_is_no_end() {
    let more = ["--model=soft", "--set=run.duration=3 s"];
    let (expected, _) = undisturbed("run", BASE, &more);
    let place = tempfile::tempdir().unwrap();
    let kept = place.path().join("kept");
    let arguments = [&["run", BASE][..], &ALL, &more].concat();
    let quoted: Vec<String> = arguments.iter().map(|argument| format!("'{argument}'")).collect();
    let script = format!(
        "mount -t tmpfs -o size=200k none '{disk}' && '{program}' {} --out '{disk}/r'; echo code $?; \
         mount -o remount,size=20m '{disk}' && '{program}' resume '{disk}/r'; echo code $?; cp -r '{disk}/r' '{kept}'",
        quoted.join(" "),
        disk = place.path().join("disk").display(),
        program = env!("CARGO_BIN_EXE_diptych"),
        kept = kept.display(),
    );
    std::fs::create_dir(place.path().join("disk")).unwrap();
    let output = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", &script])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let (said, told) = (words(&output.stdout), words(&output.stderr));
    assert!(told.contains("No space left") && said.contains("code 1") && said.contains("code 0"), "{said}\n{told}");
    same("a small disk", &results(&kept), &expected);
}
