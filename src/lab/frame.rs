//! A frame: what the page needs to draw one instant.
//!
//! Bytes, little endian: the length of the JSON that follows [u32], the JSON, blanks up to a multiple of four, and for each panel and
//! each particle, in the order of ids, x, y, z [m], speed [m/s] and overlap [m], as f32.

use crate::engine::Failure;
use serde::Serialize;

/// What is told of one panel besides its particles.
#[derive(Clone, Debug, Serialize)]
pub struct Now {
    /// [s] simulated time.
    pub time: f64,
    /// Whether it runs, is over, or has failed.
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
    /// [J] what contacts store.
    pub elastic: f64,
    /// [J] lost in impacts.
    pub dissipated: f64,
    /// [J] work of gravity, drag and moving walls.
    pub work: f64,
    /// [J] kinetic and elastic energy at the start.
    pub at_start: f64,
    /// [J] what the books leave unexplained.
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

/// How the two panels compare, in scenes that have a verdict.
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
    /// Of the choice that is running.
    pub serial: u32,
    /// Both panels.
    pub sides: &'a [Now; 2],
    /// How the two compare, in the first frame after it was judged anew.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub judged: Option<PanelComparison>,
}

/// All of it as bytes.
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

/// Why a panel stopped, as a frame tells it.
pub fn words(failure: &Failure) -> (&'static str, String) {
    (failure.kind(), failure.to_string())
}
