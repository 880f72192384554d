//! Methods that a chart compares, each with the parameter over which it is swept.

use crate::contact_law::{ContactLaw, Parameter};
use crate::engine::Counters;
use crate::experiment::{Experiment, HardStepping, Integrator, Model, SoftStepping, Spheres, TimeStep};
use crate::output::ChartMethod;

/// Parameter of a method that makes its results more precise and its runs more expensive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MethodParameter {
    /// [-] number of time steps per contact N_c of soft spheres.
    StepsPerContact,
    /// Elastic parameter of the contact law, such as the stiffness. It is varied at [`FINE_STEPS`] steps per contact.
    /// The field contains the parameter with its value in the case.
    Stiffness(Parameter),
    /// [-] step criterion θ of hard spheres in time steps: distance by which a typical pair of spheres approaches in
    /// one step, divided by the diameter.
    Theta,
    /// [s] length of the window, the time between two exchanges of momentum with the gas.
    Window,
}

/// [-] number of steps per contact N_c while the stiffness is swept. With so many steps, the fourth-order Runge-Kutta
/// method gives the restitution with an error below 1e-6.
pub const FINE_STEPS: f64 = 50.0;

/// Collision model of a method and its way through time. Soft spheres have a contact law, a kind of time steps and an
/// integrator; hard spheres move in time steps or from event to event.
#[derive(Clone, Copy, Debug, PartialEq)]
enum MethodKind {
    Soft(ContactLaw, SoftStepping, Integrator),
    Steps,
    Events,
}

/// One method of a chart, with the values of its swept parameter from cheap to expensive.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodSweep {
    /// Name of the method in the chart, such as "soft uniform, Verlet".
    pub name: &'static str,
    /// Parameter that is swept, such as the number of steps per contact.
    pub knob: MethodParameter,
    /// Values of the swept parameter in SI units, from coarse to fine.
    pub values: Vec<f64>,
    how: MethodKind,
}

/// Values over which the parameters of all methods of a chart are swept, from coarse to fine.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// [-] numbers of time steps per contact N_c of soft spheres.
    pub steps_per_contact: Vec<f64>,
    /// [-] factors by which the stiffness of the soft spheres of the case is multiplied.
    pub stiffness: Vec<f64>,
    /// [-] values of the step criterion θ of hard spheres that move in time steps.
    pub theta: Vec<f64>,
    /// [-] factors by which the window of the case (time between two exchanges of momentum with the gas) is multiplied.
    pub windows: Vec<f64>,
}

impl MethodSweep {
    /// Methods that can run the case `base`, each with the values of its swept parameter. `window` [s] is the time
    /// between two exchanges with the gas in the case.
    pub fn all(base: &Experiment, window: f64, values: &Values) -> Vec<Self> {
        use Integrator::{Rk2, VelocityVerlet};
        let mut sweeps = Vec::new();
        if let Some(law) = base.soft.law {
            let parameter = law.parameter();
            let steps = |name, stepping, integrator| Self {
                name,
                knob: MethodParameter::StepsPerContact,
                values: values.steps_per_contact.clone(),
                how: MethodKind::Soft(law, stepping, integrator),
            };
            sweeps.push(steps("soft uniform, Verlet", SoftStepping::Uniform, VelocityVerlet));
            sweeps.push(steps("soft uniform, RK2", SoftStepping::Uniform, Rk2));
            sweeps.push(steps("soft local, RK4", SoftStepping::Local, VelocityVerlet));
            sweeps.push(steps("soft local, Heun", SoftStepping::Local, Rk2));
            sweeps.push(Self {
                name: "soft local, RK4, stiffness",
                knob: MethodParameter::Stiffness(parameter),
                values: values.stiffness.iter().map(|factor| factor * parameter.value).collect(),
                how: MethodKind::Soft(law, SoftStepping::Local, VelocityVerlet),
            });
        }
        sweeps.push(Self {
            name: "hard, steps",
            knob: MethodParameter::Theta,
            values: values.theta.clone(),
            how: MethodKind::Steps,
        });
        let windows = values.windows.iter().map(|factor| factor * window).collect();
        sweeps.push(Self {
            name: "hard, events",
            knob: MethodParameter::Window,
            values: windows,
            how: MethodKind::Events,
        });
        sweeps
    }

    /// Copy of the experiment `base` that uses this method, with the value `value` (SI unit) of its swept parameter.
    pub fn experiment(&self, base: &Experiment, value: f64) -> Experiment {
        let mut experiment = base.clone();
        experiment.name = format!("{}, {} = {value}", self.name, self.method().knob);
        match self.how {
            MethodKind::Soft(law, stepping, integrator) => {
                let stiffer = match self.knob {
                    MethodParameter::Stiffness(parameter) => law.stiffened(value / parameter.value),
                    MethodParameter::StepsPerContact | MethodParameter::Theta | MethodParameter::Window => law,
                };
                experiment.run.spheres = Spheres::Soft(stiffer);
                experiment.soft.stepping = stepping;
                experiment.soft.integrator = integrator;
            }
            MethodKind::Steps => {
                experiment.run.spheres = Spheres::Hard;
                experiment.hard.stepping = HardStepping::Steps { theta: value };
            }
            MethodKind::Events => {
                experiment.run.spheres = Spheres::Hard;
                experiment.hard.stepping = HardStepping::Events;
            }
        }
        match self.knob {
            MethodParameter::StepsPerContact => experiment.soft.time_step = TimeStep::PerContact(value),
            MethodParameter::Stiffness(_) => experiment.soft.time_step = TimeStep::PerContact(FINE_STEPS),
            MethodParameter::Theta => {}
            MethodParameter::Window => experiment.run.window = Some(value),
        }
        experiment
    }

    /// Names of the method and of its swept parameter as they are written in outputs, with the unit of the parameter.
    pub fn method(&self) -> ChartMethod {
        let (knob, unit) = match self.knob {
            MethodParameter::StepsPerContact => ("N_c", ""),
            MethodParameter::Stiffness(parameter) => (parameter.symbol, parameter.unit),
            MethodParameter::Theta => ("θ", ""),
            MethodParameter::Window => ("h", "s"),
        };
        let model = match self.how {
            MethodKind::Soft(..) => Model::Soft,
            MethodKind::Steps | MethodKind::Events => Model::Hard,
        };
        ChartMethod { name: self.name.into(), model, knob, unit }
    }
}

/// Number of operations of a run: pair checks plus force evaluations plus events. It is a measure of the cost that is
/// the same on every machine.
pub fn work(counters: &Counters) -> f64 {
    (counters.pair_checks + counters.force_evaluations + counters.events) as f64
}

/// Adds the counters of one run to `sum`, the counters of all runs of a point of the chart. The size of the largest
/// island (group of particles that may meet) is not added: the largest value of all runs is kept.
pub fn total(sum: &mut Counters, one: &Counters) {
    *sum = Counters {
        steps: sum.steps + one.steps,
        uniform_steps: sum.uniform_steps + one.uniform_steps,
        pair_checks: sum.pair_checks + one.pair_checks,
        force_evaluations: sum.force_evaluations + one.force_evaluations,
        events: sum.events + one.events,
        missed_collisions: sum.missed_collisions + one.missed_collisions,
        neighbour_builds: sum.neighbour_builds + one.neighbour_builds,
        islands: sum.islands + one.islands,
        island_members: sum.island_members + one.island_members,
        largest_island: sum.largest_island.max(one.largest_island),
        islands_redone: sum.islands_redone + one.islands_redone,
    };
}
