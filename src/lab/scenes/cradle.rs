//! Scene of the lab: Newton's cradle.

use super::{BoxView, HARD, HYBRID, LabScene, SOFT};
use crate::lab::gauge::Gauge;
use crate::lab::parameter::{LabParameter, ParameterRange};

pub(super) const SCENE: LabScene = LabScene {
    name: "cradle",
    title: "Newton's cradle",
    case: "cradle",
    sets: &[],
    left: SOFT,
    rights: &[HARD, HYBRID],
    knobs: &[
        ParameterRange { knob: LabParameter::Row, least: 3.0, most: 8.0 },
        ParameterRange { knob: LabParameter::Restitution, least: 0.5, most: 1.0 },
        ParameterRange { knob: LabParameter::Stiffness, least: 300.0, most: 30_000.0 },
        ParameterRange { knob: LabParameter::StepsPerContact, least: 5.0, most: 200.0 },
    ],
    gauge: Gauge::Speeds,
    lasts: 12.0,
    view: BoxView { right: 0, up: 1, region: Some([0.7e-3, 3.7e-3, 1.4e-3, 2.6e-3]), magnify: None },
    sentences: [
        "One sphere comes from the left and hits a row of spheres that touch one another.",
        "Hard spheres hand the blow on, one pair after the other: only the last one leaves.",
        "Soft spheres press on all their neighbours at the same time, so that several of them leave and the first one comes back.",
    ],
    equation: "hard: v = 0, 0, 0, 0, u\nsoft: v = (−0.132, −0.075, −0.031, 0.296, 0.942) u",
    symbols: "v: velocities at the end of five elastic spheres, from the first to the last; u: velocity of the blow.",
    question: "Make the spheres stiffer by ten times. Does the soft cradle come closer to the hard one?",
    answer: "No. A stiffer spring makes all contacts shorter by the same factor, but they still last at the same time, so that the velocities at the end stay the same. The two models differ where spheres touch several others at once, at any stiffness. The numbers of impacts differ as well: soft contacts that open and close again count anew. So these numbers say nothing about accuracy.",
};
