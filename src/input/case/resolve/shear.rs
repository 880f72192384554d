//! Reads and checks the shear of a box.

use super::Resolver;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, DomainFile, OrbitFile, ShearFile};
use crate::case::located::Located;
use crate::domain::{Domain, Orbit};
use crate::scene::Scene;
use nalgebra::Vector3;

/// [-] smallest edge of a sheared box, divided by the largest diameter. In a smaller box, an event-driven particle
/// could collide with two periodic images of another particle.
const SMALLEST_EDGE: f64 = 4.0;

impl Resolver {
    /// Adds the shear that the case gives to the box. A box without shear is returned unchanged.
    ///
    /// # Errors
    /// A rate of zero or out of range, an orbit with unstable motion, or a box that is not periodic along all axes.
    pub(super) fn sheared(&self, domain: Domain, file: &Located<DomainFile>) -> Result<Domain, Diagnostic> {
        let Some(shear) = &file.value.shear else { return Ok(domain) };
        let typed = self.need(&shear.value.rate, "domain.shear.rate")?;
        let rate = self.in_range(typed, "a rate such as \"20 1/s\"")?;
        if rate == 0.0 {
            return Err(self.refuse(typed, "shears nothing").help("leave [domain.shear] out for a box at rest"));
        }
        let offset = match &shear.value.offset {
            Some(offset) => self.in_range(offset, "a length, at most a period")?,
            None => 0.0,
        };
        let orbit = shear.value.orbit.as_ref().map(|orbit| self.orbit(orbit, rate)).transpose()?;
        if domain.periodic != [true; 3] {
            let help = "write `periodic = [\"x\", \"y\", \"z\"]` in [domain]";
            return Err(self.refuse_shear(shear, "needs a box that is periodic along all axes").help(help));
        }
        let sheared = domain.sheared(rate, offset);
        Ok(match orbit {
            Some(orbit) => sheared.on_orbit(orbit),
            None => sheared,
        })
    }

    /// Reads the orbit of a box with the shear rate `shear` [1/s].
    ///
    /// # Errors
    /// A rate of zero or out of range, or an orbit on which free motion is unstable.
    fn orbit(&self, file: &Located<OrbitFile>, shear: f64) -> Result<Orbit, Diagnostic> {
        let typed = self.need(&file.value.rate, "domain.shear.orbit.rate")?;
        let rate = self.in_range(typed, "a rate such as \"1.3e-4 1/s\"")?;
        if rate == 0.0 {
            return Err(self.refuse(typed, "is no orbit").help("leave [domain.shear.orbit] out for a frame at rest"));
        }
        let vertical_frequency = match &file.value.vertical_frequency {
            Some(frequency) => self.in_range(frequency, "a frequency, or 0 for none")?,
            None => rate.abs(),
        };
        let orbit = Orbit { rate, vertical_frequency };
        if orbit.square_of_epicyclic_frequency(shear) <= 0.0 {
            let help = format!("around a point mass, domain.shear.rate is -3/2 of this: {:.6e} 1/s", -1.5 * rate);
            let unstable = "makes free motion unstable: 2 rate (2 rate + domain.shear.rate) must be above 0";
            return Err(self.refuse(typed, unstable).help(help));
        }
        Ok(orbit)
    }

    /// Refuses a sheared scene that has parts which cannot be sheared.
    ///
    /// # Errors
    /// Walls, a gas, gravity, or a box with an edge of less than four of the largest diameters.
    pub(super) fn check_shear(&self, file: &CaseFile, scene: &Scene) -> Result<(), Diagnostic> {
        let Some(shear) = file.domain.as_ref().and_then(|domain| domain.value.shear.as_ref()) else { return Ok(()) };
        let no = |what: &str, help: &str| Err(self.refuse_shear(shear, what).help(help));
        if !scene.walls.is_empty() {
            let help = "leave the walls out, or shear between two of them: `cases/walls/sheared-cell.toml`";
            return no("cannot have walls: the images of a wall would slide", help);
        }
        if scene.fluid.is_some() {
            let help = "leave [fluid] and [drag] out";
            return no("cannot have a gas: no profile of the gas has this mean flow", help);
        }
        if scene.gravity != Vector3::zeros() {
            let help = "leave [gravity] out";
            return no("cannot have gravity: nothing holds the particles against it", help);
        }
        let (edge, diameter) = (scene.domain.size.min(), scene.largest_diameter());
        if edge < SMALLEST_EDGE * diameter {
            let help = format!("make every edge of the box at least {:.4e} m", SMALLEST_EDGE * diameter);
            return no("needs a box of at least 4 largest diameters along each axis", &help);
        }
        Ok(())
    }

    fn refuse_shear(&self, shear: &Located<ShearFile>, what: &str) -> Diagnostic {
        self.sources.error(&shear.origin, format!("a sheared box {what}"))
    }
}
