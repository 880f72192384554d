//! Factors (changes of the case) for spheres that rotate: rotation, the tangential law, and rolling resistance.

use super::factors::{listed, no_size, plain, sized, why};
use super::plan::{PlannedFactor, SensitivityPlan};
use crate::rotation::{ImpactRule, LinearTangential, TangentialLaw};
use crate::scene::Surface;

/// [-] tangential restitution β_0 of glass on glass (Foerster et al. 1994). `TANGENTIAL_ERROR` is its standard error.
pub(super) const GLASS_TANGENTIAL: f64 = 0.44;
const TANGENTIAL_ERROR: f64 = 0.07;
/// [-] stiffness ratio κ = k_t/k_n of elastic spheres: 2(1-ν)/(2-ν) for Poisson's ratio ν = 0.3 (Mindlin 1949).
const ELASTIC_RATIO: f64 = 0.8235;
/// [-] stiffness ratio κ = k_t/k_n for which the normal and the tangential spring of solid spheres have equal periods.
/// Many soft-sphere codes use this ratio (Schäfer, Dippel and Wolf 1996, J. Phys. I 6, 5).
const EQUAL_PERIODS: f64 = 0.2857;
/// [-] rolling friction coefficient so small that its torque is below rounding errors.
const NO_TORQUE: f64 = 1e-15;

/// Plans the run without rotation or, if the spheres of the case do not rotate, a run with rotation. The change has no
/// size that could be typed, so a `size` is an error.
pub fn rotation(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    no_size(size)?;
    let first = plan.first();
    let scene = &plan.run(first).scene;
    if scene.rotation.is_some() {
        let run = plan.add("no rotation", &["contact.rotation=false".into()], None, None)?;
        return Ok(PlannedFactor::against(first, run, "rotation → none", "the paper's spheres do not rotate"));
    }
    let rough = |surface: &Surface| surface.friction > 0.0;
    let most = plan.reference().most_that_touch(plan.reference().count());
    if !scene.surfaces(most).iter().any(rough) {
        return Err("there is no friction that could turn a particle".into());
    }
    let rule = format!("hard.friction.walton.tangential_restitution={GLASS_TANGENTIAL}");
    let run = plan.add("rotation", &["contact.rotation=true".into(), rule], None, None)?;
    let change = format!("no rotation → rotation, β_0 = {GLASS_TANGENTIAL}");
    Ok(PlannedFactor::against(first, run, change, "glass, Foerster et al. 1994"))
}

/// Plans the run with a changed tangential restitution β_0. It is the β_0 of the impact rule for hard spheres or, if
/// this rule has none, that of the tangential spring of soft spheres. `size` is the new value as typed by the user;
/// `None` means a change by the standard error of measurements.
pub fn tangential_restitution(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let first = plan.first();
    let Some(rotation) = plan.run(first).scene.rotation.clone() else { return Err("spheres do not rotate".into()) };
    let of_rule = match rotation.impact {
        ImpactRule::Walton { tangential_restitution } => Some(tangential_restitution),
        ImpactRule::OfSpring(_) => None,
    };
    let of_spring = match rotation.tangential {
        TangentialLaw::Linear(LinearTangential::Restitution(restitution)) => Some(restitution),
        _ => None,
    };
    let Some(own) = of_rule.or(of_spring) else { return Err("the case gives a stiffness ratio in its place".into()) };
    // β_0 is increased unless it would exceed 1, its largest possible value
    let usual = plain(if own + TANGENTIAL_ERROR <= 1.0 { own + TANGENTIAL_ERROR } else { own - TANGENTIAL_ERROR });
    let to = sized(size, usual, -1.0, 1.0)?;
    let key = if of_rule.is_some() { "hard.friction.walton" } else { "soft.tangential.linear" };
    let run = plan.add(&format!("β_0 = {to}"), &[format!("{key}.tangential_restitution={to}")], None, None)?;
    let usual = "a measured tangential restitution is known to ± 0.07, Foerster et al. 1994";
    Ok(PlannedFactor::against(first, run, format!("β_0 {} → {to}", plain(own)), why(size, usual)))
}

/// Plans the run with a changed stiffness ratio k_t/k_n of the linear tangential law. `size` is the new ratio as typed
/// by the user; `None` means the ratio of elastic spheres or, if the case has this ratio approximately (within 0.27),
/// the ratio for equal periods.
pub fn tangential_stiffness(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let first = plan.first();
    let Some(rotation) = plan.run(first).scene.rotation.clone() else { return Err("spheres do not rotate".into()) };
    let own = match rotation.tangential {
        TangentialLaw::Linear(LinearTangential::Ratios { stiffness, .. }) => stiffness,
        TangentialLaw::Linear(LinearTangential::Restitution(_)) => {
            return Err("the case gives a tangential restitution in its place".into());
        }
        TangentialLaw::Mindlin { .. } => return Err("Mindlin's law has the stiffness of the material".into()),
        TangentialLaw::Coulomb => return Err("there is no tangential spring".into()),
    };
    let elastic = (own - ELASTIC_RATIO).abs() > 0.5 * (ELASTIC_RATIO - EQUAL_PERIODS);
    let to = sized(size, if elastic { ELASTIC_RATIO } else { EQUAL_PERIODS }, 1e-6, 10.0)?;
    let key = "soft.tangential.linear.stiffness_ratio";
    let run = plan.add(&format!("k_t/k_n = {to}"), &[format!("{key}={to}")], None, None)?;
    let usual = if elastic {
        "that of elastic spheres with Poisson's ratio 0.3, Mindlin 1949"
    } else {
        "both springs swing alike, Schäfer et al. 1996"
    };
    Ok(PlannedFactor::against(first, run, format!("k_t/k_n {} → {}", plain(own), plain(to)), why(size, usual)))
}

/// Plans the run with the rolling friction coefficient `size` [-]; without a `size`, the run has no rolling
/// resistance. Walls, and pairs in the list `contact.pairs`, that have coefficients of their own get the new
/// coefficient too. If the case has no rolling resistance, a `size` is required, since no value is usual.
pub fn rolling(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let first = plan.first();
    let reference = plan.run(first);
    let Some(rotation) = reference.scene.rotation.clone() else { return Err("spheres do not rotate".into()) };
    if !reference.model().has_contacts() {
        return Err("impacts leave rolling resistance out, and hard spheres have nothing else".into());
    }
    let own = rotation.rolling.map(|law| law.to_string());
    if own.is_none() && size.is_none() {
        return Err("there is no rolling resistance, and no value is usual: try one, as in rolling=0.05".into());
    }
    let to = sized(size, 0.0, 0.0, 10.0)?;
    let mut sets = vec![match to {
        // a change cannot remove a table of the case, so the torque is made negligible
        0.0 => format!("soft.rolling.constant.friction={NO_TORQUE}"),
        _ => format!("soft.rolling.spring.friction={to}"),
    }];
    sets.extend(with_rolling_friction(plan).into_iter().map(|table| format!("{table}.rolling_friction={to}")));
    let name = if to > 0.0 { format!("μ_r = {to}") } else { "no rolling resistance".to_owned() };
    let run = plan.add(&name, &sets, None, None)?;
    let change = format!("{} → {name}", own.unwrap_or("none".into()));
    Ok(PlannedFactor::against(
        first,
        run,
        change,
        why(size, "spheres that are round and do not deform do not resist rolling"),
    ))
}

/// Names of the tables with a rolling friction coefficient of their own, among the tables of walls and of the pairs in
/// the list `contact.pairs`.
fn with_rolling_friction(plan: &SensitivityPlan) -> Vec<String> {
    let walls = plan.reference().scene.walls.iter().enumerate();
    let walls = walls.filter(|(_, wall)| wall.resistance.rolling.is_some()).map(|(k, _)| format!("walls[{k}]"));
    let pairs = listed(plan, |_| true).into_iter().filter(|(_, meeting)| meeting.resistance.rolling.is_some());
    walls.chain(pairs.map(|(table, _)| table)).collect()
}
