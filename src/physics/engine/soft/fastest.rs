//! Bounds on the speeds of particles in uniform steps. They show how long a neighbour list stays complete. A window is
//! the time between two exchanges with the gas.

use super::SoftSolver;
use super::force_buffer::kick_all;
use crate::domain::Domain;
use crate::particles::Particles;

/// [m/s] upper limits of the speeds of particles and walls in uniform steps.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::engine) struct Fastest {
    /// [m/s] upper limit of the speed of any particle, relative to the moving frame in which the neighbour list
    /// measures motion.
    pub(in crate::engine) all: f64,
    /// [m/s] largest speed of any point of a wall whose shape moves.
    pub(super) of_walls: f64,
    /// [m/s] largest speed that any particle had just after contact forces were applied to it. It is relative to the
    /// moving frame in which the neighbour list measures motion.
    pub(super) pushed: f64,
}

impl Fastest {
    /// Raises the limits `all` and `pushed` to the speed `now` [m/s] that a particle had after a force was applied.
    pub(super) fn rise(&mut self, now: f64) {
        (self.all, self.pushed) = (self.all.max(now), self.pushed.max(now));
    }
}

impl SoftSolver {
    /// Changes the velocities by the forces of the last evaluation: v += a `dt`, with the acceleration a and the time
    /// `dt` [s]. Changes the spins by the torques, and raises the limits of speeds.
    pub(super) fn kick(&mut self, particles: &mut Particles, domain: &Domain, dt: f64) {
        let mass = self.alike.as_ref().map(|alike| alike.mass);
        let pushed = kick_all(&self.pushes, (particles, mass), dt, self.list.frame());
        // in a sheared box, particles without contact force also change their speed relative to the mean flow
        let in_flow = |_| particles.largest_speed_in(self.list.frame(), domain);
        self.speed.rise(domain.shear.map_or(pushed, in_flow));
    }

    /// [m/s] upper limit of the speed with which a particle approaches a wall. Two particles of the neighbour list
    /// approach each other with at most twice this speed. Gravity since the beginning of the window is not included.
    pub(super) fn closing_speed(&self, particles: &Particles, domain: &Domain) -> f64 {
        self.speed.all + self.list.strain(particles, domain) + self.speed.of_walls
    }
}
