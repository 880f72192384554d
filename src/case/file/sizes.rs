//! `sizes` of `[[particles]]`.

use crate::case::de::Located;
use crate::case::quantity::{Length, Ratio};
use schemars::JsonSchema;
use serde::Deserialize;

/// `sizes` of `[[particles]]`: one distribution of diameters, all of them between 1e-7 m and 1 m.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SizesFile {
    /// Every diameter between two is as likely.
    Uniform {
        /// The smallest diameter.
        #[schemars(example = &"300 um", extend("x-required" = "always"))]
        from: Option<Located<Length>>,
        /// The largest diameter.
        #[schemars(example = &"500 um", extend("x-required" = "always"))]
        to: Option<Located<Length>>,
    },
    /// The logarithms of the diameters are normal, and cut off at both ends.
    LogNormal {
        /// Median of the diameters, by number, before the ends were cut off.
        #[schemars(example = &"400 um", extend("x-required" = "always"))]
        median: Option<Located<Length>>,
        /// Geometric standard deviation before the ends were cut off: two thirds of the diameters are between the median divided by it and the
        /// median times it.
        #[schemars(example = 1.3, extend("x-required" = "always"))]
        geometric_deviation: Option<Located<Ratio>>,
        /// The smallest diameter. The time step of soft spheres and the window of drag must resolve spheres as small as this.
        #[schemars(example = &"200 um", extend("x-required" = "always"))]
        from: Option<Located<Length>>,
        /// The largest diameter.
        #[schemars(example = &"800 um", extend("x-required" = "always"))]
        to: Option<Located<Length>>,
    },
    /// A few diameters, such as those of sieves.
    Table {
        /// The diameters.
        #[schemars(extend("examples" = [["300 um", "400 um"]], "x-required" = "always"))]
        diameters: Option<Located<Vec<Located<Length>>>>,
        /// Their shares, in the same order; they count relative to their sum.
        #[schemars(extend("examples" = [[0.25, 0.75]], "x-required" = "always"))]
        fractions: Option<Located<Vec<Located<Ratio>>>>,
        /// What the shares are of.
        #[schemars(example = &"volume", extend("default" = "number"))]
        by: Option<Located<ByFile>>,
    },
}

/// What the shares of a table of sizes are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ByFile {
    /// Of the number of particles.
    Number,
    /// Of their volume, and so of their mass, as sieves give it.
    Volume,
}
