//! Reads `judge.toml`, the settings of a comparison of files: files, columns, units, times and margins (largest
//! accepted differences).

use crate::case::de::read;
use crate::case::located::Located;
use crate::case::quantity::{Exponents, Ratio, dimension_name, si_unit, unit};
use crate::case::{Diagnostic, Sources, read_text, tree};
use serde::Deserialize;
use std::path::Path;

/// Largest number of slices of the box. Each slice adds seven columns to the table.
const MOST_SLICES: u32 = 1000;

/// Contents of the file `judge.toml`, as typed.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JudgeFile {
    /// [-] margin of equivalence (largest accepted difference) of all quantities without a margin of their own, divided
    /// by the scale of each quantity. Default: 0.01, unless the command line gives a margin.
    pub margin: Option<Located<Ratio>>,
    /// Table `[a]`: first side of the comparison, whose data are compared with the reference.
    #[serde(default)]
    pub a: SideFile,
    /// Table `[b]`: second side of the comparison, the reference.
    #[serde(default)]
    pub b: SideFile,
    /// Quantities that are compared. Default: all columns with the same name on both sides.
    #[serde(default)]
    pub quantities: Vec<Located<QuantityFile>>,
}

/// Table `[a]` or `[b]` of `judge.toml`: files of one side of the comparison, and the meaning of their times.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SideFile {
    /// Paths of the files of this side of the comparison, one per replica (run with its own seed), relative to the
    /// folder of `judge.toml`. Without them the command line must name the files.
    pub files: Option<Vec<Located<String>>>,
    /// Name of this side of the comparison in sentences. Default: name of its first file.
    pub name: Option<String>,
    /// Name of the column of times. Default: the first known name, such as `t_s` or `Time`.
    pub time: Option<Located<String>>,
    /// Unit of the times, such as "ms", or "1e-5 s" for a count of time steps. Without it the unit is s, unless the
    /// column counts steps; the length of a step is then unknown.
    pub time_unit: Option<Located<String>>,
    /// Start of averaging, in the unit of the column of times. Default: the time from which the data are steady.
    pub from: Option<Located<f64>>,
    /// Number of equal slices along y in which the particles of a trajectory are averaged. Default: 1.
    pub slices: Option<Located<u32>>,
}

/// Table `[[quantities]]` of `judge.toml`: one quantity that is compared.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QuantityFile {
    /// Name of the quantity in sentences. Default: name of the column of side B.
    pub name: Option<String>,
    /// Name of the column of side A or, in a table of single values, label of a value.
    pub a: Located<String>,
    /// Name of the column of side B or, in a table of single values, label of a value.
    pub b: Located<String>,
    /// Unit of the column of side A, such as "mm/s". Both sides have a unit or neither; without units, the values are
    /// compared as they are.
    pub a_unit: Option<Located<String>>,
    /// Unit of the column of side B, such as "mm/s"; absent if `a_unit` is absent.
    pub b_unit: Option<Located<String>>,
    /// Kind of comparison, averages or curves. Default: averages if both sides are steady, else curves.
    pub compare: Option<JudgedAs>,
    /// [-] margin of equivalence (largest accepted difference) of this quantity, divided by its scale. Default: the
    /// margin of all quantities.
    pub margin: Option<Located<Ratio>>,
    /// Scale by which differences are divided, in the SI unit of the quantity or, if no units are given, in the unit of
    /// the columns. Default: magnitude of the value of side B.
    pub scale: Option<Located<f64>>,
}

/// Kind of comparison of two series over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JudgedAs {
    /// Averages over the time in which the series are steady.
    Average,
    /// Curves over time, with errors from replicas (files of runs with different seeds).
    Curve,
}

impl JudgeFile {
    /// Reads the file `judge.toml`, and returns its contents and its text. Without a file, all settings have their
    /// defaults.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, is not TOML, or has an unknown key or an unsuitable value.
    pub fn read(path: Option<&Path>, sources: &mut Sources) -> Result<(Self, String), Diagnostic> {
        let Some(path) = path else { return Ok(Default::default()) };
        let name = path.display().to_string();
        let text = read_text(path).map_err(|why| Diagnostic::about(&name, format!("cannot read `{name}`: {why}")))?;
        let source = sources.add_file(path, text.clone());
        let tree = tree::parse(&text, source, sources)?;
        let file: Self = read(&tree).map_err(|why| why.diagnostic(sources))?;
        let margins = file.quantities.iter().filter_map(|one| one.value.margin.as_ref()).chain(&file.margin);
        for margin in margins {
            if !(margin.value.0 > 0.0 && margin.value.0 < 1.0) {
                let message = format!("`{}` = {} is no margin", margin.path, sources.typed(&margin.origin));
                return Err(sources
                    .error(&margin.origin, message)
                    .help("a margin is a share between 0 and 1, such as \"1 %\""));
            }
        }
        for scale in file.quantities.iter().filter_map(|one| one.value.scale.as_ref()) {
            if !(scale.value > 0.0 && scale.value.is_finite()) {
                let message = format!("`{}` = {} is no scale", scale.path, sources.typed(&scale.origin));
                return Err(sources.error(&scale.origin, message).help("a scale is a number greater than 0"));
            }
        }
        for slices in [&file.a, &file.b].into_iter().filter_map(|side| side.slices.as_ref()) {
            if !(1..=MOST_SLICES).contains(&slices.value) {
                let message = format!("`{}` = {} is no number of slices", slices.path, slices.value);
                return Err(sources.error(&slices.origin, message).help(format!("1 to {MOST_SLICES} slices")));
            }
        }
        Ok((file, text.to_string()))
    }
}

impl SideFile {
    /// [s] length of the unit of times, in seconds; `None` if the settings give no unit.
    ///
    /// # Errors
    /// Returns an error if the unit is not a unit of time.
    pub fn time_factor(&self, sources: &Sources) -> Result<Option<f64>, Diagnostic> {
        let Some(given) = &self.time_unit else { return Ok(None) };
        match size(given, sources)? {
            ([0, 0, 1], factor) => Ok(Some(factor)),
            (other, _) => {
                let message = format!(
                    "`{}` = \"{}\" is {}, but a time belongs here",
                    given.path,
                    given.value,
                    dimension_name(other)
                );
                Err(sources.error(&given.origin, message).help("write \"s\", or \"1e-5 s\" for steps of this length"))
            }
        }
    }
}

impl QuantityFile {
    /// Factors that convert the columns of A and B to the SI unit, and this unit. Without units the factors are 1 and
    /// the unit is empty.
    ///
    /// # Errors
    /// Returns an error if only one side has a unit, or if the units of the sides have different dimensions.
    pub fn units(&self, origin: &Located<Self>, sources: &Sources) -> Result<([f64; 2], String), Diagnostic> {
        let (a, b) = match (&self.a_unit, &self.b_unit) {
            (None, None) => return Ok(([1.0; 2], String::new())),
            (Some(a), Some(b)) => (a, b),
            (Some(_), None) | (None, Some(_)) => {
                let message = format!("`{}` has a unit for one side only", origin.path);
                return Err(sources.error(&origin.origin, message).help("give both `a_unit` and `b_unit`, or neither"));
            }
        };
        let [first, second] = [size(a, sources)?, size(b, sources)?];
        if first.0 != second.0 {
            let (wanted, found) = (dimension_name(first.0), dimension_name(second.0));
            let message =
                format!("`{}` = \"{}\" is {found}, but `{}` = \"{}\" is {wanted}", b.path, b.value, a.path, a.value);
            return Err(sources.error(&b.origin, message).help("both sides need units of one dimension"));
        }
        Ok(([first.1, second.1], si_unit(first.0)))
    }
}

/// Dimension of a unit, as exponents of the base units, and the size of the unit in SI units.
fn size(given: &Located<String>, sources: &Sources) -> Result<(Exponents, f64), Diagnostic> {
    unit(&given.value).map_err(|why| {
        let error = sources.error(&given.origin, format!("`{}` = \"{}\" {}", given.path, given.value, why.message));
        error.help(why.help.unwrap_or_else(|| "write a unit such as \"m/s\"".into()))
    })
}
