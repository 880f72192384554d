//! One kick for many particles: the law tabulated over the slip speed.
//!
//! For one sphere and one duration the relative change of the slip velocity, `ratio - 1`, is a function of the slip
//! speed w alone. A law costs a power and three exponentials per particle; the table costs a polynomial. Its index is
//! made of the leading bits of w² as a floating-point number, exponent first. So every octave has the same number of
//! pieces: the table resolves w^0.687 near rest as well as in fast flow. Neither a root nor a logarithm is taken.

use super::{Drag, Sphere};
use nalgebra::{SMatrix, SVector};

/// Leading bits of the fraction of w² that pick the piece: 16 pieces per octave.
const PIECE_BITS: u32 = 4;
/// Remaining bits of w², which give its position within the piece.
const REST_BITS: u32 = f64::MANTISSA_DIGITS - 1 - PIECE_BITS;
/// [m²/s²] lower end of the table in w², a power of 2: w from 1e-6 m/s.
const LOWEST: f64 = 1.0 / (1_u64 << 40) as f64;
/// [m²/s²] upper end of the table in w², a power of 2: w to 64 m/s.
const HIGHEST: f64 = 4096.0;
/// [-] relative error of the change above which the law is evaluated instead of the piece. A smooth law gives at most
/// 2e-10, a piece in which a law switches about 1e-3.
const TOLERANCE: f64 = 5e-10;

/// Number of coefficients of a polynomial.
const TERMS: usize = 5;
/// Chebyshev points with both ends, on [0, 1]: a switch anywhere in a piece lies between two of them.
const NODES: [f64; TERMS] = [0.0, 0.146_446_609_406_726_24, 0.5, 0.853_553_390_593_273_8, 1.0];
/// Positions at which the interpolation error is largest.
const CHECKS: [f64; TERMS - 1] = [0.05, 0.32, 0.68, 0.95];

/// [-] polynomial in the position within the piece, 0 to 1, from the constant on; not-a-number where the law
/// switches.
type Piece = [f64; TERMS];

/// Effect of drag alone, over a given time, on spheres of each species.
#[derive(Clone, Debug)]
pub struct Kick {
    law: Drag,
    duration: f64,
    species: Vec<SpeciesTable>,
    /// [m] for each species whose particles differ in size, the diameter of its `sphere`; empty if no species has
    /// different sizes.
    spread: Vec<Option<f64>>,
}

/// One species: the sphere and its table, which may be empty.
#[derive(Clone, Debug)]
struct SpeciesTable {
    sphere: Sphere,
    pieces: Vec<Piece>,
}

impl Kick {
    /// Evaluates the law itself: for few particles, or as the reference. `duration` in s.
    pub fn exact(law: &Drag, spheres: &[Sphere], duration: f64) -> Self {
        let species = spheres.iter().map(|&sphere| SpeciesTable { sphere, pieces: Vec::new() }).collect();
        Self { law: law.clone(), duration, species, spread: Vec::new() }
    }

    /// Adds the sizes of species whose particles differ in diameter. For each such species `diameters` holds the
    /// diameter [m] of its `Sphere`. A table holds for one size only, so the law is evaluated for each of these
    /// particles.
    pub fn with_sizes(mut self, diameters: Vec<Option<f64>>) -> Self {
        self.spread = diameters;
        self
    }

    /// True if the sizes of particles matter.
    pub fn asks_sizes(&self) -> bool {
        self.spread.iter().any(Option::is_some)
    }

    /// Tabulates the law to 5e-10 of the change. Making a table takes as long as some 10⁴ particles by the law.
    pub fn tabulated(law: &Drag, spheres: &[Sphere], duration: f64) -> Self {
        let mut kick = Self::exact(law, spheres, duration);
        // a Vandermonde matrix of distinct nodes is invertible
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

    /// [s] duration of the kick.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// [-] change of the slip velocity per slip velocity, in [-1, 0]; `square` [m²/s²] is the square of the slip speed.
    #[inline]
    pub fn change(&self, species: u16, square: f64) -> f64 {
        let species = &self.species[species as usize];
        let place = leading(square).wrapping_sub(leading(LOWEST));
        if let Some(piece) = species.pieces.get(place as usize) {
            // the rest of the fraction, as the fraction of a number in [1, 2)
            let rest = (square.to_bits() << PIECE_BITS) & ((1 << (f64::MANTISSA_DIGITS - 1)) - 1);
            let change = value(piece, f64::from_bits(rest | 1.0_f64.to_bits()) - 1.0);
            if !change.is_nan() {
                return change;
            }
        }
        self.by_law(species, square)
    }

    /// [-] change per slip velocity, as [`change`](Self::change), for a sphere of `radius` [m], where the particles
    /// of a species may differ in size.
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

    /// [-] change per slip velocity by the law itself, without the table.
    #[cold]
    fn by_law(&self, species: &SpeciesTable, square: f64) -> f64 {
        self.law.law().change(&species.sphere, square.sqrt(), self.duration)
    }
}

/// Exponent and leading bits of the fraction of `square`.
#[inline]
fn leading(square: f64) -> u64 {
    square.to_bits() >> REST_BITS
}

/// Value of a piece at a position in [0, 1].
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

    /// The paper's spheres of 406 um and 1.5 mm in air.
    const SPHERES: [Sphere; 2] = [
        Sphere { stokes_time: 0.520_687_601, reynolds_per_speed: 406e-6 / 1.515e-5 },
        Sphere { stokes_time: 7.066_266_793, reynolds_per_speed: 1.5e-3 / 1.515e-5 },
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
                // a long kick crosses the switch from further above
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
