//! Which effects does this scene need, and which can be left out?

use super::Plan;
use crate::scene::Scene;
use serde::Serialize;

/// [-] mass loading from which the gas feels the particles. A rule of thumb: with a tenth of the gas's mass they carry about a tenth
/// of its momentum.
const TWO_WAY: f64 = 0.1;

/// [-] mass loading from which a gas that does not feel the particles is not this gas: they carry more momentum than it does.
pub const FROZEN: f64 = 1.0;

/// An effect, how large it is here, and whether it can be left out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// What.
    pub name: &'static str,
    /// What the number is.
    pub measure: &'static str,
    /// [-] how large it is; none where this scene gives no number for it.
    pub number: Option<f64>,
    /// [-] below this it can be left out.
    pub threshold: f64,
    /// Where the threshold is from.
    pub source: &'static str,
    /// Whether this program has it.
    pub modelled: bool,
}

impl Effect {
    /// Whether it can be left out; unknown numbers cannot.
    pub fn negligible(&self) -> bool {
        self.number.is_some_and(|number| number < self.threshold)
    }
}

/// All effects that were looked at. `target` [-] is the relative error wanted.
pub fn effects(scene: &Scene, plan: &Plan) -> Vec<Effect> {
    if plan.particles == 0 {
        return Vec::new();
    }
    let target = plan.target_error;
    const WANTED: &str = "the error asked for";
    let variance = plan.agitation.variance;
    // critical damping: a contact without end has no time to compare with
    let times = plan.contacts.iter().map(|row| row.contact_time).filter(|time| time.is_finite());
    let longest = times.reduce(f64::max);
    let slowest = plan.contacts.iter().map(|row| row.impact_speed).reduce(f64::min).unwrap_or(0.0);
    let friction = scene.walls.iter().map(|wall| wall.surface).chain((plan.particles > 1).then_some(scene.contact));
    let slip = friction.map(|s| (s.friction * (1.0 + s.restitution)).min(2.0 / 7.0)).fold(0.0, f64::max);
    let mut list = vec![Effect {
        name: "rotation",
        // 2/7 = 1/(1 + m r²/I) with I = 2/5 m r²: what a solid sphere that sticks passes on to its spin
        measure: "share of the tangential speed that an impact at 45 degrees passes between translation and spin, min(μ(1+e), 2/7)",
        number: Some(slip),
        threshold: target,
        source: WANTED,
        modelled: false,
    }];
    if let Some(shrink) = plan.softness {
        list.push(Effect {
            name: "finite stiffness",
            measure: "cross-section lost against hard spheres of the same diameter, 2 sqrt(π m T/(2k))/d",
            number: Some(2.0 * shrink),
            threshold: target,
            source: WANTED,
            modelled: true,
        });
    }
    if scene.gravity.norm() > 0.0 && longest.is_some() {
        list.push(Effect {
            name: "gravity within a contact",
            measure: "g T_c over the mean normal speed of impact",
            number: longest.map(|time| scene.gravity.norm() * time / slowest),
            threshold: target,
            source: WANTED,
            modelled: true,
        });
    }
    let Some(response) = plan.flow.iter().map(|flow| flow.response_time).reduce(f64::min) else { return list };
    list.push(Effect {
        name: "drag within a contact",
        measure: "T_c over the response time at the terminal slip",
        number: longest.map(|time| time / response),
        threshold: target,
        source: WANTED,
        modelled: false,
    });
    list.push(Effect {
        name: "turbulence seen by the particles",
        measure: "velocity variance that eddies would give, 2/3 k T_L/(T_L + τ), over that of the particles",
        number: plan
            .flow
            .iter()
            .map(|flow| flow.turbulent_variance)
            .reduce(|a, b| Some(a?.max(b?)))
            .flatten()
            .map(|t| t / variance),
        threshold: target,
        source: WANTED,
        modelled: false,
    });
    let loading: f64 = plan.flow.iter().map(|flow| flow.mass_loading).sum();
    list.push(Effect {
        name: "two-way coupling",
        measure: "mass of the particles over that of the gas",
        number: Some(loading),
        threshold: TWO_WAY,
        source: "a rule of thumb: a tenth of the mass has a tenth of the momentum",
        modelled: false,
    });
    list.push(Effect {
        name: "collisions",
        measure: "collisions that a particle suffers within its response time",
        number: plan.gas.as_ref().map(|gas| gas.collision_rate * response),
        threshold: target,
        source: WANTED,
        modelled: true,
    });
    list.push(Effect {
        name: "buoyancy and added mass",
        measure: "density of the gas over that of the particles",
        number: scene.fluid.as_ref().map(|fluid| {
            fluid.density / scene.species.iter().map(|species| species.density).fold(f64::INFINITY, f64::min)
        }),
        threshold: target,
        source: WANTED,
        modelled: false,
    });
    list
}
