//! Drag kick of many particles: the change of the slip velocity in a given time, tabulated over the slip speed.
//!
//! The slip velocity is the velocity of a particle relative to the gas. For one sphere and one duration, the relative
//! change of the slip velocity depends only on the slip speed w. The relative change is `ratio - 1`, where `ratio` is
//! the slip speed after the kick over that before. The law of Schiller and Naumann needs a power, two exponentials and
//! a logarithm per particle; the table needs only a polynomial.
//!
//! The table divides the range of w² into pieces, each with one polynomial. The index of a piece is the exponent and
//! the leading bits of w² as a floating-point number. Every octave (factor of two) of w² therefore has the same number
//! of pieces, which resolve w^0.687 at any speed. No root and no logarithm is needed.

use super::{Drag, Sphere};
use nalgebra::{SMatrix, SVector};

/// Number of leading bits of the mantissa of w² that select a piece of the table, with the slip speed w. Four bits give
/// 16 pieces per octave of w².
const PIECE_BITS: u32 = 4;
/// Number of remaining bits of the mantissa of w², which give the position within a piece of the table.
const REST_BITS: u32 = f64::MANTISSA_DIGITS - 1 - PIECE_BITS;
/// [m²/s²] lower end of the table in w², the square of the slip speed. It is a power of 2 and corresponds to w near
/// 1e-6 m/s.
const LOWEST: f64 = 1.0 / (1_u64 << 40) as f64;
/// [m²/s²] upper end of the table in w², the square of the slip speed. It is a power of 2 and corresponds to w = 64
/// m/s.
const HIGHEST: f64 = 4096.0;
/// [-] largest allowed relative error of a piece of the table. Instead of a piece with a larger error, the law itself
/// is evaluated. The error is at most 2e-10 for a smooth law, and about 1e-3 in a piece of the table in which a law
/// switches between two formulas.
const TOLERANCE: f64 = 5e-10;

/// Number of coefficients of the polynomial of each piece of the table.
const TERMS: usize = 5;
/// Positions in a piece of the table, from 0 to 1, at which the polynomial equals the drag law: both ends and the
/// Chebyshev points between them.
const NODES: [f64; TERMS] = [0.0, 0.146_446_609_406_726_24, 0.5, 0.853_553_390_593_273_8, 1.0];
/// Positions in a piece of the table, from 0 to 1, near which the error of the polynomial is largest. The error is
/// checked at these positions.
const CHECKS: [f64; TERMS - 1] = [0.05, 0.32, 0.68, 0.95];

/// Coefficients [-] of the polynomial of a piece of the table, constant term first. The variable is the position
/// within the piece, from 0 to 1. All coefficients are not-a-number if the error of the piece exceeds `TOLERANCE`, for
/// example where the drag law switches between two formulas.
type Piece = [f64; TERMS];

/// Drag kick: change of the slip velocity of particles by drag alone in a given time, for spheres of each species.
#[derive(Clone, Debug)]
pub struct Kick {
    law: Drag,
    duration: f64,
    species: Vec<SpeciesTable>,
    /// [m] one entry per species. If the particles of the species differ in size, it is the diameter of the sphere in
    /// the `SpeciesTable` of this species; otherwise `None`. The list is empty if no species has several sizes.
    spread: Vec<Option<f64>>,
}

/// Sphere of one species, and the table of its relative change of slip velocity. If the table is empty, the drag law
/// itself is evaluated.
#[derive(Clone, Debug)]
struct SpeciesTable {
    sphere: Sphere,
    pieces: Vec<Piece>,
}

impl Kick {
    /// Makes a drag kick over `duration` [s] without a table, so that every change is computed by the drag law itself.
    /// Such a kick is used for few particles, and as a reference.
    pub fn exact(law: &Drag, spheres: &[Sphere], duration: f64) -> Self {
        let species = spheres.iter().map(|&sphere| SpeciesTable { sphere, pieces: Vec::new() }).collect();
        Self { law: law.clone(), duration, species, spread: Vec::new() }
    }

    /// Returns the kick for species whose particles may differ in diameter. `diameters` has one entry per species: the
    /// diameter [m] of its [`Sphere`], or `None` if all its particles have this diameter. A table is valid for one
    /// size only. For particles of species with several sizes, the drag law itself is evaluated.
    pub fn with_sizes(mut self, diameters: Vec<Option<f64>>) -> Self {
        self.spread = diameters;
        self
    }

    /// True if, for some species, the change of the slip velocity depends on the diameter of each particle.
    pub fn asks_sizes(&self) -> bool {
        self.spread.iter().any(Option::is_some)
    }

    /// Makes a drag kick over `duration` [s] with a table of the law, accurate to 5e-10 of the change. A law that
    /// depends on the volume fraction of the particles is not tabulated. The table costs as much computing time as
    /// about 10⁴ evaluations of the law.
    pub fn tabulated(law: &Drag, spheres: &[Sphere], duration: f64) -> Self {
        let mut kick = Self::exact(law, spheres, duration);
        if kick.cells().is_some() {
            return kick;
        }
        // the matrix is invertible, because it is a Vandermonde matrix of distinct nodes
        let vandermonde = SMatrix::<f64, TERMS, TERMS>::from_fn(|i, j| NODES[i].powi(j as i32));
        let Some(inverse) = vandermonde.try_inverse() else { return kick };
        for species in &mut kick.species {
            let change = |square: f64| law.law().change(&species.sphere, square.sqrt(), duration);
            let piece = |leading: u64| {
                let [start, end] = [leading, leading + 1].map(|bits| f64::from_bits(bits << REST_BITS));
                let at = |place: f64| change(start + place * (end - start));
                let piece: Piece = (inverse * SVector::from(NODES.map(at))).into();
                let errs = |place: f64| (value(&piece, place) / at(place) - 1.0).abs() > TOLERANCE;
                if CHECKS.into_iter().any(errs) { [f64::NAN; TERMS] } else { piece }
            };
            species.pieces = (leading(LOWEST)..leading(HIGHEST)).map(piece).collect();
        }
        kick
    }

    /// Numbers of cells along x, y and z in which the volume fraction of the particles is computed. `None` if the drag
    /// law does not depend on this fraction.
    pub fn cells(&self) -> Option<[u32; 3]> {
        self.law.law().cells()
    }

    /// [s] duration of the drag kick.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// [-] change of the slip velocity in a kick, divided by the slip velocity before; in [-1, 0]. `species` is the
    /// index of the sphere's species, and `square` [m²/s²] the square of the slip speed before the kick.
    #[inline]
    pub fn change(&self, species: u16, square: f64) -> f64 {
        let species = &self.species[species as usize];
        let place = leading(square).wrapping_sub(leading(LOWEST));
        if let Some(piece) = species.pieces.get(place as usize) {
            // the remaining bits of w² become the fraction of a number in [1, 2)
            let rest = (square.to_bits() << PIECE_BITS) & ((1 << (f64::MANTISSA_DIGITS - 1)) - 1);
            let change = value(piece, f64::from_bits(rest | 1.0_f64.to_bits()) - 1.0);
            if !change.is_nan() {
                return change;
            }
        }
        self.by_law(species, square)
    }

    /// [-] change of the slip velocity in a kick, divided by the slip velocity before, for a sphere of `radius` [m].
    /// `species` is the index of its species, and `square` [m²/s²] the square of the slip speed before. For species of
    /// one size the result equals [`change`](Self::change).
    #[inline]
    pub fn change_of(&self, species: u16, radius: f64, square: f64) -> f64 {
        match self.spread.get(usize::from(species)) {
            Some(Some(diameter)) => {
                let sphere = self.species[usize::from(species)].sphere.scaled(2.0 * radius / diameter);
                self.law.law().change(&sphere, square.sqrt(), self.duration)
            }
            _ => self.change(species, square),
        }
    }

    /// [-] change of the slip velocity in a kick, divided by the slip velocity before. The sphere has the species with
    /// the index `species`, the radius `radius` [m] and the volume fraction `fraction` [-] of particles around it.
    /// `square` [m²/s²] is the square of the slip speed.
    pub fn change_among(&self, species: u16, radius: f64, fraction: f64, square: f64) -> f64 {
        let index = usize::from(species);
        let own = self.species[index].sphere.among(fraction);
        let sphere = match self.spread.get(index) {
            Some(Some(diameter)) => own.scaled(2.0 * radius / diameter),
            _ => own,
        };
        self.law.law().change(&sphere, square.sqrt(), self.duration)
    }

    /// [-] change of the slip velocity in a kick, divided by the slip velocity before, computed by the drag law without
    /// the table. `square` [m²/s²] is the square of the slip speed.
    #[cold]
    fn by_law(&self, species: &SpeciesTable, square: f64) -> f64 {
        self.law.law().change(&species.sphere, square.sqrt(), self.duration)
    }
}

/// Number of the piece of the table that contains `square` = w² [m²/s²], with the slip speed w: exponent and leading
/// mantissa bits of this floating-point number, as an integer. The first piece has the number `leading(LOWEST)`.
#[inline]
fn leading(square: f64) -> u64 {
    square.to_bits() >> REST_BITS
}

/// Value of the polynomial of a piece of the table: the relative change of the slip velocity at the position `place`
/// within the piece, from 0 to 1.
#[inline]
fn value(piece: &Piece, place: f64) -> f64 {
    let [a, b, c, d, e] = *piece;
    a + place * (b + place * (c + place * (d + place * e)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drag::SchillerNaumann;

    const LAW: Drag = Drag::SchillerNaumann(SchillerNaumann);

    /// Spheres of the paper (`docs/paper.md`), with diameters of 406 µm and 1.5 mm, in air.
    const SPHERES: [Sphere; 2] = [
        Sphere { stokes_time: 0.520_687_601, reynolds_per_speed: 406e-6 / 1.515e-5, fraction: 0.0 },
        Sphere { stokes_time: 7.066_266_793, reynolds_per_speed: 1.5e-3 / 1.515e-5, fraction: 0.0 },
    ];

    #[test]
    fn only_the_switch_is_left_to_the_law() {
        for duration in [1e-9, 1e-6, 1e-4, 1e-2] {
            for (species, sphere) in Kick::tabulated(&LAW, &SPHERES, duration).species.iter().zip(&SPHERES) {
                let left: Vec<u64> = (leading(LOWEST)..)
                    .zip(&species.pieces)
                    .filter(|(_, piece)| piece[0].is_nan())
                    .map(|l| l.0)
                    .collect();
                let switch = leading((1000.0 / sphere.reynolds_per_speed).powi(2));
                assert!(left.contains(&switch), "{duration} s: the jump at Re = 1000 was not seen");
                // in a long kick, particles from a wider range above the switch cross it too
                assert!(left.len() <= 3, "{duration} s: {} pieces", left.len());
                assert_eq!(species.pieces.len(), 52 * 16);
            }
        }
    }

    #[test]
    fn outside_the_table_the_law_answers() {
        let (table, exact) = (Kick::tabulated(&LAW, &SPHERES, 1e-4), Kick::exact(&LAW, &SPHERES, 1e-4));
        for square in [0.0, 5e-324, LOWEST.next_down(), HIGHEST, 1e200, f64::INFINITY] {
            assert_eq!(table.change(1, square), exact.change(1, square), "{square}");
        }
        assert!(table.change(1, f64::NAN).is_nan());
    }
}
