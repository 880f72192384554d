//! Scene of the lab: a gas that cools by inelastic collisions.

use super::{HARD, HYBRID, LabScene, SOFT, WHOLE};
use crate::lab::gauge::Gauge;
use crate::lab::parameter::{LabParameter, ParameterRange};

pub(super) const SCENE: LabScene = LabScene {
    name: "cooling",
    title: "A gas that cools",
    case: "cooling-gas",
    sets: &["domain.size=[\"7.05 mm\", \"7.05 mm\", \"7.05 mm\"]", "particles[0].count=500"],
    left: SOFT,
    rights: &[HARD, HYBRID],
    knobs: &[
        ParameterRange { knob: LabParameter::Restitution, least: 0.3, most: 1.0 },
        ParameterRange { knob: LabParameter::Stiffness, least: 300.0, most: 30_000.0 },
        ParameterRange { knob: LabParameter::StepsPerContact, least: 5.0, most: 50.0 },
        ParameterRange { knob: LabParameter::Count, least: 100.0, most: 2000.0 },
        ParameterRange { knob: LabParameter::Seed, least: 1.0, most: 99.0 },
    ],
    gauge: Gauge::Gas,
    lasts: 20.0,
    view: WHOLE,
    sentences: [
        "Spheres fly in a periodic box, start with the same velocities on both sides, and lose energy in every collision.",
        "After some collisions no sphere is where its twin of the other panel is: paths are chaotic and cannot be compared one by one. Two hard runs that differ in the last digit part in the same way.",
        "The temperature of both follows the same curve all the same, which kinetic theory gives.",
    ],
    equation: "T(t) = T₀ (1 + (1 − e²) G₀ t / 6)⁻²",
    symbols: "T: granular temperature. T₀: that of the start. e: restitution. G₀: collisions of a sphere per time at the start. Haff (1983).",
    question: "After how many collisions of a sphere has the temperature halved, and how does that depend on e?",
    answer: "After n = 3 ln 2/(1 − e²), about 11 at e = 0.9: read both curves at the same time. Each collision takes a share of the energy that depends on e alone, so T falls as exp(−(1 − e²) n/3). In time it falls ever more slowly, because slower spheres meet less often.",
};
