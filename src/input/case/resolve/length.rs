//! Refuses runs that would practically never end, because they have too many windows or time steps. A window is the
//! time between two exchanges of momentum with the gas.

use super::{Resolver, short};
use crate::case::diagnostic::Diagnostic;
use crate::case::file::CaseFile;
use crate::case::source::Origin;
use crate::case::time_or_word::WindowFile;
use crate::experiment::{Experiment, SoftStepping};
use crate::predict::contact::ContactTimes;
use crate::schedule::Schedule;
use crate::simulation::soft_step;

/// Largest number of windows (times between two exchanges with the gas), or of time steps of all particles, unless the
/// case allows more. It is about a hundred times the number in the longest run of the paper of `docs/paper.md` (6.5e6).
/// A run of a single particle with so many windows takes minutes to hours.
pub const MOST: f64 = 1e9;

/// Largest number of time steps if time steps move only particles in contact. With more steps, the length of a step
/// would be close to the rounding error of the simulated time (1e-16 of that time).
const MOST_LOCAL: f64 = 1e15;

/// Source position of the key that alone makes too many windows: the interval of samples (instants of measurement) or
/// of trajectory frames. Windows end at these instants. `None` if neither key alone makes too many.
fn too_often<'a>(file: &'a CaseFile, experiment: &Experiment) -> Option<&'a Origin> {
    let duration = experiment.run.duration;
    let samples = file.statistics.as_ref().and_then(|typed| typed.value.sample_interval.as_ref());
    let samples =
        samples.filter(|_| experiment.statistics.sample_interval.is_some_and(|every| duration / every > MOST));
    let frames = file.output.as_ref().and_then(|typed| typed.value.every.as_ref());
    let frames = frames.filter(|_| experiment.run.instants.is_some_and(|every| duration / every > MOST));
    samples.or(frames).map(|typed| &typed.origin)
}

impl Resolver {
    /// Refuses a run that has too many windows (times between two exchanges with the gas) or time steps, unless the
    /// case allows such runs.
    pub(super) fn check_length(&mut self, file: &CaseFile, experiment: &Experiment) -> Result<(), Diagnostic> {
        let Some(run) = file.run.as_ref() else { return Ok(()) };
        let value = &run.value;
        if value.allow_long.as_ref().is_some_and(|allow| allow.value) || experiment.run.duration <= 0.0 {
            return Ok(());
        }
        let duration = value.duration.as_ref().map(|typed| &typed.origin);
        let schedule = Schedule::new(experiment);
        // each trajectory frame may divide a window into two
        let instants = schedule.instants.map_or(0.0, |every| experiment.run.duration / every);
        let windows = experiment.run.duration / schedule.window + instants;
        if windows > MOST {
            let typed = value.window.as_ref().filter(|typed| matches!(typed.value, WindowFile::Time(_)));
            let window = typed.map(|typed| &typed.origin);
            let origin = too_often(file, experiment).or(window).or(duration).unwrap_or(&run.origin);
            return Err(self.too_long(origin, windows, &format!("windows of {:.3e} s", schedule.window), MOST));
        }
        let Some(law) = experiment.law() else { return Ok(()) };
        let soft = file.soft.as_ref().map(|soft| &soft.value);
        let step = soft_step(experiment, experiment.most_that_touch(experiment.count()));
        // if no contact is possible, each window is one step, so only windows are counted
        let touches =
            ContactTimes::of(experiment, &law, experiment.most_that_touch(experiment.count())).governing().is_some();
        let most = match experiment.soft.stepping {
            SoftStepping::Uniform => MOST,
            SoftStepping::Local | SoftStepping::Auto => MOST_LOCAL,
        };
        let steps = experiment.run.duration / step;
        if touches && steps > most {
            let typed = soft.and_then(|soft| soft.time_step.as_ref()).map(|step| &step.origin);
            let spring = soft.and_then(|soft| soft.linear_spring_dashpot.as_ref()).map(|law| &law.origin);
            let hertz =
                soft.and_then(|soft| soft.hertz.as_ref().or(soft.kuwabara_kono.as_ref())).map(|law| &law.origin);
            let origin = typed.or(spring).or(hertz).or(duration).unwrap_or(&run.origin);
            return Err(self.too_long(origin, steps, &format!("time steps of {step:.3e} s"), most));
        }
        Ok(())
    }

    fn too_long(&self, origin: &Origin, count: f64, what: &str, most: f64) -> Diagnostic {
        let message = format!("the run would have {count:.3e} {what}; allowed: up to {}", short(most));
        let help = "make the run shorter, or its windows, steps and intervals longer; to run it all the same, set `run.allow_long = true`";
        self.sources.error(origin, message).help(help)
    }
}
