//! Engine of a simulation, chosen by the settings of an experiment.

use crate::engine::Engine;
use crate::engine::distributed::Distributed;
use crate::engine::dsmc::Dsmc;
use crate::engine::hard::{Hard, SteppedHard};
use crate::engine::hybrid::Hybrid;
use crate::engine::soft::Soft;
use crate::experiment::{Experiment, HardStepping, Spheres, TimeStep};
use crate::predict::contact::ContactTimes;
use std::ops::{Deref, DerefMut};

/// Engine of a simulation: one that runs in a single process, or one whose run several processes can share.
pub enum SimulationEngine {
    /// An engine that runs in one process. If processes share the simulation, this engine runs in the lead process
    /// alone.
    Single(Box<dyn Engine>),
    /// An engine whose run several processes can share.
    Distributed(Box<dyn Distributed>),
}

impl SimulationEngine {
    /// Engine whose run several processes can share; `None` for an engine that runs in one process.
    pub fn distributed(&self) -> Option<&dyn Distributed> {
        match self {
            Self::Single(_) => None,
            Self::Distributed(engine) => Some(&**engine),
        }
    }

    /// Mutable engine whose run several processes can share; `None` for an engine that runs in one process.
    pub fn distributed_mut(&mut self) -> Option<&mut dyn Distributed> {
        match self {
            Self::Single(_) => None,
            Self::Distributed(engine) => Some(&mut **engine),
        }
    }

    /// True if the particles are at present divided between processes. Each process then has only the particles in its
    /// own block of the domain.
    pub fn is_cut(&self) -> bool {
        self.distributed().is_some_and(Distributed::is_cut)
    }
}

impl Deref for SimulationEngine {
    type Target = dyn Engine;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Single(engine) => &**engine,
            Self::Distributed(engine) => &**engine,
        }
    }
}

impl DerefMut for SimulationEngine {
    fn deref_mut(&mut self) -> &mut Self::Target {
        match self {
            Self::Single(engine) => &mut **engine,
            Self::Distributed(engine) => &mut **engine,
        }
    }
}

/// [s] soft time step of an experiment with `particles` particles; infinite if the step is given as a fraction of the
/// contact time and no contact is possible.
pub fn soft_step(experiment: &Experiment, particles: usize) -> f64 {
    match experiment.soft.time_step {
        TimeStep::Fixed(step) => step,
        TimeStep::PerContact(steps) => {
            let shortest = experiment.law().and_then(|law| ContactTimes::of(experiment, &law, particles).governing());
            shortest.map_or(f64::INFINITY, |time| time / steps)
        }
    }
}

/// True if soft particles of an experiment with `particles` particles can touch one another or a wall.
pub fn may_touch(experiment: &Experiment, particles: usize) -> bool {
    let shortest = experiment.law().and_then(|law| ContactTimes::of(experiment, &law, particles).governing());
    shortest.is_some()
}

/// Makes the engine for an experiment with `particles` particles.
pub fn engine(experiment: &Experiment, particles: usize) -> SimulationEngine {
    let is_whole = experiment.scene.changes() || experiment.scene.has_openings();
    let engine: Box<dyn Distributed> = match experiment.run.spheres {
        Spheres::Soft(law) => {
            let settings = &experiment.soft;
            Box::new(Soft::new(law, settings.integrator, soft_step(experiment, particles), settings.stepping))
        }
        Spheres::Hard => match experiment.hard.stepping {
            HardStepping::Events => Box::new(Hard::new().with_contact_time(experiment.hard.contact_time)),
            HardStepping::Steps { theta } => return SimulationEngine::Single(Box::new(SteppedHard::new(theta))),
        },
        Spheres::Dsmc => {
            return SimulationEngine::Single(Box::new(Dsmc::new(experiment.dsmc, experiment.run.seed)));
        }
        Spheres::Hybrid(law) => {
            let (settings, step) = (&experiment.soft, soft_step(experiment, particles));
            Box::new(Hybrid::new(law, settings.integrator, step, experiment.hybrid.clearance))
        }
    };
    // a domain that is cut into blocks supports neither images that slide, nor walls that move, nor particles that come
    // and go
    if is_whole { SimulationEngine::Single(engine) } else { SimulationEngine::Distributed(engine) }
}
