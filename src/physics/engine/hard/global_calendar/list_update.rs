//! Changes of neighbour lists after a particle has got a new shell, the ball in which the neighbour list of the
//! particle is valid. A part is a set of particles with consecutive indices, whose events one thread processes.

use super::division::Division;
use super::neighbour_lists::{NeighbourLists, lists_of, lists_of_mut};
use super::next_events::NextEvents;
use super::shells::Shell;

/// Neighbour lists to be changed: those of all particles, or those of one part (the particles of one thread). The next
/// events of the particles are included, since they contain the locations of the lists.
pub struct ListUpdate<'a> {
    /// Division of all particles into parts, one for each thread.
    pub division: &'a Division,
    /// Index, in the particle store, of the first particle whose list is included.
    pub first: u32,
    /// Next events of the particles whose lists are included; the field `shell` contains the location of the list.
    pub next_events: &'a mut [NextEvents],
    /// Neighbour lists: one item for a part (particles of one thread), or one item for each part if the lists of all
    /// particles are included.
    pub lists: &'a mut [NeighbourLists],
}

/// Change of the neighbour list of one particle: another particle is added or removed.
#[derive(Clone, Copy, Debug)]
pub struct ListChange {
    /// Index of the particle whose list changes.
    of: u32,
    /// Index of the particle that is added or removed.
    other: u32,
    /// True if `other` is added, false if it is removed.
    is_added: bool,
    /// True if the prediction of touches must look for the nearest periodic image of `other` (its copy, shifted by an
    /// edge of the box).
    across: bool,
}

impl ListUpdate<'_> {
    /// Makes the particles in `found` the neighbours of the particle at `index`, and updates the lists of its old and
    /// of its new neighbours. `across` is true if the prediction of touches must look for the nearest periodic images
    /// of the particles in `found`. Changes of lists that belong to other threads are appended to `elsewhere`.
    pub fn relink(&mut self, index: u32, (found, across): (&[u32], bool), elsewhere: &mut Vec<ListChange>) {
        let shell = *self.shell(index);
        let own = lists_of_mut(self.lists, self.division, index);
        let mut old = std::mem::take(&mut own.old);
        old.set(own.neighbours(&shell));
        let (indices, mut at_border) = (self.division.of(index), false);
        // most neighbours stay neighbours, so only the lists of new and of lost neighbours are changed
        for &j in found {
            at_border |= !indices.contains(&j);
            if !old.remove(j, index) {
                self.change(ListChange { of: j, other: index, is_added: true, across }, elsewhere);
            }
        }
        for j in old.rest(index) {
            self.change(ListChange { of: j, other: index, is_added: false, across }, elsewhere);
        }
        let mut shell = *self.shell(index);
        let own = lists_of_mut(self.lists, self.division, index);
        own.replace(index, found, &mut shell);
        (shell.at_border, shell.across) = (at_border, across);
        own.old = old;
        *self.shell(index) = shell;
    }

    /// Makes a change to a neighbour list that another thread has requested. Does nothing if the list already contains
    /// that change, because the particle has got a new list at the same time.
    pub fn apply(&mut self, change: ListChange) {
        let shell = *self.shell(change.of);
        let near = lists_of(self.lists, self.division, change.of).neighbours(&shell);
        if near.contains(&change.other) != change.is_added {
            self.change(change, &mut Vec::new());
        }
    }

    /// Makes a change to a neighbour list. The change is appended to `elsewhere` instead if the list is not included
    /// here, because it belongs to a particle of another thread.
    #[inline]
    fn change(&mut self, change: ListChange, elsewhere: &mut Vec<ListChange>) {
        let ListChange { of, other, is_added, across } = change;
        let Some(NextEvents { shell, .. }) = self.next_events.get_mut(of.wrapping_sub(self.first) as usize) else {
            return elsewhere.push(change);
        };
        let lists = lists_of_mut(self.lists, self.division, of);
        if is_added {
            lists.add(shell, of, other);
            shell.at_border |= !self.division.of(of).contains(&other);
            shell.across |= across;
        } else {
            lists.remove(shell, of, other);
        }
    }

    fn shell(&mut self, index: u32) -> &mut Shell {
        &mut self.next_events[(index - self.first) as usize].shell
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Neighbours of the particle at `index`, in ascending order.
    fn neighbours(update: &mut ListUpdate, index: u32) -> Vec<u32> {
        let shell = *update.shell(index);
        let mut near = lists_of_mut(update.lists, update.division, index).neighbours(&shell).to_vec();
        near.sort_unstable();
        near
    }

    #[test]
    fn lists_of_old_and_new_neighbours_change_in_both_parts() {
        let division = Division::new(6, 2);
        let mut lists = vec![NeighbourLists::default(); 2];
        let mut next_events = vec![NextEvents::blank(); 6];
        // a chain of six particles; 0 to 2 belong to the first part
        for (index, events) in (0u32..).zip(&mut next_events) {
            let near: Vec<u32> = (0..6).filter(|other| index.abs_diff(*other) == 1).collect();
            lists_of_mut(&mut lists, &division, index).append(index, &near, &mut events.shell);
        }
        let (own, others) = next_events.split_at_mut(3);
        let first = &mut lists[..1];
        let mut elsewhere = Vec::new();
        let mut update = ListUpdate { division: &division, first: 0, next_events: own, lists: first };
        update.relink(2, (&[0, 3, 4], true), &mut elsewhere);
        assert_eq!([0, 1, 2].map(|index| neighbours(&mut update, index)), [vec![1, 2], vec![0], vec![0, 3, 4]]);
        assert!(update.shell(2).at_border && update.shell(2).across);
        assert!(update.shell(0).across && !update.shell(0).at_border && !update.shell(1).across);
        // particle 3 stays a neighbour of 2, so only the list of particle 4 must change in the other part
        assert_eq!(elsewhere.len(), 1);
        let mut update = ListUpdate { division: &division, first: 3, next_events: others, lists: &mut lists[1..] };
        elsewhere.into_iter().for_each(|change| update.apply(change));
        assert_eq!([3, 4].map(|index| neighbours(&mut update, index)), [vec![2, 4], vec![2, 3, 5]]);
        assert!(update.shell(4).at_border && !update.shell(5).at_border);
    }

    #[test]
    fn two_particles_of_different_parts_that_get_lists_at_once_are_neighbours_once() {
        let division = Division::new(4, 2);
        let mut lists = vec![NeighbourLists::default(); 2];
        let mut next_events = vec![NextEvents::blank(); 4];
        for (index, events) in (0u32..).zip(&mut next_events) {
            lists_of_mut(&mut lists, &division, index).append(index, &[3 - index], &mut events.shell);
        }
        // 0 and 3 cease to be neighbours, and 0 and 2 become neighbours; all three have new shells
        let mut elsewhere = Vec::new();
        let parts = next_events.split_at_mut(2);
        for (first, part, own, found) in
            [(0, parts.0, 0..1, vec![(0, vec![2])]), (2, parts.1, 1..2, vec![(2, vec![1, 0]), (3, vec![])])]
        {
            let mut update = ListUpdate { division: &division, first, next_events: part, lists: &mut lists[own] };
            found.iter().for_each(|(index, near)| update.relink(*index, (near, false), &mut elsewhere));
        }
        let mut all = ListUpdate { division: &division, first: 0, next_events: &mut next_events, lists: &mut lists };
        elsewhere.into_iter().for_each(|change| all.apply(change));
        let near: Vec<_> = (0..4).map(|index| neighbours(&mut all, index)).collect();
        assert_eq!(near, [vec![2], vec![2], vec![0, 1], vec![]]);
    }
}
