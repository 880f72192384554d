//! Kicks of lift: the gas turns the slip velocity of each particle and changes its spin. The positions do not change.
//! Kicks act before and after a window, the time between two exchanges with the gas.

use super::Simulation;
use crate::exact::{self, ExactSum};
use crate::fluid::{Fluid, Lift, LiftedSphere};
use crate::particles::{CHUNK, Particles};
use crate::record::Ledger;
use crate::work_sharing;
use nalgebra::Vector3;

/// Place of a kick of lift (change of velocities and spins at fixed positions): before or after a window. Before a
/// window the torque acts first, after a window the force acts first. Both kicks together then have an error of second
/// order in the window.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum LiftKick {
    BeforeWindow,
    AfterWindow,
}

/// Result of a kick of lift for one particle: new velocity [m/s], new spin [rad/s] (`None` if it does not rotate), and
/// four numbers. The numbers are the impulse [kg m/s] along x, y and z and the work [J].
type Lifted = (Vector3<f64>, Option<Vector3<f64>>, [f64; 4]);

impl Simulation {
    /// Applies a kick of lift to all particles for `duration` [s], without any motion. `kick` is the place of this
    /// kick: before or after a window. The order of force and torque depends on this place.
    pub(super) fn lift(&mut self, duration: f64, kick: LiftKick) {
        let Some((fluid, lift)) = self.scene.fluid.as_ref().and_then(|fluid| Some((fluid, fluid.lift?))) else {
            return;
        };
        let began = self.clock.now();
        let before = self.slice_sums(None);
        let sums = apply(&mut self.particles, (fluid, lift), duration, kick);
        self.owe_lift(before);
        self.book_kick(sums, |drag_impulse, drag_work| Ledger { drag_impulse, drag_work, ..Ledger::default() });
        self.spent.drag += self.clock.now() - began;
    }
}

/// Applies a kick of lift over `duration` [s] to all particles. Returns sums over all particles: impulse [kg m/s] along
/// x, y and z, and work [J].
fn apply(particles: &mut Particles, gas: (&Fluid, Lift), duration: f64, kick: LiftKick) -> [ExactSum; 4] {
    let indices: Vec<usize> = (0..particles.len()).collect();
    let one = |indices: &[usize]| -> Vec<Lifted> {
        indices.iter().map(|&index| lifted(particles, index, gas, duration, kick)).collect()
    };
    let all = work_sharing::map(indices.chunks(CHUNK), one);
    let all: Vec<Lifted> = all.into_iter().flatten().collect();
    for (index, (velocity, spin, _)) in all.iter().enumerate() {
        particles.velocity[index] = *velocity;
        if let (Some(spins), Some(spin)) = (&mut particles.spin, spin) {
            spins[index] = *spin;
        }
    }
    exact::sums(all.len(), |index| all[index].2)
}

/// Computes a kick of lift over `duration` [s] for the particle at `index`, which itself is not changed.
fn lifted(particles: &Particles, index: usize, (fluid, lift): (&Fluid, Lift), duration: f64, kick: LiftKick) -> Lifted {
    let (position, velocity) = (&particles.position[index], particles.velocity[index]);
    let (mass, inertia) = (particles.mass[index], particles.inertia.as_ref().map_or(0.0, |inertia| inertia[index]));
    let sphere = LiftedSphere {
        gas_density: fluid.density,
        kinematic_viscosity: fluid.kinematic_viscosity,
        diameter: 2.0 * particles.radius[index],
        mass,
        inertia,
    };
    let vorticity = fluid.profile.vorticity_at(position);
    let before = particles.spin.as_ref().map(|spins| spins[index]);
    let spun = before.map(|spin| lift.spun(&sphere, spin, vorticity, duration));
    // before a window the torque acts first
    let during = if kick == LiftKick::BeforeWindow { spun } else { before };
    let mean = Vector3::new(0.0, 0.0, fluid.profile.velocity_at(position));
    let seen = fluid.turbulence.as_ref().zip(particles.eddies.as_ref());
    let gas = seen.map_or(mean, |(turbulence, eddies)| {
        mean + turbulence.seen(&eddies[index], &turbulence.at(&fluid.profile, position))
    });
    let slip = gas - velocity;
    let change = slip - lift.turned(&sphere, slip, (vorticity, during), duration);
    let rotational = |spin: Option<Vector3<f64>>| 0.5 * inertia * spin.map_or(0.0, |spin| spin.norm_squared());
    let work = mass * change.dot(&(velocity + 0.5 * change)) + rotational(spun) - rotational(before);
    (velocity + change, spun, [mass * change.x, mass * change.y, mass * change.z, work])
}
