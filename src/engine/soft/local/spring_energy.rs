//! Springs of an island by contact: their indices, their energy, and their hand-over to the contacts.

use super::springs::{ContactMotion, SpringKind};
use super::{InstantaneousRule, IslandRun};
use crate::engine::soft::contact::Contact;
use std::ops::Range;

impl<I: InstantaneousRule> IslandRun<'_, I> {
    /// Kinds of springs of each contact.
    #[inline(always)]
    pub(super) fn kinds(&self) -> &'static [SpringKind] {
        let resists = self.scene.rotation.as_ref().is_some_and(|rotation| rotation.resists());
        if resists { &SpringKind::ALL } else { &SpringKind::ALL[..1] }
    }

    /// Indices of the springs of contact `k`.
    pub(super) fn springs_of(&self, k: usize) -> Range<usize> {
        let kinds = self.kinds().len();
        k * kinds..(k + 1) * kinds
    }

    /// [J] energies of the springs of contact `k`: of the tangential one, and of rolling and twisting.
    fn energies_of(&self, k: usize) -> [f64; 2] {
        let Contact { touch, course, .. } = &self.scratch.contacts[k];
        let springs = self.springs_of(k);
        let shear = &self.scratch.sliding[springs.start].shear;
        // most springs do not depend on the overlap, which has to be computed
        if touch.tangential.half_powers == 0 && course.resistance.is_none() {
            return [touch.tangential.energy(shear), 0.0];
        }
        let (touch, met) = self.met(k);
        let sheared = touch.tangential.at(met.overlap()).energy(shear);
        let motion = ContactMotion::of(self, &touch, &met, self.resists(k));
        let resisted = springs.zip(self.kinds()).skip(1).map(|(index, &kind)| {
            motion.spring(kind, &touch, &met).constants.energy(&self.scratch.sliding[index].shear)
        });
        [sheared, resisted.sum()]
    }

    /// [J] energy of the springs of pairs and of walls.
    pub(super) fn spring_energies(&self) -> [f64; 2] {
        let mut energies = [0.0; 2];
        for (k, contact) in self.scratch.contacts.iter().enumerate() {
            let [sheared, resisted] = self.energies_of(k);
            energies[usize::from(contact.touch.couple.is_wall())] += sheared + resisted;
        }
        energies
    }

    /// Takes what springs hold more than the energies [J] that they `stored` before a step from the work that friction
    /// did in it.
    pub(super) fn keep_in_springs(&mut self, stored: [f64; 2]) {
        let kept = self.spring_energies();
        let ledger = &mut self.island.log.ledger;
        ledger.pair_friction_loss -= kept[0] - stored[0];
        ledger.wall_friction_loss -= kept[1] - stored[1];
    }

    /// Removes the springs of contact `k`, which has ended: friction takes the energy that they still hold.
    pub(super) fn drop_springs(&mut self, k: usize) {
        let left: f64 = self.energies_of(k).iter().sum();
        let (springs, is_wall) = (self.springs_of(k), self.scratch.contacts[k].touch.couple.is_wall());
        self.scratch.sliding.drain(springs);
        let ledger = &mut self.island.log.ledger;
        match is_wall {
            true => ledger.wall_friction_loss += left,
            false => ledger.pair_friction_loss += left,
        }
    }

    /// Leaves the shears to the contacts.
    pub(super) fn leave_springs(&mut self) {
        for k in 0..self.scratch.contacts.len() {
            let springs = self.springs_of(k);
            let shear = |kind: SpringKind| self.scratch.sliding[springs.start + kind as usize].shear;
            let slid = shear(SpringKind::Slide);
            if self.scratch.contacts[k].course.resistance.is_some() {
                let (_, met) = self.met(k);
                let [_, energy] = self.energies_of(k);
                let (roll, twist) = (shear(SpringKind::Roll), shear(SpringKind::Twist).dot(&met.normal));
                if let Some(memory) = &mut self.scratch.contacts[k].course.resistance {
                    (memory.roll, memory.twist, memory.energy) = (roll, twist, energy);
                }
            }
            self.scratch.contacts[k].course.shear = slid;
        }
    }
}
