//! Reads and checks the diameters of a species.

use super::Resolver;
use super::scene::unit_slip;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{ByFile, ParticlesFile, PlacedFile, SizesFile};
use crate::case::located::Located;
use crate::case::quantity::{Length, Ratio};
use crate::scene::{Fraction, SizeDistribution, Species};

/// [-] smallest fraction of a log-normal distribution that may remain between its cut-offs. The quantiles of a smaller
/// fraction would consist of rounding errors.
const LEAST_LEFT: f64 = 1e-6;

impl Resolver {
    /// [m] diameter of a species and its size distribution. The distribution is `None` if all particles have this
    /// diameter; otherwise the diameter is that of a sphere of the mean volume.
    pub(super) fn diameter(
        &self,
        kind: &Located<ParticlesFile>,
    ) -> Result<(f64, Option<SizeDistribution>), Diagnostic> {
        match (&kind.value.diameter, &kind.value.sizes) {
            (Some(diameter), _) => Ok((self.length(diameter)?, None)),
            (_, sizes) => {
                let sizes = self.sizes(self.need(sizes, "particles.diameter")?)?;
                Ok((sizes.mean_power(3).cbrt(), Some(sizes)))
            }
        }
    }

    /// [m] diameter of one particle in a list of placed particles.
    pub(super) fn own_diameter(&self, item: &Located<PlacedFile>, species: &Species) -> Result<f64, Diagnostic> {
        let (typed, sizes) = match (&item.value.diameter, &species.sizes) {
            (None, None) => return Ok(species.diameter),
            (Some(typed), None) => {
                let what = format!("is not used: all of \"{}\" have the same `diameter`", species.name);
                return Err(self.refuse(typed, what).help("leave it out, or give the kind `sizes`"));
            }
            (None, Some(_)) => {
                let message = format!("`{}.diameter` is missing: those of \"{}\" differ", item.path, species.name);
                return Err(self.sources.error(&item.origin, message).help("add it beside the position"));
            }
            (Some(typed), Some(sizes)) => (typed, sizes),
        };
        let (least, most) = (sizes.smallest(), sizes.largest());
        let allowed = format!("{least:e} ..= {most:e} m, the ends of `sizes`");
        self.checked(typed, |d| (least..=most).contains(&d), &allowed, "a particle of this kind")
    }

    fn length(&self, typed: &Located<Length>) -> Result<f64, Diagnostic> {
        let d = typed.value.0;
        let help = if d > 0.0 { unit_slip(d) } else { "a sphere has a positive diameter".into() };
        self.in_range(typed, help)
    }

    fn sizes(&self, typed: &Located<SizesFile>) -> Result<SizeDistribution, Diagnostic> {
        match &typed.value {
            SizesFile::Uniform { from, to } => {
                let [from, to] = self.ends(from, to)?;
                Ok(SizeDistribution::Uniform { from, to })
            }
            SizesFile::LogNormal { median, geometric_deviation, from, to } => {
                let [from, to] = self.ends(from, to)?;
                let middle = self.need(median, "particles.sizes.log_normal.median")?;
                let median = self.length(middle)?;
                let key = "particles.sizes.log_normal.geometric_deviation";
                let help = "a ratio of diameters: 1.3 is a narrow powder, 2 a wide one";
                let deviation = self.in_range(self.need(geometric_deviation, key)?, help)?;
                let sizes = SizeDistribution::LogNormal { median, geometric_deviation: deviation, from, to };
                let left = sizes.left();
                if left < LEAST_LEFT {
                    let what = format!("leaves {left:.1e} of the distribution between `from` and `to`");
                    return Err(self.refuse(middle, what).help("the cut-offs should be on both sides of the median"));
                }
                Ok(sizes)
            }
            SizesFile::Table { diameters, fractions, by } => {
                let diameters = self.need(diameters, "particles.sizes.table.diameters")?;
                let fractions = self.need(fractions, "particles.sizes.table.fractions")?;
                let by = by.as_ref().map_or(ByFile::Number, |by| by.value);
                self.size_table(diameters, fractions, by).map(SizeDistribution::Table)
            }
        }
    }

    /// [m] smallest and largest diameter of a distribution.
    fn ends(&self, from: &Option<Located<Length>>, to: &Option<Located<Length>>) -> Result<[f64; 2], Diagnostic> {
        let (from, to) = (self.need(from, "particles.sizes.from")?, self.need(to, "particles.sizes.to")?);
        let (least, most) = (self.length(from)?, self.length(to)?);
        if least >= most {
            let what = format!("is not less than {}", self.as_typed(to));
            return Err(self.refuse(from, what).help("for one size give `diameter`"));
        }
        Ok([least, most])
    }

    fn size_table(
        &self,
        diameters: &Located<Vec<Located<Length>>>,
        fractions: &Located<Vec<Located<Ratio>>>,
        by: ByFile,
    ) -> Result<Vec<Fraction>, Diagnostic> {
        if diameters.value.is_empty() || diameters.value.len() != fractions.value.len() {
            let (some, others) = (diameters.value.len(), fractions.value.len());
            let what = format!("has {others} shares for {some} diameters");
            return Err(self.refuse(fractions, what).help("one share for each diameter"));
        }
        let mut rows = Vec::new();
        for (diameter, fraction) in diameters.value.iter().zip(&fractions.value) {
            let d = self.length(diameter)?;
            let help = "leave out diameters that no particle has";
            let share = self.in_range(fraction, help)?;
            let share = match by {
                ByFile::Number => share,
                // a share of the volume becomes a share of the number after division by the volume of one particle
                ByFile::Volume => share / d.powi(3),
            };
            rows.push(Fraction { diameter: d, share });
        }
        rows.sort_by(|a, b| a.diameter.total_cmp(&b.diameter));
        let total: f64 = rows.iter().map(|row| row.share).sum();
        rows.iter_mut().for_each(|row| row.share /= total);
        Ok(rows)
    }
}
