//! Contracts: conditions that the simulation requires of every contact law. Laws of the calling program (which uses
//! this library) are checked when a simulation is made.

use super::{ContactLaw, Spring};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Contract (condition on a contact law) that the law violates between two given bodies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum BrokenContract {
    /// The elastic force at touch is not zero. A contact that is first detected a fraction of a time step after touch
    /// would then gain or lose energy.
    ForceAtTouch {
        /// [-] elastic force at touch over the largest elastic force in an impact.
        share: f64,
    },
    /// The stored energy is not equal to the work of the elastic force.
    Energy {
        /// [m] overlap at which the stored energy and the work of the elastic force differ.
        overlap: f64,
        /// [J] stored energy at this overlap, as the law returns it.
        stored: f64,
        /// [J] work of the elastic force from touch to this overlap.
        work: f64,
    },
    /// The viscous force accelerates the motion instead of slowing it down.
    Drives {
        /// [m] overlap at which the viscous force has the wrong sign.
        overlap: f64,
        /// [m/s] normal velocity at which the viscous force has the wrong sign; positive: separating.
        velocity: f64,
    },
    /// The law cannot stop an impact: at no overlap does the stored energy reach the kinetic energy of the impact.
    Bottomless {
        /// [m/s] normal speed of the impact that no overlap can stop.
        speed: f64,
    },
}

impl fmt::Display for BrokenContract {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ForceAtTouch { share } => {
                write!(f, "its elastic force at touch is {share:.3} of the largest in an impact, but must be zero")
            }
            Self::Energy { overlap, stored, work } => {
                write!(
                    f,
                    "it stores {stored:.4e} J at an overlap of {overlap:.4e} m, where the work of its force is {work:.4e} J"
                )
            }
            Self::Drives { overlap, velocity } => {
                write!(f, "its viscous force drives the motion at an overlap of {overlap:.4e} m and {velocity:.4e} m/s")
            }
            Self::Bottomless { speed } => write!(f, "no overlap stores the energy of an impact at {speed:.4e} m/s"),
        }
    }
}

/// [-] limit of two quantities of a law: its elastic force at touch over its largest elastic force, and the relative
/// error of its stored energy. The limit is the error of a quadrature with `POINTS` intervals for a force whose slope
/// is infinite at touch.
const TOLERANCE: f64 = 1e-3;
/// Number of intervals of the quadrature that integrates the elastic force over the overlap.
const POINTS: u32 = 1000;

impl ContactLaw {
    /// Checks the contracts of [`Law`](super::Law) for impacts at normal speeds up to `speed` [m/s]. Laws of this
    /// library satisfy the contracts and are not checked.
    ///
    /// # Errors
    /// The first contract that the law violates.
    pub fn check(&self, spring: &Spring, speed: f64) -> Result<(), BrokenContract> {
        let Self::Other(law) = self else { return Ok(()) };
        let deepest = super::numerical::greatest_overlap(*law, spring, speed);
        if !deepest.is_finite() || deepest <= 0.0 {
            return Err(BrokenContract::Bottomless { speed });
        }
        let force = |overlap: f64| law.force(spring, overlap, 0.0).0;
        let step = deepest / f64::from(POINTS);
        let largest =
            |value: &dyn Fn(f64) -> f64| (1..=POINTS).map(|k| value(f64::from(k) * step).abs()).fold(0.0, f64::max);
        let share = (force(0.0) / largest(&force)).abs();
        if share.is_nan() || share > TOLERANCE {
            return Err(BrokenContract::ForceAtTouch { share });
        }
        // the largest magnitude is the reference, because the stored energy of a law with attraction passes through
        // zero
        let whole = largest(&|overlap| law.stored_energy(spring, overlap));
        let mut work = 0.0;
        for k in 0..POINTS {
            work += force((f64::from(k) + 0.5) * step) * step;
            let overlap = f64::from(k + 1) * step;
            let stored = law.stored_energy(spring, overlap);
            if (stored - work).abs() > TOLERANCE * whole || stored.is_nan() {
                return Err(BrokenContract::Energy { overlap, stored, work });
            }
            for velocity in [-speed, speed] {
                if law.force(spring, overlap, velocity).1 * velocity > 0.0 {
                    return Err(BrokenContract::Drives { overlap, velocity });
                }
            }
        }
        Ok(())
    }
}
