//! Who comes next? Near events in order, far ones in unsorted bins.
//!
//! Each particle has one event, on its [`NextEvents`]. Bins hold places only, and nothing is ever taken out of them: when a bin's turn
//! comes, whoever's event is no longer in it is left out. What is due within the present bin is kept in order.

use super::bins::Bins;
use super::next_events::NextEvents;
use prefetch_index::prefetch_index;
use std::cmp::Ordering;

/// Events of a bin, about: so few that putting one between them is cheap, so many that there are few bins.
const PER_BIN: usize = 32;

/// Particles per bin of a revolution.
const PARTICLES_PER_BIN: usize = 8;

/// An event of the present bin.
#[derive(Clone, Copy, Debug)]
struct QueuedEvent {
    /// [s] since the epoch.
    time: f64,
    place: u32,
}

impl QueuedEvent {
    /// How it comes compared with another: by time, and at the same time by the ids of all places.
    #[inline]
    fn compare(&self, other: &Self, ids: &[u32]) -> Ordering {
        self.time.total_cmp(&other.time).then_with(|| ids[self.place as usize].cmp(&ids[other.place as usize]))
    }
}

/// What is known of all particles, by place.
#[derive(Clone, Copy)]
pub struct EventTable<'a> {
    /// Their events.
    pub next_events: &'a [NextEvents],
    /// Their ids.
    pub ids: &'a [u32],
}

impl EventTable<'_> {
    /// [s] when the event of a particle is due, since the epoch.
    #[inline]
    fn time(&self, place: u32) -> f64 {
        self.next_events[place as usize].time
    }
}

/// The events of all particles.
#[derive(Clone, Debug, Default)]
pub struct EventQueue {
    /// What is due in the present bin or before, the last first.
    near: Vec<QueuedEvent>,
    /// A ring of bins of equal length, which turns: places of particles.
    bins: Bins,
    /// Places in the bins.
    filed: usize,
    /// Beyond a revolution of the ring.
    later: Vec<u32>,
    /// [1/s] bins per time.
    rate: f64,
    /// The present bin, counted from the epoch.
    current: u64,
}

impl EventQueue {
    /// Files all events before `before` [s]; it is `now` [s] since the epoch.
    pub fn fill(&mut self, book: EventTable, now: f64, before: f64) {
        let mut times = Vec::with_capacity(book.next_events.len());
        times.extend(book.next_events.iter().map(|card| card.time).filter(|time| *time < before));
        self.near.clear();
        self.later.clear();
        self.bins.reset((times.len() / PARTICLES_PER_BIN).next_power_of_two().max(64));
        self.filed = 0;
        let sample = times.len() / 16;
        self.rate = 1.0;
        if !times.is_empty() {
            let (_, time, _) = times.select_nth_unstable_by(sample, f64::total_cmp);
            let rate = (sample + 1) as f64 / (PER_BIN as f64 * (*time - now));
            self.rate = if rate.is_finite() && rate > 0.0 { rate } else { 1.0 };
        }
        // the bins will need the memory
        drop(times);
        self.current = self.bin(now);
        for (place, _) in book.next_events.iter().enumerate().filter(|(_, card)| card.time < before) {
            self.file(place as u32, book);
        }
    }

    fn bin(&self, time: f64) -> u64 {
        (time * self.rate) as u64
    }

    /// Where the ring has a bin.
    #[inline]
    fn slot(&self, bin: u64) -> usize {
        (bin & (self.bins.count() as u64 - 1)) as usize
    }

    /// Whether a bin is beyond a revolution of the ring.
    #[inline]
    fn is_later(&self, bin: u64) -> bool {
        bin.saturating_sub(self.current) >= self.bins.count() as u64
    }

    /// Takes note of the event on a card that has changed; it must not be infinitely far.
    #[inline]
    pub fn file(&mut self, place: u32, book: EventTable) {
        let time = book.time(place);
        let bin = self.bin(time);
        if bin <= self.current {
            let entry = QueuedEvent { time, place };
            let at = self.near.partition_point(|other| other.compare(&entry, book.ids).is_gt());
            self.near.insert(at, entry);
        } else if !self.is_later(bin) {
            self.bins.put(self.slot(bin), place);
            self.filed += 1;
        } else {
            if self.later.len() == self.later.capacity() {
                // not twice as much, as it would by itself
                self.later.reserve_exact(self.later.len() / 8 + 64);
            }
            self.later.push(place);
        }
    }

    /// Takes out the next event before `before` [s]: whose it is.
    #[inline]
    pub fn next(&mut self, book: EventTable, before: f64) -> Option<u32> {
        loop {
            while let Some(entry) = self.near.last() {
                let valid = book.time(entry.place) == entry.time;
                if valid && entry.time >= before {
                    return None;
                }
                let place = entry.place;
                self.near.pop();
                if valid {
                    return Some(place);
                }
            }
            if self.current >= self.bin(before) || !self.turn(book) {
                return None;
            }
        }
    }

    /// Whose event comes `after` so many others, as far as the present bin says.
    #[inline]
    pub fn upcoming(&self, after: usize) -> Option<u32> {
        self.near.len().checked_sub(after + 1).map(|at| self.near[at].place)
    }

    /// Goes on to the next bin; false if nothing is filed.
    fn turn(&mut self, book: EventTable) -> bool {
        if self.filed == 0 {
            // straight to the first of those that were too far for the ring
            let times = self.later.iter().map(|&place| book.time(place));
            let first = times.fold(f64::INFINITY, f64::min);
            if first == f64::INFINITY {
                return false;
            }
            self.current = self.bin(first).max(self.current);
            self.refile(book);
            return true;
        }
        self.current += 1;
        let slot = self.slot(self.current);
        if slot == 0 {
            self.refile(book);
        }
        let Self { bins, near, filed, rate, current, .. } = self;
        bins.empty(slot, |place| {
            let time = book.time(place);
            *filed -= 1;
            if (time * *rate) as u64 == *current {
                near.push(QueuedEvent { time, place });
            }
        });
        self.near.sort_unstable_by(|a, b| b.compare(a, book.ids));
        self.fetch_ahead(book);
        true
    }

    /// Calls into the cache what the next two turns will look at: the events of the next bin, and where the one after that keeps its places.
    fn fetch_ahead(&self, book: EventTable) {
        self.bins
            .places(self.slot(self.current + 1))
            .for_each(|place| prefetch_index(book.next_events, place as usize));
        self.bins.fetch(self.slot(self.current + 2));
    }

    /// Files what was too far for the ring anew.
    fn refile(&mut self, book: EventTable) {
        let (count, mut kept) = (self.later.len(), 0);
        for k in 0..count {
            let place = self.later[k];
            let time = book.time(place);
            if time < f64::INFINITY {
                if self.is_later(self.bin(time)) {
                    self.later[kept] = place;
                    kept += 1;
                } else {
                    self.file(place, book);
                }
            }
        }
        self.later.truncate(kept);
    }
}
