//! Parameters that a user of the lab can change on the page, with their limits and the `--set` arguments for a change.
//! A window is the time between two exchanges with the gas.

use crate::experiment::{Amount, Experiment, HardStepping, Integrator, TimeStep};
use crate::output::numbers::significant;
use crate::simulation::soft_step;
use serde::{Deserialize, Serialize};

/// Number of significant digits of the numbers that the page can set.
const DIGITS: i32 = 4;

/// Value of a parameter, in the form in which the page sends it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ParameterValue {
    /// Number, in the unit in which the page shows the parameter.
    Number(f64),
    /// One of several words, such as the name of a method of integration in time.
    Word(String),
}

/// Parameter of a scene that a user can change on the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabParameter {
    /// [-] restitution e of contacts between particles and at walls.
    Restitution,
    /// [-] friction coefficient μ of contacts between particles and at walls.
    Friction,
    /// [N/m] stiffness k_n of the linear spring of soft contacts.
    Stiffness,
    /// [-] number N_c of time steps per contact of soft spheres.
    StepsPerContact,
    /// Method of integration in time for the contacts of soft spheres.
    Integrator,
    /// [µs] length h of a window, the time between two exchanges of momentum with the gas.
    Window,
    /// Number of particles in a scene of many particles. If it changes, the periodic sides of the box change too, so
    /// that the volume fraction stays constant.
    Count,
    /// Number of spheres in a row of spheres.
    Row,
    /// [m/s] speed of each of two spheres before they collide.
    Approach,
    /// [-] step criterion θ of hard spheres in time steps: distance by which a typical pair of spheres approaches in
    /// one step, divided by the diameter.
    Theta,
    /// [-] clearance of hybrid spheres, in contact times. A contact of two bodies is computed as an instantaneous
    /// collision if no third body can reach them within this time.
    Clearance,
    /// Seed of the random numbers: for the initial state of the particles, and during the run for turbulence, heat,
    /// rough walls and thermal walls.
    Seed,
}

/// Limits of a parameter, in the unit in which the page shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterRange {
    /// Parameter to which the limits apply.
    pub knob: LabParameter,
    /// Smallest allowed value, in the unit of the parameter on the page.
    pub least: f64,
    /// Largest allowed value, in the unit of the parameter on the page.
    pub most: f64,
}

/// Kind of the control with which the page shows a parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ParameterKind {
    /// Slider for a number between limits.
    Number {
        /// Smallest allowed value, in the unit of the parameter on the page.
        least: f64,
        /// Largest allowed value, in the unit of the parameter on the page.
        most: f64,
        /// True if the scale of the slider is logarithmic.
        logarithmic: bool,
        /// True if only whole numbers are allowed.
        whole: bool,
    },
    /// Choice of one of several words, each with its description.
    Words(Vec<(&'static str, &'static str)>),
}

/// Names of the two methods of integration in time for soft contacts, each as typed in a case and as shown on the page.
const INTEGRATORS: [(&str, &str); 2] = [("velocity_verlet", "velocity Verlet"), ("rk2", "Runge-Kutta 2 (Heun)")];

impl LabParameter {
    /// Name of the parameter in the messages between the page and the server.
    pub fn name(self) -> &'static str {
        match self {
            Self::Restitution => "e",
            Self::Friction => "mu",
            Self::Stiffness => "k",
            Self::StepsPerContact => "steps",
            Self::Integrator => "integrator",
            Self::Window => "window",
            Self::Count | Self::Row => "number",
            Self::Approach => "speed",
            Self::Theta => "theta",
            Self::Clearance => "clearance",
            Self::Seed => "seed",
        }
    }

    /// Label and unit of the parameter on the page; the unit is empty if the parameter has none.
    pub fn label(self) -> (&'static str, &'static str) {
        match self {
            Self::Restitution => ("restitution e", ""),
            Self::Friction => ("friction μ", ""),
            Self::Stiffness => ("stiffness kₙ", "N/m"),
            Self::StepsPerContact => ("steps per contact N_c", ""),
            Self::Integrator => ("integrator", ""),
            Self::Window => ("window h", "µs"),
            Self::Count => ("number of particles", ""),
            Self::Row => ("number of spheres", ""),
            Self::Approach => ("speed of each sphere", "m/s"),
            Self::Theta => ("step over diameter θ, at most", ""),
            Self::Clearance => ("clearance θ", "contact times"),
            Self::Seed => ("seed", ""),
        }
    }

    /// Effect of the parameter in one sentence, shown beside its control on the page.
    pub fn help(self) -> &'static str {
        match self {
            Self::Restitution => "Speed after an impact over the speed before it; both models are asked for the same.",
            Self::Friction => "Tangential force over normal force, the same for both models.",
            Self::Stiffness => {
                "Of the soft contact: stiffer contacts are shorter and less deep, and need shorter steps."
            }
            Self::StepsPerContact => {
                "Into how many time steps a soft contact is cut. More steps: a truer impact, in proportion more work. Take ten or more."
            }
            Self::Integrator => "How a soft time step is made.",
            Self::Window => {
                "Drag acts at both ends of a window. A whole number of windows fits between two samples, so they may be shorter than asked."
            }
            Self::Count => "The box grows with it, so that it stays as full.",
            Self::Row => "How many spheres stand in the row.",
            Self::Approach => "Both come at this speed, so that they meet at twice of it.",
            Self::Theta => {
                "How far a typical pair comes in one step of stepped hard spheres, over the diameter. A step is shortened to fit the run; the panel states its θ."
            }
            Self::Clearance => {
                "A touch of hybrid spheres is an instant if no other particle can come within so many contact times."
            }
            Self::Seed => "Another number makes another random start, and other random numbers in scenes with noise.",
        }
    }

    fn is_whole(self) -> bool {
        matches!(self, Self::Count | Self::Row | Self::Seed)
    }

    fn is_logarithmic(self) -> bool {
        matches!(self, Self::Stiffness | Self::StepsPerContact | Self::Window | Self::Approach | Self::Theta)
    }

    /// Value of the parameter in an experiment, in the unit in which the page shows it. `None` if the experiment does
    /// not have the parameter.
    pub fn value(self, experiment: &Experiment) -> Option<ParameterValue> {
        let number = match self {
            Self::Restitution => experiment.scene.contact.restitution,
            Self::Friction => experiment.scene.contact.friction,
            Self::Stiffness => experiment.soft.law?.parameter().value,
            Self::StepsPerContact => match experiment.soft.time_step {
                TimeStep::PerContact(steps) => steps,
                TimeStep::Fixed(_) => return None,
            },
            Self::Integrator => {
                let word = INTEGRATORS[usize::from(experiment.soft.integrator == Integrator::Rk2)].0;
                return Some(ParameterValue::Word(word.to_owned()));
            }
            Self::Window => 1e6 * crate::schedule::Schedule::new(experiment).window,
            Self::Count | Self::Row => experiment.count() as f64,
            Self::Approach => match &experiment.start.first()?.amount {
                Amount::Placed(placed) => placed.velocity.first()?.norm(),
                Amount::Count(_) => return None,
            },
            Self::Theta => match experiment.hard.stepping {
                HardStepping::Steps { theta } => theta,
                HardStepping::Events => return None,
            },
            Self::Clearance => experiment.hybrid.clearance,
            Self::Seed => experiment.run.seed as f64,
        };
        Some(ParameterValue::Number(rounded(number)))
    }

    /// Arguments of the form `key=value` (for `--set`) that give the parameter the value `setting`, in a scene with the
    /// given `experiment`.
    pub fn sets(self, setting: &ParameterValue, experiment: &Experiment) -> Vec<String> {
        let value = match setting {
            ParameterValue::Word(word) => return vec![format!("soft.integrator={word}")],
            ParameterValue::Number(value) => *value,
        };
        match self {
            Self::Restitution => surfaces(experiment, "restitution", value),
            Self::Friction => surfaces(experiment, "friction", value),
            Self::Stiffness => vec![format!("soft.linear_spring_dashpot.stiffness={value} N/m")],
            Self::StepsPerContact => vec![format!("soft.steps_per_contact={value}")],
            Self::Integrator => Vec::new(),
            Self::Window => vec![format!("run.window={value} us")],
            Self::Count => crowd(experiment, value),
            Self::Row => row(experiment, value as usize),
            Self::Approach => approach(experiment, value),
            Self::Theta => theta(experiment, value),
            Self::Clearance => vec![format!("hybrid.clearance={value}")],
            Self::Seed => vec![format!("run.seed={value}")],
        }
    }
}

impl ParameterRange {
    /// Kind of the control with which the page shows the parameter.
    pub fn kind(&self) -> ParameterKind {
        let Self { knob, least, most } = *self;
        match knob {
            LabParameter::Integrator => ParameterKind::Words(INTEGRATORS.to_vec()),
            _ => ParameterKind::Number { least, most, logarithmic: knob.is_logarithmic(), whole: knob.is_whole() },
        }
    }

    /// Checks a value that the page sent, and returns it. Numbers are rounded to `DIGITS` significant digits, or to a
    /// whole number if the parameter is whole.
    ///
    /// # Errors
    /// Returns the reason, as text, if the value is outside its limits or of the wrong kind.
    pub fn accept(&self, setting: &ParameterValue) -> Result<ParameterValue, String> {
        let (label, unit) = self.knob.label();
        match (setting, self.kind()) {
            (ParameterValue::Number(value), ParameterKind::Number { least, most, whole, .. }) => {
                let value = if whole { value.round() } else { rounded(*value) };
                if (least..=most).contains(&value) {
                    return Ok(ParameterValue::Number(value));
                }
                Err(format!("{label} = {value} {unit}: the lab takes {least} to {most} {unit}"))
            }
            (ParameterValue::Word(word), ParameterKind::Words(words))
                if words.iter().any(|(known, _)| known == word) =>
            {
                Ok(setting.clone())
            }
            _ => Err(format!("{label}: the lab does not know this value")),
        }
    }
}

/// Rounds a value to [`DIGITS`] significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.*e}", DIGITS as usize - 1).parse().unwrap_or(value)
}

/// Arguments of the form `key=value` that set the property `key` of contacts, such as the restitution, for pairs and
/// for every wall.
fn surfaces(experiment: &Experiment, key: &str, value: f64) -> Vec<String> {
    let walls = (0..experiment.scene.walls.len()).map(|wall| format!("walls[{wall}].{key}={value}"));
    std::iter::once(format!("contact.{key}={value}")).chain(walls).collect()
}

/// Arguments of the form `key=value` that set the number of particles to `count`. They also change the periodic sides
/// of the box, so that the volume fraction stays constant.
fn crowd(experiment: &Experiment, count: f64) -> Vec<String> {
    let domain = &experiment.scene.domain;
    let sides: Vec<usize> = (0..3).filter(|axis| domain.periodic[*axis]).collect();
    let factor = (count / experiment.count() as f64).powf(1.0 / sides.len().max(1) as f64);
    let sizes = sides.into_iter().map(|axis| {
        // rounding to five decimal places in mm changes the volume fraction by less than 0.1 %
        format!("domain.size[{axis}]={:.5} mm", 1e3 * domain.size[axis] * factor)
    });
    sizes.chain(std::iter::once(format!("particles[0].count={count}"))).collect()
}

/// Arguments of the form `key=value` that set the number of spheres in a row to `count`. The row begins with the
/// spheres of the case (input file); further spheres follow at equal distances.
fn row(experiment: &Experiment, count: usize) -> Vec<String> {
    let Some(Amount::Placed(placed)) = experiment.start.first().map(|population| &population.amount) else {
        return Vec::new();
    };
    let (Some(last), Some(before)) = (placed.len().checked_sub(1), placed.len().checked_sub(2)) else {
        return Vec::new();
    };
    let step = placed.position[last] - placed.position[before];
    let one = |k: usize| {
        let beyond = k.saturating_sub(last) as f64;
        let (x, v) = (placed.position[k.min(last)] + step * beyond, placed.velocity[k.min(last)]);
        let places: Vec<String> = x.iter().map(|x| format!("\"{} um\"", rounded(1e6 * x))).collect();
        let speeds: Vec<String> = v.iter().map(|v| format!("\"{v} m/s\"")).collect();
        format!("{{ position = [{}], velocity = [{}] }}", places.join(", "), speeds.join(", "))
    };
    vec![format!("particles[0].at=[{}]", (0..count).map(one).collect::<Vec<_>>().join(", "))]
}

/// Arguments of the form `key=value` that set the speed of each of two spheres to `speed` [m/s]; their directions stay
/// the same.
fn approach(experiment: &Experiment, speed: f64) -> Vec<String> {
    let Some(Amount::Placed(placed)) = experiment.start.first().map(|population| &population.amount) else {
        return Vec::new();
    };
    let moving = |k: usize, axis: usize| {
        let component = placed.velocity[k][axis] / placed.velocity[k].norm();
        (component != 0.0).then(|| format!("particles[0].at[{k}].velocity[{axis}]={} m/s", component * speed))
    };
    (0..placed.len()).flat_map(|k| (0..3).filter_map(move |axis| moving(k, axis))).collect()
}

/// Arguments of the form `key=value` that set θ, the step criterion of hard spheres that move in time steps. The window
/// (time between two exchanges with the gas) and the time between samples (instants of measurement) are set in
/// proportion to θ. A step cannot be longer than a window, and a window not longer than the time between samples. In
/// the scenes with this parameter, all three are equal.
fn theta(experiment: &Experiment, theta: f64) -> Vec<String> {
    let mut sets = vec![format!("hard.theta={theta}")];
    if let HardStepping::Steps { theta: before } = experiment.hard.stepping {
        let scaled = |key: &str, time: f64| format!("{key}={} us", rounded(1e6 * time * theta / before));
        sets.extend(experiment.run.window.map(|time| scaled("run.window", time)));
        sets.extend(experiment.statistics.sample_interval.map(|time| scaled("statistics.sample_interval", time)));
    }
    sets
}

/// Description of the method by which an experiment computes soft contacts: the integrator and the time step.
/// `particles` is the number of particles.
pub fn soft_method(experiment: &Experiment, particles: usize) -> String {
    let step = soft_step(experiment, particles);
    let integrator = INTEGRATORS[usize::from(experiment.soft.integrator == Integrator::Rk2)].1;
    if step.is_finite() {
        format!("{integrator}, step {} µs", significant(1e6 * step, 3))
    } else {
        integrator.to_owned()
    }
}
