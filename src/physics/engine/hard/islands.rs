//! Solver of islands of hard spheres: collisions in the order of their exact times, by a small event queue for each
//! island. An *island* is a group of particles that may meet within a *part*, a piece of the time between two exchanges
//! with the gas. Times are counted from the start of the part. A *slot* is the number of a candidate (pair, or particle
//! and wall) in the neighbour list of the island.

use super::calendar::Calendar;
use super::collapse_detector::{LastCollision, Recent, recent, rests};
use super::impulse::{Collision, CollisionMasses, ParticleAccess};
use crate::encounter::{Couple, FrameTime};
use crate::engine::Window;
use crate::engine::islands::{GivenUp, Island, Solve, TracedIslands};
use crate::scene::Scene;
use crate::walls::Touch;
use nalgebra::Vector3;

/// Solver that moves the hard spheres of one island (group of particles that may meet) from collision to collision
/// through a part (interval of time). Only the times of recent collisions are carried to the next part. The TC model
/// needs them: in it, a collision is elastic if the particle collided less than a contact time before.
#[derive(Default)]
pub struct HardIslands {
    /// Contact time t_c [s] of the TC model, in which a collision is elastic if either particle collided less than t_c
    /// before; `None` without this model.
    pub contact_time: Option<f64>,
}

impl Solve for HardIslands {
    type Finder<'a> = TracedIslands<'a>;
    type Carried = Recent;
    type Scratch = IslandEvents;

    fn indices(recent: &Recent) -> [Option<u32>; 2] {
        [Some(recent.index), None]
    }

    fn moved(recent: &Recent, index_of: &dyn Fn(u32) -> u32) -> Recent {
        Recent { index: index_of(recent.index), ..*recent }
    }

    fn energy(&self, _recent: &Recent) -> f64 {
        0.0
    }

    fn touching(&self, _recent: &Recent) -> Option<Couple> {
        None
    }

    /// Processes the collisions of the island (group of particles that may meet) one after the other, up to the time
    /// `end` [s] since the start of the part (interval of time). Returns the index, in the island, of a particle that
    /// became faster than the upper bound estimated for its speed; `None` if no particle did. An inelastic collapse
    /// (infinitely many collisions in finite time) is an error.
    ///
    /// During this work the stored position of a particle is not its present position. It is the point where the
    /// particle would have been at the start of the part if it had always flown with its present velocity. So the
    /// position at the time t is the stored point plus velocity times t. A collision then changes only the data of its
    /// two partners.
    fn solve(
        &self,
        island: &mut Island<Recent>,
        events: &mut IslandEvents,
        scene: &Scene,
        window: Window,
        end: f64,
    ) -> Result<Option<usize>, GivenUp> {
        events.begin(island, self.contact_time, scene, end);
        let mut too_fast = None;
        while too_fast.is_none()
            && let Some((slot, now)) = events.calendar.pop()
        {
            let (couple, feature) = (island.list.couple(slot as usize), events.feature(slot as usize, island));
            let (particles, moment) = (&mut island.particles, FrameTime::ahead(now));
            let met = couple.strike(particles, scene, moment, feature);
            let wall = couple.wall_motion(&met, (particles, scene), moment);
            let elastic = events.in_contact(&couple, window.start + now);
            let image = couple.image_velocity(particles, scene, &met.velocity);
            let collision = Collision { couple, met, elastic, kinds: couple.kinds(particles), wall, image };
            let (left, masses, log) = (window.duration - now, CollisionMasses::of(&couple, particles), &mut island.log);
            let (change_i, change_j) = match rests(&collision, scene, self.contact_time) {
                Some(speed) => (collision.hold_at_rest(speed, masses.mass, scene, left, log), Vector3::zeros()),
                None => collision.apply_impulse(&masses, &mut ParticleAccess::Exclusive(particles), scene, left, log),
            };
            island.events += 1;
            for (index, change) in couple.indices().into_iter().flatten().zip([change_i, change_j]) {
                particles.velocity[index as usize] += change;
                // the new flight passes through the present position, so its point at the start of the part changes
                particles.position[index as usize] -= change * now;
            }
            if events.show_collapse(&collision, scene, window.start + now) {
                return Err(GivenUp::Failed);
            }
            let partners = || couple.indices().into_iter().flatten().map(|index| index as usize);
            partners().for_each(|index| {
                island.turn(index as u32, now, island.particles.position[index], island.particles.velocity[index]);
                events.repredict(index, island, scene, now, end);
            });
            too_fast = partners().find(|&index| !island.allows(index, &island.particles.velocity[index]));
        }
        events.end(island, scene, (window.start + end, end));
        Ok(too_fast)
    }
}

/// Event queue of an island (group of particles that may meet), with the collision histories of its particles. The
/// events are the touches of the candidates in the neighbour list: pairs, and particles with walls.
#[derive(Clone, Default)]
pub struct IslandEvents {
    /// Queue of the coming touches, filled again for every island (group of particles that may meet).
    calendar: Calendar,
    /// Start of the entries of each particle in `adjacent`: the slots (numbers in the neighbour list) of particle `i`
    /// are `adjacent[first[i] .. first[i + 1]]`.
    first: Vec<u32>,
    adjacent: Vec<u32>,
    /// Scratch memory for the filling of `adjacent`: for each particle, the index of its next free entry there.
    next: Vec<u32>,
    /// For each candidate of a particle and a wall, the number of the surface feature (such as a triangle of a mesh)
    /// that the particle will touch next.
    features: Vec<u32>,
    /// Collision history of each particle of the island, by which inelastic collapse (infinitely many impacts in finite
    /// time) is detected.
    met: Vec<LastCollision>,
    /// Contact time t_c [s] of the TC model, in which a collision is elastic if either particle collided less than t_c
    /// before; `None` without this model.
    contact_time: Option<f64>,
}

impl IslandEvents {
    /// Prepares the events of an island (group of particles that may meet) that is to be solved: the histories of its
    /// particles, and the first touch of every candidate up to the time `end` [s] since the start of the part (interval
    /// of time).
    fn begin(&mut self, island: &mut Island<Recent>, contact_time: Option<f64>, scene: &Scene, end: f64) {
        self.contact_time = contact_time;
        self.met.clear();
        self.met.resize(island.particles.len(), LastCollision::default());
        for recent in &island.carried {
            self.met[recent.index as usize] = LastCollision::at(recent.time);
        }
        self.connect(island);
        self.calendar.clear();
        self.features.clear();
        self.features.resize(island.list.walls.len(), 0);
        let slots = island.list.slots();
        island.pair_checks += slots as u64;
        for slot in 0..slots {
            let touch = touch(slot, island, scene, 0.0, end);
            if touch.is_some() {
                self.predict_events(slot, island, touch);
            }
        }
    }

    /// Moves all members of the island to the end of the part (interval of time), and stores the recent collisions that
    /// the next part needs. `time` [s] is the simulated time at the end of the part, and `end` [s] the length of the
    /// part.
    fn end(&self, island: &mut Island<Recent>, scene: &Scene, (time, end): (f64, f64)) {
        let particles = &mut island.particles;
        for (x, v) in particles.position.iter_mut().zip(&mut particles.velocity).take(island.hot) {
            *x += *v * end + scene.gravity * (0.5 * end * end);
            *v += scene.gravity * end;
        }
        island.carried.clear();
        island.carried.extend(recent(self.met.iter().take(island.hot), self.contact_time, time));
    }

    /// Lists the slots (numbers in the neighbour list) of each particle of the island.
    fn connect(&mut self, island: &Island<Recent>) {
        let (list, particles) = (&island.list, island.particles.len());
        self.first.clear();
        self.first.resize(particles + 1, 0);
        let pairs = list.pairs.iter().flat_map(|pair| [pair.i, pair.j]);
        for particle in pairs.chain(list.walls.iter().map(|near| near.particle)) {
            self.first[particle as usize + 1] += 1;
        }
        for i in 0..particles {
            self.first[i + 1] += self.first[i];
        }
        self.adjacent.clear();
        self.adjacent.resize(self.first[particles] as usize, 0);
        self.next.clone_from(&self.first);
        let mut put = |particle: u32, slot: usize| {
            let next = &mut self.next[particle as usize];
            self.adjacent[*next as usize] = slot as u32;
            *next += 1;
        };
        for (slot, pair) in list.pairs.iter().enumerate() {
            put(pair.i, slot);
            put(pair.j, slot);
        }
        for (k, near) in list.walls.iter().enumerate() {
            put(near.particle, list.pairs.len() + k);
        }
    }

    /// Number of the surface feature (such as a triangle of a mesh) that the particle of the candidate number `slot`
    /// will touch next. It is 0 for a pair of particles.
    fn feature(&self, slot: usize, island: &Island<Recent>) -> u32 {
        let near = slot.checked_sub(island.list.pairs.len());
        near.and_then(|near| self.features.get(near)).copied().unwrap_or_default()
    }

    /// Puts the next touch of the two bodies at `slot` (their number in the neighbour list) into the event queue, in
    /// place of an earlier prediction. `None` for `touch` means that no touch is coming. The time of the touch is in s
    /// since the start of the part (interval of time).
    fn predict_events(&mut self, slot: usize, island: &Island<Recent>, touch: Option<Touch>) {
        if let (Some(near), Some(touch)) = (slot.checked_sub(island.list.pairs.len()), touch) {
            self.features[near] = touch.feature;
        }
        self.calendar.set(slot as u32, touch.map(|touch| touch.time));
    }

    /// Predicts all touches of the particle with the index `i` in the island from the time `now` [s] on, up to `end`
    /// [s]. Both times count from the start of the part (interval of time).
    fn repredict(&mut self, i: usize, island: &mut Island<Recent>, scene: &Scene, now: f64, end: f64) {
        for k in self.first[i]..self.first[i + 1] {
            let slot = self.adjacent[k as usize] as usize;
            let touch = touch(slot, island, scene, now, end);
            island.pair_checks += 1;
            self.predict_events(slot, island, touch);
        }
    }

    /// True if the TC model makes a collision of these bodies at simulated time `time` [s] elastic. It does so if one
    /// of them last collided less than the contact time before.
    fn in_contact(&self, couple: &Couple, time: f64) -> bool {
        let Some(contact_time) = self.contact_time else { return false };
        let last = |index: u32| self.met[index as usize].last;
        couple.indices().into_iter().flatten().any(|index| time - last(index) < contact_time)
    }

    /// Adds a collision at simulated time `time` [s] to the histories of both partners. Returns true if a history shows
    /// an inelastic collapse (infinitely many collisions in finite time). The classical algorithm (all particles at
    /// once) then finds the collapse again, and describes it in an error.
    fn show_collapse(&mut self, collision: &Collision, scene: &Scene, time: f64) -> bool {
        let mut partners = collision.couple.indices().into_iter().flatten();
        partners.any(|i| self.met[i as usize].note(collision, scene, time, self.contact_time).is_some())
    }
}

/// Next touch of the two bodies at `slot` (their number in the neighbour list) between the times `now` and `end`;
/// `None` if they do not touch then. All times are in s since the start of the part (interval of time).
fn touch(slot: usize, island: &Island<Recent>, scene: &Scene, now: f64, end: f64) -> Option<Touch> {
    let couple = island.list.couple(slot);
    let touch = couple.touch(&island.particles, scene, FrameTime::ahead(now), end - now);
    let touch = touch.map(|touch| Touch { time: now + touch.time, ..touch });
    touch.filter(|touch| couple.is_wall() || touch.time < end)
}
