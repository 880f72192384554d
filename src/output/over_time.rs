//! CSV tables of values over time. A variant is one of the experiments of a case.

use super::OutputError;
use super::csv::{CsvTable, number};
use crate::observe::{
    FRICTION_COLUMNS, GAS_COLUMNS, OPENING_COLUMNS, PathSample, Row, SERIES_COLUMNS, SERVO_COLUMNS, SHEAR_COLUMNS,
    SONINE_COLUMNS, SeriesColumn, THERMOSTAT_COLUMNS, TURBULENCE_COLUMNS,
};
use crate::outcome::Outcome;

/// Contents of `series.csv`: averages over all particles, with one row per variant (experiment of a case) and instant.
/// Numbers of impacts and energy losses are sums since the start. Columns of friction exist only if spheres rotate, and
/// columns of turbulence only if turbulence acts on the particles. Columns of the gas, of servo walls (walls that keep
/// a pressure), of shear, of a thermostat, and of inlets and outlets exist only in scenes that have them. Columns of
/// the velocity distribution exist only if this distribution is measured.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn series(outcomes: &[Outcome]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    let has = |part: fn(&Row) -> bool| rows(outcomes, |outcome| &outcome.series.rows).any(|(_, row)| part(row));
    let further: [(&[SeriesColumn], bool); 8] = [
        (&FRICTION_COLUMNS, has(|row| row.friction.is_some())),
        (&TURBULENCE_COLUMNS, has(|row| row.turbulence.is_some())),
        (&GAS_COLUMNS, has(|row| row.gas.is_some())),
        (&SERVO_COLUMNS, has(|row| row.servo.is_some())),
        (&SHEAR_COLUMNS, has(|row| row.shear.is_some())),
        (&THERMOSTAT_COLUMNS, has(|row| row.thermostat_work.is_some())),
        (&OPENING_COLUMNS, has(|row| row.particles.is_some())),
        (&SONINE_COLUMNS, has(|row| row.sonine.is_some())),
    ];
    let further = further.into_iter().filter(|(_, has)| *has).flat_map(|(columns, _)| columns);
    let columns: Vec<&SeriesColumn> = SERIES_COLUMNS.iter().chain(further).collect();
    let names: String = columns.iter().map(|column| format!(",{}", column.key)).collect();
    table.head(&format!("variant,t_s{names}"))?;
    for (outcome, row) in rows(outcomes, |outcome| &outcome.series.rows) {
        let cells = columns.iter().map(|column| number((column.of)(row)));
        table.row([outcome.experiment.name.clone(), number(row.time)].into_iter().chain(cells))?;
    }
    table.bytes()
}

/// Contents of `paths.csv`: one row per variant (experiment of a case), instant and particle. `None` if no variant has
/// recorded paths; scenes with more than 50 particles, inlets or outlets have none. The column `overlap_m` contains the
/// largest overlap of the particle at the instant.
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
