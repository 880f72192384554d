//! The contacts in progress of one block, in little room: most of them are between bodies of the same kinds, whose constants are held once.

use super::contact::{Course, Touching};
use crate::encounter::Couple;

/// So many kinds of contacts are held once for all that are like them; further ones are held by each contact.
const SHARED: usize = 16;

/// Contacts are kept in chunks of so many: a list that grows is copied, and leaves holes in memory.
const CHUNK: usize = 128;

/// A contact in progress.
#[derive(Clone, Copy, Debug)]
struct Kept {
    couple: Couple,
    /// Place of its constants.
    constants: u32,
    course: Course,
}

/// Contacts in progress, each at a place that it keeps.
#[derive(Default)]
pub struct Records {
    /// All chunks but the last are full.
    kept: Vec<Vec<Kept>>,
    /// Places in `kept` that hold no contact.
    free: Vec<u32>,
    /// The constants of contacts; the two bodies in them mean nothing.
    constants: Vec<Touching>,
    /// Places in `constants` from `SHARED` on that no contact names.
    unused: Vec<u32>,
}

impl Records {
    /// Keeps a contact; gives its place.
    pub fn keep(&mut self, touch: &Touching, course: Course) -> u32 {
        let constants = self.constants_of(touch);
        let kept = Kept { couple: touch.couple, constants, course };
        if let Some(place) = self.free.pop() {
            *self.at(place) = kept;
            return place;
        }
        if self.kept.last().is_none_or(|chunk| chunk.len() == CHUNK) {
            self.kept.push(Vec::with_capacity(CHUNK));
        }
        let full = (self.kept.len() - 1) * CHUNK;
        let chunk = &mut self.kept[full / CHUNK];
        chunk.push(kept);
        (full + chunk.len() - 1) as u32
    }

    /// The place of the constants of a contact.
    fn constants_of(&mut self, touch: &Touching) -> u32 {
        let shared = &self.constants[..self.constants.len().min(SHARED)];
        if let Some(like) = shared.iter().position(|other| other.is_like(touch)) {
            return like as u32;
        }
        match self.unused.pop() {
            Some(place) => {
                self.constants[place as usize] = *touch;
                place
            }
            None => {
                self.constants.push(*touch);
                self.constants.len() as u32 - 1
            }
        }
    }

    #[inline(always)]
    fn at(&mut self, place: u32) -> &mut Kept {
        &mut self.kept[place as usize / CHUNK][place as usize % CHUNK]
    }

    /// The contact at a place.
    #[inline(always)]
    pub fn get_mut(&mut self, place: u32) -> (Touching, &mut Course) {
        let Kept { couple, constants, course } = &mut self.kept[place as usize / CHUNK][place as usize % CHUNK];
        (Touching { couple: *couple, ..self.constants[*constants as usize] }, course)
    }

    /// The same as it is.
    #[inline(always)]
    pub fn get(&self, place: u32) -> (Touching, Course) {
        let Kept { couple, constants, course } = self.kept[place as usize / CHUNK][place as usize % CHUNK];
        (Touching { couple, ..self.constants[constants as usize] }, course)
    }

    /// Forgets the contact at a place.
    pub fn forget(&mut self, place: u32) {
        let constants = self.at(place).constants;
        if constants as usize >= SHARED {
            self.unused.push(constants);
        }
        self.free.push(place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact_law::Spring;

    fn touch(j: u32, stiffness: f64) -> Touching {
        let spring = Spring { effective_mass: 1.0, restitution: 0.9, stiffness, dashpot: 0.1 };
        Touching { couple: Couple::pair(0, j), spring, diameter: 1.0, friction: 0.0, reach: 1.0 }
    }

    #[test]
    fn contacts_keep_their_constants_however_many_kinds_there_are_and_places_are_used_again() {
        let mut records = Records::default();
        let places: Vec<u32> =
            (0..300).map(|j| records.keep(&touch(j, f64::from(j % 150)), Course::new(f64::from(j)))).collect();
        for (j, &place) in (0..).zip(&places).filter(|(j, _)| j % 3 == 0) {
            assert!(records.get(place).0.is_like(&touch(j, f64::from(j % 150))));
            records.forget(place);
        }
        let room = |records: &Records| records.kept.iter().map(Vec::len).sum::<usize>();
        let (kept, constants) = (room(&records), records.constants.len());
        let again: Vec<u32> = (0..100).map(|j| records.keep(&touch(j, 1e3 + f64::from(j)), Course::new(0.0))).collect();
        assert_eq!(room(&records), kept);
        assert!(records.constants.len() < constants + 100, "constants that nobody names are not used again");
        for (j, place) in (0..).zip(again) {
            let (found, _) = records.get(place);
            assert!(found.is_like(&touch(j, 1e3 + f64::from(j))) && found.couple == Couple::pair(0, j));
        }
        for (j, &place) in (0..).zip(&places).filter(|(j, _)| j % 3 != 0) {
            let (found, course) = records.get(place);
            assert!(found.is_like(&touch(j, f64::from(j % 150))) && found.couple == Couple::pair(0, j));
            assert_eq!(course.began, f64::from(j));
        }
    }
}
