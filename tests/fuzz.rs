//! Damaged and random inputs to every reader. No input may cause a panic, a hang, or a full memory.
//!
//! Each input is a valid input with a few random changes. The changes are drawn from the number of the input, so that
//! any input can be made again. A fault is printed with its reader and number.

use crate::files::parts::{COMB, CUBE, binary, cube, prism, text};
use crate::support::*;
use diptych::case::Case;
use diptych::case::quantity::parse;
use diptych::checkpoint::{RunIdentity, Store, StoredCommand, StoredRun, open};
use diptych::experiment::{Experiment, Integrator, Model, SoftStepping};
use diptych::observe::{Observer, Paths, RunLoop, Series};
use diptych::schedule::Schedule;
use diptych::simulation::{Simulation, Snapshot};
use diptych::statistics::Accumulator;
use diptych::study::check_text;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest time that a reader may take for an input. Inputs have some kilobytes and usually take milliseconds. The
/// limit is so long because the machine may be busy.
const LONGEST: Duration = Duration::from_secs(20);

/// [kB] largest memory of this process, which includes all tests that run at the same time.
const LARGEST: u64 = 2 << 20;

/// Numbers and words that are likely to cause errors in readers.
const ODD: [&str; 38] = [
    "0",
    "-0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "1e400",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "18446744073709551616",
    "0.1.2",
    "1_000",
    "1e",
    "0x10",
    "1,5",
    "\"1 mm\"",
    "\"-3 N/m\"",
    "\"1e300 km\"",
    "\"1e-300 pm\"",
    "[]",
    "{}",
    "[[]]",
    "true",
    "\"\"",
    "\"5 %\"",
    "\"1 m/s/s/s\"",
    "\"1 m^99\"",
    "m^-3",
    "²",
    "µm",
    "1e9",
    "4294967296",
    "\u{feff}",
    "\u{0}",
    "\"../x.csv\"",
    "\"soft\"",
];

/// Text `from` with one to four random changes.
fn mutated(from: &str, others: &[String], draw: &mut Xoshiro256PlusPlus) -> String {
    let mut bytes = from.as_bytes().to_vec();
    for _ in 0..1 + draw.random_range(0..4) {
        let length = bytes.len();
        let at = draw.random_range(0..=length);
        let end = (at + draw.random_range(0..12)).min(length);
        match draw.random_range(0..9) {
            0 if at < length => bytes[at] = draw.random_range(32..127),
            1 if at < length => bytes[at] = draw.random(),
            2 => drop(bytes.drain(at..end)),
            3 => {
                let again = bytes[at..end].to_vec();
                bytes.splice(at..at, again);
            }
            4 => drop(bytes.splice(at..at, ODD[draw.random_range(0..ODD.len())].bytes())),
            5 => odd_number(&mut bytes, at, draw),
            6 => lines(&mut bytes, others, draw),
            7 => bytes.truncate(at.max(length / 2)),
            _ => bytes.insert(at, b" \n\"'[]{}=.,#-+e%/^"[draw.random_range(0..18)]),
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Replaces the first number after `at` by a number or word from [`ODD`].
fn odd_number(bytes: &mut Vec<u8>, at: usize, draw: &mut Xoshiro256PlusPlus) {
    let Some(start) = (at..bytes.len()).find(|k| bytes[*k].is_ascii_digit()) else { return };
    let of_a_number = |byte: &u8| byte.is_ascii_digit() || b".eE+-".contains(byte);
    let end = (start..bytes.len()).find(|k| !of_a_number(&bytes[*k])).unwrap_or(bytes.len());
    bytes.splice(start..end, ODD[draw.random_range(0..ODD.len())].bytes());
}

/// Swaps two lines, removes a line, or inserts a line from another input.
fn lines(bytes: &mut Vec<u8>, others: &[String], draw: &mut Xoshiro256PlusPlus) {
    let mut lines: Vec<Vec<u8>> = bytes.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    let (one, other) = (draw.random_range(0..lines.len()), draw.random_range(0..lines.len()));
    match draw.random_range(0..3) {
        0 => lines.swap(one, other),
        1 => drop(lines.remove(one)),
        _ => {
            let from = &others[draw.random_range(0..others.len())];
            if let Some(line) = from.lines().nth(draw.random_range(0..40)) {
                lines.insert(one, line.as_bytes().to_vec());
            }
        }
    }
    *bytes = lines.join(&b'\n');
}

/// Readers that are tested, each with its number of inputs in a thousand. Reading a whole case takes milliseconds,
/// reading a quantity a microsecond.
const READERS: [(&str, u64); 13] = [
    ("quantity", 273),
    ("start.csv", 15),
    ("state.csv", 15),
    ("start.xyz", 10),
    ("start.data", 10),
    ("start.dump", 10),
    ("text.stl", 10),
    ("binary.stl", 10),
    ("wall.obj", 10),
    ("case", 20),
    ("snapshot", 300),
    ("envelope", 312),
    ("checkpoint", 5),
];

/// A file in extended XYZ format.
const XYZ: &str = "2\nLattice=\"0.004 0 0 0 0.004 0 0 0 0.004\" Properties=species:S:1:pos:R:3:velo:R:3:radius:R:1:id:I:1 Time=0.0 pbc=\"T T T\" units=\"m s\"\n\
                   glass 1e-3 1e-3 1e-3 0 0 0.1 2.03e-4 0\nglass 2e-3 1e-3 1e-3 0 0 -0.1 2.03e-4 1\n";

/// A data file of LAMMPS.
const DATA: &str = "two spheres, units si\n\n2 atoms\n1 atom types\n\n0 0.004 xlo xhi\n0 0.004 ylo yhi\n0 0.004 zlo zhi\n\n\
                    Atoms # sphere\n\n1 1 4.06e-4 2500 1e-3 1e-3 1e-3\n2 1 4.06e-4 2500 2e-3 1e-3 1e-3\n\n\
                    Velocities\n\n1 0 0 0.1 0 0 0\n2 0 0 -0.1 0 0 0\n";

/// A dump of LAMMPS.
const DUMP: &str = "ITEM: UNITS\nsi\nITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 0.004\n0 0.004\n0 0.004\n\
                    ITEM: ATOMS id type xs ys zs vx vy vz radius density ix\n\
                    0 1 0.25 0.25 0.25 0 0 0.1 2.03e-4 2500 0\n1 1 0.5 0.25 0.25 0 0 -0.1 2.03e-4 2500 0\n";

struct Fuzz {
    root: PathBuf,
    folder: tempfile::TempDir,
    quantities: Vec<String>,
    tables: Vec<String>,
    states: Vec<String>,
    cases: Vec<String>,
    snapshots: Vec<Vec<u8>>,
    checkpoint: Checkpoint,
}

/// Files of a checkpoint as written by a run, and the identity of this run.
struct Checkpoint {
    experiment: Experiment,
    run: RunIdentity,
    /// Name and bytes of each file.
    files: Vec<(String, Vec<u8>)>,
}

impl Fuzz {
    fn new() -> Self {
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
        let texts = |folder: &str, extension: &str| -> Vec<String> {
            let files = std::fs::read_dir(root.join(folder)).unwrap().map(|entry| entry.unwrap().path());
            let mut files: Vec<PathBuf> =
                files.filter(|path| path.extension().is_some_and(|e| e == extension)).collect();
            files.sort();
            files.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect()
        };
        let cases: Vec<String> = ["cases", "cases/limits", "tests/inputs/good", "tests/inputs/bad"]
            .iter()
            .flat_map(|folder| texts(folder, "toml"))
            .collect();
        let quantities = cases.iter().flat_map(|text| text.split('"').skip(1).step_by(2)).map(str::to_owned).collect();
        let table = "x,y,z,vx,vy,vz,diameter,species\n1e-3,1e-3,1e-3,0,0,0.1,4.06e-4,glass\n2e-3,1e-3,1e-3,0,0,-0.1,4.06e-4,glass\n";
        let tables = vec![table.to_owned(), "x,y,z,vx,vy,vz\n1e-3,1e-3,1e-3,0,0,0.1\n".to_owned()];
        let folder = tempfile::tempdir().unwrap();
        let mut fuzz = Self {
            states: Vec::new(),
            snapshots: snapshots(),
            checkpoint: Checkpoint::new(folder.path()),
            folder,
            root,
            quantities,
            tables,
            cases,
        };
        fuzz.states = vec![fuzz.saved()];
        fuzz
    }

    /// Text of a state file that a run has written.
    fn saved(&self) -> String {
        let out = self.folder.path().join("out");
        let run = diptych(&["run", "cases/impact.toml", "--model", "hard", "--save-state", "--quiet", "--out"])
            .arg(&out)
            .status();
        assert!(run.unwrap().success());
        std::fs::read_to_string(out.join("state.csv")).unwrap()
    }

    /// Passes one input to a reader. The reader must return; its result does not matter.
    fn one(&self, reader: &str, draw: &mut Xoshiro256PlusPlus) {
        match reader {
            "quantity" => {
                let text = mutated(pick(&self.quantities, draw), &self.quantities, draw);
                let wanted = [[1, 0, 0], [0, 0, 1], [1, 0, -1], [0, 1, -2], [0, 0, 0]][draw.random_range(0..5)];
                if let Ok(value) = parse(&text, wanted) {
                    assert!(value.is_finite(), "{text:?} is {value}");
                }
            }
            "start.csv" => self.start(reader, &mutated(pick(&self.tables, draw), &self.tables, draw)),
            "state.csv" => self.start(reader, &mutated(pick(&self.states, draw), &self.tables, draw)),
            "start.xyz" => self.start(reader, &mutated(XYZ, &self.tables, draw)),
            "start.data" => self.start(reader, &mutated(DATA, &self.tables, draw)),
            "start.dump" => self.start(reader, &mutated(DUMP, &self.tables, draw)),
            "text.stl" => {
                let part = String::from_utf8_lossy(&text("part", &cube(1.0))).into_owned();
                self.wall(reader, mutated(&part, &self.tables, draw).as_bytes());
            }
            "binary.stl" => self.wall(reader, &damaged(&binary(b"solid", &cube(1.0)), draw)),
            "wall.obj" => {
                let comb = String::from_utf8_lossy(&prism(&COMB, 1.0, 0.3)).into_owned();
                self.wall(reader, mutated(if draw.random() { CUBE } else { &comb }, &self.tables, draw).as_bytes());
            }
            "case" => {
                let text = mutated(pick(&self.cases, draw), &self.cases, draw);
                // the case is read as if from the folder of the built-in cases, so that its files are found
                let case = Case::from_text(&self.root.join("cases/fuzz.toml"), text.into(), &[]);
                // the only other possible result is an error message
                let _ = case.and_then(|case| check_text(&case));
            }
            "snapshot" => self.snapshot(draw),
            "envelope" => self.envelope(draw),
            "checkpoint" => self.checkpoint(draw),
            other => panic!("no reader {other}"),
        }
    }

    /// Reads a case whose start is this table.
    fn start(&self, name: &str, table: &str) {
        std::fs::write(self.folder.path().join(name), table).unwrap();
        let text = "[domain]\nsize = [\"4 mm\", \"4 mm\", \"4 mm\"]\n[[particles]]\nname = \"glass\"\ndiameter = \"406 um\"\ndensity = \"2500 kg/m^3\"\n\
                    file = \"NAME\"\n[contact]\nrestitution = 0.9\nfriction = 0\n[soft.linear_spring_dashpot]\nstiffness = \"1 kN/m\"\n\
                    [run]\nduration = \"1 ms\"\n";
        let text = text.replace("NAME", name);
        let case = Case::from_text(&self.folder.path().join("fuzz.toml"), text.into(), &[]).unwrap();
        let _ = [Model::Soft, Model::Hard].map(|model| case.experiment(Some(model), None).is_ok());
    }

    /// Reads a case with these triangles as a wall.
    fn wall(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.folder.path().join(name), bytes).unwrap();
        let text = "[domain]\nsize = [\"8 mm\", \"8 mm\", \"8 mm\"]\n[[particles]]\ndiameter = \"1 mm\"\ndensity = \"2500 kg/m^3\"\n\
                    count = 0\n[[walls]]\nmesh = { file = \"NAME\", unit = \"1 mm\", position = [\"2 mm\", \"2 mm\", \"2 mm\"] }\n\
                    restitution = 0.9\n[contact]\nrestitution = 0.9\n[run]\nduration = \"1 ms\"\n";
        let text = text.replace("NAME", name);
        let case = Case::from_text(&self.folder.path().join("fuzz.toml"), text.into(), &[]).unwrap();
        let _ = case.experiment(Some(Model::Hard), None).is_ok();
    }

    /// Reads a snapshot with some of its bytes changed.
    fn snapshot(&self, draw: &mut Xoshiro256PlusPlus) {
        let whole = &self.snapshots[draw.random_range(0..self.snapshots.len())];
        let _ = postcard::from_bytes::<Snapshot>(&damaged(whole, draw)).is_ok();
    }

    /// Damaged file of a checkpoint. In half of the inputs the checksum fits, so that the contents are decoded.
    fn damaged_file(&self, draw: &mut Xoshiro256PlusPlus) -> (&str, &[u8], Vec<u8>) {
        let files = &self.checkpoint.files;
        let (name, whole) = &files[draw.random_range(0..files.len())];
        let mut bytes = damaged(whole, draw);
        if draw.random() {
            bytes.truncate(bytes.len().saturating_sub(4));
            bytes.extend_from_slice(&crc32fast::hash(&bytes).to_le_bytes());
        }
        (name, whole, bytes)
    }

    /// Reads a damaged file of a checkpoint from memory.
    fn envelope(&self, draw: &mut Xoshiro256PlusPlus) {
        let (name, _, bytes) = self.damaged_file(draw);
        let _ = match name {
            "command" => open::<StoredCommand>(&bytes).is_ok(),
            "a" | "b" => open::<(u64, RunIdentity, StoredRun)>(&bytes).is_ok(),
            _ => open::<(RunIdentity, StoredRun)>(&bytes).is_ok(),
        };
    }

    /// Reads a checkpoint on the disk, one of whose files is damaged, as a resumed run does.
    fn checkpoint(&self, draw: &mut Xoshiro256PlusPlus) {
        let Checkpoint { experiment, run, .. } = &self.checkpoint;
        let (name, whole, bytes) = self.damaged_file(draw);
        let path = self.folder.path().join("checkpoint").join(name);
        std::fs::write(&path, bytes).unwrap();
        let mut store = Store::of(self.folder.path());
        let found = [store.newest().found.map(|(_, kept)| kept), store.finished(run).ok().flatten()];
        let _ = store.command().is_ok();
        for kept in found.into_iter().flatten() {
            let (mut series, mut paths, mut profiles) = observers(experiment);
            let _ = kept.pause.resume(experiment, &mut [&mut series, &mut paths, &mut profiles]).is_ok();
        }
        std::fs::write(path, whole).unwrap();
    }
}

/// Bytes with up to three damaged places.
fn damaged(whole: &[u8], draw: &mut Xoshiro256PlusPlus) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..1 + draw.random_range(0..3) {
        let at = draw.random_range(0..bytes.len());
        match draw.random_range(0..4) {
            0 => bytes[at] = draw.random(),
            1 => bytes[at] ^= 1 << draw.random_range(0..8),
            2 => bytes.truncate(at.max(1)),
            _ => drop(bytes.splice(at..at, [0xff; 9])),
        }
    }
    bytes
}

/// Observers in the run of the checkpoint.
fn observers(experiment: &Experiment) -> (Series, Paths, Accumulator) {
    let schedule = Schedule::new(experiment);
    let profiles = Accumulator::new(experiment.statistics.slices, experiment.scene.domain.size.y);
    (Series::new(experiment, &schedule), Paths::new(&schedule), profiles)
}

impl Checkpoint {
    /// Writes the checkpoint of a run that was stopped twice, and then ended.
    fn new(folder: &Path) -> Self {
        let scene = empty([5e-3; 3], [true; 3], small(), surface(0.9, 0.1));
        let mut experiment = experiment(scene, 12, [0.0; 3], 0.5, Model::Soft, 1);
        (experiment.run.duration, experiment.run.window) = (2e-3, Some(1e-5));
        let start = diptych::placement::initial_state(&experiment).unwrap();
        let run = RunIdentity::new(&experiment, start.fingerprint()).unwrap();
        let mut store = Store::of(folder);
        let arguments = ["diptych", "run", "case.toml"].map(Into::into).to_vec();
        let runs = vec![run.clone()];
        store.begin(&StoredCommand { arguments, folder: "/".into(), case: 1, runs }).unwrap();
        let (mut series, mut paths, mut profiles) = observers(&experiment);
        let mut all: [&mut dyn Observer; 3] = [&mut series, &mut paths, &mut profiles];
        let mut course = RunLoop::new(&Schedule::new(&experiment), all.len());
        let mut simulation = Simulation::new(&experiment, start);
        let mut windows = 0;
        let mut over = None;
        while over.is_none() {
            let mut leave = || {
                windows += 1;
                windows % 70 == 0
            };
            over = course.run(&mut simulation, &mut all, &mut leave).unwrap().then_some(None);
            let pause = course.store(&simulation, &all).unwrap();
            store.keep(&run, &StoredRun { pause: pause.clone(), over: None }).unwrap();
            if over.is_some() {
                store.finish(&run, &StoredRun { pause, over: over.clone() }).unwrap();
            }
        }
        let entries = std::fs::read_dir(folder.join("checkpoint")).unwrap().map(Result::unwrap);
        let file =
            |entry: std::fs::DirEntry| (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap());
        let mut files: Vec<_> = entries.map(file).collect();
        files.sort();
        assert_eq!(files.len(), 5, "the command and its copy, two generations and the end");
        Self { experiment, run, files }
    }
}

fn pick<'a>(list: &'a [String], draw: &mut Xoshiro256PlusPlus) -> &'a str {
    &list[draw.random_range(0..list.len())]
}

/// Snapshots of runs in progress, of every engine.
fn snapshots() -> Vec<Vec<u8>> {
    let scene = empty([5e-3; 3], [true; 3], small(), surface(0.9, 0.1));
    let of = |(model, stepping): (Model, SoftStepping)| {
        let mut experiment = experiment(scene.clone(), 40, [0.0; 3], 0.5, model, 1);
        (experiment.soft.stepping, experiment.soft.integrator) = (stepping, Integrator::VelocityVerlet);
        let start = diptych::placement::initial_state(&experiment).unwrap();
        let mut simulation = Simulation::new(&experiment, start);
        simulation.run(20, 1e-4).unwrap();
        postcard::to_stdvec(&simulation.snapshot().unwrap()).unwrap()
    };
    [(Model::Hard, SoftStepping::Auto), (Model::Soft, SoftStepping::Local), (Model::Soft, SoftStepping::Uniform)]
        .map(of)
        .into()
}

/// [kB] largest memory of this process up to now; `None` if the system does not report it.
fn memory() -> Option<u64> {
    let status = std::fs::read_to_string(Path::new("/proc/self/status")).ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.split_whitespace().next()?.parse().ok()
}

/// Random numbers for one input of a reader.
fn draw_of(reader: &str, number: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(number ^ reader.bytes().fold(0, |sum, byte| sum << 8 | u64::from(byte)))
}

/// Tries `inputs` inputs from number `first` on. Returns the faults, and prints the number of inputs for each reader.
fn soak(inputs: u64, first: u64) -> Vec<String> {
    let fuzz = Fuzz::new();
    let mut faults = Vec::new();
    for (reader, share) in READERS {
        let count = (inputs * share).div_ceil(1000);
        let (began, mut slowest) = (Instant::now(), Duration::ZERO);
        for number in first..first + count {
            let timed = || {
                let at = Instant::now();
                (catch_unwind(AssertUnwindSafe(|| fuzz.one(reader, &mut draw_of(reader, number)))), at.elapsed())
            };
            let (read, mut took) = timed();
            if read.is_err() {
                faults.push(format!("{reader}, input {number}: it panicked"));
            }
            // the input is tried a second time, because the process may have waited for a busy machine
            if took > LONGEST {
                took = took.min(timed().1);
            }
            slowest = slowest.max(took);
            if took > LONGEST {
                faults.push(format!("{reader}, input {number}: it took {took:?}"));
            }
            if faults.len() > 20 {
                return faults;
            }
        }
        println!("{reader}: {count} inputs in {:.1?}, the slowest in {slowest:.1?}", began.elapsed());
    }
    if let Some(most) = memory().filter(|most| *most > LARGEST) {
        faults.push(format!("{most} kB of memory"));
    }
    faults
}

#[test]
fn fuzz_a_few_inputs() {
    let faults = soak(10_000, 0);
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
#[ignore = "one input that a longer run has named: FUZZ_ONE='case 1139606' cargo test --test it -- --ignored fuzz_one --nocapture"]
fn fuzz_one_input() {
    let asked = std::env::var("FUZZ_ONE").unwrap_or_else(|_| "case 0".into());
    let (reader, number) = asked.split_once(' ').unwrap();
    let (fuzz, began) = (Fuzz::new(), Instant::now());
    fuzz.one(reader, &mut draw_of(reader, number.parse().unwrap()));
    println!("{asked}: {:.1?}", began.elapsed());
    assert!(began.elapsed() < LONGEST);
}

#[test]
#[ignore = "an hour: 10^7 inputs; FUZZ_INPUTS=1e5 for fewer: cargo test --test it -- --ignored fuzz_ --nocapture"]
fn fuzz_ten_million_inputs() {
    let inputs = std::env::var("FUZZ_INPUTS").map_or(1e7, |text| text.parse::<f64>().unwrap());
    let faults = soak(inputs as u64, 1_000_000);
    assert!(faults.is_empty(), "{faults:#?}");
}
