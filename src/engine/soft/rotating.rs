//! Tangential force of contacts between spheres that rotate, in uniform steps.

use super::contact::{ContactConstants, ContactForce, ContactState};
use super::contacts::EvaluationTime;
use crate::contact_law::ContactLaw;
use crate::contact_law::friction::{Slip, coulomb};
use crate::encounter::{Couple, Encounter};
use crate::particles::Particles;
use crate::rotation::{TangentialSpring, slip, turned};
use crate::scene::Scene;
use nalgebra::Vector3;

/// Force of a contact between bodies that may rotate.
#[derive(Clone, Copy, Debug)]
pub struct RotatingForce {
    /// Force on the centres, and powers.
    pub force: ContactForce,
    /// [N] torque on either particle over its radius: (l/r) n × F.
    pub torque: Vector3<f64>,
    /// [m] shear ξ that is left in the spring.
    pub shear: Vector3<f64>,
}

impl ContactConstants {
    /// Force of the contact between bodies that rotate, at the end of a step in which the surfaces have slipped for `at.shear_time` [s]. The shear is first
    /// turned with the normal and with the mean spin about it, and then grows by the slip.
    pub fn rotating_force(
        &self,
        couple: &Couple,
        law: &ContactLaw,
        met: &Encounter,
        (particles, scene): (&Particles, &Scene),
        course: &ContactState,
        at: &EvaluationTime,
    ) -> RotatingForce {
        let (elastic, viscous) = law.force(&self.spring, met.overlap(), met.normal_velocity);
        let normal = elastic + viscous;
        let (surface, arm) = couple.surface_velocity(particles, self.reach, met.gap);
        let slip = slip(&met.velocity, &met.normal, &surface);
        let pull = Self::pull_along(couple, met, scene);
        let spring = &self.tangential;
        let (tangential, shear) = if spring.stiffness > 0.0 {
            // a contact that has just begun has slipped only since it began
            let since = if course.normal.is_none() && met.normal_velocity < 0.0 {
                at.shear_time.min(-met.overlap() / met.normal_velocity)
            } else {
                at.shear_time
            };
            let angle = couple.twist(particles, &met.normal) * since;
            let sheared = turned(&course.shear, &met.normal, angle) + slip * since;
            spring.limited(sheared, &slip, TangentialSpring::limit(self.friction, normal))
        } else {
            let slip = Slip { velocity: slip, acceleration: pull };
            let friction = coulomb(self.friction, normal, &slip, spring.mass, [at.dt, at.to_middle]);
            (friction.map_or_else(Vector3::zeros, |friction| friction.force), Vector3::zeros())
        };
        let in_the_middle = slip + (pull - tangential / spring.mass) * at.to_middle;
        // the spring keeps a part of the work of the force
        let kept =
            if at.shear_time > 0.0 { (spring.energy(&shear) - spring.energy(&course.shear)) / at.dt } else { 0.0 };
        let on_i = met.normal * normal - tangential;
        let force = ContactForce {
            on_i,
            normal,
            restitution_power: -viscous * (met.normal_velocity + at.to_middle * normal / self.spring.effective_mass),
            friction_power: tangential.dot(&in_the_middle) - kept,
            wall_power: couple.driven(&on_i, scene),
            arm: met.normal * (self.reach + met.gap),
        };
        RotatingForce { force, torque: met.normal.cross(&tangential) * arm, shear }
    }
}
