//! Finds the required keys that a case lacks, and lists all of them in one message.

use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, ParticlesFile};
use crate::case::rules::{MissingKey, alternatives, missing};
use crate::case::source::{Origin, Sources};
use crate::case::tree::CaseNode;
use crate::experiment::Model;

/// Refuses a case that lacks required keys for the collision model `model`. `None` means that no model was chosen.
///
/// # Errors
/// The missing keys, all in one message.
pub fn refuse_missing<'a>(
    (file, tree): (&'a CaseFile, &'a CaseNode),
    model: Option<Model>,
    sources: &Sources,
) -> Result<(), Diagnostic> {
    let mut keys = missing(tree);
    let mut need = |is_there: bool, key: &str, table: Option<&'a Origin>| {
        if !is_there {
            keys.push(MissingKey { path: key.into(), alternatives: Vec::new(), table });
        }
    };
    let kinds = || file.particles.iter().flatten();
    let has_inlets = file.inlets.as_ref().is_some_and(|inlets| !inlets.is_empty());
    if has_inlets || kinds().count() > 1 || kinds().any(|kind| !is_alone(&kind.value)) {
        let contact = file.contact.as_ref();
        let is_there = contact.is_some_and(|contact| contact.value.restitution.is_some());
        need(is_there, "contact.restitution", contact.map(|contact| &contact.origin));
    }
    for wall in file.walls.iter().flatten() {
        let Some(cylinder) = &wall.value.cylinder else { continue };
        let is_pipe = cylinder.value.inside.as_ref().is_some_and(|inside| inside.value);
        let is_there = is_pipe || cylinder.value.half_height.is_some();
        need(is_there, &format!("{}.half_height", cylinder.path), Some(&cylinder.origin));
    }
    if model.is_some_and(Model::has_contacts) {
        let laws = alternatives("soft", "linear_spring_dashpot");
        let soft = tree.get("soft");
        let is_there = soft.is_some_and(|soft| laws.iter().any(|law| soft.get(law).is_some()));
        need(is_there, "soft.linear_spring_dashpot.stiffness", soft.map(|soft| &soft.origin));
    }
    need(model.is_some(), "run.model", file.run.as_ref().map(|run| &run.origin));
    into_error(&keys, sources)
}

/// True if the case places at most one particle of a kind at the start. Particles of inlets are not counted.
fn is_alone(kind: &ParticlesFile) -> bool {
    match (&kind.count, &kind.at) {
        (Some(count), _) => count.value <= 1,
        (_, Some(list)) => list.value.len() <= 1,
        _ => false,
    }
}

fn into_error(keys: &[MissingKey], sources: &Sources) -> Result<(), Diagnostic> {
    if keys.is_empty() {
        return Ok(());
    }
    let named = |key: &MissingKey| {
        let or = if key.alternatives.is_empty() {
            String::new()
        } else {
            format!(" (or `{}`)", key.alternatives.join("`, `"))
        };
        let line = key.table.map(|origin| sources.line(origin)).filter(|line| *line > 0);
        let table = line.map_or(String::new(), |line| format!(" (table in line {line})"));
        format!("`{}`{or}{table}", key.path)
    };
    let list: Vec<String> = keys.iter().map(named).collect();
    let plural = if list.len() == 1 { "a required key is missing" } else { "required keys are missing" };
    let first_table = keys.iter().find_map(|key| key.table);
    // if no missing key belongs to a table of the case, the error is about the case file as a whole, which is the
    // source with the index 0
    let whole = Origin { source: 0, span: 0..0 };
    let mut diagnostic = sources.error(first_table.unwrap_or(&whole), format!("{plural}: {}", list.join(", ")));
    if first_table.is_none()
        && let Some(place) = &mut diagnostic.place
    {
        place.line = 0;
    }
    Err(diagnostic.help("add them, or name a set of values with `use`; `cases/quick.toml` is a complete case"))
}
