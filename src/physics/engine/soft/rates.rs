//! Powers and forces of contacts, as sums over contacts and means over a step. A window is the time between two
//! exchanges with the gas.

use super::contact::ContactForce;
use crate::encounter::Couple;
use crate::record::Log;
use crate::scene::Scene;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Sums over contacts: powers [W], forces of walls on particles [N], and the virial of pairs (sum of the products of
/// the vector between the centres and the force) [N m].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Rates {
    pub pair_restitution: f64,
    pub pair_friction: f64,
    pub wall_restitution: f64,
    pub wall_friction: f64,
    pub wall_work: f64,
    pub wall_force: Vector3<f64>,
    /// [N] first moment of `wall_force` about the middle of the step, divided by the squared length of the step.
    pub wall_force_moment: Vector3<f64>,
    pub wall_normal_force: f64,
    pub pair_virial: Matrix3<f64>,
    pub shear: f64,
}

impl std::ops::AddAssign for Rates {
    fn add_assign(&mut self, other: Self) {
        self.pair_restitution += other.pair_restitution;
        self.pair_friction += other.pair_friction;
        self.wall_restitution += other.wall_restitution;
        self.wall_friction += other.wall_friction;
        self.wall_work += other.wall_work;
        self.wall_force += other.wall_force;
        self.wall_force_moment += other.wall_force_moment;
        self.wall_normal_force += other.wall_normal_force;
        self.pair_virial += other.pair_virial;
        self.shear += other.shear;
    }
}

/// Sums over one step of a contact without friction. The normal of the contact is taken as constant during the step.
#[derive(Clone, Copy, Debug, Default)]
pub struct AlongNormal {
    /// [W] power dissipated by the dashpot, as a mean over the step.
    pub restitution_power: f64,
    /// [N] contact force along the normal, as a mean over the step.
    pub force: f64,
    /// [N] first moment of the force about the middle of the step, divided by the squared length of the step.
    pub force_moment: f64,
    /// [N m] normal force times the distance of the centres, as a mean over the step, for the virial of pairs.
    pub virial: f64,
}

impl Rates {
    /// Powers, force and virial of a contact without friction, from its sums over one step. `normal` points from the
    /// other body to particle i.
    pub fn along(couple: &Couple, normal: &Vector3<f64>, sums: &AlongNormal) -> Self {
        if couple.is_wall() {
            let (power, force) = (sums.restitution_power, sums.force);
            let wall_force = normal * force;
            let wall_force_moment = normal * sums.force_moment;
            Self { wall_restitution: power, wall_force, wall_force_moment, wall_normal_force: force, ..Self::default() }
        } else {
            let pair_virial = normal * normal.transpose() * sums.virial;
            Self { pair_restitution: sums.restitution_power, pair_virial, ..Self::default() }
        }
    }

    /// Adds powers and forces of a contact at one Runge-Kutta stage. `weight` [-] is the weight of the stage in the
    /// mean over the step. `moment` [-] is its weight in the first moment of the force about the middle of the step.
    #[inline]
    pub fn count(&mut self, couple: &Couple, force: &ContactForce, [weight, moment]: [f64; 2]) {
        if couple.is_wall() {
            self.wall_restitution += weight * force.restitution_power;
            self.wall_friction += weight * force.friction_power;
            self.wall_work += weight * force.wall_power;
            self.wall_force += force.on_i * weight;
            self.wall_force_moment += force.on_i * moment;
            self.wall_normal_force += weight * force.normal;
        } else {
            self.pair_restitution += weight * force.restitution_power;
            self.pair_friction += weight * force.friction_power;
            self.pair_virial += force.arm * (force.on_i * weight).transpose();
            self.shear += weight * force.shear_power;
        }
    }

    /// Records these powers and forces for a step of `time` [s], whose middle is `remaining` [s] before the end of the
    /// window.
    #[inline]
    pub fn add(&self, time: f64, remaining: f64, scene: &Scene, log: &mut Log) {
        let ledger = &mut log.ledger;
        ledger.pair_restitution_loss += self.pair_restitution * time;
        ledger.pair_friction_loss += self.pair_friction * time;
        ledger.wall_restitution_loss += self.wall_restitution * time;
        ledger.wall_friction_loss += self.wall_friction * time;
        ledger.wall_work += self.wall_work * time;
        ledger.pair_virial += self.pair_virial * time;
        ledger.shear_work += self.shear * time;
        let impulse = self.wall_force * time;
        ledger.wall_impulse += impulse;
        ledger.wall_normal_impulse += self.wall_normal_force * time;
        // Until the end of the window, gravity does work on the momentum that walls add. The first moment corrects for
        // momentum that is added late in the step.
        ledger.gravity_work += scene.gravity.dot(&(impulse * remaining - self.wall_force_moment * (time * time)));
    }
}
