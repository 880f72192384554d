//! Scene of the lab: a ball with spin hits a plate obliquely.

use super::{BoxView, LabScene, PanelSetup, SOFT};
use crate::experiment::Model;
use crate::lab::gauge::Gauge;
use crate::lab::parameter::{LabParameter, ParameterRange};

pub(super) const SCENE: LabScene = LabScene {
    name: "oblique",
    title: "An oblique impact with spin",
    case: "rotation/oblique",
    sets: &[
        "particles[0].at[0].position=[\"20 mm\", \"3.5 mm\", \"30 mm\"]",
        "particles[0].at[0].spin=[\"0 rad/s\", \"0 rad/s\", \"1000 rad/s\"]",
        "soft.linear_spring_dashpot.stiffness=17.2 kN/m",
        "run.duration=1.2 ms",
        "run.window=4 us",
    ],
    left: SOFT,
    rights: &[
        PanelSetup { title: "hard, rule of the spring", model: Model::Hard, sets: &[] },
        PanelSetup {
            title: "hard, Walton's rule",
            model: Model::Hard,
            sets: &["hard.friction.walton.tangential_restitution=0.3"],
        },
        PanelSetup { title: "soft, without rotation", model: Model::Soft, sets: &["contact.rotation=false"] },
    ],
    knobs: &[
        ParameterRange { knob: LabParameter::Friction, least: 0.01, most: 1.0 },
        ParameterRange { knob: LabParameter::Restitution, least: 0.5, most: 1.0 },
        ParameterRange { knob: LabParameter::Stiffness, least: 10_000.0, most: 1_000_000.0 },
        ParameterRange { knob: LabParameter::StepsPerContact, least: 5.0, most: 200.0 },
    ],
    gauge: Gauge::Spin,
    lasts: 12.0,
    view: BoxView { right: 0, up: 1, region: Some([12e-3, 28e-3, 0.0, 8e-3]), magnify: None },
    sentences: [
        "A ball with backspin hits a plate: its lowest point moves faster along the plate than its centre does.",
        "Soft: friction holds the point of contact by a tangential spring or lets it slide, and the slip swings during the impact.",
        "Hard: one tangential impulse changes velocity and spin at once. The rule of the spring gives what a stiff spring would.",
    ],
    equation: "s = u − R ω,   m Δu = −J,   I Δω = R J,   J ≤ μ Jₙ",
    symbols: "s: slip of the point of contact. u: velocity along the plate. R ω: radius times spin, positive if the ball rolls forward. J: tangential impulse. μ: friction. Jₙ: normal impulse. I: moment of inertia.",
    question: "How much friction sends the ball back, and does more friction send it back faster?",
    answer: "At the friction of the case the ball slides throughout: the impulse is μ Jₙ, and the ball loses speed. From about 0.2 on the point of contact sticks, the tangential spring turns the slip round, and the ball comes back, fastest at 0.3. With 0.8 the point sticks sooner, the spring swings forth again before the contact ends, and the ball goes on. Walton's rule has one tangential restitution in place of the spring: there, more friction than 0.19 changes nothing.",
};
