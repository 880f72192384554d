//! The tables of values over time.

use super::OutputError;
use super::csv::{CsvTable, number};
use crate::observe::{PathSample, RotationSums, Row};
use crate::outcome::Outcome;
use nalgebra::Vector3;

/// `series.csv`: one row per variant and instant with averages over all particles. Impacts are counted since the start.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn series(outcomes: &[Outcome]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head(
        "variant,t_s,granular_temperature_m2_s2,Txx_m2_s2,Tyy_m2_s2,Tzz_m2_s2,\
         mean_velocity_x_m_s,mean_velocity_y_m_s,mean_velocity_z_m_s,kinetic_energy_J,elastic_energy_J,\
         momentum_x_kg_m_s,momentum_y_kg_m_s,momentum_z_kg_m_s,pair_impacts,wall_impacts,coordination_number,largest_overlap,\
         centre_of_mass_x_m,centre_of_mass_y_m,centre_of_mass_z_m,rotational_energy_J,rotational_temperature_m2_s2,\
         Rxx_m2_s2,Ryy_m2_s2,Rzz_m2_s2,mean_spin_x_rad_s,mean_spin_y_rad_s,mean_spin_z_rad_s",
    )?;
    for (outcome, row) in rows(outcomes, |outcome| &outcome.series.rows) {
        let Row { time, velocity, kinetic_energy, elastic_energy, momentum, .. } = row;
        let spread: [Option<f64>; 3] = std::array::from_fn(|axis| row.temperature.map(|parts| parts[axis]));
        let head = [Some(*time), row.granular_temperature()].into_iter().chain(spread).map(number);
        let vectors = |vector: &Vector3<f64>| <[f64; 3]>::from(*vector).map(number);
        let energies = [*kinetic_energy, *elastic_energy].map(number);
        let counts = [row.pair_impacts, row.wall_impacts].map(|count| count.to_string());
        let contacts = [row.coordination, row.largest_overlap].map(number);
        let cells = head.chain(vectors(velocity)).chain(energies).chain(vectors(momentum));
        let cells = cells.chain(counts).chain(contacts).chain(row.centre.map(number));
        // empty where spheres do not rotate
        let of_three = |of: fn(&RotationSums) -> Vector3<f64>| {
            let of = row.rotation.as_ref().map(of);
            std::array::from_fn::<_, 3, _>(|axis| of.map(|vector| vector[axis])).map(number)
        };
        let rotation = [row.rotation.map(|sums| sums.energy), row.rotational_temperature()].map(number);
        let cells = cells.chain(rotation).chain(of_three(|sums| sums.temperature)).chain(of_three(|sums| sums.spin));
        table.row(std::iter::once(outcome.experiment.name.clone()).chain(cells))?;
    }
    table.bytes()
}

/// `paths.csv`: one row per variant, instant and particle, for up to 50 particles; `None` for more. The overlap is the
/// largest of the particle at that instant.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn paths(outcomes: &[Outcome]) -> Result<Option<Vec<u8>>, OutputError> {
    if outcomes.iter().all(|outcome| outcome.paths.points.is_empty()) {
        return Ok(None);
    }
    let mut table = CsvTable::new();
    table.head("variant,t_s,id,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,overlap_m,wx_rad_s,wy_rad_s,wz_rad_s")?;
    for (outcome, point) in rows(outcomes, |outcome| &outcome.paths.points) {
        let PathSample { time, id, position, velocity, spin, overlap } = point;
        let numbers = position.iter().chain(velocity).chain([overlap]).copied().map(number);
        let head = [outcome.experiment.name.clone(), number(*time), id.to_string()];
        let spins = std::array::from_fn::<_, 3, _>(|axis| spin.map(|spin| spin[axis])).map(number);
        table.row(head.into_iter().chain(numbers).chain(spins))?;
    }
    table.bytes().map(Some)
}

fn rows<'a, T: 'a>(
    outcomes: &'a [Outcome],
    of: impl Fn(&'a Outcome) -> &'a Vec<T>,
) -> impl Iterator<Item = (&'a Outcome, &'a T)> {
    outcomes.iter().flat_map(move |outcome| of(outcome).iter().map(move |row| (outcome, row)))
}
