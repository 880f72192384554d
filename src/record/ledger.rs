//! The energy and momentum ledger.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Running totals since the start of the run.
///
/// Balance: kinetic + elastic energy now = at the start + drag_work + gravity_work + wall_work - dissipated. What is left is the
/// residual: rounding for hard spheres, the integrator's own gain or loss for soft ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// [J] work done by drag on the particles.
    pub drag_work: f64,
    /// [J] work done by gravity.
    pub gravity_work: f64,
    /// [J] work done by walls whose surface moves along itself.
    pub wall_work: f64,
    /// [J] lost to restitution (dashpot) between particles, >= 0.
    pub pair_restitution_loss: f64,
    /// [J] lost to friction between particles, >= 0.
    pub pair_friction_loss: f64,
    /// [J] lost to restitution (dashpot) at walls, >= 0 but for the TC model: what a wall gives to spheres that start to rest on
    /// it, m a_n² t_c²/32 each, is taken off.
    pub wall_restitution_loss: f64,
    /// [J] lost to friction at walls, >= 0.
    pub wall_friction_loss: f64,
    /// [J] what restitution would have taken from the collisions that the TC model made elastic, >= 0. It stays with the
    /// particles, so it is no part of the balance.
    pub contact_time_kept: f64,
    /// [kg m/s] momentum given to the particles by drag.
    pub drag_impulse: Vector3<f64>,
    /// [kg m/s] momentum given to the particles by gravity.
    pub gravity_impulse: Vector3<f64>,
    /// [kg m/s] momentum given to the particles by walls.
    pub wall_impulse: Vector3<f64>,
    /// [kg m/s] magnitude of the wall impulses along the walls' normals, summed over impacts.
    pub wall_normal_impulse: f64,
    /// [J s] Σ r f over pairs of particles in touch, over time: r from one centre to the other, f the force between them; at a collision
    /// the impulse. Rows belong to r.
    pub pair_virial: Matrix3<f64>,
}

impl Ledger {
    /// [J] everything impacts took out of the particles.
    pub fn dissipated(&self) -> f64 {
        self.pair_restitution_loss + self.pair_friction_loss + self.wall_restitution_loss + self.wall_friction_loss
    }

    /// [J] energy that went through: at the start [J], by drag, gravity and moving walls, each in magnitude.
    pub fn through(&self, energy_at_start: f64) -> f64 {
        energy_at_start.abs() + self.drag_work.abs() + self.gravity_work.abs() + self.wall_work.abs()
    }

    /// [J] what the balance leaves unexplained, given kinetic plus elastic energy at the start and now [J].
    pub fn residual(&self, energy_at_start: f64, energy_now: f64) -> f64 {
        energy_now - energy_at_start - self.drag_work - self.gravity_work - self.wall_work + self.dissipated()
    }
}

impl std::ops::AddAssign for Ledger {
    fn add_assign(&mut self, other: Self) {
        self.drag_work += other.drag_work;
        self.gravity_work += other.gravity_work;
        self.wall_work += other.wall_work;
        self.pair_restitution_loss += other.pair_restitution_loss;
        self.pair_friction_loss += other.pair_friction_loss;
        self.wall_restitution_loss += other.wall_restitution_loss;
        self.wall_friction_loss += other.wall_friction_loss;
        self.contact_time_kept += other.contact_time_kept;
        self.drag_impulse += other.drag_impulse;
        self.gravity_impulse += other.gravity_impulse;
        self.wall_impulse += other.wall_impulse;
        self.wall_normal_impulse += other.wall_normal_impulse;
        self.pair_virial += other.pair_virial;
    }
}
