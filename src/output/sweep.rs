//! Results of a sweep, which runs a case with several values of some of its keys, as plain data: the runs, and one row
//! per point and variant. A variant is one of the experiments of a case, and a point is one value for each varied key.

use super::{Provenance, figures};
use crate::case::SweepAxis;
use crate::outcome::Outcome;
use crate::statistics::{Estimate, NUMBER_DENSITY, U};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Quantity that is measured in every run of a sweep.
pub struct SweepObservable {
    /// Name of the column in `sweep.csv`, with the unit.
    pub key: &'static str,
    /// Name of the quantity in a sentence.
    pub name: &'static str,
    /// Label of the axis of this quantity in pictures, with the unit.
    pub axis: &'static str,
    /// True for an average over time. The error of an average is valid only for a steady run whose
    /// particles change their places often.
    pub is_average: bool,
    /// Function that computes the quantity from an outcome, or returns `None` if the outcome does not contain it.
    pub of: fn(&Outcome) -> Option<Estimate>,
}

/// [m/s] mean streamwise velocity of all particles, computed from the means in slices (layers of the box, one above the
/// other along y). The correlation between slices is unknown. The standard error is therefore computed for full
/// correlation, which gives the largest possible error. `None` if no slice has a value.
fn velocity(outcome: &Outcome) -> Option<Estimate> {
    let (mut sum, mut error, mut weights) = (0.0, Some(0.0), 0.0);
    for row in &outcome.profiles.slices {
        let (Some(density), Some(mean)) = (row.of(NUMBER_DENSITY), row.of(U)) else { continue };
        sum += density.value * mean.value;
        error = error.zip(mean.error).map(|(sum, error)| sum + density.value * error);
        weights += density.value;
    }
    (weights > 0.0).then(|| Estimate { value: sum / weights, error: error.map(|error| error / weights) })
}

/// Quantities measured in every run of a sweep, in the order of columns and pictures.
pub const OBSERVABLES: [SweepObservable; 9] = [
    SweepObservable {
        key: "pair_impacts_1_s",
        name: "pair impacts per time",
        axis: "pair impacts per time  [1/s]",
        is_average: true,
        of: |o| o.pair_rate,
    },
    SweepObservable {
        key: "wall_impacts_1_s",
        name: "wall impacts per time",
        axis: "wall impacts per time  [1/s]",
        is_average: true,
        of: |o| o.wall_rate,
    },
    SweepObservable {
        key: "temperature_m2_s2",
        name: "granular temperature",
        axis: "granular temperature  [m²/s²]",
        is_average: true,
        of: |o| o.temperature,
    },
    SweepObservable {
        key: "velocity_m_s",
        name: "mean streamwise velocity",
        axis: "mean streamwise velocity  [m/s]",
        is_average: true,
        of: velocity,
    },
    SweepObservable {
        key: "shear_stress_Pa",
        name: "shear stress of a sheared box",
        axis: "shear stress of a sheared box  [Pa]",
        is_average: true,
        of: |o| o.averaged.shear_stress.as_ref()?.estimate(),
    },
    SweepObservable {
        key: "pair_restitution",
        name: "realised restitution of pairs",
        axis: "realised restitution of pairs  [–]",
        is_average: false,
        of: |o| o.pair_restitution,
    },
    SweepObservable {
        key: "wall_restitution",
        name: "realised restitution at walls",
        axis: "realised restitution at walls  [–]",
        is_average: false,
        of: |o| o.wall_restitution,
    },
    SweepObservable {
        key: "mean_overlap",
        name: "mean largest overlap of pairs",
        axis: "mean largest overlap over the diameter  [–]",
        is_average: false,
        // event-driven collisions have no overlap, except for rounding errors
        of: |o| {
            let mean = o.pairs.summary().mean_maximum_overlap?;
            (mean > figures::ROUNDING).then(|| Estimate::without_error(mean))
        },
    },
    SweepObservable {
        key: "cost_s_s",
        name: "wall time per simulated time",
        axis: "wall time per simulated time  [s/s]",
        is_average: false,
        of: |o| super::cost(o).map(Estimate::without_error),
    },
];

/// Result of one run of a sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SweepRun {
    /// Hash of the experiment and of the version of the program. Runs with equal hashes have equal results.
    pub identity: String,
    /// Measured values, each under the name [`SweepObservable::key`] of its quantity. Unknown values are left out. A
    /// run that stopped early has no values.
    pub measured: BTreeMap<String, Estimate>,
    /// Reason why the run stopped early; `None` if it ended regularly.
    pub failure: Option<String>,
    /// [s] wall-clock time of the run.
    pub wall_seconds: f64,
}

/// Row of a sweep: one variant (experiment of a case) at one point, which is one value for each varied key.
pub struct SweepRow {
    /// Index of the value on each axis (varied key). These indices define the point of the sweep.
    pub at: Vec<usize>,
    /// Index, in [`SweepStudy::variants`], of the variant (experiment of a case) of this row.
    pub variant: usize,
    /// Hashes of the runs of this row (one experiment of the case at one point), one per replica (run with another
    /// seed). A run may belong to several rows.
    pub identities: Vec<String>,
    /// Results of the finished runs of this row (one experiment of the case at one point of the sweep).
    pub runs: Vec<SweepRun>,
}

impl SweepRow {
    /// Value, in this row, of the quantity whose [`SweepObservable::key`] is `key`. If there are several replicas (runs
    /// with different seeds), the value is their mean, with a standard error computed from their scatter. `None` if no
    /// run is finished, or if the value is unknown in one of the runs, as in a run that stopped early.
    pub fn measured(&self, key: &str) -> Option<Estimate> {
        let found: Option<Vec<Estimate>> = self.runs.iter().map(|run| run.measured.get(key).copied()).collect();
        let found = found?;
        if let [one] = found.as_slice() {
            return Some(*one);
        }
        let count = found.len() as f64;
        let mean = found.iter().map(|one| one.value).sum::<f64>() / count;
        let variance = found.iter().map(|one| (one.value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        (!found.is_empty()).then_some(Estimate { value: mean, error: Some((variance / count).sqrt()) })
    }

    /// Reason why a run of this row (one experiment of the case at one point of the sweep) stopped early; `None` if all
    /// runs ended.
    pub fn failure(&self) -> Option<&str> {
        self.runs.iter().find_map(|run| run.failure.as_deref())
    }

    /// Status of this row (one experiment of the case at one point of the sweep): "complete", "failed" or "not run
    /// yet".
    pub fn status(&self) -> &'static str {
        match (self.failure(), self.runs.len() < self.identities.len()) {
            (Some(_), _) => "failed",
            (None, true) => "not run yet",
            (None, false) => "complete",
        }
    }
}

/// All results of a sweep.
pub struct SweepStudy<'a> {
    /// Origin of the results: title, case and command.
    pub provenance: &'a Provenance,
    /// Keys (settings) of the case that the sweep varies, with their values.
    pub axes: &'a [SweepAxis],
    /// Names of the variants (experiments of a case) that run at each point of the sweep.
    pub variants: &'a [String],
    /// Index of the first variant (experiment of a case) with hard spheres, with which the other variants are compared.
    /// `None` if no variant has hard spheres.
    pub reference: Option<usize>,
    /// Rows in the order of the points (one value for each varied key): from point to point the value of the last key
    /// changes fastest. Each point has one row per variant (experiment of a case).
    pub rows: &'a [SweepRow],
}

impl SweepStudy<'_> {
    /// Text of a point of the sweep, such as "stiffness = 300 N/m, theta = 0.1". `at` holds the index of the value of
    /// each key.
    pub fn point(&self, at: &[usize]) -> String {
        point(self.axes, at)
    }
}

/// Text of a point of a sweep: the keys with their values. `at` holds the index of the value on each axis.
pub fn point(axes: &[SweepAxis], at: &[usize]) -> String {
    let one = |(axis, &value): (&SweepAxis, &usize)| format!("{} = {}", axis.name(), axis.typed[value]);
    axes.iter().zip(at).map(one).collect::<Vec<_>>().join(", ")
}
