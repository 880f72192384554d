//! Folder of results: which command may write into it, and which files are replaced.

use crate::support::{BASE, diptych, words};
use diptych::output::{Folder, OutputError};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Names in a folder, sorted; none if the folder does not exist.
fn names(path: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn two_runs_do_not_share_a_folder() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("results");
    // the run takes long enough to be found in progress and to be killed
    let mut first = diptych(&["run", BASE, "--set", "run.duration=1000 s", "--quiet", "--out"])
        .arg(&folder)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let began = Instant::now();
    while !folder.join("figures").exists() && began.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(10));
    }
    for more in [&[][..], &["--overwrite"]] {
        let second = diptych(&["run", BASE, "--out"]).arg(&folder).args(more).output().unwrap();
        let told = words(&second.stderr);
        assert_eq!(second.status.code(), Some(2), "{told}");
        assert!(told.contains("another run is writing into") && told.contains("--out"), "{told}");
        assert!(!folder.join("summary.json").exists() && second.stdout.is_empty());
    }
    // the lock of a killed run stops no other run, and the lock file of a finished run is removed
    first.kill().unwrap();
    first.wait().unwrap();
    let third = diptych(&["run", BASE, "--quiet", "--out"]).arg(&folder).output().unwrap();
    assert_eq!(third.status.code(), Some(0), "{}", words(&third.stderr));
    assert_eq!(
        names(&folder),
        ["figures", "impacts.csv", "profiles.csv", "report.html", "series.csv", "stress.csv", "summary.json"]
    );
}

#[test]
fn of_many_at_once_one_gets_the_folder() {
    let place = tempfile::tempdir().unwrap();
    for _ in 0..50 {
        let path = place.path().join("results");
        let all: Vec<_> = std::thread::scope(|scope| {
            let tries: Vec<_> = (0..4).map(|_| scope.spawn(|| Folder::create(&path, false))).collect();
            tries.into_iter().map(|one| one.join().unwrap()).collect()
        });
        assert_eq!(all.iter().filter(|one| one.is_ok()).count(), 1);
        assert!(all.iter().all(|one| matches!(one, Ok(_) | Err(OutputError::InUse { .. }))));
        drop(all);
        assert_eq!(names(&path), ["figures"]);
    }
}

#[test]
fn pictures_of_somebody_else_stay() {
    let place = tempfile::tempdir().unwrap();
    let own = place.path().join("figures/own.svg");
    std::fs::create_dir(place.path().join("figures")).unwrap();
    std::fs::write(&own, "<svg xmlns=\"http://www.w3.org/2000/svg\"/>").unwrap();
    let run = |arguments: &[&str]| {
        let output = diptych(arguments).arg("--quiet").arg("--out").arg(place.path()).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
        assert!(own.exists(), "{arguments:?} has removed it");
        names(&place.path().join("figures"))
    };
    assert!(run(&["compare", BASE]).contains(&"differences.svg".to_owned()));
    // files of the earlier run are removed
    assert!(!run(&["run", BASE, "--overwrite"]).contains(&"differences.svg".to_owned()));
}

#[test]
fn what_cannot_be_written_is_refused_before_anything_is_computed() {
    for name in ["summary.json", "profiles.csv", "report.html"] {
        let place = tempfile::tempdir().unwrap();
        std::fs::create_dir(place.path().join(name)).unwrap();
        let output = diptych(&["run", BASE, "--overwrite", "--out"]).arg(place.path()).output().unwrap();
        let told = words(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains(name) && told.contains("--out") && !told.contains("simulated"), "{told}");
        assert_eq!(names(place.path()), [name]);
    }
}
