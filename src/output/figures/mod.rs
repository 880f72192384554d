//! Pictures of results, as SVG text.
//!
//! All pictures except those of the module `overview` have the style of the file `chart.rs` and a width of 640 px.
//! Bands show one standard error. A variant has the same colour, dash pattern and marker in every picture of up to six
//! variants. Values that cannot be drawn are left out. A panel without points contains the text "nothing recorded". A
//! variant is one of the experiments of a case.

mod bounces;
mod budgets;
mod cells;
mod chart;
mod files_study;
mod gas;
mod geometry;
mod impacts;
mod limits;
mod map;
mod measurements;
mod over_time;
mod overview;
mod profiles;
mod rows;
mod sensitivity;
mod sweep;
mod validation;
mod work_precision;

pub use bounces::{normal_velocity, overlap_in_time, slip_after};
pub use budgets::budgets;
pub use files_study::files_study;
pub use gas::{CHANNEL_DNS, gas, gases, loaded_flows};
pub use geometry::geometry;
pub(super) use impacts::ROUNDING;
pub use impacts::{first_overlap, impact_speed, mean_overlap, overlap};
pub use limits::limits;
pub use measurements::{measurements, of_measurement};
pub use over_time::over_time;
pub(super) use overview::{COST, IN_PER_CENT, in_per_cent, quantities, symbol};
pub use profiles::{differences, number_density, second_moments, spins, streamwise_velocity};
pub use sensitivity::sensitivity;
pub use sweep::sweep;
pub use validation::validation;
pub use work_precision::{WITHIN, work_precision};

pub use super::panel::Figure;
use super::{Bounce, ObliqueStudy, Study, references};
use crate::case::saved;
use crate::outcome::Outcome;
use crate::record::{Histogram, Impacts};

/// Figures at the top of the page of a comparison: the differences and the cost. The list is empty for a single run.
pub fn glance(study: &Study) -> Vec<Figure> {
    overview::differences(study).into_iter().chain(overview::cost(study)).collect()
}

/// Figures of the averages and of the impacts of a run or comparison, in the order of the page.
pub fn study(outcomes: &[Outcome]) -> Vec<Figure> {
    let mut figures = vec![
        Figure::new(
            "number-density",
            "Number density over its mean. Band: one standard error. No centre can be nearer to a wall than one radius: slices at \
             walls are divided by the part of them that centres can be in (profiles.csv holds them as they were counted).",
            number_density(outcomes),
        ),
        Figure::new(
            "streamwise-velocity",
            "Mean streamwise velocity of the particles. Band: one standard error.",
            streamwise_velocity(outcomes),
        ),
    ];
    figures.extend(profiles::beside_the_gas(outcomes).map(|svg| {
        Figure::new(
            "streamwise-velocity-and-gas",
            "Mean streamwise velocity of the particles beside that of the gas.",
            svg,
        )
    }));
    figures.extend(gas::loaded(outcomes));
    let caption = "Second moments of the velocity fluctuations: u streamwise, v wall-normal, w spanwise.";
    figures.extend(of_groups("second-moments", caption, second_moments(outcomes)));
    let caption =
        "Mean spins Ω, and the parts of the rotational temperature T_r: x spanwise, y wall-normal, z streamwise.";
    figures.extend(of_groups("spins", caption, spins(outcomes)));
    if references(outcomes).into_iter().enumerate().any(|(place, reference)| place != reference) {
        figures.push(Figure::new(
            "differences",
            "Differences in standard errors of the difference. Where only chance differs, about 3 in 1000 points lie beyond the \
             lines at ±3.",
            differences(outcomes),
        ));
    }
    figures.push(Figure::new(
        "impact-speed",
        "Probability density of the normal speed of approach.",
        impact_speed(outcomes),
    ));
    figures.extend(overlaps(outcomes));
    figures
}

/// Makes one figure from each picture. Each entry of `pictures` is a title and the picture as SVG. The title names the
/// group of experiments that are drawn in the picture; it is empty if there is only one group.
fn of_groups(
    name: &'static str,
    caption: &'static str,
    pictures: Vec<(String, String)>,
) -> impl Iterator<Item = Figure> {
    pictures.into_iter().map(move |(title, svg)| {
        if title.is_empty() {
            return Figure::new(name, caption, svg);
        }
        Figure::new(format!("{name}-{}", file_name(&title)), format!("{title}. {caption}"), svg)
    })
}

/// Figures of the overlaps in impacts; an empty list if no impact has an overlap.
fn overlaps(outcomes: &[Outcome]) -> Vec<Figure> {
    let mut figures = Vec::new();
    let any = |of: fn(&Impacts) -> &Histogram| {
        outcomes.iter().any(|outcome| of(&outcome.pairs).maximum.max(of(&outcome.walls).maximum) > ROUNDING)
    };
    if any(|impacts| &impacts.maximum_overlap) {
        figures.push(Figure::new(
            "overlap",
            "Largest overlap of each impact over the diameter (of unequal spheres the smaller one): probability density, where an empty bin stands at half a count, \
             and share of the impacts below. Collisions at exact instants have none.",
            overlap(outcomes),
        ));
    }
    if any(|impacts| &impacts.first_overlap) {
        figures.push(Figure::new(
            "first-overlap",
            "Overlap at which each impact was first seen, over the diameter (of unequal spheres the smaller one): probability density, and share of the impacts \
             below. Contacts that begin at their exact instants have none.",
            first_overlap(outcomes),
        ));
    }
    if let Some(svg) = mean_overlap(outcomes) {
        figures.push(Figure::new(
            "mean-overlap",
            "Mean overlaps over κ_n d, κ_n = u_r/(ω_0 d) with u_r from the granular temperature of the same run. In a Maxwellian gas \
             the mean of the largest overlaps is π/2 κ_n d, the mean over the time of contact κ_n d.",
            svg,
        ));
    }
    figures
}

/// [byte] largest length of the part of a file name that is made from a title. File systems allow 255 bytes for the
/// whole name.
const LONGEST_NAME: usize = 100;

/// Converts a title to a part of a file name: ASCII letters and digits in lower case, and one hyphen in place of other
/// characters between them. Long titles are cut, and a checksum of the whole title is added.
pub fn file_name(title: &str) -> String {
    let letters = title.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { ' ' });
    let mut name = letters.collect::<String>().split_whitespace().collect::<Vec<_>>().join("-");
    if name.len() > LONGEST_NAME {
        let sum = format!("-{:016x}", saved::fingerprint(title));
        name.truncate(LONGEST_NAME - sum.len());
        name += &sum;
    }
    name
}

/// Figures of an impact study: overlap and normal velocity over time, and the slip after oblique impacts if they were
/// computed.
pub fn impact(bounces: &[Bounce], oblique: Option<&ObliqueStudy>) -> Vec<Figure> {
    let slip = oblique.map(|study| {
        let caption = "Oblique impacts without spin: slip after against slip before, both over μ u_n. On the line of slope 1 nothing changes; below zero the slip is reversed.";
        Figure::new("oblique", caption, slip_after(study))
    });
    let normal = vec![
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
    ];
    normal.into_iter().chain(slip).collect()
}
