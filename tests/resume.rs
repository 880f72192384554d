//! Killed or stopped runs can be resumed, with identical bits and without loss.

mod disk;

use crate::support::{BASE, words};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Every engine, with a duration for which a run takes some tenths of a second.
const WAYS: [(&str, &[&str]); 12] = [
    ("hard", &["--model=hard", "--set=run.duration=4 s"]),
    ("hard, contact time", &["--model=hard", "--set=run.duration=4 s", "--set=hard.contact_time=1e-6 s"]),
    (
        "hard, with paths and trajectories",
        &[
            "--model=hard",
            "--set=run.duration=4 s",
            "--set=particles[0].count=30",
            "--every=20 ms",
            "--set=output.format=both",
        ],
    ),
    (
        "hard, rough",
        &[
            "--model=hard",
            "--set=run.duration=4 s",
            "--set=contact.friction=0.3",
            "--set=hard.friction.walton.tangential_restitution=0.4",
        ],
    ),
    (
        "uniform, rough",
        &[
            "--model=soft",
            "--set=run.duration=0.3 s",
            "--set=soft.stepping=uniform",
            "--set=contact.friction=0.3",
            "--set=soft.tangential.linear.stiffness_ratio=0.8",
        ],
    ),
    (
        "local, rough",
        &[
            "--model=soft",
            "--set=run.duration=3 s",
            "--set=soft.stepping=local",
            "--set=contact.friction=0.3",
            "--set=soft.tangential.linear.tangential_restitution=0.5",
        ],
    ),
    ("stepped hard", &["--model=hard", "--set=run.duration=8 s", "--set=hard.stepping=steps"]),
    ("uniform", &["--model=soft", "--set=run.duration=0.3 s", "--set=soft.stepping=uniform"]),
    (
        "uniform, rk2",
        &["--model=soft", "--set=run.duration=0.15 s", "--set=soft.stepping=uniform", "--set=soft.integrator=rk2"],
    ),
    ("local", &["--model=soft", "--set=run.duration=3 s", "--set=soft.stepping=local"]),
    ("auto", &["--model=soft", "--set=run.duration=3 s", "--set=soft.stepping=auto"]),
    (
        "auto, dense",
        &[
            "--model=soft",
            "--set=run.duration=0.06 s",
            "--set=particles[0].count=1500",
            "--set=soft.linear_spring_dashpot.stiffness=500 N/m",
        ],
    ),
];

/// Comparisons: one with `--verify`, and a longer one with paths and trajectories.
const COMPARED: [[&str; 4]; 2] = [
    ["--verify", "--set=run.duration=0.5 s", "--margin=1%", "--set=run.seed=1"],
    ["--set=run.duration=2 s", "--set=particles[0].count=30", "--every=20 ms", "--set=output.format=both"],
];

/// Settings of all runs in this file: several windows between samples, one thread, frequent checkpoints.
const ALL: [&str; 5] = [
    "--set=run.average_from=0.01 s",
    "--set=statistics.sample_interval=2 ms",
    "--threads=1",
    "--quiet",
    "--checkpoint-every=10 ms",
];

fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diptych"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn start(what: &str, case: &str, more: &[&str], folder: &Path) -> Child {
    program().args([what, case]).args(ALL).args(more).arg("--out").arg(folder).spawn().unwrap()
}

fn resume(folder: &Path) -> Output {
    program().arg("resume").arg(folder).output().unwrap()
}

fn code(output: &Output) -> Option<i32> {
    output.status.code()
}

/// Waits until a condition is true. Returns false if the condition is not true after a minute.
fn wait_for(what: impl Fn() -> bool) -> bool {
    let began = Instant::now();
    // a condition that was true once may be false at the next call
    while !what() {
        if began.elapsed() > Duration::from_secs(60) {
            return false;
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    true
}

/// Sends a signal to a child process.
fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([name, &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
    assert!(sent.success() || cfg!(not(unix)));
}

/// All files that a run has written: tables and pictures byte by byte, and the summary without wall times and paths.
fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut results = BTreeMap::new();
    let trajectories = std::fs::read_dir(folder.join("trajectory")).into_iter().flatten().flatten();
    let inner = trajectories.map(|entry| entry.path()).filter(|path| path.is_dir());
    let places = [folder.into(), folder.join("figures"), folder.join("trajectory")].into_iter().chain(inner);
    for place in places.filter(|place: &PathBuf| place.is_dir()) {
        for entry in std::fs::read_dir(place).unwrap().map(Result::unwrap) {
            let name = entry.path().strip_prefix(folder).unwrap().display().to_string();
            // the report and the cost contain wall times, and a run killed at its very end leaves an unlocked lock file
            let of_its_own = ["report.html", "figures/cost.svg", "summary.json", ".diptych-lock"];
            if entry.path().is_file() && !of_its_own.contains(&name.as_str()) {
                results.insert(name, std::fs::read(entry.path()).unwrap());
            }
        }
    }
    let summary = std::fs::read_to_string(folder.join("summary.json")).unwrap();
    results.insert("summary.json".into(), timeless(serde_json::from_str(&summary).unwrap()).to_string().into_bytes());
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(
        ["run", "compare", "sensitivity"].iter().any(|command| page.contains(&format!("diptych {command}"))),
        "the command is not the one that was typed"
    );
    results
}

fn timeless(value: Value) -> Value {
    const TIMES: [&str; 7] = [
        "wall_seconds",
        "wall_seconds_per_simulated_second",
        "particle_windows_per_second",
        "timing",
        "command",
        "cost",
        "verdicts",
    ];
    match value {
        Value::Object(entries) => {
            let kept = entries.into_iter().filter(|(key, _)| !TIMES.contains(&key.as_str()));
            Value::Object(kept.map(|(key, value)| (key, timeless(value))).collect())
        }
        Value::Array(items) => items.into_iter().map(timeless).collect(),
        plain => plain,
    }
}

/// Results and wall time of a command that is not interrupted.
fn undisturbed(what: &str, case: &str, more: &[&str]) -> (BTreeMap<String, Vec<u8>>, Duration) {
    let place = tempfile::tempdir().unwrap();
    let began = Instant::now();
    let output = start(what, case, more, place.path()).wait_with_output().unwrap();
    let took = began.elapsed();
    assert_eq!(code(&output), Some(0), "{}", words(&output.stderr));
    assert!(!place.path().join("checkpoint").exists(), "a run that is over leaves its checkpoint");
    (results(place.path()), took)
}

/// Checks that two runs have written equal files. The message names a file that differs.
#[track_caller]
fn same(name: &str, found: &BTreeMap<String, Vec<u8>>, expected: &BTreeMap<String, Vec<u8>>) {
    assert!(found.keys().eq(expected.keys()), "{name}: {:?} {:?}", found.keys(), expected.keys());
    for (file, text) in found {
        assert!(*text == expected[file], "{name}: {file} differs");
    }
}

/// Kills a command at random times after its first stored state, and resumes it after each kill, until it ends. Returns
/// the number of kills.
fn kill_and_resume(name: &str, what: &str, more: &[&str], random: &mut Xoshiro256PlusPlus) -> u32 {
    let (expected, took) = undisturbed(what, BASE, more);
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("results");
    let mut child = start(what, BASE, more, &folder);
    assert!(wait_for(|| folder.join("checkpoint/command").exists() || folder.join("summary.json").exists()));
    let mut kills = 0;
    loop {
        std::thread::sleep(took.mul_f64(random.random::<f64>()));
        child.kill().unwrap();
        let output = child.wait_with_output().unwrap();
        // the command may have ended before the signal
        kills += u32::from(output.status.code().is_none());
        // the command may have been killed while it removed the checkpoint, after its results were complete
        if !folder.join("checkpoint/command").exists() {
            break;
        }
        // a second kill interrupts the resumed run
        child = program().arg("resume").arg(&folder).spawn().unwrap();
        if kills >= 2 {
            let output = child.wait_with_output().unwrap();
            assert_eq!(code(&output), Some(0), "{name}: {}", words(&output.stderr));
            break;
        }
    }
    same(name, &results(&folder), &expected);
    assert!(!folder.join("checkpoint/command").exists(), "{name}");
    kills
}

#[test]
fn killed_runs_go_on_with_the_same_bits() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let kills: u32 = WAYS
        .iter()
        .map(|(name, more)| kill_and_resume(name, "run", &[more, &["--save-state"][..]].concat(), &mut random))
        .sum();
    let kills = kills + kill_and_resume("compare", "compare", &COMPARED[0], &mut random);
    let replicas = ["--replicas=3", "--set=run.duration=0.3 s"];
    let kills = kills + kill_and_resume("replicas", "compare", &replicas, &mut random);
    let factors = ["--factors=model,restitution,seed", "--set=run.duration=0.3 s", "--replicas=2"];
    let kills = kills + kill_and_resume("sensitivity", "sensitivity", &factors, &mut random);
    // most commands are killed before the end, because the time of the kill is within the duration of the run
    assert!(kills >= 5, "{kills}");
}

#[test]
#[ignore = "100 kills in some minutes: cargo test --test it resume::a_hundred -- --ignored --nocapture"]
fn a_hundred_kills_lose_nothing() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
    let mut kills = BTreeMap::<&str, u32>::new();
    while kills.values().sum::<u32>() < 100 {
        for (name, more) in WAYS {
            *kills.entry(name).or_default() +=
                kill_and_resume(name, "run", &[more, &["--save-state"]].concat(), &mut random);
        }
        for more in COMPARED {
            *kills.entry("compare").or_default() += kill_and_resume("compare", "compare", &more, &mut random);
        }
        println!("{kills:?}");
    }
}

/// Folder of a run that was killed just after it had written its second checkpoint (stored state).
fn killed_after_two(more: &[&str], place: &Path) -> PathBuf {
    let folder = place.join("killed");
    let mut child = start("run", BASE, more, &folder);
    assert!(wait_for(|| folder.join("checkpoint/b").exists()));
    child.kill().unwrap();
    child.wait().unwrap();
    folder
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target)
        } else {
            let _ = std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// The newer and the older one of two stored states. The serial number of a state follows the second line of its file.
fn by_age(folder: &Path) -> [PathBuf; 2] {
    let generation = |path: &PathBuf| {
        let bytes = std::fs::read(path).unwrap();
        let end = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n').nth(1).unwrap().0;
        // varint of postcard: seven bits in each byte, the lowest bits first
        let digits = bytes[end + 1..].iter().scan(true, |more, byte| {
            let now = *more;
            *more = *byte >= 128;
            now.then_some(u64::from(byte & 127))
        });
        digits.enumerate().map(|(k, digit)| digit << (7 * k)).sum::<u64>()
    };
    let mut files = ["a", "b"].map(|name| folder.join("checkpoint").join(name));
    files.sort_by_key(|path| std::cmp::Reverse(generation(path)));
    files
}

#[test]
fn a_damaged_checkpoint_is_told_and_the_older_one_is_used() {
    let more = ["--model=soft", "--set=run.duration=3 s"];
    let (expected, _) = undisturbed("run", BASE, &more);
    let place = tempfile::tempdir().unwrap();
    let killed = killed_after_two(&more, place.path());
    let length = std::fs::metadata(&by_age(&killed)[0]).unwrap().len() as usize;
    let damages: [(&str, &dyn Fn(&mut Vec<u8>)); 5] = [
        ("first byte", &|bytes| bytes[0] ^= 1),
        ("a byte of the data", &|bytes| bytes[length / 2] ^= 16),
        ("last byte", &|bytes| *bytes.last_mut().unwrap() ^= 128),
        ("cut in the middle", &|bytes| bytes.truncate(length / 2)),
        ("empty", &Vec::clear),
    ];
    for (name, damage) in damages {
        let folder = place.path().join(name);
        copy(&killed, &folder);
        let [newer, _] = by_age(&folder);
        let mut bytes = std::fs::read(&newer).unwrap();
        damage(&mut bytes);
        std::fs::write(&newer, bytes).unwrap();
        let output = resume(&folder);
        let told = words(&output.stderr);
        assert_eq!(code(&output), Some(0), "{name}: {told}");
        let path = newer.display().to_string();
        assert!(told.contains(&path) && told.contains("the other one is used"), "{name}: {told}");
        same(name, &results(&folder), &expected);
    }
    // if no state can be used, the run starts from the beginning
    let both = place.path().join("both");
    copy(&killed, &both);
    by_age(&both).iter().for_each(|path| std::fs::write(path, "x").unwrap());
    let output = resume(&both);
    assert_eq!(code(&output), Some(0));
    assert!(words(&output.stderr).contains("is no checkpoint; there is no other one"), "{}", words(&output.stderr));
    same("both", &results(&both), &expected);
}

#[test]
fn a_signal_stops_at_the_end_of_the_window_and_a_second_one_at_once() {
    let more =
        ["--model=soft", "--set=run.duration=0.3 s", "--set=soft.stepping=uniform", "--save-state", "--every=5 ms"];
    let (expected, _) = undisturbed("run", BASE, &more);
    for name in ["-INT", "-TERM"] {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("results");
        let child = start("run", BASE, &more, &folder);
        assert!(wait_for(|| folder.join("checkpoint/a").exists()));
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        let told = words(&output.stderr);
        assert_eq!(code(&output), Some(130), "{told}");
        assert!(told.contains("\"soft\" was stopped; `diptych resume") && told.contains("goes on from t = "), "{told}");
        // there is a report of the completed part, marked as such, but no summary, which would mean that all is
        // complete
        let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
        assert!(page.contains("stopped from outside") && !folder.join("summary.json").exists());
        let again = program().args(["run", BASE, "--quiet", "--out"]).arg(&folder).output().unwrap();
        let told = words(&again.stderr);
        assert_eq!(code(&again), Some(2));
        assert!(told.contains("diptych resume"), "{told}");
        let output = resume(&folder);
        assert_eq!(code(&output), Some(0), "{}", words(&output.stderr));
        same(name, &results(&folder), &expected);
    }
    // a window of so many steps that it does not end within this test
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("results");
    let long = ["--set=run.duration=4000 s", "--set=run.window=2000 s", "--set=run.allow_long=true"];
    let sample = "--set=statistics.sample_interval=2000 s";
    let mut child =
        start("run", BASE, &[&long[..], &[sample, "--model=soft", "--set=soft.stepping=uniform"]].concat(), &folder);
    assert!(wait_for(|| folder.join("checkpoint/command").exists()));
    signal(&child, "-INT");
    std::thread::sleep(Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none(), "one signal waits for the end of the window");
    let began = Instant::now();
    signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), Some(130), "{}", words(&output.stderr));
    assert!(began.elapsed() < Duration::from_secs(10));
}

/// Number of files of a checkpoint whose names begin with `begins`.
fn stored(folder: &Path, begins: &str) -> usize {
    let Ok(entries) = std::fs::read_dir(folder.join("checkpoint")) else { return 0 };
    entries.flatten().filter(|entry| entry.file_name().to_string_lossy().starts_with(begins)).count()
}

#[test]
fn replicas_stop_at_a_signal_and_are_gone_on_with() {
    // runs so long that even a slow test finds some of them finished and others not
    let more = ["--model=hard", "--set=run.duration=4 s", "--replicas=5"];
    let (expected, _) = undisturbed("run", BASE, &more);
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("results");
    let child = start("run", BASE, &more, &folder);
    // the first run and a replica are finished, and another replica is in progress
    assert!(wait_for(|| stored(&folder, "done-") >= 2 && stored(&folder, "a-") >= 1));
    signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    let told = words(&output.stderr);
    assert_eq!(code(&output), Some(130), "{told}");
    assert!(told.contains("\"hard\" was stopped; `diptych resume") && told.contains("does what is left"), "{told}");
    let over = stored(&folder, "done-");
    // the state of the replica in progress is stored too, unless this replica has just ended
    assert!((2..5).contains(&over), "{over} are over");
    assert!(folder.join("report.html").exists() && !folder.join("summary.json").exists());
    let done: Vec<_> = std::fs::read_dir(folder.join("checkpoint")).unwrap().flatten().collect();
    let times = |file: &std::fs::DirEntry| std::fs::metadata(file.path()).and_then(|data| data.modified()).ok();
    let before: Vec<_> = done.iter().filter(|file| file.file_name().to_string_lossy().starts_with("done-")).collect();
    let written: Vec<_> = before.iter().map(|file| times(file)).collect();
    // a second stop while runs are in progress does not change the finished runs
    let mut child = program().arg("resume").arg(&folder).spawn().unwrap();
    let _ = wait_for(|| stored(&folder, "done-") > over || !folder.join("checkpoint").exists());
    child.kill().unwrap();
    child.wait().unwrap();
    if folder.join("checkpoint").exists() {
        assert!(before.iter().zip(&written).all(|(file, written)| times(file) == *written));
        let output = resume(&folder);
        assert_eq!(code(&output), Some(0), "{}", words(&output.stderr));
    }
    same("replicas", &results(&folder), &expected);
}

#[test]
fn another_program_or_a_changed_case_is_refused_by_name() {
    let place = tempfile::tempdir().unwrap();
    let case = place.path().join("own.toml");
    let text = std::fs::read_to_string(BASE)
        .unwrap()
        .replace("name = \"glass\"\ndiameter = \"406 um\"\ndensity = \"1038 kg/m^3\"\n", "use = \"particles/own\"\n");
    std::fs::write(&case, &text).unwrap();
    let models = place.path().join("models/particles");
    std::fs::create_dir_all(&models).unwrap();
    let set = "name = \"own\"\ndiameter = \"406 um\"\ndensity = \"1038 kg/m^3\"\nsource = \"none\"\n";
    std::fs::write(models.join("own.toml"), set).unwrap();
    let folder = place.path().join("results");
    let mut child = start("run", case.to_str().unwrap(), &["--set=run.duration=4 s"], &folder);
    assert!(wait_for(|| folder.join("checkpoint/b").exists()));
    child.kill().unwrap();
    child.wait().unwrap();
    let refused = |what: &str| {
        let output = resume(&folder);
        let told = words(&output.stderr);
        assert_eq!(code(&output), Some(2), "{told}");
        assert!(told.contains(what), "{told}");
    };
    std::fs::write(&case, text.replace("restitution = 0.94", "restitution = 0.95")).unwrap();
    refused("own.toml has been changed since the run began");
    std::fs::write(&case, &text).unwrap();
    std::fs::write(models.join("own.toml"), set.replace("1038", "1039")).unwrap();
    refused("\"hard\" (scene) has been changed by a file");
    std::fs::write(models.join("own.toml"), set).unwrap();
    // a file of another version: the name of the program in the file differs, and the checksum fits
    let command = folder.join("checkpoint/command");
    let own = std::fs::read(&command).unwrap();
    let mut other = own[..own.len() - 4].to_vec();
    let version = format!("diptych {}", env!("CARGO_PKG_VERSION"));
    let place_of = other.windows(version.len()).position(|part| part == version.as_bytes()).unwrap();
    other[place_of + "diptych ".len()] = b'9';
    other.extend_from_slice(&crc32fast::hash(&other).to_le_bytes());
    std::fs::write(&command, other).unwrap();
    refused("was written by diptych 9.");
    // a damaged command file is replaced by its copy, unless the copy is damaged too
    let copy = folder.join("checkpoint/command-copy");
    [&command, &copy].iter().for_each(|path| std::fs::write(path, &own[..own.len() / 2]).unwrap());
    refused("is damaged");
    // with the original file, the command can be resumed
    std::fs::write(&command, own).unwrap();
    assert_eq!(code(&resume(&folder)), Some(0));
    refused("are complete");
    let output = resume(&place.path().join("nowhere"));
    assert_eq!(code(&output), Some(2));
    assert!(words(&output.stderr).contains("holds no run to go on with"));
}
