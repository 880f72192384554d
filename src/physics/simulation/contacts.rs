//! Contacts in progress, and the energy that they store. A window is the time between two exchanges with the gas.

use super::Simulation;
use crate::encounter::{Couple, FrameTime};
use crate::engine::Overlap;
use crate::engine::distributed::Distributed;
use crate::neighbours::overlapping;

/// Summary of all contacts in progress. Both numbers are 0 if collisions are instantaneous.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSummary {
    /// Number of particles in contact, counted once per contact: two for each contact of a pair, one for each contact
    /// with a wall.
    pub ends: u64,
    /// [-] largest ratio of the overlap to the smaller diameter of the two bodies (at a wall: to the diameter of the
    /// particle).
    pub largest_overlap: f64,
}

impl Simulation {
    /// [J] kinetic and rotational energy of all particles plus the energy stored in contacts. Before the first window
    /// (time between two exchanges with the gas), the stored energy is that of the initial overlaps. The sum is over
    /// all processes; if each has a part of the particles, all of them must call this method.
    pub fn energy(&self) -> f64 {
        let sample = self.sample();
        sample.kinetic_energy() + sample.rotational_energy() + self.elastic_energy()
    }

    /// [J] energy stored in the contacts of all particles. Before the first window (time between two exchanges with
    /// the gas), it is that of the initial overlaps. The sum is over all processes; if each has a part of the
    /// particles, all of them must call this method.
    pub fn elastic_energy(&self) -> f64 {
        self.unseen.unwrap_or_else(|| self.engine.elastic_energy())
    }

    /// [J] energies stored in tangential, rolling and twisting springs, which are parts of the elastic energy. The
    /// sums are over all processes; if each has a part of the particles, all of them must call this method.
    pub fn spring_energies(&self) -> [f64; 3] {
        self.engine.spring_energies()
    }

    /// All contacts in progress: the indices of the two bodies (two particles, or a particle and a wall) and their
    /// overlap [m]. The list is empty unless the engine has soft contacts.
    pub fn contacts(&self) -> Vec<(Couple, f64)> {
        let mut contacts = Vec::new();
        self.for_each_contact(|couple, overlap| contacts.push((couple, overlap)));
        contacts
    }

    /// Calls `visit` for each contact in progress, with the indices of its two bodies (two particles, or a particle
    /// and a wall) and their overlap [m]. Engines with instantaneous collisions have no contacts. Contacts with
    /// particles of other processes are left out; [`contacts_abroad`](Self::contacts_abroad) returns them.
    pub fn for_each_contact(&self, mut visit: impl FnMut(Couple, f64)) {
        let mut look = |couple: Couple| {
            let overlap = couple.meet(&self.particles, &self.scene, FrameTime::default()).overlap();
            if overlap > 0.0 {
                visit(couple, overlap);
            }
        };
        match self.unseen {
            // the engine has not yet processed the initial state
            Some(energy) if energy > 0.0 => overlapping(&self.particles, &self.scene).into_iter().for_each(look),
            _ => self.engine.for_each_touching(&mut look),
        }
    }

    /// [m] largest overlap of each particle, in the order of [`particles`](Self::particles); 0 for a particle without
    /// a soft contact. Contacts with particles of other processes are left out.
    pub fn overlaps(&self) -> Vec<f64> {
        let mut overlaps = vec![0.0_f64; self.particles.len()];
        self.for_each_contact(|couple, overlap| {
            for index in couple.indices().into_iter().flatten() {
                overlaps[index as usize] = overlaps[index as usize].max(overlap);
            }
        });
        overlaps
    }

    /// Contacts of the soft engine with particles of other processes: the index of the particle in this process, and
    /// the overlap [m]. Both processes list the contact. The list is empty unless each process has a part of the
    /// particles.
    pub fn contacts_abroad(&self) -> Vec<(u32, f64)> {
        self.touching_abroad().into_iter().map(|(index, overlap)| (index, overlap.depth)).collect()
    }

    fn touching_abroad(&self) -> Vec<(u32, Overlap)> {
        self.engine.distributed().map_or_else(Vec::new, Distributed::touching_abroad)
    }

    /// Summary of all contacts in progress in all processes. If each process has a part of the particles, all
    /// processes must call this method.
    pub fn touching(&self) -> ContactSummary {
        let abroad = self.touching_abroad();
        let deepest = abroad.iter().map(|(_, overlap)| overlap.depth / overlap.diameter).fold(0.0, f64::max);
        let (mut ends, mut largest) = ([abroad.len() as i64], [deepest]);
        self.for_each_contact(|couple, overlap| {
            ends[0] += couple.indices().iter().flatten().count() as i64;
            largest[0] = largest[0].max(overlap / couple.diameter(&self.particles));
        });
        if let Some(share) = self.parts() {
            share.sum(&mut ends);
            share.largest(&mut largest);
        }
        ContactSummary { ends: ends[0] as u64, largest_overlap: largest[0] }
    }
}
