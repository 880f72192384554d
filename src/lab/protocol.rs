//! Messages between the page and the server of the lab. The page has two panels, which show simulations side by side.
//!
//! The page sends requests of the type [`Ask`] as JSON. The server sends messages of the type [`Tell`] as JSON, and
//! frames (`frame.rs`) as bytes.

use super::gauge::Graph;
use super::parameter::{ParameterKind, ParameterValue};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// [bytes] largest length of a message that a page may send.
pub const LONGEST: usize = 16 * 1024;

/// Values of the parameters that the user has set on the page, by the names of the parameters. All other parameters
/// have their values in the case.
pub type Settings = BTreeMap<String, ParameterValue>;

/// Scene and settings that the user has chosen on the page.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneChoice {
    /// Name of the chosen scene.
    pub scene: String,
    /// Values of the parameters that the user has set.
    #[serde(default)]
    pub settings: Settings,
    /// Index of the setup of the right panel (its collision model and changes to the case) in the list that the scene
    /// offers.
    #[serde(default)]
    pub right: usize,
    /// Serial number of the choice, counted by the page. Answers to this choice contain the same number.
    #[serde(default)]
    pub serial: u32,
}

/// Request from the page to the server.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "ask", rename_all = "lowercase", deny_unknown_fields)]
pub enum Ask {
    /// Opens a scene in its initial state, with the chosen settings.
    Open(SceneChoice),
    /// Continues or pauses the motion.
    Play {
        /// True to continue the motion.
        on: bool,
    },
    /// Computes a single frame (picture of one instant) while the motion is paused.
    Step,
    /// Sets the speed of the animation.
    Pace {
        /// [-] factor by which the pace of the animation is multiplied. The pace is simulated time divided by wall
        /// time, and each scene has a default pace.
        factor: f64,
    },
    /// Reports whether the page is visible.
    Look {
        /// True if the page is visible.
        on: bool,
    },
    /// Reports that the page has drawn a frame (picture of one instant), so that the server can send another one.
    Drawn,
}

/// One scene in the list of scenes on the page.
#[derive(Clone, Debug, Serialize)]
pub struct Listed {
    /// Name of the scene in requests of the page.
    pub name: &'static str,
    /// Heading of the scene in the list.
    pub title: &'static str,
}

/// Parameter with its label, control and value, for the page.
#[derive(Clone, Debug, Serialize)]
pub struct ShownParameter {
    /// Name of the parameter in requests of the page.
    pub name: &'static str,
    /// Label of the control on the page.
    pub label: &'static str,
    /// Effect of the parameter, in one sentence.
    pub help: &'static str,
    /// Unit of the parameter; empty for a parameter without unit.
    pub unit: &'static str,
    /// Kind of the control on the page (slider or list of words), with the limits of the parameter.
    pub kind: ParameterKind,
    /// Present value of the parameter.
    pub value: ParameterValue,
    /// Value of the parameter in the case.
    pub default: ParameterValue,
}

/// Description for the page of a panel and of the method by which its simulation computes collisions.
#[derive(Clone, Debug, Serialize)]
pub struct PanelDescription {
    /// Heading of the panel on the page.
    pub title: String,
    /// Collision model: soft, hard or hybrid.
    pub model: &'static str,
    /// Method in a few words: integrator and time step, or the way in which collisions are found.
    pub method: String,
    /// [s] shortest duration of a contact of two particles, or of a particle and a wall. `None` without a contact law.
    pub contact_time: Option<f64>,
    /// Command line that repeats the run of the panel.
    pub command: String,
}

/// Description for the page of a scene that has been opened.
#[derive(Clone, Debug, Serialize)]
pub struct Opened {
    /// Serial number of the choice (scene and settings) by which the page opened the scene.
    pub serial: u32,
    /// Name of the scene in requests of the page.
    pub scene: &'static str,
    /// Heading of the scene.
    pub title: &'static str,
    /// Description of the scene in three parts, each of one or two sentences.
    pub sentences: [&'static str; 3],
    /// Equation that describes the scene, as text for the page.
    pub equation: &'static str,
    /// Meaning of the symbols in the equation.
    pub symbols: &'static str,
    /// Question about the scene for the student.
    pub question: &'static str,
    /// Answer to the question, for the student.
    pub answer: &'static str,
    /// Parameters that the user can change on the page.
    pub knobs: Vec<ShownParameter>,
    /// Headings of the setups that the right panel can show. A setup is a collision model with changes to the case.
    pub rights: Vec<&'static str>,
    /// Index, in `rights`, of the setup that the right panel shows.
    pub right: usize,
    /// Descriptions of the left and the right panel.
    pub sides: [PanelDescription; 2],
    /// [m] lengths of the sides of the box along x, y and z.
    pub size: [f64; 3],
    /// True for each of the axes x, y and z along which the box is periodic.
    pub periodic: [bool; 3],
    /// Part of the box that the page draws, and its axes.
    pub view: super::scenes::BoxView,
    /// Graphs of the quantities that the scene measures.
    pub graphs: Vec<Graph>,
    /// [s] simulated duration of the scene: the longer one of the durations of both panels.
    pub duration: f64,
    /// [s/s] pace of the animation at its default speed: simulated time divided by wall time.
    pub pace: f64,
    /// Command line that compares the runs of both panels.
    pub command: String,
    /// Text of a case file with the present settings, which the page can save.
    pub case: String,
    /// Warnings about the case and its settings, for the user.
    pub warnings: Vec<String>,
}

/// Message of the server to a page, other than a frame (data of one instant, from which the page draws).
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "tell", rename_all = "lowercase")]
pub enum Tell {
    /// List of all scenes, sent when the page opens.
    Scenes {
        /// All scenes, in the order of the list on the page.
        scenes: Vec<Listed>,
        /// Version of the program.
        version: &'static str,
    },
    /// Reports that a scene has been opened, with its description.
    Opened(Box<Opened>),
    /// Reports that the chosen scene cannot be run with the chosen settings. The scene that was opened before
    /// continues.
    Refused {
        /// Serial number of the refused choice of scene and settings.
        serial: u32,
        /// Reason for the refusal, as text for the user.
        why: String,
    },
}
