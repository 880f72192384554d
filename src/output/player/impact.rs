//! Recording of one impact for an animation. Gaps and overlaps are enlarged so that they are visible. A variant is one
//! of the experiments of a case.

use super::{Player, RecordedVariant, RecordingFrame};
use crate::observe::{Frame, Frames};
use crate::output::numbers::{quantity, significant};
use crate::output::{Bounce, ImpactStudy, PathPoint};
use nalgebra::Vector3;

/// Number of frames (instants) of the recording of an impact.
const FRAMES: usize = 240;

/// [diameters] size at which the largest overlap among all experiments is drawn. All gaps and overlaps are enlarged by
/// the same factor, which follows from this size.
const DEEP: f64 = 0.3;

/// [-] durations of the recording before (`BEFORE`) and after (`AFTER`) the first touch, each divided by the duration
/// of the longest contact.
const BEFORE: f64 = 0.6;
const AFTER: f64 = 1.4;

impl Player {
    /// Makes a recording with one impact for each variant (experiment of a case). `None` unless at least one impact has
    /// a duration.
    pub fn of_impact(study: &ImpactStudy) -> Option<Self> {
        let of = |pick: fn(&Bounce) -> Option<f64>| {
            study.bounces.iter().filter_map(pick).filter(|value| value.is_finite()).fold(0.0, f64::max)
        };
        let (longest, deepest) = (of(|bounce| bounce.values.contact_time), of(|bounce| bounce.values.maximum_overlap));
        if longest <= 0.0 || deepest <= 0.0 {
            return None;
        }
        let times = (-BEFORE * longest, AFTER * longest);
        let magnified = DEEP * study.diameter / deepest;
        let recorded = study.bounces.iter().filter_map(|bounce| record(study, bounce, times, magnified));
        let recorded: Vec<(&Bounce, Frames)> = recorded.collect();
        let variants = recorded.iter().map(|(bounce, frames)| RecordedVariant {
            name: &bounce.name,
            stopped: bounce.failure.as_ref().map(ToString::to_string),
            frames,
        });
        let stage = RecordingFrame {
            size: size(study),
            periodic: [false; 3],
            slide: None,
            walls: Vec::new(),
            gravity: Vector3::zeros(),
            drift: Vector3::zeros(),
            names: Vec::new(),
            view: "xy",
            magnified: Some(magnified),
            words: format!(
                "The impact in slow motion. Gaps and overlaps are drawn {} times as large as they are. Hard spheres turn round at one instant; soft ones press into \
                 each other meanwhile. The clock starts {} before the first touch.",
                significant(magnified, 2),
                quantity(-times.0, "s", 3)
            ),
        };
        let variants: Vec<RecordedVariant> = variants.collect();
        (!variants.is_empty()).then(|| Self::new(&stage, &variants))
    }
}

/// [m] edge lengths of a box that contains two spheres and the gap between them.
fn size(study: &ImpactStudy) -> Vector3<f64> {
    Vector3::new(3.6, 1.4, 1.4) * study.diameter
}

/// Records the motion in one impact at equal intervals, from the time `from` to the time `to` [s], both counted from
/// the first touch. Gaps are enlarged by the factor `magnified` [-]. `None` if the spheres never touch.
fn record<'a>(
    study: &ImpactStudy,
    bounce: &'a Bounce,
    (from, to): (f64, f64),
    magnified: f64,
) -> Option<(&'a Bounce, Frames)> {
    let touch = touch(&bounce.path)?;
    let (diameter, size) = (study.diameter, size(study));
    let frame = |k: usize| {
        let time = (to - from) * k as f64 / (FRAMES - 1) as f64;
        let (gap, velocity) = at(&bounce.path, touch + from + time)?;
        let half = 0.5 * (diameter + gap * magnified);
        let sphere = |side: f64| {
            (
                Vector3::new(0.5 * size.x + side * half, 0.5 * size.y, 0.5 * size.z),
                Vector3::new(0.5 * side * velocity, 0.0, 0.0),
            )
        };
        let (positions, velocities): (Vec<_>, Vec<_>) = [-1.0, 1.0].map(sphere).into_iter().unzip();
        Some(Frame {
            time,
            position: positions.iter().map(|x| x.map(|x| x as f32)).collect(),
            velocity: velocities.iter().map(|v| v.map(|v| v as f32)).collect(),
            overlap: vec![(-gap).max(0.0) as f32; 2],
            spin: Vec::new(),
            solver: vec![0; 2],
        })
    };
    let frames: Vec<Frame> = (0..FRAMES).map_while(frame).collect();
    let recorded = Frames::recorded(vec![0.5 * diameter as f32; 2], frames);
    (recorded.frames.len() > 1).then_some((bounce, recorded))
}

/// [s] time at which the gap between the bodies first becomes zero; `None` if the bodies never touch.
fn touch(path: &[PathPoint]) -> Option<f64> {
    path.windows(2).find_map(|pair| {
        let (a, b) = (pair[0], pair[1]);
        let closes = a.gap > 0.0 && (b.gap <= 0.0 || b.normal_velocity > 0.0 && a.normal_velocity < 0.0);
        // a collision without duration happens between two points of the path, at the time at which the straight motion
        // from the first point closes the gap
        let flight = a.time - a.gap / a.normal_velocity;
        closes.then(
            || if b.gap < 0.0 { a.time + (b.time - a.time) * a.gap / (a.gap - b.gap) } else { flight.min(b.time) },
        )
    })
}

/// Gap [m] and normal velocity [m/s] at the time `time` [s]. Values between points of the path are interpolated
/// linearly. Before the first and after the last point, the normal velocity is assumed to be constant. `None` if the
/// path has no points.
fn at(path: &[PathPoint], time: f64) -> Option<(f64, f64)> {
    let (first, last) = (path.first()?, path.last()?);
    let straight = |point: &PathPoint| (point.gap + point.normal_velocity * (time - point.time), point.normal_velocity);
    if time <= first.time {
        return Some(straight(first));
    }
    if time >= last.time {
        return Some(straight(last));
    }
    let next = path.partition_point(|point| point.time <= time);
    let (a, b) = (path[next - 1], path[next]);
    let share = (time - a.time) / (b.time - a.time);
    Some((a.gap + (b.gap - a.gap) * share, a.normal_velocity + (b.normal_velocity - a.normal_velocity) * share))
}
