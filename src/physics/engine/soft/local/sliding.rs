//! Springs with sliders (limits of their forces) in the contacts of an island (group of particles that may meet) of
//! rotating spheres. The springs stick or slide, and the instants at which this changes are found within a step.
//!
//! Each contact has a tangential spring, and also a rolling and a twisting spring if contacts resist these motions. The
//! state of a spring that sticks is its shear ξ: dξ/dt = v + ω_n n × ξ. Here v is the relative velocity that stretches
//! the spring, and ω_n the mean spin about the normal n. The state of a spring that slides is the direction e of its
//! force. The length of ξ then follows from the limit of the force, and e turns towards v. The Runge-Kutta method
//! integrates states in the plane normal to n at the start of the step, and turns them with n.

use super::springs::{ContactMotion, SpringKind, SpringMotion, carried};
use super::{InstantaneousRule, IslandRun, Rates, TRIALS};
use crate::contact_law::friction::{Slip, coulomb};
use crate::encounter::{Encounter, FrameTime};
use crate::engine::soft::contact::{Contact, ContactForce, ContactState, TouchingPair, pull_along};
use crate::record::FrictionLosses;
use nalgebra::Vector3;

/// Phase of the motion of a spring with a slider, such as sticking or sliding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Phase {
    /// The spring has no memory: its force follows from the present motion only.
    Memoryless,
    /// The contact has not yet lasted for one contact time, so it does not resist rolling or twisting.
    Waiting,
    /// The force of spring and dashpot is below the limit.
    Stick,
    /// The force equals its limit, which friction sets.
    Slide,
    /// The normal force would pull the bodies together (because of the dashpot), so the spring has no force.
    Free,
}

/// State of a spring, and the normal of the contact for which the state is valid.
#[derive(Clone, Copy, Debug)]
struct SpringState {
    /// Shear ξ [m] of a spring that sticks, or direction e [-] of the force of one that slides. It is perpendicular to
    /// `normal`, or along `normal` for a twisting spring.
    vector: Vector3<f64>,
    normal: Vector3<f64>,
}

/// State of one spring with a slider (sliding, rolling or twisting) of a contact, during a time step.
#[derive(Clone, Copy, Debug)]
pub struct SlidingContact {
    pub(super) phase: Phase,
    /// State at the start of the time step.
    start: SpringState,
    /// State at the present time of the island.
    now: SpringState,
    /// Rate of change of the state [its unit per s] at the last Runge-Kutta stage, turned to the normal of `start`.
    rate: Vector3<f64>,
    /// Weighted mean of the rates of all stages of the step so far.
    mean: Vector3<f64>,
    /// [m] shear ξ at the present time of the island.
    pub(super) shear: Vector3<f64>,
    /// Distances from two conditions that end the phase (such as sticking), as a force [N] or sliding speed [m/s]. The
    /// first index is `BEFORE` or `AFTER`. The phase ends when a distance becomes negative.
    margins: [[f64; 2]; 2],
}

/// First index in `margins` (distances from the end of a phase): at the start of the step, or at the present time.
const BEFORE: usize = 0;
const AFTER: usize = 1;

/// [-] smallest fraction of a step to which the step is shortened at the end of a phase (such as sticking).
const SHORTEST: f64 = 1e-3;

impl SlidingContact {
    fn in_phase(phase: Phase) -> Self {
        let none = SpringState { vector: Vector3::zeros(), normal: Vector3::zeros() };
        let (rate, mean, shear) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
        let margins = [[f64::INFINITY; 2]; 2];
        Self { phase, start: none, now: none, rate, mean, shear, margins }
    }

    /// Begins a phase. `vector` is the shear [m] if the spring sticks, or the direction [-] of its force if it slides.
    fn take(&mut self, phase: Phase, vector: Vector3<f64>) {
        (self.phase, self.now.vector) = (phase, vector);
    }
}

/// Unit vector along a vector; zero for a zero vector.
fn along(vector: Vector3<f64>) -> Vector3<f64> {
    vector.try_normalize(0.0).unwrap_or_else(Vector3::zeros)
}

impl<I: InstantaneousRule> IslandRun<'_, I> {
    #[inline(always)]
    pub(super) fn rotates(&self) -> bool {
        self.scene.rotation.is_some()
    }

    /// Makes the springs of the contacts that began before this island was made.
    pub(super) fn adopt_springs(&mut self) {
        self.scratch.sliding.clear();
        for k in 0..self.scratch.contacts.len() {
            let Contact { slot, touch, course } = self.scratch.contacts[k];
            let met = self.encounter(slot as usize, &touch.couple, self.moment());
            self.open_springs(&touch, &course, &met);
        }
    }

    /// Appends the springs of the contact `touch`; `met` is the present encounter of its two bodies.
    pub(super) fn open_springs(&mut self, touch: &TouchingPair, course: &ContactState, met: &Encounter) {
        let motion = ContactMotion::of(self, touch, met, true);
        for &kind in self.kinds() {
            let memory = course.resistance.unwrap_or_default();
            let (shear, waits) = match kind {
                SpringKind::Slide => (course.shear, false),
                SpringKind::Roll => (memory.roll, self.window.start + self.now < memory.acts_from),
                SpringKind::Twist => (met.normal * memory.twist, self.window.start + self.now < memory.acts_from),
            };
            let spring = motion.spring(kind, touch, met);
            let sliding =
                if waits { SlidingContact::in_phase(Phase::Waiting) } else { self.begin(&spring, touch, met, shear) };
            self.scratch.sliding.push(sliding);
        }
    }

    /// Makes a spring that has the given shear [m] at the present time.
    fn begin(
        &self,
        spring: &SpringMotion,
        touch: &TouchingPair,
        met: &Encounter,
        shear: Vector3<f64>,
    ) -> SlidingContact {
        let mut sliding = SlidingContact::in_phase(Phase::Memoryless);
        if !spring.remembers() {
            return sliding;
        }
        let flat = spring.kind.in_space_of(&shear, &met.normal);
        sliding.now = SpringState { vector: flat, normal: met.normal };
        sliding.shear = flat;
        let force = spring.constants.force(&flat, &spring.velocity);
        let (square, limit) = (force.norm_squared(), spring.limit);
        let begins = limit == 0.0 && spring.at_touch && met.normal_velocity < 0.0;
        let slides = if begins && square == 0.0 {
            // at touch without damping, the force of the spring and the limit of this force both grow from zero
            spring.slides_from_touch(&self.engine.law, touch, met, self.engine.step)
        } else {
            square >= limit * limit * (1.0 - 1e-12)
        };
        let direction = if square > 0.0 { force } else { spring.velocity };
        match (slides, limit == 0.0 && !begins) {
            (_, true) => sliding.take(Phase::Free, Vector3::zeros()),
            (true, _) => sliding.take(Phase::Slide, along(direction)),
            (false, _) => sliding.take(Phase::Stick, flat),
        }
        sliding.start = sliding.now;
        sliding.margins[AFTER] = [0.0; 2];
        sliding
    }

    /// Begins the rolling and twisting resistance of contacts that have lasted for one contact time.
    fn wake_resistances(&mut self) {
        for k in 0..self.scratch.contacts.len() {
            let memory = self.scratch.contacts[k].course.resistance.unwrap_or_default();
            if self.window.start + self.now < memory.acts_from {
                continue;
            }
            for (index, &kind) in self.springs_of(k).zip(self.kinds()) {
                if self.scratch.sliding[index].phase == Phase::Waiting {
                    let (touch, met) = self.met(k);
                    let spring = ContactMotion::of(self, &touch, &met, true).spring(kind, &touch, &met);
                    self.scratch.sliding[index] = self.begin(&spring, &touch, &met, Vector3::zeros());
                }
            }
        }
    }

    /// Begins the rolling and twisting resistances that are due, and stores spins and springs at the start of a step.
    pub(super) fn keep_springs(&mut self) {
        if self.kinds().len() > 1 {
            self.wake_resistances();
        }
        let scratch = &mut *self.scratch;
        if let Some(spins) = &self.particles.spin {
            scratch.spin.clone_from(spins);
        }
        for sliding in &mut scratch.sliding {
            sliding.start = sliding.now;
            sliding.margins[BEFORE] = sliding.margins[AFTER];
        }
    }

    /// Sets the spins of all particles back to those at the start of the step.
    pub(super) fn restore_spins(&mut self) {
        if let Some(spins) = &mut self.particles.spin {
            spins.clone_from(&self.scratch.spin);
        }
    }

    /// Begins a trial step of `count` particles: sets rates and means to 0, and springs to their state before the step.
    pub(super) fn begin_turning(&mut self, count: usize) {
        let scratch = &mut *self.scratch;
        scratch.losses = FrictionLosses::default();
        scratch.turning.clear();
        scratch.turning.resize(count, Vector3::zeros());
        scratch.turned.clear();
        scratch.turned.resize(count, Vector3::zeros());
        for sliding in &mut scratch.sliding {
            (sliding.rate, sliding.mean) = (Vector3::zeros(), Vector3::zeros());
            sliding.now = sliding.start;
        }
    }

    /// Moves spins and springs from the start of the step to a stage `dt` [s] after it, at the rates of the previous
    /// stage.
    pub(super) fn turn_to_stage(&mut self, dt: f64) {
        let scratch = &mut *self.scratch;
        if let Some(spins) = &mut self.particles.spin {
            let at_start = scratch.spin.iter().zip(&scratch.turning);
            spins.iter_mut().zip(at_start).for_each(|(spin, (start, rate))| *spin = start + rate * dt);
        }
        for sliding in &mut scratch.sliding {
            sliding.now.vector = sliding.start.vector + sliding.rate * dt;
        }
    }

    /// Adds the rates of a stage, times its `weight` [-], to the means over the step.
    pub(super) fn add_turning(&mut self, weight: f64) {
        let scratch = &mut *self.scratch;
        scratch.turned.iter_mut().zip(&scratch.turning).for_each(|(mean, rate)| *mean += rate * weight);
        for sliding in &mut scratch.sliding {
            sliding.mean += sliding.rate * weight;
        }
    }

    /// Moves spins and springs by `dt` [s] at their mean rates, after the step has moved positions and velocities.
    pub(super) fn end_turning(&mut self, dt: f64) {
        let scratch = &mut *self.scratch;
        if let Some(spins) = &mut self.particles.spin {
            let at_start = scratch.spin.iter().zip(&scratch.turned);
            spins.iter_mut().zip(at_start).for_each(|(spin, (start, mean))| *spin = start + mean * dt);
        }
        for k in 0..self.scratch.contacts.len() {
            let (touch, met) = self.met(k);
            let motion = ContactMotion::of(self, &touch, &met, self.resists(k));
            for (index, &kind) in self.springs_of(k).zip(self.kinds()) {
                let spring = motion.spring(kind, &touch, &met);
                let sliding = &mut self.scratch.sliding[index];
                let moved = sliding.start.vector + sliding.mean * dt;
                let vector = carried(kind, &moved, &sliding.start.normal, &met.normal);
                sliding.now = SpringState { vector, normal: met.normal };
                sliding.shear = match sliding.phase {
                    Phase::Stick => vector,
                    Phase::Slide => {
                        sliding.now.vector = vector.try_normalize(0.0).unwrap_or(vector);
                        let along = spring.velocity.dot(&sliding.now.vector);
                        sliding.now.vector * spring.constants.sliding_length(spring.limit, along)
                    }
                    Phase::Free | Phase::Memoryless | Phase::Waiting => Vector3::zeros(),
                };
                self.scratch.sliding[index].margins[AFTER] = self.margins(index, &touch, &met, (&motion, &spring), dt);
            }
        }
    }

    /// Force of contact `k` at a stage of a step of `dt` [s], at the time `moment`. The stage has the weight `weight`
    /// [-] in the step. Adds the torques to the angular accelerations, and stores the rates of the springs.
    pub(super) fn force_at_stage(
        &mut self,
        k: usize,
        touch: &TouchingPair,
        met: &Encounter,
        (moment, dt, weight): (FrameTime, f64, f64),
    ) -> ContactForce {
        let springs = self.springs_of(k);
        let motion = ContactMotion::of(self, touch, met, self.resists(k));
        let normal = motion.elastic + motion.viscous;
        let slides = motion.spring(SpringKind::Slide, touch, met);
        let tangential = self.spring_force(springs.start, (touch, met, moment), (&motion, &slides), dt);
        let mut friction_power = tangential.dot(&slides.velocity);
        let mut losses = self.tangential_losses(springs.start, &slides, &tangential);
        let mut couple = Vector3::zeros();
        if motion.rolling.is_some() {
            for (index, kind) in springs.skip(1).zip([SpringKind::Roll, SpringKind::Twist]) {
                let spring = motion.spring(kind, touch, met);
                let force = self.spring_force(index, (touch, met, moment), (&motion, &spring), dt);
                let power = force.dot(&spring.velocity);
                friction_power += power;
                let rolls = kind == SpringKind::Roll;
                *(if rolls { &mut losses.rolling } else { &mut losses.twisting }) = power;
                let turns = if rolls { met.normal.cross(&force) } else { force };
                couple -= turns * motion.rolling_radius();
            }
        }
        self.scratch.losses += losses * weight;
        let torque = met.normal.cross(&tangential) * motion.arm;
        if let Some(inertia) = &self.particles.inertia {
            for index in touch.couple.indices().into_iter().flatten().map(|index| index as usize) {
                self.scratch.turning[index] += torque * (self.particles.radius[index] / inertia[index]);
            }
            if motion.rolling.is_some() {
                self.scratch.turning[touch.couple.i as usize] += couple / inertia[touch.couple.i as usize];
                if let Some(j) = touch.couple.j() {
                    self.scratch.turning[j as usize] -= couple / inertia[j as usize];
                }
            }
        }
        let on_i = met.normal * normal - tangential;
        ContactForce {
            on_i,
            normal,
            restitution_power: -motion.viscous * met.normal_velocity,
            friction_power,
            wall_power: touch
                .couple
                .wall_motion(met, (self.particles, self.scene), moment)
                .map_or(0.0, |wall| wall.power(&on_i, Some(&couple))),
            shear_power: on_i.z * touch.couple.image_velocity(self.particles, self.scene, &met.velocity),
            arm: met.normal * (touch.reach + met.gap),
        }
    }

    /// [N] force of a spring at a stage of a step of `dt` [s]. Also stores the rate of change of the spring.
    #[inline(always)]
    fn spring_force(
        &mut self,
        index: usize,
        (touch, met, moment): (&TouchingPair, &Encounter, FrameTime),
        (motion, spring): (&ContactMotion, &SpringMotion),
        dt: f64,
    ) -> Vector3<f64> {
        let SpringMotion { kind, velocity, constants, rates, limit, .. } = *spring;
        let normal = motion.elastic + motion.viscous;
        let sliding = &mut self.scratch.sliding[index];
        let SpringState { normal: start, .. } = sliding.start;
        let vector = carried(kind, &sliding.now.vector, &start, &met.normal);
        let spun = |vector: &Vector3<f64>| {
            met.normal.cross(vector) * touch.couple.twist(self.particles, self.scene, &met.normal)
        };
        let (force, rate) = match sliding.phase {
            Phase::Waiting | Phase::Free => (Vector3::zeros(), Vector3::zeros()),
            Phase::Memoryless => {
                let force = match &spring.resistance {
                    Some(resistance) => resistance.without_memory(&velocity, normal, dt),
                    None if kind == SpringKind::Slide => {
                        let acceleration = pull_along(&touch.couple, met, (self.particles, self.scene), moment);
                        let slip = Slip { velocity, acceleration };
                        let friction = coulomb(touch.friction, normal, &slip, constants.mass, [dt, 0.0]);
                        friction.map_or_else(Vector3::zeros, |friction| friction.force)
                    }
                    None => Vector3::zeros(),
                };
                (force, Vector3::zeros())
            }
            Phase::Stick => {
                let rate = velocity * spring.grown - vector * rates.forgotten;
                (constants.force(&vector, &velocity), rate + spun(&vector))
            }
            Phase::Slide => {
                let along = velocity.dot(&vector);
                let across = velocity - vector * along;
                // a spring shorter than the path of a step would turn too fast for the step; its rate of turning is
                // limited
                let length = constants.sliding_length(limit, along).max(velocity.norm() * dt);
                let turning = if length > 0.0 { across / length } else { across };
                (vector * limit, turning + spun(&vector))
            }
        };
        sliding.rate = carried(kind, &rate, &met.normal, &start);
        force
    }

    /// Distances (`SlidingContact::margins`) of a spring from the end of its phase (such as sticking), after a trial
    /// step of `dt` [s]. Accelerations are those of the last stage, which is at the end of the step.
    fn margins(
        &self,
        index: usize,
        touch: &TouchingPair,
        met: &Encounter,
        (motion, spring): (&ContactMotion, &SpringMotion),
        dt: f64,
    ) -> [f64; 2] {
        let sliding = &self.scratch.sliding[index];
        let normal = motion.elastic + motion.viscous;
        match sliding.phase {
            Phase::Memoryless | Phase::Waiting => [f64::INFINITY; 2],
            Phase::Stick => {
                let force = spring.constants.force(&sliding.now.vector, &spring.velocity).norm();
                [spring.limit - force, f64::INFINITY]
            }
            Phase::Slide => [self.sliding_rate(touch, met, (motion, spring), (sliding, dt)), normal],
            Phase::Free => [-normal, f64::INFINITY],
        }
    }

    /// [m/s] speed λ = v·e - d|ξ|/dt at which the surfaces of a contact slide: v is their relative velocity, e the
    /// direction of the spring's force, and ξ the shear of the spring. If λ becomes negative, the contact sticks.
    fn sliding_rate(
        &self,
        touch: &TouchingPair,
        met: &Encounter,
        (motion, spring): (&ContactMotion, &SpringMotion),
        (sliding, dt): (&SlidingContact, f64),
    ) -> f64 {
        let (along, constants) = (sliding.now.vector, &spring.constants);
        let speed = spring.velocity.dot(&along);
        let length = constants.sliding_length(spring.limit, speed);
        if length == 0.0 {
            return speed.abs();
        }
        let acceleration = |index: u32| self.scratch.acceleration[index as usize];
        let angular = |index: u32| self.scratch.turning[index as usize];
        let surface = |index: u32| angular(index) * self.particles.radius[index as usize];
        let (i, j) = (touch.couple.i, touch.couple.j());
        let (relative, surface, relative_angular) = match j {
            Some(j) => {
                let surface = (surface(i) + surface(j)) * motion.arm;
                (acceleration(i) - acceleration(j), surface, angular(i) - angular(j))
            }
            None => (acceleration(i) + self.fall_onto(&touch.couple, met), surface(i), angular(i)),
        };
        let velocity_rate = match spring.kind {
            SpringKind::Slide => (relative - surface.cross(&met.normal)).dot(&along),
            SpringKind::Roll => relative_angular.cross(&met.normal).dot(&along) * motion.rolling_radius(),
            SpringKind::Twist => relative_angular.dot(&along) * motion.rolling_radius(),
        };
        // the normal turns: that of a pair at a known rate, that of a curved wall at its mean rate in the step
        let turned = met.velocity.dot(&(met.normal - sliding.start.normal)) / dt;
        let turns = if j.is_some() { met.slip().norm_squared() / (touch.reach + met.gap) } else { turned };
        let normal_acceleration = relative.dot(&met.normal) + turns;
        let rate = spring.limit_rate(&self.engine.law, touch, met, (normal_acceleration, dt));
        let of_dashpot = constants.dashpot * (velocity_rate + spring.rates.dashpot * speed);
        speed + spring.rates.force * length - (rate - of_dashpot) / constants.stiffness
    }

    /// First end of a spring's phase within a step: estimated fraction [-] of the step, index of the spring, and index
    /// of the margin (distance from the end of the phase) that becomes negative; `None` if no phase ends.
    pub(super) fn first_switch(&self) -> Option<(f64, usize, usize)> {
        let ends = self.scratch.sliding.iter().enumerate().flat_map(|(k, sliding)| {
            let [before, after] = sliding.margins;
            (0..2).filter(move |&which| after[which] < 0.0).map(move |which| {
                let fraction = if before[which] > 0.0 && before[which].is_finite() {
                    before[which] / (before[which] - after[which])
                } else {
                    0.5
                };
                (fraction, k, which)
            })
        });
        ends.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Repeats the step from `start` [s] with the length at which a phase (such as sticking) of the spring `k` ends.
    /// The first guess is `fraction` [-] of `dt` [s]; `which` is the index of the margin.
    pub(super) fn find_switch(&mut self, start: f64, dt: f64, (fraction, k, which): (f64, usize, usize)) -> Rates {
        let before = self.scratch.sliding[k].margins[BEFORE][which];
        let mut low = (0.0, before.max(0.0));
        let mut high = (1.0, self.scratch.sliding[k].margins[AFTER][which]);
        let scale = 1e-9 * before.abs().max(high.1.abs());
        let mut fraction = fraction.max(SHORTEST);
        let mut rates = Rates::default();
        for trial in 0..2 * TRIALS {
            rates = self.repeat(start, fraction * dt);
            let margin = self.scratch.sliding[k].margins[AFTER][which];
            if margin.abs() <= scale || fraction <= SHORTEST {
                break;
            }
            if margin < 0.0 {
                high = (fraction, margin)
            } else {
                low = (fraction, margin)
            }
            let linear = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
            let middle = 0.5 * (low.0 + high.0);
            fraction = if trial % 3 == 2 || low.1 == 0.0 { middle } else { linear };
            fraction = fraction.max(SHORTEST);
        }
        rates
    }

    /// Ends the phase (such as sticking) of each spring with a negative margin (distance from the end of the phase).
    /// Also ends that of the spring `due`, given by the indices of the spring and of its margin.
    pub(super) fn switch_phases(&mut self, due: Option<(usize, usize)>) {
        for k in 0..self.scratch.contacts.len() {
            for (index, &kind) in self.springs_of(k).zip(self.kinds()) {
                let sliding = self.scratch.sliding[index];
                let over = || (0..2).rev().find(|&which| sliding.margins[AFTER][which] < 0.0);
                let due = due.filter(|(of, _)| *of == index).map(|(_, which)| which);
                let Some(which) = due.or_else(over) else { continue };
                let (touch, met) = self.met(k);
                let spring = ContactMotion::of(self, &touch, &met, true).spring(kind, &touch, &met);
                let (phase, vector) = match sliding.phase {
                    Phase::Memoryless | Phase::Waiting => continue,
                    Phase::Stick => {
                        (Phase::Slide, along(spring.constants.force(&sliding.now.vector, &spring.velocity)))
                    }
                    Phase::Slide if which == 1 => (Phase::Free, Vector3::zeros()),
                    Phase::Slide => (Phase::Stick, sliding.shear),
                    Phase::Free => (Phase::Slide, along(spring.velocity)),
                };
                self.scratch.sliding[index].take(phase, vector);
                self.scratch.sliding[index].margins[AFTER] = [0.0; 2];
            }
        }
    }
}
