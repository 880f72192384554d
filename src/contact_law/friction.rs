//! Tangential force of a contact: Coulomb's law without memory, the paper's rule for spheres that do not rotate.

use nalgebra::Vector3;

/// [N] magnitude of the Coulomb force against a slip of `slip` >= 0 [m/s]: μ|f_n| with the `friction` μ [-], but never
/// more than would stop the slip within `time_step` [s].
#[inline]
pub fn coulomb_limit(friction: f64, normal_force: f64, slip: f64, effective_mass: f64, time_step: f64) -> f64 {
    (friction * normal_force.abs()).min(effective_mass * slip / time_step)
}

/// Slip of two touching bodies, and what changes it within a time step besides friction.
#[derive(Clone, Copy, Debug)]
pub struct Slip {
    /// [m/s] velocity of particle i relative to the other surface, along the surface.
    pub velocity: Vector3<f64>,
    /// [m/s²] relative acceleration of the two along the surface by known forces other than friction.
    pub acceleration: Vector3<f64>,
}

/// Tangential force of a contact.
#[derive(Clone, Copy, Debug)]
pub struct Friction {
    /// [N] force on particle i is minus this.
    pub force: Vector3<f64>,
    /// [W] power that it takes out, `to_middle` after the instant of the slip.
    pub power: f64,
}

/// Force against the slip with which a step of `time_step` [s] would end. Against the slip of now it would come one
/// step late, and bodies at rest on a slope would creep. `to_middle` [s] is the time from the instant of the slip to
/// that at which its power is taken. `None` where nothing slips.
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
