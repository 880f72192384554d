//! Reads the walls of a case: makes the shape of each table, and checks that it fits into the domain.

use super::{Resolver, vector};
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{Axis, CaseFile, ConeFile, CylinderFile, PlaneFile, Three, WallFile};
use crate::case::located::Located;
use crate::case::quantity::Length;
use crate::domain::Domain;
use crate::scene::{Species, Surface};
use crate::walls::{
    Cavity, Frustum, Geometry, Hollow, Obstacle, Plane, RoundAxis, ThermalWall, Turning, Wall, WallGeometry,
    WallRoughness,
};
use nalgebra::Vector3;
use std::sync::Arc;

/// [-] largest component of a unit normal along an axis that counts as rounding of 0.
const ALIGNED: f64 = 1e-9;
/// [-] largest distance by which a hollow body may reach beyond the box because of rounding, divided by the size of
/// the box.
const ROUNDING: f64 = 1e-9;

/// Largest number of walls of a case. So many walls take 1 GB of memory, and about 10 s to check.
const MOST_WALLS: usize = 100_000;

/// Side of a body on which the particles are: outside a solid body, inside a vessel, or on both sides of a thin shell.
#[derive(Clone, Copy, PartialEq, Eq)]
enum BodySide {
    Solid,
    Inside,
    Shell,
}

/// Help text of the error for a body that is too near its own periodic image.
pub(super) const OWN_IMAGE: &str =
    "a body stands again beyond every periodic side: make the domain larger or the body smaller";

/// Reason to refuse a body from `low` to `high` [m] along an axis: no sphere of the diameter `largest` [m] fits between
/// the body and its periodic image. `None` if there is enough room.
pub(super) fn too_near_its_image(domain: &Domain, axis: usize, [low, high]: [f64; 2], largest: f64) -> Option<String> {
    let room = domain.size[axis] - (high - low);
    (domain.periodic[axis] && room < largest).then(|| {
        let name = ["x", "y", "z"][axis];
        format!("comes too near its periodic image: from {name} = {low:.4e} to {high:.4e} m it leaves {room:.4e} m; allowed: at least the largest diameter, {largest:.4e} m")
    })
}

/// True if the case gives the key, with the value `true`.
fn says(key: &Option<Located<bool>>) -> bool {
    key.as_ref().is_some_and(|key| key.value)
}

/// Half the edges [m] of the smallest box around a cylinder or cone, from its axis (0, 1 or 2), radius [m] and half
/// height [m].
fn around(axis: usize, radius: f64, half_height: f64) -> Vector3<f64> {
    Vector3::from_fn(|k, _| if k == axis { half_height } else { radius })
}

impl Resolver {
    /// Walls of the scene, in the order of the case.
    pub(super) fn walls(
        &mut self,
        file: &CaseFile,
        domain: &Domain,
        species: &[Species],
    ) -> Result<Vec<Wall>, Diagnostic> {
        let largest = species.iter().map(Species::largest).fold(0.0, f64::max);
        let mut walls = Vec::new();
        if let Some(wall) = file.walls.as_ref().and_then(|walls| walls.get(MOST_WALLS)) {
            let message = format!("there are more than {MOST_WALLS} walls");
            return Err(self
                .sources
                .error(&wall.origin, message)
                .help("a surface of many pieces is one wall: a `mesh`"));
        }
        for wall in file.walls.iter().flatten() {
            let geometry = self.shape(wall, domain, largest)?;
            let surface = self.surface(&wall.value.restitution, &wall.value.friction)?;
            let elasticity = self.own_elasticity(file, &wall.value.elasticity)?;
            let velocity = self.wall_velocity(&wall.value, &geometry)?;
            let turning = self.wall_turning(&wall.value, &geometry, domain)?;
            let WallFile { rolling_friction, twisting_friction, .. } = &wall.value;
            let resistance = self.resistance_friction(file, rolling_friction, twisting_friction)?;
            let motion = wall.value.motion.as_ref();
            let moves = velocity != Vector3::zeros() || turning.is_some() || motion.is_some();
            let roughness = self.roughness(&wall.value, &surface, moves)?;
            let thermal = self.thermal(&wall.value, &surface, roughness.is_some())?;
            let still =
                Wall { elasticity, velocity, turning, resistance, roughness, thermal, ..Wall::new(geometry, surface) };
            walls.push(self.moving(still, motion, domain)?);
        }
        Ok(walls)
    }

    /// Roughness of a wall; `None` if the wall is smooth. `moves` is true if the wall or its surface moves.
    fn roughness(&self, wall: &WallFile, surface: &Surface, moves: bool) -> Result<Option<WallRoughness>, Diagnostic> {
        let Some(typed) = &wall.roughness else { return Ok(None) };
        let number = self.need(&typed.value.deviation, "walls.roughness.deviation")?;
        let help = "the standard deviation of the inclination, such as \"5 deg\"; a plain number is in radians";
        let deviation = self.in_range(number, help)?;
        let refuse = |what: &str, help: &str| {
            Err(self.sources.error(&typed.origin, format!("`{}` {what}", typed.path)).help(help))
        };
        match deviation > 0.0 {
            true if moves => refuse(
                "needs a surface that does not move",
                "leave out `velocity`, `rotation` and `motion` of the wall",
            ),
            true if !surface.always_rebounds() => {
                refuse("needs a rebound: with restitution 0 a sphere stays on a facet", "use a restitution of 0.01")
            }
            // the seed is set when a run starts
            true => Ok(Some(WallRoughness { deviation, seed: 0 })),
            false => Ok(None),
        }
    }

    /// Temperature of a thermal wall; `None` if the wall has no temperature. `rough` is true if the wall has a
    /// roughness.
    fn thermal(&self, wall: &WallFile, surface: &Surface, rough: bool) -> Result<Option<ThermalWall>, Diagnostic> {
        let Some(typed) = &wall.temperature else { return Ok(None) };
        let temperature = self.in_range(typed, "for a wall without a temperature leave it out")?;
        let elastic = surface.restitution == 1.0 && surface.by_speed.is_none() && surface.friction == 0.0;
        if self.model.has_contacts() {
            let what =
                "is for impacts without duration: a lasting contact has no instant at which it gets a new velocity";
            return Err(self.refuse(typed, what).help("use the hard or the dsmc model, or leave it out"));
        }
        if !elastic || rough {
            let what = "gives every sphere a new velocity, which replaces restitution, friction and roughness";
            return Err(self.refuse(typed, what).help("write `restitution = 1`, and leave out friction and roughness"));
        }
        // the seed is set when a run starts
        Ok(Some(ThermalWall { temperature, seed: 0 }))
    }

    /// [m/s] velocity of the surface of a wall whose shape does not move; zero if the case gives none. The velocity
    /// must be parallel to the surface.
    fn wall_velocity(&self, wall: &WallFile, geometry: &WallGeometry) -> Result<Vector3<f64>, Diagnostic> {
        let Some(typed) = &wall.velocity else { return Ok(Vector3::zeros()) };
        for component in &typed.value {
            self.in_range(component, "the velocity of a wall's surface")?;
        }
        let velocity = vector(typed);
        if velocity != Vector3::zeros() && !geometry.law().slides(&velocity) {
            return Err(self.refuse(typed, "would move the surface from its place").help(
                "a wall moves along itself only: a plane at right angles to its normal, a pipe without ends along its axis",
            ));
        }
        Ok(velocity)
    }

    /// Rotation of the surface of a wall whose shape does not move; `None` if the case gives no rotation. The rotation
    /// must turn the shape into itself.
    fn wall_turning(
        &self,
        wall: &WallFile,
        geometry: &WallGeometry,
        domain: &Domain,
    ) -> Result<Option<Turning>, Diagnostic> {
        let Some(rotation) = &wall.rotation else { return Ok(None) };
        let rate = self.need(&rotation.value.rate, "rotation.rate")?;
        let rate = self.in_range(rate, "the angular velocity of a wall's surface")?;
        let round = |center: &Option<Three<Length>>, axis: &Option<Located<Axis>>| {
            let along = axis.as_ref().map(|axis| Vector3::ith(axis.value.index(), 1.0));
            (center.as_ref().map(vector), along)
        };
        let (center, own) = if let Some(plane) = &wall.plane {
            (plane.value.point.as_ref().map(vector), plane.value.normal.as_ref().map(vector))
        } else if let Some(cylinder) = &wall.cylinder {
            round(&cylinder.value.center, &cylinder.value.axis)
        } else if let Some(cone) = &wall.cone {
            round(&cone.value.center, &cone.value.axis)
        } else {
            (wall.sphere.as_ref().and_then(|sphere| sphere.value.center.as_ref().map(vector)), None)
        };
        let change = |what: &str| {
            self.refuse(rotation, what).help(
                "a wall turns along itself only: a plane about its normal, a cylinder or cone about its axis, a sphere",
            )
        };
        let axis = rotation.value.axis.as_ref().map(vector).or(own);
        let Some(center) = center else { return Err(change("would move the surface from its place")) };
        let Some(axis) = axis.and_then(|axis| axis.try_normalize(0.0)) else {
            return Err(change("has no `axis`"));
        };
        let turning = Turning { center, spin: axis * rate };
        if !geometry.law().turns(&turning) {
            return Err(change("would move the surface from its place"));
        }
        let across = |k: usize| domain.periodic[k] && axis[k].abs() < 1.0 - ALIGNED;
        if geometry.is_flat() && (0..3).any(across) {
            return Err(self
                .refuse(rotation, "turns a plane that is periodic across the axis: its surface would jump there")
                .help("make the domain not periodic along the plane"));
        }
        Ok(Some(turning))
    }

    fn shape(&mut self, wall: &Located<WallFile>, domain: &Domain, largest: f64) -> Result<WallGeometry, Diagnostic> {
        if let Some(plane) = &wall.value.plane {
            return self.plane(plane, domain).map(WallGeometry::Plane);
        }
        if let Some(mesh) = &wall.value.mesh {
            return Ok(WallGeometry::Mesh(Arc::new(self.mesh(mesh, domain, largest)?)));
        }
        let (geometry, center, extents) = if let Some(sphere) = &wall.value.sphere {
            let (at, center) = self.center(&sphere.value.center)?;
            let radius = self.positive(&sphere.value.radius, "sphere.radius")?;
            let geometry = if says(&sphere.value.inside) {
                WallGeometry::Hollow(Hollow::new(Cavity::Sphere { center, radius }))
            } else {
                WallGeometry::Obstacle(Obstacle::sphere(center, radius))
            };
            (geometry, at, Vector3::repeat(radius))
        } else if let Some(cuboid) = &wall.value.cuboid {
            let (at, center) = self.center(&cuboid.value.center)?;
            let half_extents = self.half_extents(&cuboid.value.half_extents)?;
            (WallGeometry::Obstacle(Obstacle::cuboid(center, half_extents)), at, half_extents)
        } else if let Some(room) = &wall.value.room {
            let (at, center) = self.center(&room.value.center)?;
            let half_extents = self.half_extents(&room.value.half_extents)?;
            let geometry = if says(&room.value.inside) {
                WallGeometry::Hollow(Hollow::new(Cavity::Box { center, half_extents }))
            } else {
                WallGeometry::Obstacle(Obstacle::cuboid(center, half_extents))
            };
            (geometry, at, half_extents)
        } else if let Some(cone) = &wall.value.cone {
            let (geometry, extents) = self.cone(cone)?;
            (geometry, self.need(&cone.value.center, "cone.center")?, extents)
        } else {
            let cylinder = self.need(&wall.value.cylinder, "cylinder")?;
            let (geometry, extents) = self.cylinder(cylinder)?;
            (geometry, self.need(&cylinder.value.center, "cylinder.center")?, extents)
        };
        if matches!(geometry, WallGeometry::Hollow(_)) {
            self.keep_inside(center, &extents, domain)?;
        } else {
            self.keep_from_own_image(center, &extents, domain, largest)?;
        }
        Ok(geometry)
    }

    fn center<'a>(&self, center: &'a Option<Three<Length>>) -> Result<(&'a Three<Length>, Vector3<f64>), Diagnostic> {
        let center = self.need(center, "center")?;
        Ok((center, vector(center)))
    }

    /// [m] value of a required length, which must be positive.
    pub(super) fn positive(&self, length: &Option<Located<Length>>, key: &str) -> Result<f64, Diagnostic> {
        let length = self.need(length, key)?;
        self.in_range(length, "a body has a positive size")
    }

    /// [m] half the edges of a block, all of which must be positive.
    pub(super) fn half_extents(&self, half: &Option<Three<Length>>) -> Result<Vector3<f64>, Diagnostic> {
        let half = self.need(half, "half_extents")?;
        for edge in &half.value {
            self.in_range(edge, "a body has a positive size")?;
        }
        Ok(vector(half))
    }

    /// Side of a body on which the particles are, from its keys `inside` and `open`.
    fn solidity(&self, inside: &Option<Located<bool>>, open: &Option<Located<bool>>) -> Result<BodySide, Diagnostic> {
        match (says(inside), open.as_ref().filter(|open| open.value)) {
            (true, Some(open)) => Err(self
                .refuse(open, "goes with `inside = true` no better than an open end with a closed one")
                .help("a shell that is open at its ends has particles on both sides: leave `inside` out")),
            (true, None) => Ok(BodySide::Inside),
            (false, Some(_)) => Ok(BodySide::Shell),
            (false, None) => Ok(BodySide::Solid),
        }
    }

    fn cylinder(&self, cylinder: &Located<CylinderFile>) -> Result<(WallGeometry, Vector3<f64>), Diagnostic> {
        let cylinder = &cylinder.value;
        let (_, center) = self.center(&cylinder.center)?;
        let axis = self.need(&cylinder.axis, "cylinder.axis")?.value.index();
        let radius = self.positive(&cylinder.radius, "cylinder.radius")?;
        let kind = self.solidity(&cylinder.inside, &cylinder.open)?;
        let axle = RoundAxis { center, axis };
        if kind == BodySide::Inside && cylinder.half_height.is_none() {
            let pipe = Hollow::new(Cavity::Pipe { axle, radius });
            return Ok((WallGeometry::Hollow(pipe), around(axis, radius, 0.0)));
        }
        let half_height = self.positive(&cylinder.half_height, "cylinder.half_height")?;
        let frustum = Frustum { axle, radii: [radius; 2], half_height, solid: kind != BodySide::Shell };
        let geometry = match kind {
            BodySide::Solid => WallGeometry::Obstacle(Obstacle::cylinder(center, axis, radius, half_height)),
            BodySide::Inside => WallGeometry::Hollow(Hollow::new(Cavity::ClosedCylinder(frustum))),
            BodySide::Shell => WallGeometry::Frustum(frustum),
        };
        Ok((geometry, around(axis, radius, half_height)))
    }

    fn cone(&self, cone: &Located<ConeFile>) -> Result<(WallGeometry, Vector3<f64>), Diagnostic> {
        let cone = &cone.value;
        let (_, center) = self.center(&cone.center)?;
        let axis = self.need(&cone.axis, "cone.axis")?.value.index();
        let low = self.positive(&cone.lower_radius, "cone.lower_radius")?;
        let high = self.positive(&cone.upper_radius, "cone.upper_radius")?;
        let half_height = self.positive(&cone.half_height, "cone.half_height")?;
        let kind = self.solidity(&cone.inside, &cone.open)?;
        let axle = RoundAxis { center, axis };
        let frustum = Frustum { axle, radii: [low, high], half_height, solid: kind != BodySide::Shell };
        let geometry = match kind {
            BodySide::Solid | BodySide::Shell => WallGeometry::Frustum(frustum),
            BodySide::Inside => WallGeometry::Hollow(Hollow::new(Cavity::ClosedCylinder(frustum))),
        };
        Ok((geometry, around(axis, low.max(high), half_height)))
    }

    /// Checks that a hollow body lies inside the domain, so that particles inside the body never leave the domain.
    pub(super) fn keep_inside(
        &self,
        center: &Three<Length>,
        extents: &Vector3<f64>,
        domain: &Domain,
    ) -> Result<(), Diagnostic> {
        let at = vector(center);
        for axis in 0..3 {
            let (low, high) = (at[axis] - extents[axis], at[axis] + extents[axis]);
            let slack = ROUNDING * domain.size[axis];
            if low < -slack || high > domain.size[axis] + slack {
                let name = ["x", "y", "z"][axis];
                let why = format!(
                    "puts the hollow body at {name} = {low:.4e} ..= {high:.4e} m; allowed: 0 ..= {:.4e} m, the domain",
                    domain.size[axis]
                );
                return Err(self.refuse(center, why).help("particles inside must not leave the domain"));
            }
        }
        Ok(())
    }

    pub(super) fn plane(&self, plane: &Located<PlaneFile>, domain: &Domain) -> Result<Plane, Diagnostic> {
        let point = vector(self.need(&plane.value.point, "plane.point")?);
        let typed = self.need(&plane.value.normal, "plane.normal")?;
        // after division by the largest component, squares of the components can neither overflow nor all become 0
        let raw = vector(typed);
        let largest = raw.amax();
        if largest == 0.0 {
            return Err(self
                .refuse(typed, "has no direction")
                .help("the normal points from the wall to the particles: [0, 1, 0]"));
        }
        let normal = (raw / largest).normalize();
        if let Some(axis) = (0..3).find(|axis| domain.periodic[*axis] && normal[*axis].abs() > ALIGNED) {
            let name = ["x", "y", "z"][axis];
            let why = format!("has a component along {name}, but the domain is periodic along {name}");
            return Err(self
                .refuse(typed, why)
                .help(format!("take \"{name}\" out of domain.periodic, or turn the wall")));
        }
        let plane_geometry = Plane { point, normal };
        let inside = (0..8).any(|corner| {
            let corner = Vector3::from_fn(|axis, _| if corner >> axis & 1 == 1 { domain.size[axis] } else { 0.0 });
            plane_geometry.nearest(&corner).distance > 0.0
        });
        if !inside {
            let message = format!("`{}` leaves no room: the whole domain lies behind it", plane.path);
            return Err(self
                .sources
                .error(&typed.origin, message)
                .help("the normal points from the wall to the particles"));
        }
        Ok(plane_geometry)
    }

    /// Checks that at least a part of a body is inside the domain. Across periodic sides, every sphere must fit
    /// between the body and its own periodic image. Along an axis that is not periodic the body may reach out of the
    /// domain.
    fn keep_from_own_image(
        &self,
        center: &Three<Length>,
        extents: &Vector3<f64>,
        domain: &Domain,
        largest: f64,
    ) -> Result<(), Diagnostic> {
        let at = vector(center);
        for axis in 0..3 {
            let (low, high) = (at[axis] - extents[axis], at[axis] + extents[axis]);
            if high <= 0.0 || low >= domain.size[axis] {
                return Err(self.refuse(center, "puts the body outside the domain").help("see `domain.size`"));
            }
            if let Some(why) = too_near_its_image(domain, axis, [low, high], largest) {
                return Err(self.refuse(center, format!("puts a body there that {why}")).help(OWN_IMAGE));
            }
        }
        Ok(())
    }
}
