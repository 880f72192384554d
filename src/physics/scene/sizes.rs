//! Distributions of the diameters of a species of particles.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

/// Distribution of the diameters of a species by number of particles (not by mass): the share of the particles that
/// has each diameter.
///
/// ```
/// # extern crate diptych_physics as diptych;
/// use diptych::scene::SizeDistribution;
///
/// let sizes = SizeDistribution::Uniform { from: 1e-3, to: 3e-3 }; // m
/// assert_eq!(sizes.quantile(0.25), 1.5e-3);
/// assert!((sizes.mean_power(1) / 2e-3 - 1.0).abs() < 1e-12);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SizeDistribution {
    /// All diameters between two limits are equally likely.
    Uniform {
        /// [m] smallest diameter of the distribution.
        from: f64,
        /// [m] largest diameter of the distribution.
        to: f64,
    },
    /// The logarithm of the diameter is normally distributed. Diameters below `from` and above `to` are left out.
    LogNormal {
        /// [m] median of the distribution before it is cut at `from` and `to`.
        median: f64,
        /// [-] geometric standard deviation before the distribution is cut at `from` and `to`; more than 1. About two
        /// thirds of the diameters lie between the median divided by this deviation and the median times this
        /// deviation.
        geometric_deviation: f64,
        /// [m] smallest diameter, at which the distribution is cut.
        from: f64,
        /// [m] largest diameter, at which the distribution is cut.
        to: f64,
    },
    /// A list of diameters, each with its share of the particles.
    Table(Vec<Fraction>),
}

/// One row of a table of diameters: a diameter, and the share of the particles that have it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fraction {
    /// [m] diameter of this row.
    pub diameter: f64,
    /// [-] share of the number of particles with this diameter; all shares of a table add up to 1.
    pub share: f64,
}

impl SizeDistribution {
    /// [m] smallest diameter that the distribution contains.
    pub fn smallest(&self) -> f64 {
        match self {
            Self::Uniform { from, .. } | Self::LogNormal { from, .. } => *from,
            Self::Table(rows) => rows.iter().fold(f64::INFINITY, |least, row| least.min(row.diameter)),
        }
    }

    /// [m] largest diameter that the distribution contains.
    pub fn largest(&self) -> f64 {
        match self {
            Self::Uniform { to, .. } | Self::LogNormal { to, .. } => *to,
            Self::Table(rows) => rows.iter().fold(0.0, |most: f64, row| most.max(row.diameter)),
        }
    }

    /// [m] quantile of the diameter: the share `share` [-], from 0 to 1, of the particles has at most this diameter.
    pub fn quantile(&self, share: f64) -> f64 {
        let diameter = match self {
            Self::Uniform { from, to } => from + share * (to - from),
            Self::LogNormal { median, geometric_deviation, from, to } => {
                let normal = Normal::standard();
                let width = geometric_deviation.ln();
                let [low, high] = [from, to].map(|d| normal.cdf((d / median).ln() / width));
                median * (width * normal.inverse_cdf(low + share * (high - low))).exp()
            }
            Self::Table(rows) => {
                let mut below = 0.0;
                let reached = rows.iter().find(|row| {
                    below += row.share;
                    share < below
                });
                return reached.or(rows.last()).map_or(0.0, |row| row.diameter);
            }
        };
        diameter.clamp(self.smallest(), self.largest())
    }

    /// [-] share of the uncut log-normal distribution that lies between its limits `from` and `to`; 1 for other
    /// distributions.
    pub fn left(&self) -> f64 {
        match self {
            Self::Uniform { .. } | Self::Table(_) => 1.0,
            Self::LogNormal { median, geometric_deviation, from, to } => {
                let [low, high] = [from, to].map(|d| (d / median).ln() / geometric_deviation.ln());
                Normal::standard().cdf(high) - Normal::standard().cdf(low)
            }
        }
    }

    /// [m^k] mean of the diameter to the power k, in closed form. For the log-normal distribution with median m and σ =
    /// ln(geometric deviation), the mean is m^k exp(k²σ²/2) A(kσ)/A(0). A(s) is the share of a normal distribution that
    /// lies between the cut-offs if its mean is shifted by s standard deviations.
    pub fn mean_power(&self, k: i32) -> f64 {
        match self {
            Self::Uniform { from, to } => {
                // (b^(k+1) - a^(k+1))/((k + 1)(b - a)) with a = from and b = to, as a sum without the differences,
                // whose rounding errors are large where a is close to b
                let terms = (0..=k).map(|i| from.powi(i) * to.powi(k - i));
                terms.sum::<f64>() / f64::from(k + 1)
            }
            Self::LogNormal { median, geometric_deviation, from, to } => {
                let normal = Normal::standard();
                let width = geometric_deviation.ln();
                let [low, high] = [from, to].map(|d| (d / median).ln() / width);
                let shift = f64::from(k) * width;
                let share = |shift: f64| normal.cdf(high - shift) - normal.cdf(low - shift);
                median.powi(k) * (0.5 * shift * shift).exp() * share(shift) / share(0.0)
            }
            Self::Table(rows) => rows.iter().map(|row| row.share * row.diameter.powi(k)).sum(),
        }
    }
}

impl std::fmt::Display for SizeDistribution {
    /// Describes the distribution in words, with lengths in µm.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let um = |d: f64| d * 1e6;
        match self {
            Self::Uniform { from, to } => write!(f, "diameters uniform from {:.6} to {:.6} µm", um(*from), um(*to)),
            Self::LogNormal { median, geometric_deviation, from, to } => write!(
                f,
                "log-normal diameters about {:.6} µm with geometric deviation {geometric_deviation}, cut at {:.6} and {:.6} µm",
                um(*median),
                um(*from),
                um(*to)
            ),
            Self::Table(rows) => {
                let each = rows.iter().map(|row| format!("{:.6} µm ({:.4} %)", um(row.diameter), 100.0 * row.share));
                write!(f, "diameters {} of the number", each.collect::<Vec<String>>().join(", "))
            }
        }
    }
}
