//! Sums over the spins of the particles in slices, and the averages that follow from these sums.

use crate::particles::Sample;

/// Number of sums over the particles of a slice: Σ m, Σ I, then Σ I ω and Σ I ω² along x, y and z. Here m is the mass,
/// I the moment of inertia and ω the spin.
pub const SPIN_SUMS: usize = 8;
/// Number of averages of spins: mean spin along x, y and z, rotational temperature T_r, and parts of T_r along x, y and
/// z.
pub const SPIN_QUANTITIES: usize = 7;

/// Sums over the spins of one sample (the particles at one instant), in SI units, one row for each of `slices` slices.
/// The function `slice_of` returns the slice of the particle with a given index. `None` for spheres that do not rotate.
pub fn sums(sample: Sample, slices: usize, slice_of: impl Fn(usize) -> usize + Sync) -> Option<Vec<[f64; SPIN_SUMS]>> {
    let particles = sample.particles;
    let (spins, inertia) = (particles.spin.as_ref()?, particles.inertia.as_ref()?);
    Some(sample.sums_in_groups(slices, |place| {
        let (spin, own) = (spins[place], inertia[place]);
        let (moment, square) = (spin * own, spin.component_mul(&spin) * own);
        let row = [particles.mass[place], own, moment.x, moment.y, moment.z, square.x, square.y, square.z];
        (slice_of(place), row)
    }))
}

/// Averages of spins in a slice, from its sums: mean spin Ω = Σ I ω/Σ I [rad/s], rotational temperature T_r [m²/s²],
/// and parts of T_r along x, y and z, Σ I (ω - Ω)²/Σ m. `None` for an empty slice.
pub fn derive(sums: &[f64]) -> Option<[f64; SPIN_QUANTITIES]> {
    let [mass, inertia] = [sums[0], sums[1]];
    if mass <= 0.0 || inertia <= 0.0 {
        return None;
    }
    let spin: [f64; 3] = std::array::from_fn(|axis| sums[2 + axis] / inertia);
    let part: [f64; 3] = std::array::from_fn(|axis| (sums[5 + axis] - spin[axis] * sums[2 + axis]) / mass);
    let [x, y, z] = part;
    Some([spin[0], spin[1], spin[2], (x + y + z) / 3.0, x, y, z])
}
