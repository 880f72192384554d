//! Event queue of all particles: events of the near future are sorted by time, later ones wait in unsorted bins.
//!
//! The queue contains the next event of each particle; the time of this event is stored in the particle's
//! [`NextEvents`]. Each bin covers an equal interval of time and contains only particle indices. The bins form a ring
//! that is used again and again. If the event of a particle changes, its outdated entry is not removed from its bin.
//! When the time of a bin comes, outdated entries are skipped, and all other entries are sorted.

use super::append;
use super::bins::Bins;
use super::next_events::NextEvents;
use prefetch_index::prefetch_index;
use std::cmp::Ordering;

/// Intended number of events in each bin (interval of time) of the near future. It is small enough for cheap insertion,
/// and large enough that there are few bins.
const PER_BIN: usize = 32;

/// Number of queued events divided by the number of bins (intervals of time) in the ring, before the number of bins is
/// rounded up to a power of two. It is less than [`PER_BIN`], since bins of later times contain fewer events. So the
/// ring covers at least about 64 times the time in which the earliest sixteenth of the events happens.
const PARTICLES_PER_BIN: usize = 8;

/// An entry of the sorted list of near events. The entry is outdated if the time of the particle's next event has
/// changed since the entry was made.
#[derive(Clone, Copy, Debug)]
struct QueuedEvent {
    /// Time [s] of the event since the epoch, the instant from which the event queue counts times.
    time: f64,
    index: u32,
}

impl QueuedEvent {
    /// Order of two events: the earlier event comes first. If their times are equal, the event of the particle with the
    /// lower id comes first. `ids` contains the id of each particle.
    #[inline]
    fn compare(&self, other: &Self, ids: &[u32]) -> Ordering {
        self.time.total_cmp(&other.time).then_with(|| ids[self.index as usize].cmp(&ids[other.index as usize]))
    }
}

/// Table of the next events of particles with consecutive indices, and of the ids of all particles.
#[derive(Clone, Copy)]
pub struct EventTable<'a> {
    /// Index of the first particle of the table.
    pub first: u32,
    /// Next two events of each particle, from the first particle on.
    pub next_events: &'a [NextEvents],
    /// Id of each particle, by particle index.
    pub ids: &'a [u32],
}

impl EventTable<'_> {
    /// Time [s] of the next event of a particle, given by its index, since the epoch (instant from which times are
    /// counted).
    #[inline]
    fn time(&self, index: u32) -> f64 {
        self.next_events[(index - self.first) as usize].time
    }
}

/// Event queue of all particles: a sorted list of near events, and unsorted bins (intervals of time) of later events.
/// Times are counted from the instant called epoch.
#[derive(Clone, Debug, Default)]
pub struct EventQueue {
    /// Events of the present bin (interval of time) and of earlier bins, sorted by time with the earliest event at the
    /// end of the list.
    near: Vec<QueuedEvent>,
    /// Ring of bins that cover successive equal intervals of time; each contains the indices of the particles with an
    /// event in its interval.
    bins: Bins,
    /// Number of particle indices in all bins (intervals of time), outdated indices included.
    in_bins: usize,
    /// Indices of particles whose events are too late for the ring of bins, which covers only a limited time ahead.
    later: Vec<u32>,
    /// [1/s] number of bins per time, the inverse of the interval of a bin.
    rate: f64,
    /// Number of the bin that contains the present time, counted from the epoch (instant from which times are counted).
    /// The place of this bin in the ring is its number modulo the number of bins.
    current: u64,
}

impl EventQueue {
    /// Fills the queue with the next events of all particles in `table` that are earlier than `before` [s]; the present
    /// time is `now` [s]. Both times are counted from the epoch (zero of the event queue's time). The interval of time
    /// that a bin covers is chosen from these events.
    pub fn fill(&mut self, table: EventTable, now: f64, before: f64) {
        let mut times = Vec::with_capacity(table.next_events.len());
        times.extend(table.next_events.iter().map(|events| events.time).filter(|time| *time < before));
        self.near.clear();
        self.later.clear();
        self.bins.reset((times.len() / PARTICLES_PER_BIN).next_power_of_two().max(64));
        self.in_bins = 0;
        let sample = times.len() / 16;
        self.rate = 1.0;
        if !times.is_empty() {
            let (_, time, _) = times.select_nth_unstable_by(sample, f64::total_cmp);
            let rate = (sample + 1) as f64 / (PER_BIN as f64 * (*time - now));
            self.rate = if rate.is_finite() && rate > 0.0 { rate } else { 1.0 };
        }
        // frees this memory, which the bins need
        drop(times);
        self.current = self.bin(now);
        for (index, events) in (table.first..).zip(table.next_events) {
            if events.time < before {
                self.insert(index, table);
            }
        }
    }

    /// Empties the queue, and chooses the interval of time that each bin covers. The caller then inserts a few events,
    /// of which those before `end` [s] will be processed. The present time is `now` [s]. Both times are counted from
    /// the epoch (zero of the event queue's time).
    pub fn restart(&mut self, now: f64, end: f64) {
        self.near.clear();
        self.later.clear();
        self.bins.reset(64);
        self.in_bins = 0;
        let rate = 16.0 / (end - now);
        self.rate = if rate.is_finite() { rate } else { 1.0 };
        self.current = self.bin(now);
    }

    /// Removes all entries, outdated entries included, and calls `each` with the index of the particle of every entry.
    pub fn drain(&mut self, mut each: impl FnMut(u32)) {
        self.near.drain(..).for_each(|entry| each(entry.index));
        if self.in_bins > 0 {
            (0..self.bins.count()).for_each(|bin| self.bins.empty(bin, &mut each));
        }
        self.in_bins = 0;
        self.later.drain(..).for_each(each);
    }

    fn bin(&self, time: f64) -> u64 {
        (time * self.rate) as u64
    }

    /// Index in the ring of the bin with the number `bin`, which counts the bins since the epoch (zero of time).
    #[inline]
    fn slot(&self, bin: u64) -> usize {
        (bin & (self.bins.count() as u64 - 1)) as usize
    }

    /// True if the bin with the number `bin`, counted from the epoch (zero of time), is beyond the end of the ring,
    /// because the ring covers earlier times only.
    #[inline]
    fn is_later(&self, bin: u64) -> bool {
        bin.saturating_sub(self.current) >= self.bins.count() as u64
    }

    /// Adds the next event of a particle, given by its index, to the queue after this event has changed. The time of
    /// the event in `table` must be finite.
    #[inline]
    pub fn insert(&mut self, index: u32, table: EventTable) {
        let time = table.time(index);
        let bin = self.bin(time);
        if bin <= self.current {
            let entry = QueuedEvent { time, index };
            let at = self.near.partition_point(|other| other.compare(&entry, table.ids).is_gt());
            self.near.insert(at, entry);
        } else if !self.is_later(bin) {
            self.bins.put(self.slot(bin), index);
            self.in_bins += 1;
        } else {
            append(&mut self.later, index);
        }
    }

    /// Removes the earliest event, and returns the index of its particle. `None` if no event is earlier than `before`
    /// [s] since the epoch (instant from which times are counted).
    #[inline]
    pub fn next(&mut self, table: EventTable, before: f64) -> Option<u32> {
        loop {
            while let Some(entry) = self.near.last() {
                let valid = table.time(entry.index) == entry.time;
                if valid && entry.time >= before {
                    return None;
                }
                let QueuedEvent { time, index } = *entry;
                self.near.pop();
                if valid {
                    // an entry that was outdated for a while may have become valid again
                    while self.near.last().is_some_and(|next| next.index == index && next.time == time) {
                        self.near.pop();
                    }
                    return Some(index);
                }
            }
            if self.current >= self.bin(before) || !self.next_bin(table) {
                return None;
            }
        }
    }

    /// Index of the particle whose event comes `after` events after the earliest one (0: the earliest). `None` if this
    /// event is not yet in the sorted list. The entry may be outdated, if the next event of that particle has changed
    /// since.
    #[inline]
    pub fn upcoming(&self, after: usize) -> Option<u32> {
        self.near.len().checked_sub(after + 1).map(|at| self.near[at].index)
    }

    /// Advances to the next bin (interval of time) that may contain events, and sorts the events of this bin into the
    /// list of near events. Returns false if no event is queued.
    fn next_bin(&mut self, table: EventTable) -> bool {
        if self.in_bins == 0 {
            // continues with the first of the events that were too far ahead for the ring
            let times = self.later.iter().map(|&index| table.time(index));
            let first = times.fold(f64::INFINITY, f64::min);
            if first == f64::INFINITY {
                return false;
            }
            self.current = self.bin(first).max(self.current);
            self.move_later_to_bins(table);
            return true;
        }
        self.current += 1;
        let slot = self.slot(self.current);
        if slot == 0 {
            self.move_later_to_bins(table);
        }
        let Self { bins, near, in_bins, rate, current, .. } = self;
        bins.empty(slot, |index| {
            let time = table.time(index);
            *in_bins -= 1;
            if (time * *rate) as u64 == *current {
                near.push(QueuedEvent { time, index });
            }
        });
        self.near.sort_unstable_by(|a, b| b.compare(a, table.ids));
        self.fetch_ahead(table);
        true
    }

    /// Prefetches into the processor's cache the events of the next bin (interval of time), and the first particle
    /// indices of the bin after the next.
    fn fetch_ahead(&self, table: EventTable) {
        self.bins
            .indices(self.slot(self.current + 1))
            .for_each(|index| prefetch_index(table.next_events, (index - table.first) as usize));
        self.bins.fetch(self.slot(self.current + 2));
    }

    /// Moves the events whose times the ring of bins now covers from the list `later` to the bins.
    fn move_later_to_bins(&mut self, table: EventTable) {
        let (count, mut kept) = (self.later.len(), 0);
        for k in 0..count {
            let index = self.later[k];
            let time = table.time(index);
            if time < f64::INFINITY {
                if self.is_later(self.bin(time)) {
                    self.later[kept] = index;
                    kept += 1;
                } else {
                    self.insert(index, table);
                }
            }
        }
        self.later.truncate(kept);
    }
}
