//! One contact: its two bodies (particle i, and another particle or a wall), their encounter, the contact force, and
//! the energy that the contact dissipates.

use crate::contact_law::friction::{Slip, coulomb};
use crate::contact_law::{Bodies, ContactLaw, Spring};
use crate::encounter::{Couple, Encounter, FrameTime, Other, Partner};
use crate::engine::Failure;
use crate::particles::Particles;
use crate::record::Impact;
use crate::rotation::{Rotation, SpringDashpotSlider};
use crate::scene::{Kind, Scene};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// [-] largest allowed overlap, divided by the (smaller) diameter. Beyond the limit the normal has no meaning.
///
/// At a plane (`flat` is true), a sphere beyond the limit is entirely behind the plane. In any other contact (`flat` is
/// false), the centre of the (smaller) sphere is then inside the other body.
pub fn overlap_limit(flat: bool) -> f64 {
    if flat { 1.0 } else { 0.5 }
}

/// [-] ratio of the path of a sphere in one step to its radius, below which the step is short. In a short step a sphere
/// cannot pass a surface without too large an overlap at the start or the end of the step.
pub const SHORT: f64 = 0.4;

/// Failure of the particle at index `i`, whose centre passes through wall `wall` within one step, reported for `time`
/// [s]. The step is a straight line of `length` [m]. The reported ratio of overlap to diameter is 0.5, the value for a
/// centre on the surface.
pub fn passed(particles: &Particles, i: usize, (wall, time): (u32, f64), length: f64) -> Failure {
    let (limit, diameter) = (overlap_limit(false), 2.0 * particles.radius[i]);
    let way = Some(length / diameter);
    Failure::OverlapTooLarge { time, particle: particles.id[i], partner: Partner::Wall(wall), ratio: 0.5, limit, way }
}

/// Failure of a contact whose overlap is too large; `ratio` and `limit` [-] are the overlap and its limit, divided by
/// the diameter.
#[cold]
fn refused(couple: Couple, particles: &Particles, time: f64, (ratio, limit): (f64, f64)) -> Failure {
    let (particle, partner) = (particles.id[couple.i as usize], couple.partner(particles));
    Failure::OverlapTooLarge { time, particle, partner, ratio, limit, way: None }
}

/// Returns that one of two simultaneous failures whose particle and partner have the smaller ids. If `one` is `None`,
/// the result is `other`.
#[cold]
pub fn first_named(one: Option<Failure>, other: Failure) -> Failure {
    let name = |failure: &Failure| match failure {
        Failure::OverlapTooLarge { particle, partner: Partner::Particle(other), .. } => (*particle, 0, *other),
        Failure::OverlapTooLarge { particle, partner: Partner::Wall(wall), .. } => (*particle, 1, *wall),
        _ => (0, 0, 0),
    };
    one.filter(|one| name(one) <= name(&other)).unwrap_or(other)
}

/// Constants of a contact between two bodies. They contain no index of a particle, so contacts between equal pairs of
/// bodies have equal constants.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactConstants {
    /// Constants of the normal contact law for the two bodies.
    pub spring: Spring,
    /// [m] smaller diameter of the two bodies; at a wall the diameter of the particle.
    pub diameter: f64,
    /// [-] friction coefficient μ of the two surfaces.
    pub friction: f64,
    /// [m] distance of the centres at touch; at a wall the radius of the particle.
    pub reach: f64,
    /// Constants of the tangential law; all zero if spheres do not rotate.
    pub tangential: SpringDashpotSlider,
}

/// Two bodies that touch, and the constants of their contact.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct TouchingPair {
    /// The two bodies that touch.
    pub couple: Couple,
    /// Constants of the contact of the two bodies.
    pub constants: ContactConstants,
}

impl std::ops::Deref for TouchingPair {
    type Target = ContactConstants;

    fn deref(&self) -> &ContactConstants {
        &self.constants
    }
}

/// A contact in progress.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Contact {
    /// Slot: number of the two bodies in the neighbour list.
    pub slot: u32,
    /// The two bodies that touch, and the constants of their contact.
    pub touch: TouchingPair,
    /// State of the contact: its present overlap, its springs, and values stored since it began.
    pub course: ContactState,
}

/// State of a contact: the present overlap and springs, and values stored since the contact began.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct ContactState {
    /// [m/s] speed of approach at the beginning of the contact.
    pub normal_speed: f64,
    /// [m] overlap when the contact was first found.
    pub first_overlap: f64,
    /// [m] largest overlap since the contact began.
    pub maximum_overlap: f64,
    /// [m] overlap at the last evaluation of the force.
    pub overlap: f64,
    /// [m/s] rate of change of the overlap at the last evaluation of the force; positive: approaching.
    pub growth: f64,
    /// [m s] integral of the overlap over the time since the contact began.
    pub overlap_time: f64,
    /// [s] simulated time at which the contact was first found.
    pub began: f64,
    /// Unit normal at the last evaluation of the force, in single precision; `None` before the first evaluation.
    pub normal: Option<Vector3<f32>>,
    /// [m] shear ξ of the tangential spring: displacement of particle i along the surface of the other body. It is 0
    /// for a contact without such a spring.
    pub shear: Vector3<f64>,
    /// State of the rolling and twisting springs; `None` if contacts do not resist rolling and twisting.
    pub resistance: Option<ResistanceMemory>,
    /// [m/s] slip of particle i relative to the other body at first touch; `None` if spheres do not rotate.
    pub first_slip: Option<Vector3<f32>>,
    /// [rad] rotation vector by which a rough wall has turned the velocity of particle i at first touch. The velocity
    /// is turned back when the contact ends. `None` for any other contact.
    pub facet: Option<Vector3<f64>>,
}

/// State of the rolling and twisting springs of a contact. If the two bodies of the contact change places, this state
/// stays the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResistanceMemory {
    /// [m] shear of the rolling spring, perpendicular to the normal.
    pub roll: Vector3<f64>,
    /// [m] shear of the twisting spring along the normal.
    pub twist: f64,
    /// [J] energies of the rolling and the twisting spring.
    pub energies: [f64; 2],
    /// [s] simulated time from which the contact resists rolling and twisting: one contact time after its beginning.
    pub acts_from: f64,
}

impl Contact {
    /// Makes a contact that begins with a touch at simulated time `began` [s]; its speed of approach is not yet set.
    pub fn new(slot: u32, touch: TouchingPair, began: f64) -> Self {
        Self { slot, touch, course: ContactState::new(began) }
    }
}

impl ContactState {
    /// State of a contact that begins at simulated time `began` [s]; its speed of approach is not yet set.
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
            facet: None,
        }
    }

    /// State of a contact that begins at simulated time `began` [s] with the speed of approach `normal_speed` [m/s]. If
    /// the bodies do not approach, as is possible at the start of a run, the contact resists rolling at once.
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

    /// State of this contact with its two bodies in the opposite order.
    pub fn reversed(self) -> Self {
        Self {
            normal: self.normal.map(|normal| -normal),
            shear: -self.shear,
            first_slip: self.first_slip.map(|slip| -slip),
            ..self
        }
    }

    /// Returns an error if the overlap is so large that the normal has no meaning, or if the centre has passed the
    /// other body.
    ///
    /// The overlap is too large in two cases: the centre of the (smaller) sphere is inside the other body, or a sphere
    /// is entirely behind a plane. The previous evaluation was one step of `dt` [s] before the present time `time` [s].
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

    /// Returns an error if the normal has reversed because the centre passed the other body.
    ///
    /// The normal of a sphere between two sides of a wall also reverses when the other side becomes the nearer one. In
    /// that case the centre has not crossed a surface. A distance from a surface changes no faster than the centre
    /// moves. So a centre that crosses the surface moves at least by the sum of its distances before and after.
    #[cold]
    fn refuse_to_pass(
        &self,
        couple: &Couple,
        constants: &ContactConstants,
        met: &Encounter,
        (particles, scene): (&Particles, &Scene),
        (time, dt): (f64, f64),
    ) -> Result<(), Failure> {
        /// [-] assumed upper limit of the ratio of the largest speed in a step to the speed at the end of the step. In
        /// a contact of about twenty steps the ratio is smaller.
        const FASTER: f64 = 2.0;
        let ContactConstants { diameter, reach, .. } = *constants;
        let (i, limit) = (couple.i as usize, overlap_limit(false));
        let Other::Wall(at) = couple.other else {
            // the centres of a pair have passed each other between the two evaluations
            return Err(refused(*couple, particles, time, (met.overlap().max(self.overlap) / diameter, limit)));
        };
        // the way is measured relative to the shape of the wall, which may move
        let sliding = scene.walls[at.wall as usize].sliding_velocity(&particles.position[i]);
        let way = (met.velocity + sliding).norm() * dt;
        let distances = (reach - self.overlap) + (reach - met.overlap());
        if distances > FASTER * way {
            return Ok(());
        }
        Err(passed(particles, i, (at.wall, time), way))
    }

    /// Stores overlap, rate of the overlap and normal of the present encounter `met` (relative position and velocity),
    /// and updates the largest overlap.
    pub fn note(&mut self, met: &Encounter) {
        self.normal = Some(met.normal.cast());
        self.overlap = met.overlap();
        self.growth = -met.normal_velocity;
        self.maximum_overlap = self.maximum_overlap.max(self.overlap);
    }

    /// Impact of this contact, which has ended with `rebound_speed` [m/s] at simulated time `now` [s]. `diameter` [m]
    /// is the smaller diameter of the two bodies.
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

/// Present force of a contact, and the powers of the parts of this force.
#[derive(Clone, Copy, Debug)]
pub struct ContactForce {
    /// [N] force on particle i; the other body gets the opposite force.
    pub on_i: Vector3<f64>,
    /// [N] component of the force along the normal; positive if it pushes the bodies apart.
    pub normal: f64,
    /// [W] power dissipated by the dashpot, in the middle of the time for which the force changes the velocities.
    pub restitution_power: f64,
    /// [W] power dissipated by friction, in the middle of the time for which the force changes the velocities.
    pub friction_power: f64,
    /// [W] power supplied by a wall whose surface moves.
    pub wall_power: f64,
    /// [W] power that the shear of the box supplies, if a sheared side is between the two particles; otherwise 0.
    pub shear_power: f64,
    /// [m] vector from the centre of the other particle (or from the wall) to the centre of particle i.
    pub arm: Vector3<f64>,
}

impl ContactForce {
    /// Makes a zero force with a power [W] that friction dissipates.
    pub fn lost(friction_power: f64) -> Self {
        let none = Vector3::zeros();
        let (restitution_power, wall_power, shear_power) = (0.0, 0.0, 0.0);
        Self { on_i: none, normal: 0.0, restitution_power, friction_power, wall_power, shear_power, arm: none }
    }
}

/// Contact constants of any two particles, if all particles are alike. With these constants, the code that computes a
/// force need not read the data of two particles, which are far apart in memory.
#[derive(Clone, Copy, Debug)]
pub struct Alike {
    constants: ContactConstants,
    species: u16,
    /// [kg] mass of each particle of the run.
    pub mass: f64,
}

impl Alike {
    /// Returns the common constants if there are at least two particles and all are alike; otherwise `None`.
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

    /// The two particles of `couple` with the common constants of contacts.
    pub fn touching(&self, couple: Couple) -> TouchingPair {
        TouchingPair { couple, constants: self.constants }
    }

    /// Species of the first particle of a pair, and kind of the second particle. All particles have one species, so
    /// both results name this species.
    pub fn kinds(&self) -> (u16, Kind) {
        (self.species, Kind::Species(self.species))
    }
}

/// [m/s²] gravity minus the acceleration of the wall, for a particle and a wall. For two particles it is 0, since
/// gravity accelerates both equally.
#[inline(always)]
pub(super) fn relative_gravity(
    couple: &Couple,
    met: &Encounter,
    (particles, scene): (&Particles, &Scene),
    moment: FrameTime,
) -> Vector3<f64> {
    let Other::Wall(at) = couple.other else { return Vector3::zeros() };
    if scene.walls[at.wall as usize].moving.is_none() {
        return scene.gravity;
    }
    scene.gravity - couple.wall_motion(met, (particles, scene), moment).unwrap_or_default().acceleration
}

/// [m/s²] component of [`relative_gravity`] perpendicular to the normal, which changes the slip of the two surfaces.
#[inline(always)]
pub(super) fn pull_along(
    couple: &Couple,
    met: &Encounter,
    scenery: (&Particles, &Scene),
    moment: FrameTime,
) -> Vector3<f64> {
    let gravity = relative_gravity(couple, met, scenery, moment);
    gravity - met.normal * gravity.dot(&met.normal)
}

impl TouchingPair {
    /// Makes a pair of touching bodies with the constants of their contact under the law `law`.
    pub fn new(couple: Couple, particles: &Particles, scene: &Scene, law: &ContactLaw) -> Self {
        Self { couple, constants: ContactConstants::new(&couple, particles, scene, law) }
    }

    /// Sets the constants to those of a contact that begins at the normal speed `speed` [m/s], as
    /// [`ContactConstants::begin_at`] does.
    #[inline]
    pub fn begin_at(&mut self, speed: f64, scenery: (&Particles, &Scene), law: &ContactLaw) {
        self.constants.begin_at(speed, &self.couple, scenery, law);
    }

    /// Force of the contact of these two bodies, as [`ContactConstants::force`] returns it.
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
    /// Constants of the contact of two bodies under the law `law`, before the speed of approach is known.
    pub fn new(couple: &Couple, particles: &Particles, scene: &Scene, law: &ContactLaw) -> Self {
        Self::of(&couple.bodies(particles, scene), couple, (particles, scene), law)
    }

    /// Sets the constants to those of a contact that begins at the normal speed `speed` [m/s] of approach. If the
    /// restitution depends on the speed, the dashpot gets a new constant for this contact. Otherwise nothing changes.
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

    /// Force of the contact of two bodies at the time `moment`. Friction acts for `time_step` [s]. Powers are computed
    /// for an instant `to_middle` [s] after the instant to which the velocities in `met` belong.
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
            let acceleration = pull_along(couple, met, (particles, scene), moment);
            let slip = Slip { velocity: met.slip(), acceleration };
            if let Some(friction) = coulomb(self.friction, normal, &slip, m, [time_step, to_middle]) {
                on_i -= friction.force;
                friction_power = friction.power;
            }
        }
        let restitution_power = -viscous * (met.normal_velocity + to_middle * normal / m);
        let wall = couple.wall_motion(met, (particles, scene), moment);
        let wall_power = wall.map_or(0.0, |wall| wall.later(to_middle).power(&on_i, None));
        let shear_power = on_i.z * couple.image_velocity(particles, scene, &met.velocity);
        let arm = met.normal * (self.reach + met.gap);
        ContactForce { on_i, normal, restitution_power, friction_power, wall_power, shear_power, arm }
    }
}
