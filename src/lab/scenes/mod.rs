//! Scenes of the lab. Each is a case of `cases/` with changes, its parameters, its graphs, and its texts.
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
    /// Setups that the right panel may show; the first one is shown by default.
    pub rights: &'static [PanelSetup],
    /// Parameters that may be set.
    pub knobs: &'static [ParameterRange],
    /// Quantities that are measured and drawn.
    pub gauge: Gauge,
    /// [s] wall time that the whole scene takes at its own pace.
    pub lasts: f64,
    /// View of the box.
    pub view: BoxView,
    /// Description of the scene in three sentences.
    pub sentences: [&'static str; 3],
    /// An equation.
    pub equation: &'static str,
    /// Meaning of the symbols in the equation.
    pub symbols: &'static str,
    /// A question for the student.
    pub question: &'static str,
    /// Answer to the question.
    pub answer: &'static str,
}

/// Setup of one panel.
pub struct PanelSetup {
    /// Heading.
    pub title: &'static str,
    /// Collision model.
    pub model: Model,
    /// Changes of the case for this panel alone.
    pub sets: &'static [&'static str],
}

/// View of the box.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BoxView {
    /// Coordinate on the horizontal axis.
    pub right: usize,
    /// Coordinate on the vertical axis.
    pub up: usize,
    /// [m] range shown: from and to on the horizontal axis, then on the vertical one; `None`: the whole box.
    pub region: Option<[f64; 4]>,
    /// [-] factor by which gaps between spheres are magnified (two spheres only).
    pub magnify: Option<f64>,
}

/// The whole box, seen along its third axis.
const WHOLE: BoxView = BoxView { right: 0, up: 1, region: None, magnify: None };

/// Soft spheres, as they are in the case.
const SOFT: PanelSetup = PanelSetup { title: "soft", model: Model::Soft, sets: &[] };
/// Hard spheres with an event queue.
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
