//! Scene of the lab: a column of spheres on a floor.

use super::{BoxView, HARD, HYBRID, LabScene, SOFT};
use crate::lab::gauge::Gauge;
use crate::lab::parameter::{LabParameter, ParameterRange};

pub(super) const SCENE: LabScene = LabScene {
    name: "column",
    title: "A column that must carry its weight",
    case: "column",
    sets: &["run.duration=0.2 s"],
    left: SOFT,
    rights: &[HARD, HYBRID],
    knobs: &[
        ParameterRange { knob: LabParameter::Row, least: 2.0, most: 12.0 },
        ParameterRange { knob: LabParameter::Restitution, least: 0.2, most: 0.9 },
        ParameterRange { knob: LabParameter::Stiffness, least: 1.0, most: 100.0 },
        ParameterRange { knob: LabParameter::StepsPerContact, least: 5.0, most: 50.0 },
    ],
    gauge: Gauge::Column,
    lasts: 15.0,
    view: BoxView { right: 0, up: 1, region: Some([1e-3, 3e-3, 0.0, 5e-3]), magnify: None },
    sentences: [
        "A column of spheres stands on a floor, all in touch; only weight acts.",
        "Soft spheres sink into one another until every spring carries what lies above it: the lowest contact is the deepest.",
        "Hard spheres cannot carry anything between collisions, so that they would have to collide infinitely often: the run stops and says so.",
    ],
    equation: "δᵢ = (n − i) m g / kₙ",
    symbols: "δᵢ: overlap below sphere i, counted from the floor and from 0. n: number of spheres. m: mass of one. g: gravity. kₙ: stiffness.",
    question: "Which contact overlaps most, and how does that depend on the stiffness?",
    answer: "The one with the floor: it carries the weight of all spheres. Twice the stiffness halves every overlap. Hard spheres are the limit without overlap, and there a force that lasts does not exist: impulses take its place, and a column at rest would need infinitely many.",
};
