//! Scene of the lab: hard spheres whose collisions are found only at the ends of time steps.

use super::{LabScene, PanelSetup, SOFT, WHOLE};
use crate::experiment::Model;
use crate::lab::gauge::Gauge;
use crate::lab::parameter::{LabParameter, ParameterRange};

pub(super) const SCENE: LabScene = LabScene {
    name: "stepped",
    title: "Hard spheres that miss collisions",
    case: "limits/stepped-missed",
    sets: &[
        "domain.size=[\"5.596 mm\", \"5.596 mm\", \"5.596 mm\"]",
        "particles[0].count=500",
        "soft.linear_spring_dashpot.stiffness=3000 N/m",
        "run.window=200 us",
        "statistics.sample_interval=200 us",
        "run.duration=50 ms",
    ],
    left: PanelSetup { title: "stepped hard", model: Model::Hard, sets: &[] },
    rights: &[PanelSetup { title: "hard", model: Model::Hard, sets: &["hard.stepping=events"] }, SOFT],
    knobs: &[
        ParameterRange { knob: LabParameter::Theta, least: 0.01, most: 1.0 },
        ParameterRange { knob: LabParameter::Restitution, least: 0.5, most: 1.0 },
        ParameterRange { knob: LabParameter::Count, least: 100.0, most: 1000.0 },
        ParameterRange { knob: LabParameter::Seed, least: 1.0, most: 99.0 },
    ],
    gauge: Gauge::Missed,
    lasts: 25.0,
    view: WHOLE,
    sentences: [
        "Both panels have hard spheres, and the same rule for velocities; they differ in how collisions are found.",
        "On the left spheres fly for a step. Two spheres collide if they overlap at its end and approach; a touch that begins and ends within the step is missed.",
        "On the right every collision is done at its exact instant, from a calendar of events.",
    ],
    equation: "Δt = θ d / u_r",
    symbols: "Δt: longest step. θ: how far a typical pair comes in this step, in diameters d. u_r: mean size of one component of the relative velocity of spheres.",
    question: "How small must θ be for less than one collision in a hundred to be missed?",
    answer: "About 0.07: read the curve of missed collisions, whose last value is the share beside the counter. A grazing collision is short, and the longer the step, the more of them begin and end within it. At θ = 0.3, which the literature uses, about one in six is missed. The collisions that spheres suffer fall by more, by about 30 %: compare both curves. For collisions that are found come late, from spheres that are deep in one another.",
};
