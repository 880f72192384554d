//! Scene of the lab: soft spheres with a time step that is too long.

use super::{HARD, LabScene, SOFT, WHOLE};
use crate::lab::gauge::Gauge;
use crate::lab::parameter::{LabParameter, ParameterRange};

pub(super) const SCENE: LabScene = LabScene {
    name: "unstable",
    title: "A time step that is too long",
    case: "limits/heating",
    sets: &[
        "domain.size=[\"2.07 mm\", \"2.07 mm\", \"2.07 mm\"]",
        "particles[0].count=50",
        "particles[0].velocity_fluctuation=0.2 m/s",
        "soft.integrator=velocity_verlet",
        "soft.steps_per_contact=2",
        "run.duration=10 ms",
    ],
    left: SOFT,
    rights: &[HARD],
    knobs: &[
        ParameterRange { knob: LabParameter::StepsPerContact, least: 1.2, most: 20.0 },
        ParameterRange { knob: LabParameter::Integrator, least: 0.0, most: 0.0 },
        ParameterRange { knob: LabParameter::Restitution, least: 0.5, most: 1.0 },
        ParameterRange { knob: LabParameter::Seed, least: 1.0, most: 99.0 },
    ],
    gauge: Gauge::Explosion,
    lasts: 15.0,
    view: WHOLE,
    sentences: [
        "The same elastic gas, with a time step so long that spheres are deep in one another before the spring is asked for the first time.",
        "The spring then throws them apart with more energy than they came with: the soft gas explodes.",
        "The hard gas has no step that could be too long.",
    ],
    equation: "ω₀ Δt < 2",
    symbols: "The stability limit of velocity Verlet without damping: N_c > π/2. A contact needs far more steps to be right: ten or more.",
    question: "From which number of steps per contact on does the energy stay? Is the result right there?",
    answer: "From about three on. A contact that lasts is stable above π/2 steps; a short one begins somewhere within a step, and with two steps it gains energy on average. Kept on average is not yet right: at three steps single impacts come out too fast or too slow, and only ten or more make the realised e that of each impact. Below π/2 steps the program itself stops and says why.",
};
