//! Memory that this process may still use, and the message about a run that needs more memory.
//!
//! An allocation that fails ends the program without a message. The program therefore compares the size of large data
//! with the free memory before it allocates them.

use crate::experiment::Experiment;
use crate::schedule::Schedule;

/// [byte] memory per particle: upper limit for dense scenes of soft or of hard spheres, tested in `tests/memory.rs`.
const PARTICLE: f64 = 350.0;

/// [byte] memory of one slice of the box across y for one block of time (an interval of the run that is averaged by
/// itself). It holds twenty sums of 8 bytes, stored twice while averages are computed from them
/// (`statistics/profiles.rs`).
const SLICE: f64 = 2.0 * 20.0 * 8.0;

/// Largest number of blocks of time into which the samples (instants of measurement) of a run are grouped for averages
/// (`statistics/profiles.rs`).
const MOST_BLOCKS: f64 = 512.0;

/// Estimated memory that a run needs [byte].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// [byte] memory for particles, their neighbours and contacts.
    pub particles: f64,
    /// [byte] memory for the averages in slices of the box across y.
    pub slices: f64,
}

impl Need {
    /// Estimates the memory that an experiment needs.
    pub fn of(experiment: &Experiment) -> Self {
        let kinds = experiment.scene.species.len();
        // a mixture has one table of averages per species and one for all species together
        let tables = if kinds > 1 { 1 + kinds } else { 1 } as f64;
        let samples = Schedule::new(experiment).samples as f64 + 1.0;
        let slices = experiment.statistics.slices as f64;
        Self {
            particles: PARTICLE * experiment.expected_count(),
            slices: SLICE * slices * samples.min(MOST_BLOCKS) * tables,
        }
    }

    /// [byte] memory for the particles and for the averages in slices together.
    pub fn total(&self) -> f64 {
        self.particles + self.slices
    }
}

/// [byte] memory that this process may still use; `None` if the system does not report it. The result is the smallest
/// of three numbers: the free memory of the machine, and the unused memory within the limits of the process (`ulimit
/// -v`) and of its container.
#[cfg(target_os = "linux")]
pub fn available() -> Option<f64> {
    use procfs::process::{LimitValue, Process};
    use procfs::{Current, Meminfo};
    let of_machine = Meminfo::current().ok().and_then(|memory| memory.mem_available);
    let of_process = Process::myself().ok().and_then(|process| {
        let LimitValue::Value(limit) = process.limits().ok()?.max_address_space.soft_limit else { return None };
        Some(limit.saturating_sub(process.statm().ok()?.size * procfs::page_size()))
    });
    let number = |name: &str| {
        let text = std::fs::read_to_string(format!("/sys/fs/cgroup/memory.{name}")).ok()?;
        text.trim().parse::<u64>().ok()
    };
    let of_container = number("max").and_then(|limit| Some(limit.saturating_sub(number("current")?)));
    [of_machine, of_process, of_container].into_iter().flatten().min().map(|bytes| bytes as f64)
}

/// Returns `None`, because the free memory is not known on systems other than Linux.
#[cfg(not(target_os = "linux"))]
pub fn available() -> Option<f64> {
    None
}

/// Text that states the memory `need` [byte] and the free memory; `None` if enough is free, or if the free memory is
/// not known.
pub fn lack(need: f64) -> Option<String> {
    let there = available().filter(|there| need > *there)?;
    Some(format!("about {} of memory, and {} are free for this process", size(need), size(there)))
}

/// The error message and the remedy for a run that needs more memory than is free; `None` if enough is free.
pub fn refusal(experiment: &Experiment) -> Option<(String, String)> {
    let need = Need::of(experiment);
    let lack = lack(need.total())?;
    let of = |bytes: f64, what: String| (bytes, format!("{} for {what}", size(bytes)));
    let mut parts = [
        of(need.particles, format!("{} particles", experiment.count())),
        of(need.slices, format!("{} slices", experiment.statistics.slices)),
    ];
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [(_, most), (_, least)] = parts;
    let message = format!("\"{}\" takes {lack}: {most}, {least}", experiment.name);
    Some((
        message,
        "ask for less of the first, or raise the limit of the process (`ulimit -v`) or use a larger machine".into(),
    ))
}

/// Text of a number of bytes with its unit, such as "3 MB".
pub fn size(bytes: f64) -> String {
    match bytes {
        few if few < 1e6 => format!("{:.0} kB", (1e-3 * few).ceil()),
        some if some < 1e9 => format!("{:.0} MB", 1e-6 * some),
        many => format!("{:.1} GB", 1e-9 * many),
    }
}
