//! `sizes` of `[[particles]]`.

use crate::case::de::Located;
use crate::case::quantity::{Length, Ratio};
use schemars::JsonSchema;
use serde::Deserialize;

/// `sizes` of `[[particles]]`: one distribution of diameters, all of them between 1e-7 m and 1 m.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SizesFile {
    /// Uniform distribution: all diameters between two limits are equally likely.
    Uniform {
        /// Smallest diameter.
        #[schemars(example = &"300 um", extend("x-required" = "always"))]
        from: Option<Located<Length>>,
        /// Largest diameter.
        #[schemars(example = &"500 um", extend("x-required" = "always"))]
        to: Option<Located<Length>>,
    },
    /// Log-normal distribution, cut off at both ends.
    LogNormal {
        /// Median of the diameters, by number, before the ends are cut off.
        #[schemars(example = &"400 um", extend("x-required" = "always"))]
        median: Option<Located<Length>>,
        /// Geometric standard deviation before the ends are cut off. About two thirds of the diameters lie between the
        /// median divided by it and the median times it.
        #[schemars(example = 1.3, extend("x-required" = "always"))]
        geometric_deviation: Option<Located<Ratio>>,
        /// Smallest diameter. The time step of soft spheres and the window of drag must resolve spheres of this size.
        #[schemars(example = &"200 um", extend("x-required" = "always"))]
        from: Option<Located<Length>>,
        /// Largest diameter.
        #[schemars(example = &"800 um", extend("x-required" = "always"))]
        to: Option<Located<Length>>,
    },
    /// A list of diameters, such as those of sieves.
    Table {
        /// Diameters.
        #[schemars(extend("examples" = [["300 um", "400 um"]], "x-required" = "always"))]
        diameters: Option<Located<Vec<Located<Length>>>>,
        /// Shares of the diameters, in the order of `diameters`; only the ratios matter, the sum need not be 1.
        #[schemars(extend("examples" = [[0.25, 0.75]], "x-required" = "always"))]
        fractions: Option<Located<Vec<Located<Ratio>>>>,
        /// Meaning of the shares.
        #[schemars(example = &"volume", extend("default" = "number"))]
        by: Option<Located<ByFile>>,
    },
}

/// Quantity that the shares of a table of sizes refer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ByFile {
    /// Shares of the number of particles.
    Number,
    /// Shares of the volume, and so of the mass, as a sieve analysis gives them.
    Volume,
}
