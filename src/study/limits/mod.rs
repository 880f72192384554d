//! `diptych limits`: maps of the parameters with which each method fails. A point of a map is one or several runs, and
//! every failure has a type, such as `InelasticCollapse`.
//!
//! The scene of each map is a case file in `cases/limits/`. The heading of the file contains the question, the meaning
//! of a point, and the columns of the table. A sweep is a set of points from which one or several maps are made. For
//! each family of maps, one file of this folder defines the changes from point to point and the conclusion from the
//! results.

mod anisotropy;
mod collapse;
mod cradle;
mod heating;
mod picture;
mod restitution;
mod scenes;
mod softness;
mod splitting;
mod stability;
mod stepped;
mod sweep;
mod tunnelling;
mod walton;

use crate::case::Case;
use crate::cli::Limits;
use crate::output::limits::{LimitsStudy, Map};
use crate::output::{Folder, Provenance, limits_answers, write_limits};
use crate::runs::{StudyError, command_line, conclude, use_threads};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use sweep::{MapSweep, Points};

pub use sweep::Grid;

/// Name of a map, text of its case file, and names of the columns of its table, separated by commas.
type MapEntry = (&'static str, &'static str, &'static str);

/// Maps that are made from one sweep (set of points), and the function that runs the sweep. The function returns one
/// result for each map.
type MapRun = (&'static [MapEntry], fn(&Points) -> Result<Vec<MapSweep>, StudyError>);

macro_rules! map {
    ($name:literal, $columns:literal) => {
        ($name, include_str!(concat!("../../../cases/limits/", $name, ".toml")), $columns)
    };
}

/// All sweeps (sets of points from which maps are made), in the order of the maps on the page of the report.
const SWEEPS: [MapRun; 20] = [
    (&[map!("stability-verlet", "reduced_step,restitution,growth,limit")], stability::stability),
    (&[map!("stability-heun", "reduced_step,restitution,growth,limit")], stability::stability),
    (
        &[map!("restitution-verlet", "steps_per_contact,restitution,mean,least,largest,predicted")],
        restitution::restitution,
    ),
    (
        &[map!("restitution-heun", "steps_per_contact,restitution,mean,least,largest,predicted")],
        restitution::restitution,
    ),
    (
        &[map!("restitution-hertz", "steps_per_contact,restitution,mean,least,largest,predicted")],
        restitution::restitution,
    ),
    (&[map!("heating", "steps_per_contact,heating,heating_se,predicted")], heating::heating),
    (&[map!("tunnelling-pair", "impact_speed_m_s,stiffness_n_m,overlap,predicted")], tunnelling::pair),
    (&[map!("tunnelling-plate", "reduced_speed,steps_per_contact,stopped,passed")], tunnelling::plate),
    (
        &[map!("softness", "softness,rate_ratio,rate_ratio_se,predicted,hard_of_d_eff,volume_fraction_error")],
        softness::softness,
    ),
    (
        &[map!("anisotropy", "kappa_n,softness,rate_ratio,rate_ratio_se,predicted,cross_section")],
        anisotropy::anisotropy_decay,
    ),
    (&[map!("collapse-line", "spheres,restitution,collapsed,threshold")], collapse::one_dimension),
    (&[map!("collapse-wall", "spheres,restitution,collapsed,threshold")], collapse::one_dimension),
    (&[map!("collapse-gas", "volume_fraction,restitution,collisions")], collapse::cooling),
    (&[map!("rest", "contact_time_s,t_s,rate_1_s,kept")], collapse::rest),
    (
        &[
            map!("stepped-missed", "theta,missed,missed_se,rate_error,rate_error_se"),
            map!("stepped-overlap", "theta,overlap,overlap_se,overlap_99,estimate"),
        ],
        stepped::missed_and_overlap,
    ),
    (
        &[map!(
            "cradle",
            "spheres,restitution,last_soft_m_s,last_hard_m_s,first_soft_m_s,first_hard_m_s,energy_soft,energy_hard"
        )],
        cradle::cradle,
    ),
    (&[map!("splitting", "window_s,place_error_m,velocity_error_m_s")], splitting::splitting),
    (&[map!("simultaneous", "late,middle_soft_m_s,middle_hard_m_s")], cradle::simultaneous),
    (&[map!("walton-spring", "reduced_slip,tangential_restitution,rebound,walton,error")], walton::walton),
    (&[map!("walton-undamped", "reduced_slip,tangential_restitution,rebound,walton,error")], walton::walton),
];

/// Runs all points of one sweep (entry of `SWEEPS`: a set of points from which maps are made). Returns its maps in the
/// order of the entry.
fn sweep(&(entries, run): &MapRun, grid: &Grid) -> Result<Vec<Map>, StudyError> {
    let cases: Vec<Case> = entries
        .iter()
        .map(|&(name, text, _)| Case::from_text(Path::new(&format!("cases/limits/{name}.toml")), Arc::from(text), &[]))
        .collect::<Result<_, _>>()?;
    let (base, _) = cases[0].experiment(None, None)?;
    let found = run(&Points { grid, name: entries[0].0, base })?;
    let maps = entries.iter().zip(cases).zip(found).map(|((&(name, case, columns), read), found)| Map {
        name,
        method: read.heading.split("\n\n").nth(1).unwrap_or_default().replace('\n', " "),
        title: read.title,
        lesson: found.lesson,
        columns: columns.split(',').collect(),
        rows: found.rows,
        picture: found.picture,
        case,
    });
    Ok(maps.collect())
}

/// Computes the map with the name `name`; `None` if there is no such map.
///
/// # Errors
/// Returns an error if the particles of a point cannot be placed. This would be a fault of the program.
pub fn map(name: &str, grid: &Grid) -> Option<Result<Map, StudyError>> {
    let one = SWEEPS.iter().find(|(entries, _)| entries.iter().any(|entry| entry.0 == name))?;
    sweep(one, grid).map(|maps| maps.into_iter().find(|map| map.name == name)).transpose()
}

/// Names of all maps, in their order on the page of the report.
pub fn names() -> impl Iterator<Item = &'static str> {
    SWEEPS.iter().flat_map(|(entries, _)| entries.iter().map(|entry| entry.0))
}

/// Computes the requested maps, all maps by default, and writes them to one folder.
///
/// # Errors
/// Returns an error for bad input, before anything is computed, or for a file that cannot be written. Failures of
/// engines are no errors, but results of this command.
pub fn limits(args: &Limits) -> Result<(), StudyError> {
    if let Some(unknown) = args.only.iter().find(|name| !names().any(|known| known == *name)) {
        let names: Vec<&str> = names().collect();
        return Err(StudyError::Input(format!(
            "error: there is no map `{unknown}`\nhelp: the maps are {}",
            names.join(", ")
        )));
    }
    use_threads(args.threads.map(usize::from))?;
    let path = args.output.out.clone().unwrap_or_else(|| PathBuf::from("out/limits"));
    let folder =
        Folder::create(path, args.output.overwrite).map_err(|error| StudyError::Input(format!("error: {error}")))?;
    let grid = Grid { quick: args.quick, quiet: args.output.quiet };
    let (mut maps, mut wall_seconds) = (Vec::new(), Vec::new());
    let wanted = |name: &str| args.only.is_empty() || args.only.iter().any(|only| only == name);
    for one in SWEEPS.iter().filter(|(entries, _)| entries.iter().any(|entry| wanted(entry.0))) {
        let began = Instant::now();
        let made = sweep(one, &grid)?;
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
        let lessons = maps.iter().map(|map| format!("{}: {}", map.name, map.lesson));
        let said: Vec<String> = std::iter::once(limits_answers(&study)).chain(lessons).collect();
        conclude(&said, "Report", &report);
    }
    Ok(())
}
