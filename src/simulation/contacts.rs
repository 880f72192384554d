//! Who touches whom, and the energy that this holds.

use super::Simulation;
use crate::encounter::{Couple, Moment};
use crate::neighbours::overlapping;

/// Contacts in progress of all particles in two numbers; both are 0 where contacts do not last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touching {
    /// Particles in contact, each counted once for every contact that it has: two for a pair, one at a wall.
    pub ends: u64,
    /// [-] largest overlap over the (smaller) diameter.
    pub largest_overlap: f64,
}

impl Simulation {
    /// [J] kinetic energy plus what contacts store: before the first window, what overlaps of the start hold. Of all particles, as a sum of the
    /// [`sample`](Self::sample).
    pub fn energy(&self) -> f64 {
        self.sample().kinetic_energy() + self.elastic_energy()
    }

    /// [J] what contacts store: before the first window, what overlaps of the start hold. Of all particles, as a sum of the [`sample`](Self::sample).
    pub fn elastic_energy(&self) -> f64 {
        self.unseen.unwrap_or_else(|| self.engine.elastic_energy())
    }

    /// Who overlaps now, by place in the store, and by how much [m] (soft).
    pub fn contacts(&self) -> Vec<(Couple, f64)> {
        // the engine has not looked at the start yet
        let couples = match self.unseen {
            Some(energy) if energy > 0.0 => overlapping(&self.particles, &self.scene),
            _ => self.engine.touching(),
        };
        let overlap = |couple: Couple| couple.meet(&self.particles, &self.scene, Moment::default()).overlap();
        couples.into_iter().map(|couple| (couple, overlap(couple))).filter(|(_, overlap)| *overlap > 0.0).collect()
    }

    /// Contacts with particles that other processes have, by place of one's own in the store, and the overlap [m] (soft). Each of the two processes has
    /// it; nobody has any unless each has a part of the particles.
    pub fn contacts_abroad(&self) -> Vec<(u32, f64)> {
        self.engine.touching_abroad().into_iter().map(|(place, overlap)| (place, overlap.depth)).collect()
    }

    /// All contacts in progress, as a sum of the [`sample`](Self::sample).
    pub fn touching(&self) -> Touching {
        let (contacts, abroad) = (self.contacts(), self.engine.touching_abroad());
        let bodies = contacts.iter().map(|(couple, _)| couple.places().iter().flatten().count()).sum::<usize>();
        let overlaps = contacts.iter().map(|(couple, overlap)| overlap / couple.diameter(&self.particles));
        let ends_abroad = abroad.len();
        let overlaps = overlaps.chain(abroad.into_iter().map(|(_, overlap)| overlap.depth / overlap.diameter));
        let (mut ends, mut largest) = ([(bodies + ends_abroad) as i64], [overlaps.fold(0.0, f64::max)]);
        if let Some(share) = self.parts() {
            share.sum(&mut ends);
            share.largest(&mut largest);
        }
        Touching { ends: ends[0] as u64, largest_overlap: largest[0] }
    }
}
