//! Reads and checks the measurements in addition to the standard ones.

use super::Resolver;
use crate::case::de::Located;
use crate::case::describe::length;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, DiffusionFile, PairDistributionFile, VelocityDistributionFile};
use crate::experiment::{
    DiffusionSettings, Experiment, ObserveSettings, PairDistributionSettings, VelocityDistributionSettings,
};
use crate::scene::Scene;
use crate::schedule::Schedule;

/// Largest number of bins of a histogram.
const MOST_BINS: i64 = 10_000;
/// Fewest samples in the longest time of the mean squared displacement.
const FEWEST_SAMPLES: f64 = 10.0;

impl Resolver {
    /// Measurements that a case asks for.
    ///
    /// # Errors
    /// Settings out of range, or a scene in which the measurement has no meaning.
    pub(super) fn observe(&self, file: &CaseFile, scene: &Scene) -> Result<ObserveSettings, Diagnostic> {
        let Some(asked) = file.observe.as_ref().map(|asked| &asked.value) else {
            return Ok(ObserveSettings::default());
        };
        let pairs = asked.pair_distribution.as_ref().map(|pairs| self.pair_distribution(pairs, scene));
        let velocities = asked.velocity_distribution.as_ref().map(|of| self.velocity_distribution(&of.value));
        let diffusion = asked.diffusion.as_ref().map(|of| self.diffusion(of, scene));
        Ok(ObserveSettings {
            pair_distribution: pairs.transpose()?,
            velocity_distribution: velocities.transpose()?,
            diffusion: diffusion.transpose()?,
        })
    }

    /// Refuses a measurement that needs a box without walls.
    fn refuse_sides<T>(&self, typed: &Located<T>, scene: &Scene) -> Result<(), Diagnostic> {
        if scene.domain.periodic == [true; 3] {
            return Ok(());
        }
        let message = format!("`{}` needs a box that is periodic along all axes", typed.path);
        let help = "leave the table out, or write `periodic = [\"x\", \"y\", \"z\"]` in [domain]";
        Err(self.sources.error(&typed.origin, message).help(help))
    }

    fn pair_distribution(
        &self,
        typed: &Located<PairDistributionFile>,
        scene: &Scene,
    ) -> Result<PairDistributionSettings, Diagnostic> {
        let half = 0.5 * scene.domain.size.min();
        let reach = self.need(&typed.value.reach, "observe.pair_distribution.reach")?;
        let help = format!("a length such as \"{}\", half the shortest edge of the box", length(half));
        self.in_range(reach, &help)?;
        let allowed = format!("up to {half:.6e} m, half the shortest edge of the box");
        // half a decimal number and the decimal number typed for it may differ by rounding
        let reach = self.checked(reach, |reach| reach <= half * (1.0 + 1e-9), &allowed, &help)?.min(half);
        let bins = self.bins(&typed.value.bins, 100)?;
        self.refuse_sides(typed, scene)?;
        Ok(PairDistributionSettings { reach, bins })
    }

    fn velocity_distribution(
        &self,
        typed: &VelocityDistributionFile,
    ) -> Result<VelocityDistributionSettings, Diagnostic> {
        let largest_speed = match &typed.largest_speed {
            Some(largest) => self.in_range(largest, "4 leaves out one particle in a million of a Maxwellian gas")?,
            None => 4.0,
        };
        Ok(VelocityDistributionSettings { largest_speed, bins: self.bins(&typed.bins, 40)? })
    }

    fn diffusion(&self, typed: &Located<DiffusionFile>, scene: &Scene) -> Result<DiffusionSettings, Diagnostic> {
        if scene.domain.shear.is_some() {
            let message = format!("`{}` is not for sheared boxes, whose flow carries particles apart", typed.path);
            return Err(self.sources.error(&typed.origin, message).help("leave the table out"));
        }
        let duration = self.need(&typed.value.duration, "observe.diffusion.duration")?;
        Ok(DiffusionSettings { duration: self.in_range(duration, "some ten collisions of each particle")? })
    }

    /// Checks the measurements against the samples of the run.
    ///
    /// # Errors
    /// Too few samples for a measurement.
    pub(super) fn check_observe(&self, file: &CaseFile, experiment: &Experiment) -> Result<(), Diagnostic> {
        let typed = file.observe.as_ref().and_then(|observe| observe.value.diffusion.as_ref());
        let typed = typed.and_then(|diffusion| diffusion.value.duration.as_ref());
        let (Some(asked), Some(typed)) = (experiment.observe.diffusion, typed) else { return Ok(()) };
        let interval = Schedule::new(experiment).interval();
        let (least, most) = (FEWEST_SAMPLES * interval, experiment.run.duration);
        if asked.duration >= least * (1.0 - 1e-9) && asked.duration <= most {
            return Ok(());
        }
        let allowed =
            format!("is out of range; allowed: {least:.4e} s, {FEWEST_SAMPLES} samples, up to the run of {most:.4e} s");
        let help =
            format!("sample more often: statistics.sample_interval = \"{:.1e} s\"", asked.duration.min(most) / 50.0);
        Err(self.refuse(typed, allowed).help(help))
    }

    /// Number of bins of a histogram.
    fn bins(&self, typed: &Option<Located<i64>>, default: usize) -> Result<usize, Diagnostic> {
        typed.as_ref().map_or(Ok(default), |bins| self.whole(bins, 1, MOST_BINS, "the number of bins of a histogram"))
    }
}
