//! Averages over all particles of a trajectory file at each instant, as a table with the columns of `series.csv`.

use super::table::NumberTable;
use crate::case::{Diagnostic, ParticleFrame, Sources, particle_frames};
use crate::domain::Domain;
use crate::observe::{Row, SERIES_COLUMNS, SeriesColumn};
use crate::statistics::VelocitySpread;
use nalgebra::Vector3;

/// Name of the column with the number of particles, in the table of a trajectory.
const COUNT: &str = "particles";

/// Columns of `series.csv` that can be computed from the velocities of the particles alone.
const OF_VELOCITIES: [&str; 7] = [
    "granular_temperature_m2_s2",
    "Txx_m2_s2",
    "Tyy_m2_s2",
    "Tzz_m2_s2",
    "mean_velocity_x_m_s",
    "mean_velocity_y_m_s",
    "mean_velocity_z_m_s",
];

/// Columns of `series.csv` that need the masses of the particles as well as their velocities. The last five are
/// columns of rotation; they exist only if the trajectory has spins.
const OF_MASSES: [&str; 12] = [
    "kinetic_energy_J",
    "momentum_x_kg_m_s",
    "momentum_y_kg_m_s",
    "momentum_z_kg_m_s",
    "centre_of_mass_x_m",
    "centre_of_mass_y_m",
    "centre_of_mass_z_m",
    "rotational_energy_J",
    "rotational_temperature_m2_s2",
    "Rxx_m2_s2",
    "Ryy_m2_s2",
    "Rzz_m2_s2",
];

/// Name of a column in the table of a trajectory, and its value at one instant. The unit is part of the name; `None`
/// without a value.
type AveragedColumn = (String, Option<f64>);

impl NumberTable {
    /// Fills the table from the text of a trajectory, which has the particles of several instants. Returns false if
    /// the text is no trajectory. With `slices`, the box is divided into this number of slices along y, and each slice
    /// has its own columns. Temperatures are then relative to the mean velocities of the slices.
    ///
    /// # Errors
    /// Returns an error for a line that cannot be read, or if slices are asked for and the trajectory has no box.
    pub(super) fn trajectory(
        &mut self,
        text: &str,
        slices: Option<usize>,
        sources: &Sources,
    ) -> Result<bool, Diagnostic> {
        let Some((frames, warnings)) = particle_frames((self.source, text), sources)? else {
            return Ok(false);
        };
        self.warnings = warnings;
        let (time, times) = times(&frames);
        for (frame, now) in frames.iter().zip(times) {
            if slices.is_some_and(|slices| slices > 1) && frame.domain.is_none() {
                let message = "the particles of this instant have no box that slices could divide";
                let help = "leave out `slices`, or write the box (XYZ: `Lattice`, dump: BOX BOUNDS)";
                return Err(sources.error(&frame.origin, message).help(help));
            }
            let (mut names, mut cells) = (vec![time.to_owned()], vec![format!("{now:?}")]);
            for (name, value) in columns(frame, slices.unwrap_or(1)) {
                names.push(name);
                cells.push(value.map_or(String::new(), |value| format!("{value:?}")));
            }
            if self.columns.is_empty() {
                self.head(names);
            } else if self.columns != names {
                let message = "this instant has other columns than the first one: masses, spins or periodic sides";
                return Err(sources.error(&frame.origin, message).help("give all instants of a file the same columns"));
            }
            self.row(&cells, frame.origin.span.clone(), sources)?;
        }
        Ok(true)
    }
}

/// Name of the column of times, and the time of each instant of a trajectory. Times are in seconds if every instant has
/// a time, else they are numbers of time steps. Without these numbers, the index of the instant counts as its time.
fn times(frames: &[ParticleFrame]) -> (&'static str, Vec<f64>) {
    let all = |of: fn(&ParticleFrame) -> Option<f64>| frames.iter().map(of).collect::<Option<Vec<f64>>>();
    if let Some(times) = all(|frame| frame.time) {
        return ("time_s", times);
    }
    match all(|frame| frame.step) {
        Some(steps) => ("Step", steps),
        None => ("frame", (0..frames.len()).map(|place| place as f64).collect()),
    }
}

/// Averages over the particles of one instant, each with the name of its column. If `slices` exceeds 1, the box is
/// divided into this number of slices along y. Each slice then adds its number of particles, mean velocity and
/// temperatures.
fn columns(frame: &ParticleFrame, slices: usize) -> Vec<AveragedColumn> {
    // a trajectory without a box gets an infinite box without periodic sides; one slice contains all particles
    let domain = frame.domain.clone().unwrap_or_else(|| Domain::new(Vector3::repeat(f64::INFINITY), [false; 3]));
    let particles = &frame.particles;
    let row = Row::of_sample(0.0, particles.into(), particles.mean_velocity(), (&domain, slices));
    let wanted = |key: &&str| OF_VELOCITIES.contains(key) || frame.has_masses && OF_MASSES.contains(key);
    let mut all = vec![(COUNT.to_owned(), Some(particles.len() as f64))];
    // a quantity that is not defined at this instant, such as the centre of mass along a periodic side, has no column
    let is_there = |one: &&SeriesColumn| OF_VELOCITIES.contains(&one.key) || (one.of)(&row).is_some();
    let own = SERIES_COLUMNS.iter().filter(|one| wanted(&one.key)).filter(is_there);
    all.extend(own.map(|one| (one.key.to_owned(), (one.of)(&row))));
    if slices > 1 {
        let spread = VelocitySpread::of(particles, slices, domain.size.y);
        for (number, (count, mean, temperature)) in spread.of_slices().enumerate() {
            let mut push = |name: &str, value: Option<f64>| all.push((format!("{name}[{}]", number + 1), value));
            push(COUNT, Some(count));
            for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
                push(&format!("mean_velocity_{letter}_m_s"), mean.map(|mean| mean[axis]));
                push(&format!("T{letter}{letter}_m2_s2"), temperature.map(|parts| parts[axis]));
            }
        }
    }
    all
}
