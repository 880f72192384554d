//! `diptych limits`: where does each method fail? Maps whose every point is a run and whose every failure is typed.
//!
//! One file per family of maps; each makes its points, runs them through one grid, and says what is to be learnt.

mod cells;
mod collapse;
mod cradle;
mod heating;
mod restitution;
mod scenes;
mod softness;
mod splitting;
mod stability;
mod stepped;
mod tunnelling;

use super::session::{StudyError, command_line, use_threads};
use super::terminal::{conclude, tell};
use crate::cli::{Effort, Limits};
use crate::output::limits::{LimitsStudy, Map, write_limits};
use crate::output::{Folder, Provenance};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use std::io::{IsTerminal, stderr};
use std::path::PathBuf;
use std::time::Instant;

/// How maps are made.
enum Make {
    One(fn(&Grid) -> Result<Map, StudyError>),
    /// Two of the same runs.
    Two(fn(&Grid) -> Result<[Map; 2], StudyError>),
}
use Make::{One, Two};

impl Make {
    fn maps(&self, grid: &Grid) -> Result<Vec<Map>, StudyError> {
        match self {
            One(make) => make(grid).map(|map| vec![map]),
            Two(make) => make(grid).map(Vec::from),
        }
    }
}

/// The maps by name, in the order of the page.
const MAPS: [(&[&str], Make); 17] = [
    (&["stability-verlet"], One(stability::verlet)),
    (&["stability-heun"], One(stability::heun)),
    (&["restitution-verlet"], One(restitution::verlet)),
    (&["restitution-heun"], One(restitution::heun)),
    (&["restitution-hertz"], One(restitution::hertz)),
    (&["heating"], One(heating::heating)),
    (&["tunnelling-pair"], One(tunnelling::pair)),
    (&["tunnelling-plate"], One(tunnelling::plate)),
    (&["softness"], One(softness::softness)),
    (&["collapse-line"], One(collapse::line)),
    (&["collapse-wall"], One(collapse::wall)),
    (&["collapse-gas"], One(collapse::cooling)),
    (&["rest"], One(collapse::rest)),
    (&["stepped-missed", "stepped-overlap"], Two(stepped::missed_and_overlap)),
    (&["cradle"], One(cradle::cradle)),
    (&["splitting"], One(splitting::splitting)),
    (&["simultaneous"], One(cradle::simultaneous)),
];

/// How points are run.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Coarser grids, shorter runs.
    pub quick: bool,
    /// No progress.
    pub quiet: bool,
}

impl Grid {
    /// Runs all points, several at once, and gives their results in the order of the points, whatever thread ran them.
    fn run<P: Sync, R: Send>(
        &self,
        name: &'static str,
        points: &[P],
        one: impl Fn(&P) -> Result<R, StudyError> + Sync,
    ) -> Result<Vec<R>, StudyError> {
        let bar = if self.quiet { ProgressBar::hidden() } else { ProgressBar::new(points.len() as u64) };
        // a template that does not parse would only lose its looks
        if let Ok(style) = ProgressStyle::with_template("{bar:16} {pos} of {len} points, {eta} left  {wide_msg}") {
            bar.set_style(style);
        }
        bar.set_message(name);
        let began = Instant::now();
        let each = points.par_iter().with_max_len(1).map(|point| {
            let result = one(point);
            bar.inc(1);
            result
        });
        let results = each.collect();
        bar.finish_and_clear();
        if !self.quiet && !stderr().is_terminal() {
            tell(format_args!("{name}: {} points in {:.1} s", points.len(), began.elapsed().as_secs_f64()));
        }
        results
    }
}

/// The map of that name; `None` if there is none.
///
/// # Errors
/// A scene that could not be made, which would be a fault of the program.
pub fn map(name: &str, grid: &Grid) -> Option<Result<Map, StudyError>> {
    let (_, make) = MAPS.iter().find(|(names, _)| names.contains(&name))?;
    make.maps(grid).map(|maps| maps.into_iter().find(|map| map.name == name)).transpose()
}

/// The names of all maps.
pub fn names() -> impl Iterator<Item = &'static str> {
    MAPS.iter().flat_map(|(names, _)| names.iter().copied())
}

/// Runs the maps and writes one folder.
///
/// # Errors
/// Bad input before anything is computed; what the disk refuses after. Failures of engines are results here.
pub fn limits(args: &Limits) -> Result<(), StudyError> {
    if let Some(unknown) = args.only.iter().find(|name| !names().any(|known| known == *name)) {
        let names: Vec<&str> = names().collect();
        return Err(StudyError::Input(format!(
            "error: there is no map `{unknown}`\nhelp: the maps are {}",
            names.join(", ")
        )));
    }
    use_threads(&Effort { threads: args.threads, seed: None })?;
    let path = args.output.out.clone().unwrap_or_else(|| PathBuf::from("out/limits"));
    let folder =
        Folder::create(path, args.output.overwrite).map_err(|error| StudyError::Input(format!("error: {error}")))?;
    let grid = Grid { quick: args.quick, quiet: args.output.quiet };
    let (mut maps, mut wall_seconds) = (Vec::new(), Vec::new());
    let wanted = |name: &str| args.only.is_empty() || args.only.iter().any(|only| only == name);
    for (_, make) in MAPS.iter().filter(|(names, _)| names.iter().any(|name| wanted(name))) {
        let began = Instant::now();
        let made = make.maps(&grid)?;
        let seconds = began.elapsed().as_secs_f64();
        for map in made.into_iter().filter(|map| wanted(map.name)) {
            maps.push(map);
            wall_seconds.push(seconds);
        }
    }
    let provenance = Provenance {
        title: "Where each method fails".into(),
        command: command_line(),
        case_path: "built in; each map shows one of its points".into(),
        ..Provenance::default()
    };
    let study = LimitsStudy { provenance: &provenance, maps: &maps, wall_seconds: &wall_seconds, quick: args.quick };
    let report = write_limits(&folder, &study)?;
    if !args.output.quiet {
        let lessons: Vec<String> = maps.iter().map(|map| format!("{}: {}", map.name, map.lesson)).collect();
        conclude(&lessons, "Report", &report);
    }
    Ok(())
}
