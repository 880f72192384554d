//! The page of the study of limits.

use super::{dictionary, note, page};
use crate::output::limits::{LimitsStudy, MAPS, Map, outcome};
use crate::output::numbers::{count, quantity};
use maud::{Markup, PreEscaped, html};

/// The page of a study of limits; one picture per map.
pub fn limits(study: &LimitsStudy, pictures: &[String]) -> String {
    let body = html! {
        ol { @for map in study.maps { li { a href={ "#" (map.name) } { (map.title) } } } }
        @for ((map, picture), seconds) in study.maps.iter().zip(pictures).zip(study.wall_seconds) {
            (section(study, map, picture, *seconds))
        }
    };
    let verdicts = ["Every method fails somewhere; each map shows where, by running it there.".to_owned()];
    page(study.provenance, &verdicts, &[], &body, &html! {})
}

fn section(study: &LimitsStudy, map: &Map, picture: &str, seconds: f64) -> Markup {
    let mut outcomes: Vec<(String, u64)> = Vec::new();
    for row in &map.rows {
        let name = outcome(row.failure.as_ref());
        match outcomes.iter_mut().find(|(known, _)| *known == name) {
            Some((_, number)) => *number += 1,
            None => outcomes.push((name, 1)),
        }
    }
    let outcomes: Vec<String> = outcomes.iter().map(|(name, number)| format!("{} {name}", count(*number))).collect();
    let first = map.rows.iter().find_map(|row| row.failure.as_ref());
    let entries = [
        ("points", outcomes.join(", ")),
        ("numbers", format!("{MAPS}/{}.csv", map.name)),
        ("wall time", quantity(seconds, "s", 2)),
    ];
    html! {
        h2 id=(map.name) { (map.title) }
        p.verdict { (map.lesson) }
        div.figures { figure { (PreEscaped(picture)) figcaption { (map.method) } } }
        (dictionary(&entries))
        p { "Again: " code { (study.command(map)) } }
        @if let Some(failure) = first { (note(&format!("The first failure: {failure}."))) }
        details { summary { "One point as a case for " code { "diptych run" } } pre { (map.case) } }
    }
}
