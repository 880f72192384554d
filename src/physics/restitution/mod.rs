//! Restitution that depends on the speed of the impact.
//!
//! Every law gives e as a function of the normal speed u of approach. A law contains no masses. Its constants are
//! valid only for the two kinds of bodies for which a case (input file) gives them, as is a constant restitution.

mod viscoelastic;

pub use viscoelastic::{ViscoelasticImpact, viscoelastic_impact};

use serde::{Deserialize, Serialize};
use viscoelastic::damping_for;

/// Restitution e(u) of an impact at normal speed u.
///
/// ```
/// # extern crate diptych_physics as diptych;
/// use diptych::restitution::RestitutionBySpeed;
///
/// // ice balls at 0.5 mm/s (Bridges, Hatzes and Lin 1984)
/// let ice = RestitutionBySpeed::Bridges { speed: 7.7e-5, exponent: 0.234 };
/// assert!((ice.at(5e-4) - 0.6454).abs() < 1e-4);
/// assert_eq!(ice.at(1e-5), 1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RestitutionBySpeed {
    /// Restitution e = min(1, (u/u_c)^-p), measured for ice (Bridges, Hatzes and Lin 1984, Nature 309, 333).
    Bridges {
        /// [m/s] normal speed u_c > 0 up to which impacts are elastic.
        speed: f64,
        /// [-] exponent p >= 0 in e = (u/u_c)^-p.
        exponent: f64,
    },
    /// Restitution e = max(e_min, 1 - (1 - e_1) (u/u_1)^q). The form 1 - B u^q has q = 1/5 in the first terms of the
    /// series for viscoelastic spheres (Kuwabara and Kono 1987, Jpn. J. Appl. Phys. 26, 1230). It has q = 3/4 with
    /// e_min = e_1 in simulations of shaken beds (Bizon et al. 1998, Phys. Rev. Lett. 80, 57).
    Power {
        /// [-] restitution e_1 at the normal speed u_1.
        restitution: f64,
        /// [m/s] normal speed u_1 > 0 at which the restitution is e_1.
        speed: f64,
        /// [-] exponent q > 0 in e = 1 - (1 - e_1) (u/u_1)^q.
        exponent: f64,
        /// [-] smallest restitution e_min, which fast impacts have.
        least: f64,
    },
    /// Restitution of viscoelastic spheres, whose force is k δ^(3/2) + 3/2 A k sqrt(δ) dδ/dt at the overlap δ
    /// (Kuwabara and Kono 1987; Brilliantov, Spahn, Hertzsch and Pöschel 1996, Phys. Rev. E 53, 5382). The constant
    /// k [N/m^1.5] is that of Hertz's law, and A [s] a time of the material. With the effective mass M, e is a function
    /// of β = 3/2 A (k/M)^(2/5) u^(1/5) alone ([`viscoelastic_impact`]).
    Viscoelastic {
        /// [-] restitution e_1 at the normal speed u_1.
        restitution: f64,
        /// [m/s] normal speed u_1 > 0 at which the restitution is e_1.
        speed: f64,
        /// [(s/m)^(1/5)] constant β/u^(1/5) of the two bodies, as [`RestitutionBySpeed::viscoelastic`] computes it from
        /// e_1 and u_1.
        damping: f64,
    },
}

impl RestitutionBySpeed {
    /// Makes the law of viscoelastic spheres whose restitution at the normal speed `speed` [m/s] is e_1 =
    /// `restitution` [-], 0 < e_1 <= 1.
    pub fn viscoelastic(restitution: f64, speed: f64) -> Self {
        let damping = damping_for(restitution) / speed.powf(0.2); // β ∝ u^(1/5), Ramírez et al. 1999
        Self::Viscoelastic { restitution, speed, damping }
    }

    /// [-] restitution of an impact at the normal speed `speed` [m/s] of approach; 1 for bodies that do not approach.
    pub fn at(&self, speed: f64) -> f64 {
        if speed <= 0.0 {
            return 1.0;
        }
        match self {
            Self::Bridges { speed: elastic, exponent } => (speed / elastic).powf(-exponent).min(1.0),
            Self::Power { restitution, speed: of, exponent, least } => {
                (1.0 - (1.0 - restitution) * (speed / of).powf(*exponent)).max(*least)
            }
            Self::Viscoelastic { damping, .. } => viscoelastic_impact(damping * speed.powf(0.2)).restitution,
        }
    }

    /// True if no impact, however fast, has the restitution 0.
    pub fn always_rebounds(&self) -> bool {
        match self {
            Self::Bridges { .. } | Self::Viscoelastic { .. } => true,
            Self::Power { least, .. } => *least > 0.0,
        }
    }
}

impl std::fmt::Display for RestitutionBySpeed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Bridges { speed, exponent } => write!(f, "min(1, (u/({speed} m/s))^-{exponent})"),
            Self::Power { restitution, speed, exponent, least } => {
                write!(f, "1 - {} (u/({speed} m/s))^{exponent}, at least {least}", 1.0 - restitution)
            }
            Self::Viscoelastic { restitution, speed, .. } => {
                write!(f, "that of viscoelastic spheres with {restitution} at {speed} m/s")
            }
        }
    }
}
