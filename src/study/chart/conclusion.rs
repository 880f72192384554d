//! Sentences that conclude a chart of precision against cost, made from the numbers of the chart.

use crate::experiment::Model;
use crate::output::numbers::{count, quantity as with_prefix, significant};
use crate::output::{ChartMethod, ChartPoint, ChartQuantity, ChartSlope, CostMeasure, cheapest};
use crate::statistics::power_law;

/// [-] relative errors for which the cheapest method is named, each with its text in the sentence.
const TARGETS: [(f64, &str); 2] = [(0.01, "1 %"), (0.001, "0.1 %")];
/// Number of standard errors of a result up to which the error of a method is attributed to chance.
const RESOLVED: f64 = 3.0;
/// [-] relative error below which an error of a method is attributed to rounding. Positions of about 1 mm have a
/// rounding error of about 1e-19 m, which is at most 1e-13 of an overlap of some micrometres.
const ROUNDING: f64 = 1e-12;
/// Largest number of points through which the order of convergence is fitted. The fit uses the points with the finest
/// parameters whose errors exceed chance and rounding.
const ASYMPTOTIC: usize = 5;
/// [-] smallest slope of ln(error) over ln(parameter) that is reported as an order of convergence. With a smaller
/// slope, the error does not come from the parameter that is varied.
const FLAT: f64 = 0.1;

/// Order of convergence of each method in each quantity: slope of ln(error) as a function of ln(parameter of the
/// method). The fit uses the three, four or five points with the finest parameters, whichever number gives the smallest
/// standard error of the slope. Only errors of one sign that exceed chance and rounding are used.
pub fn slopes(quantities: &[ChartQuantity], methods: usize, points: &[ChartPoint]) -> Vec<ChartSlope> {
    let mut slopes = Vec::new();
    for (index, quantity) in quantities.iter().enumerate() {
        for method in 0..methods {
            let resolved = resolved(points.iter().filter(|point| point.method == method), index, quantity);
            let ranges = (3..=ASYMPTOTIC.min(resolved.len())).map(|count| &resolved[resolved.len() - count..]);
            let fits = ranges.filter_map(|range| Some((power_law(range)?, range)));
            let best = fits.min_by(|a, b| a.0.error.total_cmp(&b.0.error));
            if let Some((law, [first, .., last])) = best {
                slopes.push(ChartSlope { method, quantity: index, law, range: (first.0, last.0) });
            }
        }
    }
    slopes
}

/// Points of one method whose errors exceed chance and rounding, from coarse to fine parameters. Each has the value of
/// the parameter and the relative error. Points before the last change of the sign of the error are left out. `index`
/// is the index of the quantity.
fn resolved<'a>(
    points: impl Iterator<Item = &'a ChartPoint>,
    index: usize,
    quantity: &ChartQuantity,
) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    let mut sign = 0.0;
    for (knob, found) in points.filter_map(|point| Some((point.knob, point.errors.get(index).copied().flatten()?))) {
        let chance = found.uncertainty.map_or(quantity.floor, |uncertainty| uncertainty.max(quantity.floor));
        if found.error <= ROUNDING || found.error <= RESOLVED * chance {
            continue;
        }
        let now = (found.value - quantity.reference.value).signum();
        if now != sign {
            kept.clear();
            sign = now;
        }
        kept.push((knob, found.error));
    }
    kept
}

/// Name of a point of the chart for a sentence: its method, and the value of the varied parameter with its unit.
pub fn name(methods: &[ChartMethod], point: &ChartPoint) -> String {
    let method = &methods[point.method];
    let value = if method.unit == "s" { with_prefix(point.knob, "s", 3) } else { significant(point.knob, 3) };
    let unit = if method.unit.is_empty() || method.unit == "s" { String::new() } else { format!(" {}", method.unit) };
    format!("{} ({} = {value}{unit})", method.name, method.knob)
}

/// Sentences for the chart: the cheapest method with an error of at most 1 % and 0.1 % in each quantity, the orders of
/// convergence, and the failures.
pub fn sentences(
    methods: &[ChartMethod],
    quantities: &[ChartQuantity],
    points: &[ChartPoint],
    slopes: &[ChartSlope],
) -> Vec<String> {
    let mut sentences = Vec::new();
    for (index, quantity) in quantities.iter().enumerate() {
        let answers: Vec<String> =
            TARGETS.iter().map(|target| within(methods, quantity, points, index, *target)).collect();
        let mut sentence = format!("{}: {}", capital(quantity.name), answers.join("; "));
        let fits: Vec<String> = slopes
            .iter()
            .filter(|slope| slope.quantity == index && slope.law.exponent.abs() > FLAT.max(RESOLVED * slope.law.error))
            .map(|slope| fit(methods, slope))
            .collect();
        if !fits.is_empty() {
            sentence += &format!(". Errors go as {}", fits.join(", "));
        }
        sentences.push(sentence + ".");
    }
    let failed: Vec<String> = points
        .iter()
        .filter_map(|point| Some(format!("{}: {}", name(methods, point), point.failure.as_ref()?.kind())))
        .collect();
    if !failed.is_empty() {
        sentences.push(format!("Failed: {}.", failed.join("; ")));
    }
    sentences
}

fn within(
    methods: &[ChartMethod],
    quantity: &ChartQuantity,
    points: &[ChartPoint],
    index: usize,
    (target, words): (f64, &str),
) -> String {
    if quantity.floor > target {
        let floor = significant(100.0 * quantity.floor, 2);
        return format!("within {words} nothing can be told, since chance alone moves one run by {floor} %");
    }
    let all = [Model::Soft, Model::Hard];
    let Some((model, first)) = cheapest_of(methods, points, index, target, &all) else {
        return format!("nothing stays within {words} for certain");
    };
    // hard spheres may give a quantity exactly by construction; the cheapest soft method is named in addition
    let soft = match (model, cheapest_of(methods, points, index, target, &[Model::Soft])) {
        (Model::Soft, _) => String::new(),
        (Model::Hard | Model::Hybrid | Model::Dsmc, Some((_, text))) => format!("; of soft methods {text}"),
        (Model::Hard | Model::Hybrid | Model::Dsmc, None) => ", and no soft method for certain".into(),
    };
    format!("within {words} the cheapest is {first}{soft}")
}

/// Model of the method that reaches the relative error `target` [-] with the fewest operations, and the cost of this
/// method as text. The error is that in the quantity with the index `index`. The text also names the method with the
/// least wall time. `None` if no method of `models` certainly reaches the target.
fn cheapest_of(
    methods: &[ChartMethod],
    points: &[ChartPoint],
    index: usize,
    target: f64,
    models: &[Model],
) -> Option<(Model, String)> {
    let least = |cost: CostMeasure| cheapest((methods, points), index, target, cost, models);
    let (by_work, by_wall) = (least(CostMeasure::Work)?, least(CostMeasure::Wall)?);
    let counts = count(by_work.work.round() as u64);
    let time = with_prefix(by_wall.wall.median, "s", 2);
    let text = if std::ptr::eq(by_wall, by_work) {
        format!("{}: {counts} operations, {time}", name(methods, by_work))
    } else {
        format!("{}: {counts} operations (by wall time {}: {time})", name(methods, by_work), name(methods, by_wall))
    };
    let given = by_work.error(index).is_some_and(|error| error <= ROUNDING);
    Some((methods[by_work.method].model, if given { text + ", exact by construction" } else { text }))
}

fn fit(methods: &[ChartMethod], slope: &ChartSlope) -> String {
    let method = &methods[slope.method];
    let exponent = slope.exponent();
    format!("{}^({exponent}) for {}", method.knob, method.name)
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
