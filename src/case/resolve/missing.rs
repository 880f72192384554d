//! Finds the required keys that a case lacks, and names all of them in one message.

use crate::case::de::Located;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{
    CaseFile, FluidFile, ImpactRuleFile, ParticlesFile, ProfileFile, RegionFile, SizesFile, TangentialFile, WallFile,
};
use crate::case::source::{Origin, Sources};
use crate::experiment::Model;

/// The keys that are missing, each with its table.
struct Missing<'a> {
    keys: Vec<(String, Option<&'a Origin>)>,
}

impl<'a> Missing<'a> {
    fn need<T>(&mut self, value: Option<&T>, key: impl Into<String>, table: Option<&'a Origin>) {
        if value.is_none() {
            self.keys.push((key.into(), table));
        }
    }
}

/// Refuses a case that lacks required keys under `model` (`None`: the case names no model).
///
/// # Errors
/// The keys that are missing, all named in one message.
pub fn refuse_missing(file: &CaseFile, model: Option<Model>, sources: &Sources) -> Result<(), Diagnostic> {
    let mut missing = Missing { keys: Vec::new() };
    let domain = file.domain.as_ref();
    missing.need(domain.and_then(|d| d.value.size.as_ref()), "domain.size", domain.map(|d| &d.origin));
    if let Some(gravity) = &file.gravity {
        missing.need(gravity.value.acceleration.as_ref(), "gravity.acceleration", Some(&gravity.origin));
    }
    if let Some(fluid) = &file.fluid {
        fluid_keys(&mut missing, fluid);
    }
    match &file.particles {
        None => missing.need(None::<&()>, "particles", None),
        Some(list) => list.iter().for_each(|kind| particle_keys(&mut missing, kind)),
    }
    for wall in file.walls.iter().flatten() {
        wall_keys(&mut missing, wall);
    }
    if file.particles.iter().flatten().any(|kind| !is_alone(&kind.value)) || file.particles.iter().flatten().count() > 1
    {
        let contact = file.contact.as_ref();
        missing.need(
            contact.and_then(|c| c.value.restitution.as_ref()),
            "contact.restitution",
            contact.map(|c| &c.origin),
        );
    }
    for pair in file.contact.iter().flat_map(|contact| contact.value.pairs.iter().flatten()) {
        missing.need(pair.value.between.as_ref(), format!("{}.between", pair.path), Some(&pair.origin));
    }
    if model.is_some_and(Model::has_contacts) {
        let soft = file.soft.as_ref();
        let spring = soft.and_then(|s| s.value.linear_spring_dashpot.as_ref());
        let hertz = soft.and_then(|s| s.value.hertz.as_ref());
        if let Some(hertz) = hertz {
            missing.need(hertz.value.youngs_modulus.as_ref(), "soft.hertz.youngs_modulus", Some(&hertz.origin));
        } else {
            missing.need(
                spring.and_then(|s| s.value.stiffness.as_ref()),
                "soft.linear_spring_dashpot.stiffness",
                spring.map(|s| &s.origin).or(soft.map(|s| &s.origin)),
            );
        }
    }
    let tangential = file.soft.as_ref().and_then(|soft| soft.value.tangential.as_ref());
    if let Some(TangentialFile::Linear { stiffness_ratio, tangential_restitution, .. }) =
        tangential.map(|typed| &typed.value)
    {
        let one = stiffness_ratio.as_ref().or(tangential_restitution.as_ref());
        let table = tangential.map(|typed| &typed.origin);
        missing.need(one, "soft.tangential.linear.stiffness_ratio", table);
    }
    let rule = file.hard.as_ref().and_then(|hard| hard.value.friction.as_ref());
    if let Some(ImpactRuleFile::Walton { tangential_restitution }) = rule.map(|typed| &typed.value) {
        let table = rule.map(|typed| &typed.origin);
        missing.need(tangential_restitution.as_ref(), "hard.friction.walton.tangential_restitution", table);
    }
    for sweep in file.sweep.iter().flatten() {
        missing.need(sweep.value.key.as_ref(), format!("{}.key", sweep.path), Some(&sweep.origin));
        missing.need(sweep.value.values.as_ref(), format!("{}.values", sweep.path), Some(&sweep.origin));
    }
    let run = file.run.as_ref();
    missing.need(model.as_ref(), "run.model", run.map(|r| &r.origin));
    missing.need(run.and_then(|r| r.value.duration.as_ref()), "run.duration", run.map(|r| &r.origin));
    missing.into_error(sources)
}

fn region_keys<'a>(missing: &mut Missing<'a>, region: &'a Located<RegionFile>) {
    let path = &region.path;
    if let Some(block) = &region.value.block {
        let at = Some(&block.origin);
        missing.need(block.value.center.as_ref(), format!("{path}.box.center"), at);
        missing.need(block.value.half_extents.as_ref(), format!("{path}.box.half_extents"), at);
    }
    if let Some(cylinder) = &region.value.cylinder {
        let at = Some(&cylinder.origin);
        missing.need(cylinder.value.center.as_ref(), format!("{path}.cylinder.center"), at);
        missing.need(cylinder.value.axis.as_ref(), format!("{path}.cylinder.axis"), at);
        missing.need(cylinder.value.radius.as_ref(), format!("{path}.cylinder.radius"), at);
        missing.need(cylinder.value.half_height.as_ref(), format!("{path}.cylinder.half_height"), at);
    }
}

fn fluid_keys<'a>(missing: &mut Missing<'a>, fluid: &'a Located<FluidFile>) {
    let at = Some(&fluid.origin);
    missing.need(fluid.value.density.as_ref(), "fluid.density", at);
    missing.need(fluid.value.kinematic_viscosity.as_ref(), "fluid.kinematic_viscosity", at);
    match &fluid.value.profile {
        None => missing.need(None::<&()>, "fluid.profile", at),
        Some(profile) => {
            let at = Some(&profile.origin);
            match &profile.value {
                ProfileFile::Uniform { velocity } => {
                    missing.need(velocity.as_ref(), "fluid.profile.uniform.velocity", at);
                }
                ProfileFile::Table { file } => missing.need(file.as_ref(), "fluid.profile.table.file", at),
                ProfileFile::KEpsilonChannel { reynolds_number, .. } => {
                    missing.need(reynolds_number.as_ref(), "fluid.profile.k_epsilon_channel.reynolds_number", at);
                }
                ProfileFile::KEpsilonPipe { reynolds_number, .. } => {
                    missing.need(reynolds_number.as_ref(), "fluid.profile.k_epsilon_pipe.reynolds_number", at);
                }
                ProfileFile::LogLaw { friction_velocity, reynolds_number, .. } => {
                    if friction_velocity.is_none() && reynolds_number.is_none() {
                        let keys = "fluid.profile.log_law.friction_velocity` (or `reynolds_number";
                        missing.keys.push((keys.into(), at));
                    }
                }
            }
        }
    }
}

fn particle_keys<'a>(missing: &mut Missing<'a>, kind: &'a Located<ParticlesFile>) {
    let (path, at, kind) = (&kind.path, Some(&kind.origin), &kind.value);
    if let Some(region) = &kind.region {
        region_keys(missing, region);
    }
    match &kind.sizes {
        None if kind.diameter.is_none() => missing.keys.push((format!("{path}.diameter` (or `sizes"), at)),
        None => {}
        Some(sizes) => size_keys(missing, sizes),
    }
    missing.need(kind.density.as_ref(), format!("{path}.density"), at);
    if kind.count.is_none() && kind.volume_fraction.is_none() && kind.file.is_none() && kind.at.is_none() {
        missing.keys.push((format!("{path}.count` (or `volume_fraction`, `file`, `at"), at));
    }
    for placed in kind.at.iter().flat_map(|list| &list.value) {
        missing.need(placed.value.position.as_ref(), format!("{}.position", placed.path), Some(&placed.origin));
    }
}

fn size_keys<'a>(missing: &mut Missing<'a>, sizes: &'a Located<SizesFile>) {
    let (path, at) = (&sizes.path, Some(&sizes.origin));
    match &sizes.value {
        SizesFile::Uniform { from, to } => {
            missing.need(from.as_ref(), format!("{path}.uniform.from"), at);
            missing.need(to.as_ref(), format!("{path}.uniform.to"), at);
        }
        SizesFile::LogNormal { median, geometric_deviation, from, to } => {
            missing.need(median.as_ref(), format!("{path}.log_normal.median"), at);
            missing.need(geometric_deviation.as_ref(), format!("{path}.log_normal.geometric_deviation"), at);
            missing.need(from.as_ref(), format!("{path}.log_normal.from"), at);
            missing.need(to.as_ref(), format!("{path}.log_normal.to"), at);
        }
        SizesFile::Table { diameters, fractions, .. } => {
            missing.need(diameters.as_ref(), format!("{path}.table.diameters"), at);
            missing.need(fractions.as_ref(), format!("{path}.table.fractions"), at);
        }
    }
}

fn wall_keys<'a>(missing: &mut Missing<'a>, wall: &'a Located<WallFile>) {
    let (path, at, wall) = (&wall.path, Some(&wall.origin), &wall.value);
    missing.need(wall.restitution.as_ref(), format!("{path}.restitution"), at);
    if let Some(plane) = &wall.plane {
        missing.need(plane.value.point.as_ref(), format!("{path}.plane.point"), at);
        missing.need(plane.value.normal.as_ref(), format!("{path}.plane.normal"), at);
    } else if let Some(sphere) = &wall.sphere {
        missing.need(sphere.value.center.as_ref(), format!("{path}.sphere.center"), at);
        missing.need(sphere.value.radius.as_ref(), format!("{path}.sphere.radius"), at);
    } else if let Some(cuboid) = &wall.cuboid {
        missing.need(cuboid.value.center.as_ref(), format!("{path}.cuboid.center"), at);
        missing.need(cuboid.value.half_extents.as_ref(), format!("{path}.cuboid.half_extents"), at);
    } else if let Some(room) = &wall.room {
        missing.need(room.value.center.as_ref(), format!("{path}.box.center"), at);
        missing.need(room.value.half_extents.as_ref(), format!("{path}.box.half_extents"), at);
    } else if let Some(cylinder) = &wall.cylinder {
        let cylinder = &cylinder.value;
        missing.need(cylinder.center.as_ref(), format!("{path}.cylinder.center"), at);
        missing.need(cylinder.axis.as_ref(), format!("{path}.cylinder.axis"), at);
        missing.need(cylinder.radius.as_ref(), format!("{path}.cylinder.radius"), at);
        if !cylinder.inside.as_ref().is_some_and(|inside| inside.value) {
            missing.need(cylinder.half_height.as_ref(), format!("{path}.cylinder.half_height"), at);
        }
    } else if let Some(cone) = &wall.cone {
        let cone = &cone.value;
        missing.need(cone.center.as_ref(), format!("{path}.cone.center"), at);
        missing.need(cone.axis.as_ref(), format!("{path}.cone.axis"), at);
        missing.need(cone.lower_radius.as_ref(), format!("{path}.cone.lower_radius"), at);
        missing.need(cone.upper_radius.as_ref(), format!("{path}.cone.upper_radius"), at);
        missing.need(cone.half_height.as_ref(), format!("{path}.cone.half_height"), at);
    } else if let Some(mesh) = &wall.mesh {
        missing.need(mesh.value.file.as_ref(), format!("{path}.mesh.file"), at);
        missing.need(mesh.value.unit.as_ref(), format!("{path}.mesh.unit"), at);
    } else {
        missing.keys.push((format!("{path}.plane` (or `sphere`, `cuboid`, `box`, `cylinder`, `cone`, `mesh"), at));
    }
}

/// True if a kind has at most one particle, so that it can only touch walls.
fn is_alone(kind: &ParticlesFile) -> bool {
    match (&kind.count, &kind.at) {
        (Some(count), _) => count.value <= 1,
        (_, Some(list)) => list.value.len() <= 1,
        _ => false,
    }
}

impl Missing<'_> {
    fn into_error(self, sources: &Sources) -> Result<(), Diagnostic> {
        let first_table = self.keys.iter().find_map(|(_, table)| *table);
        if self.keys.is_empty() {
            return Ok(());
        }
        let list: Vec<String> = self
            .keys
            .iter()
            .map(|(key, table)| match table.map(|origin| sources.line(origin)) {
                Some(line) if line > 0 => format!("`{key}` (table in line {line})"),
                _ => format!("`{key}`"),
            })
            .collect();
        let plural = if list.len() == 1 { "a required key is missing" } else { "required keys are missing" };
        // without any table of its own the error is about the case file, the first source
        let whole = Origin { source: 0, span: 0..0 };
        let mut diagnostic = sources.error(first_table.unwrap_or(&whole), format!("{plural}: {}", list.join(", ")));
        if first_table.is_none()
            && let Some(place) = &mut diagnostic.place
        {
            place.line = 0;
        }
        Err(diagnostic.help("add them, or name a set of values with `use`; `cases/quick.toml` is a complete case"))
    }
}
