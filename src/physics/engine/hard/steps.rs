//! Hard spheres with time steps, a method of the literature. The paper that docs/paper.md discusses refers to this
//! method. A window is the time between two exchanges with the gas.

use super::impulse::Collision;
use crate::clock::Clock;
use crate::encounter::{FrameTime, relative};
use crate::engine::motion::{accelerate, drift};
use crate::engine::{Counters, Engine, EngineTimes, Failure, Window};
use crate::neighbours::{NeighbourList, Pair, along_walls};
use crate::particles::{CHUNK, Particles};
use crate::record::{Log, Record};
use crate::scene::{Scene, SceneInTime};
use crate::stored::{StoreError, Stored};
use nalgebra::Vector3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Hard spheres with time steps. Particles fly for a step Δt. Then every two bodies (two particles, or a particle and a
/// wall) that overlap and approach each other receive the impulse of hard spheres. Positions are not corrected.
///
/// The step is Δt < θ d/u_r with a chosen number θ, the smallest diameter d and the mean normal speed u_r = sqrt(8
/// q²/(3π)) of one particle relative to another. The criterion is taken from section 3.4 of the paper that
/// docs/paper.md discusses. The formula for u_r is Eq. 8 of that paper, corrected: in the paper, q² is outside the
/// square root. In each time window the step is computed from the agitation q², half the mean square of the velocities
/// of all particles relative to their mean velocity along the walls. The method misses grazing collisions that begin
/// and end within a step, computes collisions up to Δt too late, and leaves overlaps. The program includes it to show
/// these errors. Missed collisions are counted, and impacts record the overlaps.
pub struct SteppedHard {
    theta: f64,
    list: NeighbourList,
    slots: Vec<u32>,
    counters: Counters,
}

impl SteppedHard {
    /// Makes an engine with the given factor θ > 0 [-] in the criterion for the time step, Δt < θ d/u_r.
    pub fn new(theta: f64) -> Self {
        Self { theta, list: NeighbourList::default(), slots: Vec::new(), counters: Counters::default() }
    }

    /// Longest time step θ d/u_r [s], with the step criterion θ = `theta`, that the engine takes in a window (time
    /// between two exchanges with the gas) of `duration` [s]. The step is infinite if no particle moves relative to
    /// other particles or to a wall.
    ///
    /// d is the smallest diameter. The mean relative speed u_r follows from the mean square of the velocities relative
    /// to their mean along the walls. The mean velocity perpendicular to a wall is included, and so is the velocity
    /// that gravity adds until the end of the window. So the step is also finite for a single falling sphere. The
    /// square of the largest speed of a moving wall is added to the mean square of the velocities.
    pub fn longest_step(theta: f64, particles: &Particles, scene: &Scene, duration: f64) -> f64 {
        let particles = &*particles.relative_to_flow(&scene.domain);
        let mean = along_walls(scene, particles.mean_velocity());
        let fall = (scene.gravity - along_walls(scene, scene.gravity)) * duration;
        let square = |frame: Vector3<f64>| particles.mean_square_speed(frame);
        // the mean square is a convex function of time in free fall, so it is largest at the beginning or the end
        let agitation = 0.5 * (square(mean).max(square(mean - fall)) + scene.wall_speed().powi(2));
        let diameter = 2.0 * particles.radius.iter().fold(f64::INFINITY, |a, &r| a.min(r));
        theta * diameter / (8.0 * agitation / (3.0 * PI)).sqrt()
    }

    /// Number of equal steps, each of at most `longest` [s], into which a window (time between two exchanges with the
    /// gas) of `duration` [s] is divided; at least one.
    fn steps(longest: f64, duration: f64) -> f64 {
        (duration / longest - 1e-9).ceil().max(1.0)
    }

    /// [-] factor θ = Δt u_r/d, with the smallest diameter d and the mean relative speed u_r, for the step Δt that the
    /// engine takes. A window (time between two exchanges with the gas) of `duration` [s] is divided into equal steps.
    /// Their number is the smallest for which θ is not larger than `theta`, so θ is usually less than `theta`.
    pub fn theta_of_window(theta: f64, particles: &Particles, scene: &Scene, duration: f64) -> f64 {
        let longest = Self::longest_step(theta, particles, scene, duration);
        theta * duration / (longest * Self::steps(longest, duration))
    }

    /// Number of pairs whose collision the time step has missed. The two particles of such a pair began to touch and
    /// came nearest to each other within the last step of `dt` [s]. At the end of the step they move apart. The pair
    /// receives no impulse, even if the particles still overlap.
    fn missed(&self, particles: &Particles, scene: &Scene, dt: f64) -> u64 {
        let passed = |pair: &&Pair| {
            let (i, j) = (pair.i as usize, pair.j as usize);
            let (apart, velocity) = relative(particles, scene, [i, j], FrameTime::default());
            let reach = pair.reach(particles).powi(2);
            let since = apart.dot(&velocity) / velocity.norm_squared();
            since > 0.0
                && since < dt
                && (apart - velocity * since).norm_squared() < reach
                && (apart - velocity * dt).norm_squared() >= reach
        };
        self.list.pairs.par_chunks(CHUNK).map(|pairs| pairs.iter().filter(passed).count() as u64).sum()
    }

    fn resolve(&mut self, particles: &mut Particles, scene: &Scene, elapsed: f64, remaining: f64, log: &mut Log) {
        self.counters.pair_checks += self.list.slots() as u64;
        self.list.overlapping(particles, scene, &mut self.slots);
        for &slot in &self.slots {
            let couple = self.list.couple(slot as usize);
            let moment = FrameTime::fallen(elapsed);
            let met = couple.meet(particles, scene, moment);
            if met.normal_velocity < 0.0 {
                let wall = couple.wall_motion(&met, (particles, scene), moment);
                let image = couple.image_velocity(particles, scene, &met.velocity);
                let kinds = couple.kinds(particles);
                let collision = Collision { couple, met, elastic: false, kinds, wall, image };
                collision.resolve(particles, scene, remaining, log);
                self.counters.events += 1;
            }
        }
    }
}

impl Engine for SteppedHard {
    fn advance(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        record: &mut Record,
    ) -> Result<(), Failure> {
        let longest = Self::longest_step(self.theta, particles, scene, window.duration);
        if longest.is_nan() {
            return Err(crate::engine::not_a_number(particles, window.start));
        }
        let steps = Self::steps(longest, window.duration);
        let dt = window.duration / steps;
        let fall = (scene.gravity - along_walls(scene, scene.gravity)).norm();
        let walls = scene.wall_speed();
        let mut scenes = SceneInTime::of(scene);
        let mut log = Log::default();
        for step in 0..steps as u64 {
            let elapsed = step as f64 * dt;
            self.list.clock.tell(window.start + elapsed);
            let now = scenes.at(window.start + elapsed);
            let travel = |list: &NeighbourList, p: &Particles| {
                let speed = p.largest_speed_in(list.frame(), &now.domain) + list.strain(p, &now.domain);
                (speed + walls + fall * (elapsed + dt)) * dt
            };
            let mut distance = travel(&self.list, particles);
            if !self.list.allows(distance) {
                if now.domain.shear.is_some() {
                    record.ledger += particles.wrap(&now.domain);
                }
                self.list.build(particles, now, dt);
                distance = travel(&self.list, particles);
            }
            drift(particles, dt, scene.gravity * (dt * (elapsed + 0.5 * dt)));
            self.list.travel(distance);
            let scene = scenes.at(window.start + (elapsed + dt));
            self.counters.missed_collisions += self.missed(particles, scene, dt);
            self.resolve(particles, scene, elapsed + dt, window.duration - (elapsed + dt), &mut log);
        }
        record.absorb(&mut log);
        accelerate(particles, scene.gravity * window.duration);
        self.counters.steps += steps as u64;
        self.counters.neighbour_builds = self.list.builds();
        Ok(())
    }

    fn work_done(&self) -> (Counters, EngineTimes) {
        (self.counters, EngineTimes::default().with_list(&self.list))
    }

    fn use_clock(&mut self, clock: Clock) {
        self.list.clock = clock;
    }

    fn stored(&self) -> Result<Stored, StoreError> {
        Stored::of(&(&self.list, &self.counters))
    }

    fn restore(&mut self, stored: &Stored) -> Result<(), StoreError> {
        let (list, counters): (NeighbourList, Counters) = stored.read()?;
        let clock = std::mem::replace(&mut self.list, list).clock;
        self.list.clock = clock;
        self.counters = counters;
        Ok(())
    }

    fn repopulate(&mut self, _index_of: &[Option<u32>]) -> f64 {
        self.list.invalidate();
        0.0
    }
}
