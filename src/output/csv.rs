//! Tables of results as CSV. The headers are fixed, because scripts depend on them. Cells of unknown numbers are empty.
//! A variant is one of the experiments of a case.

use super::limits::Map;
use super::sensitivity::SensitivityStudy;
use super::sweep::{OBSERVABLES, SweepStudy};
use super::{Bounce, ChartStudy, CostMeasure, ObliqueStudy, OutputError};
use crate::case::saved;
use crate::experiment::Model;
use crate::legible;
use crate::observe::{Budgets, MOMENTS};
use crate::outcome::Outcome;
use crate::particles::Particles;
use crate::record::{Histogram, Impacts};
use crate::scene::Scene;
use crate::statistics::{SliceColumn, SliceRow, slice_columns};
use ::csv::Writer;

/// Contents of `profiles.csv`, with one row per variant (experiment of a case) and slice (layer of the box normal to
/// y). Units: m, m/s, and powers of m/s for moments of velocity. Columns with `_se` contain one standard error.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn profiles(outcomes: &[Outcome]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head(&format!("variant,{}", slice_head(outcomes)))?;
    for outcome in outcomes {
        for (index, row) in outcome.profiles.slices.iter().enumerate() {
            table.row(std::iter::once(outcome.experiment.name.clone()).chain(slice(index, row, rotating(outcomes))))?;
        }
    }
    table.bytes()
}

/// Contents of `species.csv`: the columns of `profiles.csv` for each species of a mixture. Densities are relative to
/// the mean density of the species.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn species(outcomes: &[Outcome]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head(&format!("variant,species,{}", slice_head(outcomes)))?;
    for outcome in outcomes {
        for of in &outcome.kinds.species {
            for (index, row) in of.profiles.slices.iter().enumerate() {
                let names = [outcome.experiment.name.clone(), of.name.clone()];
                table.row(names.into_iter().chain(slice(index, row, rotating(outcomes))))?;
            }
        }
    }
    table.bytes()
}

/// Contents of `rings.csv`: the columns of `profiles.csv` for rings of equal area about the axis of a pipe. The radius
/// r_m divides the area of a ring into two equal parts. v is the velocity away from the axis, w the velocity around the
/// axis, and gas_U the mean gas velocity in the ring.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn rings(outcomes: &[Outcome]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    let head = slice_head(outcomes).replace("slice,y_m,", "ring,r_m,");
    table.head(&format!("variant,r_inner_m,r_outer_m,gas_U,{head}"))?;
    for outcome in outcomes {
        let rows = outcome.rings.rings.iter().zip(&outcome.rings.profiles.slices);
        for (index, (ring, row)) in rows.enumerate() {
            let known = [outcome.experiment.name.clone()].into_iter();
            let own = [ring.inner, ring.outer, ring.gas].map(|value| number(Some(value)));
            table.row(known.chain(own).chain(slice(index, row, rotating(outcomes))))?;
        }
    }
    table.bytes()
}

/// True if spheres rotate in at least one of the experiments, so that the tables have columns of spins.
fn rotating(outcomes: &[Outcome]) -> bool {
    outcomes.iter().any(|outcome| outcome.experiment.scene.rotation.is_some())
}

/// Header of the averages in a slice (layer of the box normal to y): names of the values, then of their standard
/// errors.
fn slice_head(outcomes: &[Outcome]) -> String {
    let columns = slice_columns(rotating(outcomes));
    let values: String = columns.iter().map(|column| format!("{},", column.name)).collect();
    let errors: String = columns.iter().map(|column| format!("{}_se,", column.name)).collect();
    format!("slice,y_m,{values}{errors}samples")
}

/// Cells of the row of one slice (layer of the box normal to y), in the order of [`slice_head`]. If `rotating` is true,
/// the columns of rotating spheres are included.
fn slice(index: usize, row: &SliceRow, rotating: bool) -> impl Iterator<Item = String> {
    let found = |column: &SliceColumn| row.of(*column);
    let columns = slice_columns(rotating).iter();
    let values = columns.clone().map(move |column| number(found(column).map(|found| found.value)));
    let errors = columns.map(move |column| number(found(column).and_then(|found| found.error)));
    [index.to_string(), number(row.y)].into_iter().chain(values).chain(errors).chain([row.samples.to_string()])
}

/// Contents of `meetings.csv`: impacts between each pair of species of a mixture, and between a species and a wall, in
/// the averaging period. Rates are in 1/s, speeds in m/s. Columns with `_se` contain one standard error.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn meetings(outcomes: &[Outcome]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head(
        "variant,species,other,impacts,impacts_per_second,impacts_per_second_se,mean_normal_speed,restitution_asked,restitution",
    )?;
    for outcome in outcomes {
        for met in &outcome.kinds.meetings {
            let [species, other] = met.between.clone();
            let names = [outcome.experiment.name.clone(), species, other, met.count.to_string()];
            let numbers = [
                met.rate.map(|rate| rate.value),
                met.rate.and_then(|rate| rate.error),
                met.normal_speed,
                Some(met.restitution_asked),
                met.restitution,
            ];
            table.row(names.into_iter().chain(numbers.map(number)))?;
        }
    }
    table.bytes()
}

/// Contents of `impacts.csv`: histograms of the impacts in every variant (experiment of a case). Overlaps are divided
/// by the diameter of the smaller sphere. If all values of a quantity are 0, such as overlaps of hard spheres, the
/// quantity has a single row, for a bin without width and density.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn impacts(outcomes: &[Outcome]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head("variant,kind,quantity,unit,bin_lower,bin_upper,count,probability_density")?;
    for outcome in outcomes {
        for (kind, impacts) in [("pair", &outcome.pairs), ("wall", &outcome.walls)] {
            for (quantity, unit, histogram) in histograms(impacts) {
                for bin in bins(histogram) {
                    let name = outcome.experiment.name.clone();
                    let labels = [name, kind.into(), quantity.into(), unit.into()];
                    let values = [number(bin.lower), number(bin.upper), bin.count.to_string(), number(bin.density)];
                    table.row(labels.into_iter().chain(values))?;
                }
            }
        }
    }
    table.bytes()
}

/// Contents of `overlaps.csv`: means and extremes of the overlaps in the averaging period, divided by the diameter of
/// the smaller sphere. Each variant (experiment of a case) with soft contacts has a row for pairs of particles and a
/// row for walls. The granular temperature is in m²/s², the elastic parameter of the contact law (such as the
/// stiffness) in SI, other numbers are [-]. The overlap number κ_n (theoretical time average of the overlap, divided by
/// the diameter) is computed from the measured temperature. The cells of κ_n are empty if spheres or surfaces differ.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn overlaps(outcomes: &[Outcome]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head(
        "variant,kind,granular_temperature_m2_s2,granular_temperature_se,elastic_parameter_si,kappa_n,\
         impacts,mean_maximum_overlap,mean_maximum_overlap_se,mean_maximum_overlap_over_kappa_n,time_mean_overlap,time_mean_overlap_over_kappa_n,p99_maximum_overlap,largest_overlap",
    )?;
    for outcome in outcomes {
        let Some(parameter) = outcome.experiment.law().map(|law| law.parameter()) else { continue };
        for (kind, wall, impacts) in [("pair", false, &outcome.pairs), ("wall", true, &outcome.walls)] {
            let summary = impacts.summary();
            let kappa = outcome.kinetic_theory(wall).map(|theory| theory.kappa);
            let over_kappa = |overlap: Option<f64>| Some(overlap? / kappa?);
            let temperature = outcome.temperature;
            let head = [
                temperature.map(|found| found.value),
                temperature.and_then(|found| found.error),
                Some(parameter.value),
                kappa,
            ];
            let tail = [
                summary.mean_maximum_overlap,
                impacts.maximum_overlap.standard_error(),
                over_kappa(summary.mean_maximum_overlap),
                summary.time_mean_overlap,
                over_kappa(summary.time_mean_overlap),
                summary.p99_maximum_overlap,
                summary.largest_overlap,
            ];
            let cells = [outcome.experiment.name.clone(), kind.into()].into_iter();
            table.row(cells.chain(head.map(number)).chain([summary.count.to_string()]).chain(tail.map(number)))?;
        }
    }
    table.bytes()
}

/// Contents of `budgets.csv`: terms of the budgets of the second moments of velocity [m²/s³]. There is one row per
/// moment and slice (layer of the box normal to y), with the centre y [m] of the slice. Rows with an empty cell `slice`
/// are means over all particles. Columns with `_se` contain one standard error.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn budgets(budgets: &Budgets) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head(
        "slice,y_m,moment,production,transport,drag,impacts,rest,\
         production_se,transport_se,drag_se,impacts_se,rest_se",
    )?;
    let slices = budgets.slices.iter().enumerate();
    let rows = slices.map(|(slice, (y, terms))| (slice.to_string(), number(*y), terms));
    for (slice, y, moments) in rows.chain([(String::new(), String::new(), &budgets.whole)]) {
        for ((name, ..), terms) in MOMENTS.into_iter().zip(moments) {
            let all = [terms.production, terms.transport, terms.drag, terms.impacts, terms.rest];
            let values = all.map(|term| number(term.value)).into_iter().chain(all.map(|term| number(term.error)));
            table.row([slice.clone(), y.clone(), name.into()].into_iter().chain(values))?;
        }
    }
    table.bytes()
}

fn histograms(impacts: &Impacts) -> [(&'static str, &'static str, &Histogram); 5] {
    [
        ("maximum_overlap", "1", &impacts.maximum_overlap),
        ("first_overlap", "1", &impacts.first_overlap),
        ("normal_speed", "m/s", &impacts.normal_speed),
        ("restitution", "1", &impacts.restitution),
        ("duration", "s", &impacts.duration),
    ]
}

/// Bin of a histogram: lower and upper end in the unit of the quantity, count, and probability density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HistogramRow {
    pub lower: f64,
    pub upper: f64,
    pub count: u64,
    /// Probability density, in one over the unit of the quantity; `None` for a bin of zero width.
    pub density: Option<f64>,
}

/// Bins of a histogram, from the first bin to the last bin that is not empty. The list is empty if the histogram has no
/// values. If all values are 0, the result is one bin of zero width.
pub(super) fn bins(histogram: &Histogram) -> Vec<HistogramRow> {
    if histogram.total == 0 {
        return Vec::new();
    }
    if histogram.width == 0.0 {
        return vec![HistogramRow { lower: 0.0, upper: 0.0, count: histogram.total, density: None }];
    }
    let used = histogram.counts.iter().rposition(|&count| count > 0).map_or(0, |last| last + 1);
    let area = histogram.total as f64 * histogram.width;
    let bin = |(k, &count): (usize, &u64)| HistogramRow {
        lower: k as f64 * histogram.width,
        upper: (k + 1) as f64 * histogram.width,
        count,
        density: Some(count as f64 / area),
    };
    histogram.counts[..used].iter().enumerate().map(bin).collect()
}

/// Contents of `state.csv`: ids, centres [m], velocities [m/s], spins [rad/s] of spheres that rotate, diameters [m] and
/// species names, in the order of the ids. Numbers have 17 significant digits, so that they are read without rounding.
/// Along periodic axes, centres are replaced by their images inside the box. Lines `# key: value` precede the table,
/// with the number of particles, a checksum, the pairs in `about`, and the box. Other programs skip these lines.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn state(particles: &Particles, scene: &Scene, about: &[(&str, String)]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    let mut particles = particles.clone();
    particles.wrap(&scene.domain);
    particles.sort_by_id();
    let names = std::iter::once("id").chain(particles.state_names()).chain(["diameter", "species"]);
    table.row(names.map(String::from))?;
    for place in 0..particles.len() {
        let index = particles.species[place];
        let species = scene.species.get(usize::from(index)).map_or_else(|| index.to_string(), |s| s.name.clone());
        let numbers = particles.state_numbers(place).into_iter().chain([2.0 * particles.radius[place]]);
        let id = std::iter::once(particles.id[place].to_string());
        table.row(id.chain(numbers.map(|value| format!("{value:.16e}"))).chain([species]))?;
    }
    let rows =
        String::from_utf8(table.bytes()?).map_err(|error| OutputError::Csv(std::io::Error::other(error).into()))?;
    let lines = about.iter().cloned().chain(saved::box_lines(&scene.domain));
    let head: String =
        lines.map(|(key, value)| format!("# {key}: {}\n", value.replace(char::is_control, " "))).collect();
    Ok(saved::sign(&(head + &rows), particles.len()).into_bytes())
}

/// Contents of `impact.csv`: the paths of the two bodies in the impact study. The gap [m] is negative while the bodies
/// overlap. The normal velocity [m/s] is negative while they approach each other. The closed-form solution for the
/// variant NAME has the name `NAME (analytic)`.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn bounces(bounces: &[Bounce]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head("variant,t_s,gap_m,normal_velocity_m_s")?;
    for bounce in bounces {
        let analytic = bounce.analytic.as_ref().map(|a| (format!("{} (analytic)", bounce.name), &a.path));
        for (name, path) in std::iter::once((bounce.name.clone(), &bounce.path)).chain(analytic) {
            for point in path {
                let numbers = [point.time, point.gap, point.normal_velocity];
                table.row(std::iter::once(name.clone()).chain(numbers.map(number)))?;
            }
        }
    }
    table.bytes()
}

/// Contents of `oblique.csv`: the reduced slip s/(μ u_n) [-] before and after oblique impacts, with slip s, coefficient
/// of friction μ and normal speed u_n. The rows of reference curves are the last.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn oblique(study: &ObliqueStudy) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head("variant,slip_before,slip_after")?;
    let curves = study.curves.iter().map(|curve| (curve.name.as_str(), curve.points.as_slice()));
    for (name, points) in curves.chain(study.references()) {
        for (before, after) in points {
            table.row([name.to_owned(), number(*before), number(*after)])?;
        }
    }
    table.bytes()
}

/// Contents of `chart.csv`: one row per point and quantity of the work-precision chart (error plotted against computing
/// cost). A failed point has a single row with the reason of the failure. Errors, uncertainties and floors (errors by
/// chance alone) are fractions [-]; other numbers are in the unit of the quantity.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn chart(study: &ChartStudy) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head(
        "method,knob,knob_value,samples,wall_seconds_median,wall_seconds_lowest,wall_seconds_highest,operations,\
         steps_all,force_evaluations_all,events_all,pair_checks_all,quantity,unit,value,lowest,highest,reference,\
         reference_se,error,error_se,floor,front_by_wall,front_by_operations,failure,failure_message",
    )?;
    let fronts: Vec<_> = (0..study.quantities.len())
        .map(|quantity| {
            [CostMeasure::Wall, CostMeasure::Work].map(|cost| study.front(quantity, cost, &[Model::Soft, Model::Hard]))
        })
        .collect();
    for (place, point) in study.points.iter().enumerate() {
        let method = &study.methods[point.method];
        let head = [method.name.clone(), method.knob.into(), number(point.knob), point.samples.to_string()];
        let wall = [point.wall.median, point.wall.lowest, point.wall.highest, point.work].map(number::<f64>);
        let c = &point.counters;
        let counts = [c.steps, c.force_evaluations, c.events, c.pair_checks].map(|count| count.to_string());
        let row: Vec<String> = head.into_iter().chain(wall).chain(counts).collect();
        if let Some(why) = &point.failure {
            // a failed point has no values in these columns
            let empty = vec![String::new(); 12];
            table.row(row.into_iter().chain(empty).chain([why.kind().into(), why.to_string()]))?;
            continue;
        }
        for (found, (quantity, front)) in point.errors.iter().zip(study.quantities.iter().zip(&fronts)) {
            let Some(found) = found else { continue };
            let reference = quantity.reference;
            let values = [
                Some(found.value),
                found.range.map(|range| range.0),
                found.range.map(|range| range.1),
                Some(reference.value),
                reference.error,
                Some(found.error),
                found.uncertainty,
                Some(quantity.floor),
            ];
            let cells = [quantity.key.into(), quantity.unit.into()].into_iter().chain(values.map(number));
            let marks = front.iter().map(|front| front.contains(&place).to_string());
            table.row(row.iter().cloned().chain(cells).chain(marks).chain([String::new(), String::new()]))?;
        }
    }
    table.bytes()
}

/// Names of the last two columns of every map (table of failures): the outcome of a point, and the message of a
/// failure.
const MAP_ENDS: [&str; 2] = ["outcome", "message"];

/// Contents of `sweep.csv`: one row per point (one value for each swept key) and variant (experiment of a case).
/// Numbers given for swept keys are in SI; other values are as typed. Columns with `_se` contain one standard error.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn sweep(study: &SweepStudy) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    let keys = study.axes.iter().map(|axis| axis.key.clone());
    let columns = OBSERVABLES.iter().flat_map(|one| [one.key.to_owned(), format!("{}_se", one.key)]);
    let names = ["variant", "replicas", "status", "wall_seconds", "runs"].map(str::to_owned);
    table.row(keys.chain(names).chain(columns))?;
    for row in study.rows {
        let point = study.axes.iter().zip(&row.at).map(|(axis, &at)| match &axis.numbers {
            Some(numbers) => number(numbers[at]),
            None => axis.typed[at].clone(),
        });
        let seconds = row.runs.iter().map(|run| run.wall_seconds).sum::<f64>();
        let facts = [
            study.variants[row.variant].clone(),
            row.identities.len().to_string(),
            row.status().to_owned(),
            number((!row.runs.is_empty()).then_some(seconds)),
            row.identities.join(" "),
        ];
        let numbers = OBSERVABLES.iter().flat_map(|one| {
            let found = row.measured(one.key);
            [number(found.map(|found| found.value)), number(found.and_then(|found| found.error))]
        });
        table.row(point.chain(facts).chain(numbers))?;
    }
    table.bytes()
}

/// Contents of `sensitivity.csv`: one row per factor (changed input) and observable. Scales, shifts and their standard
/// errors are in the unit of the observable. Columns with `over_scale` or `over_margin` in their names are [-]; the
/// margin is the largest accepted difference.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn sensitivity(study: &SensitivityStudy) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head(
        "factor,change,observable,unit,t_s,scale,shift,shift_se,degrees_of_freedom,shift_over_scale,shift_over_scale_se,\
         shift_over_margin,shift_over_margin_se,equivalent_within,verdict",
    )?;
    for factor in study.factors {
        for shift in &factor.shifts {
            let names = [factor.name.as_str(), &factor.change, &shift.observable, shift.unit].map(str::to_owned);
            let numbers = [
                shift.time,
                Some(shift.scale),
                Some(shift.difference),
                shift.error,
                shift.freedom,
                Some(shift.share()),
                shift.share_error(),
                Some(shift.share() / study.margin),
                shift.share_error().map(|error| error / study.margin),
                shift.reached,
            ];
            table.row(names.into_iter().chain(numbers.map(number)).chain([shift.answer.word().to_owned()]))?;
        }
    }
    table.bytes()
}

/// True if the text of a table is that of a map (table of the settings for which a method fails) made by [`limits`].
/// Other tables in the folder `maps` belong to the user.
pub fn is_map(table: &str) -> bool {
    table.lines().next().is_some_and(|header| header.ends_with(&MAP_ENDS.join(",")))
}

/// Contents of `maps/NAME.csv`, with one row per point of a map (table that shows where a method fails): the values of
/// the point, its outcome, and the message of a failure.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub fn limits(map: &Map) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head(&format!("{},{}", map.columns.join(","), MAP_ENDS.join(",")))?;
    for row in &map.rows {
        let message = row.failure.as_ref().map_or_else(String::new, ToString::to_string);
        let values = row.values.iter().copied().map(number);
        table.row(values.chain([row.outcome().into(), message]))?;
    }
    table.bytes()
}

/// Shortest text from which the same number can be read; empty for a number that is unknown or not finite.
pub(super) fn number<N: Into<Option<f64>>>(value: N) -> String {
    let Some(value) = value.into() else { return String::new() };
    match value.abs() {
        magnitude if !magnitude.is_finite() => String::new(),
        0.0 => "0".into(),
        magnitude if (1e-4..1e15).contains(&magnitude) => format!("{value}"),
        _ => format!("{value:e}"),
    }
}

/// CSV table that is built in memory.
pub(super) struct CsvTable(Writer<Vec<u8>>);

impl CsvTable {
    pub(super) fn new() -> Self {
        Self(Writer::from_writer(Vec::new()))
    }

    /// Adds the header of the table. `names` contains the names of the columns, separated by commas.
    pub(super) fn head(&mut self, names: &str) -> Result<(), OutputError> {
        Ok(self.0.write_record(names.split(','))?)
    }

    pub(super) fn row(&mut self, cells: impl IntoIterator<Item = String>) -> Result<(), OutputError> {
        Ok(self.0.write_record(cells.into_iter().map(legible::cell))?)
    }

    pub(super) fn bytes(self) -> Result<Vec<u8>, OutputError> {
        self.0.into_inner().map_err(|error| OutputError::Csv(error.into_error().into()))
    }
}
