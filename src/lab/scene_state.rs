//! Scene of the lab with the settings of the user, and the experiments of both panels that follow from them. The two
//! panels show simulations side by side.

use super::parameter::{LabParameter, soft_method};
use super::protocol::{Opened, PanelDescription as Heading, SceneChoice, ShownParameter};
use super::scenes::{self, LabScene, PanelSetup};
use crate::case::built_in::{self, BuiltIn};
use crate::case::{Case, Variant};
use crate::engine::hard::SteppedHard;
use crate::experiment::{Experiment, HardStepping, Model};
use crate::output::numbers::significant;
use crate::particles::Particles;
use crate::placement::initial_state;
use crate::predict::contact::ContactTimes;
use crate::schedule::Schedule;
use crate::study::quoted;

/// Scene of the lab that is ready to run, with the experiments and initial states of both panels.
pub struct SceneState {
    /// Scene that the user has chosen on the page.
    pub scene: &'static LabScene,
    /// Scene and settings that the user has chosen on the page.
    pub choice: SceneChoice,
    /// Experiments of the left and the right panel.
    pub experiments: [Experiment; 2],
    /// Initial states of the left and the right panel. They are equal unless the panels differ in the number of
    /// particles.
    pub starts: [Particles; 2],
    case: Case,
    sets: Vec<String>,
    own: Experiment,
    warnings: Vec<String>,
}

impl SceneState {
    /// Reads and checks the scene and the settings that the user has chosen on the page.
    ///
    /// # Errors
    /// Returns the reason as text: the scene or a setting does not exist, a number is outside its limits, or the case
    /// has an error.
    pub fn open(choice: &SceneChoice) -> Result<Self, String> {
        let scene = scenes::scene(&choice.scene).ok_or("there is no such scene")?;
        let right = scene.rights.get(choice.right).ok_or("the right panel cannot show this")?;
        let built_in = built_in::case(scene.case).ok_or("its case is not built in")?;
        let own = of_side(&built_in, &plain(scene), &scene.left)?.1.0;
        let sets = changes(scene, choice, &own)?;
        let (case, (left_experiment, warnings)) = of_side(&built_in, &sets, &scene.left)?;
        let right_experiment = of_side(&built_in, &sets, right)?.1.0;
        let experiments = [left_experiment, right_experiment];
        let start = |experiment| initial_state(experiment).map_err(|crowded| crowded.to_string());
        let starts = [start(&experiments[0])?, start(&experiments[1])?];
        let warnings = warnings.into_iter().map(|warning| warning.message).collect();
        Ok(Self { scene, choice: choice.clone(), experiments, starts, case, sets, own, warnings })
    }

    /// Setup of the right panel that the user has chosen: its heading, collision model and changes to the case.
    fn right(&self) -> &'static PanelSetup {
        &self.scene.rights[self.choice.right]
    }

    /// Description for the page of the scene and of both panels.
    pub fn opened(&self) -> Opened {
        let scene = self.scene;
        let [left, right] = &self.experiments;
        Opened {
            serial: self.choice.serial,
            scene: scene.name,
            title: scene.title,
            sentences: scene.sentences,
            equation: scene.equation,
            symbols: scene.symbols,
            question: scene.question,
            answer: scene.answer,
            knobs: self.knobs(),
            rights: scene.rights.iter().map(|side| side.title).collect(),
            right: self.choice.right,
            sides: [self.heading(0, &scene.left), self.heading(1, self.right())],
            size: left.scene.domain.size.into(),
            periodic: left.scene.domain.periodic,
            view: scene.view,
            graphs: scene.gauge.graphs(left, &self.starts[0]),
            duration: left.run.duration.max(right.run.duration),
            pace: self.pace(),
            command: self.command(),
            case: self.file(),
            warnings: self.warnings.clone(),
        }
    }

    /// [s/s] pace of the animation at its default speed: simulated time divided by wall time.
    pub fn pace(&self) -> f64 {
        self.experiments[0].run.duration / self.scene.lasts
    }

    fn knobs(&self) -> Vec<ShownParameter> {
        let shown = |range: &super::parameter::ParameterRange| {
            let knob = range.knob;
            let default = knob.value(&self.own)?;
            let value = self.choice.settings.get(knob.name()).and_then(|value| range.accept(value).ok());
            let (label, unit) = knob.label();
            let value = value.unwrap_or_else(|| default.clone());
            Some(ShownParameter {
                name: knob.name(),
                label,
                help: knob.help(),
                unit,
                kind: range.kind(),
                value,
                default,
            })
        };
        self.scene.knobs.iter().filter_map(shown).collect()
    }

    fn heading(&self, place: usize, side: &PanelSetup) -> Heading {
        let (experiment, start) = (&self.experiments[place], &self.starts[place]);
        let law = experiment.law();
        Heading {
            title: side.title.to_owned(),
            model: side.model.name(),
            method: method(experiment, start),
            contact_time: law.and_then(|law| ContactTimes::of(experiment, &law, start.len()).governing()),
            command: self.run_command(side),
        }
    }

    /// Command `diptych run` that repeats the run of one panel, with all changes to the case as arguments.
    fn run_command(&self, side: &PanelSetup) -> String {
        let own = side.sets.iter().map(|set| (*set).to_owned());
        let sets = self.sets.iter().cloned().chain(own);
        command(["diptych", "run", self.scene.case, "--model", side.model.name()], sets)
    }

    /// Command that compares the runs of both panels. If `diptych compare` with the built-in case runs just these two
    /// models, the command names this case. Otherwise the command names the case file that the page can save.
    fn command(&self) -> String {
        let plain = [&self.scene.left, self.right()].iter().all(|side| side.sets.is_empty());
        if plain && !self.case.names_variants() && self.right().model == Model::Hard {
            return command(["diptych", "compare", self.scene.case], self.sets.iter().cloned());
        }
        format!("diptych compare {}", self.file_name())
    }

    /// Name of the case file that the page can save, such as `lab-impact.toml`.
    pub fn file_name(&self) -> String {
        format!("lab-{}.toml", self.scene.name)
    }

    /// Text of a case file with the present settings. With this file, `diptych run` repeats the left panel, and
    /// `diptych compare` repeats both panels.
    pub fn file(&self) -> String {
        let heading = format!(
            "{}: as set in `diptych lab`\n\nQuestion: {}\nSource: the built-in case `{}`.\n{}",
            self.scene.title,
            self.scene.question,
            self.scene.case,
            self.run_command(&self.scene.left)
        );
        let variants = [&self.scene.left, self.right()].map(|side| Variant {
            name: side.title,
            model: side.model,
            sets: side.sets,
        });
        // every case that can be read can also be written; if writing fails, the file contains the reason
        self.case.written(&heading, &variants).unwrap_or_else(|why| format!("# {}\n", why.message))
    }
}

/// Changes to the built-in case that the scene makes for both panels, in the form `key=value`. Changes for one panel
/// alone and changes by the user are not included.
fn plain(scene: &LabScene) -> Vec<String> {
    scene.sets.iter().map(|set| (*set).to_owned()).collect()
}

/// Changes to the built-in case that the scene and the user make, in the form `key=value`. A setting of the user is
/// left out if it equals the value of the parameter in the experiment `own`, which has no changes by the user.
fn changes(scene: &LabScene, choice: &SceneChoice, own: &Experiment) -> Result<Vec<String>, String> {
    if let Some(name) = choice.settings.keys().find(|name| !scene.knobs.iter().any(|range| range.knob.name() == **name))
    {
        return Err(format!("this scene has no setting `{name}`"));
    }
    let mut sets = plain(scene);
    for range in scene.knobs {
        let knob: LabParameter = range.knob;
        if let Some(value) = choice.settings.get(knob.name()) {
            let value = range.accept(value)?;
            if Some(&value) != knob.value(own).as_ref() {
                sets.extend(knob.sets(&value, own));
            }
        }
    }
    Ok(sets)
}

/// Reads a built-in case with the changes `sets`, and makes the experiment of the panel `side` from it.
fn of_side(case: &BuiltIn, sets: &[String], side: &PanelSetup) -> Result<(Case, crate::case::Checked), String> {
    let case = Case::built_in(case, sets).map_err(|why| why.message)?;
    let own: Vec<String> = side.sets.iter().map(|set| (*set).to_owned()).collect();
    let checked = case.changed(&own, Some(side.model), None).map_err(|why| why.message)?;
    Ok((case, checked))
}

/// Short description, for the page, of the way in which an experiment computes collisions. `start` has the particles in
/// their initial state.
fn method(experiment: &Experiment, start: &Particles) -> String {
    match (experiment.model(), experiment.hard.stepping) {
        (Model::Soft, _) => soft_method(experiment, start.len()),
        (Model::Hard, HardStepping::Events) => "impulses at the exact instants of touch".to_owned(),
        (Model::Hard, HardStepping::Steps { theta }) => {
            let window = Schedule::new(experiment).longest();
            let real = SteppedHard::theta_of_window(theta, start, &experiment.scene, window);
            format!(
                "impulses at the ends of steps, θ = {} at the start (at most {})",
                significant(real, 3),
                significant(theta, 3)
            )
        }
        (Model::Dsmc, _) => "pairs that are drawn at random in cells".to_owned(),
        (Model::Hybrid, _) => "impulses where two meet alone, contacts elsewhere".to_owned(),
    }
}

/// Command line made of `words` and of `--set` arguments, quoted for a shell.
fn command<'a>(words: impl IntoIterator<Item = &'a str>, sets: impl Iterator<Item = String>) -> String {
    let words = words.into_iter().map(str::to_owned);
    let sets = sets.flat_map(|set| ["--set".to_owned(), set]);
    quoted(words.chain(sets).map(Into::into))
}
