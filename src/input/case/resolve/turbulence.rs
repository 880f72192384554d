//! Reads and checks the turbulence that particles see.

use super::Resolver;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, LangevinFile, SeenTurbulenceFile};
use crate::case::located::Located;
use crate::experiment::Experiment;
use crate::fluid::{EddyLaw, Langevin, Profile, Turbulence, TurbulenceStatistics};
use crate::schedule::longest_for_eddies;

impl Resolver {
    /// Turbulence that particles see in a gas with this velocity profile; `None` if the case has none. `nu` [m²/s] is
    /// the kinematic viscosity. `table` contains rows of y [m], turbulent kinetic energy k [m²/s²] and its dissipation
    /// rate ε [m²/s³], if the profile is a table with these columns.
    pub(super) fn turbulence(
        &mut self,
        file: &CaseFile,
        profile: &Profile,
        table: &[[f64; 3]],
        nu: f64,
    ) -> Result<Option<Turbulence>, Diagnostic> {
        let Some(typed) = file.fluid.as_ref().and_then(|fluid| fluid.value.turbulence.as_ref()) else {
            return Ok(None);
        };
        let (law, constants) = match &typed.value.eddy {
            Some(eddy) => (EddyLaw::Eddy, eddy),
            None => (EddyLaw::Langevin, self.need(&typed.value.langevin, "fluid.turbulence.langevin")?),
        };
        let langevin = self.langevin(&constants.value)?;
        let statistics = self.statistics_of_turbulence(typed, profile, table, nu)?;
        if file.drag.is_none() {
            let message = "`fluid.turbulence` does nothing: the gas exerts no drag";
            self.warn(&typed.origin, message, "add [drag.schiller_naumann], or leave [fluid.turbulence] out");
        }
        Ok(Some(Turbulence { statistics, law, langevin }))
    }

    /// Warns if the window that the case gives is longer than [`longest_for_eddies`] allows for the turbulence that
    /// particles see. A window is the time between two exchanges with the gas.
    pub(super) fn check_eddies(&mut self, file: &CaseFile, experiment: &Experiment) {
        let Some(typed) = file.run.as_ref().and_then(|run| run.value.window.as_ref()) else { return };
        let Some(window) = experiment.run.window else { return };
        let longest = longest_for_eddies(experiment);
        if window > longest {
            let message = format!(
                "the window of {window:.2e} s is longer than the {longest:.2e} s in which particles may move through \
                 turbulence of uneven strength; they would gather in some places by the error"
            );
            self.warn(&typed.origin, message, "use a shorter window, or leave `run.window` out");
        }
    }

    fn langevin(&self, typed: &LangevinFile) -> Result<Langevin, Diagnostic> {
        let mut langevin = Langevin::default();
        if let Some(constant) = &typed.kolmogorov_constant {
            // the values in use are from flows of different Reynolds numbers: Pope 1994, Annu. Rev. Fluid Mech. 26, 23
            langevin.kolmogorov_constant = self.in_range(constant, "values from 2 to 7 are in use")?;
        }
        if let Some(ratio) = &typed.time_scale_ratio {
            langevin.time_scale_ratio = self.in_range(ratio, "0 leaves the crossing of trajectories out")?;
        }
        Ok(langevin)
    }

    fn statistics_of_turbulence(
        &self,
        typed: &Located<SeenTurbulenceFile>,
        profile: &Profile,
        table: &[[f64; 3]],
        nu: f64,
    ) -> Result<TurbulenceStatistics, Diagnostic> {
        let SeenTurbulenceFile { kinetic_energy, dissipation_rate, .. } = &typed.value;
        let refuse = |message: &str, help: &str| Err(self.sources.error(&typed.origin, message).help(help));
        if let Profile::Uniform(_) = profile {
            let (Some(k), Some(epsilon)) = (kinetic_energy, dissipation_rate) else {
                let message = "`fluid.turbulence` needs `kinetic_energy` and `dissipation_rate`, because a uniform gas \
                               has neither k nor ε";
                return refuse(message, "add both; eddies of size L have about ε = k^(3/2)/L");
            };
            let help = "both must be greater than 0; without turbulence leave [fluid.turbulence] out";
            return Ok(TurbulenceStatistics::uniform(self.in_range(k, help)?, self.in_range(epsilon, help)?, nu));
        }
        let why = "is for a uniform gas; the profile of this case gives k and ε by itself";
        let help = "leave `kinetic_energy` and `dissipation_rate` out";
        if let Some(k) = kinetic_energy {
            return Err(self.refuse(k, why).help(help));
        }
        if let Some(epsilon) = dissipation_rate {
            return Err(self.refuse(epsilon, why).help(help));
        }
        let statistics = match profile {
            Profile::LogLaw(_) | Profile::Uniform(_) => {
                return refuse(
                    "`fluid.turbulence` needs k and ε, which the logarithmic law does not give",
                    "use fluid.profile.k_epsilon_channel, or a table with the columns k_m2_s2 and epsilon_m2_s3",
                );
            }
            Profile::Tabulated(_) if table.is_empty() => {
                return refuse(
                    "`fluid.turbulence` needs k and ε, which the file of `fluid.profile.table` does not contain",
                    "add the columns k_m2_s2 and epsilon_m2_s3 to the file",
                );
            }
            Profile::Tabulated(_) => TurbulenceStatistics::table(table, nu),
            Profile::Channel(_) | Profile::Pipe(_) => match profile.channel_flow() {
                Some(flow) => TurbulenceStatistics::of(flow),
                None => Err("the profile has no solution".into()),
            },
        };
        statistics.map_err(|why| self.sources.error(&typed.origin, format!("`fluid.turbulence`: {why}")))
    }
}
