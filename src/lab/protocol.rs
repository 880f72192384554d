//! What page and server say to each other.
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
    /// What was set.
    #[serde(default)]
    pub settings: Settings,
    /// Which model the right panel shows, by its place in the scene's list.
    #[serde(default)]
    pub right: usize,
    /// Counts the choices of a page; the answers repeat it.
    #[serde(default)]
    pub serial: u32,
}

/// What a page may ask.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "ask", rename_all = "lowercase", deny_unknown_fields)]
pub enum Ask {
    /// A scene from its start.
    Open(SceneChoice),
    /// To go on, or to stand still.
    Play {
        /// Whether to go on.
        on: bool,
    },
    /// One frame while it stands still.
    Step,
    /// As many times the scene's own pace.
    Pace {
        /// [-] the factor.
        factor: f64,
    },
    /// Whether anybody looks at the page.
    Look {
        /// Whether somebody does.
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
    /// What it does, in a sentence.
    pub help: &'static str,
    /// Unit; empty without one.
    pub unit: &'static str,
    /// What it may be.
    pub kind: ParameterKind,
    /// What it is now.
    pub value: ParameterValue,
    /// What it is in the case.
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
    /// [s] a contact of two, or of one and a wall, without others (soft).
    pub contact_time: Option<f64>,
    /// The command that reproduces it.
    pub command: String,
}

/// Everything about a scene that has been opened.
#[derive(Clone, Debug, Serialize)]
pub struct Opened {
    /// Of the choice.
    pub serial: u32,
    /// Name of the scene.
    pub scene: &'static str,
    /// Heading.
    pub title: &'static str,
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
    /// What may be set.
    pub knobs: Vec<ShownParameter>,
    /// What the right panel may show.
    pub rights: Vec<&'static str>,
    /// Which of them it does.
    pub right: usize,
    /// Both panels.
    pub sides: [PanelDescription; 2],
    /// [m] size of the box.
    pub size: [f64; 3],
    /// Which sides are open to the opposite one.
    pub periodic: [bool; 3],
    /// How the box is drawn.
    pub view: super::scenes::BoxView,
    /// What is drawn over time.
    pub graphs: Vec<Graph>,
    /// [s] how long the scene lasts.
    pub duration: f64,
    /// [s/s] simulated time per time of the clock on the wall, at the scene's own pace.
    pub pace: f64,
    /// The command that compares both panels.
    pub command: String,
    /// A case file of its own.
    pub case: String,
    /// What the reader of the case warns of.
    pub warnings: Vec<String>,
}

/// What the server tells a page, besides frames.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "tell", rename_all = "lowercase")]
pub enum Tell {
    /// Which scenes there are.
    Scenes {
        /// In the order of the list.
        scenes: Vec<Listed>,
        /// Of the program.
        version: &'static str,
    },
    /// A scene has been opened.
    Opened(Box<Opened>),
    /// A choice that cannot be run, and why. What ran before goes on.
    Refused {
        /// Of the choice.
        serial: u32,
        /// In words.
        why: String,
    },
}
