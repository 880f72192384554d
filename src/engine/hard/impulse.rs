//! The instantaneous impulse.

use crate::particles::Particles;
use crate::record::{Impact, Log};
use crate::scene::{Scene, Surface};
use nalgebra::Vector3;

/// Impulse on body i [kg m/s] from a body it approaches, without rotation:
/// J_n = (1+e) M |u_n| along the normal, J_t = min(μ J_n, M |u_t|) against the slip (design of the paper's rule, Eq. 4
/// and the Coulomb law below it).
///
/// `velocity` is u_i - u_j [m/s], `normal` points from j to i, `effective_mass` M [kg] (a wall's partner: its own mass).
pub fn impulse(surface: &Surface, effective_mass: f64, velocity: &Vector3<f64>, normal: &Vector3<f64>) -> Vector3<f64> {
    let normal_velocity = velocity.dot(normal);
    let along = -(1.0 + surface.restitution) * effective_mass * normal_velocity;
    let slip = velocity - normal * normal_velocity;
    let slip_speed = slip.norm();
    let mut impulse = normal * along;
    if surface.friction > 0.0 && slip_speed > 0.0 {
        let against = (surface.friction * along).min(effective_mass * slip_speed);
        impulse -= slip * (against / slip_speed);
    }
    impulse
}

/// Two bodies at the instant of their collision.
#[derive(Clone, Copy, Debug)]
pub struct Collision {
    /// Place of one particle.
    pub i: usize,
    /// Place of the other, or `None` and the index of the wall.
    pub other: Other,
    /// From the other body to `i`.
    pub normal: Vector3<f64>,
    /// [m/s] velocity of `i` relative to the other.
    pub velocity: Vector3<f64>,
    /// [m] overlap at this instant: rounding for events, what a step left for the stepped engine.
    pub overlap: f64,
    /// Whether it takes no energy along the normal, whatever the surfaces say: the TC model (Luding and McNamara 1998,
    /// Granular Matter 1, 113) makes a collision so that comes sooner than a contact lasts after another of its partners.
    pub elastic: bool,
}

/// The body that particle `i` meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Other {
    /// Place of a particle.
    Particle(usize),
    /// Index of a wall.
    Wall(usize),
}

impl Collision {
    fn surface<'s>(&self, scene: &'s Scene) -> &'s Surface {
        match self.other {
            Other::Particle(_) => &scene.contact,
            Other::Wall(wall) => &scene.walls[wall].surface,
        }
    }

    /// Whether it takes energy along the normal: what does not can go on for ever without a collapse.
    pub fn loses(&self, scene: &Scene) -> bool {
        !self.elastic && self.surface(scene).restitution < 1.0
    }

    /// Applies the impulse and books it; `remaining` [s] of the window are left. Returns the velocity changes of `i` and
    /// of the other particle (zero for a wall) [m/s].
    pub fn resolve(
        &self,
        particles: &mut Particles,
        scene: &Scene,
        remaining: f64,
        log: &mut Log,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let mass = particles.mass[self.i];
        let (effective_mass, diameter) = match self.other {
            Other::Particle(j) => {
                let m = 1.0 / (1.0 / mass + 1.0 / particles.mass[j]);
                (m, 2.0 * particles.radius[self.i].min(particles.radius[j]))
            }
            Other::Wall(_) => (mass, 2.0 * particles.radius[self.i]),
        };
        let mut surface = *self.surface(scene);
        if self.elastic {
            let e = std::mem::replace(&mut surface.restitution, 1.0);
            let speed = self.velocity.dot(&self.normal);
            log.ledger.contact_time_kept += 0.5 * effective_mass * speed * speed * (1.0 - e * e);
        }
        let impulse = impulse(&surface, effective_mass, &self.velocity, &self.normal);
        let after = self.velocity + impulse / effective_mass;
        let (before_n, after_n) = (self.velocity.dot(&self.normal), after.dot(&self.normal));
        let slip_square = |u: &Vector3<f64>, n: f64| (u - self.normal * n).norm_squared();
        let restitution_loss = 0.5 * effective_mass * (before_n * before_n - after_n * after_n);
        let friction_loss = if surface.friction > 0.0 {
            0.5 * effective_mass * (slip_square(&self.velocity, before_n) - slip_square(&after, after_n))
        } else {
            0.0
        };
        let overlap = self.overlap.max(0.0) / diameter;
        let impact = Impact {
            normal_speed: -before_n,
            rebound_speed: after_n,
            duration: 0.0,
            first_overlap: overlap,
            maximum_overlap: overlap,
            overlap_time: 0.0,
        };
        let change_i = impulse / mass;
        particles.velocity[self.i] += change_i;
        let ledger = &mut log.ledger;
        match self.other {
            Other::Particle(j) => {
                log.impacts.push((false, impact));
                ledger.pair_restitution_loss += restitution_loss;
                ledger.pair_friction_loss += friction_loss;
                let change_j = -impulse / particles.mass[j];
                particles.velocity[j] += change_j;
                (change_i, change_j)
            }
            Other::Wall(_) => {
                log.impacts.push((true, impact));
                ledger.wall_restitution_loss += restitution_loss;
                ledger.wall_friction_loss += friction_loss;
                ledger.wall_impulse += impulse;
                ledger.wall_normal_impulse += impulse.dot(&self.normal);
                // what walls add to the momentum, gravity works on for the rest of the window
                ledger.gravity_work += scene.gravity.dot(&impulse) * remaining;
                (change_i, Vector3::zeros())
            }
        }
    }
    /// Gives `i` the normal `speed` [m/s] away from a wall that it rests on, and books it: the energy as a loss below zero. It
    /// is no impact, as nothing approaches. `remaining` [s] of the window are left. Returns velocity changes as
    /// [`resolve`](Self::resolve) [m/s].
    pub fn lift(
        &self,
        speed: f64,
        particles: &mut Particles,
        scene: &Scene,
        remaining: f64,
        log: &mut Log,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let mass = particles.mass[self.i];
        let before = self.velocity.dot(&self.normal);
        let change = self.normal * (speed - before);
        let impulse = change * mass;
        particles.velocity[self.i] += change;
        let ledger = &mut log.ledger;
        ledger.wall_restitution_loss -= 0.5 * mass * (speed * speed - before * before);
        ledger.wall_impulse += impulse;
        ledger.wall_normal_impulse += impulse.dot(&self.normal);
        // as at an impact
        ledger.gravity_work += scene.gravity.dot(&impulse) * remaining;
        (change, Vector3::zeros())
    }
}
