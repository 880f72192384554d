//! Parts of a report about each species of a mixture, and about impacts between two species or between a species and a
//! wall.

use crate::outcome::Outcome;
use crate::output::document::{Block, TextRow};
use crate::output::numbers::{count, significant, with_error};
use crate::output::{OutputError, csv};

/// Tables of the species, and of the impacts between two species or between a species and a wall. The list is empty if
/// all particles are of one species.
pub fn blocks(outcomes: &[Outcome]) -> Vec<Block> {
    if outcomes.iter().all(|outcome| outcome.kinds.species.is_empty()) {
        return Vec::new();
    }
    let species = outcomes.iter().flat_map(|outcome| {
        outcome.kinds.species.iter().map(|of| -> TextRow {
            let cells = vec![
                outcome.experiment.name.clone(),
                of.name.clone(),
                count(of.count as u64),
                significant(of.number_density, 4),
                with_error(of.velocity),
                with_error(of.temperature),
                with_error(of.random_energy),
            ];
            (false, cells)
        })
    });
    let meetings = outcomes.iter().flat_map(|outcome| {
        outcome.kinds.meetings.iter().map(|met| -> TextRow {
            let [one, other] = &met.between;
            let cells = vec![
                outcome.experiment.name.clone(),
                format!("{one} and {other}"),
                count(met.count),
                with_error(met.rate),
                significant(met.normal_speed, 3),
                significant(met.restitution_asked, 4),
                significant(met.restitution, 5),
            ];
            (false, cells)
        })
    });
    vec![
        Block::heading("Species"),
        Block::table("variant | species | particles | per m³ | U [m/s] | T [m²/s²] | m T/2 [J]", species),
        Block::note(
            "T is about the mean of the species in each slice at the same instant. Profiles of each species are in species.csv.",
        ),
        Block::table(
            "variant | who met | impacts | impacts per s | mean normal speed [m/s] | e requested | e realised",
            meetings,
        ),
    ]
}

/// Tables `species.csv` and `meetings.csv` of a mixture, each as the name and the contents of the file. The list is
/// empty if all particles are of one species.
///
/// # Errors
/// Errors of [`csv::species`].
pub fn tables(outcomes: &[Outcome]) -> Result<Vec<(String, Vec<u8>)>, OutputError> {
    if outcomes.iter().all(|outcome| outcome.kinds.species.is_empty()) {
        return Ok(Vec::new());
    }
    Ok(vec![("species.csv".to_owned(), csv::species(outcomes)?), ("meetings.csv".to_owned(), csv::meetings(outcomes)?)])
}
