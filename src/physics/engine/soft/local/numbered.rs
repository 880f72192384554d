//! Encounters (relative positions and velocities) of the slots of an island, a group of particles that may meet. A slot
//! is the number of a candidate (pair, or particle and wall) in its neighbour list.
//!
//! Some walls, such as meshes, number their contacts with a sphere by distance. If spheres rotate, a contact with such
//! a wall keeps its slot while it lasts, even if its number changes. The remaining encounters belong to the other slots
//! of the wall, in the order of distance.

use super::{InstantaneousRule, IslandRun};
use crate::encounter::{Couple, Encounter, FrameTime, Other};
use crate::engine::soft::contact::Contact;
use crate::engine::soft::wall_contacts::{are_of_one_wall, encounters, is_numbered_by_distance, matched};
use nalgebra::Vector3;

/// [-] gap of a slot (candidate) for which its wall has no contact left, divided by the distance of the bodies at
/// touch. The value is large enough to mean that the bodies do not touch.
const APART: f64 = 1.0;

impl<I: InstantaneousRule> IslandRun<'_, I> {
    /// Encounter of the two bodies of the slot `slot` (candidate) at the time `moment`. Normal and velocity are for the
    /// order of the bodies in `couple`, which may be opposite to that of the slot.
    #[inline(always)]
    pub(super) fn encounter(&self, slot: usize, couple: &Couple, moment: FrameTime) -> Encounter {
        if self.follows_normals(slot) {
            return self.encounter_by_normal(slot, moment);
        }
        couple.meet(self.particles, self.scene, moment)
    }

    /// True if spheres rotate, and the slot (candidate) belongs to a wall that numbers its contacts by distance.
    #[inline(always)]
    pub(super) fn is_by_distance(&self, slot: usize) -> bool {
        self.rotates() && is_numbered_by_distance(&self.scratch.touches[slot].couple, self.scene)
    }

    /// True if the encounter of the slot `slot` (candidate) is found by normals. The particle then touches a wall that
    /// numbers its contacts by distance.
    #[inline(always)]
    pub(super) fn follows_normals(&self, slot: usize) -> bool {
        let couple = &self.scratch.touches[slot].couple;
        let mut touched = self.scratch.contacts.iter().map(|contact| &contact.touch.couple);
        self.is_by_distance(slot) && touched.any(|other| are_of_one_wall(couple, other))
    }

    /// Encounter of the slot `slot` (candidate), one of the possible contacts with a wall, at the time `moment`. The
    /// particle touches this wall, and its contacts with the wall are recognised by their normals.
    fn encounter_by_normal(&self, slot: usize, moment: FrameTime) -> Encounter {
        let touch = &self.scratch.touches[slot];
        let here = |contact: &&Contact| are_of_one_wall(&touch.couple, &contact.touch.couple);
        let contacts: Vec<&Contact> = self.scratch.contacts.iter().filter(here).collect();
        let mut all = encounters(&touch.couple, self.particles, self.scene, moment);
        let normal = |contact: &&Contact| match (contact.course.normal, contact.touch.couple.other) {
            (Some(normal), _) => normal.cast(),
            // the contact has not been evaluated yet, so its number is still right
            (None, Other::Wall(at)) => all.get(at.which as usize).map_or_else(Vector3::zeros, |met| met.normal),
            (None, Other::Particle(_)) => Vector3::zeros(),
        };
        let normals: Vec<Vector3<f64>> = contacts.iter().map(normal).collect();
        let found = matched(&normals, &all);
        let apart = Encounter { gap: APART * touch.reach, ..Encounter::default() };
        if let Some(k) = contacts.iter().position(|contact| contact.slot as usize == slot) {
            return found[k].map_or(apart, |n| all[n]);
        }
        // the slots without a contact have the remaining encounters
        let slots = 0..slot;
        let is_free = |other: &usize| {
            are_of_one_wall(&touch.couple, &self.scratch.touches[*other].couple)
                && contacts.iter().all(|contact| contact.slot as usize != *other)
        };
        let index = slots.filter(is_free).count();
        let mut taken = found.into_iter().flatten().collect::<Vec<usize>>();
        taken.sort_unstable();
        for n in taken.into_iter().rev() {
            all.remove(n);
        }
        all.get(index).copied().unwrap_or(apart)
    }
}
