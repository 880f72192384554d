//! Recognizes the columns of a particle file of another program by their usual names.

use super::{COLUMNS, ForeignReader, Lines};
use crate::case::diagnostic::Diagnostic;

/// Index of the x component of the position in [`COLUMNS`], the properties of a particle.
const POSITION: usize = 0;
/// Index of the x component of the velocity in [`COLUMNS`], the properties of a particle.
pub const VELOCITY: usize = 3;
/// Index of the diameter in [`COLUMNS`], the properties of a particle.
pub const DIAMETER: usize = 6;
/// Index of the species in [`COLUMNS`], the properties of a particle.
pub const SPECIES: usize = 7;
/// Index of the x component of the spin in [`COLUMNS`], the properties of a particle.
pub const SPIN: usize = 9;
/// Index of the radius in [`COLUMNS`], the properties of a particle.
pub const RADIUS: usize = 12;
/// Index of the density in [`COLUMNS`], the properties of a particle.
pub const DENSITY: usize = 13;
/// Index of the mass in [`COLUMNS`], the properties of a particle.
pub const MASS: usize = 14;
/// Index of the x component of the momentum in [`COLUMNS`], the properties of a particle.
pub const MOMENTUM: usize = 15;
/// Names of columns with the numbers of periodic images of the box. These columns are ignored, because positions within
/// the box are sufficient.
const IMAGES: [&str; 4] = ["ix", "iy", "iz", "image"];

/// Layout of a line of a particle file: for each property of a particle, the index of the word that contains it.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    /// Index of the word in the line for each of [`COLUMNS`]; `None` if the file lacks the column.
    pub at: [Option<usize>; COLUMNS.len()],
    /// True if species are given by numbers, counted from 1, instead of names.
    pub counted: bool,
    /// Form of the positions along each axis; `None` if the file lacks them.
    positions: [Option<PositionForm>; 3],
    /// Names of the columns that are ignored; a warning lists them.
    left: Vec<String>,
    /// Number of words in the line of each particle.
    pub width: usize,
}

/// Form in which a particle file gives positions. If a file gives several forms, lengths are preferred to fractions,
/// and positions inside the box to positions in its periodic images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum PositionForm {
    /// Position as a fraction of the box size, possibly in a periodic image of the box.
    ScaledUnwrapped,
    /// Position as a fraction of the box size, inside the box.
    Scaled,
    /// [m] position, possibly in a periodic image of the box.
    Unwrapped,
    /// [m] position inside the box.
    Wrapped,
}

/// Meaning of a column in a particle file of another program.
enum Meaning {
    /// Property with this index in [`COLUMNS`]. A column with several words also fills the following indices.
    Known(usize),
    /// Position along an axis (0: x, 1: y, 2: z), or along all axes for a column with three words.
    Position(usize, PositionForm),
    /// Number of a species, counted from 1.
    Type,
    /// Column that is ignored, such as the number of the periodic image.
    Image,
}

/// Meaning of a column with the given name and number of words; `None` if the name is unknown.
fn meaning(name: &str, width: usize) -> Option<Meaning> {
    let lower = name.to_ascii_lowercase();
    let plain: String = lower.chars().filter(char::is_ascii_alphanumeric).collect();
    if IMAGES.contains(&plain.as_str()) {
        return Some(Meaning::Image);
    }
    if width == 3 {
        return match plain.as_str() {
            "pos" | "position" | "positions" => Some(Meaning::Position(0, PositionForm::Wrapped)),
            "v" | "velo" | "vel" | "velocity" | "velocities" => Some(Meaning::Known(VELOCITY)),
            "omega" | "spin" | "angularvelocity" => Some(Meaning::Known(SPIN)),
            "momenta" | "momentum" => Some(Meaning::Known(MOMENTUM)),
            _ => None,
        };
    }
    let one = match plain.as_str() {
        "diameter" | "diam" => Some(DIAMETER),
        "species" | "element" => Some(SPECIES),
        "id" | "identifier" | "particleidentifier" => Some(8),
        "radius" => Some(RADIUS),
        "density" | "rho" => Some(DENSITY),
        "mass" | "masses" => Some(MASS),
        _ => None,
    };
    if let (Some(column), 1) = (one, width) {
        return Some(Meaning::Known(column));
    }
    if width != 1 {
        return None;
    }
    if plain == "type" || plain == "particletype" {
        return Some(Meaning::Type);
    }
    // accepted names: x, xu, xs, xsu; vx, v_x, vel_x, velocity.x; v_vx for a LAMMPS variable called vx
    for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
        let is = |first: &[&str], last: &[&str]| {
            first.iter().any(|first| {
                plain
                    .strip_prefix(first)
                    .and_then(|rest| rest.strip_prefix(letter))
                    .is_some_and(|rest| last.contains(&rest))
            })
        };
        let forms = [
            ("", PositionForm::Wrapped),
            ("u", PositionForm::Unwrapped),
            ("s", PositionForm::Scaled),
            ("su", PositionForm::ScaledUnwrapped),
        ];
        if let Some((_, form)) = forms.into_iter().find(|(last, _)| is(&["", "pos", "position"], &[last])) {
            return Some(Meaning::Position(axis, form));
        }
        if is(&["v", "vel", "velo", "velocity", "vv", "cv", "fv"], &[""]) {
            return Some(Meaning::Known(VELOCITY + axis));
        }
        if is(&["omega", "w", "spin", "angularvelocity"], &[""]) {
            return Some(Meaning::Known(SPIN + axis));
        }
        if is(&["momenta", "momentum"], &[""]) {
            return Some(Meaning::Known(MOMENTUM + axis));
        }
    }
    None
}

impl Layout {
    /// Adds the next column of a particle file to the layout of its lines. `width` is the number of consecutive words
    /// that the column `name` has in a line.
    ///
    /// # Errors
    /// A message in words: another column of the file has the same meaning.
    pub fn push(&mut self, name: &str, width: usize) -> Result<(), String> {
        let first = self.width;
        self.width += width;
        let twice = || Err(format!("the column `{name}` says again what another one says"));
        match meaning(name, width) {
            None => self.left.push(name.to_owned()),
            Some(Meaning::Image) => {}
            Some(Meaning::Type | Meaning::Known(SPECIES)) => {
                let is_type = !matches!(meaning(name, width), Some(Meaning::Known(_)));
                // species given by numbers are preferred, because they do not depend on the names in the case
                if self.at[SPECIES].is_none() || is_type && !self.counted {
                    (self.at[SPECIES], self.counted) = (Some(first), is_type);
                } else if is_type == self.counted {
                    return twice();
                }
            }
            Some(Meaning::Position(axis, form)) => {
                for k in 0..width {
                    let known = &mut self.positions[axis + k];
                    if *known == Some(form) {
                        return twice();
                    }
                    if *known < Some(form) {
                        (*known, self.at[POSITION + axis + k]) = (Some(form), Some(first + k));
                    }
                }
            }
            Some(Meaning::Known(column)) => {
                for k in 0..width {
                    if self.at[column + k].replace(first + k).is_some() {
                        return twice();
                    }
                }
            }
        }
        Ok(())
    }

    /// True if positions along `axis` (0: x, 1: y, 2: z) are fractions of the box size.
    pub fn is_scaled(&self, axis: usize) -> bool {
        matches!(self.positions[axis], Some(PositionForm::Scaled | PositionForm::ScaledUnwrapped))
    }

    /// Word of a line that belongs to the property with the index `column` in [`COLUMNS`]; empty if the file lacks it.
    pub fn text<'a>(&self, words: &[&'a str], column: usize) -> &'a str {
        self.at[column].and_then(|at| words.get(at)).copied().unwrap_or("")
    }
}

impl ForeignReader<'_> {
    /// Refuses a layout that lacks a component of the position, or that has only one or two components of the velocity,
    /// the spin or the momentum. `number` is the number of the line, for messages. If the file has velocities, momenta
    /// are ignored. Warns about ignored columns, and about momenta without a column of masses.
    pub(super) fn check_layout(&mut self, lines: &Lines, number: usize, layout: &mut Layout) -> Result<(), Diagnostic> {
        if layout.at[VELOCITY].is_some() && layout.at[MOMENTUM].is_some() {
            layout.left.push("momenta".into());
            layout.at[MOMENTUM..MOMENTUM + 3].fill(None);
        }
        let vectors = [(POSITION, "position"), (VELOCITY, "velocity"), (SPIN, "spin"), (MOMENTUM, "momentum")];
        for (first, what) in vectors {
            let lacks: Vec<&str> =
                (first..first + 3).filter(|at| layout.at[*at].is_none()).map(|at| COLUMNS[at]).collect();
            if first == POSITION && !lacks.is_empty() || (1..3).contains(&lacks.len()) {
                let message = format!("the columns of this line lack {}, of the {what}", lacks.join(", "));
                return Err(self.wrong(lines, number, message, "give all three"));
            }
        }
        if layout.at[MOMENTUM].is_some() && layout.at[MASS].is_none() {
            let message = "the velocities are the momenta of the file over the masses of the case";
            self.warn(&lines.origin(number), message, "a column `mass` in kg says that they are meant so");
        }
        if !layout.left.is_empty() {
            let message = format!("columns that are left aside: {}", layout.left.join(", "));
            let help = "places, velocities or momenta, radii or diameters, densities, masses, types and ids are read";
            self.warn(&lines.origin(number), message, help);
        }
        Ok(())
    }

    /// Splits a line into words, and checks their number against the layout.
    pub(super) fn words_of<'a>(
        &self,
        lines: &Lines<'a>,
        number: usize,
        layout: &Layout,
    ) -> Result<Vec<&'a str>, Diagnostic> {
        let words: Vec<&str> = lines.get(number).split_whitespace().collect();
        if words.len() == layout.width {
            return Ok(words);
        }
        let message =
            format!("the line has {} values where the header of the columns has {}", words.len(), layout.width);
        Err(self.wrong(lines, number, message, "one line for each particle, with a value for each column"))
    }
}
