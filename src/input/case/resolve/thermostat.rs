//! Reads and checks a thermostat. A window is the time between two kicks (changes of the velocities by drag or by the
//! thermostat).

use super::Resolver;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, ThermostatFile};
use crate::experiment::{Amount, Experiment};
use crate::scene::Thermostat;
use crate::schedule::longest_for_thermostat;

impl Resolver {
    /// Thermostat that the case gives; `None` if the particles are not heated.
    ///
    /// # Errors
    /// A rate out of range.
    pub(super) fn thermostat(&self, file: &CaseFile) -> Result<Option<Thermostat>, Diagnostic> {
        let help = "without heating leave [thermostat] out";
        let Some(typed) = &file.thermostat else { return Ok(None) };
        Ok(Some(match &typed.value {
            ThermostatFile::Stochastic { heating } => {
                let heating = self.need(heating, "thermostat.stochastic.heating")?;
                Thermostat::Stochastic { heating: self.in_range(heating, help)? }
            }
            ThermostatFile::Gaussian { rate } => {
                let rate = self.need(rate, "thermostat.gaussian.rate")?;
                Thermostat::Gaussian { rate: self.in_range(rate, help)? }
            }
        }))
    }

    /// Warns if nothing takes the heat of a thermostat away, or if a Gaussian thermostat, which enlarges differences
    /// of velocity, finds none at the start. Also warns if the window that the case gives (time between two kicks) is
    /// too long for the thermostat.
    pub(super) fn check_thermostat(&mut self, file: &CaseFile, experiment: &Experiment) {
        let Some(typed) = &file.thermostat else { return };
        let scene = &experiment.scene;
        let surfaces = scene.surfaces(experiment.most_that_touch(experiment.count()));
        let lossy = surfaces.iter().any(|surface| surface.restitution < 1.0 || surface.friction > 0.0);
        let dragged = scene.fluid.as_ref().is_some_and(|fluid| fluid.drag.is_some());
        if !lossy && !dragged {
            let message =
                "nothing takes away the heat of the thermostat: all impacts are elastic, and there is no drag";
            self.warn(&typed.origin, message, "give `contact` a restitution below 1, or leave [thermostat] out");
        }
        let first = experiment.start.first().map(|population| population.velocity_mean);
        let alike = experiment.start.iter().all(|population| {
            matches!(population.amount, Amount::Count(_))
                && population.mean_fluctuation() == 0.0
                && Some(population.velocity_mean) == first
        });
        if matches!(scene.thermostat, Some(Thermostat::Gaussian { .. })) && alike {
            let message = "the thermostat heats nothing: it lets differences of velocity grow, and the start has none";
            let help = "give the particles a `velocity_fluctuation`, or use [thermostat.stochastic]";
            self.warn(&typed.origin, message, help);
        }
        let Some(window) = file.run.as_ref().and_then(|run| run.value.window.as_ref()) else { return };
        let longest = longest_for_thermostat(experiment);
        if experiment.run.window.is_some_and(|window| window > longest) {
            let message = format!(
                "the window is longer than {longest:.2e} s, in which a particle collides once in 20 windows; the \
                 thermostat acts at the ends of windows, so collisions see too little of it"
            );
            self.warn(&window.origin, message, "use a shorter window, or leave `run.window` out");
        }
    }
}
