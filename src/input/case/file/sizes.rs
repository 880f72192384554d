//! Distributions of diameters: the key `sizes` of `[[particles]]`.

use crate::case::located::Located;
use crate::case::quantity::{Length, Ratio};
use schemars::JsonSchema;
use serde::Deserialize;

/// `sizes` of `[[particles]]`: one distribution of diameters, all of them between 1e-7 m and 1 m.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SizesFile {
    /// Uniform distribution: all diameters between two limits are equally likely.
    Uniform {
        /// Smallest diameter of the distribution.
        #[schemars(example = &"300 um", extend("x-required" = "always", "x-range" = "1e-7 m ..= 1 m"))]
        from: Option<Located<Length>>,
        /// Largest diameter of the distribution.
        #[schemars(example = &"500 um", extend("x-required" = "always", "x-range" = "1e-7 m ..= 1 m"))]
        to: Option<Located<Length>>,
    },
    /// Log-normal distribution of the diameters, cut off at both ends.
    LogNormal {
        /// Median of the diameters, by number, before the ends are cut off.
        #[schemars(example = &"400 um", extend("x-required" = "always", "x-range" = "1e-7 m ..= 1 m"))]
        median: Option<Located<Length>>,
        // with more than 10, two thirds of the diameters would span six decades of volume: probably a typing error
        /// Geometric standard deviation before the ends are cut off. About two thirds of the diameters lie between the
        /// median divided by this number and the median times this number.
        #[schemars(example = 1.3, extend("x-required" = "always", "x-range" = "greater than 1, up to 10"))]
        geometric_deviation: Option<Located<Ratio>>,
        /// Smallest diameter. The time step of soft spheres and the window of drag must resolve spheres of this size.
        #[schemars(example = &"200 um", extend("x-required" = "always", "x-range" = "1e-7 m ..= 1 m"))]
        from: Option<Located<Length>>,
        /// Largest diameter of the distribution.
        #[schemars(example = &"800 um", extend("x-required" = "always", "x-range" = "1e-7 m ..= 1 m"))]
        to: Option<Located<Length>>,
    },
    /// List of diameters, such as those of sieves, with the share of each.
    Table {
        /// Diameters of the particles, each with a share in `fractions`.
        #[schemars(extend("examples" = [["300 um", "400 um"]], "x-required" = "always"))]
        #[schemars(extend("x-range" = "1e-7 m ..= 1 m"))]
        diameters: Option<Located<Vec<Located<Length>>>>,
        /// Shares of the diameters, in the order of `diameters`. Only their ratios matter, so their sum need not be 1.
        #[schemars(extend("examples" = [[0.25, 0.75]], "x-required" = "always"))]
        #[schemars(extend("x-range" = "greater than 0, up to 1e9"))]
        fractions: Option<Located<Vec<Located<Ratio>>>>,
        /// Quantity of which `fractions` are shares: the number or the volume of the particles.
        #[schemars(example = &"volume", extend("default" = "number"))]
        by: Option<Located<ByFile>>,
    },
}

/// Quantity of which the numbers in `fractions` are shares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ByFile {
    /// Shares of the number of particles.
    Number,
    /// Shares of the volume of the particles, as in a sieve analysis. At equal density they are also shares of the
    /// mass.
    Volume,
}
