//! Reads and checks inlets and outlets, the places where particles come in and leave.

use super::Resolver;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{
    BlockRegionFile, CaseFile, CylinderRegionFile, InletFile, MeshFile, ObserveFile, OutletFile, OutletMeshFile,
    OutletSideFile,
};
use crate::case::located::Located;
use crate::case::source::Origin;
use crate::domain::Domain;
use crate::experiment::Population;
use crate::placement::FreeRoom;
use crate::scene::{Inlet, Outlet, OutletShape, Scene, Species, StartRegion};
use crate::walls::{Hollow, Plane};
use nalgebra::Vector3;
use std::sync::Arc;

impl Resolver {
    /// Outlets of a case (places where particles leave), in the order of the case.
    ///
    /// # Errors
    /// A shape that is out of range, a surface that is not closed, or a sheared box, whose periodic images slide.
    pub(super) fn outlets(&mut self, file: &CaseFile, scene: &Scene) -> Result<Vec<Outlet>, Diagnostic> {
        let mut outlets = Vec::new();
        for (number, typed) in file.outlets.iter().flatten().enumerate() {
            self.refuse_sheared(typed, scene)?;
            let name = typed.value.name.as_ref();
            let name = name.map_or_else(|| format!("outlet {number}"), |name| name.value.clone());
            outlets.push(Outlet { name, shape: self.outlet_shape(&typed.value, scene)? });
        }
        Ok(outlets)
    }

    fn outlet_shape(&mut self, typed: &OutletFile, scene: &Scene) -> Result<OutletShape, Diagnostic> {
        let OutletFile { side, plane, block, cylinder, mesh, .. } = typed;
        if let Some(side) = side {
            return Ok(OutletShape::Behind(self.side(side, &scene.domain)?));
        }
        if let Some(plane) = plane {
            return Ok(OutletShape::Behind(self.plane(plane, &scene.domain)?));
        }
        if let Some(Located { value, origin, path }) = mesh {
            let OutletMeshFile { file, unit, scale, position, axis, angle } = value.clone();
            let value = MeshFile { file, unit, scale, position, axis, angle, inside: None };
            let mesh = Located { value, origin: origin.clone(), path: path.clone() };
            return Ok(OutletShape::Mesh(Arc::new(self.closed_mesh(&mesh, &scene.domain)?)));
        }
        Ok(OutletShape::Body(self.opening_body((block, cylinder), scene, "outlets.side")?))
    }

    /// Body (block or cylinder) that an inlet or outlet occupies. If the case gives no body, the error names the
    /// missing `key`.
    fn opening_body(
        &self,
        (block, cylinder): (&Option<Located<BlockRegionFile>>, &Option<Located<CylinderRegionFile>>),
        scene: &Scene,
        key: &str,
    ) -> Result<Hollow, Diagnostic> {
        match block {
            Some(block) => self.block_region(block, scene),
            None => self.cylinder_region(self.need(cylinder, key)?, scene),
        }
    }

    /// Plane of a side of the box, whose normal points into the box.
    fn side(&self, typed: &Located<OutletSideFile>, domain: &Domain) -> Result<Plane, Diagnostic> {
        let (axis, is_upper) = match typed.value {
            OutletSideFile::LowerX => (0, false),
            OutletSideFile::UpperX => (0, true),
            OutletSideFile::LowerY => (1, false),
            OutletSideFile::UpperY => (1, true),
            OutletSideFile::LowerZ => (2, false),
            OutletSideFile::UpperZ => (2, true),
        };
        if domain.periodic[axis] {
            let help = "leave the axis out of `domain.periodic`";
            return Err(self.refuse(typed, "is a periodic side, which particles cross").help(help));
        }
        let along = |length: f64| Vector3::from_fn(|k, _| if k == axis { length } else { 0.0 });
        Ok(match is_upper {
            false => Plane { point: Vector3::zeros(), normal: along(1.0) },
            true => Plane { point: along(domain.size[axis]), normal: along(-1.0) },
        })
    }

    fn refuse_sheared<T>(&self, typed: &Located<T>, scene: &Scene) -> Result<(), Diagnostic> {
        if scene.domain.shear.is_none() {
            return Ok(());
        }
        let message = format!("`{}` is not for sheared boxes, whose images move", typed.path);
        Err(self.sources.error(&typed.origin, message).help("leave it out, or [domain.shear]"))
    }

    /// Inlets of a case (places where particles come in), in the order of the case. Each inlet takes its velocities
    /// and spins from the table `[[particles]]` that it names; `start` contains the values of these tables.
    ///
    /// # Errors
    /// A value that is out of range, particles that the case does not define, or a region without room for a particle.
    pub(super) fn inlets(
        &self,
        file: &CaseFile,
        scene: &Scene,
        start: &[Population],
    ) -> Result<Vec<Inlet>, Diagnostic> {
        let mut inlets = Vec::new();
        for (number, typed) in file.inlets.iter().flatten().enumerate() {
            self.refuse_sheared(typed, scene)?;
            inlets.push(self.inlet(number, typed, scene, start)?);
        }
        Ok(inlets)
    }

    fn inlet(
        &self,
        number: usize,
        typed: &Located<InletFile>,
        scene: &Scene,
        start: &[Population],
    ) -> Result<Inlet, Diagnostic> {
        let InletFile { name, particles, block, cylinder, start: opens, end, .. } = &typed.value;
        let name = name.as_ref().map_or_else(|| format!("inlet {number}"), |name| name.value.clone());
        let of = self.need(particles, "inlets.particles")?;
        let index = self.kind_named(of, &scene.species)?;
        let species = &scene.species[index];
        let region = self.opening_body((block, cylinder), scene, "inlets.box")?;
        self.check_room_of_inlet(typed, (&region, species), scene)?;
        let rate = match (&typed.value.rate, &typed.value.mass_rate) {
            (Some(rate), _) => self.in_range(rate, "a number of particles per time: \"2000 1/s\"")?,
            (None, mass) => {
                let mass = self.need(mass, "inlets.rate")?;
                self.in_range(mass, "a mass per time: \"20 g/s\"")? / species.own_mass()
            }
        };
        let opens = opens.as_ref().map_or(Ok(0.0), |start| self.in_range(start, "the run starts at 0 s"))?;
        let closes = end.as_ref().map_or(Ok(f64::INFINITY), |end| {
            self.in_range(end, "leave it out: the inlet then stays open")?;
            self.checked(end, |end| end > opens, &format!("later than `start`, {opens} s"), "leave it out: stays open")
        })?;
        let population = &start[index];
        Ok(Inlet {
            name,
            species: index as u16,
            region,
            rate,
            start: opens,
            end: closes,
            velocity_mean: population.velocity_mean,
            velocity_fluctuation: population.velocity_fluctuation,
            spin_mean: population.spin_mean,
            spin_fluctuation: population.spin_fluctuation,
        })
    }

    fn kind_named(&self, name: &Located<String>, species: &[Species]) -> Result<usize, Diagnostic> {
        species.iter().position(|kind| kind.name == name.value).ok_or_else(|| {
            let names: Vec<String> = species.iter().map(|kind| format!("\"{}\"", kind.name)).collect();
            self.refuse(name, "names no particles").help(format!("names of particles: {}", names.join(", ")))
        })
    }

    /// Checks that a sphere of the largest size fits into the region of an inlet, between the walls at the start.
    fn check_room_of_inlet(
        &self,
        typed: &Located<InletFile>,
        (region, species): (&Hollow, &Species),
        scene: &Scene,
    ) -> Result<(), Diagnostic> {
        let room = FreeRoom::within(scene, Some(&StartRegion::Body(region.clone())));
        if room.has_place_for(0.5 * species.largest()) {
            return Ok(());
        }
        let message = format!(
            "`{}` has no room for a particle of {:.4e} m between the walls at the start",
            typed.path,
            species.largest()
        );
        Err(self.sources.error(&typed.origin, message).help("make the region larger, or move it away from walls"))
    }

    /// Refuses measurements of a fixed set of particles in a scene with inlets or outlets.
    ///
    /// # Errors
    /// An error about the first such measurement.
    pub(super) fn check_openings(&self, file: &CaseFile, scene: &Scene) -> Result<(), Diagnostic> {
        let Some(observe) = file.observe.as_ref().filter(|_| scene.has_openings()) else { return Ok(()) };
        let ObserveFile { pair_distribution, diffusion, structure_factor, .. } = &observe.value;
        let refuse = |typed: Option<(&str, &Origin)>| match typed {
            None => Ok(()),
            Some((path, origin)) => {
                let message = format!("`{path}` needs particles that stay, and here they come and go");
                Err(self.sources.error(origin, message).help("leave the table out, or [[inlets]] and [[outlets]]"))
            }
        };
        refuse(pair_distribution.as_ref().map(|typed| (typed.path.as_str(), &typed.origin)))?;
        refuse(diffusion.as_ref().map(|typed| (typed.path.as_str(), &typed.origin)))?;
        refuse(structure_factor.as_ref().map(|typed| (typed.path.as_str(), &typed.origin)))
    }
}
