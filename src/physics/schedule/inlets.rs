//! Lengths of windows in scenes with inlets. A window is the time between two exchanges with the gas; particles come in
//! at the end of a window.

use crate::experiment::Experiment;
use crate::scene::Inlet;

/// [-] largest share of the volume of an inlet that is filled by the particles that come in during one window. At this
/// share, random sequential addition, which places these particles, is fast; the method jams at the share 0.382
/// (Talbot, Schaaf and Tarjus 1991).
const FILLED: f64 = 0.1;

/// [s] longest window with inlets, through which particles come in at the ends of windows; infinite without inlets. In
/// one window, the particles of an inlet fill at most a tenth of its region, and their mean velocity carries them at
/// most half-way through the region.
pub fn longest_for_inlets(experiment: &Experiment) -> f64 {
    let scene = &experiment.scene;
    let longest = |inlet: &Inlet| {
        let filling = inlet.rate * scene.species[usize::from(inlet.species)].volume();
        let [low, high] = inlet.region.corners();
        let leaving = (high - low).zip_map(&inlet.velocity_mean, |edge, speed| 0.5 * edge / speed.abs());
        (FILLED * inlet.region.volume(&scene.domain.size) / filling).min(leaving.min())
    };
    scene.inlets.iter().map(longest).fold(f64::INFINITY, f64::min)
}
