//! Removal of the copies of particles of other processes (ghosts) after a part, a piece of the time between two
//! exchanges with the gas. Own particles stay with their process.

use super::CrossRankContact;
use super::domains::{Domains, LocalParticles};
use crate::encounter::{Couple, FrameTime};
use crate::engine::Overlap;
use crate::engine::driver::Work;
use crate::engine::islands::Solve;

/// New indices of the particles that stay in the store when other particles are removed.
pub struct Stay<'a> {
    /// True for each particle, by its old index, that stays in the store.
    mine: &'a [bool],
    /// Number of particles that stay; their new indices are below this number.
    count: u32,
    /// Old and new index of each particle that moves from the end of the store to the place of a removed particle, in
    /// ascending order.
    moves: Vec<(u32, u32)>,
}

impl<'a> Stay<'a> {
    fn of(mine: &'a [bool]) -> Self {
        let count = mine.iter().filter(|mine| **mine).count();
        let (first, last) = mine.split_at(count);
        let holes = (0u32..).zip(first).filter(|(_, mine)| !**mine).map(|(index, _)| index);
        let movers = (count as u32..).zip(last).filter(|(_, mine)| **mine).map(|(index, _)| index);
        Self { mine, count: count as u32, moves: movers.zip(holes).collect() }
    }

    /// New index of the particle with the old index `before`; `None` if the particle is removed.
    fn index(&self, before: u32) -> Option<u32> {
        if !self.mine[before as usize] {
            return None;
        }
        if before < self.count {
            return Some(before);
        }
        let which = self.moves.binary_search_by_key(&before, |(from, _)| *from).ok()?;
        Some(self.moves[which].1)
    }
}

impl<C: Copy> Domains<C> {
    /// Removes the copies of particles of other processes after a part (piece of the time between two exchanges with
    /// the gas) whose results are not valid. Restores the store and the contacts from before the copies were made.
    pub fn give_back(&mut self, work: &mut Work<C>, view: LocalParticles<C>) {
        work.particles.truncate(view.count);
        (*work.lasting, self.abroad) = view.lasting;
    }

    /// Removes the copies of particles of other processes, and the contacts of such copies, after a part (piece of the
    /// time between two exchanges with the gas) with valid results. `members` lists the members of islands (groups of
    /// particles that may meet); the function adapts their indices and deletes the removed copies from the list.
    pub fn keep<S: Solve<Carried = C>>(
        &mut self,
        solver: &S,
        work: &mut Work<C>,
        view: &LocalParticles<C>,
        members: &mut Vec<u32>,
    ) {
        let stay = self.keep_some(solver, work, &view.mine);
        *members = members.iter().filter_map(|&index| stay.index(index)).collect();
    }

    /// Removes all particles for which `mine` (one entry per index) is false. Removes contacts that involve only such
    /// particles. Contacts between a removed particle and one that stays are moved to `abroad`.
    pub fn keep_own<S: Solve<Carried = C>>(&mut self, solver: &S, work: &mut Work<C>, mine: &[bool]) {
        drop(self.keep_some(solver, work, mine));
    }

    /// Removes all particles for which `mine` (one entry per index) is false. Removes contacts that involve only such
    /// particles. Contacts between a removed particle and one that stays are moved to `abroad`. Returns the new
    /// indices of the particles that stay.
    pub(super) fn keep_some<'a, S: Solve<Carried = C>>(
        &mut self,
        solver: &S,
        work: &mut Work<C>,
        mine: &'a [bool],
    ) -> Stay<'a> {
        let stay = Stay::of(mine);
        let (particles, id) = (&*work.particles, &work.particles.id);
        let overlap = |couple: Couple| Overlap {
            depth: couple.meet(particles, work.scene, FrameTime::default()).overlap(),
            diameter: couple.diameter(particles),
        };
        self.abroad.clear();
        let mut home = Vec::new();
        for carried in work.lasting.drain(..) {
            let of = S::indices(&carried);
            let mut here = of.iter().flatten().filter_map(|&index| stay.index(index));
            match here.next() {
                Some(own) if of.iter().flatten().any(|&index| stay.index(index).is_none()) => {
                    let overlap = solver.touching(&carried).map(overlap);
                    self.abroad.push(CrossRankContact {
                        carried: S::moved(&carried, &|index| id[index as usize]),
                        own,
                        overlap,
                    });
                }
                Some(_) => home.push(S::moved(&carried, &|index| stay.index(index).unwrap_or(index))),
                None => {}
            }
        }
        *work.lasting = home;
        work.particles.relocate(&stay.moves);
        work.particles.truncate(stay.count as usize);
        stay
    }
}
