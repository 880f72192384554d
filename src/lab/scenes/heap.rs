//! Scene of the lab: a heap of three balls that stays in place or falls apart, depending on friction.

use super::{BoxView, HYBRID, LabScene, PanelSetup, SOFT};
use crate::experiment::Model;
use crate::lab::gauge::Gauge;
use crate::lab::parameter::{LabParameter, ParameterRange};

pub(super) const SCENE: LabScene = LabScene {
    name: "heap",
    title: "A heap of three balls",
    case: "rotation/three-balls",
    sets: &["run.window=100 us"],
    left: SOFT,
    rights: &[
        PanelSetup { title: "soft, without rotation", model: Model::Soft, sets: &["contact.rotation=false"] },
        HYBRID,
    ],
    knobs: &[
        ParameterRange { knob: LabParameter::Friction, least: 0.05, most: 0.5 },
        ParameterRange { knob: LabParameter::Stiffness, least: 1_000.0, most: 100_000.0 },
        ParameterRange { knob: LabParameter::StepsPerContact, least: 10.0, most: 50.0 },
    ],
    gauge: Gauge::Heap,
    lasts: 12.0,
    view: BoxView { right: 0, up: 1, region: Some([11e-3, 19e-3, 0.0, 4.5e-3]), magnify: None },
    sentences: [
        "Two balls lie on a floor, a third one lies on both; only weight acts.",
        "Each lower ball must neither turn nor move aside: friction at the ball above and at the floor holds it, if there is enough.",
        "Without rotation a lower ball can only move aside, and half of the friction is enough. Hard spheres are not offered here: they cannot rest on one another, and their run would stop at once.",
    ],
    equation: "μ ≥ tan 15° = 0.268\nwithout rotation: μ ≥ 0.136",
    symbols: "μ: friction between the balls and at the floor.",
    question: "Lower the friction step by step: when does the heap collapse, and does the stiffness matter?",
    answer: "At 0.268 with rotation. The top ball presses at 30 degrees from the vertical, and the force between two balls must lie half way between this direction and the vertical, so that the lower ball does not turn. Stiffness does not enter, since forces at rest follow from the weight alone.",
};
