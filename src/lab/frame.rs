//! Frame of the lab: data of one instant, from which the page draws its two panels.
//!
//! A frame is a sequence of bytes, little endian: the length of the JSON in bytes (u32), the JSON, and blanks up to a
//! multiple of four. Then come the particles of the left panel and those of the right panel, in the order of their ids.
//! Each particle has x, y, z [m], speed [m/s] and overlap [m], as f32.

use crate::engine::Failure;
use serde::Serialize;

/// State of one panel at one instant, without its particles.
#[derive(Clone, Debug, Serialize)]
pub struct Now {
    /// [s] simulated time that the panel has reached.
    pub time: f64,
    /// State of the run: `running`, `over` (it has reached its end) or `failed`.
    pub state: &'static str,
    /// Reason why the run failed, as one word and as a sentence; `None` if it did not fail.
    pub failure: Option<(&'static str, String)>,
    /// Rows of quantities measured since the previous frame. A row has one value for each column of the graphs, in the
    /// unit of this column.
    pub rows: Vec<Vec<f64>>,
    /// Numbers of the run that the page shows next to the panel.
    pub live: Live,
}

/// Numbers of a run that the page shows next to its panel.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Live {
    /// [J] kinetic energy of all particles, including that of rotation.
    pub kinetic: f64,
    /// [J] elastic energy that is stored in contacts.
    pub elastic: f64,
    /// [J] energy that the particles have lost in impacts since the start.
    pub dissipated: f64,
    /// [J] energy that the particles have gained since the start other than by impacts, such as by gravity, drag and
    /// moving walls.
    pub work: f64,
    /// [J] kinetic plus elastic energy at the start.
    pub at_start: f64,
    /// [J] residual of the energy balance: change of the energy since the start, minus the work, plus the recorded
    /// losses.
    pub residual: f64,
    /// Number of impacts between particles that have ended.
    pub pairs: u64,
    /// Number of impacts of particles on walls that have ended.
    pub walls: u64,
    /// [-] realised restitution as root mean square over all impacts, of pairs and at walls; `None` without an impact.
    pub restitution: Option<f64>,
    /// [-] largest overlap so far, divided by the diameter of the smaller sphere; `None` without an overlap.
    pub overlap: Option<f64>,
    /// [s] mean duration of the impacts of pairs and at walls; `None` without an impact.
    pub duration: Option<f64>,
    /// [s/s] wall time that the engine needs, divided by the simulated time; `None` at the start.
    pub cost: Option<f64>,
    /// Number of time steps of the engine since the start.
    pub steps: u64,
    /// Number of collisions since the start that were computed as an impulse.
    pub events: u64,
    /// Number of pairs of particles since the start whose distance was checked.
    pub checks: u64,
    /// Number of collisions since the start that hard spheres in time steps missed.
    pub missed: u64,
}

/// Result of the comparison of the two panels, in scenes whose statistics are tested.
#[derive(Clone, Debug, Serialize)]
pub struct PanelComparison {
    /// Answer of the comparison of the two panels: equivalent, different or unresolved.
    pub answer: String,
    /// Sentence that explains the answer.
    pub sentence: String,
    /// [s] simulated time at which averaging begins.
    pub from: f64,
    /// Profiles of the left and the right panel over the height. Each slice has the height y [mm], the streamwise
    /// velocity and its standard error [m/s], and the granular temperature [m²/s²].
    pub profiles: [Vec<[Option<f64>; 4]>; 2],
}

/// Part of a frame that is sent as JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Head<'a> {
    /// Serial number of the choice (scene and settings) by which the page opened the running scene.
    pub serial: u32,
    /// States of the left and the right panel.
    pub sides: &'a [Now; 2],
    /// Comparison of the two panels. It is present only in the first frame after a new comparison.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub judged: Option<PanelComparison>,
}

/// Bytes of a frame, made from its JSON part and from the values of the particles of the left and the right panel.
pub fn bytes(head: &Head, particles: [&[[f32; 5]]; 2]) -> Vec<u8> {
    let mut json = serde_json::to_vec(head).unwrap_or_default();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = (json.len() as u32).to_le_bytes().to_vec();
    bytes.append(&mut json);
    for values in particles.into_iter().flatten().flatten() {
        bytes.extend_from_slice(&values.to_le_bytes());
    }
    bytes
}

/// Reason why a run failed: the kind of the failure as one word, and a sentence.
pub fn words(failure: &Failure) -> (&'static str, String) {
    (failure.kind(), failure.to_string())
}
