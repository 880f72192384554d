//! What the impact study hands to the outputs: plain data, one [`Bounce`] per variant.

use super::Provenance;
use crate::engine::Failure;
use crate::experiment::Model;
use serde::Serialize;

/// One instant of an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// [s] time.
    pub time: f64,
    /// [m] surface to surface; negative while they overlap.
    pub gap: f64,
    /// [m/s] relative velocity along the normal; negative while they approach.
    pub normal_velocity: f64,
}

/// What an impact did, in three numbers; `None` if none ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BounceValues {
    /// [-] rebound over approach speed.
    pub restitution: Option<f64>,
    /// [s] time in contact; 0 for a collision.
    pub contact_time: Option<f64>,
    /// [m] largest overlap; 0 for a collision.
    pub maximum_overlap: Option<f64>,
}

/// The closed-form answer for one variant.
#[derive(Clone, Debug, PartialEq)]
pub struct Analytic {
    /// Its path.
    pub path: Vec<PathPoint>,
    /// Its numbers.
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
    /// Steps or events until the spheres were apart again.
    pub work: u64,
    /// [s] wall-clock time of the impact.
    pub wall_seconds: f64,
    /// Every resolved parameter in SI, as it goes into `summary.json`.
    pub parameters: serde_json::Value,
    /// Why it stopped early, if it did.
    pub failure: Option<Failure>,
}

/// Everything outputs need to know of an impact study.
#[derive(Clone, Copy, Debug)]
pub struct ImpactStudy<'a> {
    /// Where it comes from.
    pub provenance: &'a Provenance,
    /// One per variant.
    pub bounces: &'a [Bounce],
    /// [-] the restitution the case asks for.
    pub requested_restitution: f64,
    /// [m] diameter that overlaps are compared with.
    pub diameter: f64,
    /// [m/s] normal speed of approach.
    pub impact_speed: f64,
    /// The answer in sentences, the shortest first; it heads the page.
    pub verdicts: &'a [String],
    /// What limits how far the numbers can be trusted, a sentence each.
    pub notes: &'a [String],
}
