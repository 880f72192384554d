//! Springs of the contacts of an island (group of particles that may meet): their indices, energies and losses, and the
//! storage of their state in the contacts.

use super::sliding::Phase;
use super::springs::{ContactMotion, SpringKind, SpringMotion};
use super::{InstantaneousRule, IslandRun};
use crate::encounter::Encounter;
use crate::engine::soft::contact::{Contact, TouchingPair};
use crate::record::FrictionLosses;
use nalgebra::Vector3;
use std::ops::Range;

/// Energies of the springs of an island [J].
#[derive(Clone, Copy, Debug, Default)]
pub struct SpringEnergies {
    /// [J] energies of the springs of all kinds: in contacts of pairs (first), and in contacts with walls (second).
    by_partner: [f64; 2],
    /// [J] energy of the rolling springs of all contacts.
    rolling: f64,
    /// [J] energy of the twisting springs of all contacts.
    twisting: f64,
}

impl<I: InstantaneousRule> IslandRun<'_, I> {
    /// Kinds of springs that each contact of the island has: sliding alone, or sliding, rolling and twisting.
    #[inline(always)]
    pub(super) fn kinds(&self) -> &'static [SpringKind] {
        let resists = self.scene.rotation.as_ref().is_some_and(|rotation| rotation.resists());
        if resists { &SpringKind::ALL } else { &SpringKind::ALL[..1] }
    }

    /// Range of the springs of contact `k` in the list of all springs of the island.
    pub(super) fn springs_of(&self, k: usize) -> Range<usize> {
        let kinds = self.kinds().len();
        k * kinds..(k + 1) * kinds
    }

    /// True if contact `k` is old enough to resist rolling and twisting.
    pub(super) fn resists(&self, k: usize) -> bool {
        let springs = self.springs_of(k);
        springs.len() > 1 && self.scratch.sliding[springs.start + 1].phase != Phase::Waiting
    }

    /// The two bodies of contact `k`, and their present encounter (relative position and velocity).
    pub(super) fn met(&self, k: usize) -> (TouchingPair, Encounter) {
        let Contact { slot, touch, .. } = self.scratch.contacts[k];
        (touch, self.encounter(slot as usize, &touch.couple, self.moment()))
    }

    /// [J] energies of the tangential, the rolling and the twisting spring of contact `k`.
    fn energies_of(&self, k: usize) -> [f64; 3] {
        let Contact { touch, course, .. } = &self.scratch.contacts[k];
        let springs = self.springs_of(k);
        let shear = &self.scratch.sliding[springs.start].shear;
        // the energy of a spring with constant stiffness does not depend on the overlap, which then need not be
        // computed
        if touch.tangential.half_powers == 0 && course.resistance.is_none() {
            return [touch.tangential.energy(shear), 0.0, 0.0];
        }
        let (touch, met) = self.met(k);
        let sheared = touch.tangential.at(met.overlap()).energy(shear);
        let motion = ContactMotion::of(self, &touch, &met, self.resists(k));
        let mut energies = [sheared, 0.0, 0.0];
        for (index, &kind) in springs.zip(self.kinds()).skip(1) {
            energies[kind as usize] =
                motion.spring(kind, &touch, &met).constants.energy(&self.scratch.sliding[index].shear);
        }
        energies
    }

    /// [W] power that the tangential force `force` [N] of a contact dissipates, listed by cause: the dashpot while the
    /// contact sticks, and the spring, which loses energy because its stiffness changes.
    #[inline(always)]
    pub(super) fn tangential_losses(
        &self,
        index: usize,
        spring: &SpringMotion,
        force: &Vector3<f64>,
    ) -> FrictionLosses {
        let (constants, velocity) = (&spring.constants, &spring.velocity);
        let (damped, shear) = match self.scratch.sliding[index].phase {
            Phase::Stick => (constants.dashpot, force - velocity * constants.dashpot),
            Phase::Slide => {
                let along = force.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
                (0.0, along * (spring.limit - constants.dashpot * velocity.dot(&along)).max(0.0))
            }
            Phase::Memoryless | Phase::Waiting | Phase::Free => return FrictionLosses::default(),
        };
        let rescaling = if constants.half_powers > 0 && constants.stiffness > 0.0 {
            (spring.rates.forgotten - spring.rates.force) * 0.5 * shear.norm_squared() / constants.stiffness
        } else {
            0.0
        };
        FrictionLosses::new(damped * velocity.norm_squared(), [0.0, rescaling, 0.0, 0.0])
    }

    /// Present energies [J] of the springs of all contacts of the island.
    pub(super) fn spring_energies(&self) -> SpringEnergies {
        let mut energies = SpringEnergies::default();
        for (k, contact) in self.scratch.contacts.iter().enumerate() {
            let [sheared, rolling, twisting] = self.energies_of(k);
            energies.by_partner[usize::from(contact.touch.couple.is_wall())] += sheared + (rolling + twisting);
            energies.rolling += rolling;
            energies.twisting += twisting;
        }
        energies
    }

    /// Subtracts the energy that springs have gained in a step of `dt` [s] from the work of friction in this step.
    /// `stored` contains the energies of the springs before the step. Also records the work of friction by cause.
    pub(super) fn keep_in_springs(&mut self, stored: &SpringEnergies, dt: f64) {
        let kept = self.spring_energies();
        let ledger = &mut self.island.log.ledger;
        ledger.pair_friction_loss -= kept.by_partner[0] - stored.by_partner[0];
        ledger.wall_friction_loss -= kept.by_partner[1] - stored.by_partner[1];
        ledger.friction += self.scratch.losses * dt;
        ledger.friction.rolling -= kept.rolling - stored.rolling;
        ledger.friction.twisting -= kept.twisting - stored.twisting;
    }

    /// Removes the springs of contact `k`, which has ended. Their remaining energy is recorded as lost by friction.
    pub(super) fn drop_springs(&mut self, k: usize) {
        let [sheared, rolling, twisting] = self.energies_of(k);
        let left = sheared + (rolling + twisting);
        let (springs, is_wall) = (self.springs_of(k), self.scratch.contacts[k].touch.couple.is_wall());
        self.scratch.sliding.drain(springs);
        let ledger = &mut self.island.log.ledger;
        ledger.friction.separation += left;
        match is_wall {
            true => ledger.wall_friction_loss += left,
            false => ledger.pair_friction_loss += left,
        }
    }

    /// Stores the shears [m] and energies [J] of the springs in their contacts, which continue after this island (group
    /// of particles) is solved.
    pub(super) fn leave_springs(&mut self) {
        for k in 0..self.scratch.contacts.len() {
            let springs = self.springs_of(k);
            let shear = |kind: SpringKind| self.scratch.sliding[springs.start + kind as usize].shear;
            let slid = shear(SpringKind::Slide);
            if self.scratch.contacts[k].course.resistance.is_some() {
                let (_, met) = self.met(k);
                let [_, energies @ ..] = self.energies_of(k);
                let (roll, twist) = (shear(SpringKind::Roll), shear(SpringKind::Twist).dot(&met.normal));
                if let Some(memory) = &mut self.scratch.contacts[k].course.resistance {
                    (memory.roll, memory.twist, memory.energies) = (roll, twist, energies);
                }
            }
            self.scratch.contacts[k].course.shear = slid;
        }
    }
}
