//! Impulse of a collision of hard spheres: the instantaneous change of momentum. A window is the time between two
//! exchanges with the gas. The ledger holds the sums of energies and impulses of a run.

use crate::encounter::{AtWall, Couple, Encounter, Other, WallMotion};
use crate::particles::Particles;
use crate::record::{Between, Impact, Ledger, Log};
use crate::scene::{Kind, Scene, Surface};
use crate::walls::WallApproach;
use nalgebra::Vector3;
use std::ops::Deref;

/// Impulse on body i [kg m/s] from a body j that it approaches, without rotation. The normal part is J_n = (1+e) M
/// |u_n|, with the restitution e at the normal speed |u_n|. The tangential part acts against the slip **u**_t, with the
/// magnitude J_t = min(μ J_n, M |u_t|) and the friction coefficient μ. These are Eq. 4 of the paper discussed in
/// docs/paper.md, and the Coulomb law below that equation.
///
/// `velocity` is the relative velocity u = u_i - u_j [m/s], and the unit vector `normal` points from j to i.
/// `effective_mass` is M [kg]; for a wall it is the mass of the particle.
pub fn impulse(surface: &Surface, effective_mass: f64, velocity: &Vector3<f64>, normal: &Vector3<f64>) -> Vector3<f64> {
    let normal_velocity = velocity.dot(normal);
    let along = -(1.0 + surface.restitution_at(-normal_velocity)) * effective_mass * normal_velocity;
    let slip = velocity - normal * normal_velocity;
    let slip_speed = slip.norm();
    let mut impulse = normal * along;
    if surface.friction > 0.0 && slip_speed > 0.0 {
        let against = (surface.friction * along).min(effective_mass * slip_speed);
        impulse -= slip * (against / slip_speed);
    }
    impulse
}

/// Access of a collision to the particle store.
pub enum ParticleAccess<'a> {
    /// Particle store that only one thread uses, so that a collision can change spins in the store.
    Exclusive(&'a mut Particles),
    /// Particle store that several threads read at the same time. Spheres do not rotate in this case.
    Shared(&'a Particles),
}

impl Deref for ParticleAccess<'_> {
    type Target = Particles;

    fn deref(&self) -> &Particles {
        match self {
            Self::Exclusive(particles) => particles,
            Self::Shared(particles) => particles,
        }
    }
}

impl ParticleAccess<'_> {
    /// Particle store, for a change of the spins; `None` if other threads read the store at the same time.
    fn exclusive(&mut self) -> Option<&mut Particles> {
        match self {
            Self::Exclusive(particles) => Some(particles),
            Self::Shared(_) => None,
        }
    }
}

/// Two bodies at the instant of their collision; body `i` is the first particle of `couple`.
#[derive(Clone, Copy, Debug)]
pub struct Collision {
    /// The two bodies that collide: particle `i`, and another particle or a wall.
    pub couple: Couple,
    /// Position and velocity of particle `i` relative to the other body. Rounding may cause a small overlap; in the
    /// engine with time steps the finite step causes a larger one.
    pub met: Encounter,
    /// True if the collision loses no energy along the normal, whatever the surfaces. In the TC model (Luding and
    /// McNamara 1998, Granular Matter 1, 113) a collision is elastic if one of the partners collided less than the
    /// contact time before.
    pub elastic: bool,
    /// Species of particle `i`, and kind (species or wall) of the other body; they select restitution and friction.
    pub kinds: (u16, Kind),
    /// Motion of the wall's surface at the point of contact: velocity, spin and accelerations. `None` if the other body
    /// is a particle.
    pub wall: Option<WallMotion>,
    /// [m/s] velocity along z of the periodic image that particle `i` hits, relative to the particle of which it is an
    /// image. It is 0 unless the two particles meet across a sheared side of the box ([`Couple::image_velocity`]).
    pub image: f64,
}

/// Masses and lengths of two colliding bodies that determine their impulse and the recorded overlap.
#[derive(Clone, Copy, Debug)]
pub struct CollisionMasses {
    /// [kg] mass of particle `i`.
    pub mass: f64,
    /// Mass [kg] of the other particle; `None` for a wall.
    pub other: Option<f64>,
    /// [m] smaller of the two diameters, by which recorded overlaps are divided; at a wall the diameter of the
    /// particle.
    pub diameter: f64,
    /// [m] distance between the centres at touch; at a wall the radius of the particle.
    pub reach: f64,
}

impl CollisionMasses {
    /// Reads masses and lengths of the two bodies from the particle store.
    pub fn of(couple: &Couple, particles: &Particles) -> Self {
        Self {
            mass: particles.mass[couple.i as usize],
            other: couple.j().map(|j| particles.mass[j as usize]),
            diameter: couple.diameter(particles),
            reach: couple.indices().into_iter().flatten().map(|index| particles.radius[index as usize]).sum(),
        }
    }

    /// Effective mass m_i m_j/(m_i + m_j) [kg]; at a wall the mass of the particle.
    fn effective(&self) -> f64 {
        self.other.map_or(self.mass, |other| 1.0 / (1.0 / self.mass + 1.0 / other))
    }
}

impl Collision {
    /// Speed [m/s] at which the two bodies approach along the normal; positive if they approach.
    pub fn approach(&self) -> f64 {
        -self.met.normal_velocity
    }

    /// True if the restitution takes energy along the normal. Collisions without this loss may go on without end, and
    /// are no sign of an inelastic collapse. The result is false at a thermal wall, which does not use its restitution.
    pub fn loses(&self, scene: &Scene) -> bool {
        let dissipates = || scene.surface(self.kinds.0, self.kinds.1).restitution_at(self.approach()) < 1.0;
        !self.elastic && !self.is_thermal(scene) && dissipates()
    }

    /// True if the other body is a thermal wall, which gives the particle a new velocity at each impact.
    pub fn is_thermal(&self, scene: &Scene) -> bool {
        matches!(self.couple.other, Other::Wall(at) if scene.walls[at.wall as usize].thermal.is_some())
    }

    /// Applies the impulse to the velocities and spins in `particles`, and adds the impact to `log`. An impulse **J**
    /// of a wall also changes the work of gravity **g** until the end of the window, `remaining` [s] later, by
    /// **g**·**J** `remaining`; the log contains this change. Returns the velocity changes [m/s] of the first particle
    /// and of the second one (zero for a wall).
    pub fn resolve(
        &self,
        particles: &mut Particles,
        scene: &Scene,
        remaining: f64,
        log: &mut Log,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let masses = CollisionMasses::of(&self.couple, particles);
        let changes = self.apply_impulse(&masses, &mut ParticleAccess::Exclusive(particles), scene, remaining, log);
        particles.velocity[self.couple.i as usize] += changes.0;
        if let Some(j) = self.couple.j() {
            particles.velocity[j as usize] += changes.1;
        }
        changes
    }

    /// Returns the collision with a randomly inclined facet of a rough wall: the normal of the facet replaces that of
    /// the smooth wall. `None` if the second body is a particle or a smooth wall.
    fn on_facet(&self, particles: &Particles, scene: &Scene) -> Option<Self> {
        let Other::Wall(AtWall { wall, .. }) = self.couple.other else { return None };
        let roughness = scene.walls[wall as usize].roughness?;
        let surface = scene.surface(self.kinds.0, self.kinds.1);
        let impact = self.wall_approach(particles, wall);
        let restitution = |speed: f64| if self.elastic { 1.0 } else { surface.restitution_at(speed) };
        let normal = roughness.facet(&impact, restitution);
        let velocity = self.met.velocity;
        Some(Self { met: Encounter { normal, normal_velocity: velocity.dot(&normal), ..self.met }, ..*self })
    }

    /// [m/s] velocity, relative to the wall, with which the particle leaves a thermal wall (a wall that gives spheres
    /// the velocities of a gas). `None` if the other body is no thermal wall.
    fn thermal_rebound(&self, particles: &Particles, scene: &Scene) -> Option<Vector3<f64>> {
        let Other::Wall(AtWall { wall, .. }) = self.couple.other else { return None };
        Some(scene.walls[wall as usize].thermal?.rebound(&self.wall_approach(particles, wall)))
    }

    fn wall_approach(&self, particles: &Particles, wall: u32) -> WallApproach {
        let Encounter { velocity, normal, .. } = self.met;
        WallApproach { velocity, normal, id: particles.id[self.couple.i as usize], wall }
    }

    /// Adds the impact to `log`, and returns the velocity changes [m/s] of the first particle and of the second one
    /// (zero for a wall). The velocities in `particles` stay, but the spins of rotating spheres are changed there. An
    /// impulse **J** of a wall also changes the work of gravity **g** until the end of the window, `remaining` [s]
    /// later, by **g**·**J** `remaining`; the log contains this change.
    pub fn apply_impulse(
        &self,
        weights: &CollisionMasses,
        particles: &mut ParticleAccess,
        scene: &Scene,
        remaining: f64,
        log: &mut Log,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let facet = self.on_facet(particles, scene);
        let this = facet.as_ref().unwrap_or(self);
        let (velocity, normal) = (this.met.velocity, this.met.normal);
        let effective_mass = weights.effective();
        let of_kinds = scene.surface(this.kinds.0, this.kinds.1).at_speed(this.approach());
        let mut surface = of_kinds;
        let thermal = this.thermal_rebound(particles, scene);
        // the rebound from a thermal wall does not depend on the restitution
        if this.elastic && thermal.is_none() {
            let e = std::mem::replace(&mut surface.restitution, 1.0);
            log.ledger.contact_time_kept += 0.5 * effective_mass * this.approach().powi(2) * (1.0 - e * e);
        }
        let rotation = scene.rotation.as_ref().filter(|_| thermal.is_none());
        let rough = rotation.zip(particles.exclusive()).map(|(rotation, particles)| {
            let normal_impulse = (1.0 + surface.restitution) * effective_mass * this.approach();
            let numbers = (normal_impulse, effective_mass, weights.reach);
            this.rough_impulse(rotation, &of_kinds, numbers, particles)
        });
        let impulse = match (&thermal, &rough) {
            (Some(after), _) => (after - velocity) * effective_mass,
            (None, Some(rough)) => rough.impulse,
            (None, None) => impulse(&surface, effective_mass, &velocity, &normal),
        };
        let after = velocity + impulse / effective_mass;
        let (before_n, after_n) = (this.met.normal_velocity, after.dot(&normal));
        let slip_square = |u: &Vector3<f64>, n: f64| (u - normal * n).norm_squared();
        let restitution_loss = 0.5 * effective_mass * (before_n * before_n - after_n * after_n);
        let friction_loss = if let Some(rough) = &rough {
            log.ledger.friction.tangential_restitution += rough.tangential_restitution_loss;
            rough.friction_loss
        } else if surface.friction > 0.0 {
            0.5 * effective_mass * (slip_square(&velocity, before_n) - slip_square(&after, after_n))
        } else {
            0.0
        };
        let slip = rough.as_ref().map(|rough| rough.slip);
        let impact = Impact { rebound_speed: after_n, slip, ..this.impact(weights.diameter) };
        let ledger = &mut log.ledger;
        let (species, other) = this.kinds;
        log.impacts.push((Between::of(species, other), impact));
        let change_i = impulse / weights.mass;
        match weights.other {
            Some(other) => {
                ledger.pair_restitution_loss += restitution_loss;
                ledger.pair_friction_loss += friction_loss;
                ledger.shear_work += impulse.z * this.image;
                ledger.pair_virial += normal * (impulse * (weights.reach + this.met.gap)).transpose();
                (change_i, -impulse / other)
            }
            None => {
                match thermal {
                    Some(after) => {
                        ledger.thermostat_work +=
                            0.5 * effective_mass * (after.norm_squared() - velocity.norm_squared());
                    }
                    None => {
                        ledger.wall_restitution_loss += restitution_loss;
                        ledger.wall_friction_loss += friction_loss;
                    }
                }
                ledger.wall_work += this.wall.map_or(0.0, |wall| wall.power(&impulse, None));
                // `self` instead of `this`: the pressure on a rough wall follows from the normal of the smooth wall
                self.book_wall_impulse(&impulse, scene, remaining, ledger);
                (change_i, Vector3::zeros())
            }
        }
    }

    /// Entry of this collision in the statistics of impacts. Its rebound speed is 0 and must be set by the caller.
    /// `diameter` [m] is the smaller diameter of the two bodies.
    fn impact(&self, diameter: f64) -> Impact {
        let overlap = self.met.overlap().max(0.0) / diameter;
        Impact {
            normal_speed: -self.met.normal_velocity,
            rebound_speed: 0.0,
            duration: 0.0,
            first_overlap: overlap,
            maximum_overlap: overlap,
            overlap_time: 0.0,
            left_out: None,
            slip: None,
        }
    }

    /// Adds to the ledger (sums of energies and impulses of the run) the impulse [kg m/s] that a wall gives to the
    /// particle. Also adds the change of the work of gravity, **g**·`impulse` `remaining`, that this impulse causes
    /// until the end of the window, `remaining` [s] later.
    fn book_wall_impulse(&self, impulse: &Vector3<f64>, scene: &Scene, remaining: f64, ledger: &mut Ledger) {
        ledger.wall_impulse += impulse;
        ledger.wall_normal_impulse += impulse.dot(&self.met.normal);
        ledger.gravity_work += scene.gravity.dot(impulse) * remaining;
    }

    /// Velocity change [m/s] that gives a particle of `mass` [kg], which rests on a wall, the normal speed `speed`
    /// [m/s] away from the wall. The energy given to the particle is recorded as a negative loss. No impact is
    /// recorded, since the particle is at rest on the wall. The log also contains the change of the work of gravity by
    /// this impulse until the end of the window, `remaining` [s] later.
    pub fn hold_at_rest(&self, speed: f64, mass: f64, scene: &Scene, remaining: f64, log: &mut Log) -> Vector3<f64> {
        let before = self.met.normal_velocity;
        let change = self.met.normal * (speed - before);
        let impulse = change * mass;
        let ledger = &mut log.ledger;
        ledger.wall_restitution_loss -= 0.5 * mass * (speed * speed - before * before);
        ledger.wall_work += self.wall.map_or(0.0, |wall| impulse.dot(&wall.carried));
        self.book_wall_impulse(&impulse, scene, remaining, ledger);
        change
    }
}
