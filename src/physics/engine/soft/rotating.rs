//! Tangential force of contacts between spheres that rotate, in uniform steps.

use super::contact::{ContactConstants, ContactForce, ContactState, ResistanceMemory, pull_along};
use super::contacts::EvaluationTime;
use super::force_buffer::ContactTorque;
use super::rolling::{ResistedStep, RollingMotion};
use crate::contact_law::ContactLaw;
use crate::contact_law::friction::{Slip, coulomb};
use crate::encounter::{Couple, Encounter};
use crate::particles::Particles;
use crate::record::{FrictionLosses, SlipChange};
use crate::rotation::{SpringDashpotSlider, slip, turned};
use crate::scene::Scene;
use nalgebra::Vector3;

/// Motion of the surfaces of two touching bodies that rotate.
#[derive(Clone, Copy, Debug, Default)]
pub struct SurfaceMotion {
    /// [m/s] slip s: tangential velocity of the surface of particle i relative to that of the second body.
    pub slip: Vector3<f64>,
    /// [-] lever arm of the tangential force about the centre of a sphere, divided by the radius of the sphere.
    pub arm: f64,
    /// [rad/s] component of the mean spin of the two bodies along the normal.
    pub twist: f64,
}

impl SurfaceMotion {
    /// Motion of the surfaces of two bodies. `reach` [m] is the distance of the centres at touch; at a wall, the radius
    /// of the particle.
    #[inline(always)]
    pub fn of(couple: &Couple, reach: f64, met: &Encounter, (particles, scene): (&Particles, &Scene)) -> Self {
        let (surface, arm) = couple.surface_velocity(particles, reach, met.gap);
        Self {
            slip: slip(&met.velocity, &met.normal, &surface),
            arm,
            twist: couple.twist(particles, scene, &met.normal),
        }
    }
}

/// State of a contact between bodies that rotate, at the start of a step.
pub struct BeforeStep<'a> {
    /// True if the contact has begun since the last evaluation.
    pub begins: bool,
    /// [m] overlap at the start of the step.
    pub overlap: f64,
    /// [m] shear of the tangential spring at the start of the step.
    pub shear: Vector3<f64>,
    /// State of the rolling and twisting springs, which the step changes; `None` if contacts do not resist these
    /// motions.
    pub resistance: Option<&'a mut ResistanceMemory>,
}

/// Force and torques of a contact between bodies that rotate.
pub struct RotatingForce {
    /// Force on the centres of the two bodies, with its powers.
    pub force: ContactForce,
    /// Torques on the two bodies.
    pub torque: ContactTorque,
    /// [m] shear ξ of the tangential spring after the step.
    pub shear: Vector3<f64>,
    /// [W] parts of the friction power of the force, by cause.
    pub losses: FrictionLosses,
}

impl ContactConstants {
    /// Force and torques of a contact between rotating bodies, at the end of a step in which the surfaces have slipped
    /// for `at.shear_time` [s]. The shear before the step is first turned with the normal, and by the mean spin about
    /// the normal. Then the distance slipped is added to the shear.
    #[inline(always)]
    pub fn rotating_force(
        &self,
        couple: &Couple,
        law: &ContactLaw,
        (met, surfaces): (&Encounter, &SurfaceMotion),
        (particles, scene): (&Particles, &Scene),
        before: BeforeStep,
        at: &EvaluationTime,
    ) -> RotatingForce {
        let (elastic, viscous) = law.force(&self.spring, met.overlap(), met.normal_velocity);
        let normal = elastic + viscous;
        let SurfaceMotion { slip, arm, twist } = *surfaces;
        let pull = pull_along(couple, met, (particles, scene), at.moment());
        let spring = &self.tangential.at(met.overlap());
        // a contact that has just begun has slipped only since its beginning
        let since = if before.begins && met.normal_velocity < 0.0 {
            at.shear_time.min(-met.overlap() / met.normal_velocity)
        } else {
            at.shear_time
        };
        let stored = self.tangential.at(before.overlap).energy(&before.shear);
        let (mut rescaled, mut damped) = (0.0, 0.0);
        let (tangential, shear) = if self.tangential.stiffness > 0.0 {
            let (kept, grown) = self.tangential.growth(before.overlap, met.overlap());
            let carried = turned(&before.shear, &met.normal, twist * since) * kept;
            if self.tangential.half_powers > 0 {
                rescaled = stored - spring.energy(&carried);
            }
            let sheared = carried + slip * (since * grown);
            let (force, left) = spring.limited(sheared, &slip, SpringDashpotSlider::limit(self.friction, normal));
            if left == sheared {
                damped = spring.dashpot;
            }
            (force, left)
        } else {
            let slip = Slip { velocity: slip, acceleration: pull };
            let friction = coulomb(self.friction, normal, &slip, spring.mass, [at.dt, at.to_middle]);
            (friction.map_or_else(Vector3::zeros, |friction| friction.force), Vector3::zeros())
        };
        let mut slip_change = pull - tangential / spring.mass;
        let resisted = before.resistance.map(|memory| {
            let turns = SurfaceTurn { arm, angle: twist * since, tangential, normal, elapsed: since };
            self.resist(couple, law, met, (particles, scene), (memory, before.overlap), (&turns, at))
        });
        if let Some(resisted) = &resisted {
            slip_change += resisted.slip_change;
        }
        let in_the_middle = slip + slip_change * at.to_middle;
        // the spring stores a part of the work of the force
        let kept = if at.shear_time > 0.0 { (spring.energy(&shear) - stored) / at.dt } else { 0.0 };
        let [rolling, twisting] = resisted.as_ref().map_or([0.0; 2], |some| some.parts);
        let rescaling = if at.shear_time > 0.0 { rescaled / at.dt } else { 0.0 };
        let losses = FrictionLosses::new(damped * slip.dot(&in_the_middle), [0.0, rescaling, rolling, twisting]);
        let on_i = met.normal * normal - tangential;
        let force = ContactForce {
            on_i,
            normal,
            restitution_power: -viscous * (met.normal_velocity + at.to_middle * normal / self.spring.effective_mass),
            friction_power: tangential.dot(&in_the_middle) - kept + resisted.as_ref().map_or(0.0, |some| some.power),
            wall_power: couple
                .wall_motion(met, (particles, scene), at.moment())
                .map_or(0.0, |wall| wall.later(at.to_middle).power(&on_i, resisted.as_ref().map(|some| &some.couple))),
            shear_power: on_i.z * couple.image_velocity(particles, scene, &met.velocity),
            arm: met.normal * (self.reach + met.gap),
        };
        let torque = ContactTorque {
            over_radius: met.normal.cross(&tangential) * arm,
            couple: resisted.map(|some| some.couple),
        };
        RotatingForce { force, torque, shear, losses }
    }

    /// Resistance to rolling and twisting at the end of a step; zero until the contact has lasted for one contact
    /// time. This function is not inlined, because few scenes have resistance.
    #[inline(never)]
    fn resist(
        &self,
        couple: &Couple,
        law: &ContactLaw,
        met: &Encounter,
        (particles, scene): (&Particles, &Scene),
        (memory, before): (&mut ResistanceMemory, f64),
        (turns, at): (&SurfaceTurn, &EvaluationTime),
    ) -> Resisted {
        let Some(rotation) = scene.rotation.as_ref().filter(|_| at.start + at.elapsed >= memory.acts_from) else {
            return Resisted::default();
        };
        let motion = RollingMotion::of(couple, self, (law, rotation), met, (particles, scene));
        let passed_on = motion.passed_on(couple, particles) * turns.arm;
        let step =
            ResistedStep { before, after: met.overlap(), dt: at.dt, elapsed: turns.elapsed, to_middle: at.to_middle };
        let driven = turns.tangential * passed_on;
        let done = motion.resist(memory, &met.normal, turns.normal, (turns.angle, &driven), &step);
        Resisted { couple: done.couple, power: done.power, parts: done.parts, slip_change: done.rolling * passed_on }
    }
}

/// Motion and forces of a contact in a step, from which its resistance to rolling and twisting is computed.
struct SurfaceTurn {
    /// [-] lever arm of the tangential force divided by the radius of the sphere.
    arm: f64,
    /// [rad] angle by which the mean spin has turned the contact about the normal.
    angle: f64,
    /// [N] tangential force of the contact in this step.
    tangential: Vector3<f64>,
    /// [N] normal force of the contact in this step.
    normal: f64,
    /// [s] part of the step in which the surfaces have moved.
    elapsed: f64,
}

/// Effect of the resistance of a contact to rolling and twisting in one step.
#[derive(Default)]
struct Resisted {
    /// [N m] torque of the resistance on particle i.
    couple: Vector3<f64>,
    /// [W] power that the resistance takes from the rotation.
    power: f64,
    /// [W] power that rolling resistance takes from the rotation, and power that twisting resistance takes.
    parts: [f64; 2],
    /// [m/s²] acceleration of the slip by the resistance.
    slip_change: Vector3<f64>,
}

impl ContactState {
    /// Slip before and after the impact of two rotating bodies; `None` if no slip was stored at first touch. `met` is
    /// the encounter at the end of the impact, and `rebound_speed` [m/s] the speed of rebound.
    pub fn slip_change(
        &self,
        couple: &Couple,
        constants: &ContactConstants,
        (met, rebound_speed): (&Encounter, f64),
        (particles, scene): (&Particles, &Scene),
    ) -> Option<SlipChange> {
        let first: Vector3<f64> = self.first_slip?.cast();
        let along = first - met.normal * first.dot(&met.normal);
        let direction = along.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        let (before, last) = (first.norm(), SurfaceMotion::of(couple, constants.reach, met, (particles, scene)).slip);
        // the direction of the first slip has turned with the normal
        let change = (last - direction * before).norm();
        let normal_impulse = constants.spring.effective_mass * (self.normal_speed + rebound_speed);
        let impulse = couple.tangential_mass(particles) * change;
        Some(SlipChange::new([before, last.dot(&direction)], impulse, constants.friction * normal_impulse))
    }
}
