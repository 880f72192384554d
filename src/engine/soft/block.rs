//! The contacts in one part of the neighbour list.
//!
//! Blocks share nothing that changes, so they are evaluated beside each other, and what they leave is added up in their order: results are
//! the same for any number of threads. The record of a contact stays where it is for as long as the contact lasts; what is sorted by slot
//! and made anew at every step is an index of eight bytes.

use super::contact::{Contact, ContactState, TouchingPair};
use super::contacts::ContactSearch;
use super::pushes::{ForceBuffer, ForceIncrement, StoreIndex};
use super::records::Records;
use super::tally::ContactRows;
use crate::contact_law::ContactLaw;
use crate::encounter::{Couple, Encounter, FrameTime, Partner};
use crate::engine::Failure;
use crate::neighbours::NeighbourList;
use crate::record::{Between, Impact};
use nalgebra::Vector3;
use std::ops::Range;

/// Contacts that are looked at one after the other once it is known how all of them stand: 2 kB.
const BATCH: usize = 32;

/// Makes room for `room` in all, and a little more: lists of contacts would take up to twice their length if they grew by doubling.
pub fn reserve<T>(list: &mut Vec<T>, room: usize) {
    if room > list.capacity() {
        list.reserve_exact(room + room / 8 + 8 - list.len());
    }
}

/// A slot where two bodies touch, and the place of its record.
#[derive(Clone, Copy, Debug)]
struct TouchingSlot {
    slot: u32,
    record: u32,
}

/// What an evaluation of the forces did.
#[derive(Clone, Copy, Debug, Default)]
pub struct ForceEvaluation {
    /// Forces computed.
    pub forces: u64,
    /// Slots looked at for an overlap.
    pub checks: u64,
}

/// What an evaluation of the forces adds up.
#[derive(Default)]
pub struct ForceSums {
    /// What the forces dissipate and pass on.
    pub rows: ContactRows,
    /// [J] stored in the contacts, where they do not know it themselves: in a predicted state.
    pub elastic_energy: f64,
    /// What that took.
    pub done: ForceEvaluation,
    /// Of the contacts that made no sense the one of the smallest ids.
    pub failure: Option<Failure>,
}

impl ForceSums {
    fn clear(&mut self) {
        self.rows.clear();
        (self.elastic_energy, self.done, self.failure) = (0.0, ForceEvaluation::default(), None);
    }
}

/// What an evaluation needs for itself; blocks that are evaluated one after the other share it.
#[derive(Default)]
pub struct BlockScratch {
    /// What single contacts dissipate and pass on.
    rows: ContactRows,
    /// The contacts of the step before.
    before: Vec<TouchingSlot>,
    /// Slots that overlap.
    overlapping: Vec<u32>,
    /// Slots that may overlap soon.
    near: Vec<u32>,
}

/// The contacts of a range of slots.
#[derive(Default)]
pub struct ContactBlock {
    slots: Range<usize>,
    /// In ascending order of slot.
    touching: Vec<TouchingSlot>,
    records: Records,
    /// Contacts that the last predicted state met first, in ascending order of slot.
    foreseen: Vec<Contact>,
    /// Slots of pairs that may overlap until the list's particles have travelled as far as `near_until`, in ascending order.
    near: Vec<u32>,
    /// [m] in the list's account of travel; `None` before the first look.
    near_until: Option<f64>,
    /// The same of walls.
    near_walls: Vec<u32>,
    /// [m] in the list's account of travel, of each slot of a wall: up to where the two cannot touch.
    free_until: Vec<f64>,
    /// Accelerations of the last evaluation.
    pub pushes: ForceBuffer,
    /// Impacts that ended in it.
    pub ended: Vec<(Between, Impact)>,
    /// What the last evaluation added up.
    pub sums: ForceSums,
}

impl ContactBlock {
    /// Of those slots, without contacts so far.
    pub fn of(slots: Range<usize>) -> Self {
        Self { slots, ..Self::default() }
    }

    /// Takes a contact of its slots over, whose bodies may be named in the other order than in the list.
    pub fn put(&mut self, contact: &Contact, list: &NeighbourList) {
        let Contact { touch, course, slot } = *contact;
        let course = if list.couple(slot as usize) == touch.couple { course } else { course.reversed() };
        let record = self.records.keep(&touch, course);
        let all = self.touching.len() + 1;
        reserve(&mut self.touching, all);
        self.touching.push(TouchingSlot { slot: contact.slot, record });
    }

    /// Takes a contact of its slots over that the last predicted state met first.
    pub fn put_foreseen(&mut self, contact: Contact) {
        self.foreseen.push(contact);
    }

    /// Puts what it has taken over in order.
    pub fn sort(&mut self) {
        self.touching.sort_unstable_by_key(|touch| touch.slot);
        self.foreseen.sort_unstable_by_key(|contact| contact.slot);
    }

    /// Gives back the memory of what is found anew for another list.
    pub fn shed(&mut self) {
        (self.near, self.near_walls, self.near_until) = (Vec::new(), Vec::new(), None);
        (self.free_until, self.ended, self.pushes) = (Vec::new(), Vec::new(), ForceBuffer::default());
        self.sums = ForceSums::default();
    }

    /// Forgets which of its slots may overlap soon.
    pub fn look_anew(&mut self) {
        self.near_until = None;
        self.free_until.clear();
    }

    /// How many contacts are in progress.
    pub fn count(&self) -> usize {
        self.touching.len()
    }

    /// Who touches whom, in ascending order of slot.
    pub fn couples(&self, list: &NeighbourList) -> impl Iterator<Item = Couple> {
        self.touching.iter().map(|touch| list.couple(touch.slot as usize))
    }

    /// The contacts in progress, in ascending order of slot, if those are their [`couples`](Self::couples).
    pub fn contacts(&self, couples: impl Iterator<Item = Couple>) -> impl Iterator<Item = Contact> {
        self.touching.iter().zip(couples).map(|(&TouchingSlot { slot, record }, couple)| {
            let (touch, course) = self.records.get(record, couple);
            Contact { slot, touch, course }
        })
    }

    /// Contacts that the last predicted state met first, in ascending order of slot.
    pub fn foreseen(&self) -> &[Contact] {
        &self.foreseen
    }

    /// Finds what overlaps, and computes its forces. Where contacts begin and end (`opens`), opens and closes them.
    pub fn evaluate(&mut self, view: ContactSearch, law: &ContactLaw, scratch: &mut BlockScratch) {
        self.sums.clear();
        let BlockScratch { rows, before, overlapping, near } = scratch;
        self.find(view, overlapping, near);
        self.pushes.clear(overlapping.len());
        let counted = |slot: &&u32| view.counts(&view.list.couple(**slot as usize));
        let all = overlapping.len();
        let forces = if view.mine.is_none() { all } else { overlapping.iter().filter(counted).count() };
        self.sums.done.forces = forces as u64;
        if view.at.opens {
            before.clone_from(&self.touching);
            self.go_on(view, law, (before, overlapping));
            self.look_at_all(view, law, rows);
        } else {
            self.foresee(view, law, (overlapping, rows));
        }
        rows.leave(&mut self.sums.rows);
    }

    /// Finds the slots that overlap. Most pairs of the list are too far apart to touch soon, and so are most walls: those that are not are
    /// listed anew from time to time, which finds the same.
    fn find(&mut self, view: ContactSearch, overlapping: &mut Vec<u32>, near: &mut Vec<u32>) {
        let ContactSearch { list, particles, scene, at, .. } = view;
        overlapping.clear();
        let Some(skin) = list.inner_skin().filter(|_| at.travel_is_exact) else {
            self.sums.done.checks += self.slots.len() as u64;
            list.overlapping_within(self.slots.clone(), particles, scene, overlapping);
            return;
        };
        if self.near_until.is_none_or(|until| list.travelled() > until) {
            near.clear();
            // as in the skin of the list, the factor is for rounding in the account of travel
            list.pairs_within(self.slots.clone(), skin * (1.0 + 1e-9), (particles, scene), near);
            self.near.clear();
            reserve(&mut self.near, near.len());
            self.near.extend_from_slice(near);
            let until = list.travelled() + 0.5 * skin;
            self.near_until = Some(until);
            self.list_walls(until, list);
            self.sums.done.checks += self.slots.len() as u64;
        }
        self.sums.done.checks += (self.near.len() + self.near_walls.len()) as u64;
        list.overlapping_of(&self.near, particles, scene, overlapping);
        self.find_walls(view, overlapping);
    }

    /// Lists the walls that may be touched before the list's particles have travelled as far as `until` [m].
    fn list_walls(&mut self, until: f64, list: &NeighbourList) {
        let first = self.slots.start.max(list.pairs.len());
        self.free_until.resize(self.slots.end.saturating_sub(first), f64::NEG_INFINITY);
        self.near_walls.clear();
        let slots = (first as u32..).zip(&self.free_until);
        self.near_walls.extend(slots.filter(|(_, free)| **free < until).map(|(slot, _)| slot));
    }

    /// Finds the walls that overlap with their particle. Whoever is found apart is not asked again before it can have come near.
    fn find_walls(&mut self, view: ContactSearch, overlapping: &mut Vec<u32>) {
        let ContactSearch { list, particles, scene, .. } = view;
        let (travelled, pairs) = (list.travelled(), list.pairs.len());
        let first = self.slots.start.max(pairs);
        let mut apart: Option<(Couple, f64)> = None;
        for &slot in &self.near_walls {
            let free_until = &mut self.free_until[slot as usize - first];
            if *free_until > travelled {
                continue;
            }
            let near = &list.walls[slot as usize - pairs];
            let couple = Couple::at_wall(near.particle, near.at);
            let beyond = apart.filter(|(nearer, _)| couple.is_beyond(nearer, scene));
            let gap = beyond.map_or_else(|| near.gap(particles, scene), |(_, gap)| gap);
            if gap < 0.0 {
                overlapping.push(slot);
            } else {
                // of contacts numbered by distance only the first comes nearer no faster than its sphere: another may turn up anywhere
                let numbered = near.at.which > 0 && scene.walls[near.at.wall as usize].geometry.is_nearest_first();
                if beyond.is_some() || !numbered {
                    // the factor is for rounding in the account of travel
                    *free_until = travelled + gap * (1.0 - 1e-9);
                }
                apart = Some((couple, gap));
            }
        }
    }

    /// Real state: contacts begin, last and end.
    fn go_on(&mut self, view: ContactSearch, law: &ContactLaw, (before, overlapping): (&[TouchingSlot], &[u32])) {
        self.touching.clear();
        reserve(&mut self.touching, overlapping.len());
        let mut old = before.iter().peekable();
        for &slot in overlapping {
            while let Some(gone) = old.next_if(|touch| touch.slot < slot) {
                self.close(*gone, view);
            }
            let record = match old.next_if(|touch| touch.slot == slot) {
                Some(touch) => touch.record,
                None => {
                    let contact = self.open(slot, view, law);
                    self.records.keep(&contact.touch, contact.course)
                }
            };
            self.touching.push(TouchingSlot { slot, record });
        }
        for gone in old {
            self.close(*gone, view);
        }
    }

    /// Looks at all contacts in progress. How some of them stand is computed before any is looked at: root and quotients of one then do not wait for
    /// those of the one before.
    fn look_at_all(&mut self, view: ContactSearch, law: &ContactLaw, rows: &mut ContactRows) {
        let Self { touching, records, sums, pushes, .. } = self;
        for some in touching.chunks(BATCH) {
            let mut met = [Encounter::default(); BATCH];
            for (met, TouchingSlot { slot, record }) in met.iter_mut().zip(some) {
                *met = meet(&records.get(*record, view.list.couple(*slot as usize)).0, view);
            }
            for (met, TouchingSlot { slot, record }) in met.iter().zip(some) {
                let (touch, kept) = records.get_mut(*record, view.list.couple(*slot as usize));
                let mut course = kept.course();
                look((&touch, &mut course), met, view, law, (sums, rows, pushes));
                kept.update(&course);
            }
        }
    }

    /// Predicted state of a Runge-Kutta stage: contacts in progress stay as they are.
    fn foresee(&mut self, view: ContactSearch, law: &ContactLaw, (overlapping, rows): (&[u32], &mut ContactRows)) {
        self.foreseen.clear();
        let mut next = 0;
        for &slot in overlapping {
            while self.touching.get(next).is_some_and(|touch| touch.slot < slot) {
                next += 1;
            }
            match self.touching.get(next).filter(|touch| touch.slot == slot) {
                Some(touch) => {
                    let (bodies, mut aside) = self.records.get(touch.record, view.list.couple(slot as usize));
                    let met = meet(&bodies, view);
                    look((&bodies, &mut aside), &met, view, law, (&mut self.sums, rows, &mut self.pushes));
                }
                None => {
                    let mut contact = self.open(slot, view, law);
                    let met = meet(&contact.touch, view);
                    let Contact { touch, course, .. } = &mut contact;
                    look((touch, course), &met, view, law, (&mut self.sums, rows, &mut self.pushes));
                    self.foreseen.push(contact);
                }
            }
        }
    }

    /// A contact that begins here.
    fn open(&self, slot: u32, view: ContactSearch, law: &ContactLaw) -> Contact {
        let ContactSearch { list, at, .. } = view;
        let touch = view.touching(list.couple(slot as usize), law);
        let met = meet(&touch, view);
        // where a predicted state met it first its force acted already: the speed of approach is the one seen there
        let foreseen = self.foreseen.binary_search_by_key(&slot, |contact| contact.slot);
        let normal_speed = match foreseen {
            Ok(k) if at.opens => self.foreseen[k].course.normal_speed,
            _ => -met.normal_velocity,
        };
        let began = at.start + at.elapsed;
        let course = ContactState { normal_speed, first_overlap: met.overlap(), ..ContactState::new(began) };
        Contact { slot, touch, course }
    }

    /// Notes the impact of a contact that no longer overlaps, and forgets it.
    fn close(&mut self, TouchingSlot { slot, record }: TouchingSlot, view: ContactSearch) {
        let ContactSearch { list, at, .. } = view;
        let (touch, course) = self.records.get(record, list.couple(slot as usize));
        let counts = view.counts(&touch.couple);
        self.records.forget(record);
        // a contact first seen while it opens (a start with overlap) is no impact
        if course.normal_speed <= 0.0 || !counts {
            return;
        }
        let met = meet(&touch, view);
        // what has gone far in one step may be out of sight of its surface, which then has no normal
        let before = course.normal.filter(|_| met.normal == Vector3::zeros());
        let normal = before.map_or(met.normal, |normal| normal.cast());
        let rebound = met.velocity.dot(&normal);
        let (species, other) = view.kinds(&touch.couple);
        self.ended.push((Between::of(species, other), course.impact(touch.diameter, rebound, at.start + at.elapsed)));
    }
}

/// Of two failures of the same instant that of the smaller ids.
#[cold]
pub fn first_named(one: Option<Failure>, other: Failure) -> Failure {
    let name = |failure: &Failure| match failure {
        Failure::OverlapTooLarge { particle, partner: Partner::Particle(other), .. } => (*particle, 0, *other),
        Failure::OverlapTooLarge { particle, partner: Partner::Wall(wall), .. } => (*particle, 1, *wall),
        _ => (0, 0, 0),
    };
    one.filter(|one| name(one) <= name(&other)).unwrap_or(other)
}

/// How two bodies stand to one another at the instant of a view.
#[inline(always)]
fn meet(touch: &TouchingPair, view: ContactSearch) -> Encounter {
    touch.couple.meet_at(touch.reach, view.particles, view.scene, FrameTime::fallen(view.at.fall))
}

/// Notes what a contact is like now, and adds up what its force does.
#[inline(always)]
fn look(
    (touch, course): (&TouchingPair, &mut ContactState),
    met: &Encounter,
    view: ContactSearch,
    law: &ContactLaw,
    (sums, rows, pushes): (&mut ForceSums, &mut ContactRows, &mut ForceBuffer),
) {
    let ContactSearch { particles, scene, at, .. } = view;
    if let Err(failure) = course.check(touch, met, (particles, scene), (at.start + at.elapsed, at.dt)) {
        sums.failure = Some(first_named(sums.failure.take(), failure));
    }
    course.note(met);
    // touches come at any phase of the steps: on average the sum is the integral
    course.overlap_time += met.overlap() * at.dt;
    let force = touch.force(law, met, scene, at.dt, at.to_middle);
    if !at.travel_is_exact {
        sums.elastic_energy += law.stored_energy(&touch.spring, met.overlap());
    }
    if view.counts(&touch.couple) {
        rows.add(&touch.couple, &force, (scene, at.remaining), &mut sums.rows);
    }
    pushes.add(ForceIncrement { i: touch.couple.i, j: touch.couple.j().map(StoreIndex::of), force: force.on_i });
}
