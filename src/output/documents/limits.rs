//! Document of the study of limits, with maps of the settings for which each method fails.

use crate::output::document::{Block, Document, TextRow, text};
use crate::output::files::{MAPS, write_summary};
use crate::output::limits::{LimitsStudy, Map};
use crate::output::numbers::{count, quantity};
use crate::output::{Folder, OutputError, csv, figures};
use serde_json::json;
use std::path::PathBuf;

/// Writes all results of a study of limits: a table and a picture for each map, one page, and finally the summary.
/// Returns the path of the page.
///
/// # Errors
/// An [`OutputError`]. Files written before the error remain, but there is no `summary.json`.
pub fn write_limits(folder: &Folder, study: &LimitsStudy) -> Result<PathBuf, OutputError> {
    let mut body = vec![Block::Contents(study.maps.iter().map(|map| (map.name, map.title.clone())).collect())];
    let (mut tables, mut maps) = (Vec::new(), Vec::new());
    for (place, (map, &seconds)) in study.maps.iter().zip(study.wall_seconds).enumerate() {
        body.extend(study.section(place, map, seconds));
        tables.push((format!("{MAPS}/{}.csv", map.name), csv::limits(map)?));
        let outcomes: serde_json::Map<_, _> =
            map.outcomes().into_iter().map(|(name, number)| (name.to_owned(), number.into())).collect();
        maps.push(json!({
            "name": map.name,
            "title": map.title,
            "lesson": map.lesson,
            "points": map.rows.len(),
            "outcomes": outcomes,
            "wall_seconds": seconds,
            "command": study.command(map),
        }));
    }
    let document = Document {
        provenance: study.provenance,
        failures: Vec::new(),
        verdicts: &["Every method fails somewhere; each map shows where, by running it there.".to_owned()],
        answers: usize::MAX,
        front: Vec::new(),
        notes: &[],
        body,
        tail: Vec::new(),
        tables,
        figures: study.maps.iter().map(figures::limits).collect(),
    };
    let page = document.write_part(folder)?;
    let summary = json!({
        "title": study.provenance.title,
        "command": study.provenance.command,
        "status": "complete",
        "version": env!("CARGO_PKG_VERSION"),
        "quick": study.quick,
        "maps": maps,
    });
    write_summary(folder, &summary)?;
    Ok(page)
}

/// Table of the maps (which show for which settings a method fails) for a terminal. For each map, the table contains
/// the number of points with each outcome.
pub fn limits_answers(study: &LimitsStudy) -> String {
    let rows = study.maps.iter().map(|map| -> TextRow {
        let outcomes = map.outcomes().into_iter().map(|(name, number)| format!("{} {name}", count(number)));
        (false, vec![map.name.to_owned(), count(map.rows.len() as u64), outcomes.collect::<Vec<_>>().join(", ")])
    });
    text(&[Block::table("map | points | outcomes", rows)])
}

impl LimitsStudy<'_> {
    /// Section of the page about one map. `place` is the index of the picture of the map, and `seconds` the wall-clock
    /// time of its runs [s].
    fn section(&self, place: usize, map: &Map, seconds: f64) -> Vec<Block> {
        let outcomes: Vec<String> =
            map.outcomes().iter().map(|(name, number)| format!("{} {name}", count(*number))).collect();
        let first = map.rows.iter().find_map(|row| row.failure.as_ref());
        let mut section = vec![
            Block::Section(map.name, map.title.clone()),
            Block::Verdict(map.lesson.clone()),
            Block::Figures(place..place + 1),
            Block::entries([
                ("points", outcomes.join(", ")),
                ("numbers", format!("{MAPS}/{}.csv", map.name)),
                ("wall time", quantity(seconds, "s", 2)),
                ("again", self.command(map)),
            ]),
        ];
        section.extend(first.map(|failure| Block::Note(format!("The first failure: {failure}."))));
        section.push(Block::Source("One point as a case for diptych run".into(), map.case.into()));
        section
    }
}
