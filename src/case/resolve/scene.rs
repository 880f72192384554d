//! Domain, walls, gas, gravity and surfaces.

use super::{Resolver, short, vector};
use crate::case::de::Located;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, FluidFile, PlaneFile, ProfileFile, Three, TurbulenceFile, WallFile};
use crate::case::quantity::{Length, Ratio};
use crate::domain::Domain;
use crate::experiment::Model;
use crate::fluid::TurbulenceModel;
use crate::fluid::{Fluid, Profile};
use crate::scene::{Species, Surface};
use crate::walls::{Geometry, Obstacle, Plane, Wall, WallGeometry};
use nalgebra::Vector3;

/// [m/s²] a hundred times that of the fastest centrifuges.
const STRONGEST: f64 = 1e9;
/// [-] below it a normal's component along an axis is rounding.
const ALIGNED: f64 = 1e-9;

impl Resolver {
    /// Box and periodic axes.
    pub(super) fn domain(&mut self, file: &CaseFile) -> Result<Domain, Diagnostic> {
        let domain = self.need(&file.domain, "domain")?;
        let size = self.need(&domain.value.size, "domain.size")?;
        for edge in &size.value {
            self.checked(edge, |l| l > 0.0, "greater than 0 m", "an edge of the box has a positive length")?;
            self.checked(edge, |l| (1e-6..=1e4).contains(&l), "1e-6 m ..= 1e4 m", unit_slip(edge.value.0))?;
        }
        let mut periodic = [false; 3];
        for axis in domain.value.periodic.iter().flatten() {
            let index = axis.value.index();
            if periodic[index] {
                return Err(self.refuse(axis, "names an axis twice").help("each axis once: [\"x\", \"z\"]"));
            }
            periodic[index] = true;
        }
        Ok(Domain::new(vector(size), periodic))
    }

    /// [m/s²] zero if the case has none.
    ///
    /// # Errors
    /// An acceleration with which nothing can be computed.
    pub(super) fn gravity(&mut self, file: &CaseFile) -> Result<Vector3<f64>, Diagnostic> {
        let Some(acceleration) = file.gravity.as_ref().and_then(|gravity| gravity.value.acceleration.as_ref()) else {
            return Ok(Vector3::zeros());
        };
        for component in &acceleration.value {
            let help = "the earth's is 9.81 m/s^2, that of the fastest centrifuges 1e7 m/s^2";
            self.checked(component, |g| g.abs() <= STRONGEST, "-1e9 ..= 1e9 m/s^2", help)?;
        }
        let gravity = vector(acceleration);
        if gravity.norm() > 1000.0 {
            let message = format!("`gravity.acceleration` is {:.3e} m/s^2", gravity.norm());
            self.warn(&acceleration.origin, message, "the earth's is 9.81 m/s^2");
        }
        Ok(gravity)
    }

    /// Restitution and friction.
    pub(super) fn surface(
        &self,
        restitution: &Option<Located<Ratio>>,
        friction: &Option<Located<Ratio>>,
    ) -> Result<Surface, Diagnostic> {
        let restitution = self.need(restitution, "restitution")?;
        let help = "restitution is the ratio of normal speeds after and before an impact: 1 elastic, 0 without rebound";
        let e = self.checked(restitution, |e| (0.0..=1.0).contains(&e), "0 ..= 1", help)?;
        if e == 0.0 && self.model == Model::Soft {
            let why = "cannot be had from a linear spring-dashpot: its damping ratio -ln e / sqrt(π² + ln² e) needs ln 0; \
                       allowed: 0 < e <= 1";
            return Err(self.refuse(restitution, why).help("use 0.01, or the hard model, which takes 0"));
        }
        let mu = match friction {
            Some(friction) => self.checked(
                friction,
                |mu| (0.0..=100.0).contains(&mu),
                "0 ..= 100",
                "friction opposes sliding; 0 is smooth",
            )?,
            None => 0.0,
        };
        Ok(Surface { restitution: e, friction: mu })
    }

    /// The gas, if there is one.
    pub(super) fn fluid(
        &mut self,
        file: &CaseFile,
        domain: &Domain,
        species: &[Species],
    ) -> Result<Option<Fluid>, Diagnostic> {
        let Some(fluid) = &file.fluid else {
            if let Some(drag) = &file.drag {
                self.warn(&drag.origin, "`drag` does nothing: there is no gas", "add [fluid], or leave [drag] out");
            }
            return Ok(None);
        };
        let density = self.need(&fluid.value.density, "fluid.density")?;
        let rho =
            self.checked(density, |rho| rho > 0.0, "greater than 0 kg/m^3", "the density of air is 1.2 kg/m^3")?;
        self.checked(
            density,
            |rho| (1e-4..=3e4).contains(&rho),
            "1e-4 ..= 3e4 kg/m^3",
            "did you mean \"1.2 kg/m^3\" (air)?",
        )?;
        let viscosity = self.need(&fluid.value.kinematic_viscosity, "fluid.kinematic_viscosity")?;
        // from mm²/s, or from St; the shortest way to print either is to let the parser scale it
        let unit = if viscosity.value.0 > 1.0 { "mm^2/s" } else { "cm^2/s" };
        let slip =
            format!("did you mean \"{} {unit}\"? air has 1.5e-5 m^2/s, water 1e-6 m^2/s", short(viscosity.value.0));
        let nu = self.checked(viscosity, |nu| (1e-8..=1e-2).contains(&nu), "1e-8 ..= 1e-2 m^2/s", slip)?;
        let profile = self.profile(fluid, domain, nu, species)?;
        let drag = match &file.drag {
            Some(drag) => Some(drag.value.clone()),
            None => {
                self.warn(
                    &fluid.origin,
                    "the gas exerts no force: the case has no drag law",
                    "add [drag.schiller_naumann]",
                );
                None
            }
        };
        Ok(Some(Fluid { density: rho, kinematic_viscosity: nu, profile, drag }))
    }

    fn profile(
        &mut self,
        fluid: &Located<FluidFile>,
        domain: &Domain,
        nu: f64,
        species: &[Species],
    ) -> Result<Profile, Diagnostic> {
        let profile = self.need(&fluid.value.profile, "fluid.profile")?;
        match &profile.value {
            ProfileFile::Uniform { velocity } => {
                let velocity = self.need(velocity, "fluid.profile.uniform.velocity")?;
                let slow = |u: f64| u.abs() <= 1e4;
                Ok(Profile::Uniform(self.checked(velocity, slow, "-1e4 ..= 1e4 m/s", "a gas velocity along z")?))
            }
            ProfileFile::Table { file } => {
                let name = self.need(file, "fluid.profile.table.file")?;
                let points = self.profile_table(name)?;
                let smallest = species.iter().map(|kind| 0.5 * kind.diameter).fold(f64::INFINITY, f64::min);
                self.check_cover(name, &points, domain.size.y, smallest)?;
                Profile::table(&points).map_err(|why| self.refuse(name, format!("is no velocity profile: {why}")))
            }
            ProfileFile::KEpsilonChannel { reynolds_number, model } => {
                let number = self.need(reynolds_number, "fluid.profile.k_epsilon_channel.reynolds_number")?;
                let model = match model.as_ref().map_or(TurbulenceFile::WallFunctions, |model| model.value) {
                    TurbulenceFile::WallFunctions => TurbulenceModel::WallFunctions,
                    TurbulenceFile::LaunderSharma => TurbulenceModel::LaunderSharma,
                };
                let help = "Re = U_b L_y/ν with the bulk velocity and the full width; k-ε is for turbulent flow, and wall functions \
                            need a higher Re than `model = \"launder_sharma\"`";
                let lowest = model.lowest_reynolds();
                let reynolds =
                    self.checked(number, |re| (lowest..=1e8).contains(&re), &format!("{lowest} ..= 1e8"), help)?;
                self.between_walls(number, domain)?;
                let height = domain.size.y;
                Profile::k_epsilon_channel(reynolds * nu / height, height, nu, model)
                    .map_err(|why| self.refuse(number, format!("gives no k-ε solution: {why}")).help(help))
            }
            ProfileFile::LogLaw { friction_velocity, reynolds_number, von_karman, intercept } => {
                let constants = self.log_constants(von_karman.as_ref(), intercept.as_ref())?;
                self.log_law((friction_velocity.as_ref(), reynolds_number.as_ref()), constants, domain, nu)
                    .map(Profile::LogLaw)
            }
        }
    }

    /// Walls, in the order of the case.
    pub(super) fn walls(
        &mut self,
        file: &CaseFile,
        domain: &Domain,
        species: &[Species],
    ) -> Result<Vec<Wall>, Diagnostic> {
        let largest = species.iter().map(|kind| kind.diameter).fold(0.0, f64::max);
        let mut walls = Vec::new();
        for wall in file.walls.iter().flatten() {
            let shapes = [
                wall.value.plane.is_some(),
                wall.value.sphere.is_some(),
                wall.value.cuboid.is_some(),
                wall.value.cylinder.is_some(),
            ];
            if shapes.iter().filter(|named| **named).count() > 1 {
                let message = format!("`{}` has more than one shape", wall.path);
                let help = "one [[walls]] table each, with `plane`, `sphere`, `cuboid` or `cylinder`";
                return Err(self.sources.error(&wall.origin, message).help(help));
            }
            let geometry = match &wall.value.plane {
                Some(plane) => WallGeometry::Plane(self.plane(plane, domain)?),
                None => WallGeometry::Obstacle(self.obstacle(wall, domain, largest)?),
            };
            let surface = self.surface(&wall.value.restitution, &wall.value.friction)?;
            let elasticity = self.own_elasticity(file, &wall.value.elasticity)?;
            walls.push(Wall { geometry, surface, elasticity });
        }
        Ok(walls)
    }

    fn plane(&self, plane: &Located<PlaneFile>, domain: &Domain) -> Result<Plane, Diagnostic> {
        let point = vector(self.need(&plane.value.point, "plane.point")?);
        let typed = self.need(&plane.value.normal, "plane.normal")?;
        // scaled first: the squares of tiny or huge components would leave the range of a double
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

    fn obstacle(&self, wall: &Located<WallFile>, domain: &Domain, largest: f64) -> Result<Obstacle, Diagnostic> {
        let positive = |length: &Located<Length>| {
            self.checked(length, |l| l > 0.0, "greater than 0 m", "a solid body has a positive size")
        };
        let (obstacle, center, extents) = if let Some(sphere) = &wall.value.sphere {
            let center = self.need(&sphere.value.center, "sphere.center")?;
            let radius = positive(self.need(&sphere.value.radius, "sphere.radius")?)?;
            (Obstacle::sphere(vector(center), radius), center, Vector3::repeat(radius))
        } else if let Some(cuboid) = &wall.value.cuboid {
            let center = self.need(&cuboid.value.center, "cuboid.center")?;
            let half = self.need(&cuboid.value.half_extents, "cuboid.half_extents")?;
            half.value.iter().try_for_each(|edge| positive(edge).map(|_| ()))?;
            (Obstacle::cuboid(vector(center), vector(half)), center, vector(half))
        } else {
            let cylinder = &self.need(&wall.value.cylinder, "cylinder")?.value;
            let center = self.need(&cylinder.center, "cylinder.center")?;
            let axis = self.need(&cylinder.axis, "cylinder.axis")?.value.index();
            let radius = positive(self.need(&cylinder.radius, "cylinder.radius")?)?;
            let half = positive(self.need(&cylinder.half_height, "cylinder.half_height")?)?;
            let extents = Vector3::from_fn(|i, _| if i == axis { half } else { radius });
            (Obstacle::cylinder(vector(center), axis, radius, half), center, extents)
        };
        self.keep_from_periodic_sides(center, &extents, domain, largest)?;
        Ok(obstacle)
    }

    /// An obstacle has no periodic image: no particle on the other side may reach it.
    fn keep_from_periodic_sides(
        &self,
        center: &Three<Length>,
        extents: &Vector3<f64>,
        domain: &Domain,
        largest: f64,
    ) -> Result<(), Diagnostic> {
        let at = vector(center);
        for axis in 0..3 {
            let (low, high) = (at[axis] - extents[axis], at[axis] + extents[axis]);
            let room = largest;
            if domain.periodic[axis] && (low < room || high > domain.size[axis] - room) {
                let name = ["x", "y", "z"][axis];
                let why = format!(
                    "puts the body at {name} = {low:.4e} ..= {high:.4e} m, too near a periodic side; allowed: {room:.4e} ..= {:.4e} m",
                    domain.size[axis] - room
                );
                return Err(self
                    .refuse(center, why)
                    .help("a body stays one particle diameter away from periodic sides"));
            }
            if high <= 0.0 || low >= domain.size[axis] {
                return Err(self.refuse(center, "puts the body outside the domain").help("see `domain.size`"));
            }
        }
        Ok(())
    }
}

/// "did you mean" for a length that is no particle or channel size.
pub(super) fn unit_slip(length: f64) -> String {
    if length > 1.0 {
        let number = short(length);
        format!("a plain number is in metres: did you mean \"{number} um\" or \"{number} mm\"?")
    } else {
        "a plain number is in metres".to_string()
    }
}
