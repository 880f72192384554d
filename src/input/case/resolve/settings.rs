//! Reads and checks the settings of the engines, of the run and of the statistics.

use super::{Resolver, VariantChoice};
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, DsmcFile, ElasticityFile, HardFile, HardSteppingFile, SoftFile};
use crate::case::located::Located;
use crate::case::time_or_word::{AverageFromFile, WindowFile};
use crate::contact_law::{ContactLaw, Hertz, KuwabaraKono};
use crate::experiment::{
    AverageFrom, DsmcSettings, Experiment, HardSettings, HardStepping, HybridSettings, Integrator, Model, Population,
    RunSettings, SoftSettings, Spheres, StatisticsSettings, TimeStep,
};
use crate::predict::contact::ContactTimes;
use crate::predict::energy::too_long;
use crate::scene::{Elasticity, Scene};
use crate::simulation::soft_step;

/// [-] smallest number of time steps per contact N_c that resolves a contact. Fewer steps are refused, unless the case
/// allows them.
const FEWEST_STEPS: f64 = 5.0;
/// [-] number of steps per contact N_c below which a warning is given. Section 3.4 of the paper (see `docs/paper.md`)
/// has steps from T_c/50 to T_c/15, where T_c is the duration of a contact.
const GOOD_STEPS: f64 = 15.0;
/// [N/m] allowed range of spring stiffness, which includes all real bodies: a bubble has 0.1, a diamond sphere of 1 mm
/// has 1e9. Outside the range, squares of times or frequencies would exceed the range of floating-point numbers.
pub(super) const SPRINGS: std::ops::RangeInclusive<f64> = 1e-9..=1e20;

impl Resolver {
    /// Settings of the soft engine. If the model has no lasting contacts, these settings are not used, and an error in
    /// them becomes a warning.
    pub(super) fn soft(&mut self, file: &CaseFile) -> Result<SoftSettings, Diagnostic> {
        match self.soft_settings(file) {
            Err(error) if !self.model.has_contacts() => {
                let help = format!("not used by the {} model; correct it for the soft one", self.model.name());
                self.warnings.push(error.into_warning().help(help));
                Ok(SoftSettings::default())
            }
            result => result,
        }
    }

    fn soft_settings(&mut self, file: &CaseFile) -> Result<SoftSettings, Diagnostic> {
        let mut settings = SoftSettings::default();
        let Some(soft) = file.soft.as_ref().map(|soft| &soft.value) else { return Ok(settings) };
        settings.law = self.contact_law(soft)?;
        if let Some(steps) = &soft.steps_per_contact {
            let help = "N_c, time steps in the shortest contact; 20 is a good start";
            let n = self.in_range(steps, help)?;
            settings.time_step = TimeStep::PerContact(n);
        }
        if let Some(step) = &soft.time_step {
            let help = "or give `steps_per_contact = 20` instead, which finds the step";
            settings.time_step = TimeStep::Fixed(self.in_range(step, help)?);
        }
        if let Some(stepping) = &soft.stepping {
            settings.stepping = stepping.value;
        }
        if let Some(integrator) = &soft.integrator {
            settings.integrator = integrator.value;
        }
        settings.allow_unstable = soft.allow_unstable.as_ref().is_some_and(|allow| allow.value);
        Ok(settings)
    }

    /// Contact law that a case gives; `None` if it gives no law.
    fn contact_law(&mut self, soft: &SoftFile) -> Result<Option<ContactLaw>, Diagnostic> {
        let spring = soft.linear_spring_dashpot.as_ref();
        if let Some(hertz) = &soft.hertz {
            return Ok(Some(ContactLaw::Hertz(Hertz { elasticity: self.elasticity(hertz)? })));
        }
        if let Some(kuwabara_kono) = &soft.kuwabara_kono {
            return Ok(Some(ContactLaw::KuwabaraKono(KuwabaraKono { elasticity: self.elasticity(kuwabara_kono)? })));
        }
        let Some(stiffness) = spring.and_then(|law| law.value.stiffness.as_ref()) else { return Ok(None) };
        let help = "the paper uses 3000 N/m and 5000 N/m";
        Ok(Some(ContactLaw::linear(self.in_range(stiffness, help)?)))
    }

    /// Young's modulus and Poisson's ratio from a table of the case.
    fn elasticity(&self, typed: &Located<ElasticityFile>) -> Result<Elasticity, Diagnostic> {
        /// [-] Poisson's ratio of most metals, glasses and plastics: a round textbook value (Johnson 1985).
        const USUAL: f64 = 0.3;
        let modulus = self.need(&typed.value.youngs_modulus, "youngs_modulus")?;
        let help = "70 GPa is glass, 3 GPa polystyrene; softer bodies are often computed, and then a plan says how soft they may be";
        let youngs_modulus = self.in_range(modulus, help)?;
        let poissons_ratio = match &typed.value.poissons_ratio {
            Some(ratio) => {
                let help = "0.5 is rubber, 0.2 glass, 0.3 most others";
                self.in_range(ratio, help)?
            }
            None => USUAL,
        };
        Ok(Elasticity { youngs_modulus, poissons_ratio })
    }

    /// Elasticity of one species or one wall; `None` if the case gives none for it.
    pub(super) fn own_elasticity(
        &mut self,
        file: &CaseFile,
        typed: &Option<Located<ElasticityFile>>,
    ) -> Result<Option<Elasticity>, Diagnostic> {
        let Some(typed) = typed else { return Ok(None) };
        let is_elastic = |soft: &SoftFile| soft.hertz.is_some() || soft.kuwabara_kono.is_some();
        if !file.soft.as_ref().is_some_and(|soft| is_elastic(&soft.value)) {
            let message = format!(
                "`{}` is not used: only `soft.hertz` and `soft.kuwabara_kono` derive their stiffness from materials",
                typed.path
            );
            self.warn(&typed.origin, message, "add [soft.hertz], or leave it out");
        }
        self.elasticity(typed).map(Some)
    }

    /// Refuses a time step that does not resolve the shortest contact, unless the case allows it. Warns about an
    /// allowed step, and about a step that barely resolves the contact.
    pub(super) fn check_step(&mut self, file: &CaseFile, experiment: &Experiment) -> Result<(), Diagnostic> {
        let (Some(law), Some(soft)) = (experiment.law(), file.soft.as_ref().map(|soft| &soft.value)) else {
            return Ok(());
        };
        let typed = soft.time_step.as_ref().map(|step| &step.origin);
        let Some(origin) = typed.or(soft.steps_per_contact.as_ref().map(|steps| &steps.origin)) else { return Ok(()) };
        let allowed = experiment.soft.allow_unstable || soft.allow_large_step.as_ref().is_some_and(|allow| allow.value);
        let times = ContactTimes::of(experiment, &law, experiment.most_that_touch(experiment.count()));
        let Some(shortest) = times.governing() else { return Ok(()) };
        let step = soft_step(experiment, experiment.most_that_touch(experiment.count()));
        let steps = shortest / step;
        // a number exactly at the limit must not be refused because of rounding
        if steps >= GOOD_STEPS * (1.0 - 1e-9) {
            return Ok(());
        }
        let describe = |name: &str, time: Option<f64>| {
            time.map(|time| format!("{name} contact {time:.4e} s, N_c = {:.2}", time / step))
        };
        let both: Vec<String> =
            [describe("pair", times.pair), describe("wall", times.wall)].into_iter().flatten().collect();
        let message = format!("time step {step:.4e} s: {}", both.join("; "));
        if steps < FEWEST_STEPS * (1.0 - 1e-9) && !allowed {
            let message = format!("{message}; allowed: time steps up to {:.4e} s (N_c >= 5)", shortest / FEWEST_STEPS);
            let help = "use `soft.steps_per_contact = 20`; to run it all the same, set `soft.allow_large_step = true`";
            return Err(self.sources.error(origin, message).help(help));
        }
        self.warn(
            origin,
            format!("{message}; a contact is well resolved from N_c = 15 on"),
            "use `soft.steps_per_contact = 20`",
        );
        Ok(())
    }

    /// Refuses a time step beyond the stability limit of its integrator. If the case allows such a step, or if the
    /// integrator is unstable at any step, a warning is given instead.
    pub(super) fn check_stability(&mut self, file: &CaseFile, experiment: &Experiment) -> Result<(), Diagnostic> {
        let Some(soft) = file.soft.as_ref().filter(|_| self.model.has_contacts()) else { return Ok(()) };
        let particles = experiment.most_that_touch(experiment.count());
        let step = soft_step(experiment, particles);
        let value = &soft.value;
        let typed =
            [value.time_step.as_ref().map(|step| &step.origin), value.steps_per_contact.as_ref().map(|n| &n.origin)];
        let origin = typed.into_iter().flatten().next().unwrap_or(&soft.origin);
        let Some(failure) = too_long(experiment, particles, step) else { return Ok(()) };
        if experiment.soft.allow_unstable || experiment.soft.integrator == Integrator::Rk2 {
            self.warn(
                origin,
                failure.to_string(),
                "contacts that last swing ever wider; `velocity_verlet` is stable at 20 steps per contact",
            );
            return Ok(());
        }
        let help = "to run it all the same, set `soft.allow_unstable = true`";
        Err(self.sources.error(origin, failure.to_string()).help(help))
    }

    pub(super) fn hard(&mut self, file: &CaseFile) -> Result<HardSettings, Diagnostic> {
        let events = HardSettings::default();
        let Some(hard) = file.hard.as_ref().map(|hard| &hard.value) else { return Ok(events) };
        let stepping = hard.stepping.as_ref().map_or(HardSteppingFile::Events, |stepping| stepping.value);
        let mut theta = 0.3;
        if let Some(typed) = &hard.theta {
            let help = "the stepped hard engine uses Δt < θ d/u_r (the paper's section 3.4); the paper takes 0.3";
            match self.in_range(typed, help) {
                Ok(number) => theta = number,
                Err(error) if self.model != Model::Hard => self.warnings.push(error.into_warning()),
                Err(error) => return Err(error),
            }
            if stepping == HardSteppingFile::Events {
                self.warn(
                    &typed.origin,
                    "`hard.theta` is not used by events",
                    "add `stepping = \"steps\"`, or leave it out",
                );
            }
        }
        let contact_time = self.contact_time(hard, stepping)?;
        Ok(match stepping {
            HardSteppingFile::Events => HardSettings { contact_time, ..events },
            HardSteppingFile::Steps => HardSettings { stepping: HardStepping::Steps { theta }, ..events },
        })
    }

    /// [s] contact time t_c of the TC model: a collision is elastic if either particle has collided less than t_c
    /// before. `None` if the case gives no contact time.
    fn contact_time(&mut self, hard: &HardFile, stepping: HardSteppingFile) -> Result<Option<f64>, Diagnostic> {
        let Some(typed) = &hard.contact_time else { return Ok(None) };
        let help = "t_c of the TC model: how long a contact would last, for example \"1e-6 s\"; leave it out for none";
        let time = match self.in_range(typed, help) {
            Err(error) if self.model != Model::Hard => {
                self.warnings.push(error.into_warning());
                return Ok(None);
            }
            result => result?,
        };
        if stepping == HardSteppingFile::Steps {
            let help = "leave it out: collisions at the ends of steps cannot pile up";
            self.warn(&typed.origin, "`hard.contact_time` is not used by steps", help);
        }
        Ok(Some(time))
    }

    pub(super) fn hybrid(&mut self, file: &CaseFile) -> Result<HybridSettings, Diagnostic> {
        let mut settings = HybridSettings::default();
        let Some(typed) = file.hybrid.as_ref().and_then(|hybrid| hybrid.value.clearance.as_ref()) else {
            return Ok(settings);
        };
        let help = "a touch is an instant if no other particle can come within so many contact times";
        match self.in_range(typed, help) {
            Ok(clearance) => settings.clearance = clearance,
            Err(error) if self.model != Model::Hybrid => self.warnings.push(error.into_warning()),
            Err(error) => return Err(error),
        }
        Ok(settings)
    }

    /// Settings of direct simulation Monte Carlo, in which pairs collide by chance. If the model is another one, an
    /// error in these settings is only a warning.
    pub(super) fn dsmc(
        &mut self,
        file: &CaseFile,
        scene: &Scene,
        start: &[Population],
    ) -> Result<DsmcSettings, Diagnostic> {
        let Some(dsmc) = file.dsmc.as_ref().map(|dsmc| &dsmc.value) else { return Ok(DsmcSettings::default()) };
        let particles = start.iter().map(|population| population.amount.count()).sum();
        match self.dsmc_settings(dsmc, scene, particles) {
            Err(error) if self.model != Model::Dsmc => {
                self.warnings.push(error.into_warning());
                Ok(DsmcSettings::default())
            }
            result => result,
        }
    }

    /// Settings of direct simulation Monte Carlo, in which pairs collide by chance, for a start with this number of
    /// `particles`.
    fn dsmc_settings(&mut self, dsmc: &DsmcFile, scene: &Scene, particles: usize) -> Result<DsmcSettings, Diagnostic> {
        let mut settings = DsmcSettings::default();
        if let Some(enskog) = &dsmc.enskog {
            settings.enskog = enskog.value;
        }
        if let Some(step) = &dsmc.step {
            settings.step =
                self.in_range(step, "a fifth of the mean free time is a good choice; longer steps are wrong")?;
        }
        if let Some(cells) = &dsmc.cells {
            let help = "leave it out to have them chosen; about 20 particles in a cell are good";
            let numbers = self.cells(cells, &scene.domain, &scene.species, help)?.map(|count| count as usize);
            let (total, particles) = (numbers.iter().product::<usize>(), particles.max(1));
            if total > particles {
                let why =
                    format!("makes {total} cells for {particles} particles; allowed: at most one cell for a particle");
                return Err(self.refuse(cells, why).help(help));
            }
            settings.cells = Some(numbers);
        }
        Ok(settings)
    }

    /// Settings of the run: model, duration, averaging, window (time between two exchanges with the gas) and seed.
    pub(super) fn run(
        &mut self,
        file: &CaseFile,
        choice: &VariantChoice,
        soft: &SoftSettings,
    ) -> Result<RunSettings, Diagnostic> {
        let run = &self.need(&file.run, "run")?.value;
        let typed = self.need(&run.duration, "run.duration")?;
        let help = "0 s writes the initial state only";
        let help = if typed.value.0 < 0.0 { help } else { "1e9 s are thirty years" };
        let duration = self.in_range(typed, help)?;
        let mut average_from = AverageFrom::Steady;
        if let Some(typed) = &run.average_from {
            average_from = match typed.value {
                AverageFromFile::Steady => AverageFrom::Steady,
                AverageFromFile::Time(from) if from < 0.0 => {
                    return Err(self
                        .refuse(typed, "is out of range; allowed: 0 s or more, or \"steady\"")
                        .help("the time at which averaging starts"));
                }
                AverageFromFile::Time(from) if from >= duration && duration > 0.0 => {
                    let half = 0.5 * duration;
                    let message = format!("{} leaves nothing of {duration} s to average", self.as_typed(typed));
                    self.warn(
                        &typed.origin,
                        message,
                        format!("averaging starts at half the duration, {half} s, instead"),
                    );
                    AverageFrom::Time(half)
                }
                AverageFromFile::Time(from) => AverageFrom::Time(from),
            };
        }
        let window = match run.window.as_ref() {
            Some(typed) => match typed.value {
                WindowFile::Auto => None,
                WindowFile::Time(window) if window > 0.0 => Some(window),
                WindowFile::Time(_) => {
                    let what = "is out of range; allowed: greater than 0 s, or \"auto\"";
                    return Err(self.refuse(typed, what).help("the time between two drag kicks"));
                }
            },
            None => None,
        };
        let seed = match (choice.seed, &run.seed) {
            (Some(seed), _) => seed,
            (None, Some(typed)) => self.whole(typed, 0, i64::MAX, "any whole number from 0")? as u64,
            (None, None) => 1,
        };
        let law = || self.need(&soft.law, "soft.linear_spring_dashpot.stiffness").copied();
        let spheres = match self.model {
            Model::Soft => Spheres::Soft(law()?),
            Model::Hard => Spheres::Hard,
            Model::Hybrid => Spheres::Hybrid(law()?),
            Model::Dsmc => Spheres::Dsmc,
        };
        // other errors of `[output]` are reported where that table is checked
        let every = file.output.as_ref().and_then(|output| output.value.every.as_ref()).map(|every| every.value.0);
        let instants = every.filter(|every| *every > 0.0);
        Ok(RunSettings { instants, spheres, duration, average_from, window, seed })
    }

    pub(super) fn statistics(&mut self, file: &CaseFile) -> Result<StatisticsSettings, Diagnostic> {
        let mut settings = StatisticsSettings::default();
        let Some(statistics) = file.statistics.as_ref().map(|statistics| &statistics.value) else {
            return Ok(settings);
        };
        if let Some(slices) = &statistics.slices {
            settings.slices =
                self.whole(slices, 1, 100_000, "slices between y = 0 and y = L_y; the paper has 40 and 15")?;
        }
        if let Some(interval) = &statistics.sample_interval {
            let help = "the time between two samples; leave it out to have it chosen";
            settings.sample_interval = Some(self.in_range(interval, help)?);
        }
        Ok(settings)
    }
}
