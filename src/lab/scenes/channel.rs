//! Scene of the lab: a short and narrow piece of the channel flow of the paper (docs/paper.md).

use super::{BoxView, HARD, LabScene, SOFT};
use crate::lab::gauge::Gauge;
use crate::lab::parameter::{LabParameter, ParameterRange};

pub(super) const SCENE: LabScene = LabScene {
    name: "channel",
    title: "Particles in a channel",
    case: "quick",
    sets: &["domain.size=[\"50 mm\", \"40 mm\", \"32 mm\"]", "particles[0].count=507", "run.duration=20 s"],
    left: SOFT,
    rights: &[HARD],
    knobs: &[
        ParameterRange { knob: LabParameter::Restitution, least: 0.8, most: 1.0 },
        ParameterRange { knob: LabParameter::Friction, least: 0.0, most: 0.5 },
        ParameterRange { knob: LabParameter::Stiffness, least: 500.0, most: 50_000.0 },
        ParameterRange { knob: LabParameter::StepsPerContact, least: 5.0, most: 50.0 },
        ParameterRange { knob: LabParameter::Count, least: 100.0, most: 1000.0 },
        ParameterRange { knob: LabParameter::Window, least: 100.0, most: 5000.0 },
    ],
    gauge: Gauge::Channel,
    lasts: 60.0,
    view: BoxView { right: 2, up: 1, region: None, magnify: None },
    sentences: [
        "Air blows particles of 1.5 mm to the right against gravity, between an upper and a lower wall; they meet the walls and one another.",
        "The profiles below are averages over height slices: they fill in, and their error bars, drawn from eight blocks of time on, shrink as more is averaged.",
        "The verdict is that of the command compare: first nothing can be said, and later the models are found equal within a margin, or not. Here the margin is 10 %, since few spheres in 20 s cannot decide a smaller one.",
    ],
    equation: "error ~ 1/√(averaging time)",
    symbols: "error: standard error of an average, from how far averages over blocks of time scatter.",
    question: "Both profiles differ a little at every moment. When is that a difference between the models?",
    answer: "When it is larger than its error explains. Two runs of the same model with other starts differ as well; the error bars tell by how much. A difference that shrinks as the errors shrink is chance. It is a difference of the models if it stays, at three or more of its standard errors, while these shrink, and other seeds give it again.",
};
