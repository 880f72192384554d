//! Reads the particles of all instants in a file of another program, so that averages over them can be computed.

use super::columns::{DENSITY, DIAMETER, MASS, MOMENTUM, RADIUS, SPIN, VELOCITY};
use super::{COLUMNS, Cells, Foreign, ForeignInstant, ForeignReader, Lines};
use crate::case::diagnostic::Diagnostic;
use crate::case::source::{Origin, Sources};
use crate::domain::Domain;
use crate::legible::quote;
use crate::particles::Particles;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// [-] inertia factor of a solid sphere, I = 2/5 m r². It is assumed because files contain spins, but no moments of
/// inertia.
const SOLID: f64 = 0.4;

/// Particles of one instant in a file of another program.
#[derive(Clone, Debug)]
pub struct ParticleFrame {
    /// [s] time of the instant; `None` if the file does not give it.
    pub time: Option<f64>,
    /// [-] number of the time step; `None` if the file does not give it.
    pub step: Option<f64>,
    /// Box of the instant; `None` if the file gives none.
    pub domain: Option<Domain>,
    /// Particles of the instant. Their radius is 0 m if the file gives no radii, and their mass 1 kg if the file gives
    /// no masses. Spheres rotate only if the file gives all spins, radii and masses; they are then solid.
    pub particles: Particles,
    /// True if the file gives the masses of the particles.
    pub has_masses: bool,
    /// Source position of the instant in its file, for messages.
    pub origin: Origin,
}

/// Particles of all instants of a file, and the warnings about the file.
pub type FramesAndWarnings = (Vec<ParticleFrame>, Vec<Diagnostic>);

/// Reads all instants of a text dump of LAMMPS or LIGGGHTS, or of an extended XYZ file; `None` for a text of another
/// format. `source` is the index of the text in `sources`. The returned warnings are about the file.
///
/// # Errors
/// A line that cannot be read, particles without velocities, or a box that is not rectangular.
pub fn particle_frames(
    (source, text): (usize, &str),
    sources: &Sources,
) -> Result<Option<FramesAndWarnings>, Diagnostic> {
    let lines = Lines::of(source, text);
    let mut reader = ForeignReader { sources, warnings: Vec::new() };
    let frames = match Foreign::of_frames(text) {
        Some(Foreign::Xyz) => {
            let one = |reader: &mut ForeignReader, instant| {
                let instant = reader.xyz_instant(&lines, instant)?;
                reader.frame(&lines, instant)
            };
            let instants = reader.xyz_instants(&lines)?;
            instants.into_iter().map(|instant| one(&mut reader, instant)).collect::<Result<Vec<_>, _>>()?
        }
        Some(Foreign::Dump) => {
            let one = |reader: &mut ForeignReader, instant| {
                let instant = reader.dump_instant(&lines, instant)?;
                reader.frame(&lines, instant)
            };
            let instants = reader.dump_instants(&lines)?;
            instants.iter().map(|instant| one(&mut reader, instant)).collect::<Result<Vec<_>, _>>()?
        }
        _ => return Ok(None),
    };
    Ok(Some((frames, reader.warnings)))
}

impl ForeignReader<'_> {
    /// Makes the particles and the box of an instant from the texts of the file.
    fn frame(&self, lines: &Lines, instant: ForeignInstant) -> Result<ParticleFrame, Diagnostic> {
        let ForeignInstant { start, time, step, first } = instant;
        if let Some((_, origin)) = &start.tilt {
            return Err(self.tilted(origin, "averages are not taken in tilted boxes"));
        }
        let mut particles = Particles::default();
        let mut spins = Vec::new();
        let mut has_masses = true;
        for (cells, origin) in &start.rows {
            let mass = self.mass(cells, origin)?;
            has_masses &= mass.is_some();
            let Some(velocity) = self.velocity(cells, mass, origin)? else {
                let message = "the file has no velocities, of which averages are taken";
                let help = "write vx, vy, vz beside the positions (XYZ: `velo:R:3` in `Properties`)";
                return Err(self.sources.error(origin, message).help(help));
            };
            let position = self.vector(cells, 0, origin)?.unwrap_or_default();
            let radius = self.radius(cells, origin)?.unwrap_or_default();
            particles.push(position, velocity, radius, mass.unwrap_or(1.0), 0);
            spins.extend(self.vector(cells, SPIN, origin)?);
        }
        if spins.len() == particles.len() && has_masses && particles.radius.iter().all(|radius| *radius > 0.0) {
            particles.let_rotate(&[SOLID]);
            particles.spin = Some(spins);
        }
        let axes = start.periodic.unwrap_or_default();
        let periodic = ["x", "y", "z"].map(|axis| axes.split(' ').any(|one| one == axis));
        let is_box = |edges: &Vector3<f64>| edges.iter().all(|edge| *edge > 0.0 && edge.is_finite());
        let domain = start.edges.filter(is_box).map(|edges| Domain::new(edges, periodic));
        Ok(ParticleFrame { time, step, domain, particles, has_masses, origin: lines.origin(first) })
    }

    /// Finite number in the cell of a column; `None` if the file has no such column.
    fn number(&self, cells: &Cells, column: usize, origin: &Origin) -> Result<Option<f64>, Diagnostic> {
        let text = &cells[column];
        if text.is_empty() {
            return Ok(None);
        }
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        let wrong = || {
            let message = format!("`{}` = {:?} is not a finite number", COLUMNS[column], quote(text));
            self.sources.error(origin, message).help("plain SI numbers")
        };
        number.map(Some).ok_or_else(wrong)
    }

    /// Three numbers in consecutive columns, the first of which has the index `first`; `None` if the file lacks one of
    /// these columns.
    fn vector(&self, cells: &Cells, first: usize, origin: &Origin) -> Result<Option<Vector3<f64>>, Diagnostic> {
        let mut vector = Vector3::zeros();
        for axis in 0..3 {
            let Some(number) = self.number(cells, first + axis, origin)? else { return Ok(None) };
            vector[axis] = number;
        }
        Ok(Some(vector))
    }

    /// [m] radius of a particle, from its radius or its diameter; `None` if the file gives neither.
    fn radius(&self, cells: &Cells, origin: &Origin) -> Result<Option<f64>, Diagnostic> {
        let half = self.number(cells, DIAMETER, origin)?.map(|diameter| 0.5 * diameter);
        Ok(self.number(cells, RADIUS, origin)?.or(half))
    }

    /// [kg] mass of a particle. If the file gives no mass, the mass is computed from radius and density. `None` if
    /// radius or density is also missing.
    fn mass(&self, cells: &Cells, origin: &Origin) -> Result<Option<f64>, Diagnostic> {
        let (radius, density) = (self.radius(cells, origin)?, self.number(cells, DENSITY, origin)?);
        let of_sphere = radius.zip(density).map(|(radius, density)| 4.0 / 3.0 * PI * radius.powi(3) * density);
        let mass = self.number(cells, MASS, origin)?.or(of_sphere);
        if mass.is_some_and(|mass| mass <= 0.0) {
            let message = format!("the mass of this particle is {} kg", mass.unwrap_or_default());
            return Err(self.sources.error(origin, message).help("a mass is greater than 0"));
        }
        Ok(mass)
    }

    /// [m/s] velocity of a particle. If the file gives no velocity, the velocity is the momentum over `mass` [kg].
    /// `None` if momentum or mass is also missing.
    fn velocity(&self, cells: &Cells, mass: Option<f64>, origin: &Origin) -> Result<Option<Vector3<f64>>, Diagnostic> {
        let of_momentum = self.vector(cells, MOMENTUM, origin)?.zip(mass).map(|(momentum, mass)| momentum / mass);
        Ok(self.vector(cells, VELOCITY, origin)?.or(of_momentum))
    }
}
