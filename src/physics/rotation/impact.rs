//! Rules of the tangential impulse of instantaneous impacts.

use super::TangentialLaw;
use super::rebound::{ObliqueImpact, ReboundTable};
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Rule of the tangential impulse of an instantaneous impact.
#[derive(Clone, Debug, PartialEq)]
pub enum ImpactRule {
    /// Rule of Walton. An impact that sticks changes the slip s to -β_0 s; all other impacts slide. The tangential
    /// impulse is J_t = min(μ J_n, M_t (1 + β_0) |s|). Here μ is the friction, J_n the normal impulse, M_t the
    /// effective mass of the slip, and β_0 the tangential restitution (Walton 1993; Foerster et al. 1994, Phys. Fluids
    /// 6, 1108).
    Walton {
        /// [-] tangential restitution β_0, from -1 to 1. The value -1 leaves the slip unchanged, and 1 reverses it.
        tangential_restitution: f64,
    },
    /// Rule of stiff soft spheres: the slip s becomes s' = μ u_n Φ(s/(μ u_n)), with the friction μ, the normal speed
    /// u_n of approach, and the function Φ that follows from the tangential law of soft contacts. There is one table
    /// of Φ for each restitution and mass ratio of the scene.
    OfSpring(Arc<[ReboundTable]>),
}

/// Properties of impacts between two kinds of bodies. Impacts with the same properties follow the same rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactKind {
    /// [-] normal restitution e of impacts between the two kinds of bodies.
    pub restitution: f64,
    /// [-] effective mass M_t of the slip, divided by the effective mass M.
    pub mass_ratio: f64,
    /// [-] Mindlin's tangential stiffness over Hertz's elastic constant; 0 for other contact laws.
    pub shear_ratio: f64,
}

impl ImpactKind {
    /// True if both kinds of impacts have the same restitution and, up to rounding, the same mass ratios and shear
    /// ratios.
    pub fn is_like(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs();
        self.has_table_of(other) && near(self.shear_ratio, other.shear_ratio)
    }

    /// True if one rebound table serves both kinds of impacts: they have the same restitution and, up to rounding, the
    /// same mass ratio M_t/M.
    pub fn has_table_of(&self, other: &Self) -> bool {
        self.restitution == other.restitution && (self.mass_ratio - other.mass_ratio).abs() <= 1e-9 * self.mass_ratio
    }
}

/// Data of an oblique impact from which its tangential impulse is computed.
#[derive(Clone, Copy, Debug)]
pub struct ObliqueApproach {
    /// [-] friction coefficient μ of the two surfaces.
    pub friction: f64,
    /// [-] normal restitution e of the surfaces.
    pub restitution: f64,
    /// [m/s] normal speed of approach u_n > 0.
    pub normal_speed: f64,
    /// [kg m/s] magnitude of the normal impulse J_n of the impact.
    pub normal_impulse: f64,
    /// [m/s] magnitude |s| of the slip before the impact.
    pub slip: f64,
    /// [kg] effective mass M_t of the slip of the two bodies.
    pub mass: f64,
    /// [-] effective mass M_t of the slip, divided by the effective mass M.
    pub mass_ratio: f64,
}

impl ImpactRule {
    /// Coulomb's rule: an impact stops the slip if the friction suffices. There is no tangential restitution.
    pub const COULOMB: Self = Self::Walton { tangential_restitution: 0.0 };

    /// Makes the rule of stiff soft spheres from a tangential law with memory. `impacts` are the kinds of impacts
    /// between the bodies of a scene; a table is made for each kind.
    pub fn of_spring(law: &TangentialLaw, impacts: &[ImpactKind]) -> Self {
        let table = |&ImpactKind { restitution, mass_ratio, shear_ratio }: &ImpactKind| {
            ReboundTable::new(restitution, ObliqueImpact::of_law(law, restitution, mass_ratio, shear_ratio))
        };
        Self::OfSpring(impacts.iter().map(table).collect())
    }

    /// [kg m/s] magnitude of the tangential impulse of an impact. The impulse acts against the slip of the particle.
    #[inline]
    pub fn impulse(&self, approach: &ObliqueApproach) -> f64 {
        let ObliqueApproach { friction, slip, mass, .. } = *approach;
        match self {
            Self::Walton { tangential_restitution } => {
                (friction * approach.normal_impulse).min(mass * (1.0 + tangential_restitution) * slip)
            }
            Self::OfSpring(tables) => {
                let unit = friction * approach.normal_speed;
                if unit <= 0.0 {
                    return 0.0;
                }
                let off = |table: &&ReboundTable| table.distance(approach.restitution, approach.mass_ratio);
                let table = tables.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
                table.map_or(0.0, |table| mass * (slip - unit * table.rebound(slip / unit)))
            }
        }
    }
}

impl std::fmt::Display for ImpactRule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Walton { tangential_restitution } => {
                write!(f, "by Walton's rule with a tangential restitution of {tangential_restitution}")
            }
            Self::OfSpring(_) => write!(f, "by the rule of that spring"),
        }
    }
}

impl Serialize for ImpactRule {
    /// Serializes the rule as in a case. The rule of stiff soft spheres is written as one word, since it has no
    /// parameters beyond those of the tangential law.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Walton { tangential_restitution } => {
                let keys = BTreeMap::from([("tangential_restitution", tangential_restitution)]);
                BTreeMap::from([("walton", keys)]).serialize(serializer)
            }
            Self::OfSpring(_) => "of_spring".serialize(serializer),
        }
    }
}
