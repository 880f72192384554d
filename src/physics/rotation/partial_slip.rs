//! Oblique impact of elastic spheres whose contact circle sticks in the middle and slips at its edge, after Maw, Barber
//! and Fawcett (1976, Wear 38, 101). A spring model has one tangential force per contact. In this model the traction
//! (tangential force per area) depends on the distance r from the centre of the contact circle.
//!
//! The normal motion is Hertz's. The contact circle is divided into rings, and each half of the contact time into as
//! many steps as there are rings. At the end of every step, the edge of the contact is the edge of a ring. The traction
//! is a sum of the distributions q sqrt(1 - r²/c²), one for the outer radius c of each ring. The tangential
//! displacement by one distribution is averaged around the ring at r. A pressure with the same distribution gives a
//! normal displacement. The mean tangential displacement is this displacement times the ratio of the tangential to the
//! normal compliance (Johnson 1985, Contact Mechanics, Eqs. 3.42 and 3.91), since the mean of cos² over all directions
//! is 1/2. A ring that sticks is displaced by as much as the bodies. In a ring that slides, the traction is the
//! friction μ times the pressure.
//!
//! Units: largest overlap, effective radius, effective mass and normal speed are 1. The slip is divided by μ.

use nalgebra::{DMatrix, DVector};
use std::f64::consts::{FRAC_PI_2, PI};

/// Number of rings into which the contact circle is divided. The slip after an impact is then exact to 0.02 in units of
/// μ u_n, with the friction μ and the normal speed u_n (comparison of 10, 20, 40 and 80 rings in docs/rotation.md).
const RINGS: usize = 40;

/// [-] effective Young's modulus E*, if largest overlap, effective radius, effective mass and normal speed are 1. The
/// energy 1/2 of the normal motion before the impact equals the elastic energy at the largest overlap, 2/5 · 4/3 E*.
const MODULUS: f64 = 15.0 / 16.0;

/// State of a ring of the contact circle: the surfaces stick together or slide.
#[derive(Clone, Copy, PartialEq)]
enum RingState {
    Sticks,
    /// The surfaces slide. The number, 1 or -1, is the sign of the traction and of the slip.
    Slides(f64),
}

/// Oblique impact of elastic spheres whose contact circle sticks in the middle and slips at its edge. The largest
/// overlap, effective radius, effective mass and normal speed are 1.
pub struct PartialSlip {
    /// [-] effective mass M_t of the slip, divided by the effective mass M of the normal motion.
    mass: f64,
    /// [-] outer radii of the rings, from the inside out. The outermost radius is the largest radius of the contact, 1.
    radii: Vec<f64>,
    /// [-] time in which the edge of the growing contact crosses each ring, from the inside out.
    steps: Vec<f64>,
    /// [-] mean tangential displacements. The element in row i and column j is the displacement at the middle of ring
    /// i, by the traction sqrt(1 - r²/c²) on a circle of radius c, the outer radius of ring j.
    displacement: DMatrix<f64>,
    /// [-] tractions (tangential forces per area). The element in row i and column j is the traction at the middle of
    /// ring i, of the distribution sqrt(1 - r²/c²) on a circle of radius c, the outer radius of ring j.
    traction: DMatrix<f64>,
}

impl PartialSlip {
    /// Makes an impact. `stiffness` [-] is Mindlin's ratio k_t/k_n = 4 G*/E* (0.82 at Poisson's ratio 0.3), and `mass`
    /// [-] the ratio M_t/M of the effective masses (2/7 for solid spheres).
    pub fn new(stiffness: f64, mass: f64) -> Self {
        // with a phase from 0 to π/2, overlap and speed are sin^(4/5) and cos, and a step of time is proportional to
        // sin^(-1/5)
        let phase = |k: usize| FRAC_PI_2 * k as f64 / RINGS as f64;
        let radii: Vec<f64> = (1..=RINGS).map(|k| phase(k).sin().powf(0.4)).collect();
        let steps = (0..RINGS).map(|k| {
            let middle = 0.5 * (phase(k) + phase(k + 1));
            (phase(k + 1).powf(0.8) - phase(k).powf(0.8)) * (middle / middle.sin()).powf(0.2)
        });
        let middle = |i: usize| 0.5 * (if i == 0 { 0.0 } else { radii[i - 1] } + radii[i]);
        let displacement = DMatrix::from_fn(RINGS, RINGS, |i, j| normal_displacement(middle(i), radii[j]) / stiffness);
        let traction = DMatrix::from_fn(RINGS, RINGS, |i, j| ellipse(middle(i) / radii[j]));
        Self { mass, steps: steps.collect(), displacement, traction, radii }
    }

    /// [-] reduced slip σ' = s'/(μ u_n) after an impact: the slip s' after it, divided by friction times normal speed.
    /// `slip` is the reduced slip σ_0 >= 0 before the impact. A negative result means that the surfaces slip backwards.
    /// The model contains no resistance to rolling and twisting.
    pub fn rebound(&self, slip: f64) -> f64 {
        let mut slip = slip;
        let mut displaced = DVector::zeros(RINGS);
        let mut state = [RingState::Sticks; RINGS];
        let mut force = 0.0;
        let loading = (0..RINGS).map(|k| (k + 1, self.steps[k]));
        let unloading = (1..RINGS).rev().map(|k| (k, self.steps[k]));
        for (rings, time) in loading.chain(unloading) {
            slip -= 0.5 * time * force / self.mass;
            state[rings..].fill(RingState::Sticks);
            let amplitudes = self.tractions(&mut state[..rings], &displaced, slip * time);
            displaced = self.displacement.columns(0, rings) * &amplitudes;
            // integral of the distribution q sqrt(1 - r²/c²) over the circle of radius c
            force = amplitudes.iter().zip(&self.radii).map(|(q, c)| 2.0 / 3.0 * PI * c * c * q).sum();
            slip -= 0.5 * time * force / self.mass;
        }
        // in the last step the innermost ring opens, and the force falls to zero
        slip - 0.5 * self.steps[0] * force / self.mass
    }

    /// Amplitudes q of the tractions q sqrt(1 - r²/c²), one per radius c of a ring in contact. They are computed after
    /// the bodies have moved by `moved` relative to each other. `displaced` holds the displacements of the rings before
    /// this motion. `state` has the states of the rings in contact, at least one. The states are changed until two
    /// conditions hold. Each ring that sticks has at most the traction of the friction limit, and each ring that slides
    /// does so along its traction.
    fn tractions(&self, state: &mut [RingState], displaced: &DVector<f64>, moved: f64) -> DVector<f64> {
        let rings = state.len();
        let displacement = self.displacement.view((0, 0), (rings, rings));
        let traction = self.traction.view((0, 0), (rings, rings));
        // Hertz's pressure 2 E* c/π sqrt(1 - r²/c²)
        let pressure = traction.column(rings - 1) * (2.0 * MODULUS * self.radii[rings - 1] / PI);
        let mut amplitudes = DVector::zeros(rings);
        // a ring changes at most twice within a step; the bound only ends a cycle that rounding could cause
        for _ in 0..4 * rings {
            let matrix = DMatrix::from_fn(rings, rings, |i, j| match state[i] {
                RingState::Sticks => displacement[(i, j)],
                RingState::Slides(_) => traction[(i, j)],
            });
            let wanted = DVector::from_fn(rings, |i, _| match state[i] {
                RingState::Sticks => displaced[i] + moved,
                RingState::Slides(sign) => sign * pressure[i],
            });
            let Some(solved) = matrix.lu().solve(&wanted) else { break };
            amplitudes = solved;
            let (now, tractions) = (displacement * &amplitudes, traction * &amplitudes);
            let next = |i: usize| match state[i] {
                RingState::Sticks if tractions[i].abs() > pressure[i] => RingState::Slides(tractions[i].signum()),
                RingState::Slides(sign) if sign * (moved - now[i] + displaced[i]) < 0.0 => RingState::Sticks,
                same => same,
            };
            let changed: Vec<RingState> = (0..rings).map(next).collect();
            if changed == *state {
                break;
            }
            state.copy_from_slice(&changed);
        }
        amplitudes
    }
}

/// sqrt(1 - x²) for |x| <= 1, and 0 for larger |x|.
fn ellipse(x: f64) -> f64 {
    (1.0 - x * x).max(0.0).sqrt()
}

/// [-] normal displacement at the radius r by the pressure sqrt(1 - r²/c²) on a circle of radius c (Johnson 1985, Eqs.
/// 3.42a and b). The effective Young's modulus is [`MODULUS`].
fn normal_displacement(r: f64, c: f64) -> f64 {
    let scale = 1.0 / (2.0 * MODULUS * c);
    if r <= c {
        return scale * FRAC_PI_2 * (2.0 * c * c - r * r);
    }
    let x = c / r;
    scale * ((2.0 * c * c - r * r) * x.asin() + r * c * ellipse(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [-] Mindlin's ratio k_t/k_n of the stiffnesses at Poisson's ratio 0.3.
    const STEEL: f64 = 2.0 * 0.7 / 1.7;
    const SOLID: f64 = 2.0 / 7.0;

    /// Compares the spin R ω'/(μ u_n) after an impact, as a function of the slip s/(μ u_n) before it, with finite
    /// elements (steel on a rigid plane; Chung and Ooi 2011, test 5). The points are six of the ten in
    /// `study/validate/chung_ooi.rs`. In gross sliding, where the value is 5, the points of the finite elements are up
    /// to 0.06 off.
    #[test]
    fn spins_are_those_of_finite_elements() {
        let impact = PartialSlip::new(STEEL, SOLID);
        for (slip, expected) in
            [(0.5954, 0.4056), (1.8960, 1.7933), (2.7630, 2.8564), (3.8902, 4.0412), (4.6879, 4.5685), (5.6590, 4.9415)]
        {
            let spin = (slip - impact.rebound(slip)) * 5.0 / 7.0;
            assert!((spin - expected).abs() < 0.06, "{slip}: {spin} and {expected}");
        }
    }

    #[test]
    fn far_from_the_normal_all_rings_slide_all_the_time() {
        let impact = PartialSlip::new(STEEL, SOLID);
        // the change of the slip is (1 + e) M/M_t
        assert!((impact.rebound(12.0) - (12.0 - 7.0)).abs() < 0.01);
    }

    /// If the tangential stiffness is large, the rings stick as long as the pressure allows it. The slip after the
    /// impact is then small compared with the slip before.
    #[test]
    fn stiff_surfaces_end_the_slip() {
        let impact = PartialSlip::new(100.0, SOLID);
        assert!(impact.rebound(1.0).abs() < 0.1, "{}", impact.rebound(1.0));
    }
}
