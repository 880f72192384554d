//! Still picture of the last instant of a recording, for print and for readers without scripts.

use super::RecordingFrame;
use crate::observe::Frames;
use maud::html;
use nalgebra::Vector3;

/// [px] width (`WIDTH`) of a still picture, and margin (`MARGIN`) between the edge of the picture and the box.
const WIDTH: f64 = 400.0;
const MARGIN: f64 = 6.0;

/// Colours of spheres, from that of the slowest to that of the fastest sphere, as in the script scene.js.
const SCALE: [&str; 6] = ["#323888", "#245696", "#1b798e", "#3e9d79", "#8ebc52", "#ecd646"];

/// SVG picture of the last recorded instant of a run; empty if nothing was recorded. Spheres are coloured by speed.
pub fn still(stage: &RecordingFrame, frames: &Frames) -> String {
    let Some(last) = frames.frames.last() else { return String::new() };
    let [right, up] = match stage.view {
        "zy" => [2, 1],
        "xz" => [0, 2],
        _ => [0, 1],
    };
    let scale = (WIDTH - 2.0 * MARGIN) / stage.size[right];
    let height = stage.size[up] * scale + 2.0 * MARGIN;
    let place = |x: Vector3<f64>| (MARGIN + x[right] * scale, height - MARGIN - x[up] * scale);
    let fastest = last.velocity.iter().map(|v| v.norm()).fold(0.0, f32::max);
    let slowest = last.velocity.iter().map(|v| v.norm()).fold(fastest, f32::min);
    let colour = |v: &Vector3<f32>| {
        let share = (v.norm() - slowest) / (fastest - slowest);
        SCALE[if share.is_finite() { (share * 5.0).round() as usize } else { 0 }.min(5)]
    };
    let spheres = last.position.iter().zip(&last.velocity).zip(&frames.radius);
    let spheres = spheres.map(|((x, v), radius)| (place(x.cast()), (f64::from(*radius) * scale).max(1.0), colour(v)));
    let line = |part: &[f64]| {
        let [from, to] = [0, 3].map(|k| place(Vector3::new(part[k], part[k + 1], part[k + 2])));
        format!("M{:.1} {:.1}L{:.1} {:.1}", from.0, from.1, to.0, to.1)
    };
    let walls: String = stage.walls.iter().flat_map(|wall| wall.chunks_exact(6)).map(line).collect();
    let picture = html! {
        svg.themed viewBox=(format!("0 0 {WIDTH} {height:.0}")) role="img" aria-label="The spheres at the end of the recording" {
            rect x=(MARGIN) y=(MARGIN) width=(WIDTH - 2.0 * MARGIN) height=(format!("{:.1}", height - 2.0 * MARGIN)) fill="var(--scene)" stroke="var(--line)" {}
            @for ((x, y), radius, colour) in spheres {
                circle cx=(format!("{x:.1}")) cy=(format!("{y:.1}")) r=(format!("{radius:.1}")) fill=(colour) {}
            }
            path d=(walls) stroke="var(--ink)" stroke-width="2" fill="none" {}
        }
    };
    picture.into_string()
}
