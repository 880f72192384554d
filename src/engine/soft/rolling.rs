//! Rolling and twisting resistance of a contact, as the engines evaluate it.

use super::contact::{ContactConstants, ResistanceMemory};
use crate::contact_law::ContactLaw;
use crate::encounter::{Couple, Encounter};
use crate::particles::Particles;
use crate::rotation::{Resistance, RollingBodies, Rotation, SpringDashpotSlider, turned};
use crate::scene::Scene;
use nalgebra::Vector3;

/// Two touching bodies that roll and twist on one another.
#[derive(Clone, Copy, Debug)]
pub struct RollingMotion {
    /// Radii and inertia of the bodies.
    pub bodies: RollingBodies,
    /// [m/s] rolling velocity R_eff (ω_i - ω_j) × n.
    pub rolling: Vector3<f64>,
    /// [m/s] twisting speed R_eff (ω_i - ω_j)·n.
    pub twisting: f64,
    /// Resistance to rolling.
    pub against_rolling: Option<Resistance>,
    /// Resistance to twisting.
    pub against_twisting: Option<Resistance>,
}

/// Resistance of a contact at the end of a uniform step.
#[derive(Clone, Copy, Debug, Default)]
pub struct ResistingCouple {
    /// [N m] couple on particle i; the other body gets the opposite one.
    pub couple: Vector3<f64>,
    /// [N] force f of the rolling resistance; the couple is -R_eff n × f.
    pub rolling: Vector3<f64>,
    /// [W] taken from the rotation, in the middle of the kick.
    pub power: f64,
    /// [W] parts of it that rolling and twisting resistance take.
    pub parts: [f64; 2],
}

impl RollingMotion {
    /// Motion of two bodies and the resistances of their scene against it.
    pub fn of(
        couple: &Couple,
        constants: &ContactConstants,
        (law, rotation): (&ContactLaw, &Rotation),
        met: &Encounter,
        (particles, scene): (&Particles, &Scene),
    ) -> Self {
        let inertia = particles.inertia.as_deref().unwrap_or_default();
        let body = |place: u32| {
            let place = place as usize;
            (particles.mass[place], particles.radius[place], inertia[place])
        };
        let bodies = RollingBodies::of(couple.places().into_iter().flatten().map(body));
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

    /// [1/kg] acceleration of rolling per tangential force, and of slip per rolling resistance: R_eff (r_i/I_i - r_j/I_j)
    /// per lever arm over radius.
    pub fn passed_on(&self, couple: &Couple, particles: &Particles) -> f64 {
        let inertia = particles.inertia.as_deref().unwrap_or_default();
        let of = |place: u32| particles.radius[place as usize] / inertia[place as usize];
        self.bodies.radius * (of(couple.i) - couple.j().map_or(0.0, of))
    }

    /// [N m] couple on particle i of resistances [N] against rolling and twisting.
    #[inline(always)]
    pub fn couple(&self, normal: &Vector3<f64>, rolling: &Vector3<f64>, twisting: f64) -> Vector3<f64> {
        -(normal.cross(rolling) + normal * twisting) * self.bodies.radius
    }
}

/// Overlaps [m] before and after a step, its length `dt` [s], and the part of it in which the surfaces have moved.
#[derive(Clone, Copy, Debug)]
pub struct ResistedStep {
    /// [m]
    pub before: f64,
    /// [m]
    pub after: f64,
    /// [s]
    pub dt: f64,
    /// [s]
    pub elapsed: f64,
    /// [s] from the given velocities to the middle of the kick.
    pub to_middle: f64,
}

impl Resistance {
    /// [N] resistance without memory against a velocity [m/s], at a normal force [N]: at most what stops the motion
    /// within `dt` [s].
    #[inline(always)]
    pub fn without_memory(&self, velocity: &Vector3<f64>, normal_force: f64, dt: f64) -> Vector3<f64> {
        let speed = velocity.norm();
        if speed == 0.0 {
            return Vector3::zeros();
        }
        let wanted = (self.friction + self.viscosity * speed) * normal_force.max(0.0);
        velocity * (wanted.min(self.spring.mass * speed / dt) / speed)
    }

    /// Force [N] at the end of a step at a velocity [m/s], and the shear [m] that is left of `shear` [m].
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
    /// Resistance at the end of a uniform step in which the mean spin about the normal turned by `angle` [rad].
    /// `driven` [m/s²] is the rolling acceleration by the tangential force.
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

    /// [J] energies of the rolling and the twisting spring at overlap δ [m].
    pub fn energies(&self, memory: &ResistanceMemory, overlap: f64) -> [f64; 2] {
        let of = |resistance: &Option<Resistance>, square: f64| {
            resistance.map_or(0.0, |resistance| 0.5 * resistance.spring.at(overlap).stiffness * square)
        };
        [of(&self.against_rolling, memory.roll.norm_squared()), of(&self.against_twisting, memory.twist.powi(2))]
    }
}
