//! Who comes next? Near events in order, far ones in unsorted bins.
//!
//! Each particle has one event, on its [`Card`]. Bins hold places only, and nothing is ever taken out of them: when a bin's turn
//! comes, whoever's event is no longer in it is left out. What is due within the present bin is kept in order.

use super::card::Card;

/// Events of a bin, about: so few that putting one between them is cheap, so many that there are few bins.
const PER_BIN: usize = 32;

/// Particles per bin of a revolution.
const PARTICLES_PER_BIN: usize = 8;

/// An event of the present bin.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// [s] since the epoch.
    time: f64,
    id: u32,
    place: u32,
}

impl Entry {
    /// Whether it comes after another: later, or at the same time and of a higher id.
    fn follows(&self, other: &Self) -> bool {
        self.time.total_cmp(&other.time).then(self.id.cmp(&other.id)).is_gt()
    }
}

/// The events of all particles.
#[derive(Clone, Debug, Default)]
pub struct Agenda {
    /// What is due in the present bin or before, the last first.
    near: Vec<Entry>,
    /// A ring of bins of equal length, which turns: places of particles.
    bins: Vec<Vec<u32>>,
    /// Places in the bins.
    filed: usize,
    /// Beyond a revolution of the ring.
    later: Vec<u32>,
    /// [1/s] bins per time.
    rate: f64,
    /// The present bin, counted from the epoch.
    current: u64,
}

impl Agenda {
    /// Files all events before `before` [s]; it is `now` [s] since the epoch.
    pub fn fill(&mut self, cards: &[Card], now: f64, before: f64) {
        let mut times: Vec<f64> = cards.iter().map(|card| card.time).filter(|time| *time < before).collect();
        self.near.clear();
        self.later.clear();
        self.bins.iter_mut().for_each(Vec::clear);
        self.bins.resize((times.len() / PARTICLES_PER_BIN).next_power_of_two().max(64), Vec::new());
        self.filed = 0;
        let sample = times.len() / 16;
        self.rate = 1.0;
        if !times.is_empty() {
            let (_, time, _) = times.select_nth_unstable_by(sample, f64::total_cmp);
            let rate = (sample + 1) as f64 / (PER_BIN as f64 * (*time - now));
            self.rate = if rate.is_finite() && rate > 0.0 { rate } else { 1.0 };
        }
        self.current = self.bin(now);
        for (place, card) in cards.iter().enumerate().filter(|(_, card)| card.time < before) {
            self.file(place as u32, card);
        }
    }

    fn bin(&self, time: f64) -> u64 {
        (time * self.rate) as u64
    }

    /// Takes note of the event on a card that has changed; it must not be infinitely far.
    #[inline]
    pub fn file(&mut self, place: u32, card: &Card) {
        let bin = self.bin(card.time);
        let ring = self.bins.len() as u64;
        if bin <= self.current {
            let entry = Entry { time: card.time, id: card.id, place };
            let at = self.near.partition_point(|other| other.follows(&entry));
            self.near.insert(at, entry);
        } else if bin - self.current < ring {
            self.bins[(bin & (ring - 1)) as usize].push(place);
            self.filed += 1;
        } else {
            self.later.push(place);
        }
    }

    /// Takes out the next event before `before` [s]: whose it is.
    #[inline]
    pub fn next(&mut self, cards: &[Card], before: f64) -> Option<u32> {
        loop {
            while let Some(entry) = self.near.last() {
                let valid = cards[entry.place as usize].time == entry.time;
                if valid && entry.time >= before {
                    return None;
                }
                let place = entry.place;
                self.near.pop();
                if valid {
                    return Some(place);
                }
            }
            if self.current >= self.bin(before) || !self.turn(cards) {
                return None;
            }
        }
    }

    /// Goes on to the next bin; false if nothing is filed.
    fn turn(&mut self, cards: &[Card]) -> bool {
        if self.filed == 0 {
            // straight to the first of those that were too far for the ring
            let times = self.later.iter().map(|&place| cards[place as usize].time);
            let first = times.fold(f64::INFINITY, f64::min);
            if first == f64::INFINITY {
                return false;
            }
            self.current = self.bin(first).max(self.current);
            self.refile(cards);
            return true;
        }
        let ring = self.bins.len() as u64;
        self.current += 1;
        let slot = (self.current & (ring - 1)) as usize;
        if slot == 0 {
            self.refile(cards);
        }
        let mut bin = std::mem::take(&mut self.bins[slot]);
        self.filed -= bin.len();
        for &place in &bin {
            let card = &cards[place as usize];
            if self.bin(card.time) == self.current {
                self.near.push(Entry { time: card.time, id: card.id, place });
            }
        }
        bin.clear();
        self.bins[slot] = bin;
        self.near.sort_unstable_by(|a, b| b.time.total_cmp(&a.time).then(b.id.cmp(&a.id)));
        true
    }

    /// Files what was too far for the ring anew.
    fn refile(&mut self, cards: &[Card]) {
        for place in std::mem::take(&mut self.later) {
            let card = &cards[place as usize];
            if card.time < f64::INFINITY {
                self.file(place, card);
            }
        }
    }
}
