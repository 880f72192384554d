//! Gas flow in a channel or a pipe, changed by the particles in it (two-way coupling in one dimension).
//! `docs/design/coupling.md` gives the equations and the reasons. k [m²/s²] is the turbulent kinetic energy, ε [m²/s³]
//! its dissipation rate. In wall units, lengths are in units of ν/u_τ and velocities in units of u_τ, with the
//! kinematic viscosity ν and the friction velocity u_τ of the gas alone.

use super::half_channel::{HalfChannel, SweepStep};
use super::k_epsilon::{ChannelFlow, TurbulenceModel};
use super::turbulence::Langevin;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// [-] factor C_ε3: particles damp the dissipation rate ε at C_ε3 ε/k times the rate at which they damp the kinetic
/// energy k; Elghobashi and Abou-Arab 1983, Phys. Fluids 26, 931, and Simonin (1996).
const C_EPSILON_3: f64 = 1.2;
/// Smallest allowed turbulent kinetic energy k [u_τ²] and dissipation rate ε [u_τ⁴/ν], far below those of any
/// turbulent flow. These limits keep k/ε finite where particles have damped the turbulence.
const LEAST: f64 = 1e-12;

/// Settings of the two-way coupling, in which gas and particles change each other's momentum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coupling {
    /// Number of slices of equal width from the wall to the centre plane or the axis, for sums over particles.
    pub slices: usize,
    /// Quantity that is kept constant while the particles change the flow.
    pub held: HeldFlow,
    /// Effect of the particles on the turbulence of the gas.
    pub modulation: Modulation,
}

/// Quantity of a gas flow that is kept constant while the particles change the flow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeldFlow {
    /// Flow rate of the gas, which stays at its value at the start of the run.
    FlowRate,
    /// Pressure drop per length [Pa/m], without the hydrostatic part; positive if it drives the gas along +z.
    PressureGradient(f64),
}

/// Effect of the particles on the turbulence of the gas. The exchange rate is r = Σ(m/τ)/(ρ_f V_g), with the mass m and
/// response time τ of each particle, and the density ρ_f and volume V_g of the gas.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Modulation {
    /// Particles change the turbulence only through the mean velocity of the gas.
    None,
    /// Particles damp the kinetic energy k at the rate 2 r k St/(1 + St), with the exchange rate r, and ε at 1.2 ε/k
    /// times this rate (Simonin 1996). St is the response time τ over the integral time of the gas velocity that
    /// particles see. The covariance of gas and particle velocities is that of Tchen (1947), 2k/(1 + St).
    Simonin,
    /// Particles produce the kinetic energy k at the rate r s² by their mean slip s, with the exchange rate r. Then ε
    /// is k^(3/2)/l with 1/l = 1/l_0 + 1/λ. Here l_0 is the length k^(3/2)/ε of the gas alone, and λ the mean distance
    /// between the surfaces of neighbouring particles (Crowe 2000, Int. J. Multiphase Flow 26, 719; Kenning and Crowe
    /// 1997, ibid. 23, 403).
    Crowe,
}

/// Sums over the particles of one slice in a kick (change of the velocities by drag).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SliceSums {
    /// [kg m/s] momentum along z that the gas has given to the particles.
    pub impulse: f64,
    /// [m³] volume of the particles in the slice.
    pub volume: f64,
    /// [kg] mass of the particles in the slice.
    pub mass: f64,
    /// [kg/s] sum of m/τ over the particles of the slice, with the mass m and response time τ of each.
    pub exchange: f64,
    /// [-] number of particles in the slice.
    pub count: f64,
}

impl SliceSums {
    /// [m] mean distance between the surfaces of neighbouring particles in a slice of `volume` [m³]: edge of a cube
    /// with the volume per particle, minus the diameter of a sphere with the mean volume. It is at least a hundredth
    /// of this diameter, so that dissipation stays finite in a packing. It is infinite without particles.
    pub fn spacing(&self, volume: f64) -> f64 {
        /// [-] smallest distance between the surfaces of two particles, over their diameter; chosen for this program.
        const LEAST_SPACING: f64 = 0.01;
        if self.count == 0.0 {
            return f64::INFINITY;
        }
        let diameter = (6.0 / PI * self.volume / self.count).cbrt();
        ((volume / self.count).cbrt() - diameter).max(LEAST_SPACING * diameter)
    }
}

/// Gas flow that particles change: velocity, k and ε from the wall to the centre plane, at one instant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoadedFlow {
    coupling: Coupling,
    model: TurbulenceModel,
    /// Flow in wall units: the unit of velocity is the friction velocity of the gas without particles.
    channel: HalfChannel,
    /// [m] full width of the channel, or diameter of the pipe.
    height: f64,
    /// [m²/s] kinematic viscosity ν of the gas.
    kinematic_viscosity: f64,
    /// [kg/m³] density ρ_f of the gas.
    density: f64,
    /// [m²] area of all walls of the flow.
    wall_area: f64,
    /// [-] volume fraction of the gas in each cell; empty before the first step.
    gas_fraction: Vec<f64>,
    /// Flow rate of the gas at the start, per area of the wall, in wall units.
    flow_rate: f64,
    /// [m/s] bulk velocity of the gas alone over its flow rate in wall units, the sum over the cells. The bulk velocity
    /// also includes the flow between the wall and the first node, by the law of the wall.
    bulk_per_flow: f64,
    /// Pressure gradient in the latest step, in wall units; at first the given gradient, or that of the gas alone.
    pressure_gradient: f64,
    /// [kg m/s] momentum along z that lift has given to the particles of each slice since the latest step. In the next
    /// step the gas loses this momentum.
    owed: Vec<f64>,
    /// Lengths k^(3/2)/ε of the gas alone, one per cell in wall units, which only Crowe's modulation uses.
    alone_length: Vec<f64>,
    /// Constants by which Simonin's modulation computes the integral time of the gas velocity that particles see.
    langevin: Langevin,
    /// [kg m/s] momentum of the gas along z at the start, and its gains and losses since the start.
    pub balance: GasBalance,
}

/// Momentum of the gas along z: value at the start, and all gains and losses since then.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GasBalance {
    /// [kg m/s] momentum of the gas along z at the start of the run.
    pub start: f64,
    /// [kg m/s] momentum of the gas along z at present.
    pub now: f64,
    /// [kg m/s] momentum along z that the gas has gained from the pressure gradient since the start.
    pub by_pressure: f64,
    /// [kg m/s] momentum along z that the gas has lost by friction at the walls since the start.
    pub to_walls: f64,
    /// [kg m/s] momentum along z that the gas has lost to the particles since the start.
    pub to_particles: f64,
}

impl GasBalance {
    /// [kg m/s] present momentum of the gas along z that the start value, the gains and the losses do not explain.
    pub fn unexplained(&self) -> f64 {
        self.now - self.start - self.by_pressure + self.to_walls + self.to_particles
    }

    /// [-] unexplained momentum of the gas, divided by the largest magnitude among the five entries of the balance.
    pub fn unexplained_share(&self) -> f64 {
        let parts = [self.start, self.now, self.by_pressure, self.to_walls, self.to_particles];
        let largest = parts.into_iter().map(f64::abs).fold(0.0, f64::max);
        if largest > 0.0 { self.unexplained() / largest } else { 0.0 }
    }
}

impl LoadedFlow {
    /// Makes the flow of a gas alone, before particles act on it. `flow` is its steady solution, `density` [kg/m³] the
    /// density of the gas, and `wall_area` [m²] the area of the walls in the box.
    pub fn new(coupling: Coupling, flow: &ChannelFlow, density: f64, wall_area: f64) -> Self {
        let channel = flow.half_channel().clone();
        let mut loaded = Self {
            coupling,
            model: flow.model,
            height: flow.height,
            kinematic_viscosity: flow.kinematic_viscosity,
            density,
            wall_area,
            gas_fraction: Vec::new(),
            flow_rate: 0.0,
            bulk_per_flow: 0.0,
            pressure_gradient: 0.0,
            owed: vec![0.0; coupling.slices],
            alone_length: channel.k.iter().zip(&channel.epsilon).map(|(k, epsilon)| k.powf(1.5) / epsilon).collect(),
            langevin: Langevin::default(),
            balance: GasBalance::default(),
            channel,
        };
        loaded.bulk_per_flow = flow.bulk_velocity / loaded.gas_momentum();
        loaded.pressure_gradient = match coupling.held {
            HeldFlow::FlowRate => flow.pressure_gradient(density) / loaded.unit_gradient(),
            HeldFlow::PressureGradient(gradient) => gradient / loaded.unit_gradient(),
        };
        loaded.renew_stress();
        loaded
    }

    /// Replaces the default constants of the Langevin equation, which Simonin's modulation uses.
    pub fn with_langevin(self, langevin: Langevin) -> Self {
        Self { langevin, ..self }
    }

    /// Sets the volume fraction of the gas in each cell, and starts the momentum balance; called in the first step
    /// only.
    fn begin(&mut self, gas_fraction: Vec<f64>) {
        self.gas_fraction = gas_fraction;
        self.flow_rate = self.gas_momentum();
        let start = self.flow_rate * self.unit_impulse();
        self.balance = GasBalance { start, now: start, ..GasBalance::default() };
    }

    /// [m/s] unit of velocities: the friction velocity of the gas alone.
    fn unit_velocity(&self) -> f64 {
        self.channel.reynolds_tau * self.kinematic_viscosity / (0.5 * self.height)
    }

    /// [m] unit of lengths: ν/u_τ with the friction velocity u_τ of the gas alone.
    fn unit_length(&self) -> f64 {
        0.5 * self.height / self.channel.reynolds_tau
    }

    fn unit_time(&self) -> f64 {
        self.unit_length() / self.unit_velocity()
    }

    fn unit_gradient(&self) -> f64 {
        self.density * self.unit_velocity().powi(2) / self.unit_length()
    }

    /// [kg m/s] unit of momentum: that of a layer of gas along all walls, of unit thickness and unit velocity.
    fn unit_impulse(&self) -> f64 {
        self.density * self.wall_area * self.unit_length() * self.unit_velocity()
    }

    /// Index of the slice at the distance `depth` [m] from the wall; the slice at the wall has the index 0.
    #[inline]
    pub fn slice(&self, depth: f64) -> usize {
        let share = depth / (0.5 * self.height) * self.coupling.slices as f64;
        (share.max(0.0) as usize).min(self.coupling.slices - 1)
    }

    /// Number of slices between the wall and the centre plane or the axis.
    pub fn slices(&self) -> usize {
        self.coupling.slices
    }

    /// Settings of the coupling between gas and particles.
    pub fn coupling(&self) -> &Coupling {
        &self.coupling
    }

    /// [m³] volume of the slice with the index `slice`. In a channel, the equal slices at both walls count together.
    fn slice_volume(&self, slice: usize) -> f64 {
        let width = self.channel.reynolds_tau / self.coupling.slices as f64;
        let middle = (slice as f64 + 0.5) * width;
        self.channel.area(middle) * width * self.wall_area * self.unit_length()
    }

    /// Converts values from slices to cells of the solver: for each cell the mean of the values in the slices that it
    /// overlaps, weighted by volume.
    fn on_cells(&self, values: &[f64]) -> Vec<f64> {
        let width = self.channel.reynolds_tau / self.coupling.slices as f64;
        let cell = |ends: &[f64]| {
            let [start, end] = [ends[0], ends[1]];
            let first = ((start / width) as usize).min(self.coupling.slices - 1);
            let (mut sum, mut whole) = (0.0, 0.0);
            let begins_before = |slice: usize| (slice as f64) * width < end;
            for (slice, value) in (first..).zip(&values[first..]).take_while(|(slice, _)| begins_before(*slice)) {
                let low = start.max(slice as f64 * width);
                let high = if slice + 1 == self.coupling.slices { end } else { end.min((slice + 1) as f64 * width) };
                // by rounding, the first slice may end where the cell begins
                let volume = (high - low).max(0.0) * self.channel.area(0.5 * (low + high));
                (sum, whole) = (sum + volume * value, whole + volume);
            }
            sum / whole
        };
        self.channel.face.windows(2).map(cell).collect()
    }

    /// Stores momentum along z [kg m/s] that lift gave to the particles of each slice. In the next step the gas loses
    /// this momentum.
    pub fn owe(&mut self, impulses: impl IntoIterator<Item = f64>) {
        self.owed.iter_mut().zip(impulses).for_each(|(owed, impulse)| *owed += impulse);
    }

    /// Advances the gas by `duration` [s]. `slices` contains the sums over the particles of each slice for this time.
    /// The implicit Euler scheme for the velocity uses the k, ε and eddy viscosity of the previous step.
    pub fn advance(&mut self, duration: f64, slices: &[SliceSums]) {
        let per_volume = |of: &dyn Fn(usize, &SliceSums) -> f64| -> Vec<f64> {
            slices.iter().enumerate().map(|(slice, sums)| of(slice, sums) / self.slice_volume(slice)).collect()
        };
        let unit = self.density * self.unit_velocity();
        let taken = self.on_cells(&per_volume(&|slice, sums| (sums.impulse + self.owed[slice]) / unit));
        let fraction = self.on_cells(&per_volume(&|_, sums| sums.volume));
        let fraction: Vec<f64> = fraction.into_iter().map(|particles| 1.0 - particles).collect();
        if self.gas_fraction.is_empty() {
            self.begin(fraction.clone());
        }
        let damping = self.damping(duration, slices);
        let step = duration / self.unit_time();
        self.advance_velocity(step, &taken, fraction);
        self.renew_stress();
        let lengths = self.hybrid_lengths(slices);
        self.set_dissipation(&lengths);
        let produced = self.production(duration, slices);
        let damping = (damping.as_slice(), C_EPSILON_3);
        let turbulence = SweepStep { relaxation: 1.0, rate: 1.0 / step, damping, produced: &produced };
        self.model.sweep_turbulence(&mut self.channel, &turbulence);
        self.channel.k.iter_mut().chain(&mut self.channel.epsilon).for_each(|value| *value = value.max(LEAST));
        if !lengths.is_empty() {
            self.set_dissipation(&lengths);
            self.model.renew_viscosity(&mut self.channel);
        }
        let to_particles: f64 = slices.iter().zip(&self.owed).map(|(sums, owed)| sums.impulse + owed).sum();
        let pressed = self.pressure_gradient * self.volume() * step;
        let braked = self.channel.wall_stress() * self.gas_fraction[0] * step;
        let unit = self.unit_impulse();
        self.balance.to_particles += to_particles;
        self.balance.by_pressure += pressed * unit;
        self.balance.to_walls += braked * unit;
        self.balance.now = self.gas_momentum() * unit;
        self.owed.fill(0.0);
    }

    /// Volume of the gas and the particles in the flow per area of the wall, in wall units.
    fn volume(&self) -> f64 {
        (0..self.channel.u.len()).map(|cell| self.channel.volume(cell)).sum()
    }

    /// Momentum of the gas per wall area, in wall units; also its flow rate, as the density is 1 in these units.
    fn gas_momentum(&self) -> f64 {
        let fraction = |cell: usize| self.gas_fraction.get(cell).copied().unwrap_or(1.0);
        let cells = self.channel.u.iter().enumerate();
        cells.map(|(cell, u)| fraction(cell) * self.channel.volume(cell) * u).sum()
    }

    /// Computes the velocity of the gas after a time step of length `step`. `taken` is the momentum per volume that the
    /// gas loses in each cell, and `fraction` the new volume fraction of the gas. All in wall units.
    fn advance_velocity(&mut self, step: f64, taken: &[f64], fraction: Vec<f64>) {
        let channel = &self.channel;
        let count = channel.u.len();
        let volume: Vec<f64> = (0..count).map(|cell| channel.volume(cell)).collect();
        // where particles move away from the wall, gas moves towards the wall and carries its momentum along z with it
        let mut right = Vec::with_capacity(count);
        let mut inflow = 0.0;
        for cell in 0..count {
            let carried = |face: usize, inflow: f64| {
                let from = if inflow > 0.0 { face.min(count - 1) } else { face.saturating_sub(1) };
                inflow * channel.u[from]
            };
            let before = carried(cell, inflow);
            inflow += (fraction[cell] - self.gas_fraction[cell]) * volume[cell];
            let after = if cell + 1 < count { carried(cell + 1, inflow) } else { 0.0 };
            let own = self.gas_fraction[cell] * volume[cell] * channel.u[cell];
            right.push(own + after - before - taken[cell] * volume[cell]);
        }
        let conductance: Vec<f64> = (0..=count)
            .map(|face| match face {
                0 => step * fraction[0] / self.model.first_velocity_per_stress(channel),
                _ if face == count => 0.0,
                _ => {
                    let gas = 0.5 * (fraction[face - 1] + fraction[face]);
                    let distance = channel.y[face] - channel.y[face - 1];
                    step * gas * channel.area(channel.face[face]) * (1.0 + channel.face_nu_t(face)) / distance
                }
            })
            .collect();
        let inertia: Vec<f64> = fraction.iter().zip(&volume).map(|(fraction, volume)| fraction * volume).collect();
        let alone = diffused(&inertia, &conductance, &right);
        let pressed: Vec<f64> = volume.iter().map(|volume| step * volume).collect();
        let response = diffused(&inertia, &conductance, &pressed);
        let flow = |u: &[f64]| -> f64 { inertia.iter().zip(u).map(|(inertia, u)| inertia * u).sum() };
        self.pressure_gradient = match self.coupling.held {
            HeldFlow::FlowRate => (self.flow_rate - flow(&alone)) / flow(&response),
            HeldFlow::PressureGradient(gradient) => gradient / self.unit_gradient(),
        };
        self.channel.u = alone.iter().zip(&response).map(|(u, more)| u + self.pressure_gradient * more).collect();
        self.gas_fraction = fraction;
    }

    /// Computes the shear stress at all faces of the cells from the present velocity.
    fn renew_stress(&mut self) {
        let channel = &self.channel;
        let count = channel.u.len();
        let stress = (0..=count).map(|face| match face {
            0 => channel.u[0] / self.model.first_velocity_per_stress(channel),
            _ if face == count => 0.0,
            _ => {
                let slope = (channel.u[face] - channel.u[face - 1]) / (channel.y[face] - channel.y[face - 1]);
                (1.0 + channel.face_nu_t(face)) * slope
            }
        });
        self.channel.face_stress = Some(stress.collect());
    }

    /// Damping rate of the turbulent kinetic energy in each cell by Simonin's modulation, in wall units; otherwise 0.
    fn damping(&self, duration: f64, slices: &[SliceSums]) -> Vec<f64> {
        let count = self.channel.u.len();
        match self.coupling.modulation {
            Modulation::None | Modulation::Crowe => return vec![0.0; count],
            Modulation::Simonin => {}
        }
        let slice = |of: fn(&SliceSums, f64) -> f64| -> Vec<f64> {
            self.on_cells(&slices.iter().map(|sums| of(sums, duration)).collect::<Vec<_>>())
        };
        let rates = self.exchange_rates(slices);
        // slices without particles have the means 0; cells wholly within such slices have the rate 0, so the means do
        // not matter
        let response = slice(|sums, _| if sums.exchange > 0.0 { sums.mass / sums.exchange } else { 0.0 });
        let slip =
            slice(|sums, duration| if sums.exchange > 0.0 { sums.impulse / (sums.exchange * duration) } else { 0.0 });
        let langevin = &self.langevin;
        let (unit_time, unit_velocity) = (self.unit_time(), self.unit_velocity());
        (0..count)
            .map(|cell| {
                let (k, epsilon) = (self.channel.k[cell], self.channel.epsilon[cell]);
                let slip = slip[cell] / unit_velocity;
                let crossing = (1.0 + langevin.time_scale_ratio.powi(2) * slip * slip / (2.0 / 3.0 * k)).sqrt();
                let seen = langevin.share_of_turnover() * k / epsilon / crossing;
                let stokes = response[cell] / unit_time / seen;
                2.0 * rates[cell] * unit_time / self.gas_fraction[cell] * stokes / (1.0 + stokes)
            })
            .collect()
    }

    /// [1/s] exchange rate Σ(m/τ)/(ρ_f V) of each cell, with the mass m and response time τ of each particle, the
    /// density ρ_f of the gas, and the volume V of gas and particles.
    fn exchange_rates(&self, slices: &[SliceSums]) -> Vec<f64> {
        let slices = slices.iter().enumerate();
        let rates = slices.map(|(slice, sums)| sums.exchange / (self.density * self.slice_volume(slice)));
        self.on_cells(&rates.collect::<Vec<_>>())
    }

    /// Production r s² of the turbulent kinetic energy k by the mean slip s of the particles in each cell, in wall
    /// units, in a step of `duration` [s]. r is Σ(m/τ)/(ρ_f V_g), with the mass m and response time τ of each particle,
    /// and the density ρ_f and volume V_g of the gas. Empty unless the modulation is that of Crowe.
    fn production(&self, duration: f64, slices: &[SliceSums]) -> Vec<f64> {
        match self.coupling.modulation {
            Modulation::None | Modulation::Simonin => return Vec::new(),
            Modulation::Crowe => {}
        }
        let slip = |sums: &SliceSums| if sums.exchange > 0.0 { sums.impulse / (sums.exchange * duration) } else { 0.0 };
        let square: Vec<f64> = slices.iter().map(|sums| slip(sums).powi(2)).collect();
        let unit = self.unit_time() / self.unit_velocity().powi(2);
        let rates = self.exchange_rates(slices).into_iter().zip(self.on_cells(&square));
        rates.zip(&self.gas_fraction).map(|((rate, square), gas)| rate / gas * square * unit).collect()
    }

    /// Lengths l of the gas among the particles, by which the dissipation rate is ε = k^(3/2)/l, one per cell in wall
    /// units; empty unless the modulation is that of Crowe.
    fn hybrid_lengths(&self, slices: &[SliceSums]) -> Vec<f64> {
        match self.coupling.modulation {
            Modulation::None | Modulation::Simonin => return Vec::new(),
            Modulation::Crowe => {}
        }
        let inverse = |(slice, sums): (usize, &SliceSums)| self.unit_length() / sums.spacing(self.slice_volume(slice));
        let inverse = self.on_cells(&slices.iter().enumerate().map(inverse).collect::<Vec<_>>());
        self.alone_length.iter().zip(inverse).map(|(length, inverse)| 1.0 / (1.0 / length + inverse)).collect()
    }

    /// Sets the dissipation rate ε = k^(3/2)/l in every cell for lengths l in wall units, unless `lengths` is empty.
    fn set_dissipation(&mut self, lengths: &[f64]) {
        let cells = self.channel.epsilon.iter_mut().zip(&self.channel.k).zip(lengths);
        cells.for_each(|((epsilon, k), length)| *epsilon = k.powf(1.5) / length);
    }

    /// [m³] volume of the gas and the particles in the flow.
    pub fn box_volume(&self) -> f64 {
        self.volume() * self.wall_area * self.unit_length()
    }

    /// [Pa/m] pressure drop per length in the latest step, without the hydrostatic part.
    pub fn pressure_gradient(&self) -> f64 {
        self.pressure_gradient * self.unit_gradient()
    }

    /// [m/s] bulk velocity of the gas: its flow rate over the cross-section.
    pub fn bulk_velocity(&self) -> f64 {
        self.gas_momentum() * self.bulk_per_flow
    }

    /// [m/s] friction velocity; negative if the stress at the wall drives the gas along +z.
    pub fn friction_velocity(&self) -> f64 {
        let stress = self.channel.wall_stress();
        stress.signum() * stress.abs().sqrt() * self.unit_velocity()
    }

    /// Flow at the present time, from which a velocity profile can be made.
    ///
    /// # Errors
    /// A velocity that is not finite.
    pub fn flow(&self) -> Result<ChannelFlow, String> {
        ChannelFlow::of(&self.channel, self.model, [self.height, self.kinematic_viscosity, self.bulk_velocity()])
    }
}

/// Solves inertia[i] u[i] = right[i] + inflow for the velocity u[i] of each cell i (Thomas' algorithm). The inflow is
/// the flux through face i minus that through face i + 1. The flux is conductance[i] (u[i - 1] - u[i]); face 0 is at
/// the wall, where u = 0.
fn diffused(inertia: &[f64], conductance: &[f64], right: &[f64]) -> Vec<f64> {
    let count = inertia.len();
    let (mut upper, mut u) = (vec![0.0; count], vec![0.0; count]);
    for cell in 0..count {
        let lower = if cell > 0 { conductance[cell] } else { 0.0 };
        let diagonal = inertia[cell] + conductance[cell] + conductance[cell + 1];
        let (before_upper, before) = if cell > 0 { (upper[cell - 1], u[cell - 1]) } else { (0.0, 0.0) };
        let pivot = diagonal - lower * before_upper;
        upper[cell] = conductance[cell + 1] / pivot;
        u[cell] = (right[cell] + lower * before) / pivot;
    }
    for cell in (0..count.saturating_sub(1)).rev() {
        u[cell] += upper[cell] * u[cell + 1];
    }
    u
}
