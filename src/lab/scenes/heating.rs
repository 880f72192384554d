//! Scene of the lab: a gas whose energy grows by the error of a time integrator.

use super::{HARD, LabScene, SOFT, WHOLE};
use crate::lab::gauge::Gauge;
use crate::lab::parameter::{LabParameter, ParameterRange};

pub(super) const SCENE: LabScene = LabScene {
    name: "heating",
    title: "An integrator that warms the gas",
    case: "limits/heating",
    sets: &["domain.size=[\"3.27 mm\", \"3.27 mm\", \"3.27 mm\"]", "particles[0].count=100", "run.duration=10 ms"],
    left: SOFT,
    rights: &[HARD],
    knobs: &[
        ParameterRange { knob: LabParameter::Integrator, least: 0.0, most: 0.0 },
        ParameterRange { knob: LabParameter::StepsPerContact, least: 5.0, most: 50.0 },
        ParameterRange { knob: LabParameter::Stiffness, least: 300.0, most: 10_000.0 },
        ParameterRange { knob: LabParameter::Seed, least: 1.0, most: 99.0 },
    ],
    gauge: Gauge::Energy,
    lasts: 15.0,
    view: WHOLE,
    sentences: [
        "An elastic gas in a periodic box: nothing takes energy and nothing gives any, so that the energy must stay as it is.",
        "On the left contacts are stepped by a Runge-Kutta scheme of second order, which adds a little energy in every collision.",
        "On the right hard spheres collide at exact instants and keep the energy to rounding.",
    ],
    equation: "amplification per step ≈ 1 + (ω₀Δt)⁴ / 8",
    symbols: "By this factor one step of Heun's scheme makes a swing wider. ω₀Δt: step in units of the contact's own frequency, π/N_c without damping.",
    question: "Choose velocity Verlet, or twice as many steps per contact. Which helps more, and why?",
    answer: "Velocity Verlet. It is symmetric in time: what it adds in the first half of a contact it takes in the second. Heun's scheme makes every swing wider; twice the steps make each step's gain sixteen times as small, and a contact's eight times as small, but never zero. In numbers: at N_c = 7.7 a step gains (π/N_c)⁴/8 = 0.34 %, and the N_c steps of a contact gain 2.6 %. The page shows this gain as the realised e of about 1.025.",
};
