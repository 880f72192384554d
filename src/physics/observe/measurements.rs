//! Measurements that a case asks for, and the common form of their results: curves and numbers with standard errors.

use super::Observer;
use super::clusters::ParticleClusters;
use super::contact_network::{ContactLine, ContactNetwork};
use super::diffusion::Diffusion;
use super::fields::Fields;
use super::free_surface::FreeSurface;
use super::pair_distribution::PairDistribution;
use super::seen_gas::SeenGas;
use super::structure_factor::StructureFactor;
use super::velocity_distribution::VelocityDistribution;
use super::viscosity::Viscosity;
use crate::experiment::Experiment;
use crate::schedule::Schedule;
use crate::statistics::{Batches, Estimate, estimate};
use nalgebra::Vector3;

/// Quantity whose values a curve or a number of a measurement holds: its names and its unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObservedQuantity {
    /// Name of the column of the quantity in files, with its unit.
    pub column: String,
    /// Name of the quantity in pictures and tables.
    pub symbol: String,
    /// SI unit of the quantity; empty for a pure number.
    pub unit: &'static str,
}

impl ObservedQuantity {
    /// Creates a quantity from the name of its column, its symbol and its unit.
    pub fn new(column: impl Into<String>, symbol: impl Into<String>, unit: &'static str) -> Self {
        Self { column: column.into(), symbol: symbol.into(), unit }
    }
}

/// Curve of a measurement: values of a quantity at all places along the axis of the measurement, such as distances.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedCurve {
    /// Quantity whose values the curve holds.
    pub quantity: ObservedQuantity,
    /// Values in the unit of the quantity, one for each place of the measurement; `None` where the value is unknown.
    pub values: Vec<Option<Estimate>>,
    /// Name of a theory, and the values of the theory at the same places in the same unit; `None` without a theory.
    pub theory: Option<(&'static str, Vec<f64>)>,
    /// True if pictures show the values of the curve on a logarithmic axis.
    pub is_logarithmic: bool,
}

/// Single number that a measurement gives, such as a value at contact.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedNumber {
    /// Quantity whose value is given.
    pub quantity: ObservedQuantity,
    /// Value in the unit of the quantity; `None` if it is unknown.
    pub value: Option<Estimate>,
    /// Name of a theory, and the value of the theory in the same unit; `None` without a theory.
    pub theory: Option<(&'static str, f64)>,
    /// Values over blocks of time in the unit of the quantity, by which runs are compared. `None` if only `value` is
    /// known; then its standard error counts as exact, so that differences are tested by the normal distribution.
    pub batches: Option<Batches>,
}

impl ObservedNumber {
    /// Creates a number that is the mean of `samples`, in the unit of the quantity and in the order of time. `clock`
    /// has the time of the first sample and the interval between samples, both in s. `theory` is the name and the value
    /// of a theory; `None` without a theory.
    pub fn of_series(
        quantity: ObservedQuantity,
        samples: &[f64],
        clock: [f64; 2],
        theory: Option<(&'static str, f64)>,
    ) -> Self {
        let [from, interval] = clock;
        Self { quantity, value: estimate(samples), theory, batches: Batches::of_series(samples, interval, from) }
    }
}

/// Time averages on a grid of equal cells that fill the box.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedGrid {
    /// Numbers of cells along x, y and z.
    pub cells: [usize; 3],
    /// [m] edge lengths of a cell along x, y and z.
    pub spacing: Vector3<f64>,
    /// Fields on the grid: name with unit, number of components, and the components of each cell. The index along x
    /// changes first from cell to cell.
    pub fields: Vec<(&'static str, usize, Vec<f64>)>,
}

/// Result of a measurement, averaged over the averaging period.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observation {
    /// Name of the measurement in the case, and of the file with its curves.
    pub name: &'static str,
    /// Heading of the measurement in reports.
    pub title: &'static str,
    /// Quantity on the common axis of all curves, such as a distance.
    pub axis: ObservedQuantity,
    /// [SI] places along the axis at which the curves have values, in the unit of the axis.
    pub places: Vec<f64>,
    /// Curves of the measurement, each with a value at every place.
    pub curves: Vec<ObservedCurve>,
    /// Single numbers that the measurement gives.
    pub numbers: Vec<ObservedNumber>,
    /// Contacts at the end of the run, which are written to a file as lines between the centres.
    pub lines: Vec<ContactLine>,
    /// Averages in the cells of a grid, which are written to a file; `None` if the measurement has no grid. If several
    /// runs are pooled, the averages are those of the first run.
    pub grid: Option<ObservedGrid>,
    /// Reason why values are unknown, and how to avoid it; `None` if all values are known.
    pub remark: Option<&'static str>,
}

impl Observation {
    /// Means over several replicas (runs with different seeds). If `by_runs` is true, errors follow from the scatter
    /// between the runs; this choice is for particles that do not mix within a run.
    pub fn pool(runs: &[&[Self]], by_runs: bool) -> Vec<Self> {
        let Some(first) = runs.first() else { return Vec::new() };
        let mean = |values: &mut dyn Iterator<Item = Option<Estimate>>| {
            if !by_runs {
                return Estimate::mean_of(values);
            }
            let values: Option<Vec<f64>> = values.map(|value| value.map(|value| value.value)).collect();
            Batches::of_runs(vec![values?]).estimate()
        };
        let mut pooled = first.to_vec();
        for (place, result) in pooled.iter_mut().enumerate() {
            for (k, curve) in result.curves.iter_mut().enumerate() {
                let values = |point: usize| runs.iter().map(move |run| run[place].curves[k].values[point]);
                curve.values = (0..curve.values.len()).map(|point| mean(&mut values(point))).collect();
            }
            for (k, number) in result.numbers.iter_mut().enumerate() {
                number.value = mean(&mut runs.iter().map(|run| run[place].numbers[k].value));
                let parts: Option<Vec<&Batches>> =
                    runs.iter().map(|run| run[place].numbers[k].batches.as_ref()).collect();
                number.batches = parts.and_then(|parts| Batches::pool(&parts, by_runs));
            }
            result.remark = runs.iter().find_map(|run| run[place].remark);
        }
        pooled
    }
}

/// Observer of a run whose result has the common form of an [`Observation`].
pub trait Measurement: Observer {
    /// Returns the result for the averaging period, from the time `from` [s] to the end of the run.
    fn result(&self, experiment: &Experiment, from: f64) -> Observation;
}

/// Measurements of a run that the case asks for. `None` means that the case does not ask for the measurement.
#[derive(Clone, Debug, Default)]
pub struct Measurements {
    pair_distribution: Option<PairDistribution>,
    velocity_distribution: Option<VelocityDistribution>,
    diffusion: Option<Diffusion>,
    structure_factor: Option<StructureFactor>,
    contact_network: Option<ContactNetwork>,
    fields: Option<Fields>,
    seen_gas: Option<SeenGas>,
    viscosity: Option<Viscosity>,
    clusters: Option<ParticleClusters>,
    free_surface: Option<FreeSurface>,
}

impl Measurements {
    /// Creates the measurements for a run of `experiment`. `schedule` contains the instants of measurement.
    pub fn new(experiment: &Experiment, schedule: &Schedule) -> Self {
        let asked = &experiment.observe;
        Self {
            pair_distribution: asked
                .pair_distribution
                .map(|settings| PairDistribution::new(experiment, schedule, settings)),
            velocity_distribution: asked
                .velocity_distribution
                .map(|settings| VelocityDistribution::new(experiment, schedule, settings)),
            diffusion: asked.diffusion.map(|settings| Diffusion::new(experiment, schedule, settings)),
            structure_factor: asked
                .structure_factor
                .map(|settings| StructureFactor::new(experiment, schedule, settings)),
            contact_network: asked.contact_network.then(|| ContactNetwork::new(experiment, schedule)),
            fields: asked.fields.map(|settings| Fields::new(experiment, schedule, settings)),
            seen_gas: asked.seen_gas.then(|| SeenGas::new(experiment, schedule)),
            viscosity: asked.viscosity.map(|settings| Viscosity::new(schedule, settings)),
            clusters: asked.clusters.map(|settings| ParticleClusters::new(schedule, settings)),
            free_surface: asked.free_surface.map(|settings| FreeSurface::new(experiment, schedule, settings)),
        }
    }

    /// All measurements that the case asks for.
    pub fn each(&mut self) -> impl Iterator<Item = &mut dyn Measurement> {
        let pairs = self.pair_distribution.as_mut().map(|of| of as &mut dyn Measurement);
        let velocities = self.velocity_distribution.as_mut().map(|of| of as &mut dyn Measurement);
        let diffusion = self.diffusion.as_mut().map(|of| of as &mut dyn Measurement);
        let structure = self.structure_factor.as_mut().map(|of| of as &mut dyn Measurement);
        let network = self.contact_network.as_mut().map(|of| of as &mut dyn Measurement);
        let fields = self.fields.as_mut().map(|of| of as &mut dyn Measurement);
        let seen = self.seen_gas.as_mut().map(|of| of as &mut dyn Measurement);
        let viscosity = self.viscosity.as_mut().map(|of| of as &mut dyn Measurement);
        let clusters = self.clusters.as_mut().map(|of| of as &mut dyn Measurement);
        let surface = self.free_surface.as_mut().map(|of| of as &mut dyn Measurement);
        [pairs, velocities, diffusion, structure, network, fields, seen, viscosity, clusters, surface]
            .into_iter()
            .flatten()
    }

    /// Results of all measurements, averaged from the time `from` [s] to the end of the run.
    pub fn results(mut self, experiment: &Experiment, from: f64) -> Vec<Observation> {
        self.each().map(|measurement| measurement.result(experiment, from)).collect()
    }
}
