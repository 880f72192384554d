//! Impacts by the kinds that met.

use super::Impact;
use crate::scene::{Kind, in_order};
use serde::{Deserialize, Serialize};

/// The two kinds of an impact; of two species the one that comes first in the case comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Between {
    /// A species.
    pub species: u16,
    /// What it met.
    pub other: Kind,
}

impl Between {
    /// In either order.
    #[inline]
    pub fn of(species: u16, other: Kind) -> Self {
        let (species, other) = in_order(species, other);
        Self { species, other }
    }

    /// Whether the other is a wall.
    #[inline]
    pub fn is_wall(&self) -> bool {
        matches!(self.other, Kind::Wall(_))
    }
}

/// Impacts of two kinds, in a few sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Totals {
    /// Impacts that have ended.
    pub count: u64,
    /// [m/s] normal speeds of approach, summed.
    pub speed: f64,
    /// [m²/s²] their squares, summed.
    pub approach: f64,
    /// [m²/s²] squared normal speeds of rebound, summed.
    pub rebound: f64,
}

impl Totals {
    /// What was added since this was `before`.
    pub fn since(&self, before: &Self) -> Self {
        Self {
            count: self.count - before.count,
            speed: self.speed - before.speed,
            approach: self.approach - before.approach,
            rebound: self.rebound - before.rebound,
        }
    }
}

/// The sums of all kinds that have met.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ByKinds(Vec<(Between, Totals)>);

impl ByKinds {
    /// Counts one impact.
    pub fn add(&mut self, between: Between, impact: &Impact) {
        let place = match self.0.binary_search_by_key(&between, |(between, _)| *between) {
            Ok(place) => place,
            Err(place) => {
                self.0.insert(place, (between, Totals::default()));
                place
            }
        };
        let totals = &mut self.0[place].1;
        totals.count += 1;
        totals.speed += impact.normal_speed;
        totals.approach += impact.normal_speed * impact.normal_speed;
        totals.rebound += impact.rebound_speed * impact.rebound_speed;
    }

    /// The sums of two kinds; zeros if they have not met.
    pub fn of(&self, between: Between) -> Totals {
        let place = self.0.binary_search_by_key(&between, |(between, _)| *between);
        place.map_or_else(|_| Totals::default(), |place| self.0[place].1)
    }

    /// Who has met, in ascending order.
    pub fn met(&self) -> impl Iterator<Item = Between> {
        self.0.iter().map(|(between, _)| *between)
    }
}
