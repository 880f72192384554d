//! Closed forms of the kinetic theory of hard spheres that engines and predictions share.

/// [-] contact value of spheres with the diameters a and b [m] in a mixture with the volume fraction φ and
/// `second_moment` ξ_2 = π/6 Σ n_i d_i² [1/m] (Boublík 1970, J. Chem. Phys. 53, 471; Mansoori, Carnahan, Starling and
/// Leland 1971, J. Chem. Phys. 54, 1523). For equal spheres it is Carnahan and Starling's (1 - φ/2)/(1 - φ)³.
pub fn contact_value(a: f64, b: f64, volume_fraction: f64, second_moment: f64) -> f64 {
    let free = 1.0 - volume_fraction;
    let ratio = a * b / (a + b) * second_moment;
    1.0 / free + 3.0 * ratio / (free * free) + 2.0 * ratio * ratio / (free * free * free)
}
