//! Plan of a sensitivity study: its runs, without duplicates, and the runs that are compared for each factor (change of
//! the case). Replicas are runs with different seeds.

use super::factors::{KNOWN, own};
use crate::case::{Case, Checked, fingerprint};
use crate::cli::Sensitivity;
use crate::experiment::{Amount, Experiment, Model};
use crate::output::sensitivity::OmittedFactor;
use crate::predict::transient::fades;
use crate::runs::StudyError;
use crate::study::plan::any_model;
use crate::study::replicas::replicas;

/// Default number of replicas (runs with different seeds) in a study of many particles that lose energy and are not
/// kept moving, so that no run is steady. Student's t of a difference then has 14 degrees of freedom.
const REPLICAS: u16 = 8;

/// Reason for leaving out a factor (change of the case) if the user has named other factors.
pub const NOT_ASKED: &str = "not asked for";

/// Largest number of particles for which runs are compared by the paths of the particles. Such a comparison needs no
/// replicas (runs with different seeds).
const FEW: usize = 50;

/// Runs that are compared for a factor (change of the case), given by their indices in the plan.
#[derive(Clone, Debug, PartialEq)]
pub enum Compared {
    /// Difference of two runs: the run with the second index minus the run with the first index.
    Against(usize, usize),
    /// Result extrapolated from several runs to infinite stiffness, minus the result of the first run. Each entry has
    /// the index of a run, and the depth of its overlaps divided by that of the first run [-]. The results are
    /// extrapolated to the depth 0, which belongs to infinite stiffness.
    Extrapolated(Vec<(usize, f64)>),
}

/// Factor (change of the case) whose runs are planned.
pub struct PlannedFactor {
    /// Name of the factor on the command line. A factor that the user defines has the name of its key.
    pub name: String,
    /// Title of the factor (change of the case) in a sentence, such as "the stiffness".
    pub title: String,
    /// Runs that are compared for the factor.
    pub compared: Compared,
    /// Change from the old value to the new one, as text for the report.
    pub change: String,
    /// Reason for the size of the change, as text for the report.
    pub why: String,
    /// Change of the case that leaves out a model; `None` if the factor does not leave out a model. It is set by
    /// `diptych needs`.
    pub simpler: Option<Simplification>,
}

/// Change of the richest case (the case with all models) that leaves out one model.
#[derive(Clone, Debug, Default)]
pub struct Simplification {
    /// Changes of keys of the case, in the form `key=value`.
    pub sets: Vec<String>,
    /// Collision model of the changed case; `None` if it is not changed.
    pub model: Option<Model>,
    /// Change of the experiment that no key can make, because it removes a table of the case; `None` if keys suffice.
    pub edit: Option<fn(&mut Experiment)>,
}

impl PlannedFactor {
    /// Factor (change of the case) that compares the run with the index `run` with the run with the index `base`.
    pub fn against(base: usize, run: usize, change: impl Into<String>, why: impl Into<String>) -> Self {
        Self::new(Compared::Against(base, run), change.into(), why.into())
    }

    /// Factor (change of the case) that compares the extrapolation of several runs to infinite stiffness with the
    /// first run. Each entry of `runs` has the index of a run, and the depth of its overlaps divided by that of the
    /// first run [-].
    pub fn extrapolated(runs: Vec<(usize, f64)>, change: String, why: String) -> Self {
        Self::new(Compared::Extrapolated(runs), change, why)
    }

    fn new(compared: Compared, change: String, why: String) -> Self {
        Self { name: String::new(), title: String::new(), compared, change, why, simpler: None }
    }

    /// Indices of the changed runs of the factor (change of the case), then indices of the runs with which they are
    /// compared.
    pub fn sides(&self) -> [Vec<usize>; 2] {
        match &self.compared {
            Compared::Against(base, run) => [vec![*run], vec![*base]],
            Compared::Extrapolated(runs) => {
                [runs.iter().skip(1).map(|one| one.0).collect(), runs.iter().take(1).map(|one| one.0).collect()]
            }
        }
    }
}

/// One run of the study, with the changes of the case by which it is made.
pub struct PlannedRun {
    /// Experiment of the run, with the seed of its first replica (run with one of several seeds).
    pub experiment: Experiment,
    /// Changes of the case, in the form in which a user types them.
    pub set: String,
    hash: String,
}

/// Runs and factors (changes of the case) of a sensitivity study. The first run is that of the unchanged case.
pub struct SensitivityPlan<'a> {
    case: &'a Case,
    seed: Option<u64>,
    model: Option<Model>,
    /// Changes of keys of the case that apply to all runs.
    base: Vec<String>,
    /// Runs of the study, without duplicates.
    pub runs: Vec<PlannedRun>,
    /// Factors (changes of the case) that are studied, the built-in ones first.
    pub factors: Vec<PlannedFactor>,
    /// Factors (changes of the case) that are not studied, each with the reason.
    pub left_out: Vec<OmittedFactor>,
    /// Assumptions that were made when models were added to the case, as text for the report.
    pub assumed: Vec<String>,
    /// Number of replicas (runs with different seeds) of each run.
    pub replicas: u16,
}

impl<'a> SensitivityPlan<'a> {
    /// Plans the runs of the factors that the user has requested.
    ///
    /// # Errors
    /// Returns an error if the unchanged case cannot run. It also returns an error if a requested factor is unknown, is
    /// named twice, or makes no sense for the case.
    pub fn new(case: &'a Case, args: &Sensitivity) -> Result<(Self, Checked), StudyError> {
        let seed = args.runs.effort.seed;
        let checked = match args.runs.model {
            Some(model) => case.experiment(Some(model), seed)?,
            None => any_model(case, seed)?,
        };
        let mut plan = Self::begin(case, args, (&checked.0, "as it is"), Vec::new())?;
        plan.choose(args)?;
        for text in &args.vary {
            let name = text.split('=').next().unwrap_or(text).trim().to_owned();
            let factor =
                own(&mut plan, text).map_err(|why| StudyError::Input(format!("error: --vary {text}: {why}")))?;
            plan.factors.push(PlannedFactor { title: format!("`{name}`"), name, ..factor });
        }
        plan.refuse_nothing()?;
        Ok((plan, checked))
    }

    /// Begins a plan whose first run is the experiment `reference` with the name `name`. The list `base` has the
    /// changes of the case that apply to all runs.
    ///
    /// # Errors
    /// Returns an error if the reference cannot have the requested number of replicas.
    pub fn begin(
        case: &'a Case,
        args: &Sensitivity,
        (reference, name): (&Experiment, &str),
        base: Vec<String>,
    ) -> Result<Self, StudyError> {
        let (seed, reference) = (args.runs.effort.seed, reference.clone());
        let placed = reference.start.iter().all(|population| matches!(population.amount, Amount::Placed(_)));
        // if replicas are impossible for this case, the error is found before anything is planned
        replicas(&reference, args.runs.replicas.unwrap_or(1))?;
        let transient = fades(&reference) && !placed && reference.count() > FEW;
        let count = args.runs.replicas.unwrap_or(if transient { REPLICAS } else { 1 });
        let model = Some(reference.model());
        let set = base.join(", ");
        let (runs, factors, left_out, assumed) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut plan = Self { case, seed, model, base, runs, factors, left_out, assumed, replicas: count };
        plan.enlist(Experiment { name: name.into(), against: None, ..reference }, set)?;
        Ok(plan)
    }

    /// Returns an error if the plan has no factor (change of the case).
    ///
    /// # Errors
    /// The message of the error gives the reasons why factors are left out.
    pub fn refuse_nothing(&self) -> Result<(), StudyError> {
        if !self.factors.is_empty() {
            return Ok(());
        }
        let why = self.left_out.iter().map(|one| format!("\n  {}: {}", one.name, one.why)).collect::<String>();
        Err(StudyError::Input(format!("error: there is no factor to look at{why}")))
    }

    /// Plans the built-in factors that the user has named; all of them if none is named.
    fn choose(&mut self, args: &Sensitivity) -> Result<(), StudyError> {
        let mut wanted: Vec<(&str, Option<&str>)> = Vec::new();
        for text in &args.factors {
            let (name, size) =
                text.split_once('=').map_or((text.trim(), None), |(name, size)| (name.trim(), Some(size.trim())));
            if KNOWN.iter().all(|known| known.name != name) {
                let names: Vec<&str> = KNOWN.iter().map(|known| known.name).collect();
                return Err(StudyError::Input(format!(
                    "error: --factors: there is no factor `{name}`\nhelp: there are {}; --vary KEY=VALUE makes one of any key",
                    names.join(", ")
                )));
            }
            if wanted.iter().any(|(other, _)| *other == name) {
                return Err(StudyError::Input(format!("error: --factors names `{name}` twice")));
            }
            wanted.push((name, size));
        }
        for known in &KNOWN {
            let asked = wanted.iter().find(|(name, _)| *name == known.name);
            if asked.is_none() && !(args.factors.is_empty()) {
                self.left_out.push(OmittedFactor { name: known.name.into(), why: NOT_ASKED.into() });
                continue;
            }
            let size = asked.and_then(|(_, size)| *size);
            match (known.make)(self, size) {
                Ok(factor) => {
                    self.factors.push(PlannedFactor { name: known.name.into(), title: known.title.into(), ..factor });
                }
                Err(why) if asked.is_some() => {
                    return Err(StudyError::Input(format!("error: --factors {}: {why}", known.name)));
                }
                Err(why) => self.left_out.push(OmittedFactor { name: known.name.into(), why }),
            }
        }
        Ok(())
    }

    /// Experiment of the first run, with which all changed runs are compared.
    pub fn reference(&self) -> &Experiment {
        &self.runs[self.first()].experiment
    }

    /// Index of the first run, with which all changed runs are compared.
    pub fn first(&self) -> usize {
        0
    }

    /// Experiment of the run with the index `place`.
    pub fn run(&self, place: usize) -> &Experiment {
        &self.runs[place].experiment
    }

    /// Index of the run of the case with soft spheres. The run is added to the plan if it is missing.
    ///
    /// # Errors
    /// Returns the reason, as text, why the case cannot run with soft spheres.
    pub fn soft(&mut self) -> Result<usize, String> {
        self.add("soft", &[], Some(Model::Soft), None)
    }

    /// Index of the run of the case with hard spheres. The run is added to the plan if it is missing.
    ///
    /// # Errors
    /// Returns the reason, as text, why the case cannot run with hard spheres.
    pub fn hard(&mut self) -> Result<usize, String> {
        self.add("hard", &[], Some(Model::Hard), None)
    }

    /// Experiment of the case with the changes `sets`. Without a `model` or a `seed`, it has those of the first run.
    ///
    /// # Errors
    /// Returns the reason, as text, why the case refuses the changes.
    pub fn changed(&self, sets: &[String], model: Option<Model>, seed: Option<u64>) -> Result<Experiment, String> {
        let sets: Vec<String> = self.base.iter().chain(sets).cloned().collect();
        let changed = self.case.changed(&sets, model.or(self.model), seed.or(self.seed));
        changed.map(|(experiment, _)| experiment).map_err(|why| why.message)
    }

    /// Index of the run of the case with the changes `sets`. Without a `model` or a `seed`, it has those of the first
    /// run. The run is added to the plan unless the plan has an equal run.
    ///
    /// # Errors
    /// Returns the reason, as text, why the case refuses the changes.
    pub fn add(
        &mut self,
        name: &str,
        sets: &[String],
        model: Option<Model>,
        seed: Option<u64>,
    ) -> Result<usize, String> {
        let experiment = Experiment { name: name.to_owned(), against: None, ..self.changed(sets, model, seed)? };
        self.enlist(experiment, sets.join(", ")).map_err(|why| why.to_string())
    }

    /// Index of the run of the case with the changes `by`, each of which leaves out one model. The run is added to the
    /// plan unless the plan has an equal run.
    ///
    /// # Errors
    /// Returns the reason, as text, why the case refuses the changes.
    pub fn simplified(&mut self, name: &str, by: &[&Simplification]) -> Result<usize, String> {
        let sets: Vec<String> = by.iter().flat_map(|one| one.sets.iter().cloned()).collect();
        let model = by.iter().find_map(|one| one.model);
        let mut experiment = Experiment { name: name.to_owned(), against: None, ..self.changed(&sets, model, None)? };
        by.iter().filter_map(|one| one.edit).for_each(|edit| edit(&mut experiment));
        self.enlist(experiment, sets.join(", ")).map_err(|why| why.to_string())
    }

    fn enlist(&mut self, mut experiment: Experiment, set: String) -> Result<usize, StudyError> {
        let failed = |why: serde_json::Error| StudyError::Failed(format!("error: cannot describe the case: {why}"));
        let hash = fingerprint(&experiment).map_err(failed)?;
        if let Some(place) = self.runs.iter().position(|one| one.hash == hash) {
            return Ok(place);
        }
        // different runs need different names
        let name = experiment.name.clone();
        for k in 2.. {
            if self.runs.iter().all(|one| one.experiment.name != experiment.name) {
                break;
            }
            experiment.name = format!("{name} ({k})");
        }
        self.runs.push(PlannedRun { experiment, set, hash });
        Ok(self.runs.len() - 1)
    }
}
