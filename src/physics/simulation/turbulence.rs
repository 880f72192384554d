//! Kicks of drag in a turbulent gas. In a kick the velocity of each particle changes together with the fluctuation of
//! the gas velocity that the particle sees (that at its position). `docs/design/turbulence.md` gives the equations.
//! The kicks act between windows, which are the times between two exchanges with the gas.

use super::Simulation;
use crate::drag::Kick;
use crate::encounter::{AtWall, Couple, FrameTime};
use crate::exact::{self, BLOCK, ExactSum};
use crate::fluid::{EddyLaw, EddySeen, Fluid, LocalFractions, Profile, Turbulence};
use crate::noise::{Noise, NoiseUse};
use crate::particles::{CHUNK, Particles};
use crate::scene::Scene;
use crate::work_sharing;
use nalgebra::Vector3;

impl Simulation {
    /// Number of the kick (change of velocities by drag) that follows the latest completed window. The random numbers
    /// of the kick depend on this number. A half-kick for observers uses the same number, because that half-kick is
    /// undone before the kick itself.
    pub(super) fn number_of_kick(&self) -> u64 {
        2 * self.windows
    }

    /// Number of the half-kick (change of velocities by drag in half a window) before the next window, in a run whose
    /// previous window ended with a half-kick. The random numbers of the half-kick depend on this number.
    pub(super) fn number_of_first_half(&self) -> u64 {
        2 * self.windows + 1
    }
}

impl Simulation {
    /// Chooses at random the fluctuations of the gas velocity that new particles see, if the particles in the scene
    /// have such fluctuations.
    pub(super) fn draw_eddies_of(&self, fresh: &mut Particles) {
        let fluid = self.scene.fluid.as_ref().filter(|_| self.particles.eddies.is_some());
        if let Some((fluid, turbulence)) = fluid.and_then(|fluid| Some((fluid, fluid.turbulence.as_ref()?))) {
            draw_first_eddies(fresh, (fluid, turbulence), self.seed);
        }
    }
}

/// Chooses at random the fluctuation of the gas velocity that each particle sees at the start, unless particles have
/// one already. The stored value is the fluctuation divided by its standard deviation [-] for the Langevin equation,
/// and a velocity [m/s] for the discrete random walk.
pub(super) fn draw_first_eddies(particles: &mut Particles, (fluid, turbulence): (&Fluid, &Turbulence), seed: u64) {
    let Particles { eddies, id, position, .. } = particles;
    eddies.get_or_insert_with(|| {
        let mut noise = Noise::new(seed, NoiseUse::FirstEddies, 0);
        let draw = |(&id, position): (&u32, &Vector3<f64>)| {
            let drawn = noise.normals::<1>(id)[0];
            match turbulence.law {
                EddyLaw::Langevin => drawn,
                EddyLaw::Eddy => drawn * turbulence.at(&fluid.profile, position).deviation,
            }
        };
        id.iter().zip(position.iter()).map(draw).collect()
    });
}

/// Mirrors the fluctuations of the gas velocity at particles that a wall has reflected within the past `window` [s].
/// The component along the normal of the wall changes its sign. A particle counts as reflected if it has a gap to the
/// wall, but its free flight back in time leads into the wall.
pub(super) fn mirror_at_walls(particles: &mut Particles, scene: &Scene, window: f64) {
    let Some(mut eddies) = particles.eddies.take() else { return };
    let all = &*particles;
    let each = |(chunk, eddies): (usize, &mut [Vector3<f64>])| {
        for (index, eddy) in (chunk * CHUNK..).zip(eddies) {
            let speed = all.velocity[index].norm() + scene.gravity.norm() * window + scene.wall_speed();
            let reach = all.radius[index] + 2.0 * speed * window;
            for (number, wall) in (0..).zip(&scene.walls) {
                if wall.geometry.nearest(&all.position[index]).distance > reach {
                    continue;
                }
                for which in 0..wall.geometry.contacts() {
                    let couple = Couple::at_wall(index as u32, AtWall { wall: number, which });
                    let now = couple.meet(all, scene, FrameTime::default());
                    if now.gap >= 0.0 && couple.meet(all, scene, FrameTime::ahead(-window)).gap < 0.0 {
                        *eddy -= now.normal * (2.0 * eddy.dot(&now.normal));
                    }
                }
            }
        }
    };
    work_sharing::for_each(eddies.chunks_mut(CHUNK).enumerate(), each);
    particles.eddies = Some(eddies);
}

/// Kick of drag in a turbulent gas: change of the velocities of all particles during a time, at fixed positions.
pub(super) struct TurbulentKick<'a> {
    /// Profile of the mean velocity of the gas.
    pub profile: &'a Profile,
    /// Turbulence of the gas: statistics, and law of the fluctuations that particles see.
    pub turbulence: &'a Turbulence,
    /// Change of the velocities by drag alone in a gas of constant velocity, from which the kick in turbulence is
    /// computed.
    pub kick: &'a Kick,
    /// Local volume fractions of the particles; `None` if the drag law does not depend on them.
    pub fractions: Option<&'a LocalFractions>,
    /// Seed of the run, and number of the kick. They determine the random numbers of the kick.
    pub seed_and_number: (u64, u64),
}

/// Velocities [m/s] of one chunk of particles (successive particles that one thread treats), and the stored values of
/// the fluctuations of the gas velocity that these particles see.
type Moving<'a> = (&'a mut [Vector3<f64>], &'a mut [Vector3<f64>]);

impl TurbulentKick<'_> {
    /// Applies drag to all particles, and advances in time the fluctuations of the gas velocity at the particles.
    /// Returns sums over all particles: the impulse [kg m/s] of drag along x, y and z, and the work [J] of drag.
    pub fn apply(&self, particles: &mut Particles) -> [ExactSum; 4] {
        let Some(mut eddies) = particles.eddies.take() else { return exact::none() };
        let mut velocity = std::mem::take(&mut particles.velocity);
        let all = &*particles;
        let each = |(chunk, moving): (usize, Moving)| self.apply_to(all, chunk * CHUNK, moving);
        let chunks = velocity.chunks_mut(CHUNK).zip(eddies.chunks_mut(CHUNK)).enumerate();
        let sums = work_sharing::map(chunks, each).into_iter().fold(exact::none(), exact::merged);
        (particles.velocity, particles.eddies) = (velocity, Some(eddies));
        sums
    }

    /// Applies the kick to consecutive particles, the first of which has the index `first`. Returns the sums of
    /// [`apply`](Self::apply) over these particles.
    fn apply_to(&self, all: &Particles, first: usize, (velocity, eddies): Moving) -> [ExactSum; 4] {
        let (mut sums, mut rows) = (exact::none(), [[0.0; 4]; BLOCK]);
        let (seed, number) = self.seed_and_number;
        let mut noise = Noise::new(seed, NoiseUse::Eddies, number);
        let blocks = velocity.chunks_mut(BLOCK).zip(eddies.chunks_mut(BLOCK));
        for (start, (velocity, eddies)) in (first..).step_by(BLOCK).zip(blocks) {
            let rows = &mut rows[..velocity.len()];
            for (index, ((v, eddy), row)) in (start..).zip(velocity.iter_mut().zip(eddies).zip(&mut *rows)) {
                let change = self.change(all, index, (v, eddy), &mut noise);
                let mass = all.mass[index];
                *row = [change.x * mass, change.y * mass, change.z * mass, mass * change.dot(&(*v + 0.5 * change))];
                *v += change;
            }
            exact::add_rows(sums.each_mut(), rows);
        }
        sums
    }

    /// [m/s] change of the velocity `v` [m/s] of the particle at `index` in this kick. Also advances `eddy`, the
    /// fluctuation of the gas velocity that the particle sees.
    #[inline]
    fn change(
        &self,
        all: &Particles,
        index: usize,
        (v, eddy): (&Vector3<f64>, &mut Vector3<f64>),
        noise: &mut Noise,
    ) -> Vector3<f64> {
        let position = &all.position[index];
        let local = self.turbulence.at(self.profile, position);
        let velocity = v - Vector3::new(0.0, 0.0, self.profile.velocity_at(position));
        let ratio = |slip: Vector3<f64>| self.ratio(all, index, slip.norm_squared());
        // the share of the slip that remains is exp(-h/τ); for a long kick it is 0 up to rounding of the table
        let lost = ratio(velocity - self.turbulence.seen(eddy, &local)).max(-1.0);
        let (langevin, duration) = (&self.turbulence.langevin, self.kick.duration());
        let seen = EddySeen { fluctuation: *eddy, velocity, response: -duration / lost.ln_1p() };
        let id = all.id[index];
        let [end, mean] = match self.turbulence.law {
            EddyLaw::Langevin => langevin.advance(&seen, &local, duration, &noise.normals(id)),
            EddyLaw::Eddy => langevin.walk(&seen, &local, duration, noise.of(id)),
        };
        *eddy = end;
        let slip = velocity - self.turbulence.seen(&mean, &local);
        slip * ratio(slip)
    }

    /// [-] change of the slip velocity of the particle at `index` in this kick, divided by the slip velocity before
    /// the kick; at least -1 (rounding may make it slightly smaller). `square` [m²/s²] is the square of the magnitude
    /// of the slip velocity.
    #[inline]
    fn ratio(&self, all: &Particles, index: usize, square: f64) -> f64 {
        let (species, radius) = (all.species[index], all.radius[index]);
        match self.fractions {
            Some(fractions) => {
                self.kick.change_among(species, radius, fractions.at(&all.position[index], radius), square)
            }
            None => self.kick.change_of(species, radius, square),
        }
    }
}
