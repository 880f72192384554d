//! Rounds: short pieces of time in which several threads process the events of dense hard spheres.
//!
//! Each thread has a part of the particles. The particles of a part have consecutive indices, so they fill a region of
//! the box. A shell is a ball around a particle in which its neighbour list is valid. Times are counted from the
//! *epoch*, the zero of the event queue's time. A round has three steps:
//!
//! 1. Each thread processes the events of its part as if there were no other parts. A particle whose next event is a
//!    touch with a particle of another part is *stopped*. A particle whose next event is a touch with a stopped
//!    particle is stopped too.
//! 2. Each thread predicts the events of particles at the border of its part again, now with all neighbours.
//! 3. One thread processes the events of stopped particles, and the events that step 2 has found, in the order of time.
//!
//! If an event of step 3 is found too late, because its particle has already had a later event, the round is undone and
//! repeated with a shorter length. This is rare, because few particles have two events in a round. The time of a touch
//! depends only on two flights, so the results are bit for bit equal to the results of a single thread.
//!
//! A particle that comes near the surface of its shell gets a new shell at once, if all cells around it belong to its
//! part ([`Territories`](super::territories::Territories)). Otherwise the particle gets a new shell after the round, or
//! after a later round. Until then, it may fly on by a small distance, which is left for this purpose. If a particle
//! becomes so fast that it may fly farther, the round is undone, and one thread repeats it. An undone round leaves new
//! shells where they are: within a round, no particle flies farther than the small distance, so each particle was
//! inside its new shell also at the start of the round.

use super::division::Division;
use super::event_queue::{EventQueue, EventTable};
use super::neighbour_lists::NeighbourLists;
use super::next_events::{EventKind, NextEvents};
use super::part::{EventCounts, Part};
use super::prediction::Flights;
use super::records::Records;
use super::territories::MOST_PARTS;
use super::undo::Undo;
use super::{CalendarWindow, GlobalCalendar, Recent, view_of, whole_of};
use crate::engine::Failure;
use crate::engine::driver::Work;
use crate::engine::hard::impulse::ParticleAccess;
use crate::particles::Particles;
use crate::record::{Log, Record};
use crate::scene::Scene;
use crate::work_sharing;

/// Smallest number of particles in a part (the particles of one thread). With 4000 in each of two parts, two threads
/// were slower than one.
const FEWEST: usize = 10_000;

/// [-] distance inside the surface of a particle's shell (ball in which its neighbour list is valid), divided by the
/// shell's radius, at which the exit from the shell is processed. The particle may fly on by this distance until it
/// gets a new shell.
const SLACK: f64 = 0.08;

/// [-] speed that no particle may exceed in a round (piece of time shared by threads), divided by the largest speed of
/// any particle. The largest speed is computed only at intervals ([`RENEWALS`](super::renewal::RENEWALS)).
const FASTER: f64 = 1.25;

/// [-] factor by which rounds (pieces of time shared by threads) become longer after each successful round with few
/// collisions.
const LONGER: f64 = 1.01;

/// [-] factor by which rounds (pieces of time shared by threads) become shorter after each failed round. With these
/// values of `SHORTER` and [`LONGER`], about one round in twenty fails.
const SHORTER: f64 = 0.8;

/// [-] shortest length of a round (piece of time shared by threads), divided by the longest. The first round has the
/// shortest length: just after a random start there are very many collisions, and the states that are stored to undo
/// them would need much memory.
const SHORTEST: f64 = 1e-3;

/// Number of particles per collision in a round (piece of time shared by threads), above which the next rounds become
/// longer. So this ratio limits the memory of the states that are stored to undo a round.
const PER_COLLISION: usize = 128;

/// Largest number of failures after which a round (piece of time shared by threads) is tried again; after one more
/// failure, one thread processes its events.
const ATTEMPTS: u32 = 3;

/// Data that events write in one round (piece of time shared by threads). The events are those of one part (the
/// particles of one thread), or those that concern several parts.
#[derive(Clone, Default)]
pub struct Round {
    /// [s] time since the epoch (zero of the event queue's time) at which the round begins.
    pub start: f64,
    /// Indices of particles that need new shells (balls in which their neighbour lists are valid).
    pub leaving: Vec<u32>,
    /// Indices of particles whose events were predicted without their neighbours in other parts (particles of other
    /// threads). In the data of events that concern several parts: indices of particles whose next event is a touch
    /// with another particle.
    pub predicted: Vec<u32>,
    /// States of particles before the events, by which the round (piece of time shared by threads) can be undone.
    pub undo: Undo,
    /// Collisions of this piece of time, with the amounts that they add to the ledger (sums of energies and momenta).
    pub records: Records,
    /// Numbers of collisions and of tested pairs in this round (piece of time shared by threads).
    pub counts: EventCounts,
    /// [m/s] speed that no particle may exceed in the round (piece of time shared by threads).
    pub speed: f64,
    /// True for the events that concern several parts (particles of several threads), which one thread processes last.
    pub is_border: bool,
    /// True if a particle was too fast, or if an event failed; one thread then repeats the round (this piece of time).
    pub must_be_repeated: bool,
    /// [s] time since the epoch (zero of time) of the earliest event that was processed too early, before an event on
    /// which it depends. The events from `start` to this time are then repeated. Infinite if there is no such event.
    pub early: f64,
}

impl Round {
    fn begin(&mut self, start: f64, speed: f64, is_border: bool) {
        (self.start, self.speed, self.is_border) = (start, speed, is_border);
        (self.must_be_repeated, self.early) = (false, f64::INFINITY);
    }

    /// Checks the order of two events of a particle: the present one at `now` [s], and the one at `time` [s] with which
    /// its flight began. Both times are counted from the epoch (zero of the event queue's time). If `time` is later
    /// than `now`, the event at `time` was processed too early.
    #[inline]
    pub fn note_order(&mut self, time: f64, now: f64) {
        if time > now {
            self.early = self.early.min(time);
        }
    }

    /// True if the round (piece of time shared by threads) must be undone.
    pub fn has_failed(&self) -> bool {
        self.must_be_repeated || self.early < f64::INFINITY
    }
}

/// State of one part (the particles of one thread), stored from one round (piece of time shared by threads) to the
/// next. The states of two parts share no cache line, nor a pair of lines that processors fetch together.
#[repr(align(128))]
#[derive(Clone, Default)]
pub struct PartState {
    queue: EventQueue,
    /// One bit for each particle of the part. It is set if the particle is stopped, because it will touch a particle of
    /// another part or a stopped particle.
    stopped: Vec<u64>,
    /// Indices of particles whose next event is left to the single thread that processes the events between parts.
    deferred: Vec<u32>,
    /// Indices of particles whose next event, after the end of the round (piece of time), is a touch with a particle of
    /// another part (group of particles of one thread).
    across: Vec<u32>,
    /// Data that the events of a round (piece of time shared by threads) write.
    pub round: Round,
    /// Log of the collisions. Its impacts are added to `record` at the start of the next round.
    log: Log,
    /// Statistics of the impacts since the start of the window.
    record: Record,
}

impl PartState {
    /// Predicts the events of the particles in `round.predicted` with the neighbours in all parts (particles of all
    /// threads). Events before `end` [s] since the epoch are left to the last step of a round. `next_events` are those
    /// of this part, whose first particle has the index `first`, and `lists` their neighbour lists.
    fn complete(
        &mut self,
        all: Flights,
        (first, next_events, lists): (u32, &mut [NextEvents], &NeighbourLists),
        end: f64,
    ) {
        let Self { queue, deferred, across, round, .. } = self;
        let own = first..first + next_events.len() as u32;
        round.predicted.sort_unstable();
        for same in round.predicted.chunk_by(|a, b| a == b) {
            let index = same[0];
            let (body, events) = (&all.bodies[index as usize], &mut next_events[(index - first) as usize]);
            let all = Flights { now: all.now.max(body.time), ..all };
            let before = events.time;
            all.predict_into(body, events, lists);
            round.counts.pair_checks += u64::from(events.shell.count());
            let neighbours = lists.neighbours(&events.shell).iter();
            // a particle that was predicted twice may have had a flight that this prediction does not include
            let had_others = |j: &&u32| same.len() > 1 || all.bodies[**j as usize].time > round.start;
            let unknown = neighbours.filter(|j| !own.contains(j)).filter(had_others);
            let late = unknown.filter_map(|&j| all.may_have_touched(body, j, round.start, round.speed));
            round.early = late.fold(round.early, f64::min);
            if events.time < end {
                deferred.push(index);
            } else {
                if matches!(events.kind, EventKind::Pair(j) if !own.contains(&j)) {
                    across.push(index);
                }
                // an event at the same time is already in the queue
                if events.time != before {
                    queue.insert(index, EventTable { first, next_events, ids: all.around.ids });
                }
            }
        }
        round.predicted.clear();
    }
}

/// Processes the events of a part (the particles of one thread) up to `end` [s] since the epoch as if there were no
/// other parts. A particle is stopped if its next event is a touch with a particle of another part or with a stopped
/// particle. Its index is then added to `deferred`. `stopped` has one bit for each particle of the part.
fn process(mut part: Part, stopped: &mut [u64], deferred: &mut Vec<u32>, end: f64) {
    while let Some(index) = part.next(end) {
        let is_stopped = |index: u32, stopped: &[u64]| {
            let place = part.place(index);
            place >= part.bodies.len() || stopped[place / 64] >> (place % 64) & 1 == 1
        };
        let place = part.place(index);
        let touches_stopped = match part.next_events[place].kind {
            EventKind::Pair(j) => is_stopped(j, stopped),
            EventKind::Wall(_) | EventKind::LeaveShell | EventKind::Predict => false,
        };
        if touches_stopped || is_stopped(index, stopped) {
            stopped[place / 64] |= 1 << (place % 64);
            deferred.push(index);
        } else if !part.event_in_round(index) {
            return;
        }
    }
}

/// Parts (particles of one thread), each with the index of its first particle and the next events of its particles.
pub fn pieces<'a>(
    parts: &'a mut [PartState],
    division: &Division,
    mut next_events: &'a mut [NextEvents],
) -> Vec<(&'a mut PartState, u32, &'a mut [NextEvents])> {
    let mut first = 0;
    let piece = |part| {
        let own = division.of(first);
        let events = next_events.split_off_mut(..own.len()).unwrap_or_default();
        first = own.end;
        (part, own.start, events)
    };
    parts.iter_mut().map(piece).collect()
}

impl GlobalCalendar {
    /// True if several threads share the events of a window.
    pub(super) fn is_shared(&self, scene: &Scene) -> bool {
        self.number_of_parts() > 1 && self.may_be_shared(scene)
    }

    /// True if the scene allows several threads to share the events of a window. The number of particles is not tested.
    pub(super) fn may_be_shared(&self, scene: &Scene) -> bool {
        !scene.is_kicked()
            && self.far_images == [false; 3]
            && scene.domain.shear.is_none()
            && scene.rotation.is_none()
            && !scene.has_moving_walls()
    }

    /// Number of parts into which the particles are divided if several threads share the events.
    pub(super) fn number_of_parts(&self) -> usize {
        rayon::current_num_threads().min(self.bodies.len() / FEWEST).min(MOST_PARTS)
    }

    /// Processes all events up to the time `stop` [s] since the epoch by several threads, in rounds (pieces of time).
    pub(super) fn rounds(&mut self, work: &mut Work<Recent>, span: CalendarWindow, stop: f64) -> Result<(), Failure> {
        let (mut failures, mut until) = (0, f64::INFINITY);
        while self.now < stop {
            if self.parts.len() != self.number_of_parts() {
                self.divide(work.scene);
            }
            let renewal = self.renewed_at + 0.5 * self.grace;
            let end = (self.now + self.round).min(stop).min(renewal).min(until);
            self.process_parts(work, span, end);
            self.complete(work.scene, end);
            self.process_border(work, span, end);
            let rounds = || self.parts.iter().map(|part| &part.round).chain([&self.border]);
            if rounds().all(|round| !round.has_failed()) {
                let before = self.events;
                self.finish(work);
                (self.now, failures, until) = (end, 0, f64::INFINITY);
                if ((self.events - before) as usize) < self.bodies.len() / PER_COLLISION {
                    self.round = (LONGER * self.round).min(0.5 * self.grace);
                }
                self.clock.tell(span.time(end));
                if end >= renewal || end >= stop {
                    self.renew_shells(work, span);
                }
                continue;
            }
            failures += 1;
            let early = rounds().map(|round| round.early).fold(end, f64::min);
            let repeat = rounds().any(|round| round.must_be_repeated) || failures > ATTEMPTS;
            self.undo(work.scene);
            self.round *= SHORTER;
            if repeat {
                self.count_impacts(work.record);
                self.renew_shells(work, span);
                self.one_after_the_other(work, span, end)?;
                until = f64::INFINITY;
            } else {
                until = early;
            }
        }
        self.count_impacts(work.record);
        Ok(())
    }

    /// Adds the statistics of impacts of all parts (particles of one thread) to the record of the run.
    fn count_impacts(&mut self, record: &mut Record) {
        for part in &mut self.parts {
            part.record.count(&mut part.log.impacts);
            record.merge(&part.record);
            part.record = Record::default();
        }
    }

    /// Divides the particles into parts, one for each thread.
    fn divide(&mut self, scene: &Scene) {
        let slack = SLACK * self.shells.margin;
        let is_new = self.slack != slack;
        (self.slack, self.renewed_at, self.renewals) = (slack, self.now, 0);
        self.limit_speed();
        if self.lists.len() != self.number_of_parts() {
            let division = Division::new(self.bodies.len(), self.number_of_parts());
            (self.lists, self.next_events) = self.shells.copy_lists(&self.lists, &division, &self.next_events);
            self.shells.parts = division;
        }
        self.shells.divide_cells(&self.next_events);
        if is_new {
            self.predict_all(scene);
        }
        // frees the memory of the events, which the parts need
        self.queue = EventQueue::default();
        self.parts = vec![PartState::default(); self.shells.parts.count()];
        let pieces = pieces(&mut self.parts, &self.shells.parts, &mut self.next_events);
        for ((part, first, next_events), lists) in pieces.into_iter().zip(&self.lists) {
            part.queue.fill(EventTable { first, next_events, ids: &self.ids }, self.now, self.horizon);
            part.stopped.resize(next_events.len().div_ceil(64), 0);
            let own = first..first + next_events.len() as u32;
            for events in next_events {
                let mut neighbours = lists.neighbours(&events.shell).iter();
                events.shell.at_border = neighbours.any(|k| !own.contains(k));
            }
        }
    }

    /// Chooses the speed that no particle may exceed in a round (piece of time shared by threads), and the length of
    /// the next round. Also chooses the time for which touches are predicted after an exit from a shell.
    pub(super) fn limit_speed(&mut self) {
        let fastest = self.bodies.iter().map(|body| body.velocity.norm_squared()).fold(0.0, f64::max).sqrt();
        self.speed = FASTER * fastest;
        let longest = self.slack / self.speed;
        self.round = self.round.clamp(SHORTEST * longest, longest);
        self.grace = 2.0 * longest;
    }

    /// Processes the events of all parts up to `end` [s] since the epoch, each part by one thread (step 1 of a round).
    fn process_parts(&mut self, work: &mut Work<Recent>, span: CalendarWindow, end: f64) {
        let (around, now, speed) = (view_of!(self, work.scene), self.now, self.speed);
        let particles: &Particles = work.particles;
        let (mut bodies, mut histories) = (self.bodies.as_mut_slice(), self.last_collisions.as_mut_slice());
        let mut with_flights = Vec::new();
        let pieces = pieces(&mut self.parts, &self.shells.parts, &mut self.next_events);
        for ((part, first, next_events), lists) in pieces.into_iter().zip(&mut self.lists) {
            let bodies = bodies.split_off_mut(..next_events.len()).unwrap_or_default();
            let histories = histories.split_off_mut(..next_events.len()).unwrap_or_default();
            with_flights.push((part, first, next_events, bodies, histories, lists));
        }
        work_sharing::for_each(
            with_flights.into_iter(),
            |(state, first, next_events, bodies, last_collisions, lists)| {
                let PartState { queue, stopped, deferred, round, log, record, .. } = state;
                record.count(&mut log.impacts);
                let (counts, particles) = (EventCounts::default(), ParticleAccess::Shared(particles));
                round.begin(now, speed, false);
                let round = Some(round);
                let around = &around;
                let part = Part {
                    around,
                    particles,
                    first,
                    bodies,
                    next_events,
                    last_collisions,
                    lists: std::slice::from_mut(lists),
                    queue,
                    now,
                    span,
                    log,
                    counts,
                    round,
                };
                process(part, stopped, deferred, end);
            },
        );
    }

    /// Predicts the events of particles at the borders of parts again, now with the neighbours in all parts (step 2 of
    /// a round). Events before `end` [s] since the epoch are left to one thread.
    fn complete(&mut self, scene: &Scene, end: f64) {
        let (around, bodies, now) = (view_of!(self, scene), self.bodies.as_slice(), self.now);
        let all = Flights { around: &around, first: 0, bodies, now, in_order: false };
        let pieces = pieces(&mut self.parts, &self.shells.parts, &mut self.next_events);
        work_sharing::for_each(pieces.into_iter().zip(&self.lists), |((part, first, next_events), lists)| {
            part.complete(all, (first, next_events, lists), end);
        });
    }

    /// Processes by one thread the events that concern several parts (particles of several threads), up to `end` [s]
    /// since the epoch. This is the last step of a round.
    fn process_border(&mut self, work: &mut Work<Recent>, span: CalendarWindow, end: f64) {
        let (mut parts, mut border) = (std::mem::take(&mut self.parts), std::mem::take(&mut self.border));
        let mut log = Log::default();
        border.begin(self.now, self.speed, true);
        self.queue.restart(self.now, end);
        let (around, particles) = (view_of!(self, work.scene), ParticleAccess::Shared(work.particles));
        let mut part = whole_of!(self, &around, particles, &mut log, span);
        part.round = Some(&mut border);
        let mut first = 0;
        for PartState { stopped, deferred, .. } in &mut parts {
            for &index in &*deferred {
                stopped[(index - first) as usize / 64] = 0;
                part.enqueue(index);
            }
            first = part.around.shells.parts.of(first).end;
        }
        if parts.iter().all(|part| !part.round.has_failed()) {
            while let Some(index) = part.next(end) {
                if !part.event_in_round(index) {
                    break;
                }
            }
        }
        if let Some(part) = parts.first_mut() {
            part.log.impacts.append(&mut log.impacts);
        }
        (self.parts, self.border) = (parts, border);
    }

    /// Restores the state before the present round (piece of time shared by threads), which has failed. The next events
    /// of all particles that had events are predicted again, since some of these particles have new shells.
    fn undo(&mut self, scene: &Scene) {
        let Self { parts, border, bodies, next_events, last_collisions, shells, .. } = self;
        let mut changed = Vec::new();
        for round in [border].into_iter().chain(parts.iter_mut().map(|part| &mut part.round)) {
            round.undo.restore(bodies, last_collisions, &mut changed);
            round.records.clear();
            round.predicted.clear();
            round.counts.collisions = 0;
        }
        for part in &mut *parts {
            part.across.clear();
            part.log.impacts.clear();
            changed.append(&mut part.deferred);
        }
        for index in changed {
            // the present event may not be in the queue of the part
            next_events[index as usize].time = f64::INFINITY;
            parts[shells.parts.number(index)].round.predicted.push(index);
        }
        self.predict_first_of_round(scene);
    }

    /// Adds the collisions of a successful round (piece of time shared by threads) to the log of the run. Moves the
    /// remaining events from the queue of the single thread back to the queues of the parts.
    fn finish(&mut self, work: &mut Work<Recent>) {
        let Self { parts, border, queue, shells, next_events, ids, .. } = self;
        let lists: Vec<&Records> = parts.iter().map(|part| &part.round.records).chain([&border.records]).collect();
        Records::merge(&lists, work.log, work.record, self.events);
        let across = std::mem::take(&mut border.predicted);
        queue.drain(|index| {
            let table = EventTable { first: 0, next_events, ids };
            if next_events[index as usize].time < self.horizon {
                parts[shells.parts.number(index)].queue.insert(index, table);
            }
        });
        parts.iter_mut().for_each(|part| part.deferred.clear());
        for round in [border].into_iter().chain(parts.iter_mut().map(|part| &mut part.round)) {
            let EventCounts { collisions, pair_checks } = std::mem::take(&mut round.counts);
            self.events += collisions;
            self.pair_checks += pair_checks;
            round.undo.clear();
            round.records.clear();
        }
        self.store_with_partners(across);
    }

    /// Stores each coming touch of two particles of different parts also in the entry of the partner, which must be
    /// stopped at this touch too. `across` and `PartState::across` contain the indices of particles whose next event
    /// may be such a touch.
    fn store_with_partners(&mut self, mut across: Vec<u32>) {
        let Self { parts, shells, bodies, next_events, ids, .. } = self;
        parts.iter_mut().for_each(|part| across.append(&mut part.across));
        for index in across {
            let NextEvents { time, kind, detail, .. } = next_events[index as usize];
            if let EventKind::Pair(j) = kind
                && time < next_events[j as usize].time
                && bodies[j as usize].collision_count == detail
            {
                next_events[j as usize].put_first(time, index, bodies[index as usize].collision_count);
                let table = EventTable { first: 0, next_events, ids };
                parts[shells.parts.number(j)].queue.insert(j, table);
            }
        }
    }

    /// Predicts the events of the particles in `Round::predicted` of each part, at the start of a round.
    pub(super) fn predict_first_of_round(&mut self, scene: &Scene) {
        self.parts.iter_mut().for_each(|part| part.round.begin(self.now, self.speed, false));
        self.complete(scene, self.now);
        self.store_with_partners(Vec::new());
    }
}
