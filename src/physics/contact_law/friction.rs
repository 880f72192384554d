//! Tangential force of a contact by Coulomb's law without memory. The paper that docs/paper.md describes uses this rule
//! for spheres that do not rotate.

use nalgebra::Vector3;

/// [N] magnitude of the Coulomb force: μ |f_n|, but at most the force that stops the slip within `time_step` [s].
/// `friction` is μ [-], `normal_force` f_n [N], `slip` >= 0 [m/s] the magnitude of the slip, and `effective_mass` [kg]
/// the mass that the force decelerates.
#[inline]
pub fn coulomb_limit(friction: f64, normal_force: f64, slip: f64, effective_mass: f64, time_step: f64) -> f64 {
    (friction * normal_force.abs()).min(effective_mass * slip / time_step)
}

/// Slip of two touching bodies, and the rate at which forces other than friction change it.
#[derive(Clone, Copy, Debug)]
pub struct Slip {
    /// [m/s] velocity of particle i (the first of the two bodies) relative to the surface of the other body, along the
    /// surface.
    pub velocity: Vector3<f64>,
    /// [m/s²] relative acceleration of the two surfaces, along the surface, by all forces other than friction.
    pub acceleration: Vector3<f64>,
}

/// Tangential force of friction between two touching bodies, and its power.
#[derive(Clone, Copy, Debug)]
pub struct Friction {
    /// [N] friction force on the other body; the force on particle i is its negative.
    pub force: Vector3<f64>,
    /// [W] rate at which friction reduces the kinetic energy, at the instant that is `to_middle` [s] (an argument of
    /// [`coulomb`]) after the instant of the slip.
    pub power: f64,
}

/// Friction force against the slip that the bodies would have, without friction, at the end of a step of `time_step`
/// [s]. A force against the present slip would act one step late, and bodies would creep down a slope. `to_middle` [s]
/// is the time from now to the instant for which the power is computed. `friction`, `normal_force` and `effective_mass`
/// are those of [`coulomb_limit`]. `None` if the friction force is zero.
#[inline(always)]
pub fn coulomb(
    friction: f64,
    normal_force: f64,
    slip: &Slip,
    effective_mass: f64,
    [time_step, to_middle]: [f64; 2],
) -> Option<Friction> {
    let at_end = slip.velocity + slip.acceleration * time_step;
    let speed = at_end.norm();
    let magnitude = coulomb_limit(friction, normal_force, speed, effective_mass, time_step);
    (magnitude > 0.0).then(|| {
        let force = at_end * (magnitude / speed);
        let in_the_middle = slip.velocity + (slip.acceleration - force / effective_mass) * to_middle;
        Friction { force, power: force.dot(&in_the_middle) }
    })
}
