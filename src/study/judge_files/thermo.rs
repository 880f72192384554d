//! Reads thermo output of LAMMPS and LIGGGHTS from their logs: tables of averages over all particles, such as
//! temperature and energy, with one row per printed time step.
//!
//! Format: LAMMPS documentation, commands `thermo_style` and `thermo_modify line`,
//! <https://docs.lammps.org/thermo_style.html>.

use super::table::{NumberTable, words};
use crate::case::{Diagnostic, Sources};
use std::ops::Range;

/// Beginnings of the line before the header of a table of thermo output, in present and in older versions of LAMMPS.
const BEFORE_HEADER: [&str; 2] = ["Per MPI rank memory allocation", "Memory usage per processor"];

/// Beginning of the line with the names of the columns, in the style `yaml` of thermo output.
const YAML_HEADER: &str = "keywords:";

impl NumberTable {
    /// Reads the tables of thermo output in a LAMMPS log. Each table ends at a line with `Loop time`. The rows of all
    /// tables with the same header as the last table are read. Returns false if the text contains no header.
    pub(super) fn thermo(&mut self, text: &str, lines: &[Range<usize>], sources: &Sources) -> Result<bool, Diagnostic> {
        let line = |place: usize| text[lines[place].clone()].trim();
        let is_header = |place: usize| {
            let follows = place > 0 && BEFORE_HEADER.iter().any(|start| line(place - 1).starts_with(start));
            line(place).starts_with(YAML_HEADER)
                || words(line(place)).next() == Some("Step")
                || follows && !line(place).starts_with("---")
        };
        let Some(header) = (0..lines.len()).rev().find(|&place| is_header(place)) else { return Ok(false) };
        let wanted = cells(line(header));
        self.head(wanted.iter().map(|name| name.trim_matches(['\'', '"']).to_owned()).collect());
        let mut inside = false;
        for place in 0..lines.len() {
            let row = line(place);
            if is_header(place) {
                inside = cells(row) == wanted;
            } else if row.starts_with("Loop time") {
                inside = false;
            } else if inside {
                let cells = cells(row);
                // LAMMPS may print warnings between the rows; the last line of an unfinished run may be incomplete
                let is_row = cells.first().is_some_and(|first| first.parse::<f64>().is_ok());
                let is_cut = cells.len() != wanted.len() && place + 1 == lines.len();
                if is_row && !is_cut {
                    self.row(&cells, lines[place].clone(), sources)?;
                }
            }
        }
        Ok(true)
    }
}

/// Cells of a line of thermo output: its words or, in the style `yaml`, the entries of its list in brackets.
fn cells(line: &str) -> Vec<String> {
    match line.trim_start_matches([' ', '-']).trim_start_matches(YAML_HEADER).trim().strip_prefix('[') {
        Some(list) => {
            let list = list.trim_end_matches(']');
            list.split(',').map(|cell| cell.trim().to_owned()).filter(|cell| !cell.is_empty()).collect()
        }
        None => words(line).map(str::to_owned).collect(),
    }
}
