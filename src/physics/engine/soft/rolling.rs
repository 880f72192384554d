//! Rolling and twisting resistance of a contact, for the engines of soft spheres.

use super::contact::{ContactConstants, ResistanceMemory};
use crate::contact_law::ContactLaw;
use crate::encounter::{Couple, Encounter};
use crate::particles::Particles;
use crate::rotation::{Resistance, RollingBodies, Rotation, SpringDashpotSlider, turned};
use crate::scene::Scene;
use nalgebra::Vector3;

/// Rolling and twisting motion of two touching bodies, and the resistances to this motion.
#[derive(Clone, Copy, Debug)]
pub struct RollingMotion {
    /// Effective radius R_eff and inertia of the two bodies for rolling and twisting.
    pub bodies: RollingBodies,
    /// [m/s] rolling velocity R_eff (ω_i - ω_j) × n, with the spins ω and the unit normal n.
    pub rolling: Vector3<f64>,
    /// [m/s] twisting speed R_eff (ω_i - ω_j)·n, with the spins ω and the unit normal n.
    pub twisting: f64,
    /// Resistance to rolling; `None` if the contact does not resist rolling.
    pub against_rolling: Option<Resistance>,
    /// Resistance to twisting; `None` if the contact does not resist twisting.
    pub against_twisting: Option<Resistance>,
}

/// Torque and power of the resistance of a contact at the end of a uniform step.
#[derive(Clone, Copy, Debug, Default)]
pub struct ResistingCouple {
    /// [N m] torque on particle i; the other body gets the opposite torque.
    pub couple: Vector3<f64>,
    /// [N] force f of the rolling resistance; its torque is -R_eff n × f, with the effective radius R_eff and normal n.
    pub rolling: Vector3<f64>,
    /// [W] power that the resistance takes from the rotation, in the middle of the kick (change of velocities by
    /// forces).
    pub power: f64,
    /// [W] power that rolling resistance takes from the rotation, and power that twisting resistance takes; their sum
    /// is `power`.
    pub parts: [f64; 2],
}

impl RollingMotion {
    /// Rolling and twisting motion of two bodies, and the resistances to this motion by the laws of the scene.
    pub fn of(
        couple: &Couple,
        constants: &ContactConstants,
        (law, rotation): (&ContactLaw, &Rotation),
        met: &Encounter,
        (particles, scene): (&Particles, &Scene),
    ) -> Self {
        let inertia = particles.inertia.as_deref().unwrap_or_default();
        let body = |index: u32| {
            let index = index as usize;
            (particles.mass[index], particles.radius[index], inertia[index])
        };
        let bodies = RollingBodies::of(couple.indices().into_iter().flatten().map(body));
        let spins = couple.relative_spin(particles, scene) * bodies.radius;
        let (species, other) = couple.kinds(particles);
        let own = scene.resistance(species, other);
        let against_rolling = rotation.rolling.map(|rolling| {
            let normal = law.normal_spring(&couple.bodies(particles, scene), &constants.spring);
            rolling.with_friction(own.rolling).between(&normal, &bodies)
        });
        let friction = own.twisting.unwrap_or(constants.friction);
        let against_twisting =
            rotation.twisting.map(|twisting| twisting.between(&constants.tangential, friction, met.overlap(), &bodies));
        let (rolling, twisting) = (spins.cross(&met.normal), spins.dot(&met.normal));
        Self { bodies, rolling, twisting, against_rolling, against_twisting }
    }

    /// [1/kg] rolling acceleration divided by the tangential force that causes it: R_eff (r_i/I_i - r_j/I_j), without
    /// r_j/I_j at a wall. R_eff is the effective radius, r a radius and I a moment of inertia. The lever arm of the
    /// force is taken as the radius. The acceleration of the slip divided by the rolling resistance has the same value.
    pub fn passed_on(&self, couple: &Couple, particles: &Particles) -> f64 {
        let inertia = particles.inertia.as_deref().unwrap_or_default();
        let of = |index: u32| particles.radius[index as usize] / inertia[index as usize];
        self.bodies.radius * (of(couple.i) - couple.j().map_or(0.0, of))
    }

    /// [N m] torque on particle i by the forces `rolling` and `twisting` [N] of the resistances.
    #[inline(always)]
    pub fn couple(&self, normal: &Vector3<f64>, rolling: &Vector3<f64>, twisting: f64) -> Vector3<f64> {
        -(normal.cross(rolling) + normal * twisting) * self.bodies.radius
    }
}

/// A step in which a contact resists rolling and twisting.
#[derive(Clone, Copy, Debug)]
pub struct ResistedStep {
    /// [m] overlap of the contact before the step.
    pub before: f64,
    /// [m] overlap of the contact after the step.
    pub after: f64,
    /// [s] length of the step.
    pub dt: f64,
    /// [s] time in the step during which the surfaces have moved. It is less than `dt` if the contact has just begun.
    pub elapsed: f64,
    /// [s] time from the instant to which the rolling and twisting velocities belong, until the middle of the kick
    /// (change of velocities by forces).
    pub to_middle: f64,
}

impl Resistance {
    /// [N] force of a resistance without spring, for a velocity [m/s] and a normal force [N]. It is at most the force
    /// that stops the motion within `dt` [s].
    #[inline(always)]
    pub fn without_memory(&self, velocity: &Vector3<f64>, normal_force: f64, dt: f64) -> Vector3<f64> {
        let speed = velocity.norm();
        if speed == 0.0 {
            return Vector3::zeros();
        }
        let wanted = (self.friction + self.viscosity * speed) * normal_force.max(0.0);
        velocity * (wanted.min(self.spring.mass * speed / dt) / speed)
    }

    /// Returns the force [N] at the end of a step, and the shear [m] of the spring after the step. `shear` [m] is the
    /// shear before the step, and `velocity` [m/s] the relative velocity that stretches the spring.
    fn resist(
        &self,
        (shear, velocity): (Vector3<f64>, Vector3<f64>),
        normal_force: f64,
        step: &ResistedStep,
    ) -> (Vector3<f64>, Vector3<f64>) {
        if self.spring.stiffness == 0.0 {
            return (self.without_memory(&velocity, normal_force, step.dt), shear);
        }
        let (kept, grown) = self.spring.growth(step.before, step.after);
        let limit = SpringDashpotSlider::limit(self.friction, normal_force);
        self.spring.at(step.after).limited(shear * kept + velocity * (step.elapsed * grown), &velocity, limit)
    }
}

impl RollingMotion {
    /// Torque and power of the resistance at the end of a uniform step, in which the mean spin has turned the contact
    /// by `angle` [rad] about the normal. `driven` [m/s²] is the rolling acceleration that the tangential force causes.
    /// Stores the new state of the springs in `memory`.
    pub fn resist(
        &self,
        memory: &mut ResistanceMemory,
        normal: &Vector3<f64>,
        normal_force: f64,
        (angle, driven): (f64, &Vector3<f64>),
        step: &ResistedStep,
    ) -> ResistingCouple {
        let mut done = ResistingCouple::default();
        let mut twisting = 0.0;
        if let Some(resistance) = &self.against_rolling {
            let start = (turned(&memory.roll, normal, angle), self.rolling);
            (done.rolling, memory.roll) = resistance.resist(start, normal_force, step);
            let in_the_middle = self.rolling + (driven - done.rolling / self.bodies.mass) * step.to_middle;
            done.parts[0] = done.rolling.dot(&in_the_middle);
        }
        if let Some(resistance) = &self.against_twisting {
            let start = (normal * memory.twist, normal * self.twisting);
            let (force, left) = resistance.resist(start, normal_force, step);
            (twisting, memory.twist) = (force.dot(normal), left.dot(normal));
            done.parts[1] = twisting * (self.twisting - twisting / self.bodies.mass * step.to_middle);
        }
        let energies = self.energies(memory, step.after);
        done.power = done.parts.iter().sum();
        if step.elapsed > 0.0 {
            let stored = |energies: [f64; 2]| energies[0] + energies[1];
            done.power -= (stored(energies) - stored(memory.energies)) / step.dt;
            for (part, (energy, before)) in done.parts.iter_mut().zip(energies.iter().zip(memory.energies)) {
                *part -= (energy - before) / step.dt;
            }
        }
        memory.energies = energies;
        done.couple = self.couple(normal, &done.rolling, twisting);
        done
    }

    /// [J] energies of the rolling and the twisting spring at the overlap `overlap` [m].
    pub fn energies(&self, memory: &ResistanceMemory, overlap: f64) -> [f64; 2] {
        let of = |resistance: &Option<Resistance>, square: f64| {
            resistance.map_or(0.0, |resistance| 0.5 * resistance.spring.at(overlap).stiffness * square)
        };
        [of(&self.against_rolling, memory.roll.norm_squared()), of(&self.against_twisting, memory.twist.powi(2))]
    }
}
