//! Records of impacts in quantities that all collision models provide.

use super::Histogram;
use crate::exact::ExactSum;
use serde::{Deserialize, Serialize};

/// One finished impact: a soft contact that has ended, or an instantaneous collision.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Impact {
    /// [m/s] normal speed of approach at first touch, positive.
    pub normal_speed: f64,
    /// [m/s] normal speed of separation at the end of the impact; positive if the bodies separate.
    pub rebound_speed: f64,
    /// [s] duration of the contact; 0 for an instantaneous collision.
    pub duration: f64,
    /// [-] overlap when the impact was first detected, divided by the smaller diameter of the two bodies; 0 for an
    /// event-driven collision.
    pub first_overlap: f64,
    /// [-] largest overlap during the impact, divided by the smaller diameter of the two bodies; 0 for an event-driven
    /// collision.
    pub maximum_overlap: f64,
    /// [s] time integral over the impact of the relative overlap (overlap divided by the smaller diameter); 0 for an
    /// instantaneous collision.
    pub overlap_time: f64,
    /// Soft contact that this instantaneous impact replaces, in an engine that also has lasting contacts (hybrid
    /// spheres); otherwise `None`.
    pub left_out: Option<LeftOut>,
    /// Slip of the surfaces before and after the impact; `None` for spheres without rotation.
    pub slip: Option<SlipChange>,
}

/// Slip of two surfaces before and after an impact of bodies that rotate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SlipChange {
    /// [m/s] slip speed |s| at first touch.
    pub before: f64,
    /// [m/s] component of the slip at the end in the direction of the slip at first touch; negative if the slip is
    /// reversed.
    pub after: f64,
    /// True if the surfaces slide during the whole impact: the tangential impulse is at Coulomb's limit μ J_n, with
    /// the friction coefficient μ and the normal impulse J_n.
    pub slides: bool,
}

/// Smallest ratio [-] of the tangential impulse to Coulomb's limit μ J_n for which the surfaces count as sliding all
/// the time. Here μ is the friction coefficient and J_n the normal impulse. The value was chosen for this program:
/// errors of time steps and of rebound tables are smaller than 0.1 %.
const AT_LIMIT: f64 = 0.999;

impl SlipChange {
    /// Makes the record of one impact from its slips before and after [m/s]. `impulse` is the tangential impulse [kg
    /// m/s] and `limit` its limit by Coulomb's law, μ J_n [kg m/s], with the friction coefficient μ and the normal
    /// impulse J_n.
    pub fn new([before, after]: [f64; 2], impulse: f64, limit: f64) -> Self {
        Self { before, after, slides: impulse >= AT_LIMIT * limit }
    }
}

/// Sums over the impacts of bodies that rotate, in which surfaces slip (move tangentially against each other).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Slips {
    /// Number of impacts of bodies that rotate, with one another or with walls.
    pub count: u64,
    /// Number of impacts in which the surfaces slide during the whole impact.
    pub sliding: u64,
    squares: ExactSum,
    products: ExactSum,
}

impl Slips {
    fn add(&mut self, slip: SlipChange) {
        self.count += 1;
        self.sliding += u64::from(slip.slides);
        self.squares.add(slip.before * slip.before);
        self.products.add(slip.before * slip.after);
    }

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.sliding += other.sliding;
        self.squares.merge(&other.squares);
        self.products.merge(&other.products);
    }

    fn since(&self, before: &Self) -> Self {
        Self {
            count: self.count - before.count,
            sliding: self.sliding - before.sliding,
            squares: self.squares.less(&before.squares),
            products: self.products.less(&before.products),
        }
    }

    /// [-] realised tangential restitution β = -Σ s·s'/Σ s², from slips s at first touch and s' at the end; -1 without
    /// friction, 1 if every slip is reversed. `None` without slips.
    pub fn restitution(&self) -> Option<f64> {
        let squares = self.squares.value();
        (squares > 0.0).then(|| -self.products.value() / squares)
    }

    /// [-] share of the impacts in which the surfaces slide during the whole impact; `None` without impacts.
    pub fn share_sliding(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sliding as f64 / self.count as f64)
    }
}

/// Contact that an engine replaced by an instantaneous impact. The values are those of an isolated contact under the
/// contact law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// [s] duration that the replaced contact would have had.
    pub duration: f64,
    /// [-] largest overlap that the replaced contact would have had, divided by the smaller diameter of the two bodies.
    pub overlap: f64,
}

/// Sums over contacts that an engine replaced by instantaneous impacts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InstantaneousContacts {
    /// Number of contacts that the engine replaced by instantaneous impacts.
    pub count: u64,
    /// [-] largest overlap that any of the replaced contacts would have reached, divided by the smaller diameter of its
    /// two bodies.
    pub largest_overlap: f64,
    duration: ExactSum,
    overlap: ExactSum,
    approach_squares: ExactSum,
    rebound_squares: ExactSum,
}

/// Sums and histograms of the speeds, overlaps, restitutions and durations of impacts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Impacts {
    /// Number of impacts that have ended.
    pub count: u64,
    /// [m/s] normal speed of approach of each impact.
    pub normal_speed: Histogram,
    /// [-] largest overlap of each impact, divided by the smaller diameter of the two bodies.
    pub maximum_overlap: Histogram,
    /// [-] first detected overlap of each impact, divided by the smaller diameter of the two bodies.
    pub first_overlap: Histogram,
    /// [-] realised restitution of each impact: speed of rebound divided by speed of approach.
    pub restitution: Histogram,
    /// [s] duration of the contact of each impact; 0 for an instantaneous collision.
    pub duration: Histogram,
    /// Contacts that an engine replaced by instantaneous impacts.
    pub instants: InstantaneousContacts,
    /// Sums over the slips (tangential relative velocities) in impacts between bodies that rotate.
    pub slips: Slips,
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

    /// Sums over the replaced contacts that were added after `before` was copied from these sums. The largest overlap
    /// is that of all replaced contacts, also the earlier ones.
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

    /// [s] sum of the durations that the replaced contacts would have had.
    pub fn duration(&self) -> f64 {
        self.duration.value()
    }

    /// [-] sum of the largest overlaps that the replaced contacts would have had, each divided by the smaller diameter
    /// of the two bodies.
    pub fn overlap(&self) -> f64 {
        self.overlap.value()
    }

    /// [m²/s²] sum of the squared normal speeds of approach of the impacts that replaced contacts.
    pub fn approach_squares(&self) -> f64 {
        self.approach_squares.value()
    }

    /// [m²/s²] sum of the squared normal speeds of rebound of the impacts that replaced contacts.
    pub fn rebound_squares(&self) -> f64 {
        self.rebound_squares.value()
    }

    /// [-] realised restitution of the impacts that replaced contacts: square root of the ratio of the two sums of
    /// squared speeds, rebound over approach. `None` without such impacts.
    pub fn restitution(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.rebound_squares() / self.approach_squares()).sqrt())
    }
}

impl Impacts {
    /// Adds one impact to the sums and histograms.
    pub fn add(&mut self, impact: &Impact) {
        self.add_all(std::iter::once(impact));
    }

    /// Adds several impacts to the sums and histograms; their order does not matter.
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
            if let Some(slip) = impact.slip {
                self.slips.add(slip);
            }
        }
    }

    /// Adds the impacts of another record.
    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.normal_speed.merge(&other.normal_speed);
        self.maximum_overlap.merge(&other.maximum_overlap);
        self.first_overlap.merge(&other.first_overlap);
        self.restitution.merge(&other.restitution);
        self.duration.merge(&other.duration);
        self.instants.merge(&other.instants);
        self.slips.merge(&other.slips);
        self.rebound_squares.merge(&other.rebound_squares);
        self.overlap_time.merge(&other.overlap_time);
    }

    /// Sums and histograms of the impacts that were added after `before` was copied from this record.
    pub fn since(&self, before: &Self) -> Self {
        Self {
            count: self.count - before.count,
            normal_speed: self.normal_speed.since(&before.normal_speed),
            maximum_overlap: self.maximum_overlap.since(&before.maximum_overlap),
            first_overlap: self.first_overlap.since(&before.first_overlap),
            restitution: self.restitution.since(&before.restitution),
            duration: self.duration.since(&before.duration),
            instants: self.instants.since(&before.instants),
            slips: self.slips.since(&before.slips),
            rebound_squares: self.rebound_squares.less(&before.rebound_squares),
            overlap_time: self.overlap_time.less(&before.overlap_time),
        }
    }

    /// [m²/s²] sum of the squared normal speeds of rebound over all impacts.
    pub fn rebound_squares(&self) -> f64 {
        self.rebound_squares.value()
    }

    /// [s] sum over impacts of the time integral of the relative overlap (overlap divided by the smaller diameter).
    pub fn overlap_time(&self) -> f64 {
        self.overlap_time.value()
    }

    /// Means and largest values of the impacts, for a summary.
    pub fn summary(&self) -> Summary {
        Summary {
            count: self.count,
            mean_normal_speed: self.normal_speed.mean(),
            mean_restitution: (self.count > 0)
                .then(|| (self.rebound_squares() / self.normal_speed.sum_of_squares()).sqrt()),
            tangential_restitution: self.slips.restitution(),
            share_sliding: self.slips.share_sliding(),
            mean_duration: self.duration.mean(),
            mean_first_overlap: self.first_overlap.mean(),
            time_mean_overlap: (self.duration.sum() > 0.0).then(|| self.overlap_time() / self.duration.sum()),
            mean_maximum_overlap: self.maximum_overlap.mean(),
            p99_maximum_overlap: self.maximum_overlap.quantile(0.99),
            largest_overlap: self.maximum_overlap.largest(),
        }
    }
}

/// Means and largest values of impacts; a mean or largest value is `None` without impacts. Overlaps are divided by the
/// smaller diameter of the two bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Number of impacts that have ended.
    pub count: u64,
    /// [m/s] mean normal speed of approach at first touch.
    pub mean_normal_speed: Option<f64>,
    /// [-] realised restitution sqrt(Σ u'²/Σ u²), with the normal speeds u before and u' after each impact. A grazing
    /// impact, whose normal turns during the contact, has a low normal speed and so counts little.
    pub mean_restitution: Option<f64>,
    /// [-] realised tangential restitution β: -1 without friction, 1 if every slip is reversed
    /// ([`Slips::restitution`]). `None` without slips, and where spheres do not rotate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tangential_restitution: Option<f64>,
    /// [-] share of the impacts in which the surfaces slide during the whole impact; `None` without impacts, and where
    /// spheres do not rotate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_sliding: Option<f64>,
    /// [s] mean duration of the impacts; an instantaneous collision counts with the duration 0.
    pub mean_duration: Option<f64>,
    /// [-] mean of the overlaps at which impacts were first detected, each divided by the smaller diameter.
    pub mean_first_overlap: Option<f64>,
    /// [-] time average, during the contacts, of the overlap divided by the smaller diameter. `None` without impacts,
    /// and if all impacts were instantaneous.
    pub time_mean_overlap: Option<f64>,
    /// [-] mean of the largest overlaps of the impacts, each divided by the smaller diameter.
    pub mean_maximum_overlap: Option<f64>,
    /// [-] overlap, divided by the smaller diameter, that is not exceeded in 99 % of the impacts.
    pub p99_maximum_overlap: Option<f64>,
    /// [-] largest overlap of all impacts, divided by the smaller diameter.
    pub largest_overlap: Option<f64>,
}
