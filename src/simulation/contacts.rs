//! Who touches whom, and the energy that this holds.

use super::Simulation;
use crate::encounter::{Couple, FrameTime};
use crate::neighbours::overlapping;

/// Contacts in progress of all particles in two numbers; both are 0 where contacts do not last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSummary {
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
        let mut contacts = Vec::new();
        self.for_each_contact(|couple, overlap| contacts.push((couple, overlap)));
        contacts
    }

    /// Shows who overlaps now, by place in the store, and by how much [m] (soft).
    pub fn for_each_contact(&self, mut visit: impl FnMut(Couple, f64)) {
        let mut look = |couple: Couple| {
            let overlap = couple.meet(&self.particles, &self.scene, FrameTime::default()).overlap();
            if overlap > 0.0 {
                visit(couple, overlap);
            }
        };
        match self.unseen {
            // the engine has not looked at the start yet
            Some(energy) if energy > 0.0 => overlapping(&self.particles, &self.scene).into_iter().for_each(look),
            _ => self.engine.for_each_touching(&mut look),
        }
    }

    /// [m] the largest overlap of each particle, by place in the store; 0 of those that touch nothing (soft).
    pub fn overlaps(&self) -> Vec<f64> {
        let mut overlaps = vec![0.0_f64; self.particles.len()];
        self.for_each_contact(|couple, overlap| {
            for place in couple.places().into_iter().flatten() {
                overlaps[place as usize] = overlaps[place as usize].max(overlap);
            }
        });
        overlaps
    }

    /// Contacts with particles that other processes have, by place of one's own in the store, and the overlap [m] (soft). Each of the two processes has
    /// it; nobody has any unless each has a part of the particles.
    pub fn contacts_abroad(&self) -> Vec<(u32, f64)> {
        self.engine.touching_abroad().into_iter().map(|(place, overlap)| (place, overlap.depth)).collect()
    }

    /// All contacts in progress, as a sum of the [`sample`](Self::sample).
    pub fn touching(&self) -> ContactSummary {
        let abroad = self.engine.touching_abroad();
        let deepest = abroad.iter().map(|(_, overlap)| overlap.depth / overlap.diameter).fold(0.0, f64::max);
        let (mut ends, mut largest) = ([abroad.len() as i64], [deepest]);
        self.for_each_contact(|couple, overlap| {
            ends[0] += couple.places().iter().flatten().count() as i64;
            largest[0] = largest[0].max(overlap / couple.diameter(&self.particles));
        });
        if let Some(share) = self.parts() {
            share.sum(&mut ends);
            share.largest(&mut largest);
        }
        ContactSummary { ends: ends[0] as u64, largest_overlap: largest[0] }
    }
}
