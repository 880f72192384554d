//! The only contact of an island, without friction: for how long it is sure to stay so, and taking it to its end.

use super::Run;
use super::alone::{Alone, State};
use crate::engine::Failure;
use crate::engine::soft::contact::Meeting;
use nalgebra::Vector3;

impl Run<'_> {
    /// [s] for how long a single contact without friction is sure to remain the only one, up to `end`; 0 where there are
    /// several, or friction, or a curved wall.
    pub(super) fn clear_time(&self, end: f64) -> f64 {
        let [contact] = self.scratch.contacts.as_slice() else { return 0.0 };
        let touch = &contact.touch;
        let flat = !touch.wall || self.scene.walls[touch.other as usize].geometry.is_flat();
        if touch.surface(self.scene).friction > 0.0 || !flat {
            return 0.0;
        }
        let left = end - self.now;
        let among = |place: usize| place == touch.i as usize || (!touch.wall && place == touch.other as usize);
        // the speed of the two relative to each other stays below this, so neither velocity changes by more than twice it
        let meeting = self.meeting(touch, self.now);
        let stored = 2.0 * self.engine.law.stored_energy(touch.spring(), contact.overlap) / touch.effective_mass();
        let change = 2.0 * (meeting.normal_velocity.powi(2) + meeting.slip.norm_squared() + stored).sqrt();
        let list = &self.island.list;
        let clear = |slot: usize| {
            let (gap, rate) = self.scratch.gaps[slot];
            let (speed, mine) = match list.pairs.get(slot) {
                Some(pair) => {
                    let (i, j) = (pair.i as usize, pair.j as usize);
                    let speed = (self.particles.velocity[i] - self.particles.velocity[j]).norm();
                    (speed, usize::from(among(i)) + usize::from(among(j)))
                }
                None => {
                    let near = list.walls[slot - list.pairs.len()];
                    let curved = !self.scene.walls[near.wall as usize].geometry.is_flat();
                    let along = if curved { self.particles.velocity[near.particle as usize].norm() } else { 0.0 };
                    let gravity = self.scene.gravity.norm() * end;
                    (rate.abs() + along + gravity, usize::from(among(near.particle as usize)))
                }
            };
            gap / (speed + mine as f64 * change)
        };
        let others = (0..list.slots()).filter(|&slot| slot != contact.slot as usize).map(clear);
        others.fold(left, |least, time| if time >= 0.0 { least.min(time) } else { 0.0 })
    }

    /// Takes the only contact there is to its end, or for `clear` [s]; everybody else flies. Gives who got out of bounds.
    pub(super) fn resolve_alone(&mut self, clear: f64) -> Result<Option<usize>, Failure> {
        let (start, gravity) = (self.now, self.scene.gravity);
        let touch = self.scratch.contacts[0].touch;
        let meeting = self.meeting(&touch, start);
        let i = touch.i as usize;
        let j = (!touch.wall).then_some(touch.other as usize);
        let (radii, spin, fall) = match j {
            None => (self.particles.radius[i], 0.0, gravity.dot(&meeting.normal)),
            Some(j) => (self.particles.radius[i] + self.particles.radius[j], meeting.slip.norm(), 0.0),
        };
        let distance = radii - meeting.overlap;
        let alone = Alone {
            law: &self.engine.law,
            touch,
            reach: radii,
            spin: spin * distance,
            gravity: fall,
            normal: meeting.normal,
            stages: self.engine.stages(),
        };
        let begin = State { distance, rate: meeting.normal_velocity, angle: 0.0 };
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
            let overlap = radii - state.distance;
            self.deepen(0, &Meeting { overlap, normal_velocity: state.rate, ..meeting }, taken)?;
        }
        // everybody else has flown straight, and so has the centre of mass
        let (x, v) = (self.particles.position[i], self.particles.velocity[i]);
        let other = j.map(|j| (self.particles.position[j], self.particles.velocity[j]));
        self.now = start;
        self.fly(start + time);
        match (j, other) {
            (Some(j), Some((xj, vj))) => {
                let (mi, mj) = (self.particles.mass[i], self.particles.mass[j]);
                let along = if spin > 0.0 { meeting.slip / spin } else { Vector3::zeros() };
                let (sin, cos) = state.angle.sin_cos();
                let (normal, along) = (meeting.normal * cos + along * sin, along * cos - meeting.normal * sin);
                // how much more than on a straight flight the two have moved, and changed their velocity
                let straight = self.scene.domain.separation(&x, &xj) + (v - vj) * time;
                let moved = normal * state.distance - straight;
                let kicked = normal * state.rate + along * (alone.spin / state.distance) - (v - vj);
                let (share, rest) = (mj / (mi + mj), mi / (mi + mj));
                self.particles.position[i] += moved * share;
                self.particles.position[j] -= moved * rest;
                self.particles.velocity[i] += kicked * share;
                self.particles.velocity[j] -= kicked * rest;
            }
            _ => {
                // seen from the wall the frame falls
                let normal = meeting.normal;
                let straight = begin.distance + (begin.rate + 0.5 * fall * time) * time;
                self.particles.position[i] += normal * (state.distance - straight);
                self.particles.velocity[i] += normal * (state.rate - begin.rate - fall * time);
            }
        }
        self.look();
        let slot = self.scratch.contacts[0].slot as usize;
        if !closed {
            self.turn(slot);
        }
        let places = [Some(i), j];
        Ok(places.into_iter().flatten().find(|&place| !self.island.allows(place, &self.particles.velocity[place])))
    }
}
