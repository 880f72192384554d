//! Messages between page and server.
//!
//! The page sends [`Ask`]s as JSON. The server answers with [`Tell`]s as JSON, and with frames (`frame.rs`) as bytes.

use super::gauge::Graph;
use super::parameter::{ParameterKind, ParameterValue};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// [bytes] the longest message that a page may send.
pub const LONGEST: usize = 16 * 1024;

/// Values that the page has set, by the names of their knobs; what is not set is as in the case.
pub type Settings = BTreeMap<String, ParameterValue>;

/// A choice of scene and settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneChoice {
    /// Name of the scene.
    pub scene: String,
    /// Values that were set.
    #[serde(default)]
    pub settings: Settings,
    /// Model that the right panel shows, by its index in the scene's list.
    #[serde(default)]
    pub right: usize,
    /// Counts the choices of a page; the answers repeat it.
    #[serde(default)]
    pub serial: u32,
}

/// Requests of a page.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "ask", rename_all = "lowercase", deny_unknown_fields)]
pub enum Ask {
    /// A scene from its start.
    Open(SceneChoice),
    /// Goes on, or stands still.
    Play {
        /// True to go on.
        on: bool,
    },
    /// One frame while it stands still.
    Step,
    /// Sets the pace, as a factor on the scene's own pace.
    Pace {
        /// [-] the factor.
        factor: f64,
    },
    /// Tells the lab if the page is visible.
    Look {
        /// True if the page is visible.
        on: bool,
    },
    /// The page has drawn a frame and can take another one.
    Drawn,
}

/// A scene in the list.
#[derive(Clone, Debug, Serialize)]
pub struct Listed {
    /// Name.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
}

/// A knob as the page shows it.
#[derive(Clone, Debug, Serialize)]
pub struct ShownParameter {
    /// Name in settings.
    pub name: &'static str,
    /// Words beside it.
    pub label: &'static str,
    /// Effect of the parameter, in a sentence.
    pub help: &'static str,
    /// Unit; empty without one.
    pub unit: &'static str,
    /// Kind of control and limits of the parameter.
    pub kind: ParameterKind,
    /// Present value.
    pub value: ParameterValue,
    /// Value in the case.
    pub default: ParameterValue,
}

/// A panel as the page shows it.
#[derive(Clone, Debug, Serialize)]
pub struct PanelDescription {
    /// Heading.
    pub title: String,
    /// soft, hard or hybrid.
    pub model: &'static str,
    /// Its method in a few words: integrator and step, or calendar.
    pub method: String,
    /// [m] radii in the order of ids.
    pub radii: Vec<f32>,
    /// [s] duration of an isolated contact of two particles, or of a particle and a wall (soft).
    pub contact_time: Option<f64>,
    /// Command that reproduces the panel.
    pub command: String,
}

/// Everything about a scene that has been opened.
#[derive(Clone, Debug, Serialize)]
pub struct Opened {
    /// Serial number of the choice.
    pub serial: u32,
    /// Name of the scene.
    pub scene: &'static str,
    /// Heading.
    pub title: &'static str,
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
    /// Parameters that may be set.
    pub knobs: Vec<ShownParameter>,
    /// Models that the right panel may show.
    pub rights: Vec<&'static str>,
    /// Index of the model that the right panel shows.
    pub right: usize,
    /// Both panels.
    pub sides: [PanelDescription; 2],
    /// [m] size of the box.
    pub size: [f64; 3],
    /// Axes along which the box is periodic.
    pub periodic: [bool; 3],
    /// View of the box.
    pub view: super::scenes::BoxView,
    /// Graphs over time.
    pub graphs: Vec<Graph>,
    /// [s] duration of the scene.
    pub duration: f64,
    /// [s/s] simulated time per time of the clock on the wall, at the scene's own pace.
    pub pace: f64,
    /// The command that compares both panels.
    pub command: String,
    /// A case file of its own.
    pub case: String,
    /// Warnings from reading the case.
    pub warnings: Vec<String>,
}

/// Messages of the server to a page, besides frames.
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
    /// A scene has been opened.
    Opened(Box<Opened>),
    /// A choice that cannot be run, and why. What ran before goes on.
    Refused {
        /// Serial number of the choice.
        serial: u32,
        /// The reason in words.
        why: String,
    },
}
