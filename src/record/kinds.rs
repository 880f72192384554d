//! Impacts by the kinds of the two bodies.

use super::Impact;
use crate::exact::{ExactSum, add_rows};
use crate::scene::{Kind, in_order};
use serde::{Deserialize, Serialize};

/// The two kinds of an impact; of two species the one that comes first in the case comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Between {
    /// A species.
    pub species: u16,
    /// Kind of the other body.
    pub other: Kind,
}

impl Between {
    /// The two kinds, given in either order.
    #[inline]
    pub fn of(species: u16, other: Kind) -> Self {
        let (species, other) = in_order(species, other);
        Self { species, other }
    }

    /// True if the other body is a wall.
    #[inline]
    pub fn is_wall(&self) -> bool {
        matches!(self.other, Kind::Wall(_))
    }
}

/// Sums over impacts between two kinds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeetingTotals {
    /// Number of impacts that have ended.
    pub count: u64,
    /// [m/s] sum of the normal speeds of approach.
    pub speed: f64,
    /// [m²/s²] sum of the squared normal speeds of approach.
    pub approach: f64,
    /// [m²/s²] sum of the squared normal speeds of rebound.
    pub rebound: f64,
}

impl MeetingTotals {
    /// Sums over impacts since this was `before`.
    pub fn since(&self, before: &Self) -> Self {
        Self {
            count: self.count - before.count,
            speed: self.speed - before.speed,
            approach: self.approach - before.approach,
            rebound: self.rebound - before.rebound,
        }
    }
}

/// Sums for all pairs of kinds that have met, at an instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ByKinds(Vec<(Between, MeetingTotals)>);

impl ByKinds {
    /// Sums for two kinds; zeros if they have not met.
    pub fn of(&self, between: Between) -> MeetingTotals {
        let place = self.0.binary_search_by_key(&between, |(between, _)| *between);
        place.map_or_else(|_| MeetingTotals::default(), |place| self.0[place].1)
    }

    /// Pairs of kinds that have met, in ascending order.
    pub fn met(&self) -> impl Iterator<Item = Between> {
        self.0.iter().map(|(between, _)| *between)
    }
}

/// Exact running sums for [`MeetingTotals`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct MeetingSums {
    count: u64,
    speed: ExactSum,
    approach: ExactSum,
    rebound: ExactSum,
}

/// Running sums for all pairs of kinds that have met; the order of impacts does not matter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Meetings(Vec<(Between, MeetingSums)>);

impl Meetings {
    fn entry(&mut self, between: Between) -> &mut MeetingSums {
        let place = match self.0.binary_search_by_key(&between, |(between, _)| *between) {
            Ok(place) => place,
            Err(place) => {
                self.0.insert(place, (between, MeetingSums::default()));
                place
            }
        };
        &mut self.0[place].1
    }

    /// Counts impacts of two kinds.
    pub fn add_all<'a>(&mut self, between: Between, impacts: impl Iterator<Item = &'a Impact>) {
        let row = |impact: &Impact| {
            let Impact { normal_speed, rebound_speed, .. } = impact;
            [*normal_speed, normal_speed * normal_speed, rebound_speed * rebound_speed]
        };
        let rows: Vec<[f64; 3]> = impacts.map(row).collect();
        let entry = self.entry(between);
        entry.count += rows.len() as u64;
        add_rows([&mut entry.speed, &mut entry.approach, &mut entry.rebound], &rows);
    }

    /// Adds the impacts of another record.
    pub fn merge(&mut self, other: &Self) {
        for (between, others) in &other.0 {
            let entry = self.entry(*between);
            entry.count += others.count;
            entry.speed.merge(&others.speed);
            entry.approach.merge(&others.approach);
            entry.rebound.merge(&others.rebound);
        }
    }

    /// Present values of the sums.
    pub fn totals(&self) -> ByKinds {
        let totals = |MeetingSums { count, speed, approach, rebound }: &MeetingSums| MeetingTotals {
            count: *count,
            speed: speed.value(),
            approach: approach.value(),
            rebound: rebound.value(),
        };
        ByKinds(self.0.iter().map(|(between, sums)| (*between, totals(sums))).collect())
    }
}
