//! Results of the impact study, as plain data for the outputs: one [`Bounce`] per variant. A variant is one of the
//! experiments of a case.

use super::Provenance;
use crate::engine::Failure;
use crate::experiment::Model;
use serde::Serialize;

/// State of the two bodies at one instant of an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// [s] simulated time since the start of the run.
    pub time: f64,
    /// [m] gap between the surfaces of the two bodies; negative while they overlap.
    pub gap: f64,
    /// [m/s] relative velocity of the two bodies along the normal; negative during approach.
    pub normal_velocity: f64,
}

/// Restitution, contact time and largest overlap of an impact; `None` for each of them if the impact did not end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BounceValues {
    /// [-] restitution, the ratio of the rebound speed to the approach speed; `None` if the impact did not end.
    pub restitution: Option<f64>,
    /// [s] duration of the contact; 0 for an instantaneous collision, `None` if the impact did not end.
    pub contact_time: Option<f64>,
    /// [m] largest overlap; 0 for an instantaneous collision of hard spheres, `None` if the impact did not end.
    pub maximum_overlap: Option<f64>,
}

/// Closed-form solution for the impact of one variant (experiment of a case).
#[derive(Clone, Debug, PartialEq)]
pub struct Analytic {
    /// Path of the two bodies by the closed-form solution.
    pub path: Vec<PathPoint>,
    /// Restitution, contact time and largest overlap by the closed-form solution.
    pub values: BounceValues,
}

/// Impact of two bodies as computed by one variant (experiment of a case) of the impact study.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounce {
    /// Name of the variant (experiment of a case).
    pub name: String,
    /// Collision model with which the impact was computed.
    pub model: Model,
    /// Computed path of the two bodies.
    pub path: Vec<PathPoint>,
    /// Restitution, contact time and largest overlap of the computed impact.
    pub values: BounceValues,
    /// Closed-form solution for the parameters of this experiment; `None` if there is no such solution.
    pub analytic: Option<Analytic>,
    /// [s] time step of the run; `None` for event-driven collisions.
    pub time_step: Option<f64>,
    /// Number of time steps or events that the run needed.
    pub work: u64,
    /// [s] wall-clock time of the run of the impact.
    pub wall_seconds: f64,
    /// All parameters of the experiment in SI, as written to `summary.json`.
    pub parameters: serde_json::Value,
    /// Reason why the run stopped early; `None` if it ended regularly.
    pub failure: Option<Failure>,
}

/// Curve of one variant (experiment of a case): the reduced slip after oblique impacts as a function of the reduced
/// slip before them. The reduced slip is s/(μ u_n), with slip s, coefficient of friction μ and normal speed u_n.
#[derive(Clone, Debug, PartialEq)]
pub struct ObliqueCurve {
    /// Name of the variant (experiment of a case) to which the curve belongs.
    pub name: String,
    /// Reduced slip s/(μ u_n) before and after the impact [-], with slip s, coefficient of friction μ and normal speed
    /// u_n.
    pub points: Vec<(f64, f64)>,
}

/// Results for oblique impacts of the two bodies of an impact study.
#[derive(Clone, Debug, PartialEq)]
pub struct ObliqueStudy {
    /// Curves of the reduced slip, one for each variant (experiment of a case).
    pub curves: Vec<ObliqueCurve>,
    /// Measured reduced slip s/(μ u_n) of solid spheres before and after the impact [-], with slip s, coefficient of
    /// friction μ and normal speed u_n. The list is empty for other bodies.
    pub measured: Vec<(f64, f64)>,
    /// Reduced slip s/(μ u_n) before and after elastic impacts in which only the edge of the contact circle slips [-]
    /// ([`PartialSlip`](crate::rotation::PartialSlip)). Here s is the slip, μ the coefficient of friction and u_n the
    /// normal speed. The list is empty if the contact law has no elastic constants.
    pub partial_slip: Vec<(f64, f64)>,
    /// [-] change of the reduced slip by the friction impulse of an impact that slides to its end: (1+e) M/M_t, with
    /// the restitution e, the effective mass M of the two bodies, and the effective mass M_t of their slip (tangential
    /// impulse divided by the change of the slip). No impact changes the reduced slip by more.
    pub impulse: f64,
}

impl ObliqueStudy {
    /// Reference points and curves that are not results of this program, with their labels.
    pub fn references(&self) -> [(&'static str, &[(f64, f64)]); 2] {
        [
            ("measured (Kharaz et al. 2001)", &self.measured),
            ("partial slip, e = 1 (Maw et al. 1976)", &self.partial_slip),
        ]
    }

    /// Largest difference [-] between the curve with the index `curve` and the first curve, divided by
    /// [`impulse`](Self::impulse), and the reduced slip before the impact at this difference. `None` if the two curves
    /// have no points with equal slip before the impact.
    pub fn difference(&self, curve: usize) -> Option<(f64, f64)> {
        let (first, other) = (self.curves.first()?, self.curves.get(curve)?);
        let off = |(at, after): &(f64, f64)| {
            let (_, reference) = first.points.iter().find(|(slip, _)| slip == at)?;
            Some(((after - reference).abs() / self.impulse, *at))
        };
        other.points.iter().filter_map(off).max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// All data of an impact study for its outputs.
#[derive(Clone, Copy, Debug)]
pub struct ImpactStudy<'a> {
    /// Origin of the results: title, case and command.
    pub provenance: &'a Provenance,
    /// Computed impacts, one for each variant (experiment of a case).
    pub bounces: &'a [Bounce],
    /// [-] restitution that the case prescribes for the impact.
    pub requested_restitution: f64,
    /// Oblique impacts of the two bodies. `None` if spheres do not rotate or have no friction.
    pub oblique: Option<&'a ObliqueStudy>,
    /// [m] diameter by which the overlaps of the study are divided.
    pub diameter: f64,
    /// [m/s] normal speed of approach of the two bodies.
    pub impact_speed: f64,
    /// Answers in sentences: one per variant (experiment of a case), then those on oblique impacts. The page begins
    /// with these sentences.
    pub verdicts: &'a [String],
    /// Remarks on how far the numbers are reliable, one sentence each.
    pub notes: &'a [String],
}
