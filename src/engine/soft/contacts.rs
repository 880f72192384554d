//! Contacts in progress: their forces, their records, and what they dissipate.

use super::law::{LinearSpringDashpot, friction_force};
use crate::engine::{Failure, Partner};
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use crate::record::{Impact, Record};
use crate::scene::{Scene, Surface};
use nalgebra::Vector3;

/// An acceleration to be applied to one particle.
#[derive(Clone, Copy, Debug)]
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

/// What is known of two touching bodies besides their motion.
#[derive(Clone, Copy, Debug)]
struct Touch {
    i: u32,
    /// Place of the other particle, or index of the wall.
    other: u32,
    wall: bool,
    effective_mass: f64,
    damping: f64,
    /// [m] smaller diameter.
    diameter: f64,
}

/// A contact that has begun and not ended.
#[derive(Clone, Copy, Debug)]
struct Contact {
    slot: u32,
    touch: Touch,
    normal_speed: f64,
    first_overlap: f64,
    maximum_overlap: f64,
    began: f64,
}

/// Relative motion of two bodies that overlap.
struct Meeting {
    /// From the other body to particle i.
    normal: Vector3<f64>,
    overlap: f64,
    /// [m/s] positive: separating.
    normal_velocity: f64,
    slip: Vector3<f64>,
}

/// Powers [W] and force on the particles from walls [N], as of the last evaluation.
#[derive(Clone, Copy, Debug, Default)]
struct Rates {
    pair_restitution: f64,
    pair_friction: f64,
    wall_restitution: f64,
    wall_friction: f64,
    wall_force: Vector3<f64>,
    wall_normal_force: f64,
}

/// All contacts of a scene.
pub struct Contacts {
    law: LinearSpringDashpot,
    /// In ascending order of slot.
    active: Vec<Contact>,
    /// Contacts that the last predicted state met first, in ascending order of slot: their forces acted already, so the
    /// speed of approach is the one seen there.
    foreseen: Vec<Contact>,
    slots: Vec<u32>,
    elastic_energy: f64,
    rates: Rates,
}

impl Contacts {
    pub fn new(law: LinearSpringDashpot) -> Self {
        Self {
            law,
            active: Vec::new(),
            foreseen: Vec::new(),
            slots: Vec::new(),
            elastic_energy: 0.0,
            rates: Rates::default(),
        }
    }

    pub fn elastic_energy(&self) -> f64 {
        self.elastic_energy
    }

    /// The store has been reordered and the list rebuilt: the particle once at `p` is now at `place_of[p]`.
    pub fn reorder(&mut self, place_of: &[u32], list: &NeighbourList) {
        let follow = |contact: &mut Contact| {
            let touch = &mut contact.touch;
            touch.i = place_of[touch.i as usize];
            let slot = if touch.wall {
                list.wall_slot(touch.i, touch.other)
            } else {
                touch.other = place_of[touch.other as usize];
                list.pair_slot(touch.i, touch.other)
            };
            contact.slot = slot.unwrap_or_default() as u32;
            slot.is_some()
        };
        for contacts in [&mut self.active, &mut self.foreseen] {
            contacts.retain_mut(follow);
            contacts.sort_unstable_by_key(|contact| contact.slot);
        }
    }

    /// Finds what overlaps, opens and closes contacts, and appends the accelerations to `pushes`. Returns the number
    /// of forces computed.
    pub fn evaluate(
        &mut self,
        list: &NeighbourList,
        particles: &Particles,
        scene: &Scene,
        at: Instant,
        pushes: &mut Vec<Push>,
        record: &mut Record,
    ) -> Result<u64, Failure> {
        let mut slots = std::mem::take(&mut self.slots);
        list.overlapping(particles, scene, &mut slots);
        let mut rates = Rates::default();
        self.elastic_energy = 0.0;
        let mut kept = 0;
        let mut known = 0;
        if at.opens {
            self.close_missing(&slots, particles, scene, at, record);
        } else {
            self.foreseen.clear();
        }
        let before = self.active.len();
        for &slot in &slots {
            while known < before && self.active[known].slot < slot {
                known += 1;
            }
            let mut contact = if known < before && self.active[known].slot == slot {
                self.active[known]
            } else {
                let touch = self.touch(slot, list, particles, scene);
                Contact {
                    slot,
                    touch,
                    normal_speed: 0.0,
                    first_overlap: 0.0,
                    maximum_overlap: 0.0,
                    began: at.start + at.elapsed,
                }
            };
            let meeting = contact.touch.meeting(particles, scene, at);
            contact.touch.check(&meeting, particles, at)?;
            if contact.first_overlap == 0.0 {
                let foreseen = self.foreseen.binary_search_by_key(&slot, |contact| contact.slot);
                contact.normal_speed = match foreseen {
                    Ok(k) if at.opens => self.foreseen[k].normal_speed,
                    _ => -meeting.normal_velocity,
                };
                contact.first_overlap = meeting.overlap;
            }
            contact.maximum_overlap = contact.maximum_overlap.max(meeting.overlap);
            self.push(&contact.touch, &meeting, particles, scene, at, pushes, &mut rates);
            if at.opens {
                if known < before && self.active[known].slot == slot {
                    self.active[known] = contact;
                } else {
                    self.active.push(contact);
                    kept += 1;
                }
            } else if !(known < before && self.active[known].slot == slot) {
                self.foreseen.push(contact);
            }
        }
        if kept > 0 {
            self.active.sort_unstable_by_key(|contact| contact.slot);
        }
        rates.add(at.weight * at.dt, at.remaining, scene, record);
        self.rates = rates;
        let forces = slots.len() as u64;
        self.slots = slots;
        Ok(forces)
    }

    /// Books the half of the last kick that was left for this window; `remaining` [s] is the whole window.
    pub fn settle(&mut self, time: f64, remaining: f64, scene: &Scene, record: &mut Record) {
        self.rates.add(time, remaining, scene, record);
        self.rates = Rates::default();
    }

    /// Records and removes the contacts whose slot no longer overlaps.
    fn close_missing(&mut self, slots: &[u32], particles: &Particles, scene: &Scene, at: Instant, record: &mut Record) {
        if self.active.is_empty() {
            return;
        }
        let mut next = slots.iter().peekable();
        self.active.retain(|contact| {
            while next.next_if(|&&slot| slot < contact.slot).is_some() {}
            if next.peek() == Some(&&contact.slot) {
                return true;
            }
            let rebound = contact.touch.meeting(particles, scene, at).normal_velocity;
            // a contact first seen while it opens (a start with overlap) is no impact
            if contact.normal_speed > 0.0 {
                let impacts = if contact.touch.wall { &mut record.walls } else { &mut record.pairs };
                impacts.add(&Impact {
                    normal_speed: contact.normal_speed,
                    rebound_speed: rebound,
                    duration: at.start + at.elapsed - contact.began,
                    first_overlap: contact.first_overlap / contact.touch.diameter,
                    maximum_overlap: contact.maximum_overlap / contact.touch.diameter,
                });
            }
            false
        });
    }

    fn touch(&self, slot: u32, list: &NeighbourList, particles: &Particles, scene: &Scene) -> Touch {
        let slot = slot as usize;
        if let Some(pair) = list.pairs.get(slot) {
            let (i, j) = (pair.i as usize, pair.j as usize);
            let effective_mass = 1.0 / (1.0 / particles.mass[i] + 1.0 / particles.mass[j]);
            let damping = self.law.damping(effective_mass, scene.contact.restitution);
            let diameter = 2.0 * particles.radius[i].min(particles.radius[j]);
            Touch { i: pair.i, other: pair.j, wall: false, effective_mass, damping, diameter }
        } else {
            let near = list.walls[slot - list.pairs.len()];
            let i = near.particle as usize;
            let effective_mass = particles.mass[i];
            let damping = self.law.damping(effective_mass, scene.walls[near.wall as usize].surface.restitution);
            let diameter = 2.0 * particles.radius[i];
            Touch { i: near.particle, other: near.wall, wall: true, effective_mass, damping, diameter }
        }
    }

    /// Force of one contact, as accelerations of its particles, and its powers.
    #[expect(clippy::too_many_arguments, reason = "one contact's share of everything an evaluation yields")]
    fn push(
        &mut self,
        touch: &Touch,
        meeting: &Meeting,
        particles: &Particles,
        scene: &Scene,
        at: Instant,
        pushes: &mut Vec<Push>,
        rates: &mut Rates,
    ) {
        let surface = touch.surface(scene);
        let m = touch.effective_mass;
        let (spring, dashpot) = self.law.normal_force(meeting.overlap, meeting.normal_velocity, m, touch.damping);
        let normal = spring + dashpot;
        let slip = meeting.slip.norm();
        let friction = friction_force(surface, normal, slip, m, at.dt);
        let mut force = meeting.normal * normal;
        if friction > 0.0 {
            force -= meeting.slip * (friction / slip);
        }
        self.elastic_energy += 0.5 * self.law.stiffness * meeting.overlap * meeting.overlap;
        let restitution_power = -dashpot * (meeting.normal_velocity + at.to_middle * normal / m);
        let friction_power = friction * (slip - at.to_middle * friction / m);
        let i = touch.i as usize;
        pushes.push(Push { particle: touch.i, acceleration: force / particles.mass[i] });
        if touch.wall {
            rates.wall_restitution += restitution_power;
            rates.wall_friction += friction_power;
            rates.wall_force += force;
            rates.wall_normal_force += normal;
        } else {
            rates.pair_restitution += restitution_power;
            rates.pair_friction += friction_power;
            pushes.push(Push { particle: touch.other, acceleration: -force / particles.mass[touch.other as usize] });
        }
    }
}

impl Touch {
    fn surface<'s>(&self, scene: &'s Scene) -> &'s Surface {
        if self.wall { &scene.walls[self.other as usize].surface } else { &scene.contact }
    }

    fn meeting(&self, particles: &Particles, scene: &Scene, at: Instant) -> Meeting {
        let i = self.i as usize;
        let (x, r) = (&particles.position[i], particles.radius[i]);
        let (normal, gap, velocity) = if self.wall {
            let nearest = scene.walls[self.other as usize].geometry.law().nearest(x);
            (nearest.normal, nearest.distance - r, particles.velocity[i] + scene.gravity * at.fall)
        } else {
            let j = self.other as usize;
            let apart = scene.domain.separation(x, &particles.position[j]);
            let distance = apart.norm();
            // centres that coincide have no normal; the overlap check refuses them
            let normal = if distance > 0.0 { apart / distance } else { Vector3::y() };
            (normal, distance - (r + particles.radius[j]), particles.velocity[i] - particles.velocity[j])
        };
        let normal_velocity = velocity.dot(&normal);
        Meeting { normal, overlap: -gap, normal_velocity, slip: velocity - normal * normal_velocity }
    }

    /// Refuses overlaps at which "the normal" no longer means anything: centres of a pair nearer than half the distance
    /// of touch, or a sphere wholly behind a wall.
    fn check(&self, meeting: &Meeting, particles: &Particles, at: Instant) -> Result<(), Failure> {
        let limit = if self.wall { 1.0 } else { 0.5 };
        let ratio = meeting.overlap / self.diameter;
        if ratio <= limit {
            return Ok(());
        }
        let partner =
            if self.wall { Partner::Wall(self.other) } else { Partner::Particle(particles.id[self.other as usize]) };
        let particle = particles.id[self.i as usize];
        Err(Failure::OverlapTooLarge { time: at.start + at.elapsed, particle, partner, ratio, limit })
    }
}

impl Rates {
    fn add(&self, time: f64, remaining: f64, scene: &Scene, record: &mut Record) {
        let ledger = &mut record.ledger;
        ledger.pair_restitution_loss += self.pair_restitution * time;
        ledger.pair_friction_loss += self.pair_friction * time;
        ledger.wall_restitution_loss += self.wall_restitution * time;
        ledger.wall_friction_loss += self.wall_friction * time;
        let impulse = self.wall_force * time;
        ledger.wall_impulse += impulse;
        ledger.wall_normal_impulse += self.wall_normal_force * time;
        // what walls add to the momentum, gravity works on for the rest of the window
        ledger.gravity_work += scene.gravity.dot(&impulse) * remaining;
    }
}
