//! Makes walls of triangles: reads the file, moves its triangles to their position in the case, and reports its
//! defects.

use super::walls::{OWN_IMAGE, too_near_its_image};
use super::{Resolver, short, vector};
use crate::case::diagnostic::Diagnostic;
use crate::case::file::MeshFile;
use crate::case::located::Located;
use crate::domain::Domain;
use crate::memory;
use crate::triangles::{Heap, TriangleFile, TriangleFormat};
use crate::walls::{Continued, Findings, Mesh, Mismatch, Nested, Sides, continued};
use nalgebra::{Rotation3, Unit, Vector3};

/// [-] largest allowed ratio of the longest edge of the mesh to that of the box, or the inverse ratio. Beyond this
/// ratio the unit of the mesh is probably wrong.
const ANOTHER_UNIT: f64 = 100.0;
/// [-] distance by which a surface is continued beyond periodic sides, divided by the largest particle diameter. It
/// must exceed the distance within which contacts are searched for, 1.25 radii.
const MARGIN: f64 = 2.0;
/// [byte] memory per triangle while a wall is made from the triangles. It was measured as the growth of the peak memory
/// of the process from 1e5 to 4e5 triangles.
const TRIANGLE: f64 = 2000.0;

impl Resolver {
    /// Makes the surface that a `mesh` table of the case describes. `largest` [m] is the largest diameter of the
    /// particles.
    pub(super) fn mesh(&mut self, mesh: &Located<MeshFile>, domain: &Domain, largest: f64) -> Result<Mesh, Diagnostic> {
        let name = self.need(&mesh.value.file, "mesh.file")?;
        let scale = self.scale(mesh)?;
        let TriangleFile { heap, welded, notes } = self.triangles(name)?;
        let heap = self.in_place(mesh, scale, heap)?;
        let sides = mesh.value.inside.as_ref().map(|inside| if inside.value { Sides::Inside } else { Sides::Outside });
        let continued = self.through_the_sides(mesh, &heap, domain, largest)?;
        let (made, findings) = Mesh::without_end(&name.value, &heap, sides, &continued).map_err(|why| {
            let help = "repair it in the program that made it; without `inside` an open surface is a thin sheet";
            self.refuse(name, format!("makes no wall: {why}")).help(help)
        })?;
        self.warn_of_file(name, welded, notes);
        self.warn_of_findings(name, &findings, made.sides());
        self.check_bounds(mesh, &made, domain, largest)?;
        Ok(made)
    }

    /// Makes the closed surface that the `mesh` table of an outlet describes.
    ///
    /// # Errors
    /// A file that cannot be read, a surface without an inside, or one that reaches beyond a periodic side of the box.
    pub(super) fn closed_mesh(&mut self, mesh: &Located<MeshFile>, domain: &Domain) -> Result<Mesh, Diagnostic> {
        let name = self.need(&mesh.value.file, "mesh.file")?;
        let scale = self.scale(mesh)?;
        let TriangleFile { heap, welded, notes } = self.triangles(name)?;
        let heap = self.in_place(mesh, scale, heap)?;
        let (made, findings) = Mesh::new(&name.value, &heap, Some(Sides::Outside)).map_err(|why| {
            let help = "close it in the program that made it, or use `plane`, `box` or `cylinder`";
            self.refuse(name, format!("makes no outlet: {why}")).help(help)
        })?;
        let crossing = findings.nested.crossing;
        if crossing > 0 {
            let why = format!("makes no outlet: it has closed parts that are partly within others ({crossing})");
            return Err(self.refuse(name, why).help("write one outlet for each of them, or unite them"));
        }
        self.warn_of_file(name, welded, notes);
        self.check_extent(mesh, &made, domain)?;
        let [low, high] = made.bounds();
        let beyond = |axis: &usize| domain.periodic[*axis] && (low[*axis] < 0.0 || high[*axis] > domain.size[*axis]);
        if let Some(axis) = (0..3).find(beyond) {
            let place = mesh.value.position.as_ref().map_or(&mesh.origin, |position| &position.origin);
            let message = format!(
                "`{}` reaches beyond a periodic side: {} = {:.4e} ..= {:.4e} m; allowed: 0 ..= {:.4e} m, the domain",
                mesh.path,
                ["x", "y", "z"][axis],
                low[axis],
                high[axis],
                domain.size[axis]
            );
            return Err(self.sources.error(place, message).help("cut it there: write one outlet on each side"));
        }
        Ok(made)
    }

    /// Continues a surface of triangles beyond those periodic sides of the box that it crosses, by copies of its
    /// triangles.
    fn through_the_sides(
        &self,
        mesh: &Located<MeshFile>,
        heap: &Heap,
        domain: &Domain,
        largest: f64,
    ) -> Result<Continued, Diagnostic> {
        let periods = std::array::from_fn(|axis| domain.periodic[axis].then_some(domain.size[axis]));
        continued(heap, periods, MARGIN * largest).map_err(|Mismatch { axis, step }| {
            let name = ["x", "y", "z"][axis];
            let place = mesh.value.position.as_ref().map_or(&mesh.origin, |position| &position.origin);
            let message = format!(
                "`{}` goes through the periodic sides along {name}, but its edges do not match there: the largest step is {step:.4e} m",
                mesh.path
            );
            let help = "make both ends alike in the program that made the file, or the surface shorter than the period";
            self.sources.error(place, message).help(help)
        })
    }

    /// Reads a file of triangles, STL or OBJ.
    fn triangles(&mut self, name: &Located<String>) -> Result<TriangleFile, Diagnostic> {
        let Some(format) = TriangleFormat::of(&name.value) else {
            return Err(self.refuse(name, "is neither an STL nor an OBJ file").help("the name ends with .stl or .obj"));
        };
        let (path, bytes, kind) = self.bytes_of(name)?;
        self.sources.add_text(&path, "".into(), kind);
        let file = format
            .read(&bytes)
            .map_err(|why| self.refuse(name, why).help("export it anew as STL (binary or text) or OBJ"))?;
        if let Some(lack) = memory::lack(TRIANGLE * file.heap.len() as f64) {
            let what = format!("has {} triangles, which take {lack}", file.heap.len());
            return Err(self.refuse(name, what).help("coarsen the surface in the program that made it"));
        }
        Ok(file)
    }

    /// [m] length of one unit of the mesh file, from the keys `unit` and `scale`.
    fn scale(&self, mesh: &Located<MeshFile>) -> Result<f64, Diagnostic> {
        let unit = self.need(&mesh.value.unit, "mesh.unit")?;
        let help = "files of triangles mostly are in \"1 mm\"";
        let scale = self.in_range(unit, help)?;
        let Some(factor) = &mesh.value.scale else { return Ok(scale) };
        Ok(scale * self.in_range(factor, "1 leaves the size as it is")?)
    }

    /// [m] triangles of the file after scaling, rotation and translation to their position in the case. `scale` [m] is
    /// the length of one unit of the file.
    fn in_place(&self, mesh: &Located<MeshFile>, scale: f64, mut heap: Heap) -> Result<Heap, Diagnostic> {
        let mesh = &mesh.value;
        let angle = mesh.angle.as_ref().map_or(0.0, |angle| angle.value.0);
        let axis = match &mesh.axis {
            None => Vector3::z_axis(),
            Some(typed) => {
                let raw = vector(typed);
                let direction = raw / raw.amax();
                Unit::try_new(direction, 0.0).filter(|unit| unit.iter().all(|value| value.is_finite())).ok_or_else(
                    || self.refuse(typed, "has no direction").help("the direction to turn about: [1, 0, 0]"),
                )?
            }
        };
        let position = mesh.position.as_ref().map_or_else(Vector3::zeros, vector);
        // without a rotation the corners must keep their exact values
        let rotation = (angle != 0.0).then(|| Rotation3::from_axis_angle(&axis, angle));
        for corner in heap.iter_mut().flatten() {
            let scaled = *corner * scale;
            *corner = rotation.map_or(scaled, |rotation| rotation * scaled) + position;
        }
        Ok(heap)
    }

    /// Warns about lines of the file that are ignored (`notes`), and about corners that were merged (`welded` is their
    /// number).
    fn warn_of_file(&mut self, name: &Located<String>, welded: usize, notes: Vec<String>) {
        let typed = self.as_typed(name);
        if !notes.is_empty() {
            let message = format!("{typed} has {}", notes.join("; "));
            self.warn(&name.origin, message, "the triangles were read; repair the file to be rid of this warning");
        }
        if welded > 0 {
            let message = format!(
                "{typed} has {welded} corners that differ from others by the rounding of its numbers only: they were made one with them"
            );
            self.warn(&name.origin, message, "export it anew with more digits, if they are meant to be apart");
        }
    }

    /// Warns about the repairs of a surface that `findings` counts, such as removed triangles, about nested parts, and
    /// about an open surface with particles on both sides.
    fn warn_of_findings(&mut self, name: &Located<String>, findings: &Findings, sides: Sides) {
        let typed = self.as_typed(name);
        let mut told = Vec::new();
        let counted = |(count, first): (usize, usize), what: &str| {
            (count > 0).then(|| format!("{count} {what}, the first is triangle {first}"))
        };
        told.extend(counted(findings.degenerate, "triangles without an area, left out"));
        told.extend(counted(findings.duplicate, "triangles that are there twice, left out"));
        told.extend(counted(findings.turned, "triangles that faced the other way than their neighbours, turned round"));
        if findings.inside_out {
            told.push("a closed part whose normals pointed inwards, turned round".into());
        }
        if !told.is_empty() {
            let message = format!("{typed} has {}", told.join("; "));
            self.warn(&name.origin, message, "the wall is what remains; repair the file to be rid of this warning");
        }
        self.warn_of_nesting(name, &findings.nested);
        if sides == Sides::Both && !findings.is_closed() {
            let message = format!(
                "{typed} is not watertight: {} edges with one triangle, {} with more than two, {} whose triangles cannot face the same way; \
                 it is taken as a thin sheet with particles on both sides",
                findings.open_edges, findings.crowded_edges, findings.twisted_edges
            );
            self.warn(
                &name.origin,
                message,
                "for a floor or a funnel that is right; a body or a vessel should be closed",
            );
        }
    }

    /// Warns about closed parts of a surface within other closed parts, and explains how they are treated.
    fn warn_of_nesting(&mut self, name: &Located<String>, nested: &Nested) {
        let Nested { cavities, turned, skins, bodies, crossing } = *nested;
        let typed = self.as_typed(name);
        if cavities > 0 {
            let turned = match turned {
                0 => String::new(),
                turned => format!(" ({turned} were drawn as bodies, with their normals outwards)"),
            };
            let (where_to, help) = if skins > 0 {
                (
                    format!("particles are in them; {skins} outer skins around them are left out"),
                    "leave out `inside` for particles outside too",
                )
            } else {
                let help = "`inside = true` keeps particles in the cavities of a wall that is drawn with its thickness";
                ("particles may be in them and outside, with the solid between".into(), help)
            };
            self.warn(
                &name.origin,
                format!("{typed} has {cavities} cavities, closed parts within others{turned}: {where_to}"),
                help,
            );
        }
        if bodies > 0 {
            let message = format!(
                "{typed} has {bodies} closed parts within others: they are bodies in the vessel, particles are between"
            );
            self.warn(
                &name.origin,
                message,
                "for a wall with its thickness turn the normals of the inner skin inwards",
            );
        }
        if crossing > 0 {
            let message =
                format!("{typed} has {crossing} closed parts that are partly within others: each is a body by itself");
            self.warn(&name.origin, message, "unite them in the program that made the file, if they are one body");
        }
    }

    /// Checks that a mesh has the size of the domain within a factor of 100, and is not wholly outside.
    fn check_extent(&self, mesh: &Located<MeshFile>, made: &Mesh, domain: &Domain) -> Result<(), Diagnostic> {
        let [low, high] = made.bounds();
        let unit = self.need(&mesh.value.unit, "mesh.unit")?;
        let (longest, edge) = ((high - low).max(), domain.size.max());
        if longest > ANOTHER_UNIT * edge || longest * ANOTHER_UNIT < edge {
            let why = format!(
                "makes the mesh {} m long in a box of {} m; allowed: 1/{ANOTHER_UNIT} to {ANOTHER_UNIT} times the box",
                short(longest),
                short(edge)
            );
            let times = 1000.0f64.powf((edge / longest).log(1000.0).round());
            let help = format!("did you mean unit = \"{} m\"?", short(unit.value.0 * times));
            return Err(self.refuse(unit, why).help(help));
        }
        let place = mesh.value.position.as_ref().map_or(&mesh.origin, |position| &position.origin);
        for axis in 0..3 {
            let (name, size) = (["x", "y", "z"][axis], domain.size[axis]);
            if high[axis] < 0.0 || low[axis] > size {
                let message = format!(
                    "`{}` lies outside the domain: {name} = {:.4e} ..= {:.4e} m; the domain is 0 ..= {size:.4e} m",
                    mesh.path, low[axis], high[axis]
                );
                return Err(self.sources.error(place, message).help("see `position`, `unit` and `domain.size`"));
            }
        }
        Ok(())
    }

    /// Checks that a mesh has the size of the domain within a factor of 100, and is neither wholly outside nor too
    /// near its own periodic images. If the particles are inside the mesh, it must not reach beyond periodic sides.
    fn check_bounds(
        &self,
        mesh: &Located<MeshFile>,
        made: &Mesh,
        domain: &Domain,
        largest: f64,
    ) -> Result<(), Diagnostic> {
        self.check_extent(mesh, made, domain)?;
        let [low, high] = made.bounds();
        let place = mesh.value.position.as_ref().map_or(&mesh.origin, |position| &position.origin);
        for axis in 0..3 {
            let (name, size) = (["x", "y", "z"][axis], domain.size[axis]);
            if made.spans()[axis] {
                continue;
            }
            if made.sides() != Sides::Inside {
                if let Some(why) = too_near_its_image(domain, axis, [low[axis], high[axis]], largest) {
                    return Err(self.sources.error(place, format!("`{}` {why}", mesh.path)).help(OWN_IMAGE));
                }
            } else if domain.periodic[axis] && (low[axis] < 0.0 || high[axis] > size) {
                let message = format!(
                    "`{}` holds the particles at {name} = {:.4e} ..= {:.4e} m; allowed: 0 ..= {size:.4e} m, the domain",
                    mesh.path, low[axis], high[axis]
                );
                return Err(self.sources.error(place, message).help("particles inside must not leave the domain"));
            }
        }
        Ok(())
    }
}
