//! A frame: what the page needs to draw one instant.
//!
//! A frame is a string of bytes, little endian. First comes the length of the JSON [u32], then the JSON, then blanks up
//! to a multiple of four. For each panel and each particle, in the order of ids, follow x, y, z [m], speed [m/s] and
//! overlap [m], as f32.

use crate::engine::Failure;
use serde::Serialize;

/// State of one panel, apart from its particles.
#[derive(Clone, Debug, Serialize)]
pub struct Now {
    /// [s] simulated time.
    pub time: f64,
    /// State of the run: going on, over, or failed.
    pub state: &'static str,
    /// Why it stopped, by one word and in a sentence.
    pub failure: Option<(&'static str, String)>,
    /// Rows of the gauge since the frame before.
    pub rows: Vec<Vec<f64>>,
    /// Numbers beside the panel.
    pub live: Live,
}

/// Numbers beside a panel.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Live {
    /// [J] kinetic energy.
    pub kinetic: f64,
    /// [J] elastic energy stored in contacts.
    pub elastic: f64,
    /// [J] lost in impacts.
    pub dissipated: f64,
    /// [J] work of gravity, drag and moving walls.
    pub work: f64,
    /// [J] kinetic and elastic energy at the start.
    pub at_start: f64,
    /// [J] energy that the balance leaves unexplained.
    pub residual: f64,
    /// Impacts between particles that have ended.
    pub pairs: u64,
    /// Impacts at walls that have ended.
    pub walls: u64,
    /// [-] realised restitution of all impacts.
    pub restitution: Option<f64>,
    /// [-] largest overlap over the diameter.
    pub overlap: Option<f64>,
    /// [s] mean duration of an impact.
    pub duration: Option<f64>,
    /// [s/s] wall time of the engine per simulated time.
    pub cost: Option<f64>,
    /// Time steps.
    pub steps: u64,
    /// Collisions that got an impulse.
    pub events: u64,
    /// Contacts looked at.
    pub checks: u64,
    /// Collisions that were missed (stepped hard spheres).
    pub missed: u64,
}

/// Comparison of the two panels, in scenes that have a verdict.
#[derive(Clone, Debug, Serialize)]
pub struct PanelComparison {
    /// equivalent, different or unresolved.
    pub answer: String,
    /// The answer in words.
    pub sentence: String,
    /// [s] simulated time from which on averages are taken.
    pub from: f64,
    /// Profiles of both panels over the height: of each slice y [mm], the streamwise velocity and its standard error [m/s], and the
    /// granular temperature [m²/s²].
    pub profiles: [Vec<[Option<f64>; 4]>; 2],
}

/// The JSON of a frame.
#[derive(Clone, Debug, Serialize)]
pub struct Head<'a> {
    /// Serial number of the choice that is running.
    pub serial: u32,
    /// Both panels.
    pub sides: &'a [Now; 2],
    /// Comparison of the two panels, in the first frame after a new verdict.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub judged: Option<PanelComparison>,
}

/// Whole frame as bytes.
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

/// Reason why a panel stopped, by one word and in a sentence.
pub fn words(failure: &Failure) -> (&'static str, String) {
    (failure.kind(), failure.to_string())
}
