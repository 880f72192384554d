//! Places particles at positions from a file: a saved state, a plain table, or a file of another program.

use super::Resolver;
use super::foreign::{COLUMNS, Foreign, OF_CSV};
use super::start::{FASTEST, Placed};
use super::table::{DataTable, TableRow};
use crate::case::de::suggestion;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::ParticlesFile;
use crate::case::located::Located;
use crate::case::saved::box_lines;
use crate::case::source::Origin;
use crate::legible::quote;
use crate::particles::Particles;
use crate::scene::{Scene, SizeDistribution};
use crate::triangles::digits;
use nalgebra::Vector3;

/// Index in [`COLUMNS`] (the properties of a particle) of the x component of the velocity. The other constants `OF_…`
/// are indices in the same list, of the spin and of the momentum also that of the x component.
const OF_VELOCITY: usize = 3;
const OF_DIAMETER: usize = 6;
const OF_SPECIES: usize = 7;
const OF_ID: usize = 8;
const OF_SPIN: usize = 9;
const OF_RADIUS: usize = 12;
const OF_DENSITY: usize = 13;
const OF_MASS: usize = 14;
const OF_MOMENTUM: usize = 15;
/// [rad/s] fastest spin about an axis that a file may give. It is the limit of the key `spin` of a case.
const FASTEST_SPIN: f64 = 1e9;
/// [-] relative error of a number in single precision, which other programs write.
const SINGLE: f64 = f32::EPSILON as f64;
/// A number with at least this many significant digits may have been rounded at its last digit. Numbers with fewer
/// digits are taken as exact, up to single precision.
const ROUNDED: usize = 6;

/// [-] relative error of a number, estimated from the number of significant digits of its text.
fn precision(text: &str) -> f64 {
    let digits = digits(text);
    if digits < ROUNDED { SINGLE } else { SINGLE.max(10f64.powi(1 - digits as i32)) }
}

/// True if two displacements [m] along z of the image above a sheared box are equal, up to rounding and to whole
/// periods of the box; `period` [m] is the length of the box along z. False unless `there` and `here` hold one number
/// each.
fn near_offset(there: &[f64], here: &[f64], period: f64) -> bool {
    let ([there], [here]) = (there, here) else { return false };
    let apart = (there - here) / period;
    (apart - apart.round()).abs() < SINGLE
}

impl Resolver {
    /// Particles in the file `name` that belong to the species with the given `index`, in the order of their ids. If
    /// the table has no column of species, all rows belong to this species. `kinds` are the kinds of particles of the
    /// case. The particles are also added to `particles`.
    pub(super) fn placed_in_file(
        &mut self,
        name: &Located<String>,
        (kinds, index): (&[Located<ParticlesFile>], usize),
        scene: &Scene,
        particles: &mut Particles,
    ) -> Result<Vec<Placed>, Diagnostic> {
        let table = self.table_of_places(name, scene)?;
        let species = &scene.species[index];
        let mut left_out = vec![0; scene.species.len()];
        let mut rows = Vec::new();
        for row in table.rows() {
            let named = self.species_of(row, scene)?.unwrap_or(index);
            if scene.species[named].name == species.name {
                self.check_row(row, index, scene)?;
                rows.push((self.id(row)?, row));
            } else {
                left_out[named] += 1;
            }
        }
        self.warn_of_kinds_left_out(name, kinds, &left_out);
        rows.sort_by_key(|(id, _)| *id);
        let twice = rows.windows(2).find(|pair| pair[0].0.is_some() && pair[0].0 == pair[1].0);
        if let Some([_, (id, row)]) = twice {
            let message = format!("`id` = {} stands in two lines", id.unwrap_or_default());
            return Err(self.sources.error(row.origin, message).help("each particle has an id of its own"));
        }
        let mut placed = Vec::new();
        for (_, row) in rows {
            let place = self.push_row(row, index, scene, particles)?;
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
        let table = match Foreign::of(&name.value, &text) {
            Some(format) => self.foreign_table(format, (source, &text), scene)?,
            None => self.csv_table(name, (source, &text), &COLUMNS[..3], &COLUMNS[3..OF_CSV])?,
        };
        for (first, what) in [(OF_VELOCITY, "velocities"), (OF_SPIN, "spins")] {
            let absent: Vec<&str> = (first..first + 3).filter(|at| !table.has(*at)).map(|at| COLUMNS[at]).collect();
            if (1..3).contains(&absent.len()) {
                let header = Origin { source, span: 0..text.find('\n').unwrap_or(text.len()) };
                let message = format!("the header of `{}` lacks {}", name.value, absent.join(", "));
                let help = format!("give all three {what}, or none: then all are 0");
                return Err(self.sources.error(&header, message).help(help));
            }
        }
        if table.has(OF_SPIN) && scene.rotation.is_none() {
            let message = format!("the spins in `{}` are left out: spheres of this case do not rotate", name.value);
            self.warn(&name.origin, message, "add `rotation = true` to [contact] to let them");
        }
        self.warn_of_another_box(&table, name, scene);
        self.warn_of_another_time(&table, name, scene);
        self.warn_of_no_rows(&table, name);
        Ok(table)
    }

    /// Index of the species that a row names, by its name or by its index; `None` if the table has no column of
    /// species.
    fn species_of(&self, row: TableRow<'_>, scene: &Scene) -> Result<Option<usize>, Diagnostic> {
        let Some(of) = row.text(OF_SPECIES) else { return Ok(None) };
        let named = scene.species.iter().position(|kind| kind.name == of);
        match named.or_else(|| of.parse().ok().filter(|index| *index < scene.species.len())) {
            Some(index) => Ok(Some(index)),
            None => {
                let names: Vec<&str> = scene.species.iter().map(|kind| kind.name.as_str()).collect();
                let help = suggestion(of, &names, "kinds of particles in the case");
                Err(self.sources.error(row.origin, format!("unknown species \"{}\"", quote(of))).help(help))
            }
        }
    }

    /// Id of the particle in a row; `None` if the table has no column of ids.
    fn id(&self, row: TableRow<'_>) -> Result<Option<u64>, Diagnostic> {
        let Some(text) = row.text(OF_ID) else { return Ok(None) };
        let refuse = |_| {
            let message = format!("`id` = {} is no whole number", quote(text));
            self.sources.error(row.origin, message).help("ids are 0, 1, 2 and so on; the column may be left out")
        };
        text.parse().map(Some).map_err(refuse)
    }

    /// Warns if the file `name` contains particles of kinds whose tables in the case do not name this file, since these
    /// particles are then left out. `left_out` is the number of such particles of each kind.
    fn warn_of_kinds_left_out(&mut self, name: &Located<String>, kinds: &[Located<ParticlesFile>], left_out: &[usize]) {
        for (kind, count) in kinds.iter().zip(left_out).filter(|(_, count)| **count > 0) {
            let names_it = kind.value.file.as_ref().is_some_and(|file| file.value == name.value);
            if let (false, Some(other)) = (names_it, &kind.value.name) {
                let message =
                    format!("{count} particles of \"{}\" in `{}` are left out", quote(&other.value), name.value);
                self.warn(&name.origin, message, "name the file under that kind too, if they belong to the start");
            }
        }
    }

    /// Checks that diameter, density and mass in a row agree with those of the species with the given `index`.
    fn check_row(&self, row: TableRow<'_>, index: usize, scene: &Scene) -> Result<(), Diagnostic> {
        let species = &scene.species[index];
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
            let of_case = species.of_one_size(size.map_or(species.diameter, |(diameter, _)| diameter)).own_mass();
            // factor 4: three times the relative error of the diameter for the volume, plus the error of the mass
            // itself
            self.agree(row, (OF_MASS, mass), (of_case, &species.name), "kg", 4.0)?;
        }
        Ok(())
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

    /// Refuses the value `value` in the column `column` of a row if it differs by more than rounding from `wanted`,
    /// the value of the species `kind`. The allowed relative difference is `factor` times the precision of the typed
    /// number, which follows from its number of digits.
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
        let sphere = species.of_one_size(diameter);
        particles.push(Vector3::zeros(), Vector3::zeros(), 0.5 * diameter, sphere.mass(), index as u16);
        particles.set_state(place, &numbers);
        if row.text(OF_MOMENTUM).is_some() {
            let momentum = |axis: usize| self.number(row, OF_MOMENTUM + axis, COLUMNS[OF_MOMENTUM + axis]);
            particles.velocity[place] = Vector3::new(momentum(0)?, momentum(1)?, momentum(2)?) / sphere.own_mass();
        }
        particles.position[place] = scene.domain.wrap(&particles.position[place]);
        let velocity = &particles.velocity[place];
        if let Some(axis) = (0..3).find(|&axis| velocity[axis].abs() > FASTEST) {
            return Err(self.too_fast(["vx", "vy", "vz"][axis], velocity[axis], row.origin));
        }
        let spin = particles.spin.as_ref().map_or_else(Vector3::zeros, |spins| spins[place]);
        if let Some(axis) = (0..3).find(|&axis| spin[axis].abs() > FASTEST_SPIN) {
            let (column, spin) = (COLUMNS[OF_SPIN + axis], spin[axis]);
            let message = format!("`{column}` = {spin:e} rad/s is out of range; allowed: -1e9 ..= 1e9 rad/s");
            return Err(self.sources.error(row.origin, message).help("spins are in rad/s"));
        }
        Ok(place)
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
            // a displacement of the image by whole periods of the box changes nothing
            let slides = key == "image_offset_m" && near_offset(&there, &here_m, scene.domain.size.z);
            if value != here && !(key == "box_m" && near) && !slides {
                let said = |text: &str| if text.is_empty() { "none".to_owned() } else { text.to_owned() };
                let message =
                    format!("`{}` was saved with {key} {}, the case has {}", name.value, said(value), said(here));
                self.warn(&name.origin, message, "change `domain`, if the box of the file is meant");
            }
        }
    }

    /// Warns if a state was saved at another time than 0 and the case has walls that move, since these begin at their
    /// places of time 0 again.
    fn warn_of_another_time(&mut self, table: &DataTable, name: &Located<String>, scene: &Scene) {
        let time = table.head.iter().find(|(key, _)| key == "time_s").and_then(|(_, time)| time.parse::<f64>().ok());
        let Some(time) = time.filter(|time| *time != 0.0 && scene.has_moving_walls()) else { return };
        let message =
            format!("`{}` was saved at {time} s, but walls that move begin at their places of time 0", name.value);
        let help =
            "for a vibration add 2 pi f t to its `phase`; otherwise move the shape; `resume` continues a stopped run";
        self.warn(&name.origin, message, help);
    }

    /// Creates the error about a velocity [m/s] in a table that is too large.
    fn too_fast(&self, column: &str, velocity: f64, origin: &Origin) -> Diagnostic {
        let message = format!("`{column}` = {velocity:e} m/s is out of range; allowed: -1e5 ..= 1e5 m/s");
        self.sources.error(origin, message).help("velocities are in m/s")
    }
}
