//! Contacts with rough walls that begin or end in a step, for one block (range of slots). A slot is the number of a
//! candidate (pair, or particle and wall) in the neighbour list.

use super::ContactBlock;
use crate::encounter::Couple;
use crate::engine::soft::contacts::ContactSearch;
use crate::neighbours::NeighbourList;
use nalgebra::Vector3;

/// Contacts with rough walls that begin or end in a step, for one block (range of candidates in the neighbour list).
/// Both lists are empty between two steps.
#[derive(Default)]
pub struct FacetTurns {
    /// Slots (numbers of candidates) of contacts that begin, in ascending order, with the rotation vectors [rad] by
    /// which velocities have been turned.
    begun: Vec<(u32, Vector3<f64>)>,
    /// Couples (pairs of bodies) whose contacts have ended, with the rotation vectors [rad] by which their velocities
    /// were turned at the beginning.
    ended: Vec<(Couple, Vector3<f64>)>,
}

impl FacetTurns {
    /// Adds the rotation vector `turn` [rad] of a contact that begins at the slot `slot` (candidate of the neighbour
    /// list).
    pub fn begin(&mut self, slot: u32, turn: Vector3<f64>) {
        self.begun.push((slot, turn));
    }

    /// True if a rough wall has turned the velocity of the particle for a contact that begins at this slot (candidate
    /// of the neighbour list).
    pub fn begins(&self, slot: u32) -> bool {
        self.begun.iter().any(|(begun, _)| *begun == slot)
    }

    /// Removes and returns the rotation vector [rad] of the contact that begins at a slot (candidate of the neighbour
    /// list); `None` if no contact begins there.
    pub fn take(&mut self, slot: u32) -> Option<Vector3<f64>> {
        let k = self.begun.iter().position(|(begun, _)| *begun == slot)?;
        Some(self.begun.remove(k).1)
    }

    /// Adds the rotation vector `turn` [rad] of a contact that has ended. Does nothing if `turn` is `None`, as for a
    /// contact with a smooth wall.
    pub fn end(&mut self, couple: &Couple, turn: Option<Vector3<f64>>) {
        self.ended.extend(turn.map(|turn| (*couple, turn)));
    }
}

impl ContactBlock {
    /// Adds to `slots` the slots (candidates) of the block at which a contact with a rough wall begins at the present
    /// positions.
    pub fn find_begun_at_rough_walls(&self, view: ContactSearch, slots: &mut Vec<u32>) {
        let ContactSearch { list, particles, scene, .. } = view;
        let pairs = list.pairs.len();
        let first = self.slots.start.max(pairs);
        let touches = |slot: usize| self.touching.binary_search_by_key(&(slot as u32), |touch| touch.slot).is_ok();
        for slot in first..self.slots.end {
            let near = &list.walls[slot - pairs];
            let is_rough = scene.walls[near.at.wall as usize].roughness.is_some();
            let free_until = self.free_until.get(slot - first).filter(|_| view.at.travel_is_exact);
            let is_free = free_until.is_some_and(|until| *until > list.travelled());
            if is_rough && !is_free && near.gap(particles, scene) < 0.0 && !touches(slot) {
                slots.push(slot as u32);
            }
        }
    }

    /// Moves the contacts with rough walls that have ended, or that were expected to begin and did not, to `left`. The
    /// entries of `left` are couples (pairs of bodies) and rotation vectors [rad].
    pub fn take_left_facets(&mut self, list: &NeighbourList, left: &mut Vec<(Couple, Vector3<f64>)>) {
        let FacetTurns { begun, ended } = &mut self.facets;
        left.append(ended);
        left.extend(begun.drain(..).map(|(slot, turn)| (list.couple(slot as usize), turn)));
    }
}
