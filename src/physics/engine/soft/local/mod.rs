//! Local stepping of one island (group of particles that may meet): straight flight to the first touch, time steps
//! while bodies touch, then straight flight again. A slot is the number of a candidate (pair, or particle and wall) in
//! the neighbour list of the island. A part is a piece of a window, the time between two exchanges with the gas. Times
//! are counted from the start of the part.
//!
//! The instants at which contacts begin and end are found within a step. So no contact begins or ends late, and the
//! error of the restitution has the order of the integrator. The steps are Runge-Kutta of fourth order, or of second
//! order for comparison with the paper that docs/paper.md describes.

mod alone;
mod integrate;
mod numbered;
mod single;
mod sliding;
mod spring_energy;
mod springs;
mod turns;

use super::backoff::steps_cost;
use super::contact::{Contact, SHORT, TouchingPair, passed};
use super::rates::Rates;
use crate::contact_law::ContactLaw;
use crate::encounter::{Couple, Encounter, FrameTime, Other};
use crate::engine::islands::{BoundedIslands, GivenUp, Island, Solve};
use crate::engine::{Failure, Window};
use crate::experiment::Integrator;
use crate::particles::Particles;
use crate::record::{FrictionLosses, Log};
use crate::scene::Scene;
use alone::TRIALS;
use integrate::{FOURTH_ORDER, HEUN, RungeKuttaStage, crossing};
use nalgebra::Vector3;
use sliding::SlidingContact;
use spring_energy::SpringEnergies;

/// Two bodies of an island (group of particles that may meet) that touch at the present time of the island.
pub struct ReachedTouch<'a> {
    /// The two bodies and their contact constants.
    pub touch: TouchingPair,
    /// Gap, normal and relative velocity of the two bodies.
    pub met: Encounter,
    /// Walls, surfaces and gravity.
    pub scene: &'a Scene,
    /// Time of the touch, in a frame of reference that falls freely from the start of the part (time for which the
    /// island is solved).
    pub moment: FrameTime,
    /// [s] time from the touch to the end of the window.
    pub remaining: f64,
}

/// Rule that decides which touches are instantaneous impulses; all other touches begin a contact.
pub trait InstantaneousRule: Sync {
    /// [s] time for which no third body may reach the two bodies if their touch is to be an instantaneous impulse.
    /// `None` if the touch begins a contact in any case.
    fn clear_for(&self, meeting: &ReachedTouch, particles: &Particles) -> Option<f64>;

    /// Applies the impulse of an instantaneous touch, and records the impulse in `log`.
    fn strike(&self, meeting: &ReachedTouch, particles: &mut Particles, log: &mut Log);
}

/// Rule by which every touch begins a contact, and none is an instantaneous impulse.
pub struct NoInstants;

impl InstantaneousRule for NoInstants {
    #[inline(always)]
    fn clear_for(&self, _meeting: &ReachedTouch, _particles: &Particles) -> Option<f64> {
        None
    }

    fn strike(&self, _meeting: &ReachedTouch, _particles: &mut Particles, _log: &mut Log) {}
}

/// Solver of islands (groups of particles that may meet) of soft spheres, by local time steps.
pub struct SoftIslands<I = NoInstants> {
    /// Contact law of all contacts in the islands.
    pub law: ContactLaw,
    /// Time integrator. Islands use fourth-order Runge-Kutta for `VelocityVerlet`, and Heun's method for `Rk2`.
    pub integrator: Integrator,
    /// [s] longest time step while bodies of the island are in contact.
    pub step: f64,
    /// Largest cost of an island. A more expensive island is given up, and its particles are moved by uniform steps
    /// (equal steps of all particles).
    pub allowance: Allowance,
    /// Rule that decides which touches are instantaneous.
    pub instants: I,
}

/// [ns/s] largest cost (computing time) of an island (group of particles that may meet) per simulated time. If it is
/// infinite, no island is given up.
#[derive(Clone, Copy, Debug)]
pub struct Allowance {
    /// [ns/s] part of the largest cost that is the same for all islands (groups of particles that may meet).
    pub each: f64,
    /// [ns/s] part of the largest cost that is added for each hot particle (member) of the island.
    pub per_particle: f64,
}

impl<I> SoftIslands<I> {
    /// Stages of the Runge-Kutta method by which an island (group of particles that may meet) makes a step.
    pub fn stages(&self) -> &'static [RungeKuttaStage] {
        match self.integrator {
            Integrator::VelocityVerlet => &FOURTH_ORDER,
            Integrator::Rk2 => &HEUN,
        }
    }
}

/// Working memory of a thread that solves islands (groups of particles that may meet) one after another.
#[derive(Default)]
pub struct IslandScratch {
    contacts: Vec<Contact>,
    /// Bodies and contact constants of every slot (candidate: two particles, or a particle and a wall).
    touches: Vec<TouchingPair>,
    /// True for each slot (candidate: two particles, or a particle and a wall) that is in contact.
    touching: Vec<bool>,
    /// Present gap [m] and its rate [m/s] of every slot (candidate).
    gaps: Vec<(f64, f64)>,
    /// Gap [m] and its rate [m/s] of every slot (candidate) before the step.
    before: Vec<(f64, f64)>,
    position: Vec<Vector3<f64>>,
    velocity: Vec<Vector3<f64>>,
    acceleration: Vec<Vector3<f64>>,
    moved: Vec<Vector3<f64>>,
    kicked: Vec<Vector3<f64>>,
    /// Springs of the contacts in `contacts`; empty if spheres do not rotate.
    sliding: Vec<SlidingContact>,
    /// [rad/s] spin of each particle at the start of the step.
    spin: Vec<Vector3<f64>>,
    /// [rad/s²] angular acceleration of each particle at the last Runge-Kutta stage.
    turning: Vec<Vector3<f64>>,
    /// [rad/s²] angular acceleration of each particle, averaged over the stages of the step with their Runge-Kutta
    /// weights.
    turned: Vec<Vector3<f64>>,
    /// [W] power that friction dissipates, listed by cause and averaged over the stages with their Runge-Kutta weights.
    /// Rolling and twisting include the power that the springs store.
    losses: FrictionLosses,
}

impl<I: InstantaneousRule> Solve for SoftIslands<I> {
    type Finder<'a> = BoundedIslands<'a>;
    type Carried = Contact;
    type Scratch = IslandScratch;

    fn indices(contact: &Contact) -> [Option<u32>; 2] {
        contact.touch.couple.indices()
    }

    fn moved(contact: &Contact, index_of: &dyn Fn(u32) -> u32) -> Contact {
        let couple = contact.touch.couple.moved(index_of);
        Contact { touch: TouchingPair { couple, ..contact.touch }, ..*contact }
    }

    fn energy(&self, contact: &Contact) -> f64 {
        let [sheared, rolling, twisting] = self.spring_energies(contact);
        self.law.stored_energy(&contact.touch.spring, contact.course.overlap) + sheared + (rolling + twisting)
    }

    fn available_energy(&self, contact: &Contact) -> f64 {
        let [sheared, rolling, twisting] = self.spring_energies(contact);
        self.law.available_energy(&contact.touch.spring, contact.course.overlap) + sheared + (rolling + twisting)
    }

    fn spring_energies(&self, contact: &Contact) -> [f64; 3] {
        let Contact { touch, course, .. } = contact;
        let sheared = touch.tangential.at(course.overlap).energy(&course.shear);
        let [rolling, twisting] = course.resistance.map_or([0.0; 2], |memory| memory.energies);
        [sheared, rolling, twisting]
    }

    fn touching(&self, contact: &Contact) -> Option<Couple> {
        Some(contact.touch.couple)
    }

    fn solve(
        &self,
        island: &mut Island<Contact>,
        scratch: &mut IslandScratch,
        scene: &Scene,
        window: Window,
        end: f64,
    ) -> Result<Option<usize>, GivenUp> {
        let mut particles = std::mem::take(&mut island.particles);
        scratch.contacts.clear();
        scratch.touches.clear();
        for slot in 0..island.list.slots() {
            let couple = island.list.couple(slot);
            scratch.touches.push(TouchingPair::new(couple, &particles, scene, &self.law));
            let here = island.carried.iter().filter(|contact| contact.touch.couple.is(&couple));
            scratch.contacts.extend(here.map(|contact| Contact { slot: slot as u32, ..*contact }));
        }
        let mut run = IslandRun {
            engine: self,
            island,
            scratch,
            scene,
            window,
            particles: &mut particles,
            now: 0.0,
            struck: None,
        };
        if run.rotates() {
            run.adopt_springs();
        }
        let result = run.until(end);
        island.carried.clear();
        island.carried.extend_from_slice(&scratch.contacts);
        island.particles = particles;
        result
    }
}

/// Computation of one island (group of particles that may meet) in a part (interval of time). Positions and velocities
/// are relative to a frame of reference that falls freely, from rest at the start of the part.
struct IslandRun<'a, I> {
    engine: &'a SoftIslands<I>,
    island: &'a mut Island<Contact>,
    scratch: &'a mut IslandScratch,
    scene: &'a Scene,
    window: Window,
    particles: &'a mut Particles,
    now: f64,
    /// The two bodies of the last instantaneous touch, or of the last touch at which a rough wall turned a velocity.
    /// `None` after their velocities have been checked against the speed limits.
    struck: Option<Couple>,
}

impl<I: InstantaneousRule> IslandRun<'_, I> {
    /// Moves the island until `end` [s] after the start of the part, or until a particle exceeds its speed limit (the
    /// bound with which islands were found) or is touched without being a member. Returns the local index of that
    /// particle; `None` if the island has reached `end`. It is an error if the island costs too much or the engine
    /// fails.
    fn until(&mut self, end: f64) -> Result<Option<usize>, GivenUp> {
        self.update_gaps();
        while self.now < end {
            if self.scratch.contacts.is_empty() {
                let Some((touch, slot)) = self.next_touch(end) else { break };
                self.fly(touch);
                self.update_gaps();
                self.open(slot);
            } else {
                let clear = self.clear_time(end);
                if clear >= self.engine.step {
                    if let Some(index) = self.resolve_alone(clear)? {
                        return Ok(Some(index));
                    }
                } else {
                    self.step((end - self.now).min(self.engine.step))?;
                }
                if end - self.now <= 1e-12 * self.engine.step {
                    self.now = end;
                }
            }
            if self.costs_too_much(end) {
                return Err(GivenUp::TooExpensive);
            }
            if let Some(index) = self.out_of_bounds() {
                return Ok(Some(index));
            }
        }
        self.fly(end);
        if self.rotates() {
            self.leave_springs();
        }
        // positions and velocities are converted from the falling frame to the frame at rest
        for (x, v) in self.particles.position.iter_mut().zip(&mut self.particles.velocity) {
            *x += self.scene.gravity * (0.5 * end * end);
            *v += self.scene.gravity * end;
        }
        Ok(None)
    }

    /// True if solving the island has cost more so far than is allowed for the simulated time up to `end` [s]. The cost
    /// is that of steps, and of testing all pairs in the searches for the next touch.
    fn costs_too_much(&self, end: f64) -> bool {
        let Allowance { each, per_particle } = self.engine.allowance;
        let allowed = (each + per_particle * self.island.hot as f64) * end;
        let Island { force_evaluations, updates, pair_checks, .. } = &*self.island;
        steps_cost(*force_evaluations, updates + pair_checks) > allowed
    }

    /// Index of a particle, in contact or just struck, that exceeds its speed limit or is not a member of the island;
    /// `None` if there is no such particle.
    fn out_of_bounds(&mut self) -> Option<usize> {
        let struck = self.struck.take();
        let couples = self.scratch.contacts.iter().map(|contact| contact.touch.couple).chain(struck);
        let indices = couples.flat_map(|couple| couple.indices()).flatten();
        let mut indices = indices.map(|index| index as usize);
        indices.find(|&index| !self.island.allows(index, &self.particles.velocity[index]))
    }

    /// Moves all particles along straight lines until the time `time` [s], counted from the start of the part.
    fn fly(&mut self, time: f64) {
        let dt = time - self.now;
        for (x, v) in self.particles.position.iter_mut().zip(&self.particles.velocity) {
            *x += v * dt;
        }
        self.now = time;
    }

    /// First touch of two bodies on straight flights from now until `end` [s]: the time [s] of the touch, and its slot
    /// (number of the candidate). `None` if no bodies touch before `end`. Times are counted from the start of the part.
    fn next_touch(&mut self, end: f64) -> Option<(f64, usize)> {
        let left = end - self.now;
        self.island.pair_checks += self.island.list.slots() as u64;
        let times = (0..self.island.list.slots()).filter_map(|slot| {
            let couple = &self.scratch.touches[slot].couple;
            Some((couple.touch_time(self.particles, self.scene, self.moment(), left)?, slot))
        });
        let first = times.min_by(|a, b| a.0.total_cmp(&b.0))?;
        (first.0 < left).then_some((self.now + first.0, first.1))
    }

    /// Present time of the island, in the frame that falls freely from the start of the part.
    fn moment(&self) -> FrameTime {
        FrameTime::in_free_fall(self.now)
    }

    /// Present gap [m] between the two bodies of the slot `slot` (candidate), and rate of change of the gap [m/s];
    /// positive: separating.
    fn gap(&self, slot: usize) -> (f64, f64) {
        let met = self.encounter(slot, &self.scratch.touches[slot].couple, self.moment());
        (met.gap, met.normal_velocity)
    }

    /// Computes the present gaps of all slots (candidates) and their rates, and stores them in `gaps`.
    fn update_gaps(&mut self) {
        let mut gaps = std::mem::take(&mut self.scratch.gaps);
        self.island.updates += self.island.list.slots() as u64;
        gaps.clear();
        for (slot, touch) in self.scratch.touches.iter().enumerate() {
            // if the nearest contact with a wall has a gap, the gaps of the further contacts are at least as large
            let before = slot.checked_sub(1).filter(|_| touch.couple.is_further() && !self.follows_normals(slot));
            let nearer = before.and_then(|slot| Some((self.scratch.touches.get(slot)?, gaps.get(slot)?)));
            let beyond =
                nearer.filter(|(before, gap)| gap.0 > 0.0 && touch.couple.is_beyond(&before.couple, self.scene));
            gaps.push(beyond.map_or_else(|| self.gap(slot), |(_, gap)| *gap));
        }
        self.scratch.gaps = gaps;
    }

    /// Makes one step of up to `dt` [s], which ends at the first instant at which a contact begins or ends, or at which
    /// a spring starts or stops sliding. Before and after the step, `gaps` contains the present gaps.
    fn step(&mut self, dt: f64) -> Result<(), Failure> {
        self.scratch.position.clone_from(&self.particles.position);
        self.scratch.velocity.clone_from(&self.particles.velocity);
        let start = self.now;
        let mut stored = SpringEnergies::default();
        if self.rotates() {
            stored = self.spring_energies();
            self.keep_springs();
        }
        let scratch = &mut *self.scratch;
        std::mem::swap(&mut scratch.gaps, &mut scratch.before);
        let mut rates = self.integrate(dt);
        self.update_gaps();
        let scratch = &mut *self.scratch;
        scratch.touching.clear();
        scratch.touching.resize(scratch.gaps.len(), false);
        for contact in &scratch.contacts {
            scratch.touching[contact.slot as usize] = true;
        }
        let mut first: Option<(f64, usize)> = None;
        for (slot, (&was, &(gap, rate))) in self.scratch.before.iter().zip(&self.scratch.gaps).enumerate() {
            let touching = self.scratch.touching[slot];
            // an overlap begins a contact if it grows, or if there was a gap before the step; two bodies whose contact
            // has just ended may still overlap by rounding, but their gap grows
            let turns = if touching { gap > 0.0 } else { gap < 0.0 && (rate < 0.0 || was.0 > 0.0) };
            if turns {
                let fraction = crossing(was, (gap, rate), dt);
                if first.is_none_or(|(least, _)| fraction < least) {
                    first = Some((fraction, slot));
                }
            }
        }
        let switch = if self.rotates() { self.first_switch() } else { None };
        let switch = switch.filter(|(fraction, ..)| first.is_none_or(|(least, _)| *fraction < least));
        if let Some(switch) = switch {
            first = None;
            rates = self.find_switch(start, dt, switch);
            self.update_gaps();
        } else if let Some((fraction, slot)) = first {
            rates = self.find_turn(start, dt, fraction, slot);
            self.update_gaps();
        }
        self.refuse_to_pass(start)?;
        if self.rotates() {
            self.keep_in_springs(&stored, self.now - start);
            self.switch_phases(switch.map(|(_, k, which)| (k, which)));
        }
        self.book(rates, self.now - start)?;
        if let Some((_, slot)) = first {
            self.turn(slot);
        }
        Ok(())
    }

    /// Returns an error if the centre of a sphere has passed a thin wall in the step that began at `start` [s]. Sphere
    /// and wall need not overlap at the start or end of such a step.
    fn refuse_to_pass(&self, start: f64) -> Result<(), Failure> {
        for touch in &self.scratch.touches {
            let (i, Other::Wall(at)) = (touch.couple.i as usize, touch.couple.other) else { continue };
            let fallen = |time: f64| self.scene.gravity * (0.5 * time * time);
            let from = self.scratch.position[i] + fallen(start);
            let to = self.particles.position[i] + fallen(self.now);
            let radius = self.particles.radius[i];
            let wall = &self.scene.walls[at.wall as usize];
            let length = (to - from).norm() + wall.travel(self.now - start);
            let is_long = length >= SHORT * radius;
            if is_long && at.which == 0 && wall.is_passed([&from, &to], radius, [start, self.now]) {
                return Err(passed(self.particles, i, (at.wall, self.window.start + start), length));
            }
        }
        Ok(())
    }

    /// Makes again, with the new length `dt` [s], the step that began at `start` [s]. Returns the powers and wall
    /// forces as means over the step.
    fn repeat(&mut self, start: f64, dt: f64) -> Rates {
        self.particles.position.clone_from(&self.scratch.position);
        self.particles.velocity.clone_from(&self.scratch.velocity);
        if self.rotates() {
            self.restore_spins();
        }
        self.now = start;
        self.integrate(dt)
    }

    /// Records the powers and forces of a step of `dt` [s] in the log, and the overlaps in the contacts.
    fn book(&mut self, rates: Rates, dt: f64) -> Result<(), Failure> {
        let remaining = self.window.duration - (self.now - 0.5 * dt);
        rates.add(dt, remaining, self.scene, &mut self.island.log);
        self.island.events += 1;
        for k in 0..self.scratch.contacts.len() {
            let (_, met) = self.met(k);
            self.deepen(k, &met, dt)?;
        }
        Ok(())
    }

    /// Records the overlap of a contact after a step of `dt` [s]. Returns an error if the overlap is too large, or if
    /// the centre has passed the other body.
    fn deepen(&mut self, contact: usize, met: &Encounter, dt: f64) -> Result<(), Failure> {
        let contact = &mut self.scratch.contacts[contact];
        let instant = (self.window.start + self.now, dt);
        let TouchingPair { couple, constants } = &contact.touch;
        contact.course.check(couple, constants, met, (self.particles, self.scene), instant)?;
        // integral of the cubic polynomial that has these overlaps and rates at both ends of the step
        let course = &mut contact.course;
        let (before, growing) = (course.overlap, course.growth);
        course.note(met);
        course.overlap_time += 0.5 * dt * (before + course.overlap) + dt * dt / 12.0 * (growing - course.growth);
        Ok(())
    }
}
