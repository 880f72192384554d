//! Scene of the lab: a ball that bounces until it rests.

use super::{BoxView, HARD, HYBRID, LabScene, SOFT};
use crate::lab::gauge::Gauge;
use crate::lab::parameter::{LabParameter, ParameterRange};

pub(super) const SCENE: LabScene = LabScene {
    name: "bounce",
    title: "A ball that comes to rest",
    case: "bouncing-sphere",
    sets: &["run.duration=1.5 s"],
    left: SOFT,
    rights: &[HARD, HYBRID],
    knobs: &[
        ParameterRange { knob: LabParameter::Restitution, least: 0.5, most: 0.95 },
        ParameterRange { knob: LabParameter::Stiffness, least: 30.0, most: 3000.0 },
        ParameterRange { knob: LabParameter::StepsPerContact, least: 5.0, most: 50.0 },
    ],
    gauge: Gauge::Bounces,
    lasts: 15.0,
    view: BoxView { right: 0, up: 1, region: Some([-2e-3, 6e-3, 0.0, 24e-3]), magnify: None },
    sentences: [
        "A sphere falls 20 mm and bounces, each time with the same share e of its speed.",
        "Hard: the bounces come faster and faster, infinitely many before a finite time, and the run must stop there.",
        "Soft: the last bounces merge into one contact that does not end, and the sphere lies still on its spring.",
    ],
    equation: "t_end = √(2h/g) · (1 + e) / (1 − e)",
    symbols: "t_end: when infinitely many bounces are over. h: height of the fall. g: gravity. e: restitution.",
    question: "Why does the hard sphere stop, although nothing is wrong with its rule?",
    answer: "Each flight is e times as long as the one before, so that their sum is finite although their number is not. An event calendar has to do them one by one, and cannot come past that time. A sphere at rest needs a contact that lasts: a soft or a hybrid one, or a rule that makes very close collisions elastic.",
};
