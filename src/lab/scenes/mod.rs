//! The scenes of the lab: each is a case of `cases/` with changes, what may be set of it, what is drawn, and the words.
//!
//! A new scene is one file here and two lines below.

mod bounce;
mod channel;
mod column;
mod cooling;
mod cradle;
mod heating;
mod impact;
mod stepped;
mod unstable;

use super::gauge::Gauge;
use super::parameter::ParameterRange;
use crate::experiment::Model;
use serde::Serialize;

/// One scene.
pub struct LabScene {
    /// Name.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// The built-in case.
    pub case: &'static str,
    /// Changes of the case that both panels share, as `--set` takes them.
    pub sets: &'static [&'static str],
    /// The left panel.
    pub left: PanelSetup,
    /// What the right panel may show; the first is shown unless another one is chosen.
    pub rights: &'static [PanelSetup],
    /// What may be set.
    pub knobs: &'static [ParameterRange],
    /// What is measured and drawn.
    pub gauge: Gauge,
    /// [s] of the clock on the wall in which the whole scene passes at its own pace.
    pub lasts: f64,
    /// How the box is drawn.
    pub view: BoxView,
    /// What is seen, three sentences.
    pub sentences: [&'static str; 3],
    /// An equation.
    pub equation: &'static str,
    /// What its symbols are.
    pub symbols: &'static str,
    /// A question for the student.
    pub question: &'static str,
    /// Its answer.
    pub answer: &'static str,
}

/// What one panel runs.
pub struct PanelSetup {
    /// Heading.
    pub title: &'static str,
    /// Collision model.
    pub model: Model,
    /// Changes of the case for this panel alone.
    pub sets: &'static [&'static str],
}

/// How the box is drawn.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BoxView {
    /// Which coordinate goes to the right.
    pub right: usize,
    /// Which one goes up.
    pub up: usize,
    /// [m] what is shown of them: from and to, to the right, then up; `None`: the whole box.
    pub region: Option<[f64; 4]>,
    /// [-] gaps between spheres are drawn so many times as large (two spheres only).
    pub magnify: Option<f64>,
}

/// The whole box, seen along its third axis.
const WHOLE: BoxView = BoxView { right: 0, up: 1, region: None, magnify: None };

/// Soft spheres, as they are in the case.
const SOFT: PanelSetup = PanelSetup { title: "soft", model: Model::Soft, sets: &[] };
/// Hard spheres with a calendar of events.
const HARD: PanelSetup = PanelSetup { title: "hard", model: Model::Hard, sets: &[] };
/// Hybrid spheres.
const HYBRID: PanelSetup = PanelSetup { title: "hybrid", model: Model::Hybrid, sets: &[] };

/// All scenes, in the order of the list.
pub const SCENES: &[LabScene] = &[
    impact::SCENE,
    cradle::SCENE,
    bounce::SCENE,
    cooling::SCENE,
    channel::SCENE,
    column::SCENE,
    heating::SCENE,
    unstable::SCENE,
    stepped::SCENE,
];

/// The scene of that name.
pub fn scene(name: &str) -> Option<&'static LabScene> {
    SCENES.iter().find(|scene| scene.name == name)
}
