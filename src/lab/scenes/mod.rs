//! Scenes of the lab. A scene is a case of `cases/` with changes, adjustable parameters, graphs and texts. Its two
//! panels show simulations side by side.
//!
//! To add a scene, write a file in this folder, and name it below in a line `mod` and in [`SCENES`].

mod bounce;
mod channel;
mod column;
mod cooling;
mod cradle;
mod heap;
mod heating;
mod impact;
mod oblique;
mod rolling;
mod stepped;
mod unstable;

use super::gauge::Gauge;
use super::parameter::ParameterRange;
use crate::experiment::Model;
use serde::Serialize;

/// One scene of the lab: case, panels, adjustable parameters, graphs and texts.
pub struct LabScene {
    /// Name of the scene in requests of the page.
    pub name: &'static str,
    /// Heading of the scene on the page.
    pub title: &'static str,
    /// Name of the built-in case from which the scene is made.
    pub case: &'static str,
    /// Changes to the case for both panels, in the form of `--set` arguments.
    pub sets: &'static [&'static str],
    /// Setup of the left panel: its heading, collision model and changes to the case.
    pub left: PanelSetup,
    /// Setups (heading, collision model and changes to the case) that the user can choose for the right panel. The
    /// first one is shown by default.
    pub rights: &'static [PanelSetup],
    /// Parameters that the user can change on the page, with their limits.
    pub knobs: &'static [ParameterRange],
    /// Set of quantities that are measured and drawn as graphs.
    pub gauge: Gauge,
    /// [s] wall time of the whole animation at its default speed.
    pub lasts: f64,
    /// Part of the box that the page draws, and its axes.
    pub view: BoxView,
    /// Description of the scene in three parts, each of one or two sentences.
    pub sentences: [&'static str; 3],
    /// Equation that describes the scene, as text for the page. A line break separates two equations.
    pub equation: &'static str,
    /// Meaning of the symbols in the equation.
    pub symbols: &'static str,
    /// Question about the scene for the student.
    pub question: &'static str,
    /// Answer to the question, for the student.
    pub answer: &'static str,
}

/// Setup of one panel: heading, collision model and changes to the case.
pub struct PanelSetup {
    /// Heading of the panel on the page.
    pub title: &'static str,
    /// Collision model of the panel.
    pub model: Model,
    /// Changes to the case for this panel alone, in the form of `--set` arguments.
    pub sets: &'static [&'static str],
}

/// Part of the box that the page draws, and the coordinates on its axes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BoxView {
    /// Coordinate drawn on the horizontal axis: 0, 1 or 2 for x, y or z.
    pub right: usize,
    /// Coordinate drawn on the vertical axis: 0, 1 or 2 for x, y or z.
    pub up: usize,
    /// [m] part of the box that is drawn: lower and upper limit on the horizontal axis, then on the vertical axis.
    /// `None` means the whole box.
    pub region: Option<[f64; 4]>,
    /// [-] factor by which the drawing enlarges gaps and overlaps of two spheres; `None` in scenes with fewer or more
    /// than two spheres.
    pub magnify: Option<f64>,
}

/// View of the whole box along the z axis, with x to the right and y upwards.
const WHOLE: BoxView = BoxView { right: 0, up: 1, region: None, magnify: None };

/// Setup of a panel with soft spheres, with the contact law and the time step of the case.
const SOFT: PanelSetup = PanelSetup { title: "soft", model: Model::Soft, sets: &[] };
/// Setup of a panel with hard spheres, whose collisions are computed as in the case, by default at their exact
/// instants.
const HARD: PanelSetup = PanelSetup { title: "hard", model: Model::Hard, sets: &[] };
/// Setup of a panel with hybrid spheres, whose impacts are soft contacts or instantaneous collisions.
const HYBRID: PanelSetup = PanelSetup { title: "hybrid", model: Model::Hybrid, sets: &[] };

/// All scenes, in the order in which the page lists them.
pub const SCENES: &[LabScene] = &[
    impact::SCENE,
    cradle::SCENE,
    bounce::SCENE,
    cooling::SCENE,
    channel::SCENE,
    column::SCENE,
    oblique::SCENE,
    rolling::SCENE,
    heap::SCENE,
    heating::SCENE,
    unstable::SCENE,
    stepped::SCENE,
];

/// Finds the scene with the name `name`; `None` if there is no such scene.
pub fn scene(name: &str) -> Option<&'static LabScene> {
    SCENES.iter().find(|scene| scene.name == name)
}
