//! Reads data files of LAMMPS: the box, the section `Atoms` in style sphere or atomic, and the section `Velocities`.
//!
//! Format: LAMMPS documentation, command `read_data`, <https://docs.lammps.org/read_data.html>.

use super::columns::{DENSITY, DIAMETER, MASS, SPECIES, SPIN};
use super::{Cells, ForeignReader, ForeignStart, ID, Lines};
use crate::case::diagnostic::Diagnostic;
use crate::legible::quote;
use nalgebra::Vector3;
use rustc_hash::FxHashMap;
use std::ops::Range;

/// Names of the lower and the upper end of the box along x, y and z.
const SIDES: [[&str; 2]; 3] = [["xlo", "xhi"], ["ylo", "yhi"], ["zlo", "zhi"]];

/// Section `Atoms` of a LAMMPS data file: the indices of its columns and lines.
#[derive(Clone)]
struct Atoms {
    /// Index of the column of the diameter, after which follows the column of the density; `None` without diameters.
    diameter: Option<usize>,
    place: usize,
    header: usize,
    lines: Range<usize>,
}

/// Contents of a LAMMPS data file, except the lines of the atoms.
#[derive(Default)]
struct Outline<'a> {
    /// [m] lower corner of the box; the next field `high` is the upper corner.
    low: Vector3<f64>,
    high: Vector3<f64>,
    boxed: bool,
    /// Number of atoms that the header of the file states, and index of the line that states it; `None` if no line
    /// does.
    announced: Option<(usize, usize)>,
    atoms: Option<Atoms>,
    /// Index of the header line of the section `Velocities`; `None` if the file has no such section.
    moving: Option<usize>,
    /// For each atom, by its id: index of its line in the section `Velocities`, and texts of its velocity and angular
    /// velocity.
    velocities: FxHashMap<&'a str, (usize, [&'a str; 3], [&'a str; 3])>,
    /// Text of the mass of each atom type, by the number of the type.
    masses: FxHashMap<&'a str, &'a str>,
    /// True if any atom has an angular velocity other than 0.
    spins: bool,
    /// Header lines of sections that are ignored.
    left: Vec<&'a str>,
}

impl ForeignReader<'_> {
    /// Reads the particles of a LAMMPS data file.
    pub(super) fn lammps(&mut self, lines: &Lines) -> Result<ForeignStart, Diagnostic> {
        match lines.get(0).split_once("units = ").map(|(_, units)| units.trim()) {
            Some("si") => {}
            Some(other) => {
                let message = format!("the file is in the units \"{other}\" of LAMMPS");
                return Err(self.wrong(lines, 0, message, "write it with `units si`"));
            }
            None => self.warn_of_units(lines, 0, "LAMMPS writes `units = si` into the first line under `units si`"),
        }
        let mut outline = self.outline(lines)?;
        let Some(atoms) = outline.atoms.take() else {
            let help = "LAMMPS writes one with `write_data`";
            return Err(self.wrong(lines, 0, "the file has no section `Atoms`", help));
        };
        let mut rows = Vec::new();
        for number in atoms.lines.clone() {
            let cells = words(lines.get(number));
            if !cells.is_empty() {
                rows.push((self.atom(lines, number, &cells, (&atoms, &mut outline))?, lines.origin(number)));
            }
        }
        if let Some((count, line)) = outline.announced.filter(|(count, _)| *count != rows.len()) {
            let message = format!("{count} atoms are announced in line {}, {} follow", line + 1, rows.len());
            return Err(self.wrong(lines, atoms.header, message, "the file was cut short? write it again"));
        }
        if let Some((id, (line, ..))) = outline.velocities.iter().min_by_key(|(_, (line, ..))| *line) {
            let message = format!("a velocity of atom {id}, which is not among the atoms, or there twice");
            return Err(self.wrong(lines, *line, message, "one line for each atom"));
        }
        self.warn_of_left_sections(lines, &outline);
        let edges = outline.boxed.then(|| outline.high - outline.low);
        Ok(ForeignStart { rows, edges, tilt: None, periodic: None, counted: true })
    }

    /// Warns about sections that are ignored.
    fn warn_of_left_sections(&mut self, lines: &Lines, outline: &Outline) {
        if !outline.left.is_empty() {
            let message = format!("sections that are left aside: {}", outline.left.join(", "));
            self.warn(&lines.origin(0), message, "atoms, their velocities and the masses of types are read");
        }
    }

    /// Reads the box, the velocities and the masses, and finds the section `Atoms`.
    fn outline<'a>(&self, lines: &Lines<'a>) -> Result<Outline<'a>, Diagnostic> {
        let mut found = Outline::default();
        let mut number = 1;
        while number < lines.count() {
            let line = words(lines.get(number));
            let mut next = number + 1;
            match line[..] {
                [count, "atoms"] => {
                    found.announced = Some((self.cell(lines, number, count, "the number of atoms")?, number));
                }
                [xy, xz, yz, "xy", "xz", "yz"] => {
                    for tilt in [xy, xz, yz] {
                        if self.cell::<f64>(lines, number, tilt, "the tilt")? != 0.0 {
                            return Err(self.wrong(
                                lines,
                                number,
                                "the box is tilted",
                                "only rectangular boxes can be run",
                            ));
                        }
                    }
                }
                _ if line.iter().any(|word| of_box(word)) => self.side(lines, number, &line, &mut found)?,
                [_, _, _, "avec" | "bvec" | "cvec"] => {
                    return Err(self.wrong(lines, number, "the box is tilted", "only rectangular boxes can be run"));
                }
                [first, ..] if first.starts_with(|c: char| c.is_ascii_alphabetic()) => {
                    let body = section(lines, next);
                    next = body.end;
                    self.section(lines, number, body, &mut found)?;
                }
                _ => {}
            }
            number = next;
        }
        Ok(found)
    }

    /// Reads the two ends of the box along one axis.
    fn side(&self, lines: &Lines, number: usize, line: &[&str], found: &mut Outline) -> Result<(), Diagnostic> {
        let axis = |names: [&str; 2]| SIDES.iter().position(|side| *side == names);
        let ([from, to], Some(axis)) = (match line[..] {
            [from, to, low, high] => ([from, to], axis([low, high])),
            _ => ([""; 2], None),
        }) else {
            let message = format!("{:?} is no line of the box", quote(lines.get(number).trim()));
            return Err(self.wrong(
                lines,
                number,
                message,
                "write two ends and their names: 0 0.01 xlo xhi; leave tilts of 0 out",
            ));
        };
        let ends: [f64; 2] = [self.cell(lines, number, from, "the box")?, self.cell(lines, number, to, "the box")?];
        if let Some(end) = ends.iter().find(|end| !end.is_finite()) {
            return Err(self.wrong(lines, number, format!("the box = {end} is not finite"), "plain SI numbers"));
        }
        [found.low[axis], found.high[axis]] = ends;
        if ends[0] >= ends[1] {
            let message = format!("the box has no size along {}", ["x", "y", "z"][axis]);
            return Err(self.wrong(lines, number, message, "write the lower end first: 0 0.01 xlo xhi"));
        }
        found.boxed = true;
        Ok(())
    }

    /// Reads the section with the header line `header` and the other lines `body` into `found`.
    fn section<'a>(
        &self,
        lines: &Lines<'a>,
        header: usize,
        body: Range<usize>,
        found: &mut Outline<'a>,
    ) -> Result<(), Diagnostic> {
        let filled =
            body.clone().map(|number| (number, words(lines.get(number)))).filter(|(_, words)| !words.is_empty());
        match words(lines.get(header))[..] {
            ["Atoms"] => found.atoms = Some(self.atoms(lines, header, body)?),
            ["Velocities"] => {
                found.moving = Some(header);
                for (number, line) in filled {
                    let [id, x, y, z, ref spin @ ..] = line[..] else {
                        let message = format!("the line has {} values, at least 4 belong here", line.len());
                        return Err(self.wrong(lines, number, message, "id vx vy vz, one line for each atom"));
                    };
                    found.spins |= spin.iter().any(|spin| spin.parse::<f64>() != Ok(0.0));
                    let spin = match spin[..] {
                        [x, y, z] => [x, y, z],
                        [] => ["0"; 3],
                        _ => {
                            let message = format!("{} values after the velocity of atom {id}", spin.len());
                            return Err(self.wrong(lines, number, message, "spheres have three, the angular velocity"));
                        }
                    };
                    if found.velocities.insert(id, (number, [x, y, z], spin)).is_some() {
                        let message = format!("a second velocity of atom {id}");
                        return Err(self.wrong(lines, number, message, "one line for each atom"));
                    }
                }
            }
            ["Masses"] => found.masses = filled.filter_map(|(_, line)| Some((*line.first()?, *line.get(1)?))).collect(),
            _ => found.left.push(lines.get(header).trim()),
        }
        Ok(())
    }

    /// Indices of the columns of a section `Atoms`, which depend on the atom style in the header of the section.
    fn atoms(&self, lines: &Lines, header: usize, body: Range<usize>) -> Result<Atoms, Diagnostic> {
        let help = "write `Atoms # sphere` or `Atoms # atomic`";
        match lines.get(header).split_once('#').map(|(_, style)| style.trim()) {
            Some("sphere" | "granular") => Ok(Atoms { diameter: Some(2), place: 4, header, lines: body }),
            Some("atomic") => Ok(Atoms { diameter: None, place: 2, header, lines: body }),
            Some(other) => Err(self.wrong(lines, header, format!("atoms of style \"{other}\" cannot be read"), help)),
            None => Err(self.wrong(lines, header, "the section does not name its style", help)),
        }
    }

    /// Reads the line of one atom in the section `Atoms`, and adds the velocity of this atom from the section
    /// `Velocities`.
    fn atom(
        &self,
        lines: &Lines,
        number: usize,
        cells: &[&str],
        (atoms, outline): (&Atoms, &mut Outline),
    ) -> Result<Cells, Diagnostic> {
        let least = atoms.place + 3;
        if cells.len() < least {
            let message = format!("the line has {} values, at least {least} belong here", cells.len());
            let help = "sphere: id type diameter density x y z; atomic: id type x y z";
            return Err(self.wrong(lines, number, message, help));
        }
        let mut row = Cells::default();
        let (velocity, spin) = match (outline.moving, outline.velocities.remove(cells[0])) {
            (None, _) => (["0"; 3], ["0"; 3]),
            (Some(_), Some((_, velocity, spin))) => (velocity, spin),
            (Some(header), None) => {
                let message = format!(
                    "atom {} has no velocity in the section in line {}, or is there twice",
                    cells[0],
                    header + 1
                );
                return Err(self.wrong(lines, number, message, "the file was cut short? one line for each atom"));
            }
        };
        for axis in 0..3 {
            row[axis] = self.shifted(lines, number, cells[atoms.place + axis], outline.low[axis])?;
            row[3 + axis] = velocity[axis].to_owned();
            if outline.spins {
                row[SPIN + axis] = spin[axis].to_owned();
            }
        }
        match atoms.diameter {
            Some(diameter) => {
                row[DIAMETER] = cells[diameter].to_owned();
                row[DENSITY] = cells[diameter + 1].to_owned();
            }
            None => row[MASS] = outline.masses.get(cells[1]).map_or("", |mass| mass).to_owned(),
        }
        row[SPECIES] = cells[1].to_owned();
        row[ID] = cells[0].to_owned();
        Ok(row)
    }
}

/// True for a word, in small letters or in capitals, that marks a line about the box, such as `xlo` or `xy`.
fn of_box(word: &str) -> bool {
    SIDES.iter().flatten().chain(&["xy", "xz", "yz"]).any(|name| name.eq_ignore_ascii_case(word))
}

/// Words of a line, without its comment.
fn words(line: &str) -> Vec<&str> {
    line.split('#').next().unwrap_or("").split_whitespace().collect()
}

/// Lines of a section that begins at line `from`. A line that begins with a letter starts the next section.
fn section(lines: &Lines, from: usize) -> Range<usize> {
    let begins = |line: &str| line.trim_start().starts_with(|c: char| c.is_ascii_alphabetic());
    let end = (from..lines.count()).find(|&number| begins(lines.get(number))).unwrap_or(lines.count());
    from.min(end)..end
}
