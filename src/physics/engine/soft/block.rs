//! Contacts in a block: a range of slots (entries: two particles, or a particle and a wall) of the neighbour list.
//!
//! Blocks share no data that changes, so threads evaluate blocks in parallel. The results are added in the order of
//! blocks, so the sums are equal for any number of threads. The record of a contact keeps its place in memory while
//! the contact lasts. Only a list of eight bytes per contact, sorted by slot, is rebuilt at every step.

mod facets;
mod renumber;

use super::contact::{Contact, ContactConstants, ContactForce, ContactState, TouchingPair, first_named};
use super::contact_sums::ContactRows;
use super::contacts::ContactSearch;
use super::force_buffer::{ForceBuffer, ForceIncrement, StoreIndex};
use super::packed_contacts::{PackedContacts, RotatingRecord};
use super::rotating::{BeforeStep, RotatingForce, SurfaceMotion};
use crate::contact_law::ContactLaw;
use crate::encounter::{Couple, Encounter};
use crate::engine::Failure;
use crate::neighbours::NeighbourList;
use crate::record::{Between, FrictionLosses, Impact};
use facets::FacetTurns;
use nalgebra::Vector3;
use std::ops::Range;

/// Number of contacts whose encounters (relative positions and velocities, 2 kB) are computed before their forces.
const BATCH: usize = 32;

/// Reserves memory for `room` elements in total, plus an eighth. Lists of contacts that grow by doubling would take up
/// to twice the memory.
pub fn reserve<T>(list: &mut Vec<T>, room: usize) {
    if room > list.capacity() {
        list.reserve_exact(room + room / 8 + 8 - list.len());
    }
}

/// Slot (number in the neighbour list) of two touching bodies, and the index of the record of their contact.
#[derive(Clone, Copy, Debug)]
struct TouchingSlot {
    slot: u32,
    record: u32,
}

/// Numbers of operations (forces computed, pairs tested) of a force evaluation.
#[derive(Clone, Copy, Debug, Default)]
pub struct ForceEvaluation {
    /// Number of contact forces computed.
    pub forces: u64,
    /// Number of slots (candidates of the neighbour list) tested for an overlap.
    pub checks: u64,
}

/// Sums over the contacts of one block (range of candidates in the neighbour list) in one force evaluation.
#[derive(Default)]
pub struct ForceSums {
    /// Lists (rows) of powers [W] and forces [N] whose exact sums are the sums over all contacts of the block.
    pub rows: ContactRows,
    /// [J] elastic energy of the contacts. It is summed only for Heun's method, in which the last forces of a step are
    /// those of a predicted state, which contacts do not store.
    pub elastic_energy: f64,
    /// Numbers of contact forces computed and of candidates tested in the evaluation.
    pub done: ForceEvaluation,
    /// Failure (overlap too large, or centre passed a body) with the smallest ids of particles; `None` without failure.
    pub failure: Option<Failure>,
}

impl ForceSums {
    fn clear(&mut self) {
        self.rows.clear();
        (self.elastic_energy, self.done, self.failure) = (0.0, ForceEvaluation::default(), None);
    }
}

/// Working memory of an evaluation, shared by blocks that are evaluated one after the other.
#[derive(Default)]
pub struct BlockScratch {
    /// Powers and forces, one row (list) per contact, before these rows are condensed into a few with the same sums.
    rows: ContactRows,
    /// Contacts of the block at the previous step, in the order of the neighbour list.
    before: Vec<TouchingSlot>,
    /// Slots (candidates of the neighbour list) whose two bodies overlap.
    overlapping: Vec<u32>,
    /// Slots (candidates of the neighbour list) of pairs that may overlap soon.
    near: Vec<u32>,
}

/// Contacts in progress within a range of slots (candidates) of the neighbour list.
#[derive(Default)]
pub struct ContactBlock {
    slots: Range<usize>,
    /// Contacts in progress, in the order of the neighbour list.
    touching: Vec<TouchingSlot>,
    records: PackedContacts,
    /// Contacts that began in the state last predicted by Heun's method, in the order of the neighbour list.
    foreseen: Vec<Contact>,
    /// Slots (candidates) of pairs that may overlap before a particle has moved by `near_until`, in ascending order.
    near: Vec<u32>,
    /// [m] motion of particles up to which `near` and `near_walls` are valid; `None` if they must be made anew.
    near_until: Option<f64>,
    /// Slots (candidates) of particles that may overlap a wall before a particle has moved by `near_until` [m].
    near_walls: Vec<u32>,
    /// [m] for each slot with a wall: motion since the list was built, below which the particle cannot touch the wall.
    free_until: Vec<f64>,
    /// Contact forces of the last evaluation.
    pub pushes: ForceBuffer,
    /// Contacts with rough walls that begin or end in the present step.
    pub facets: FacetTurns,
    /// Impacts that ended in the last evaluation.
    pub ended: Vec<(Between, Impact)>,
    /// Sums over the contacts in the last evaluation.
    pub sums: ForceSums,
}

impl ContactBlock {
    /// Makes a block of a range of slots (candidates of the neighbour list), without contacts.
    pub fn of(slots: Range<usize>) -> Self {
        Self { slots, ..Self::default() }
    }

    /// True if all slots (candidates) of the block are after `slot` in the neighbour list.
    pub fn begins_after(&self, slot: u32) -> bool {
        self.slots.start > slot as usize
    }

    /// True if `slot` is one of the block's slots (candidates of the neighbour list).
    #[cfg(test)]
    pub fn holds(&self, slot: u32) -> bool {
        self.slots.contains(&(slot as usize))
    }

    /// Adds a contact of one of the block's slots (candidates). In `list` its bodies may be in the opposite order.
    pub fn put(&mut self, contact: &Contact, list: &NeighbourList) {
        let Contact { touch, course, slot } = *contact;
        let course = if list.couple(slot as usize) == touch.couple { course } else { course.reversed() };
        let record = self.records.keep(&touch, course);
        let all = self.touching.len() + 1;
        reserve(&mut self.touching, all);
        self.touching.push(TouchingSlot { slot: contact.slot, record });
    }

    /// Adds a contact that began in the state that Heun's method last predicted, and whose force has acted already.
    pub fn put_foreseen(&mut self, contact: Contact) {
        self.foreseen.push(contact);
    }

    /// Sorts the contacts of the block in the order of the neighbour list.
    pub fn sort(&mut self) {
        self.touching.sort_unstable_by_key(|touch| touch.slot);
        self.foreseen.sort_unstable_by_key(|contact| contact.slot);
    }

    /// Frees the memory of data that the block computes anew for each neighbour list.
    pub fn shed(&mut self) {
        (self.near, self.near_walls, self.near_until) = (Vec::new(), Vec::new(), None);
        (self.free_until, self.ended, self.pushes) = (Vec::new(), Vec::new(), ForceBuffer::default());
        self.sums = ForceSums::default();
    }

    /// Discards the lists of candidates that may overlap soon, so that the next evaluation tests all candidates.
    pub fn look_anew(&mut self) {
        self.near_until = None;
        self.free_until.clear();
    }

    /// Number of contacts in progress in the block.
    pub fn count(&self) -> usize {
        self.touching.len()
    }

    /// Couples of bodies that touch, in the order of the neighbour list `list`.
    pub fn couples(&self, list: &NeighbourList) -> impl Iterator<Item = Couple> {
        self.touching.iter().map(|touch| list.couple(touch.slot as usize))
    }

    /// Contacts in progress, in the order of the list; `couples` must be the result of [`couples`](Self::couples).
    pub fn contacts(&self, couples: impl Iterator<Item = Couple>) -> impl Iterator<Item = Contact> {
        self.touching.iter().zip(couples).map(|(&TouchingSlot { slot, record }, couple)| {
            let (constants, course) = self.records.whole(record);
            Contact { slot, touch: TouchingPair { couple, constants: *constants }, course }
        })
    }

    /// Contacts that began in the state last predicted by Heun's method, in the order of the neighbour list.
    pub fn foreseen(&self) -> &[Contact] {
        &self.foreseen
    }

    /// Finds overlaps and computes the contact forces. Contacts begin and end only if `view.at.opens` is true.
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
            if view.scene.rotation.is_some() {
                self.renumber(view, (before, overlapping), rows);
            }
            self.go_on(view, law, (before, overlapping), rows);
            self.look_at_all(view, law, rows);
        } else {
            self.foresee(view, law, (overlapping, rows));
        }
        rows.leave(&mut self.sums.rows);
    }

    /// Finds the slots (candidates) whose bodies overlap. Most slots of the list are too far apart to touch soon. The
    /// other slots are listed from time to time, and only the listed slots are tested in between, with the same result.
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
            // the factor covers rounding in the travelled distance, as for the skin (safety distance) of the list
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

    /// Lists the slots (candidates) of particles that may touch a wall before particles have moved by `until` [m].
    fn list_walls(&mut self, until: f64, list: &NeighbourList) {
        let first = self.slots.start.max(list.pairs.len());
        self.free_until.resize(self.slots.end.saturating_sub(first), f64::NEG_INFINITY);
        self.near_walls.clear();
        let slots = (first as u32..).zip(&self.free_until);
        self.near_walls.extend(slots.filter(|(_, free)| **free < until).map(|(slot, _)| slot));
    }

    /// Finds the slots (candidates) of particles that overlap a wall. After a test has found a gap, the slot is not
    /// tested again until its particle can have crossed this gap.
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
                // a sphere approaches its nearest contact with a wall no faster than the sphere moves; but if contacts
                // are numbered by distance, a further contact (`which` > 0) may appear at any distance
                let numbered =
                    near.at.which > 0 && scene.walls[near.at.wall as usize].geometry.law().is_nearest_first();
                if beyond.is_some() || !numbered {
                    // the factor covers rounding in the travelled distance
                    *free_until = travelled + gap * (1.0 - 1e-9);
                }
                apart = Some((couple, gap));
            }
        }
    }

    /// Updates the list of contacts in an actual (not a predicted) state: contacts begin, continue and end.
    fn go_on(
        &mut self,
        view: ContactSearch,
        law: &ContactLaw,
        (before, overlapping): (&[TouchingSlot], &[u32]),
        rows: &mut ContactRows,
    ) {
        self.touching.clear();
        reserve(&mut self.touching, overlapping.len());
        let mut old = before.iter().peekable();
        for &slot in overlapping {
            while let Some(gone) = old.next_if(|touch| touch.slot < slot) {
                self.close(*gone, view, false, rows);
            }
            let record = match old.next_if(|touch| touch.slot == slot) {
                Some(touch) => touch.record,
                None => {
                    let Contact { touch, mut course, .. } = self.open(slot, view, law);
                    course.facet = self.facets.take(slot);
                    self.records.keep(&touch, course)
                }
            };
            self.touching.push(TouchingSlot { slot, record });
        }
        for gone in old {
            self.close(*gone, view, false, rows);
        }
    }

    /// Evaluates all contacts in progress. The encounters (relative motions) of 32 contacts are computed before their
    /// forces, so that the processor computes the square roots and divisions of several contacts at the same time.
    fn look_at_all(&mut self, view: ContactSearch, law: &ContactLaw, rows: &mut ContactRows) {
        let Self { touching, records, sums, pushes, .. } = self;
        if view.scene.rotation.is_some() {
            for some in touching.chunks(BATCH) {
                let mut met = [(Encounter::default(), SurfaceMotion::default()); BATCH];
                for (met, TouchingSlot { slot, record }) in met.iter_mut().zip(some) {
                    let (couple, constants) = (view.list.couple(*slot as usize), records.get(*record).0);
                    met.0 = meet(&couple, constants, view);
                    met.1 = SurfaceMotion::of(&couple, constants.reach, &met.0, (view.particles, view.scene));
                }
                for (met, TouchingSlot { slot, record }) in met.iter().zip(some) {
                    let couple = view.list.couple(*slot as usize);
                    look_rotating(&couple, records.rotating(*record), met, view, law, (sums, rows, pushes));
                }
            }
            return;
        }
        for some in touching.chunks(BATCH) {
            let mut met = [Encounter::default(); BATCH];
            for (met, TouchingSlot { slot, record }) in met.iter_mut().zip(some) {
                *met = meet(&view.list.couple(*slot as usize), records.get(*record).0, view);
            }
            for (met, TouchingSlot { slot, record }) in met.iter().zip(some) {
                let (constants, kept) = records.get_mut(*record);
                let mut course = kept.course();
                let couple = view.list.couple(*slot as usize);
                evaluate((&couple, constants, &mut course), met, view, law, (sums, rows, pushes));
                kept.update(&course);
            }
        }
    }

    /// Computes the forces in the state that Heun's method predicts. Contacts in progress are not changed.
    fn foresee(&mut self, view: ContactSearch, law: &ContactLaw, (overlapping, rows): (&[u32], &mut ContactRows)) {
        self.foreseen.clear();
        let mut next = 0;
        for &slot in overlapping {
            while self.touching.get(next).is_some_and(|touch| touch.slot < slot) {
                next += 1;
            }
            match self.touching.get(next).filter(|touch| touch.slot == slot) {
                Some(touch) => {
                    let (constants, mut aside) = self.records.get(touch.record);
                    let couple = view.list.couple(slot as usize);
                    let met = meet(&couple, constants, view);
                    evaluate(
                        (&couple, constants, &mut aside),
                        &met,
                        view,
                        law,
                        (&mut self.sums, rows, &mut self.pushes),
                    );
                }
                None => {
                    let mut contact = self.open(slot, view, law);
                    let Contact { touch: TouchingPair { couple, constants }, course, .. } = &mut contact;
                    let met = meet(couple, constants, view);
                    evaluate((couple, constants, course), &met, view, law, (&mut self.sums, rows, &mut self.pushes));
                    self.foreseen.push(contact);
                }
            }
        }
    }

    /// Makes the contact that begins between the two bodies of the slot `slot` (number in the neighbour list).
    fn open(&self, slot: u32, view: ContactSearch, law: &ContactLaw) -> Contact {
        let ContactSearch { list, at, .. } = view;
        let mut touch = view.touching(list.couple(slot as usize), law);
        let met = meet(&touch.couple, &touch.constants, view);
        // if the contact began in a predicted state, its force has already acted, so the speed of approach is that of
        // the predicted state
        let foreseen = self.foreseen.binary_search_by_key(&slot, |contact| contact.slot);
        let normal_speed = match foreseen {
            Ok(k) if at.opens && !self.facets.begins(slot) => self.foreseen[k].course.normal_speed,
            _ => -met.normal_velocity,
        };
        touch.begin_at(normal_speed, (view.particles, view.scene), law);
        let began = at.start + at.elapsed;
        let begun = ContactState::beginning(began, normal_speed, &touch, view.scene, law);
        let surfaces = || SurfaceMotion::of(&touch.couple, touch.reach, &met, (view.particles, view.scene));
        let first_slip = view.scene.rotation.is_some().then(|| surfaces().slip.cast());
        let course = ContactState { first_overlap: met.overlap(), first_slip, ..begun };
        Contact { slot, touch, course }
    }

    /// Records the impact of a contact that has ended, and removes the contact. `gone` is true if the wall has no
    /// contact with this normal any more, and its slot (candidate) now stands for a contact with another normal.
    fn close(
        &mut self,
        TouchingSlot { slot, record }: TouchingSlot,
        view: ContactSearch,
        gone: bool,
        rows: &mut ContactRows,
    ) {
        let ContactSearch { list, at, .. } = view;
        let couple = list.couple(slot as usize);
        let (&constants, course) = self.records.whole(record);
        self.facets.end(&couple, course.facet);
        let counts = view.counts(&couple);
        let resisted: f64 = course.resistance.map_or(0.0, |memory| memory.energies.iter().sum());
        if counts && (course.shear != Vector3::zeros() || resisted > 0.0) {
            // the energy that is left in the springs is lost by friction
            let sheared = constants.tangential.at(course.overlap).energy(&course.shear);
            let lost = (sheared + resisted) / at.dt;
            let losses = FrictionLosses { separation: lost, ..FrictionLosses::default() };
            let force = (&ContactForce::lost(lost), &losses);
            rows.add_rotating(&couple, force, (view.scene, at.remaining), &mut self.sums.rows);
        }
        self.records.forget(record);
        // a contact that separated when it was first found (a start with overlap) is not an impact
        if course.normal_speed <= 0.0 || !counts {
            return;
        }
        let met = meet(&couple, &constants, view);
        // a particle that has moved far in one step may be out of reach of the surface; the present normal is then zero
        let before = course.normal.filter(|_| gone || met.normal == Vector3::zeros());
        let normal = before.map_or(met.normal, |normal| normal.cast());
        let rebound = met.velocity.dot(&normal);
        let (species, other) = view.kinds(&couple);
        let slip = course.slip_change(&couple, &constants, (&met, rebound), (view.particles, view.scene));
        let slip = slip.filter(|_| !gone);
        let impact = Impact { slip, ..course.impact(constants.diameter, rebound, at.start + at.elapsed) };
        self.ended.push((Between::of(species, other), impact));
    }
}

/// Gap, normal and relative velocity of two bodies at the time of an evaluation.
#[inline(always)]
fn meet(couple: &Couple, constants: &ContactConstants, view: ContactSearch) -> Encounter {
    couple.meet_at(constants.reach, view.particles, view.scene, view.at.moment())
}

/// Updates the state of a contact between rotating bodies, and adds its force, torque and powers to the results.
#[inline(always)]
fn look_rotating(
    couple: &Couple,
    record: RotatingRecord,
    (met, surfaces): &(Encounter, SurfaceMotion),
    view: ContactSearch,
    law: &ContactLaw,
    (sums, rows, pushes): (&mut ForceSums, &mut ContactRows, &mut ForceBuffer),
) {
    let RotatingRecord { constants, kept, shear: kept_shear, resistance } = record;
    let ContactSearch { particles, scene, at, .. } = view;
    let mut course = kept.course();
    if let Err(failure) = course.check(couple, constants, met, (particles, scene), (at.start + at.elapsed, at.dt)) {
        sums.failure = Some(first_named(sums.failure.take(), failure));
    }
    let shear = kept_shear.as_deref().map_or_else(Vector3::zeros, |shear| *shear);
    let before = BeforeStep { begins: course.normal.is_none(), overlap: course.overlap, shear, resistance };
    let RotatingForce { force, torque, shear, losses } =
        constants.rotating_force(couple, law, (met, surfaces), (particles, scene), before, &at);
    if let Some(kept_shear) = kept_shear {
        *kept_shear = shear;
    }
    course.note(met);
    course.overlap_time += met.overlap() * at.shear_time;
    kept.update(&course);
    if view.counts(couple) {
        rows.add_rotating(couple, (&force, &losses), (scene, at.remaining), &mut sums.rows);
    }
    let increment = ForceIncrement { i: couple.i, j: couple.j().map(StoreIndex::of), force: force.on_i };
    pushes.add_rotating(increment, torque);
}

/// Updates the state of a contact between bodies that do not rotate. Appends its force to `pushes` (forces on
/// particles), and a row (list) of its force and powers [W] to `rows`; rows are added later without rounding errors.
#[inline(always)]
fn evaluate(
    (couple, constants, course): (&Couple, &ContactConstants, &mut ContactState),
    met: &Encounter,
    view: ContactSearch,
    law: &ContactLaw,
    (sums, rows, pushes): (&mut ForceSums, &mut ContactRows, &mut ForceBuffer),
) {
    let ContactSearch { particles, scene, at, .. } = view;
    if let Err(failure) = course.check(couple, constants, met, (particles, scene), (at.start + at.elapsed, at.dt)) {
        sums.failure = Some(first_named(sums.failure.take(), failure));
    }
    course.note(met);
    // contacts begin at random instants of a step, so this sum equals, on average, the integral of the overlap
    course.overlap_time += met.overlap() * at.shear_time;
    let force = constants.force(couple, law, met, (particles, scene), at.moment(), [at.dt, at.to_middle]);
    if !at.travel_is_exact {
        sums.elastic_energy += law.stored_energy(&constants.spring, met.overlap());
    }
    if view.counts(couple) {
        rows.add(couple, &force, (scene, at.remaining), &mut sums.rows);
    }
    pushes.add(ForceIncrement { i: couple.i, j: couple.j().map(StoreIndex::of), force: force.on_i });
}
