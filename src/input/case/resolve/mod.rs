//! Turns a typed case into an experiment: checks all values, converts names, units and amounts, and reports errors. A
//! variant is the case with one collision model and some settings.

mod coupling;
mod foreign;
mod gas;
mod length;
mod mesh;
mod missing;
mod motion;
mod observe;
mod openings;
mod output;
mod overlap;
mod pairs;
mod places;
mod reference;
mod region;
mod restitution;
mod rotation;
mod scene;
mod settings;
mod shear;
mod sizes;
mod start;
mod table;
mod thermostat;
mod turbulence;
mod walls;

use super::built_in;
use super::diagnostic::Diagnostic;
use super::file::{CaseFile, Three};
use super::located::Located;
use super::quantity::Quantity;
use super::rules::{is_within, range};
use super::source::{Origin, SourceKind, Sources};
use super::tree::CaseNode;
use crate::case::against::AgainstFile;
use crate::experiment::{Experiment, Model, Trajectories};
use crate::predict::contact::usual_impact;
use crate::rotation::{ImpactRule, Rotation, TangentialLaw};
use nalgebra::Vector3;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

pub use foreign::{FramesAndWarnings, ParticleFrame, particle_frames};
pub(super) use table::leads_out;
pub use table::read_text;
use table::{read_bytes, text_of};

/// Model, seed, name and reference (variant or table with which it is compared) of one variant, as given on the
/// command line or in `[[compare]]`.
#[derive(Clone, Debug, Default)]
pub struct VariantChoice {
    /// Collision model that the command line or the variant gives; `None` if the case determines the model.
    pub model: Option<Model>,
    /// Seed of the random numbers that the command line gives; `None` if the case determines the seed.
    pub seed: Option<u64>,
    /// Name of the variant; `None` means the name of its model.
    pub name: Option<String>,
    /// Reference with which this variant is compared; `None` if the case gives none.
    pub against: Option<Located<AgainstFile>>,
}

/// Data that are kept while a case is turned into an experiment: source texts, warnings and the model.
pub(super) struct Resolver {
    /// Texts of all files and arguments from which the case was read, for messages. Texts of data tables are added when
    /// they are read.
    pub sources: Sources,
    /// Warnings so far; a case with warnings can still be run.
    pub warnings: Vec<Diagnostic>,
    /// Collision model of the run.
    pub model: Model,
}

/// Checks a case and turns it into an experiment. The returned list contains the warnings.
///
/// # Errors
/// The first error in the case, or all missing keys.
pub fn resolve(
    (file, tree): (&CaseFile, &CaseNode),
    choice: &VariantChoice,
    sources: Sources,
) -> Result<(Experiment, Vec<Diagnostic>), Diagnostic> {
    let typed = file.run.as_ref().and_then(|run| run.value.model.as_ref()).map(|model| model.value);
    let named = choice.model.or(typed);
    missing::refuse_missing((file, tree), named, &sources)?;
    // a case without a model has been refused above
    let mut resolver = Resolver { sources, warnings: Vec::new(), model: named.unwrap_or(Model::Hard) };
    let domain = resolver.domain(file)?;
    let species = resolver.species(file)?;
    let walls = resolver.walls(file, &domain, &species)?;
    let fluid = resolver.fluid(file, &domain, &species)?;
    let gravity = resolver.gravity(file)?;
    let contact = match &file.contact {
        Some(contact) => resolver.surface(&contact.value.restitution, &contact.value.friction)?,
        // a case without the table `[contact]` has passed the check above only if it has at most one particle
        None => crate::scene::Surface::new(1.0, 0.0),
    };
    let pairs = crate::scene::Pairs::default();
    let (rotation, thermostat) = (None, resolver.thermostat(file)?);
    let (outlets, inlets) = (Vec::new(), Vec::new());
    let mut scene = crate::scene::Scene {
        domain,
        gravity,
        fluid,
        walls,
        contact,
        pairs,
        species,
        rotation,
        thermostat,
        outlets,
        inlets,
    };
    resolver.check_shear(file, &scene)?;
    resolver.added_mass(file, &mut scene)?;
    resolver.buoyancy(file, &mut scene);
    // the start depends on whether spheres rotate; the laws of rotation replace this value below, when all surfaces are
    // known
    scene.rotation = Resolver::rotates(file).then_some(Rotation::new(TangentialLaw::Coulomb, ImpactRule::COULOMB));
    scene.outlets = resolver.outlets(file, &scene)?;
    let start = resolver.start(file, &scene)?;
    scene.inlets = resolver.inlets(file, &scene, &start)?;
    let soft = resolver.soft(file)?;
    let usual = usual_impact(&scene, &start);
    scene.represent(usual);
    scene.pairs = resolver.pairs(file, &scene, &soft, usual)?;
    resolver.check_restitution(file, &scene, &soft)?;
    scene.rotation = resolver.rotation(file, &scene, &soft)?;
    let hard = resolver.hard(file)?;
    let hybrid = resolver.hybrid(file)?;
    let dsmc = resolver.dsmc(file, &scene, &start)?;
    let run = resolver.run(file, choice, &soft)?;
    let statistics = resolver.statistics(file)?;
    let observe = resolver.observe(file, &scene)?;
    let name = choice.name.clone().unwrap_or_else(|| model_name(resolver.model).to_string());
    let against = choice.against.as_ref().map(|against| resolver.reference(&against.value, &scene)).transpose()?;
    let experiment = Experiment { name, against, scene, start, soft, hard, hybrid, dsmc, run, statistics, observe };
    resolver.check_step(file, &experiment)?;
    resolver.check_stability(file, &experiment)?;
    resolver.check_length(file, &experiment)?;
    resolver.check_motion(file, &experiment);
    resolver.check_drag(file, &experiment);
    resolver.check_eddies(file, &experiment);
    resolver.check_coupling(file, &experiment)?;
    resolver.check_thermostat(file, &experiment);
    resolver.check_trajectories(file, &experiment)?;
    resolver.check_observe(file, &experiment)?;
    resolver.check_openings(file, &experiment.scene)?;
    Ok((experiment, resolver.warnings))
}

/// Settings of trajectory files that a case requests; `None` if it requests none.
///
/// # Errors
/// The time between two instants of the trajectories is out of range.
pub fn trajectories(file: &CaseFile, sources: Sources) -> Result<Option<Trajectories>, Diagnostic> {
    Resolver { sources, warnings: Vec::new(), model: Model::Hard }.trajectories(file)
}

/// Name of a collision model: `soft`, `hard`, `hybrid` or `dsmc`.
pub(super) fn model_name(model: Model) -> &'static str {
    model.name()
}

/// Text of a number as a user would type it: with a power of ten if the number is very small or large.
fn short(number: f64) -> String {
    let plain = (1e-6..1e9).contains(&number.abs()) || number == 0.0;
    if plain { number.to_string() } else { format!("{number:e}") }
}

/// [SI] components of a typed vector.
fn vector<const M: i8, const K: i8, const S: i8>(three: &Three<Quantity<M, K, S>>) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| three.value[axis].value.0)
}

impl Resolver {
    /// Returns the value of a required key; `key` is its name in the error. Keys that every case requires have been
    /// checked before, all in one message. So an error here is about a key that only some cases require.
    fn need<'a, T>(&self, value: &'a Option<T>, key: &str) -> Result<&'a T, Diagnostic> {
        value.as_ref().ok_or_else(|| Diagnostic::about("the case", format!("the required key `{key}` is missing")))
    }

    /// Text `key = value` with the value as the user typed it, for messages.
    fn as_typed<T>(&self, value: &Located<T>) -> String {
        format!("`{}` = {}", value.path, self.sources.typed(&value.origin))
    }

    /// Creates an error about a value: `key = value`, then what is wrong.
    fn refuse<T>(&self, value: &Located<T>, what: impl AsRef<str>) -> Diagnostic {
        self.sources.error(&value.origin, format!("{} {}", self.as_typed(value), what.as_ref()))
    }

    /// Adds a warning about a value to the list of warnings.
    fn warn(&mut self, origin: &Origin, message: impl Into<String>, help: impl Into<String>) {
        let warning = self.sources.warning(origin, message).help(help);
        // if several species name the same file, it is read once for each of them, but one warning is enough
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// [SI] value of a key within the range declared with the key. If the value is out of range, the error contains the
    /// range and the remedy `help`.
    fn in_range<const M: i8, const K: i8, const S: i8>(
        &self,
        value: &Located<Quantity<M, K, S>>,
        help: impl AsRef<str>,
    ) -> Result<f64, Diagnostic> {
        let range = range(&value.path).unwrap_or_default();
        self.checked(value, |number| is_within(range, number), range, help)
    }

    /// [SI] value of a key that fulfils the condition `good`. Otherwise the error contains the `allowed` range and the
    /// remedy `help`. This function checks ranges that depend on other keys; fixed ranges are declared with the key.
    fn checked<const M: i8, const K: i8, const S: i8>(
        &self,
        value: &Located<Quantity<M, K, S>>,
        good: impl Fn(f64) -> bool,
        allowed: &str,
        help: impl AsRef<str>,
    ) -> Result<f64, Diagnostic> {
        let number = value.value.0;
        if good(number) {
            return Ok(number);
        }
        Err(self.refuse(value, format!("is out of range; allowed: {allowed}")).help(help.as_ref()))
    }

    /// Whole number of a key within `from ..= to`. If the number is out of range, the error contains the range and the
    /// remedy `help`.
    fn whole(&self, value: &Located<i64>, from: i64, to: i64, help: &str) -> Result<usize, Diagnostic> {
        if (from..=to).contains(&value.value) {
            return Ok(value.value as usize);
        }
        Err(self.refuse(value, format!("is out of range; allowed: {from} ..= {to}")).help(help))
    }

    /// Reads the text of the file `name`, and returns its source index and the text. The path is relative to the folder
    /// of the file that contains the name. A name in a built-in text refers to a built-in file. If a calling program
    /// has given a table of this name, that table is returned instead.
    fn read_named(&mut self, name: &Located<String>) -> Result<(usize, Arc<str>), Diagnostic> {
        if let Some(given) = self.sources.table(&name.value) {
            return Ok(given);
        }
        let (path, bytes, kind) = self.bytes_of(name)?;
        let text = text_of(&bytes).map_err(|why| self.unread(name, &path, &why))?;
        let source = self.sources.add_text(&path, text.clone(), kind);
        Ok((source, text))
    }

    /// Path and bytes of the file `name`, and the kind of source: a file on the disk or a built-in one.
    fn bytes_of(&self, name: &Located<String>) -> Result<(PathBuf, Vec<u8>, SourceKind), Diagnostic> {
        let path = self.path_of(name)?;
        let (bytes, kind) = match self.sources.get(&name.origin).map_or(SourceKind::File, |typed_in| typed_in.kind) {
            SourceKind::BuiltIn => {
                let none = || "no such file is built in".to_owned();
                (built_in::file(&path).map(<[u8]>::to_vec).ok_or_else(none), SourceKind::BuiltIn)
            }
            SourceKind::File | SourceKind::Argument | SourceKind::Values | SourceKind::Table => {
                (read_bytes(&path), SourceKind::File)
            }
        };
        let bytes = bytes.map_err(|why| self.unread(name, &path, &why))?;
        Ok((path, bytes, kind))
    }

    /// Path of the file `name`. A case may name only files in its own folder and in folders below it, so that a case
    /// from another person cannot read other data. Paths typed on the command line, or given by a calling program, are
    /// not restricted.
    fn path_of(&self, name: &Located<String>) -> Result<PathBuf, Diagnostic> {
        let source = self.sources.get(&name.origin);
        let folder = source.map(|source| source.folder.clone()).unwrap_or_default();
        let named = Path::new(&name.value);
        let path = folder.join(named);
        let outside = named.components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir));
        let kind = source.map_or(SourceKind::Argument, |source| source.kind);
        let is_restricted = matches!(kind, SourceKind::File | SourceKind::BuiltIn);
        if is_restricted && (outside || kind == SourceKind::File && leads_out(&path, &folder)) {
            let what = if outside { "is not" } else { "is a link to what is not" };
            let help = format!(
                "put the file beside the case, or name it on the command line: --set {}={:?}",
                name.path, name.value
            );
            return Err(self.refuse(name, format!("{what} in the folder of the case or below")).help(help));
        }
        Ok(path)
    }

    /// Creates the error about a file that could not be read.
    fn unread(&self, name: &Located<String>, path: &Path, why: &str) -> Diagnostic {
        let help = "the name is relative to the folder of the file that names it";
        self.refuse(name, format!("cannot be read: {why} ({})", path.display())).help(help)
    }
}
