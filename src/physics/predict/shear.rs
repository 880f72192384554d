//! Soft spheres in a sheared box: ratios of time scales, and the difference of the stress from that of hard spheres.
//!
//! Otsuki, Hayakawa and Luding (2010, Prog. Theor. Phys. Suppl. 184, 110) describe sheared soft disks by ratios of time
//! scales. According to their abstract the dissipation rate over the shear rate distinguishes near-rigid disks, which
//! collide, from soft disks with several contacts at once. The ratios of this module combine the shear rate γ, the
//! collision rate ω, the dissipation rate and the contact time.

use super::gas::Gas;
use super::recommendation::plain;
use crate::contact_law::ContactLaw;
use crate::scene::Scene;
use serde::Serialize;

/// [-] largest relative difference of the shear stress from that of hard spheres, over the share T_c ω of the time in
/// which a particle is in contact. T_c is the contact time, and ω the collision rate of a particle. Measured for smooth
/// spheres of restitution 0.7 and 0.9 with linear springs: 0.36 to 0.43 at a volume fraction of 0.3, less at 0.5
/// (docs/design/shear.md, "Soft or hard").
const STRESS_CHANGE: f64 = 0.4;

/// [-] largest share of the time in contact for which the difference of the stress is taken as proportional to this
/// share. This was the largest share in the measurements of [`STRESS_CHANGE`] at a volume fraction of 0.3.
const LONGEST: f64 = 0.5;

/// Predictions for soft spheres in a sheared box: ratios of time scales, and the difference of the shear stress from
/// that of hard spheres.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShearPrediction {
    /// [1/s] shear rate γ of the box.
    pub shear_rate: f64,
    /// [-] contact time times shear rate, T_c γ. For linear springs of the stiffness k without a dashpot, between
    /// spheres of the mass m, the stiffness number k/(m γ²) is π²/2 over the square of this ratio.
    pub contact_over_shear: f64,
    /// [-] rate at which collisions reduce the granular temperature, over this temperature and over the shear rate. In
    /// steady shear of hard spheres this ratio is a function of volume fraction and restitution alone.
    pub dissipation_over_shear: f64,
    /// [-] largest expected relative difference of the shear stress from that of hard spheres; `None` if contacts last
    /// so long that the difference is no longer proportional to their duration.
    pub largest_stress_change: Option<f64>,
    /// Smallest parameter of the contact law with which the shear stress differs from that of hard spheres by no more
    /// than the error that the plan allows. The text contains the value and its unit.
    pub hard_from: String,
}

/// [-] factor by which the elastic constant of `law` must increase so that the shear stress differs from that of hard
/// spheres by no more than the relative error `error` [-]. `in_contact` [-] is the share of the time in which a
/// particle is in contact.
pub fn stiffening_in_shear(law: &ContactLaw, in_contact: f64, error: f64) -> f64 {
    law.stiffening(STRESS_CHANGE * in_contact / error)
}

/// Predictions for the spheres of a sheared box under the contact law `law`. `contact_time` [s] is the duration of a
/// contact, and `error` [-] the relative error that the plan allows. `None` without shear.
pub fn shear(scene: &Scene, gas: &Gas, law: &ContactLaw, [contact_time, error]: [f64; 2]) -> Option<ShearPrediction> {
    let rate = scene.domain.shear?.rate.abs();
    let restitution = scene.restitution_of_pairs().unwrap_or(scene.contact.restitution);
    let in_contact = gas.collision_rate * contact_time;
    let hard = law.stiffened(stiffening_in_shear(law, in_contact, error)).parameter();
    Some(ShearPrediction {
        shear_rate: rate,
        contact_over_shear: contact_time * rate,
        // a collision takes the energy (1 - e²) m T on average, from two particles with 3/2 m T each
        dissipation_over_shear: gas.collision_rate * (1.0 - restitution * restitution) / 3.0 / rate,
        largest_stress_change: (in_contact <= LONGEST).then_some(STRESS_CHANGE * in_contact),
        hard_from: format!("{} {}", plain(hard.value, 3), hard.unit),
    })
}
