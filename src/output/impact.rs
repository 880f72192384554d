//! Results of the impact study, as plain data for the outputs: one [`Bounce`] per variant.

use super::Provenance;
use crate::engine::Failure;
use crate::experiment::Model;
use serde::Serialize;

/// One instant of an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// [s] time.
    pub time: f64,
    /// [m] gap between the surfaces; negative while they overlap.
    pub gap: f64,
    /// [m/s] relative velocity along the normal; negative during approach.
    pub normal_velocity: f64,
}

/// Result of an impact in three numbers; `None` if it did not end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BounceValues {
    /// [-] rebound speed over approach speed.
    pub restitution: Option<f64>,
    /// [s] time in contact; 0 for a collision.
    pub contact_time: Option<f64>,
    /// [m] largest overlap; 0 for an instantaneous collision of hard spheres, `None` if the impact did not end.
    pub maximum_overlap: Option<f64>,
}

/// The closed-form answer for one variant.
#[derive(Clone, Debug, PartialEq)]
pub struct Analytic {
    /// Path of the spheres.
    pub path: Vec<PathPoint>,
    /// Result in numbers.
    pub values: BounceValues,
}

/// One variant of the impact study.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounce {
    /// Name of the variant.
    pub name: String,
    /// The engine of the variant.
    pub model: Model,
    /// The path as computed.
    pub path: Vec<PathPoint>,
    /// The numbers as computed.
    pub values: BounceValues,
    /// The closed form for the same parameters, if there is one.
    pub analytic: Option<Analytic>,
    /// [s] time step; `None` for events.
    pub time_step: Option<f64>,
    /// Number of steps or events until the spheres were apart again.
    pub work: u64,
    /// [s] wall-clock time of the impact.
    pub wall_seconds: f64,
    /// Every resolved parameter in SI, as written to `summary.json`.
    pub parameters: serde_json::Value,
    /// Reason of an early stop, if there was one.
    pub failure: Option<Failure>,
}

/// Slip after oblique impacts under one variant.
#[derive(Clone, Debug, PartialEq)]
pub struct ObliqueCurve {
    /// Name of the variant.
    pub name: String,
    /// Reduced slip s/(μ u_n) before and after the impact [-].
    pub points: Vec<(f64, f64)>,
}

/// Oblique impacts of the two bodies of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct ObliqueStudy {
    /// One per variant.
    pub curves: Vec<ObliqueCurve>,
    /// Measured points of solid spheres, likewise; none for other bodies.
    pub measured: Vec<(f64, f64)>,
    /// [-] change of the reduced slip by the largest friction impulse, (1+e) M/M_t.
    pub impulse: f64,
}

impl ObliqueStudy {
    /// Largest difference of a curve from the first one, over the change by the largest friction impulse [-], and the
    /// reduced slip at which it is found.
    pub fn difference(&self, curve: usize) -> Option<(f64, f64)> {
        let (first, other) = (self.curves.first()?, self.curves.get(curve)?);
        let off = |(at, after): &(f64, f64)| {
            let (_, reference) = first.points.iter().find(|(slip, _)| slip == at)?;
            Some(((after - reference).abs() / self.impulse, *at))
        };
        other.points.iter().filter_map(off).max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// All data of an impact study that outputs need.
#[derive(Clone, Copy, Debug)]
pub struct ImpactStudy<'a> {
    /// Origin of the results.
    pub provenance: &'a Provenance,
    /// One per variant.
    pub bounces: &'a [Bounce],
    /// [-] restitution given in the case.
    pub requested_restitution: f64,
    /// Oblique impacts of the two bodies, where spheres rotate.
    pub oblique: Option<&'a ObliqueStudy>,
    /// [m] diameter that overlaps are compared with.
    pub diameter: f64,
    /// [m/s] normal speed of approach.
    pub impact_speed: f64,
    /// The answer in sentences, the shortest first; it heads the page.
    pub verdicts: &'a [String],
    /// Limits of the reliability of the numbers, a sentence each.
    pub notes: &'a [String],
}
