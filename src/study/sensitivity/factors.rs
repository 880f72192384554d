//! Built-in factors of a sensitivity study. A factor is a change of the case; the change has a size, and a reason for
//! this size.
//!
//! If the case is idealised (restitution 1, no friction), a factor sets a value of real particles. If the case has such
//! a value, the factor changes it by the uncertainty of measurements. If a factor makes no sense for a scene, its
//! function returns the reason. The paper is the channel study of docs/paper.md.

use super::plan::{PlannedFactor, SensitivityPlan};
use super::rotating::{rolling, rotation, tangential_restitution, tangential_stiffness};
use crate::contact_law::ContactLaw;
use crate::experiment::{Amount, Experiment, HardStepping, Integrator, Model, TimeStep};
use crate::fluid::Profile;
use crate::output::numbers::quantity;
use crate::scene::{Kind, Meeting, Surface};

/// [-] restitution of the inelastic walls of the paper (docs/paper.md, section 4). A study of sensitivity changes a
/// restitution of 1 to this value.
const PAPER_RESTITUTION: f64 = 0.94;
/// [-] standard error of a measured restitution, by which the study reduces a restitution below 1: cellulose acetate
/// 0.87 ± 0.02 (Foerster, Louge, Chang and Allia 1994, Phys. Fluids 6, 1108).
const RESTITUTION_ERROR: f64 = 0.02;
/// [-] friction coefficient of glass on glass (Foerster et al. 1994). A study of sensitivity gives this friction to
/// particles that have none.
const GLASS_FRICTION: f64 = 0.092;
/// [-] friction coefficient of the rough walls of the paper (docs/paper.md, section 4). A study of sensitivity gives
/// this friction to walls that have none.
const PAPER_WALL_FRICTION: f64 = 0.325;
/// [-] standard error of a measured friction coefficient, by which the study increases a friction that is not 0:
/// cellulose acetate 0.25 ± 0.02 (Foerster et al. 1994).
const FRICTION_ERROR: f64 = 0.02;
/// [-] number of steps per contact in the cases B to D of the paper, from the time step and the stiffness that the
/// paper prints (docs/paper.md, "The audit").
const PAPER_STEPS: f64 = 7.7;
/// [-] step criterion θ of hard spheres that move in time steps: distance by which a typical pair of spheres approaches
/// in one step, divided by the diameter. The value is a third of the usual 0.3, at which fast spheres pass through
/// walls (docs/limits.md).
const THETA: f64 = 0.1;
/// [-] factor by which the stiffness is reduced from run to run. The first of three runs has the stiffness of the
/// case. Each reduction by 4 doubles the overlaps of linear springs, so the overlaps of the third run are four times
/// as deep.
const STIFFNESS_RATIO: f64 = 4.0;
/// [-] length of the shortened box divided by that of the box of the case.
const BOX_SHARE: f64 = 0.5;

/// Function that plans the runs of a factor (a change of the case), or returns the reason why the factor makes no
/// sense. The second argument is the size of the change as typed by the user; `None` if the user typed no size.
type Make = fn(&mut SensitivityPlan, Option<&str>) -> Result<PlannedFactor, String>;

/// Built-in factor of a sensitivity study: a change of the case that the user can select by name.
pub struct Known {
    /// Name of the factor on the command line.
    pub name: &'static str,
    /// Title of the factor in a sentence, such as "the stiffness".
    pub title: &'static str,
    /// Function that plans the runs of the factor, or returns the reason why the factor makes no sense.
    pub make: Make,
}

/// All built-in factors of a sensitivity study, in the order of the help text.
pub const KNOWN: [Known; 16] = [
    Known { name: "model", title: "the contact model", make: model },
    Known { name: "stiffness", title: "the stiffness", make: stiffness },
    Known { name: "integrator", title: "the integrator of soft contacts", make: integrator },
    Known { name: "stepping", title: "the stepping of hard spheres", make: stepping },
    Known { name: "restitution", title: "the restitution between particles", make: restitution },
    Known { name: "wall-restitution", title: "the restitution at walls", make: wall_restitution },
    Known { name: "friction", title: "the friction between particles", make: friction },
    Known { name: "wall-friction", title: "the friction at walls", make: wall_friction },
    Known { name: "rotation", title: "the rotation of particles", make: rotation },
    Known { name: "tangential-restitution", title: "the tangential restitution", make: tangential_restitution },
    Known { name: "tangential-stiffness", title: "the tangential stiffness", make: tangential_stiffness },
    Known { name: "rolling", title: "the rolling resistance", make: rolling },
    Known { name: "gas", title: "the gas profile", make: gas },
    Known { name: "drag", title: "the drag law", make: drag },
    Known { name: "box", title: "the length of the box", make: shorter_box },
    Known { name: "seed", title: "another seed", make: seed },
];

/// Size of a change: the number in the text `size` that the user typed, or `usual` if nothing was typed. Returns an
/// error if the number is not within `from ..= to`.
pub(super) fn sized(size: Option<&str>, usual: f64, from: f64, to: f64) -> Result<f64, String> {
    let Some(text) = size else { return Ok(usual) };
    let number = text.trim().parse().ok().filter(|number| (from..=to).contains(number));
    number.ok_or_else(|| format!("its size `{text}` is no number from {from} to {to}"))
}

/// Reason for the size of a change: "as asked for" if the user typed a size, else the text `usual`.
pub(super) fn why(size: Option<&str>, usual: impl Into<String>) -> String {
    if size.is_some() { "as asked for".into() } else { usual.into() }
}

/// Returns an error if the user typed a size for a factor that has no size.
pub(super) fn no_size(size: Option<&str>) -> Result<(), String> {
    size.map_or(Ok(()), |text| Err(format!("it has no size, and `{text}` is given")))
}

/// Number rounded to six decimals, as a user would type it.
pub(super) fn plain(number: f64) -> f64 {
    (1e6 * number).round() / 1e6
}

/// Description of the soft spheres of a case: symbol and value of the elastic parameter of their contact law, such as
/// "k_n = 3 kN/m". Without a contact law, the description is "soft".
fn stiff(law: Option<ContactLaw>) -> String {
    law.map_or("soft".into(), |law| {
        let parameter = law.parameter();
        format!("{} = {}", parameter.symbol, quantity(parameter.value, parameter.unit, 3))
    })
}

fn model(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    no_size(size)?;
    let (other, change) = match plan.reference().model() {
        Model::Soft => (plan.hard()?, format!("soft ({}) → hard", stiff(plan.reference().law()))),
        Model::Hybrid => (plan.hard()?, "hybrid → hard".to_owned()),
        Model::Dsmc => (plan.hard()?, "dsmc → hard".to_owned()),
        Model::Hard => {
            let soft = plan.soft()?;
            (soft, format!("hard → soft ({})", stiff(plan.run(soft).law())))
        }
    };
    Ok(PlannedFactor::against(plan.first(), other, change, "the question of this program"))
}

fn stiffness(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let ratio = sized(size, STIFFNESS_RATIO, 1.1, 1e4)?;
    let soft = plan.soft()?;
    let law = plan.run(soft).law().ok_or("there is no contact law")?;
    let parameter = law.parameter();
    let mut runs = vec![(soft, 1.0)];
    // a stiffness that is larger by the factor s reduces overlaps by the factor s^(1/power). The power follows from
    // `stiffening(2.0)`, the factor s that halves the overlaps
    let power = law.stiffening(2.0).log2();
    for k in 1..=2 {
        let factor = ratio.powi(k);
        let softer = law.stiffened(1.0 / factor).parameter().value;
        let name = format!("{} = {}", parameter.symbol, quantity(softer, parameter.unit, 3));
        let sets = [format!("{} = \"{softer:e} {}\"", parameter.path(), parameter.unit)];
        runs.push((plan.add(&name, &sets, Some(Model::Soft), None)?, factor.powf(1.0 / power)));
    }
    let change = format!("{} → ∞", stiff(Some(law)));
    let usual = format!(
        "extrapolated from {}, that over {} and over {}: what softness does goes with the depth of the overlaps (docs/theory/softness.md)",
        stiff(Some(law)),
        plain(ratio),
        plain(ratio * ratio)
    );
    Ok(PlannedFactor::extrapolated(runs, change, usual))
}

fn integrator(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let steps = sized(size, PAPER_STEPS, 1.0, 1e6)?;
    let soft = plan.soft()?;
    let before = match plan.run(soft).soft.time_step {
        TimeStep::PerContact(steps) => format!("{} steps per contact", plain(steps)),
        TimeStep::Fixed(step) => format!("steps of {}", quantity(step, "s", 3)),
    };
    let sets = |name: &str| vec![format!("soft.integrator={name}"), format!("soft.steps_per_contact={steps}")];
    let (sets, to) = match plan.run(soft).soft.integrator {
        Integrator::VelocityVerlet => (sets("rk2"), "RK2"),
        Integrator::Rk2 => (sets("velocity_verlet"), "velocity Verlet"),
    };
    let run = plan.add(&format!("{to}, N_c = {}", plain(steps)), &sets, Some(Model::Soft), None)?;
    let change = format!("{before} → {to} at N_c = {}", plain(steps));
    Ok(PlannedFactor::against(soft, run, change, why(size, "the steps per contact of the paper's cases B to D")))
}

fn stepping(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let theta = sized(size, THETA, 1e-6, 1.0)?;
    let hard = plan.hard()?;
    if let HardStepping::Steps { .. } = plan.run(hard).hard.stepping {
        let run = plan.add("hard, events", &["hard.stepping=events".into()], Some(Model::Hard), None)?;
        return Ok(PlannedFactor::against(hard, run, "steps → events", "the exact instants"));
    }
    let sets = ["hard.stepping=steps".into(), format!("hard.theta={theta}")];
    let run = plan.add(&format!("hard, θ = {}", plain(theta)), &sets, Some(Model::Hard), None)?;
    let change = format!("events → steps, θ = {}", plain(theta));
    Ok(PlannedFactor::against(
        hard,
        run,
        change,
        why(size, "a third of the usual 0.3, at which fast spheres pass through walls"),
    ))
}

/// Names of all tables of a case that define a surface: those of contacts between particles, of walls, and of the pairs
/// in the list `contact.pairs`.
pub fn surfaces(plan: &SensitivityPlan) -> Vec<String> {
    let pairs = pairs(plan).unwrap_or_default().into_iter().map(|(table, _)| table);
    let walls = walls(plan, |surface| surface.friction).unwrap_or_default().into_iter().map(|(table, _)| table);
    pairs.chain(walls).collect()
}

/// Tables of a case that define contacts between particles: `contact`, and one for each pair of species in the list
/// `contact.pairs`. Each entry has the name of the table and the surface properties that the table defines.
fn pairs(plan: &SensitivityPlan) -> Result<Vec<(String, Surface)>, String> {
    let reference = plan.reference();
    if reference.most_that_touch(reference.count()) < 2 {
        return Err("there is one particle only".into());
    }
    let listed = listed(plan, |other| matches!(other, Kind::Species(_)));
    let listed = listed.into_iter().map(|(table, meeting)| (table, meeting.surface));
    Ok(std::iter::once(("contact".to_owned(), reference.scene.contact)).chain(listed).collect())
}

/// Names of the tables in the list `contact.pairs` whose second kind of body is `wanted` (a species or a wall), each
/// with its contact properties. To find the pair of bodies to which a table belongs, the function changes the friction
/// in this table on trial. The table belongs to the pair whose friction then differs.
pub(super) fn listed(plan: &SensitivityPlan, wanted: fn(&Kind) -> bool) -> Vec<(String, Meeting)> {
    /// [-] friction coefficient of the trial, which does not occur in any case.
    const PROBE: f64 = 0.123_456_789;
    let before = &plan.reference().scene.pairs;
    let tables = (0..before.iter().count()).map_while(|k| {
        let table = format!("contact.pairs[{k}]");
        let probed = plan.changed(&[format!("{table}.friction={PROBE}")], None, None).ok()?;
        let changed = before.iter().zip(probed.scene.pairs.iter()).find(|(a, b)| a.2.surface != b.2.surface);
        Some(changed.map(|((_, other, meeting), _)| (table, *other, *meeting)))
    });
    tables.flatten().filter(|(_, other, _)| wanted(other)).map(|(table, _, meeting)| (table, meeting)).collect()
}

fn restitution(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let to = |own: f64| sized(size, usual_restitution(own), 0.0, 1.0);
    let surfaces = pairs(plan)?;
    refuse_by_speed(surfaces.iter().map(|(_, surface)| surface))?;
    let own = surfaces.into_iter().map(|(key, surface)| (key, surface.restitution));
    let all: Vec<_> = own.map(|(key, own)| Ok((key, own, to(own)?))).collect::<Result<_, String>>()?;
    let first = all.first().map_or(1.0, |one| one.1);
    surface(plan, &all, ("restitution", "e"), why(size, why_restitution(first)))
}

/// Returns an error if the restitution of a surface depends on the speed, since the factor (change of the case) sets
/// one number.
fn refuse_by_speed<'a>(mut surfaces: impl Iterator<Item = &'a Surface>) -> Result<(), String> {
    match surfaces.any(|surface| surface.by_speed.is_some()) {
        true => Err("the restitution depends on the speed: `diptych sweep` changes the keys of its law".into()),
        false => Ok(()),
    }
}

fn wall_restitution(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    refuse_by_speed(plan.reference().scene.walls.iter().map(|wall| &wall.surface))?;
    let walls = walls(plan, |surface| surface.restitution)?;
    let to = |own: f64| sized(size, usual_restitution(own), 0.0, 1.0);
    let all: Vec<_> = walls.into_iter().map(|(key, own)| Ok((key, own, to(own)?))).collect::<Result<_, String>>()?;
    let first = all.first().map_or(1.0, |one| one.1);
    surface(plan, &all, ("restitution", "wall e"), why(size, why_restitution(first)))
}

fn friction(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let usual = |own: f64| if own == 0.0 { GLASS_FRICTION } else { plain(own + FRICTION_ERROR) };
    let to = |own: f64| sized(size, usual(own), 0.0, 100.0);
    let own = pairs(plan)?.into_iter().map(|(key, surface)| (key, surface.friction));
    let all: Vec<_> = own.map(|(key, own)| Ok((key, own, to(own)?))).collect::<Result<_, String>>()?;
    let smooth = all.iter().all(|(_, own, _)| *own == 0.0);
    let source = if smooth { "glass on glass, Foerster et al. 1994" } else { FRICTION_IS_KNOWN };
    surface(plan, &all, ("friction", "μ"), why(size, source))
}

fn wall_friction(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let walls = walls(plan, |surface| surface.friction)?;
    let usual = |own: f64| if own == 0.0 { PAPER_WALL_FRICTION } else { plain(own + FRICTION_ERROR) };
    let to = |own: f64| sized(size, usual(own), 0.0, 100.0);
    let all: Vec<_> = walls.into_iter().map(|(key, own)| Ok((key, own, to(own)?))).collect::<Result<_, String>>()?;
    let ideal = all.iter().all(|(_, own, _)| *own == 0.0);
    let source = if ideal { "the paper's rough walls" } else { FRICTION_IS_KNOWN };
    surface(plan, &all, ("friction", "wall μ"), why(size, source))
}

/// Reason for the size of the change of a friction coefficient, as text for the report.
const FRICTION_IS_KNOWN: &str = "a measured friction is known to ± 0.02, Foerster et al. 1994";

fn usual_restitution(own: f64) -> f64 {
    if own == 1.0 { PAPER_RESTITUTION } else { plain((own - RESTITUTION_ERROR).max(0.0)) }
}

fn why_restitution(own: f64) -> &'static str {
    if own == 1.0 {
        "the paper's inelastic walls"
    } else {
        "a measured restitution is known to ± 0.02, Foerster et al. 1994"
    }
}

/// Names of the tables of all walls and of all listed pairs with a wall. With each table comes the property of its
/// surface that the function `of` returns, such as the friction.
fn walls(plan: &SensitivityPlan, of: fn(&Surface) -> f64) -> Result<Vec<(String, f64)>, String> {
    let walls = &plan.reference().scene.walls;
    if walls.is_empty() {
        return Err("there are no walls".into());
    }
    let every = walls.iter().enumerate().map(|(k, wall)| (format!("walls[{k}]"), of(&wall.surface)));
    let listed = listed(plan, |other| matches!(other, Kind::Wall(_)));
    Ok(every.chain(listed.iter().map(|(table, meeting)| (table.clone(), of(&meeting.surface)))).collect())
}

/// Factor (change of the case) that changes the key `key` of several surfaces. `symbol` is the symbol of the key in
/// texts. Each surface is given by the name of its table, the old value and the new value.
fn surface(
    plan: &mut SensitivityPlan,
    surfaces: &[(String, f64, f64)],
    (key, symbol): (&str, &str),
    why: String,
) -> Result<PlannedFactor, String> {
    if surfaces.iter().all(|(_, own, to)| own == to) {
        return Err("it has that value already".into());
    }
    let sets: Vec<String> = surfaces.iter().map(|(table, _, to)| format!("{table}.{key}={to}")).collect();
    let mut changes: Vec<String> =
        surfaces.iter().map(|(_, own, to)| format!("{} → {}", plain(*own), plain(*to))).collect();
    changes.dedup();
    let change = format!("{symbol}: {}", changes.join(", "));
    let run = plan.add(&change, &sets, None, None)?;
    Ok(PlannedFactor::against(plan.first(), run, change, why))
}

fn gas(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let reference = plan.reference();
    let fluid =
        reference.scene.fluid.as_ref().filter(|fluid| fluid.drag.is_some()).ok_or("no gas acts on the particles")?;
    let bulk = fluid.profile.bulk_velocity();
    let reynolds = bulk.map(|bulk| bulk * reference.scene.domain.size.y / fluid.kinematic_viscosity);
    let usual = match &fluid.profile {
        Profile::Channel(_) => "log_law",
        Profile::LogLaw(_) => "k_epsilon",
        Profile::Pipe(_) if size.is_none() => return Err("no other flow in a pipe is known".into()),
        Profile::Pipe(_) => return Err("the other profiles are those of channels, and this is a pipe".into()),
        Profile::Uniform(_) if size.is_none() => return Err("its velocity is the same everywhere".into()),
        Profile::Tabulated(_) if size.is_none() => {
            return Err("its profile is a table, and of another one only you know: gas=FILE.csv".into());
        }
        Profile::Uniform(_) | Profile::Tabulated(_) => "log_law",
    };
    let to = size.unwrap_or(usual);
    let by_number = |table: &str| match reynolds {
        Some(number) => Ok(format!("fluid.profile.{table}.reynolds_number={number}")),
        None => Err(format!("a profile without a Reynolds number cannot be replaced by {table}")),
    };
    let (sets, name) = match to {
        "log_law" => (vec![by_number("log_law")?], "logarithmic law".to_owned()),
        "k_epsilon" => (vec![by_number("k_epsilon_channel")?], "k-ε, wall functions".to_owned()),
        "launder_sharma" => {
            let model = "fluid.profile.k_epsilon_channel.model=launder_sharma".to_owned();
            (vec![by_number("k_epsilon_channel")?, model], "k-ε, Launder-Sharma".to_owned())
        }
        file if file.ends_with(".csv") => (vec![format!("fluid.profile.table.file={file}")], file.to_owned()),
        other => return Err(format!("`{other}` is no profile: log_law, k_epsilon, launder_sharma or FILE.csv")),
    };
    let before = match &fluid.profile {
        Profile::Channel(_) => "k-ε",
        Profile::LogLaw(_) => "logarithmic law",
        Profile::Uniform(_) => "uniform",
        Profile::Tabulated(_) => "table",
        Profile::Pipe(_) => "pipe",
    };
    let change = format!("{before} → {name}");
    let run = plan.add(&format!("gas: {name}"), &sets, None, None)?;
    let usual = "another good profile of the same channel and bulk velocity";
    Ok(PlannedFactor::against(plan.first(), run, change, why(size, usual)))
}

fn drag(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let fluid = plan.reference().scene.fluid.as_ref();
    let law = fluid.and_then(|fluid| fluid.drag.as_ref()).ok_or("no gas acts on the particles")?;
    let before = law.law().name();
    let to = size.unwrap_or(if before == "stokes" { "schiller_naumann" } else { "stokes" });
    if to == before {
        return Err("it has that law already".into());
    }
    let run = plan.add(&format!("drag: {}", title(to)), &[format!("drag.{to}={{}}")], None, None)?;
    let change = format!("{} → {}", title(before), title(to));
    Ok(PlannedFactor::against(plan.first(), run, change, why(size, "another law of this program")))
}

/// Name of a law of a case as a title: `schiller_naumann` becomes "Schiller-Naumann".
fn title(name: &str) -> String {
    let capital = |word: &str| {
        let mut rest = word.chars();
        rest.next().map_or(String::new(), |first| first.to_uppercase().chain(rest).collect())
    };
    name.split('_').map(capital).collect::<Vec<_>>().join("-")
}

fn shorter_box(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let share = sized(size, BOX_SHARE, 0.01, 100.0)?;
    let reference = plan.reference();
    let scene = &reference.scene;
    // the box is shortened along the flow if it is periodic there, else across the flow
    let axis = [2, 0].into_iter().find(|axis| scene.domain.periodic[*axis]);
    let axis = axis.ok_or("the box repeats itself neither along z nor along x")?;
    if reference.start.iter().any(|population| matches!(population.amount, Amount::Placed(_))) {
        return Err("particles start at given places".into());
    }
    if scene.walls.iter().any(|wall| !wall.geometry.is_flat()) {
        return Err("a body stands in the box".into());
    }
    let before = scene.domain.size[axis];
    let counts: Vec<usize> = reference.start.iter().map(|population| population.amount.count()).collect();
    let after = before * share;
    let name = format!("box: {} along {}", quantity(after, "m", 4), ["x", "y", "z"][axis]);
    let shorter = format!("domain.size[{axis}]=\"{after:e} m\"");
    let number = |k: usize| format!("particles[{k}].count={}", (counts[k] as f64 * share).round().max(1.0));
    // if the case gives the number of particles, they would be crowded in a shorter box, so the number is reduced as
    // well
    let same = |experiment: &Experiment| experiment.counts() == reference.counts();
    let sets = match plan.changed(std::slice::from_ref(&shorter), None, None) {
        Ok(experiment) if !same(&experiment) => vec![shorter],
        _ => std::iter::once(shorter).chain((0..counts.len()).map(number)).collect(),
    };
    let change = format!("{} → {} along {}", quantity(before, "m", 4), quantity(after, "m", 4), ["x", "y", "z"][axis]);
    let run = plan.add(&name, &sets, None, None)?;
    Ok(PlannedFactor::against(
        plan.first(),
        run,
        change,
        why(size, "half of it: statistics of a long enough box do not change"),
    ))
}

fn seed(plan: &mut SensitivityPlan, size: Option<&str>) -> Result<PlannedFactor, String> {
    let reference = plan.reference();
    if reference.start.iter().all(|population| matches!(population.amount, Amount::Placed(_))) {
        return Err("all particles start at given places: there is no chance in it".into());
    }
    let own = reference.run.seed;
    // a seed that no run of the unchanged case uses
    let usual = own.wrapping_add(u64::from(plan.replicas));
    let to = match size {
        None => usual,
        Some(text) => text.trim().parse().map_err(|_| format!("its size `{text}` is no seed: a whole number"))?,
    };
    if own.abs_diff(to) < u64::from(plan.replicas) {
        return Err(format!("the seed {to} is one of those of the case as it is"));
    }
    let run = plan.add(&format!("seed {to}"), &[], None, Some(to))?;
    Ok(PlannedFactor::against(
        plan.first(),
        run,
        format!("{own} → {to}"),
        why(size, "nothing but chance: the noise of these runs"),
    ))
}

/// Factor (change of the case) that the user defines by one key, given as `key=value` in `text`.
pub fn own(plan: &mut SensitivityPlan, text: &str) -> Result<PlannedFactor, String> {
    let run = plan.add(text, &[text.to_owned()], None, None)?;
    Ok(PlannedFactor::against(plan.first(), run, text.to_owned(), "as asked for"))
}
