//! Contacts with a wall, such as a mesh, that numbers its contacts with a sphere by distance, the nearest first. As
//! the sphere moves, the numbers change. The record of a contact is therefore found by the normal of the contact, not
//! by its number. A slot is the number of a candidate (pair, or particle and wall) in the neighbour list.

use super::{ContactBlock, TouchingSlot};
use crate::encounter::{AtWall, Couple, Other};
use crate::engine::soft::contact_sums::ContactRows;
use crate::engine::soft::contacts::ContactSearch;
use crate::engine::soft::wall_contacts::{are_of_one_wall, encounters, is_numbered_by_distance, matched};
use nalgebra::Vector3;

impl ContactBlock {
    /// Assigns the present slots (numbers of candidates) to the contacts of the previous step, `before`, which are in
    /// ascending order of slot. A contact ends if the wall no longer has a contact with nearly the same normal.
    pub(super) fn renumber(
        &mut self,
        view: ContactSearch,
        (before, overlapping): (&mut Vec<TouchingSlot>, &[u32]),
        rows: &mut ContactRows,
    ) {
        let list = view.list;
        let mut first = before.partition_point(|touch| (touch.slot as usize) < list.pairs.len());
        while first < before.len() {
            let slot = before[first].slot;
            let couple = list.couple(slot as usize);
            let of_wall = |touch: &&TouchingSlot| are_of_one_wall(&couple, &list.couple(touch.slot as usize));
            let mut end = first + before[first..].iter().take_while(of_wall).count();
            let only = end == first + 1 && !couple.is_further() && overlapping.binary_search(&(slot + 1)).is_err();
            if !only && is_numbered_by_distance(&couple, view.scene) {
                let gone = self.renumber_at_wall(view, couple, &mut before[first..end]);
                for touch in before.drain(end - gone..end) {
                    self.close(touch, view, true, rows);
                }
                end -= gone;
            }
            first = end;
        }
    }

    /// Assigns the present slots (numbers of candidates) to the contacts `touching` of one particle with one wall.
    /// Contacts that no longer exist are moved to the end of `touching`; the function returns their number.
    fn renumber_at_wall(&self, view: ContactSearch, couple: Couple, touching: &mut [TouchingSlot]) -> usize {
        let ContactSearch { list, particles, scene, at, .. } = view;
        let all = encounters(&couple, particles, scene, at.moment());
        let number = |slot: u32| match list.couple(slot as usize).other {
            Other::Wall(at) => at.which as usize,
            Other::Particle(_) => 0,
        };
        let normal = |touch: &TouchingSlot| match self.records.get(touch.record).1.normal {
            Some(normal) => normal.cast(),
            None => all.get(number(touch.slot)).map_or_else(Vector3::zeros, |met| met.normal),
        };
        let normals: Vec<Vector3<f64>> = touching.iter().map(normal).collect();
        let slot_of = |which: usize| {
            let Other::Wall(at) = couple.other else { return None };
            list.slot(&Couple::at_wall(couple.i, AtWall { which: which as u32, ..at }))
        };
        let mut gone = 0;
        for (touch, found) in touching.iter_mut().zip(matched(&normals, &all)) {
            touch.slot = found.and_then(slot_of).map_or(u32::MAX, |slot| slot as u32);
            gone += usize::from(touch.slot == u32::MAX);
        }
        touching.sort_unstable_by_key(|touch| touch.slot);
        // a contact that ends must still have a slot of its wall
        let last = touching.len() - gone;
        touching[last..].iter_mut().for_each(|touch| touch.slot = slot_of(0).map_or(touch.slot, |slot| slot as u32));
        gone
    }
}
