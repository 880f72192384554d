//! The engine that an experiment asks for.

use crate::engine::Engine;
use crate::engine::hard::{Hard, SteppedHard};
use crate::engine::hybrid::Hybrid;
use crate::engine::soft::Soft;
use crate::experiment::{Experiment, HardStepping, Spheres, TimeStep};
use crate::predict::contact::ContactTimes;

/// [s] longest soft time step of an experiment with `particles` particles; infinite if nothing can touch.
pub fn soft_step(experiment: &Experiment, particles: usize) -> f64 {
    match experiment.soft.time_step {
        TimeStep::Fixed(step) => step,
        TimeStep::PerContact(steps) => {
            let shortest = experiment.law().and_then(|law| ContactTimes::of(experiment, &law, particles).governing());
            shortest.map_or(f64::INFINITY, |time| time / steps)
        }
    }
}

/// True if the `particles` soft particles of an experiment can touch one another or a wall.
pub fn may_touch(experiment: &Experiment, particles: usize) -> bool {
    let shortest = experiment.law().and_then(|law| ContactTimes::of(experiment, &law, particles).governing());
    shortest.is_some()
}

/// The engine that an experiment with `particles` particles asks for.
pub fn engine(experiment: &Experiment, particles: usize) -> Box<dyn Engine> {
    match experiment.run.spheres {
        Spheres::Soft(law) => {
            let settings = &experiment.soft;
            Box::new(Soft::new(law, settings.integrator, soft_step(experiment, particles), settings.stepping))
        }
        Spheres::Hard => match experiment.hard.stepping {
            HardStepping::Events => Box::new(Hard::new().with_contact_time(experiment.hard.contact_time)),
            HardStepping::Steps { theta } => Box::new(SteppedHard::new(theta)),
        },
        Spheres::Hybrid(law) => {
            let (settings, step) = (&experiment.soft, soft_step(experiment, particles));
            Box::new(Hybrid::new(law, settings.integrator, step, experiment.hybrid.clearance))
        }
    }
}
