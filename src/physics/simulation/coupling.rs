//! Two-way coupling: the gas loses the momentum that a kick (change of velocities by drag at fixed positions) gives to
//! the particles, and its velocity profile is computed again. A window is the time between two kicks.

use super::Simulation;
use crate::domain::Domain;
use crate::drag::Kick;
use crate::engine::Failure;
use crate::fluid::{Fluid, LoadedFlow, LocalFractions, Modulation, Profile, SliceSums, TurbulenceStatistics};
use std::f64::consts::PI;

/// Makes the gas flow on which the particles act, as it is at the start; `None` if the particles do not change the gas
/// of the scene.
pub(super) fn flow_at_start(fluid: &Fluid, domain: &Domain) -> Option<LoadedFlow> {
    let (coupling, flow) = (fluid.coupling?, fluid.profile.channel_flow()?);
    let wall_area = match &fluid.profile {
        Profile::Pipe(pipe) => 2.0 * PI * pipe.radius() * domain.size.z,
        Profile::Uniform(_) | Profile::Tabulated(_) | Profile::Channel(_) | Profile::LogLaw(_) => {
            2.0 * domain.size.x * domain.size.z
        }
    };
    let langevin = fluid.turbulence.as_ref().map(|turbulence| turbulence.langevin).unwrap_or_default();
    Some(LoadedFlow::new(coupling, flow, fluid.density, wall_area).with_langevin(langevin))
}

impl Simulation {
    /// Gas flow on which the particles act; `None` if the particles do not change the gas of the scene.
    pub fn loaded_flow(&self) -> Option<&LoadedFlow> {
        self.loaded_flow.as_deref()
    }

    /// Sums over the particles in each slice of the gas (layer at equal distance from the wall), before or after a
    /// kick. The field `impulse` is the momentum [kg m/s] of the particles along z. The field `exchange` is the sum of
    /// m/τ [kg/s], with the mass m of each particle and its response time τ in `kick`. It is 0 without `kick`, or if
    /// the particles do not change the turbulence. `None` if the particles do not change the gas.
    pub(super) fn slice_sums(&self, kick: Option<(&Kick, Option<&LocalFractions>)>) -> Option<Vec<SliceSums>> {
        let (flow, fluid) = (self.loaded_flow()?, self.scene.fluid.as_ref()?);
        let kick = kick.filter(|_| flow.coupling().modulation != Modulation::None);
        let particles = &self.particles;
        let sums = self.sample().sums_in_groups(flow.slices(), |index| {
            let (position, velocity, radius) =
                (&particles.position[index], particles.velocity[index], particles.radius[index]);
            let mass = particles.mass[index];
            let exchange = kick.map_or(0.0, |(kick, fractions)| {
                let mut slip = velocity;
                slip.z -= fluid.profile.velocity_at(position);
                let (species, square) = (particles.species[index], slip.norm_squared());
                let ratio = match fractions {
                    Some(fractions) => kick.change_among(species, radius, fractions.at(position, radius), square),
                    None => kick.change_of(species, radius, square),
                };
                // the share of the slip that remains after a duration h is exp(-h/τ)
                -mass * ratio.max(-1.0 + f64::EPSILON).ln_1p() / kick.duration()
            });
            let volume = 4.0 / 3.0 * PI * radius.powi(3);
            (flow.slice(fluid.profile.depth(position).0), [mass * velocity.z, volume, mass, exchange, 1.0])
        });
        let slice =
            |[impulse, volume, mass, exchange, count]: [f64; 5]| SliceSums { impulse, volume, mass, exchange, count };
        Some(sums.into_iter().map(slice).collect())
    }

    /// Takes from the gas the momentum that a kick has given to the particles, and advances the gas by the `duration`
    /// [s] of the kick. `before` are the [`slice_sums`](Self::slice_sums) before the kick; with `None` this method
    /// does nothing.
    pub(super) fn advance_gas(&mut self, before: Option<Vec<SliceSums>>, duration: f64) {
        let Some((before, after)) = before.zip(self.slice_sums(None)) else { return };
        let given = before.iter().zip(&after).map(|(before, after)| after.impulse - before.impulse);
        let sums: Vec<_> = before.iter().zip(given).map(|(sums, impulse)| SliceSums { impulse, ..*sums }).collect();
        if let Some(flow) = &mut self.loaded_flow {
            flow.advance(duration, &sums);
        }
        self.renew_profile();
    }

    /// Records the momentum along z that lift has given to the particles; the gas loses it in the next drag kick.
    /// `before` are the [`slice_sums`](Self::slice_sums) before the kick of lift; with `None` this method does
    /// nothing.
    pub(super) fn owe_lift(&mut self, before: Option<Vec<SliceSums>>) {
        let Some((before, after)) = before.zip(self.slice_sums(None)) else { return };
        if let Some(flow) = &mut self.loaded_flow {
            flow.owe(before.iter().zip(&after).map(|(before, after)| after.impulse - before.impulse));
        }
    }

    /// Replaces the gas flow on which the particles act by `flow`, and makes the velocity profile from `flow`. Does
    /// nothing with `None`.
    pub(super) fn take_gas(&mut self, flow: Option<Box<LoadedFlow>>) {
        if flow.is_some() && flow != self.loaded_flow {
            self.loaded_flow = flow;
            self.renew_profile();
        }
    }

    /// Makes the velocity profile and the turbulence of the gas from the present flow. If the flow is not finite, the
    /// next window returns a failure.
    pub(super) fn renew_profile(&mut self) {
        let (Some(flow), Some(fluid)) = (&self.loaded_flow, &mut self.scene.fluid) else { return };
        let renewed = flow.flow().and_then(|flow| {
            if let Some(turbulence) = &mut fluid.turbulence {
                turbulence.statistics = TurbulenceStatistics::of(&flow)?;
            }
            fluid.profile = fluid.profile.with_flow(flow)?;
            Ok(())
        });
        if let Err(why) = renewed {
            self.refused = Some(Failure::Gas { time: self.time, why });
        }
    }
}
