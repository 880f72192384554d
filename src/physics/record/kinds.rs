//! Records of impacts, separate for each pair of kinds of bodies. A kind is a species of particles or a wall.

use super::Impact;
use crate::exact::{ExactSum, add_rows};
use crate::scene::{Kind, in_order};
use serde::{Deserialize, Serialize};

/// Kinds of the two bodies of an impact. Two species are in the order in which the case lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Between {
    /// Index of the species of the first body.
    pub species: u16,
    /// Kind of the second body.
    pub other: Kind,
}

impl Between {
    /// Makes the sorted pair from a species and another species or a wall, in any order.
    #[inline]
    pub fn of(species: u16, other: Kind) -> Self {
        let (species, other) = in_order(species, other);
        Self { species, other }
    }

    /// True if the second body is a wall.
    #[inline]
    pub fn is_wall(&self) -> bool {
        matches!(self.other, Kind::Wall(_))
    }
}

/// Sums over the impacts between two kinds of bodies, each a species of particles or a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeetingTotals {
    /// Number of finished impacts between the two kinds.
    pub count: u64,
    /// [m/s] sum of the normal speeds of approach over the impacts between the two kinds.
    pub speed: f64,
    /// [m²/s²] sum of the squared normal speeds of approach over the impacts between the two kinds.
    pub approach: f64,
    /// [m²/s²] sum of the squared normal speeds of rebound over the impacts between the two kinds.
    pub rebound: f64,
}

impl MeetingTotals {
    /// Sums over the impacts since `before` was copied from these sums.
    pub fn since(&self, before: &Self) -> Self {
        Self {
            count: self.count - before.count,
            speed: self.speed - before.speed,
            approach: self.approach - before.approach,
            rebound: self.rebound - before.rebound,
        }
    }
}

/// Sums over impacts up to one instant, for every pair of kinds (each a species or a wall) that has had impacts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ByKinds(Vec<(Between, MeetingTotals)>);

impl ByKinds {
    /// Sums over the impacts between two kinds (each a species or a wall); zeros if these kinds have had no impact.
    pub fn of(&self, between: Between) -> MeetingTotals {
        let place = self.0.binary_search_by_key(&between, |(between, _)| *between);
        place.map_or_else(|_| MeetingTotals::default(), |place| self.0[place].1)
    }

    /// Pairs of kinds (each a species or a wall) that have had impacts, in ascending order of their indices.
    pub fn met(&self) -> impl Iterator<Item = Between> {
        self.0.iter().map(|(between, _)| *between)
    }
}

/// Exact running sums over the impacts between two kinds, which [`MeetingTotals`] holds as rounded numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct MeetingSums {
    count: u64,
    speed: ExactSum,
    approach: ExactSum,
    rebound: ExactSum,
}

/// Exact running sums for every pair of kinds (each a species or a wall) that has had impacts. Exact sums do not depend
/// on the order of the impacts.
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

    /// Adds impacts between two kinds of bodies (each a species or a wall) to the sums of this pair of kinds.
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

    /// Adds the sums of another record.
    pub fn merge(&mut self, other: &Self) {
        for (between, others) in &other.0 {
            let entry = self.entry(*between);
            entry.count += others.count;
            entry.speed.merge(&others.speed);
            entry.approach.merge(&others.approach);
            entry.rebound.merge(&others.rebound);
        }
    }

    /// Sums over the impacts so far, rounded to double precision.
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
