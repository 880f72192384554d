//! New shells of single particles. A shell is a ball around a particle, in which its neighbour list is valid.

use super::cells::rounded;
use super::list_update::ListUpdate;
use super::neighbour_lists::lists_of_mut;
use super::next_events::ParticleRange;
use super::part::Part;
use super::rounds::{PartState, pieces};
use super::search::{FoundNeighbours, has_images};
use super::{CalendarWindow, GlobalCalendar, Recent, view_of, whole_of};
use crate::engine::driver::Work;
use crate::engine::hard::impulse::ParticleAccess;
use crate::work_sharing;

/// Number of pauses between rounds (pieces of time shared by threads) in which new shells (balls in which neighbour
/// lists are valid) are made. After so many pauses, the largest speed and the regions of the threads are determined
/// again.
pub const RENEWALS: u32 = 64;

impl Part<'_> {
    /// Gives the particle at `index` a new shell (ball in which its neighbour list is valid) about its present
    /// position, and predicts its events.
    pub fn renew_shell(&mut self, index: u32) {
        self.recentre(index);
        let (around, domain) = (self.around, self.around.domain_of_lists());
        let own = lists_of_mut(self.lists, &around.shells.parts, index);
        let mut found = std::mem::take(&mut own.found);
        found.clear();
        self.counts.pair_checks += around.shells.find_neighbours(index, self.range(), &domain, &mut found);
        let across = has_images(index, &found, self.range(), (&domain, self.now));
        let (division, first, lists) = (&around.shells.parts, self.first, &mut *self.lists);
        let mut update = ListUpdate { division, first, next_events: self.next_events, lists };
        // no list elsewhere changes: a new shell has neighbours in other parts only if this part contains all particles
        update.relink(index, (&found, across), &mut Vec::new());
        lists_of_mut(self.lists, division, index).found = found;
        self.predict_events(index);
    }

    /// True if this part may give the particle at `index` a new shell (ball in which its neighbour list is valid) while
    /// other threads process the events of other parts.
    pub fn may_renew(&self, index: u32) -> bool {
        let (around, place) = (self.around, self.place(index));
        let shell = &self.next_events[place].shell;
        let new = rounded(&around.centre(&self.bodies[place], self.now));
        !shell.at_border && around.shells.may_move(index, [&shell.rounded_centre(), &new])
    }

    /// Moves the shell (ball in which the neighbour list is valid) of the particle at `index` to the present position
    /// of the particle. The neighbour list must then be made again.
    pub fn recentre(&mut self, index: u32) {
        let (around, place) = (self.around, self.place(index));
        let (body, shell) = (&self.bodies[place], &mut self.next_events[place].shell);
        let centre = rounded(&around.centre(body, self.now));
        around.shells.levels[around.shells.level(body)].cells.change(index, shell.rounded_centre(), centre);
        *shell = shell.about(centre, around.at_wall(body, self.now));
    }

    /// The particles of this part (those of one thread), with their flights and shells.
    pub fn range(&self) -> ParticleRange<'_> {
        ParticleRange { first: self.first, bodies: self.bodies, next_events: self.next_events }
    }
}

impl GlobalCalendar {
    /// Makes new shells (balls in which neighbour lists are valid) for the particles that need them, and predicts the
    /// events of these particles.
    pub(super) fn renew_shells(&mut self, work: &mut Work<Recent>, span: CalendarWindow) {
        for index in self.border.leaving.drain(..) {
            self.parts[self.shells.parts.number(index)].round.leaving.push(index);
        }
        let (around, particles) = (view_of!(self, work.scene), ParticleAccess::Shared(work.particles));
        let mut all = whole_of!(self, &around, particles, work.log, span);
        for PartState { round, .. } in &mut self.parts {
            round.leaving.sort_unstable();
            round.leaving.dedup();
            round.leaving.iter().for_each(|&index| all.recentre(index));
        }
        let (domain, range) = ((&work.scene.domain, all.now), all.range());
        let found: Vec<FoundNeighbours> = work_sharing::map(self.parts.iter(), |part| {
            around.shells.neighbours_of_each(part.round.leaving.iter().copied(), range, domain)
        });
        self.pair_checks += found.iter().map(|found| found.checks).sum::<u64>();
        self.relink(&found);
        for index in self.parts.iter_mut().flat_map(|part| part.round.leaving.drain(..)) {
            self.shells.note_move(index, &self.next_events[index as usize].shell.rounded_centre());
        }
        self.note_renewal();
        self.predict_first_of_round(work.scene);
    }

    /// Makes the particles in `found` the neighbours of the particles in `Round::leaving` of each part (particles of
    /// one thread). Each thread changes the lists of its part. The few changes in lists of other parts are made
    /// afterwards.
    fn relink(&mut self, found: &[FoundNeighbours]) {
        let division = &self.shells.parts;
        let pieces = pieces(&mut self.parts, division, &mut self.next_events).into_iter();
        let elsewhere = work_sharing::map(pieces.zip(&mut self.lists).zip(found), |((piece, lists), found)| {
            let (PartState { round, .. }, first, next_events) = piece;
            let mut update = ListUpdate { division, first, next_events, lists: std::slice::from_mut(lists) };
            let mut elsewhere = Vec::new();
            for (&index, list) in round.leaving.iter().zip(found.each()) {
                update.relink(index, list, &mut elsewhere);
            }
            round.predicted.extend(&round.leaving);
            elsewhere
        });
        let (next_events, lists) = (&mut self.next_events, &mut self.lists);
        let mut all = ListUpdate { division, first: 0, next_events, lists };
        elsewhere.into_iter().flatten().for_each(|change| all.apply(change));
    }

    /// Counts the pauses between rounds (pieces of time shared by threads) in which new shells (balls in which
    /// neighbour lists are valid) are made. After every [`RENEWALS`] pauses, the largest speed and the regions of the
    /// threads are determined again.
    fn note_renewal(&mut self) {
        (self.renewed_at, self.renewals) = (self.now, self.renewals + 1);
        if self.renewals.is_multiple_of(RENEWALS) {
            self.limit_speed();
            self.shells.divide_cells(&self.next_events);
        }
    }
}
