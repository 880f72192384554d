//! The pictures, as SVG text 640 px wide.
//!
//! All share the style of one file. Bands show one standard error. A variant keeps its colour, dash and marker in every
//! picture; what cannot be drawn is left out, and a panel without points says so.

mod bounces;
mod cells;
mod chart;
mod impacts;
mod limits;
mod profiles;
mod work_precision;

pub use bounces::{normal_velocity, overlap_in_time};
pub use impacts::{impact_speed, overlap};
pub use limits::limits;
pub use profiles::{differences, number_density, second_moments, streamwise_velocity};
pub use work_precision::work_precision;

use super::{Bounce, cost, reference};
use crate::outcome::Outcome;

/// A picture with its place in the folder and what it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// File name without `.svg`.
    pub name: String,
    /// What is to be seen, in a sentence or two.
    pub caption: String,
    /// The picture.
    pub svg: String,
}

impl Figure {
    fn new(name: impl Into<String>, caption: impl Into<String>, svg: String) -> Self {
        Self { name: name.into(), caption: caption.into(), svg }
    }
}

/// The pictures of a run or comparison, in the order of a page.
pub fn study(outcomes: &[Outcome]) -> Vec<Figure> {
    let against = outcomes.get(reference(outcomes)).map_or("", |outcome| outcome.experiment.name.as_str());
    let mut figures = vec![
        Figure::new(
            "number-density",
            "Number density over its mean. Band: one standard error. No centre can be nearer to a wall than one radius; slices at \
             walls are not corrected for it.",
            number_density(outcomes),
        ),
        Figure::new(
            "streamwise-velocity",
            "Mean streamwise velocity. Band: one standard error.",
            streamwise_velocity(outcomes),
        ),
        Figure::new(
            "second-moments",
            "Second moments of the velocity fluctuations: u streamwise, v wall-normal, w spanwise.",
            second_moments(outcomes),
        ),
    ];
    if outcomes.len() > 1 {
        figures.push(Figure::new(
            "differences",
            format!(
                "Difference from “{against}” in standard errors of the difference. Where only chance differs, about 3 in \
                 1000 points lie beyond the lines at ±3."
            ),
            differences(outcomes),
        ));
        figures.push(Figure::new("cost", "Wall-clock time per simulated second.", cost_bars(outcomes)));
    }
    figures.push(Figure::new(
        "impact-speed",
        "Probability density of the normal speed of approach.",
        impact_speed(outcomes),
    ));
    if outcomes.iter().any(|outcome| {
        let of = |impacts: &crate::record::Impacts| impacts.maximum_overlap.maximum;
        of(&outcome.record.pairs).max(of(&outcome.record.walls)) > impacts::ROUNDING
    }) {
        figures.push(Figure::new(
            "overlap",
            "Probability density of the largest overlap of each impact, over the diameter; an empty bin stands at half a \
             count. Collisions at exact instants have none.",
            overlap(outcomes),
        ));
    }
    figures
}

/// The pictures of an impact study.
pub fn impact(bounces: &[Bounce]) -> Vec<Figure> {
    vec![
        Figure::new(
            "overlap-in-time",
            "Overlap during the impact; below zero the surfaces are apart.",
            overlap_in_time(bounces),
        ),
        Figure::new(
            "normal-velocity",
            "Relative velocity along the normal; negative while approaching.",
            normal_velocity(bounces),
        ),
    ]
}

/// Wall-clock time per simulated time, a bar per variant.
pub fn cost_bars(outcomes: &[Outcome]) -> String {
    let values: Vec<_> = outcomes.iter().map(|outcome| (outcome.experiment.name.clone(), cost(outcome))).collect();
    chart::bars("wall-clock seconds per simulated second", &values)
}
