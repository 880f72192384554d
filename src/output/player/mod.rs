//! Animations of several variants (experiments of a case) next to each other on a page. This module makes the data for
//! the script player.js, and still pictures for print and for readers without scripts.
//!
//! The page contains the recording as JSON. Positions are 16-bit fractions of the box; velocities, overlaps and spins
//! are 16-bit fractions of their largest value. This resolution is finer than the pixels of a screen. The recording has
//! first all positions, then all velocities, then overlaps and spins, if there are any. At the end are code numbers of
//! the methods that moved the particles. The values of each quantity are ordered by frame (recorded instant), then by
//! particle.

mod impact;
mod outlines;
mod still;

#[cfg(feature = "lab")]
pub(crate) use outlines::outlines;

use crate::observe::{Frame, Frames};
use crate::outcome::Outcome;
use crate::output::numbers::{count, quantity};
use crate::scene::Scene;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{Markup, PreEscaped, html};
use nalgebra::Vector3;
use serde::Serialize;
use serde_json::{Value, json};

/// Number of variants (experiments of a case) that have a panel when the page opens. The reader can choose other
/// variants.
const SHOWN: usize = 3;

/// Scripts, in the order in which a page contains them.
const SCRIPTS: [&str; 2] = [include_str!("../page/scene.js"), include_str!("../page/player.js")];

/// [-] largest unsigned 16-bit number. Recorded fractions from 0 to 1 are multiplied by this number.
const FULL: f64 = u16::MAX as f64;

/// Recorded motion that a page shows as an animation, with still pictures.
#[derive(Clone, Debug)]
pub(super) struct Player {
    /// Caption of the animation, of one or two sentences.
    words: String,
    /// Name and still picture (SVG) of each variant (experiment of a case) that has a panel when the page opens.
    panels: Vec<(String, String)>,
    /// Data of the recorded motion for the script.
    data: Value,
}

/// Recorded motion of one variant (experiment of a case).
struct RecordedVariant<'a> {
    name: &'a str,
    /// Reason why the run stopped early; `None` if it ended regularly.
    stopped: Option<String>,
    frames: &'a Frames,
}

/// Displacement along z of the periodic image one box height above a particle, in a sheared box.
#[derive(Clone, Copy, Serialize)]
struct ImageSlide {
    /// [m] displacement at time 0.
    start: f64,
    /// [m/s] rate at which the displacement grows.
    speed: f64,
}

/// Data of a recording that are common to all variants (experiments of a case): box, walls, gravity and view.
struct RecordingFrame {
    /// [m] edge lengths of the box along x, y and z.
    size: Vector3<f64>,
    periodic: [bool; 3],
    /// Displacement along z of periodic images in a sheared box; `None` without shear.
    slide: Option<ImageSlide>,
    /// Line segments that outline each wall, with six coordinates [m] per segment.
    walls: Vec<Vec<f64>>,
    /// [m/s²] acceleration by gravity, with which the script draws curved paths between the recorded instants; 0 in a
    /// gas.
    gravity: Vector3<f64>,
    /// [m/s] mean initial velocity along each periodic axis. A component is 0 unless it exceeds three times the
    /// velocity fluctuations. The view of the animation may move with this velocity.
    drift: Vector3<f64>,
    /// Names of the species.
    names: Vec<String>,
    /// Axes of the box that point to the right and upwards, such as `zy`; `3d` for a view in three dimensions.
    view: &'static str,
    /// [-] factor by which gaps and overlaps are enlarged; `None` if they are drawn to scale.
    magnified: Option<f64>,
    words: String,
}

impl Player {
    /// Makes the animation of recorded runs. Runs with fewer than two recorded instants or without spheres are left
    /// out; `None` if no run remains.
    pub fn of(outcomes: &[Outcome], frames: &[Frames]) -> Option<Self> {
        let variants =
            outcomes.iter().zip(frames).filter(|(_, frames)| frames.frames.len() > 1 && !frames.radius.is_empty());
        let variants: Vec<RecordedVariant> = variants
            .map(|(outcome, frames)| RecordedVariant {
                name: &outcome.experiment.name,
                stopped: outcome.failure.as_ref().map(ToString::to_string),
                frames,
            })
            .collect();
        let first = variants.first()?;
        let outcome = outcomes.iter().find(|outcome| outcome.experiment.name == first.name)?;
        Some(Self::new(&stage(outcome, first.frames), &variants))
    }

    fn new(stage: &RecordingFrame, variants: &[RecordedVariant]) -> Self {
        let panels =
            variants.iter().take(SHOWN).map(|variant| (variant.name.to_owned(), still::still(stage, variant.frames)));
        let data = json!({
            "size": stage.size.as_slice(),
            "periodic": stage.periodic,
            "slide": stage.slide,
            "walls": stage.walls,
            "gravity": stage.gravity.as_slice(),
            "drift": stage.drift.as_slice(),
            "names": stage.names,
            "view": stage.view,
            "linear": stage.magnified.is_some(),
            "magnified": stage.magnified.is_some(),
            "variants": variants.iter().map(|variant| variant.record(stage)).collect::<Vec<_>>(),
        });
        Self { words: stage.words.clone(), panels: panels.collect(), data }
    }

    /// HTML of the animation for a page, with its still pictures and data.
    pub fn markup(&self) -> Markup {
        // within a script element of a page, a tag would end the data, so each character `<` is replaced
        let data = self.data.to_string().replace('<', "\\u003c");
        html! {
            section.player aria-label="Particles" {
                p { (self.words) }
                div.panels {
                    @for (name, still) in &self.panels { figure.panel { figcaption { (name) } (PreEscaped(still)) } }
                }
                noscript { p.note { "Seen at the end of the recording; with script the spheres move." } }
                script type="application/json" { (PreEscaped(data)) }
            }
        }
    }
}

/// HTML with the scripts that a page with an animation needs.
pub(super) fn scripts() -> Markup {
    html! { @for script in SCRIPTS { script { (PreEscaped(script)) } } }
}

/// Makes the data that are common to all recorded runs of a scene: box, walls, gravity and view.
fn stage(outcome: &Outcome, frames: &Frames) -> RecordingFrame {
    let scene = &outcome.experiment.scene;
    let drift = drift(scene, frames);
    let shown = frames.radius.len();
    let until = frames.frames.last().map_or(0.0, |frame| frame.time);
    let who = if shown < frames.particles {
        format!(
            "{} of {} spheres, so that some rebound from others that are not shown",
            count(shown as u64),
            count(frames.particles as u64)
        )
    } else if shown == 1 {
        "One sphere".into()
    } else {
        format!("All {} spheres", count(shown as u64))
    };
    let when = if until < 0.99 * outcome.experiment.run.duration && outcome.failure.is_none() {
        format!("the first {} of {}", quantity(until, "s", 3), quantity(outcome.experiment.run.duration, "s", 3))
    } else {
        format!("{} in all", quantity(outcome.experiment.run.duration, "s", 3))
    };
    RecordingFrame {
        size: scene.domain.size,
        periodic: scene.domain.periodic,
        slide: scene.domain.shear.map(|shear| ImageSlide { start: shear.start, speed: scene.domain.sliding() }),
        walls: outlines::outlines(scene),
        gravity: if scene.fluid.is_some() { Vector3::zeros() } else { scene.gravity },
        drift,
        names: scene.species.iter().map(|species| species.name.clone()).collect(),
        view: view(scene, shown),
        magnified: None,
        words: format!(
            "{who}, {when}, the same start in every variant. Between two recorded frames they are drawn as flying freely."
        ),
    }
}

/// View that shows a scene best, as the names of the two axes that point to the right and upwards in the picture. The
/// upward axis is z if there is no gas and gravity has a component along z but none along y; otherwise it is y. More
/// than 50 spheres without walls have the view `3d`, in three dimensions.
fn view(scene: &Scene, shown: usize) -> &'static str {
    let size = scene.domain.size;
    let falls_along_z = scene.gravity.z != 0.0 && scene.gravity.y == 0.0 && scene.fluid.is_none();
    match () {
        () if scene.walls.is_empty() && shown > 50 => "3d",
        () if falls_along_z => "xz",
        () if scene.fluid.is_some() || size.z > size.x => "zy",
        () => "xy",
    }
}

/// [m/s] mean initial velocity along periodic axes. A component is 0 unless it exceeds three times the velocity
/// fluctuations.
fn drift(scene: &Scene, frames: &Frames) -> Vector3<f64> {
    let Some(first) = frames.frames.first() else { return Vector3::zeros() };
    let count = first.velocity.len().max(1) as f64;
    let velocities = || first.velocity.iter().map(|v| v.cast::<f64>());
    let mean = velocities().sum::<Vector3<f64>>() / count;
    let agitation = (velocities().map(|v| (v - mean).norm_squared()).sum::<f64>() / count).sqrt();
    Vector3::from_fn(
        |axis, _| if scene.domain.periodic[axis] && mean[axis].abs() > 3.0 * agitation { mean[axis] } else { 0.0 },
    )
}

impl RecordedVariant<'_> {
    /// Data of the recorded motion of one experiment, for the script of the animation.
    fn record(&self, stage: &RecordingFrame) -> Value {
        let Frames { radius, species, frames, .. } = self.frames;
        let fastest = frames.iter().flat_map(|frame| &frame.velocity).fold(0.0_f32, |most, v| most.max(v.amax()));
        let largest =
            |of: fn(&Frame) -> &Vec<f32>| frames.iter().flat_map(of).fold(0.0_f32, |most, one| most.max(*one));
        let magnitudes: [fn(&Frame) -> &Vec<f32>; 2] = [|frame| &frame.overlap, |frame| &frame.spin];
        let [deepest, swiftest] = magnitudes.map(largest);
        let unit = f64::from(fastest).max(f64::MIN_POSITIVE) / f64::from(i16::MAX);
        let mut bytes: Vec<u8> = Vec::new();
        let each = |put: &mut dyn FnMut(&Frame)| frames.iter().for_each(put);
        each(&mut |frame| {
            for part in frame.position.iter().flat_map(|x| x.cast::<f64>().component_div(&stage.size).data.0[0]) {
                bytes.extend(((part.clamp(0.0, 1.0) * FULL).round() as u16).to_le_bytes());
            }
        });
        each(&mut |frame| {
            for part in frame.velocity.iter().flat_map(|v| v.cast::<f64>().data.0[0]) {
                bytes.extend(((part / unit).round() as i16).to_le_bytes());
            }
        });
        for (of, most) in magnitudes.into_iter().zip([deepest, swiftest]).filter(|(_, most)| *most > 0.0) {
            each(&mut |frame| {
                for one in of(frame) {
                    bytes.extend(((f64::from(*one / most) * FULL).round() as u16).to_le_bytes());
                }
            });
        }
        each(&mut |frame| bytes.extend(&frame.solver));
        json!({
            "name": self.name,
            "stopped": self.stopped,
            "radius": radius,
            "species": species,
            "times": frames.iter().map(|frame| frame.time).collect::<Vec<_>>(),
            "unit": unit,
            "deepest": deepest,
            "swiftest": swiftest,
            "data": BASE64_STANDARD.encode(bytes),
        })
    }
}
