//! Messages between the page and the server of the lab.
//!
//! The page sends each [`Ask`] as JSON. The server answers with each [`Tell`] as JSON, and with frames (`frame.rs`) as
//! bytes.

use super::gauge::Graph;
use super::parameter::{ParameterKind, ParameterValue};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// [bytes] length of the longest message that a page may send.
pub const LONGEST: usize = 16 * 1024;

/// Values of the parameters that the user has set on the page, by the names of the parameters. All other parameters
/// have the values of the case.
pub type Settings = BTreeMap<String, ParameterValue>;

/// Scene and settings that the user has chosen on the page.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneChoice {
    /// Name of the scene.
    pub scene: String,
    /// Values of parameters that the user has set.
    #[serde(default)]
    pub settings: Settings,
    /// Index of the model of the right panel in the list of models that the scene offers.
    #[serde(default)]
    pub right: usize,
    /// Serial number of the choice, counted by the page. Answers to the choice contain the same number.
    #[serde(default)]
    pub serial: u32,
}

/// Requests from the page to the server.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "ask", rename_all = "lowercase", deny_unknown_fields)]
pub enum Ask {
    /// Opens a scene at its start.
    Open(SceneChoice),
    /// Continues or pauses the motion.
    Play {
        /// True to continue the motion.
        on: bool,
    },
    /// Computes one frame while the motion is paused.
    Step,
    /// Sets the speed of the animation.
    Pace {
        /// [-] factor on the default pace, the simulated time per wall time of the scene.
        factor: f64,
    },
    /// Reports whether the page is visible.
    Look {
        /// True if the page is visible.
        on: bool,
    },
    /// Reports that the page has drawn a frame, so that another one can be sent.
    Drawn,
}

/// Entry in the list of scenes.
#[derive(Clone, Debug, Serialize)]
pub struct Listed {
    /// Name of the scene in requests.
    pub name: &'static str,
    /// Heading of the scene.
    pub title: &'static str,
}

/// Parameter with its label, control and value, for the page.
#[derive(Clone, Debug, Serialize)]
pub struct ShownParameter {
    /// Name of the parameter in settings.
    pub name: &'static str,
    /// Label of the control on the page.
    pub label: &'static str,
    /// Effect of the parameter, in a sentence.
    pub help: &'static str,
    /// Unit of the parameter; empty for a parameter without unit.
    pub unit: &'static str,
    /// Kind of control and limits of the parameter.
    pub kind: ParameterKind,
    /// Present value of the parameter.
    pub value: ParameterValue,
    /// Value of the parameter in the case.
    pub default: ParameterValue,
}

/// Description of a panel for the page.
#[derive(Clone, Debug, Serialize)]
pub struct PanelDescription {
    /// Heading of the panel.
    pub title: String,
    /// Collision model: soft, hard or hybrid.
    pub model: &'static str,
    /// Method in a few words: integrator and step, or the way in which collisions are found.
    pub method: String,
    /// [m] radii of the particles in the order of their ids.
    pub radii: Vec<f32>,
    /// [s] duration of an isolated contact of two particles, or of a particle and a wall. `None` without a contact law.
    pub contact_time: Option<f64>,
    /// Command line that reproduces the panel.
    pub command: String,
}

/// Description of an opened scene for the page.
#[derive(Clone, Debug, Serialize)]
pub struct Opened {
    /// Serial number of the choice by which the page opened the scene.
    pub serial: u32,
    /// Name of the scene.
    pub scene: &'static str,
    /// Heading of the scene.
    pub title: &'static str,
    /// Description of the scene in three sentences.
    pub sentences: [&'static str; 3],
    /// Equation that describes the scene.
    pub equation: &'static str,
    /// Meaning of the symbols in the equation.
    pub symbols: &'static str,
    /// Question for the student.
    pub question: &'static str,
    /// Answer to the question.
    pub answer: &'static str,
    /// Parameters that the page can change.
    pub knobs: Vec<ShownParameter>,
    /// Names of the models that the right panel may show.
    pub rights: Vec<&'static str>,
    /// Index of the model that the right panel shows.
    pub right: usize,
    /// Descriptions of the left and the right panel.
    pub sides: [PanelDescription; 2],
    /// [m] size of the box.
    pub size: [f64; 3],
    /// Axes along which the box is periodic.
    pub periodic: [bool; 3],
    /// View of the box that the page draws.
    pub view: super::scenes::BoxView,
    /// Graphs of the measured quantities.
    pub graphs: Vec<Graph>,
    /// [s] simulated duration of the scene.
    pub duration: f64,
    /// [s/s] simulated time per wall time at the default speed of the animation.
    pub pace: f64,
    /// Command line that compares both panels.
    pub command: String,
    /// Text of a case file with the present settings.
    pub case: String,
    /// Warnings from reading the case.
    pub warnings: Vec<String>,
}

/// Messages of the server to a page, except frames.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "tell", rename_all = "lowercase")]
pub enum Tell {
    /// List of the scenes.
    Scenes {
        /// The scenes, in the order of the list.
        scenes: Vec<Listed>,
        /// Version of the program.
        version: &'static str,
    },
    /// Reports that a scene has been opened.
    Opened(Box<Opened>),
    /// Reports that a choice cannot be run, and the reason. The scene that was opened before continues.
    Refused {
        /// Serial number of the refused choice of scene and settings.
        serial: u32,
        /// Reason for the refusal in words.
        why: String,
    },
}
