//! Reads and checks the domain, the gas, the gravity and the surfaces of a scene.

use super::{Resolver, short, vector};
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, DragFile, FluidFile, ProfileFile, TurbulenceFile};
use crate::case::located::Located;
use crate::case::quantity::Ratio;
use crate::domain::Domain;
use crate::drag::{Drag, SchillerNaumann, Stokes, SuspensionDrag, SuspensionLaw};
use crate::fluid::TurbulenceModel;
use crate::fluid::{Fluid, Lift, Profile};
use crate::scene::{ADDED_MASS, Scene, Species};
use nalgebra::Vector3;

/// [-] largest ratio of the buoyancy to the weight, or of the added mass to the mass, at which the case may leave the
/// force out without a warning. The value equals the default margin (largest accepted difference) of comparisons.
const SMALL: f64 = 0.01;

impl Resolver {
    /// Box of the case, with its periodic axes and its shear.
    pub(super) fn domain(&mut self, file: &CaseFile) -> Result<Domain, Diagnostic> {
        let domain = self.need(&file.domain, "domain")?;
        let size = self.need(&domain.value.size, "domain.size")?;
        for edge in &size.value {
            let length = edge.value.0;
            let help = if length > 0.0 { unit_slip(length) } else { "an edge of the box has a positive length".into() };
            self.in_range(edge, help)?;
        }
        let mut periodic = [false; 3];
        for axis in domain.value.periodic.iter().flatten() {
            let index = axis.value.index();
            if periodic[index] {
                return Err(self.refuse(axis, "names an axis twice").help("each axis once: [\"x\", \"z\"]"));
            }
            periodic[index] = true;
        }
        self.sheared(Domain::new(vector(size), periodic), domain)
    }

    /// [m/s²] acceleration by gravity; zero if the case gives none.
    ///
    /// # Errors
    /// An acceleration that is out of range.
    pub(super) fn gravity(&mut self, file: &CaseFile) -> Result<Vector3<f64>, Diagnostic> {
        let Some(acceleration) = file.gravity.as_ref().and_then(|gravity| gravity.value.acceleration.as_ref()) else {
            return Ok(Vector3::zeros());
        };
        for component in &acceleration.value {
            let help = "the earth's is 9.81 m/s^2, that of the fastest centrifuges 1e7 m/s^2";
            self.in_range(component, help)?;
        }
        let gravity = vector(acceleration);
        if gravity.norm() > 1000.0 {
            let message = format!("`gravity.acceleration` is {:.3e} m/s^2", gravity.norm());
            self.warn(&acceleration.origin, message, "the earth's is 9.81 m/s^2");
        }
        Ok(gravity)
    }

    /// Lift of the gas on the particles; `None` if the case gives no lift.
    ///
    /// # Errors
    /// Lift by spin of spheres that do not rotate.
    fn lift(&self, fluid: &Located<FluidFile>, file: &CaseFile) -> Result<Option<Lift>, Diagnostic> {
        let Some(lift) = &fluid.value.lift else { return Ok(None) };
        let is_on = |key: &Option<Located<bool>>| key.as_ref().is_some_and(|key| key.value);
        let (shear, spin) = (is_on(&lift.value.shear), is_on(&lift.value.spin));
        if let Some(key) = lift.value.spin.as_ref().filter(|_| spin && !Self::rotates(file)) {
            let help = "add `rotation = true` to [contact], or a tangential law";
            return Err(self.refuse(key, "needs spheres that rotate").help(help));
        }
        Ok((shear || spin).then_some(Lift { shear, spin }))
    }

    /// Adds the added mass to the species of the scene, if the case requests it. If the case does not mention it, a
    /// warning is given for species whose added mass exceeds 1 % of their mass.
    ///
    /// # Errors
    /// Added mass without buoyancy, since both are forces of the displaced gas.
    pub(super) fn added_mass(&mut self, file: &CaseFile, scene: &mut Scene) -> Result<(), Diagnostic> {
        let Some(typed) = &file.fluid else { return Ok(()) };
        let of = |key: &Option<Located<bool>>| key.as_ref().map(|key| key.value);
        let (added, floats) = (of(&typed.value.added_mass), of(&typed.value.buoyancy).unwrap_or(true));
        if let Some(key) = typed.value.added_mass.as_ref().filter(|key| key.value && !floats) {
            let help = "leave out `fluid.buoyancy`, which is true by default";
            return Err(self.refuse(key, "needs buoyancy: both are forces of the displaced gas").help(help));
        }
        if added == Some(true) {
            scene.add_added_mass();
            return Ok(());
        }
        let Some(fluid) = scene.fluid.as_ref().filter(|_| added.is_none() && floats) else { return Ok(()) };
        for species in &scene.species {
            let share = ADDED_MASS * fluid.density / species.density;
            if share > SMALL {
                let percent = 100.0 * share;
                let message = format!(
                    "added mass is left out: in this fluid it is {percent:.1} % of the mass of \"{}\"",
                    species.name
                );
                self.warn(
                    &typed.origin,
                    message,
                    "add `added_mass = true` to [fluid]; `false` leaves it out in silence",
                );
            }
        }
        Ok(())
    }

    /// Adds buoyancy to the scene, unless the case leaves it out. If the case does so, a warning is given for species
    /// whose buoyancy exceeds 1 % of their weight.
    pub(super) fn buoyancy(&mut self, file: &CaseFile, scene: &mut Scene) {
        let Some(typed) = file.fluid.as_ref().and_then(|fluid| fluid.value.buoyancy.as_ref()).filter(|on| !on.value)
        else {
            return scene.add_buoyancy();
        };
        let Some(fluid) = scene.fluid.as_ref().filter(|_| scene.gravity != Vector3::zeros()) else { return };
        for species in &scene.species {
            let lifted = fluid.density / species.density;
            if lifted > SMALL {
                let (name, left) = (&species.name, 1.0 - lifted);
                let message = format!(
                    "buoyancy is left out: in this fluid \"{name}\" has {left:.3} of its weight, and here it has all of it"
                );
                self.warn(&typed.origin, message, "leave out `fluid.buoyancy`, which is true by default");
            }
        }
    }

    /// [-] coefficient of friction; 0 if the case gives none.
    pub(super) fn friction(&self, friction: &Option<Located<Ratio>>) -> Result<f64, Diagnostic> {
        let Some(friction) = friction else { return Ok(0.0) };
        let help = "friction opposes sliding; 0 is smooth";
        self.in_range(friction, help)
    }

    /// Gas with its velocity profile and drag law; `None` if the case has no gas.
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
        let rho = self.in_range(density, "did you mean \"1.2 kg/m^3\" (air)?")?;
        let viscosity = self.need(&fluid.value.kinematic_viscosity, "fluid.kinematic_viscosity")?;
        // a large number was probably meant in mm²/s or in stokes (St, cm²/s)
        let unit = if viscosity.value.0 > 1.0 { "mm^2/s" } else { "cm^2/s" };
        let slip =
            format!("did you mean \"{} {unit}\"? air has 1.5e-5 m^2/s, water 1e-6 m^2/s", short(viscosity.value.0));
        let nu = self.in_range(viscosity, slip)?;
        let (profile, table) = self.profile(fluid, domain, nu, species)?;
        let turbulence = self.turbulence(file, &profile, &table, nu)?;
        let lift = self.lift(fluid, file)?;
        let coupling = self.coupling(file, &fluid.value, &profile)?;
        let drag = match &file.drag {
            Some(drag) => Some(self.drag(&drag.value, domain, species)?),
            None => {
                self.warn(
                    &fluid.origin,
                    "the gas exerts no drag: the case has no drag law",
                    "add [drag.schiller_naumann]",
                );
                None
            }
        };
        Ok(Some(Fluid { turbulence, lift, coupling, ..Fluid::new(rho, nu, profile, drag) }))
    }

    fn drag(&self, drag: &DragFile, domain: &Domain, species: &[Species]) -> Result<Drag, Diagnostic> {
        let (law, cells) = match drag {
            DragFile::SchillerNaumann {} => return Ok(Drag::SchillerNaumann(SchillerNaumann)),
            DragFile::Stokes {} => return Ok(Drag::Stokes(Stokes)),
            DragFile::WenYu { cells } => (SuspensionLaw::WenYu, cells),
            DragFile::Gidaspow { cells } => (SuspensionLaw::Gidaspow, cells),
            DragFile::Beetstra { cells } => (SuspensionLaw::Beetstra, cells),
            DragFile::Tenneti { cells } => (SuspensionLaw::Tenneti, cells),
            DragFile::DiFelice { cells } => (SuspensionLaw::DiFelice, cells),
        };
        let cells = self.need(cells, "drag.*.cells")?;
        let help =
            "in a channel, slices such as [1, 20, 1]; the more particles a cell holds, the less their number scatters";
        Ok(Drag::Suspension(SuspensionDrag { law, cells: self.cells(cells, domain, species, help)? }))
    }

    /// Numbers of cells along x, y and z. No cell may be narrower than the largest particle. The error message contains
    /// `help`, a recommendation.
    pub(super) fn cells(
        &self,
        typed: &Located<[Located<i64>; 3]>,
        domain: &Domain,
        species: &[Species],
        help: &str,
    ) -> Result<[u32; 3], Diagnostic> {
        let largest = species.iter().map(Species::largest).fold(0.0, f64::max);
        let mut cells = [1; 3];
        for (axis, (count, typed)) in cells.iter_mut().zip(&typed.value).enumerate() {
            *count = self.whole(typed, 1, 10_000, help)? as u32;
            let most = (domain.size[axis] / largest).floor().max(1.0);
            if f64::from(*count) > most {
                let why = format!("makes cells narrower than the largest particle; allowed: 1 ..= {most}");
                return Err(self.refuse(typed, why).help(help));
            }
        }
        Ok(cells)
    }

    /// Velocity profile of the gas. If the profile is a table with turbulence, also returns the rows of the table: y
    /// [m], turbulent kinetic energy k [m²/s²] and its dissipation rate ε [m²/s³]. Otherwise the list is empty.
    fn profile(
        &mut self,
        fluid: &Located<FluidFile>,
        domain: &Domain,
        nu: f64,
        species: &[Species],
    ) -> Result<(Profile, Vec<[f64; 3]>), Diagnostic> {
        let profile = self.need(&fluid.value.profile, "fluid.profile")?;
        let mut turbulence = Vec::new();
        let profile = match &profile.value {
            ProfileFile::Uniform { velocity } => {
                let velocity = self.need(velocity, "fluid.profile.uniform.velocity")?;
                Ok(Profile::Uniform(self.in_range(velocity, "a gas velocity along z")?))
            }
            ProfileFile::Table { file } => {
                let name = self.need(file, "fluid.profile.table.file")?;
                let (points, columns) = self.profile_table(name)?;
                turbulence = columns;
                let smallest = species.iter().map(|kind| 0.5 * kind.smallest()).fold(f64::INFINITY, f64::min);
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
            ProfileFile::KEpsilonPipe { reynolds_number, diameter, center } => {
                let number = self.need(reynolds_number, "fluid.profile.k_epsilon_pipe.reynolds_number")?;
                self.pipe(number, diameter.as_ref(), center.as_ref(), (domain, nu))
            }
            ProfileFile::LogLaw { friction_velocity, reynolds_number, von_karman, intercept } => {
                let constants = self.log_constants(von_karman.as_ref(), intercept.as_ref())?;
                self.log_law((friction_velocity.as_ref(), reynolds_number.as_ref()), constants, domain, nu)
                    .map(Profile::LogLaw)
            }
        };
        Ok((profile?, turbulence))
    }
}

/// Remedy for a length [m] out of range, which was probably meant in µm or mm.
pub(super) fn unit_slip(length: f64) -> String {
    if length > 1.0 {
        let number = short(length);
        format!("a plain number is in metres: did you mean \"{number} um\" or \"{number} mm\"?")
    } else {
        "a plain number is in metres".to_string()
    }
}
