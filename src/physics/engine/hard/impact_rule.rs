//! Impulse (change of momentum) and change of spin in a collision of hard spheres that rotate.

use super::impulse::Collision;
use crate::particles::Particles;
use crate::record::SlipChange;
use crate::rotation::{ImpactRule, ObliqueApproach, Rotation, slip, tangential_mass};
use crate::scene::Surface;
use nalgebra::Vector3;

/// Result of a collision of two rotating bodies: the impulse, and the energy lost by friction.
#[derive(Clone, Copy, Debug)]
pub struct RoughImpulse {
    /// [kg m/s] change of the momentum of particle `i`, the first of the two bodies.
    pub impulse: Vector3<f64>,
    /// [J] kinetic energy of the two bodies that is lost by friction and by tangential restitution.
    pub friction_loss: f64,
    /// [J] part of `friction_loss` that is due to tangential restitution. It is all of `friction_loss` if the surfaces
    /// stick under Walton's rule, otherwise 0.
    pub tangential_restitution_loss: f64,
    /// Tangential relative velocity of the two surfaces before and after the collision.
    pub slip: SlipChange,
}

impl Collision {
    /// Computes the impulse (change of momentum) of particle `i`, and changes the spins of both bodies in `particles`.
    /// The impulse is J_n **n** - **J**_t, with the normal **n** from the other body to `i`. J_n is (1+e) M |u_n|, with
    /// the restitution e and the normal velocity u_n. **J**_t is parallel to the slip, the tangential velocity of the
    /// surface of `i` relative to the other surface. The scene's impact rule gives the magnitude of **J**_t. The spin
    /// of each body changes by l **n** × **J**_t/I, with its lever arm l and its moment of inertia I
    /// (docs/rotation.md).
    ///
    /// The tuple contains J_n [kg m/s], the effective mass M [kg], and the distance [m] of the centres at touch (the
    /// radius at a wall). Without spins, slip or friction the impulse is J_n **n**, and no spin changes.
    pub fn rough_impulse(
        &self,
        rotation: &Rotation,
        surface: &Surface,
        (normal_impulse, effective_mass, reach): (f64, f64, f64),
        particles: &mut Particles,
    ) -> RoughImpulse {
        let (couple, met) = (&self.couple, &self.met);
        let along = met.normal * normal_impulse;
        let (surface_velocity, arm) = couple.surface_velocity(particles, reach, met.gap);
        let slip = slip(&met.velocity, &met.normal, &surface_velocity);
        let speed = slip.norm();
        let limit = surface.friction * normal_impulse;
        let slip_change = SlipChange::new([speed, speed], 0.0, limit);
        let none =
            RoughImpulse { impulse: along, friction_loss: 0.0, tangential_restitution_loss: 0.0, slip: slip_change };
        let (Some(spins), Some(inertia)) = (&mut particles.spin, &particles.inertia) else { return none };
        if speed == 0.0 || surface.friction == 0.0 {
            return none;
        }
        let arm_of = |index: usize| arm * particles.radius[index];
        let indices = || couple.indices().into_iter().flatten().map(|index| index as usize);
        let mass = tangential_mass(indices().map(|index| (particles.mass[index], arm_of(index), inertia[index])));
        let tangential = rotation.impact.impulse(&ObliqueApproach {
            friction: surface.friction,
            restitution: surface.restitution,
            normal_speed: self.approach(),
            normal_impulse,
            slip: speed,
            mass,
            mass_ratio: mass / effective_mass,
        });
        let against = slip * (tangential / speed);
        let torque = met.normal.cross(&against);
        indices().for_each(|index| spins[index] += torque * (arm_of(index) / inertia[index]));
        let friction_loss = tangential * (speed - 0.5 * tangential / mass);
        // the other rule, that of a tangential spring, does not separate the loss by tangential restitution from the
        // loss by sliding
        let sticks = matches!(rotation.impact, ImpactRule::Walton { .. }) && tangential < limit;
        let tangential_restitution_loss = if sticks { friction_loss } else { 0.0 };
        let slip = SlipChange::new([speed, speed - tangential / mass], tangential, limit);
        RoughImpulse { impulse: along - against, friction_loss, tangential_restitution_loss, slip }
    }
}
