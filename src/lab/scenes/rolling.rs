//! Scene of the lab: a ball that slides along a floor until it rolls.

use super::{BoxView, HYBRID, LabScene, PanelSetup, SOFT};
use crate::experiment::Model;
use crate::lab::gauge::Gauge;
use crate::lab::parameter::{LabParameter, ParameterRange};

pub(super) const SCENE: LabScene = LabScene {
    name: "rolling",
    title: "A ball that slides until it rolls",
    case: "rotation/slide-to-roll",
    sets: &["run.window=100 us"],
    left: SOFT,
    rights: &[
        PanelSetup { title: "soft, without rotation", model: Model::Soft, sets: &["contact.rotation=false"] },
        HYBRID,
    ],
    knobs: &[
        ParameterRange { knob: LabParameter::Friction, least: 0.02, most: 1.0 },
        ParameterRange { knob: LabParameter::Stiffness, least: 1_000.0, most: 100_000.0 },
        ParameterRange { knob: LabParameter::StepsPerContact, least: 10.0, most: 50.0 },
    ],
    gauge: Gauge::Spin,
    lasts: 12.0,
    view: BoxView { right: 0, up: 1, region: Some([4e-3, 9e-3, 0.0, 2.5e-3]), magnify: None },
    sentences: [
        "A ball of 1 mm starts along a floor at 0.1 m/s, without spin.",
        "With rotation, friction brakes the ball and turns it until its lowest point stands still: from then on it rolls.",
        "Without rotation the same friction brakes it all the time, until it stands. Hard spheres are not offered here: they cannot lie on a floor, and their run would stop at once.",
    ],
    equation: "t = 2 u₀ / (7 μ g),   u = 5 u₀ / 7",
    symbols: "t: when it begins to roll. u₀: velocity at the start. u: velocity from then on. μ: friction. g: gravity.",
    question: "Twice the friction: how fast does the ball roll in the end?",
    answer: "Just as fast, at five sevenths of its first velocity, but it begins to roll in half the time. What friction takes from the motion and gives to the spin does not depend on how long that takes. Once the ball rolls, the force of friction is zero, and nothing brakes it: that would take rolling resistance.",
};
