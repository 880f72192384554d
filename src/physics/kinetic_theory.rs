//! Closed forms of the kinetic theory of hard spheres that engines, measurements and predictions share.

use std::f64::consts::PI;

/// [-] contact value of spheres with the diameters a and b [m]: their collision rate over that of a dilute gas (Enskog
/// factor). The mixture has the volume fraction φ and the `second_moment` ξ_2 = π/6 Σ n_i d_i² [1/m]. The sum is over
/// the components, with their number densities n_i and diameters d_i (Boublík 1970, J. Chem. Phys. 53, 471; Mansoori,
/// Carnahan, Starling and Leland 1971, J. Chem. Phys. 54, 1523). For equal spheres the value is that of Carnahan and
/// Starling, (1 - φ/2)/(1 - φ)³.
pub fn contact_value(a: f64, b: f64, volume_fraction: f64, second_moment: f64) -> f64 {
    let free = 1.0 - volume_fraction;
    let ratio = a * b / (a + b) * second_moment;
    1.0 / free + 3.0 * ratio / (free * free) + 2.0 * ratio * ratio / (free * free * free)
}

/// [-] leading Sonine coefficient a₂ of a homogeneous gas of smooth spheres that cools, with the `restitution` e. It
/// measures the deviation of the velocity distribution from a Maxwellian. Its value is 16 (1 - e)(1 - 2e²)/(81 - 17 e +
/// 30 e² (1 - e)) (van Noije and Ernst 1998, Granular Matter 1, 57). The formula comes from equations linear in a₂. For
/// e above 0.6 the result differs from simulations by some per cent.
pub fn cooling_a2(restitution: f64) -> f64 {
    let (e, square) = (restitution, restitution * restitution);
    // numbers of van Noije and Ernst 1998 in three dimensions
    16.0 * (1.0 - e) * (1.0 - 2.0 * square) / (81.0 - 17.0 * e + 30.0 * square * (1.0 - e))
}

/// [-] leading Sonine coefficient a₂ of a homogeneous gas of smooth spheres with random accelerations, with the
/// `restitution` e. It measures the deviation of the velocity distribution from a Maxwellian. Its value is 16 (1 -
/// e)(1 - 2e²)/(241 - 177 e + 30 e² (1 - e)) (van Noije and Ernst 1998, Granular Matter 1, 57). The formula comes from
/// equations linear in a₂.
pub fn heated_a2(restitution: f64) -> f64 {
    let (e, square) = (restitution, restitution * restitution);
    // numbers of van Noije and Ernst 1998 in three dimensions
    16.0 * (1.0 - e) * (1.0 - 2.0 * square) / (241.0 - 177.0 * e + 30.0 * square * (1.0 - e))
}

/// [m²/s] coefficient of self-diffusion of elastic hard spheres by Enskog's theory, in the first approximation: 3/(8 n
/// d² χ) sqrt(T/π). n is the `density` [1/m³], d the `diameter` [m] and T the granular `temperature` [m²/s²]. χ is the
/// contact value, which is the Enskog factor (Chapman and Cowling 1970, The Mathematical Theory of Non-Uniform Gases,
/// sections 14.2 and 16.6). The exact value of a dilute gas is 1.9 % larger than this approximation.
pub fn enskog_self_diffusion(density: f64, diameter: f64, temperature: f64, contact_value: f64) -> f64 {
    3.0 / (8.0 * density * diameter * diameter * contact_value) * (temperature / PI).sqrt()
}

/// [-] structure factor at the wave number k = 0 of hard spheres with the volume fraction φ: (1 - φ)⁴/(1 + 4φ + 4φ² -
/// 4φ³ + φ⁴). It is the isothermal compressibility over that of an ideal gas, by the equation of state of Carnahan and
/// Starling (1969, J. Chem. Phys. 51, 635).
pub fn compressibility(volume_fraction: f64) -> f64 {
    let phi = volume_fraction;
    // numbers of Carnahan and Starling 1969, from the derivative of φ Z
    (1.0 - phi).powi(4) / (1.0 + 4.0 * phi + 4.0 * phi * phi - 4.0 * phi.powi(3) + phi.powi(4))
}

/// [-] structure factor S of hard spheres by the Percus-Yevick equation. `q` is the wave number times the diameter, and
/// φ the volume fraction. 1/S = 1 + 24 φ ∫ x² sin(qx)/(qx) (λ₁ + 6 φ λ₂ x + φ λ₁ x³/2) dx over the distance x in
/// diameters, from 0 to 1. Here λ₁ = (1 + 2φ)²/(1 - φ)⁴ and λ₂ = -(1 + φ/2)²/(1 - φ)⁴ (Wertheim 1963, Phys. Rev. Lett.
/// 10, 321; Hansen and McDonald 2013, Theory of Simple Liquids, section 4.4).
pub fn percus_yevick(q: f64, volume_fraction: f64) -> f64 {
    let phi = volume_fraction;
    let free = (1.0 - phi).powi(4);
    let (first, second) = ((1.0 + 2.0 * phi).powi(2) / free, -(1.0 + 0.5 * phi).powi(2) / free);
    let (sin, cos) = q.sin_cos();
    // integrals of x^n sin(qx)/q over x from 0 to 1, with n = 1, 2 and 4, by parts
    let of_one = (sin - q * cos) / q.powi(3);
    let of_two = (2.0 * q * sin - (q * q - 2.0) * cos - 2.0) / q.powi(4);
    let of_four = ((4.0 * q.powi(3) - 24.0 * q) * sin - (q.powi(4) - 12.0 * q * q + 24.0) * cos + 24.0) / q.powi(6);
    let core = first * of_one + 6.0 * phi * second * of_two + 0.5 * phi * first * of_four;
    1.0 / (1.0 + 24.0 * phi * core)
}

/// Transport coefficients of a gas of smooth hard spheres, as ratios without a unit. The ratios contain the collision
/// frequency ν_0 = (16/5) n d² sqrt(π T) of a dilute gas, with the number density n, the diameter d and the granular
/// temperature T.
///
/// The coefficients are those of Garzó and Dufty (1999, Phys. Rev. E 59, 5895): first order in the gradients, first
/// Sonine polynomial, contact value of Carnahan and Starling. The theory assumes velocities of neighbours without
/// correlation. At a restitution of 1 the viscosity is that of Enskog (Chapman and Cowling 1970, section 16.6) in the
/// first approximation. In a dilute gas the exact viscosity is 1.6 % larger than this approximation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GasTransport {
    /// [-] shear viscosity divided by ρ T/ν_0, with the mass density ρ and the granular temperature T of the gas, and
    /// the collision frequency ν_0 of a dilute gas.
    pub viscosity: f64,
    /// [-] relative rate at which collisions reduce the granular temperature, divided by the collision frequency ν_0 of
    /// a dilute gas; 0 for elastic spheres.
    pub cooling_rate: f64,
}

impl GasTransport {
    /// Coefficients of a gas with a volume fraction and a restitution, both [-].
    pub fn of(volume_fraction: f64, restitution: f64) -> Self {
        let (phi, e) = (volume_fraction, restitution);
        let chi = contact_value(1.0, 1.0, phi, phi);
        // numbers and symbols of Garzó and Dufty 1999; their c* is twice a₂
        let c = 2.0 * cooling_a2(e);
        let cooling_rate = 5.0 / 12.0 * chi * (1.0 - e * e) * (1.0 + 3.0 / 32.0 * c);
        let frequency = chi * (1.0 - 0.25 * (1.0 - e).powi(2)) * (1.0 - c / 64.0);
        let kinetic = (1.0 - 0.4 * (1.0 + e) * (1.0 - 3.0 * e) * phi * chi) / (frequency - 0.5 * cooling_rate);
        let bulk = 384.0 / (25.0 * PI) * phi * phi * chi * (1.0 + e) * (1.0 - c / 32.0);
        Self { viscosity: kinetic * (1.0 + 0.8 * phi * chi * (1.0 + e)) + bulk, cooling_rate }
    }

    /// [-] shear rate over ν_0 in steady simple shear, in which the work of the stress equals the loss of energy in
    /// collisions: sqrt(3 ζ/(2 η)). Here ζ is the `cooling_rate`, η the `viscosity`, and ν_0 the collision frequency of
    /// a dilute gas.
    pub fn steady_shear_rate(&self) -> f64 {
        (1.5 * self.cooling_rate / self.viscosity).sqrt()
    }
}

/// [1/s] collision frequency ν_0 = (16/5) n d² sqrt(π T) of a dilute gas, with the number `density` n [1/m³], the
/// `diameter` d [m] and the granular `temperature` T [m²/s²] (Garzó and Dufty 1999, Phys. Rev. E 59, 5895).
pub fn collision_frequency(density: f64, diameter: f64, temperature: f64) -> f64 {
    3.2 * density * diameter * diameter * (PI * temperature).sqrt()
}
