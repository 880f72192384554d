//! Models that a scene may have or leave out, with the changes by which `diptych needs` adds each model to a case and
//! leaves it out.

use super::factors::{KNOWN, surfaces};
use super::plan::{PlannedFactor, SensitivityPlan, Simplification};
use super::rotating::GLASS_TANGENTIAL;
use crate::case::{Case, Checked};
use crate::cli::Sensitivity;
use crate::contact_law::ContactLaw;
use crate::experiment::{Experiment, Model};
use crate::fluid::{Fluid, Profile};
use crate::output::sensitivity::OmittedFactor;
use crate::runs::StudyError;
use crate::study::plan::any_model;
use nalgebra::Vector3;

/// Factors of `diptych sensitivity` that `diptych needs` studies besides the models: integrator, drag law, length of
/// the box, and the effect of chance.
const BESIDE: [&str; 4] = ["integrator", "drag", "box", "seed"];
/// Largest number of slices across the box in which the volume fraction is averaged, for drag in suspensions.
const SLICES: f64 = 20.0;

/// Way to add one model to a case, or the reason why this is impossible. With all possible models, the case becomes
/// the richest case.
enum Richer {
    /// The case already has the model.
    Has,
    /// Changes of keys, in the form `key=value`, that add the model. The text is the assumption behind the values.
    Sets(Vec<String>, String),
    /// Reason, as text, why the scene cannot have the model.
    No(&'static str),
}

/// Model that a scene may have or leave out, such as friction.
struct Switch {
    /// Name of the factor (change of the case) that leaves out the model.
    name: &'static str,
    /// Title of the model in a sentence.
    title: &'static str,
    /// Function that returns the changes by which the model is added to a case, or the reason why the model cannot be
    /// added.
    richer: fn(&Experiment) -> Richer,
    /// Function that returns the change by which the model is left out, for a case with this model.
    simpler: fn(&SensitivityPlan) -> Simplification,
}

/// All models that a scene may have or leave out, in the order in which they are added to the case. Later models may
/// need earlier ones.
const SWITCHES: [Switch; 11] = [
    Switch { name: "friction", title: "friction", richer: friction, simpler: without_friction },
    Switch {
        name: "restitution-by-speed",
        title: "restitution by speed",
        richer: by_speed,
        simpler: |_| of_edit(at_usual_speed),
    },
    Switch {
        name: "facets",
        title: "inclined facets of walls",
        richer: facets,
        simpler: |_| of_edit(|experiment| experiment.scene.walls.iter_mut().for_each(|wall| wall.roughness = None)),
    },
    Switch { name: "rotation", title: "rotation", richer: rotation, simpler: |_| of_keys(&["contact.rotation=false"]) },
    Switch {
        name: "turbulence",
        title: "turbulence seen by the particles",
        richer: turbulence,
        simpler: |_| of_edit(|experiment| edit_gas(experiment, |fluid| fluid.turbulence = None)),
    },
    Switch {
        name: "two-way",
        title: "a gas that feels the particles",
        richer: coupling,
        simpler: |_| of_edit(|experiment| edit_gas(experiment, |fluid| fluid.coupling = None)),
    },
    Switch {
        name: "suspension",
        title: "drag in suspensions",
        richer: suspension,
        simpler: |_| of_keys(&["drag.schiller_naumann={}"]),
    },
    Switch {
        name: "lift",
        title: "lift",
        richer: lift,
        simpler: |_| of_edit(|experiment| edit_gas(experiment, |fluid| fluid.lift = None)),
    },
    Switch {
        name: "buoyancy",
        title: "buoyancy and added mass",
        richer: buoyancy,
        simpler: |_| of_keys(&["fluid.buoyancy=false", "fluid.added_mass=false"]),
    },
    Switch {
        name: "contacts",
        title: "contacts that last (hard spheres have none)",
        richer: |_| Richer::Has,
        simpler: |_| Simplification { model: Some(Model::Hard), ..Simplification::default() },
    },
    Switch {
        name: "positions",
        title: "the instants and places of collisions (dsmc has none)",
        richer: |_| Richer::Has,
        simpler: |_| Simplification { model: Some(Model::Dsmc), ..Simplification::default() },
    },
];

fn of_keys(keys: &[&str]) -> Simplification {
    Simplification { sets: keys.iter().map(|key| (*key).to_owned()).collect(), ..Simplification::default() }
}

fn of_edit(edit: fn(&mut Experiment)) -> Simplification {
    Simplification { edit: Some(edit), ..Simplification::default() }
}

fn edit_gas(experiment: &mut Experiment, edit: fn(&mut Fluid)) {
    experiment.scene.fluid.iter_mut().for_each(edit);
}

/// Gas that exerts drag on the particles; `None` without a gas or without drag.
fn dragging(experiment: &Experiment) -> Option<&Fluid> {
    experiment.scene.fluid.as_ref().filter(|fluid| fluid.drag.is_some())
}

fn sets(keys: &[&str], assumed: &str) -> Richer {
    Richer::Sets(keys.iter().map(|key| (*key).to_owned()).collect(), assumed.to_owned())
}

fn has_friction(experiment: &Experiment) -> bool {
    experiment
        .scene
        .surfaces(experiment.most_that_touch(experiment.count()))
        .iter()
        .any(|surface| surface.friction > 0.0)
}

fn friction(experiment: &Experiment) -> Richer {
    if has_friction(experiment) { Richer::Has } else { Richer::No("the case gives none, and no value is usual") }
}

fn without_friction(plan: &SensitivityPlan) -> Simplification {
    let tables = surfaces(plan).into_iter().map(|table| format!("{table}.friction=0"));
    Simplification { sets: tables.collect(), ..Simplification::default() }
}

fn by_speed(experiment: &Experiment) -> Richer {
    match experiment.law() {
        _ if !experiment.scene.depends_on_speed() => Richer::No("the case gives a constant one, and no law is usual"),
        Some(ContactLaw::KuwabaraKono(_)) if experiment.model().has_contacts() => {
            Richer::No("it is that of the contact law itself")
        }
        _ => Richer::Has,
    }
}

/// Replaces every restitution that depends on the speed by a constant: its value at the typical impact speed of the
/// case, which predictions use.
fn at_usual_speed(experiment: &mut Experiment) {
    let scene = &mut experiment.scene;
    let walls = scene.walls.iter_mut().map(|wall| &mut wall.surface);
    walls.chain([&mut scene.contact]).chain(scene.pairs.surfaces_mut()).for_each(|surface| surface.by_speed = None);
}

fn facets(experiment: &Experiment) -> Richer {
    match experiment.scene.has_rough_walls() {
        true => Richer::Has,
        false => Richer::No("the case gives none, and no inclination is usual"),
    }
}

fn rotation(experiment: &Experiment) -> Richer {
    match (&experiment.scene.rotation, has_friction(experiment)) {
        (Some(_), _) => Richer::Has,
        (None, false) => Richer::No("no friction turns a particle"),
        (None, true) => {
            let spring = format!("soft.tangential.linear.tangential_restitution={GLASS_TANGENTIAL}");
            sets(&["contact.rotation=true", &spring], "a tangential restitution of 0.44 (glass, Foerster et al. 1994)")
        }
    }
}

fn turbulence(experiment: &Experiment) -> Richer {
    match dragging(experiment) {
        Some(fluid) if fluid.turbulence.is_some() => Richer::Has,
        Some(fluid) if fluid.profile.channel_flow().is_some() => {
            sets(&["fluid.turbulence.langevin={}"], "k and ε of the k-ε model, C_0 = 2.1")
        }
        Some(_) => Richer::No("the gas has no k and ε"),
        None => Richer::No("no gas exerts drag"),
    }
}

fn coupling(experiment: &Experiment) -> Richer {
    let gravity = experiment.scene.gravity;
    match dragging(experiment) {
        Some(fluid) if fluid.coupling.is_some() => Richer::Has,
        Some(fluid) if fluid.profile.channel_flow().is_none() => Richer::No("the gas flow is not computed"),
        Some(_) if gravity != Vector3::new(0.0, 0.0, gravity.z) => Richer::No("gravity acts across the flow"),
        Some(_) => sets(&["fluid.coupling={}"], "a constant flow rate, damping of turbulence after Simonin"),
        None => Richer::No("no gas exerts drag"),
    }
}

fn suspension(experiment: &Experiment) -> Richer {
    let Some(fluid) = dragging(experiment) else { return Richer::No("no gas exerts drag") };
    if fluid.drag.as_ref().is_some_and(|drag| drag.law().cells().is_some()) {
        return Richer::Has;
    }
    let scene = &experiment.scene;
    let largest = scene.species.iter().map(crate::scene::Species::largest).fold(0.0, f64::max);
    let slices = (scene.domain.size.y / largest).floor().clamp(1.0, SLICES);
    if experiment.most_that_touch(experiment.count()) < 2 {
        return Richer::No("there is one particle only");
    }
    sets(&[&format!("drag.wen_yu.cells=[1, {slices}, 1]")], "the law of Wen and Yu in slices across the box")
}

fn lift(experiment: &Experiment) -> Richer {
    match dragging(experiment) {
        Some(fluid) if fluid.lift.is_some() => Richer::Has,
        Some(_) if experiment.scene.rotation.is_some() => sets(
            &["fluid.lift={ shear = true, spin = true }"],
            "Saffman and Mei in shear, Oesterlé and Bui Dinh by spin",
        ),
        Some(fluid) if matches!(fluid.profile, Profile::Uniform(_)) => Richer::No("the gas is not sheared"),
        Some(_) => sets(&["fluid.lift.shear=true"], "Saffman and Mei in shear"),
        None => Richer::No("no gas exerts drag"),
    }
}

fn buoyancy(experiment: &Experiment) -> Richer {
    let Some(fluid) = &experiment.scene.fluid else { return Richer::No("there is no gas") };
    // without gravity there is no buoyancy, but accelerated particles still have added mass
    let has_gravity = experiment.scene.gravity != Vector3::zeros();
    let has_added_mass = experiment.scene.species.iter().all(|species| species.added_density > 0.0);
    if has_added_mass && (fluid.buoyancy.is_some() || !has_gravity) {
        return Richer::Has;
    }
    let keys: &[&str] = if has_gravity { &["fluid.buoyancy=true"] } else { &[] };
    sets(&[keys, &["fluid.added_mass=true"]].concat(), "half the displaced gas as added mass")
}

impl<'a> SensitivityPlan<'a> {
    /// Plans the run of the richest case (the case with all models that are possible), and one run without each model.
    ///
    /// # Errors
    /// Returns an error if the case cannot run, or if no model can be left out.
    pub fn richest(case: &'a Case, args: &Sensitivity) -> Result<(Self, Checked), StudyError> {
        let seed = args.runs.effort.seed;
        let soft = || case.experiment(Some(Model::Soft), seed);
        let mut checked = match args.runs.model {
            Some(model) => case.experiment(Some(model), seed)?,
            None => soft().or_else(|_| any_model(case, seed))?,
        };
        let model = Some(checked.0.model());
        let (mut base, mut left_out, mut assumed) = (Vec::new(), Vec::new(), Vec::new());
        let omitted = |switch: &Switch, why: &str| OmittedFactor { name: switch.name.into(), why: why.into() };
        let mut present = Vec::new();
        for switch in &SWITCHES {
            match (switch.richer)(&checked.0) {
                Richer::Has => present.push((switch, String::new())),
                Richer::No(why) => left_out.push(omitted(switch, why)),
                Richer::Sets(sets, why) => {
                    let more: Vec<String> = base.iter().cloned().chain(sets).collect();
                    match case.changed(&more, model, seed) {
                        Ok(richer) => {
                            (checked, base) = (richer, more);
                            assumed.push(format!("{}: {why}", switch.title));
                            present.push((switch, format!("added: {why}")));
                        }
                        Err(refused) => left_out.push(omitted(switch, &refused.message)),
                    }
                }
            }
        }
        let mut plan = Self::begin(case, args, (&checked.0, "richest"), base)?;
        (plan.left_out, plan.assumed) = (left_out, assumed);
        for (switch, why) in present {
            plan.leave_out(switch, why);
        }
        for known in KNOWN.iter().filter(|known| BESIDE.contains(&known.name)) {
            match (known.make)(&mut plan, None) {
                Ok(factor) => {
                    let factor = PlannedFactor { name: known.name.into(), title: known.title.into(), ..factor };
                    plan.factors.push(factor);
                }
                Err(why) => plan.left_out.push(OmittedFactor { name: known.name.into(), why }),
            }
        }
        plan.refuse_nothing()?;
        Ok((plan, checked))
    }

    /// Plans the run without the model `switch`. The text `why` says how the model was added to the case. It is empty
    /// if the user's case has the model already.
    fn leave_out(&mut self, switch: &Switch, why: String) {
        let simpler = (switch.simpler)(self);
        let name = match simpler.model {
            Some(model) => model.name().to_owned(),
            None => format!("without {}", switch.title),
        };
        match self.simplified(&name, &[&simpler]) {
            Ok(run) if run == self.first() => {
                let why = "the richest case does without it".into();
                self.left_out.push(OmittedFactor { name: switch.name.into(), why });
            }
            Ok(run) => {
                let why = if why.is_empty() { "the case has it".to_owned() } else { why };
                let factor = PlannedFactor::against(self.first(), run, name, why);
                let (name, title) = (switch.name.into(), switch.title.into());
                self.factors.push(PlannedFactor { name, title, simpler: Some(simpler), ..factor });
            }
            Err(why) => self.left_out.push(OmittedFactor { name: switch.name.into(), why }),
        }
    }
}
