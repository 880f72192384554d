//! Scene of the lab: one impact of two spheres in slow motion.

use super::{BoxView, HARD, HYBRID, LabScene, SOFT};
use crate::lab::gauge::Gauge;
use crate::lab::parameter::{LabParameter, ParameterRange};

pub(super) const SCENE: LabScene = LabScene {
    name: "impact",
    title: "One impact in slow motion",
    case: "impact",
    sets: &["soft.stepping=uniform"],
    left: SOFT,
    rights: &[HARD, HYBRID],
    knobs: &[
        ParameterRange { knob: LabParameter::Restitution, least: 0.3, most: 1.0 },
        ParameterRange { knob: LabParameter::Stiffness, least: 300.0, most: 30_000.0 },
        ParameterRange { knob: LabParameter::StepsPerContact, least: 5.0, most: 200.0 },
        ParameterRange { knob: LabParameter::Integrator, least: 0.0, most: 0.0 },
        ParameterRange { knob: LabParameter::Approach, least: 0.25, most: 2.0 },
    ],
    gauge: Gauge::Impact,
    lasts: 12.0,
    view: BoxView { right: 2, up: 0, region: Some([1.15e-3, 2.85e-3, 1.7e-3, 2.3e-3]), magnify: Some(20.0) },
    sentences: [
        "Two spheres of 406 µm meet head on; every gap and overlap is drawn twenty times as large as it is.",
        "On the left a spring pushes them apart for as long as they overlap, and a dashpot takes energy: the arrows are these two forces.",
        "On the right there is no contact at all: at the instant of touch both velocities change at once, by the impulse that gives the same restitution.",
    ],
    equation: "T_c = π / √(kₙ/M − γₙ²),   δ_max ≈ u √(M/kₙ)",
    symbols: "T_c: time in contact. kₙ: stiffness. M: half the mass of a sphere. γₙ: damping, from the restitution e. u: speed of approach.",
    question: "Four times the stiffness: what happens to the time in contact, to the largest overlap and to the cost?",
    answer: "Time and overlap both halve, since both go with 1/√kₙ. One impact costs the same: N_c steps, whatever the stiffness. A step is a fixed part of the contact, so it halves too. Here all spheres take every step, in contact or not, so a simulated second costs twice as much: its cost grows with √kₙ. The energy that an impact loses is the area of the loop of force over overlap. It becomes heat inside the spheres, which is not simulated. The hard sphere is what is left when kₙ has no limit: no time, no overlap, an impulse.",
};
