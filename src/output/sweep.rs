//! What a sweep comes to: runs, and the rows of its points.

use super::{Provenance, figures};
use crate::case::SweepAxis;
use crate::outcome::Outcome;
use crate::statistics::Estimate;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Something that is measured in every run of a sweep.
pub struct SweepObservable {
    /// Name of its column in `sweep.csv`, with the unit.
    pub key: &'static str,
    /// Its name in a sentence.
    pub name: &'static str,
    /// Label of its axis.
    pub axis: &'static str,
    /// True for an average over time, whose error holds for a steady run that mixes.
    pub is_average: bool,
    /// How it is read off an outcome.
    pub of: fn(&Outcome) -> Option<Estimate>,
}

/// [m/s] mean streamwise velocity over all slices, weighted by their particles. Slices move together to an unknown degree: the error is
/// the most that theirs can come to.
fn velocity(outcome: &Outcome) -> Option<Estimate> {
    let (mut sum, mut error, mut weights) = (0.0, Some(0.0), 0.0);
    for row in &outcome.profiles.slices {
        let (Some(density), Some(mean)) = (row.number_density_ratio, row.mean[0]) else { continue };
        sum += density.value * mean.value;
        error = error.zip(mean.error).map(|(sum, error)| sum + density.value * error);
        weights += density.value;
    }
    (weights > 0.0).then(|| Estimate { value: sum / weights, error: error.map(|error| error / weights) })
}

/// What is measured, in the order of columns and pictures.
pub const OBSERVABLES: [SweepObservable; 8] = [
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
        // at exact instants there is none but that of rounding
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

/// The result of one run, as it stands in a file of the folder `points`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepRun {
    /// Hash of the resolved case and the version of the program: equal for runs that must give the same.
    pub identity: String,
    /// What was measured, by [`SweepObservable::key`]; what is not known is not there. Nothing of a run that stopped early.
    pub measured: BTreeMap<String, Estimate>,
    /// Why it stopped early, if it did.
    pub failure: Option<String>,
    /// [s] wall time.
    pub wall_seconds: f64,
    /// Threads that it had to itself.
    pub threads: usize,
}

/// A variant at one point of a sweep.
pub struct SweepRow {
    /// Which value of each axis.
    pub at: Vec<usize>,
    /// Which of the variants.
    pub variant: usize,
    /// Identities of its runs, one per replica; a run may belong to several rows.
    pub identities: Vec<String>,
    /// The runs of these that are done.
    pub runs: Vec<SweepRun>,
}

impl SweepRow {
    /// A number of this row: that of its run, or the mean over replicas with the standard error of their scatter. None if it is
    /// not known, or a run stopped early.
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

    /// Why a run of it stopped early, if one did.
    pub fn failure(&self) -> Option<&str> {
        self.runs.iter().find_map(|run| run.failure.as_deref())
    }

    /// "complete", "failed", or "not run yet".
    pub fn status(&self) -> &'static str {
        match (self.failure(), self.runs.len() < self.identities.len()) {
            (Some(_), _) => "failed",
            (None, true) => "not run yet",
            (None, false) => "complete",
        }
    }
}

/// Everything outputs need to know of a sweep.
pub struct SweepStudy<'a> {
    /// Where it comes from.
    pub provenance: &'a Provenance,
    /// What is varied.
    pub axes: &'a [SweepAxis],
    /// Names of the variants.
    pub variants: &'a [String],
    /// Which variant the others are compared with: the first hard one, if there is one.
    pub reference: Option<usize>,
    /// Points in the order of the axes, the last one fastest; at each point all variants.
    pub rows: &'a [SweepRow],
}

impl SweepStudy<'_> {
    /// A point in words: "stiffness = 300 N/m, theta = 0.1".
    pub fn point(&self, at: &[usize]) -> String {
        point(self.axes, at)
    }
}

/// A point of a sweep in words.
pub fn point(axes: &[SweepAxis], at: &[usize]) -> String {
    let one = |(axis, &value): (&SweepAxis, &usize)| format!("{} = {}", axis.name(), axis.typed[value]);
    axes.iter().zip(at).map(one).collect::<Vec<_>>().join(", ")
}
