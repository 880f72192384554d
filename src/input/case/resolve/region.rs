//! Part of the domain in which particles with random positions start.

use super::{Resolver, vector};
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{BlockRegionFile, CaseFile, CylinderRegionFile, ParticlesFile};
use crate::case::given::START;
use crate::case::located::Located;
use crate::scene::{Scene, StartRegion};
use crate::walls::{Cavity, Frustum, Hollow, RoundAxis};
use nalgebra::Vector3;

impl Resolver {
    /// Region in which a species starts; `None` if the case gives no region.
    pub(super) fn region(
        &self,
        kind: &Located<ParticlesFile>,
        file: &CaseFile,
        scene: &Scene,
    ) -> Result<Option<StartRegion>, Diagnostic> {
        let Some(region) = &kind.value.region else { return Ok(None) };
        // a start from arrays takes the place of the region
        if kind.value.file.as_ref().is_some_and(|file| file.value == START) {
            return Ok(None);
        }
        if kind.value.file.is_some() || kind.value.at.is_some() {
            let message = format!("`{}` is of no use: these particles have given places", region.path);
            return Err(self.sources.error(&region.origin, message).help("leave it out"));
        }
        let found = match (&region.value.block, &region.value.cylinder, &region.value.inside) {
            (Some(block), ..) => StartRegion::Body(self.block_region(block, scene)?),
            (_, Some(cylinder), _) => StartRegion::Body(self.cylinder_region(cylinder, scene)?),
            (_, _, inside) => {
                let name = self.need(inside, "particles.in.inside")?;
                StartRegion::InsideWalls(self.walls_inside(name, file, scene)?)
            }
        };
        Ok(Some(found))
    }

    pub(super) fn block_region(&self, block: &Located<BlockRegionFile>, scene: &Scene) -> Result<Hollow, Diagnostic> {
        let center = self.need(&block.value.center, "particles.in.box.center")?;
        let half_extents = self.half_extents(&block.value.half_extents)?;
        self.keep_inside(center, &half_extents, &scene.domain)?;
        Ok(Hollow::new(Cavity::Box { center: vector(center), half_extents }))
    }

    pub(super) fn cylinder_region(
        &self,
        cylinder: &Located<CylinderRegionFile>,
        scene: &Scene,
    ) -> Result<Hollow, Diagnostic> {
        let cylinder = &cylinder.value;
        let center = self.need(&cylinder.center, "particles.in.cylinder.center")?;
        let axis = self.need(&cylinder.axis, "particles.in.cylinder.axis")?.value.index();
        let radius = self.positive(&cylinder.radius, "particles.in.cylinder.radius")?;
        let half_height = self.positive(&cylinder.half_height, "particles.in.cylinder.half_height")?;
        let extents = Vector3::from_fn(|k, _| if k == axis { half_height } else { radius });
        self.keep_inside(center, &extents, &scene.domain)?;
        let axle = RoundAxis { center: vector(center), axis };
        Ok(Hollow::new(Cavity::ClosedCylinder(Frustum { axle, radii: [radius; 2], half_height, solid: true })))
    }

    /// Indices of the walls with the given name, each of which must be able to enclose particles, such as a vessel.
    fn walls_inside(&self, name: &Located<String>, file: &CaseFile, scene: &Scene) -> Result<Vec<u32>, Diagnostic> {
        let walls = file.walls.iter().flatten().zip(0u32..);
        let is_named = |wall: &Option<Located<String>>| wall.as_ref().is_some_and(|own| own.value == name.value);
        let named: Vec<u32> = walls.filter(|(wall, _)| is_named(&wall.value.name)).map(|(_, index)| index).collect();
        if named.is_empty() {
            let names: Vec<String> = file
                .walls
                .iter()
                .flatten()
                .filter_map(|wall| Some(format!("\"{}\"", wall.value.name.as_ref()?.value)))
                .collect();
            let help = match names.is_empty() {
                true => "no wall has a `name`: give it one".to_owned(),
                false => format!("names of walls: {}", names.join(", ")),
            };
            return Err(self.refuse(name, "names no wall").help(help));
        }
        if named.iter().any(|wall| !scene.walls[*wall as usize].geometry.law().has_inside()) {
            let help = "a vessel (`inside = true`), a shell (`open = true`) or an open mesh has one; for other places use `box` or `cylinder`";
            return Err(self.refuse(name, "names a wall that has no inside").help(help));
        }
        Ok(named)
    }
}
