//! Tangential force of contacts between spheres that rotate, in uniform steps.

use super::contact::{ContactConstants, ContactForce};
use super::contacts::EvaluationTime;
use crate::contact_law::ContactLaw;
use crate::contact_law::friction::{Slip, coulomb};
use crate::encounter::{Couple, Encounter};
use crate::particles::Particles;
use crate::rotation::{TangentialSpring, slip, turned};
use crate::scene::Scene;
use nalgebra::Vector3;

/// Motion of the surfaces of two touching bodies that rotate.
#[derive(Clone, Copy, Debug, Default)]
pub struct SurfaceMotion {
    /// [m/s] slip s.
    pub slip: Vector3<f64>,
    /// [-] lever arm over radius.
    pub arm: f64,
    /// [rad/s] mean spin about the normal.
    pub twist: f64,
}

impl SurfaceMotion {
    /// Motion of the surfaces of two bodies with a known [`reach`](Couple::reach) [m].
    #[inline(always)]
    pub fn of(couple: &Couple, reach: f64, met: &Encounter, particles: &Particles) -> Self {
        let (surface, arm) = couple.surface_velocity(particles, reach, met.gap);
        Self { slip: slip(&met.velocity, &met.normal, &surface), arm, twist: couple.twist(particles, &met.normal) }
    }
}

impl ContactConstants {
    /// Force of the contact between bodies that rotate, at the end of a step in which the surfaces have slipped for
    /// `at.shear_time` [s]. The shear is first turned with the normal and with the mean spin about it, and then grows
    /// by the slip. Gives the force on the centres with its powers, the torque on either particle over its radius [N],
    /// (l/r) n × F, and the shear ξ [m] that is left.
    #[inline(always)]
    pub fn rotating_force(
        &self,
        couple: &Couple,
        law: &ContactLaw,
        (met, surfaces): (&Encounter, &SurfaceMotion),
        scene: &Scene,
        (begins, before): (bool, &Vector3<f64>),
        at: &EvaluationTime,
    ) -> (ContactForce, Vector3<f64>, Vector3<f64>) {
        let (elastic, viscous) = law.force(&self.spring, met.overlap(), met.normal_velocity);
        let normal = elastic + viscous;
        let SurfaceMotion { slip, arm, twist } = *surfaces;
        let pull = Self::pull_along(couple, met, scene);
        let spring = &self.tangential;
        let (tangential, shear) = if spring.stiffness > 0.0 {
            // a contact that has just begun has slipped only since it began
            let since = if begins && met.normal_velocity < 0.0 {
                at.shear_time.min(-met.overlap() / met.normal_velocity)
            } else {
                at.shear_time
            };
            let sheared = turned(before, &met.normal, twist * since) + slip * since;
            spring.limited(sheared, &slip, TangentialSpring::limit(self.friction, normal))
        } else {
            let slip = Slip { velocity: slip, acceleration: pull };
            let friction = coulomb(self.friction, normal, &slip, spring.mass, [at.dt, at.to_middle]);
            (friction.map_or_else(Vector3::zeros, |friction| friction.force), Vector3::zeros())
        };
        let in_the_middle = slip + (pull - tangential / spring.mass) * at.to_middle;
        // the spring keeps a part of the work of the force
        let kept = if at.shear_time > 0.0 { (spring.energy(&shear) - spring.energy(before)) / at.dt } else { 0.0 };
        let on_i = met.normal * normal - tangential;
        let force = ContactForce {
            on_i,
            normal,
            restitution_power: -viscous * (met.normal_velocity + at.to_middle * normal / self.spring.effective_mass),
            friction_power: tangential.dot(&in_the_middle) - kept,
            wall_power: couple.driven(&on_i, scene),
            arm: met.normal * (self.reach + met.gap),
        };
        (force, met.normal.cross(&tangential) * arm, shear)
    }
}
