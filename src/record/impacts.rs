//! Impacts, in terms that both engines can give.

use super::Histogram;
use crate::exact::ExactSum;
use serde::{Deserialize, Serialize};

/// One finished impact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Impact {
    /// [m/s] normal speed of approach at first touch, > 0.
    pub normal_speed: f64,
    /// [m/s] normal speed of separation at the end.
    pub rebound_speed: f64,
    /// [s] how long it lasted; 0 for a collision.
    pub duration: f64,
    /// [-] overlap when first seen, over the (smaller) diameter; 0 for an event-driven collision.
    pub first_overlap: f64,
    /// [-] largest overlap over the (smaller) diameter; 0 for an event-driven collision.
    pub maximum_overlap: f64,
    /// [s] overlap over the (smaller) diameter, integrated over the impact; 0 for a collision.
    pub overlap_time: f64,
    /// What the contact would have been, if an engine that knows contacts took this impact for an instant.
    pub left_out: Option<LeftOut>,
}

/// A contact that was taken for an instant: what an isolated one would have been by the contact law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// [s] its duration.
    pub duration: f64,
    /// [-] its largest overlap over the (smaller) diameter.
    pub overlap: f64,
}

/// Contacts that were taken for instants, added up.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InstantaneousContacts {
    /// How many.
    pub count: u64,
    /// [-] the largest overlap that one would have had, over the (smaller) diameter.
    pub largest_overlap: f64,
    duration: ExactSum,
    overlap: ExactSum,
    approach_squares: ExactSum,
    rebound_squares: ExactSum,
}

/// Impacts added up.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Impacts {
    /// Number of impacts that have ended.
    pub count: u64,
    /// [m/s] normal speeds of approach.
    pub normal_speed: Histogram,
    /// [-] largest overlaps over the (smaller) diameter.
    pub maximum_overlap: Histogram,
    /// [-] first seen overlaps over the (smaller) diameter.
    pub first_overlap: Histogram,
    /// [-] realised restitution, rebound over approach speed.
    pub restitution: Histogram,
    /// [s] durations.
    pub duration: Histogram,
    /// Those of them that were taken for instants by an engine that knows contacts.
    pub instants: InstantaneousContacts,
    rebound_squares: ExactSum,
    overlap_time: ExactSum,
}

impl InstantaneousContacts {
    fn add(&mut self, impact: &Impact, left_out: LeftOut) {
        self.count += 1;
        self.largest_overlap = self.largest_overlap.max(left_out.overlap);
        self.duration.add(left_out.duration);
        self.overlap.add(left_out.overlap);
        self.approach_squares.add(impact.normal_speed * impact.normal_speed);
        self.rebound_squares.add(impact.rebound_speed * impact.rebound_speed);
    }

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.largest_overlap = self.largest_overlap.max(other.largest_overlap);
        self.duration.merge(&other.duration);
        self.overlap.merge(&other.overlap);
        self.approach_squares.merge(&other.approach_squares);
        self.rebound_squares.merge(&other.rebound_squares);
    }

    /// Those added since this was `before`; the largest overlap stays that of all.
    fn since(&self, before: &Self) -> Self {
        Self {
            count: self.count - before.count,
            largest_overlap: self.largest_overlap,
            duration: self.duration.less(&before.duration),
            overlap: self.overlap.less(&before.overlap),
            approach_squares: self.approach_squares.less(&before.approach_squares),
            rebound_squares: self.rebound_squares.less(&before.rebound_squares),
        }
    }

    /// [s] durations that they would have had, summed.
    pub fn duration(&self) -> f64 {
        self.duration.value()
    }

    /// [-] largest overlaps that they would have had, over the (smaller) diameter, summed.
    pub fn overlap(&self) -> f64 {
        self.overlap.value()
    }

    /// [m²/s²] sum of the squared speeds of approach.
    pub fn approach_squares(&self) -> f64 {
        self.approach_squares.value()
    }

    /// [m²/s²] sum of the squared rebound speeds.
    pub fn rebound_squares(&self) -> f64 {
        self.rebound_squares.value()
    }

    /// [-] realised restitution, as that of [`Summary`]; `None` without an instant.
    pub fn restitution(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.rebound_squares() / self.approach_squares()).sqrt())
    }
}

impl Impacts {
    /// Counts one impact.
    pub fn add(&mut self, impact: &Impact) {
        self.add_all(std::iter::once(impact));
    }

    /// Counts several impacts; their order does not matter.
    pub fn add_all<'a>(&mut self, impacts: impl Iterator<Item = &'a Impact> + Clone) {
        self.normal_speed.add_all(impacts.clone().map(|impact| impact.normal_speed));
        self.maximum_overlap.add_all(impacts.clone().map(|impact| impact.maximum_overlap));
        self.first_overlap.add_all(impacts.clone().map(|impact| impact.first_overlap));
        self.restitution.add_all(impacts.clone().map(|impact| impact.rebound_speed / impact.normal_speed));
        self.duration.add_all(impacts.clone().map(|impact| impact.duration));
        for impact in impacts {
            self.count += 1;
            self.rebound_squares.add(impact.rebound_speed * impact.rebound_speed);
            self.overlap_time.add(impact.overlap_time);
            if let Some(left_out) = impact.left_out {
                self.instants.add(impact, left_out);
            }
        }
    }

    /// Adds the impacts that another has counted.
    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.normal_speed.merge(&other.normal_speed);
        self.maximum_overlap.merge(&other.maximum_overlap);
        self.first_overlap.merge(&other.first_overlap);
        self.restitution.merge(&other.restitution);
        self.duration.merge(&other.duration);
        self.instants.merge(&other.instants);
        self.rebound_squares.merge(&other.rebound_squares);
        self.overlap_time.merge(&other.overlap_time);
    }

    /// The impacts that were added since this was `before`.
    pub fn since(&self, before: &Self) -> Self {
        Self {
            count: self.count - before.count,
            normal_speed: self.normal_speed.since(&before.normal_speed),
            maximum_overlap: self.maximum_overlap.since(&before.maximum_overlap),
            first_overlap: self.first_overlap.since(&before.first_overlap),
            restitution: self.restitution.since(&before.restitution),
            duration: self.duration.since(&before.duration),
            instants: self.instants.since(&before.instants),
            rebound_squares: self.rebound_squares.less(&before.rebound_squares),
            overlap_time: self.overlap_time.less(&before.overlap_time),
        }
    }

    /// [m²/s²] sum of the squared rebound speeds.
    pub fn rebound_squares(&self) -> f64 {
        self.rebound_squares.value()
    }

    /// [s] overlaps over the (smaller) diameter, integrated over the impacts, summed.
    pub fn overlap_time(&self) -> f64 {
        self.overlap_time.value()
    }

    /// The numbers a summary shows.
    pub fn summary(&self) -> Summary {
        Summary {
            count: self.count,
            mean_normal_speed: self.normal_speed.mean(),
            mean_restitution: (self.count > 0)
                .then(|| (self.rebound_squares() / self.normal_speed.sum_of_squares()).sqrt()),
            mean_duration: self.duration.mean(),
            mean_first_overlap: self.first_overlap.mean(),
            time_mean_overlap: (self.duration.sum() > 0.0).then(|| self.overlap_time() / self.duration.sum()),
            mean_maximum_overlap: self.maximum_overlap.mean(),
            p99_maximum_overlap: self.maximum_overlap.quantile(0.99),
            largest_overlap: self.maximum_overlap.largest(),
        }
    }
}

/// Impacts in a few numbers, `None` where there was no impact. Overlaps are over the (smaller) diameter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Impacts that have ended.
    pub count: u64,
    /// [m/s] mean normal speed of approach.
    pub mean_normal_speed: Option<f64>,
    /// [-] realised restitution: the root of the normal energy after over before, summed over impacts, so that grazing
    /// impacts, whose normal turns while they last, do not weigh more than they carry.
    pub mean_restitution: Option<f64>,
    /// [s] mean duration.
    pub mean_duration: Option<f64>,
    /// [-] mean overlap when first seen.
    pub mean_first_overlap: Option<f64>,
    /// [-] mean overlap over the time that contacts last; `None` also where all of them were instants.
    pub time_mean_overlap: Option<f64>,
    /// [-] mean of the largest overlaps.
    pub mean_maximum_overlap: Option<f64>,
    /// [-] the overlap that 99 % of the impacts stay below.
    pub p99_maximum_overlap: Option<f64>,
    /// [-] the largest overlap of all.
    pub largest_overlap: Option<f64>,
}
