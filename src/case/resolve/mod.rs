//! Turns a typed case into an experiment: checks every value, resolves names, units and amounts, and reports faults.

mod foreign;
mod gas;
mod length;
mod mesh;
mod missing;
mod output;
mod overlap;
mod pairs;
mod places;
mod region;
mod rotation;
mod scene;
mod settings;
mod sizes;
mod start;
mod table;
mod triangles;
mod walls;

use super::built_in;
use super::de::Located;
use super::diagnostic::Diagnostic;
use super::file::{CaseFile, Three};
use super::quantity::Quantity;
use super::rules::{is_within, range};
use super::source::{Origin, SourceKind, Sources};
use super::tree::CaseNode;
use crate::experiment::{Experiment, Model, Trajectories};
use crate::rotation::{ImpactRule, Rotation, TangentialLaw};
use nalgebra::Vector3;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

pub(super) use table::{leads_out, read_text};
use table::{read_bytes, text_of};

/// Choices made outside the case file.
#[derive(Clone, Debug, Default)]
pub struct VariantChoice {
    /// Model, if the command line or the variant names it.
    pub model: Option<Model>,
    /// Seed, if the command line names it.
    pub seed: Option<u64>,
    /// Name of the variant; that of the model if `None`.
    pub name: Option<String>,
    /// Name of the variant that it is compared with, if the case names one.
    pub against: Option<String>,
}

/// State of the check of a case: its texts, the warnings so far and the model.
pub(super) struct Resolver {
    /// All texts, for messages; tables of numbers are added as they are read.
    pub sources: Sources,
    /// Warnings for the user; the case can still run.
    pub warnings: Vec<Diagnostic>,
    /// Collision model of the run.
    pub model: Model,
}

/// Checks a case and turns it into an experiment; the list holds the warnings.
///
/// # Errors
/// The first fault, or all missing keys.
pub fn resolve(
    (file, tree): (&CaseFile, &CaseNode),
    choice: &VariantChoice,
    sources: Sources,
) -> Result<(Experiment, Vec<Diagnostic>), Diagnostic> {
    let typed = file.run.as_ref().and_then(|run| run.value.model.as_ref()).map(|model| model.value);
    let named = choice.model.or(typed);
    missing::refuse_missing((file, tree), named, &sources)?;
    // refuse_missing has refused a case without a model
    let mut resolver = Resolver { sources, warnings: Vec::new(), model: named.unwrap_or(Model::Hard) };
    let domain = resolver.domain(file)?;
    let species = resolver.species(file)?;
    let walls = resolver.walls(file, &domain, &species)?;
    let fluid = resolver.fluid(file, &domain, &species)?;
    let gravity = resolver.gravity(file)?;
    let contact = match &file.contact {
        Some(contact) => resolver.surface(&contact.value.restitution, &contact.value.friction)?,
        // refuse_missing accepts a missing table only for a single particle
        None => crate::scene::Surface { restitution: 1.0, friction: 0.0 },
    };
    let pairs = crate::scene::Pairs::default();
    let mut scene = crate::scene::Scene { domain, gravity, fluid, walls, contact, pairs, species, rotation: None };
    // the start needs to know of it; the law follows when all surfaces are known
    scene.rotation = Resolver::rotates(file).then_some(Rotation::new(TangentialLaw::Coulomb, ImpactRule::COULOMB));
    let start = resolver.start(file, &scene)?;
    resolver.warn_of_buoyancy(file, &scene);
    let soft = resolver.soft(file)?;
    scene.pairs = resolver.pairs(file, &scene, &soft)?;
    scene.rotation = resolver.rotation(file, &scene, &soft)?;
    let hard = resolver.hard(file)?;
    let hybrid = resolver.hybrid(file)?;
    let run = resolver.run(file, choice, &soft)?;
    let statistics = resolver.statistics(file)?;
    let name = choice.name.clone().unwrap_or_else(|| model_name(resolver.model).to_string());
    let experiment =
        Experiment { name, against: choice.against.clone(), scene, start, soft, hard, hybrid, run, statistics };
    resolver.check_step(file, &experiment)?;
    resolver.check_stability(file, &experiment)?;
    resolver.check_length(file, &experiment)?;
    resolver.check_drag(file, &experiment);
    resolver.check_trajectories(file, &experiment)?;
    Ok((experiment, resolver.warnings))
}

/// The trajectories that a case asks for.
///
/// # Errors
/// The time between them is out of range.
pub fn trajectories(file: &CaseFile, sources: Sources) -> Result<Option<Trajectories>, Diagnostic> {
    Resolver { sources, warnings: Vec::new(), model: Model::Hard }.trajectories(file)
}

/// `soft`, `hard` or `hybrid`.
pub(super) fn model_name(model: Model) -> &'static str {
    model.name()
}

/// A number as a user would type it: with a power of ten if it is very small or large.
fn short(number: f64) -> String {
    let plain = (1e-6..1e9).contains(&number.abs()) || number == 0.0;
    if plain { number.to_string() } else { format!("{number:e}") }
}

/// [SI] the components of a vector.
fn vector<const M: i8, const K: i8, const S: i8>(three: &Three<Quantity<M, K, S>>) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| three.value[axis].value.0)
}

impl Resolver {
    /// A required value; missing ones have been refused before, all at once.
    fn need<'a, T>(&self, value: &'a Option<T>, key: &str) -> Result<&'a T, Diagnostic> {
        value.as_ref().ok_or_else(|| Diagnostic::about("the case", format!("the required key `{key}` is missing")))
    }

    /// `key = value as typed`.
    fn as_typed<T>(&self, value: &Located<T>) -> String {
        format!("`{}` = {}", value.path, self.sources.typed(&value.origin))
    }

    /// An error about a value: `key = value` and the fault.
    fn refuse<T>(&self, value: &Located<T>, what: impl AsRef<str>) -> Diagnostic {
        self.sources.error(&value.origin, format!("{} {}", self.as_typed(value), what.as_ref()))
    }

    /// Adds a warning about a value to the list.
    fn warn(&mut self, origin: &Origin, message: impl Into<String>, help: impl Into<String>) {
        let warning = self.sources.warning(origin, message).help(help);
        // a file that several kinds name is read for each of them
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// [SI] a value if it is within the range that stands at its key; else an error with the range and a remedy.
    fn in_range<const M: i8, const K: i8, const S: i8>(
        &self,
        value: &Located<Quantity<M, K, S>>,
        help: impl AsRef<str>,
    ) -> Result<f64, Diagnostic> {
        let range = range(&value.path).unwrap_or_default();
        self.checked(value, |number| is_within(range, number), range, help)
    }

    /// [SI] a value if it is `good`; else an error with the allowed range and a remedy. For ranges that depend on other
    /// keys; fixed ones stand at their key.
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

    /// A whole number if it is within `from ..= to`.
    fn whole(&self, value: &Located<i64>, from: i64, to: i64, help: &str) -> Result<usize, Diagnostic> {
        if (from..=to).contains(&value.value) {
            return Ok(value.value as usize);
        }
        Err(self.refuse(value, format!("is out of range; allowed: {from} ..= {to}")).help(help))
    }

    /// The text of the file named by `name`, relative to the file in which it was typed; also its index as a source. A
    /// built-in text names built-in files.
    fn read_named(&mut self, name: &Located<String>) -> Result<(usize, Arc<str>), Diagnostic> {
        let (path, bytes, kind) = self.bytes_of(name)?;
        let text = text_of(&bytes).map_err(|why| self.unread(name, &path, &why))?;
        let source = self.sources.add_text(&path, text.clone(), kind);
        Ok((source, text))
    }

    /// The path and the bytes of the file named by `name`, and the kind of source that results.
    fn bytes_of(&self, name: &Located<String>) -> Result<(PathBuf, Vec<u8>, SourceKind), Diagnostic> {
        let path = self.path_of(name)?;
        let (bytes, kind) = match self.sources.get(&name.origin).map_or(SourceKind::File, |typed_in| typed_in.kind) {
            SourceKind::BuiltIn => {
                let none = || "no such file is built in".to_owned();
                (built_in::file(&path).map(<[u8]>::to_vec).ok_or_else(none), SourceKind::BuiltIn)
            }
            SourceKind::File | SourceKind::Argument => (read_bytes(&path), SourceKind::File),
        };
        let bytes = bytes.map_err(|why| self.unread(name, &path, &why))?;
        Ok((path, bytes, kind))
    }

    /// Path of the file named by `name`. A case may only read files in its own folder and below, so that a foreign case
    /// cannot read other data. Paths typed on the command line are not restricted.
    fn path_of(&self, name: &Located<String>) -> Result<PathBuf, Diagnostic> {
        let source = self.sources.get(&name.origin);
        let folder = source.map(|source| source.folder.clone()).unwrap_or_default();
        let named = Path::new(&name.value);
        let path = folder.join(named);
        let outside = named.components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir));
        let kind = source.map_or(SourceKind::Argument, |source| source.kind);
        if kind != SourceKind::Argument && (outside || kind == SourceKind::File && leads_out(&path, &folder)) {
            let what = if outside { "is not" } else { "is a link to what is not" };
            let help = format!(
                "put the file beside the case, or name it on the command line: --set {}={:?}",
                name.path, name.value
            );
            return Err(self.refuse(name, format!("{what} in the folder of the case or below")).help(help));
        }
        Ok(path)
    }

    /// The error about a file that could not be read.
    fn unread(&self, name: &Located<String>, path: &Path, why: &str) -> Diagnostic {
        let help = "the name is relative to the folder of the file that names it";
        self.refuse(name, format!("cannot be read: {why} ({})", path.display())).help(help)
    }
}
