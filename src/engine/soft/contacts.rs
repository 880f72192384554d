//! Contacts in progress: their forces, their records, and what they dissipate.

use super::contact::{Contact, Force, Rates, Touching};
use crate::contact_law::ContactLaw;
use crate::encounter::{Couple, Moment};
use crate::engine::Failure;
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use crate::record::{Between, Log};
use crate::scene::Scene;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// An acceleration to be applied to one particle.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Push {
    /// Place in the store.
    pub particle: u32,
    /// [m/s²]
    pub acceleration: Vector3<f64>,
}

/// When forces are evaluated, and for how much time they stand. All times in s.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Simulated time at the start of the window.
    pub start: f64,
    /// Since the start of the window, for the positions.
    pub elapsed: f64,
    /// Until the end of the window.
    pub remaining: f64,
    /// The time step.
    pub dt: f64,
    /// Since the start of the window, for the velocities: what gravity has added to them.
    pub fall: f64,
    /// From the given velocities to the middle of the kick, where powers are taken.
    pub to_middle: f64,
    /// Fraction of the step these forces stand for now.
    pub weight: f64,
    /// Whether contacts begin and end here (not in the predicted state of a Runge-Kutta stage).
    pub opens: bool,
}

/// What contacts are looked for in, and when.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// The pairs and walls that may overlap.
    pub list: &'a NeighbourList,
    /// Positions and velocities of the particles.
    pub particles: &'a Particles,
    /// Walls, surfaces and gravity.
    pub scene: &'a Scene,
    /// The instant at which forces are asked for.
    pub at: Instant,
}

/// All contacts of a scene.
pub struct Contacts {
    law: ContactLaw,
    /// In ascending order of slot.
    active: Vec<Contact>,
    slots: Vec<u32>,
    due: Due,
}

/// What the last evaluation of the forces leaves to the next one.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Due {
    /// Contacts that the last predicted state met first, in ascending order of slot: their forces acted already, so the
    /// speed of approach is the one seen there.
    foreseen: Vec<Contact>,
    /// [J] stored in all contacts.
    elastic_energy: f64,
    /// Of the kick of which a half is still to be booked.
    rates: Rates,
}

impl Due {
    /// Notes what a contact is like now, its beginning too if it is `new`, and gives its force.
    fn look(&mut self, contact: &mut Contact, new: bool, law: &ContactLaw, view: View) -> Result<Force, Failure> {
        let View { particles, scene, at, .. } = view;
        let met = contact.touch.couple.meet(particles, scene, Moment::fallen(at.fall));
        contact.check(&met, particles, scene, at.start + at.elapsed)?;
        if new {
            let foreseen = self.foreseen.binary_search_by_key(&contact.slot, |contact| contact.slot);
            contact.normal_speed = match foreseen {
                Ok(k) if at.opens => self.foreseen[k].normal_speed,
                _ => -met.normal_velocity,
            };
            contact.first_overlap = met.overlap();
        }
        contact.note(&met);
        // touches come at any phase of the steps: on average the sum is the integral
        contact.overlap_time += met.overlap() * at.dt;
        self.elastic_energy += law.stored_energy(&contact.touch.spring, met.overlap());
        Ok(contact.touch.force(law, &met, scene, at.dt, at.to_middle))
    }
}

impl Contacts {
    pub fn new(law: ContactLaw) -> Self {
        Self { law, active: Vec::new(), slots: Vec::new(), due: Due::default() }
    }

    pub fn elastic_energy(&self) -> f64 {
        self.due.elastic_energy
    }

    /// What the last evaluation leaves to the next one.
    pub fn due(&self) -> &Due {
        &self.due
    }

    /// Goes on from what an evaluation left.
    pub fn resume(&mut self, due: Due) {
        self.due = due;
    }

    /// Opens a contact for everything that overlaps at the start, at simulated time `now` [s].
    pub fn find(&mut self, list: &NeighbourList, particles: &Particles, scene: &Scene, now: f64) {
        list.overlapping(particles, scene, &mut self.slots);
        for &slot in &self.slots {
            let touch = Touching::new(list.couple(slot as usize), particles, scene, &self.law);
            let met = touch.couple.meet(particles, scene, Moment::default());
            self.active.push(Contact {
                normal_speed: -met.normal_velocity,
                first_overlap: met.overlap(),
                maximum_overlap: met.overlap(),
                overlap: met.overlap(),
                growth: -met.normal_velocity,
                ..Contact::new(slot, touch, now)
            });
        }
    }

    /// Hands over the contacts in progress. What is due of the last kick stays, in case they come back as they were.
    pub fn take(&mut self) -> Vec<Contact> {
        std::mem::take(&mut self.active)
    }

    /// Drops what is due of the last kick: somebody else has moved the contacts on.
    pub fn forget(&mut self) {
        self.due.elastic_energy = 0.0;
        self.due.rates = Rates::default();
    }

    /// Takes contacts in progress over, for a list they are in.
    pub fn put(&mut self, contacts: Vec<Contact>) {
        self.active = contacts;
    }

    /// The store has been reordered and the list rebuilt: the particle once at `p` is now at `place_of[p]`.
    pub fn reorder(&mut self, place_of: &[u32], list: &NeighbourList) {
        let follow = |contact: &mut Contact| {
            contact.touch.couple = contact.touch.couple.moved(|place| place_of[place as usize]);
            let slot = list.slot(&contact.touch.couple);
            contact.slot = slot.map_or(contact.slot, |slot| slot as u32);
            slot.is_some()
        };
        for contacts in [&mut self.active, &mut self.due.foreseen] {
            contacts.retain_mut(follow);
            contacts.sort_unstable_by_key(|contact| contact.slot);
        }
    }

    /// Finds what overlaps, opens and closes contacts, and appends the accelerations to `pushes`. Returns the number
    /// of forces computed.
    pub fn evaluate(&mut self, view: View, pushes: &mut Vec<Push>, log: &mut Log) -> Result<u64, Failure> {
        let View { list, particles, scene, at } = view;
        let mut slots = std::mem::take(&mut self.slots);
        list.overlapping(particles, scene, &mut slots);
        let mut rates = Rates::default();
        self.due.elastic_energy = 0.0;
        let mut known = 0;
        if at.opens {
            self.close_missing(&slots, particles, scene, at, log);
        } else {
            self.due.foreseen.clear();
        }
        let known_before = self.active.len();
        for &slot in &slots {
            while known < known_before && self.active[known].slot < slot {
                known += 1;
            }
            let lasts = known < known_before && self.active[known].slot == slot;
            let mut aside = None;
            let contact = if lasts && at.opens {
                &mut self.active[known]
            } else if lasts {
                // a predicted state leaves the contacts in progress as they are
                aside.insert(self.active[known])
            } else {
                let touch = Touching::new(list.couple(slot as usize), particles, scene, &self.law);
                aside.insert(Contact::new(slot, touch, at.start + at.elapsed))
            };
            // a contact that islands opened at its very touch has a first overlap of 0 and was seen nevertheless
            let force = self.due.look(contact, !lasts, &self.law, view)?;
            rates.count(&contact.touch.couple, &force, 1.0);
            push(&contact.touch.couple, &force, particles, pushes);
            match aside {
                Some(new) if at.opens => self.active.push(new),
                Some(new) if !lasts => self.due.foreseen.push(new),
                _ => {}
            }
        }
        if self.active.len() > known_before {
            self.active.sort_unstable_by_key(|contact| contact.slot);
        }
        rates.add(at.weight * at.dt, at.remaining, scene, log);
        self.due.rates = rates;
        let forces = slots.len() as u64;
        self.slots = slots;
        Ok(forces)
    }

    /// Books the half of the last kick that was left for this window; `remaining` [s] is the whole window.
    pub fn settle(&mut self, time: f64, remaining: f64, scene: &Scene, log: &mut Log) {
        self.due.rates.add(time, remaining, scene, log);
        self.due.rates = Rates::default();
    }

    /// Records and removes the contacts whose slot no longer overlaps.
    fn close_missing(&mut self, slots: &[u32], particles: &Particles, scene: &Scene, at: Instant, log: &mut Log) {
        if self.active.is_empty() {
            return;
        }
        let mut next = slots.iter().peekable();
        self.active.retain(|contact| {
            while next.next_if(|&&slot| slot < contact.slot).is_some() {}
            if next.peek() == Some(&&contact.slot) {
                return true;
            }
            let met = contact.touch.couple.meet(particles, scene, Moment::fallen(at.fall));
            // what has gone far in one step may be out of sight of its surface, which then has no normal
            let normal = contact.normal.filter(|_| met.normal == Vector3::zeros()).unwrap_or(met.normal);
            let rebound = met.velocity.dot(&normal);
            // a contact first seen while it opens (a start with overlap) is no impact
            if contact.normal_speed > 0.0 {
                let (species, other) = contact.touch.couple.kinds(particles);
                log.impacts.push((Between::of(species, other), contact.impact(rebound, at.start + at.elapsed)));
            }
            false
        });
    }
}

/// The force of one contact as accelerations of its particles.
fn push(couple: &Couple, force: &Force, particles: &Particles, pushes: &mut Vec<Push>) {
    let i = couple.i;
    pushes.push(Push { particle: i, acceleration: force.on_i / particles.mass[i as usize] });
    if let Some(j) = couple.j() {
        pushes.push(Push { particle: j, acceleration: -force.on_i / particles.mass[j as usize] });
    }
}
