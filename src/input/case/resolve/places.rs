//! Places particles at positions from a file: a saved state, a plain table, or a file of another program.

use super::Resolver;
use super::foreign::{COLUMNS, Foreign, OF_CSV};
use super::start::{FASTEST, Placed};
use super::table::{DataTable, TableRow};
use crate::case::de::{Located, suggestion};
use crate::case::diagnostic::Diagnostic;
use crate::case::saved::box_lines;
use crate::case::source::Origin;
use crate::legible::quote;
use crate::particles::Particles;
use crate::scene::{Scene, SizeDistribution};
use crate::triangles::digits;
use nalgebra::Vector3;
use rustc_hash::FxHashSet;

/// Index of the diameter in [`COLUMNS`], the properties of a particle. The constants below are indices of other
/// properties that a file may lack; `OF_SPIN` and `OF_MOMENTUM` are those of the x component of a vector.
const OF_DIAMETER: usize = 6;
const OF_SPECIES: usize = 7;
const OF_ID: usize = 8;
const OF_SPIN: usize = 9;
const OF_RADIUS: usize = 12;
const OF_DENSITY: usize = 13;
const OF_MASS: usize = 14;
const OF_MOMENTUM: usize = 15;
/// [-] relative error of a number in single precision, which other programs write.
const SINGLE: f64 = f32::EPSILON as f64;
/// Number of significant digits from which on the last digit of a number may be rounded. Numbers with fewer digits are
/// taken as exact, up to single precision.
const ROUNDED: usize = 6;

/// [-] relative error of a number, estimated from the number of significant digits of its text.
fn precision(text: &str) -> f64 {
    let digits = digits(text);
    if digits < ROUNDED { SINGLE } else { SINGLE.max(10f64.powi(1 - digits as i32)) }
}

impl Resolver {
    /// Particles in the file `name` that belong to the species with the given `index`. If the table has no column of
    /// species, all rows belong to this species.
    pub(super) fn placed_in_file(
        &mut self,
        name: &Located<String>,
        index: usize,
        scene: &Scene,
        particles: &mut Particles,
    ) -> Result<Vec<Placed>, Diagnostic> {
        let table = self.table_of_places(name, scene)?;
        let mut ids = FxHashSet::default();
        let mut placed = Vec::new();
        for row in table.rows() {
            if !self.is_of(row, index, scene)? {
                continue;
            }
            if let Some(id) = row.text(OF_ID).filter(|id| !ids.insert(*id)) {
                let message = format!("`id` = {} stands in two lines", quote(id));
                return Err(self.sources.error(row.origin, message).help("each particle has an id of its own"));
            }
            let place = self.push_row(row, index, scene, particles)?;
            let species = &scene.species[index];
            let radius = particles.radius[place];
            placed.push(Placed {
                position: particles.position[place],
                radius,
                saved: table.saved,
                foreign: table.foreign,
                label: format!("particle {} of \"{}\"", placed.len(), species.name),
                origin: row.origin.clone(),
            });
        }
        Ok(placed)
    }

    /// Reads a table of positions, and of velocities if the file contains them, in any supported format.
    fn table_of_places(&mut self, name: &Located<String>, scene: &Scene) -> Result<DataTable, Diagnostic> {
        let (source, text) = self.read_named(name)?;
        let kinds: Vec<&str> = scene.species.iter().map(|kind| kind.name.as_str()).collect();
        let table = match Foreign::of(&name.value, &text) {
            Some(format) => self.foreign_table(format, (source, &text), &kinds)?,
            None => self.csv_table(name, (source, &text), &COLUMNS[..3], &COLUMNS[3..OF_CSV])?,
        };
        let absent: Vec<&str> = (3..6).filter(|at| !table.has(*at)).map(|at| COLUMNS[at]).collect();
        if (1..3).contains(&absent.len()) {
            let header = Origin { source, span: 0..text.find('\n').unwrap_or(text.len()) };
            let message = format!("the header of `{}` lacks {}", name.value, absent.join(", "));
            let help = "give all three velocities, or none: then all are 0";
            return Err(self.sources.error(&header, message).help(help));
        }
        if table.has(OF_SPIN) && scene.rotation.is_none() {
            let message = format!("the spins in `{}` are left out: spheres of this case do not rotate", name.value);
            self.warn(&name.origin, message, "add `rotation = true` to [contact] to let them");
        }
        self.warn_of_another_box(&table, name, scene);
        self.warn_of_no_rows(&table, name);
        Ok(table)
    }

    /// True if a row belongs to the species with the given `index`. Diameter, density and mass in the row must agree
    /// with those of the species.
    fn is_of(&self, row: TableRow<'_>, index: usize, scene: &Scene) -> Result<bool, Diagnostic> {
        let species = &scene.species[index];
        if let Some(of) = row.text(OF_SPECIES) {
            let named = scene.species.iter().position(|kind| kind.name == of);
            let Some(index) = named.or_else(|| of.parse().ok().filter(|index| *index < scene.species.len())) else {
                let names: Vec<&str> = scene.species.iter().map(|kind| kind.name.as_str()).collect();
                let help = suggestion(of, &names, "kinds of particles in the case");
                return Err(self.sources.error(row.origin, format!("unknown species \"{}\"", quote(of))).help(help));
            };
            if scene.species[index].name != species.name {
                return Ok(false);
            }
        }
        let size = self.size(row)?;
        match (size, &species.sizes) {
            (Some((diameter, _)), Some(sizes)) => self.check_size(row, diameter, sizes)?,
            (Some((diameter, column)), None) => {
                self.agree(row, (column, diameter), (species.diameter, &species.name), "m", 1.0)?;
            }
            (None, Some(_)) => {
                let message = format!("the table has no `diameter`, and those of \"{}\" differ", species.name);
                let help = "add the column, or give the kind a `diameter` in place of `sizes`";
                return Err(self.sources.error(row.origin, message).help(help));
            }
            (None, None) => {}
        }
        if row.text(OF_DENSITY).is_some_and(|text| !text.is_empty()) {
            let density = self.number(row, OF_DENSITY, "density")?;
            self.agree(row, (OF_DENSITY, density), (species.density, &species.name), "kg/m^3", 1.0)?;
        }
        if row.text(OF_MASS).is_some_and(|text| !text.is_empty()) {
            let mass = self.number(row, OF_MASS, "mass")?;
            let of_case = species.of_one_size(size.map_or(species.diameter, |(diameter, _)| diameter)).mass();
            // factor 4: three times the relative error of the diameter for the volume, plus the error of the mass
            // itself
            self.agree(row, (OF_MASS, mass), (of_case, &species.name), "kg", 4.0)?;
        }
        Ok(true)
    }

    /// [m] diameter of the particle in a row, and the index of the column from which it comes: that of the diameter or
    /// that of the radius. `None` if the row has neither.
    fn size(&self, row: TableRow<'_>) -> Result<Option<(f64, usize)>, Diagnostic> {
        let has = |column: usize| row.text(column).is_some_and(|text| !text.is_empty());
        let radius = if has(OF_RADIUS) { Some(2.0 * self.number(row, OF_RADIUS, "radius")?) } else { None };
        if row.text(OF_DIAMETER).is_none() || !has(OF_DIAMETER) && radius.is_some() {
            return Ok(radius.map(|diameter| (diameter, OF_RADIUS)));
        }
        let diameter = self.number(row, OF_DIAMETER, "diameter")?;
        let off = |column: usize| precision(row.text(column).unwrap_or(""));
        if let Some(other) = radius.filter(|other| (other / diameter - 1.0).abs() > off(OF_DIAMETER) + off(OF_RADIUS)) {
            let message = format!("`diameter` = {diameter:e} m, but `radius` = {:e} m", 0.5 * other);
            return Err(self.sources.error(row.origin, message).help("a diameter is twice a radius"));
        }
        Ok(Some((diameter, OF_DIAMETER)))
    }

    /// Refuses a value in a row of a table that differs from the value of its species by more than rounding. The
    /// allowed relative difference is `factor` times the precision of the text.
    fn agree(
        &self,
        row: TableRow<'_>,
        (column, value): (usize, f64),
        (wanted, kind): (f64, &str),
        unit: &str,
        factor: f64,
    ) -> Result<(), Diagnostic> {
        let text = row.text(column).unwrap_or("");
        if (value / wanted - 1.0).abs() <= factor * precision(text) {
            return Ok(());
        }
        // a radius was converted to a diameter, so the message is about the diameter
        let name = if column == OF_RADIUS { COLUMNS[OF_DIAMETER] } else { COLUMNS[column] };
        let message = format!("`{name}` = {value:e} {unit}, but \"{kind}\" has {wanted:e} {unit}");
        Err(self.sources.error(row.origin, message).help("name the file under the kind it belongs to"))
    }

    /// Refuses a diameter [m] outside the size distribution of a species.
    fn check_size(&self, row: TableRow<'_>, diameter: f64, sizes: &SizeDistribution) -> Result<(), Diagnostic> {
        let (least, most) = (sizes.smallest(), sizes.largest());
        if (least * (1.0 - SINGLE)..=most * (1.0 + SINGLE)).contains(&diameter) {
            return Ok(());
        }
        let message = format!("`diameter` = {diameter:e} m is out of range; allowed: {least:e} ..= {most:e} m");
        Err(self.sources.error(row.origin, message).help("those are the smallest and the largest of `sizes`"))
    }

    /// Appends the particle in a row to the store, as a particle of the species with the given `index`. Returns its
    /// index in the store.
    fn push_row(
        &self,
        row: TableRow<'_>,
        index: usize,
        scene: &Scene,
        particles: &mut Particles,
    ) -> Result<usize, Diagnostic> {
        let species = &scene.species[index];
        let number = |column: &&str| {
            let at = COLUMNS.iter().position(|known| known == column).unwrap_or_default();
            match row.text(at) {
                // velocities and spins may be absent, and are then 0
                None if at >= 3 => Ok(0.0),
                _ => self.number(row, at, column),
            }
        };
        let columns = particles.state_names();
        let numbers = columns.iter().map(number).collect::<Result<Vec<f64>, Diagnostic>>()?;
        let place = particles.len();
        let diameter = match species.sizes {
            Some(_) => self.size(row)?.map_or(species.diameter, |(diameter, _)| diameter),
            None => species.diameter,
        };
        let mass = species.of_one_size(diameter).mass();
        particles.push(Vector3::zeros(), Vector3::zeros(), 0.5 * diameter, mass, index as u16);
        particles.set_state(place, &numbers);
        if row.text(OF_MOMENTUM).is_some() {
            let momentum = |axis: usize| self.number(row, OF_MOMENTUM + axis, COLUMNS[OF_MOMENTUM + axis]);
            particles.velocity[place] = Vector3::new(momentum(0)?, momentum(1)?, momentum(2)?) / mass;
        }
        particles.position[place] = scene.domain.wrap(&particles.position[place]);
        let velocity = &particles.velocity[place];
        match (0..3).find(|&axis| velocity[axis].abs() > FASTEST) {
            Some(axis) => Err(self.too_fast(["vx", "vy", "vz"][axis], velocity[axis], row.origin)),
            None => Ok(place),
        }
    }

    /// Warns about a table that has a header but no rows, and so no particles.
    fn warn_of_no_rows(&mut self, table: &DataTable, name: &Located<String>) {
        if table.rows().next().is_none() {
            let message = format!("`{}` has a header but no line of numbers: no particles", name.value);
            self.warn(&name.origin, message, "a table cut short? `count = 0` starts without particles too");
        }
    }

    /// Warns if the box of a file differs from that of the case, since particles that touched across periodic sides of
    /// the box in the file may then be apart.
    fn warn_of_another_box(&mut self, table: &DataTable, name: &Located<String>, scene: &Scene) {
        let own = box_lines(&scene.domain);
        for (key, value) in &table.head {
            let Some((_, here)) = own.iter().find(|(known, _)| known == key) else { continue };
            // computed edges are equal only up to rounding
            let edges =
                |text: &str| text.split_whitespace().filter_map(|edge| edge.parse::<f64>().ok()).collect::<Vec<f64>>();
            let (there, here_m) = (edges(value), edges(here));
            let near = there.len() == here_m.len()
                && there.iter().zip(&here_m).all(|(a, b)| (a - b).abs() <= SINGLE * b.abs());
            if value != here && !(key == "box_m" && near) {
                let said = |text: &str| if text.is_empty() { "none".to_owned() } else { text.to_owned() };
                let message =
                    format!("`{}` was saved with {key} {}, the case has {}", name.value, said(value), said(here));
                self.warn(&name.origin, message, "change `domain`, if the box of the file is meant");
            }
        }
    }

    /// Creates the error about a velocity [m/s] in a table that is too large.
    fn too_fast(&self, column: &str, velocity: f64, origin: &Origin) -> Diagnostic {
        let message = format!("`{column}` = {velocity:e} m/s is out of range; allowed: -1e5 ..= 1e5 m/s");
        self.sources.error(origin, message).help("velocities are in m/s")
    }
}
