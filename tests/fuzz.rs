//! Damaged and made-up inputs to every reader: none may panic, hang or fill the memory.
//!
//! Inputs are shipped ones with a few mutations each, drawn from the number of the input, so that any of them can be made again.
//! A fault is printed with its reader and number.

use crate::support::*;
use diptych::case::Case;
use diptych::case::quantity::parse;
use diptych::experiment::{Integrator, Model, SoftStepping};
use diptych::simulation::{Simulation, Snapshot};
use diptych::study::check_text;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// No reader may take longer for any of these inputs, which are some kilobytes long. They take milliseconds; the rest is for a
/// busy machine.
const LONGEST: Duration = Duration::from_secs(20);

/// [kB] of this process, all tests that run beside this one included.
const LARGEST: u64 = 2 << 20;

/// Numbers and words that readers trip over, if they do.
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

/// `from` with one to four mutations.
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

/// Puts something odd in the place of the first number after `at`.
fn odd_number(bytes: &mut Vec<u8>, at: usize, draw: &mut Xoshiro256PlusPlus) {
    let Some(start) = (at..bytes.len()).find(|k| bytes[*k].is_ascii_digit()) else { return };
    let of_a_number = |byte: &u8| byte.is_ascii_digit() || b".eE+-".contains(byte);
    let end = (start..bytes.len()).find(|k| !of_a_number(&bytes[*k])).unwrap_or(bytes.len());
    bytes.splice(start..end, ODD[draw.random_range(0..ODD.len())].bytes());
}

/// Swaps two lines, leaves one out, or brings one in from another input.
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

/// What is read, and how many of a thousand inputs go to it. Those that come to a whole case cost
/// milliseconds each, quantities microseconds.
const READERS: [(&str, u64); 5] = [("quantity", 980), ("start.csv", 7), ("state.csv", 5), ("case", 4), ("snapshot", 4)];

struct Fuzz {
    root: PathBuf,
    folder: tempfile::TempDir,
    quantities: Vec<String>,
    tables: Vec<String>,
    states: Vec<String>,
    cases: Vec<String>,
    snapshots: Vec<Vec<u8>>,
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
        let mut fuzz = Self {
            folder: tempfile::tempdir().unwrap(),
            states: Vec::new(),
            snapshots: snapshots(),
            root,
            quantities,
            tables,
            cases,
        };
        fuzz.states = vec![fuzz.saved()];
        fuzz
    }

    /// A state that a run has saved.
    fn saved(&self) -> String {
        let out = self.folder.path().join("out");
        let run = diptych(&["run", "cases/impact.toml", "--model", "hard", "--save-state", "--quiet", "--out"])
            .arg(&out)
            .status();
        assert!(run.unwrap().success());
        std::fs::read_to_string(out.join("state.csv")).unwrap()
    }

    /// One input; what it did is of no interest as long as it comes back.
    fn one(&self, reader: &str, draw: &mut Xoshiro256PlusPlus) {
        match reader {
            "quantity" => {
                let text = mutated(pick(&self.quantities, draw), &self.quantities, draw);
                let wanted = [[1, 0, 0], [0, 0, 1], [1, 0, -1], [0, 1, -2], [0, 0, 0]][draw.random_range(0..5)];
                if let Ok(value) = parse(&text, wanted) {
                    assert!(value.is_finite(), "{text:?} is {value}");
                }
            }
            "start.csv" => self.start(&mutated(pick(&self.tables, draw), &self.tables, draw)),
            "state.csv" => self.start(&mutated(pick(&self.states, draw), &self.tables, draw)),
            "case" => {
                let text = mutated(pick(&self.cases, draw), &self.cases, draw);
                // as if it stood beside the shipped ones, so that their files are found
                let case = Case::from_text(&self.root.join("cases/fuzz.toml"), text.into(), &[]);
                // a message is all that may come of it
                let _ = case.and_then(|case| check_text(&case));
            }
            "snapshot" => self.snapshot(draw),
            other => panic!("no reader {other}"),
        }
    }

    /// A case that starts from this table.
    fn start(&self, table: &str) {
        std::fs::write(self.folder.path().join("start.csv"), table).unwrap();
        let text = "[domain]\nsize = [\"4 mm\", \"4 mm\", \"4 mm\"]\n[[particles]]\nname = \"glass\"\ndiameter = \"406 um\"\ndensity = \"2500 kg/m^3\"\n\
                    file = \"start.csv\"\n[contact]\nrestitution = 0.9\nfriction = 0\n[soft.linear_spring_dashpot]\nstiffness = \"1 kN/m\"\n\
                    [run]\nduration = \"1 ms\"\n";
        let case = Case::from_text(&self.folder.path().join("fuzz.toml"), text.into(), &[]).unwrap();
        let _ = [Model::Soft, Model::Hard].map(|model| case.experiment(Some(model), None).is_ok());
    }

    /// What lasts between windows, with some of its bytes changed.
    fn snapshot(&self, draw: &mut Xoshiro256PlusPlus) {
        let whole = &self.snapshots[draw.random_range(0..self.snapshots.len())];
        let mut bytes = whole.clone();
        for _ in 0..1 + draw.random_range(0..3) {
            let at = draw.random_range(0..bytes.len());
            match draw.random_range(0..4) {
                0 => bytes[at] = draw.random(),
                1 => bytes[at] ^= 1 << draw.random_range(0..8),
                2 => bytes.truncate(at.max(1)),
                _ => drop(bytes.splice(at..at, [0xff; 9])),
            }
        }
        // decoding only: a file of it has a checksum, and nothing is taken up from one that does not fit
        let _ = postcard::from_bytes::<Snapshot>(&bytes).is_ok();
    }
}

fn pick<'a>(list: &'a [String], draw: &mut Xoshiro256PlusPlus) -> &'a str {
    &list[draw.random_range(0..list.len())]
}

/// Runs on their way, of every engine.
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

/// [kB] the most memory that this process has had, where the system tells.
fn memory() -> Option<u64> {
    let status = std::fs::read_to_string(Path::new("/proc/self/status")).ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.split_whitespace().next()?.parse().ok()
}

/// `inputs` in all, from number `first` on; gives the faults and prints how many went to each reader.
fn soak(inputs: u64, first: u64) -> Vec<String> {
    let fuzz = Fuzz::new();
    let mut faults = Vec::new();
    for (reader, share) in READERS {
        let count = (inputs * share).div_ceil(1000);
        let (began, mut slowest) = (Instant::now(), Duration::ZERO);
        for number in first..first + count {
            let at = Instant::now();
            let mut draw = Xoshiro256PlusPlus::seed_from_u64(
                number ^ reader.bytes().fold(0, |sum, byte| sum << 8 | u64::from(byte)),
            );
            if catch_unwind(AssertUnwindSafe(|| fuzz.one(reader, &mut draw))).is_err() {
                faults.push(format!("{reader}, input {number}: it panicked"));
            }
            let took = at.elapsed();
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
    let faults = soak(20_000, 0);
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
#[ignore = "a quarter of an hour: 10^7 inputs; FUZZ_INPUTS=1e5 for fewer: cargo test --test it -- --ignored fuzz_ --nocapture"]
fn fuzz_ten_million_inputs() {
    let inputs = std::env::var("FUZZ_INPUTS").map_or(1e7, |text| text.parse::<f64>().unwrap());
    let faults = soak(inputs as u64, 1_000_000);
    assert!(faults.is_empty(), "{faults:#?}");
}
