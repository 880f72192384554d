//! Drag of a sphere among other spheres, which depends on the volume fraction of particles around it.
//!
//! Let w be the slip velocity: the velocity of the gas between the particles relative to the sphere. Let ε = 1 - φ be
//! the volume fraction of the gas. Two forces of the gas act on a sphere in a suspension: friction, and the pressure
//! gradient of the flow past all particles. Their sum is the friction divided by ε. The gas is given in this program,
//! so no other part of the program computes this pressure gradient. A law in this file therefore gives the sum of both
//! forces, 3π μ d w F, with the dynamic viscosity μ and the diameter d of the sphere. F is the usual dimensionless
//! drag force: the friction divided by 3π μ d ε w. The Reynolds number is Re = ε w d/ν, with the kinematic viscosity
//! ν.

use super::{DragLaw, SchillerNaumann, Sphere, flow};

/// [-] largest volume fraction at which a drag law is evaluated: that of the densest packing of equal spheres, π/√18.
/// The fraction computed in a small cell can be larger; it is then replaced by this value.
const DENSEST: f64 = 0.740_480_489_693_061_1;
/// [-] time step in the integration of a kick (change of the velocities by drag in a given time), divided by the
/// response time. The Runge-Kutta method of fourth order then has a relative error of at most 0.02⁴/120 = 1.3e-9.
const STEP: f64 = 0.02;
/// Largest number of Runge-Kutta steps in a kick. A kick that needs more is integrated with adaptive steps instead.
const MOST_STEPS: f64 = 10.0;

/// Law for the drag of spheres in a suspension, from experiments or from simulations that resolve the flow between the
/// spheres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SuspensionLaw {
    /// Wen and Yu 1966: from experiments on fluidised beds.
    WenYu,
    /// Gidaspow 1994: Ergun's law of packed beds for ε < 0.8, and the law of Wen and Yu otherwise.
    Gidaspow,
    /// Beetstra, van der Hoef and Kuipers 2007: from lattice-Boltzmann simulations.
    Beetstra,
    /// Tenneti, Garg and Subramaniam 2011: from simulations with immersed boundaries.
    Tenneti,
    /// Di Felice 1994: from experiments on sedimentation and fluidisation.
    DiFelice,
}

/// Drag in a suspension, with the grid of cells in which the volume fraction of the particles is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SuspensionDrag {
    /// Law of the drag of a sphere among other spheres.
    pub law: SuspensionLaw,
    /// Numbers of cells along x, y and z that divide the box into equal cells.
    pub cells: [u32; 3],
}

/// [-] drag of a single sphere over Stokes drag, C_D Re/24, at the Reynolds number `re`, by Schiller and Naumann.
fn single(re: f64) -> f64 {
    1.0 / SchillerNaumann.response_time(&Sphere { stokes_time: 1.0, reynolds_per_speed: 1.0, fraction: 0.0 }, re)
}

impl SuspensionLaw {
    /// All drag laws for suspensions.
    pub const ALL: [Self; 5] = [Self::WenYu, Self::Gidaspow, Self::Beetstra, Self::Tenneti, Self::DiFelice];

    /// [-] dimensionless drag force F: drag over the Stokes drag 3π μ d w at the slip speed w. `phi` is the volume
    /// fraction of particles, and `re` the Reynolds number ε w d/ν, with the volume fraction ε = 1 - `phi` of the gas.
    pub fn force(self, phi: f64, re: f64) -> f64 {
        let e = 1.0 - phi;
        match self {
            // constants of MFIX, model/drag_gs.f (`WEN_YU`): C_D of Schiller and Naumann, exponent -2.65 of the
            // friction
            Self::WenYu => single(re) * e.powf(-3.65),
            // constants 150 and 1.75 of Ergun, switch at ε = 0.8: phasicFlow, ErgunWenYu.hpp
            Self::Gidaspow if e < 0.8 => (150.0 * phi + 1.75 * re) / (18.0 * e * e),
            Self::Gidaspow => Self::WenYu.force(phi, re),
            // constants of MFIX, drag_gs_mod.f (`DRAG_BVK`), and of OpenFOAM, Beetstra.C
            Self::Beetstra => {
                let creeping = 10.0 * phi / (e * e) + e * e * (1.0 + 1.5 * phi.sqrt());
                if re == 0.0 {
                    return creeping;
                }
                let inertia = (1.0 / e + 3.0 * e * phi + 8.4 * re.powf(-0.343))
                    / (1.0 + 10.0_f64.powf(3.0 * phi) * re.powf(-0.5 * (1.0 + 4.0 * phi)));
                creeping + 0.413 * re / (24.0 * e * e) * inertia
            }
            // constants of OpenFOAM, Tenneti.C; the force there contains the mean pressure gradient, so F is ε times
            // that force
            Self::Tenneti => {
                let still = 5.81 * phi / e.powi(3) + 0.48 * phi.cbrt() / e.powi(4);
                let inertia = phi.powi(3) * re * (0.95 + 0.61 * phi.powi(3) / (e * e));
                e * (single(re) / e.powi(3) + still + inertia)
            }
            // constants of phasicFlow, DiFeliceGrain.hpp: C_D of Dalla Valle and the exponent of Di Felice
            Self::DiFelice => {
                let drag = (0.63 * re.sqrt() + 4.8).powi(2) / 24.0;
                let exponent = 3.7 - 0.65 * (-0.5 * (1.5 - re.log10()).powi(2)).exp();
                drag * e.powf(-exponent)
            }
        }
    }

    /// Name of the drag law in cases.
    fn name(self) -> &'static str {
        match self {
            Self::WenYu => "wen_yu",
            Self::Gidaspow => "gidaspow",
            Self::Beetstra => "beetstra",
            Self::Tenneti => "tenneti",
            Self::DiFelice => "di_felice",
        }
    }

    /// Authors and year of the publication of the drag law.
    fn source(self) -> &'static str {
        match self {
            Self::WenYu => "Wen and Yu (1966)",
            Self::Gidaspow => "Gidaspow (1994)",
            Self::Beetstra => "Beetstra et al. (2007)",
            Self::Tenneti => "Tenneti et al. (2011)",
            Self::DiFelice => "Di Felice (1994)",
        }
    }
}

impl DragLaw for SuspensionDrag {
    fn name(&self) -> &'static str {
        self.law.name()
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        let [x, y, z] = self.cells.map(f64::from);
        vec![("cells_x", x), ("cells_y", y), ("cells_z", z)]
    }

    fn title(&self) -> String {
        let [x, y, z] = self.cells;
        format!("drag in suspensions by {}, volume fractions in {x} x {y} x {z} cells", self.law.source())
    }

    fn cells(&self) -> Option<[u32; 3]> {
        Some(self.cells)
    }

    fn response_time(&self, sphere: &Sphere, slip: f64) -> f64 {
        let phi = sphere.fraction.min(DENSEST);
        sphere.stokes_time / self.law.force(phi, (1.0 - phi) * sphere.reynolds_per_speed * slip)
    }

    fn log_decay(&self, sphere: &Sphere, slip: f64, duration: f64) -> f64 {
        // with L = ln(w/w_0), dL/dt = -1/τ(w_0 e^L)
        let rate = |log: f64| -1.0 / self.response_time(sphere, slip * log.exp());
        let first = rate(0.0);
        let steps = (-first * duration / STEP).ceil().max(1.0);
        if steps.is_nan() || steps > MOST_STEPS {
            return flow::integrate(&rate, duration);
        }
        let h = duration / steps;
        let (mut log, mut a) = (0.0, first);
        for _ in 0..steps as usize {
            let b = rate(log + 0.5 * h * a);
            let c = rate(log + 0.5 * h * b);
            let d = rate(log + h * c);
            log += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
            a = rate(log);
        }
        log
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integration of short kicks by Runge-Kutta steps agrees with `flow::integrate`, which is accurate to 1e-12.
    #[test]
    fn short_kicks_agree_with_adaptive_ones() {
        for law in SuspensionLaw::ALL {
            let drag = SuspensionDrag { law, cells: [1; 3] };
            for fraction in [0.0, 0.01, 0.3, 0.6] {
                let sphere = Sphere { stokes_time: 0.5, reynolds_per_speed: 27.0, fraction };
                for slip in [0.0, 1e-3, 1.0, 20.0] {
                    let duration = 0.15 * drag.response_time(&sphere, slip);
                    let rate = |log: f64| -1.0 / drag.response_time(&sphere, slip * log.exp());
                    let (short, exact) = (drag.log_decay(&sphere, slip, duration), flow::integrate(&rate, duration));
                    assert!((short / exact - 1.0).abs() < 2e-9, "{law:?}, {fraction}, {slip}: {short} {exact}");
                }
            }
        }
    }
}
