//! Lift and torque of the gas on a sphere. Lift is a force perpendicular to the slip velocity of the sphere; its cause
//! is shear of the gas or spin of the sphere.
//!
//! The slip velocity s is the velocity of the gas relative to the sphere. During a kick (change of the velocities by
//! lift in a given time) the gas and the spin are taken as constant. Then s turns about a fixed axis without a change
//! of length. This solution is exact.

use nalgebra::{Rotation3, Vector3};
use serde::Serialize;
use std::f64::consts::PI;

/// Lift forces that a gas exerts on the particles: those by shear, those by spin, or both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Lift {
    /// True if sheared gas causes lift, after Saffman (1965) and Mei (1992).
    pub shear: bool,
    /// True if spin causes lift (Magnus force), after Rubinow and Keller (1961) and Oesterlé and Bui Dinh (1998). The
    /// gas then also exerts a torque, after Dennis, Singh and Ingham (1980).
    pub spin: bool,
}

/// Properties of a sphere and of the gas around it on which lift depends.
#[derive(Clone, Copy, Debug)]
pub struct LiftedSphere {
    /// [kg/m³] density of the gas.
    pub gas_density: f64,
    /// [m²/s] kinematic viscosity of the gas.
    pub kinematic_viscosity: f64,
    /// [m] diameter d of the sphere.
    pub diameter: f64,
    /// [kg] mass of the sphere plus its added mass (mass of gas that accelerates with the sphere).
    pub mass: f64,
    /// [kg m²] moment of inertia of the sphere about its centre.
    pub inertia: f64,
}

/// [-] factor of Saffman's force, written as a lift coefficient: 1.615 · 8/π (Saffman 1965 with the correction of
/// 1968).
const SAFFMAN: f64 = 4.1126;

/// [-] slip Reynolds number up to which the first of two formulas for the lift by shear applies (Mei 1992, Int. J.
/// Multiphase Flow 18, 145).
const MEI_LIMIT: f64 = 40.0;

/// [-] Reynolds number Re_r = Ω d²/ν of spin, with the angular velocity Ω of the gas relative to the sphere, up to
/// which the torque coefficient is that of creeping flow, 64π/Re_r.
const CREEPING_SPIN: f64 = 32.0;

/// [-] numbers in the coefficient 12.9/√Re_r + 128.4/Re_r of the torque at Reynolds numbers Re_r of spin above 32
/// (Dennis, Singh and Ingham 1980, J. Fluid Mech. 101, 257).
const TORQUE: [f64; 2] = [12.9, 128.4];

impl LiftedSphere {
    /// [-] Reynolds number w d/ν of a speed w = `speed` [m/s], with the diameter d of the sphere.
    fn reynolds(&self, speed: f64) -> f64 {
        speed * self.diameter / self.kinematic_viscosity
    }

    /// [-] Reynolds number Ω d²/ν of an angular velocity Ω = `rate` [rad/s], with the diameter d of the sphere.
    fn reynolds_of_turn(&self, rate: f64) -> f64 {
        self.reynolds(rate * self.diameter)
    }

    /// [-] factor k of the acceleration k s × ω of the sphere by lift in sheared gas. Here s is the slip velocity and ω
    /// the vorticity of the gas; `slip` [m/s] > 0 and `vorticity` [1/s] > 0 are the magnitudes of s and ω.
    fn shear(&self, slip: f64, vorticity: f64) -> f64 {
        let (re, re_shear) = (self.reynolds(slip), self.reynolds_of_turn(vorticity));
        let root = (0.5 * re_shear / re).sqrt();
        let mei = if re <= MEI_LIMIT {
            (1.0 - 0.3314 * root) * (-0.1 * re).exp() + 0.3314 * root
        } else {
            0.0524 * (0.5 * re_shear).sqrt()
        };
        let coefficient = SAFFMAN / re_shear.sqrt() * mei;
        PI / 8.0 * self.gas_density * self.diameter.powi(3) * coefficient / self.mass
    }

    /// [-] factor k of the acceleration k Ω × s of the sphere by its spin. Here s is the slip velocity. Ω = ω/2 - ω_p
    /// is the angular velocity of the gas relative to the sphere, with the vorticity ω of the gas and the spin ω_p.
    /// `slip` [m/s] > 0 and `turn` [rad/s] > 0 are the magnitudes of s and Ω.
    fn magnus(&self, slip: f64, turn: f64) -> f64 {
        let (re, re_turn) = (self.reynolds(slip), self.reynolds_of_turn(turn));
        let coefficient = 0.45 + (re_turn / re - 0.45) * (-0.05684 * re_turn.powf(0.4) * re.powf(0.3)).exp();
        PI / 8.0 * self.gas_density * self.diameter.powi(2) * coefficient * slip / (turn * self.mass)
    }

    /// [-] angular velocity of the gas relative to the sphere after `duration` [s] of torque alone, over its initial
    /// magnitude `turn` [rad/s]. The torque is ρ_f/2 (d/2)⁵ C |Ω| Ω, with this angular velocity Ω and a coefficient C.
    /// The equation has a closed-form solution for each of the two formulas for C.
    fn spin_left(&self, turn: f64, duration: f64) -> f64 {
        let re_turn = self.reynolds_of_turn(turn);
        let scale = 0.5 * self.gas_density * (0.5 * self.diameter).powi(5) / self.inertia;
        let per_rate = self.kinematic_viscosity / self.diameter.powi(2);
        let creeping = 64.0 * PI * scale * per_rate;
        if re_turn <= CREEPING_SPIN {
            return (-creeping * duration).exp();
        }
        // with the start value Ω_0, the equation dΩ/dt = -a Ω^(3/2) - b Ω has the solution
        // Ω^(-1/2) = (Ω_0^(-1/2) + a/b) exp(b t/2) - a/b
        let (a, b) = (TORQUE[0] * scale * per_rate.sqrt(), TORQUE[1] * scale * per_rate);
        let start = turn.powf(-0.5);
        let limit = (CREEPING_SPIN * per_rate).powf(-0.5);
        let until = 2.0 / b * ((limit + a / b) / (start + a / b)).ln();
        if until < duration {
            return CREEPING_SPIN / re_turn * (-creeping * (duration - until)).exp();
        }
        let left = (start + a / b) * (0.5 * b * duration).exp() - a / b;
        (start / left).powi(2)
    }
}

impl Lift {
    /// Slip velocity [m/s] after `duration` [s] of lift alone, in a gas with the given vorticity [1/s]. `slip` [m/s] is
    /// the slip velocity before. `spin` [rad/s] is the spin of the sphere; `None` if spheres do not rotate.
    pub fn turned(
        &self,
        sphere: &LiftedSphere,
        slip: Vector3<f64>,
        (vorticity, spin): (Vector3<f64>, Option<Vector3<f64>>),
        duration: f64,
    ) -> Vector3<f64> {
        let speed = slip.norm();
        let mut rate = Vector3::zeros();
        if self.shear && speed > 0.0 && vorticity != Vector3::zeros() {
            rate += vorticity * sphere.shear(speed, vorticity.norm());
        }
        let turn = spin.map_or_else(Vector3::zeros, |spin| 0.5 * vorticity - spin);
        if self.spin && speed > 0.0 && turn != Vector3::zeros() {
            rate -= turn * sphere.magnus(speed, turn.norm());
        }
        // with the velocity v of the sphere, and the factors k_S by shear and k_M by spin:
        // ds/dt = -dv/dt = -k_S s × ω - k_M Ω × s = (k_S ω - k_M Ω) × s
        Rotation3::from_scaled_axis(rate * duration) * slip
    }

    /// Spin [rad/s] after `duration` [s] of torque alone, in a gas with the given vorticity [1/s]. `spin` [rad/s] is
    /// the spin before.
    pub fn spun(
        &self,
        sphere: &LiftedSphere,
        spin: Vector3<f64>,
        vorticity: Vector3<f64>,
        duration: f64,
    ) -> Vector3<f64> {
        let turn = 0.5 * vorticity - spin;
        if !self.spin || turn == Vector3::zeros() {
            return spin;
        }
        0.5 * vorticity - turn * sphere.spin_left(turn.norm(), duration)
    }
}
