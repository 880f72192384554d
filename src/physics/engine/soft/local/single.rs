//! Single contact of an island (group of particles that may meet), without friction: the time for which no other
//! contact can begin, and the motion until the contact ends. A slot is the number of a candidate (pair, or particle and
//! wall) in the neighbour list of the island. Times are counted from the start of the part, a piece of the time between
//! two exchanges with the gas.

use super::alone::{IsolatedContact, OrbitState};
use super::{InstantaneousRule, IslandRun, ReachedTouch};
use crate::encounter::{AtWall, Couple, Encounter, Other, relative};
use crate::engine::Failure;
use crate::engine::soft::contact::{ContactConstants, TouchingPair};
use crate::rotation::Rotation;
use nalgebra::Vector3;

/// True if the particle at `index` is one of the two bodies of `couple`.
fn is_of(couple: &Couple, index: u32) -> bool {
    couple.indices().contains(&Some(index))
}

impl<I: InstantaneousRule> IslandRun<'_, I> {
    /// [s] time from now, at most until `end` [s], for which a single contact without friction remains the only one.
    /// It is 0 if there is not exactly one contact, or if it has friction. It is also 0 if the contact is at a curved
    /// or moving wall, or if another gap is closed.
    pub(super) fn clear_time(&self, end: f64) -> f64 {
        let [contact] = self.scratch.contacts.as_slice() else { return 0.0 };
        let TouchingPair { couple, constants: ContactConstants { spring, friction, .. } } = contact.touch;
        let curved = couple.is_wall() && !couple.is_flat(self.scene);
        let moves = matches!(couple.other, Other::Wall(at) if self.scene.walls[at.wall as usize].moving.is_some());
        let resists = self.scene.rotation.as_ref().is_some_and(Rotation::resists);
        if friction > 0.0 || resists || curved || moves {
            return 0.0;
        }
        let left = end - self.now;
        // without gravity, the relative speed of the two bodies stays below this root, so neither velocity changes by
        // more than twice the root
        let met = couple.meet(self.particles, self.scene, self.moment());
        let stored = 2.0 * self.engine.law.available_energy(&spring, contact.course.overlap) / spring.effective_mass;
        let change = 2.0 * (met.normal_velocity.powi(2) + met.slip().norm_squared() + stored).sqrt();
        // a wall holds its particle against gravity, while all other particles fall
        let held = if couple.is_wall() { self.scene.gravity.dot(&met.normal).abs() } else { 0.0 };
        let others = (0..self.scratch.touches.len()).filter(|&slot| slot != contact.slot as usize);
        let clear = others.map(|slot| self.clear_of(slot, &couple, [change, held], end));
        clear.fold(left, |least, time| if time >= 0.0 { least.min(time) } else { 0.0 })
    }

    /// Vector [m] from particle j to particle i, and velocity [m/s] of i relative to j, at the present time of the
    /// island.
    fn relative(&self, i: usize, j: usize) -> (Vector3<f64>, Vector3<f64>) {
        relative(self.particles, self.scene, [i, j], self.moment())
    }

    /// Number of particles of `couple` that are also a body of the slot `slot` (two particles, or a particle and a
    /// wall).
    fn shared(&self, slot: usize, couple: &Couple) -> usize {
        let indices = self.scratch.touches[slot].couple.indices();
        indices.into_iter().flatten().filter(|&index| is_of(couple, index)).count()
    }

    /// [s] time from now for which the gap of the slot `slot` (candidate) cannot close; it is valid up to `end` [s]
    /// after the start of the part. Meanwhile the velocity of each body of `couple` may change by `change` [m/s] at
    /// once, and by the acceleration `held` [m/s²]. The result is negative or not a number if the gap is closed
    /// already.
    fn clear_of(&self, slot: usize, couple: &Couple, [change, held]: [f64; 2], end: f64) -> f64 {
        let velocity = |index: u32| self.particles.velocity[index as usize];
        let (gap, rate) = self.scratch.gaps[slot];
        let other = self.scratch.touches[slot].couple;
        let speed = match other.j() {
            Some(j) => self.relative(other.i as usize, j as usize).1.norm(),
            None => {
                let along = if other.is_flat(self.scene) { 0.0 } else { velocity(other.i).norm() };
                rate.abs() + along + self.scene.gravity.norm() * end + self.swing(&other)
            }
        };
        let shared = self.shared(slot, couple) as f64;
        let (speed, held) = (speed + shared * change, shared * held);
        // the time t with gap = speed t + held t²/2
        if held == 0.0 { gap / speed } else { 2.0 * gap / (speed + (speed * speed + 2.0 * held * gap).sqrt()) }
    }

    /// [m/s] upper limit of the change of velocity of the second body of `couple` between any two instants, if it is a
    /// moving wall. 0 for a wall that does not move, and for a particle.
    fn swing(&self, couple: &Couple) -> f64 {
        match couple.other {
            Other::Wall(at) => 2.0 * self.scene.walls[at.wall as usize].largest_speed(),
            Other::Particle(_) => 0.0,
        }
    }

    /// True if the gap of the slot `slot` (candidate) may close within `time` [s] because the impulse of the touch
    /// `meeting` changes the velocity of one of its particles.
    ///
    /// While two bodies fly straight, the rate at which their gap closes does not grow, so the present rate is an upper
    /// limit. An impulse changes the velocity of a particle by at most 2 (1 + μ) M |u_n|/m, or 2 (1 + μ) M |u|/m at a
    /// rough wall. Here m is the mass of the particle, M the effective mass, μ the friction coefficient and u the
    /// relative velocity with normal part u_n.
    fn may_come(&self, slot: usize, meeting: &ReachedTouch, time: f64) -> bool {
        let other = self.scratch.touches[slot].couple;
        let ReachedTouch { touch, met, scene, .. } = meeting;
        let rubs = 1.0 + touch.couple.surface(self.particles, scene).friction;
        let is_rough = |at: AtWall| scene.walls[at.wall as usize].roughness.is_some();
        let speed = match touch.couple.other {
            // a facet may have any normal
            Other::Wall(at) if is_rough(at) => met.velocity.norm(),
            Other::Wall(_) | Other::Particle(_) => met.normal_velocity.abs(),
        };
        let kick = 2.0 * rubs * touch.spring.effective_mass * speed;
        let shared = other.indices().into_iter().flatten().filter(|&index| is_of(&touch.couple, index));
        let change: f64 = shared.map(|index| kick / self.particles.mass[index as usize]).sum();
        if change == 0.0 {
            return false;
        }
        let (gap, rate) = self.scratch.gaps[slot];
        let at_wall = |i: u32| {
            let bent = if other.is_flat(self.scene) { 0.0 } else { self.particles.velocity[i as usize].norm() };
            bent + self.scene.gravity.norm() * (self.now + time) + self.swing(&other)
        };
        let curved = if other.is_wall() { at_wall(other.i) } else { 0.0 };
        (curved + change - rate) * time > gap
    }

    /// Applies an impulse if the touch of the two bodies of the slot `slot` (candidate) is instantaneous. Returns true
    /// if the impulse was applied.
    pub(super) fn strike(&mut self, slot: usize) -> bool {
        let touch = self.scratch.touches[slot];
        let moment = self.moment();
        let met = touch.couple.meet(self.particles, self.scene, moment);
        let meeting =
            ReachedTouch { touch, met, scene: self.scene, moment, remaining: self.window.duration - self.now };
        let Some(clear_for) = self.engine.instants.clear_for(&meeting, self.particles) else { return false };
        let shares = |couple: &Couple| couple.indices().into_iter().flatten().any(|index| is_of(&touch.couple, index));
        let held = self.scratch.contacts.iter().any(|contact| shares(&contact.touch.couple));
        let mut others = (0..self.scratch.touches.len()).filter(|&other| other != slot);
        if held || others.any(|other| self.may_come(other, &meeting, clear_for)) {
            return false;
        }
        self.engine.instants.strike(&meeting, self.particles, &mut self.island.log);
        self.island.impulses += 1;
        self.struck = Some(touch.couple);
        self.update_gaps();
        true
    }

    /// Computes the motion of the only contact to its end, but for at most `clear` [s], while all other particles fly
    /// straight. Returns the index of a particle of the contact that is not a member of the island, or is faster than
    /// its speed limit (estimated upper bound); the island must then be solved again. Otherwise returns `None`.
    ///
    /// # Errors
    /// The overlap is too large, or the centre of a particle has passed the other body.
    pub(super) fn resolve_alone(&mut self, clear: f64) -> Result<Option<usize>, Failure> {
        let start = self.now;
        let touch = self.scratch.contacts[0].touch;
        let met = touch.couple.meet(self.particles, self.scene, self.moment());
        let i = touch.couple.i as usize;
        let j = touch.couple.j().map(|j| j as usize);
        let (radii, spin, fall) = match j {
            None => (self.particles.radius[i], 0.0, self.scene.gravity.dot(&met.normal)),
            Some(j) => (self.particles.radius[i] + self.particles.radius[j], met.slip().norm(), 0.0),
        };
        let distance = radii - met.overlap();
        let alone = IsolatedContact {
            law: &self.engine.law,
            touch,
            reach: radii,
            spin: spin * distance,
            gravity: fall,
            normal: met.normal,
            stages: self.engine.stages(),
        };
        let begin = OrbitState { distance, rate: met.normal_velocity, angle: 0.0 };
        let mut state = begin;
        let (mut closed, mut time) = (true, 0.0);
        while closed && time < clear {
            let step = self.engine.step.min(clear - time);
            let (next, taken, rates) = alone.advance(&state, step);
            closed = next.distance < radii && taken == step;
            state = next;
            time += taken;
            self.now = start + time;
            self.island.force_evaluations += alone.stages.len() as u64;
            self.island.events += 1;
            rates.add(taken, self.window.duration - (self.now - 0.5 * taken), self.scene, &mut self.island.log);
            let gap = state.distance - radii;
            self.deepen(0, &Encounter { gap, normal_velocity: state.rate, ..met }, taken)?;
        }
        self.now = start;
        self.part(&alone, met.slip(), [begin, state], time);
        self.update_gaps();
        let slot = self.scratch.contacts[0].slot as usize;
        if !closed {
            self.turn(slot);
        }
        let indices = [Some(i), j];
        Ok(indices.into_iter().flatten().find(|&index| !self.island.allows(index, &self.particles.velocity[index])))
    }

    /// Moves all particles for `time` [s], while the only contact changes from the state `begin` to `state`. All other
    /// particles fly straight, and so does the centre of mass of the two touching bodies. `slip` [m/s] is the
    /// tangential relative velocity of these bodies at the start.
    fn part(&mut self, alone: &IsolatedContact, slip: Vector3<f64>, [begin, state]: [OrbitState; 2], time: f64) {
        let couple = alone.touch.couple;
        let (i, j) = (couple.i as usize, couple.j().map(|j| j as usize));
        let before = j.map(|j| self.relative(i, j));
        let image = couple.image_velocity(self.particles, self.scene, &before.unwrap_or_default().1);
        self.fly(self.now + time);
        match (j, before) {
            (Some(j), Some((apart, relative))) => {
                let (mi, mj) = (self.particles.mass[i], self.particles.mass[j]);
                let spin = slip.norm();
                let along = if spin > 0.0 { slip / spin } else { Vector3::zeros() };
                let (sin, cos) = state.angle.sin_cos();
                let (normal, along) = (alone.normal * cos + along * sin, along * cos - alone.normal * sin);
                // displacement and velocity change of one body relative to the other, beyond those of a straight
                // flight
                let straight = apart + relative * time;
                let moved = normal * state.distance - straight;
                let kicked = normal * state.rate + along * (alone.spin / state.distance) - relative;
                let (share, rest) = (mj / (mi + mj), mi / (mi + mj));
                self.particles.position[i] += moved * share;
                self.particles.position[j] -= moved * rest;
                self.particles.velocity[i] += kicked * share;
                self.particles.velocity[j] -= kicked * rest;
                self.island.log.ledger.shear_work += mi * share * kicked.z * image;
            }
            _ => {
                // distance from the wall after a flight without contact; gravity is included, since the wall does not
                // fall
                let (normal, fall) = (alone.normal, alone.gravity);
                let straight = begin.distance + (begin.rate + 0.5 * fall * time) * time;
                self.particles.position[i] += normal * (state.distance - straight);
                self.particles.velocity[i] += normal * (state.rate - begin.rate - fall * time);
            }
        }
    }
}
