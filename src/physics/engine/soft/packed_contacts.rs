//! Compact records of the contacts in progress of one block (range of candidates in the neighbour list). Contacts
//! between bodies of the same kinds have equal constants, which are stored only once (for up to 16 different sets of
//! constants). The contacts are stored in chunks of equal length.

use super::contact::{ContactConstants, ContactState, ResistanceMemory};
use nalgebra::Vector3;

/// Number of entries, in the list of contact constants, that many contacts may share. Every further entry belongs to a
/// single contact.
const SHARED: usize = 16;

/// Number of contacts per chunk of storage. A single list would be copied when it grows, and would fragment the memory.
const CHUNK: usize = 128;

/// A contact in progress, in 64 bytes. Its two bodies are those of its slot (number of the candidate) in the neighbour
/// list. The normal, and data that only the statistics of impacts need, are in single precision.
#[derive(Clone, Copy, Debug)]
pub struct PackedContact {
    normal_speed: f64,
    overlap: f64,
    growth: f64,
    overlap_time: f64,
    began: f64,
    first_overlap: f32,
    maximum_overlap: f32,
    /// Unit normal at the last evaluation of the force; not a number (NaN) before the first evaluation.
    normal: Vector3<f32>,
    /// Index of the contact's constants in the list of constants.
    constants: u32,
}

impl PackedContact {
    fn new(constants: u32, course: &ContactState) -> Self {
        let ContactState { normal_speed, overlap, growth, overlap_time, began, .. } = *course;
        let (first_overlap, maximum_overlap) = (course.first_overlap as f32, course.maximum_overlap as f32);
        let normal = course.normal.unwrap_or(Vector3::from_element(f32::NAN));
        Self { normal_speed, overlap, growth, overlap_time, began, first_overlap, maximum_overlap, normal, constants }
    }

    /// State of the contact at the last evaluation of its force. The springs in the returned state are empty, because
    /// [`PackedContacts`] stores them.
    #[inline(always)]
    pub fn course(&self) -> ContactState {
        let Self { normal_speed, overlap, growth, overlap_time, began, normal, .. } = *self;
        let (first_overlap, maximum_overlap) = (self.first_overlap.into(), self.maximum_overlap.into());
        let normal = (!normal.x.is_nan()).then_some(normal);
        let shear = Vector3::zeros();
        ContactState {
            normal_speed,
            first_overlap,
            maximum_overlap,
            overlap,
            growth,
            overlap_time,
            began,
            normal,
            shear,
            resistance: None,
            first_slip: None,
            facet: None,
        }
    }

    /// Replaces the stored state of the contact, except its springs, by `course`.
    #[inline(always)]
    pub fn update(&mut self, course: &ContactState) {
        *self = Self::new(self.constants, course);
    }
}

/// Mutable access to the stored state and the springs of a contact between rotating bodies.
pub struct RotatingRecord<'a> {
    /// Constants of the contact.
    pub constants: &'a ContactConstants,
    /// Stored state of the contact without its springs.
    pub kept: &'a mut PackedContact,
    /// [m] shear of the tangential spring; `None` if contacts have no such spring.
    pub shear: Option<&'a mut Vector3<f64>>,
    /// State of the rolling and twisting springs; `None` if contacts do not resist rolling and twisting.
    pub resistance: Option<&'a mut ResistanceMemory>,
}

/// Contacts in progress, each at an index that does not change while the contact lasts.
#[derive(Default)]
pub struct PackedContacts {
    /// Chunks of contacts; all chunks but the last are full.
    kept: Vec<Vec<PackedContact>>,
    /// Indices in `kept` whose contacts have ended; new contacts get these indices first.
    free: Vec<u32>,
    /// Constants of contacts. Many contacts may share one of the first `SHARED` entries. Each further entry is for one
    /// contact.
    constants: Vec<ContactConstants>,
    /// Indices in `constants`, from `SHARED` on, whose entries no contact uses.
    unused: Vec<u32>,
    /// [m] shears of the contacts in `kept`, at the same indices; empty if contacts have no tangential springs.
    shears: Vec<Vec<Vector3<f64>>>,
    /// States of the rolling and twisting springs of the contacts in `kept`, at the same indices; empty without such
    /// springs.
    resistances: Vec<Vec<ResistanceMemory>>,
    /// [m/s] slips at first touch of the contacts in `kept`, at the same indices; empty if spheres do not rotate.
    /// `None` for a contact whose first slip is not recorded.
    first_slips: Vec<Vec<Option<Vector3<f32>>>>,
    /// [rad] rotation vectors by which rough walls have turned velocities, for the contacts in `kept` at the same
    /// indices. `None` for a contact without a turned velocity. Empty if there is no such turn.
    facets: Vec<Vec<Option<Vector3<f64>>>>,
}

/// Returns the element at `index` of a list that is stored in chunks of equal length; `None` if there are fewer chunks.
#[inline(always)]
fn in_chunks<T>(chunks: &mut [Vec<T>], index: u32) -> Option<&mut T> {
    Some(&mut chunks.get_mut(index as usize / CHUNK)?[index as usize % CHUNK])
}

/// Stores a value for the contact at `index` of a list in chunks of equal length, and adds chunks if they are needed.
fn store_in_chunks<T: Clone + Default>(chunks: &mut Vec<Vec<T>>, index: u32, value: T) {
    while chunks.len() <= index as usize / CHUNK {
        chunks.push(vec![T::default(); CHUNK]);
    }
    chunks[index as usize / CHUNK][index as usize % CHUNK] = value;
}

impl PackedContacts {
    /// Stores a contact that begins, and returns the index of its record.
    pub fn keep(&mut self, touch: &ContactConstants, course: ContactState) -> u32 {
        let constants = self.constants_of(touch);
        let kept = PackedContact::new(constants, &course);
        let index = self.store(kept);
        if touch.tangential.stiffness > 0.0 {
            store_in_chunks(&mut self.shears, index, course.shear);
        }
        if let Some(resistance) = course.resistance {
            store_in_chunks(&mut self.resistances, index, resistance);
        }
        if course.first_slip.is_some() || !self.first_slips.is_empty() {
            store_in_chunks(&mut self.first_slips, index, course.first_slip);
        }
        if course.facet.is_some() || !self.facets.is_empty() {
            store_in_chunks(&mut self.facets, index, course.facet);
        }
        index
    }

    fn store(&mut self, kept: PackedContact) -> u32 {
        if let Some(index) = self.free.pop() {
            *self.at(index) = kept;
            return index;
        }
        if self.kept.last().is_none_or(|chunk| chunk.len() == CHUNK) {
            self.kept.push(Vec::with_capacity(CHUNK));
        }
        let full = (self.kept.len() - 1) * CHUNK;
        let chunk = &mut self.kept[full / CHUNK];
        chunk.push(kept);
        (full + chunk.len() - 1) as u32
    }

    /// Index of an entry of `constants` that equals `touch`. If none of the first `SHARED` entries equals `touch`, an
    /// unused or new entry is set to `touch`.
    fn constants_of(&mut self, touch: &ContactConstants) -> u32 {
        let shared = &self.constants[..self.constants.len().min(SHARED)];
        if let Some(like) = shared.iter().position(|other| other == touch) {
            return like as u32;
        }
        match self.unused.pop() {
            Some(index) => {
                self.constants[index as usize] = *touch;
                index
            }
            None => {
                self.constants.push(*touch);
                self.constants.len() as u32 - 1
            }
        }
    }

    #[inline(always)]
    fn at(&mut self, index: u32) -> &mut PackedContact {
        &mut self.kept[index as usize / CHUNK][index as usize % CHUNK]
    }

    /// Constants and packed record of the contact at `index`. [`PackedContact::update`] changes the record.
    #[inline(always)]
    pub fn get_mut(&mut self, index: u32) -> (&ContactConstants, &mut PackedContact) {
        let kept = &mut self.kept[index as usize / CHUNK][index as usize % CHUNK];
        (&self.constants[kept.constants as usize], kept)
    }

    /// Constants and present state of the contact at `index`, without its springs ([`whole`](Self::whole) includes
    /// them).
    #[inline(always)]
    pub fn get(&self, index: u32) -> (&ContactConstants, ContactState) {
        let kept = &self.kept[index as usize / CHUNK][index as usize % CHUNK];
        (&self.constants[kept.constants as usize], kept.course())
    }

    /// Mutable access to the contact at `index`, with its springs.
    #[inline(always)]
    pub fn rotating(&mut self, index: u32) -> RotatingRecord<'_> {
        let kept = &mut self.kept[index as usize / CHUNK][index as usize % CHUNK];
        let constants = &self.constants[kept.constants as usize];
        let (shear, resistance) = (in_chunks(&mut self.shears, index), in_chunks(&mut self.resistances, index));
        RotatingRecord { constants, kept, shear, resistance }
    }

    /// Constants and present state of the contact at `index`, with its springs, first slip and turn by a rough wall.
    pub fn whole(&self, index: u32) -> (&ContactConstants, ContactState) {
        let (constants, course) = self.get(index);
        let (chunk, offset) = (index as usize / CHUNK, index as usize % CHUNK);
        let shear = self.shears.get(chunk).map_or_else(Vector3::zeros, |some| some[offset]);
        let resistance = self.resistances.get(chunk).map(|some| some[offset]);
        let first_slip = self.first_slips.get(chunk).and_then(|some| some[offset]);
        let facet = self.facets.get(chunk).and_then(|some| some[offset]);
        (constants, ContactState { shear, resistance, first_slip, facet, ..course })
    }

    /// Removes the contact at `index`. The next new contact may get this index.
    pub fn forget(&mut self, index: u32) {
        let constants = self.at(index).constants;
        if constants as usize >= SHARED {
            self.unused.push(constants);
        }
        self.free.push(index);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact_law::Spring;

    fn touch(stiffness: f64) -> ContactConstants {
        let spring = Spring { effective_mass: 1.0, restitution: 0.9, stiffness, dashpot: 0.1 };
        ContactConstants { spring, diameter: 1.0, friction: 0.0, reach: 1.0, tangential: Default::default() }
    }

    #[test]
    fn contacts_keep_their_constants_however_many_kinds_there_are_and_places_are_used_again() {
        let mut records = PackedContacts::default();
        let indices: Vec<u32> =
            (0..300).map(|j| records.keep(&touch(f64::from(j % 150)), ContactState::new(f64::from(j)))).collect();
        for (j, &index) in (0..).zip(&indices).filter(|(j, _)| j % 3 == 0) {
            assert!(records.get(index).0 == &touch(f64::from(j % 150)));
            records.forget(index);
        }
        let room = |records: &PackedContacts| records.kept.iter().map(Vec::len).sum::<usize>();
        let (kept, constants) = (room(&records), records.constants.len());
        let again: Vec<u32> =
            (0..100).map(|j| records.keep(&touch(1e3 + f64::from(j)), ContactState::new(0.0))).collect();
        assert_eq!(room(&records), kept);
        assert!(records.constants.len() < constants + 100, "constants that nobody names are not used again");
        for (j, index) in (0..).zip(again) {
            let (found, course) = records.get(index);
            assert!(found == &touch(1e3 + f64::from(j)) && course.began == 0.0);
        }
        for (j, &index) in (0..).zip(&indices).filter(|(j, _)| j % 3 != 0) {
            let (found, course) = records.get(index);
            assert!(found == &touch(f64::from(j % 150)));
            assert_eq!(course.began, f64::from(j));
        }
    }
}
