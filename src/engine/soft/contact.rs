//! One contact: its two bodies, their encounter, the contact force, and the energy that the contact takes.

use crate::contact_law::friction::{Slip, coulomb};
use crate::contact_law::{Bodies, ContactLaw, Spring};
use crate::encounter::{Couple, Encounter, FrameTime, Other, Partner};
use crate::engine::Failure;
use crate::particles::Particles;
use crate::record::{Impact, Log};
use crate::rotation::{Rotation, SpringDashpotSlider};
use crate::scene::{Kind, Scene};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// [-] largest overlap over the (smaller) diameter at which "the normal" still has a meaning.
///
/// At a plane (`flat`) the limit is passed when the sphere is wholly behind the plane. Otherwise it is passed when the
/// centres of a pair are nearer than half their distance at touch, or when a centre is within a body.
pub fn overlap_limit(flat: bool) -> f64 {
    if flat { 1.0 } else { 0.5 }
}

/// [-] share of the radius below which a step is short: it cannot pass a surface without too large an overlap at one
/// end.
pub const SHORT: f64 = 0.4;

/// Failure of the particle at index `i`, whose centre passes wall `wall` within one step, reported for `time` [s]. The
/// step is a straight line of `length` [m]. On the surface the overlap of the particle is its radius.
pub fn passed(particles: &Particles, i: usize, (wall, time): (u32, f64), length: f64) -> Failure {
    let (limit, diameter) = (overlap_limit(false), 2.0 * particles.radius[i]);
    let way = Some(length / diameter);
    Failure::OverlapTooLarge { time, particle: particles.id[i], partner: Partner::Wall(wall), ratio: 0.5, limit, way }
}

/// Failure of a sphere with too large an overlap; `ratio` and `limit` are overlaps over the diameter.
#[cold]
fn refused(couple: Couple, particles: &Particles, time: f64, (ratio, limit): (f64, f64)) -> Failure {
    let (particle, partner) = (particles.id[couple.i as usize], couple.partner(particles));
    Failure::OverlapTooLarge { time, particle, partner, ratio, limit, way: None }
}

/// Constants of a contact between two bodies, whichever particles these are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactConstants {
    /// Constants of the normal law.
    pub spring: Spring,
    /// [m] smaller diameter.
    pub diameter: f64,
    /// [-] friction coefficient μ.
    pub friction: f64,
    /// [m] distance of the centres at touch; at a wall the radius.
    pub reach: f64,
    /// Constants of the tangential law, if spheres rotate.
    pub tangential: SpringDashpotSlider,
}

/// Two bodies that touch, and the constants of their contact.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct TouchingPair {
    /// The two bodies that touch.
    pub couple: Couple,
    /// Constants of their contact.
    pub constants: ContactConstants,
}

impl std::ops::Deref for TouchingPair {
    type Target = ContactConstants;

    fn deref(&self) -> &ContactConstants {
        &self.constants
    }
}

/// A contact that has begun and not ended.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Contact {
    /// Slot of the neighbour list.
    pub slot: u32,
    /// The two bodies that touch, and the constants of their contact.
    pub touch: TouchingPair,
    /// State of the contact so far.
    pub course: ContactState,
}

/// State of a contact: the present overlap and the record so far.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct ContactState {
    /// [m/s] speed of approach at the beginning.
    pub normal_speed: f64,
    /// [m] overlap when first seen.
    pub first_overlap: f64,
    /// [m] largest overlap so far.
    pub maximum_overlap: f64,
    /// [m] present overlap.
    pub overlap: f64,
    /// [m/s] present growth rate of the overlap.
    pub growth: f64,
    /// [m s] overlap integrated over time so far.
    pub overlap_time: f64,
    /// [s] simulated time when first seen.
    pub began: f64,
    /// Normal at the last evaluation, which only tells sides; `None` before the first.
    pub normal: Option<Vector3<f32>>,
    /// [m] shear ξ of the tangential spring: by how much particle i has been displaced along the other surface; 0
    /// without memory.
    pub shear: Vector3<f64>,
    /// Memory of rolling and twisting, where contacts resist these.
    pub resistance: Option<ResistanceMemory>,
    /// [m/s] slip of particle i against the other body at first touch, where spheres rotate.
    pub first_slip: Option<Vector3<f32>>,
}

/// Memory of a contact that resists rolling and twisting. It does not depend on the order of the two bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResistanceMemory {
    /// [m] shear of the rolling spring.
    pub roll: Vector3<f64>,
    /// [m] shear of the twisting spring along the normal.
    pub twist: f64,
    /// [J] energies of the rolling and the twisting spring.
    pub energies: [f64; 2],
    /// [s] simulated time from which the contact resists: one contact time after it began.
    pub acts_from: f64,
}

impl Contact {
    /// A contact that begins at the instant of touch, at simulated time `began` [s]; without a speed so far.
    pub fn new(slot: u32, touch: TouchingPair, began: f64) -> Self {
        Self { slot, touch, course: ContactState::new(began) }
    }
}

impl ContactState {
    /// State of a contact that begins at simulated time `began` [s]; without a speed so far.
    pub fn new(began: f64) -> Self {
        Self {
            normal_speed: 0.0,
            first_overlap: 0.0,
            maximum_overlap: 0.0,
            overlap: 0.0,
            growth: 0.0,
            overlap_time: 0.0,
            began,
            normal: None,
            shear: Vector3::zeros(),
            resistance: None,
            first_slip: None,
        }
    }

    /// State of a contact that begins at simulated time `began` [s] with a speed of approach [m/s]. A contact that has
    /// not approached, because it was there from the start, resists rolling at once.
    pub fn beginning(
        began: f64,
        normal_speed: f64,
        constants: &ContactConstants,
        scene: &Scene,
        law: &ContactLaw,
    ) -> Self {
        let resists = scene.rotation.as_ref().is_some_and(Rotation::resists);
        let resistance = resists.then(|| {
            let impact = if normal_speed > 0.0 { law.contact_time(&constants.spring, normal_speed) } else { 0.0 };
            ResistanceMemory { acts_from: began + impact, ..ResistanceMemory::default() }
        });
        Self { normal_speed, resistance, ..Self::new(began) }
    }

    /// The state of this contact with its two bodies named in the other order.
    pub fn reversed(self) -> Self {
        Self {
            normal: self.normal.map(|normal| -normal),
            shear: -self.shear,
            first_slip: self.first_slip.map(|slip| -slip),
            ..self
        }
    }

    /// Refuses overlaps at which "the normal" no longer has a meaning.
    ///
    /// These are: centres of a pair nearer than half their distance at touch, a centre within a solid body or already
    /// beyond its middle, or a sphere wholly behind a plane. The last evaluation was one step of `dt` [s] ago; `time`
    /// [s] is now.
    #[inline(always)]
    pub fn check(
        &self,
        couple: &Couple,
        constants: &ContactConstants,
        met: &Encounter,
        (particles, scene): (&Particles, &Scene),
        (time, dt): (f64, f64),
    ) -> Result<(), Failure> {
        let ContactConstants { diameter, .. } = *constants;
        let limit = overlap_limit(couple.is_flat(scene));
        let ratio = met.overlap() / diameter;
        let turned = self.normal.is_some_and(|normal| normal.cast().dot(&met.normal) < 0.0);
        if ratio <= limit && !turned {
            return Ok(());
        }
        if ratio <= limit {
            return self.refuse_to_pass(couple, constants, met, (particles, scene), (time, dt));
        }
        Err(refused(*couple, particles, time, (ratio, limit)))
    }

    /// Refuses a normal that has turned round because the centre passed the other body.
    ///
    /// The normal of a sphere that a wall holds from two sides also turns, when the other side becomes the nearer one.
    /// But then the centre has not come to the surface. On a way through the surface it would have moved at least as
    /// far as both distances together, since the distance from a surface changes no faster than the centre moves.
    #[cold]
    fn refuse_to_pass(
        &self,
        couple: &Couple,
        constants: &ContactConstants,
        met: &Encounter,
        (particles, scene): (&Particles, &Scene),
        (time, dt): (f64, f64),
    ) -> Result<(), Failure> {
        /// [-] bound on the speed during a step over the speed at its end. In a contact of some twenty steps the ratio
        /// is smaller.
        const FASTER: f64 = 2.0;
        let ContactConstants { diameter, reach, .. } = *constants;
        let (i, limit) = (couple.i as usize, overlap_limit(false));
        let Other::Wall(at) = couple.other else {
            // between the two evaluations the centres of a pair have passed each other
            return Err(refused(*couple, particles, time, (met.overlap().max(self.overlap) / diameter, limit)));
        };
        let way = (met.velocity + scene.walls[at.wall as usize].surface_velocity(&particles.position[i])).norm() * dt;
        let distances = (reach - self.overlap) + (reach - met.overlap());
        if distances > FASTER * way {
            return Ok(());
        }
        Err(passed(particles, i, (at.wall, time), way))
    }

    /// Records the present encounter of the two bodies.
    pub fn note(&mut self, met: &Encounter) {
        self.normal = Some(met.normal.cast());
        self.overlap = met.overlap();
        self.growth = -met.normal_velocity;
        self.maximum_overlap = self.maximum_overlap.max(self.overlap);
    }

    /// Impact of the contact, which has ended with `rebound_speed` [m/s] at time `now` [s]; `diameter` [m] is the
    /// smaller one.
    pub fn impact(&self, diameter: f64, rebound_speed: f64, now: f64) -> Impact {
        Impact {
            normal_speed: self.normal_speed,
            rebound_speed,
            duration: now - self.began,
            first_overlap: self.first_overlap / diameter,
            maximum_overlap: self.maximum_overlap / diameter,
            overlap_time: self.overlap_time / diameter,
            left_out: None,
            slip: None,
        }
    }
}

/// Present force of a contact, and its powers.
#[derive(Clone, Copy, Debug)]
pub struct ContactForce {
    /// [N] force on particle i; the other body gets the opposite force.
    pub on_i: Vector3<f64>,
    /// [N] component of the force along the normal.
    pub normal: f64,
    /// [W] taken out by the dashpot, in the middle of the kick.
    pub restitution_power: f64,
    /// [W] taken out by friction, in the middle of the kick.
    pub friction_power: f64,
    /// [W] put in by a wall whose surface moves.
    pub wall_power: f64,
    /// [m] vector from the other centre (or the wall) to that of particle i.
    pub arm: Vector3<f64>,
}

impl ContactForce {
    /// No force, but a power [W] that friction takes.
    pub fn lost(friction_power: f64) -> Self {
        let none = Vector3::zeros();
        Self { on_i: none, normal: 0.0, restitution_power: 0.0, friction_power, wall_power: 0.0, arm: none }
    }
}

/// Powers [W], forces from walls on the particles [N], and the virial of pairs [N m].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Rates {
    pub pair_restitution: f64,
    pub pair_friction: f64,
    pub wall_restitution: f64,
    pub wall_friction: f64,
    pub wall_work: f64,
    pub wall_force: Vector3<f64>,
    /// [N] first moment of `wall_force` about the middle of the step, over the step's length squared.
    pub wall_force_moment: Vector3<f64>,
    pub wall_normal_force: f64,
    pub pair_virial: Matrix3<f64>,
}

/// Constants of any two particles where all particles are alike. Without them each first touch and each push would wait
/// for memory, because the data of two particles stand far apart there.
#[derive(Clone, Copy, Debug)]
pub struct Alike {
    constants: ContactConstants,
    species: u16,
    /// [kg] mass of each particle.
    pub mass: f64,
}

impl Alike {
    /// Constants of these particles, if there are at least two and all are alike.
    pub fn of(particles: &Particles, scene: &Scene, law: &ContactLaw) -> Option<Self> {
        let all = |one: &[f64]| one.iter().all(|other| *other == one[0]);
        let species = *particles.species.first()?;
        let one_species = particles.species.iter().all(|other| *other == species);
        let alike = particles.len() > 1 && one_species && all(&particles.radius) && all(&particles.mass);
        let alike = alike && particles.inertia.as_ref().is_none_or(|inertia| all(inertia));
        alike.then(|| {
            let constants = ContactConstants::new(&Couple::pair(0, 1), particles, scene, law);
            Self { constants, species, mass: particles.mass[0] }
        })
    }

    /// Constants of the contact between the two particles of `couple`.
    pub fn touching(&self, couple: Couple) -> TouchingPair {
        TouchingPair { couple, constants: self.constants }
    }

    /// Species of one particle and kind of the other: all particles are of one species.
    pub fn kinds(&self) -> (u16, Kind) {
        (self.species, Kind::Species(self.species))
    }
}

impl TouchingPair {
    /// Two bodies with their constants under a contact law.
    pub fn new(couple: Couple, particles: &Particles, scene: &Scene, law: &ContactLaw) -> Self {
        Self { couple, constants: ContactConstants::new(&couple, particles, scene, law) }
    }

    /// [`ContactConstants::begin_at`] of these two bodies.
    #[inline]
    pub fn begin_at(&mut self, speed: f64, scenery: (&Particles, &Scene), law: &ContactLaw) {
        self.constants.begin_at(speed, &self.couple, scenery, law);
    }

    /// [`ContactConstants::force`] of these two bodies.
    #[inline(always)]
    pub fn force(
        &self,
        law: &ContactLaw,
        met: &Encounter,
        scenery: (&Particles, &Scene),
        moment: FrameTime,
        times: [f64; 2],
    ) -> ContactForce {
        self.constants.force(&self.couple, law, met, scenery, moment, times)
    }
}

impl ContactConstants {
    /// Constants of two bodies under a contact law.
    pub fn new(couple: &Couple, particles: &Particles, scene: &Scene, law: &ContactLaw) -> Self {
        Self::of(&couple.bodies(particles, scene), couple, (particles, scene), law)
    }

    /// Sets the constants to those of a contact that begins at the normal speed `speed` [m/s] of approach, if its
    /// restitution depends on the speed: its dashpot lasts as long as the contact. Other constants stay.
    #[inline]
    pub fn begin_at(&mut self, speed: f64, couple: &Couple, scenery: (&Particles, &Scene), law: &ContactLaw) {
        let (particles, scene) = scenery;
        if couple.surface(particles, scene).by_speed.is_some() {
            *self = Self::of(&couple.bodies(particles, scene).at_speed(speed), couple, scenery, law);
        }
    }

    fn of(bodies: &Bodies, couple: &Couple, (particles, scene): (&Particles, &Scene), law: &ContactLaw) -> Self {
        let spring = law.between(bodies);
        let friction = couple.surface(particles, scene).friction;
        let diameter = couple.diameter(particles);
        let tangential = scene.rotation.as_ref().map_or_else(SpringDashpotSlider::default, |rotation| {
            rotation.tangential.between(|| law.normal_spring(bodies, &spring), couple.tangential_mass(particles))
        });
        Self { spring, diameter, friction, reach: couple.reach(particles), tangential }
    }

    /// [m/s²] relative acceleration of the two bodies along their surfaces by gravity, which walls do not feel.
    #[inline(always)]
    pub(super) fn pull_along(couple: &Couple, met: &Encounter, scene: &Scene) -> Vector3<f64> {
        if couple.is_wall() { scene.gravity - met.normal * scene.gravity.dot(&met.normal) } else { Vector3::zeros() }
    }

    /// Force of the contact of two bodies, which meet at a `moment`. Friction acts for a time step [s], the first of the times. Powers are taken
    /// the second of them [s], `to_middle`, after the time of these velocities.
    #[inline(always)]
    pub fn force(
        &self,
        couple: &Couple,
        law: &ContactLaw,
        met: &Encounter,
        (particles, scene): (&Particles, &Scene),
        moment: FrameTime,
        [time_step, to_middle]: [f64; 2],
    ) -> ContactForce {
        let m = self.spring.effective_mass;
        let (elastic, viscous) = law.force(&self.spring, met.overlap(), met.normal_velocity);
        let normal = elastic + viscous;
        let mut on_i = met.normal * normal;
        let mut friction_power = 0.0;
        if self.friction > 0.0 {
            let slip = Slip { velocity: met.slip(), acceleration: Self::pull_along(couple, met, scene) };
            if let Some(friction) = coulomb(self.friction, normal, &slip, m, [time_step, to_middle]) {
                on_i -= friction.force;
                friction_power = friction.power;
            }
        }
        let restitution_power = -viscous * (met.normal_velocity + to_middle * normal / m);
        let wall = couple.wall_motion(met, (particles, scene), moment);
        let wall_power = wall.map_or(0.0, |wall| wall.power(&on_i, None));
        let arm = met.normal * (self.reach + met.gap);
        ContactForce { on_i, normal, restitution_power, friction_power, wall_power, arm }
    }
}

impl std::ops::AddAssign for Rates {
    fn add_assign(&mut self, other: Self) {
        self.pair_restitution += other.pair_restitution;
        self.pair_friction += other.pair_friction;
        self.wall_restitution += other.wall_restitution;
        self.wall_friction += other.wall_friction;
        self.wall_work += other.wall_work;
        self.wall_force += other.wall_force;
        self.wall_force_moment += other.wall_force_moment;
        self.wall_normal_force += other.wall_normal_force;
        self.pair_virial += other.pair_virial;
    }
}

/// Sums over a step of a contact without friction, whose normal is taken as fixed.
#[derive(Clone, Copy, Debug, Default)]
pub struct AlongNormal {
    /// [W] taken out by the dashpot.
    pub restitution_power: f64,
    /// [N] force along the normal.
    pub force: f64,
    /// [N] first moment of the force about the middle of the step, over the step's length squared.
    pub force_moment: f64,
    /// [N m] normal force times distance of the centres, for the virial of pairs.
    pub virial: f64,
}

impl Rates {
    /// Rates of a contact without friction; `normal` points from the other body to particle i.
    pub fn along(couple: &Couple, normal: &Vector3<f64>, sums: &AlongNormal) -> Self {
        if couple.is_wall() {
            let (power, force) = (sums.restitution_power, sums.force);
            let wall_force = normal * force;
            let wall_force_moment = normal * sums.force_moment;
            Self { wall_restitution: power, wall_force, wall_force_moment, wall_normal_force: force, ..Self::default() }
        } else {
            let pair_virial = normal * normal.transpose() * sums.virial;
            Self { pair_restitution: sums.restitution_power, pair_virial, ..Self::default() }
        }
    }

    /// Adds the rates of a contact with the weights [-] of a stage in means over the step and in first moments.
    #[inline]
    pub fn count(&mut self, couple: &Couple, force: &ContactForce, [weight, moment]: [f64; 2]) {
        if couple.is_wall() {
            self.wall_restitution += weight * force.restitution_power;
            self.wall_friction += weight * force.friction_power;
            self.wall_work += weight * force.wall_power;
            self.wall_force += force.on_i * weight;
            self.wall_force_moment += force.on_i * moment;
            self.wall_normal_force += weight * force.normal;
        } else {
            self.pair_restitution += weight * force.restitution_power;
            self.pair_friction += weight * force.friction_power;
            self.pair_virial += force.arm * (force.on_i * weight).transpose();
        }
    }

    /// Books these powers and forces for a step of `time` [s], whose middle is `remaining` [s] before the end of the
    /// window.
    #[inline]
    pub fn add(&self, time: f64, remaining: f64, scene: &Scene, log: &mut Log) {
        let ledger = &mut log.ledger;
        ledger.pair_restitution_loss += self.pair_restitution * time;
        ledger.pair_friction_loss += self.pair_friction * time;
        ledger.wall_restitution_loss += self.wall_restitution * time;
        ledger.wall_friction_loss += self.wall_friction * time;
        ledger.wall_work += self.wall_work * time;
        ledger.pair_virial += self.pair_virial * time;
        let impulse = self.wall_force * time;
        ledger.wall_impulse += impulse;
        ledger.wall_normal_impulse += self.wall_normal_force * time;
        // For the rest of the window gravity does work on the momentum that walls add. Momentum that is added late in
        // the step has less time.
        ledger.gravity_work += scene.gravity.dot(&(impulse * remaining - self.wall_force_moment * (time * time)));
    }
}
