//! Physical effects that may matter in a scene, with their sizes, and the sizes below which they can be neglected.

use super::RunPrediction;
use crate::fluid::Fluid;
use crate::scene::Scene;
use serde::Serialize;

/// [-] mass loading (mass of particles over mass of gas) above which the particles change the gas flow noticeably. This
/// is a rule of thumb: at a mass loading of a tenth the particles carry about a tenth of the momentum of the gas.
const TWO_WAY: f64 = 0.1;

/// [-] mass loading (mass of particles over mass of gas) above which a gas flow that the particles do not change is a
/// wrong model. The particles then carry more momentum than the gas.
pub const FROZEN: f64 = 1.0;

/// Physical effect in a scene, with its size and the size below which it can be neglected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// Name of the physical effect.
    pub name: &'static str,
    /// Definition, in words, of the ratio `number` that measures the size of the effect.
    pub measure: &'static str,
    /// [-] size of the effect, the ratio defined by `measure`; `None` if it cannot be computed from the scene.
    pub number: Option<f64>,
    /// [-] value of `number` (size of the effect) below which the effect can be neglected.
    pub threshold: f64,
    /// Source of `threshold`, such as a reference.
    pub source: &'static str,
    /// True if this program models the effect in the scene.
    pub modelled: bool,
}

impl Effect {
    /// True if the effect can be neglected. An effect of unknown size cannot be neglected.
    pub fn negligible(&self) -> bool {
        self.number.is_some_and(|number| number < self.threshold)
    }
}

/// Lists all physical effects that are considered, with their sizes in the scene. An effect has a threshold of its
/// own, or its threshold is the relative error that `plan` allows. The list is empty without particles.
pub fn effects(scene: &Scene, plan: &RunPrediction) -> Vec<Effect> {
    let particles = plan.particles + plan.coming.unwrap_or(0);
    if particles == 0 {
        return Vec::new();
    }
    // at critical damping a contact does not end, so it has no duration
    let times = plan.contacts.iter().map(|row| row.contact_time).filter(|time| time.is_finite());
    let longest = times.reduce(f64::max);
    let slowest = plan.contacts.iter().map(|row| row.impact_speed).reduce(f64::min);
    let surfaces = scene.surfaces(particles);
    let slip = surfaces.iter().map(|s| (s.friction * (1.0 + s.restitution)).min(2.0 / 7.0)).fold(0.0, f64::max);
    let against_target = |name, measure, number, modelled| against_target(plan, name, measure, number, modelled);
    let mut list = vec![against_target(
        "rotation",
        // 2/7 = 1/(1 + m r²/I) with I = 2/5 m r² is the share of the tangential speed that a solid, sticking sphere
        // converts to spin
        "share of the tangential speed that an impact at 45 degrees passes between translation and spin, min(μ(1+e), 2/7)",
        Some(slip),
        scene.rotation.is_some(),
    )];
    if let Some(friction) = scene.rotation.as_ref().and_then(|rotation| rotation.rolling?.friction()) {
        // at a wall the time integral of the rolling torque, μ_r r J_n with the normal impulse J_n, changes the spin by
        // μ_r r (1+e) m u_n/(2/5 m r²). Soft contacts resist rolling only after they have lasted longer than an impact
        let restitution = surfaces.iter().map(|surface| surface.restitution).fold(0.0, f64::max);
        let measure = "surface speed that a constant rolling torque would change in an impact at a wall, over the normal speed, (5/2) μ_r (1+e)";
        let number = Some(2.5 * friction * (1.0 + restitution));
        list.push(against_target("rolling resistance within impacts", measure, number, false));
    }
    if let Some(shrink) = plan.softness {
        let measure = "cross-section lost against hard spheres of the same diameter, 2 sqrt(π m T/(2k))/d";
        list.push(against_target("finite stiffness", measure, Some(2.0 * shrink), true));
    }
    if let Some((longest, slowest)) = longest.zip(slowest).filter(|_| scene.gravity.norm() > 0.0) {
        let measure = "g T_c over the mean normal speed of impact";
        list.push(against_target(
            "gravity within a contact",
            measure,
            Some(scene.gravity.norm() * longest / slowest),
            true,
        ));
    }
    if let Some(gas) = &plan.gas {
        // the pressure of a dense gas is n T (1 + 2 (1 + e) φ g): Jenkins and Richman 1985, Arch. Ration. Mech. Anal.
        // 87, 355
        let restitution = surfaces.iter().map(|surface| surface.restitution).fold(0.0, f64::max);
        let share = 2.0 * (1.0 + restitution) * gas.volume_fraction * gas.contact_value;
        let measure = "momentum that collisions carry from centre to centre over that which flights carry, 2 (1+e) φ g; below the threshold, collisions by chance (--model dsmc) suffice";
        list.push(against_target("distance between colliding centres", measure, Some(share), true));
    }
    list.extend(in_gas(scene, plan, longest));
    list
}

/// Makes an effect that can be neglected if its size `number` is below the relative error that `plan` allows.
fn against_target(
    plan: &RunPrediction,
    name: &'static str,
    measure: &'static str,
    number: Option<f64>,
    modelled: bool,
) -> Effect {
    Effect { name, measure, number, threshold: plan.target_error, source: "the error asked for", modelled }
}

/// Effects of the gas on the particles, and of the particles on the gas; the list is empty without drag. `contact` [s]
/// is the duration of the longest contact; `None` if no contact has a finite duration.
fn in_gas(scene: &Scene, plan: &RunPrediction, contact: Option<f64>) -> Vec<Effect> {
    let Some(response) = plan.flow.iter().map(|flow| flow.response_time).reduce(f64::min) else { return Vec::new() };
    let against_target = |name, measure, number, modelled| against_target(plan, name, measure, number, modelled);
    let turbulent = plan.flow.iter().map(|flow| flow.turbulent_variance).reduce(|a, b| Some(a?.max(b?))).flatten();
    let lightest = scene.species.iter().map(|species| species.density).reduce(f64::min);
    let floats = scene.fluid.as_ref().is_some_and(|fluid| fluid.buoyancy.is_some());
    let has_added_mass = scene.species.iter().any(|species| species.added_density > 0.0);
    // the gas that a sphere accelerates has half the volume of the sphere
    let (effect, measure, share) = if floats || has_added_mass {
        ("added mass", "half the density of the gas over that of the particles", 0.5)
    } else {
        ("buoyancy and added mass", "density of the gas over that of the particles", 1.0)
    };
    let ratio = |(fluid, lightest): (&Fluid, f64)| share * fluid.density / lightest;
    vec![
        against_target(
            "drag within a contact",
            "T_c over the response time at the terminal slip",
            contact.map(|time| time / response),
            false,
        ),
        against_target(
            "turbulence seen by the particles",
            "velocity variance that eddies would give, 2/3 k T_L/(T_L + τ), over that of the particles",
            turbulent.map(|variance| variance / plan.agitation.variance),
            scene.fluid.as_ref().is_some_and(|fluid| fluid.turbulence.is_some()),
        ),
        Effect {
            name: "two-way coupling",
            measure: "mass of the particles over that of the gas",
            number: Some(plan.flow.iter().map(|flow| flow.mass_loading).sum()),
            threshold: TWO_WAY,
            source: "a rule of thumb: a tenth of the mass has a tenth of the momentum",
            modelled: scene.fluid.as_ref().is_some_and(|fluid| fluid.coupling.is_some()),
        },
        against_target(
            "collisions",
            "collisions that a particle suffers within its response time",
            plan.gas.as_ref().map(|gas| gas.collision_rate * response),
            true,
        ),
        against_target(effect, measure, scene.fluid.as_ref().zip(lightest).map(ratio), has_added_mass),
    ]
}
