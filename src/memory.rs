//! Memory that this process may still take, and what is said where it is not enough.
//!
//! An allocation that fails ends the program without a word. What is large is therefore compared with what is free before it is made.

use crate::experiment::Experiment;
use crate::schedule::Schedule;

/// [byte] per particle: the bound of `tests/memory.rs` for dense scenes of either model.
const PARTICLE: f64 = 350.0;

/// [byte] per slice and block of time: twenty sums, and as much again while averages are made of them (`statistics/profiles.rs`).
const SLICE: f64 = 2.0 * 20.0 * 8.0;

/// Blocks of time at most, however many samples there are (`statistics/profiles.rs`).
const MOST_BLOCKS: f64 = 512.0;

/// Memory that a run takes [byte].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// [byte] of particles, their neighbours and contacts.
    pub particles: f64,
    /// [byte] of averages in slices.
    pub slices: f64,
}

impl Need {
    /// The memory that an experiment takes.
    pub fn of(experiment: &Experiment) -> Self {
        let kinds = experiment.scene.species.len();
        // a mixture has averages of each kind beside those of all
        let tables = if kinds > 1 { 1 + kinds } else { 1 } as f64;
        let samples = Schedule::new(experiment).samples as f64 + 1.0;
        let slices = experiment.statistics.slices as f64;
        Self {
            particles: PARTICLE * experiment.count() as f64,
            slices: SLICE * slices * samples.min(MOST_BLOCKS) * tables,
        }
    }

    /// [byte] of all.
    pub fn total(&self) -> f64 {
        self.particles + self.slices
    }
}

/// [byte] that this process may still take: what the machine has free, within the limit of the process (`ulimit -v`) and that of its container;
/// `None` where the system does not tell.
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

/// Elsewhere it is not known.
#[cfg(not(target_os = "linux"))]
pub fn available() -> Option<f64> {
    None
}

/// Why so many bytes cannot be had: how many there are; `None` if they can, or if that is not known.
pub fn lack(need: f64) -> Option<String> {
    let there = available().filter(|there| need > *there)?;
    Some(format!("about {} of memory, and {} are free for this process", size(need), size(there)))
}

/// Why a run cannot have the memory that it takes, and the remedy.
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

/// Bytes in words.
pub fn size(bytes: f64) -> String {
    match bytes {
        few if few < 1e6 => format!("{:.0} kB", (1e-3 * few).ceil()),
        some if some < 1e9 => format!("{:.0} MB", 1e-6 * some),
        many => format!("{:.1} GB", 1e-9 * many),
    }
}
