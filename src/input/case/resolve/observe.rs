//! Reads and checks the measurements that a case requests in addition to the standard ones.

use super::Resolver;
use crate::case::describe::length;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{
    CaseFile, ClustersFile, DiffusionFile, FieldsFile, FreeSurfaceFile, PairDistributionFile, StructureFactorFile,
    VelocityDistributionFile, ViscosityFile,
};
use crate::case::located::Located;
use crate::case::quantity::Time;
use crate::experiment::{
    ClustersSettings, DiffusionSettings, Experiment, FieldsSettings, FreeSurfaceSettings, ObserveSettings,
    PairDistributionSettings, StructureFactorSettings, VelocityDistributionSettings, ViscositySettings,
};
use crate::scene::Scene;
use crate::schedule::Schedule;

/// Largest number of bins of a histogram.
const MOST_BINS: i64 = 10_000;
/// Largest number of wavelengths along an edge of the box. The list of wave vectors grows with the third power of this
/// number.
const MOST_WAVES: f64 = 100.0;
/// Largest number of cells of a grid of fields (density, velocity and stress). A cell takes 2.5 KB of memory: 16 sums
/// for each of the 20 parts into which the time of a run is divided.
const MOST_CELLS: i64 = 50_000;
/// Smallest number of columns of a surface along an edge of the box; `MOST_COLUMNS` is the largest number. The
/// computing time at each instant of measurement grows with the third power of the number of columns.
const FEWEST_COLUMNS: f64 = 10.0;
const MOST_COLUMNS: f64 = 500.0;
/// Smallest number of samples (instants of measurement) within the longest time span of the mean squared displacement,
/// or of the correlation of stresses.
const FEWEST_SAMPLES: f64 = 10.0;

impl Resolver {
    /// Settings of the measurements that a case requests in addition to the standard ones.
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
        let structure = asked.structure_factor.as_ref().map(|of| self.structure_factor(of, scene));
        let fields = asked.fields.as_ref().map(|of| self.fields(of, scene));
        let viscosity = asked.viscosity.as_ref().map(|of| self.viscosity(of, scene));
        let clusters = asked.clusters.as_ref().map(|of| self.clusters(of, scene));
        let surface = asked.free_surface.as_ref().map(|of| self.free_surface(of, scene));
        if let Some(seen) = asked.seen_gas.as_ref().filter(|_| !scene.has_turbulence()) {
            let why = "needs a gas whose fluctuations particles see";
            return Err(self.refuse(seen, why).help("add [fluid.turbulence.langevin], or leave the table out"));
        }
        Ok(ObserveSettings {
            pair_distribution: pairs.transpose()?,
            velocity_distribution: velocities.transpose()?,
            diffusion: diffusion.transpose()?,
            structure_factor: structure.transpose()?,
            contact_network: asked.contact_network.is_some(),
            fields: fields.transpose()?,
            seen_gas: asked.seen_gas.is_some(),
            viscosity: viscosity.transpose()?,
            clusters: clusters.transpose()?,
            free_surface: surface.transpose()?,
        })
    }

    /// Refuses a measurement that needs a box that is periodic along all axes, if the box of the scene is not.
    fn refuse_sides<T>(&self, typed: &Located<T>, scene: &Scene) -> Result<(), Diagnostic> {
        if scene.domain.periodic == [true; 3] {
            return Ok(());
        }
        let message = format!("`{}` needs a box that is periodic along all axes", typed.path);
        let help = "leave the table out, or write `periodic = [\"x\", \"y\", \"z\"]` in [domain]";
        Err(self.sources.error(&typed.origin, message).help(help))
    }

    /// Refuses a measurement that needs periodic images at rest, if the box is sheared.
    fn refuse_shear_of<T>(&self, typed: &Located<T>, scene: &Scene) -> Result<(), Diagnostic> {
        if scene.domain.shear.is_none() {
            return Ok(());
        }
        let message = format!("`{}` is not for sheared boxes, whose images move", typed.path);
        Err(self.sources.error(&typed.origin, message).help("leave the table out"))
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
        // half an edge of the box and the decimal number typed for it may differ by rounding
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
        self.refuse_shear_of(typed, scene)?;
        let duration = self.need(&typed.value.duration, "observe.diffusion.duration")?;
        Ok(DiffusionSettings { duration: self.in_range(duration, "some ten collisions of each particle")? })
    }

    fn structure_factor(
        &self,
        typed: &Located<StructureFactorFile>,
        scene: &Scene,
    ) -> Result<StructureFactorSettings, Diagnostic> {
        let wavelength = self.need(&typed.value.wavelength, "observe.structure_factor.wavelength")?;
        let help = "half a diameter shows two peaks of a dense fluid";
        self.in_range(wavelength, help)?;
        let bins = self.bins(&typed.value.bins, 50)?;
        self.refuse_sides(typed, scene)?;
        self.refuse_shear_of(typed, scene)?;
        let (least, most) = (scene.domain.size.max() / MOST_WAVES, scene.domain.size.min());
        let allowed =
            format!("{least:.4e} to {most:.4e} m, a hundredth of the longest edge to the shortest edge of the box");
        let fits = |length: f64| length >= least * (1.0 - 1e-9) && length <= most;
        let wavelength = self.checked(wavelength, fits, &allowed, help)?;
        Ok(StructureFactorSettings { wavelength, bins })
    }

    fn fields(&self, typed: &Located<FieldsFile>, scene: &Scene) -> Result<FieldsSettings, Diagnostic> {
        let width = self.need(&typed.value.width, "observe.fields.width")?;
        let help = "half a diameter to a diameter";
        self.in_range(width, help)?;
        let cells = self.need(&typed.value.cells, "observe.fields.cells")?;
        let numbers = [0, 1, 2].map(|axis| cells.value[axis].value);
        let total = numbers.iter().fold(1_i64, |total, count| total.saturating_mul(*count));
        if numbers.iter().any(|count| *count < 1) || total > MOST_CELLS {
            let why = format!("is out of range; allowed: at least one along each axis, together up to {MOST_CELLS}");
            return Err(self.refuse(cells, why).help("about two cells in a width of the Gaussian"));
        }
        self.refuse_shear_of(typed, scene)?;
        let most = scene.domain.size.min();
        let allowed = format!("up to {most:.6e} m, the shortest edge of the box");
        let width = self.checked(width, |width| width <= most, &allowed, help)?;
        Ok(FieldsSettings { width, cells: numbers.map(|count| count as usize) })
    }

    fn viscosity(&self, typed: &Located<ViscosityFile>, scene: &Scene) -> Result<ViscositySettings, Diagnostic> {
        let duration = &typed.value.duration;
        if scene.domain.shear.is_none() {
            let duration = self.need(duration, "observe.viscosity.duration")?;
            let duration = self.in_range(duration, "some twenty mean free times")?;
            return Ok(ViscositySettings { duration: Some(duration) });
        }
        match duration {
            Some(given) => Err(self.refuse(given, "is not used in a sheared box").help("leave the key out")),
            None => Ok(ViscositySettings { duration: None }),
        }
    }

    fn clusters(&self, typed: &Located<ClustersFile>, scene: &Scene) -> Result<ClustersSettings, Diagnostic> {
        let gap = self.need(&typed.value.gap, "observe.clusters.gap")?;
        let help = "a length such as \"20 um\", some per cent of a diameter";
        self.in_range(gap, help)?;
        let edges = (0..3).filter(|axis| scene.domain.periodic[*axis]).map(|axis| scene.domain.size[axis]);
        let most = 0.5 * edges.fold(f64::INFINITY, f64::min) - scene.largest_diameter();
        let allowed = format!("up to {most:.4e} m, half the shortest periodic edge less the largest diameter");
        Ok(ClustersSettings { gap: self.checked(gap, |gap| gap <= most, &allowed, help)? })
    }

    fn free_surface(&self, typed: &Located<FreeSurfaceFile>, scene: &Scene) -> Result<FreeSurfaceSettings, Diagnostic> {
        let spacing = self.need(&typed.value.spacing, "observe.free_surface.spacing")?;
        let help = "about a diameter";
        self.in_range(spacing, help)?;
        let smoothing = typed.value.smoothing.as_ref();
        smoothing.map_or(Ok(0.0), |width| self.in_range(width, "two columns, or 0 for heights as they are"))?;
        let axis = scene.gravity.iamax();
        if scene.gravity[axis] == 0.0 || (0..3).any(|other| other != axis && scene.gravity[other] != 0.0) {
            let message = format!("`{}` needs gravity along x, y or z", typed.path);
            let help = "leave the table out, or write [gravity] with an acceleration along one axis";
            return Err(self.sources.error(&typed.origin, message).help(help));
        }
        let edges = (0..3).filter(|level| *level != axis).map(|level| scene.domain.size[level]);
        let (shortest, longest) = edges.fold((f64::INFINITY, 0.0_f64), |(a, b), edge| (a.min(edge), b.max(edge)));
        let (least, most) = (longest / MOST_COLUMNS, shortest / FEWEST_COLUMNS);
        let allowed =
            format!("{least:.4e} to {most:.4e} m, so that each edge has {FEWEST_COLUMNS} to {MOST_COLUMNS} columns");
        // an edge divided by a whole number and the decimal number typed for it may differ by rounding
        let fits = |spacing: f64| spacing >= least * (1.0 - 1e-9) && spacing <= most * (1.0 + 1e-9);
        let spacing = self.checked(spacing, fits, &allowed, help)?;
        let smoothing = match smoothing {
            None => 2.0 * spacing,
            Some(given) => {
                let allowed = format!("up to {:.4e} m, a tenth of the shorter horizontal edge", 0.1 * shortest);
                self.checked(given, |width| width <= 0.1 * shortest, &allowed, "two columns")?
            }
        };
        Ok(FreeSurfaceSettings { up: (axis, -scene.gravity[axis].signum()), spacing, smoothing })
    }

    /// Checks the measurements against the experiment and the samples of its run.
    ///
    /// # Errors
    /// Too few samples for a measurement, or a viscosity of a scene that is neither sheared nor in equilibrium.
    pub(super) fn check_observe(&self, file: &CaseFile, experiment: &Experiment) -> Result<(), Diagnostic> {
        let Some(asked) = file.observe.as_ref().map(|observe| &observe.value) else { return Ok(()) };
        let diffusion = asked.diffusion.as_ref().and_then(|of| of.value.duration.as_ref());
        diffusion.map_or(Ok(()), |typed| self.check_samples(typed, experiment))?;
        let Some(viscosity) = &asked.viscosity else { return Ok(()) };
        let duration = viscosity.value.duration.as_ref();
        duration.map_or(Ok(()), |typed| self.check_samples(typed, experiment))?;
        if experiment.scene.domain.shear.is_some() || experiment.is_in_equilibrium() {
            return Ok(());
        }
        let message = format!("`{}` needs a sheared box or a gas in equilibrium", viscosity.path);
        let help = "add [domain.shear], or let nothing but elastic, frictionless collisions act in a box that is periodic along x, y and z";
        Err(self.sources.error(&viscosity.origin, message).help(help))
    }

    /// Checks that the longest time span of a measurement, such as that of a displacement, contains enough samples
    /// (instants of measurement) and is within the run.
    fn check_samples(&self, typed: &Located<Time>, experiment: &Experiment) -> Result<(), Diagnostic> {
        let interval = Schedule::new(experiment).interval();
        let (asked, least, most) = (typed.value.0, FEWEST_SAMPLES * interval, experiment.run.duration);
        if asked >= least * (1.0 - 1e-9) && asked <= most {
            return Ok(());
        }
        let allowed =
            format!("is out of range; allowed: {least:.4e} s, {FEWEST_SAMPLES} samples, up to the run of {most:.4e} s");
        let help = format!("sample more often: statistics.sample_interval = \"{:.1e} s\"", asked.min(most) / 50.0);
        Err(self.refuse(typed, allowed).help(help))
    }

    /// Number of bins of a histogram: the number in the case, or else `default`.
    fn bins(&self, typed: &Option<Located<i64>>, default: usize) -> Result<usize, Diagnostic> {
        typed.as_ref().map_or(Ok(default), |bins| self.whole(bins, 1, MOST_BINS, "the number of bins of a histogram"))
    }
}
