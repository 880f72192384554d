//! Reads and checks the two-way coupling between gas and particles: each changes the motion of the other. A window is
//! the time between two exchanges of momentum between them.

use super::Resolver;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, FluidFile, ModulationFile};
use crate::experiment::Experiment;
use crate::fluid::{Coupling, HeldFlow, Modulation, Profile};
use crate::schedule::longest_for_coupling;
use nalgebra::Vector3;

impl Resolver {
    /// Two-way coupling between particles and a gas with the velocity profile `profile`; `None` if the case requests
    /// one-way coupling.
    ///
    /// # Errors
    /// A gas without drag, or a profile without a solution of the k-ε model.
    pub(super) fn coupling(
        &self,
        file: &CaseFile,
        fluid: &FluidFile,
        profile: &Profile,
    ) -> Result<Option<Coupling>, Diagnostic> {
        let Some(typed) = &fluid.coupling else { return Ok(None) };
        let slices = match &typed.value.slices {
            Some(slices) => self.whole(slices, 1, 1000, "a slice should hold some hundred particles")?,
            None => 20,
        };
        let held = match &typed.value.pressure_gradient {
            Some(gradient) => {
                let help = "the weight of the particles per volume is carried by the pressure gradient too";
                HeldFlow::PressureGradient(self.in_range(gradient, help)?)
            }
            None => HeldFlow::FlowRate,
        };
        let refuse = |message: &str, help: &str| Err(self.sources.error(&typed.origin, message).help(help));
        if profile.channel_flow().is_none() {
            return refuse(
                "`fluid.coupling` needs a gas flow that is computed, because its momentum equation is solved anew",
                "use fluid.profile.k_epsilon_channel or fluid.profile.k_epsilon_pipe",
            );
        }
        if file.drag.is_none() {
            return refuse(
                "`fluid.coupling` needs drag, by which particles act on the gas",
                "add [drag.schiller_naumann]",
            );
        }
        let modulation = match typed.value.modulation.as_ref().map_or(ModulationFile::Simonin, |typed| typed.value) {
            ModulationFile::None => Modulation::None,
            ModulationFile::Simonin => Modulation::Simonin,
            ModulationFile::Crowe => Modulation::Crowe,
        };
        Ok(Some(Coupling { slices, held, modulation }))
    }

    /// Checks that gravity is along the gas flow, because the gas is computed as symmetric about its axis. Warns if the
    /// window (time between two exchanges of momentum with the gas) is too long for the coupling.
    ///
    /// # Errors
    /// Gravity is not along the flow of a gas that the particles change.
    pub(super) fn check_coupling(&mut self, file: &CaseFile, experiment: &Experiment) -> Result<(), Diagnostic> {
        let Some(fluid) = &file.fluid else { return Ok(()) };
        let Some(typed) = &fluid.value.coupling else { return Ok(()) };
        let gravity = experiment.scene.gravity;
        if gravity != Vector3::new(0.0, 0.0, gravity.z) {
            let message =
                "`fluid.coupling` needs gravity along z or none: the gas is computed as symmetric about its axis";
            return Err(self.sources.error(&typed.origin, message).help("leave [fluid.coupling] out"));
        }
        let Some(window) = file.run.as_ref().and_then(|run| run.value.window.as_ref()) else { return Ok(()) };
        let longest = longest_for_coupling(experiment);
        if experiment.run.window.is_some_and(|window| window > longest) {
            let message = format!(
                "the window is longer than {longest:.2e} s, in which the particles take a tenth of the slip from the gas; \
                 the exchange of momentum becomes inaccurate, and unstable at 20 times this window"
            );
            self.warn(&window.origin, message, "use a shorter window, or leave `run.window` out");
        }
        Ok(())
    }
}
